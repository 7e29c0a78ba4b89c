"""The sizing program solved: which variables are free, what is minimised, where to start."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.design import DesignVariables, FlightConditions, variable_keys
from sizing.mass_budget import closed_design
from sizing.optimisation.climb_constraints import (
    Strategy,
    aloft_parameters,
    block_winds_m_per_s,
)
from sizing.optimisation.energy_constraints import NODES, light_of_days, sun_parameters
from sizing.optimisation.problem import SizingProblem, SizingProblems
from sizing.optimisation.result import FlownSun, ProblemInstance, Solution, SolverReport
from sizing.optimisation.solver_options import Effort
from sizing.optimisation.variables import (
    HEIGHT,
    TOTAL_MASS,
    WIND,
    WORST_EXCESS,
    Constraint,
    Role,
)
from sizing.parameters import parameter_value
from sizing.performance import Performance, performance, performance_of_designs
from sizing.sunlight import FINE_STEP_H, SolarDay, SolarModel, solar_day
from solar.types import FloatArray

# Another time step may take this from an excess time, or make another scenario the worst [h]: it is
# off by 0.002 h, but where the day returns just what the night takes, excess times leap by 0.05 h.
_BY_STEP_H = 0.1
_COARSE = 4  # time steps in one, where only the order of the scenarios counts

# Sequential quadratic programming ends where the point is feasible and the multipliers balance the
# cost. Old ones do so still where a requirement has only become easier, though it no longer binds;
# slightly off, they make the program look for its active requirements at least once.
_NOT_QUITE = 0.999

# Which requirement may be missed first: the excess time, then the energy over the cycle, and only
# as a last resort what makes the design an aircraft at all.
_SLACK_WEIGHTS = {"excess_time": 1.0, "energy_balance": 10.0, "battery_capacity": 10.0}
_OTHER_SLACK_WEIGHT = 100.0


# Where the least that is missed stands still: over so many steps, to this part of it, rows as well;
# and what is then missed beyond doubt, relative or in hours.
_STILL, _STILL_KEPT, _CLEARLY_MISSED = 30, 1e-3, 0.01
# A program with climbs starts from solutions without and with all height as well: optima of several
# heights, none among them, are common where the battery must be full before the aircraft climbs.
# From these where the ceiling is further above the floor than that [m], where few designs reach it.
_HELD_BETWEEN, _FAR_M = (0.4, 0.6, 0.8), 12e3
# Held where only level flight has been solved: short of the ceiling all rows have a way to give.
_BELOW_CEILING = 0.99
_AT_CEILING = 0.999  # a solution whose heights are all above need not be looked for from there
_SAME_COST = 1e-4  # of two solutions that are one; costs are logarithms, or payloads over a scale
_SETTLED = 1e-6  # what rows and derivatives may lack at an optimum without a kink


class _Posed(NamedTuple):
    """An instance as arguments of a program, all but the start."""

    problem: SizingProblem
    instance: ProblemInstance
    scenarios: tuple[int, ...]
    weights: FloatArray
    ends: Mapping[str, tuple[float, float]]
    limits: dict[str, Any]

    @property
    def heights(self) -> list[int]:
        """Places of the heights of climbs."""
        return [self.problem.index[v.name] for v in self.problem.of_role(Role.height)]

    def within(self, x: FloatArray) -> FloatArray:
        """Point moved into the bounds."""
        return np.clip(x, self.limits["lbx"], self.limits["ubx"])


class ProgramSolver:
    """Solves the programs of an aircraft for one mission, and counts the work.

    ``day``: sun in every scenario that may fill a block. ``by_model``: whether ``day`` is what the
    solar power model gives, so that a finer step may confirm it. ``nearly``: where the last solve
    stood still at a kink without clearly missing a requirement.
    """

    def __init__(
        self,
        problems: SizingProblems,
        mission: Mission,
        solar: SolarModel,
        day: SolarDay,
        *,
        by_model: bool = False,
    ) -> None:
        self.aircraft, self.problems = problems.aircraft, problems
        self.mission, self.solar, self.day = mission, solar, day
        self.by_model = by_model
        self._fine_days: dict[int, SolarDay] = {}
        self.conditions = FlightConditions.of(mission, problems.aircraft)
        climb = mission.climb
        self.climb: Strategy | None = None if climb is None else climb.strategy
        self._aloft = None if climb is None else aloft_parameters(mission, self.aircraft)
        far = climb is not None and climb.ceiling_m - mission.altitude_m > _FAR_M
        self._held_between = _HELD_BETWEEN if far or mission.holds_station else ()
        self._suns = sun_parameters(day, mission, range(len(day.scenarios)))
        self._winds = block_winds_m_per_s(mission, day.scenarios)
        self.work = SolverReport()
        self.unreached: set[float] = set()  # heights that no design has
        self.nearly: Solution | None = None

    def solve(
        self,
        instance: ProblemInstance,
        scenarios: Sequence[int],
        starts: Sequence[DesignVariables],
        *,
        efforts: Sequence[Effort] = ("quick",),
        previous: Solution | None = None,
    ) -> Solution | None:
        """First solution that is found; None where the solver fails.

        ``starts``: designs that the interior-point method starts from, one after the other.
        ``previous``: of a similar instance: sequential quadratic programming from there is tried
        first.
        """
        posed = self._posed(instance, scenarios)
        distinct = list(dict.fromkeys(scenarios))
        repeated = len(distinct) < len(scenarios)
        # An eased program only points the way: sizings confirm what it finds.
        rises = self.climb is not None and not posed.problem.of_role(Role.wind)
        known, level, from_floor = None, previous, list[DesignVariables]()
        if rises and previous is not None and _same_but_for_goal(posed, previous):
            known = self._solved(posed, "next", _warm(posed, previous))
            if known is not None and _cost_of(known) <= previous.rival:
                margin_cost = self._margin_cost(posed, known)
                return replace(known, rival=previous.rival, margin_cost=margin_cost)
            previous = None
        if rises and previous is None and instance.penalty != math.inf:
            # Without climbs a program takes a fraction of the time.
            at_floor = self._posed(instance, scenarios, climbs=False)
            level = self._from(at_floor, starts, ("quick",), None)
            if level is not None and not level.missed():
                from_floor = [level.design]
        efforts = () if repeated else efforts
        known = known or self._from(posed, [*from_floor, *starts], efforts, previous)
        if repeated and known is None:
            # Blocks of one scenario have equal rows, between which an active set may cycle.
            return self.solve(instance, distinct, starts, efforts=efforts)
        if not rises or (known is not None and instance.penalty == math.inf):
            return known
        found = [known, *self._risen(posed, starts, level, known)]
        # Of several the best: a little height may be worth less than none, and more than either.
        solved = sorted((one for one in found if one is not None), key=_cost_of)
        if not solved:
            return None
        heights = solved[0].x[posed.heights]
        if np.ptp(heights) == 0.0 and 0.0 < heights[0] < _BELOW_CEILING:
            # Still held: steps from there have ended at a kink.
            freed = self._solved(posed, "quick", {"x0": solved[0].x})
            if freed is not None and _cost_of(freed) < _cost_of(solved[0]):
                solved.insert(0, freed)
        others = (_cost_of(one) for one in solved if not _same_cost(one, solved[0]))
        margin_cost = self._margin_cost(posed, solved[0])
        return replace(solved[0], rival=min(others, default=math.inf), margin_cost=margin_cost)

    def _margin_cost(self, posed: _Posed, solution: Solution) -> float:
        """What a unit of margin adds to the cost, by the multipliers of all rows that know it."""
        step = 1e-4
        more = replace(posed.instance, margin=posed.instance.margin + step)
        now, then = (
            np.asarray(posed.problem.program.rows(solution.x, one.limits["p"])[1]).ravel()
            for one in (posed, self._posed(more, posed.scenarios))
        )
        return abs(float(solution.constraint_multipliers @ (then - now))) / step

    def _risen(
        self,
        posed: _Posed,
        starts: Sequence[DesignVariables],
        level: Solution | None,
        known: Solution | None,
    ) -> Iterator[Solution]:
        """Solutions next to those whose heights are all held at one value, from none to all.

        Each starts from the one before, the first from the optimum of ``level`` flight.
        """
        last, highest = level, 0.0 if known is None else known.x[posed.heights].min()
        # What is missed at the floor as well is missed by as much from there.
        heights = [0.0]
        if known is not None and level is not None and level.missed() and _as_good(known, level):
            heights = []
        heights += [*self._held_between, 1.0]
        if known is None:
            heights.append(_BELOW_CEILING)
        for height in heights:
            if height > 0.0 and highest >= _AT_CEILING:
                return
            near = known if known is not None and height == 1.0 else last
            held = None if height in self.unreached else self._held(posed, height, starts, near)
            if held is None:
                continue
            last = held
            freed = self._solved(posed, "next", _warm(posed, held)) or held
            highest = max(highest, freed.x[posed.heights].min())
            yield freed
            if height == 1.0:
                return

    def _held(
        self,
        posed: _Posed,
        height: float,
        starts: Sequence[DesignVariables],
        previous: Solution | None,
    ) -> Solution | None:
        """Solution with all heights held at one value."""
        places = posed.heights
        lower, upper = (np.array(posed.limits[key]) for key in ("lbx", "ubx"))
        lower[places] = upper[places] = height
        ends = posed.limits | {"lbx": lower, "ubx": upper}
        held = self._from(posed._replace(limits=ends), starts, ("quick",), previous)
        if held is None and posed.instance.penalty is not None:
            self.unreached.add(height)  # every other row has a way to give
        return held

    def _from(
        self,
        posed: _Posed,
        starts: Sequence[DesignVariables],
        efforts: Sequence[Effort],
        previous: Solution | None,
    ) -> Solution | None:
        """First solution that is found."""
        problem, instance = posed.problem, posed.instance
        if previous is not None and _leads_to(previous, posed):
            solution = self._solved(posed, "next", _warm(posed, previous))
            if solution is not None:
                return solution
        for number, variables in enumerate(starts):
            begin = self._start_vector(problem, instance, variables)
            if number == 0 and instance.penalty != math.inf:
                solution = self._directly(posed, begin)
                if solution is not None:
                    return solution
            for effort in efforts:
                soft = effort == "quick" and instance.penalty not in (None, math.inf)
                solution = self._solved(
                    posed, "still" if soft else effort, {"x0": posed.within(begin)}
                )
                if solution is not None:
                    return solution
        return None

    def _directly(self, posed: _Posed, begin: FloatArray) -> Solution | None:
        """Solution that meets every requirement, by a few whole steps from a point."""
        problem = posed.problem
        lower, upper = np.array(posed.limits["lbx"]), np.array(posed.limits["ubx"])
        upper[[problem.index[v.name] for v in problem.of_role(Role.slack)]] = 0.0
        # No excess time below zero: the same as no charge below zero, but for a sun that carries
        # the load. Of two equal requirements that is left whose name is told.
        if not posed.instance.sunlit:
            lower[[problem.index[v.name] for v in problem.of_role(Role.dawn_state)]] = -1.0
        strict = posed._replace(limits=posed.limits | {"lbx": lower, "ubx": upper})
        return self._solved(strict, "direct", {"x0": strict.within(begin)})

    def performance(self, variables: DesignVariables, *, coarse: bool = False) -> Performance:
        """Design, or a batch of them, simulated in all scenarios, on request by coarse steps."""
        day = self.day.coarsened(_COARSE) if coarse else self.day
        return performance_of_designs(self.aircraft, self.mission, variables, self.solar, day=day)

    def least_excess_h(self, perf: Performance, required_h: float) -> float:
        """Excess time of one design in its worst scenario [h].

        Where it is just enough, the less of two time steps.
        """
        excess_h = perf.cycle.excess_time_h
        least_h = float(np.min(excess_h))
        to_spare_h = least_h - required_h
        if not self.by_model or least_h <= 0.0 or not 0.0 <= to_spare_h <= _BY_STEP_H:
            return least_h
        some = np.flatnonzero(excess_h <= least_h + _BY_STEP_H).tolist()
        fine = performance(
            *(self.aircraft, self.mission, self.solar),
            day=SolarDay.joined([self._fine_day(scenario) for scenario in some]),
            design=perf.design,
        )
        return min(least_h, float(np.min(fine.cycle.excess_time_h)))

    def _fine_day(self, scenario: int) -> SolarDay:
        """Sun of one scenario with a fine time step."""
        if scenario not in self._fine_days:
            alone = self.day.at([scenario]).scenarios
            self._fine_days[scenario] = solar_day(
                *(self.aircraft, self.mission, self.solar), scenarios=alone, step_h=FINE_STEP_H
            )
        return self._fine_days[scenario]

    def _posed(
        self, instance: ProblemInstance, scenarios: Sequence[int], *, climbs: bool = True
    ) -> _Posed:
        """Arguments of the program with these scenarios in its blocks, with climbs or without."""
        begun = time.perf_counter()
        climb = self.climb if climbs else None
        kind: Any = {"climb": climb, "holds": self.mission.holds_station}
        problem = self.problems.of(len(scenarios), **kind)
        if any(name not in problem.index for name in instance.freed):
            problem = self.problems.of(len(scenarios), eased=True, **kind)
        self.work += SolverReport(build_time_s=time.perf_counter() - begun)
        weights = problem.weights(_cost(problem, instance))
        suns = self._suns_of(instance, scenarios)
        if climb is None:
            suns = np.hstack([suns[:, : 2 * NODES], suns[:, -3:]])
        sunlit = [scenario in instance.sunlit for scenario in scenarios]
        suns[:, -1] *= np.where(sunlit, 1.0 / (1.0 + instance.spare_sun), 0.0)
        ends = self._variable_bounds(problem, instance)
        lower, upper = np.array(
            [[v.to_program(end) for end in ends[v.name]] for v in problem.variables]
        ).T
        conditions = self.conditions
        if instance.wind_m_per_s is not None:
            conditions = conditions._replace(wind_m_per_s=instance.wind_m_per_s)
        limits = {
            "p": problem.parameters(
                *(weights, conditions, suns),
                margin=instance.margin,
                aloft=None if climb is None else self._aloft,
                winds=self._winds[list(scenarios), : 1 if climb is None else None],
            ),
            "lbx": lower,
            "ubx": upper,
            "lbg": np.array([_least(row, instance, scenarios) for row in problem.constraints]),
            "ubg": np.array([0.0 if c.equation else np.inf for c in problem.constraints]),
        }
        return _Posed(problem, instance, tuple(scenarios), weights, ends, limits)

    def _suns_of(self, instance: ProblemInstance, scenarios: Sequence[int]) -> FloatArray:
        """Sun of scenarios, with the lowest power of the day in each."""
        flown = {} if instance.sun is None else instance.sun.rows
        return np.stack([flown.get(one, self._suns[one]) for one in scenarios])

    def flown_sun(self, perf: Performance, solution: Solution) -> FlownSun | None:
        """Sun in the flow of a solution's design; None where no flow cools the modules.

        ``perf``: of the design, in the scenarios of the solver's day.
        """
        if not self.day.is_cooled:
            return None
        own = perf.sun_in_own_flow(self.day).at(solution.scenarios)
        return self.sun_of(own, solution)

    def sun_of(self, own: SolarDay, solution: Solution) -> FlownSun:
        """Sun in the flow of a solution's design, of which ``own`` is the day in its blocks."""
        rows = sun_parameters(own, self.mission, range(len(own.scenarios)))
        had = self._suns_of(solution.instance, solution.scenarios)
        heights = solution.heights if solution.climbs else np.zeros(len(rows))
        now, then = (light_of_days(one, heights) for one in (rows, had))
        off = np.max(np.abs(now - then) / np.where(now > 0.0, now, 1.0))
        return FlownSun(dict(zip(solution.scenarios, rows, strict=True)), float(off))

    def _solved(
        self, posed: _Posed, effort: Effort, start: Mapping[str, FloatArray]
    ) -> Solution | None:
        """Solution from a start; None where the solver fails."""
        program = posed.problem.program
        with program.lock:
            begun = time.perf_counter()
            solver = program.solver(effort)
            built = time.perf_counter()
            answer: Any = solver(**(posed.limits | dict(start)))
            solved = time.perf_counter()
            stats = solver.stats()
        self.work += SolverReport(
            iterations=int(stats["iter_count"]),
            time_s=solved - built,
            build_time_s=built - begun,
            solves=1,
            message=str(stats["return_status"]),
        )
        x, rows, bounds = (np.asarray(answer[k]).ravel() for k in ("x", "lam_g", "lam_x"))
        problem, instance = posed.problem, posed.instance
        stands = instance.penalty is not None and _stands_still(stats, effort)
        self.nearly = None
        if not ((stats["success"] or stands) and np.isfinite(x).all()):
            return None
        slacks = [problem.index[v.name] for v in problem.of_role(Role.slack)]
        # With climbs most optima lie at a kink: whether one misses anything the simulator decides.
        doubtful = bool(stands and np.all(x[slacks] < _CLEARLY_MISSED)) and not program.climbs
        if stands and not doubtful:
            x[slacks] = np.where(x[slacks] < _CLEARLY_MISSED, 0.0, x[slacks])
        design = problem.design_variables(x, posed.ends)
        solution = Solution(
            *(instance, problem.variables, problem.constraints, posed.scenarios, design),
            *(x, posed.weights, rows, bounds),
        )
        if doubtful:
            self.nearly = solution
            return None
        return solution

    def _variable_bounds(
        self, problem: SizingProblem, instance: ProblemInstance
    ) -> dict[str, tuple[float, float]]:
        """Least and largest value of each variable, in its unit; the same where it is held."""
        most_h = problem.variables[problem.index[WORST_EXCESS]].maximum
        held = self._held_values(problem) | dict(instance.held)
        fixed = {name: (at, at) for name, at in held.items() if name not in instance.freed}
        fixed[WORST_EXCESS] = (instance.goal_h, most_h if instance.best_excess else instance.goal_h)
        if instance.penalty is None:
            fixed |= {v.name: (0.0, 0.0) for v in problem.of_role(Role.slack)}
        own = {v.name: (v.minimum, v.maximum) for v in problem.variables}
        return own | {k: v for k, v in (dict(instance.bounds) | fixed).items() if k in own}

    def _held_values(self, problem: SizingProblem) -> dict[str, float]:
        """Variables that stay as aircraft and mission have them unless they are freed."""
        relative = {v.name: 1.0 for v in problem.of_role(Role.technology, Role.limit)}
        payload = self.mission.payload
        carried = {"payload_mass_kg": payload.mass_kg, "payload_power_w": payload.power_w}
        return relative | carried | {WIND: self.conditions.wind_m_per_s}

    def _start_vector(
        self, problem: SizingProblem, instance: ProblemInstance, variables: DesignVariables
    ) -> FloatArray:
        """Decision vector to start from: a design, its mass, and what the rest is likely to be."""
        design = closed_design(self.aircraft, self.mission, variables)
        mass = float(design.total_mass_kg)
        polar = getattr(self.aircraft.airframe, "aerodynamics", None)
        guess = self._held_values(problem) | {
            TOTAL_MASS: mass if np.isfinite(mass) else 3.0 * variables.battery_mass_kg,
            "lift_coefficient": getattr(polar, "flight_lift_coefficient", 1.0),
            WORST_EXCESS: instance.goal_h + 1.0,
        }
        own = {n: parameter_value(self.aircraft, None, k) for k, n in variable_keys().items()}
        guess |= {n: v for n, v in own.items() if v is not None and n not in guess}
        guess |= {name: float(value) for name, value in variables.chosen().items()}
        guess["module_area_m2"] = max(guess["module_area_m2"], 1e-3)
        return np.array([v.to_program(guess.get(v.name, v.first_guess)) for v in problem.variables])


