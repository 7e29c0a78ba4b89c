"""What shortens and lengthens the season of perpetual flight at AtlantikSolar's airfield."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missions.dates import date_label
from missions.library import load_mission
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM, SolarModel, solar_day
from sizing.library import load_aircraft
from sizing.performance import performance
from studies.render.tables import Column, Table

AIRCRAFT, MISSION, LATITUDE_DEG = "atlantiksolar-as2", "rafz-july", 47.6
DAYS_PER_MONTH = 365.0 / 12.0


@dataclass(frozen=True)
class Condition:
    """What is changed: keys of the mission as by ``--set``, and the solar power model."""

    name: str
    overrides: tuple[str, ...] = ()
    solar: SolarModel = UNCORRECTED_CAM


def _air_c(celsius: float) -> str:
    return f"air={{ambient_temperature_c: {celsius}}}"


CONDITIONS = (
    Condition("as in validation: clear, calm, 31.3 °C"),
    Condition("correction report", solar=SolarModel("CAM", "report")),
    *(Condition(f"clearness {c:g}", (f"clearness={c}",)) for c in (0.9, 0.8, 0.7)),
    *(
        Condition(f"{100 * k:g} % more propulsion power", (f"turbulence.all_day={k}",))
        for k in (0.1, 0.2, 0.3)
    ),
    *(Condition(f"air {c:g} °C", (_air_c(c),)) for c in (0.0, 10.0, 20.0)),
    Condition("5 h of excess time required", ("required_excess_time_h=5",)),
    Condition("clearness 0.9, 10 % more power", ("clearness=0.9", "turbulence.all_day=0.1")),
    Condition("the same at 10 °C", ("clearness=0.9", "turbulence.all_day=0.1", _air_c(10.0))),
)


@dataclass(frozen=True)
class Season:
    """Days of the year with enough excess time, and those of them that fill the battery.

    ``gaps`` counts the days between the first and the last that do not have enough.
    """

    condition: str
    days: int
    full_days: int
    first: str | None
    last: str | None
    gaps: int

    @property
    def months(self) -> float:
        """Length in twelfths of a year."""
        return self.days / DAYS_PER_MONTH


def seasons_table() -> Table:
    """A row for each condition."""
    columns = (
        Column("condition"),
        Column("perpetual_days", "perpetual", "days"),
        Column("months", form=".1f"),
        Column("first", "from"),
        Column("last", "to"),
        Column("full_days", "full battery", "days"),
    )
    rows = tuple((s.condition, s.days, s.months, s.first, s.last, s.full_days) for s in seasons())
    return Table("season of perpetual flight", columns, rows)


def seasons(conditions: Sequence[Condition] = CONDITIONS) -> tuple[Season, ...]:
    """Compute the seasons of AtlantikSolar AS-2 at its airfield."""
    aircraft = load_aircraft(AIRCRAFT)
    return tuple(_season(aircraft, load_mission(MISSION, list(c.overrides)), c) for c in conditions)


def _season(aircraft: Aircraft, mission: Mission, condition: Condition) -> Season:
    every = np.arange(1, 366)
    scenarios = Scenarios(np.full(len(every), LATITUDE_DEG), every)
    sunlit = solar_day(aircraft, mission, condition.solar, scenarios=scenarios)
    cycle = performance(aircraft, mission, day=sunlit, keep_trajectory=False).cycle
    enough = cycle.perpetual & (cycle.excess_time_h >= mission.required_excess_time_h)
    days = every[enough]
    return Season(
        condition.name,
        len(days),
        int(np.count_nonzero(enough & (cycle.charge_margin_h > 0.0))),
        date_label(int(days[0])) if len(days) else None,
        date_label(int(days[-1])) if len(days) else None,
        int(days[-1] - days[0] + 1 - len(days)) if len(days) else 0,
    )
