"""Many sizings of one aircraft at once: a design for every cell of a map.

Every cell is one place on one day, or a few such scenarios together, with a payload and a required
excess time of its own if need be, and has a search of its own (:mod:`sizing.program.size`). Designs
of all cells fly in one batch; programs are solved one after the other. Some cells far apart come
first, then those half-way between, and so on: each starts from the mean of the designs on both
sides, and from the multipliers of one of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.day.light import UNCORRECTED_CAM, SolarDay, SolarModel, solar_day
from sizing.design import DesignVariables, picked, variables_of
from sizing.limits import meets_requirements
from sizing.mass_budget import closed_design
from sizing.performance import Performance, fly
from sizing.program.climbing import Profile, simulate
from sizing.program.corrections import neighbours
from sizing.program.objectives import Objective
from sizing.program.reasons import missed_by, violations
from sizing.program.result import (
    ABSOLUTE_TOLERANCE_H,
    RELATIVE_TOLERANCE,
    SizingStatus,
    Violation,
    merit_of,
    objective_value,
)
from sizing.program.search import Search
from sizing.program.solve import ActiveSet
from sizing.program.task import SizingTask, Values
from sizing.program.variables import WIND
from solar.types import FloatArray, IntArray

_STRIDE = 16  # cells between those that start from nothing
# Cross-check: random neighbours of every optimum, and by how much one may be better.
_NEIGHBOURS = 24
_SPREADS = (0.03, 0.004)
_PAYLOADS = ("payload_mass_kg", "payload_power_w")


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
    if objective.of_range:
        raise ValueError(f"{objective.value} is a range of days or latitudes: use widest_range")
    count = len(scenarios) // scenarios_per_cell

    def each(given: ArrayLike | None, otherwise: float) -> list[float]:
        return [float(v) for v in np.broadcast_to(otherwise if given is None else given, count)]

    columns = zip(
        each(required_excess_time_h, mission.required_excess_time_h),
        each(payload_mass_kg, mission.payload.mass_kg),
        each(payload_power_w, mission.payload.power_w),
        strict=True,
    )
    day = solar_day(aircraft, mission, solar, scenarios=scenarios)
    tasks = []
    for cell, (required_h, mass_kg, power_w) in enumerate(columns):
        some = day.at(np.arange(cell * scenarios_per_cell, (cell + 1) * scenarios_per_cell))
        payload = mission.payload.model_copy(update={"mass_kg": mass_kg, "power_w": power_w})
        own = mission.model_copy(update={"payload": payload})
        if mission.wind_statistics is not None and not mission.holds_station:
            own = own.in_wind(float(mission.scenario_winds_m_per_s(some.scenarios).max()))
        tasks.append(SizingTask(aircraft, own, objective, solar, some, required_h))
    return _Cells(tasks, day).run(seed)


@dataclass
class _Cells:
    """Searches for the designs of all cells."""

    tasks: Sequence[SizingTask]
    day: SolarDay
    row: ActiveSet = field(default_factory=ActiveSet)
    found: dict[int, Search] = field(default_factory=dict)

    def run(self, seed: int) -> CellSizings:
        for wave in _waves(len(self.tasks)):
            self._run({cell: self._search(cell) for cell in wave})
        again = {
            cell: Search(self.tasks[cell])
            for cell, one in self.found.items()
            if one.status is SizingStatus.not_converged
        }
        self._run(again)
        lit = {}
        for cell, task in enumerate(self.tasks):
            if task.has_continuous_sun:
                lit[cell] = Search(task.with_values(continuous=True))
        self._run(lit)
        return self._results(seed)

    def _search(self, cell: int) -> Search:
        """Search that starts between the nearest cells on both sides that are known."""
        before = [i for i in self.found if i < cell]
        behind = [i for i in self.found if i > cell]
        ends = [max(before)] if before else []
        ends += [min(behind)] if behind else []
        known = [one for i in ends if (one := self.found[i].outcome) is not None]
        if not known:
            return Search(self.tasks[cell], active_set=self.row)
        sizes = {name: np.array([one.values[name] for one in known]) for name in known[0].values}
        first = {n: float(np.exp(np.log(np.maximum(v, 1e-12)).mean())) for n, v in sizes.items()}
        return Search(self.tasks[cell], first=first, warm=known[0].solution, active_set=self.row)

    def _run(self, searches: dict[int, Search]) -> None:
        """Run some searches; the designs of all fly together in every round."""
        rounds = {cell: one.rounds() for cell, one in searches.items()}
        asked = {cell: next(one) for cell, one in rounds.items()}
        while asked:
            near = {cell: neighbours(searches[cell].task, values) for cell, values in asked.items()}
            flights = self._flown(near, {c: searches[c].profiles for c in near}, keep=True)
            asked = {}
            for cell, perf in flights.items():
                with suppress(StopIteration):
                    asked[cell] = rounds[cell].send(perf)
        for cell, one in searches.items():
            known = self.found.get(cell)
            if known is None or one.merit > known.merit:
                self.found[cell] = one

    def _flown(
        self,
        designs: Mapping[int, list[Values]],
        profiles: Mapping[int, Mapping[int, Profile]],
        *,
        keep: bool = False,
    ) -> dict[int, Performance]:
        """Flights of some designs for each cell, with climbs along the cell's profiles."""
        first = self.tasks[0]
        mission = first.mission  # whose flights are no batch of pairs
        if mission.climb is not None or mission.holds_station or first.window_h is not None:
            return {
                cell: simulate(self.tasks[cell], some, profiles[cell])
                for cell, some in designs.items()
            }
        cells = np.repeat(list(designs), [len(some) for some in designs.values()])
        every = [one for some in designs.values() for one in some]
        perf = self.performance(every, cells, keep=keep)
        flights: dict[int, Performance] = {}
        for cell in designs:
            task, own = self.tasks[cell], perf.of_designs(cells == cell)
            flights[cell] = replace(own, mission=task.mission, day=task.day)
        return flights

    def performance(
        self, designs: Sequence[Values], cells: IntArray, *, keep: bool = False
    ) -> Performance:
        """Fly designs, each in the scenarios of its cell, which are the last axis of a batch."""
        first, each, names = self.tasks[0], self.tasks[0].count, set(_PAYLOADS)
        pairs = list(zip(cells.tolist(), designs, strict=True))
        chosen = [self.tasks[c].held | self.tasks[c].design_variables(d).chosen() for c, d in pairs]
        names |= first.design_variables(designs[0]).chosen().keys()
        columns = {name: np.array([one[name] for one in chosen]) for name in names}
        places = cells[:, np.newaxis] * each + np.arange(each)
        variables = DesignVariables(**columns).mapped(lambda v: np.repeat(v, each))
        perf = fly(
            first.simulated_aircraft,
            first.mission,
            first.solar,
            closed_design(first.simulated_aircraft, first.mission, variables),
            self.day.at(places.ravel()),
            keep_trajectory=keep,
            paired=True,
        )
        shape = len(cells), each
        store = perf.store
        return replace(
            perf,
            design=picked(perf.design, slice(None, None, each)),
            solar_power_w=perf.solar_power_w.reshape(*shape, -1),
            load_w=perf.load_w.reshape(*shape, -1),
            nominal_load_w=perf.nominal_load_w.reshape(shape),
            store=replace(store, battery_energy_wh=store.battery_energy_wh.reshape(shape)),
            cycle=perf.cycle.reshaped(shape),
        )

    def _checked(self, kept: IntArray, own: FloatArray, seed: int) -> NDArray[np.bool_]:
        """Whether no random neighbour of a design is better by more than the tolerance."""
        first, rng = self.tasks[0], np.random.default_rng(seed)
        spread = np.repeat(_SPREADS, _NEIGHBOURS // len(_SPREADS))
        factors = {name: np.exp(spread * rng.standard_normal(len(spread))) for name in first.moved}
        designs, profiles = {}, {}
        for cell in kept.tolist():
            best, task = self.found[cell].best, self.tasks[cell]
            assert best is not None
            profiles[cell] = best.profiles
            near = [
                {name: best.values[name] * by[number] for name, by in factors.items()}
                for number in range(len(spread))
            ]
            designs[cell] = [task.within_bounds(best.values | values) for values in near]
        best_of = np.full(len(kept), -np.inf)
        for place, (cell, perf) in enumerate(self._flown(designs, profiles).items()):
            task, excess_h = self.tasks[cell], perf.cycle.excess_time_h.min(axis=-1)
            good = (excess_h > 0.0) & (excess_h >= task.required_h)
            wind = task.held[WIND]
            good &= meets_requirements(task.simulated_aircraft, perf.design, wind_m_per_s=wind)
            merit = np.where(good, merit_of(first.objective, perf), -np.inf)
            best_of[place] = merit.max()
        in_hours = ABSOLUTE_TOLERANCE_H if first.objective is Objective.max_excess_time else 0.0
        # Sums rather than differences: the excess time may be infinite on both sides.
        return np.asarray(best_of <= own + np.maximum(RELATIVE_TOLERANCE * np.abs(own), in_hours))

    def _results(self, seed: int) -> CellSizings:
        count, first = len(self.tasks), self.tasks[0]
        status = np.array([self.found[cell].status for cell in range(count)], int)
        columns: dict[str, Any] = {f.name: np.full(count, np.nan) for f in fields(CellSizings)}
        columns |= {"status": status, "message": np.full(count, "", object)}
        columns["requirement"] = np.full(count, "", "<U40")
        for cell in np.flatnonzero(status == SizingStatus.infeasible).tolist():
            worst = _missed_most(self.found[cell])
            columns["requirement"][cell], columns["message"][cell] = worst.requirement, worst.text
            columns["shortfall"][cell] = worst.shortfall
        best = {cell: one.values for cell in range(count) if (one := self.found[cell].best)}
        names = {*variables_of(first.aircraft).chosen(), *_PAYLOADS}
        variables = {name: np.full(count, np.nan) for name in names}
        if best:
            kept = np.array(list(best))
            perf = self.performance(list(best.values()), kept)
            checked = self._checked(kept, merit_of(first.objective, perf), seed)
            status[kept] = np.where(checked, SizingStatus.cross_checked, SizingStatus.optimal)
            columns["objective_value"][kept] = objective_value(first.objective, perf)
            columns["total_mass_kg"][kept] = perf.design.total_mass_kg
            columns["airspeed_m_per_s"][kept] = perf.design.airspeed_m_per_s
            columns["load_w"][kept] = perf.nominal_load_w[:, 0]
            worst_of = (np.arange(len(kept)), perf.cycle.excess_time_h.argmin(axis=-1))
            for name in ("excess_time_h", "charge_margin_h", "minimum_state_of_charge"):
                columns[name][kept] = getattr(perf.cycle, name)[worst_of]
            for name, column in perf.design.variables.chosen().items():
                variables.setdefault(name, np.full(count, np.nan))[kept] = column
        columns["variables"] = DesignVariables(**variables)
        return CellSizings(**columns)


def _waves(count: int) -> Iterator[range]:
    """Every so many of some places, then those half-way between, until all are told."""
    stride = _STRIDE
    yield range(0, count, stride)
    while stride > 1:
        stride //= 2
        yield range(stride, count, 2 * stride)


def _missed_most(search: Search) -> Violation:
    """Requirement that the design of a cell misses most that comes nearest."""
    nearest, task = search.nearest, search.task
    assert nearest is not None
    perf = replace(nearest.perf.of_designs(0), mission=task.mission, day=task.day)
    missed = missed_by(task, nearest.solution, perf)
    short_h = task.required_h - float(np.min(perf.cycle.excess_time_h))
    if task.required_h > short_h > 0.0:  # it flies perpetually
        missed = {"excess_time": short_h}
    return max(violations(task, perf, missed), key=lambda one: one.shortfall)
