"""Where a sizing starts: the most promising design of a coarse grid."""

from __future__ import annotations

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, FlightConditions
from sizing.limits import EQUATIONS, design_requirements
from sizing.mass_budget import closed_design
from sizing.sunlight import SolarDay
from solar.types import FloatArray

# Points of span, battery and modules each, by the number of other free variables.
_GRID_POINTS = (9, 7, 6)
_FEW_POINTS = 3
_HOUR = 12  # steps of the day that are one here


def grid_of(aircraft: Aircraft) -> DesignVariables:
    """Designs on a grid, evenly spaced in their logarithm; a few values of what else is free."""
    space, airframe = aircraft.design_space, aircraft.airframe
    shape, lift = space.aspect_ratio, space.lift_coefficient
    points = _GRID_POINTS[(shape is not None) + (lift is not None)]
    axes = [
        np.geomspace(r.minimum, r.maximum, points)
        for r in (space.wingspan_m, space.battery_mass_kg, space.module_area_m2)
    ]
    axes.append(
        np.array([airframe.aspect_ratio])
        if shape is None
        else np.geomspace(shape.minimum, shape.maximum, _FEW_POINTS)
    )
    if lift is not None:
        axes.append(np.geomspace(lift.minimum, lift.maximum, _FEW_POINTS))
    span, battery, area, aspect, *rest = (v.ravel() for v in np.meshgrid(*axes, indexing="ij"))
    return DesignVariables(span, aspect, battery, area, *rest)


def most_promising(
    aircraft: Aircraft, mission: Mission, day: SolarDay, required_h: float, rank: FloatArray | None
) -> DesignVariables:
    """Design of the grid that misses least of an energy balance and its requirements.

    Of those that miss nothing the one of the least ``rank``.
    """
    grid = grid_of(aircraft)
    design = closed_design(aircraft, mission, grid)
    missed = missed_by(aircraft, mission, day, required_h, grid, design)
    best = int(np.argmin(missed)) if rank is None else int(np.lexsort((rank(design), missed))[0])
    return grid.mapped(lambda v: float(np.asarray(v)[best]))


def missed_by(aircraft, mission, day, required_h, grid, design) -> FloatArray:
    """What closed designs miss, relative: the night's charge, the day's return, requirements."""
    battery = aircraft.battery
    into, out_of = battery.mean_charge_efficiency, battery.mean_discharge_efficiency
    with np.errstate(all="ignore"):
        load_w = np.asarray(design.nominal_load_w(mission))[:, np.newaxis, np.newaxis]
        light = day.specific_power_w_per_m2[:, ::_HOUR]
        step_h = float(day.time_h[_HOUR] - day.time_h[0])
        net = np.asarray(grid.module_area_m2)[:, np.newaxis, np.newaxis] * light[..., :-1] - load_w
        surplus = np.maximum(net, 0.0).sum(axis=-1) * step_h
        deficit = np.maximum(-net, 0.0).sum(axis=-1) * step_h
        load_w = load_w[..., 0]
        full = np.asarray(design.battery_energy_wh)[:, np.newaxis]
        night = (deficit + required_h * load_w * (deficit > 0.0)) / (out_of * full)
        returned = (deficit / out_of) / np.maximum(into * surplus, 1e-9)
        missed = np.max(np.maximum(np.maximum(night, returned) - 1.0, 0.0), axis=-1)
        heaviest = aircraft.design_space.maximum_total_mass_kg or np.inf
        mass = np.asarray(design.total_mass_kg)
        missed = missed + np.maximum(mass / heaviest - 1.0, 0.0)
        conditions = FlightConditions.of(mission, aircraft)
        for row in design_requirements(aircraft, design, conditions.with_payload_of(grid)):
            if row.name not in EQUATIONS:
                missed = missed + np.maximum(-np.asarray(row.value), 0.0)
    return np.where(np.isfinite(missed) & np.isfinite(mass), missed, np.inf)
