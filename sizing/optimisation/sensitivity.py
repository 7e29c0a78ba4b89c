"""What each technology parameter is worth at an optimum.

By the envelope theorem the derivative of the best objective with respect to a parameter is that of
the Lagrangian, ``d f*/dp = df/dp + lambda dg/dp``, with the point and the prices of the constraints
held: no sizing has to be repeated. The Lagrangian is differentiated by central differences, in
double precision good to about eight digits. It holds as long as no constraint changes between
active and inactive.

Source: Fiacco, A. V. (1983), Introduction to Sensitivity and Stability Analysis in Nonlinear
Programming.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import FlightConditions
from sizing.optimisation.energy_constraints import lowest_sun_parameters, sun_parameters
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import LINEAR_SCALES, SizingProblem, build_problem
from sizing.optimisation.result import Optimum, SizingResult
from sizing.parameters import parameter_value, with_parameter
from sizing.sunlight import UNCORRECTED_CAM, SolarModel, solar_day
from solar.types import FloatArray

# Charge limited by the sun turns into charge limited by the charger within a relative change of
# some 1e-5, and optima like to sit at such a turn: a longer step would average over both sides.
_RELATIVE_STEP = 1e-6
# Multipliers below this are what the solver leaves of an inactive constraint.
LEAST_PRICE = 1e-5

# Parameters as keys of the aircraft file, or of the mission file behind "mission.", and their unit.
PARAMETERS: dict[str, str] = {
    "battery.specific_energy_wh_per_kg": "Wh/kg",
    "battery.charge_efficiency": "1",
    "battery.discharge_efficiency": "1",
    "modules.efficiency_stc": "1",
    "modules.mppt_efficiency": "1",
    "modules.camber_efficiency": "1",
    "modules.mass_kg_per_m2": "kg/m2",
    "modules.temperature_coefficient_per_k": "1/K",
    "airframe.structure.calibration": "1",
    "airframe.structure.coefficient_kg": "kg",
    "airframe.structure.safety_factor": "1",
    "airframe.structure.cruise_gust_m_per_s": "m/s",
    "airframe.structure.modulus_pa": "Pa",
    "airframe.structure.cap_width_fraction": "1",
    "airframe.structure.minimum_web_thickness_m": "m",
    "airframe.structure.covering_kg_per_m2": "kg/m2",
    "airframe.aerodynamics.lift_coefficient": "1",
    "airframe.aerodynamics.profile_drag_coefficient": "1",
    "airframe.aerodynamics.parasitic_drag_coefficient": "1",
    "airframe.aerodynamics.span_efficiency": "1",
    "airframe.aerodynamics.calibration": "1",
    "airframe.propulsion.motor_efficiency": "1",
    "airframe.propulsion.propeller_efficiency": "1",
    "airframe.propulsion.mass_kg_per_w": "kg/W",
    "airframe.propulsion.climb_power_ratio": "1",
    "airframe.propulsion.climb_rate_m_per_s": "m/s",
    "airframe.avionics_mass_kg": "kg",
    "airframe.aspect_ratio": "1",
    "power.avionics_w": "W",
    "mission.payload.mass_kg": "kg",
    "mission.payload.power_w": "W",
    "mission.clearness": "1",
    "mission.turbulence.all_day": "1",
}


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
    aircraft: Aircraft,
    mission: Mission,
    result: SizingResult,
    solar: SolarModel = UNCORRECTED_CAM,
) -> list[Sensitivity]:
    """Sensitivities of an optimum to every technology parameter that the aircraft has.

    Parameters
    ----------
    aircraft, mission, solar
        What :func:`sizing.optimisation.search.size_aircraft` was asked.
    result : SizingResult
        Its answer.

    Returns
    -------
    list of Sensitivity
        Largest change of the objective per per cent first; empty where the excess time is infinite,
        which no small change makes any longer.

    Raises
    ------
    ValueError
        If the result is no optimum.
    """
    if result.optimum is None or result.simulated is None or result.objective_value is None:
        raise ValueError(f"the sizing is {result.status}: only an optimum has sensitivities")
    if not np.isfinite(result.objective_value):
        return []
    every = result.simulated.day.scenarios
    filled = list(result.optimum.filled)
    scenarios = Scenarios(every.latitude_deg[filled], every.day_of_year[filled])
    lagrangian = _Lagrangian(result.optimum, solar, scenarios)
    to_units = _objective_per_cost(result)
    chosen = _chosen_keys(aircraft, result.objective)
    found = []
    for name, unit in PARAMETERS.items():
        value = parameter_value(aircraft, mission, name)
        if value is None or name in chosen:
            continue
        derivative = to_units * lagrangian.derivative(aircraft, mission, name, value)
        scale = result.objective_value
        elasticity = derivative * value / scale if value != 0.0 and scale != 0.0 else None
        found.append(Sensitivity(name, unit, value, derivative, elasticity))
    return sorted(found, key=lambda s: -abs(s.per_percent))


@dataclass(frozen=True)
class ConstraintPrice:
    """What the objective gains when one active requirement or bound is eased.

    ``gain`` is in units of the objective, positive where the objective becomes better, for easing
    by ``step``: 1 % of a limit, 1 % of the battery's capacity, or one hour of required excess time.
    """

    constraint: str
    gain: float
    step: str


def constraint_prices(result: SizingResult) -> list[ConstraintPrice]:
    """Prices of the requirements and bounds that hold an optimum back, dearest first.

    They are the multipliers of the program, in the units of the objective. Like sensitivities they
    hold for small changes.

    Raises
    ------
    ValueError
        If the result is no optimum.
    """
    if result.optimum is None or result.simulated is None or result.objective_value is None:
        raise ValueError(f"the sizing is {result.status}: only an optimum has prices")
    if not np.isfinite(result.objective_value):
        return []
    worth = abs(_objective_per_cost(result))
    labels = result.simulated.day.scenarios.label
    prices: dict[str, ConstraintPrice] = {}

    def add(name: str, price: float, per: float, step: str) -> None:
        gain = worth * abs(price) * per
        if abs(price) > LEAST_PRICE:
            before = prices[name].gain if name in prices else 0.0
            prices[name] = ConstraintPrice(name, before + gain, step)

    optimum = result.optimum
    for constraint, price in zip(optimum.constraints, optimum.constraint_prices, strict=True):
        if constraint.slot is None:
            if constraint.name != "mass_budget":
                add(constraint.name, float(price), 0.01, "1 % of the limit")
            continue
        name = f"{constraint.name} ({labels(optimum.filled[constraint.slot])})"
        if constraint.name == "excess_time":
            # The row counts in tenths of the day.
            if result.objective is not Objective.max_excess_time:
                add(name, float(price), 1.0 / 2.4, "1 h")
        else:
            add(name, float(price), 0.01, "1 % of the battery's capacity")
    for variable, price in optimum.bound_prices.items():
        add(f"{variable} at its bound", price, 0.01, "1 % of the bound")
    return sorted(prices.values(), key=lambda one: -one.gain)


def _chosen_keys(aircraft: Aircraft, objective: Objective) -> set[str]:
    """Keys whose values the optimiser chooses: no parameters."""
    space = aircraft.design_space
    chosen = set()
    if space.aspect_ratio is not None:
        chosen.add("airframe.aspect_ratio")
    if space.lift_coefficient is not None:
        chosen.add("airframe.aerodynamics.lift_coefficient")
    if objective is Objective.max_payload_mass:
        chosen.add("mission.payload.mass_kg")
    if objective is Objective.max_payload_power:
        chosen.add("mission.payload.power_w")
    return chosen


def _objective_per_cost(result: SizingResult) -> float:
    """Derivative of the objective with respect to the program's cost."""
    if result.objective is Objective.max_excess_time:
        return -24.0  # the cost is -T/24
    if result.objective.variable in LINEAR_SCALES:
        return -LINEAR_SCALES[result.objective.variable]  # the cost is the payload over its scale
    assert result.objective_value is not None
    return result.objective_value  # the cost is the logarithm of span or mass


