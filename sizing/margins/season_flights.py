"""Many designs at once through the days of a record's season: which days close.

What a record asks of a design depends on two numbers in the main: *income*, module area over the
load, and *storage*, energy of the battery over the load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from missions.dates import date_code, date_label
from missions.files.errors import file_error
from missions.mission import Mission
from missions.weather.record import Weather, run_lengths
from sizing.aircraft import Aircraft
from sizing.design import Design
from sizing.energy.battery import Store
from sizing.energy.carried_days import carried_over, dawns_of
from sizing.energy.power_balance import PowerBalance
from sizing.optimisation.result import SizingStatus
from sizing.sunlight import SolarModel
from sizing.weather_run import WeatherDays
from solar.sun import HOURS_PER_DAY
from solar.types import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class SeasonDays:
    """Days of a record's season, and which of them close.

    ``year``, ``day_of_year``: of each day of the season, by local date. ``closes``: whether it
    closes. ``longest_gap_days``: most consecutive days of the season that do not close.
    """

    year: IntArray
    day_of_year: IntArray
    closes: BoolArray
    longest_gap_days: int

    @classmethod
    def of(cls, flights: SeasonFlights, designs: Powers) -> SeasonDays:
        """Days of a season that a single design closes."""
        closes = flights.closes(designs)[0]
        axis, counted = flights.days.axis, flights.counted
        missed = np.zeros(len(axis), bool)
        missed[counted] = ~closes
        return cls(
            year=axis.year[counted],
            day_of_year=axis.day_of_year[counted],
            closes=closes,
            longest_gap_days=int(np.max(run_lengths(missed), initial=0)),
        )

    def __len__(self) -> int:
        return len(self.closes)

    @property
    def that_close(self) -> int:
        """Days that close."""
        return int(np.count_nonzero(self.closes))

    @property
    def share(self) -> float:
        """Share of the days that close [-]."""
        return self.that_close / len(self)

    def by_year(self) -> list[dict[str, Any]]:
        """Days, and days that close, of each year."""
        return [
            {
                "year": int(year),
                "days": int(np.count_nonzero(at)),
                "days_that_close": int(np.count_nonzero(self.closes[at])),
                "share": float(np.mean(self.closes[at])),
            }
            for year in np.unique(self.year)
            if np.any(at := self.year == year)
        ]


@dataclass(frozen=True)
class Survival:
    """How a sized design flies through the season of a weather record.

    ``mission``: at the record's site; its dates are the season. ``required``: share of the days
    that was asked for [-]. ``days``: of the design; of the one with the most days that close that
    was found, where no design has enough. ``clear_sky_status``: of the sizing for perpetual flight
    under a clear sky on the same dates. ``clear_sky_objective``: its objective, in its unit; None
    where it has no design. ``clear_sky_days``: what that design makes of the record. ``notes``:
    what was changed to fly the mission at the record's site.
    """

    weather: Weather
    mission: Mission
    required: float
    days: SeasonDays
    clear_sky_status: SizingStatus
    clear_sky_objective: float | None
    clear_sky_days: SeasonDays | None
    notes: tuple[str, ...] = ()

    @property
    def achieved(self) -> float:
        """Share of the season's days that close [-]."""
        return self.days.share

    @property
    def several_years(self) -> bool:
        """Whether the record tells years apart."""
        return not self.weather.typical and len(np.unique(self.days.year)) > 1

    def to_dict(self) -> dict[str, Any]:
        """Record, JSON-ready."""
        weather, clear = self.weather, self.clear_sky_days
        season = self.mission.dates.range()
        return {
            **weather.origin(),
            "flight_altitude_m": self.mission.altitude_m,
            "season": {"from": date_code(season[0]), "to": date_code(season[-1])},
            "required": self.required,
            "achieved": self.achieved,
            "days": len(self.days),
            "days_that_close": self.days.that_close,
            "longest_gap_days": self.days.longest_gap_days,
            "by_year": self.days.by_year() if self.several_years else [],
            "clear_sky": {
                "status": self.clear_sky_status.name,
                "objective": self.clear_sky_objective,
                "days_that_close": None if clear is None else clear.that_close,
                "share": None if clear is None else clear.share,
            },
            "repairs": list(weather.repairs),
            "notes": list(self.notes),
        }


# Values of an array that designs are flown in at once.
_AT_ONCE = 2_000_000


