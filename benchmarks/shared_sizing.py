"""One sizing problem, put to this project and to AeroSandbox, with one physics.

The least wingspan that flies for ever with some excess time on three dates. Masses and power are
those of :func:`sizing.mass_budget.parametric_design`, which takes numbers and CasADi symbols
alike; the structure is a power law and the battery takes any charge power, so that both sides can
say it in full. Specific solar power over the day is data for both.

AeroSandbox gets the direct collocation that its users write: 150 points for each day, state of
charge, charge and discharge power as variables, design variables in their logarithms, guesses
from the aircraft file and from a typical day. Surplus that is not needed may be thrown away, so
that no minimum or maximum stands in the equations.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from missions.library import load_mission
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarDay, solar_day
from sizing.design import DesignVariables, variables_of
from sizing.library import load_aircraft
from sizing.limits import design_requirements
from sizing.mass_budget import constant_power_w, parametric_design
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult
from sizing.program.size import size_aircraft
from solar.types import FloatArray

POINTS_PER_DAY = 150
REQUIRED_H = 3.0
# Limits that a user with many cases would set, in favour of AeroSandbox: a feasible case takes
# about 30 iterations and 0.1 s; without a limit, infeasible ones were seen to take up to 30 s.
_MOST_ITERATIONS, _MOST_S = 150, 1.0


def shared_aircraft() -> Aircraft:
    """AtlantikSolar's technology with a power-law structure and without a charge limit.

    The law is made up for this benchmark: square in the span, 1.35 kg at 5.65 m as for the built
    wing.
    """
    law = "model: power_law, coefficient_kg: 0.0423, span_exponent: 2.0, aspect_ratio_exponent: 0.0"
    return load_aircraft(
        "atlantiksolar-design",
        [f"airframe.structure={{{law}}}", "battery.charge_limit={kind: none}"],
    )


def shared_mission(latitude_deg: float = 47.6, payload_kg: float = 0.0) -> Mission:
    """1 May, 23 June and 15 August at a latitude, with a payload."""
    overrides = [f"latitude_deg={latitude_deg}", f"payload.mass_kg={payload_kg}"]
    return load_mission("central-europe-summer", overrides)


def sun_of(aircraft: Aircraft, mission: Mission) -> SolarDay:
    """Specific power by CAM: the data of the problem."""
    return solar_day(aircraft, mission)


def size_ours(
    aircraft: Aircraft, mission: Mission, day: SolarDay, required_h: float = REQUIRED_H
) -> SizingResult:
    """Build and solve by this project, with the confirmation by its simulator."""
    return size_aircraft(
        aircraft, mission, Objective.min_wingspan, required_excess_time_h=required_h, day=day
    )


@dataclass(frozen=True)
class Collocation:
    """AeroSandbox's program, built once; sun, payload and required time are parameters."""

    opti: Any
    variables: DesignVariables
    sun: Any
    required_h: Any
    payload_kg: Any

    @classmethod
    def build(cls, asb: Any, aircraft: Aircraft, mission: Mission, day: SolarDay) -> Collocation:
        """Write the program down for the scenarios of a day."""
        opti = asb.Opti()
        space, guess = aircraft.design_space, variables_of(aircraft)

        def positive(name: str) -> Any:
            bounds = getattr(space, name)
            return opti.variable(
                init_guess=getattr(guess, name),
                log_transform=True,
                lower_bound=bounds.minimum,
                upper_bound=bounds.maximum,
            )

        variables = DesignVariables(
            wingspan_m=positive("wingspan_m"),
            aspect_ratio=guess.aspect_ratio,
            battery_mass_kg=positive("battery_mass_kg"),
            module_area_m2=positive("module_area_m2"),
        )
        total_kg = opti.variable(init_guess=7.0, log_transform=True)
        payload_kg = opti.parameter(value=mission.payload.mass_kg)
        required_h = opti.parameter(value=REQUIRED_H)
        # The payload enters the masses as a number; as a parameter it is added here.
        empty = mission.model_copy(
            update={"payload": mission.payload.model_copy(update={"mass_kg": 0.0})}
        )
        design = parametric_design(aircraft, empty, variables, total_kg)
        rows = {one.name: one.value for one in design_requirements(aircraft, design)}
        opti.subject_to(rows.pop("mass_budget") == payload_kg / total_kg)
        opti.subject_to([value >= 0.0 for value in rows.values()])

        nominal_w = design.propulsion_power_w + constant_power_w(aircraft, mission.payload.power_w)
        battery = aircraft.battery
        time_h = np.linspace(0.0, 24.0, POINTS_PER_DAY)
        power = sampled(day)
        sun = [opti.parameter(value=row) for row in power]
        for specific_power, values in zip(sun, power, strict=True):
            typical = guess.module_area_m2 * values - 40.0
            charge_w = 100.0 * opti.variable(
                init_guess=np.maximum(typical, 0.0) / 100.0, lower_bound=0.0
            )
            discharge_w = 100.0 * opti.variable(
                init_guess=np.maximum(-typical, 0.0) / 100.0, lower_bound=0.0
            )
            charge = opti.variable(
                init_guess=0.6 + 0.35 * np.cos((time_h - 18.0) / 24.0 * 2.0 * np.pi),
                upper_bound=1.0,
            )
            surplus_w = variables.module_area_m2 * specific_power - nominal_w
            opti.subject_to((surplus_w - charge_w + discharge_w) / 100.0 >= 0.0)
            rate = battery.charge_efficiency * charge_w - discharge_w / battery.discharge_efficiency
            opti.constrain_derivative(rate / design.battery_energy_wh, charge, time_h)
            opti.subject_to(charge[0] == charge[-1])
            reserve_wh = required_h * nominal_w / battery.discharge_efficiency
            opti.subject_to(charge >= reserve_wh / design.battery_energy_wh)
        opti.minimize(variables.wingspan_m / guess.wingspan_m)
        return cls(opti, variables, sun, required_h, payload_kg)

    def solve(self) -> float | None:
        """Least wingspan with the parameters as they are [m]; none where IPOPT finds none."""
        try:
            solution = self.opti.solve(
                verbose=False, max_iter=_MOST_ITERATIONS, max_runtime=_MOST_S
            )
        except RuntimeError:
            return None
        return float(solution(self.variables.wingspan_m))

    def start_from_solution(self) -> None:
        """Take the last solution for the guess of the next solve."""
        self.opti.set_initial(self.opti.x, self.opti.value(self.opti.x))

    def put(self, day: SolarDay, required_h: float, payload_kg: float) -> None:
        """Fill the parameters with another case."""
        for parameter, values in zip(self.sun, sampled(day), strict=True):
            self.opti.set_value(parameter, values)
        self.opti.set_value(self.required_h, required_h)
        self.opti.set_value(self.payload_kg, payload_kg)


def sampled(day: SolarDay) -> list[FloatArray]:
    """Specific power of each scenario at the points of the collocation [W/m2]."""
    time_h = np.linspace(0.0, 24.0, POINTS_PER_DAY)
    return [np.interp(time_h, day.time_h, row) for row in day.specific_power_w_per_m2]
