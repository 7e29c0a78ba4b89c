"""Weather of grids: ERA5 and NASA POWER as NetCDF and CSV, at the point nearest to a mission."""

import numpy as np
import pytest
import xarray as xr
from builders import mission
from weather_files import SITE, clear_record, minutes_behind_the_sun, write_power

from missions.files.errors import InputError
from missions.weather.files import load_weather
from missions.weather.light import light_at_altitude
from missions.weather.record import Site

HOUR_S = 3600.0
NORTH, EAST = np.array([47.05, 46.8, 46.55]), np.array([6.65, 6.9, 7.15])
HERE = mission(latitude_deg=46.85, longitude_deg=6.95, altitude_m=900.0)


def horizontal(record):
    """Direct light on a level surface [W/m2]."""
    return record.ghi - record.dhi


def era5(record, **changes):
    """Dataset as the Climate Data Store returns it; the light of the hour before each time."""
    time = (record.start_s + HOUR_S).astype("datetime64[s]").astype("datetime64[ns]")
    coords = {"valid_time": time, "latitude": NORTH, "longitude": EAST % 360.0}

    def spread(values, units):
        """The same values in the middle of the grid, others around it."""
        grid = np.zeros((len(time), 3, 3)) + np.asarray(values).reshape(-1, 1, 1)
        around = grid * 0.5
        around[:, 1, 1] = grid[:, 1, 1]
        return xr.DataArray(around, coords, attrs={"units": units})

    data = {
        "ssrd": spread(record.ghi * HOUR_S, "J m**-2"),
        "fdir": spread(horizontal(record) * HOUR_S, "J m**-2"),
        "t2m": spread(288.15, "K"),
        "u10": spread(3.0, "m s**-1"),
        "v10": spread(-4.0, "m s**-1"),
        "z": spread(SITE.altitude_m * 9.80665, "m**2 s**-2"),
    }
    return xr.Dataset(data | changes)


def same(found, record):
    assert found.start_s == pytest.approx(record.start_s)
    for name in ("ghi", "dhi"):
        assert getattr(found, name) == pytest.approx(getattr(record, name), abs=0.1)
    # Direct light is that on a level surface over the mean cosine: 2 % off at a sun of 15 degrees.
    high = record.ghi > 200.0
    assert found.dni[high] == pytest.approx(record.dni[high], rel=3e-2)
    assert found.temperature_c == pytest.approx(15.0)
    assert found.wind_m_per_s == pytest.approx(5.0)


def test_era5_is_read_at_the_grid_point_nearest_to_the_mission(tmp_path):
    record = clear_record(3)
    era5(record).to_netcdf(tmp_path / "era5.nc")
    found = load_weather(tmp_path / "era5.nc", HERE)
    same(found, record)
    assert found.site.latitude_deg == 46.8
    assert found.site.longitude_deg == pytest.approx(6.9)
    assert found.site.altitude_m == pytest.approx(SITE.altitude_m)
    assert found.repairs == ()


def test_swapped_axes_and_mean_rates_are_the_same(tmp_path):
    record = clear_record(3)
    data = era5(record)
    rates = data.rename(ssrd="avg_sdswrf", fdir="avg_sdirswrf")
    for name in ("avg_sdswrf", "avg_sdirswrf"):
        rates[name] = (rates[name] / HOUR_S).assign_attrs(units="W m**-2")
    for name in ("t2m", "u10", "v10", "z"):
        rates[name].attrs["units"] = data[name].attrs["units"]
    rates.transpose("longitude", "valid_time", "latitude").to_netcdf(tmp_path / "rates.nc")
    same(load_weather(tmp_path / "rates.nc", HERE), record)


def test_without_the_ground_its_height_is_that_of_the_pressure_or_sea_level(tmp_path):
    data = era5(clear_record(3)).drop_vars("z")
    data.to_netcdf(tmp_path / "flat.nc")
    found = load_weather(tmp_path / "flat.nc", HERE)
    assert found.site.altitude_m == 0.0
    assert "sea level" in found.repairs[0]
    # 955.6 hPa at 491 m in the standard atmosphere (ISO 2533).
    pressure = (data["t2m"] * 0.0 + 95_560.0).assign_attrs(units="Pa")
    data.assign(sp=pressure).to_netcdf(tmp_path / "sp.nc")
    assert load_weather(tmp_path / "sp.nc", HERE).site.altitude_m == pytest.approx(491.0, abs=3.0)


def test_air_at_flight_altitude_comes_from_the_levels(tmp_path):
    data = era5(clear_record(3)).drop_vars(["t2m", "u10", "v10"])
    heights = xr.DataArray([0.0, 1000.0, 3000.0], dims="altitude", attrs={"units": "m"})
    level = data["ssrd"].expand_dims(altitude=heights) * 0.0
    level["altitude"].attrs["units"] = "m"
    warm = (level + 290.0 - 0.01 * level["altitude"]).assign_attrs(units="K")
    wind = (level + 0.01 * level["altitude"]).assign_attrs(units="m s**-1")
    still = (level * 0.0).assign_attrs(units="m s**-1")
    data.assign(t=warm, u=wind, v=still).to_netcdf(tmp_path / "levels.nc")
    found = load_weather(tmp_path / "levels.nc", HERE)
    assert found.air_altitude_m == 900.0
    light = light_at_altitude(found, 900.0)
    assert light.temperature_c == pytest.approx(290.0 - 9.0 - 273.15)
    assert light.wind_m_per_s == pytest.approx(9.0)
    with pytest.raises(InputError, match="has t at altitude_m 0 to 3000, not 4000"):
        load_weather(tmp_path / "levels.nc", HERE.at_altitude(4000.0))


