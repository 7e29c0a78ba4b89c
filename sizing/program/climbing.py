"""Flight along a height profile that the program has chosen.

The simulator flies the profile like any other load: light and power of level flight at the height
of the moment, linear between levels at most 500 m apart, and ``m g dz/dt`` over the efficiency.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from sizing.design import Design
from sizing.held_station import flight_faster
from sizing.mass_budget import closed_design, parametric_design
from sizing.performance import Performance, fly
from sizing.program.intervals import CutDay
from sizing.program.task import SizingTask, Values
from sizing.program.transcription import LEVELS, lagrange
from solar.types import FloatArray


class Profile(NamedTuple):
    """Height over the way to the ceiling at times of a day [h], repeated."""

    clock_h: FloatArray
    share: FloatArray

    def at(self, time_h: FloatArray) -> FloatArray:
        """Return the share of the way to the ceiling at times of the day."""
        return np.interp(time_h, self.clock_h % 24.0, self.share, period=24.0)


def simulate(
    task: SizingTask, designs: list[Values], profiles: Mapping[int, Profile]
) -> Performance:
    """Simulate designs in all scenarios; climbs along profiles, else at the floor."""
    design = closed_design(task.simulated_aircraft, task.mission, task.stacked(designs))
    return fly(
        task.simulated_aircraft,
        task.mission,
        task.solar,
        design,
        task.day,
        heights_m=heights_along(task, profiles, len(designs)),
    )


def heights_along(task: SizingTask, profiles: Mapping[int, Profile], count: int) -> FloatArray:
    """Return heights above the floor [m], ``(scenario, time)``, once for each of some designs.

    Zero without a profile.
    """
    height_m = np.zeros((task.count, len(task.day.time_h)))
    for number, profile in profiles.items():
        height_m[number] = profile.at(task.day.time_h) * task.climb_height_m
    return np.tile(height_m, (count, 1))


def power_beyond_floor(task: SizingTask, design: Design, number: int, day: CutDay) -> FloatArray:
    """Return the load above that of level flight at the floor, as the program has it [W].

    ``design``: a batch. Returns of shape ``(design, interval)``.
    """
    heights, hours = day.share, day.means.hours
    weights = np.stack(lagrange((heights[1:] + heights[:-1]) / 2.0, LEVELS))[:, np.newaxis]
    designs = [
        parametric_design(task.simulated_aircraft, air, design.variables, design.total_mass_kg)
        for air in task.airs
    ]
    powers = [np.asarray(it.propulsion_power_w)[:, np.newaxis] for it in designs]
    if task.mission.holds_station:
        speeds = np.stack([np.asarray(it.airspeed_m_per_s)[:, np.newaxis] for it in designs])
        wind = np.sum(weights[:, 0] * task.winds_m_per_s[number][:, np.newaxis], axis=0)
        ratio = np.maximum(wind / np.exp(np.sum(weights * np.log(speeds), axis=0)), 1.0)
        columns = (it.mapped(lambda v: np.asarray(v)[..., np.newaxis]) for it in designs)
        powers = [
            flight_faster(task.simulated_aircraft, air, it, ratio).propulsion_power_w
            for air, it in zip(task.airs, columns, strict=True)
        ]
    table = np.log(np.stack(np.broadcast_arrays(*powers)))
    power_w, floor_w = np.exp(np.sum(weights * table, axis=0)), np.exp(table[0, :, :1])
    assert designs[0].chain is not None
    weight_n = np.asarray(design.total_mass_kg) * GRAVITY_M_PER_S2
    rate = np.diff(heights) * task.climb_height_m / (3600.0 * hours)
    climb_w = (weight_n / designs[0].chain.efficiency)[:, np.newaxis] * rate
    steady = 1.0 + task.mission.turbulence.all_day
    return np.asarray((power_w - floor_w) * steady + climb_w)
