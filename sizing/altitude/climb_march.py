"""Steps through a day with battery and potential-energy storage until the day repeats itself.

What a step does, and why, stands at the head of :mod:`sizing.altitude.climb_cycle`.
"""

from __future__ import annotations

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


class Stored(NamedTuple):
    """Energy in the battery, and potential energy above the lowest level [Wh]; per element."""

    battery_wh: FloatArray
    potential_wh: FloatArray


class Power(NamedTuple):
    """Power of steps, and what is left over or lacking in them whatever is stored.

    Of sun and motor in level flight at both ends, at the altitude of the middle [W]; surplus and
    deficit, that of the avionics alone, and what the propulsion could take besides level flight
    while there is a surplus [Wh]; ``sunlit_h`` is how long there is one. A deficit comes before the
    surplus of its step where ``early`` is 1, after it where that is 0.
    """

    solar_left_w: FloatArray
    solar_right_w: FloatArray
    motor_left_w: FloatArray
    motor_right_w: FloatArray
    surplus_wh: FloatArray
    deficit_wh: FloatArray
    of_avionics_wh: FloatArray
    room_wh: FloatArray
    sunlit_h: FloatArray
    early: FloatArray


class DayRun:
    """What a day has done, step by step; time is the first axis, elements the second.

    ``energy_wh`` and ``potential_wh`` are stored at the nodes of the steps. Energy that moves in a
    step [Wh]: ``charged``, ``drawn``, ``left_over`` of the surplus, of that ``climb``, ``glide``,
    which is electric energy that sinking has saved, and ``unserved``.
    """

    def __init__(self, march: March) -> None:
        # Most steps are at the lowest altitude.
        self.march, self.power = march, Power(*(values.copy() for values in march.at_floor))
        steps, elements = self.power.solar_left_w.shape
        self.energy_wh, self.potential_wh = np.zeros((2, steps + 1, elements))
        self.charged, self.drawn, self.left_over = np.zeros((3, steps, elements))
        self.climb, self.glide, self.unserved = np.zeros((3, steps, elements))

    def keep(self, number: int, moves: _Moves, power: Power | None) -> None:
        """Keep what a step does; ``power`` where it is above the lowest altitude."""
        self.charged[number], self.left_over[number] = moves.charged_wh, moves.left_over_wh
        self.climb[number] = moves.climb_wh
        for drawn in (moves.first, moves.second):
            if drawn is not None:
                self.drawn[number] += drawn.drawn_wh
                self.glide[number] += drawn.glide_wh
                self.unserved[number] += drawn.unserved_wh
        self.energy_wh[number + 1], self.potential_wh[number + 1] = moves.end
        if power is not None:
            for row, values in zip(self.power, power, strict=True):
                row[number] = values

    @property
    def solar_wh(self) -> FloatArray:
        """Energy of the modules in every step [Wh]."""
        return (self.power.solar_left_w + self.power.solar_right_w) / 2.0 * self.march.hours

    @property
    def level_electric_wh(self) -> FloatArray:
        """Electric energy that level flight takes in every step [Wh]."""
        return (self.power.motor_left_w + self.power.motor_right_w) / 2.0 * self.march.hours

    @property
    def motor_wh(self) -> FloatArray:
        """Electric energy of the propulsion in every step [Wh]."""
        return self.level_electric_wh + self.climb - self.glide

    @property
    def missing_h(self) -> FloatArray:
        """Hours without energy."""
        lacking = (self.march.hours - self.power.sunlit_h) * self.unserved
        return np.asarray((lacking / np.maximum(self.power.deficit_wh, 1e-300)).sum(axis=0))


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
        self.node_h, self.levels, self.store = np.asarray(time_h, float), levels, store
        self.steps_per_node, self.strategy = steps_per_node, strategy
        self.potential_max_wh = levels.potential_energy_wh[-1]
        self.per_wh = _inverse(np.diff(levels.potential_energy_wh, axis=0)).ravel()
        self.thresholds_wh = levels.potential_energy_wh[1:-1]
        self.potential_at = levels.potential_energy_wh.ravel()
        self.motor_at = levels.propulsion_power_w.ravel()
        self.count = len(levels.scenario)
        self.places, self._nothing = np.arange(self.count), np.zeros(self.count)
        # Of every node: solar power at all levels, one after the other, and turbulence.
        light = np.moveaxis(levels.specific_power_w_per_m2, -1, 0)[:, :, levels.scenario]
        self.solar_at = (light * levels.module_area_m2).reshape(len(light), -1)
        self.factor = levels.turbulence_factor.T[:, levels.scenario]
        self.counts_as_full_wh = FULL * store.battery_energy_wh
        self.hours = np.repeat(np.diff(self.node_h) / steps_per_node, steps_per_node)[:, np.newaxis]
        self._hours = [float(hours) for hours in self.hours[:, 0]]

    def select(self, some: IntArray | BoolArray) -> March:
        """Steps of some of the elements."""
        levels, store = self.levels.select(some), self.store.select(some)
        return March(self.node_h, levels, store, self.strategy, self.steps_per_node)

    @property
    def time_h(self) -> FloatArray:
        """Nodes of the steps [h]."""
        parts = np.arange(self.steps_per_node) / self.steps_per_node
        fine = self.node_h[:-1, np.newaxis] + np.diff(self.node_h)[:, np.newaxis] * parts
        return np.append(fine.ravel(), self.node_h[-1])

    def end_of_day(self, stored: Stored, run: DayRun | None = None) -> Stored:
        """What is stored at the end of the day, from what is at its start; kept in a run."""
        if run is not None:
            run.energy_wh[0], run.potential_wh[0] = stored
        before, number = stored.potential_wh, 0
        while number < len(self._hours):
            at_floor = not (stored.potential_wh.any() or before.any())
            until = self._dark_until[number]
            if at_floor and until > number:
                stored = self._discharged(stored, slice(number, until), run)
                before, number = stored.potential_wh, until
                continue
            if at_floor:
                power, phases = self._floor_steps[number]
            else:
                middle = 1.5 * stored.potential_wh - 0.5 * before
                power = self._power_at(number, middle)
                phases = _phases(power)
            moves = self._moves(stored, power, phases, self._hours[number])
            if run is not None:
                run.keep(number, moves, None if at_floor else power)
            before, stored, number = stored.potential_wh, moves.end, number + 1
        return stored

    @cached_property
    def at_floor(self) -> Power:
        """All steps of the day at the lowest altitude."""
        node, part = np.divmod(np.arange(len(self._hours)), self.steps_per_node)
        floor = slice(None, self.count)
        ends = [
            first + (last - first) * share[:, np.newaxis]
            for first, last in (
                (self.solar_at[node, floor], self.solar_at[node + 1, floor]),
                (self.factor[node], self.factor[node + 1]),
            )
            for share in (part / self.steps_per_node, (part + 1) / self.steps_per_node)
        ]
        motor_w = self.motor_at[floor]
        return self._balance(ends[0], ends[1], motor_w * ends[2], motor_w * ends[3], self.hours)

    @cached_property
    def _floor_steps(self) -> list[tuple[Power, _Phases]]:
        """The same step by step: most of them, known beforehand."""
        rows = (Power(*row) for row in zip(*self.at_floor, strict=True))
        return [(row, _phases(row)) for row in rows]

    @cached_property
    def _dark_until(self) -> list[int]:
        """First step from each on in which any element has a surplus."""
        lit = np.any(self.at_floor.surplus_wh > 0.0, axis=1)
        steps = np.where(lit, np.arange(len(lit)), len(lit))
        return [int(step) for step in np.minimum.accumulate(steps[::-1])[::-1]]

    @cached_property
    def _floor_deficit_wh(self) -> FloatArray:
        """Deficits at the lowest altitude from the first to every node [Wh]."""
        zero = np.zeros((1, self.count))
        return np.concatenate([zero, np.cumsum(self.at_floor.deficit_wh, axis=0)])

    def _discharged(self, stored: Stored, steps: slice, run: DayRun | None) -> Stored:
        """Fly on the battery at the lowest altitude, without any surplus."""
        eta, sums = self.store.discharge_efficiency, self._floor_deficit_wh
        if run is None:
            used_wh = (sums[steps.stop] - sums[steps.start]) / eta
            return stored._replace(battery_wh=np.maximum(stored.battery_wh - used_wh, 0.0))
        used_wh = (sums[steps.start + 1 : steps.stop + 1] - sums[steps.start]) / eta
        energy_wh = np.maximum(stored.battery_wh - used_wh, 0.0)
        run.energy_wh[steps.start + 1 : steps.stop + 1] = energy_wh
        drawn_wh = -np.diff(np.concatenate([stored.battery_wh[np.newaxis], energy_wh]), axis=0)
        run.drawn[steps] = drawn_wh
        lacking_wh = self.at_floor.deficit_wh[steps] - eta * drawn_wh
        # What rounding leaves of a deficit that is met is none.
        unmet = energy_wh <= 0.0
        run.unserved[steps] = np.where(unmet, np.maximum(lacking_wh, 0.0), 0.0)
        return stored._replace(battery_wh=energy_wh[-1])

    def _power_at(self, number: int, potential_wh: FloatArray) -> Power:
        """Power of one step at a potential energy."""
        node, part = divmod(number, self.steps_per_node)
        potential_wh = np.minimum(np.maximum(potential_wh, 0.0), self.potential_max_wh)
        below = (potential_wh >= self.thresholds_wh).sum(axis=0) * self.count + self.places
        above = below + self.count
        upper = (potential_wh - self.potential_at[below]) * self.per_wh[below]
        lower = 1.0 - upper
        here, there = self.solar_at[node], self.solar_at[node + 1]
        left = lower * here[below] + upper * here[above]
        right = lower * there[below] + upper * there[above]
        motor_w = lower * self.motor_at[below] + upper * self.motor_at[above]
        first, last = self.factor[node], self.factor[node + 1]
        if self.steps_per_node > 1:
            a, b = part / self.steps_per_node, (part + 1) / self.steps_per_node
            left, right = left + (right - left) * a, left + (right - left) * b
            first, last = first + (last - first) * a, first + (last - first) * b
        return self._balance(left, right, motor_w * first, motor_w * last, self._hours[number])

    def _balance(
        self,
        solar_left: FloatArray,
        solar_right: FloatArray,
        motor_left: FloatArray,
        motor_right: FloatArray,
        hours: float | FloatArray,
    ) -> Power:
        """Surplus and deficit of one step, or of a column of steps."""
        constant = self.levels.constant_power_w
        left = solar_left - motor_left - constant
        right = solar_right - motor_right - constant
        sunlit_h = hours * _surplus_share(left, right)
        room_w = self.levels.maximum_power_w - (motor_left + motor_right) / 2.0
        return Power(
            *(solar_left, solar_right, motor_left, motor_right),
            surplus_wh=positive_part_wh(left, right, hours),
            deficit_wh=positive_part_wh(-left, -right, hours),
            of_avionics_wh=positive_part_wh(constant - solar_left, constant - solar_right, hours),
            room_wh=np.maximum(room_w, 0.0) * sunlit_h,
            sunlit_h=sunlit_h,
            early=np.where(left < 0.0, 1.0, 0.0),
        )

    def _moves(self, stored: Stored, power: Power, phases: _Phases, hours: float) -> _Moves:
        """Early deficit, surplus (charge, then climb), late deficit; none where there is none."""
        first = second = None
        climb = charged_wh = left_over = self._nothing
        if phases.begins_short:
            first = self._drawn(stored, power, power.early)
            stored = first.end
        if phases.has_surplus:
            energy, potential = stored
            charged = self.store.charged(energy, power.surplus_wh, hours)
            charged_wh = charged - energy
            left_over = power.surplus_wh - charged_wh / self.store.charge_efficiency
            usable = self._usable_wh(energy, charged, power.surplus_wh, left_over, hours)
            climb = self._climb_wh(potential, usable, power.room_wh)
            stored = Stored(charged, potential + self.levels.efficiency * climb)
        if phases.ends_short:
            second = self._drawn(stored, power, 1.0 - power.early)
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
        if self.strategy == "surplus":
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
        energy = np.minimum(np.minimum(usable_wh, room_wh), to_ceiling)
        return np.asarray(np.maximum(energy, 0.0))

    def _drawn(self, stored: Stored, power: Power, share: FloatArray) -> _Drawn:
        """Meet a deficit: what the motor lacks by sinking first, all else from the battery."""
        energy, potential = stored
        deficit = share * power.deficit_wh
        of_motor = deficit - share * power.of_avionics_wh
        glide = np.minimum(np.maximum(of_motor, 0.0), potential / self.levels.efficiency)
        wanted = deficit - glide
        eta = self.store.discharge_efficiency
        drawn = np.minimum(wanted / eta, energy)
        # Rounding must leave no potential energy that is none.
        lower = np.maximum(potential - self.levels.efficiency * glide, 0.0)
        unserved = np.maximum(wanted - eta * drawn, 0.0)
        return _Drawn(Stored(energy - drawn, lower), drawn, glide, unserved)


