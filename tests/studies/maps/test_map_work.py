"""Tests of maps on the engine: in parallel, stopped and continued, sized cell by cell."""

import json
import os
import pickle
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from figure_checks import heading

from missions.library import load_mission
from sizing.day.light import SolarModel
from sizing.day.metrics import Status
from sizing.library import load_aircraft
from sizing.program.objectives import Objective
from studies.engine.run import ComputationError
from studies.maps import study as map_study
from studies.maps.plots import plot_map, plot_resized_map
from studies.maps.study import feasibility_map, prepare, resized_map, sized_cells
from studies.output.gridded import SizingStatus, to_netcdf_bytes

pytestmark = pytest.mark.slow

AS2 = load_aircraft("atlantiksolar-as2")
DESIGN = load_aircraft("atlantiksolar-design")
JULY = load_mission("rafz-july")

SMALL = ["atlantiksolar-as2", "--latitudes", "40:50:2", "--days", "1:361:40"]


def test_map_of_chunks_is_that_of_one(monkeypatch):
    where = {"latitudes": np.linspace(-80, 80, 9), "days": np.arange(1, 362, 4)}
    whole = prepare(AS2, JULY, *where.values(), SolarModel())
    assert len(whole.job.chunks) == 1
    one = feasibility_map(AS2, JULY, **where)
    monkeypatch.setattr("studies.maps.study._CELL_S", 1e-3)
    small = prepare(AS2, JULY, *where.values(), SolarModel())
    assert len(small.job.chunks) > 4
    np.testing.assert_array_equal(np.concatenate(small.job.chunks), np.arange(len(small.cells)))
    for workers in (1, 2):
        xr.testing.assert_identical(feasibility_map(AS2, JULY, **where, workers=workers), one)


def test_kept_parts_are_used_again(run, tmp_path, monkeypatch):
    assert run("map", *SMALL, "--out", "map.nc", "--keep-parts").code == 0
    assert list((tmp_path / "map.nc.parts").glob("*.part"))

    def refuse(*arguments):
        raise AssertionError("computed again")

    monkeypatch.setattr(map_study, "_simulated", refuse)
    first = xr.load_dataset(tmp_path / "map.nc", engine="h5netcdf")
    # Another file, the same work.
    run("map", *SMALL, "--out", "again.nc", "--work", "map.nc.parts").good()
    xr.testing.assert_identical(first, xr.load_dataset(tmp_path / "again.nc", engine="h5netcdf"))
    assert not (tmp_path / "map.nc.parts").exists()


simulated = map_study._simulated


def failing(aircraft, mission, solar, scenarios):
    if np.any((scenarios.latitude_deg == 44.0) & (scenarios.day_of_year == 81)):
        raise FloatingPointError("not today")
    return simulated(aircraft, mission, solar, scenarios)


def test_cells_that_fail_have_a_flag_and_are_tried_again(run, tmp_path, monkeypatch):
    monkeypatch.setattr(map_study, "_simulated", failing)
    answer = run("map", *SMALL, "--out", "map.nc", "--workers", "1", "--json")
    assert answer.code == 1
    said = "1 of 60 cells failed; the first: FloatingPointError: not today"
    first, *_, last = answer.err.splitlines()
    assert said in first
    assert said in last
    assert answer.json()["failed_days"] == [0, 0, 1, 0, 0, 0]
    table = run("map", *SMALL, "--workers", "1")
    assert table.code == 1
    (row,) = (line.split() for line in table.out.splitlines() if line.startswith("44° N"))
    assert row[-1] == "1"
    data = xr.load_dataset(tmp_path / "map.nc", engine="h5netcdf")
    meanings, values = (data["status"].attrs[f"flag_{of}"] for of in ("meanings", "values"))
    flags = dict(zip(meanings.split(), values.tolist(), strict=True))
    failed = (data["status"] == flags["failed"]).values
    assert failed.sum() == 1
    assert failed[2, 2]
    assert np.isnan(data["excess_time"].values[2, 2])
    assert data.attrs["failed_cells"] == "latitude 44, day 81: FloatingPointError: not today"
    (legend,) = plot_map(data).legends
    assert [text.get_text() for text in legend.get_texts()] == ["could not be computed"]
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    assert run("map", *SMALL, "--out", "map.nc").code == 0
    again = xr.load_dataset(tmp_path / "map.nc", engine="h5netcdf")
    assert "failed_cells" not in again.attrs
    assert sorted(p.name for p in tmp_path.iterdir()) == ["map.nc"]


