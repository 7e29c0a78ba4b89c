"""Small weather files of every layout, written as their makers write them."""

import json
from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np

from missions.weather.light import light_at_altitude
from missions.weather.record import Site, Weather, day_of_year
from solar.clearsky import clear_sky, global_horizontal
from solar.sun import cos_zenith, declination, hour_angle, solar_time_h

SITE = Site("Somewhere", 46.8, 6.9, 491.0, 1.0)


def clear_light(start_s, interval_s, site=SITE, share=1.0, altitude_m=None):
    """Means of the clear sky over intervals, from steps of a minute."""
    steps = max(1, round(interval_s / 60.0))
    fine = np.asarray(start_s)[:, None] + (np.arange(steps) + 0.5) * interval_s / steps
    day = day_of_year(fine.reshape(-1))
    hour = solar_time_h((day % 1.0) * 24.0, day, site.longitude_deg)
    cosine = cos_zenith(site.latitude_deg, declination(day), hour_angle(hour))
    altitude = site.altitude_m if altitude_m is None else altitude_m
    sky = clear_sky(day, site.latitude_deg, cosine, altitude)
    ghi = global_horizontal(sky, cosine)
    return tuple(share * part.reshape(-1, steps).mean(axis=1) for part in (ghi, *sky))


def clear_record(days=4, first="2001-06-20", interval_s=3600.0, share=1.0, **changes):
    """Record of a clear (or evenly dimmed) sky."""
    site = changes.pop("site", SITE)
    begin = float((np.datetime64(first, "s") - np.datetime64("1970-01-01T00:00:00")).astype(int))
    begin -= site.utc_offset_h * 3600.0
    start_s = begin + interval_s * np.arange(round(days * 86400.0 / interval_s))
    ghi, dni, dhi = clear_light(start_s, interval_s, site, share)
    made = Weather("made", "CSV", site, start_s, interval_s, ghi, dni, dhi, None, None, False)
    return replace(made, **changes)


def rows(record, ahead_s=0.0):
    """Rows of a record: the time, some seconds ahead of universal time; ghi, dni, dhi."""
    times = [datetime(1970, 1, 1) + timedelta(seconds=float(t) + ahead_s) for t in record.start_s]
    return zip(times, record.ghi, record.dni, record.dhi, strict=True)


def written(path, lines, encoding="utf-8"):
    """Write a file of lines, and return its path."""
    path.write_text("\n".join(lines) + "\n", encoding)
    return path


def write_plain(path, record, header=None, changed=lambda table: table):
    """Plain CSV of a record."""
    site = record.site
    lines = header or [
        f"# name: {site.name}",
        f"# latitude_deg: {site.latitude_deg}",
        f"# longitude_deg: {site.longitude_deg}",
        f"# altitude_m: {site.altitude_m}",
        "time_utc,ghi,dni,dhi",
    ]
    table = [f"{t.isoformat()}Z,{g:.3f},{b:.3f},{d:.3f}" for t, g, b, d in rows(record)]
    return written(path, [*lines, *changed(table)])


def write_epw(path, record, name="Zürich", years=None):
    """EPW in Latin-1, local standard time, hours that end at 1 to 24, or parts of them."""
    site, part_min = record.site, record.interval_s / 60.0
    lines = [
        f"LOCATION,{name},-,CHE,IWEC Data,066700,{site.latitude_deg},{site.longitude_deg},"
        f"{site.utc_offset_h},{site.altitude_m}",
        *["DESIGN CONDITIONS,0", "TYPICAL/EXTREME PERIODS,0", "GROUND TEMPERATURES,0"],
        *["HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0", "COMMENTS 1,-", "COMMENTS 2,-"],
        f"DATA PERIODS,1,{60.0 / part_min:g},Data,Sunday, 1/ 1,12/31",
    ]
    for local, g, b, d in rows(record, site.utc_offset_h * 3600.0):
        year = (years or {}).get(local.month, local.year)
        hour = f"{year},{local.month},{local.day},{local.hour + 1},{round(local.minute + part_min)}"
        air = "?,15.0,5.0,50,95000,0,0,300"
        rest = "0,0,0,0,180,3.0,5,5,20,9999,0,0,10,0.1,0,88,0.2,0,1"
        lines.append(f"{hour},{air},{g:.2f},{b:.2f},{d:.2f},{rest}")
    return written(path, lines, "latin-1")


