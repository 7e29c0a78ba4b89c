"""What the product says of a wild problem, held against a search by simulation."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.simulated_search import Effort, Found, Judge, judge_of, search
from benchmarks.wild_problems import WildProblem
from missions.files.overrides import with_values
from sizing.aircraft import Aircraft
from sizing.day.light import DEFAULT_STEP_H
from sizing.design import DesignVariables
from sizing.limits import ROW_TOLERANCE
from sizing.performance import Performance
from sizing.program.objectives import Objective
from sizing.program.ranges import widest_range
from sizing.program.reasons import least_mission
from sizing.program.relaxations import relaxations
from sizing.program.result import (
    ABSOLUTE_TOLERANCE_H,
    RELATIVE_TOLERANCE,
    SizingResult,
    SizingStatus,
)
from sizing.program.size import size_aircraft, sized_in_own_flow
from sizing.relaxed_flight import Relaxation

_EDGE = 0.999  # of the largest excess time
_LESS = 0.01  # of a relaxation's value, without which it must not solve
_SAME = 1e-6  # relative, of what the product's own design is simulated to

# Verdicts; all but the first two speak against the product.
AGREE, BETTER = "agree", "product better"
FALSE_OPTIMUM, FALSE_INFEASIBLE = "false optimum", "false infeasible"
NOT_CONVERGED, UNSOUND, ERROR = "not converged", "unsound", "error"
PASSED = (AGREE, BETTER)


@dataclass(frozen=True)
class Claim:
    """What the product says: status, value and design; ``nearest`` where there is no optimum."""

    status: str
    value: float | None = None
    design: DesignVariables | None = None
    nearest: DesignVariables | None = None
    cpu_s: float = 0.0
    text: str = ""
    result: SizingResult | None = None
    aircraft: Aircraft | None = None  # with the flow of its optimum


def at_the_edge(problem: WildProblem) -> WildProblem:
    """Edge problems with the required excess time just below the largest one that there is."""
    if not problem.edge:
        return problem
    mission = least_mission(problem.aircraft, problem.mission, problem.objective)
    largest = size_aircraft(
        problem.aircraft,
        mission,
        Objective.max_excess_time,
        problem.solar,
        required_excess_time_h=0.0,
    )
    value = largest.objective_value
    if value is None or not math.isfinite(value):
        return problem
    return problem.requiring(_EDGE * value)


def claim_of(problem: WildProblem) -> Claim:
    """What the product says of a problem, with the flow of its optimum as in ``sizing.size``."""
    given = (problem.mission, problem.objective, problem.solar)
    hours: dict[str, Any] = {"required_excess_time_h": problem.required_h}
    begun = time.process_time()
    value: float | None
    aircraft = problem.aircraft
    try:
        if problem.objective.of_range:
            wide = widest_range(problem.aircraft, *given, **hours)
            result, value = wide.sizing, float(wide.extent)
        else:
            aircraft, result = sized_in_own_flow(aircraft, *given, **hours)
            value = result.objective_value
    except Exception as error:  # any of them is a finding
        cpu_s = time.process_time() - begun
        return Claim("error", cpu_s=cpu_s, text=f"{type(error).__name__}: {error}")
    cpu_s = time.process_time() - begun
    if result.design is None:
        nearest = None if result.nearest is None else result.nearest.design.variables.mapped(float)
        text = "; ".join(v.text for v in result.violations)
        return Claim(result.status.name, None, None, nearest, cpu_s, text, result)
    design = result.design.variables
    return Claim(result.status.name, value, design, None, cpu_s, result=result, aircraft=aircraft)


def judged(
    problem: WildProblem,
    claim: Claim,
    seed: int = 0,
    effort: Effort | None = None,
    earlier: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """Verdict on a claim, by a search that is independent of it.

    Parameters
    ----------
    problem : WildProblem
        With its final required excess time.
    claim : Claim
        What the product says.
    seed : int
        Of the search.
    effort : Effort, optional
        Length of the search.
    earlier : dict, optional
        Row of this very problem, whose design stands for a new search.

    Returns
    -------
    dict
        One row: the claim, what the search found, and the verdict.
    """
    if claim.aircraft is not None:
        problem = replace(problem, aircraft=claim.aircraft)
    judge = judge_of(problem)
    begun = time.process_time()
    if earlier is None:
        found = search(judge, seed, claim.design or claim.nearest, effort)
    else:
        found = _recalled(judge, earlier)
    searched_s = time.process_time() - begun
    verdict, gain = _verdict(judge, claim, found)
    return {
        "number": problem.seed,
        "objective": problem.objective.value,
        "required_h": problem.required_h,
        "model": problem.solar.model,
        "correction": problem.solar.correction,
        "tags": list(problem.tags),
        "status": claim.status,
        "value": _plain(claim.value),
        "design": _plain_design(claim.design),
        "says": claim.text,
        "product_cpu_s": claim.cpu_s,
        "verdict": verdict,
        "gain_percent": _plain(gain),
        "found": _plain(_signed(judge, found.cost)) if found.feasible else None,
        "found_by_chance": _plain(_signed(judge, found.cost_by_chance)),
        "missed": found.missed,
        "found_design": _plain_design(found.variables),
        "designs": judge.simulated,
        "search_cpu_s": searched_s,
    }


def _verdict(judge: Judge, claim: Claim, found: Found) -> tuple[str, float | None]:
    """Verdict, and by how many per cent the search is better than the product."""
    feasible = found.feasible and not math.isnan(_at(judge, found.variables, fine=True)[0])
    value = _signed(judge, found.cost)
    if claim.status == "error":
        return ERROR, None
    if claim.status == "not_converged":
        return NOT_CONVERGED, None
    if claim.value is None or claim.design is None:
        return (FALSE_INFEASIBLE if feasible else AGREE), None
    own, perf = _at(judge, claim.design)
    if math.isnan(own) or not _same(judge, own, claim.value):
        return UNSOUND, None
    if own == value or not found.feasible:
        return (AGREE if own == value else BETTER), 0.0
    gain = (value - own) if judge.problem.objective.maximised else (own - value)
    tolerance = _tolerance(judge, own, perf)
    percent = 100.0 * gain / max(abs(own), 1e-9)
    if gain > tolerance:
        return (FALSE_OPTIMUM if feasible else AGREE), percent
    return (BETTER if gain < -tolerance else AGREE), percent


def _recalled(judge: Judge, earlier: dict[str, Any]) -> Found:
    """Design that an earlier search found, simulated again."""
    variables = DesignVariables(**earlier["found_design"])
    value, _ = _at(judge, variables)
    missed = earlier["missed"] if math.isnan(value) else 0.0
    sign = -1.0 if judge.problem.objective.maximised else 1.0
    by_chance = earlier.get("found_by_chance")
    chance = sign * by_chance if isinstance(by_chance, float) else math.nan
    return Found(missed, sign * value, variables, chance)


def _at(
    judge: Judge, variables: DesignVariables, *, fine: bool = False
) -> tuple[float, Performance]:
    """Value of one design, NaN where it misses a requirement, and its performance."""
    step_h = judge.fine_step_h if fine else DEFAULT_STEP_H
    perf = judge.performance(variables.mapped(lambda v: np.atleast_1d(float(v))), step_h)
    value = judge.value(perf, judge.allowance_h if fine else 0.0)
    return float(value[0]), perf


def _same(judge: Judge, own: float, claimed: float) -> bool:
    if judge.problem.objective.of_range:
        return int(own) >= int(claimed)  # the design may do more than the range it was found for
    return own == claimed or abs(own - claimed) <= _SAME * max(abs(own), 1.0)


def _tolerance(judge: Judge, value: float, perf: Performance) -> float:
    """By how much a value must be better to count, in its unit; the cross-check's."""
    least = {
        Objective.max_excess_time: ABSOLUTE_TOLERANCE_H,
        Objective.max_payload_mass: ROW_TOLERANCE * float(perf.design.total_mass_kg[0]),
        Objective.max_payload_power: ROW_TOLERANCE * float(np.max(perf.nominal_load_w)),
        # Whole members; the fraction is the search's own.
        Objective.longest_season: 1.0,
        Objective.widest_latitude_band: 1.0,
    }
    return max(RELATIVE_TOLERANCE * abs(value), least.get(judge.problem.objective, 0.0))


