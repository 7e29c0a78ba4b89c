"""Sizing with a propulsion at its operating point.

The program has formulas that it can differentiate in place of the propulsion's own search for a
speed of rotation. The exact chain judges the optimum: a factor makes the two equal there, and the
program is solved again until that factor stays. A propeller by tables, which have corners, has
constant efficiencies in the program, found in the same way.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from missions.mission import Mission
from sizing.aircraft import PROPULSION_VARIABLES, Aircraft
from sizing.design import (
    DesignVariables,
    ImpossibleDesignError,
    design_of,
    first_chain,
    level_point,
    mixed_chain,
    operating_trouble,
    parametric_design,
)
from sizing.optimisation.coverage import widest_range
from sizing.optimisation.objectives import Objective
from sizing.optimisation.result import SizingResult
from sizing.optimisation.search import size_aircraft
from sizing.propulsion.chain import OperatingPointPropulsion, Propulsion
from sizing.smooth_propulsion import corrected, smooth_propulsion, with_propulsion
from sizing.sunlight import UNCORRECTED_CAM, SolarModel

_ROUNDS, _NARROWED = 12, 2
# What the efficiency may differ: of formulas, which miss it by little at once, and of constants.
_SETTLED, _SETTLED_CONSTANT, _SHRINKS = 1e-6, 1e-4, 0.5


@dataclass(frozen=True)
class _Request:
    """What is sized."""

    aircraft: Aircraft
    mission: Mission
    objective: Objective
    solar: SolarModel
    required_h: float | None

    def optimum(self, aircraft: Aircraft, start: DesignVariables | None) -> SizingResult:
        """Optimum with another propulsion; why there is none is not asked."""
        given = (aircraft, self.mission, self.objective, self.solar)
        hours = self.required_h
        if self.objective.of_range:
            return widest_range(*given, required_excess_time_h=hours).sizing
        return size_aircraft(*given, required_excess_time_h=hours, start=start, explain=False)

    def exact_chain(self, result: SizingResult) -> Propulsion:
        """Chain of the parts at an optimum."""
        assert result.design is not None
        variables = result.design.variables
        exact = parametric_design(
            *(self.aircraft, self.mission, variables, result.design.total_mass_kg),
            horizontal_volume=result.design.horizontal_volume,
        )
        assert exact.chain is not None
        if not isfinite(exact.chain.efficiency):
            raise ImpossibleDesignError(operating_trouble(self.aircraft, self.mission, variables))
        return exact.chain


def with_smooth_chain(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
) -> tuple[Aircraft, DesignVariables | None]:
    """Aircraft whose program can be built, with the exact chain's efficiency at its optimum.

    One with constants is returned as it is. Also returns the optimum, where one was searched for
    and found.

    Raises :class:`ImpossibleDesignError` if the propulsors cannot do level flight at the optimum.
    """
    given = (aircraft, mission, objective, solar)
    return sized_smoothly(*given, required_excess_time_h=required_excess_time_h)[:2]


def sized_smoothly(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    *,
    required_excess_time_h: float | None = None,
) -> tuple[Aircraft, DesignVariables | None, SizingResult | None]:
    """As :func:`with_smooth_chain`, with the sizing of the aircraft that is returned, if it was."""
    propulsion = getattr(aircraft.airframe, "propulsion", None)
    if not isinstance(propulsion, OperatingPointPropulsion) or not propulsion.is_exact:
        return aircraft, None, None
    request = _Request(aircraft, mission, objective, solar, required_excess_time_h)
    if propulsion.propeller.table is not None:
        return *_with_constants(request, propulsion), None
    smooth = smooth_propulsion(aircraft, mission, propulsion)
    start: DesignVariables | None = None
    sizes = set(PROPULSION_VARIABLES) & aircraft.design_space.requested_ranges().keys()
    for number in range(_ROUNDS):
        flown = with_propulsion(aircraft, smooth)
        result = request.optimum(flown, start)
        if result.design is None:
            return flown, start, None
        start = result.design.variables
        if sizes and number < _NARROWED:
            # Fitted anew, narrowly around the last optimum.
            smooth = smooth_propulsion(aircraft, mission, propulsion, result.design)
            smooth = corrected(smooth, aircraft, mission, result.design)
            continue
        point = level_point(aircraft, mission, result.design)
        before, smooth = smooth, corrected(smooth, aircraft, mission, result.design, point)
        moved = max(abs(a - b) for a, b in zip(smooth.correction, before.correction, strict=True))
        if moved < _SETTLED:
            if point.reason:
                raise ImpossibleDesignError(operating_trouble(aircraft, mission, start))
            return flown, start, None if objective.of_range else result
    raise _no_common_optimum(request, f"formulas and exact chain still differ by {moved:.1e}")


def _with_constants(
    request: _Request, propulsion: OperatingPointPropulsion
) -> tuple[Aircraft, DesignVariables | None]:
    """Aircraft with the constant efficiencies of its optimum.

    Without an optimum they are those of the design in the file, for what explains the failure.
    """
    aircraft = request.aircraft
    chain, before = first_chain(propulsion), 0.0
    start: DesignVariables | None = None
    for _ in range(_ROUNDS):
        fixed = with_propulsion(aircraft, _in_two_links(chain))
        result = request.optimum(fixed, start)
        if result.design is None:
            if start is None:
                own = design_of(aircraft, request.mission).chain or chain
                fixed = with_propulsion(aircraft, _in_two_links(own))
            return fixed, start
        start = result.design.variables
        exact = request.exact_chain(result)
        moved = exact.efficiency - chain.efficiency
        if abs(moved) < _SETTLED_CONSTANT:
            return with_propulsion(aircraft, _in_two_links(exact)), start
        # Each round moves by a share of the one before: the rest of the row is its sum.
        share = moved / before if abs(moved) < _SHRINKS * abs(before) else 0.0
        chain = mixed_chain(exact, chain, share / (1.0 - share))
        before = moved
    raise _no_common_optimum(request, f"the efficiency still moves by {abs(before):.1e}")


def _no_common_optimum(request: _Request, why: str) -> ImpossibleDesignError:
    return ImpossibleDesignError(
        f"design and propulsion of {request.aircraft.name} have no common optimum on "
        f"{request.mission.name}: {why}"
    )


def _in_two_links(chain: Propulsion) -> Propulsion:
    """Chain whose efficiencies are parameters of the program: motor's of all but the propeller."""
    links = {
        "wiring_efficiency": None,
        "controller_efficiency": 1.0,
        "gearbox_efficiency": 1.0,
        "motor_efficiency": chain.efficiency / chain.propeller_efficiency,
    }
    return chain.model_copy(update=links)