class _Phases(NamedTuple):
    """Which phases of a step any element has."""

    begins_short: bool
    has_surplus: bool
    ends_short: bool


def _phases(power: Power) -> _Phases:
    short = power.deficit_wh > 0.0
    if not short.any():
        return _Phases(begins_short=False, has_surplus=True, ends_short=False)
    early = power.early > 0.0
    return _Phases(
        bool((short & early).any()), bool(power.surplus_wh.any()), bool((short & ~early).any())
    )


class _Drawn(NamedTuple):
    """What is stored after a deficit, and what was given [Wh]; ``glide_wh`` is electric, saved."""

    end: Stored
    drawn_wh: FloatArray
    glide_wh: FloatArray
    unserved_wh: FloatArray


class _Moves(NamedTuple):
    """What a step does with what is stored; per element."""

    first: _Drawn | None
    charged_wh: FloatArray
    left_over_wh: FloatArray
    climb_wh: FloatArray
    second: _Drawn | None
    end: Stored


def _inverse(rises_wh: FloatArray) -> FloatArray:
    return 1.0 / np.where(rises_wh > 0.0, rises_wh, np.inf)


def _surplus_share(left: FloatArray, right: FloatArray) -> FloatArray:
    """Share of a step in which a power that is linear over it is not negative."""
    low, high = np.minimum(left, right), np.maximum(left, right)
    if low.min() >= 0.0 or high.max() < 0.0:  # most steps: nothing changes its sign
        return np.where(high < 0.0, 0.0, 1.0)
    crossing = crossing_fraction(left, right)
    begin = np.where(left < 0.0, np.where(right < 0.0, 1.0, crossing), 0.0)
    end = np.where((right < 0.0) & (left >= 0.0), crossing, 1.0)
    return end - begin
