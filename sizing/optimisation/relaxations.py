"""What would make an infeasible mission feasible: the value of one parameter at a time.

Each relaxation is a sizing of its own: the program frees the parameter besides the design and moves
it no further than it must. The simulator confirms the design with the parameter at the value told,
which is rounded away from the edge.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables
from sizing.design_space import LimitedQuantity, LimitEnd
from sizing.limits import meets_requirements
from sizing.optimisation.cells import size_cells
from sizing.optimisation.infeasibility import least_mission
from sizing.optimisation.latitudes import nearest_latitude
from sizing.optimisation.loop import (
    PENALTY,
    Accepted,
    Search,
    Simulated,
    run,
    spare_sun,
    telling_scenarios,
)
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.result import (
    GOAL_CUSHION_H,
    ProblemInstance,
    SizingResult,
    SizingStatus,
    Solution,
)
from sizing.optimisation.search import size_aircraft
from sizing.optimisation.solver import ProgramSolver
from sizing.optimisation.variables import (
    SOLAR_TECHNOLOGY,
    TOTAL_MASS,
    WIND,
    WORST_EXCESS,
    Role,
    limit_rows,
)
from sizing.parameters import catalogue, parameter, parameter_value, with_parameter
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.relaxed_flight import Direction, Relaxation, rounded
from sizing.sunlight import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from solar.types import BoolArray

# A structure lighter than this fraction of today's is no relaxation; others may fall to the last.
_LEAST_RELATIVE = {
    f"airframe.structure.{key}": 0.5 for key in ("build", "calibration", "coefficient_kg")
}
_LEAST_OTHER = 1e-3
_WIDER = 4.0  # bounds of the design space are moved by no more than this factor
_AT_BOUND = 0.995
_BLOCKS = 2
MINIMAL = 0.01  # of the value told: with so much less of a change no design is feasible
_BISECTED = 1e-3  # of the value, well within that


def relaxations(
    aircraft: Aircraft,
    mission: Mission,
    result: SizingResult,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    problems: SizingProblems | None = None,
) -> list[Relaxation]:
    """Find what would make an infeasible mission feasible, one parameter at a time.

    Returns smallest relative change first; empty where no single parameter suffices.
    """
    if result.status is not SizingStatus.infeasible or result.nearest is None:
        raise ValueError(
            f"the sizing is {result.status.name}: only an infeasible one has relaxations"
        )
    search = _Relaxations(aircraft, mission, result, solar, problems or SizingProblems(aircraft))
    return sorted(search.all(), key=lambda found: found.relative_change)


class _Move(NamedTuple):
    """A variable of the program that may move, and the parameter that it stands for.

    ``furthest``: end of the variable that helps most, None where the design chooses. ``scale``: of
    the parameter per variable.
    """

    key: str
    name: str
    present: float
    ends: tuple[float, float]
    upwards: bool
    furthest: float | None = None
    scale: float = 1.0


class _Relaxations:
    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        result: SizingResult,
        solar: SolarModel,
        problems: SizingProblems,
    ) -> None:
        assert result.nearest is not None
        # What is to be carried as much as possible need not be carried at all.
        mission = least_mission(mission, result.objective)
        self.aircraft, self.mission, self.solar, self.problems = aircraft, mission, solar, problems
        self.nearest, self.required_h = result.nearest, result.required_excess_time_h
        self.objective = result.objective
        self.others_missed = {v.requirement for v in result.violations} - {"excess_time"}
        # A requirement that is met at the expense of another one stands in the way as well.
        held = {label.partition(" (")[0] for label in result.active_constraints}
        self.in_the_way = self.others_missed | held
        self.day = result.nearest.day
        self.solver = ProgramSolver(problems, mission, solar, self.day)
        self.start = result.nearest.design.variables.mapped(float)
        self.program = problems.of(_BLOCKS, eased=True, climb=self.solver.climb)
        self.technology = [v.name for v in self.program.of_role(Role.technology)]
        self.limits = limit_rows(aircraft)
        self.last: Solution | None = None

    def all(self) -> Iterable[Relaxation]:
        """Every relaxation that works."""
        found = [self._moved_relaxation(move) for move in (*self._of_values(), *self._of_ends())]
        found += [self._latitude(), self._required_excess()]
        return [one for one in found if one is not None]

    # --- one parameter in the program ----------------------------------------------------------

    def _of_values(self) -> Iterator[_Move]:
        """Technology and payload."""
        for key in self.technology:
            present, one = parameter_value(self.aircraft, self.mission, key), parameter(key)
            assert present is not None
            upwards, furthest = one.relaxable == "up", one.maximum / present
            if upwards and furthest <= 1.0:
                continue
            if not upwards:
                furthest = _LEAST_RELATIVE.get(key, _LEAST_OTHER)
            ends = (min(furthest, 1.0), max(furthest, 1.0))
            yield _Move(key, key, present, ends, upwards, furthest, present)
        for name in (v.name for v in self.program.of_role(Role.payload)):
            key = parameter(name).key
            present = parameter_value(self.aircraft, self.mission, key)
            if present and self.objective.variable != name:
                yield _Move(key, name, present, (0.0, present), False, 0.0)

    def _of_ends(self) -> Iterator[_Move]:
        """Bounds that the nearest design has reached, wind and limits that stand in the way."""
        reached = self.start.chosen() | {TOTAL_MASS: float(self.nearest.design.total_mass_kg)}
        for key in (key for key, one in catalogue().items() if one.kind == "bound"):
            bare = key.removeprefix("design_space.")
            name = bare.removesuffix(".maximum").removeprefix("maximum_")
            present = self.program.variables[self.program.index[name]].maximum
            if name != Objective.min_wingspan.variable and reached[name] < _AT_BOUND * present:
                continue
            if not math.isinf(present):
                yield _Move(key, name, present, (present, _WIDER * present), True)
        space, wind = self.aircraft.design_space, self.mission.strongest_wind_m_per_s
        if "airspeed_above_wind" in self.in_the_way and wind != 0.0:
            yield _Move(WIND, WIND, wind, (0.0, wind), False, 0.0)
        for name in (name for name in self.limits if name in self.in_the_way):
            quantity, end = self.limits[name]
            key = f"design_space.{space.key_of_limit(quantity, end)}"
            present = getattr(space.all_limits()[quantity], end)
            bounds, upwards = self.program.variables[self.program.index[name]], end == "maximum"
            ends = (1.0, bounds.maximum) if upwards else (bounds.minimum, 1.0)
            yield _Move(key, name, present, ends, upwards, scale=present)

    def _moved_relaxation(self, move: _Move) -> Relaxation | None:
        """Relaxation that moves a variable no further than it must, confirmed by the simulator."""
        moved = self._moved_least(move.name, move.ends, move.furthest, upwards=move.upwards)
        if moved is None:
            return None
        variables = moved.solution.design
        if move.name in variables._fields and move.name.startswith("payload"):
            variables = variables._replace(payload_mass_kg=None, payload_power_w=None)

        def eased(value: float) -> tuple[Aircraft, Mission]:
            if move.name in self.limits:
                return self._with_limit(*self.limits[move.name], value / move.present), self.mission
            if move.key == WIND:
                return self.aircraft, self.mission.in_wind(value)
            return with_parameter(self.aircraft, self.mission, move.key, value)

        found = move.scale * moved.solution.value(move.name)
        confirmed = self._confirmed_value(
            move.present, found, variables, eased, upwards=move.upwards
        )
        of = self.limits[move.name][0] if move.name in self.limits else move.key
        return confirmed and Relaxation(move.key, parameter(of).unit, move.present, *confirmed)

    def _moved_least(
        self, name: str, ends: tuple[float, float], furthest: float | None, *, upwards: bool
    ) -> Accepted | None:
        """Design that moves one variable no further than it must.

        Most variables cannot help at all: what the best design reaches with the variable as far as
        it goes tells this soonest. ``furthest`` is that end, or none where the design chooses.
        """
        sign = 1.0 if upwards else -1.0
        instance = ProblemInstance(
            cost={name: sign},
            goal_h=self.required_h + GOAL_CUSHION_H,
            freed=(name,),
            bounds={name: ends},
        )
        count = len(self.day.scenarios)
        scenarios = telling_scenarios(self.nearest, min(_BLOCKS, count))
        reached = self._solve(
            replace(
                ProblemInstance.of(Objective.max_excess_time, 0.0),
                freed=(name,),
                bounds={name: ends if furthest is None else (furthest, furthest)},
            ),
            scenarios,
            self.start,
        )
        at_its_end = self.last
        if reached is None or reached.value(WORST_EXCESS) < self.required_h:
            return None

        def solve(search: Search) -> Solution | None:
            before = reached if search.previous is None else search.previous
            return self._solve(search.instance, search.filled(), before.design)

        search = Search(instance, self.required_h, scenarios, solve, count=count)
        run(
            [search],
            lambda some: [
                self._simulated_eased(one.current, -sign * one.current.value(name)) for one in some
            ],
        )
        # The next parameter starts with the same cost, not with this one's.
        self.last = at_its_end
        return search.best

    def _solve(
        self, instance: ProblemInstance, scenarios: list[int], start: DesignVariables
    ) -> Solution | None:
        """Solution from the last one of the same program; none where it misses a requirement."""
        last = self.last
        solution = self.solver.solve(
            instance.penalised(PENALTY),
            scenarios,
            [start],
            efforts=("quick", "steady"),
            previous=last if last is not None and len(last.scenarios) == len(scenarios) else None,
        )
        if solution is None:
            return None
        self.last = solution
        return None if solution.missed() else solution

    def _eased(self, solution: Solution) -> tuple[Aircraft, Mission, SolarDay]:
        """Aircraft, mission and sun with the values that the program chose."""
        aircraft, mission, day = self.aircraft, self.mission, self.day
        for key in solution.instance.freed:
            present, chosen = parameter_value(aircraft, mission, key), solution.value(key)
            if key == WIND:
                mission = mission.in_wind(chosen)
            elif key in self.technology and present is not None:
                aircraft, mission = with_parameter(aircraft, mission, key, present * chosen)
                day = day.scaled(chosen) if key == SOLAR_TECHNOLOGY else day
            elif key in self.limits:
                aircraft = self._with_limit(*self.limits[key], chosen)
        return aircraft, mission, day

    def _with_limit(self, quantity: LimitedQuantity, end: LimitEnd, relative: float) -> Aircraft:
        """Aircraft with one of its limits multiplied by a factor."""
        space = self.aircraft.design_space
        limit = getattr(space.all_limits()[quantity], end) * relative
        eased = space.with_limit(quantity, end, limit)
        return self.aircraft.model_copy(update={"design_space": eased})

    def _simulated_eased(self, solution: Solution, merit: float) -> Simulated:
        """What the simulator finds for a solution, with the values that the program chose."""
        aircraft, mission, day = self._eased(solution)
        perf = performance_of_designs(aircraft, mission, solution.design, self.solar, day=day)
        worst = perf.worst_scenario()
        excess_h = float(perf.cycle.excess_time_h[worst])
        sound = bool(meets_requirements(aircraft, mission, perf.design))
        spare = spare_sun(perf, solution.instance.sunlit)
        sun = self.solver.flown_sun(perf, solution)
        return Simulated(excess_h, worst, merit, sound, perf, spare, sun)

    def _confirmed_value(
        self,
        present: float,
        found: float,
        variables: DesignVariables,
        eased: Callable[[float], tuple[Aircraft, Mission]],
        *,
        upwards: bool,
    ) -> tuple[Direction, float, float] | None:
        """Direction and value that the simulator confirms, and the worst excess time there.

        The program may stop at a design that needs more of the parameter than others: a sizing with
        a little less of a change tells, and then the value is bisected.
        """
        direction: Direction = "at least" if upwards else "at most"
        value = rounded(found, direction)
        worst_h = self._reached_by(variables, *eased(value))
        if worst_h is None:
            return None
        step = MINIMAL * (value or present)
        enough, short = value + (-step if upwards else step), present
        if (enough <= short if upwards else enough >= short) or not self._suffices(eased(enough)):
            return direction, value, worst_h
        enough = bisected(
            short,
            enough,
            lambda middle: self._suffices(eased(middle)),
            lambda found: _BISECTED * max(found, MINIMAL * present),
        )
        least = rounded(enough, direction)
        least_h = self._reached_h(self._largest_excess(*eased(least)))
        return (direction, value, worst_h) if least_h is None else (direction, least, least_h)

    def _suffices(self, eased: tuple[Aircraft, Mission]) -> bool:
        """Whether a sizing finds a design for another aircraft or mission."""
        return self._reached_h(self._largest_excess(*eased)) is not None

    def _reached_by(
        self, variables: DesignVariables, aircraft: Aircraft, mission: Mission
    ) -> float | None:
        """Worst excess time of a design; None if it is not enough, or something else is missed."""
        day = solar_day(aircraft, mission, self.solar, scenarios=self.day.scenarios)
        perf = performance_of_designs(aircraft, mission, variables, self.solar, day=day)
        worst_h = float(np.min(perf.cycle.excess_time_h))
        enough = worst_h > 0.0 and worst_h >= self.required_h
        return worst_h if enough and meets_requirements(aircraft, mission, perf.design) else None

    # --- latitude and required time ------------------------------------------------------------

    def _required_excess(self) -> Relaxation | None:
        """Largest excess time there is, where more is required."""
        worst_h = float(np.min(self.nearest.cycle.excess_time_h))
        # Missing anything else means that even without a required time no design exists.
        if self.others_missed or not 0.0 < worst_h < self.required_h:
            return None
        value = rounded(worst_h, "at most")
        return Relaxation(
            "mission.required_excess_time_h", "h", self.required_h, "at most", value, worst_h
        )

    def _latitude(self) -> Relaxation | None:
        """Latitude nearest to the mission's at which a design flies perpetually."""
        own = self.aircraft
        found = nearest_latitude(
            *(own, self.mission, self.solar, self.nearest),
            enough=self._enough,
            confirmed_h=lambda at: self._reached_h(self._largest_excess(own, at, explain=True)),
        )
        return found and Relaxation(found[0], "deg", *found[1:])

    def _enough(self, moved: list[Mission]) -> BoolArray:
        """Whether the required excess time is reached on each of some missions.

        Of the scenarios only those count that matter most to the nearest design.
        """
        telling = telling_scenarios(self.nearest, min(_BLOCKS, len(self.day.scenarios)))
        scenarios = [one.scenarios() for one in moved]
        latitudes = np.concatenate([one.latitude_deg[telling] for one in scenarios])
        days = np.concatenate([one.day_of_year[telling] for one in scenarios])
        sizings = size_cells(
            *(self.aircraft, self.mission, Scenarios(latitudes, days)),
            *(Objective.max_excess_time, self.solar),
            scenarios_per_cell=len(telling),
            required_excess_time_h=0.0,
            problems=self.problems,
        )
        return np.asarray(sizings.objective_value >= self.required_h)

    def _largest_excess(
        self, aircraft: Aircraft, mission: Mission, *, explain: bool = False
    ) -> SizingResult:
        """Sizing of another aircraft or mission for the largest excess time."""
        return size_aircraft(
            aircraft,
            mission,
            Objective.max_excess_time,
            self.solar,
            required_excess_time_h=0.0,
            problems=self.problems if aircraft is self.aircraft else None,
            start=self.start,
            explain=explain,
        )

    def _reached_h(self, result: SizingResult) -> float | None:
        """Worst excess time of a sizing; None if it is not enough."""
        worst_h = result.objective_value
        return worst_h if worst_h is not None and worst_h >= self.required_h else None


def bisected(
    short: float,
    enough: float,
    suffices: Callable[[float], bool],
    tolerance: Callable[[float], float],
    as_shown: Callable[[float], float] = float,
) -> float:
    """Value that is enough, next to one that is too short, within a tolerance of what is found.

    ``as_shown``: form in which values are tried.
    """
    while abs(enough - short) > tolerance(enough):
        middle = as_shown((short + enough) / 2.0)
        if middle in (short, enough):
            break
        if suffices(middle):
            enough = middle
        else:
            short = middle
    return enough
