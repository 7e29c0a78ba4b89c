"""Ceiling of perpetual flight: the search's result as text, table, record and figure."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.ceiling import (
    DEFAULT_STEP_M,
    HOPELESS_H,
    PerpetualCeiling,
    highest_perpetual_altitude,
)
from sizing.day.light import SolarModel
from sizing.results.result import Result, data_frame
from sizing.validity.extrapolations import merge_extrapolations
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
from solar.schema import spell
from studies.output.figures import drawing
from studies.output.figures.options import DEFAULT
from studies.quantities import EXCESS_TIME, group, table_of, text_of
from studies.render.tables import Line, Table
from studies.render.words import extrapolation_blocks, extrapolation_caption, hours
from studies.serialise import plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

_ROWS = {1: 11, 2: 21}  # of the table, by level


@dataclass(frozen=True, repr=False)
class Ceiling(Result):
    """Highest altitude of perpetual flight, and the flights at all altitudes of the search."""

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    search: PerpetualCeiling

    @property
    def climbs(self) -> str:
        """Climbs of all flights in words; empty in level flight."""
        return "" if self.mission.climb is None else f"climbs to {spell(self.mission.ceiling_m)} m"

    @property
    def altitude(self) -> str:
        """What its altitudes are called."""
        return "night's floor" if self.climbs else "altitude"

    @property
    def extrapolations(self) -> tuple[Extrapolation, ...]:
        """Extrapolated quantities up to the ceiling, and at the best altitude."""
        ceiling = self.search
        top_m = -math.inf if ceiling.highest is None else ceiling.highest.altitude_m
        claimed = [flight for flight in ceiling.flights if flight.altitude_m <= top_m]
        ends = (ceiling.best, *(() if ceiling.highest is None else (ceiling.highest,)))
        claimed += [flight for flight in ends if flight not in claimed]
        return merge_extrapolations([flight.extrapolations for flight in claimed], "altitudes")

    def table(self, most: int = _ROWS[2]) -> Table:
        """Return a table from the lowest altitude to the first without power, with the ceiling."""
        search, scenarios = self.search, self.mission.scenarios()
        ends = (search.flights[0], search.flights[-1])
        ends = (*ends, *(() if search.highest is None else (search.highest,)))
        between = search.flights[1:-1]
        altitudes = [flight.altitude_m for flight in between]
        step = altitudes[1] - altitudes[0] if len(altitudes) > 1 else 1.0
        stride = max(math.ceil(len(between) / (most - len(ends))), 1)
        # Multiples of a round step, not every n-th from the first.
        at_round = [f for f in between if round(f.altitude_m / step) % stride == 0]
        each = {flight.altitude_m: flight for flight in (*at_round, *ends)}
        shown = [each[altitude_m] for altitude_m in sorted(each)]
        while len(shown) > 1 and all(flight.excess_time_h <= HOPELESS_H for flight in shown[-2:]):
            shown.pop()  # nothing changes from there up
        keys = "altitude_m excess_time_h minimum_state_of_charge propulsion_power_w solar_energy_wh"
        keys += " airspeed_m_per_s" + " maximum_altitude_m" * bool(self.climbs)
        keys += " worst_scenario" * (len(scenarios) > 1)
        altitude, *others = group(keys + " reason" * any(flight.reason for flight in shown))
        altitude = replace(altitude, label=self.altitude)
        rows = (
            vars(flight) | {"worst_scenario": scenarios.label(flight.worst_scenario)}
            for flight in shown
        )
        return table_of("", (altitude, *others), rows)

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each altitude."""
        return data_frame(plain(self.search.flights))


def headline(ceiling: Ceiling) -> str:
    """Return ceiling and best altitude in one line."""
    search, required = ceiling.search, ceiling.search.required_excess_time_h
    more = [ceiling.climbs] if ceiling.climbs else []
    more += [f"more than {spell(required)} h of excess time"] if required > 0.0 else []
    how = f" with {' and '.join(more)}" if more else ""
    best = f"; largest excess time {hours(search.best.excess_time_h)}"
    best += f" at {text_of('altitude_m', search.best.altitude_m)}"
    ends = [search.flights[end].altitude_m for end in (0, -1)]
    floors = "night floors " if ceiling.climbs else ""
    between = f"{floors}{ends[0]:.0f} to {text_of('altitude_m', ends[1])}"
    said = f"no perpetual flight{how} from {between}"
    if search.highest is not None:
        beyond = " and beyond the search" if search.at_search_limit else ""
        if search.highest.altitude_m >= ceiling.mission.highest_floor_m:
            beyond = ", the ceiling itself"
        up_to = f"{text_of('altitude_m', search.highest.altitude_m)}{beyond}"
        said = f"perpetual flight{how}{floors and ' from night floors'} up to {up_to}"
        if search.highest.altitude_m < ceiling.mission.altitude_m:
            # Altitudes below were not tried, where the excess time may be larger.
            said, best = f"{said}, below the mission's {spell(ceiling.mission.altitude_m)} m", ""
    return f"{ceiling.aircraft.name} on {ceiling.mission.name}: {said}{best}"


