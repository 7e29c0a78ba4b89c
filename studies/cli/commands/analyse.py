"""Commands to analyse with: ``solar-uav analyse``, ``map``, ``ceiling``, ``station`` and others."""

from __future__ import annotations

import click

from sizing.program.objectives import RESIZE_NAMES
from studies.cli.command import command, option
from studies.cli.options import (
    DrawnOptions,
    JsonOptions,
    LevelOptions,
    MassOptions,
    ModelOptions,
    PlaceOptions,
    WorkOptions,
    grid_option,
    plot_option,
    table_option,
    weather_option,
)
from studies.cli.values import Grid, RealRange

_HIGHEST_M, _LEAST_STEP_M = 32000.0, 10.0


@command(
    "Analyse",
    "How long it flies, there and then.",
    "analyse:analyse",
    "solar-uav analyse atlantiksolar-as2 --latitude 47.6 --date 10-15",
)
class Analyse(ModelOptions, LevelOptions, MassOptions, PlaceOptions, DrawnOptions):
    """Analyse how long AIRCRAFT (name, file or folder) flies, there and then."""

    weather_file: str | None = weather_option(
        "Fly through a weather record: EPW, TMY2, TMY3, PVGIS, SAM, BSRN, POWER, ERA5 or plain CSV."
    )
    table_file: str | None = table_option("the cycle over time, or the days of the weather record")
    table_years: str | None = table_option(
        "the years of the weather record, a row a year", "--table-years", older="--csv-years"
    )
    plot_file: str | None = plot_option("Draw the cycle, or the weather record")

    def refuse(self) -> None:
        """Refuse what does not go together."""
        if self.weather_file is None:
            if self.table_years is not None:
                raise click.UsageError(
                    "--table-years needs --weather: years are those of a weather record"
                )
            return
        self.refuse_with_weather()


@command(
    "Analyse",
    "Where and when it flies perpetually.",
    "map:map_",
    "solar-uav map atlantiksolar-as2 --latitudes 0:70:5 --plot map.png",
)
class Map(ModelOptions, LevelOptions, MassOptions, WorkOptions, DrawnOptions):
    """Map where and when AIRCRAFT (name, file or folder) flies perpetually.

    Latitude against season; of the mission the air and the load count, not its latitudes and
    dates. With --resize: which design flies there and then. The exit code is 1 if any cell could
    not be computed.
    """

    latitudes: list[float] | None = option(
        "--latitudes",
        type=Grid(-90.0, 90.0, latitudes=True),
        help="Latitudes [deg], north positive; the last one is met where the steps lead to it. "
        "[default: -70:70:1; with --resize, --endurance, VM, FM, loiter and climb -70:70:2]",
    )
    days: list[float] | None = option(
        "--days",
        type=Grid(1.0, 365.0, whole=True),
        help="Days of the year, 1 to 365; the last one is met where the steps lead to it. "
        "[default: 1:365:1; where --latitudes has steps of 2 by itself 1:365:4]",
    )
    endurance: bool = option(
        "--endurance",
        is_flag=True,
        help="Also the longest flight of each cell (slow); not with --resize.",
    )
    objective: str | None = option(
        "--resize",
        type=click.Choice(RESIZE_NAMES),
        help="Size the aircraft anew in every cell for it.",
    )
    out_file: str | None = grid_option("all cells")
    plot_file: str | None = plot_option("Draw the map")

    def refuse(self) -> None:
        """Refuse what does not go together."""
        if self.objective is not None and self.endurance:
            raise click.UsageError("--endurance is of a fixed aircraft; not with --resize")


