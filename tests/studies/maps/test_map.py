import io
import json
from itertools import product

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from figure_checks import heading
from map_blocks import map_block
from matplotlib.contour import ContourSet

from missions.files.overrides import with_values
from missions.library import load_mission
from missions.mission import Scenarios
from sizing.day.light import SolarModel, solar_day
from sizing.day.metrics import Status
from sizing.library import load_aircraft
from sizing.performance import performance
from studies.maps import study
from studies.maps.plots import plot_map
from studies.maps.results import MapResult
from studies.output.gridded import to_netcdf_bytes
from studies.output.season_scale import LEVELS_H

AS2 = load_aircraft("atlantiksolar-as2")
JULY = load_mission("rafz-july")
LATITUDES = np.array([-75.0, -40.0, 0.0, 47.6, 89.0])
DAYS = np.array([1, 80, 172, 266, 355])


@pytest.fixture(scope="module")
def data():
    return study.feasibility_map(AS2, JULY, latitudes=LATITUDES, days=DAYS, endurance=True)


def test_map_does_not_depend_on_the_size_of_its_blocks(monkeypatch):
    latitudes, days = np.linspace(-66.0, 66.0, 5), np.arange(1, 366, 30)
    whole = map_block(AS2, JULY, latitudes, days, SolarModel(), True)
    monkeypatch.setattr("sizing.day.cycle.CELLS_AT_ONCE", 7)
    monkeypatch.setattr("sizing.day.flight._AT_ONCE", 100)
    monkeypatch.setattr("solar.horizontal_models._POINTS_AT_ONCE", 333)
    again = map_block(AS2, JULY, latitudes, days, SolarModel(), True)
    for name, values in whole.items():
        np.testing.assert_array_equal(again[name], values, name)


@pytest.mark.parametrize(
    ("plane", "thermal", "model"),
    [
        ("atlantiksolar-as2", 0.0, "CAM"),
        ("atlantiksolar-as2", 0.6, "CDM"),
        ("atlantiksolar-design", 0.0, "CDM"),
        ("atlantiksolar-as2", 0.0, "FM"),
    ],
)
def test_cells_are_those_of_single_analyses(plane, thermal, model):
    aircraft, solar = load_aircraft(plane), SolarModel(model)
    rough = with_values(JULY, {"turbulence.thermal": thermal})
    result = map_block(aircraft, rough, LATITUDES, DAYS, solar)
    for (i, latitude), (j, day) in product(enumerate(LATITUDES), enumerate(DAYS)):
        scenario = Scenarios(np.array([latitude]), np.array([day]))
        sun = solar_day(aircraft, rough, solar, scenarios=scenario)
        cycle = performance(aircraft, rough, solar, day=sun).cycle
        assert int(result["status"][i, j]) == int(cycle.status[0])
        # Rounding of the flow's factor, which a map leaves out.
        assert result["excess_time"][i, j] == pytest.approx(cycle.excess_time_h[0], rel=1e-12)
        assert result["charge_margin"][i, j] == cycle.charge_margin_h[0]
        lowest = cycle.minimum_state_of_charge[0]
        assert result["minimum_state_of_charge"][i, j] == pytest.approx(lowest, rel=1e-7)
        assert result["load_energy"][i, j] == cycle.energy_budget.load_wh[0]


def test_file_carries_units_flags_and_configuration(data):
    again = xr.open_dataset(io.BytesIO(to_netcdf_bytes(data)), engine="h5netcdf")
    assert again["excess_time"].attrs["units"] == "h"
    assert again["status"].attrs["flag_meanings"] == "failed limited perpetual always_lit never_lit"
    assert again.attrs["Conventions"].startswith("CF-")
    assert json.loads(again.attrs["aircraft"])["name"] == "atlantiksolar-as2"
    np.testing.assert_array_equal(again["status"], data["status"])
    np.testing.assert_array_equal(again["excess_time"], data["excess_time"])


