"""Many sizings of one aircraft at once: a design for every cell of a map.

Every cell is one place on one day, or a few such scenarios together, with a payload and a required
excess time of its own if need be, and has a search of its own (:mod:`sizing.program.search`).
Designs of all cells fly in one batch; programs are solved in turn. Some cells far apart come first,
then those half-way between, and so on: each starts from the mean of the designs on both sides, and
from the multipliers of one of them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from itertools import accumulate, chain, pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.day.light import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from sizing.design import DesignVariables, variables_of
from sizing.mass_budget import closed_design
from sizing.performance import Performance, fly
from sizing.program.climbing import Profile, heights_along
from sizing.program.corrections import neighbours
from sizing.program.cross_check import random_factors
from sizing.program.objectives import Objective, refuse_range
from sizing.program.reasons import missed_by, violations
from sizing.program.result import (
    ABSOLUTE_TOLERANCE_H,
    RELATIVE_TOLERANCE,
    SizingStatus,
    Violation,
    merit_of,
    objective_value,
)
from sizing.program.search import Flights, Search
from sizing.program.solve import ActiveSet
from sizing.program.task import SizingTask, Values
from sizing.program.transcription import lagrange
from solar.types import FloatArray, IntArray

_STRIDE = 16  # cells between those that start from no neighbour; a power of two
_LEAST = 1e-12  # of a value whose logarithm is taken
_NEIGHBOURS = 24  # of every optimum that its cross-check simulates
_PAYLOADS = ("payload_mass_kg", "payload_power_w")
_OPEN = SizingStatus.not_converged


@dataclass(frozen=True)
class CellSizings:
    """Designs of all cells; arrays over the cells, NaN where there is no design.

    ``status``: see :class:`sizing.program.objectives.SizingStatus`; ``cross_checked`` where none
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
    seed: int = 0,
) -> CellSizings:
    """Size a parametric aircraft for many cells.

    Neighbouring cells should follow each other. Results depend on the other cells within the
    search's tolerance: the same cells in the same order give the same bits.

    Parameters
    ----------
    aircraft, mission, objective, solar
        As for :func:`sizing.program.size.size_aircraft`; latitude and dates of the mission play no
        part.
    scenarios : Scenarios
        Latitude and day of every cell.
    scenarios_per_cell : int
        How many scenarios, following each other, make one cell; the worst of them counts.
    required_excess_time_h : array_like, optional
        Of all cells or of each, instead of the mission's [h].
    payload_mass_kg, payload_power_w : array_like, optional
        Payload of every cell, instead of the mission's.
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
        For an objective that is a range, or scenarios that do not fill the cells.
    """
    if scenarios_per_cell < 1 or len(scenarios) % scenarios_per_cell:
        raise ValueError(
            f"{len(scenarios)} scenarios do not make cells of {scenarios_per_cell} each"
        )
    if not isinstance(aircraft.airframe, ParametricAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    refuse_range(objective, "use widest_range")
    count = len(scenarios) // scenarios_per_cell

    def each(values: ArrayLike | None, otherwise: float) -> list[float]:
        """Return a value for every cell."""
        return [float(v) for v in np.broadcast_to(otherwise if values is None else values, count)]

    columns = zip(
        each(required_excess_time_h, mission.required_excess_time_h),
        each(payload_mass_kg, mission.payload.mass_kg),
        each(payload_power_w, mission.payload.power_w),
        strict=True,
    )
    day = solar_day(aircraft, mission, solar, scenarios=scenarios)
    tasks = []
    for cell, (required_h, mass_kg, power_w) in enumerate(columns):
        light = day.at(np.arange(cell * scenarios_per_cell, (cell + 1) * scenarios_per_cell))
        payload = mission.payload.model_copy(update={"mass_kg": mass_kg, "power_w": power_w})
        there = mission.model_copy(update={"payload": payload})
        if mission.wind_statistics is not None and not mission.holds_station:
            there = there.in_wind(float(mission.scenario_winds_m_per_s(light.scenarios).max()))
        tasks.append(SizingTask(aircraft, there, objective, solar, light, required_h))
    return _Cells(tasks, day).run(seed)


@dataclass
class _Cells:
    """Searches for the designs of all cells."""

    tasks: Sequence[SizingTask]
    day: SolarDay
    active_set: ActiveSet = field(default_factory=ActiveSet)
    searches: dict[int, Search] = field(default_factory=dict)

    def run(self, seed: int) -> CellSizings:
        """Search in every cell, and once more where a search ends without a verdict."""
        for stride, wave in _waves(len(self.tasks)):
            self._run({cell: self._search(cell, stride) for cell in wave})
        without = [cell for cell, search in self.searches.items() if search.status is _OPEN]
        self._run({cell: Search(self.tasks[cell]) for cell in without})
        branches = {
            cell: Search(replace(task, continuous=True))
            for cell, task in enumerate(self.tasks)
            if task.has_continuous_sun
        }
        self._run(branches)
        return self._results(seed)

    def _search(self, cell: int, stride: int) -> Search:
        """Return a search that starts between known cells, a stride and three of them away."""
        search = Search(self.tasks[cell], active_set=self.active_set)
        around = [self.searches.get(cell + place * stride) for place in (-3, -1, 1, 3)]
        known = [it for it in around[1:3] + around[::3] if it is not None and it.outcome][:2]
        if known:
            search.warm = known[0].solution
            sized = [it for it in around if it is not None and it.best is not None]
            used = sized if len(sized) == 4 else known
            designs = [it.outcome.values for it in used if it.outcome is not None]
            logs = np.log([[max(v, _LEAST) for v in values.values()] for values in designs])
            # A cubic through four designs, or the mean of two.
            middle = np.exp(np.asarray(lagrange(0.5, len(used))) @ logs)
            search.first = dict(zip(designs[0], middle.tolist(), strict=True))
        return search

    def _run(self, searches: dict[int, Search]) -> None:
        """Run searches; the designs of all are simulated together in every round.

        Of two searches in a cell the better one counts; where none has a design, the later one of
        the same task if the first had no verdict.
        """
        rounds = {cell: search.rounds() for cell, search in searches.items()}
        needed = {cell: next(steps) for cell, steps in rounds.items()}
        while needed:
            near = {
                cell: neighbours(searches[cell].task, it.values)
                for cell, it in needed.items()
                if it.best_in is None
            }
            profiles = {cell: searches[cell].profiles for cell in near}
            best = {cell: it for cell, it in needed.items() if cell not in near}
            flights = self._simulated(near, profiles, keep=True) if near else {}
            flights |= self._best(best) if best else {}
            needed = {}
            for cell, perf in flights.items():
                with suppress(StopIteration):
                    needed[cell] = rounds[cell].send(perf)
        for cell, search in searches.items():
            known = self.searches.get(cell)
            if (
                known is None
                or search.merit > known.merit
                or (known.status is _OPEN and search.task is known.task)
            ):
                self.searches[cell] = search

    def _simulated(
        self,
        designs: Mapping[int, list[Values]],
        profiles: Mapping[int, Mapping[int, Profile]],
        *,
        keep: bool = False,
        of_others: bool = False,
    ) -> dict[int, Performance]:
        """Simulate the designs of each cell, with climbs along the cell's profiles.

        ``of_others``: along those of another design, as far as each can.
        """
        first, counts = self.tasks[0], [len(values) for values in designs.values()]
        cells = np.repeat(list(designs), counts)
        places = cells[:, np.newaxis] * first.count + np.arange(first.count)
        along = zip(designs, counts, strict=True)
        heights = [heights_along(self.tasks[cell], profiles[cell], n) for cell, n in along]
        every = list(chain.from_iterable(designs.values()))
        perf = self._fly(
            every, cells, places, np.concatenate(heights), keep=keep, of_others=of_others
        )
        flights = _by_cell(perf, cells)
        return {
            cell: replace(of_cell, mission=self.tasks[cell].mission, day=self.tasks[cell].day)
            for cell, of_cell in flights.items()
        }

    def _fly(
        self,
        designs: Sequence[Values],
        cells: IntArray,
        places: IntArray,
        heights_m: FloatArray | None = None,
        *,
        keep: bool = False,
        of_others: bool = False,
    ) -> Performance:
        """Simulate designs of cells, each in its ``places``: scenarios of all cells."""
        first, shape = self.tasks[0], places.shape
        names = {*_PAYLOADS, *first.design_variables(designs[0]).chosen()}
        pairs = list(zip(cells.tolist(), designs, strict=True))
        chosen = [self.tasks[c].held | self.tasks[c].design_variables(d).chosen() for c, d in pairs]
        columns = {name: np.array([values[name] for values in chosen]) for name in names}
        variables = DesignVariables(**columns).mapped(lambda v: np.repeat(v, shape[1]))
        winds = np.array([self.tasks[cell].conditions.wind_m_per_s for cell in cells.tolist()])
        conditions = first.conditions._replace(wind_m_per_s=np.repeat(winds, shape[1]))
        perf = fly(
            first.simulated_aircraft,
            first.mission,
            first.solar,
            closed_design(first.simulated_aircraft, conditions, variables),
            self.day.at(places.ravel()),
            keep_trajectory=keep,
            paired=True,
            heights_m=heights_m,
            of_others=of_others,
        )
        return perf.reshaped(shape)

    def _best(self, needed: Mapping[int, Flights]) -> dict[int, Performance]:
        """Simulate designs along their best heights, each in scenarios of its cell."""
        pairs = [
            (cell, it.values, cell * self.tasks[cell].count + number)
            for cell, it in needed.items()
            if it.best_in is not None
            for number in it.best_in.tolist()
        ]
        cells, designs, places = (list(column) for column in zip(*pairs, strict=True))
        perf = self._fly(designs, np.array(cells), np.array(places)[:, np.newaxis], keep=True)
        return _by_cell(perf, np.array(cells))

    def _checked(self, kept: IntArray, merits: FloatArray, seed: int) -> NDArray[np.bool_]:
        """Return whether no random neighbour of a design is better by more than the tolerance.

        ``kept``: cells with a design. ``merits``: theirs. Climbs follow the heights of the design.
        """
        first, rng = self.tasks[0], np.random.default_rng(seed)
        factors = random_factors(first.moved, _NEIGHBOURS, rng)
        designs, profiles = {}, {}
        for cell in kept.tolist():
            best, task = self.searches[cell].best, self.tasks[cell]
            assert best is not None
            profiles[cell] = best.best_profiles
            designs[cell] = [
                task.within_bounds(
                    best.values | {name: best.values[name] * by[i] for name, by in factors.items()}
                )
                for i in range(_NEIGHBOURS)
            ]
        highest = np.full(len(kept), -np.inf)
        for place, (cell, perf) in enumerate(
            self._simulated(designs, profiles, of_others=True).items()
        ):
            task = self.tasks[cell]
            good = task.is_enough(perf.cycle.excess_time_h) & task.meets(perf)
            highest[place] = np.where(good, merit_of(first.objective, perf), -np.inf).max()
        in_hours = ABSOLUTE_TOLERANCE_H if first.objective is Objective.max_excess_time else 0.0
        tolerance = np.maximum(RELATIVE_TOLERANCE * np.abs(merits), in_hours)
        # Sums rather than differences: the excess time may be infinite on both sides.
        return np.asarray(highest <= merits + tolerance)

    def _results(self, seed: int) -> CellSizings:
        count, first = len(self.tasks), self.tasks[0]
        status = np.array([self.searches[cell].status for cell in range(count)], int)
        columns: dict[str, Any] = {f.name: np.full(count, np.nan) for f in fields(CellSizings)}
        columns |= {"status": status, "message": np.full(count, "", object)}
        columns["requirement"] = np.full(count, "", "<U40")
        for cell in np.flatnonzero(status == SizingStatus.infeasible).tolist():
            missed = _missed_most(self.searches[cell])
            columns["requirement"][cell], columns["message"][cell] = missed.requirement, missed.text
            columns["shortfall"][cell] = missed.shortfall
        best = {cell: it for cell in range(count) if (it := self.searches[cell].best)}
        names = {*variables_of(first.aircraft).chosen(), *_PAYLOADS}
        variables = {name: np.full(count, np.nan) for name in names}
        for cell, judged in best.items():
            perf, task = judged.flight, self.tasks[cell]
            columns["objective_value"][cell] = objective_value(task.objective, perf)
            columns["total_mass_kg"][cell] = perf.design.total_mass_kg
            columns["airspeed_m_per_s"][cell] = perf.design.airspeed_m_per_s
            columns["load_w"][cell] = np.ravel(perf.nominal_load_w)[0]
            worst = perf.worst_scenario()
            for name in ("excess_time_h", "charge_margin_h", "minimum_state_of_charge"):
                columns[name][cell] = getattr(perf.cycle, name)[worst]
            chosen = task.held | task.design_variables(judged.values).chosen()
            for name in chosen.keys() & set(DesignVariables._fields):
                variables.setdefault(name, np.full(count, np.nan))[cell] = chosen[name]
        if best:
            kept = np.array(list(best))
            checked = self._checked(kept, np.array([it.merit for it in best.values()]), seed)
            status[kept] = np.where(checked, SizingStatus.cross_checked, SizingStatus.optimal)
        columns["variables"] = DesignVariables(**variables)
        return CellSizings(**columns)


def _by_cell(perf: Performance, cells: IntArray) -> dict[int, Performance]:
    """Return the flights of every cell, whose designs follow each other."""
    counts = Counter(cells.tolist())
    parts = pairwise(accumulate(counts.values(), initial=0))
    return {c: perf.of_designs(slice(*part)) for c, part in zip(counts, parts, strict=True)}


def _waves(count: int) -> Iterator[tuple[int, range]]:
    """Yield every so many of the places, then those half-way between, until none is left.

    With the distance to those before.
    """
    stride = _STRIDE
    yield stride, range(0, count, stride)
    while stride > 1:
        stride //= 2
        yield stride, range(stride, count, 2 * stride)


def _missed_most(search: Search) -> Violation:
    """Return the requirement that the nearest design of a cell misses most."""
    nearest, task = search.nearest, search.task
    assert nearest is not None
    perf = replace(nearest.perf.of_designs(0), mission=task.mission, day=task.day)
    missed = missed_by(task, nearest.solution, perf)
    short_h = task.required_h - float(np.min(perf.cycle.excess_time_h))
    if task.required_h > short_h > 0.0:  # it flies perpetually
        missed = {"excess_time": short_h}
    return max(violations(task, perf, missed), key=lambda violation: violation.shortfall)
