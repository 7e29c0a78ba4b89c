"""The command ``solar-uav``.

Heavy packages are imported inside the commands that use them, so that help texts appear at once.
"""

from __future__ import annotations

import io
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from solar._version import __version__
from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, OBJECTIVE_NAMES
from studies.ceiling_command import ceiling
from studies.climb_checks import refuse_climb, require_climber
from studies.verify_command import verify

if TYPE_CHECKING:
    from missions.mission import Mission
    from sizing.performance import SolarModel
    from studies.library import LoadedAircraft, LoadedMission

DEFAULT_MISSION = "rafz-july"
EXIT_FAILED, EXIT_BAD_INPUT = 1, 2

_MAXIMUM_GRID = 2000

Command = TypeVar("Command", bound=Callable[..., Any])


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


class Grid(click.ParamType["list[float]"]):
    """Evenly spaced numbers ``first:last:step``, both ends included."""

    name = "first:last:step"

    def __init__(self, lowest: float, highest: float) -> None:
        self.lowest, self.highest = lowest, highest

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> list[float]:
        """Read the numbers and check their range."""
        try:
            first, last, step = (float(part) for part in str(value).split(":"))
        except ValueError:
            self.fail(f"{value!r} is not first:last:step, for example -70:70:2", param, ctx)
        if not (self.lowest <= first <= last <= self.highest and step > 0.0):
            self.fail(
                f"must rise within {self.lowest:g} to {self.highest:g} by a positive step "
                f"(got {value})",
                param,
                ctx,
            )
        count = int((last - first) / step + 1e-9) + 1
        if count > _MAXIMUM_GRID:
            self.fail(f"has {count} numbers, at most {_MAXIMUM_GRID} are allowed", param, ctx)
        return [first + i * step for i in range(count)]


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


def solar_options(command: Command) -> Command:
    """Options of the solar power model, shared by all studies."""
    for option in (
        click.option(
            "--set",
            "overrides",
            metavar="KEY=VALUE",
            multiple=True,
            help="Override a key of the aircraft file, e.g. power.avionics_w=8, or of the mission "
            "with the prefix 'mission.', e.g. mission.clearness=0.8. May be repeated.",
        ),
        click.option(
            "--correction",
            type=click.Choice(CORRECTION_NAMES),
            default="none",
            show_default=True,
            help="Correct the model's systematic error as measured in flight.",
        ),
        click.option(
            "--model",
            type=click.Choice(MODEL_NAMES),
            default="CAM",
            show_default=True,
            help="Solar power model.",
        ),
        click.option("--json", "as_json", is_flag=True, help="Print JSON instead of tables."),
    ):
        command = option(command)
    return command


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
    from sizing.optimiser import size_aircraft
    from studies import sizing_study

    craft, where = _load(aircraft, mission, overrides)
    if isinstance(craft.aircraft.airframe, MeasuredAirframe):
        from missions.configfile import located_error

        raise located_error(
            craft.document,
            ("airframe", "kind"),
            "a measured aircraft cannot be sized; allowed: parametric",
        )
    refuse_climb(where, "size")
    _refuse_polar_night(where.mission, where, options=False)
    _require_path(model, correction, craft, where)
    if required_h is not None and required_h != required_h:
        raise click.BadParameter("must be a number of hours", param_hint="--required-excess-time")
    if out_dir is not None:
        from missions.output_files import check_writable_folder

        check_writable_folder(Path(out_dir))
    result = size_aircraft(
        craft.aircraft,
        where.mission,
        Objective(objective),
        _solar_model(model, correction),
        required_excess_time_h=required_h,
    )
    record = sizing_study.to_json(result, craft.aircraft, where.mission)
    asked = (craft.aircraft, where.mission, result, _solar_model(model, correction))
    worth = None
    if with_sensitivities and result.feasible:
        from sizing.sensitivity import sensitivities

        worth = sensitivities(*asked)
        record["sensitivities"] = sizing_study.sensitivity_records(worth)
    certificate = None
    if with_certificate and result.feasible:
        from sizing.certificate import certify

        certificate = certify(*asked)
        record["certificate"] = sizing_study.certificate_record(certificate)
    if out_dir is not None and result.feasible:
        from studies.sizing_files import write_sizing

        write_sizing(Path(out_dir), result, record, craft, where.mission, worth)
    if as_json:
        _print_json(record)
    else:
        from studies.tables import print_sizing

        print_sizing(_console(), result, record)
        if worth is not None:
            from studies.tables import print_sensitivities

            print_sensitivities(_console(), worth, result.objective)
        if certificate is not None:
            from studies.tables import print_certificate

            print_certificate(_console(), certificate, result.objective)
        if out_dir is not None and result.feasible:
            click.echo(f"written to {out_dir}")
    if not result.feasible:
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


