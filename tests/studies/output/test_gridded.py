"""What an earlier run has kept is used again; files are made in memory."""

import errno
import tempfile

import pytest
from builders import AS2, DESIGN, mission

from sizing.day.light import SolarModel
from studies.engine import run as engine
from studies.engine.chunk_store import ChunkStore
from studies.engine.workers import Pool
from studies.maps.study import prepare
from studies.output.gridded import to_netcdf_bytes


def fixed():
    """Map from pole to pole: with and without sun."""
    return prepare(AS2, mission(), [-90.0, 0.0, 90.0], [1, 172], SolarModel()).job


def sized():
    """One cell that can be sized, and one that cannot."""
    return prepare(DESIGN, mission(), [0.0, 90.0], [355], SolarModel(), objective="min_mass").job


@pytest.mark.parametrize("make", [fixed, sized])
def test_what_was_computed_is_believed(make, tmp_path):
    job = make()
    for kept in (0, len(job.chunks)):
        with ChunkStore(tmp_path).opened() as store:
            outcome = engine.run(job, Pool(1), store)
        assert outcome.kept_chunks == kept


@pytest.mark.parametrize("light", [True, False])
def test_netcdf_needs_no_room_in_the_temporary_folder(light, monkeypatch, tmp_path):
    # HDF5 ends the process where its disk is full: the file is made in memory.
    study = prepare(AS2, mission(), [0.0, 45.0], [1, 172], SolarModel())
    data = study.computed() if light else study.computed().to_xarray()

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    for name in ("mkstemp", "mkdtemp", "TemporaryFile", "NamedTemporaryFile"):
        monkeypatch.setattr(tempfile, name, full)
    monkeypatch.setenv("TMPDIR", str(tmp_path / "gone"))
    assert to_netcdf_bytes(data).startswith(b"\x89HDF")
