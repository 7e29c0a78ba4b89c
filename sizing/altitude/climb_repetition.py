"""The day with battery and potential-energy storage that repeats itself."""

from __future__ import annotations

import numpy as np

from sizing.altitude.climb_march import March
from sizing.altitude.climb_run import DayRun, Stored
from solar.types import BoolArray, FloatArray, IntArray

_TOLERANCE = 1e-10  # of the battery's energy: gain of a cycle that repeats itself
_MAXIMUM_ROUNDS = 160
_PLAIN_ROUNDS = 4  # before an extrapolation
_SHRINKS = 0.9  # from day to day, where an extrapolation of both storages is trusted
_LAST_ROUNDS = 40  # without any, for what extrapolating does not settle


def repeated_day(march: March) -> DayRun:
    """Day that repeats itself, from midnight to midnight.

    The cycle is repeated from a full battery, which settles at once where the battery is filled or
    emptied every day. A small gain from day to day takes many days: every few of them what is
    stored is extrapolated to where a geometric series of the gains would end (Aitken). Without
    altitude at midnight the energy is halved between those that are known to rise and to fall if
    the series leaves them; with altitude the battery was full in the evening, and plain repetition
    settles whatever the series does.
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
    begun = Stored(*(values[unsettled] for values in end))
    settled = _periodic_state(march.select(unsettled), scale[unsettled], begun)
    for values, found in zip(start, settled, strict=True):
        values[unsettled] = found
    run = march.empty_run()
    march.end_of_day(start, run)
    return run


def _periodic_state(march: March, scale: FloatArray, begun: Stored) -> Stored:
    """What is stored at midnight of a day that repeats itself, by repetition from a first day."""
    full = march.store.battery_energy_wh
    energy, potential = begun
    bracket = _EnergyBracket(full)
    last = Stored(np.zeros_like(full), np.zeros_like(full))
    low = np.ones(full.shape, bool)
    found, places = Stored(energy.copy(), potential.copy()), np.arange(len(full))
    for number in range(1, _MAXIMUM_ROUNDS + 1):
        end = march.end_of_day(Stored(energy, potential))
        gains = Stored(end.battery_wh - energy, end.potential_wh - potential)
        low = low & (potential == 0.0) & (end.potential_wh == 0.0)
        bracket.learn(energy, gains.battery_wh, low)
        energy, potential = end
        found.battery_wh[places], found.potential_wh[places] = end
        moves = np.maximum(*map(np.abs, gains)) > _TOLERANCE * scale
        if not moves.any():
            break
        if number % _PLAIN_ROUNDS == 0 and number <= _MAXIMUM_ROUNDS - _LAST_ROUNDS:
            below = bracket.extrapolated(energy, gains.battery_wh, last.battery_wh)
            aloft = _extrapolated(end, gains, last, Stored(full, march.potential_max_wh))
            energy = np.where(low, below, aloft.battery_wh)
            potential = np.where(low, potential, aloft.potential_wh)
            low = np.ones_like(low)
        last = gains
        if 2 * np.count_nonzero(moves) <= len(moves):
            # Elements that have settled need not wait for the others.
            some = np.flatnonzero(moves)
            march, bracket, places = march.select(some), bracket.select(some), places[some]
            full = march.store.battery_energy_wh
            last = Stored(last.battery_wh[some], last.potential_wh[some])
            energy, potential, scale, low = (
                values[some] for values in (energy, potential, scale, low)
            )
    return found


def _extrapolated(stored: Stored, gains: Stored, last: Stored, most: Stored) -> Stored:
    """Where the gains of two days one after the other lead to, as a geometric series.

    They have one ratio, of what is stored as a whole; where it does not shrink, ``stored`` stays.
    """
    along = gains.battery_wh * last.battery_wh + gains.potential_wh * last.potential_wh
    before = last.battery_wh**2 + last.potential_wh**2
    ratio = along / np.where(before == 0.0, np.inf, before)
    shrinking = np.where((ratio > 0.0) & (ratio < _SHRINKS), ratio, 0.0)
    ahead = shrinking / (1.0 - shrinking)
    ends = (one + gain * ahead for one, gain in zip(stored, gains, strict=True))
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

    def extrapolated(
        self, energy: FloatArray, gain: FloatArray, previous: FloatArray
    ) -> FloatArray:
        """Next energy to try, from the gains of two days one after the other."""
        ratio = gain / np.where(previous == 0.0, np.inf, previous)
        shrinks = (ratio > 0.0) & (ratio < 1.0 - 1e-9)
        ahead = energy + gain * ratio / np.where(shrinks, 1.0 - ratio, 1.0)
        halved = (self.lower + self.upper) / 2.0
        inside = shrinks & (ahead > self.lower) & (ahead < self.upper)
        trial = np.where(inside, ahead, halved)
        return np.where(np.abs(gain) > _TOLERANCE * self.full, trial, energy)
