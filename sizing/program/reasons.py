"""What holds a sizing back, and why there is no design: what is missed, by how much, in words.

Multipliers of the program's solution tell what holds back. Where there is no design the elastic
program tells what the design misses that comes nearest; its simulated flight tells what the
energy of its worst day lacks.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.held_station import POWER_AGAINST_WIND
from sizing.limits import MASS_BUDGET, ROW_TOLERANCE, design_requirements
from sizing.mass_budget import parametric_design
from sizing.parameters import with_parameter
from sizing.performance import Performance
from sizing.program.corrections import day_of
from sizing.program.intervals import deficit_wh
from sizing.program.objectives import Objective
from sizing.program.result import Violation
from sizing.program.solve import LACKING, Solution, within_reach
from sizing.program.start import grid_of
from sizing.program.task import SizingTask
from sizing.program.transcription import RESERVE_SCALE_H
from sizing.program.variables import Role

# A requirement limits if its multiplier is at least this fraction of the largest one: what the
# barrier of interior points leaves on others is below 0.0035 of it.
LIMITING_FRACTION = 5e-3
PERCENT = 0.01
# Masses that a design might have, as multiples of its payload and battery.
_HEAVIER = np.geomspace(1.0, 100.0, 9)


class Limit(NamedTuple):
    """What holds a solution back.

    ``multiplier``: change of the cost per relative change of the limit, or for ten hours.
    ``gain``: of the cost, where it is eased by ``step``.
    """

    name: str
    multiplier: float
    gain: float
    step: str


def limits_of(solution: Solution) -> list[Limit]:
    """Return what holds a solution back; those come first whose easing gains most."""
    label, program = solution.task.day.scenarios.label, solution.program
    strengths: defaultdict[tuple[str, str], float] = defaultdict(float)

    for row in program.constraints:
        if row.block is None and not row.equation:
            strengths[row.name, "1 % of the limit"] += solution.multiplier(row.name, None)
    by_hour = solution.by_hour()
    for block, scenario in enumerate(solution.linearisation.known):
        where = f" ({label(scenario)})"
        full = solution.full(block)
        capacity = solution.multiplier("battery_capacity", block)
        # What the day returns is worth what the next night is, less what the battery has no room
        # for.
        returned = solution.multiplier("energy_balance", block) - capacity
        of_battery = "1 % of the battery's capacity"
        strengths["battery_capacity" + where, of_battery] += full * capacity
        strengths["energy_balance" + where, of_battery] += full * max(returned, 0.0)
        strengths["excess_time" + where, "1 h"] += by_hour[block] * RESERVE_SCALE_H
        for name, named in (("continuous", "always_lit"), (POWER_AGAINST_WIND,) * 2):
            strengths[named + where, "1 % of the limit"] += solution.multiplier(name, block)
    bounds = solution.bound_multipliers[program.parts["design"]]  # positive at an upper one
    for v, multiplier in zip(solution.task.variables, bounds, strict=True):
        free = v.role is Role.design or v.name in solution.task.free_names
        low, high = within_reach(solution.task, solution.linearisation, v)
        end, own = (
            ("maximum", v.maximum == high) if multiplier > 0.0 else ("minimum", v.minimum == low)
        )
        if free and own and v.minimum < v.maximum:
            strengths[f"{v.name} at its {end}", "1 % of the bound"] += abs(float(multiplier))
    least = LIMITING_FRACTION * max(strengths.values(), default=0.0)
    shares = {"1 h": 1.0 / RESERVE_SCALE_H}
    limits = [
        Limit(name, strength, strength * shares.get(step, PERCENT), step)
        for (name, step), strength in strengths.items()
        if strength > least
    ]
    return sorted(limits, key=lambda limit: -limit.gain)


def least_mission(aircraft: Aircraft, mission: Mission, objective: Objective) -> Mission:
    """Return the easiest mission: without the payload that is to be as large as possible."""
    if objective.payload_key is None:
        return mission
    return with_parameter(aircraft, mission, objective.payload_key, 0.0)[1]


def violations(
    task: SizingTask, nearest: Performance, missed: Mapping[str, float]
) -> tuple[Violation, ...]:
    """Return missed requirements in words.

    ``missed``: shortfall by name of the requirement: relative, or in hours of excess time.
    """
    worst, required_h = nearest.worst_scenario(), task.required_h
    with np.errstate(invalid="ignore"):  # the nearest design may be impossible
        rows = design_requirements(task.simulated_aircraft, nearest.design)
    where = nearest.day.scenarios.label(worst)
    left_h = float(nearest.cycle.excess_time_h[worst])
    flown = f"an excess time of {required_h:g} h is out of reach at {where}: the nearest design"
    flown = f"{flown} has {left_h:.2f} h"
    if task.window_h is not None:
        flown = f"no design lands at {where} with {required_h:g} h left: the nearest one "
        flown += f"has {left_h:.2f} h" if left_h > 0.0 else f"lacks power for {-left_h:.2f} h"
    texts = {row.name: row.text for row in rows} | {
        "battery_capacity": f"the battery cannot carry the night at {where}: short by {{missed}} "
        "of its capacity",
        "energy_balance": f"the day does not recharge the battery at {where}: short by {{missed}} "
        "of its capacity",
        "sun": f"polar night: the sun never rises at {where}",
        POWER_AGAINST_WIND: f"flight as fast as the wind at {where} takes {{missed}} more than the "
        "rated power",
        "excess_time": flown,
    }
    missing = []
    for name, shortfall in missed.items():
        percent = f"{100.0 * shortfall:.0f} %" if shortfall > 0.1 else f"{100.0 * shortfall:.2g} %"
        missing.append(Violation(name, shortfall, texts[name].format(missed=percent)))
    return tuple(missing)


def missed_by(
    task: SizingTask, solution: Solution | None, nearest: Performance
) -> dict[str, float]:
    """Return what the nearest design misses, relative; of energy, to the battery's capacity."""
    if task.has_polar_night:
        return {"sun": 1.0}
    if not np.isfinite(float(np.ravel(nearest.design.total_mass_kg)[0])):
        least = 0.0 if solution is None else solution.missed.get(MASS_BUDGET, 0.0)
        if least:
            return {MASS_BUDGET: least}
        # Part of its own mass that no design of the grid can lift, at whatever mass it has.
        designs, conditions = grid_of(task.aircraft), task.conditions
        designs = designs.mapped(lambda v: np.asarray(v)[:, np.newaxis])
        least_kg = float(conditions.payload_mass_kg) + np.asarray(designs.battery_mass_kg)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            design = parametric_design(task.aircraft, conditions, designs, least_kg * _HEAVIER)
            unlifted = np.asarray(design.masses.total_kg) / (least_kg * _HEAVIER) - 1.0
        least = float(np.min(unlifted, initial=math.inf, where=np.isfinite(unlifted)))
        return {MASS_BUDGET: max(least, ROW_TOLERANCE)}
    missed = {} if solution is None else dict(solution.missed)
    if solution is None or solution.lack.max() > LACKING or not missed:
        missed |= _energy_missed(task, solution, nearest)
    return missed