def test_where_every_cell_fails_there_is_no_file(run, tmp_path, monkeypatch):
    monkeypatch.setattr(map_study, "_simulated", failing)
    cell = ("--latitudes", "44", "--days", "81", "--workers", "1")
    answer = run("map", "atlantiksolar-as2", *cell, "--out", "map.nc")
    assert answer.code == 1
    assert "1 of 1 cells failed" in answer.err
    assert not (tmp_path / "map.nc").exists()


def command(*arguments, cwd):
    """Start the command as it is installed: worker processes import that script again."""
    root = str(Path(map_study.__file__).parents[2])
    return subprocess.Popen(
        [str(Path(sys.executable).with_name("solar-uav")), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": root},
        start_new_session=True,
    )


@pytest.mark.parametrize(("signum", "workers"), [(signal.SIGINT, "2"), (signal.SIGTERM, "1")])
def test_a_stopped_command_says_how_to_go_on(tmp_path, signum, workers):
    asked = ["atlantiksolar-design", "--resize", "min_mass", "--latitudes", "0:60:20"]
    asked = ["map", *asked, "--days", "1:365:10", "--out", "m.nc", "--workers", workers]
    process = command(*asked, cwd=tmp_path)
    folder = tmp_path / "m.nc.parts"
    deadline = time.monotonic() + 120.0
    while len(list(folder.glob("*.part"))) < 1:
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


@pytest.fixture(scope="module")
def sized():
    return resized_map(DESIGN, JULY, "min_wingspan", latitudes=[0.0, 47.6, 75.0], days=[172, 355])


def test_a_worker_sizes_the_next_chunk_with_an_equal_aircraft():
    """Each task brings its own copy of the aircraft; the worker keeps the programs of the last."""
    asked = (DESIGN, JULY, SolarModel(), Objective.min_wingspan)
    once = sized_cells(asked, np.array([[0.0, 172.0]]))
    # What was derived while it was used in this process travels along.
    again = sized_cells(pickle.loads(pickle.dumps(asked)), np.array([[0.0, 172.0]]))
    assert once["status"].tolist() == again["status"].tolist() == [SizingStatus.cross_checked]
    assert once["wingspan"].tolist() == again["wingspan"].tolist()


def test_sized_map_follows_cf_and_survives_its_file(sized, tmp_path):
    path = tmp_path / "sized.nc"
    path.write_bytes(to_netcdf_bytes(sized))
    again = xr.load_dataset(path, engine="h5netcdf")
    meanings = again["status"].attrs["flag_meanings"]
    assert meanings == "failed optimal infeasible not_converged invalid cross_checked"
    assert again["status"].attrs["flag_values"].tolist() == [-1, 0, 1, 2, 3, 4]
    assert again["latitude"].attrs["standard_name"] == "latitude"
    assert json.loads(again.attrs["aircraft"])["name"] == "atlantiksolar-design"
    assert again.attrs["objective"] == "min_wingspan"
    xr.testing.assert_equal(again, sized)


def test_table_counts_the_cross_checked_designs(run):
    asked = ["atlantiksolar-design", "--resize", "min_wingspan", "--workers", "1"]
    answer = run("map", *asked, "--latitudes", "0:75:75", "--days", "172:355:183").good()
    degree = "\N{DEGREE SIGN}"
    lines = answer.out.splitlines()
    rows = {row.split(degree)[0]: row.split() for row in lines if degree in row[:5]}
    # Latitude, days with a design, without one, unknown: cross-checked is a design.
    assert rows["0"][1:4] == ["2", "0", "0"]
    assert rows["75"][2:5] == ["1", "1", "0"]


def test_figure_of_best_designs_hatches_what_has_none(sized):
    figure = plot_resized_map(sized)
    assert "wingspan [m]" in figure.axes[1].get_ylabel()
    title = "Best designs of atlantiksolar-design on rafz-july\nsmallest wingspan · CAM"
    assert heading(figure).startswith(title)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "energy: the day gives less than the load takes",
        "polar night",
    ]
    assert any(c.get_hatch() for c in figure.axes[0].collections)