def test_figures_of_maps_of_any_size(data):
    figure = plot_map(data)
    axes, bar = figure.axes
    assert axes.get_ylabel() == "latitude"
    assert [t.get_text() for t in axes.get_xticklabels()][:2] == ["Jan", "Feb"]
    assert "CAM, uncorrected" in heading(figure)
    assert "[h]" in bar.get_ylabel()
    # A few days have dates and round numbers.
    polar_day = study.feasibility_map(AS2, JULY, latitudes=[89.0, 90.0], days=[170, 172, 174])
    axes, bar = plot_map(polar_day).axes
    assert [label.get_text() for label in axes.get_xticklabels()][::4] == ["19 Jun", "23 Jun"]
    assert axes.get_ylim()[1] == 90.0  # there is no latitude beyond the pole
    assert bar.get_yticks().tolist() == list(LEVELS_H)
    axes = plot_map(study.feasibility_map(AS2, JULY, latitudes=[47.6], days=[196])).axes[0]
    (mesh,) = axes.collections
    assert np.ptp(mesh.get_coordinates(), axis=(0, 1)).min() > 0.0
    west, east = axes.get_xlim()
    assert west < 196 < east


def test_edge_of_perpetual_flight_is_drawn_between_cells(data):
    (line,) = [
        one
        for one in plot_map(data).axes[0].collections
        if isinstance(one, ContourSet) and not one.filled
    ]
    excess_h = data["excess_time"]
    for path in line.get_paths()[:1]:
        for day, latitude in path.vertices:
            around = excess_h.sel(
                latitude=[edge(data["latitude"].values, latitude, side) for side in (-1, 1)],
                day=[edge(data["day"].values, day, side) for side in (-1, 1)],
            )
            assert around.min() <= 0.0 <= around.max()


def edge(axis, value, side):
    """Last value of an axis below, or first one above."""
    beyond = axis[axis <= value + 1e-9] if side < 0 else axis[axis >= value - 1e-9]
    return float(beyond[-1] if side < 0 else beyond[0])


def test_a_map_as_a_table_has_a_row_for_each_cell(run, tmp_path):
    call = ["map", "atlantiksolar-as2", "--latitudes", "-80:80:40", "--days", "1:365:91"]
    for name in ("map.csv", "map.nc"):
        run(*call, "--out", str(tmp_path / name)).good()
    table = pd.read_csv(tmp_path / "map.csv", comment="#")
    configuration = json.loads((tmp_path / "map.csv").read_text().splitlines()[0].removeprefix("#"))
    assert json.loads(configuration["aircraft"])["name"] == "atlantiksolar-as2"
    with xr.open_dataset(tmp_path / "map.nc", engine="h5netcdf") as data:
        cells = table.set_index(["latitude", "day"])
        assert len(cells) == data["status"].size
        for (latitude, day), row in cells.iterrows():
            cell = data.sel(latitude=latitude, day=day)
            assert row["excess_time"] == pytest.approx(float(cell["excess_time"]), nan_ok=True)
        assert set(table["status"]) <= set(data["status"].attrs["flag_meanings"].split())


def test_resized_map_tells_an_excess_time_without_end(run, tmp_path):
    # At the pole in midsummer the sun stands at 23 degrees all day.
    picture = tmp_path / "map.png"
    where = ["--latitudes", "90:90:1", "--days", "172:177:5"]
    command = ["map", "atlantiksolar-design", *where, "--resize", "max_excess_time"]
    record = run(*command, "--json", "--plot", str(picture)).good().json()
    assert record["infeasible_days"] == [0]
    assert record["least_excess_time_h"] == [None]
    assert picture.read_bytes().startswith(b"\x89PNG")
    table = run(*command).out
    assert "unlimited" in table
    assert "inf " not in table


def test_endurance_of_the_days_without_perpetual_flight_is_told():
    result = study.feasibility_map(
        AS2, JULY, latitudes=[0.0, 47.6], days=[1, 100, 172], endurance=True
    )
    record = MapResult(result).to_dict()
    hours = result["endurance"].to_numpy()
    finite = hours[1][np.isfinite(hours[1])]
    assert record["least_endurance_h"][1] == pytest.approx(finite.min())
    assert record["largest_endurance_h"][1] == pytest.approx(finite.max())
    assert record["perpetual_days"][1] == 3 - len(finite)
    assert "endurance" in str(MapResult(result))
    plain = study.feasibility_map(AS2, JULY, latitudes=[47.6], days=[1])
    assert "least_endurance_h" not in MapResult(plain).to_dict()


def test_tropics_fly_all_year_and_polar_winter_never(data):
    assert int(study.season_length(data).sel(latitude=0.0)) == len(DAYS)
    assert int(data["status"].sel(latitude=89.0, day=355)) == Status.never_lit
    assert int(data["status"].sel(latitude=89.0, day=172)) == Status.always_lit
    assert np.isinf(data["excess_time"].sel(latitude=89.0, day=172))
