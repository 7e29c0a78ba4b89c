"""Commands without ``--workers``: the pool that starts by itself changes nothing."""

from multiprocessing.process import BaseProcess

import pytest
import xarray as xr

from studies.output.gridded import SizingStatus

pytestmark = pytest.mark.slow

DESIGN = ["atlantiksolar-design", "--resize", "min_wingspan"]
MAP = ["map", *DESIGN, "--latitudes", "-70:70:20", "--days", "1:365:60"]
SWEEP = ["sweep", *DESIGN, "--vary", "battery.specific_energy_wh_per_kg=200:400:20"]


@pytest.fixture
def started(monkeypatch):
    """Names of the processes that were started; any work is long enough for two of them."""
    names = []
    start = BaseProcess.start

    def noted(process):
        start(process)
        names.append(process.name)

    monkeypatch.setattr(BaseProcess, "start", noted)
    monkeypatch.setattr("studies.engine.workers._PAYS_S", 0.0)
    monkeypatch.setattr("studies.engine.workers.available_cores", lambda: 2)
    # Chunks so small that a few cells make enough of them for all processes.
    monkeypatch.setattr("studies.engine.run._LEAST_CHUNK_S", 0.06)
    return names


@pytest.mark.parametrize("command", [MAP, SWEEP], ids=lambda command: command[0])
def test_processes_are_started_unasked_and_agree(command, run, started, tmp_path):
    assert run(*command, "--out", "one.nc", "--workers", "1").code == 0
    assert not started
    assert run(*command, "--out", "default.nc").code == 0
    assert len(started) >= 2, "the work ended before the pool was worth its start"
    assert run(*command, "--out", "two.nc", "--workers", "2").code == 0
    one, default, two = (
        xr.load_dataset(tmp_path / f"{name}.nc", engine="h5netcdf")
        for name in ("one", "default", "two")
    )
    xr.testing.assert_identical(one, default)
    xr.testing.assert_identical(one, two)
    assert not (default["status"] == SizingStatus.failed).any()
