"""The day with battery and potential-energy storage that repeats itself."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sizing.altitude.climb_march import March
from sizing.altitude.climb_run import DayRun, Stored
from solar.types import BoolArray, FloatArray, IntArray

_TOLERANCE = 1e-11  # of the battery's energy: gain of a cycle that repeats itself
_MAXIMUM_ROUNDS = 160
_PLAIN_ROUNDS = 4  # before an extrapolation
_STEADY = 0.1  # change of the ratio of gains over what it is short of 1, in a geometric series
_SHRINKS = 0.9  # from day to day, where an extrapolation of both storages is trusted
_LAST_ROUNDS = 40  # without any, for what extrapolating does not settle


def repeated_day(march: March) -> DayRun:
    """Day that repeats itself, from midnight to midnight.

    The cycle is repeated from a full battery, which settles at once where the battery is filled or
    emptied every day. A small gain from day to day takes many days: once the gains are a geometric
    series, what is stored is extrapolated to where it ends (Aitken), and every few days even where
    they are none yet. Without altitude at midnight the energy is then halved between those that
    are known to rise and to fall if the series leaves them; with altitude the battery was full in
    the evening, and plain repetition settles whatever the series does.
    """
    full = march.store.battery_energy_wh
    scale = np.maximum(full, march.potential_max_wh)
    run = march.empty_run()
    start = march.end_of_day(Stored(full.copy(), np.zeros_like(full)))
    end = march.end_of_day(start, run)
    changes = [np.abs(a - b) for a, b in zip(start, end, strict=True)]
    unsettled = np.flatnonzero(np.maximum(*changes) > _TOLERANCE * scale)
    if not len(unsettled):
        return run
    first, begun = (Stored(*(values[unsettled] for values in one)) for one in (start, end))
    settled = _periodic_state(march.select(unsettled), scale[unsettled], first, begun)
    for values, found in zip(start, settled, strict=True):
        values[unsettled] = found
    run = march.empty_run()
    march.end_of_day(start, run)
    return run


def _periodic_state(march: March, scale: FloatArray, first: Stored, begun: Stored) -> Stored:
    """What is stored at midnight of a day that repeats itself, from start and end of a first."""
    full = march.store.battery_energy_wh
    stored, series = begun, _Series.of(first, begun)
    bracket = _EnergyBracket(full)
    low = np.ones(full.shape, bool)
    found, places = Stored(*(one.copy() for one in begun)), np.arange(len(full))
    for number in range(1, _MAXIMUM_ROUNDS + 1):
        end = march.end_of_day(stored)
        series, steady = series.next(stored, end)
        low = low & (stored.potential_wh == 0.0) & (end.potential_wh == 0.0)
        bracket.learn(stored.battery_wh, series.gains.battery_wh, low)
        found.battery_wh[places], found.potential_wh[places] = end
        moves = np.maximum(*map(np.abs, series.gains)) > _TOLERANCE * scale
        if not moves.any():
            break
        due = number % _PLAIN_ROUNDS == 0 and number <= _MAXIMUM_ROUNDS - _LAST_ROUNDS
        most = Stored(full, march.potential_max_wh)
        stored = series.extrapolated(end, steady | due, most)
        if due:
            below = bracket.extrapolated(end.battery_wh, series)
            stored = Stored(
                np.where(low, below, stored.battery_wh),
                np.where(low, end.potential_wh, stored.potential_wh),
            )
            low = np.ones_like(low)
        if 2 * np.count_nonzero(moves) <= len(moves):
            # Elements that have settled need not wait for the others.
            some = np.flatnonzero(moves)
            march, bracket, places = march.select(some), bracket.select(some), places[some]
            full, series = march.store.battery_energy_wh, series.select(some)
            stored = Stored(*(values[some] for values in stored))
            scale, low = scale[some], low[some]
    return found


class _Series(NamedTuple):
    """A day's start and gains, and the ratio of its gains to those of the day before.

    Of what is stored as a whole, and by the starts of both days: also after an extrapolation.
    """

    start: Stored
    gains: Stored
    ratio: FloatArray

    @classmethod
    def of(cls, start: Stored, end: Stored) -> _Series:
        """Series of a first day, with no ratio yet."""
        gains = Stored(*(b - a for a, b in zip(start, end, strict=True)))
        return cls(start, gains, np.full_like(start.battery_wh, np.inf))

    def next(self, start: Stored, end: Stored) -> tuple[_Series, BoolArray]:
        """Series with another day, and whether its ratio is that of the day before."""
        new = _Series.of(start, end)
        moved = [b - a for a, b in zip(self.start, start, strict=True)]
        along = sum((b - a) * by for a, b, by in zip(self.gains, new.gains, moved, strict=True))
        by = moved[0] ** 2 + moved[1] ** 2
        ratio = 1.0 + along / np.where(by == 0.0, np.inf, by)
        steady = np.abs(ratio - self.ratio) < _STEADY * (1.0 - ratio)
        return new._replace(ratio=ratio), steady

    def select(self, some: IntArray) -> _Series:
        """Series of some of the elements."""
        start, gains = (Stored(*(one[some] for one in both)) for both in self[:2])
        return _Series(start, gains, self.ratio[some])

    def extrapolated(self, end: Stored, which: BoolArray, most: Stored) -> Stored:
        """Where some of the series lead to; elsewhere, and where one does not shrink, ``end``."""
        shrinks = which & (self.ratio > 0.0) & (self.ratio < _SHRINKS)
        ratio = np.where(shrinks, self.ratio, 0.0)
        ahead = ratio / (1.0 - ratio)
        ends = (one + gain * ahead for one, gain in zip(end, self.gains, strict=True))
        return Stored(*(np.clip(one, 0.0, top) for one, top in zip(ends, most, strict=True)))


class _EnergyBracket:
    """Energies below and above that of the repeating day, per scenario."""

    def __init__(self, battery_energy_wh: FloatArray) -> None:
        self.full = battery_energy_wh
        self.lower, self.upper = np.zeros_like(self.full), self.full.copy()

    def select(self, some: IntArray) -> _EnergyBracket:
        """Energies of some of the elements."""
        part = _EnergyBracket(self.full[some])
        part.lower, part.upper = self.lower[some], self.upper[some]
        return part

    def learn(self, energy: FloatArray, gain: FloatArray, low: BoolArray) -> None:
        """Narrow by the gain of a day, or start anew where altitude was left at midnight."""
        self.lower = np.where(gain > 0.0, np.maximum(self.lower, energy), self.lower)
        self.upper = np.where(gain < 0.0, np.minimum(self.upper, energy), self.upper)
        void = ~low | (self.lower > self.upper)
        self.lower = np.where(void, 0.0, self.lower)
        self.upper = np.where(void, self.full, self.upper)

    def extrapolated(self, energy: FloatArray, series: _Series) -> FloatArray:
        """Next energy to try, from that at the end of a day and its series."""
        gain, ratio = series.gains.battery_wh, series.ratio
        shrinks = (ratio > 0.0) & (ratio < 1.0 - 1e-9)
        ahead = energy + gain * ratio / np.where(shrinks, 1.0 - ratio, 1.0)
        halved = (self.lower + self.upper) / 2.0
        inside = shrinks & (ahead > self.lower) & (ahead < self.upper)
        trial = np.where(inside, ahead, halved)
        return np.where(np.abs(gain) > _TOLERANCE * self.full, trial, energy)
