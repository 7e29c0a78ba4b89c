"""Steps through a day with battery and potential-energy storage until the day repeats itself.

What a step does, and why, stands at the head of :mod:`sizing.altitude.climb_cycle`.
"""

from __future__ import annotations

from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from sizing.altitude.climb_chain import Place
from sizing.altitude.climb_levels import FlightLevels
from sizing.altitude.climb_run import DayRun, Drawn, Moves, Power, Record, Stored
from sizing.energy.battery import Store
from sizing.energy.battery_voltage import FIRST_CHARGE
from sizing.energy.cycle import FULL
from sizing.energy.power_balance import crossing_fraction, positive_part_wh
from solar.types import BoolArray, FloatArray, IntArray

Strategy = Literal["battery_full", "surplus"]

STEPS_PER_NODE = 5  # of the day's axis: 1 min


class March:
    """Steps through the day of aircraft in scenarios with both storages.

    ``levels``: the aircraft between the lowest altitude and the ceiling. ``steps_per_node``: steps
    in one of the day's axis. ``bus_v``: voltages at the nodes of the steps, ``(node, element)``, by
    which a propulsion has the efficiency of the moment; by default those of a half charged battery.
    ``nominal_w``: load that equal power and excess time count by; by default that at the lowest
    altitude without thermals.
    """

    def __init__(
        self,
        time_h: FloatArray,
        levels: FlightLevels,
        store: Store,
        strategy: Strategy,
        steps_per_node: int,
        *,
        bus_v: FloatArray | None = None,
        nominal_w: FloatArray | None = None,
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
        for number in range(light.shape[1]):
            factor = levels.cooling_factor(number)
            if factor is not None:
                light[:, number] *= factor.T
        self.solar_at = (light * levels.module_area_m2).reshape(len(light), -1)
        self.factor = levels.turbulence_factor.T[:, levels.scenario]
        self.counts_as_full_wh = FULL * store.battery_energy_wh
        self.hours = np.repeat(np.diff(self.node_h) / steps_per_node, steps_per_node)[:, np.newaxis]
        self._hours = [float(hours) for hours in self.hours[:, 0]]
        chain, shape = levels.chain, (len(self._hours) + 1, self.count)
        if chain is not None:
            # Rows of the propulsion's tables at the levels, which designs share.
            rows = np.arange(len(levels.altitude_m))[:, np.newaxis] * chain.count + levels.design
            self.row_at, self.thrust_at = rows.ravel(), levels.thrust_power_w.ravel()
            if bus_v is None:
                bus_v = np.full(shape, float(chain.voltage_of(np.array(FIRST_CHARGE))))
            self.volts = chain.places(bus_v)
            if nominal_w is None:
                at = self.volts.at(0)
                thrust = chain.power_w(rows[0], at, levels.nominal_factor)
                nominal_w = thrust + levels.constant_power_w
        self.bus_v = bus_v
        self.nominal_w = levels.nominal_load_w if nominal_w is None else nominal_w

    def select(self, some: IntArray | BoolArray) -> March:
        """Steps of some of the elements."""
        levels, store = self.levels.select(some), self.store.select(some)
        bus_v = None if self.bus_v is None else self.bus_v[:, some]
        given = (self.node_h, levels, store, self.strategy, self.steps_per_node)
        return March(*given, bus_v=bus_v, nominal_w=self.nominal_w[some])

    def at_voltages(self, bus_v: FloatArray, nominal_w: FloatArray) -> March:
        """Steps of the same flights with other voltages, and with the nominal load by them."""
        given = (self.node_h, self.levels, self.store, self.strategy, self.steps_per_node)
        return March(*given, bus_v=bus_v, nominal_w=nominal_w)

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
        while number < len(self._hours):
            at_floor = not (stored.potential_wh.any() or before.any())
            until = self._dark_until[number]
            if at_floor and until > number >= all_fly:
                stored = self._discharged(stored, slice(number, until), run)
                before, number = stored.potential_wh, until
                continue
            place = None
            if at_floor:
                power, phases = self._floor_steps[number]
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
        chain = self.levels.chain
        if chain is None:
            motor_w = self.motor_at[floor]
            return self._balance(ends[0], ends[1], motor_w * ends[2], motor_w * ends[3], self.hours)
        row = self.row_at[floor]
        here, there = self.volts.at(slice(None, -1)), self.volts.at(slice(1, None))
        motors = chain.power_w(row, here, ends[2]), chain.power_w(row, there, ends[3])
        return self._balance(ends[0], ends[1], *motors, self.hours, chain.most_w(row, here))

    @cached_property
    def floor_thrust_w(self) -> FloatArray:
        """Thrust power of level flight at the lowest altitude in every step [W]; 0 by constants."""
        if self.levels.chain is None:
            return np.zeros((len(self._hours), self.count))
        node, part = np.divmod(np.arange(len(self._hours)), self.steps_per_node)
        middle = ((part + 0.5) / self.steps_per_node)[:, np.newaxis]
        factor = self.factor[node] + (self.factor[node + 1] - self.factor[node]) * middle
        return np.asarray(self.thrust_at[: self.count] * factor)

    def _floor_place(self, number: int, power: Power) -> Place:
        """Where a step at the lowest altitude is flown."""
        chain, row, volts = self.levels.chain, self.row_at[: self.count], self.volts.at(number)
        assert chain is not None
        thrust_w = self.floor_thrust_w[number]
        motor_w = (power.motor_left_w + power.motor_right_w) / 2.0
        return Place(chain, row, row, self._nothing, volts, motor_w, thrust_w)

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
        node, part = divmod(number, self.steps_per_node)
        potential_wh = np.minimum(np.maximum(potential_wh, 0.0), self.potential_max_wh)
        below = (potential_wh >= self.thresholds_wh).sum(axis=0) * self.count + self.places
        above = below + self.count
        upper = (potential_wh - self.potential_at[below]) * self.per_wh[below]
        lower = 1.0 - upper
        here, there = self.solar_at[node], self.solar_at[node + 1]
        left = lower * here[below] + upper * here[above]
        right = lower * there[below] + upper * there[above]
        first, last = self.factor[node], self.factor[node + 1]
        if self.steps_per_node > 1:
            a, b = part / self.steps_per_node, (part + 1) / self.steps_per_node
            left, right = left + (right - left) * a, left + (right - left) * b
            first, last = first + (last - first) * a, first + (last - first) * b
        hours, chain = self._hours[number], self.levels.chain
        if chain is None:
            motor_w = lower * self.motor_at[below] + upper * self.motor_at[above]
            return self._balance(left, right, motor_w * first, motor_w * last, hours), None
        rows = np.array([self.row_at[below], self.row_at[above]])[:, np.newaxis]
        volts = self.volts.at(slice(number, number + 2))
        motors = chain.power_w(rows, volts, np.array([first, last]))
        motor_left, motor_right = lower * motors[0] + upper * motors[1]
        thrust_w = lower * self.thrust_at[below] + upper * self.thrust_at[above]
        place = Place(
            *(chain, self.row_at[below], self.row_at[above], upper, volts.at(0)),
            motor_w=(motor_left + motor_right) / 2.0,
            thrust_w=thrust_w * (first + last) / 2.0,
        )
        most_w = lower * chain.most_w(place.below, place.volts)
        most_w = most_w + upper * chain.most_w(place.above, place.volts)
        return self._balance(left, right, motor_left, motor_right, hours, most_w), place

    def _gain(self, place: Place | None, more_w: FloatArray) -> FloatArray:
        """Thrust power that the motor's power beyond level flight's gives, over that power [-].

        ``more_w``: below zero for less than level flight's.
        """
        return self.levels.efficiency if place is None else place.gain(more_w)

    def _balance(
        self,
        solar_left: FloatArray,
        solar_right: FloatArray,
        motor_left: FloatArray,
        motor_right: FloatArray,
        hours: float | FloatArray,
        most_w: FloatArray | None = None,
    ) -> Power:
        """Surplus and deficit of one step, or of a column of steps."""
        constant = self.levels.constant_power_w
        left = solar_left - motor_left - constant
        right = solar_right - motor_right - constant
        sunlit_h = hours * _surplus_share(left, right)
        rated_w = self.levels.maximum_power_w
        most_w = rated_w if most_w is None else np.minimum(rated_w, most_w)
        room_w = most_w - (motor_left + motor_right) / 2.0
        return Power(
            *(solar_left, solar_right, motor_left, motor_right),
            surplus_wh=positive_part_wh(left, right, hours),
            deficit_wh=positive_part_wh(-left, -right, hours),
            of_avionics_wh=positive_part_wh(constant - solar_left, constant - solar_right, hours),
            room_wh=np.maximum(room_w, 0.0) * sunlit_h,
            sunlit_h=sunlit_h,
            early=np.where(left < 0.0, 1.0, 0.0),
        )

    def _moves(
        self, stored: Stored, power: Power, place: Place | None, phases: _Phases, hours: float
    ) -> Moves:
        """Early deficit, surplus (charge, then climb), late deficit; none where there is none."""
        first = second = None
        climb = charged_wh = left_over = lifted_wh = self._nothing
        if phases.begins_short:
            first = self._drawn(stored, power, place, power.early, hours)
            stored = first.end
        if phases.has_surplus:
            energy, potential = stored
            charged = self.store.charged(energy, power.surplus_wh, hours)
            charged_wh = charged - energy
            left_over = power.surplus_wh - charged_wh / self.store.charge_efficiency
            usable = self._usable_wh(energy, charged, power.surplus_wh, left_over, hours)
            # What climbs does so all the time of the surplus, up to the ceiling.
            wanted = np.minimum(usable, power.room_wh)
            eta = self._gain(place, _mean_w(np.maximum(wanted, 0.0), power.sunlit_h))
            climb = self._climb_wh(potential, wanted, eta)
            lifted_wh = eta * climb
            stored = Stored(charged, potential + lifted_wh)
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
        self, potential: FloatArray, wanted_wh: FloatArray, eta: FloatArray
    ) -> FloatArray:
        """Electric energy spent on climbing [Wh]."""
        to_ceiling = (self.potential_max_wh - potential) / eta
        return np.asarray(np.maximum(np.minimum(wanted_wh, to_ceiling), 0.0))

    def _drawn(
        self, stored: Stored, power: Power, place: Place | None, share: FloatArray, hours: float
    ) -> Drawn:
        """Meet a deficit: what the motor lacks by sinking first, all else from the battery."""
        energy, potential = stored
        deficit = share * power.deficit_wh
        of_motor = deficit - share * power.of_avionics_wh
        saved = np.maximum(of_motor, 0.0)
        sinks = self._gain(place, -_mean_w(saved, share * (hours - power.sunlit_h)))
        glide = np.minimum(saved, potential / sinks)
        sunk = sinks * glide
        wanted = deficit - glide
        eta = self.store.discharge_efficiency
        drawn = np.minimum(wanted / eta, energy)
        # Rounding must leave no potential energy that is none.
        lower = np.maximum(potential - sunk, 0.0)
        unserved = np.maximum(wanted - eta * drawn, 0.0)
        return Drawn(Stored(energy - drawn, lower), drawn, glide, sunk, unserved)


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


def _inverse(rises_wh: FloatArray) -> FloatArray:
    return 1.0 / np.where(rises_wh > 0.0, rises_wh, np.inf)


def _mean_w(energy_wh: FloatArray, hours: FloatArray) -> FloatArray:
    """Power of an energy over some hours [W]; none without any."""
    return np.asarray(energy_wh / np.where(hours > 0.0, hours, np.inf))


def _surplus_share(left: FloatArray, right: FloatArray) -> FloatArray:
    """Share of a step in which a power that is linear over it is not negative."""
    low, high = np.minimum(left, right), np.maximum(left, right)
    if low.min() >= 0.0 or high.max() < 0.0:  # most steps: nothing changes its sign
        return np.where(high < 0.0, 0.0, 1.0)
    crossing = crossing_fraction(left, right)
    begin = np.where(left < 0.0, np.where(right < 0.0, 1.0, crossing), 0.0)
    end = np.where((right < 0.0) & (left >= 0.0), crossing, 1.0)
    return end - begin