def _signed(judge: Judge, cost: float) -> float:
    return -cost if judge.problem.objective.maximised else cost


def _plain(value: float | None) -> float | str | None:
    """Number for JSON, which has no infinity."""
    if value is None or math.isfinite(value):
        return value
    return "unlimited" if value > 0.0 else None


def _plain_design(design: DesignVariables | None) -> dict[str, float] | None:
    if design is None:
        return None
    return {name: float(value) for name, value in design.chosen().items()}


# --- relaxations ------------------------------------------------------------------------------


def checked_relaxations(problem: WildProblem, claim: Claim) -> list[dict[str, Any]]:
    """Relaxations of an infeasible problem, each tried at its printed value and with 1 % less.

    Parameters
    ----------
    problem : WildProblem
        As it was sized, for a single design.
    claim : Claim
        Infeasible.

    Returns
    -------
    list of dict
        Text and status of each, where ``optimal`` is as it should be, and the status with the value
        moved back by 1 %, where it is not; None where that is today's value or beyond.
    """
    if claim.result is None or claim.result.status is not SizingStatus.infeasible:
        return []
    given = (problem.aircraft, problem.mission, claim.result, problem.solar)
    try:
        return [
            {
                "text": found.text,
                "status": _relaxed_status(problem, found, float(f"{found.value:g}")),
                "with_less": _status_with_less(problem, found),
            }
            for found in relaxations(*given)
        ]
    except Exception as error:  # any of them is a finding
        return [{"text": f"{type(error).__name__}: {error}", "status": "error", "with_less": None}]


def _status_with_less(problem: WildProblem, found: Relaxation) -> str | None:
    """Status of the sizing with the value moved back by 1 %; latitudes move in steps."""
    if found.parameter.startswith("mission.latitude_deg"):
        return None
    upwards = found.direction == "at least"
    less = found.value * (1.0 - _LESS if upwards else 1.0 + _LESS)
    if less <= found.present if upwards else less >= found.present:
        return None
    return _relaxed_status(problem, found, less)


def _relaxed_status(problem: WildProblem, found: Relaxation, value: float) -> str:
    """Status of the sizing with one parameter at another value."""
    aircraft, mission, required_h = problem.aircraft, problem.mission, problem.required_h
    if found.parameter == "mission.required_excess_time_h":
        required_h = value
    elif found.parameter.startswith("mission."):
        mission = with_values(mission, {found.parameter.removeprefix("mission."): value})
    else:
        aircraft = with_values(aircraft, {found.parameter: value})
    result = size_aircraft(
        aircraft, mission, problem.objective, problem.solar, required_excess_time_h=required_h
    )
    return result.status.name
