"""What an earlier run has kept is believed where it can be a result, and nowhere else."""

import errno
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import AS2, DESIGN, mission

from sizing.day.light import SolarModel
from sizing.day.metrics import (
    ENDS,
    Status,
)
from studies.engine import run as engine
from studies.engine.chunk_store import ChunkStore
from studies.engine.workers import Job, LocalPool
from studies.maps import feasibility, resized
from studies.output.gridded import can_be_result, to_netcdf_bytes

POSSIBLE = can_be_result((Status.failed, *ENDS), [Status.perpetual, Status.never_lit])
GOOD: dict[str, Any] = {
    "status": np.array([Status.perpetual, Status.limited], np.int8),
    "excess_time": np.array([1.0, np.nan]),
    "extrapolations": np.array(["", ""]),
}


def test_a_result_is_believed() -> None:
    assert POSSIBLE(GOOD)
    assert POSSIBLE({name: GOOD[name] for name in ("status", "excess_time")})
    assert POSSIBLE(GOOD | {"excess_time": np.array([np.inf, 0.0])})


def test_other_states_and_a_result_without_a_number_are_refused() -> None:
    for status in (99, -1, 127):
        assert not POSSIBLE(GOOD | {"status": np.array([status, 1], np.int8)})
    assert not POSSIBLE(GOOD | {"excess_time": np.array([np.nan, 1.0])})


def test_what_tells_of_no_model_is_refused() -> None:
    with pytest.raises(ValueError, match="names no model"):
        POSSIBLE(GOOD | {"extrapolations": np.array(["", "\x1b[31m"])})


def fixed() -> Job:
    """Map from pole to pole: with and without sun."""
    return feasibility.prepare(AS2, mission(), [-90.0, 0.0, 90.0], [1, 172], SolarModel()).job


def sized() -> Job:
    """One cell that can be sized, and one that cannot."""
    return resized.prepare(DESIGN, mission(), "min_mass", [0.0, 90.0], [355], SolarModel()).job


@pytest.mark.parametrize("make", [fixed, sized])
def test_what_was_computed_is_believed(make: Any, tmp_path: Path) -> None:
    job = make()
    for kept in (0, len(job.chunks)):
        with ChunkStore(tmp_path).opened() as store:
            outcome = engine.run(job, LocalPool(1), store)
        assert outcome.kept_chunks == kept


@pytest.mark.parametrize("light", [True, False])
def test_netcdf_needs_no_room_in_the_temporary_folder(
    light: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    # HDF5 ends the process where its disk is full: the file is made in memory.
    study = feasibility.prepare(AS2, mission(), [0.0, 45.0], [1, 172], SolarModel())
    outcome = engine.run(study.job, LocalPool(1))
    data = study.gridded(outcome) if light else study.dataset(outcome)

    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    for name in ("mkstemp", "mkdtemp", "TemporaryFile", "NamedTemporaryFile"):
        monkeypatch.setattr(tempfile, name, full)
    monkeypatch.setenv("TMPDIR", str(tmp_path / "gone"))
    assert to_netcdf_bytes(data).startswith(b"\x89HDF")
