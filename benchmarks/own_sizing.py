"""Times of this project alone, without a peer: a sizing, and the cells of a map."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.measuring import best_time_s, row
from missions.mission import Scenarios
from sizing.objectives import Objective
from sizing.optimiser import size_aircraft
from sizing.performance import performance, solar_day
from studies.library import load_aircraft, load_mission


def sizing() -> list[dict[str, Any]]:
    """Sizing for nine scenarios: whole call, and time in the solver."""
    aircraft = load_aircraft("atlantiksolar-design").aircraft
    mission = load_mission("central-europe-summer").mission
    solves: list[float] = []

    def work() -> None:
        result = size_aircraft(
            aircraft, mission, Objective.min_wingspan, required_excess_time_h=5.0
        )
        solves.append(result.solver.time_s)

    whole = best_time_s(work)
    text = "9 scenarios, least wingspan with 5 h of excess time"
    return [
        row("sizing, with simulation", text, whole, None, None),
        row("sizing, solver alone", text, min(solves), None, None),
    ]


def map_cells() -> list[dict[str, Any]]:
    """Cost of a map against its size: time for each cell."""
    aircraft = load_aircraft("atlantiksolar-as2").aircraft
    mission = load_mission("rafz-july").mission
    rows = []
    for count in (128, 512, 2048):
        scenarios = Scenarios(
            np.linspace(-70.0, 70.0, count), np.arange(count, dtype=int) * 7 % 365 + 1
        )

        def work(scenarios: Scenarios = scenarios) -> None:
            lit = solar_day(aircraft, mission, scenarios=scenarios)
            performance(aircraft, mission, day=lit)

        rows.append(row("map, one cell", f"of {count}", best_time_s(work, 3) / count, None, None))
    return rows
