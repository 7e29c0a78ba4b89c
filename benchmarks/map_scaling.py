"""The feasibility map: its time, its cost against its size, and its memory."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

from benchmarks.measuring import best_time_s, row
from missions.library import load_mission
from sizing.day.light import SolarModel
from sizing.library import load_aircraft
from studies.maps.study import prepare

_AIRCRAFT, _MISSION = "atlantiksolar-as2", "rafz-july"
_LATITUDES, _DAYS = np.linspace(-90.0, 90.0, 181), np.arange(1, 366)


def _row(work: str, ours_s: float) -> dict[str, Any]:
    return row("map", work, ours_s, None, None)


def _map(latitudes: Any, days: Any, *, endurance: bool = False) -> Mapping[str, Any]:
    """Columns of a map, computed in this process."""
    aircraft, mission = load_aircraft(_AIRCRAFT), load_mission(_MISSION)
    study = prepare(aircraft, mission, latitudes, days, SolarModel(), endurance=endurance)
    return study.job.function(study.configuration, study.cells)


def full_map() -> list[dict[str, Any]]:
    """The full map."""
    ours = best_time_s(lambda: _map(_LATITUDES, _DAYS), 3)
    return [
        _row(f"{len(_LATITUDES)} latitudes x {len(_DAYS)} days, all metrics; processor time", ours)
    ]


def map_endurance() -> list[dict[str, Any]]:
    """A ninth of the full map with the longest flight of every cell."""
    begun = time.process_time()
    part = _map(_LATITUDES[::3], _DAYS[::3], endurance=True)
    used = time.process_time() - begun
    ends = int(np.isfinite(part["endurance"]).sum())
    text = f"{part['status'].size} cells with endurance, finite in {ends}; processor time"
    return [_row(text, used)]


def two_processes() -> list[dict[str, Any]]:
    """The full map in two processes that are already running."""
    parts = np.array_split(_LATITUDES, 8)
    with ProcessPoolExecutor(2) as pool:
        times = []
        for _ in range(4):
            begun = time.perf_counter()
            list(pool.map(_map, parts, [_DAYS] * len(parts)))
            times.append(time.perf_counter() - begun)
    return [_row("the full map in two warm processes; wall time", min(times[1:]))]


def map_memory() -> list[dict[str, Any]]:
    """Most memory of a process that computes the full map, Python and libraries included."""
    code = (
        "import json, resource, sys, time\n"
        "from benchmarks import map_scaling as m\n"
        "begun = time.process_time()\n"
        "m._map(m._LATITUDES, m._DAYS)\n"
        "peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "unit = 2**20 if sys.platform == 'darwin' else 2**10\n"
        "print(json.dumps([time.process_time() - begun, peak / unit]))\n"
    )
    answer = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
    used_s, peak_mib = json.loads(answer.stdout)
    row = _row(f"the full map in a fresh process; peak memory {peak_mib:.0f} MiB", used_s)
    return [dict(row, peak_memory_mib=peak_mib)]


def map_sizes() -> list[dict[str, Any]]:
    """Cost of a cell against their number, up to 10^5."""
    return _cost_against_size((10**3, 10**4, 10**5))


def large_maps() -> list[dict[str, Any]]:
    """The same up to 10^7, which takes minutes."""
    return _cost_against_size((10**5, 10**6, 10**7))[1:]


def _cost_against_size(sizes: Sequence[int]) -> list[dict[str, Any]]:
    rows, cells, times = [], [], []
    for size in sizes:
        latitudes = np.linspace(-90.0, 90.0, max(round(size / len(_DAYS)), 2))
        count = len(latitudes) * len(_DAYS)
        parts = np.array_split(latitudes, max(1, count // 10**5))

        def work(parts: Any = parts) -> None:
            for part in parts:
                _map(part, _DAYS)

        used = best_time_s(work, 5) if size <= 10**4 else _once_cpu_s(work)
        rows.append(_row(f"{count} cells: {1e6 * used / count:.1f} us for each", used))
        cells.append(count)
        times.append(used)
    slope = float(np.polyfit(np.log(cells), np.log(times), 1)[0])
    slope_text = f"; slope of log time against log cells {slope:.3f} from {cells[0]} cells"
    rows[-1]["work"] += slope_text
    rows[-1]["slope"] = slope
    return rows


def _once_cpu_s(work: Callable[[], Any]) -> float:
    begun = time.process_time()
    work()
    return time.process_time() - begun