def _least(row: Constraint, instance: ProblemInstance, scenarios: Sequence[int]) -> float:
    """Least value of a row: in the program climbs end too high by their error."""
    if row.name != HEIGHT or row.block is None:
        return 0.0
    return instance.height_errors.get(scenarios[row.block], 0.0)


def _stands_still(stats: Mapping[str, Any], effort: Effort) -> bool:
    """Whether interior points have ended where the cost stands still, at an optimum with a kink.

    There steps go to and fro, and nothing but the derivative along the kink fails to vanish.
    """
    course = stats.get("iterations", {})
    if "obj" not in course:
        return False
    if effort == "still" and stats["return_status"] == "Solved_To_Acceptable_Level":
        return bool(max(course["inf_pr"][-1], course["inf_du"][-1]) > _SETTLED)
    if stats["return_status"] != "Maximum_Iterations_Exceeded":
        return False
    cost = np.array(course["obj"][-_STILL:])
    kept = max(course["inf_pr"][-_STILL:]) < _STILL_KEPT
    return bool(kept and np.ptp(cost) < _STILL_KEPT * abs(cost[-1]))


def _cost_of(solution: Solution) -> float:
    return float(solution.weights @ solution.x)


def _as_good(one: Solution, other: Solution) -> bool:
    """Whether a solution that misses something costs no more than another one."""
    return _cost_of(one) <= (1.0 + _SAME_COST) * _cost_of(other)


