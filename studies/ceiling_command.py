"""The command ``solar-uav ceiling``."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any

import click

from studies.climb_checks import refuse_climb
from studies.command_options import (
    DEFAULT_MISSION,
    EXIT_FAILED,
    check_outputs,
    console,
    image_format,
    load,
    print_json,
    progress_bar,
    refuse_polar_night,
    require_path,
    solar_model,
    solar_options,
    write_files,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from rich.console import Console

    from missions.mission import Scenarios
    from sizing.ceiling import AltitudeFlight, PerpetualCeiling
    from sizing.performance import SolarModel

_HIGHEST_M, _LEAST_STEP_M = 32000.0, 10.0
_PRINTED_ROWS = 20
# Okabe & Ito's palette, as in studies.plots, which is not imported at start-up.
_EXCESS, _POWER, _INCOME, _MARK = "#009E73", "#0072B2", "#E69F00", "#555555"


@click.command()
@click.argument("aircraft")
@click.option("--mission", "-m", default=DEFAULT_MISSION, show_default=True, help="Name or file.")
@click.option(
    "--highest",
    "highest_m",
    type=click.FloatRange(-500.0, _HIGHEST_M),
    default=20000.0,
    show_default=True,
    metavar="METRES",
    help="End of the search, which starts at the mission's altitude.",
)
@click.option(
    "--step",
    "step_m",
    type=click.FloatRange(_LEAST_STEP_M, 10000.0),
    default=250.0,
    show_default=True,
    metavar="METRES",
    help="Spacing of the altitudes that are tried.",
)
@click.option("--csv", "csv_file", type=click.Path(), help="Write the altitudes as CSV.")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw them (png, svg, pdf).")
@solar_options
def ceiling(
    aircraft: str,
    mission: str,
    highest_m: float,
    step_m: float,
    csv_file: str | None,
    plot_file: str | None,
    model: str,
    correction: str,
    overrides: tuple[str, ...],
    as_json: bool,
) -> None:
    """Find how high AIRCRAFT (name or file) flies for ever; exit code 1 if nowhere."""
    from sizing.ceiling import highest_perpetual_altitude

    image = image_format(plot_file)
    check_outputs(csv=csv_file, plot=plot_file)
    _require_numbers(highest_m, step_m)
    craft, where = load(aircraft, mission, overrides)
    refuse_climb(where, "ceiling")
    refuse_polar_night(where.mission, where, options=False)
    require_path(model, correction, craft, where)
    if highest_m <= where.mission.altitude_m:
        message = f"must be above the mission's altitude_m of {where.mission.altitude_m:g}"
        raise click.BadParameter(f"{message} (got {highest_m:g})", param_hint="--highest")
    solar = solar_model(model, correction)
    with progress_bar("altitudes") as progress:
        found = highest_perpetual_altitude(
            craft.aircraft,
            where.mission,
            solar,
            highest_m=highest_m,
            step_m=step_m,
            progress=progress,
        )
    record = to_json(found, craft.aircraft.name, where.mission.name, solar)
    contents: dict[str | os.PathLike[str], bytes] = {}
    if csv_file is not None:
        contents[csv_file] = to_csv(found).encode()
    if plot_file is not None and image is not None:
        from studies.plots import to_bytes

        title = f"{craft.aircraft.name}, {where.mission.name}"
        contents[plot_file] = to_bytes(ceiling_figure(found, title, solar), image)
    write_files(contents)
    if as_json:
        print_json(record)
    else:
        print_ceiling(console(), found, record, where.mission.scenarios())
    if found.highest is None:
        raise SystemExit(EXIT_FAILED)


def _require_numbers(highest_m: float, step_m: float) -> None:
    """Refuse NaN, which passes every range."""
    for name, value in (("--highest", highest_m), ("--step", step_m)):
        if math.isnan(value):
            raise click.BadParameter("must be a number of metres", param_hint=name)


# ---- Results


def to_json(
    found: PerpetualCeiling, aircraft: str, mission: str, solar: SolarModel
) -> dict[str, Any]:
    """Ceiling and all altitudes, JSON-ready."""
    highest = found.highest
    return {
        "aircraft": aircraft,
        "mission": mission,
        "model": solar.model,
        "correction": solar.correction,
        "required_excess_time_h": found.required_excess_time_h,
        "highest_perpetual_altitude_m": None if highest is None else highest.altitude_m,
        "at_search_limit": found.at_search_limit,
        "best_altitude_m": found.best.altitude_m,
        "best_excess_time_h": _finite(found.best.excess_time_h),
        "altitudes": [flight_record(flight) for flight in found.flights],
    }


def flight_record(flight: AltitudeFlight) -> dict[str, Any]:
    """One altitude, JSON-ready."""
    return {
        name: value if name == "worst_scenario" else _finite(value)
        for name, value in vars(flight).items()
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def to_csv(found: PerpetualCeiling) -> str:
    """All altitudes as CSV."""
    import pandas as pd

    return pd.DataFrame([vars(flight) for flight in found.flights]).to_csv(index=False)


def print_ceiling(
    console: Console, found: PerpetualCeiling, record: dict[str, Any], scenarios: Scenarios
) -> None:
    """Ceiling in words, and a table of altitudes around and below it."""
    from rich.table import Table

    console.print(f"{record['aircraft']}, {record['mission']}: {_verdict(found)}", style="bold")
    table = Table()
    several = len(scenarios) > 1
    heads = ["altitude m", "excess h", "charge %", "level W", "sun Wh", "speed m/s"]
    for name in heads:
        table.add_column(name, justify="right")
    if several:
        table.add_column("worst", no_wrap=True)
    for flight in _printed(found):
        table.add_row(
            f"{flight.altitude_m:.0f}",
            _shown(flight.excess_time_h, ".2f"),
            _shown(100.0 * flight.minimum_state_of_charge, ".1f"),
            _shown(flight.propulsion_power_w, ".1f"),
            _shown(flight.solar_energy_wh, ".0f"),
            _shown(flight.airspeed_m_per_s, ".1f"),
            *([scenarios.label(flight.worst_scenario)] if several else []),
            style="bold" if flight is found.highest else None,
        )
    console.print(table)
    console.print(
        f"{record['model']}, correction: {record['correction']}; excess time, least state of "
        "charge, electric power of level flight, electric energy of the sun over a day, airspeed",
        style="dim",
    )


def _printed(found: PerpetualCeiling) -> list[AltitudeFlight]:
    """Both ends, some altitudes between them, and the ceiling."""
    ends = (found.flights[0], found.flights[-1])
    between = found.flights[1:-1]
    altitudes = [flight.altitude_m for flight in between]
    step = altitudes[1] - altitudes[0] if len(altitudes) > 1 else 1.0
    stride = max(-(-len(between) // _PRINTED_ROWS), 1)
    # Multiples of a round step rather than every so many from the first.
    shown = [f for f in between if round(f.altitude_m / step) % stride == 0]
    shown += [f for f in (*ends, found.highest) if f is not None and f not in shown]
    return sorted(shown, key=lambda flight: flight.altitude_m)


def _verdict(found: PerpetualCeiling) -> str:
    required = found.required_excess_time_h
    more = f" with more than {required:g} h of excess time" if required > 0.0 else ""
    endless = math.isinf(found.best.excess_time_h)
    largest = "without end" if endless else f"{found.best.excess_time_h:.2f} h"
    best = f"largest excess time {largest} at {found.best.altitude_m:.0f} m"
    if found.highest is None:
        return f"no perpetual flight{more} at any altitude; {best}"
    beyond = " and beyond the search" if found.at_search_limit else ""
    return f"perpetual flight{more} up to {found.highest.altitude_m:.0f} m{beyond}; {best}"


def _shown(value: float, digits: str) -> str:
    if math.isinf(value):
        return "endless"
    return "-" if math.isnan(value) else f"{value:{digits}}"


def ceiling_figure(found: PerpetualCeiling, title: str, solar: SolarModel) -> Figure:
    """Excess time, power of level flight and daily income over altitude, the ceiling marked."""
    from matplotlib.figure import Figure

    from studies.plots import caption

    figure = Figure(figsize=(9.0, 4.8), layout="constrained")
    excess, power, income = figure.subplots(1, 3, sharey=True)
    altitude_km = found.column("altitude_m") / 1000.0
    excess.plot(found.column("excess_time_h"), altitude_km, color=_EXCESS)
    excess.axvline(found.required_excess_time_h, color=_MARK, linewidth=0.8)
    power.plot(found.column("propulsion_power_w"), altitude_km, color=_POWER)
    power.set(xlabel="level-flight power [W]", xlim=(0.0, None))
    income.plot(found.column("solar_energy_wh"), altitude_km, color=_INCOME, label="sun")
    income.plot(
        found.column("load_energy_wh"), altitude_km, color=_POWER, linestyle="--", label="load"
    )
    income.set(xlabel="energy of the day [Wh]", xlim=(0.0, None))
    income.legend(loc="lower right", fontsize="small")
    excess.set(xlabel="excess time [h]", ylabel="altitude [km]")
    for axes in (excess, power, income):
        _mark_ceiling(axes, found)
        axes.grid(alpha=0.3)
    if found.highest is not None:
        excess.annotate(
            f"ceiling {found.highest.altitude_m:.0f} m",
            (0.96, found.highest.altitude_m / 1000.0),
            (0, 4),
            xycoords=excess.get_yaxis_transform(),
            textcoords="offset points",
            ha="right",
        )
    figure.suptitle(f"{title}, worst scenario ({caption(solar)})", parse_math=False)
    return figure


def _mark_ceiling(axes: Axes, found: PerpetualCeiling) -> None:
    """Dotted line at the ceiling, none where the search ended below it."""
    if found.highest is not None and not found.at_search_limit:
        axes.axhline(found.highest.altitude_m / 1000.0, color=_MARK, linestyle=":", linewidth=1.2)