def blocks(ceiling: Ceiling, level: int) -> list[Any]:
    """Return headline, a table of altitudes, extrapolations and conditions."""
    note = f"{ceiling.solar.label}; solar energy: electric, of one day"
    note += "; power and airspeed at the night's floor" if ceiling.climbs else ""
    outside = extrapolation_blocks(ceiling.extrapolations, level)
    table = ceiling.table(_ROWS[level])
    return [Line(headline(ceiling), "strong"), table, *outside, Line(note, "faint")]


def perpetual_ceiling(
    aircraft: Aircraft,
    mission: Mission,
    *,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    highest_m: float | None = None,
    step_m: float = DEFAULT_STEP_M,
    progress: Callable[[int, int], None] | None = None,
) -> Ceiling:
    """Find the highest altitude of perpetual flight in all scenarios of a mission.

    Parameters
    ----------
    aircraft, mission
        Aircraft and mission; the search starts at the mission's altitude, and goes down from there
        if no altitude above is feasible. With ``climb`` it searches the highest night's floor below
        a fixed ceiling of the climbs.
    model, correction : str
        Solar power model and its correction.
    highest_m, step_m : float
        End of the search and spacing of its altitudes [m]. Without an end it is 20,000 m, or 32,000
        m for missions above 15,000 m.
    progress : callable, optional
        Called after every altitude with the altitudes done and in all.

    Returns
    -------
    Ceiling

    Raises
    ------
    ValueError
        If the search has no length or no step, or a name does not exist.
    ImpossibleDesignError
        If the aircraft cannot carry its own mass at any altitude.
    """
    solar = SolarModel(model, correction)
    ceiling = highest_perpetual_altitude(
        aircraft, mission, solar, highest_m=highest_m, step_m=step_m, progress=progress
    )
    return Ceiling(aircraft, mission, solar, ceiling)


@drawing.styled
def plot_ceiling(result: Ceiling, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw excess time, power and daily energies over altitude, the ceiling marked.

    Parameters
    ----------
    result : Ceiling
    """
    ceiling, mark = result.search, drawing.DARK_GREY
    drawn, panels = drawing.new_figure(
        1,
        3,
        canvas=figure,
        title=f"{result.aircraft.name} on {result.mission.name}, worst scenario",
        notes=(
            result.solar.label,
            result.climbs,
            extrapolation_caption(result.extrapolations),
        ),
        size_in=(9.0, 5.2),
        sharey=True,
    )
    excess, power, energy = panels
    altitude_km = ceiling.column("altitude_m") / 1000.0
    excess.plot(ceiling.column(EXCESS_TIME.name), altitude_km, color=drawing.CHARGE)
    excess.axvline(ceiling.required_excess_time_h, color=mark, linewidth=0.8)
    excess.set(xlabel=EXCESS_TIME.heading, ylabel=f"{result.altitude} [km]")
    power.plot(ceiling.column("propulsion_power_w"), altitude_km, color=drawing.LOAD)
    power.set(xlabel="level-flight power [W]", xlim=(0.0, None))
    energy.plot(
        ceiling.column("solar_energy_wh"), altitude_km, color=drawing.SUN, label="solar energy"
    )
    energy.plot(
        ceiling.column("load_energy_wh"), altitude_km, "--", color=drawing.LOAD, label="load"
    )
    energy.set(xlabel="energy of the day [Wh]", xlim=(0.0, None))
    energy.legend(loc="upper left")
    if ceiling.highest is None:
        return drawn
    highest_km = ceiling.highest.altitude_m / 1000.0
    if not ceiling.at_search_limit:
        for axes in panels:
            axes.axhline(highest_km, color=mark, linestyle=":", linewidth=1.2)
    name = "highest floor" if result.climbs else "ceiling"
    name = f"{name} {text_of('altitude_m', ceiling.highest.altitude_m)}"
    drawing.note(
        excess, name, (0.96, highest_km), (0, 4), across=True, ha="right", fontsize="medium"
    )
    return drawn
