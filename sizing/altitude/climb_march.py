"""Steps through a day with battery and potential-energy storage until the day repeats itself.

What a step does, and why, stands at the head of :mod:`sizing.altitude.climb_cycle`.
"""

from __future__ import annotations

from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from sizing.altitude.climb_chain import Place
from sizing.altitude.climb_levels import FlightLevels
from sizing.altitude.climb_run import DayRun, Drawn, Moves, Power, Record, Stored, mean_of_ends
from sizing.energy.battery import Store
from sizing.energy.cycle import FULL
from sizing.energy.power_balance import PowerBalance, crossing_fraction, positive_part_wh
from solar.types import BoolArray, FloatArray, IntArray

Strategy = Literal["battery_full", "surplus"]

STEPS_PER_NODE = 5  # of the day's axis: 1 min
_ZERO, _ONE = np.array(0.0), np.array(1)  # NumPy takes half as long with them as with numbers


class March:
    """Steps through the day of aircraft in scenarios with both storages.

    ``levels``: the aircraft between the lowest altitude and the ceiling. ``steps_per_node``: steps
    in one of the day's axis. ``nominal_w``: load that equal power and excess time count by; by
    default that at the lowest altitude without thermals.
    """

    def __init__(
        self,
        time_h: FloatArray,
        levels: FlightLevels,
        store: Store,
        strategy: Strategy,
        steps_per_node: int,
        *,
        nominal_w: FloatArray | None = None,
    ) -> None:
        self.node_h, self.levels, self.store = np.asarray(time_h, float), levels, store
        self.steps_per_node, self.strategy = steps_per_node, strategy
        count, at_wh = len(levels.scenario), levels.potential_energy_wh
        self.count, self._nothing = count, np.zeros(count)
        self.potential_max_wh = levels.highest_wh
        # Tables have all levels of an element, one after the other, and then those of the next.
        self.floor = slice(None, None, len(at_wh))
        self.potential_at, self.motor_at = at_wh.T.ravel(), levels.propulsion_power_w.T.ravel()
        self.per_wh = _inverse(np.diff(at_wh, axis=0, append=at_wh[-1:])).T.ravel()
        # Heights over the ceiling's and twice the element's number: one search finds all levels.
        self._per_ceiling, self._apart = _inverse(at_wh[-1]), 2.0 * np.arange(count)
        self._thresholds = (at_wh[1:-1] * self._per_ceiling + self._apart).T.ravel()
        self._first = 2 * np.arange(count)
        steps = np.arange((len(self.node_h) - 1) * steps_per_node)
        self._node, part = np.divmod(steps, steps_per_node)
        self._share = (part[:, np.newaxis] + np.arange(2))[..., np.newaxis] / steps_per_node
        self.counts_as_full_wh = FULL * store.battery_energy_wh
        self.hours = np.repeat(np.diff(self.node_h) / steps_per_node, steps_per_node)[:, np.newaxis]
        self._hours = [np.array(hours) for hours in self.hours[:, 0]]
        self._constant_w = np.array([levels.constant_power_w] * 2)
        self._floor_steps = dict[int, tuple[Power, _Phases]]()
        chain = levels.chain
        if chain is not None:
            # Rows of the propulsion's tables at the levels, which designs share.
            rows = np.arange(len(levels.altitude_m))[:, np.newaxis] * chain.count + levels.design
            self.row_at, self.thrust_at = rows.T.ravel(), levels.thrust_power_w.T.ravel()
            if nominal_w is None:
                thrust = chain.power_w(rows[0], levels.nominal_factor)
                nominal_w = thrust + levels.constant_power_w
        self.nominal_w = levels.nominal_load_w if nominal_w is None else nominal_w

    def select(self, some: IntArray | BoolArray) -> March:
        """Steps of some of the elements."""
        levels, store = self.levels.select(some), self.store.select(some)
        given = (self.node_h, levels, store, self.strategy, self.steps_per_node)
        return March(*given, nominal_w=self.nominal_w[some])

    @cached_property
    def solar_at(self) -> FloatArray:
        """Solar power of every node at all levels of each element [W]."""
        levels = self.levels
        light = np.moveaxis(levels.specific_power_w_per_m2, -1, 0)[:, :, levels.scenario]
        for number in range(light.shape[1]):
            factor = levels.cooling_factor(number)
            if factor is not None:
                light[:, number] *= factor.T
        light = (light * levels.module_area_m2).transpose(0, 2, 1)
        return np.asarray(light.reshape(len(light), -1))

    @cached_property
    def factor(self) -> FloatArray:
        """Turbulence at both ends of every step: power over that in calm air [-]."""
        return self._ends(self.levels.turbulence_factor.T[:, self.levels.scenario])

    @property
    def time_h(self) -> FloatArray:
        """Nodes of the steps [h]."""
        parts = np.arange(self.steps_per_node) / self.steps_per_node
        fine = self.node_h[:-1, np.newaxis] + np.diff(self.node_h)[:, np.newaxis] * parts
        return np.append(fine.ravel(), self.node_h[-1])

    def empty_run(self) -> DayRun:
        """Record of a day that has not been flown."""
        constant = self.levels.efficiency if self.levels.chain is None else None
        return DayRun(self.at_floor, self.floor_thrust_w, self.hours, constant)

    def end_of_day(
        self, stored: Stored, run: Record | None = None, first: IntArray | None = None
    ) -> Stored:
        """What is stored at the end of the day, from what is at its start; kept in a run.

        ``first``: step with which every element begins, and until which it keeps what it has.
        """
        if isinstance(run, DayRun):
            run.energy_wh[0], run.potential_wh[0] = stored
        launched, all_fly = stored, 0 if first is None else int(np.max(first))
        before, number = stored.potential_wh, 0
        aloft = was_aloft = np.count_nonzero(before)
        while number < len(self._hours):
            at_floor = not (aloft or was_aloft)
            until = self._dark_until[number]
            if at_floor and until > number >= all_fly:
                stored = self._discharged(stored, slice(number, until), run)
                before, number = stored.potential_wh, until
                continue
            place = None
            if at_floor:
                power, phases = self._floor_step(number)
                if self.levels.chain is not None:
                    place = self._floor_place(number, power)
            else:
                middle = 1.5 * stored.potential_wh - 0.5 * before
                power, place = self._power_at(number, middle)
                phases = _phases(power)
            moves = self._moves(stored, power, place, phases, self._hours[number])
            if run is not None:
                run.keep(number, moves, None if at_floor else power, place)
            before, stored, number = stored.potential_wh, moves.end, number + 1
            if first is not None and number <= all_fly:
                waits = first >= number
                stored = Stored(
                    *(np.where(waits, a, b) for a, b in zip(launched, stored, strict=True))
                )
            aloft, was_aloft = np.count_nonzero(stored.potential_wh), aloft
        return stored

    def _ends(self, values: FloatArray) -> FloatArray:
        """Values at both ends of every step, ``(step, end, ...)``, from those at the nodes."""
        first, last = values[self._node, np.newaxis], values[self._node + 1, np.newaxis]
        return _between(first, last, self._share)

    @cached_property
    def at_floor(self) -> Power:
        """All steps of the day at the lowest altitude."""
        floor, hours, chain = self.floor, self.hours, self.levels.chain
        solar_w = self._ends(self.solar_at[:, floor])
        if chain is None:
            return self._balance(solar_w, self.motor_at[floor] * self.factor, hours)
        row = self.row_at[floor]
        motor_w = chain.power_w(row, self.factor)
        return self._balance(solar_w, motor_w, hours, chain.most_w(row))

    def floor_balance(self) -> PowerBalance:
        """Power of the whole day at the lowest altitude, at the nodes of its steps."""
        solar_w, motor_w = (at_nodes(one) for one in (self.at_floor.solar_w, self.at_floor.motor_w))
        constant_w = self.levels.constant_power_w[:, np.newaxis]
        return PowerBalance.of(self.time_h, solar_w, motor_w + constant_w)

    @cached_property
    def floor_thrust_w(self) -> FloatArray:
        """Thrust power of level flight at the lowest altitude in every step [W]; 0 by constants."""
        if self.levels.chain is None:
            return np.zeros((len(self._hours), self.count))
        return np.asarray(self.thrust_at[self.floor] * self.factor.mean(axis=1))

    def _floor_place(self, number: int, power: Power) -> Place:
        """Where a step at the lowest altitude is flown."""
        chain, row = self.levels.chain, self.row_at[self.floor]
        assert chain is not None
        thrust_w = self.floor_thrust_w[number]
        return Place(chain, row, row, self._nothing, mean_of_ends(power.motor_w), thrust_w)

    def _floor_step(self, number: int) -> tuple[Power, _Phases]:
        """One step at the lowest altitude, kept for the next day."""
        if number not in self._floor_steps:
            power = Power(*(one[number] for one in self.at_floor))
            self._floor_steps[number] = power, _phases(power)
        return self._floor_steps[number]

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

    def _discharged(self, stored: Stored, steps: slice, run: Record | None) -> Stored:
        """Fly on the battery at the lowest altitude, without any surplus."""
        eta, sums = self.store.discharge_efficiency, self._floor_deficit_wh
        if run is not None:
            used_wh = (sums[steps.start + 1 : steps.stop + 1] - sums[steps.start]) / eta
            run.discharge(steps, stored, used_wh, eta)
        used_wh = (sums[steps.stop] - sums[steps.start]) / eta
        return stored._replace(battery_wh=np.maximum(stored.battery_wh - used_wh, 0.0))

    def _power_at(self, number: int, potential_wh: FloatArray) -> tuple[Power, Place | None]:
        """Power of one step at a potential energy, and its place."""
        node = number // self.steps_per_node
        potential_wh = np.minimum(np.maximum(potential_wh, self._nothing), self.potential_max_wh)
        place = potential_wh * self._per_ceiling + self._apart
        below = self._thresholds.searchsorted(place, side="right") + self._first
        above = below + _ONE
        upper = (potential_wh - self.potential_at[below]) * self.per_wh[below]
        solar = self.solar_at[node : node + 2]
        solar_w = _between(solar.take(below, axis=1), solar.take(above, axis=1), upper)
        if self.steps_per_node > 1:
            solar_w = _between(solar_w[0], solar_w[1], self._share[number])
        factor, hours, chain = self.factor[number], self._hours[number], self.levels.chain
        if chain is None:
            motor_w = _between(self.motor_at[below], self.motor_at[above], upper)
            return self._balance(solar_w, motor_w * factor, hours), None
        rows = np.array([self.row_at[below], self.row_at[above]])[:, np.newaxis]
        motors_w = chain.power_w(rows, factor)
        motor_w = _between(motors_w[0], motors_w[1], upper)
        thrust_w = _between(self.thrust_at[below], self.thrust_at[above], upper)
        at = Place(
            *(chain, self.row_at[below], self.row_at[above], upper),
            motor_w=mean_of_ends(motor_w),
            thrust_w=thrust_w * mean_of_ends(factor),
        )
        most_w = _between(chain.most_w(at.below), chain.most_w(at.above), upper)
        return self._balance(solar_w, motor_w, hours, most_w), at

    def _gain(self, place: Place | None, more_wh: FloatArray, hours: FloatArray) -> FloatArray:
        """Thrust power that the motor's power beyond level flight's gives, over that power [-].

        ``more_wh``: over the hours; below zero for less than level flight's.
        """
        if place is None:
            return self.levels.efficiency
        return place.gain(more_wh / np.where(hours > 0.0, hours, np.inf))

    def _balance(
        self,
        solar_w: FloatArray,
        motor_w: FloatArray,
        hours: FloatArray,
        most_w: FloatArray | None = None,
    ) -> Power:
        """Surplus and deficit of one step, or of a column of steps."""
        spare_w = solar_w - self._constant_w
        net_w = spare_w - motor_w
        mean_wh = mean_of_ends(net_w) * hours
        none = np.zeros(mean_wh.shape)
        lit = np.count_nonzero(net_w > _ZERO)
        # Most steps are all surplus or all deficit, in every element.
        if not lit:
            of_avionics_wh = _deficit_wh(spare_w, hours)
            return Power(solar_w, motor_w, none, -mean_wh, of_avionics_wh, none, none, none)
        rated_w = self.levels.maximum_power_w
        most_w = rated_w if most_w is None else np.minimum(rated_w, most_w)
        room_w = np.maximum(most_w - mean_of_ends(motor_w), none)
        if lit == net_w.size:
            room_wh = room_w * hours
            return Power(solar_w, motor_w, mean_wh, none, none, room_wh, none + hours, none)
        left, right = net_w[..., 0, :], net_w[..., 1, :]
        sunlit_h = hours * _surplus_share(left, right)
        return Power(
            *(solar_w, motor_w),
            surplus_wh=positive_part_wh(left, right, hours),
            deficit_wh=positive_part_wh(-left, -right, hours),
            of_avionics_wh=_deficit_wh(spare_w, hours),
            room_wh=room_w * sunlit_h,
            sunlit_h=sunlit_h,
            early=np.where(left < 0.0, 1.0, 0.0),
        )

    def _moves(
        self, stored: Stored, power: Power, place: Place | None, phases: _Phases, hours: FloatArray
    ) -> Moves:
        """Early deficit, surplus (charge, then climb), late deficit; none where there is none."""
        first = second = None
        climb = charged_wh = left_over = lifted_wh = self._nothing
        if phases.begins_short:
            early = power.early if phases.has_surplus else None
            first = self._drawn(stored, power, place, early, hours)
            stored = first.end
        if phases.has_surplus:
            energy, potential = stored
            charged = self.store.charged(energy, power.surplus_wh, hours)
            charged_wh = charged - energy
            left_over = power.surplus_wh - charged_wh / self.store.charge_efficiency
            usable = self._usable_wh(energy, charged, power.surplus_wh, left_over, hours)
            if np.count_nonzero(usable):
                # What climbs does so all the time of the surplus, up to the ceiling.
                wanted = np.minimum(usable, power.room_wh)
                eta = self._gain(place, wanted, power.sunlit_h)
                to_ceiling = (self.potential_max_wh - potential) / eta
                climb = np.maximum(np.minimum(wanted, to_ceiling), self._nothing)
                lifted_wh = eta * climb
                potential = potential + lifted_wh
            stored = Stored(charged, potential)
        if phases.ends_short:
            second = self._drawn(stored, power, place, 1.0 - power.early, hours)
            stored = second.end
        return Moves(first, charged_wh, left_over, climb, lifted_wh, second, stored)

    def _usable_wh(
        self,
        energy: FloatArray,
        charged: FloatArray,
        surplus: FloatArray,
        left_over: FloatArray,
        hours: FloatArray,
    ) -> FloatArray:
        """Part of the left-over surplus that the strategy lets climb [Wh]."""
        if self.strategy == "surplus":
            return left_over
        full = charged >= self.counts_as_full_wh
        clock = self.store.clock
        if clock is None or not np.count_nonzero(full & (energy < self.counts_as_full_wh)):
            return np.where(full, left_over, 0.0)
        # In the step that fills the battery, only what comes after that instant; a step that
        # counted as a whole would make the day's gain jump with the state of charge.
        soc = np.minimum(energy / self.store.battery_energy_wh, 1.0)
        after = np.clip(1.0 - clock.hours_to_full(soc) / hours, 0.0, 1.0)
        usable = np.where(energy < self.counts_as_full_wh, after * surplus, left_over)
        return np.where(full, np.minimum(left_over, usable), 0.0)

    def _drawn(
        self,
        stored: Stored,
        power: Power,
        place: Place | None,
        share: FloatArray | None,
        hours: FloatArray,
    ) -> Drawn:
        """Meet a share of a deficit, or all: what the motor lacks by sinking first.

        All else comes from the battery.
        """
        energy, potential = stored
        deficit, of_avionics = power.deficit_wh, power.of_avionics_wh
        if share is not None:
            deficit, of_avionics = share * deficit, share * of_avionics
            hours = share * (hours - power.sunlit_h)
        saved = np.maximum(deficit - of_avionics, self._nothing)
        sinks = self._gain(place, -saved, hours)
        glide = np.minimum(saved, potential / sinks)
        sunk = sinks * glide
        wanted = deficit - glide
        eta = self.store.discharge_efficiency
        drawn = np.minimum(wanted / eta, energy)
        # Rounding must leave no potential energy that is none.
        lower = np.maximum(potential - sunk, self._nothing)
        unserved = np.maximum(wanted - eta * drawn, self._nothing)
        return Drawn(Stored(energy - drawn, lower), drawn, glide, sunk, unserved)


