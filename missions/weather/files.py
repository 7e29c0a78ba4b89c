"""Weather records from files, by name or path, and missions at their site."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path

import numpy as np

from missions.files.errors import file_error, in_file, printable
from missions.files.shipped import shipped_file, shipped_names
from missions.mission import Mission
from missions.mission.scenarios import latitude_label
from missions.weather.record import Weather
from solar.clearsky import THIN_AIR_FROM_M
from solar.schema import spell


def load_weather(path: str | os.PathLike[str], mission: Mission | None = None) -> Weather:
    """Load a weather record: light, temperature and wind at a site over time.

    Parameters
    ----------
    path : str or path
        Name of the shipped record, ``colorado-2023``, or a file: EPW, TMY2, TMY3, PVGIS (typical
        year or hourly, CSV or JSON), SAM, NSRDB PSM, BSRN, NASA POWER (CSV), ERA5 (CSV time
        series), NetCDF of ERA5, NASA POWER and others, or a plain CSV table. Which of them it is
        is seen from the contents.
    mission : Mission, optional
        Whose latitude, longitude and altitude choose the point of gridded data.

    Returns
    -------
    Weather
        Equal intervals without gaps; ``repairs`` lists repairs.

    Raises
    ------
    InputError
        With file, line and reason, if the file cannot be read or its values cannot be true.
    """
    # They read with pandas, which takes longer than a command without a record.
    from missions.weather import checks, layouts

    with weather_file(path) as (place, source), in_file(source):
        return checks.checked_record(layouts.read_layout(place, mission), source)


@contextmanager
def weather_file(path: str | os.PathLike[str]) -> Iterator[tuple[Path, str]]:
    """Yield a weather record's file while it is read, and its name for messages."""
    name = os.fspath(path)
    source = printable(name) or repr(name)
    if name in shipped_names("record") and not Path(name).exists():
        with resources.as_file(shipped_file("record", name)) as place:
            yield place, f"{name} (shipped)"
        return
    if not os.path.lexists(name):
        known = ", ".join(shipped_names("record"))
        raise file_error(source, f"there is no such file, and none is shipped but {known}")
    yield Path(name), source


# ---- Missions at the site of a record

EARTH_RADIUS_KM = 6371.0
NEAR_KM, FAR_KM = 100, 1000
# Height above the ground of a mission that sets none [m].
DEFAULT_HEIGHT_M = 120


def mission_at_site(
    mission: Mission, weather: Weather, *, chosen: bool = True
) -> tuple[Mission, tuple[str, ...]]:
    """Return a mission at the site of a weather record, without its launch, and notes.

    ``chosen``: False for a default mission, which follows the record anywhere. Missions with climbs
    are refused.
    """
    if mission.climb is not None:
        raise file_error(
            weather.source,
            f"flights through a weather record keep their altitude: leave out climb of "
            f"{mission.name}",
        )
    site, notes, latitudes = weather.site, [], sorted(mission.latitudes())
    # Great-circle distance from the site to the nearest of the mission's latitudes.
    here = np.radians(site.latitude_deg)
    there = np.radians(np.clip(site.latitude_deg, latitudes[0], latitudes[-1]))
    east_deg = mission.longitude_deg
    across = 0.0 if east_deg is None else np.radians(site.longitude_deg - east_deg)
    half = np.cos(here) * np.cos(there) * np.sin(across / 2.0) ** 2
    half = np.sin((there - here) / 2.0) ** 2 + half
    away_km = 2.0 * EARTH_RADIUS_KM * float(np.arcsin(np.sqrt(half)))
    if chosen and away_km > FAR_KM:
        raise file_error(
            weather.source,
            f"its site {site.label} is {round(away_km)} km from the mission {mission.name}; "
            f"allowed: up to {FAR_KM} km (set the mission's latitude_deg; solar-uav analyse may "
            "also leave the mission out)",
        )
    if away_km > NEAR_KM and east_deg is not None:
        notes.append(f"simulated at the record's site, {round(away_km)} km from the mission's site")
    elif away_km > NEAR_KM:
        ends = map(latitude_label, sorted({latitudes[0], latitudes[-1]}))
        notes.append(
            f"the mission has no longitude: its site is at {latitude_label(site.latitude_deg)} "
            f"instead of {' to '.join(ends)}"
        )
    altitude_m, ground_m = mission.altitude_m, round(site.altitude_m)
    if altitude_m >= THIN_AIR_FROM_M:
        raise file_error(
            weather.source,
            f"its site is {ground_m} m high and its clouds lie below the mission's altitude_m of "
            f"{spell(altitude_m)}: a flight through a record is below {spell(THIN_AIR_FROM_M)} m; "
            "above, leave the record out",
        )
    if altitude_m < site.altitude_m:
        higher_m = site.altitude_m + DEFAULT_HEIGHT_M
        if chosen:
            raise file_error(
                weather.source,
                f"the ground of its site is {ground_m} m high: the mission's altitude_m of "
                f"{spell(altitude_m)} is below it; {DEFAULT_HEIGHT_M} m above the ground: "
                f"--set mission.altitude_m={round(higher_m)}",
            )
        altitude_m = higher_m
        notes.append(f"simulated {DEFAULT_HEIGHT_M} m above the site, at {round(altitude_m)} m")
    elsewhere = mission.at_altitude(altitude_m) if altitude_m != mission.altitude_m else mission
    moved = elsewhere.model_copy(
        update={
            "latitude_deg": site.latitude_deg,
            "longitude_deg": site.longitude_deg,
            "launch": None,
        }
    )
    return moved, tuple(notes)
