"""NetCDF files with components of the wind, in the layouts of ERA5 and of the CF conventions."""

import h5py
import numpy as np
import pytest
import xarray as xr

from missions.air import standard_air
from missions.files.errors import InputError
from missions.mission import Mission
from missions.weather.files import load_weather
from missions.winds.netcdf import nearest, wind_table_from_netcdf

TIMES = np.arange("2020-01-01", "2021-01-01", dtype="datetime64[D]")
LATITUDES, LONGITUDES, LEVELS = [50.0, 45.0, 40.0], [0.0, 5.0, 355.0], [30.0, 50.0, 100.0]


def era5(times=TIMES, seed=1):
    """Winds as the Climate Data Store lays them out since 2024; speeds known by construction."""
    rng = np.random.default_rng(seed)
    shape = (len(times), len(LEVELS), len(LATITUDES), len(LONGITUDES))
    axes = ("valid_time", "pressure_level", "latitude", "longitude")
    u, v = rng.normal(0.0, 10.0, (2, *shape))
    return xr.Dataset(
        {"u": (axes, u), "v": (axes, v)},
        {
            "valid_time": times,
            "pressure_level": ("pressure_level", LEVELS, {"units": "hPa"}),
            "latitude": LATITUDES,
            "longitude": LONGITUDES,
        },
    )


def written(data, folder, name="era5.nc"):
    path = folder / name
    data.to_netcdf(path, engine="h5netcdf")
    return str(path)


def altitude_m(hpa):
    heights = np.arange(0.0, 32000.0, 1.0)
    return float(np.interp(-hpa, -standard_air(heights).pressure_pa / 100.0, heights))


def test_percentiles_are_those_of_the_instants_of_a_month(tmp_path):
    data = era5()
    winds = wind_table_from_netcdf(written(data, tmp_path), 5.0)
    july = data.sel(valid_time="2020-07", latitude=45.0, longitude=5.0, pressure_level=50.0)
    speeds = np.sort(np.hypot(july["u"], july["v"]).to_numpy())
    found = winds.at(45.0, altitude_m(50.0), 7, 90.0)
    # 31 values: nine tenths of the way along them lies on the 28th, 0.9 * 30 = 27 from the first.
    assert found == pytest.approx(speeds[27], rel=1e-3)
    assert winds.latitude_deg.tolist() == [40.0, 45.0, 50.0]
    assert winds.months == tuple(range(1, 13))
    # 29 days of February make no 99th percentile, nor a 97th.
    assert winds.percentiles[-1] == 95.0
    short = wind_table_from_netcdf(written(era5(TIMES[:51]), tmp_path), 5.0, also=95.0)
    assert short.percentiles[-1] == 95.0


@pytest.mark.parametrize("longitude", [-4.0, 356.0 - 360.0, -7.4])
def test_the_nearest_longitude_is_taken_and_told(tmp_path, longitude):
    data = era5()
    winds = wind_table_from_netcdf(written(data, tmp_path), longitude)
    assert f"longitude -5, nearest to {longitude:g}" in winds.source
    alone = wind_table_from_netcdf(written(data.sel(longitude=[355.0]), tmp_path, "one.nc"))
    assert np.array_equal(winds.wind_m_per_s, alone.wind_m_per_s)


def test_order_and_names_of_axes_play_no_part(tmp_path):
    data = era5()
    single = wind_table_from_netcdf(written(data, tmp_path), 5.0)
    other = (
        data.rename(valid_time="time", pressure_level="level", latitude="lat", longitude="lon")
        .transpose("lon", "lat", "level", "time")
        .sortby("lat")
        .assign_coords(lon=[0.0, 5.0, -5.0])
        .rename(u="eastward", v="northward")
        .expand_dims(number=[0])
    )
    other["eastward"].attrs["standard_name"] = "eastward_wind"
    other["northward"].attrs["standard_name"] = "northward_wind"
    other["level"] = ("level", other["level"].to_numpy() * 100.0, {"units": "Pa"})
    two = wind_table_from_netcdf(written(other, tmp_path, "other.nc"), 5.0)
    assert np.allclose(single.wind_m_per_s, two.wind_m_per_s, rtol=1e-12)
    assert np.allclose(single.altitude_m, two.altitude_m)


def test_heights_are_heights(tmp_path):
    data = era5().rename(pressure_level="height")
    data["height"] = ("height", [24.0, 20.0, 16.0], {"units": "km"})
    winds = wind_table_from_netcdf(written(data, tmp_path), 5.0)
    assert winds.altitude_m.tolist() == [16000.0, 20000.0, 24000.0]


def with_u(value):
    """Make a change that puts one value among the eastward winds."""
    return lambda data: data.assign(u=data["u"].where(data["u"] != data["u"][3, 1, 1, 1], value))


@pytest.mark.parametrize("names", ["uv", "v"])
def test_components_in_knots_are_winds_in_m_per_s(tmp_path, names):
    data = era5()
    plain = wind_table_from_netcdf(written(data, tmp_path))
    for name in names:
        data[name] = (data[name] * 3600.0 / 1852.0).assign_attrs(units="knots")
    knots = wind_table_from_netcdf(written(data, tmp_path, "knots.nc"))
    assert knots.wind_m_per_s == pytest.approx(plain.wind_m_per_s)


