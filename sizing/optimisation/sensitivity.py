"""Sensitivity of an optimum to technology parameters, and the multipliers of its constraints.

By the envelope theorem the derivative of the best objective with respect to a parameter is that of
the Lagrangian, ``d f*/dp = df/dp + lambda dg/dp``, with the point and the multipliers held: no
sizing has to be repeated. The Lagrangian is differentiated by central differences, in double
precision good to about eight digits. It holds as long as no constraint changes between active and
inactive.

Source: Fiacco, A. V. (1983), Introduction to Sensitivity and Stability Analysis in Nonlinear
Programming.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import FlightConditions, variable_keys
from sizing.optimisation.climb_constraints import aloft_parameters, block_winds_m_per_s
from sizing.optimisation.energy_constraints import sun_parameters
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import SizingProblem, build_problem
from sizing.optimisation.result import SizingResult, Solution
from sizing.optimisation.variables import HEIGHT, RELATIVE_STEP, Role
from sizing.parameters import catalogue, is_doubled, parameter_value, with_parameter
from sizing.performance import Performance
from sizing.sunlight import UNCORRECTED_CAM, SolarModel, solar_day
from solar.types import FloatArray

# Charge limited by the sun turns into charge limited by the charger within a relative change of
# some 1e-5, and optima like to sit at such a turn: a longer step would average over both sides.
_RELATIVE_STEP = 1e-6
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


def sensitivities(
    aircraft: Aircraft, mission: Mission, result: SizingResult, solar: SolarModel = UNCORRECTED_CAM
) -> list[Sensitivity]:
    """Sensitivities of an optimum to every parameter of the catalogue that the aircraft has.

    Returns largest change of the objective per per cent first; empty where the excess time is
    infinite, which no small change makes any longer.
    """
    optimum, perf, objective_value = _checked(result, "sensitivities")
    if not np.isfinite(objective_value):
        return []
    every, blocks = perf.day.scenarios, list(optimum.scenarios)
    scenarios = Scenarios(every.latitude_deg[blocks], every.day_of_year[blocks])
    lagrangian = _Lagrangian(optimum, solar, scenarios)
    to_units = _objective_per_cost(result)
    chosen = _chosen_keys(aircraft, result.objective)
    rows = []
    for name, one in catalogue().items():
        value = parameter_value(aircraft, mission, name)
        if not one.sensitive or value is None or name in chosen or is_doubled(aircraft, name):
            continue
        derivative = to_units * lagrangian.derivative(aircraft, mission, name, value)
        both = value != 0.0 and objective_value != 0.0
        elasticity = derivative * value / objective_value if both else None
        rows.append(Sensitivity(name, one.unit, value, derivative, elasticity))
    # Efficiencies of one chain have one sensitivity, but for rounding: they keep their order.
    return sorted(rows, key=lambda s: -float(f"{abs(s.per_percent):.9g}"))


def _checked(result: SizingResult, wanted: str) -> tuple[Solution, Performance, float]:
    """Parts of a result that an optimum alone has."""
    if result.optimum is None or result.simulated is None or result.objective_value is None:
        raise ValueError(f"the sizing is {result.status.name}: only an optimum has {wanted}")
    return result.optimum, result.simulated, result.objective_value


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
    optimum, perf, objective_value = _checked(result, "multipliers")
    if not np.isfinite(objective_value):
        return []
    to_units = abs(_objective_per_cost(result))
    label = perf.day.scenarios.label
    gains: dict[tuple[str, str], float] = {}

    def add(name: str, multiplier: float, per: float, step: str) -> None:
        if abs(multiplier) > LEAST_MULTIPLIER:
            gain = to_units * abs(multiplier) * per
            gains[name, step] = gains.get((name, step), 0.0) + gain

    for row, multiplier in zip(optimum.constraints, optimum.constraint_multipliers, strict=True):
        if row.equation:
            continue
        if row.block is None:
            add(row.name, float(multiplier), row.step, "1 % of the limit")
            continue
        name = f"{row.name} ({label(optimum.scenarios[row.block])})"
        if row.name == HEIGHT:
            add(name, float(multiplier), row.step, "1 % of the height of the ceiling")
        elif row.unit == "1":
            add(name, float(multiplier), row.step, "1 % of the battery's capacity")
        elif result.objective is not Objective.max_excess_time:
            add(name, float(multiplier), row.step, f"1 {row.unit}")
    for variable, multiplier in optimum.free_bound_multipliers().items():
        add(f"{variable} at its bound", multiplier, RELATIVE_STEP, "1 % of the bound")
    multipliers = [ConstraintMultiplier(name, gain, step) for (name, step), gain in gains.items()]
    return sorted(multipliers, key=lambda one: -one.gain)


def _chosen_keys(aircraft: Aircraft, objective: Objective) -> set[str]:
    """Keys whose values the optimiser chooses: no parameters."""
    requested = aircraft.design_space.requested_ranges()
    chosen = {one.key for one in catalogue().values() if objective.variable in (one.key, one.name)}
    return chosen | {key for key, name in variable_keys().items() if name in requested}


def _objective_per_cost(result: SizingResult) -> float:
    """Derivative of the objective with respect to the program's cost."""
    optimum = result.optimum
    assert optimum is not None
    assert result.objective_value is not None
    ((weight, scale),) = (
        (float(weight), variable.scale)
        for weight, variable in zip(optimum.weights, optimum.variables, strict=True)
        if weight != 0.0 and variable.role is not Role.slack
    )
    # The variable is a logarithm, or the value over its scale.
    return (result.objective_value if scale is None else scale) / weight


