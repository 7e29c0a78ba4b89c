"""Season of perpetual flight: the days of the year on which it is possible at a latitude.

Every eighth day is simulated, and edges between two that differ are bisected, on the assumption
that there is one. Changes wholly between two equal days are missed.

VM, FM and the loiter correction take milliseconds a day: they are simulated on every 32nd day, and
on those eighth days that CAM, scaled to their energy, leaves in doubt. A day whose wind is too
strong for the flight path counts as not perpetual.
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
from sizing.performance import performance
from solar.names import ModelName
from solar.types import FloatArray

_STRIDE, _FAR_STRIDE = 8, 32
# Relative error of power estimated as CAM's times a ratio of energies, interpolated between every
# 32nd day: 1.5 % by the ratio (atlantiksolar-as2 on its circle, from 0 to 80 degrees), and about as
# much by the distribution over the day.
_DOUBT = 0.03

Flags = NDArray[np.bool_]
T = TypeVar("T")


@dataclass(frozen=True)
class Season:
    """Number of days of perpetual flight in a year, and the window around the summer solstice.

    ``first`` and ``last``: ends of the unbroken window of ``window_days``, which may cross the
    year's end; None if flight is not perpetual on the solstice, the year's ends if it is on all
    days.
    """

    days: int
    window_days: int
    first: int | None
    last: int | None


def season_of(perpetual: Flags, latitude_deg: float) -> Season:
    """Return the season of flags of perpetual flight by day of year, shape ``(365,)``."""
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
    """Flag days of perpetual flight by model, each of shape ``(365,)``.

    ``latitude_deg``: replaces the mission's latitude [deg], north positive.
    """
    year = _Year(aircraft, mission, latitude_deg)
    known: dict[SolarModel, dict[int, bool]] = {model: {} for model in models}

    def simulate(days_of: Mapping[SolarModel, Iterable[int]]) -> None:
        days = {model: sorted({*of} - known[model].keys()) for model, of in days_of.items()}
        suns = {model: year.sun(model, of) for model, of in days.items() if of}
        for model, flags in year.perpetual(suns).items():
            known[model].update(zip(days[model], flags, strict=True))

    near, far = ({*range(1, DAYS_PER_YEAR + 1, n), *SOLSTICES} for n in (_STRIDE, _FAR_STRIDE))
    slow = [model for model in models if model.needs_path]
    simulate({model: far if model in slow else near for model in models})
    simulate(_days_in_doubt(year, slow, sorted(near), sorted(far)))
    while any((halves := {m: _middles_of_edges(days) for m, days in known.items()}).values()):
        simulate(halves)
    every, perpetual = np.arange(1, DAYS_PER_YEAR + 1), {}
    for model, flags in known.items():
        days = np.array(sorted(flags))
        filled = np.array([flags[day] for day in days.tolist()], bool)
        # Every day is as the last known one before.
        perpetual[model] = filled[np.searchsorted(days, every, side="right") - 1]
    return perpetual


class _Year:
    """Days of the year at a latitude; a day's power by a model is computed once."""

    def __init__(self, aircraft: Aircraft, mission: Mission, latitude_deg: float) -> None:
        self.aircraft, self.mission = aircraft, mission
        self.latitude_deg = float(latitude_deg)
        self.powers: dict[tuple[ModelName, float, float | None, int], FloatArray] = {}

    def scenarios(self, days: Sequence[int]) -> Scenarios:
        return Scenarios(np.full(len(days), self.latitude_deg), np.array(days, int))

    def sun(self, model: SolarModel, days: Sequence[int]) -> SolarDay:
        """Compute the sun of some days by a model."""
        return _CachedSunlight(self, days).day(model)

    def perpetual(self, suns: Mapping[T, SolarDay]) -> dict[T, list[bool]]:
        """Flag perpetual flight under each sun; a single march simulates all."""
        if not suns:
            return {}
        # A model matters to the simulator by its power alone, so all share one march.
        together = SolarDay.joined(list(suns.values()))
        flags, mission = np.zeros(len(together.scenarios), bool), self.mission
        if mission.climb is not None:  # level flight is one of the schedules, and known at once
            flags |= self._perpetual(mission.at_altitude(mission.altitude_m), together)
        if not flags.all():
            flags[~flags] = self._perpetual(mission, together.at(np.flatnonzero(~flags)))
        ends = np.cumsum([len(sun.scenarios) for sun in suns.values()])
        parts = np.split(flags, ends[:-1])
        return {name: part.tolist() for name, part in zip(suns, parts, strict=True)}

    def _perpetual(self, mission: Mission, day: SolarDay) -> Flags:
        result = performance(self.aircraft, mission, day=day, keep_trajectory=False)
        return result.cycle.sufficient


