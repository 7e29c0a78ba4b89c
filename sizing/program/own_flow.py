"""A sizing in the flow of its own design, where that cools the modules.

The program takes the sun from the flow of the aircraft's first guess; how the simulator knows it
from that for other designs (:mod:`sizing.day.module_power`) is exact at three flows. The optimum is
flown in its own.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.parameters import with_parameter
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult
from sizing.program.size import size_aircraft

_LIFT = "airframe.aerodynamics.lift_coefficient"
_NEGLIGIBLE_H = 0.003  # of excess time: the steps of the simulator make half as much


def sized_in_own_flow(
    aircraft: Aircraft, mission: Mission, objective: Objective, solar: SolarModel, **options: Any
) -> tuple[Aircraft, SizingResult]:
    """Size an aircraft, whose first guess becomes the design where the flow cools its modules.

    The result is simulated with that aircraft's own sun. Where the known one was off by more than
    next to nothing, or the design is not enough after all, the sizing is repeated from there.
    ``options``: as for :func:`~sizing.program.size.size_aircraft`.
    """
    result = size_aircraft(aircraft, mission, objective, solar, **options)
    perf = result.simulated or result.nearest
    if perf is None or perf.day.cooling is None or not np.isfinite(perf.design.total_mass_kg):
        return aircraft, result
    variables = perf.design.variables.mapped(float)
    # Its design point is that of the design, as far as its file has numbers for it.
    span_m, aspect_ratio = variables.wingspan_m, variables.aspect_ratio
    guessed = aircraft.with_airframe(wingspan_m=span_m, aspect_ratio=aspect_ratio)
    if variables.lift_coefficient is not None:
        guessed, _ = with_parameter(guessed, mission, _LIFT, variables.lift_coefficient)
    if aircraft.battery.pack is None:
        guessed, _ = with_parameter(guessed, mission, "battery.mass_kg", variables.battery_mass_kg)
    if aircraft.modules.layout is None:
        guessed, _ = with_parameter(guessed, mission, "modules.area_m2", variables.module_area_m2)
    if not result.feasible:
        return guessed, result
    in_own_flow = performance_of_designs(guessed, mission, variables, solar)
    least_h, known_h = (float(np.min(it.cycle.excess_time_h)) for it in (in_own_flow, perf))
    sufficient = least_h > 0.0 and least_h >= result.required_excess_time_h
    if sufficient and (least_h == known_h or abs(least_h - known_h) < _NEGLIGIBLE_H):
        return guessed, result.with_design(in_own_flow)
    again = size_aircraft(guessed, mission, objective, solar, **options | {"start": variables})
    if sufficient and again.merit <= result.merit:
        return guessed, result.with_design(in_own_flow)
    return guessed, again