@dataclass(frozen=True)
class _Lagrangian:
    optimum: Solution
    solar: SolarModel
    scenarios: Scenarios

    def derivative(self, aircraft: Aircraft, mission: Mission, key: str, value: float) -> float:
        step = _RELATIVE_STEP * abs(value) if value != 0.0 else _RELATIVE_STEP
        low = max(value - step, 0.0)  # no parameter may become negative
        high = value + step
        return (
            self.at(*with_parameter(aircraft, mission, key, high))
            - self.at(*with_parameter(aircraft, mission, key, low))
        ) / (high - low)

    def at(self, aircraft: Aircraft, mission: Mission) -> float:
        """Value with other data, the point and the multipliers held."""
        day = solar_day(aircraft, mission, self.solar, scenarios=self.scenarios)
        climb = mission.climb
        problem = build_problem(
            *(aircraft, len(self.scenarios)),
            holds=mission.holds_station,
            climb=None if climb is None else climb.strategy,
        )
        always = self.optimum.instance.sunlit
        sunlit = [i for i, scenario in enumerate(self.optimum.scenarios) if scenario in always]
        parameters = problem.parameters(
            self._weights(problem),
            FlightConditions.of(mission, aircraft),
            sun_parameters(day, mission, sunlit),
            margin=self.optimum.instance.margin,
            aloft=None if climb is None else aloft_parameters(mission, aircraft),
            winds=block_winds_m_per_s(mission, self.scenarios),
        )
        cost, rows = problem.program.rows(self._point(problem, mission), parameters)
        multipliers = self.optimum.constraint_multipliers
        return float(cost) + float(np.asarray(rows).ravel() @ multipliers)

    def _weights(self, problem: SizingProblem) -> FloatArray:
        """Cost of the optimum in another program of the same aircraft."""
        named = zip(self.optimum.variables, self.optimum.weights, strict=True)
        return problem.weights({v.name: float(weight) for v, weight in named if weight != 0.0})

    def _point(self, problem: SizingProblem, mission: Mission) -> FloatArray:
        """Decision vector of the optimum in the program of another aircraft or mission.

        A payload that is not chosen is the mission's.
        """
        optimum = {v.name: x for v, x in zip(self.optimum.variables, self.optimum.x, strict=True)}
        held = {
            "payload_mass_kg": mission.payload.mass_kg,
            "payload_power_w": mission.payload.power_w,
        }
        chosen = {
            v.name for v, w in zip(self.optimum.variables, self.optimum.weights, strict=True) if w
        }
        for v in problem.variables:
            if v.name in held and v.name not in chosen:
                optimum[v.name] = v.to_program(held[v.name])
        return np.array([optimum[v.name] for v in problem.variables])
