"""What ``solar-uav compare`` does."""

from __future__ import annotations

import sys
from pathlib import Path

from studies.cli.commands.verify import Compare
from studies.cli.files import load, refuse_polar_night, require_climber, require_path
from studies.cli.options import EXIT_FAILED
from studies.cli.outputs import deliver, figure_of, table_of
from studies.cli.telling import progress_of
from studies.models import comparison
from studies.models.plots import plot_comparison
from studies.models.solar_models import attitude_is_known
from studies.output.formats import csv_bytes
from studies.output.run_folder import write_run_folder


def compare(options: Compare) -> None:
    """Run all solar power models, and tell what each says."""
    case = load(options)
    require_climber(case)
    refuse_polar_night(case)
    if options.needs_path is not None or attitude_is_known(case.aircraft, case.mission):
        # With surfaces and a path, the reference flies it even if no case does.
        require_path(case, options.needs_path or "the reference")
    with progress_of("models", lines=False) as progress:
        compared = comparison.compare(
            case.aircraft,
            case.mission,
            models=options.models,
            corrections=options.corrections,
            objective=options.objective,
            design=not options.no_design,
            progress=progress,
        )
    drawing = figure_of(lambda: plot_comparison(compared, figure=options.figure))
    files = {
        options.table_file: table_of(compared.to_frame, "models"),
        options.plot_file: drawing,
    }

    def write(folder: str) -> None:
        contents = {"comparison.csv": csv_bytes(compared.to_frame())}
        record, drawn = case.named(compared.to_dict()), {"comparison.png": drawing}
        write_run_folder(Path(folder), case.inputs(), record, contents, drawn)

    deliver(case, compared, files, writers={options.out_dir: write})
    sized = [
        case_of_model.built for case_of_model in compared.cases if case_of_model.built is not None
    ]
    if sized and all(built.judged is None for built in sized):
        sys.exit(EXIT_FAILED)