@cli.command(name="map")
@click.argument("aircraft")
@click.option("--mission", "-m", default=DEFAULT_MISSION, show_default=True, help="Name or file.")
@click.option("--latitudes", type=Grid(-90.0, 90.0), default="-70:70:2", show_default=True)
@click.option("--days", type=Grid(1.0, 365.0), default="1:365:4", show_default=True)
@click.option("--endurance", is_flag=True, help="Also the longest flight of each cell (slow).")
@click.option("--out", "out_file", type=click.Path(), help="Write the map as NetCDF.")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw the map (png, svg, pdf).")
@solar_options
def map_(
    aircraft: str,
    mission: str,
    latitudes: list[float],
    days: list[float],
    endurance: bool,
    out_file: str | None,
    plot_file: str | None,
    model: str,
    correction: str,
    overrides: tuple[str, ...],
    as_json: bool,
) -> None:
    """Map where and when AIRCRAFT (name or file) flies for ever: latitude against season."""
    import numpy as np

    from studies import feasibility_map as study

    image = _image_format(plot_file)
    craft, where = _load(aircraft, mission, overrides)
    refuse_climb(where, "map")
    _require_path(model, correction, craft, where)
    with _progress("cells") as progress:
        data = study.feasibility_map(
            craft.aircraft,
            where.mission,
            np.array(latitudes),
            np.unique(np.round(days).astype(int)),
            _solar_model(model, correction),
            endurance=endurance,
            progress=progress,
        )
    contents: dict[str | os.PathLike[str], bytes] = {}
    if out_file is not None:
        contents[out_file] = study.to_netcdf_bytes(data)
    if plot_file is not None and image is not None:
        from studies.plots import to_bytes

        contents[plot_file] = to_bytes(study.map_figure(data), image)
    _write_files(contents)
    season = study.season_length(data)
    if as_json:
        _print_json(
            {
                "latitude_deg": data["latitude"].to_numpy().tolist(),
                "days": data["day"].to_numpy().tolist(),
                "perpetual_days": season.to_numpy().tolist(),
            }
        )
        return
    from studies.tables import print_seasons

    print_seasons(_console(), data, season)


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


cli.add_command(verify)
cli.command()(solar_options(ceiling))


def _load(
    aircraft: str, mission: str, overrides: tuple[str, ...]
) -> tuple[LoadedAircraft, LoadedMission]:
    """Load both files and report what is wrong with either of them together."""
    from missions.problems import InputError
    from studies.library import load_aircraft, load_mission, split_overrides

    of_aircraft, of_mission = split_overrides(overrides)
    try:
        craft = load_aircraft(aircraft, of_aircraft)
    except InputError as error:
        try:
            load_mission(mission, of_mission)
        except InputError as second:
            raise InputError([*error.problems, *second.problems]) from None
        raise
    return craft, load_mission(mission, of_mission)


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


def _refuse_polar_night(mission: Mission, where: LoadedMission, *, options: bool) -> None:
    """Refuse scenarios in which the sun never rises: there is nothing to analyse or to size."""
    from missions.configfile import located_error

    scenarios = mission.scenarios()
    dark = scenarios.in_polar_night()
    if not dark.any():
        return
    label = scenarios.label(int(dark.argmax()))
    message = f"polar night: the sun never rises at {label}; allowed: latitudes and dates with sun"
    if options:
        raise click.UsageError(f"--latitude/--date: {message}")
    raise located_error(where.document, ("latitude_deg",), message)


def _flyable_winds(mission: Mission, winds_m_per_s: tuple[float, ...]) -> list[float]:
    """Those of the winds that the mission's flight path can be held in."""
    from missions.flight_path import largest_wind_m_per_s

    assert mission.flight_path is not None
    limit = largest_wind_m_per_s(mission.flight_path)
    return [w for w in winds_m_per_s if w < limit]


def _require_path(model: str, correction: str, craft: LoadedAircraft, where: LoadedMission) -> None:
    """Refuse VM, FM and the loiter correction without module surfaces and a flight path."""
    if model not in ATTITUDE_MODELS and correction != "loiter":
        return
    from missions.configfile import located_error
    from missions.flight_path import orbit

    asked = f"--model {model}" if model in ATTITUDE_MODELS else "--correction loiter"
    if craft.aircraft.modules.geometry is None:
        message = f"{asked} needs the module surfaces: add geometry with its surfaces"
        raise located_error(craft.document, ("modules",), message)
    if where.mission.flight_path is None:
        message = f"{asked} needs a flight path: add flight_path with kind, radius_m, ..."
        raise located_error(where.document, ("name",), message)
    try:
        orbit(where.mission.flight_path, where.mission.wind, samples=4)
    except ValueError as error:
        raise located_error(where.document, ("flight_path",), str(error)) from None


def _solar_model(model: str, correction: str) -> SolarModel:
    from sizing.performance import SolarModel

    return SolarModel(model, correction)  # type: ignore[arg-type]  # click checked both


@contextmanager
def _progress(unit: str) -> Iterator[Callable[[int, int], None]]:
    """Progress bar on a terminal's standard error, nothing elsewhere."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(unit)

        def update(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)

        yield update


def _write_files(contents: dict[str | os.PathLike[str], bytes]) -> None:
    """Write all files of a command, or none."""
    from missions.output_files import write_files_atomically

    write_files_atomically(contents)


def _image_format(path: str | None) -> str | None:
    if path is None:
        return None
    from studies.formats import IMAGE_FORMATS, image_format

    found = image_format(path)
    if found is None:
        allowed = ", ".join(f".{f}" for f in IMAGE_FORMATS)
        raise click.BadParameter(f"{path!r} must end in {allowed}", param_hint="--plot")
    return found


def _console() -> Any:
    from rich.console import Console

    # Names from files are text, never markup.
    return Console(highlight=False, markup=False, emoji=False)


def _print_json(record: Any) -> None:
    click.echo(json.dumps(record, indent=2, allow_nan=False))


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
