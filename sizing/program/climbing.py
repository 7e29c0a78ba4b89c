"""Flight along a height profile that the program has chosen.

The simulator flies the profile like any other load: light and power of level flight at the height
of the moment, linear between levels at most 500 m apart, and ``m g dz/dt`` over the efficiency.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from sizing.altitude.climb_levels import FlightLevels, flight_levels
from sizing.design import Design, DesignVariables, parametric_design
from sizing.energy.battery import Store
from sizing.held_station import flown_faster
from sizing.mass_budget import closed_design
from sizing.performance import Performance
from sizing.program.days import lagrange
from sizing.program.schedule import flown_along
from sizing.program.task import SizingTask, Values
from sizing.program.transcription import LEVELS
from solar.types import FloatArray


class Profile(NamedTuple):
    """Height over the way to the ceiling at times of a day [h], repeated."""

    clock_h: FloatArray
    share: FloatArray

    def at(self, time_h: FloatArray) -> FloatArray:
        """Share of the way to the ceiling at some times of the day."""
        return np.interp(time_h, self.clock_h % 24.0, self.share, period=24.0)


def flight(
    task: SizingTask, designs: list[Values], profiles: Mapping[int, Profile]
) -> tuple[Performance, FlightLevels | None]:
    """Fly designs in all scenarios, on missions with climbs along their profiles."""
    if task.mission.climb is None:
        return task.simulate(designs), None
    return climbing_performance(task.eased(designs[0]), designs, profiles)


def climbing_performance(
    task: SizingTask, designs: Sequence[Values], profiles: Mapping[int, Profile]
) -> tuple[Performance, FlightLevels]:
    """Fly designs in all scenarios along their profiles, at the floor where there is none."""
    chosen = [task.design_variables(values).chosen() for values in designs]
    stacked = {name: np.array([float(one[name]) for one in chosen]) for name in chosen[0]}
    design = closed_design(task.flown, task.mission, DesignVariables(**stacked))
    levels = flight_levels(task.flown, task.mission, design, task.day)
    time_h, shape = task.day.time_h, (len(designs), task.count)
    share = np.zeros((task.count, len(time_h)))
    for number, profile in profiles.items():
        share[number] = profile.at(time_h)
    height_m = np.tile(share * task.climb_height_m, (len(designs), 1))
    energy_wh = np.asarray(design.battery_energy_wh)[:, np.newaxis]
    store = Store.of(task.aircraft.battery, energy_wh)
    flown = flown_along(time_h, levels, store.flat(shape), height_m)
    altitude_m, solar_w, load_w = (
        one.reshape(*shape, -1)
        for one in (levels.altitude_m[0] + flown.height_m, flown.solar_w, flown.load_w)
    )
    nominal_w, cycle = levels.nominal_load_w.reshape(shape), flown.cycle.reshaped(shape)
    perf = Performance(
        *(design, task.mission, task.solar, task.day, solar_w, load_w, nominal_w, store, cycle),
        altitude_m=altitude_m,
        levels=levels,
    )
    return perf, levels


def light_at_heights(levels: FlightLevels, scenario: int) -> FloatArray:
    """Specific power of the first design at the program's heights, ``(height, time)``."""
    heights_m = np.linspace(0.0, levels.altitude_m[-1] - levels.altitude_m[0], LEVELS)
    return levels.at_heights(scenario, heights_m)[0]


def power_beyond_floor(
    task: SizingTask, design: Design, number: int, heights: FloatArray, hours: FloatArray
) -> FloatArray:
    """Load above that of level flight at the floor, as the program has it [W].

    ``design``: a batch. ``heights``: at the nodes, over the way to the ceiling. Returns of shape
    ``(design, interval)``.
    """
    weights = lagrange((heights[1:] + heights[:-1]) / 2.0, LEVELS)[:, np.newaxis]
    flown = [
        parametric_design(task.flown, air, design.variables, design.total_mass_kg)
        for air in task.airs
    ]
    powers = [np.asarray(one.propulsion_power_w)[:, np.newaxis] for one in flown]
    if task.mission.holds_station:
        speeds = np.stack([np.asarray(one.airspeed_m_per_s)[:, np.newaxis] for one in flown])
        wind = np.sum(weights[:, 0] * task.winds_m_per_s[number][:, np.newaxis], axis=0)
        ratio = np.maximum(wind / np.exp(np.sum(weights * np.log(speeds), axis=0)), 1.0)
        powers = [
            flown_faster(task.flown, air, _spread(one), ratio).propulsion_power_w
            for air, one in zip(task.airs, flown, strict=True)
        ]
    table = np.log(np.stack(np.broadcast_arrays(*powers)))
    power_w, floor_w = np.exp(np.sum(weights * table, axis=0)), np.exp(table[0, :, :1])
    assert flown[0].chain is not None
    weight_n = np.asarray(design.total_mass_kg) * GRAVITY_M_PER_S2
    rate = np.diff(heights) * task.climb_height_m / (3600.0 * hours)
    climb_w = (weight_n / flown[0].chain.efficiency)[:, np.newaxis] * rate
    steady = 1.0 + task.mission.turbulence.all_day
    return np.asarray((power_w - floor_w) * steady + climb_w)


def _spread(design: Design) -> Design:
    """Designs with an axis for the intervals."""
    return design.mapped(lambda value: np.asarray(value)[..., np.newaxis])
