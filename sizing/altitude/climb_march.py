"""Steps through a day with battery and potential-energy storage until the day repeats itself.

What a step does, and why, stands at the head of :mod:`sizing.altitude.climb_cycle`.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from sizing.altitude.climb_levels import FlightLevels
from sizing.energy.battery import Store
from sizing.energy.cycle import FULL
from sizing.energy.power_balance import crossing_fraction, positive_part_wh
from solar.types import BoolArray, FloatArray, IntArray

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
    """Steps through the day of aircraft in scenarios with both storages.

    ``levels``: the aircraft between the lowest altitude and the ceiling. ``steps_per_node``: steps
    in one of the day's axis.
    """

    def __init__(
        self,
        time_h: FloatArray,
        levels: FlightLevels,
        store: Store,
        strategy: Strategy,
        steps_per_node: int,
    ) -> None:
        self.node_h = np.asarray(time_h, float)
        self.steps_per_node = steps_per_node
        self.always_climb = strategy == "surplus"
        self.light = np.ascontiguousarray(np.moveaxis(levels.specific_power_w_per_m2, -1, 0))
        self.factor = np.ascontiguousarray(levels.turbulence_factor.T)
        lengths = np.diff(self.node_h) / self.steps_per_node
        self.hours = [float(length) for length in lengths for _ in range(self.steps_per_node)]
        self._take(levels, store)

    def _take(self, levels: FlightLevels, store: Store) -> None:
        """Hold what belongs to the elements; the light and the day are those of all scenarios."""
        self.levels, self.store = levels, store
        self.potential_max_wh = levels.potential_energy_wh[-1]
        self.places = np.arange(len(levels.scenario))
        rises = np.diff(levels.potential_energy_wh, axis=0)
        self.per_wh = 1.0 / np.where(rises > 0.0, rises, np.inf)
        self.thresholds_wh = levels.potential_energy_wh[1:-1]
        self.counts_as_full_wh = FULL * store.battery_energy_wh
        zero = np.zeros(len(self.places))
        self.nothing = _Drawn(Stored(zero, zero), zero, zero, zero)

    def select(self, some: BoolArray) -> March:
        """Steps of a part of the elements."""
        part = copy.copy(self)
        vars(part).pop("_at_floor", None)  # of all elements
        part._take(self.levels.select(some), self.store.select(some))
        return part

    @property
    def time_h(self) -> FloatArray:
        """Nodes of the steps [h]."""
        parts = np.arange(self.steps_per_node) / self.steps_per_node
        fine = self.node_h[:-1, np.newaxis] + np.diff(self.node_h)[:, np.newaxis] * parts
        return np.append(fine.ravel(), self.node_h[-1])

    def steps(self, stored: Stored) -> Iterator[ClimbStep]:
        """March through the day from what is stored at its start."""
        before = stored.potential_wh
        for number, hours in enumerate(self.hours):
            supply = self._supply(number, stored.potential_wh, before)
            moves = self._moves(stored, supply, hours)
            yield ClimbStep(stored, supply.power, _flows(supply, moves, hours), moves.end)
            before, stored = stored.potential_wh, moves.end

    def end_of_day(self, stored: Stored) -> Stored:
        """What is stored at the end of the day, from what is at its start."""
        before = stored.potential_wh
        for number, hours in enumerate(self.hours):
            supply = self._supply(number, stored.potential_wh, before)
            before, stored = stored.potential_wh, self._moves(stored, supply, hours).end
        return stored

    def _supply(self, number: int, potential_wh: FloatArray, before_wh: FloatArray) -> _Supply:
        """What a step has to go on, at the altitude extrapolated to its middle."""
        if not (potential_wh.any() or before_wh.any()):
            return self._at_floor[number]
        middle = np.clip(1.5 * potential_wh - 0.5 * before_wh, 0.0, self.potential_max_wh)
        power = self._power(*divmod(number, self.steps_per_node), middle)
        return _Supply.of(power, self._balance(power, self.hours[number]))

    @cached_property
    def _at_floor(self) -> list[_Supply]:
        """All steps of the day at the lowest altitude: most of them, known beforehand."""
        node, part = np.divmod(np.arange(len(self.hours))[:, np.newaxis], self.steps_per_node)
        power = self._power(node, part, np.zeros(len(self.places)))
        balance = self._balance(power, np.array(self.hours)[:, np.newaxis])
        rows = zip(zip(*power, strict=True), zip(*balance, strict=True), strict=True)
        return [_Supply.of(StepPower(*p), _Balance(*b)) for p, b in rows]

    def _power(
        self, node: int | IntArray, part: int | IntArray, potential_wh: FloatArray
    ) -> StepPower:
        """Power of one step, or of a column of steps, at an altitude."""
        levels, places, scenario = self.levels, self.places, self.levels.scenario
        below = (potential_wh >= self.thresholds_wh).sum(axis=0)
        above = below + 1
        potential_at = levels.potential_energy_wh
        upper = (potential_wh - potential_at[below, places]) * self.per_wh[below, places]
        lower = 1.0 - upper
        light, level_w = self.light, levels.propulsion_power_w
        low_area, high_area = lower * levels.module_area_m2, upper * levels.module_area_m2
        start = low_area * light[node, below, scenario] + high_area * light[node, above, scenario]
        following = node + 1
        end = low_area * light[following, below, scenario]
        end = end + high_area * light[following, above, scenario]
        motor = lower * level_w[below, places] + upper * level_w[above, places]
        a, b = part / self.steps_per_node, (part + 1) / self.steps_per_node
        first, last = self.factor[node, scenario], self.factor[following, scenario]
        return StepPower(
            start + (end - start) * a,
            start + (end - start) * b,
            motor * (first + (last - first) * a),
            motor * (first + (last - first) * b),
        )

    def _balance(self, power: StepPower, hours: float | FloatArray) -> _Balance:
        """Surplus and deficit of one step, or of a column of steps."""
        constant = self.levels.constant_power_w
        solar_left, solar_right, motor_left, motor_right = power
        left = solar_left - motor_left - constant
        right = solar_right - motor_right - constant
        deficit = positive_part_wh(-left, -right, hours)
        of_avionics = positive_part_wh(constant - solar_left, constant - solar_right, hours)
        early = np.where(left < 0.0, 1.0, 0.0)
        late = 1.0 - early
        lit_h = hours * _surplus_share(left, right)
        room_w = self.levels.maximum_power_w - (motor_left + motor_right) / 2.0
        return _Balance(
            surplus_wh=positive_part_wh(left, right, hours),
            deficit_wh=deficit,
            early_wh=early * deficit,
            early_avionics_wh=early * of_avionics,
            late_wh=late * deficit,
            late_avionics_wh=late * of_avionics,
            lit_h=lit_h,
            room_wh=room_w * lit_h,
        )

    def _moves(self, stored: Stored, supply: _Supply, hours: float) -> _Moves:
        """Early deficit, surplus (charge, then climb), late deficit; none where there is none."""
        balance = supply.balance
        first = second = self.nothing
        climb = charged_wh = left_over = self.nothing.drawn_wh
        if supply.begins_short:
            first = self._drawn(stored, balance.early_wh, balance.early_avionics_wh)
            stored = first.end
        if supply.has_surplus:
            energy, potential = stored
            charged = self.store.charged(energy, balance.surplus_wh, hours)
            charged_wh = charged - energy
            left_over = balance.surplus_wh - charged_wh / self.store.charge_efficiency
            usable = self._usable_wh(energy, charged, balance.surplus_wh, left_over, hours)
            climb = self._climb_wh(potential, usable, balance.room_wh)
            stored = Stored(charged, potential + self.levels.efficiency * climb)
        if supply.ends_short:
            second = self._drawn(stored, balance.late_wh, balance.late_avionics_wh)
            stored = second.end
        return _Moves(first, charged_wh, left_over, climb, second, stored)

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
        usable = np.where(energy < self.counts_as_full_wh, after * surplus, left_over)
        return np.where(full, np.minimum(left_over, usable), 0.0)

    def _climb_wh(
        self, potential: FloatArray, usable_wh: FloatArray, room_wh: FloatArray
    ) -> FloatArray:
        """Electric energy spent on climbing [Wh]."""
        to_ceiling = (self.potential_max_wh - potential) / self.levels.efficiency
        energy = np.minimum(np.minimum(usable_wh, np.maximum(room_wh, 0.0)), to_ceiling)
        return np.asarray(np.maximum(energy, 0.0))

    def _drawn(self, stored: Stored, deficit: FloatArray, of_avionics: FloatArray) -> _Drawn:
        """Meet a deficit: what the motor lacks by sinking first, all else from the battery."""
        energy, potential = stored
        of_motor = deficit - of_avionics
        glide = np.minimum(np.maximum(of_motor, 0.0), potential / self.levels.efficiency)
        wanted = deficit - glide
        eta = self.store.discharge_efficiency
        drawn = np.minimum(wanted / eta, energy)
        # Rounding must leave no potential energy that is none.
        lower = np.maximum(potential - self.levels.efficiency * glide, 0.0)
        unserved = np.maximum(wanted - eta * drawn, 0.0)
        return _Drawn(Stored(energy - drawn, lower), drawn, glide, unserved)


class _Balance(NamedTuple):
    """Energy that is left over or lacking in a step, whatever is stored [Wh]; per scenario.

    ``room_wh`` is what the propulsion could take besides level flight while there is a surplus.
    """

    surplus_wh: FloatArray
    deficit_wh: FloatArray
    early_wh: FloatArray
    early_avionics_wh: FloatArray
    late_wh: FloatArray
    late_avionics_wh: FloatArray
    lit_h: FloatArray
    room_wh: FloatArray


class _Supply(NamedTuple):
    """Power and balance of a step, and which of its phases any scenario has."""

    power: StepPower
    balance: _Balance
    begins_short: bool
    has_surplus: bool
    ends_short: bool

    @classmethod
    def of(cls, power: StepPower, balance: _Balance) -> _Supply:
        phases = (balance.early_wh, balance.surplus_wh, balance.late_wh)
        return cls(power, balance, *(bool(phase.any()) for phase in phases))


class _Moves(NamedTuple):
    """What a step does with what is stored; per scenario."""

    first: _Drawn
    charged_wh: FloatArray
    left_over_wh: FloatArray
    climb_wh: FloatArray
    second: _Drawn
    end: Stored


class _Drawn(NamedTuple):
    """What is stored after a deficit, and what was given [Wh]; ``glide_wh`` is electric, saved."""

    end: Stored
    drawn_wh: FloatArray
    glide_wh: FloatArray
    unserved_wh: FloatArray


def _flows(supply: _Supply, moves: _Moves, hours: float) -> Flows:
    """Energy that moved within a step."""
    power, balance = supply.power, supply.balance
    first, second = moves.first, moves.second
    unserved = first.unserved_wh + second.unserved_wh
    return Flows(
        solar_wh=(power.solar_left_w + power.solar_right_w) / 2.0 * hours,
        level_electric_wh=(power.motor_left_w + power.motor_right_w) / 2.0 * hours,
        charged_wh=moves.charged_wh,
        drawn_wh=first.drawn_wh + second.drawn_wh,
        curtailed_wh=moves.left_over_wh - moves.climb_wh,
        climb_wh=moves.climb_wh,
        glide_wh=first.glide_wh + second.glide_wh,
        unserved_wh=unserved,
        missing_h=(hours - balance.lit_h) * unserved / np.maximum(balance.deficit_wh, 1e-300),
    )


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
    found, places = Stored(energy.copy(), potential.copy()), np.arange(len(full))
    for number in range(1, _MAXIMUM_ROUNDS + 1):
        end = march.end_of_day(Stored(energy, potential))
        gain, shift = end.battery_wh - energy, np.abs(end.potential_wh - potential)
        low = low & (potential == 0.0) & (end.potential_wh == 0.0)
        bracket.learn(energy, gain, low)
        energy, potential = end
        found.battery_wh[places], found.potential_wh[places] = end
        moves = np.maximum(np.abs(gain), shift) > _TOLERANCE * scale
        if not moves.any():
            break
        if number % _PLAIN_ROUNDS == 0 and number <= _MAXIMUM_ROUNDS - _LAST_ROUNDS:
            energy = np.where(low, bracket.extrapolated(energy, gain, previous), energy)
            low = np.ones_like(low)
        previous = gain
        if not moves.all():
            # Elements that have settled stay as they are, whatever the others take.
            march, bracket, places = march.select(moves), bracket.select(moves), places[moves]
            energy, potential, scale, previous, low = (
                values[moves] for values in (energy, potential, scale, previous, low)
            )
    return found


class _EnergyBracket:
    """Energies below and above that of the repeating day, per scenario."""

    def __init__(self, battery_energy_wh: FloatArray) -> None:
        self.full = battery_energy_wh
        self.lower, self.upper = np.zeros_like(self.full), self.full.copy()

    def select(self, some: BoolArray) -> _EnergyBracket:
        """Energies of a part of the scenarios."""
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