def _energy_missed(
    task: SizingTask, solution: Solution | None, nearest: Performance
) -> dict[str, float]:
    """Return what the battery lacks for the worst night, and what the next day does not return."""
    worst = nearest.worst_scenario()
    if task.window_h is not None:
        return {"excess_time": task.required_h - float(nearest.cycle.excess_time_h[worst])}
    day, store = day_of(task, nearest, worst), nearest.store.flat((task.count,))
    store = store.select(np.array([worst]))
    full_wh = float(store.battery_energy_wh[0])
    needed = deficit_wh(day) / task.aircraft.battery.mean_discharge_efficiency / full_wh
    path = day.path(store, max(1.0 - needed, 0.0))
    fullest = int(np.argmax(path))
    returned = float(path[fullest] - path[: fullest + 1].min())
    missed = {"battery_capacity": needed - 1.0}
    if returned < min(needed, 1.0) - LACKING:  # a larger battery would be no fuller
        missed["energy_balance"] = needed - returned
    missed = {name: short for name, short in missed.items() if short > LACKING}
    if not missed:  # over many days
        lack = LACKING if solution is None else max(float(solution.lack.max()), LACKING)
        missed = {"energy_balance": lack * 24.0 * float(np.mean(day.load_w)) / full_wh}
    return missed