def _same_cost(one: Solution, other: Solution) -> bool:
    return abs(_cost_of(one) - _cost_of(other)) <= _SAME_COST


def _same_but_for_goal(posed: _Posed, previous: Solution) -> bool:
    """Whether a solution differs by what the simulator corrects, in the same scenarios."""
    now, then = posed.instance, previous.instance
    by_simulator = ("goal_h", "margin", "spare_sun", "height_errors", "sun", "penalty")
    then = replace(then, **{name: getattr(now, name) for name in by_simulator})
    same = then == now and previous.scenarios == posed.scenarios
    return same and now.penalty != math.inf and previous.climbs


def _leads_to(previous: Solution, posed: _Posed) -> bool:
    """Whether a solution has the rows of a program, but for the heights of climbs."""
    rows = [row for row in posed.problem.constraints if row.name != HEIGHT or previous.climbs]
    return previous.constraints == tuple(rows)


def _warm(posed: _Posed, previous: Solution) -> dict[str, FloatArray]:
    """Start of the solver from the point and the multipliers of a solution.

    Variables that the solution's program did not have begin where they are held.
    """
    x, bounds, rows = previous.x, previous.bound_multipliers, previous.constraint_multipliers
    if previous.constraints != posed.problem.constraints:
        known_rows = dict(zip(previous.constraints, rows, strict=True))
        rows = np.array([known_rows.get(row, 0.0) for row in posed.problem.constraints])
    if previous.variables is not posed.problem.variables:
        names = posed.problem.program.names
        place = {v.name: i for i, v in enumerate(previous.variables)}
        known = [place.get(name, -1) for name in names]
        x, bounds = (np.where(np.array(known) < 0, 0.0, one[known]) for one in (x, bounds))
    multipliers = _NOT_QUITE * np.concatenate([bounds, rows])
    # QRQP of CasADi 3.8 notes which multipliers change their signs, and has no memory for all of
    # them. Of interior points none is zero, and all may.
    multipliers[np.argmin(np.abs(multipliers))] = 0.0
    lam_x0, lam_g0 = np.split(multipliers, [len(bounds)])
    return {"x0": posed.within(x), "lam_x0": lam_x0, "lam_g0": lam_g0}


def _cost(problem: SizingProblem, instance: ProblemInstance) -> dict[str, float]:
    """Cost of an instance, with what a missed requirement costs."""
    if instance.penalty is None:
        return dict(instance.cost)
    weights = {
        slack: _SLACK_WEIGHTS.get(row.name, _OTHER_SLACK_WEIGHT)
        for row in problem.constraints
        for slack in row.slacks
    }
    if math.isinf(instance.penalty):
        return weights
    # The rows of the energy count in fractions of the battery, those of the excess time in tenths
    # of the day; what makes a design an aircraft at all must not be traded.
    traded = {name: instance.penalty * weight**0.5 for name, weight in weights.items()}
    return traded | dict(instance.cost)
