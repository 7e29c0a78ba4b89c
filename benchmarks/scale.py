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
from sizing.sunlight import SolarModel
from studies.engine.dask_pool import DaskPool
from studies.engine.run import run
from studies.engine.workers import Columns, LocalPool, Pool, available_cores
from studies.maps.resized import prepare

_REPEATS = 2


def variants(dask: bool) -> dict[str, Callable[[], Pool]]:
    """Pools to be compared, by name."""
    local: dict[str, Callable[[], Pool]] = {
        "1 process": lambda: LocalPool(1),
        "2 processes": lambda: LocalPool(2),
    }
    if dask:
        local["dask, 1 worker"] = lambda: DaskPool("local-cluster", 1)
        local["dask, 2 workers"] = lambda: DaskPool("local-cluster", 2)
    return local


def main(arguments: list[str]) -> None:
    """Measure and print a table."""
    job = prepare(
        load_aircraft("atlantiksolar-design"),
        load_mission("rafz-july"),
        "min_wingspan",
        np.linspace(-60.0, 60.0, 61),
        np.arange(1, 366, 7),
        SolarModel(),
    ).job
    print(f"{len(job.cells)} cells in {len(job.chunks)} chunks, {available_cores()} cores")
    first: Columns = {}
    best: dict[str, float] = {}
    for _ in range(_REPEATS):
        for name, pool in variants("--scheduler" in arguments).items():
            begun = time.perf_counter()
            columns = run(job, pool()).columns
            spent = time.perf_counter() - begun
            best[name] = min(best.get(name, spent), spent)
            first = first or columns
            same = all(first[k].tobytes() == columns[k].tobytes() for k in first)
            print(f"  {name:16} {spent:6.1f} s{'' if same else '  OTHER RESULT'}", flush=True)
    for name, spent in best.items():
        print(f"{name:16} {spent:6.1f} s, {best['1 process'] / spent:.2f} times one process")


if __name__ == "__main__":
    main(sys.argv[1:])
