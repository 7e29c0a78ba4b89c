"""The command ``solar-uav``.

Heavy packages are imported inside the commands that use them, so that help texts appear at once.
"""

from __future__ import annotations

import io
import json
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from solar._version import __version__
from solar.names import OBJECTIVE_NAMES
from studies.ceiling_command import ceiling
from studies.climb_checks import refuse_climb, require_climber
from studies.command_options import DEFAULT_MISSION, EXIT_BAD_INPUT, EXIT_FAILED, solar_options
from studies.command_options import check_outputs as _check_outputs
from studies.command_options import console as _console
from studies.command_options import image_format as _image_format
from studies.command_options import load as _load
from studies.command_options import print_json as _print_json
from studies.command_options import refuse_polar_night as _refuse_polar_night
from studies.command_options import require_path as _require_path
from studies.command_options import solar_model as _solar_model
from studies.command_options import write_files as _write_files
from studies.compare_command import compare
from studies.map_command import map_
from studies.sweep_command import sweep
from studies.verify_command import verify

if TYPE_CHECKING:
    from missions.mission import Mission


class Latitude(click.ParamType[float]):
    """Latitude in degrees, -90 to 90."""

    name = "deg"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Read the number and check its range; NaN is outside."""
        try:
            if "_" in str(value):  # Python's own notation, nobody's latitude
                raise ValueError
            number = float(value)
        except (TypeError, ValueError):
            self.fail(f"{value!r} is not a number", param, ctx)
        if not -90.0 <= number <= 90.0:
            self.fail(f"must be from -90 to 90 (got {value})", param, ctx)
        return number


class MonthDay(click.ParamType[int]):
    """A date MM-DD, as a day of year."""

    name = "mm-dd"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Read the date."""
        from missions.dates import day_of_year

        try:
            return day_of_year(str(value))
        except ValueError as error:
            self.fail(str(error), param, ctx)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="solar-uav")
def cli() -> None:
    """Size solar-electric aircraft and predict how long they stay up."""


@cli.command()
@click.argument("aircraft")
@click.option("--mission", "-m", default=DEFAULT_MISSION, show_default=True, help="Name or file.")
@click.option("--latitude", type=Latitude(), help="Latitude instead of the mission's.")
@click.option("--day-of-year", type=click.IntRange(1, 365), help="Day instead of the mission's.")
@click.option("--date", type=MonthDay(), help="Date instead of the mission's.")
@click.option("--csv", "csv_file", type=click.Path(), help="Write the cycle over time as CSV.")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw the cycle (png, svg, pdf).")
@solar_options
def analyse(
    aircraft: str,
    mission: str,
    latitude: float | None,
    day_of_year: int | None,
    date: int | None,
    csv_file: str | None,
    plot_file: str | None,
    model: str,
    correction: str,
    overrides: tuple[str, ...],
    as_json: bool,
) -> None:
    """Analyse how long AIRCRAFT (name or file) flies, there and then."""
    from studies import analysis as study

    if day_of_year is not None and date is not None:
        raise click.UsageError("give --day-of-year or --date, not both")
    image_format = _image_format(plot_file)
    _check_outputs(csv=csv_file, plot=plot_file)
    craft, where = _load(aircraft, mission, overrides)
    day = day_of_year if day_of_year is not None else date
    placed = _placed(where.mission, latitude, day)
    _refuse_polar_night(placed, where, options=latitude is not None or day is not None)
    _require_path(model, correction, craft, where)
    require_climber(craft, where)
    replay = latitude is None and day is None
    result = study.analyse(craft.aircraft, placed, _solar_model(model, correction), replay=replay)
    record = study.to_json(result)
    contents: dict[str | os.PathLike[str], bytes] = {}
    if csv_file is not None:
        contents[csv_file] = study.trajectory_table(result).to_csv(index=False).encode()
    if plot_file is not None and image_format is not None:
        from studies import plots

        flight = result.flight
        figure = (
            plots.cycle_figure(result) if flight is None else plots.flight_figure(result, flight)
        )
        contents[plot_file] = plots.to_bytes(figure, image_format)
    _write_files(contents)
    if as_json:
        _print_json(record)
        return
    from studies.tables import print_analysis

    print_analysis(_console(), result, record)


