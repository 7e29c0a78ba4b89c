"""What ``solar-uav bench`` does."""

from __future__ import annotations

from pathlib import Path

from missions.files.errors import printable
from missions.files.validation import validate
from missions.files.writing import write_text_atomically
from sizing.aircraft import Aircraft
from studies.bench.result import evaluate_bench
from studies.cli.commands.bench import Bench
from studies.cli.files import open_aircraft
from studies.cli.outputs import answer, refuse_to_overwrite
from studies.fitting.files import changed_document, file_text, provenance, value_lines
from studies.output.run_folder import InputFile


def bench(options: Bench) -> None:
    """Evaluate bench tests, write the aircraft, and tell which keys changed."""
    refuse_to_overwrite("--write", options.write_file, (options.aircraft, *options.files))
    given = open_aircraft(options.aircraft)
    found = evaluate_bench(validate(given.document, Aircraft), *options.files)
    if options.write_file is not None:
        sources = {"aircraft_sha256": given.sha256}
        sums = [
            {"log": printable(one), "sha256": InputFile.of(Path(one)).sha256}
            for one in options.files
        ]
        block = {**provenance(given.document, "bench", sources), "bench_tests": sums}
        document = changed_document(given.document, found.fitted, block, "tested")
        lines = ["bench tests", *value_lines(found.fitted)]
        write_text_atomically(options.write_file, file_text(document, lines))
    answer(found.to_dict(), found, (options.write_file,), as_json=options.as_json)
