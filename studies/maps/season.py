"""Season of perpetual flight: the days of the year on which it is possible at a latitude.

Every eighth day is looked at, and between two of these that differ the edge is found by halving,
which takes for granted that there is one. A gap or a spell that lies wholly between two equal ones
is not seen.

VM, FM and the loiter correction take milliseconds for each day. They are simulated on every 32nd
day, and of the eighth days on those alone of which CAM, scaled to their energy, leaves it in doubt.
By them a day whose wind is too strong for the flight path is no day of perpetual flight.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from missions.dates import DAYS_PER_YEAR
from missions.mission import Mission, Scenarios
from missions.mission.scenarios import SOLSTICES
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM, SolarDay, SolarModel, Sunlight
from sizing.day.module_power import path_troubles
from sizing.performance import performance
from solar.names import MODELS, ModelName
from solar.types import FloatArray

_STRIDE, _FAR_STRIDE = 8, 32
# By so much, relative, may power be missed that is CAM's times a ratio of energies, interpolated
# between every 32nd day: the ratio by 1.5 % (of atlantiksolar-as2 on its circle, from 0 to 80
# degrees), and about as much as the power is otherwise spread over the day.
_DOUBT = 0.03

Flags = NDArray[np.bool_]
T = TypeVar("T")


@dataclass(frozen=True)
class Season:
    """Days of perpetual flight in a year: all of them, and those around the summer solstice.

    ``first`` and ``last`` are the ends of the unbroken window of ``window_days`` around the summer
    solstice; the window may cross the year's end. They are none where the solstice itself is not
    flown perpetually, and the year's ends where every day is.
    """

    days: int
    window_days: int
    first: int | None
    last: int | None


def season_of(perpetual: Flags, latitude_deg: float) -> Season:
    """Season from a flag for each day of the year; the solstice is that of the hemisphere.

    ``perpetual``: whether the flight is perpetual on each day of the year. Returns days in all, and
    of the window around the summer solstice.
    """
    total = int(perpetual.sum())
    if total == DAYS_PER_YEAR:
        return Season(total, total, 1, DAYS_PER_YEAR)
    solstice = SOLSTICES[0 if latitude_deg >= 0.0 else 1] - 1
    if not perpetual[solstice]:
        return Season(total, 0, None, None)
    # Seen from the solstice, the first day without perpetual flight on either side.
    after = int(np.argmin(np.roll(perpetual, -solstice)))
    before = int(np.argmin(np.roll(perpetual, -solstice - 1)[::-1]))
    first, last = (solstice - before + 1), (solstice + after - 1)
    return Season(total, last - first + 1, first % DAYS_PER_YEAR + 1, last % DAYS_PER_YEAR + 1)


def perpetual_flags(
    aircraft: Aircraft, mission: Mission, latitude_deg: float, models: Sequence[SolarModel]
) -> dict[SolarModel, Flags]:
    """For each model, on which of the 365 days of the year the aircraft can fly perpetually.

    ``latitude_deg``: latitude [deg], north positive, instead of the mission's own. Returns for each
    model an array of bool, shape ``(365,)``.
    """
    year = _Year(aircraft, mission, latitude_deg)
    known: dict[SolarModel, dict[int, bool]] = {model: {} for model in models}

    def fly(wanted: Mapping[SolarModel, Iterable[int]]) -> None:
        days = {model: sorted({*of} - known[model].keys()) for model, of in wanted.items()}
        suns = {model: year.sun(model, of) for model, of in days.items() if of}
        for model, flags in year.perpetual(suns).items():
            known[model].update(zip(days[model], flags, strict=True))

    near, far = ({*range(1, DAYS_PER_YEAR + 1, n), *SOLSTICES} for n in (_STRIDE, _FAR_STRIDE))
    slow = [model for model in models if model.needs_path]
    fly({model: far if model in slow else near for model in models})
    fly(_in_doubt(year, slow, sorted(near), sorted(far)))
    while any((halves := {one: _middles_of_edges(days) for one, days in known.items()}).values()):
        fly(halves)
    return {model: _filled(days) for model, days in known.items()}


class _Year:
    """Days of the year at a latitude; a day's power by a model is computed once."""

    def __init__(self, aircraft: Aircraft, mission: Mission, latitude_deg: float) -> None:
        self.aircraft, self.mission = aircraft, mission
        self.latitude_deg = float(latitude_deg)
        self.powers: dict[tuple[ModelName, float, float | None, int], FloatArray] = {}

    def scenarios(self, days: Sequence[int]) -> Scenarios:
        return Scenarios(np.full(len(days), self.latitude_deg), np.array(days, int))

    def sun(self, model: SolarModel, days: Sequence[int]) -> SolarDay:
        """Sun of some days by a model."""
        return _SomeDays(self, days).day(model)

    def perpetual(self, suns: Mapping[T, SolarDay]) -> dict[T, list[bool]]:
        """Whether flight is perpetual under each sun; one march for all of them."""
        if not suns:
            return {}
        # The simulator sees nothing of a model but its power.
        together = SolarDay.joined(list(suns.values()))
        flags, mission = np.zeros(len(together.scenarios), bool), self.mission
        if mission.climb is not None:  # level flight is one of the schedules, and known at once
            flags |= self._flown(mission.at_altitude(mission.altitude_m), together)
        if not flags.all():
            flags[~flags] = self._flown(mission, together.at(np.flatnonzero(~flags)))
        ends = np.cumsum([len(sun.scenarios) for sun in suns.values()])
        parts = np.split(flags, ends[:-1])
        return {name: part.tolist() for name, part in zip(suns, parts, strict=True)}

    def _flown(self, mission: Mission, day: SolarDay) -> Flags:
        flown = performance(self.aircraft, mission, day=day, keep_trajectory=False)
        return flown.cycle.flown


