"""Results of the search for the ceiling of perpetual flight: JSON, table, words and figure."""

from __future__ import annotations

import math
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from missions.mission import Scenarios
from sizing.altitude.ceiling import AltitudeFlight, PerpetualCeiling
from sizing.results.records import finite
from sizing.sunlight import SolarModel
from studies.output.plots import CHARGE, LOAD, SUN, caption

_PRINTED_ROWS = 20
_MARK = "#555555"


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
        "best_excess_time_h": finite(found.best.excess_time_h),
        "altitudes": [flight_record(flight) for flight in found.flights],
    }


def flight_record(flight: AltitudeFlight) -> dict[str, Any]:
    """One altitude, JSON-ready."""
    return {
        name: value if name == "worst_scenario" else finite(value)
        for name, value in vars(flight).items()
    }


def altitude_table(found: PerpetualCeiling) -> pd.DataFrame:
    """All altitudes, one row each."""
    return pd.DataFrame([vars(flight) for flight in found.flights])


def print_ceiling(
    console: Console, found: PerpetualCeiling, record: dict[str, Any], scenarios: Scenarios
) -> None:
    """Ceiling in words, and a table of altitudes around and below it."""
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
    figure = Figure(figsize=(9.0, 4.8), layout="constrained")
    excess, power, income = figure.subplots(1, 3, sharey=True)
    altitude_km = found.column("altitude_m") / 1000.0
    excess.plot(found.column("excess_time_h"), altitude_km, color=CHARGE)
    excess.axvline(found.required_excess_time_h, color=_MARK, linewidth=0.8)
    power.plot(found.column("propulsion_power_w"), altitude_km, color=LOAD)
    power.set(xlabel="level-flight power [W]", xlim=(0.0, None))
    income.plot(found.column("solar_energy_wh"), altitude_km, color=SUN, label="sun")
    income.plot(
        found.column("load_energy_wh"), altitude_km, color=LOAD, linestyle="--", label="load"
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
