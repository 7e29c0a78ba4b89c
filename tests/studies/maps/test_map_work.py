"""Tests of maps on the engine: in parallel, stopped and continued, sized cell by cell."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner, Result

from missions.files.errors import InputError
from missions.library import load_mission
from missions.mission import Dates
from sizing.library import load_aircraft
from sizing.optimisation.objectives import Objective
from sizing.optimisation.search import size_aircraft
from sizing.sunlight import SolarModel
from studies.cli.__main__ import cli
from studies.engine.run import run as compute
from studies.engine.workers import ProcessCrew, SerialCrew
from studies.maps import feasibility as feasibility_map
from studies.maps import jobs as map_jobs
from studies.maps.jobs import MapConfiguration, SizedMapConfiguration, rectangles
from studies.output.columns import SizingStatus

pytestmark = pytest.mark.slow

AS2 = load_aircraft("atlantiksolar-as2")
DESIGN = load_aircraft("atlantiksolar-design")
JULY = load_mission("rafz-july")

SMALL = ["atlantiksolar-as2", "--latitudes", "40:50:2", "--days", "1:361:40"]


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(cli, ["map", *arguments])


@pytest.mark.parametrize("cell_s", [1e-6, 0.004, 0.03, 10.0])
def test_chunks_hold_every_cell_once_and_are_rectangles(cell_s: float) -> None:
    latitudes, days = np.linspace(-70, 70, 15), np.arange(1, 362, 20)
    chunks = rectangles(latitudes, days, cell_s)
    cells = [cell for chunk in chunks for cell in chunk]
    assert sorted(cells) == [(lat, day) for lat in latitudes for day in days]
    for chunk in chunks:
        assert len(chunk) == len({lat for lat, _ in chunk}) * len({day for _, day in chunk})
        assert len(chunk) <= max(0.5 / cell_s, 1.0) + 1.0


def test_map_of_chunks_is_that_of_the_function() -> None:
    latitudes, days = np.linspace(-80, 80, 9), np.arange(1, 362, 4)
    job = map_jobs.map_job(MapConfiguration(AS2, JULY, SolarModel()), latitudes, days)
    assert len(job.chunks) == 1
    # In chunks of five rows, by two processes.
    cut = map_jobs.map_job(MapConfiguration(AS2, JULY, SolarModel()), latitudes, days)
    small = type(cut)(
        cut.function, cut.configuration, rectangles(latitudes, days, 1e-3), cut.blanks
    )
    assert len(small.chunks) > 1
    pooled = map_jobs.map_dataset(small, compute(small, ProcessCrew(2)), latitudes, days)
    alone = map_jobs.map_dataset(small, compute(small, SerialCrew()), latitudes, days)
    xr.testing.assert_identical(pooled, alone)
    whole = feasibility_map.feasibility_map(AS2, JULY, latitudes, days, SolarModel())
    # The fixed point is settled to 1e-11 of the battery, in whatever block a cell stands.
    xr.testing.assert_allclose(alone, whole, rtol=1e-7, atol=1e-9)
    assert alone.attrs == whole.attrs


def test_command_is_the_same_with_processes_and_leaves_no_parts(
    invoke: Any, tmp_path: Path
) -> None:
    for name, options in (("one.nc", ["--workers", "1"]), ("two.nc", ["--workers", "2"])):
        answer = invoke(*SMALL, "--out", name, *options)
        assert answer.exit_code == 0, answer.output
    one, two = (xr.load_dataset(tmp_path / n, engine="h5netcdf") for n in ("one.nc", "two.nc"))
    xr.testing.assert_identical(one, two)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["one.nc", "two.nc"]


def test_kept_parts_are_used_again(invoke: Any, tmp_path: Path, monkeypatch: Any) -> None:
    assert invoke(*SMALL, "--out", "map.nc", "--keep-parts").exit_code == 0
    assert list((tmp_path / "map.nc.parts").glob("*.part"))

    def refuse(*arguments: Any) -> None:
        raise AssertionError("computed again")

    monkeypatch.setattr(feasibility_map, "map_block", refuse)
    first = xr.load_dataset(tmp_path / "map.nc", engine="h5netcdf")
    # Another file, the same work.
    answer = invoke(*SMALL, "--out", "again.nc", "--work", "map.nc.parts")
    assert answer.exit_code == 0, answer.output
    xr.testing.assert_identical(first, xr.load_dataset(tmp_path / "again.nc", engine="h5netcdf"))
    assert not (tmp_path / "map.nc.parts").exists()


def test_cells_that_fail_have_a_flag_and_are_tried_again(
    invoke: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    block = feasibility_map.map_block

    def failing(aircraft: Any, mission: Any, latitudes: Any, days: Any, *rest: Any) -> Any:
        if 44.0 in latitudes and 81 in days:
            raise FloatingPointError("not today")
        return block(aircraft, mission, latitudes, days, *rest)

    monkeypatch.setattr(feasibility_map, "map_block", failing)
    answer = invoke(*SMALL, "--out", "map.nc", "--workers", "1", "--json")
    assert answer.exit_code == 0, answer.output
    assert "1 of 60 cells failed; the first: FloatingPointError: not today" in answer.stderr
    json.loads(answer.stdout)
    data = xr.load_dataset(tmp_path / "map.nc", engine="h5netcdf")
    flags = dict(
        zip(
            data["status"].attrs["flag_meanings"].split(),
            data["status"].attrs["flag_values"].tolist(),
            strict=True,
        )
    )
    failed = (data["status"] == flags["failed"]).values
    assert failed.sum() == 1
    assert failed[2, 2]
    assert np.isnan(data["excess_time"].values[2, 2])
    assert data.attrs["failed_cells"] == "latitude 44, day 81: FloatingPointError: not today"
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    assert invoke(*SMALL, "--out", "map.nc").exit_code == 0
    again = xr.load_dataset(tmp_path / "map.nc", engine="h5netcdf")
    assert "failed_cells" not in again.attrs
    assert sorted(p.name for p in tmp_path.iterdir()) == ["map.nc"]


def test_where_every_cell_fails_there_is_no_file(
    invoke: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*arguments: Any) -> None:
        raise FloatingPointError("never")

    monkeypatch.setattr(feasibility_map, "map_block", failing)
    answer = invoke(*SMALL, "--out", "map.nc", "--workers", "1")
    assert answer.exit_code == 1
    assert "60 of 60 cells failed" in answer.stderr
    assert not (tmp_path / "map.nc").exists()


def command(*arguments: str, cwd: Path) -> subprocess.Popen[str]:
    root = str(Path(feasibility_map.__file__).parents[2])
    return subprocess.Popen(
        [sys.executable, "-m", "studies.cli", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": root},
        start_new_session=True,
    )


@pytest.mark.parametrize(("signum", "workers"), [(signal.SIGINT, "2"), (signal.SIGTERM, "1")])
def test_a_stopped_command_says_how_to_go_on(
    tmp_path: Path, signum: signal.Signals, workers: str
) -> None:
    asked = ["atlantiksolar-design", "--resize", "min_mass", "--latitudes", "0:60:4"]
    asked = ["map", *asked, "--days", "1:365:10", "--out", "m.nc", "--workers", workers]
    process = command(*asked, cwd=tmp_path)
    folder = tmp_path / "m.nc.parts"
    deadline = time.monotonic() + 120.0
    while len(list(folder.glob("*.part"))) < 2:
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.02)
    os.killpg(process.pid, signum)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (128 + signum, "")
    assert "Traceback" not in err
    kept = len(list(folder.glob("*.part")))
    assert f"{kept} of " in err
    assert err.strip().endswith(f"solar-uav {' '.join(asked)}")
    process = command(*asked, cwd=tmp_path)
    _, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    assert not folder.exists()
    data = xr.load_dataset(tmp_path / "m.nc", engine="h5netcdf")
    found = set(data["status"].to_numpy().ravel().tolist())
    assert SizingStatus.cross_checked in found
    assert found <= {SizingStatus.cross_checked, SizingStatus.optimal, SizingStatus.infeasible}


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--out", "none/map.nc"], 1, "folder does not exist"),
        (["--out", "folder.nc"], 1, "it is a folder"),
        (["--out", "map.nc", "--work", "file"], 1, "cannot make file"),
        (["--plot", "none/map.png"], 1, "folder does not exist"),
        (["--resize", "min_mass", "--endurance"], 2, "--endurance"),
        (["--scheduler", "tcp://a:1", "--workers", "2"], 2, "--workers"),
    ],
)
def test_what_cannot_work_is_refused_at_once(
    invoke: Any, tmp_path: Path, options: list[str], code: int, words: str
) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder.nc").mkdir()
    answer = invoke(*SMALL, *options)
    text = answer.output if answer.exception is None else f"{answer.output}{answer.exception}"
    assert words in text
    assert answer.exit_code == code


def test_a_measured_aircraft_cannot_be_sized(invoke: Any) -> None:
    answer = invoke(*SMALL, "--resize", "min_mass")
    assert isinstance(answer.exception, InputError)
    assert "parametric" in str(answer.exception)


# ---- the best design of each cell


@pytest.fixture(scope="module")
def sized() -> xr.Dataset:
    latitudes, days = np.array([0.0, 47.6, 75.0]), np.array([172, 355])
    asked = SizedMapConfiguration(DESIGN, JULY, SolarModel(), Objective.min_wingspan)
    job = map_jobs.sized_map_job(asked, latitudes, days)
    return map_jobs.sized_map_dataset(job, compute(job, SerialCrew()), latitudes, days)


def test_a_worker_sizes_the_next_chunk_with_an_equal_aircraft() -> None:
    """Each task brings its own copy of the aircraft; the worker keeps the programs of the last."""
    asked = SizedMapConfiguration(DESIGN, JULY, SolarModel(), Objective.min_wingspan)
    once = map_jobs.sized_map_chunk(asked, [(0.0, 172.0)])
    # What was derived while it was used in this process travels along.
    again = map_jobs.sized_map_chunk(pickle.loads(pickle.dumps(asked)), [(0.0, 172.0)])
    assert once["status"].tolist() == again["status"].tolist() == [SizingStatus.cross_checked]
    assert once["wingspan"].tolist() == again["wingspan"].tolist()


@pytest.mark.slow
def test_sized_map_is_the_same_whoever_computes_it(invoke: Any, tmp_path: Path) -> None:
    asked = ["atlantiksolar-design", "--resize", "min_wingspan"]
    asked += ["--latitudes", "-70:70:10", "--days", "1:365:15"]
    maps = []
    for name, options in (("some", []), ("one", ["--workers", "1"]), ("two", ["--workers", "2"])):
        answer = invoke(*asked, "--out", f"{name}.nc", *options)
        assert answer.exit_code == 0, answer.output
        maps.append(xr.load_dataset(tmp_path / f"{name}.nc", engine="h5netcdf"))
        assert not (maps[-1]["status"] == SizingStatus.failed).any()
    xr.testing.assert_identical(maps[0], maps[1])
    xr.testing.assert_identical(maps[0], maps[2])


def test_cells_are_sizings_of_their_own(sized: xr.Dataset) -> None:
    mission = JULY.model_copy(update={"latitude_deg": 47.6, "dates": Dates(on="06-21")})
    result = size_aircraft(DESIGN, mission, Objective.min_wingspan)
    cell = sized.sel(latitude=47.6, day=172)
    assert int(cell["status"]) == SizingStatus.cross_checked
    # Two searches that both stop within 0.012 h of the requirement.
    assert float(cell["wingspan"]) == pytest.approx(result.objective_value, rel=2e-3)
    assert float(cell["excess_time"]) > 0.0
    assert float(cell["module_area"]) <= 0.85 * float(cell["wingspan"]) ** 2 / 18.5 * (1 + 1e-6)


def test_infeasible_cells_say_what_is_missing(sized: xr.Dataset) -> None:
    winter = sized.sel(latitude=47.6, day=355)
    assert int(winter["status"]) == SizingStatus.infeasible
    assert winter["violated_requirement"].item() == "energy_balance"
    assert float(winter["shortfall"]) > 0.0
    assert np.isnan(winter["wingspan"])
    night = sized.sel(latitude=75.0, day=355)
    assert int(night["status"]) == SizingStatus.infeasible
    assert "polar night" in night["message"].item()


def test_sized_map_follows_cf_and_survives_its_file(sized: xr.Dataset, tmp_path: Path) -> None:
    path = tmp_path / "sized.nc"
    path.write_bytes(feasibility_map.to_netcdf_bytes(sized))
    again = xr.load_dataset(path, engine="h5netcdf")
    meanings = again["status"].attrs["flag_meanings"].split()
    assert meanings == [
        *("failed", "optimal", "infeasible", "not_converged", "invalid", "cross_checked")
    ]
    assert again["status"].attrs["flag_values"].tolist() == [-1, 0, 1, 2, 3, 4]
    assert again["latitude"].attrs["standard_name"] == "latitude"
    assert json.loads(again.attrs["aircraft"])["name"] == "atlantiksolar-design"
    assert again.attrs["objective"] == "min_wingspan"
    xr.testing.assert_equal(again, sized)


def test_table_counts_the_cross_checked_designs(invoke: Any) -> None:
    asked = ["atlantiksolar-design", "--resize", "min_wingspan", "--workers", "1"]
    answer = invoke(*asked, "--latitudes", "0:75:75", "--days", "172:355:183")
    assert answer.exit_code == 0, answer.output
    rows = {row.split()[1]: row.split() for row in answer.output.splitlines() if "N" in row[:12]}
    # Latitude, days with a design, without one, unknown: cross-checked is a design.
    assert [rows["0"][i] for i in (4, 6, 8)] == ["2", "0", "0"]
    assert [rows["75"][i] for i in (4, 6, 8)] == ["1", "1", "0"]


def test_figure_of_best_designs_hatches_what_has_none(sized: xr.Dataset) -> None:
    figure = map_jobs.sized_map_figure(sized)
    assert "wingspan [m]" in figure.axes[1].get_ylabel()
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["infeasible"]
    assert any(c.get_hatch() for c in figure.axes[0].collections)