@cli.command()
@click.argument("aircraft")
@click.option("--mission", "-m", required=True, help="Name or file.")
@click.option(
    "--objective",
    type=click.Choice(OBJECTIVE_NAMES),
    default=OBJECTIVE_NAMES[0],
    show_default=True,
    help="What to optimise.",
)
@click.option(
    "--required-excess-time",
    "required_h",
    type=click.FloatRange(0.0, 1000.0),
    metavar="HOURS",
    help="Excess time that every scenario must have, instead of the mission's.",
)
@click.option("--out", "out_dir", type=click.Path(), help="Folder for the sized aircraft's files.")
@click.option(
    "--sensitivities",
    "with_sensitivities",
    is_flag=True,
    help="Tell what each technology parameter is worth at the optimum.",
)
@click.option(
    "--certify",
    "with_certificate",
    is_flag=True,
    help="Attack the optimum with other designs through the simulator.",
)
@solar_options
def size(
    aircraft: str,
    mission: str,
    objective: str,
    required_h: float | None,
    out_dir: str | None,
    with_sensitivities: bool,
    with_certificate: bool,
    model: str,
    correction: str,
    overrides: tuple[str, ...],
    as_json: bool,
) -> None:
    """Find the best design of AIRCRAFT (name or file) for a mission."""
    from sizing.aircraft import MeasuredAirframe
    from sizing.objectives import Objective
    from studies import sizing_study

    asked = Objective(objective)
    if asked.of_range and (with_sensitivities or with_certificate):
        raise click.UsageError(
            f"{objective} counts days or degrees: it has no sensitivities and no certificate"
        )
    craft, where = _load(aircraft, mission, overrides)
    if isinstance(craft.aircraft.airframe, MeasuredAirframe):
        from missions.configfile import located_error

        raise located_error(
            craft.document,
            ("airframe", "kind"),
            "a measured aircraft cannot be sized; allowed: parametric",
        )
    refuse_climb(where, "size")
    if not asked.of_range:
        _refuse_polar_night(where.mission, where, options=False)
    _require_path(model, correction, craft, where)
    if required_h is not None and required_h != required_h:
        raise click.BadParameter("must be a number of hours", param_hint="--required-excess-time")
    if out_dir is not None:
        from missions.output_files import check_writable_folder

        check_writable_folder(Path(out_dir))
    study = sizing_study.size(
        craft.aircraft,
        where.mission,
        asked,
        _solar_model(model, correction),
        required_excess_time_h=required_h,
        with_sensitivities=with_sensitivities,
        with_certificate=with_certificate,
    )
    record = study.record()
    if out_dir is not None and study.result.feasible:
        from studies.sizing_files import write_sizing

        write_sizing(Path(out_dir), study, record, craft)
    if as_json:
        _print_json(record)
    else:
        from studies.tables import print_sizing_study

        print_sizing_study(_console(), study, record)
        if out_dir is not None and study.result.feasible:
            click.echo(f"written to {out_dir}")
    if not study.result.feasible:
        sys.exit(EXIT_FAILED)


@cli.command(name="list")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def list_(as_json: bool) -> None:
    """List the aircraft and missions that ship with the package."""
    from studies.library import find_document, shipped_names

    shipped = {
        kind: {
            name: str(find_document(kind, name).data.get("description", ""))
            for name in shipped_names(kind)
        }
        for kind in ("aircraft", "mission")
    }
    if as_json:
        _print_json(shipped)
        return
    for kind, entries in shipped.items():
        click.secho(kind if kind == "aircraft" else "missions", bold=True)
        for name, description in entries.items():
            click.echo(f"  {name:24} {description}")


@cli.command()
@click.argument("name")
def init(name: str) -> None:
    """Write commented starter files NAME.yaml and NAME-mission.yaml into this folder."""
    from studies.starters import write_starters

    for path in write_starters(name, Path.cwd()):
        click.echo(f"wrote {path.name}")
    click.echo(f"try: solar-uav size {name}.yaml --mission {name}-mission.yaml")


@cli.command()
@click.argument("files", nargs=-1, required=True)
def validate(files: tuple[str, ...]) -> None:
    """Check aircraft and mission FILES and say everything that is wrong with them."""
    from missions.configfile import validate as check
    from missions.mission import Mission
    from missions.problems import InputError
    from missions.yaml_document import read_yaml
    from sizing.aircraft import Aircraft
    from studies.library import document_kind

    wrong = False
    for file in files:
        try:
            document = read_yaml(file)
            kind = document_kind(document)
            if kind == "aircraft":
                check(document, Aircraft)
            else:
                check(document, Mission)
            click.echo(f"{file}: valid {kind}")
        except InputError as error:
            click.echo(str(error), err=True)
            wrong = True
    if wrong:
        sys.exit(EXIT_BAD_INPUT)


@cli.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--markdown", "markdown_file", type=click.Path(), help="Write the table to a file.")
def published(as_json: bool, markdown_file: str | None) -> None:
    """Compare published numbers with computed ones; exit code 1 if one is missed."""
    from studies import published as study

    rows = study.comparisons()
    if markdown_file is not None:
        from missions.output_files import write_text_atomically

        write_text_atomically(markdown_file, study.markdown(rows))
    if as_json:
        _print_json([row.record() for row in rows])
    else:
        from studies.tables import print_published

        print_published(_console(), rows)
    if not all(row.met for row in rows):
        sys.exit(EXIT_FAILED)


