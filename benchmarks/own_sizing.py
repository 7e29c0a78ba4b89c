"""Times of this project alone, without a peer: a sizing."""

from __future__ import annotations

from typing import Any

from benchmarks.measuring import best_time_s, row
from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.program.objectives import Objective
from sizing.program.size import size_aircraft


def sizing() -> list[dict[str, Any]]:
    """Sizing for nine scenarios: whole call, and time in the solver."""
    aircraft = load_aircraft("atlantiksolar-design")
    mission = load_mission("central-europe-summer")
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