def test_nasa_power_begins_its_hours_at_their_number(tmp_path):
    record = clear_record(3)
    path = write_power(tmp_path / "power.csv", record)
    head, rows = path.read_text().splitlines()[:8], path.read_text().splitlines()[8:]
    found = load_weather(path)
    same(found, record)
    assert found.layout == "NASA POWER"
    assert found.site.altitude_m == 491.0
    in_mj = [
        ",".join([*r[:4], *(f"{float(v) * 0.0036:.7f}" for v in r[4:7]), *r[7:]])
        for r in (row.split(",") for row in rows)
    ]
    units = [f"{name}  CERES SYN1deg (MJ/hr)" for name in head[-1].split(",")[4:7]]
    path.write_text("\n".join([*head[:-2], *units, *head[-2:], *in_mj]) + "\n")
    same(load_weather(path), record)
    path.write_text("\n".join([*head, *in_mj]) + "\n")
    with pytest.raises(InputError, match="of the light of a clear sky: is the unit wrong"):
        load_weather(path)
    path.write_text("\n".join([*head, *rows]).replace("= 491.0", "= -999") + "\n")
    assert load_weather(path).site.altitude_m == 0.0
    path.write_text("\n".join([*head, *rows]).replace("= 491.0", "= 49100") + "\n")
    with pytest.raises(InputError, match="altitude of its site must be from -500 to 9000"):
        load_weather(path)
    rows[30] = ",".join([*rows[30].split(",")[:4], *["-999"] * 5])
    path.write_text("\n".join([*head, *rows]) + "\n")
    assert load_weather(path).repairs == (
        "1 rows filled between their neighbours",
        "temperature missing in 1 of 72 rows: filled between their neighbours",
        "wind speed missing in 1 of 72 rows: filled between their neighbours",
    )


# Zones by NASA's documentation: whole hours, the sun at noon in the middle of a belt of 15 degrees.
@pytest.mark.parametrize(
    ("longitude_deg", "ahead_h"), [(6.95, 0), (7.6, 1), (-7.6, -1), (-104.9, -7), (172.6, 12)]
)
def test_local_solar_time_of_nasa_power_is_that_of_its_belt(tmp_path, longitude_deg, ahead_h):
    record = clear_record(3, site=Site("", 46.8, longitude_deg, 491.0, 0.0))
    found = load_weather(write_power(tmp_path / "a.csv", record, "LST", ahead_h))
    assert found.start_s == pytest.approx(record.start_s)
    assert found.repairs == (
        f"local solar time taken as UTC{ahead_h:+d} h, that of its belt of 15 degrees",
    )
    assert abs(minutes_behind_the_sun(found)) < 1.0  # light is written to 0.001 W/m2


def test_era5_time_series_end_their_hours_at_their_time(tmp_path):
    record = clear_record(3)
    stamps = (record.start_s + HOUR_S).astype("datetime64[s]")
    values = zip(stamps, record.ghi * HOUR_S, horizontal(record) * HOUR_S, strict=True)
    rows = [f"{t},3.0,-4.0,288.15,95560,{g:.1f},{b:.1f},46.8,6.9" for t, g, b in values]
    head = "valid_time,u10,v10,t2m,sp,ssrd,fdir,latitude,longitude"
    path = tmp_path / "series.csv"
    path.write_text("\n".join([head, *rows]) + "\n")
    found = load_weather(path)
    same(found, record)
    assert found.site.altitude_m == pytest.approx(491.0, abs=3.0)
    text = path.read_text()
    path.write_text("\n".join([f"{head},avg_sdswrf", *(f"{row},1.0" for row in rows)]))
    same(load_weather(path), record)  # the first of two names of global light
    for old, new, message in (
        (",46.8,", ",nan,", "latitude of its site must be from -90 to 90"),
        (",95560,", ",0,", "has a pressure at the ground of 0 Pa"),
        ("ssrd,fdir", "fdir,ssrd", "has more direct than global light"),
    ):
        path.write_text(text.replace(old, new))
        with pytest.raises(InputError, match=message):
            load_weather(path)


