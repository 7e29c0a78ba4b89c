"""What all benchmarks share: times, optional peers, and the lines of the result.

Times are CPU times of the process, which other users of the machine disturb least. Neither this
project nor its peers start threads of their own in these tasks.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

REPEATS = 5


def best_time_s(work: Callable[[], Any], repeats: int = REPEATS, *, warm_up: bool = True) -> float:
    """Least CPU time of several runs after one that warms up [s]."""
    if warm_up:
        work()
    times = []
    for _ in range(repeats):
        begun = time.process_time()
        work()
        times.append(time.process_time() - begun)
    return min(times)


def row(
    name: str, work: str, ours_s: float, peer: str | None, peer_s: float | None
) -> dict[str, Any]:
    """One line of the result."""
    ratio = None if peer_s is None else peer_s / ours_s
    return {
        "name": name,
        "work": work,
        "ours_s": ours_s,
        "peer": peer,
        "peer_s": peer_s,
        "ratio": ratio,
    }


def optional(name: str) -> Any:
    """Peer's module, none where it is not installed."""
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def missing(name: str, work: str, ours_s: float, peer: str) -> dict[str, Any]:
    """Line for a peer that is not installed."""
    return row(name, work, ours_s, f"{peer}: not installed", None)
