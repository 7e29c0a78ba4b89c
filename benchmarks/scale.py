"""``python -m benchmarks.scale [--scheduler]``: a map of best designs by one and two workers.

Every variant computes the same job in full, and must give the same bits. Wall time includes the
start of the workers. With ``--scheduler`` also on dask clusters of this machine. The cells are held
to one thread each, so that two workers are compared with one and not with idle cores.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.optimisation.objectives import Objective
from sizing.sunlight import SolarModel
from studies.engine.run import Columns, run
from studies.engine.workers import Crew, DaskCrew, ProcessCrew, SerialCrew, available_cores
from studies.maps.jobs import SizedMapConfiguration, sized_map_job

_REPEATS = 2


def variants(dask: bool) -> dict[str, Callable[[], Crew]]:
    """Crews to be compared, by name."""
    local: dict[str, Callable[[], Crew]] = {
        "this process": SerialCrew,
        "1 process": lambda: ProcessCrew(1),
        "2 processes": lambda: ProcessCrew(2),
    }
    if dask:
        local["dask, 1 worker"] = lambda: DaskCrew("local-cluster", 1)
        local["dask, 2 workers"] = lambda: DaskCrew("local-cluster", 2)
    return local


def main(arguments: list[str]) -> None:
    """Measure and print a table."""
    job = sized_map_job(
        SizedMapConfiguration(
            load_aircraft("atlantiksolar-design"),
            load_mission("rafz-july"),
            SolarModel(),
            Objective.min_wingspan,
        ),
        np.linspace(-60.0, 60.0, 61),
        np.arange(1.0, 366.0, 7.0),
    )
    print(f"{job.cells} cells in {len(job.chunks)} chunks, {available_cores()} cores")
    first: Columns = {}
    best: dict[str, float] = {}
    for _ in range(_REPEATS):
        for name, crew in variants("--scheduler" in arguments).items():
            begun = time.perf_counter()
            columns = run(job, crew()).columns
            spent = time.perf_counter() - begun
            best[name] = min(best.get(name, spent), spent)
            first = first or columns
            same = all(first[k].tobytes() == columns[k].tobytes() for k in first)
            print(f"  {name:16} {spent:6.1f} s{'' if same else '  OTHER RESULT'}", flush=True)
    for name, spent in best.items():
        print(f"{name:16} {spent:6.1f} s, {best['1 process'] / spent:.2f} times one process")


if __name__ == "__main__":
    main(sys.argv[1:])
