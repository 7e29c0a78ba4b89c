"""Many sizings of one aircraft at once: a design for every cell of a map.

Every cell is one place on one day, or a few such scenarios together, with a payload and a required
excess time of its own if need be. The program of the
optimiser is asked with its requirements made soft: missing one costs more than any design could
save, so that a cell without a design ends as quickly as one that has it, and says what it lacks.
Cells are solved one after the other by sequential quadratic programming, each from the last one's
solution and prices; where that fails, by the interior-point method from the aircraft's own design.
The simulator judges all cells at once, and those it corrects are asked again.

Source of the penalty: Nocedal, J. and Wright, S. J. (2006), Numerical Optimization, section 17.2:
an exact penalty has the solutions of the original problem once it outweighs the prices. Where it
may not have, a second question, for the least that must be missed alone, decides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, Masses, variables_of
from sizing.limits import meets_requirements
from sizing.optimisation.agreement import GOAL_CUSHION_H, WASTE_H, shifted
from sizing.optimisation.energy_constraints import lowest_sun_parameters, never_dark
from sizing.optimisation.objectives import Objective, without_battery
from sizing.optimisation.problem import Effort, SizingProblems
from sizing.optimisation.result import objective_value
from sizing.optimisation.solver import FIRST_MARGIN, Answer, ProgramSolver, Question
from sizing.performance import Performance, performance_of_pairs
from sizing.smooth import Value
from sizing.sunlight import UNCORRECTED_CAM, SolarModel, solar_day
from solar.types import FloatArray

# Prices of missed requirements in units of the cost; see the module's docstring.
_PENALTIES = (10.0, 300.0)
_ROUNDS = 6
# Certification: random neighbours of every optimum, and by how much one may be better.
_NEIGHBOURS = 24
_SPREADS = (0.03, 0.004)
_TOLERANCE, _TOLERANCE_H = 0.005, 0.01
_ROW_TOLERANCE = 1e-6  # the solver meets its rows to about 1e-8


class CellStatus(IntEnum):
    """How a cell ends; the values are flags of gridded results.

    ``optimal`` is an optimum that the simulator confirms but a neighbour beats; ``certified`` one
    that none of its neighbours beats; ``infeasible`` misses a requirement whatever the design;
    ``not_converged`` says nothing about feasibility.
    """

    infeasible = 0
    certified = 1
    optimal = 2
    not_converged = 3


@dataclass(frozen=True)
class CellSizings:
    """Designs of all cells; arrays over the cells, NaN where there is no design.

    Attributes
    ----------
    status : ndarray of int
        See :class:`CellStatus`.
    objective_value : ndarray
        Objective as the simulator finds it.
    variables : DesignVariables
        Of arrays.
    total_mass_kg, excess_time_h, charge_margin_h, minimum_state_of_charge : ndarray
        Of the design, as the simulator finds them.
    airspeed_m_per_s, load_w : ndarray
        Of level flight, and nominal load.
    requirement : ndarray of str
        Requirement that is missed most where the cell is infeasible, empty elsewhere.
    shortfall : ndarray
        By how much, relative to its limit; excess time in hours.
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
        As for :func:`sizing.optimisation.search.size_aircraft`; latitude and dates of the mission
        play no
        part.
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
        Of the random neighbours of the certification.

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
    if objective.of_range:
        raise ValueError(f"{objective.value} is a range: cells are single days and latitudes")
    if problems is not None and problems.aircraft is not aircraft:
        raise ValueError("the programs belong to another aircraft")
    count = len(scenarios) // scenarios_per_cell

    def each(given: ArrayLike | None, otherwise: float) -> FloatArray:
        return np.array(np.broadcast_to(otherwise if given is None else given, count), float)

    required = each(required_excess_time_h, mission.required_excess_time_h)
    payload = np.stack(
        [
            each(payload_mass_kg, mission.payload.mass_kg),
            each(payload_power_w, mission.payload.power_w),
        ]
    )
    day = solar_day(aircraft, mission, solar, scenarios=scenarios)
    solver = ProgramSolver(problems or SizingProblems(aircraft), mission, day)
    return _Cells(solver, solar, objective, required, payload, seed, scenarios_per_cell).run()


