"""Flight along a height profile that the program has chosen.

The simulator flies the profile like any other load: light and power of level flight at the height
of the moment, linear between levels at most 500 m apart, and ``m g dz/dt`` over the efficiency.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from sizing.altitude.climb_levels import FlightLevels, flight_levels
from sizing.design import Design, parametric_design
from sizing.energy.battery import Store
from sizing.energy.cycle import simulate_cycle
from sizing.held_station import flown_faster
from sizing.mass_budget import closed_design
from sizing.performance import Performance
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


def climbing_performance(
    task: SizingTask, values: Values, profiles: Mapping[int, Profile]
) -> tuple[Performance, FlightLevels]:
    """Fly a design in all scenarios along their profiles, at the floor where there is none."""
    chosen = task.design_variables(values).mapped(lambda v: np.array([float(v)]))
    design = closed_design(task.flown, task.mission, chosen)
    levels = flight_levels(task.flown, task.mission, design, task.day)
    time_h, count = task.day.time_h, task.count
    share = np.zeros((count, len(time_h)))
    for number, profile in profiles.items():
        share[number] = profile.at(time_h)
    height_m = levels.altitude_m - levels.altitude_m[0]
    place = share * height_m[-1]
    light = _light(levels)
    power = np.broadcast_to(levels.propulsion_power_w[..., np.newaxis], light.shape)
    solar, motor = (
        np.stack([_interpolated(place[i], height_m, rows[:, i]) for i in range(count)])
        for rows in (light, power)
    )
    mass_kg, efficiency = float(np.ravel(design.total_mass_kg)[0]), levels.efficiency[0]
    rate = np.diff(place, axis=-1) / (3600.0 * np.diff(time_h))
    climb_w = mass_kg * GRAVITY_M_PER_S2 * rate / efficiency
    at_nodes = np.empty_like(place)
    at_nodes[:, 1:-1] = (climb_w[:, 1:] + climb_w[:, :-1]) / 2.0
    at_nodes[:, 0] = at_nodes[:, -1] = (climb_w[:, 0] + climb_w[:, -1]) / 2.0
    load = motor * levels.turbulence_factor + at_nodes + levels.constant_power_w[:, np.newaxis]
    solar = solar * levels.module_area_m2[:, np.newaxis]
    store = Store.of(task.aircraft.battery, np.reshape(design.battery_energy_wh, (1, 1)))
    powers = solar[np.newaxis], load[np.newaxis], levels.nominal_load_w[np.newaxis]
    cycle = simulate_cycle(time_h, *powers[:2], store, nominal_load_w=powers[2])
    perf = Performance(
        *(design, task.mission, task.solar, task.day, *powers, store, cycle),
        maximum_altitude_m=(levels.altitude_m[0] + place.max(axis=-1))[np.newaxis],
    )
    return perf, levels


def alone(perf: Performance) -> Performance:
    """Performance of the one design of a batch."""

    def first(value: Any) -> Any:
        if isinstance(value, tuple):  # design, variables, masses, energy budget
            return type(value)._make(first(one) for one in value)  # type: ignore[attr-defined]  # a NamedTuple
        if isinstance(value, np.ndarray) and value.ndim and value.shape[0] == 1:
            return value[0]
        return value

    cycle = perf.cycle
    names = [f.name for f in fields(cycle) if f.name != "time_h"]
    return replace(
        perf,
        design=perf.design._replace(
            **{k: first(v) for k, v in perf.design._asdict().items() if k != "chain"}
        ),
        solar_power_w=first(perf.solar_power_w),
        load_w=first(perf.load_w),
        nominal_load_w=first(perf.nominal_load_w),
        store=replace(perf.store, battery_energy_wh=first(perf.store.battery_energy_wh)),
        cycle=replace(cycle, **{name: first(getattr(cycle, name)) for name in names}),
        maximum_altitude_m=first(perf.maximum_altitude_m),
    )


def _light(levels: FlightLevels) -> FloatArray:
    """Specific power at all levels in the design's own flow, ``(level, scenario, time)``."""
    factors = [levels.cooling_factor(n) for n in range(len(levels.altitude_m))]
    pairs = zip(levels.specific_power_w_per_m2, factors, strict=True)
    return np.stack([power if f is None else power * f for power, f in pairs])


def _interpolated(place: FloatArray, known: FloatArray, rows: FloatArray) -> FloatArray:
    """Values of rows of levels at a place of their own at every time."""
    below = np.clip(np.searchsorted(known, place, side="right") - 1, 0, len(known) - 2)
    upper = (place - known[below]) / (known[below + 1] - known[below])
    at = np.arange(rows.shape[-1])
    return (1.0 - upper) * rows[below, at] + upper * rows[below + 1, at]


def light_at_heights(levels: FlightLevels, scenario: int) -> FloatArray:
    """Specific power of a scenario at the heights of the program, ``(height, time)``."""
    light, known = _light(levels)[:, scenario], levels.altitude_m
    heights = np.linspace(known[0], known[-1], LEVELS)
    return np.stack([_interpolated(np.full(light.shape[-1], h), known, light) for h in heights])


def lagrange(place: FloatArray, count: int) -> FloatArray:
    """Weights of evenly spaced nodes from 0 to 1 in the polynomial through them."""
    nodes = np.linspace(0.0, 1.0, count)
    rows = []
    for own in nodes:
        others = nodes[nodes != own]
        rows.append(np.prod([(place - other) / (own - other) for other in others], axis=0))
    return np.stack(rows)


def power_beyond_floor(
    task: SizingTask, design: Design, number: int, heights: FloatArray, hours: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Load above that of level flight at the floor in every interval, as the program has it [W].

    Also the logarithm of the airspeed over the design's own that holds the place.
    """
    steady = 1.0 + task.mission.turbulence.all_day
    middle = (heights[1:] + heights[:-1]) / 2.0
    weights = lagrange(middle, LEVELS)
    variables = design.variables
    flown = [
        parametric_design(task.flown, air, variables, design.total_mass_kg) for air in task.airs
    ]
    speeds = np.array([float(np.ravel(one.airspeed_m_per_s)[0]) for one in flown])
    faster = np.zeros(len(middle))
    if task.mission.holds_station:
        own = np.exp(weights.T @ np.log(speeds))
        wind = weights.T @ task.winds_m_per_s[number]
        faster = np.log(np.maximum(wind / own, 1.0))
        powers = [
            np.ravel(flown_faster(task.flown, air, one, np.exp(faster)).propulsion_power_w)
            for air, one in zip(task.airs, flown, strict=True)
        ]
        table = np.log(np.stack(powers))
    else:
        level_w = [float(np.ravel(one.propulsion_power_w)[0]) for one in flown]
        table = np.repeat(np.log(level_w)[:, np.newaxis], len(middle), axis=1)
    power_w = np.exp(np.sum(weights * table, axis=0))
    floor_w = np.exp(table[0, 0])
    assert flown[0].chain is not None
    weight_n = float(np.ravel(design.total_mass_kg)[0]) * GRAVITY_M_PER_S2
    rate = np.diff(heights) * task.climb_height_m / (3600.0 * hours)
    climb_w = weight_n * rate / float(np.ravel(flown[0].chain.efficiency)[0])
    return power_w * steady + climb_w - floor_w * steady, faster
