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
from typing import Any

import casadi as ca
import numpy as np
from pydantic import BaseModel

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.energy_balance import FloatArray
from sizing.objectives import Objective
from sizing.optimiser import Optimum, SizingResult
from sizing.performance import UNCORRECTED_CAM, SolarModel, solar_day
from sizing.sizing_problem import build_program

_RELATIVE_STEP = 1e-4
_MISSION = "mission."

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
        What :func:`sizing.optimiser.size_aircraft` was asked.
    result : SizingResult
        Its answer.

    Returns
    -------
    list of Sensitivity
        Largest change of the objective per per cent first.

    Raises
    ------
    ValueError
        If the result is no optimum.
    """
    if result.optimum is None or result.simulated is None or result.objective_value is None:
        raise ValueError(f"the sizing is {result.status}: only an optimum has sensitivities")
    every = result.simulated.day.scenarios
    filled = list(result.optimum.filled)
    scenarios = Scenarios(every.latitude_deg[filled], every.day_of_year[filled])
    lagrangian = _Lagrangian(result.objective, result.optimum, solar, scenarios)
    to_units = _objective_per_cost(result)
    fixed = aircraft.design_space.aspect_ratio is None
    free = set() if fixed else {"airframe.aspect_ratio"}
    found = []
    for name, unit in PARAMETERS.items():
        value = _value(aircraft, mission, name)
        if value is None or name in free:
            continue
        derivative = to_units * lagrangian.derivative(aircraft, mission, name, value)
        scale = result.objective_value
        elasticity = derivative * value / scale if value != 0.0 and scale != 0.0 else None
        found.append(Sensitivity(name, unit, value, derivative, elasticity))
    return sorted(found, key=lambda s: -abs(s.per_percent))


def _objective_per_cost(result: SizingResult) -> float:
    """Derivative of the objective with respect to the program's cost."""
    if result.objective is Objective.max_excess_time:
        return -24.0  # the cost is -T/24
    assert result.objective_value is not None
    return result.objective_value  # the cost is the logarithm of span or mass


@dataclass(frozen=True)
class _Lagrangian:
    objective: Objective
    optimum: Optimum
    solar: SolarModel
    scenarios: Scenarios

    def derivative(self, aircraft: Aircraft, mission: Mission, name: str, value: float) -> float:
        step = _RELATIVE_STEP * abs(value) if value != 0.0 else _RELATIVE_STEP
        low = max(value - step, 0.0)  # no parameter may become negative
        high = value + step
        return (
            self._at(*_with(aircraft, mission, name, high))
            - self._at(*_with(aircraft, mission, name, low))
        ) / (high - low)

    def _at(self, aircraft: Aircraft, mission: Mission) -> float:
        day = solar_day(aircraft, mission, self.solar, scenarios=self.scenarios)
        slots = len(self.scenarios)
        program = build_program(aircraft, mission, day, self.objective, slots)
        function = ca.Function("program", [program.x, program.p], [program.f, program.g])
        parameters = program.axis.parameters(
            range(slots), elastic=False, goal_h=self.optimum.goal_h, margin=self.optimum.margin
        )
        cost, rows = function(self.optimum.x, parameters)
        prices: FloatArray = self.optimum.constraint_prices
        return float(cost) + float(np.asarray(rows).ravel() @ prices)


def _value(aircraft: Aircraft, mission: Mission, name: str) -> float | None:
    """Value of a parameter; none where this aircraft does not have it."""
    on_mission = name.startswith(_MISSION)
    node: Any = mission if on_mission else aircraft
    for part in name.removeprefix(_MISSION).split("."):
        node = getattr(node, part, None)
    return float(node) if isinstance(node, (int, float)) else None


def _with(
    aircraft: Aircraft, mission: Mission, name: str, value: float
) -> tuple[Aircraft, Mission]:
    parts = name.removeprefix(_MISSION).split(".")
    if name.startswith(_MISSION):
        return aircraft, _replaced(mission, parts, value)
    return _replaced(aircraft, parts, value), mission


def _replaced(node: Any, parts: list[str], value: float) -> Any:
    """Copy of a description with one value replaced, without validation: the step may leave it.

    It is built anew, because a plain copy would take over what the original has cached.
    """
    assert isinstance(node, BaseModel)
    head, *rest = parts
    new = value if not rest else _replaced(getattr(node, head), rest, value)
    fields = {name: getattr(node, name) for name in type(node).model_fields}
    return type(node).model_construct(**(fields | {head: new}))
