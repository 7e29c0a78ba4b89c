"""What a sizing settles before the one that counts: propulsion, and the flow about its modules.

Of a propulsion at its operating point the program has formulas that it can differentiate in place
of the propulsion's own search for a speed of rotation. The exact chain judges the optimum: a factor
makes the two equal there, and the program is solved again until that factor stays. A propeller by
tables, which have corners, has constant efficiencies in the program, found in the same way.

The program takes the sun from the flow of the aircraft's first guess, and then from that of the
designs that it finds; how the simulator knows it from that of the first guess
(:mod:`sizing.module_power`) is exact at three flows. The optimum is flown in its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import NO_FLIGHT_W, Design, DesignVariables, parametric_design
from sizing.design_space import PROPULSION_VARIABLES
from sizing.mass_budget import (
    ImpossibleDesignError,
    design_of,
    first_chain,
    level_point,
    mixed_chain,
    operating_trouble,
)
from sizing.optimisation.result import SizingResult
from sizing.optimisation.search import size_aircraft, unjudged_optimum
from sizing.optimisation.variables import TOTAL_MASS
from sizing.parameters import with_parameter
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.ranges import widest_range
from sizing.propulsion.chain import OperatingPointPropulsion, Propulsion
from sizing.smooth_propulsion import corrected, smooth_propulsion
from sizing.sunlight import UNCORRECTED_CAM, SolarModel

_LIFT = "airframe.aerodynamics.lift_coefficient"
_ROUNDS, _NARROWED = 12, 2
_LEAST_MORE_H = 0.03  # of required excess time, where parts fly an optimum with less
_SHORT_AGAINST_WIND = "against the wind its parts fly every design with less than is required"
_SAME_H = 0.003  # of excess time: half of what the goal of a program has to spare
# What the efficiency may differ: of formulas, which miss it by little at once, and of constants.
_SETTLED, _SETTLED_CONSTANT, _SHRINKS = 1e-6, 1e-4, 0.5


@dataclass(frozen=True)
class _Request:
    """What is sized; ``more_h``: excess time beyond the required one that its program must have."""

    aircraft: Aircraft
    mission: Mission
    objective: Objective
    solar: SolarModel
    required_h: float | None
    more_h: float = 0.0

    @property
    def asked_h(self) -> float:
        """Required excess time of the mission, or instead of it [h]."""
        return self.mission.required_excess_time_h if self.required_h is None else self.required_h

    def as_asked(self, result: SizingResult) -> SizingResult | None:
        """Sizing under the required time that was asked for; None of a range."""
        result = replace(result, required_excess_time_h=self.asked_h)
        return None if self.objective.of_range else result

    def optimum(self, aircraft: Aircraft, start: DesignVariables | None) -> SizingResult:
        """Optimum with another propulsion; why there is none is not asked."""
        given = (aircraft, self.mission, self.objective, self.solar)
        hours = self.asked_h + self.more_h
        if self.objective.of_range:
            return widest_range(*given, required_excess_time_h=hours).sizing
        return size_aircraft(*given, required_excess_time_h=hours, start=start, explain=False)

    def first_design(self, aircraft: Aircraft) -> Design | None:
        """Design near the optimum with another propulsion; None where the quick way finds none."""
        if self.objective.of_range:
            return None
        given = (aircraft, self.mission, self.objective, self.solar)
        found = unjudged_optimum(*given, required_excess_time_h=self.asked_h)
        if found is None:
            return None
        mass_kg = found.value(TOTAL_MASS)
        return parametric_design(aircraft, self.mission, found.design, mass_kg)

    def exact_chain(self, result: SizingResult) -> Propulsion:
        """Chain of the parts at an optimum."""
        assert result.design is not None
        variables = result.design.variables
        mass_kg = result.design.total_mass_kg
        exact = parametric_design(self.aircraft, self.mission, variables, mass_kg)
        assert exact.chain is not None
        if not isfinite(exact.chain.efficiency):
            raise ImpossibleDesignError(operating_trouble(self.aircraft, self.mission, variables))
        return exact.chain

    def short_by_parts_h(self, result: SizingResult) -> float:
        """Excess time that an optimum lacks as its parts fly it against the wind [h].

        Formulas and parts are equal at the design's own airspeed, where alone they fly without a
        place to hold.
        """
        if not self.mission.holds_station:
            return 0.0
        assert result.design is not None
        found, known = result.design.variables, result.simulated
        assert known is not None
        flown = performance_of_designs(
            self.aircraft, self.mission, found, self.solar, day=known.day
        )
        if np.any(flown.nominal_load_w > NO_FLIGHT_W / 2.0):
            wind = np.max(self.mission.scenario_winds_m_per_s(known.day.scenarios))
            raise ImpossibleDesignError(
                f"the propulsion of {self.aircraft.name} cannot hold the wind of {wind:.3g} m/s on "
                f"{self.mission.name} at {self.mission.altitude_m:g} m, though its rated power "
                "would: give it other parts, or ask for less wind"
            )
        least_h = float(np.min(flown.cycle.excess_time_h))
        if least_h > 0.0 and least_h >= self.asked_h:
            return 0.0
        # How much is lacking, days that do not close do not tell.
        return max(self.asked_h - least_h if least_h > 0.0 else 0.0, _LEAST_MORE_H)


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
    propulsion = aircraft.propulsion_by_parts
    if propulsion is None or not propulsion.is_exact:
        return aircraft, None, None
    request = _Request(aircraft, mission, objective, solar, required_excess_time_h)
    if propulsion.propeller.table is not None:
        return _with_constants(request, propulsion)
    smooth = smooth_propulsion(aircraft, mission, propulsion)
    start: DesignVariables | None = None
    sizes = set(PROPULSION_VARIABLES) & aircraft.design_space.requested_ranges().keys()
    for number in range(_ROUNDS):
        flown = aircraft.with_airframe(propulsion=smooth)
        # The first round only tells where to compare.
        design, result = None if number else request.first_design(flown), None
        if design is None:
            result = request.optimum(flown, start)
            if result.design is None:
                return flown, start, None
            design = result.design
        start = design.variables
        if sizes and number < _NARROWED:
            # Fitted anew, narrowly around the last optimum.
            smooth = smooth_propulsion(aircraft, mission, propulsion, design)
            smooth = corrected(smooth, aircraft, mission, design)
            continue
        point = level_point(aircraft, mission, design)
        before, smooth = smooth, corrected(smooth, aircraft, mission, design, point)
        moved = max(abs(a - b) for a, b in zip(smooth.correction, before.correction, strict=True))
        why = f"formulas and exact chain still differ by {moved:.1e}"
        if moved < _SETTLED and result is not None:
            if point.reason:
                raise ImpossibleDesignError(operating_trouble(aircraft, mission, start))
            short_h = request.short_by_parts_h(result)
            if short_h <= 0.0:
                return flown, start, request.as_asked(result)
            request, why = replace(request, more_h=request.more_h + short_h), _SHORT_AGAINST_WIND
    raise _no_common_optimum(request, why)


def _with_constants(
    request: _Request, propulsion: OperatingPointPropulsion
) -> tuple[Aircraft, DesignVariables | None, SizingResult | None]:
    """Aircraft with the constant efficiencies of its optimum.

    Without an optimum they are those of the design in the file, for what explains the failure. The
    sizing as well where a place is held.
    """
    aircraft = request.aircraft
    chain, before = first_chain(propulsion), 0.0
    start: DesignVariables | None = None
    for _ in range(_ROUNDS):
        fixed = aircraft.with_airframe(propulsion=_in_two_links(chain))
        result = request.optimum(fixed, start)
        if result.design is None:
            if start is None:
                own = design_of(aircraft, request.mission).chain or chain
                fixed = aircraft.with_airframe(propulsion=_in_two_links(own))
            return fixed, start, None
        start = result.design.variables
        exact = request.exact_chain(result)
        moved = exact.efficiency - chain.efficiency
        why = f"the efficiency still moves by {abs(moved):.1e}"
        if abs(moved) < _SETTLED_CONSTANT:
            short_h = request.short_by_parts_h(result)
            if short_h <= 0.0:
                known = request.as_asked(result) if request.mission.holds_station else None
                settled = fixed.with_airframe(propulsion=_in_two_links(exact))
                return settled if known is None else fixed, start, known
            request, why = replace(request, more_h=request.more_h + short_h), _SHORT_AGAINST_WIND
        # Each round moves by a share of the one before: the rest of the row is its sum.
        share = moved / before if abs(moved) < _SHRINKS * abs(before) else 0.0
        chain = mixed_chain(exact, chain, share / (1.0 - share))
        before = moved
    raise _no_common_optimum(request, why)


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


def sized_in_own_flow(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    *,
    settled: SizingResult | None = None,
    **options: Any,
) -> tuple[Aircraft, SizingResult]:
    """Sizing, and the aircraft with its design as first guess where the flow cools its modules.

    The result is simulated with that aircraft's own sun. Where the known one was off by more than
    next to nothing, or the design is not enough after all, the sizing is repeated from there.
    ``settled``: sizing that is known. ``options``: as for
    :func:`~sizing.optimisation.search.size_aircraft`.
    """
    given = (mission, objective, solar)
    result = settled or size_aircraft(aircraft, *given, **options)
    flown = result.simulated or result.nearest
    if flown is None or not flown.day.is_cooled or not np.isfinite(flown.design.total_mass_kg):
        return aircraft, result
    variables = flown.design.variables.mapped(float)
    guessed = _first_guessed(aircraft, mission, variables)
    if not result.feasible:
        return guessed, result
    own = performance_of_designs(guessed, mission, variables, solar)
    least_h, known_h = (float(np.min(one.cycle.excess_time_h)) for one in (own, flown))
    enough = least_h > 0.0 and least_h >= result.required_excess_time_h
    if enough and (least_h == known_h or abs(least_h - known_h) < _SAME_H):
        return guessed, result.with_design(own)
    again = size_aircraft(guessed, *given, **options | {"start": variables})
    return guessed, again if again.feasible or not enough else result


def _first_guessed(aircraft: Aircraft, mission: Mission, found: DesignVariables) -> Aircraft:
    """Aircraft whose design point is that of a design, as far as its file has numbers for it."""
    guess = aircraft.with_airframe(wingspan_m=found.wingspan_m, aspect_ratio=found.aspect_ratio)
    if found.lift_coefficient is not None:
        guess, _ = with_parameter(guess, mission, _LIFT, found.lift_coefficient)
    parts: dict[str, Any] = {}
    if aircraft.battery.pack is None:
        battery = {"mass_kg": found.battery_mass_kg}
        parts["battery"] = aircraft.battery.model_copy(update=battery)
    if aircraft.modules.layout is None:
        area = {"area_m2": found.module_area_m2}
        parts["modules"] = aircraft.modules.model_copy(update=area)
    return guess.model_copy(update=parts)
