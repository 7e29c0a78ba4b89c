"""The map against an independent loop in C, cell by cell over the year and all latitudes."""

import shutil
from pathlib import Path

import pytest

from benchmarks import map_scaling

pytestmark = pytest.mark.slow


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no C compiler")
def test_map_is_that_of_a_loop_in_c(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Every third of the benchmark's latitudes and days: all its statuses occur among them.
    for name in ("_LATITUDES", "_DAYS"):
        monkeypatch.setattr(map_scaling, name, getattr(map_scaling, name)[::3])
    library = map_scaling._compiled(tmp_path)
    bound = map_scaling._Bound(library)
    # Compares all metrics to 1e-8 and asks for every status to occur.
    bound.check(map_scaling._map(map_scaling._LATITUDES, map_scaling._DAYS))
