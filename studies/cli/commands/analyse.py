"""The command ``solar-uav analyse``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from studies.cli.checks import require_climber
from studies.cli.options import (
    check_image,
    check_outputs,
    csv_bytes,
    load,
    mission_option,
    print_json,
    refuse_polar_night,
    require_path,
    solar_model,
    solar_options,
    write_results,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from missions.mission import Mission
    from sizing.results.analysis import Analysis


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


@click.command(short_help="How long it flies, there and then.")
@click.argument("aircraft")
@mission_option()
@click.option(
    "--latitude", type=Latitude(), help="Latitude, -90 to 90 (north), instead of the mission's."
)
@click.option("--day-of-year", type=click.IntRange(1, 365), help="Day instead of the mission's.")
@click.option("--date", type=MonthDay(), help="Date instead of the mission's, e.g. 10-15.")
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
    from sizing.results.analysis import analyse as run_analysis

    if day_of_year is not None and date is not None:
        raise click.UsageError("give --day-of-year or --date, not both")
    check_image(plot_file)
    check_outputs(csv=csv_file, plot=plot_file)
    craft, where = load(aircraft, mission, overrides)
    day = day_of_year if day_of_year is not None else date
    placed = _placed(where.mission, latitude, day)
    refuse_polar_night(placed, where, options=latitude is not None or day is not None)
    require_path(model, correction, craft, where)
    require_climber(craft, where)
    replay = latitude is None and day is None
    solar = solar_model(model, correction)
    result = run_analysis(
        craft.aircraft, placed, model=solar.model, correction=solar.correction, replay=replay
    )
    write_results(
        csv_file,
        lambda: csv_bytes(result.trajectory()),
        plot_file,
        lambda: _figure(result),
    )
    if as_json:
        print_json(result.to_dict())
        return
    from studies.output.terminal import show

    show(result)


def _figure(result: Analysis) -> Figure:
    """Replayed flight where there is one, else the cycle of the worst scenario."""
    from studies.output import plots

    flight = result.flight
    return plots.cycle_figure(result) if flight is None else plots.flight_figure(result, flight)


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