def write_pvgis_tmy(path, record, years=None, offset_h=0.1761):
    """Typical year of PVGIS as CSV; its rows are instants, told for the whole hour."""
    site, years = record.site, years or {}
    lines = [
        f"Latitude (decimal degrees): {site.latitude_deg:.3f}",
        f"Longitude (decimal degrees): {site.longitude_deg:.3f}",
        f"Elevation (m): {site.altitude_m}",
        f"Irradiance Time Offset (h): {offset_h}",
        "month,year",
        *(f"{month},{years.get(month, 2018)}" for month in range(1, 13)),
        "time(UTC),T2m,RH,G(h),Gb(n),Gd(h),IR(h),WS10m,WD10m,SP",
    ]
    for utc, g, b, d in rows(record):
        stamp = f"{years.get(utc.month, utc.year)}{utc:%m%d:%H%M}"
        lines.append(f"{stamp},15.0,50.0,{g:.2f},{b:.2f},{d:.2f},300.0,3.0,180.0,95000.0")
    lines += ["", "T2m: 2-m air temperature (degree Celsius)", "RH: relative humidity (%)"]
    return written(path, lines)


def write_pvgis_tmy_json(path, record, offset_h=0.1761):
    """Typical year of PVGIS as JSON; its offset stands with the place."""
    site = record.site
    hours = [
        {
            **{"time(UTC)": f"{utc:%Y%m%d:%H%M}", "T2m": 15.0, "RH": 50.0, "G(h)": round(g, 2)},
            **{"Gb(n)": round(b, 2), "Gd(h)": round(d, 2), "IR(h)": 300.0},
            **{"WS10m": 3.0, "WD10m": 180.0, "SP": 95000.0},
        }
        for utc, g, b, d in rows(record)
    ]
    place = {"latitude": site.latitude_deg, "longitude": site.longitude_deg}
    place |= {"elevation": site.altitude_m, "irradiance_time_offset": offset_h}
    content = {
        "inputs": {"location": place, "meteo_data": {"radiation_db": "PVGIS-SARAH3"}},
        "outputs": {"months_selected": [{"month": 1, "year": 2018}], "tmy_hourly": hours},
        "meta": {"inputs": {}, "outputs": {}},
    }
    return written(path, [json.dumps(content)])


def write_pvgis_tmy_epw(path, record, zone_h=1.0, offset_h=0.1761):
    """Typical year of PVGIS as EPW: hours of universal time under the zone of the country.

    Before version 5.3 without an offset.
    """
    lines = write_epw(path, record, name="unknown").read_text("latin-1").splitlines()
    fields = lines[0].split(",")
    fields[4], fields[8] = "ECMWF/ERA", f"{zone_h:g}"
    lines[0] = ",".join(fields)
    if offset_h is not None:
        lines[6] = f"COMMENTS 2,Irradiance Time Offset (h):{offset_h - 1.0:g}"
    return written(path, lines, "latin-1")


def write_pvgis_hourly(path, record):
    """Hourly series of PVGIS on the horizontal, with components."""
    site, middle_s = record.site, record.start_s + 1800.0
    lines = [
        f"Latitude (decimal degrees):\t{site.latitude_deg:.3f}",
        f"Longitude (decimal degrees):\t{site.longitude_deg:.3f}",
        f"Elevation (m):\t{site.altitude_m:.0f}",
        "Radiation database:\tPVGIS-SARAH2",
        *["", "", "Slope: 0 deg. ", "Azimuth: 0 deg. "],
        "time,Gb(i),Gd(i),Gr(i),H_sun,T2m,WS10m,Int",
    ]
    day = day_of_year(middle_s)
    angle = hour_angle(solar_time_h((day % 1.0) * 24.0, day, site.longitude_deg))
    sine = cos_zenith(site.latitude_deg, declination(day), angle)
    heights = np.degrees(np.arcsin(np.maximum(sine, 0.0)))
    for (utc, g, _, d), height in zip(rows(record, 1800.0), heights, strict=True):
        lines.append(f"{utc:%Y%m%d:%H%M},{g - d:.2f},{d:.2f},0.0,{height:.2f},15.0,3.0,0.0")
    lines += ["", "Gb(i): Beam irradiance", "", "PVGIS (c) European Union, 2001-2021"]
    return written(path, lines)