BOTH = [
    ({"model": "XX"}, "unknown model 'XX'; allowed: CDM, CAM, VM, FM"),
    ({"correction": "some"}, "unknown correction 'some'; allowed: none, report, loiter"),
    ({"latitudes": [50, 40]}, "latitudes must ascend within -90 to 90"),
    ({"latitudes": []}, "latitudes must ascend"),
    ({"latitudes": [float("nan")]}, "latitudes must ascend"),
    ({"days": [0, 1]}, "days must ascend within 1 to 365"),
    ({"days": [1.5]}, "days must be whole numbers"),
    ({"workers": 0}, "workers must be at least 1"),
]
UNKNOWN = "unknown objective '{}'; allowed: max_excess_time"
RESIZED = [
    *[({"objective": one}, UNKNOWN.format(one)) for one in ("min_price", "longest_season")],
    ({"aircraft": AS2}, "atlantiksolar-as2 is measured"),
    ({"required_excess_time_h": -1.0}, "required_excess_time_h: must be at least 0"),
]


@pytest.mark.parametrize(
    ("make", "options", "words"),
    [
        *[(feasibility_map, *case) for case in BOTH],
        *[(resized_map, *case) for case in (*BOTH, *RESIZED)],
    ],
)
def test_python_refuses_what_is_not_allowed(make, options, words):
    asked = {"aircraft": DESIGN, "mission": JULY, "latitudes": [40.0], "days": [172]}
    if make is resized_map:
        asked["objective"] = "min_mass"
    with pytest.raises(ValueError, match=re.escape(words)):
        make(**(asked | options))


def test_python_names_what_a_model_needs():
    bare = JULY.model_copy(update={"flight_path": None})
    for options in ({"model": "FM"}, {"correction": "loiter"}):
        with pytest.raises(ValueError, match="needs a flight_path on the mission rafz-july"):
            feasibility_map(AS2, bare, latitudes=[0.0], days=[1], **options)


def test_python_warns_of_failed_cells_and_raises_where_all_failed(monkeypatch):
    monkeypatch.setattr(map_study, "_simulated", failing)
    with pytest.warns(RuntimeWarning, match="1 of 2 cells failed; the first: FloatingPointError"):
        data = feasibility_map(AS2, JULY, latitudes=[40.0, 44.0], days=[81])
    assert data["status"].values[:, 0].tolist()[1] == Status.failed
    with pytest.raises(ComputationError, match="1 of 1 cells failed"):
        feasibility_map(AS2, JULY, latitudes=[44.0], days=[81])


@pytest.mark.parametrize(
    ("grid", "note"),
    [
        (["--latitudes", "40:60:7"], "--latitudes 40:60:7 stops at 54"),
        (["--days", "1:365:91"], ""),
        (["--days", "1:300:90"], "--days 1:300:90 stops at 271"),
    ],
)
def test_a_grid_that_does_not_meet_its_end_says_so(run, grid, note):
    small = ["--latitudes", "40:45:5", "--days", "100:200:100"]
    answer = run("map", "atlantiksolar-as2", *small, *grid, "--json")
    assert answer.code == 0
    assert note in answer.err
    assert bool(note) == ("stops at" in answer.err)
    answer.json()