def test_every_third_hour_of_era5_is_the_light_of_one_hour(tmp_path):
    record = clear_record(8)
    era5(record).isel(valid_time=slice(2, None, 3)).to_netcdf(tmp_path / "a.nc")
    found = load_weather(tmp_path / "a.nc", HERE)
    assert found.interval_s == HOUR_S
    note = "rows 3 h apart have the light of 1 h each: shares of the clear sky between"
    assert note in found.repairs
    assert np.sum(found.ghi) == pytest.approx(np.sum(record.ghi[2:]), rel=0.01)  # a clear sky
    assert abs(minutes_behind_the_sun(found)) < 2.0  # hours of the low sun are filled
    assert found.temperature_c == pytest.approx(15.0)
    era5(record).isel(valid_time=slice(5, None, 6)).to_netcdf(tmp_path / "b.nc")
    with pytest.raises(InputError, match="has a row every 360 minutes; allowed: from 1 minute"):
        load_weather(tmp_path / "b.nc", HERE)


@pytest.mark.parametrize("step", [1, 3])
@pytest.mark.parametrize("east_deg", [6.9, 178.0])
def test_light_summed_up_since_midnight_is_taken_apart(tmp_path, step, east_deg):
    """ERA5-Land: the row of 00 UTC has the whole of the day before."""
    site = Site("", 46.8, east_deg, 491.0, 0.0)
    record = clear_record(6, site=site)
    data = era5(record)
    for name in ("ssrd", "fdir"):
        days = data[name].to_numpy().reshape(6, 24, 3, 3)
        data[name].values = np.cumsum(days, axis=1).reshape(-1, 3, 3)
    data = data.assign_coords(longitude=EAST - 6.9 + east_deg)
    # Downloads begin with the row of 00 UTC, of which the hours are not known.
    data.isel(valid_time=slice(23, None)).sel(
        valid_time=data["valid_time"].dt.hour[23:] % step == 0
    ).to_netcdf(tmp_path / "land.nc")
    where = mission(latitude_deg=46.85, longitude_deg=east_deg, altitude_m=900.0)
    found = load_weather(tmp_path / "land.nc", where)
    assert "light summed up from 00 UTC, as of ERA5-Land, taken apart by the row" in found.repairs
    assert found.interval_s == step * HOUR_S
    means = record.ghi[24:].reshape(-1, step).mean(axis=1)
    assert found.ghi[1:] == pytest.approx(means, abs=0.1)
    assert abs(minutes_behind_the_sun(found)) < 2.0  # the direct light over a mean cosine


def test_final_and_preliminary_months_of_era5_are_one_record(tmp_path):
    record = clear_record(4)
    data, first = era5(record), np.arange(96) < 48
    axis = xr.DataArray(first, dims="valid_time")
    mixed = xr.concat([data.where(axis), data.where(~axis)], xr.IndexVariable("expver", [1, 5]))
    for name in data.data_vars:
        mixed[name].attrs = data[name].attrs
    mixed.isel(expver=[1, 0]).to_netcdf(tmp_path / "a.nc")
    same(load_weather(tmp_path / "a.nc", HERE), record)
    table = mixed.isel(latitude=1, longitude=1).to_dataframe().reset_index()
    table.drop(columns="z").to_csv(tmp_path / "a.csv", index=False)
    found = load_weather(tmp_path / "a.csv", HERE)
    assert found.start_s == pytest.approx(record.start_s)
    assert found.ghi == pytest.approx(record.ghi, abs=0.1)


def test_a_grid_without_the_place_or_whose_parts_do_not_fit_each_other_is_refused(tmp_path):
    data = era5(clear_record(3))
    far = mission(latitude_deg=48.0, longitude_deg=6.9)
    west = mission(latitude_deg=46.8, longitude_deg=-40.0)
    level = ("pressure_level", [900.0, 800.0], {"units": "hPa"})
    column = xr.DataArray([280.0, 275.0], {"pressure_level": level}, attrs={"units": "K"})
    direct = data.drop_vars("ssrd").assign(dni=data["fdir"].assign_attrs(units="W m**-2"))
    odd = data.assign(ssrd=data["ssrd"].assign_attrs(units="furlongs"))
    swapped = data.assign_coords(latitude=[170.0, 175.0, 180.0])
    for broken, where, message in (
        (data, None, "has 3 values of latitude_deg: give latitude_deg on the mission"),
        (data, mission(latitude_deg=46.8, longitude_deg=None), "has 3 values of longitude_deg"),
        (data, far, "has latitudes 46.55 to 47.05, not 48"),
        (data, west, "has longitudes 6.65 to 7.15, not -40"),
        (swapped, HERE, "latitudes beyond 90 degrees: its axes may be swapped"),
        (data[["t2m"]], HERE, "has no light"),
        (odd, HERE, "has ghi in furlongs"),
        (direct, HERE, "has no light: ghi, or dni and dhi, are needed"),
        (data.drop_vars("t2m").assign(t=column), HERE, "has t on levels, but not over time"),
        (data.isel(latitude=slice(0)), HERE, "has a latitude without values"),
        (data.assign_coords(latitude=[46.5, np.nan, 47.0]), HERE, "has a latitude without values"),
    ):
        broken.to_netcdf(tmp_path / "a.nc")
        with pytest.raises(InputError, match=message):
            load_weather(tmp_path / "a.nc", where)
    (tmp_path / "a.nc").write_bytes(b"\x89HDF\r\n\x1a\n" + b"nonsense")
    with pytest.raises(InputError, match="cannot be read as NetCDF"):
        load_weather(tmp_path / "a.nc", HERE)