class _CachedSunlight(Sunlight):
    """Sunlight on some days of a year that keeps their power."""

    def __init__(self, year: _Year, days: Sequence[int]) -> None:
        super().__init__(year.aircraft, year.mission, year.scenarios(days))
        self._year, self._days = year, days

    def _in_flow(self, model: ModelName, there: Mission, convection: float | None) -> FloatArray:
        known, place = self._year.powers, (model, there.altitude_m, convection)
        lacking = [day for day in self._days if (*place, day) not in known]
        if lacking:
            none = np.zeros(len(self.time_h))
            known.update(((*place, day), none) for day in lacking)
            # A day whose wind is too strong for the model's path has no power.
            where = self._year.scenarios(lacking)
            troubles = SolarModel(model).path_troubles(self.aircraft, there, where)
            lacking = [d for d, why in zip(lacking, troubles, strict=True) if why is None]
        if lacking:
            days = Sunlight(self.aircraft, there, self._year.scenarios(lacking))
            powers = days._in_flow(model, there, convection)
            known.update(((*place, day), power) for day, power in zip(lacking, powers, strict=True))
        return np.stack([known[*place, day] for day in self._days])


def _days_in_doubt(
    year: _Year, models: Sequence[SolarModel], near: Sequence[int], far: Sequence[int]
) -> dict[SolarModel, set[int]]:
    """Return the days among ``near`` on which each model, known on days ``far``, is in doubt.

    Days on which an estimate, CAM's power times the ratio of daily energies, does not decide, and
    both sides of an edge.
    """
    cam = year.sun(UNCORRECTED_CAM, near)
    energy_wh = np.asarray(np.trapezoid(cam.specific_power_w_per_m2, cam.time_h, axis=-1))
    of_cam_wh = energy_wh[np.isin(near, far)]
    suns: dict[tuple[SolarModel, float], SolarDay] = {}
    for model in models:
        model_wh = np.trapezoid(year.sun(model, far).specific_power_w_per_m2, cam.time_h, axis=-1)
        ratio = np.divide(model_wh, of_cam_wh, out=np.ones(len(far)), where=of_cam_wh > 0.0)
        of_day = np.reshape(np.interp(near, far, ratio, period=DAYS_PER_YEAR), (-1, 1))
        for sign in (-1.0, 1.0):
            suns[model, sign] = cam.scaled(of_day * (1.0 + sign * _DOUBT))
    perpetual = year.perpetual(suns)
    doubtful = {}
    for model in models:
        low, high = (dict(zip(near, perpetual[model, sign], strict=True)) for sign in (-1.0, 1.0))
        unclear = {day for day in near if low[day] != high[day]}
        doubtful[model] = unclear.union(*(pair for flags in (low, high) for pair in _edges(flags)))
    return doubtful


def _edges(flags: Mapping[int, bool]) -> list[tuple[int, int]]:
    """Return neighbouring days, also across the year's end, with different flags."""
    days = sorted(flags)
    return [(a, b) for a, b in zip(days, [*days[1:], days[0]], strict=True) if flags[a] != flags[b]]


def _middles_of_edges(flags: Mapping[int, bool]) -> set[int]:
    """Return the days half-way between the sides of every edge, unless adjacent."""
    apart = [(day, (after - day) % DAYS_PER_YEAR) for day, after in _edges(flags)]
    return {(day + days // 2 - 1) % DAYS_PER_YEAR + 1 for day, days in apart if days > 1}
