"""Sizing with a propulsion at its operating point.

The program takes constant efficiencies, which keeps it smooth and small. They are those of the
exact chain at the optimum, put in and solved for again until they stay.
"""

from __future__ import annotations

from math import isfinite

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import (
    DesignVariables,
    ImpossibleDesignError,
    design_of,
    first_chain,
    mixed_chain,
    operating_trouble,
    parametric_design,
)
from sizing.optimisation.coverage import widest_range
from sizing.optimisation.objectives import Objective
from sizing.optimisation.result import SizingResult
from sizing.optimisation.search import size_aircraft
from sizing.propulsion.chain import OperatingPointPropulsion, Propulsion
from sizing.sunlight import UNCORRECTED_CAM, SolarModel

__all__ = ["with_fixed_chain"]

_ROUNDS, _SETTLED, _SHRINKS = 12, 1e-4, 0.5


def with_fixed_chain(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
) -> tuple[Aircraft, DesignVariables | None]:
    """Aircraft with the constant efficiencies that its optimum has at its operating point.

    One with constants is returned as it is. Without an optimum the efficiencies are those of the
    design in the file, for what explains the failure. Its motor's efficiency is that of all links
    but the propeller. Also returns the optimum, where one was searched for.

    Raises :class:`ImpossibleDesignError` if the propulsors cannot do level flight at the optimum.
    """
    propulsion = getattr(aircraft.airframe, "propulsion", None)
    if not isinstance(propulsion, OperatingPointPropulsion):
        return aircraft, None
    chain, before = first_chain(propulsion), 0.0
    start: DesignVariables | None = None
    for _ in range(_ROUNDS):
        fixed = _with(aircraft, chain)
        result = _optimum(fixed, mission, objective, solar, required_excess_time_h, start)
        if result.design is None:
            if start is None:
                fixed = _with(aircraft, design_of(aircraft, mission).chain or chain)
            return fixed, start
        start = result.design.variables
        exact = parametric_design(aircraft, mission, start, result.design.total_mass_kg)
        assert exact.chain is not None
        if not isfinite(exact.chain.efficiency):
            raise ImpossibleDesignError(operating_trouble(aircraft, mission, start))
        moved = exact.chain.efficiency - chain.efficiency
        if abs(moved) < _SETTLED:
            return _with(aircraft, exact.chain), start
        # Each round moves by a share of the one before: the rest of the row is its sum.
        share = moved / before if abs(moved) < _SHRINKS * abs(before) else 0.0
        chain = mixed_chain(exact.chain, chain, share / (1.0 - share))
        before = moved
    raise ImpossibleDesignError(
        f"design and propulsion of {aircraft.name} have no common optimum on {mission.name}: the "
        f"efficiency still moves by {abs(before):.1e}"
    )


def _optimum(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    required_h: float | None,
    start: DesignVariables | None,
) -> SizingResult:
    """Optimum with constant efficiencies; why there is none is not asked."""
    given = (aircraft, mission, objective, solar)
    if objective.of_range:
        return widest_range(*given, required_excess_time_h=required_h).sizing
    return size_aircraft(*given, required_excess_time_h=required_h, start=start, explain=False)


def _with(aircraft: Aircraft, chain: Propulsion) -> Aircraft:
    """Aircraft with a chain whose efficiencies are parameters of the program, of any kind."""
    links = {
        "wiring_efficiency": None,
        "controller_efficiency": 1.0,
        "gearbox_efficiency": 1.0,
        "motor_efficiency": chain.efficiency / chain.propeller_efficiency,
    }
    airframe = aircraft.airframe.model_copy(update={"propulsion": chain.model_copy(update=links)})
    return aircraft.model_copy(update={"airframe": airframe})
