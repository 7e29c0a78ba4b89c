"""Steps through a day with battery and potential-energy storage until the day repeats itself.

What a step does, and why, stands at the head of :mod:`sizing.altitude.climb_cycle`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from sizing.altitude.climb_levels import FlightLevels
from sizing.energy.battery import Store
from sizing.energy.cycle import FULL
from sizing.energy.power_balance import crossing_fraction, positive_part_wh
from solar.types import BoolArray, FloatArray

Strategy = Literal["battery_full", "surplus"]

STEPS_PER_NODE = 5  # of the day's axis: 1 min
_TOLERANCE = 1e-10  # of the battery's energy: gain of a cycle that repeats itself
_MAXIMUM_ROUNDS = 160
_PLAIN_ROUNDS = 4  # before an extrapolation
_LAST_ROUNDS = 40  # without any, for what extrapolating does not settle


class Flows(NamedTuple):
    """Energy that moved within one step [Wh]; per scenario."""

    solar_wh: FloatArray
    level_electric_wh: FloatArray
    charged_wh: FloatArray
    drawn_wh: FloatArray
    curtailed_wh: FloatArray
    climb_wh: FloatArray
    glide_wh: FloatArray
    unserved_wh: FloatArray
    missing_h: FloatArray

    @property
    def motor_wh(self) -> FloatArray:
        """Electric energy of the propulsion [Wh]."""
        return self.level_electric_wh + self.climb_wh - self.glide_wh


class StepPower(NamedTuple):
    """Power at both ends of a step, at the altitude of its middle [W]; per scenario."""

    solar_left_w: FloatArray
    solar_right_w: FloatArray
    motor_left_w: FloatArray
    motor_right_w: FloatArray


class Stored(NamedTuple):
    """Energy in the battery, and potential energy above the lowest level [Wh]; per scenario."""

    battery_wh: FloatArray
    potential_wh: FloatArray


class ClimbStep(NamedTuple):
    """What is stored at both ends of a step, its power and its flows."""

    start: Stored
    power: StepPower
    flows: Flows
    end: Stored


class March:
    """Steps through the day of some scenarios with both storages.

    Parameters
    ----------
    time_h : ndarray, shape (time,)
        Nodes over one day [h].
    levels : FlightLevels
        The aircraft between the lowest altitude and the ceiling.
    store : Store
        Battery of every scenario.
    strategy : {"battery_full", "surplus"}
        When surplus power may be spent on climbing.
    """

    def __init__(
        self, time_h: FloatArray, levels: FlightLevels, store: Store, strategy: Strategy
    ) -> None:
        self.node_h, self.levels, self.store = np.asarray(time_h, float), levels, store
        self.steps_per_node = STEPS_PER_NODE
        self.always_climb = strategy == "surplus"
        self.potential_max_wh = float(levels.potential_energy_wh[-1])
        self.solar = np.ascontiguousarray(np.moveaxis(levels.solar_power_w, -1, 0))
        self.factor = np.ascontiguousarray(levels.turbulence_factor.T)
        self.places = np.arange(levels.solar_power_w.shape[1])
        rises = np.diff(levels.potential_energy_wh)
        self.per_wh = 1.0 / np.where(rises > 0.0, rises, np.inf)
        self.counts_as_full_wh = FULL * store.battery_energy_wh

    @property
    def time_h(self) -> FloatArray:
        """Nodes of the steps [h]."""
        parts = np.arange(self.steps_per_node) / self.steps_per_node
        fine = self.node_h[:-1, np.newaxis] + np.diff(self.node_h)[:, np.newaxis] * parts
        return np.append(fine.ravel(), self.node_h[-1])

    def steps(self, stored: Stored) -> Iterator[ClimbStep]:
        """March through the day from what is stored at its start."""
        before = stored.potential_wh
        for node in range(len(self.node_h) - 1):
            hours = (self.node_h[node + 1] - self.node_h[node]) / self.steps_per_node
            for part in range(self.steps_per_node):
                middle = 1.5 * stored.potential_wh - 0.5 * before
                power = self._power(node, part, np.clip(middle, 0.0, self.potential_max_wh))
                step = self._step(stored, power, hours)
                yield step
                before, stored = stored.potential_wh, step.end

    def end_of_day(self, stored: Stored) -> Stored:
        """What is stored at the end of the day, from what is at its start."""
        for step in self.steps(stored):
            stored = step.end
        return stored

    def _power(self, node: int, part: int, potential_wh: FloatArray) -> StepPower:
        levels = self.levels
        below = np.searchsorted(levels.potential_energy_wh, potential_wh, side="right") - 1
        below = np.clip(below, 0, len(self.per_wh) - 1)
        upper = (potential_wh - levels.potential_energy_wh[below]) * self.per_wh[below]
        lower = 1.0 - upper
        left, right = self.solar[node], self.solar[node + 1]
        start = lower * left[below, self.places] + upper * left[below + 1, self.places]
        end = lower * right[below, self.places] + upper * right[below + 1, self.places]
        level_w = levels.propulsion_power_w
        motor = lower * level_w[below] + upper * level_w[below + 1]
        a, b = part / self.steps_per_node, (part + 1) / self.steps_per_node
        first, last = self.factor[node], self.factor[node + 1]
        return StepPower(
            start + (end - start) * a,
            start + (end - start) * b,
            motor * (first + (last - first) * a),
            motor * (first + (last - first) * b),
        )

    def _step(self, stored: Stored, power: StepPower, hours: float) -> ClimbStep:
        """Early deficit, surplus (charge, then climb), late deficit."""
        constant = self.levels.constant_power_w
        solar_left, solar_right, motor_left, motor_right = power
        left = solar_left - motor_left - constant
        right = solar_right - motor_right - constant
        surplus = positive_part_wh(left, right, hours)
        deficit = positive_part_wh(-left, -right, hours)
        of_avionics = positive_part_wh(constant - solar_left, constant - solar_right, hours)
        early = np.where(left < 0.0, 1.0, 0.0)
        lit_h = hours * _surplus_share(left, right)
        first = self._drawn(stored, early * deficit, early * of_avionics)
        energy = first.end.battery_wh
        charged = self.store.charged(energy, surplus, hours)
        left_over = surplus - (charged - energy) / self.store.charge_efficiency
        room_w = self.levels.limits.maximum_power_w - (motor_left + motor_right) / 2.0
        usable = self._usable_wh(energy, charged, surplus, left_over, hours)
        climb = self._climb_wh(first.end.potential_wh, usable, room_w * lit_h)
        higher = first.end.potential_wh + self.levels.limits.efficiency * climb
        second = _Drawn(Stored(charged, higher), *np.zeros((3, len(charged))))
        if np.any((left >= 0.0) & (right < 0.0)):
            late = 1.0 - early
            second = self._drawn(second.end, late * deficit, late * of_avionics)
        unserved = first.unserved_wh + second.unserved_wh
        flows = Flows(
            solar_wh=(solar_left + solar_right) / 2.0 * hours,
            level_electric_wh=(motor_left + motor_right) / 2.0 * hours,
            charged_wh=charged - energy,
            drawn_wh=first.drawn_wh + second.drawn_wh,
            curtailed_wh=left_over - climb,
            climb_wh=climb,
            glide_wh=first.glide_wh + second.glide_wh,
            unserved_wh=unserved,
            missing_h=(hours - lit_h) * unserved / np.maximum(deficit, 1e-300),
        )
        return ClimbStep(stored, power, flows, second.end)

    def _usable_wh(
        self,
        energy: FloatArray,
        charged: FloatArray,
        surplus: FloatArray,
        left_over: FloatArray,
        hours: float,
    ) -> FloatArray:
        """Part of the left-over surplus that the strategy lets climb [Wh]."""
        if self.always_climb:
            return left_over
        full = charged >= self.counts_as_full_wh
        clock = self.store.clock
        if clock is None or not np.any(full & (energy < self.counts_as_full_wh)):
            return np.where(full, left_over, 0.0)
        # In the step that fills the battery, only what comes after that instant; a step that
        # counted as a whole would make the day's gain jump with the state of charge.
        soc = np.minimum(energy / self.store.battery_energy_wh, 1.0)
        after = np.clip(1.0 - clock.hours_to_full(soc) / hours, 0.0, 1.0)
        return np.where(full, np.minimum(left_over, after * surplus), 0.0)

    def _climb_wh(
        self, potential: FloatArray, usable_wh: FloatArray, room_wh: FloatArray
    ) -> FloatArray:
        """Electric energy spent on climbing [Wh]."""
        to_ceiling = (self.potential_max_wh - potential) / self.levels.limits.efficiency
        energy = np.minimum(np.minimum(usable_wh, np.maximum(room_wh, 0.0)), to_ceiling)
        return np.maximum(energy, 0.0)

    def _drawn(self, stored: Stored, deficit: FloatArray, of_avionics: FloatArray) -> _Drawn:
        """Meet a deficit: what the motor lacks by sinking first, all else from the battery."""
        energy, potential = stored
        of_motor = deficit - of_avionics
        glide = np.minimum(np.maximum(of_motor, 0.0), potential / self.levels.limits.efficiency)
        wanted = deficit - glide
        eta = self.store.discharge_efficiency
        drawn = np.minimum(wanted / eta, energy)
        # Rounding must leave no potential energy that is none.
        lower = np.maximum(potential - self.levels.limits.efficiency * glide, 0.0)
        unserved = np.maximum(wanted - eta * drawn, 0.0)
        return _Drawn(Stored(energy - drawn, lower), drawn, glide, unserved)


class _Drawn(NamedTuple):
    """What is stored after a deficit, and what was given [Wh]; ``glide_wh`` is electric, saved."""

    end: Stored
    drawn_wh: FloatArray
    glide_wh: FloatArray
    unserved_wh: FloatArray


def _surplus_share(left: FloatArray, right: FloatArray) -> FloatArray:
    """Share of a step in which a power that is linear over it is not negative."""
    crossing = crossing_fraction(left, right)
    begin = np.where(left < 0.0, np.where(right < 0.0, 1.0, crossing), 0.0)
    end = np.where((right < 0.0) & (left >= 0.0), crossing, 1.0)
    return end - begin


def periodic_state(march: March) -> Stored:
    """What is stored at midnight of a day that repeats itself.

    The cycle is repeated from a full battery, which settles at once where the battery is filled or
    emptied every day. A small gain from day to day takes many days: every few of them the energy
    is extrapolated to where a geometric series of the gains would end (Aitken), or halved between
    the energies that are known to rise and to fall if the series leaves them. Where altitude is
    left at midnight the battery was full in the evening, and plain repetition settles fast.
    """
    full = march.store.battery_energy_wh
    energy, potential = full.copy(), np.zeros_like(full)
    scale = np.maximum(full, march.potential_max_wh)
    bracket = _EnergyBracket(full)
    previous = np.zeros_like(full)
    low = np.ones(full.shape, bool)
    for number in range(1, _MAXIMUM_ROUNDS + 1):
        end = march.end_of_day(Stored(energy, potential))
        gain, shift = end.battery_wh - energy, np.abs(end.potential_wh - potential)
        low = low & (potential == 0.0) & (end.potential_wh == 0.0)
        bracket.learn(energy, gain, low)
        energy, potential = end
        if np.all(np.maximum(np.abs(gain), shift) <= _TOLERANCE * scale):
            break
        if number % _PLAIN_ROUNDS == 0 and number <= _MAXIMUM_ROUNDS - _LAST_ROUNDS:
            energy = np.where(low, bracket.extrapolated(energy, gain, previous), energy)
            low = np.ones_like(low)
        previous = gain
    return Stored(energy, potential)


class _EnergyBracket:
    """Energies below and above that of the repeating day, per scenario."""

    def __init__(self, battery_energy_wh: FloatArray) -> None:
        self.full = battery_energy_wh
        self.lower, self.upper = np.zeros_like(self.full), self.full.copy()

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