def test_the_level_without_pressure_is_left_out(tmp_path):
    levels = ("pressure_level", [0.0, *LEVELS[1:]], {"units": "hPa"})
    winds = wind_table_from_netcdf(written(era5().assign_coords(pressure_level=levels), tmp_path))
    assert len(winds.altitude_m) == len(LEVELS) - 1


@pytest.mark.parametrize(
    ("axis", "values", "degrees", "index"),
    [
        ("latitude", [40.0, 45.0, 46.0], 42.4, 0),
        ("latitude", [46.0, 45.0, 40.0], 50.0, 0),
        ("longitude", [350.0, 0.0, 5.0], -6.0, 0),
        ("longitude", [-5.0, 0.0, 10.0], 19.0, 2),
    ],
)
def test_places_between_uneven_values_or_a_spacing_beyond_are_near(axis, values, degrees, index):
    assert nearest(axis, np.array(values), degrees) == index
    with pytest.raises(InputError, match=f"has {axis}s .*, not 80 of the mission"):
        nearest(axis, np.array(values), 80.0)


SWAPPED = {"latitude": "longitude", "longitude": "latitude"}


@pytest.mark.parametrize(
    ("change", "longitude", "message"),
    [
        (lambda data: data.rename(SWAPPED), None, "has latitudes beyond 90 .* axes may be swapped"),
        (lambda data: data.assign_coords(pressure_level=LEVELS), 5.0, "has levels in no unit"),
        (with_u(np.nan), 5.0, "has gaps in the wind"),
        (lambda data: data.drop_vars("v"), 5.0, "has no northward_wind"),
        (lambda data: data.drop_vars("latitude"), 5.0, "has no latitude for u"),
        (lambda data: data.expand_dims(member=[0, 1]), 5.0, "has the axis member for u, beside"),
        # One value of twenty lies above the 95th percentile; of nineteen none does.
        (lambda data: data.isel(valid_time=slice(0, 50)), 5.0, "19 values in a month, too few fo"),
        (lambda data: data.assign(u=data["u"].assign_attrs(units="K")), 5.0, "u in K .*, knots"),
        (with_u(-999.0), 5.0, "has a wind of 999 m/s: a code of missing values or its unit"),
        (lambda data: data.isel(longitude=[0]), 5.0, "has longitudes 0, not 5 of the mission"),
        (lambda data: data, 120.0, "has longitudes 0 to 355, not 120 of the mission"),
    ],
)
def test_what_cannot_be_read_is_refused_in_a_line(tmp_path, change, longitude, message):
    path = written(change(era5()), tmp_path)
    with pytest.raises(InputError, match=message) as refused:
        wind_table_from_netcdf(path, longitude, also=95.0)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("reader", [wind_table_from_netcdf, load_weather])
def test_axes_that_unpack_to_gigabytes_are_refused_before(reader, tmp_path):
    path = tmp_path / "big.nc"
    path.write_text("nothing")
    with pytest.raises(InputError, match=r"big\.nc: (cannot be read as NetCDF|is no weather file)"):
        reader(str(path))
    with h5py.File(path, "w") as file:  # nothing is written: some kilobytes
        file.create_dataset("time", (200_000_000,), "i4", chunks=(1_000_000,), compression="gzip")
    with pytest.raises(InputError, match=r"big\.nc: .*time has 200,000,000 values, at most 10,0"):
        reader(str(path))


@pytest.mark.parametrize("engine", ["h5netcdf", "scipy"])
@pytest.mark.parametrize("at", [4, 200, 1500, 0.3, 0.7])
def test_a_damaged_file_is_named(engine, at, tmp_path, capfd):
    path = tmp_path / "damaged.nc"
    era5(TIMES[:40]).to_netcdf(path, engine=engine)
    content = bytearray(path.read_bytes())
    place = int(at if at > 1 else at * len(content))
    content[place : place + 3000] = b"\xff" * 3000
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"^\S*damaged\.nc:? [^\n]*$"):
        wind_table_from_netcdf(str(path))
    assert capfd.readouterr().err == ""


def test_a_mission_takes_the_winds_of_its_longitude(tmp_path):
    path = written(era5(), tmp_path)
    data = {
        "name": "own winds",
        "latitude_deg": 47.5,
        "longitude_deg": 5.2,
        "dates": {"on": "07-15"},
        "altitude_m": 20000.0,
        "wind": {"percentile": 93.0, "file": path},
    }
    mission = Mission.model_validate(data)
    table = wind_table_from_netcdf(path, 5.2, also=93.0)
    assert mission.strongest_wind_m_per_s == float(table.at(47.5, 20000.0, 7, 93.0))
    assert 93.0 in table.percentiles


def test_final_and_preliminary_months_are_one(tmp_path):
    data = era5()
    final = xr.DataArray(np.datetime64("2020-09-15") > TIMES, dims="valid_time")
    version = xr.IndexVariable("expver", [1, 5])
    mixed = xr.concat([data.where(final), data.where(~final)], version)
    once = wind_table_from_netcdf(written(data, tmp_path, "a.nc"), 5.0)
    found = wind_table_from_netcdf(written(mixed, tmp_path, "b.nc"), 5.0)
    assert np.array_equal(found.wind_m_per_s, once.wind_m_per_s)
