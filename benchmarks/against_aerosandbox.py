"""Sizing against AeroSandbox: one case, another with new parameters, and a map of 240 cases."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.measuring import best_time_s, missing, optional, row
from benchmarks.shared_sizing import (
    POINTS_PER_DAY,
    REQUIRED_H,
    Collocation,
    shared_aircraft,
    shared_mission,
    size_ours,
    sun_of,
)
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import SolarDay
from sizing.program.cells import size_cells
from sizing.program.objectives import Objective
from sizing.program.transcription import _program
from solar.types import FloatArray

_PEER = "AeroSandbox Opti"
# Equal optima differ by the trapezoids of the collocation, 10 min wide, and by the margin of one
# part in a thousand of the night's energy that our program keeps: together about 0.1 % of the span.
_AGREEMENT = 0.003
_LATITUDES = np.linspace(-57.0, 57.0, 20)
_PAYLOADS_KG = np.linspace(0.0, 8.8, 12)
_EVERY = 10


def sizing_against_aerosandbox() -> list[dict[str, Any]]:
    """The three-date problem: build and solve, and solve again with another requirement."""
    aircraft, mission = shared_aircraft(), shared_mission()
    day = sun_of(aircraft, mission)
    work = (
        f"least span for 3 dates at 47.6° N; ours with confirmation by simulation and the program "
        f"of its kind of aircraft kept, the peer with {POINTS_PER_DAY} points a day"
    )
    first = "the same where no such aircraft has been sized before: ours builds its program as well"
    requirements = np.linspace(REQUIRED_H, REQUIRED_H + 2.0, 21)
    ours_s = best_time_s(lambda: size_ours(aircraft, mission, day))
    ours_again_s = _ours_again(aircraft, mission, requirements)
    ours_first_s = best_time_s(lambda: _first_of_its_kind(aircraft, mission, day))
    asb = optional("aerosandbox")
    names = ("sizing, build and solve", "sizing, first of its kind", "sizing, solve again")
    if asb is None:
        times = (ours_s, ours_first_s, ours_again_s)
        return [missing(n, work, s, _PEER) for n, s in zip(names, times, strict=True)]
    _quiet()
    built = Collocation.build(asb, aircraft, mission, day)
    theirs_m = built.solve()
    ours_m = size_ours(aircraft, mission, day).objective_value
    agreed = _agreement([(ours_m, theirs_m)])
    peer_s = best_time_s(lambda: Collocation.build(asb, aircraft, mission, day).solve())
    built.start_from_solution()

    def solve_again(required_h: float) -> Any:
        built.put(day, required_h, 0.0)
        return built.solve()

    peer_again_s = _again(solve_again, requirements)
    again = (
        f"one of {len(requirements)} required excess times, program built before; ours all in a "
        "row with confirmation by simulation, the peer one by one with warm start"
    )
    return [
        row(names[0], f"{work}; {agreed}", ours_s, _PEER, peer_s),
        row(names[1], first, ours_first_s, _PEER, peer_s),
        row(names[2], again, ours_again_s, _PEER, peer_again_s),
    ]


def _first_of_its_kind(aircraft: Aircraft, mission: Mission, day: SolarDay) -> None:
    """Size an aircraft as if none of its kind had been sized before in this process."""
    _program.cache_clear()
    size_ours(aircraft, mission, day)


def _ours_again(aircraft: Aircraft, mission: Mission, requirements: FloatArray) -> float:
    """Time for one of several requirements, with a program that stands already [s]."""
    one = mission.scenarios()
    count = len(requirements)
    scenarios = Scenarios(np.tile(one.latitude_deg, count), np.tile(one.day_of_year, count))

    def work() -> None:
        size_cells(
            aircraft,
            mission,
            scenarios,
            Objective.min_wingspan,
            scenarios_per_cell=len(one),
            required_excess_time_h=requirements,
        )

    return best_time_s(work, 3) / count


def _again(solve: Any, requirements: Any) -> float:
    """Mean time for one of several requirements, of the fastest pass through them [s]."""

    def work() -> None:
        for required_h in requirements[1:]:
            solve(float(required_h))

    return best_time_s(work, 3) / (len(requirements) - 1)


# ---- The map


@dataclass(frozen=True)
class Cell:
    """One case of the map: a mission, and the sun in its scenarios."""

    mission: Mission
    day: SolarDay


def map_against_aerosandbox() -> list[dict[str, Any]]:
    """Map of least wingspans over latitude and payload, with its infeasible cells."""
    aircraft = shared_aircraft()
    cells = [
        _cell(aircraft, float(latitude), float(payload_kg))
        for latitude in _LATITUDES
        for payload_kg in _PAYLOADS_KG
    ]
    spans_m, ours_s = _timed(lambda: map_ours(aircraft, cells))
    feasible = [cell for cell, span_m in zip(cells, spans_m, strict=True) if span_m is not None]
    _, feasible_s = _timed(lambda: map_ours(aircraft, feasible))
    names = (f"map of {len(cells)} sizings", "its feasible cells")
    works = (
        f"latitude x payload, 3 dates, {len(cells) - len(feasible)} of {len(cells)} infeasible",
        f"{len(feasible)} cells",
    )
    asb = optional("aerosandbox")
    if asb is None:
        times = (ours_s, feasible_s)
        return [missing(n, w, s, _PEER) for n, w, s in zip(names, works, times, strict=True)]
    _quiet()
    chosen = range(0, len(cells), _EVERY)
    theirs_m, times_s = _map_peer(asb, aircraft, [cells[i] for i in chosen])
    agreed = _agreement([(spans_m[i], s) for i, s in zip(chosen, theirs_m, strict=True)])
    failed = np.array([s is None for s in theirs_m])
    taken = np.array(times_s)
    of_feasible_s = len(feasible) * float(taken[~failed].mean())
    of_others_s = (len(cells) - len(feasible)) * float(taken[failed].mean())
    measured = (
        f"peer measured on {len(taken)} cells ({failed.sum()} infeasible) and scaled to all, "
        f"{1e3 * taken[~failed].mean():.0f} ms for a feasible and "
        f"{1e3 * taken[failed].mean():.0f} ms for an infeasible one"
    )
    peer = f"{_PEER}, one by one"
    return [
        row(
            names[0], f"{works[0]}; {measured}; {agreed}", ours_s, peer, of_feasible_s + of_others_s
        ),
        row(names[1], f"{works[1]}; peer scaled as above", feasible_s, peer, of_feasible_s),
    ]


def _timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """Result of a run that is too long to repeat, and its CPU time [s]."""
    begun = time.process_time()
    result = work()
    return result, time.process_time() - begun


def _cell(aircraft: Aircraft, latitude_deg: float, payload_kg: float) -> Cell:
    mission = shared_mission(latitude_deg, payload_kg)
    return Cell(mission, sun_of(aircraft, mission))


def map_ours(aircraft: Aircraft, cells: Sequence[Cell]) -> list[float | None]:
    """Least wingspan of every cell [m], none where infeasible: all cells at once."""
    each = [cell.mission.scenarios() for cell in cells]
    found = size_cells(
        aircraft,
        cells[0].mission,
        Scenarios(
            np.concatenate([one.latitude_deg for one in each]),
            np.concatenate([one.day_of_year for one in each]),
        ),
        Objective.min_wingspan,
        scenarios_per_cell=len(each[0]),
        required_excess_time_h=REQUIRED_H,
        payload_mass_kg=[cell.mission.payload.mass_kg for cell in cells],
    )
    return [float(v) if np.isfinite(v) else None for v in found.objective_value]


def _map_peer(
    asb: Any, aircraft: Aircraft, cells: Sequence[Cell]
) -> tuple[list[float | None], list[float]]:
    """Least wingspans by AeroSandbox and the time of each; the program is built once."""
    built = Collocation.build(asb, aircraft, cells[0].mission, cells[0].day)
    spans_m, times_s = [], []
    for cell in cells:
        begun = time.process_time()
        built.put(cell.day, REQUIRED_H, cell.mission.payload.mass_kg)
        spans_m.append(built.solve())
        times_s.append(time.process_time() - begun)
    return spans_m, times_s


def _agreement(pairs: Sequence[tuple[float | None, float | None]]) -> str:
    """Say that the optima are the same.

    Raises
    ------
    AssertionError
        If they are not: the comparison would be void.
    """
    worst = 0.0
    for ours, theirs in pairs:
        if (ours is None) != (theirs is None):
            raise AssertionError(f"ours {ours}, peer {theirs}: only one of them is feasible")
        if ours is not None and theirs is not None:
            worst = max(worst, abs(ours / theirs - 1.0))
    if worst > _AGREEMENT:
        raise AssertionError(f"the optima differ by {100 * worst:.2f} %")
    return f"optima within {100 * worst:.2f} % of each other"


def _quiet() -> None:
    # CasADi announces a change of its NumPy support whenever AeroSandbox calls it.
    warnings.filterwarnings("ignore", category=FutureWarning)
