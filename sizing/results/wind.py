"""Wind of a mission that has it by latitude, altitude and month, as results tell it."""

from __future__ import annotations

from typing import Any

import numpy as np

from missions.mission import Mission


def wind_record(mission: Mission) -> dict[str, Any] | None:
    """Percentile, table and wind of every scenario, JSON-ready; none for a given wind."""
    given = mission.wind_statistics
    if given is None:
        return None
    return {
        "percentile": given.percentile,
        "hold_station": given.hold_station,
        "source": given.table(mission.longitude_deg).source,
        "scenarios_m_per_s": mission.scenario_winds_m_per_s().tolist(),
    }


def wind_rows(mission: Mission) -> list[tuple[str, str]]:
    """Row of a table of facts: the wind, from the weakest to the strongest scenario."""
    given = mission.wind_statistics
    if given is None:
        return []
    winds = mission.scenario_winds_m_per_s()
    ends = dict.fromkeys(f"{w:.1f}" for w in (np.min(winds), np.max(winds)))
    source = given.table(mission.longitude_deg).source
    return [
        (f"wind, {given.percentile:g} % of the time at most", f"{' to '.join(ends)} m/s"),
        ("winds from", source),
        *(
            [("flown, to hold its place", "as fast as the wind at least")]
            if given.hold_station
            else []
        ),
    ]
