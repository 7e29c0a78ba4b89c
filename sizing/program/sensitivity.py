"""Sensitivity of an optimum to technology parameters, and the multipliers of its constraints.

By the envelope theorem the derivative of the best objective with respect to a parameter is that of
the Lagrangian, ``d f*/dp = df/dp + lambda dg/dp``, with the point and the multipliers held: no
sizing has to be repeated. The Lagrangian is differentiated by central differences; light and load
along the day are those of the design as it flies with the other parameter. It holds as long as no
constraint changes between active and inactive.

Source: Fiacco, A. V. (1983), Introduction to Sensitivity and Stability Analysis in Nonlinear
Programming.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import FINE_STEP_H, SolarDay, solar_day
from sizing.design import variable_keys
from sizing.parameters import build_scales, catalogue, parameter_value, with_parameter
from sizing.program.climbing import simulate
from sizing.program.corrections import Linearisation, Scenario, linearised, neighbours
from sizing.program.objectives import Objective
from sizing.program.reasons import limits_of
from sizing.program.result import SizingResult
from sizing.program.solve import Solution, parameters_of, solve
from sizing.program.task import SizingTask, Values
from sizing.program.transcription import build_program
from sizing.program.variables import TOTAL_MASS, WORST_EXCESS, Role, scales_of

# Of a parameter: in double precision differences are then good to about five digits.
_RELATIVE_STEP = 1e-5
# Multipliers below this are what the solver leaves of an inactive constraint.
LEAST_MULTIPLIER = 1e-5


@dataclass(frozen=True)
class Sensitivity:
    """Change of the best objective with one parameter.

    ``derivative`` is in units of the objective (h, m or kg) per unit of the parameter;
    ``elasticity`` the relative change of the objective per relative change of the parameter, None
    where one of them is zero.
    """

    parameter: str
    unit: str
    value: float
    derivative: float
    elasticity: float | None

    @property
    def per_percent(self) -> float:
        """Change of the objective when the parameter grows by one per cent, in its units."""
        return self.derivative * self.value / 100.0


def sensitivities(aircraft: Aircraft, mission: Mission, result: SizingResult) -> list[Sensitivity]:
    """Sensitivities of an optimum to every parameter of the catalogue that the aircraft has.

    Returns largest change of the objective per per cent first; empty where the excess time is
    infinite, which no small change makes any longer.
    """
    if result.objective_value == np.inf:
        return []
    optimum, objective_value = _optimum(result, "sensitivities")
    to_units = _objective_per_cost(optimum, objective_value)
    # What the optimiser chooses is no parameter.
    requested = aircraft.design_space.requested_ranges()
    chosen = {key for key, name in variable_keys().items() if name in requested}
    rows = []
    for name, row in catalogue().items():
        value = parameter_value(aircraft, mission, name)
        if not row.sensitive or value is None or name in chosen or build_scales(aircraft, name):
            continue
        if result.objective.variable in (row.key, row.name):
            continue
        step = _RELATIVE_STEP * abs(value) if value != 0.0 else _RELATIVE_STEP
        low, high = max(value - step, 0.0), value + step  # no parameter may become negative
        below, above = (
            _lagrangian(optimum, *with_parameter(aircraft, mission, name, moved))
            for moved in (low, high)
        )
        derivative = to_units * (above - below) / (high - low)
        both = value != 0.0 and objective_value != 0.0
        elasticity = derivative * value / objective_value if both else None
        rows.append(Sensitivity(name, row.unit, value, derivative, elasticity))
    # Efficiencies of one chain have one sensitivity, but for rounding: they keep their order.
    return sorted(rows, key=lambda s: -float(f"{abs(s.per_percent):.6g}"))


@dataclass(frozen=True)
class ConstraintMultiplier:
    """What the objective gains when one active requirement or bound is eased.

    ``gain`` is in units of the objective, positive where the objective becomes better, for easing
    by ``step``: 1 % of a limit, 1 % of the battery's capacity, or one hour of required excess time.
    """

    constraint: str
    gain: float
    step: str


def constraint_multipliers(result: SizingResult) -> list[ConstraintMultiplier]:
    """Multipliers of the requirements and bounds that hold an optimum back, largest first.

    They are those of the program, in the units of the objective. Like sensitivities they hold for
    small changes.
    """
    if result.objective_value == np.inf:
        return []
    optimum, objective_value = _optimum(result, "multipliers")
    to_units = abs(_objective_per_cost(optimum, objective_value))
    longest = result.objective is Objective.max_excess_time
    gains: defaultdict[tuple[str, str], float] = defaultdict(float)
    for limit in limits_of(optimum):
        if limit.multiplier > LEAST_MULTIPLIER and not (longest and limit.step == "1 h"):
            name = limit.name
            if limit.step == "1 % of the bound":
                name = f"{name.partition(' ')[0]} at its bound"
            gains[name, limit.step] += to_units * limit.gain
    multipliers = [ConstraintMultiplier(name, gain, step) for (name, step), gain in gains.items()]
    return sorted(multipliers, key=lambda multiplier: -multiplier.gain)


def _optimum(result: SizingResult, purpose: str) -> tuple[Solution, float]:
    """Solution around the simulated optimum itself, and its objective."""
    solution = result.optimum
    if solution is None or result.simulated is None or result.objective_value is None:
        raise ValueError(f"the sizing is {result.status.name}: only an optimum has {purpose}")
    task, point = solution.task, solution.linearisation
    task = replace(task, day=_fine_day(task, task.aircraft, task.mission))
    values = task.first_values(result.simulated.design.variables.mapped(float))
    values[TOTAL_MASS] = float(result.simulated.design.total_mass_kg)
    flown = zip(point.known.items(), solution.profiles, strict=True)
    known = {n: replace(scenario, profile=profile) for (n, scenario), profile in flown}
    point = _linearised(task, neighbours(task, values), known)
    return solve(task, point, excess_h=solution.excess_time_h), result.objective_value


def _linearised(
    task: SizingTask,
    designs: list[Values],
    known: Mapping[int, Scenario],
    like: Linearisation | None = None,
) -> Linearisation:
    """Light and load of a design and its neighbours, at heights that are known."""
    profiles = {n: it.profile for n, it in known.items() if it.profile is not None}
    return linearised(task, dict(designs[0]), simulate(task, designs, profiles), known, like)


def _fine_day(task: SizingTask, aircraft: Aircraft, mission: Mission) -> SolarDay:
    """Light in steps so short that it hardly counts when in one a battery begins to hold back."""
    scenarios = task.day.scenarios
    return solar_day(aircraft, mission, task.solar, scenarios=scenarios, step_h=FINE_STEP_H)


def _objective_per_cost(optimum: Solution, objective_value: float) -> float:
    """Derivative of the objective with respect to the program's cost."""
    task = optimum.task
    ((name, _),) = task.cost.items()
    weights = optimum.parameters[: len(task.variables) + 1]
    if name == WORST_EXCESS:
        return 1.0 / float(weights[-1])
    place = task.names.index(name)
    scale = scales_of(task.variables, optimum.linearisation.values)[place]
    # The variable is a logarithm, or the value over its scale.
    return float((scale if task.variables[place].linear else objective_value) / weights[place])


