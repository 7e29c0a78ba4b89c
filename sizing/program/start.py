"""Where a sizing starts: the most promising design of a coarse grid."""

from __future__ import annotations

import numpy as np

from sizing.aircraft import Aircraft
from sizing.design import Design, DesignVariables
from sizing.limits import MASS_BUDGET, design_requirements
from sizing.mass_budget import closed_design
from sizing.program.objectives import Objective
from sizing.program.task import SizingTask
from solar.types import FloatArray

# Points of span, battery and modules each, by the number of other free variables.
_GRID_POINTS = (9, 7, 6)
_FEW_POINTS = 3
_ROUGHLY = 1e-3  # of masses, of which the grid is far coarser


def most_promising(task: SizingTask) -> DesignVariables:
    """Return the design of the grid that misses least; of those that miss nothing the best."""
    grid = grid_of(task.aircraft)
    aircraft = task.aircraft.with_airframe(propulsion=task.aircraft.propulsion.first_chain())
    with np.errstate(all="ignore"):
        design = closed_design(aircraft, task.conditions, grid, relative_tolerance=_ROUGHLY)
        missed = missed_by(task, design)
        ranks = {
            Objective.min_mass.variable: design.total_mass_kg,
            Objective.min_wingspan.variable: grid.wingspan_m,
            # What is stored lasts longest; and the largest design carries most.
            Objective.max_excess_time.variable: -np.asarray(design.battery_energy_wh)
            / np.asarray(design.nominal_load_w(task.mission)),
            Objective.max_payload_mass.variable: -np.asarray(design.total_mass_kg),
            Objective.max_payload_power.variable: -np.asarray(grid.module_area_m2),
        }
        rank = np.asarray(ranks.get(task.objective.variable, missed))
    best = int(np.lexsort((rank, missed))[0])
    return grid.mapped(lambda v: float(np.asarray(v)[best]))


def grid_of(aircraft: Aircraft) -> DesignVariables:
    """Return designs on a grid, even in their logarithm; a few values of what else is free."""
    space = aircraft.design_space
    others = [n for n in ("aspect_ratio", "lift_coefficient") if getattr(space, n) is not None]
    sizes = ("wingspan_m", "battery_mass_kg", "module_area_m2")
    points = dict.fromkeys(sizes, _GRID_POINTS[len(others)]) | dict.fromkeys(others, _FEW_POINTS)
    ends = {name: getattr(space, name) for name in points}
    axes = [np.geomspace(ends[name].minimum, ends[name].maximum, points[name]) for name in points]
    values = [axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")]
    designs = {"aspect_ratio": np.full(len(values[0]), aircraft.airframe.aspect_ratio)}
    return DesignVariables(**designs | dict(zip(points, values, strict=True)))


def missed_by(task: SizingTask, design: Design) -> FloatArray:
    """Return what closed designs miss of a day's energy and their requirements, relative.

    The battery must hold the night and the required excess time, the day return the night: on a
    flight from launch to landing nothing need be returned.
    """
    aircraft, day, battery = task.aircraft, task.day, task.aircraft.battery
    load_w = np.asarray(design.nominal_load_w(task.mission))[:, np.newaxis, np.newaxis]
    hourly = round(1.0 / float(day.time_h[1] - day.time_h[0]))
    light = day.specific_power_w_per_m2[:, :: min(max(hourly, 1), len(day.time_h) - 1)]
    step_h = day.time_h[-1] / (light.shape[-1] - 1)
    area = np.asarray(design.variables.module_area_m2)[:, np.newaxis, np.newaxis]
    net = area * light[..., :-1] - load_w
    if task.window_h is not None:
        hours = np.arange(light.shape[-1] - 1) * step_h
        net = net * ((hours >= task.window_h[:, :1]) & (hours < task.window_h[:, 1:]))
    surplus = battery.mean_charge_efficiency * np.maximum(net, 0.0).sum(axis=-1) * step_h
    deficit = np.maximum(-net, 0.0).sum(axis=-1) * step_h
    reserve = np.where(deficit > 0.0, task.goal_h, 0.0) * load_w[..., 0]
    out_of = battery.mean_discharge_efficiency
    capacity = out_of * np.asarray(design.battery_energy_wh)[:, np.newaxis]
    short = (deficit + reserve) / capacity - 1.0
    if task.window_h is None:
        short = np.maximum(short, deficit / out_of / (surplus + 1e-9) - 1.0)
    missed = np.maximum(short, 0.0).max(axis=-1)
    mass = np.asarray(design.total_mass_kg)
    heaviest = aircraft.design_space.maximum_total_mass_kg or np.inf
    missed = missed + np.maximum(mass / heaviest - 1.0, 0.0)
    for row in design_requirements(aircraft, design):
        if row.name != MASS_BUDGET:
            missed = missed + np.maximum(-np.asarray(row.value), 0.0)
    return np.where(np.isfinite(missed) & np.isfinite(mass), missed, np.inf)
