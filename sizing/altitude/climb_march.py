"""Steps through a day with two stores, battery and height, until the day repeats itself.

What a step does, and why, stands at the head of :mod:`sizing.altitude.climb_cycle`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from sizing.altitude.climb_levels import FlightLevels
from sizing.energy.march import (
    Store,
    crossing_fraction,
    positive_part_wh,
)
from solar.types import BoolArray, FloatArray

Strategy = Literal["battery_full", "surplus"]

STEPS_PER_NODE = 5  # of the day's axis: 1 min
_FULL = 1.0 - 1e-9  # of the capacity, as in sizing.energy.cycle
_TOLERANCE = 1e-10  # of the capacity: gain of a cycle that repeats itself
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


class Balance(NamedTuple):
    """Power at both ends of a step, at the height of its middle [W]; per scenario."""

    solar_left: FloatArray
    solar_right: FloatArray
    motor_left: FloatArray
    motor_right: FloatArray


Note: TypeAlias = Callable[[int, FloatArray, FloatArray, Balance, Flows], None]
"""Told the number of a step, energy and height at its start [Wh], its power and its flows."""


class March:
    """Steps through the day with two stores."""

    def __init__(
        self, time_h: FloatArray, levels: FlightLevels, store: Store, strategy: Strategy
    ) -> None:
        self.node_h, self.levels, self.store = np.asarray(time_h, float), levels, store
        self.steps_per_node = STEPS_PER_NODE
        self.always_climb = strategy == "surplus"
        self.height_max = float(levels.height_wh[-1])
        self.solar = np.ascontiguousarray(np.moveaxis(levels.solar_power_w, -1, 0))
        self.factor = np.ascontiguousarray(levels.turbulence_factor.T)
        self.places = np.arange(levels.solar_power_w.shape[1])
        rises = np.diff(levels.height_wh)
        self.per_wh = 1.0 / np.where(rises > 0.0, rises, np.inf)
        self.full_wh = _FULL * store.battery_energy_wh

    @property
    def time_h(self) -> FloatArray:
        """Nodes of the steps [h]."""
        parts = np.arange(self.steps_per_node) / self.steps_per_node
        fine = self.node_h[:-1, np.newaxis] + np.diff(self.node_h)[:, np.newaxis] * parts
        return np.append(fine.ravel(), self.node_h[-1])

    def fly(
        self, energy: FloatArray, height: FloatArray, note: Note | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """State at the end of the day from that at its start; ``note`` is told every step."""
        before = height
        number = 0
        for node in range(len(self.node_h) - 1):
            hours = (self.node_h[node + 1] - self.node_h[node]) / self.steps_per_node
            for part in range(self.steps_per_node):
                middle = np.clip(1.5 * height - 0.5 * before, 0.0, self.height_max)
                balance = self._balance(node, part, middle)
                new_energy, new_height, flows = self._step(energy, height, balance, hours)
                if note is not None:
                    note(number, energy, height, balance, flows)
                before, energy, height = height, new_energy, new_height
                number += 1
        return energy, height

    def _balance(self, node: int, part: int, height: FloatArray) -> Balance:
        levels = self.levels
        below = np.searchsorted(levels.height_wh, height, side="right") - 1
        below = np.clip(below, 0, len(self.per_wh) - 1)
        share = (height - levels.height_wh[below]) * self.per_wh[below]
        lower, upper = 1.0 - share, share
        left, right = self.solar[node], self.solar[node + 1]
        start = lower * left[below, self.places] + upper * left[below + 1, self.places]
        end = lower * right[below, self.places] + upper * right[below + 1, self.places]
        power = levels.propulsion_power_w
        motor = lower * power[below] + upper * power[below + 1]
        a, b = part / self.steps_per_node, (part + 1) / self.steps_per_node
        first, last = self.factor[node], self.factor[node + 1]
        return Balance(
            start + (end - start) * a,
            start + (end - start) * b,
            motor * (first + (last - first) * a),
            motor * (first + (last - first) * b),
        )

    def _step(
        self, energy: FloatArray, height: FloatArray, balance: Balance, hours: float
    ) -> tuple[FloatArray, FloatArray, Flows]:
        constant = self.levels.constant_power_w
        solar_left, solar_right, motor_left, motor_right = balance
        left = solar_left - motor_left - constant
        right = solar_right - motor_right - constant
        surplus = positive_part_wh(left, right, hours)
        deficit = positive_part_wh(-left, -right, hours)
        of_avionics = positive_part_wh(constant - solar_left, constant - solar_right, hours)
        early = np.where(left < 0.0, 1.0, 0.0)
        lit_h = hours * _surplus_share(left, right)
        first = self._drawn(energy, height, early * deficit, early * of_avionics)
        charged = self.store.charged(first.energy, surplus, hours)
        left_over = surplus - (charged - first.energy) / self.store.charge_efficiency
        room_w = self.levels.limits.maximum_power_w - (motor_left + motor_right) / 2.0
        usable = self._usable_wh(first.energy, charged, surplus, left_over, hours)
        climb = self._climb_wh(first.height, usable, room_w * lit_h)
        higher = first.height + self.levels.limits.efficiency * climb
        second = first
        if np.any((left >= 0.0) & (right < 0.0)):
            late = 1.0 - early
            second = self._drawn(charged, higher, late * deficit, late * of_avionics)
            end_energy, end_height = second.energy, second.height
            drawn, glide, unserved = (
                first.drawn + second.drawn,
                first.glide + second.glide,
                first.unserved + second.unserved,
            )
        else:
            end_energy, end_height = charged, higher
            drawn, glide, unserved = first.drawn, first.glide, first.unserved
        dark_h = hours - lit_h
        flows = Flows(
            solar_wh=(solar_left + solar_right) / 2.0 * hours,
            level_electric_wh=(motor_left + motor_right) / 2.0 * hours,
            charged_wh=charged - first.energy,
            drawn_wh=drawn,
            curtailed_wh=left_over - climb,
            climb_wh=climb,
            glide_wh=glide,
            unserved_wh=unserved,
            missing_h=dark_h * unserved / np.maximum(deficit, 1e-300),
        )
        return end_energy, end_height, flows

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
        full = charged >= self.full_wh
        clock = self.store.clock
        if clock is None or not np.any(full & (energy < self.full_wh)):
            return np.where(full, left_over, 0.0)
        # In the step that fills the battery, only what comes after that instant; a step that
        # counted as a whole would make the day's gain jump with the state of charge.
        soc = np.minimum(energy / self.store.battery_energy_wh, 1.0)
        after = np.clip(1.0 - clock.hours_to_full(soc) / hours, 0.0, 1.0)
        return np.where(full, np.minimum(left_over, after * surplus), 0.0)

    def _climb_wh(
        self, height: FloatArray, usable_wh: FloatArray, room_wh: FloatArray
    ) -> FloatArray:
        """Electric energy spent on climbing [Wh]."""
        to_ceiling = (self.height_max - height) / self.levels.limits.efficiency
        energy = np.minimum(np.minimum(usable_wh, np.maximum(room_wh, 0.0)), to_ceiling)
        return np.maximum(energy, 0.0)

    def _drawn(
        self, energy: FloatArray, height: FloatArray, deficit: FloatArray, of_avionics: FloatArray
    ) -> _Drawn:
        """Meet a deficit: what the motor lacks from height first, all else from the battery."""
        of_motor = deficit - of_avionics
        glide = np.minimum(np.maximum(of_motor, 0.0), height / self.levels.limits.efficiency)
        wanted = deficit - glide
        eta = self.store.discharge_efficiency
        drawn = np.minimum(wanted / eta, energy)
        # Rounding must leave no height that is no height.
        lower = np.maximum(height - self.levels.limits.efficiency * glide, 0.0)
        return _Drawn(energy - drawn, lower, drawn, glide, np.maximum(wanted - eta * drawn, 0.0))


class _Drawn(NamedTuple):
    """Stores after a deficit, and what they gave [Wh]; ``glide`` is electric, that it saved."""

    energy: FloatArray
    height: FloatArray
    drawn: FloatArray
    glide: FloatArray
    unserved: FloatArray


def _surplus_share(left: FloatArray, right: FloatArray) -> FloatArray:
    """Share of a step in which a power that is linear over it is not negative."""
    crossing = crossing_fraction(left, right)
    begin = np.where(left < 0.0, np.where(right < 0.0, 1.0, crossing), 0.0)
    end = np.where((right < 0.0) & (left >= 0.0), crossing, 1.0)
    return end - begin


def periodic_state(march: March) -> tuple[FloatArray, FloatArray]:
    """Stored energy and height at midnight of a day that repeats itself.

    The cycle is repeated from a full battery, which settles at once where the battery is filled or
    emptied every day. A small gain from day to day takes many days: every few of them the energy
    is extrapolated to where a geometric series of the gains would end (Aitken), or halved between
    the energies that are known to rise and to fall if the series leaves them. Where height is left
    at midnight the battery was full in the evening, and plain repetition settles fast.
    """
    capacity = march.store.battery_energy_wh
    energy, height = capacity.copy(), np.zeros_like(capacity)
    scale = np.maximum(capacity, march.height_max)
    bracket = _EnergyBracket(capacity)
    previous = np.zeros_like(capacity)
    low = np.ones(capacity.shape, bool)
    for number in range(1, _MAXIMUM_ROUNDS + 1):
        new_energy, new_height = march.fly(energy, height)
        gain, shift = new_energy - energy, np.abs(new_height - height)
        low = low & (height == 0.0) & (new_height == 0.0)
        bracket.learn(energy, gain, low)
        energy, height = new_energy, new_height
        if np.all(np.maximum(np.abs(gain), shift) <= _TOLERANCE * scale):
            break
        if number % _PLAIN_ROUNDS == 0 and number <= _MAXIMUM_ROUNDS - _LAST_ROUNDS:
            energy = np.where(low, bracket.extrapolated(energy, gain, previous), energy)
            low = np.ones_like(low)
        previous = gain
    return energy, height


class _EnergyBracket:
    """Energies below and above that of the repeating day, per scenario."""

    def __init__(self, capacity: FloatArray) -> None:
        self.capacity = capacity
        self.lower, self.upper = np.zeros_like(capacity), capacity.copy()

    def learn(self, energy: FloatArray, gain: FloatArray, low: BoolArray) -> None:
        """Narrow by the gain of a day, or start anew where height was left at midnight."""
        rises, falls = gain > 0.0, gain < 0.0
        self.lower = np.where(rises, np.maximum(self.lower, energy), self.lower)
        self.upper = np.where(falls, np.minimum(self.upper, energy), self.upper)
        void = ~low | (self.lower > self.upper)
        self.lower = np.where(void, 0.0, self.lower)
        self.upper = np.where(void, self.capacity, self.upper)

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
        return np.where(np.abs(gain) > _TOLERANCE * self.capacity, trial, energy)