def _lagrangian(optimum: Solution, aircraft: Aircraft, mission: Mission) -> float:
    """Lagrangian with other data, the point and the multipliers held."""
    point, task_then = optimum.linearisation, optimum.task
    day = _fine_day(task_then, aircraft, mission)
    task: SizingTask = replace(task_then, aircraft=aircraft, mission=mission, day=day)
    # A payload that is not chosen is the mission's.
    held = {
        v.name: task.held[v.name]
        for v in task.variables
        if v.role is Role.payload and v.name not in task.free_names
    }
    moved_point = _linearised(task, [point.values | held], point.known, point)
    blocks = tuple(
        now._replace(
            light_slope=then.light_slope,
            load_slope=then.load_slope,
            shift_h=then.shift_h,
            shift_slope_h=then.shift_slope_h,
        )
        for now, then in zip(moved_point.blocks, point.blocks, strict=True)
    )
    scales = scales_of(task_then.variables, point.values)
    design = optimum.program.parts["design"]
    x, centre = optimum.x.copy(), optimum.centre.copy()
    for i, v in enumerate(task_then.variables):
        if v.name in held:
            x[design][i] = centre[i] = v.to_program(held[v.name], scales[i])
    program = build_program(aircraft, optimum.program.form)
    parts = point.parts
    if parts is not None and moved_point.parts is not None:
        parts = moved_point.parts._replace(slope=parts.slope, bend=parts.bend)
    moved = replace(point, blocks=blocks, parts=parts)
    cost, rows = program.evaluated(x, parameters_of(task, program, moved, scales, centre))
    # What must be left between the nodes is a bound on the charge there.
    least = moved_point.least * moved_point.load_w / point.load_w
    bounds = optimum.bound_multipliers[optimum.program.parts["charge"]]
    return cost + float(rows @ optimum.row_multipliers - bounds @ least)