@command(
    "Analyse",
    "How high it flies perpetually.",
    "ceiling:ceiling",
    "solar-uav ceiling atlantiksolar-as2 --plot ceiling.png",
)
class Ceiling(ModelOptions, LevelOptions, DrawnOptions):
    """Find how high AIRCRAFT (name, file or folder) flies perpetually; exit code 1 if nowhere."""

    highest_m: float | None = option(
        "--highest",
        type=RealRange(-500.0, _HIGHEST_M, unit="metres"),
        metavar="METRES",
        help="End of the search, which starts at the mission's altitude and goes down from there "
        "where nothing above is feasible; by default 20000, for missions above 15000 m 32000.",
    )
    step_m: float = option(
        "--step",
        type=RealRange(_LEAST_STEP_M, 10000.0, unit="metres"),
        default=250.0,
        show_default=True,
        metavar="METRES",
        help="Spacing of the altitudes that are tried.",
    )
    table_file: str | None = table_option("the altitudes")
    plot_file: str | None = plot_option("Draw them")


@command(
    "Analyse",
    "How often it holds its place in the wind.",
    "station:station",
    "solar-uav station my-aircraft.yaml -m my-mission.yaml --latitudes 0:60:5 --plot station.png",
)
class Station(ModelOptions, LevelOptions, WorkOptions, DrawnOptions):
    """Tell how much of the time AIRCRAFT (name, file or folder) holds its place, by month.

    Latitude against month, altitude against month at the mission's latitude, or latitude against
    month at the best altitude. It flies as fast as the repeated
    day allows, and the wind is that of the mission's key wind.
    """

    latitudes: list[float] | None = option(
        "--latitudes",
        type=Grid(-90.0, 90.0, latitudes=True),
        help="Latitudes [deg], north positive. [default: -70:70:5]",
    )
    altitudes: list[float] | None = option(
        "--altitudes",
        type=Grid(-500.0, 32000.0),
        help="Altitudes [m] in place of latitudes; with --latitudes too, that of the largest share "
        "is flown in each month.",
    )
    out_file: str | None = grid_option("all cells")
    plot_file: str | None = plot_option("Draw them")


@command(
    "Analyse",
    "How likely it flies perpetually when inputs scatter.",
    "uncertainty:uncertainty",
    "solar-uav uncertainty atlantiksolar-as2 --samples 1024",
)
class Uncertainty(ModelOptions, LevelOptions, DrawnOptions):
    """Find how likely AIRCRAFT (name, file or folder) flies perpetually when its inputs scatter."""

    samples: int = option(
        "--samples",
        type=click.IntRange(64, 2**20),
        default=8192,
        show_default=True,
        help="Draws of all uncertain inputs, rounded up to a power of two.",
    )
    seed: int = option(
        "--seed",
        type=click.IntRange(0, 2**31),
        default=0,
        show_default=True,
        help="The same seed gives the same draws.",
    )
    no_model_error: bool = option(
        "--no-model-error",
        is_flag=True,
        help="Leave out the error of the solar power model, which is an input by itself.",
    )
    table_file: str | None = table_option("the draws")
    plot_file: str | None = plot_option("Draw them")


@command(
    "Analyse",
    "A page on a design, to be read or printed.",
    "report:report",
    "solar-uav report atlantiksolar-as2 -m rafz-july --out report.html",
)
class Report(ModelOptions, JsonOptions, MassOptions):
    """Write a report on AIRCRAFT (name, file or folder): one page, to be read or printed."""

    out_file: str = option(
        "--out",
        type=click.Path(),
        required=True,
        metavar="FILE",
        help="Write the page: .html, or .pdf for the printed one alone.",
    )
    with_pdf: bool = option("--pdf", is_flag=True, help="Also print it, beside the page, as PDF.")
    project: str = option("--project", default="", metavar="TEXT", help="Project, for the head.")
    author: str = option("--author", default="", metavar="TEXT", help="Author, for the head.")
    weather_file: str | None = weather_option("Also fly through a weather record, as analyse does.")
    uncertainty: bool | None = option(
        "--uncertainty/--no-uncertainty",
        default=None,
        help="Whether inputs scatter.  [default: if aircraft or mission has uncertain inputs]",
    )