class _Phases(NamedTuple):
    """Which phases of a step any element has."""

    begins_short: bool
    has_surplus: bool
    ends_short: bool


def _phases(power: Power) -> _Phases:
    short = power.deficit_wh > _ZERO
    if not np.count_nonzero(short):
        return _Phases(begins_short=False, has_surplus=True, ends_short=False)
    if not np.count_nonzero(power.surplus_wh):
        return _Phases(begins_short=True, has_surplus=False, ends_short=False)
    early = power.early > 0.0
    return _Phases(bool((short & early).any()), True, bool((short & ~early).any()))


def at_nodes(values: FloatArray) -> FloatArray:
    """Values at the nodes from those at both ends of every step, elements first."""
    return np.concatenate([values[:, 0], values[-1:, 1]]).T


def _inverse(rises_wh: FloatArray) -> FloatArray:
    return 1.0 / np.where(rises_wh > 0.0, rises_wh, np.inf)


def _between(below: FloatArray, above: FloatArray, share: FloatArray) -> FloatArray:
    return np.asarray(below + share * (above - below))


def _deficit_wh(power_w: FloatArray, hours: FloatArray) -> FloatArray:
    """What powers at both ends of steps are below zero, over some hours [Wh]."""
    if np.count_nonzero(power_w < _ZERO) == power_w.size:
        return -mean_of_ends(power_w) * hours
    return positive_part_wh(-power_w[..., 0, :], -power_w[..., 1, :], hours)


def _surplus_share(left: FloatArray, right: FloatArray) -> FloatArray:
    """Share of a step in which a power that is linear over it is not negative."""
    crossing = crossing_fraction(left, right)
    begin = np.where(left < 0.0, np.where(right < 0.0, 1.0, crossing), 0.0)
    end = np.where((right < 0.0) & (left >= 0.0), crossing, 1.0)
    return end - begin
