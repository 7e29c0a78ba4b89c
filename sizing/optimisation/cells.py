"""Many sizings of one aircraft at once: a design for every cell of a map.

Every cell is one place on one day, or a few such scenarios together, with a payload and a required
excess time of its own if need be. Each has its own search (:mod:`sizing.optimisation.loop`);
their programs are solved one after the other and simulated together. The requirements are
penalised: missing one costs more than any design could save, so that a cell without a design ends
as quickly as one that has it, and says what it lacks. Each program is solved by sequential
quadratic programming from the last one's solution and multipliers; where that fails, by the
interior-point method from the aircraft's own design.

Source of the penalty: Nocedal, J. and Wright, S. J. (2006), Numerical Optimization, section 17.2:
an exact penalty has the solutions of the original problem once it outweighs the multipliers. Where
it may not have, the least that must be missed decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, parametric_design, variables_of
from sizing.limits import Requirement, design_requirements, meets_requirements
from sizing.optimisation.energy_constraints import growing_lit_sets, lowest_power
from sizing.optimisation.infeasibility import percent, texts_of_requirements
from sizing.optimisation.loop import PENALTY, Search, Simulated, run
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.result import (
    ABSOLUTE_TOLERANCE_H,
    RELATIVE_TOLERANCE,
    ProblemInstance,
    SizingStatus,
    Solution,
    merit_of,
    objective_value,
)
from sizing.optimisation.search import checked_problems
from sizing.optimisation.solver import ProgramSolver
from sizing.optimisation.solver_options import Effort
from sizing.optimisation.variables import Role
from sizing.performance import Performance, performance_of_pairs
from sizing.program.objectives import Objective
from sizing.smooth import Value
from sizing.sunlight import UNCORRECTED_CAM, SolarModel, solar_day
from solar.types import FloatArray

# Costs of missed requirements in units of the cost; see the module's docstring.
_PENALTIES = (10.0, PENALTY)
_ROUNDS = 6
# Cross-check: random neighbours of every optimum, and by how much one may be better.
_NEIGHBOURS = 24
_SPREADS = (0.03, 0.004)


@dataclass(frozen=True)
class CellSizings:
    """Designs of all cells; arrays over the cells, NaN where there is no design.

    ``status``: see :class:`sizing.optimisation.result.SizingStatus`; ``cross_checked`` where none
    of the random neighbours of an optimum is better by more than 0.5 %. ``objective_value``:
    objective as the simulator finds it. ``total_mass_kg``, ``excess_time_h``, ``charge_margin_h``,
    ``minimum_state_of_charge``: of the design, as the simulator finds them. ``airspeed_m_per_s``,
    ``load_w``: of level flight, and nominal load. ``requirement``: requirement that is missed most
    where the cell is infeasible, empty elsewhere. ``shortfall``: by how much, relative to its
    limit; excess time in hours. ``message``: the same in words, as a sizing of that cell alone says
    it.
    """

    status: NDArray[np.int_]
    objective_value: FloatArray
    variables: DesignVariables
    total_mass_kg: FloatArray
    excess_time_h: FloatArray
    charge_margin_h: FloatArray
    minimum_state_of_charge: FloatArray
    airspeed_m_per_s: FloatArray
    load_w: FloatArray
    requirement: NDArray[np.str_]
    shortfall: FloatArray
    message: NDArray[np.object_]


def size_cells(
    aircraft: Aircraft,
    mission: Mission,
    scenarios: Scenarios,
    objective: Objective = Objective.min_wingspan,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    scenarios_per_cell: int = 1,
    required_excess_time_h: ArrayLike | None = None,
    payload_mass_kg: ArrayLike | None = None,
    payload_power_w: ArrayLike | None = None,
    problems: SizingProblems | None = None,
    seed: int = 0,
) -> CellSizings:
    """Size a parametric aircraft for many cells.

    Neighbouring cells should follow each other. Results depend on the other cells within the
    search's tolerance: the same cells in the same order give the same bits.

    Parameters
    ----------
    aircraft, mission, objective, solar
        As for :func:`sizing.optimisation.search.size_aircraft`; latitude and dates of the
        mission play no part.
    scenarios : Scenarios
        Latitude and day of every cell.
    scenarios_per_cell : int
        How many scenarios, following each other, make one cell; the worst of them counts. All of
        them are in the program: a handful, not hundreds.
    required_excess_time_h : array_like, optional
        Of all cells or of each, instead of the mission's [h].
    payload_mass_kg, payload_power_w : array_like, optional
        Payload of every cell, instead of the mission's.
    problems : SizingProblems, optional
        Programs of this very aircraft.
    seed : int
        Of the random neighbours of the cross-check.

    Returns
    -------
    CellSizings

    Raises
    ------
    TypeError
        For a measured aircraft.
    ValueError
        For an objective that is a range, programs of another aircraft, or scenarios that do not
        fill the cells.
    """
    if scenarios_per_cell < 1 or len(scenarios) % scenarios_per_cell:
        raise ValueError(
            f"{len(scenarios)} scenarios do not make cells of {scenarios_per_cell} each"
        )
    problems = checked_problems(aircraft, objective, problems)
    count = len(scenarios) // scenarios_per_cell

    def each(given: ArrayLike | None, otherwise: float) -> FloatArray:
        return np.array(np.broadcast_to(otherwise if given is None else given, count), float)

    required = each(required_excess_time_h, mission.required_excess_time_h)
    payload = {
        "payload_mass_kg": each(payload_mass_kg, mission.payload.mass_kg),
        "payload_power_w": each(payload_power_w, mission.payload.power_w),
    }
    day = solar_day(aircraft, mission, solar, scenarios=scenarios)
    solver = ProgramSolver(problems, mission, solar, day)
    return _Cells(solver, objective, required, payload, seed, scenarios_per_cell).run()


class _CellSearch(Search):
    """Search for the design of one cell; what it misses whatever the design stays in ``missed``."""

    def __init__(self, cells: _Cells, cell: int, sunlit: Sequence[int] = ()) -> None:
        required_h = float(cells.required_h[cell])
        held = {name: float(values[cell]) for name, values in cells.payload.items()}
        instance = replace(
            ProblemInstance.of(cells.objective, required_h),
            held=held,
            wind_m_per_s=float(cells.wind_m_per_s[cell]),
        )
        super().__init__(
            instance.always_lit(sunlit, all_of_them=len(sunlit) == cells.each),
            required_h,
            range(cell * cells.each, (cell + 1) * cells.each),
            cells.solve,
            count=cells.each,
        )
        self.cell = cell
        self.missed: dict[str, float] = {}


class _Cells:
    def __init__(
        self,
        solver: ProgramSolver,
        objective: Objective,
        required_h: FloatArray,
        payload: dict[str, FloatArray],
        seed: int,
        each: int,
    ) -> None:
        self.solver, self.objective, self.day = solver, objective, solver.day
        self.required_h, self.payload, self.seed = required_h, payload, seed
        self.each = each
        self.count = len(self.day.scenarios) // each
        winds = solver.mission.scenario_winds_m_per_s(self.day.scenarios)
        strongest = winds.reshape(-1, each).max(axis=-1)
        self.wind_m_per_s = np.asarray(solver.mission.wind_to_beat_m_per_s(strongest))
        self.own = variables_of(solver.aircraft)
        self.last: Solution | None = None

    def run(self) -> CellSizings:
        searches = [_CellSearch(self, cell) for cell in range(self.count)]
        self._run(searches)
        best = {one.cell: one.best for one in searches if one.best is not None}
        sunlit = self._lit_searches()
        self._run(sunlit)
        for one in sunlit:
            own = best.get(one.cell)
            if one.best is not None and (own is None or one.best.found.merit > own.found.merit):
                best[one.cell] = one.best
        return self._results(
            {cell: found.solution for cell, found in best.items()},
            {one.cell: one.missed for one in searches if one.missed and one.cell not in best},
        )

    def _lit_searches(self) -> list[_CellSearch]:
        """Searches for designs that fly by the sun alone under some of a cell's midnight suns."""
        lowest = lowest_power(self.day).reshape(-1, self.each)
        polar = lowest.max(axis=-1) > 0.0
        if self.objective is not Objective.max_excess_time:
            polar = polar & (self.required_h > 0.0)
        return [
            _CellSearch(self, int(cell), [int(cell) * self.each + i for i in some])
            for cell in np.flatnonzero(polar)
            for some in growing_lit_sets(lowest[cell])
        ]

    def _run(self, searches: Sequence[_CellSearch]) -> None:
        self.last = None
        run(searches, self._simulated, rounds=_ROUNDS)

    # --- the program ---------------------------------------------------------------------------

    def solve(self, search: Search) -> Solution | None:
        """Solution for a cell, from its own last one or that of the cell before."""
        assert isinstance(search, _CellSearch)
        search.missed = {}
        previous = self.last if search.previous is None else search.previous
        for penalty in _PENALTIES:
            solution = self._penalised(search, search.instance.penalised(penalty), previous)
            if solution is not None and not solution.missed():
                return self._kept(solution)
            # The penalty may have been too low, or too high for the solver: what must be missed?
            instance = search.instance.least_missed()
            least = self._penalised(search, instance, solution, efforts=("quick", "steady"))
            nearest = least if solution is None else solution
            if nearest is None:
                return None
            if least is None or least.missed():
                search.missed = nearest.missed()
                self._kept(nearest)
                return None
            previous = nearest
        instance = search.instance.penalised(_PENALTIES[-1])
        last = self._penalised(search, instance, previous, efforts=("steady",))
        return None if last is None or last.missed() else self._kept(last)

    def _kept(self, solution: Solution) -> Solution:
        """Solution that the next cell starts from."""
        self.last = solution
        return solution

    def _penalised(
        self,
        search: Search,
        instance: ProblemInstance,
        previous: Solution | None,
        efforts: Sequence[Effort] = ("quick",),
    ) -> Solution | None:
        starts = [self.own] if previous is None else [self.own, previous.design]
        return self.solver.solve(
            instance, search.filled(), starts, efforts=efforts, previous=previous
        )

    # --- the simulator -------------------------------------------------------------------------

    def _performance(self, variables: DesignVariables, cells: NDArray[np.int_]) -> Performance:
        """Performance of designs in their cells; the scenarios of a cell are the last axis."""
        return _by_cell(self._flown(variables, cells), self.each)

    def _flown(self, variables: DesignVariables, cells: NDArray[np.int_]) -> Performance:
        """Performance of designs in each scenario of their cells."""
        scenarios = (cells[:, np.newaxis] * self.each + np.arange(self.each)).ravel()
        return performance_of_pairs(
            self.solver.aircraft,
            self.solver.mission,
            variables.mapped(lambda v: np.repeat(v, self.each)),
            self.solver.solar,
            day=self.day.at(scenarios),
        )

    def _keeps_requirements(self, perf: Performance, cells: NDArray[np.int_]) -> NDArray[np.bool_]:
        return meets_requirements(
            self.solver.aircraft,
            self.solver.mission,
            perf.design,
            wind_m_per_s=self.wind_m_per_s[cells],
        )

    def _simulated(self, searches: Sequence[Search]) -> list[Simulated]:
        cells = np.array([one.scenarios[0] // self.each for one in searches])
        flown = self._flown(_stacked([one.current.design for one in searches]), cells)
        perf = _by_cell(flown, self.each)
        worst = perf.cycle.excess_time_h.argmin(axis=-1)
        excess = perf.cycle.excess_time_h.min(axis=-1)
        columns = (
            excess.tolist(),
            (cells * self.each + worst).tolist(),
            merit_of(self.objective, perf).tolist(),
            self._keeps_requirements(perf, cells).tolist(),
        )
        lowest = perf.solar_power_w.min(axis=-1) / np.repeat(perf.nominal_load_w, self.each) - 1.0
        spare = [
            min(own[[i % self.each for i in search.instance.sunlit]], default=0.0)
            for search, own in zip(searches, lowest.reshape(-1, self.each), strict=True)
        ]
        own = flown.sun_in_own_flow(flown.day) if flown.day.is_cooled else None
        heights = None if flown.levels is None else flown.climbed()
        found = []
        for number, (one, row) in enumerate(zip(searches, zip(*columns, strict=True), strict=True)):
            here, sun, climbed = np.arange(self.each) + number * self.each, None, None
            if own is not None:
                sun = self.solver.sun_of(own.at(here), one.current)
            if heights is not None:
                climbed = dict(zip(one.scenarios, heights[here].tolist(), strict=True))
            found.append(Simulated(*row, None, spare[number], sun, climbed))
        return found

    def _cross_checked(
        self, cells: NDArray[np.int_], variables: DesignVariables, perf: Performance
    ) -> NDArray[np.bool_]:
        """Whether no random neighbour of a design is better by more than the tolerance."""
        bounds = {
            v.name: (v.minimum, v.maximum)
            for v in self.solver.problems.of(self.each, climb=self.solver.climb).of_role(
                Role.design
            )
        }
        free = {*bounds, self.objective.variable}
        rng = np.random.default_rng(self.seed)
        spread = np.repeat(_SPREADS, _NEIGHBOURS // len(_SPREADS))
        moved = {}
        for name, values in variables.chosen().items():
            factor = np.exp(spread * rng.standard_normal(len(spread)))
            around = np.outer(values, factor if name in free else np.ones_like(factor))
            moved[name] = (np.clip(around, *bounds[name]) if name in bounds else around).ravel()
        around_cells = np.repeat(cells, len(spread))
        flight = self._performance(DesignVariables(**moved), around_cells)
        excess = flight.cycle.excess_time_h.min(axis=-1)
        good = (excess > 0.0) & (excess >= self.required_h[around_cells])
        good &= self._keeps_requirements(flight, around_cells)
        merit = np.where(good, merit_of(self.objective, flight), -np.inf)
        best, own = merit.reshape(len(cells), -1).max(axis=1), merit_of(self.objective, perf)
        in_hours = ABSOLUTE_TOLERANCE_H if self.objective is Objective.max_excess_time else 0.0
        # Sums rather than differences: the excess time may be infinite on both sides.
        return np.asarray(best <= own + np.maximum(RELATIVE_TOLERANCE * np.abs(own), in_hours))

    # --- results -------------------------------------------------------------------------------

    def _results(
        self, best: dict[int, Solution], missed: dict[int, dict[str, float]]
    ) -> CellSizings:
        def blank() -> FloatArray:
            return np.full(self.count, np.nan)

        status = np.full(self.count, SizingStatus.not_converged, int)
        requirement, shortfall = np.full(self.count, "", dtype="<U40"), blank()
        message = np.full(self.count, "", dtype=object)
        for cell, slacks in missed.items():
            status[cell] = SizingStatus.infeasible
            requirement[cell] = name = max(slacks, key=lambda key: slacks[key])
            problem = self.solver.problems.of(self.each, climb=self.solver.climb)
            scales = {c.name: c.scale for c in problem.constraints}
            shortfall[cell] = short = scales[name] * slacks[name]
            message[cell] = self._message(cell, name, short)
        names = self.own.chosen() | self.payload
        names |= next((one.design.chosen() for one in best.values()), {})
        designs = {name: blank() for name in names}
        found = CellSizings(
            status=status,
            objective_value=blank(),
            variables=DesignVariables(**designs),
            total_mass_kg=blank(),
            excess_time_h=blank(),
            charge_margin_h=blank(),
            minimum_state_of_charge=blank(),
            airspeed_m_per_s=blank(),
            load_w=blank(),
            requirement=requirement,
            shortfall=shortfall,
            message=message,
        )
        if best:
            kept = np.array(sorted(best), int)
            variables = _stacked([best[int(i)].design for i in kept])
            perf = self._performance(variables, kept)
            checked = self._cross_checked(kept, variables, perf)
            status[kept] = np.where(checked, SizingStatus.cross_checked, SizingStatus.optimal)
            worst = (np.arange(len(kept)), perf.cycle.excess_time_h.argmin(axis=-1))
            found.objective_value[kept] = objective_value(self.objective, perf)
            found.total_mass_kg[kept] = perf.design.total_mass_kg
            found.excess_time_h[kept] = perf.cycle.excess_time_h[worst]
            found.charge_margin_h[kept] = perf.cycle.charge_margin_h[worst]
            found.minimum_state_of_charge[kept] = perf.cycle.minimum_state_of_charge[worst]
            found.airspeed_m_per_s[kept] = perf.design.airspeed_m_per_s
            found.load_w[kept] = perf.nominal_load_w
            for name, values in variables.chosen().items():
                designs[name][kept] = values
        return found

    @cached_property
    def _of_design(self) -> list[Requirement]:
        """Requirements on a design, for their texts: whichever one it is."""
        own = self.solver
        design = parametric_design(own.aircraft, own.conditions, self.own, 1.0)
        return design_requirements(own.aircraft, design, own.conditions)

    def _message(self, cell: int, name: str, short: float) -> str:
        """What a requirement that is missed in a cell says."""
        required_h, where = float(self.required_h[cell]), self.day.scenarios.label(cell * self.each)
        texts = texts_of_requirements(self._of_design, where, required_h, required_h - short)
        return texts[name].format(missed=percent(short))


def _stacked(designs: list[DesignVariables]) -> DesignVariables:
    names = designs[0].chosen()
    return DesignVariables(**{n: np.array([d.chosen()[n] for d in designs]) for n in names})


def _by_cell(perf: Performance, each: int) -> Performance:
    """Performance of pairs as that of cells: one design each, their scenarios as the last axis."""

    def first(value: Value) -> Value:
        if isinstance(value, tuple):  # design, variables and masses
            return type(value)._make(first(one) for one in value)  # type: ignore[attr-defined]  # a NamedTuple
        return np.asarray(value)[::each] if np.ndim(value) else value

    cycle = replace(
        perf.cycle,
        excess_time_h=perf.cycle.excess_time_h.reshape(-1, each),
        charge_margin_h=perf.cycle.charge_margin_h.reshape(-1, each),
        minimum_state_of_charge=perf.cycle.minimum_state_of_charge.reshape(-1, each),
    )
    load_w = first(perf.nominal_load_w)
    return replace(perf, design=first(perf.design), nominal_load_w=load_w, cycle=cycle)
