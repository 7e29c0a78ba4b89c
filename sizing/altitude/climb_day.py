"""The day that repeats itself with battery and potential-energy storage, and its metrics.

What a step of it does, and why, stands at the head of :mod:`sizing.altitude.climb_cycle`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sizing.altitude import climb_march
from sizing.altitude.climb_levels import FlightLevels
from sizing.altitude.climb_march import March, Strategy
from sizing.altitude.climb_repetition import repeated_day
from sizing.energy.battery import Store
from sizing.energy.cycle import Cycle, EnergyBudget, EqualPower, cycle_of, equal_power, joined
from sizing.energy.power_balance import blocks
from solar.types import FloatArray

_ELEMENTS_AT_ONCE = 512  # so that the arrays of a day stay near the processor


@dataclass(frozen=True)
class ClimbEnergyBudget:
    """Where the energy of one cycle goes [Wh]; arrays of the scenarios.

    ``solar + unserved = constant_load + level_flight + propulsion_loss + stored + stored_potential
    + charge_loss + discharge_loss + curtailed``. ``level_flight`` is drag times airspeed, whether
    the motor or a descent provides it; ``climb_electric`` and ``glide_potential`` are parts of the
    flows: electric energy spent on climbing, potential energy given back.
    """

    solar_wh: FloatArray
    unserved_wh: FloatArray
    constant_load_wh: FloatArray
    level_flight_wh: FloatArray
    propulsion_loss_wh: FloatArray
    stored_wh: FloatArray
    stored_potential_wh: FloatArray
    charge_loss_wh: FloatArray
    discharge_loss_wh: FloatArray
    curtailed_wh: FloatArray
    climb_electric_wh: FloatArray
    glide_potential_wh: FloatArray


@dataclass(frozen=True)
class ClimbCycle:
    """Converged cycles with potential-energy storage.

    ``cycle`` has the metrics of :mod:`sizing.energy.cycle`, on the nodes of the day, with two
    extensions: excess time counts the glide from whatever altitude is left at the morning's equal
    power before the battery takes over, and the load is what motor and avionics draw in fact.
    Arrays of the trajectory have the shape ``(scenario, step)`` with the nodes ``time_h``; power is
    the mean of the step that begins there. ``gliding_h`` is the time of sinking after the last
    climb of the day.
    """

    cycle: Cycle
    energy_budget: ClimbEnergyBudget
    time_h: FloatArray
    altitude_m: FloatArray
    energy_wh: FloatArray
    potential_energy_wh: FloatArray
    solar_power_w: FloatArray
    load_w: FloatArray
    gliding_h: FloatArray

    @property
    def maximum_altitude_m(self) -> FloatArray:
        """Highest altitude of the day [m]."""
        return np.asarray(self.altitude_m.max(axis=-1))

    @property
    def maximum_potential_energy_wh(self) -> FloatArray:
        """Largest potential energy of the day [Wh]."""
        return np.asarray(self.potential_energy_wh.max(axis=-1))

    @property
    def nodes(self) -> slice:
        """Steps of the trajectory that begin at a node of the day's axis."""
        return slice(None, None, (len(self.time_h) - 1) // (len(self.cycle.time_h) - 1))


def simulate_climb(
    time_h: FloatArray,
    levels: FlightLevels,
    store: Store,
    strategy: Strategy,
    *,
    steps_per_node: int | None = None,
) -> ClimbCycle:
    """Converge the cycle with potential-energy storage and measure it.

    ``time_h``: nodes over one day, 0 to 24 [h], both ends included. ``levels``: solar power,
    propulsion power and potential energy over altitude; ``store``: batteries of its elements.
    Returns arrays of the elements.
    """
    steps = climb_march.STEPS_PER_NODE if steps_per_node is None else steps_per_node
    return Day(March(time_h, levels, store, strategy, steps)).result()


def cycles_with_climb(
    time_h: FloatArray, levels: FlightLevels, store: Store, strategy: Strategy
) -> tuple[Cycle, FloatArray]:
    """Metrics of many days with potential-energy storage, one step from node to node.

    Of 247 days, steps of 5 min are within 0.02 h of excess time of those of 1 min. Returns cycles,
    and the highest altitude of each [m].
    """
    parts, highest_m = [], []
    for some in blocks(len(levels.scenario), _ELEMENTS_AT_ONCE):
        day = Day(March(time_h, levels.select(some), store.select(some), strategy, 1))
        parts.append(day.cycle())
        highest_m.append(day.maximum_altitude_m())
    return joined(parts), np.concatenate(highest_m)


class Day:
    """Trajectory, flows and metrics of the day that repeats itself; time is the first axis."""

    def __init__(self, march: March) -> None:
        self.march, self.time_h, self.run = march, march.time_h, repeated_day(march)
        self.energy, self.potential = self.run.energy_wh, self.run.potential_wh

    def result(self) -> ClimbCycle:
        """Metrics of the whole day."""
        levels = self.march.levels
        return ClimbCycle(
            cycle=self.cycle(),
            energy_budget=self.energy_budget,
            time_h=self.time_h,
            altitude_m=levels.altitude_at(self.potential.T),
            energy_wh=self.energy.T.copy(),
            potential_energy_wh=self.potential.T.copy(),
            solar_power_w=_closed(self.run.power.solar_w[:, 0]),
            load_w=_closed(self.run.motor_wh / self.march.hours + levels.constant_power_w),
            gliding_h=_gliding_h(self.time_h, self.potential),
        )

    def maximum_altitude_m(self) -> FloatArray:
        """Highest altitude of the day [m]."""
        highest_wh = self.potential.max(axis=0)
        return self.march.levels.altitude_at(highest_wh[:, np.newaxis])[:, 0]

    @cached_property
    def energy_budget(self) -> ClimbEnergyBudget:
        """Where the energy goes."""
        run, march = self.run, self.march
        charged_wh, level_wh, lifted_wh, sunk_wh = (
            one.sum(axis=0) for one in (run.charged, run.level_thrust_wh, run.lifted, run.sunk)
        )
        discharge_loss = 1.0 - march.store.discharge_efficiency
        return ClimbEnergyBudget(
            solar_wh=run.solar_wh.sum(axis=0),
            unserved_wh=run.unserved.sum(axis=0),
            constant_load_wh=24.0 * march.levels.constant_power_w,
            level_flight_wh=level_wh,
            propulsion_loss_wh=run.motor_wh.sum(axis=0) - level_wh - lifted_wh + sunk_wh,
            stored_wh=self.energy[-1] - self.energy[0],
            stored_potential_wh=self.potential[-1] - self.potential[0],
            charge_loss_wh=charged_wh * (1.0 / march.store.charge_efficiency - 1.0),
            discharge_loss_wh=run.drawn.sum(axis=0) * discharge_loss,
            curtailed_wh=(run.left_over - run.climb).sum(axis=0),
            climb_electric_wh=run.climb.sum(axis=0),
            glide_potential_wh=sunk_wh,
        )

    @cached_property
    def _equal(self) -> EqualPower:
        """Instants at which the sun at the lowest altitude equals the nominal load."""
        march = self.march
        floor_w = march.solar_at[:, march.floor]
        return equal_power(march.node_h, floor_w - march.nominal_w)

    def cycle(self) -> Cycle:
        """Metrics of :mod:`sizing.energy.cycle`, with the altitude that is left at dawn."""
        march, budget = self.march, self.energy_budget
        battery_energy_wh, missing_h = march.store.battery_energy_wh, self.run.missing_h
        equal = self._equal
        of_cycle = EnergyBudget(
            solar_wh=budget.solar_wh,
            load_wh=budget.constant_load_wh + self.run.motor_wh.sum(axis=0),
            unserved_wh=budget.unserved_wh,
            stored_wh=budget.stored_wh,
            charge_loss_wh=budget.charge_loss_wh,
            discharge_loss_wh=budget.discharge_loss_wh,
            curtailed_wh=budget.curtailed_wh,
        )
        return cycle_of(
            *(equal, of_cycle, missing_h, self._reserve_h(equal.morning_h)),
            state_of_charge=self.energy.min(axis=0) / battery_energy_wh,
            full_h=self._full_h(),
            runs_empty=budget.unserved_wh > 1e-9 * battery_energy_wh,
            time_h=march.node_h,
            energy_wh=self.energy[:: march.steps_per_node].T.copy(),
        )

    def _reserve_h(self, dawn_h: FloatArray) -> FloatArray:
        """Hours that altitude and battery left at dawn would last without any sun.

        The aircraft glides first, while the battery feeds the avionics alone.
        """
        levels, eta = self.march.levels, self.march.store.discharge_efficiency
        at = np.where(np.isnan(dawn_h), 0.0, dawn_h)
        energy = _at_times(self.time_h, self.energy, at) * eta
        glide_h = levels.glide_h(_at_times(self.time_h, self.potential, at))
        for_avionics = levels.constant_power_w * glide_h
        with np.errstate(divide="ignore", invalid="ignore"):
            level_h = np.maximum(energy - for_avionics, 0.0) / self.march.nominal_w
            shortened = np.where(energy < for_avionics, energy / levels.constant_power_w, glide_h)
        return shortened + level_h

    def _full_h(self) -> tuple[FloatArray, FloatArray]:
        """First and last instant of full charge [h], NaN without one."""
        full = self.energy >= self.march.counts_as_full_wh
        ever = full.any(axis=0)
        first = self.time_h[np.argmax(full, axis=0)]
        last = self.time_h[len(full) - 1 - np.argmax(full[::-1], axis=0)]
        return np.where(ever, first, np.nan), np.where(ever, last, np.nan)


def _closed(power_w: FloatArray) -> FloatArray:
    """Power of the steps, elements first; that of the end is that of the beginning."""
    return np.concatenate([power_w, power_w[:1]]).T.copy()


def _at_times(time_h: FloatArray, values: FloatArray, at_h: FloatArray) -> FloatArray:
    """Columns of a trajectory, each at its own time."""
    below = np.clip(np.searchsorted(time_h, at_h, side="right") - 1, 0, len(time_h) - 2)
    columns = np.arange(values.shape[1])
    share = (at_h - time_h[below]) / (time_h[below + 1] - time_h[below])
    return np.asarray(values[below, columns] * (1.0 - share) + values[below + 1, columns] * share)


def _gliding_h(time_h: FloatArray, potential_wh: FloatArray) -> FloatArray:
    """Hours of sinking between the last climb of the day and the next one."""
    change = np.diff(potential_wh, axis=0)
    climbs = change > 0.0
    begun = np.logical_or.accumulate(climbs, axis=0)
    to_come = np.logical_or.accumulate(climbs[::-1], axis=0)[::-1]
    # The glide may last beyond midnight, to the first climb of the next day.
    gliding = (change < 0.0) & ~(begun & to_come) & climbs.any(axis=0)
    return np.asarray(np.diff(time_h) @ gliding)
