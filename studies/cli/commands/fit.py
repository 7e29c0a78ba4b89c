"""The command ``solar-uav fit``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from studies.cli.help_texts import command
from studies.cli.log_options import log_options
from studies.cli.options import (
    EXIT_FAILED,
    Asked,
    RealRange,
    aircraft_argument,
    case_options,
    completes,
    figure_options,
    json_option,
    mission_option,
    out_option,
    print_json,
)
from studies.output.figures.options import FigureOptions

if TYPE_CHECKING:
    from missions.files.yaml import Document
    from missions.logs.columns import ColumnMap
    from studies.cli.files import Case
    from studies.fitting.flight import FlightFit


@command("solar-uav fit atlantiksolar-as2 flight.csv --write mine.yaml")
@aircraft_argument()
@click.argument("log_file", metavar="LOG", shell_complete=completes("log_file"))
@mission_option("rafz-28h")
@log_options
@click.option(
    "--fit",
    "names",
    metavar="NAME",
    multiple=True,
    help="Parameter to fit, e.g. temperature_rise; see docs/fit.md. May be repeated.  "
    "[default: module_efficiency, temperature_rise, the level power, specific_energy]",
)
@click.option(
    "--light-sigma",
    type=RealRange(0.0, 0.5, unit="a share"),
    default=0.03,
    show_default=True,
    help="Standard uncertainty of the clear sky, relative.",
)
@click.option(
    "--predict",
    "other_log",
    metavar="LOG",
    help="Another flight, whose charge is predicted from the fit.",
)
@click.option(
    "--write",
    "write_file",
    type=click.Path(),
    metavar="FILE",
    help="Write the fitted aircraft, with where its numbers come from.",
)
@case_options
@out_option("a figure")
@figure_options
def fit(
    asked: Asked,
    log_file: str,
    layout: ColumnMap,
    names: tuple[str, ...],
    light_sigma: float,
    other_log: str | None,
    write_file: str | None,
    out_dir: str | None,
    figure: FigureOptions,
) -> None:
    """Fit parameters of AIRCRAFT to the flight LOG, with confidence intervals."""
    from missions.files.writing import check_writable_folder, write_text_atomically
    from missions.logs.csv import read_flight_log
    from sizing.results.tables import Summary
    from studies.cli.checks import check_outputs, refuse_to_overwrite
    from studies.cli.files import refuse_swapped_log
    from studies.cli.outputs import figure_bytes, told
    from studies.fitting.files import file_text, fitted_lines
    from studies.fitting.flight import fit_flight
    from studies.fitting.plots import plot_fit
    from studies.fitting.prediction import predict_flight
    from studies.output.run_folder import write_run_folder

    if out_dir is not None:
        check_writable_folder(Path(out_dir))
    check_outputs(write=write_file)
    refuse_to_overwrite("--write", write_file, (asked.aircraft, asked.mission, log_file, other_log))
    refuse_swapped_log(asked.aircraft, log_file, "fit")
    case = asked.case()
    _check_names(names, case)
    found = fit_flight(
        *(case.aircraft, read_flight_log(log_file, layout), case.mission),
        names=names,
        light_sigma=light_sigma,
    )
    record, shown = case.named(found.to_dict()), found.summary()
    if other_log is not None:
        prediction = predict_flight(found, read_flight_log(other_log, layout), case.mission)
        record["prediction"] = prediction.to_dict()
        shown = shown + Summary((prediction.table(),))
    if not found.fitted:
        write_file = out_dir = None
    with told(case, record, shown, out_dir=out_dir, files=(write_file,)):
        if write_file is not None or out_dir is not None:
            document = _fitted(case, found, Path(log_file))
            if write_file is not None:
                write_text_atomically(write_file, file_text(document, fitted_lines(found)))
            if out_dir is not None:
                inputs = case.inputs(log=Path(log_file)).of_aircraft(document.data)
                drawn = {"fit.png": lambda: figure_bytes(plot_fit(found, figure=figure), "fit.png")}
                write_run_folder(Path(out_dir), inputs, record, {}, drawn)
    if not found.fitted:
        click.echo("solar-uav: the log tells none of the parameters; nothing is written", err=True)
        sys.exit(EXIT_FAILED)


def _check_names(names: tuple[str, ...], case: Case) -> None:
    """Refuse parameters that the aircraft does not have."""
    from studies.fitting.parameters import chosen

    try:
        chosen(names, case.aircraft)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--fit") from None


def _fitted(case: Case, found: FlightFit, log_file: Path) -> Document:
    """File of the fitted aircraft, with where its numbers come from."""
    from studies.fitting.files import fitted_document
    from studies.output.run_folder import InputFile

    log = InputFile.of(log_file)
    sources = {
        "aircraft_sha256": case.craft.sha256,
        "log": log.source,
        "log_sha256": log.sha256,
        "mission": case.where.document.source,
    }
    return fitted_document(case.craft.document, found, sources)


@command("solar-uav calibrate atlantiksolar-as2 atlantiksolar-design --write mine.yaml")
@aircraft_argument()
@click.argument("technology", shell_complete=completes("aircraft"))
@click.option(
    "--set",
    "overrides",
    metavar="KEY=VALUE",
    multiple=True,
    help="Override a key of TECHNOLOGY, e.g. airframe.avionics_mass_kg=0.3. May be repeated.",
)
@click.option("--write", "write_file", type=click.Path(), metavar="FILE", help="Write the file.")
@json_option
def calibrate(
    aircraft: str,
    technology: str,
    overrides: tuple[str, ...],
    write_file: str | None,
    as_json: bool,
) -> None:
    """Make a parametric aircraft of a measured AIRCRAFT and the models of TECHNOLOGY."""
    from missions.files.writing import write_text_atomically
    from studies.cli.checks import check_outputs, refuse_to_overwrite
    from studies.cli.files import open_aircraft
    from studies.fitting.calibration import calibrate as make
    from studies.fitting.files import file_text
    from studies.output.terminal import show, tell_line

    check_outputs(write=write_file)
    refuse_to_overwrite("--write", write_file, (aircraft, technology))
    built, models = open_aircraft(aircraft), open_aircraft(technology, overrides)
    sources = {"aircraft_sha256": built.sha256, "technology_sha256": models.sha256}
    found = make(built.document, models.document, sources)
    if write_file is not None:
        told = [f"  {one.key}: {one.after:.5g}, from {one.source}" for one in found.factors]
        write_text_atomically(write_file, file_text(found.document, told))
    if as_json:
        print_json(found.to_dict())
        return
    show(found.summary())
    if write_file is not None:
        tell_line(f"written to {write_file}")