class _Cells:
    def __init__(
        self,
        solver: ProgramSolver,
        solar: SolarModel,
        objective: Objective,
        required_h: FloatArray,
        payload: FloatArray,
        seed: int,
        each: int,
    ) -> None:
        self.solver, self.solar, self.objective = solver, solar, objective
        self.aircraft, self.mission, self.day = solver.aircraft, solver.mission, solver.day
        self.required_h, self.payload, self.seed = required_h, payload, seed
        self.each = each
        self.count = len(self.day.scenarios) // each
        cushion_h = 0.0 if objective is Objective.max_excess_time else GOAL_CUSHION_H
        self.goals_h = required_h + cushion_h
        self.margins = np.full(self.count, FIRST_MARGIN)
        self.answers: list[Answer | None] = [None] * self.count
        self.slacks: list[dict[str, float]] = [{} for _ in range(self.count)]
        self.own = variables_of(self.aircraft)
        self.without_battery = np.zeros(self.count, bool)

    def run(self) -> CellSizings:
        best = self._search(np.arange(self.count))
        lit = never_dark(self.day).reshape(-1, self.each).all(axis=-1)
        if self.objective is not Objective.max_excess_time:
            lit = lit & (self.required_h > 0.0)
        if lit.any():
            missed = list(self.slacks)
            for cell, found in self._search_without_battery(np.flatnonzero(lit)).items():
                if cell not in best or found[0] > best[cell][0]:
                    best[cell] = found
            self.slacks = missed
        return self._results(best)

    def _search_without_battery(self, cells: NDArray[np.int_]) -> dict[int, tuple[float, Answer]]:
        """Best designs that fly by the sun alone at all times, under a midnight sun."""
        self.without_battery[cells] = True
        self.goals_h[cells], self.margins[cells] = 0.0, FIRST_MARGIN
        for cell in cells:
            self.answers[cell] = None
        where = (cells[:, np.newaxis] * self.each + np.arange(self.each)).ravel()
        self.solver.suns[where] = lowest_sun_parameters(self.day.at(where), self.mission)
        return self._search(cells)

    def _search(self, open_cells: NDArray[np.int_]) -> dict[int, tuple[float, Answer]]:
        """Merit and answer of those cells that have a design."""
        best: dict[int, tuple[float, Answer]] = {}
        for _ in range(_ROUNDS):
            if not len(open_cells):
                break
            self._solve(open_cells)
            solved = np.array(
                [i for i in open_cells if self.answers[i] is not None and not self.slacks[i]], int
            )
            if not len(solved):
                break
            open_cells = self._judge(solved, best)
        return best

    # --- the program ---------------------------------------------------------------------------

    def _solve(self, cells: NDArray[np.int_]) -> None:
        previous: Answer | None = None
        for i in cells:
            known = self.answers[i]
            answer = self._ask(int(i), previous if known is None else known)
            self.answers[i] = answer
            if answer is not None:
                previous = answer

    def _ask(self, cell: int, previous: Answer | None) -> Answer | None:
        """Answer for a cell; what it misses whatever the design goes into ``slacks``."""
        self.slacks[cell] = {}
        for penalty in _PENALTIES:
            answer = self._softly(cell, penalty, previous)
            if answer is not None and not answer.missed():
                return answer
            # The penalty may have been too low, or too high for the solver: what must be missed?
            least = self._softly(cell, None, answer, efforts=("quick", "steady"))
            nearest = least if answer is None else answer
            if nearest is None:
                return None
            if least is None or least.missed():
                self.slacks[cell] = nearest.missed()
                return nearest
            previous = nearest
        last = self._softly(cell, _PENALTIES[-1], previous, efforts=("steady",))
        return None if last is None or last.missed() else last

    def _softly(
        self,
        cell: int,
        penalty: float | None,
        previous: Answer | None,
        efforts: Sequence[Effort] = ("quick",),
    ) -> Answer | None:
        objective = self.objective
        if self.without_battery[cell]:
            objective = without_battery(objective)
        question = Question.of(objective, float(self.goals_h[cell]))
        held = dict(zip(("payload_mass_kg", "payload_power_w"), self.payload[:, cell], strict=True))
        if penalty is None:
            question = question.elastically()
        return self.solver.ask_softly(
            replace(question, margin=float(self.margins[cell])),
            range(cell * self.each, (cell + 1) * self.each),
            penalty,
            held={k: float(v) for k, v in held.items()},
            start=self.own,
            previous=previous,
            efforts=efforts,
        )

    # --- the simulator -------------------------------------------------------------------------

    def _judge(
        self, solved: NDArray[np.int_], best: dict[int, tuple[float, Answer]]
    ) -> NDArray[np.int_]:
        """Keep what the simulator accepts, shift the goals of the others; cells to ask again."""
        perf = self._simulate(self._variables(solved), solved)
        excess = perf.cycle.excess_time_h.min(axis=-1)
        value = objective_value(self.objective, perf)
        merit = value if self.objective.maximised else -value
        again = []
        for k, i in enumerate(solved):
            found_h, required_h = float(excess[k]), float(self.required_h[i])
            accepted = found_h > 0.0 and found_h >= required_h
            answer = self.answers[i]
            assert answer is not None
            if accepted and (i not in best or merit[k] > best[i][0]):
                best[int(i)] = (float(merit[k]), answer)
            costs = self.objective is not Objective.max_excess_time
            wasteful = costs and self.goals_h[i] > 0.0 and found_h - required_h > WASTE_H
            if accepted and not wasteful:
                continue
            self.goals_h[i], self.margins[i] = shifted(
                self.goals_h[i],
                self.margins[i],
                required_h=required_h,
                found_h=found_h,
                cushion_h=GOAL_CUSHION_H,
            )
            again.append(i)
        return np.array(again, int)

    def _variables(self, cells: NDArray[np.int_]) -> DesignVariables:
        found = []
        for i in cells:
            answer = self.answers[i]
            assert answer is not None
            found.append(answer.variables)
        return _stacked(found)

    def _simulate(self, variables: DesignVariables, cells: NDArray[np.int_]) -> Performance:
        """Performance of designs in their cells; the scenarios of a cell are the last axis."""
        where = (cells[:, np.newaxis] * self.each + np.arange(self.each)).ravel()
        repeated = variables.mapped(lambda v: np.repeat(v, self.each))
        perf = performance_of_pairs(
            self.aircraft, self.mission, repeated, self.solar, day=self.day.at(where)
        )
        return _by_cell(perf, self.each)

    def _withstands(
        self, cells: NDArray[np.int_], variables: DesignVariables, perf: Performance
    ) -> NDArray[np.bool_]:
        """Whether no random neighbour of a design is better by more than the tolerance."""
        bounds = {
            v.name: (v.minimum, v.maximum) for v in self.solver.problems.of(self.each).variables
        }
        fixed = {"payload_mass_kg", "payload_power_w", "aspect_ratio"} - (
            {self.objective.variable} | ({"aspect_ratio"} & set(bounds))
        )
        rng = np.random.default_rng(self.seed)
        spread = np.repeat(_SPREADS, _NEIGHBOURS // len(_SPREADS))
        moved = {}
        for name, values in variables.chosen().items():
            factor = np.exp(spread * rng.standard_normal(len(spread)))
            factor = np.ones_like(factor) if name in fixed else factor
            around = np.outer(values, factor)
            moved[name] = (np.clip(around, *bounds[name]) if name in bounds else around).ravel()
        attack = DesignVariables(**moved)
        found = self._simulate(attack, np.repeat(cells, len(spread)))
        excess = found.cycle.excess_time_h.min(axis=-1)
        good = (excess > 0.0) & (excess >= np.repeat(self.required_h[cells], len(spread)))
        good = good & meets_requirements(
            self.aircraft, found.design, self.solver.conditions, tolerance=_ROW_TOLERANCE
        )
        value = objective_value(self.objective, found)
        sign = 1.0 if self.objective.maximised else -1.0
        merit = np.where(good, sign * value, -np.inf).reshape(len(cells), -1).max(axis=1)
        own = sign * objective_value(self.objective, perf)
        in_hours = _TOLERANCE_H if self.objective is Objective.max_excess_time else 0.0
        # Sums rather than differences: the excess time may be infinite on both sides.
        return np.asarray(merit <= own + np.maximum(_TOLERANCE * np.abs(own), in_hours))

    # --- results -------------------------------------------------------------------------------

    def _results(self, best: dict[int, tuple[float, Answer]]) -> CellSizings:
        kept = np.array(sorted(best), int)
        status = np.full(self.count, CellStatus.not_converged, int)
        nothing = [i for i in range(self.count) if i not in best and self.slacks[i]]
        status[nothing] = CellStatus.infeasible
        columns = {
            name: np.full(self.count, np.nan)
            for name in ("value", "mass", "excess", "margin", "lowest", "airspeed", "load")
        }
        chosen: dict[str, FloatArray] = {}
        if len(kept):
            variables = _stacked([best[int(i)][1].variables for i in kept])
            perf = self._simulate(variables, kept)
            rows, worst = np.arange(len(kept)), perf.cycle.excess_time_h.argmin(axis=-1)
            sound = self._withstands(kept, variables, perf)
            status[kept] = np.where(sound, CellStatus.certified, CellStatus.optimal)
            columns["value"][kept] = objective_value(self.objective, perf)
            columns["mass"][kept] = perf.design.total_mass_kg
            columns["excess"][kept] = perf.cycle.excess_time_h[rows, worst]
            columns["margin"][kept] = perf.cycle.charge_margin_h[rows, worst]
            columns["lowest"][kept] = perf.cycle.minimum_state_of_charge[rows, worst]
            columns["airspeed"][kept] = perf.design.airspeed_m_per_s
            columns["load"][kept] = perf.nominal_load_w
            for name, values in variables.chosen().items():
                chosen[name] = np.full(self.count, np.nan)
                chosen[name][kept] = values
        else:
            names = self.own.chosen() | {"payload_mass_kg": None, "payload_power_w": None}
            chosen = {name: np.full(self.count, np.nan) for name in names}
        requirement = np.full(self.count, "", dtype="<U40")
        shortfall = np.full(self.count, np.nan)
        for i in nothing:
            name = max(self.slacks[i], key=lambda key: self.slacks[i][key])
            in_hours = 2.4 if name == "excess_time" else 1.0  # the row counts in tenths of a day
            requirement[i], shortfall[i] = name, in_hours * self.slacks[i][name]
        return CellSizings(
            status=status,
            objective_value=columns["value"],
            variables=DesignVariables(**chosen),
            total_mass_kg=columns["mass"],
            excess_time_h=columns["excess"],
            charge_margin_h=columns["margin"],
            minimum_state_of_charge=columns["lowest"],
            airspeed_m_per_s=columns["airspeed"],
            load_w=columns["load"],
            requirement=requirement,
            shortfall=shortfall,
        )


def _stacked(designs: list[DesignVariables]) -> DesignVariables:
    names = designs[0].chosen()
    return DesignVariables(**{n: np.array([d.chosen()[n] for d in designs]) for n in names})


def _by_cell(perf: Performance, each: int) -> Performance:
    """Performance of pairs as that of cells: one design each, their scenarios as the last axis."""

    def first(value: Value) -> Value:
        return np.asarray(value)[::each] if np.ndim(value) else value

    def gathered(values: FloatArray) -> FloatArray:
        return values.reshape(-1, each)

    design, cycle = perf.design, perf.cycle
    return replace(
        perf,
        design=design._replace(
            variables=design.variables.mapped(first),
            masses=Masses(*(first(mass) for mass in design.masses)),
            **{name: first(getattr(design, name)) for name in _DESIGN_NUMBERS},
        ),
        nominal_load_w=first(perf.nominal_load_w),
        cycle=replace(
            cycle,
            excess_time_h=gathered(cycle.excess_time_h),
            charge_margin_h=gathered(cycle.charge_margin_h),
            minimum_state_of_charge=gathered(cycle.minimum_state_of_charge),
        ),
    )


_DESIGN_NUMBERS = (
    "total_mass_kg",
    "battery_energy_wh",
    "propulsion_power_w",
    "constant_power_w",
    "airspeed_m_per_s",
)