def write_psm(path, record):
    """NSRDB PSM, rows at the middles of their intervals, trailing commas as of a spreadsheet."""
    site = record.site
    lines = [
        "Source,Location ID,City,State,Country,Latitude,Longitude,Time Zone,Elevation,"
        "Local Time Zone",
        f"NSRDB,1,-,-,-,{site.latitude_deg},{site.longitude_deg},{site.utc_offset_h:g},"
        f"{site.altitude_m:.0f},{site.utc_offset_h:g}",
        "Year,Month,Day,Hour,Minute,DHI,DNI,GHI,Temperature,Wind Speed,Cloud Type,Fill Flag,,",
    ]
    for at, g, b, d in rows(record, record.interval_s / 2.0 + site.utc_offset_h * 3600.0):
        stamp = f"{at.year},{at.month},{at.day},{at.hour},{at.minute}"
        lines.append(f"{stamp},{d:.2f},{b:.2f},{g:.2f},15.0,3.0,0,0,,")
    return written(path, lines)


def write_sam(path, record, columns="Year,Month,Day,Hour,GHI,DNI,DHI,Tdry,Wspd"):
    """Hours as the System Advisor Model heads them, by default without minutes."""
    site = record.site
    lines = [
        "Source,Location ID,City,State,Country,Latitude,Longitude,Time Zone,Elevation",
        f"Own,1,Here,-,-,{site.latitude_deg},{site.longitude_deg},{site.utc_offset_h:g},491",
        columns,
    ]
    minute = ",30" if "Minute" in columns else ""
    for at, g, b, d in rows(record, site.utc_offset_h * 3600.0):
        stamp = f"{at.year},{at.month},{at.day},{at.hour}{minute}"
        lines.append(f"{stamp},{g:.2f},{b:.2f},{d:.2f},15.0,3.0")
    return written(path, lines)


def write_power(path, record, standard="UTC", ahead_h=0):
    """NASA POWER's hours of a point, numbered some hours ahead of universal time."""
    site = record.site
    lines = [
        "-BEGIN HEADER-",
        "NASA/POWER Source Native Resolution Hourly Data ",
        f"Dates (month/day/year): 06/20/2001 through 06/22/2001 in {standard}",
        f"Location: latitude  {site.latitude_deg}   longitude {site.longitude_deg}",
        "elevation from MERRA-2: Average for 0.5 x 0.625 degree lat/lon region = 491.0 meters",
        "The value for missing source data that cannot be computed or is outside of the sources "
        "availability range: -999",
        "-END HEADER-",
        "YEAR,MO,DY,HR,ALLSKY_SFC_SW_DWN,ALLSKY_SFC_SW_DNI,ALLSKY_SFC_SW_DIFF,T2M,WS10M",
    ]
    for at, g, b, d in rows(record, ahead_h * 3600.0):
        lines.append(f"{at.year},{at.month},{at.day},{at.hour},{g:.3f},{b:.3f},{d:.3f},15.0,5.0")
    return written(path, lines)


def write_bsrn(path, record):
    """BSRN station-to-archive file of one month's minutes."""
    site = record.site
    begin = next(rows(record))[0]
    lines = [
        *["*U0001", f" 21 {begin.month:2d} {begin.year}  1", "*U0004", " -1 -1 -1", " 13  4"],
        f"Station, {site.name}, Country",
        f"{'+41 0':<20s} +41 0",
        f"{'0.0.0.0':<15s}   nobody",
        f"{site.latitude_deg + 90:8.3f}{site.longitude_deg + 180:8.3f}"
        f" {site.altitude_m:4.0f} 00000",
        *[" -1 -1 -1", "   0  1  90  2", "*U0100"],
    ]
    for utc, g, b, d in rows(record):
        stamp = f"{utc.day:3d} {utc.hour * 60 + utc.minute:4d}"
        lines += [
            f"{stamp}   {g:4.0f}   0.1    0    0   {b:4.0f}   0.0    0    0",
            f"           {d:4.0f}   0.2   -1    0    348   0.3  347  349     15.0  50.0  950",
        ]
    return written(path, lines)


def minutes_behind_the_sun(found):
    """By how much the centre of a clear record's mornings and evenings lags the sun's [min]."""
    light = light_at_altitude(found, found.site.altitude_m)
    clock, lags = light.time_solar_h, []
    for half in (clock < 12.0, clock >= 12.0):
        centres = [
            np.average(clock[half], weights=global_horizontal(sky, light.cos_zenith)[half])
            for sky in (light.recorded, light.clear)
        ]
        lags.append(60.0 * (centres[0] - centres[1]))
    return float(max(lags, key=abs))