class Powers(NamedTuple):
    """What a design is to a record, arrays of shape ``(design,)``.

    ``area_m2``: module area [m2]. ``level_w``, ``constant_w``: propulsion power of level flight on
    the record's days, ``(design, day)`` or one for all, and what draws power at all times [W].
    ``battery_wh``: energy at full charge in the mission's air [Wh].
    """

    area_m2: FloatArray
    level_w: FloatArray
    constant_w: FloatArray
    battery_wh: FloatArray

    @classmethod
    def of(cls, design: Design, days: WeatherDays) -> Powers:
        """Powers of a design or of a batch of them, on the days of a record."""
        level = days.level_w(design)
        single = design.variables.module_area_m2, design.constant_power_w, design.battery_energy_wh
        batch = np.broadcast_shapes((len(level),), *(np.shape(np.atleast_1d(v)) for v in single))
        area, constant, battery = (np.array(np.broadcast_to(v, batch)) for v in single)
        level = np.array(np.broadcast_to(level, (*batch, level.shape[1])))
        return cls(area, level, constant, battery)

    @classmethod
    def joined(cls, several: Sequence[Powers]) -> Powers:
        """Designs of several batches, one batch after the other."""
        return cls(*map(np.concatenate, zip(*several, strict=True)))

    def scaled(self, income: FloatArray, storage: FloatArray) -> Powers:
        """Designs with that many times the income and the storage of this single one.

        Returns at the same load.
        """
        every = self.select(np.zeros(len(income), int))
        return every._replace(area_m2=income * self.area_m2, battery_wh=storage * self.battery_wh)

    def select(self, some: slice | IntArray) -> Powers:
        """Part of the designs."""
        return Powers(*(values[some] for values in self))

    @property
    def place(self) -> FloatArray:
        """Logarithms of income [m2/W] and storage [h], shape ``(2, design)``."""
        load = np.mean(self.level_w, axis=1) + self.constant_w
        return np.log([self.area_m2 / load, self.battery_wh / load])


def days_of_season(axis_days: IntArray, mission: Mission) -> BoolArray:
    """Days of year that are within a mission's dates.

    ``mission``: one date, or a range that may cross the year's end.
    """
    return np.isin(axis_days, mission.dates.range())


@dataclass(frozen=True)
class SeasonFlights:
    """Days of a record, and which of them are the season's.

    ``days``: of the whole record. ``kept``: days that are flown, in their order. ``counted``: which
    of these are in the season. ``specific_w_per_m2``: solar power per module area [W/m2].
    """

    days: WeatherDays
    kept: IntArray
    counted: BoolArray
    specific_w_per_m2: FloatArray

    @classmethod
    def of(
        cls,
        aircraft: Aircraft,
        mission: Mission,
        weather: Weather,
        solar: SolarModel,
        *,
        step_s: float,
        lead_days: int | None = None,
    ) -> SeasonFlights:
        """Days of a record for an aircraft.

        ``aircraft``, ``mission``, ``weather``, ``solar``: as for
        :func:`sizing.weather_run.weather_performance`; the mission's dates are the season.
        ``lead_days``: leave out days that are further before the season than this, from a full
        battery again after each gap; all days are flown by default.
        """
        days = WeatherDays.of(aircraft, mission, weather, solar, step_s=step_s)
        season = days_of_season(days.axis.day_of_year, mission)
        if not season.any():
            first, last = (date_label(int(days.axis.day_of_year[i])) for i in (0, -1))
            dates = dict.fromkeys(date_label(mission.dates.range()[i]) for i in (0, -1))
            raise file_error(
                weather.source,
                f"has no day of the season of the mission {mission.name}, {' to '.join(dates)}: "
                f"the record covers {first} to {last} (set the mission's dates)",
            )
        kept = np.arange(len(season))
        if lead_days is not None:
            kept = np.flatnonzero(_near(season, lead_days))
        specific = days.specific_power_w_per_m2(days.light.recorded)
        return cls(days, kept, season[kept], specific[kept])

    def __len__(self) -> int:
        return int(np.count_nonzero(self.counted))

    def closes(self, designs: Powers) -> BoolArray:
        """Which days of the season close, shape ``(design, day)``."""
        per_design = self.specific_w_per_m2.size
        step = max(1, _AT_ONCE // per_design)
        count = len(designs.area_m2)
        parts = [
            self._closes(designs.select(slice(first, first + step)))
            for first in range(0, count, step)
        ]
        return np.concatenate(parts)

    def that_close(self, designs: Powers) -> IntArray:
        """Days of the season that close, of each design."""
        return np.asarray(self.closes(designs).sum(axis=1))

    def _closes(self, designs: Powers) -> BoolArray:
        days, some = self.days, self.kept
        count, nodes = len(designs.area_m2), self.specific_w_per_m2.shape[1]

        def each(values: FloatArray) -> FloatArray:
            return values[:, np.newaxis, np.newaxis]

        full = designs.battery_wh[:, np.newaxis] * days.capacity_ratio[some]
        store = Store.of(days.aircraft.battery, full.reshape(-1))
        level = designs.level_w
        level = level if level.shape[1] == 1 else level[:, some]
        load = level[:, :, np.newaxis] * days.propulsion_ratio[some]
        load += each(designs.constant_w) + days.more_heater_w[some]
        power = each(designs.area_m2) * self.specific_w_per_m2
        balance = PowerBalance.of(
            days.axis.time_h, power.reshape(-1, nodes), load.reshape(-1, nodes)
        )
        carried = carried_over(balance, store, full[:, 0], len(some))
        noon_h = HOURS_PER_DAY / 2.0 - np.tile(days.axis.midnight_h[some], count)
        dawns = dawns_of(balance, carried.day, store, noon_h)
        closes = carried.closes(dawns).reshape(count, -1)
        return np.asarray(closes[:, self.counted])


def _near(season: BoolArray, lead_days: int) -> BoolArray:
    """Days of the season, so many before it, and the one after it, on which its last night ends."""
    ahead = np.convolve(season[::-1], np.ones(lead_days + 1))[: len(season)][::-1] > 0.0
    return np.asarray(ahead | np.append(False, season[:-1]))
