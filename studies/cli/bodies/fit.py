"""What ``solar-uav fit`` and ``calibrate`` do."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import click

from missions.files.errors import printable
from missions.files.overrides import with_overrides
from missions.files.writing import write_text_atomically
from missions.files.yaml import Document
from sizing.results.tables import Summary
from studies.cli.commands.fit import Calibrate, Fit
from studies.cli.files import Case, load, open_aircraft
from studies.cli.logs import read_log, refuse_swapped_log
from studies.cli.options import EXIT_FAILED
from studies.cli.outputs import answer, figure_of, refuse_to_overwrite, told
from studies.fitting import calibration
from studies.fitting.files import file_text, fitted_document, fitted_lines
from studies.fitting.flight import FlightFit, fit_flight
from studies.fitting.parameters import chosen
from studies.fitting.plots import plot_fit
from studies.fitting.prediction import predict_flight
from studies.output.run_folder import InputFile, write_run_folder


def fit(options: Fit) -> None:
    """Fit an aircraft to a flight, write it, and tell what was found."""
    log_files, other_log = (options.log.log_file, *options.more_logs), options.other_log
    read = (options.case.aircraft, options.case.mission, *log_files, other_log)
    refuse_to_overwrite("--write", options.write_file, read)
    refuse_swapped_log(options.case.aircraft, options.log.log_file, "fit")
    case = load(options.case)
    try:
        chosen(options.names, case.aircraft)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--fit") from None
    logs = [read_log(replace(options.log, log_file=one)) for one in log_files]
    fitted = fit_flight(
        case.aircraft, logs, case.mission, names=options.names, light_sigma=options.light_sigma
    )
    record, shown = case.named(fitted.to_dict()), fitted.summary()
    if other_log is not None:
        other = read_log(replace(options.log, log_file=other_log, start=None, exclude=()))
        prediction = predict_flight(fitted, other, case.mission)
        record["prediction"] = prediction.to_dict()
        shown = shown + Summary((prediction.table(),))
    write_file, folder = (options.write_file, options.out_dir) if fitted.fitted else (None, None)
    with told(case, record, shown, files=(write_file, folder)):
        if write_file is not None or folder is not None:
            document = _fitted(case, fitted, log_files)
            if write_file is not None:
                write_text_atomically(write_file, file_text(document, fitted_lines(fitted)))
            if folder is not None:
                more = enumerate(log_files[1:], 2)
                files = {"log": Path(log_files[0]), **{f"log_{n}": Path(one) for n, one in more}}
                inputs = case.inputs(None, **files).of_aircraft(document.data)
                drawn = {"fit.png": figure_of(lambda: plot_fit(fitted, figure=options.figure))}
                write_run_folder(Path(folder), inputs, record, {}, drawn)
    if not fitted.fitted:
        click.echo(
            "solar-uav: the log determines none of the parameters; nothing is written", err=True
        )
        sys.exit(EXIT_FAILED)


def _fitted(case: Case, fitted: FlightFit, log_files: tuple[str, ...]) -> Document:
    """File of the fitted aircraft, with where its numbers come from."""
    sums = [InputFile.of(Path(one)).sha256 for one in log_files]
    sources = {
        "aircraft_sha256": case.aircraft_file.sha256,
        "log": fitted.log.source,
        "log_sha256": sums[0],
        "mission": case.mission_file.document.source,
    }
    document = fitted_document(case.aircraft_file.document, fitted, sources)
    if len(sums) > 1:
        names = [printable(one.source) for one in fitted.logs[1:]]
        more = [{"log": n, "sha256": s} for n, s in zip(names, sums[1:], strict=True)]
        document = with_overrides(document, {"provenance.more_logs": more})
    return document


def calibrate(options: Calibrate) -> None:
    """Make a parametric aircraft of a measured one, write it, and tell its factors."""
    refuse_to_overwrite("--write", options.write_file, (options.aircraft, options.technology))
    built = open_aircraft(options.aircraft)
    models = open_aircraft(options.technology, options.overrides)
    sources = {"aircraft_sha256": built.sha256, "technology_sha256": models.sha256}
    estimated = calibration.calibrate(built.document, models.document, sources)
    if options.write_file is not None:
        lines = [f"  {one.key}: {one.after:.5g}, from {one.source}" for one in estimated.factors]
        write_text_atomically(options.write_file, file_text(estimated.document, lines))
    answer(estimated.to_dict(), estimated, (options.write_file,), as_json=options.as_json)
