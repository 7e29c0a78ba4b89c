"""The command ``solar-uav analyse``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from studies.cli.files import Case

from studies.cli.help_texts import command
from studies.cli.options import (
    Asked,
    Parsed,
    aircraft_argument,
    check_image,
    completes,
    figure_options,
    gathered,
    mission_option,
    solar_options,
    table_option,
)
from studies.output.figures.options import FigureOptions
from studies.output.formats import table_bytes


@dataclass(frozen=True)
class _Flight:
    """Where, when and for how long, instead of the mission's own."""

    latitude: float | None
    day_of_year: int | None
    date: int | None
    days: int | None
    weather_file: str | None

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        if self.day_of_year is not None and self.date is not None:
            raise click.UsageError("give --day-of-year or --date, not both")
        if self.weather_file is None:
            return
        if self.days is not None:
            raise click.UsageError("give --days or --weather, not both")
        if self.latitude is not None:
            raise click.UsageError(
                "a weather record has its own place: give --latitude or --weather"
            )
        if self.day_of_year is not None or self.date is not None:
            dated = "--date" if self.date is not None else "--day-of-year"
            raise click.UsageError(f"a weather record has its own days: give {dated} or --weather")

    def of(self, case: Case) -> Case:
        """Case at this place and on this day."""
        from missions.dates import date_code

        moved: dict[str, Any] = {} if self.latitude is None else {"latitude_deg": self.latitude}
        day = self.day_of_year if self.day_of_year is not None else self.date
        if day is not None:
            moved["dates"] = {"on": date_code(day)}
        if moved:
            # The mission's launch is one at its own place and day.
            case = case.with_mission(**moved, launch=None)
        if self.days is not None and case.mission.climb is not None:
            raise click.UsageError("--days flies at constant altitude: give it or mission.climb")
        return case


@command("solar-uav analyse atlantiksolar-as2 --latitude 47.6 --date 10-15")
@aircraft_argument()
@mission_option()
@click.option(
    "--latitude",
    type=Parsed("deg", "missions.places:latitude_deg"),
    help="Latitude, -90 to 90 (north) or as 33.9S, instead of the mission's.",
)
@click.option("--day-of-year", type=click.IntRange(1, 365), help="Day instead of the mission's.")
@click.option(
    "--date",
    type=Parsed("mm-dd", "missions.dates:day_of_year"),
    help="Date instead of the mission's, e.g. 10-15 or 15 Oct.",
)
@click.option(
    "--days",
    type=click.IntRange(1, 365),
    help="Fly so many days from an empty battery, the date advancing, not one day without end.",
)
@click.option(
    "--weather",
    "weather_file",
    shell_complete=completes("weather_file"),
    type=click.Path(),
    metavar="FILE",
    help="Fly through a weather record: EPW, TMY2, TMY3, PVGIS, NSRDB PSM, BSRN or plain CSV.",
)
@table_option("the cycle over time, or the days of the weather record")
@table_option("the years of the weather record, a row a year", "--table-years", older="--csv-years")
@click.option(
    "--plot",
    "plot_file",
    type=click.Path(),
    help="Draw the cycle, or the weather record (png, svg, pdf).",
)
@solar_options
@figure_options
@gathered("flight", _Flight)
def analyse(
    asked: Asked,
    flight: _Flight,
    table_file: str | None,
    table_years: str | None,
    plot_file: str | None,
    figure: FigureOptions,
) -> None:
    """Analyse how long AIRCRAFT (name, file or folder) flies, there and then."""
    from sizing.results.analysis import analyse as run_analysis
    from studies.cli.checks import (
        check_outputs,
        refuse_to_overwrite,
        require_climber,
        require_path,
    )
    from studies.cli.outputs import told, write_results
    from studies.output.plots import plot_cycle, plot_flight

    if table_years is not None and flight.weather_file is None:
        raise click.UsageError("--table-years needs --weather: years are those of a weather record")
    check_image(plot_file)
    check_outputs(**{"table": table_file, "table-years": table_years, "plot": plot_file})
    for option, path in (("--table", table_file), ("--table-years", table_years)):
        refuse_to_overwrite(option, path, (flight.weather_file,))
    case = flight.of(asked.case())
    require_path(case)
    if flight.weather_file is not None:
        _in_weather(case, flight.weather_file, table_file, table_years, plot_file, figure)
        return
    require_climber(case)
    solar, days = case.solar, flight.days
    result = run_analysis(
        case.aircraft, case.mission, model=solar.model, correction=solar.correction, days=days
    )
    flown = result.flight
    with told(
        *(case, case.named(result.to_dict()), result),
        files=(table_file, plot_file),
        next_step=_next_step(case, perpetual=bool(result.performance.cycle.perpetual.all())),
    ):
        write_results(
            table_file,
            lambda: table_bytes(result.trajectory(), table_file, title="cycle"),
            plot_file,
            lambda: (
                plot_cycle(result, figure=figure)
                if flown is None
                else plot_flight(result, flown, figure=figure)
            ),
        )


def _next_step(case: Case, *, perpetual: bool) -> str:
    """What to do after an analysis."""
    from studies.cli.outputs import call

    if perpetual:
        return f"{call('map')} (where and when else)"
    if case.aircraft.airframe.kind == "parametric":
        return f"{call('size')} (a design that flies perpetually)"
    return f"{call('map')} (where and when it flies perpetually)"


def _in_weather(
    case: Case,
    weather_file: str,
    table_file: str | None,
    table_years: str | None,
    plot_file: str | None,
    figure: FigureOptions,
) -> None:
    """Fly the case through a weather record, and tell what became of it."""
    from missions.weather.files import load_weather
    from sizing.results.analysis import analyse as run_analysis
    from sizing.results.weather import analyse_weather
    from studies.cli.outputs import told, write_results
    from studies.weather.plots import plot_weather

    weather = load_weather(weather_file)
    if table_years is not None and weather.typical:
        raise click.UsageError("--table-years needs a record of years: this is a typical year")
    result = analyse_weather(
        case.aircraft,
        case.mission,
        weather,
        model=case.solar.model,
        correction=case.solar.correction,
        mission_chosen=not case.mission_is_default,
    )
    record = {"weather": result.to_dict()}
    if case.as_json:
        clear_day = run_analysis(
            case.aircraft,
            result.mission,
            model=case.solar.model,
            correction=case.solar.correction,
            replay=False,
        )
        record = clear_day.to_dict() | record
    files = (table_file, table_years, plot_file)
    with told(case, case.named(record), result, files=files):
        write_results(
            table_years, lambda: table_bytes(result.to_years_frame(), table_years, title="years")
        )
        write_results(
            table_file,
            lambda: table_bytes(result.to_frame(), table_file, title="days"),
            plot_file,
            lambda: plot_weather(result, figure=figure),
        )