class _SomeDays(Sunlight):
    """Sunlight on some days of a year, which keeps their power."""

    def __init__(self, year: _Year, days: Sequence[int]) -> None:
        super().__init__(year.aircraft, year.mission, year.scenarios(days))
        self._year, self._days = year, days

    def _in_flow(self, model: ModelName, there: Mission, convection: float | None) -> FloatArray:
        known, place = self._year.powers, (model, there.altitude_m, convection)
        lacking = [day for day in self._days if (*place, day) not in known]
        if lacking:
            none = np.zeros(len(self.time_h))
            known.update(((*place, day), none) for day in lacking)
            if MODELS[model].needs_path:  # a day whose wind is too strong for it has no power
                where = self._year.scenarios(lacking)
                troubles = path_troubles(self.aircraft, there, where)
                lacking = [d for d, why in zip(lacking, troubles, strict=True) if why is None]
        if lacking:
            days = Sunlight(self.aircraft, there, self._year.scenarios(lacking))
            powers = days._in_flow(model, there, convection)
            known.update(((*place, day), power) for day, power in zip(lacking, powers, strict=True))
        return np.stack([known[*place, day] for day in self._days])


def _in_doubt(
    year: _Year, models: Sequence[SolarModel], near: Sequence[int], far: Sequence[int]
) -> dict[SolarModel, set[int]]:
    """Days among ``near`` that each model, known on those ``far``, is to be simulated on.

    Those of which an estimate of its power does not tell whether they are flown perpetually, and
    both sides of an edge. The estimate: power of CAM, times the ratio of daily energies.
    """
    cam = year.sun(UNCORRECTED_CAM, near)
    energy_wh = np.asarray(np.trapezoid(cam.specific_power_w_per_m2, cam.time_h, axis=-1))
    of_cam_wh = energy_wh[np.isin(near, far)]
    suns: dict[tuple[SolarModel, float], SolarDay] = {}
    for model in models:
        own_wh = np.trapezoid(year.sun(model, far).specific_power_w_per_m2, cam.time_h, axis=-1)
        ratio = np.divide(own_wh, of_cam_wh, out=np.ones(len(far)), where=of_cam_wh > 0.0)
        of_day = np.reshape(np.interp(near, far, ratio, period=DAYS_PER_YEAR), (-1, 1))
        for sign in (-1.0, 1.0):
            suns[model, sign] = cam.scaled(of_day * (1.0 + sign * _DOUBT))
    flown = year.perpetual(suns)
    found = {}
    for model in models:
        low, high = (dict(zip(near, flown[model, sign], strict=True)) for sign in (-1.0, 1.0))
        unclear = {day for day in near if low[day] != high[day]}
        found[model] = unclear.union(*(pair for flags in (low, high) for pair in _edges(flags)))
    return found


def _edges(flown: Mapping[int, bool]) -> list[tuple[int, int]]:
    """Neighbours of which one is flown perpetually and the other not, across the year's end too."""
    days = sorted(flown)
    return [(a, b) for a, b in zip(days, [*days[1:], days[0]], strict=True) if flown[a] != flown[b]]


def _middles_of_edges(flown: Mapping[int, bool]) -> set[int]:
    """Days half-way between the two sides of every edge; none where they are neighbours."""
    apart = [(day, (after - day) % DAYS_PER_YEAR) for day, after in _edges(flown)]
    return {(day + days // 2 - 1) % DAYS_PER_YEAR + 1 for day, days in apart if days > 1}


def _filled(flown: Mapping[int, bool]) -> Flags:
    """Flag of every day: that of the last known one."""
    days = np.array(sorted(flown))
    flags = np.array([flown[day] for day in days.tolist()], bool)
    return flags[np.searchsorted(days, np.arange(1, DAYS_PER_YEAR + 1), side="right") - 1]