@cli.command(name="loiter-correction")
@click.argument("aircraft", default="atlantiksolar-as2")
@click.option("--mission", "-m", default="rafz-loiter", show_default=True, help="Name or file.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--markdown", "markdown_file", type=click.Path(), help="Write the table to a file.")
def loiter_correction(
    aircraft: str, mission: str, as_json: bool, markdown_file: str | None
) -> None:
    """Tabulate how the errors of CDM and CAM change with latitude, season and wind."""
    craft, where = _load(aircraft, mission, ())
    _require_path("FM", "none", craft, where)
    from studies import model_transfer as study

    winds = _flyable_winds(where.mission, study.WINDS_M_PER_S)
    errors = study.transferred_errors(craft.aircraft, where.mission, winds_m_per_s=winds)
    if markdown_file is not None:
        from missions.output_files import write_text_atomically

        write_text_atomically(markdown_file, study.markdown(errors))
    if as_json:
        _print_json(study.to_json(errors))
    else:
        from studies.tables import print_transfer

        print_transfer(_console(), errors)


@cli.command()
@click.argument("aircraft")
@click.option("--mission", "-m", default="rafz-loiter", show_default=True, help="Name or file.")
@click.option("--csv", "csv_file", type=click.Path(), help="Write the table over time as CSV.")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw it (png, svg, pdf).")
def efficiencies(aircraft: str, mission: str, csv_file: str | None, plot_file: str | None) -> None:
    """Show what drives the Full Model's power of AIRCRAFT: every component efficiency."""
    image = _image_format(plot_file)
    _check_outputs(csv=csv_file, plot=plot_file)
    craft, where = _load(aircraft, mission, ())
    _require_path("FM", "none", craft, where)
    _refuse_polar_night(where.mission, where, options=False)
    from studies import component_efficiencies as study

    data = study.component_efficiencies(craft.aircraft, where.mission)
    contents: dict[str | os.PathLike[str], bytes] = {}
    if csv_file is not None:
        contents[csv_file] = data.to_dataframe().to_csv().encode()
    if plot_file is not None and image is not None:
        from studies.plots import to_bytes

        contents[plot_file] = to_bytes(study.figure(data), image)
    _write_files(contents)
    from studies.tables import print_efficiencies

    print_efficiencies(_console(), data)


@cli.command(name="reproduce-report")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--out", "out_dir", type=click.Path(), help="Folder for figure, table and JSON.")
def reproduce_report(as_json: bool, out_dir: str | None) -> None:
    """Fly the report's verification morning and compare all four models with it."""
    from studies import report_reproduction as study

    if out_dir is not None:
        from missions.output_files import check_writable_folder

        check_writable_folder(Path(out_dir))
    aircraft, mission = study.reference()
    result = study.reproduce(aircraft, mission)
    varied = study.sensitivities(aircraft, mission)
    record = study.to_json(result, mission, varied)
    if out_dir is not None:
        from missions.output_files import write_folder
        from studies.plots import to_bytes

        contents = {
            "report.json": json.dumps(record, indent=2).encode(),
            "report.md": study.markdown(result, varied).encode(),
            "report.png": to_bytes(study.figure(aircraft, mission), "png"),
        }
        write_folder(Path(out_dir), contents)
    if as_json:
        _print_json(record)
        return
    from studies.tables import print_reproduction

    print_reproduction(_console(), record)


cli.add_command(map_)
cli.add_command(sweep)
cli.add_command(compare)
cli.add_command(verify)
cli.add_command(ceiling)


def _placed(mission: Mission, latitude_deg: float | None, day: int | None) -> Mission:
    """Mission moved to another latitude or day."""
    from missions.dates import date_code
    from missions.mission import Dates

    update: dict[str, Any] = {}
    if latitude_deg is not None:
        update["latitude_deg"] = latitude_deg
    if day is not None:
        update["dates"] = Dates(on=date_code(day))
    return mission.model_copy(update=update)


def _flyable_winds(mission: Mission, winds_m_per_s: tuple[float, ...]) -> list[float]:
    """Those of the winds that the mission's flight path can be held in."""
    from missions.flight_path import largest_wind_m_per_s

    assert mission.flight_path is not None
    limit = largest_wind_m_per_s(mission.flight_path)
    return [w for w in winds_m_per_s if w < limit]


def main() -> None:
    """Run the command; a user's mistake ends as one clear message and exit code 2."""
    for stream in (sys.stdout, sys.stderr):
        # A terminal that cannot show a character shows a stand-in; it is no reason to fail.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    try:
        cli.main(prog_name="solar-uav", standalone_mode=True)
    except ValueError as error:
        from missions.problems import InputError
        from sizing.design import ImpossibleDesignError

        if isinstance(error, InputError):
            click.echo(str(error), err=True)
            sys.exit(EXIT_BAD_INPUT)
        if isinstance(error, ImpossibleDesignError):
            click.echo(f"solar-uav: {error}", err=True)
            sys.exit(EXIT_FAILED)
        raise
    except OSError as error:
        click.echo(f"solar-uav: {error}", err=True)
        sys.exit(EXIT_FAILED)


if __name__ == "__main__":
    main()