@dataclass(frozen=True)
class _Lagrangian:
    optimum: Optimum
    solar: SolarModel
    scenarios: Scenarios

    def derivative(self, aircraft: Aircraft, mission: Mission, key: str, value: float) -> float:
        step = _RELATIVE_STEP * abs(value) if value != 0.0 else _RELATIVE_STEP
        low = max(value - step, 0.0)  # no parameter may become negative
        high = value + step
        return (
            self._at(*with_parameter(aircraft, mission, key, high))
            - self._at(*with_parameter(aircraft, mission, key, low))
        ) / (high - low)

    def _at(self, aircraft: Aircraft, mission: Mission) -> float:
        day = solar_day(aircraft, mission, self.solar, scenarios=self.scenarios)
        problem = build_problem(aircraft, len(self.scenarios))
        symbols = problem.symbols
        function = ca.Function(
            "program", [symbols["x"], symbols["p"]], [symbols["f"], symbols["g"]]
        )
        suns = lowest_sun_parameters if self.optimum.needs_no_battery else sun_parameters
        parameters = problem.parameters(
            self.optimum.weights,
            FlightConditions.of(mission),
            suns(day, mission),
            margin=self.optimum.margin,
        )
        cost, rows = function(self._point(problem, mission), parameters)
        prices: FloatArray = self.optimum.constraint_prices
        return float(cost) + float(np.asarray(rows).ravel() @ prices)

    def _point(self, problem: SizingProblem, mission: Mission) -> FloatArray:
        """Decision vector of the optimum; a payload that is no variable is the mission's."""
        x = self.optimum.x.copy()
        held = {
            "payload_mass_kg": mission.payload.mass_kg,
            "payload_power_w": mission.payload.power_w,
        }
        for i, variable in enumerate(problem.variables):
            if variable.name in held and self.optimum.weights[i] == 0.0:
                x[i] = variable.to_program(held[variable.name])
        return x
