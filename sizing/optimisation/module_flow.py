"""First guesses whose modules are cooled as those of the optimum are.

The program takes the sun from the flow of the aircraft's first guess; the simulator gives each
design its own (:mod:`sizing.module_power`). Where the two are far apart, the program weighs modules
wrongly: its first optimum is the guess of the sizing that counts.
"""

from __future__ import annotations

from typing import Any

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables
from sizing.module_power import balances_heat
from sizing.optimisation.objectives import Objective
from sizing.optimisation.search import size_aircraft
from sizing.sunlight import SolarModel


def with_flow_of_optimum(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    *,
    start: DesignVariables | None = None,
    **options: Any,
) -> tuple[Aircraft, DesignVariables | None]:
    """Aircraft whose first guess is about its optimum, and where to start; as it is elsewhere.

    ``options``: as for :func:`~sizing.optimisation.search.size_aircraft`.
    """
    if objective.of_range or not balances_heat(mission):
        return aircraft, start
    first = size_aircraft(
        *(aircraft, mission, objective, solar), start=start, explain=False, **options
    )
    if first.design is None or not first.feasible:
        return aircraft, start
    found = first.design.variables.mapped(float)
    geometry = {"wingspan_m": found.wingspan_m, "aspect_ratio": found.aspect_ratio}
    parts: dict[str, Any] = {"airframe": aircraft.airframe.model_copy(update=geometry)}
    if aircraft.battery.pack is None:
        battery = {"mass_kg": found.battery_mass_kg}
        parts["battery"] = aircraft.battery.model_copy(update=battery)
    if aircraft.modules.layout is None:
        area = {"area_m2": found.module_area_m2}
        parts["modules"] = aircraft.modules.model_copy(update=area)
    return aircraft.model_copy(update=parts), found
