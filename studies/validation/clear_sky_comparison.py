"""Daily insolation of the clear sky against pvlib's models (needs the extra ``pvlib``)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions.dates import date_label
from sizing.results.tables import Column, Table
from solar.clearsky import clear_sky, global_horizontal
from solar.sun import cos_zenith, declination, hour_angle
from solar.types import FloatArray


@dataclass(frozen=True)
class Site:
    """A place on Earth: degrees, metres above mean sea level."""

    name: str
    latitude_deg: float
    longitude_deg: float
    altitude_m: float


SITES = (
    Site("Singapore", 1.35, 103.82, 15.0),
    Site("Tucson", 32.22, -110.97, 750.0),
    Site("Rafz", 47.6, 8.53, 536.0),
    Site("Stockholm", 59.33, 18.07, 28.0),
    Site("Cape Town", -33.92, 18.42, 42.0),
)
DAYS = (80, 172, 266, 355)
_STEP_H = 1.0 / 12.0
_TIME_H = np.arange(0.0, 24.0 + _STEP_H / 2, _STEP_H)


@dataclass(frozen=True)
class Insolation:
    """Daily horizontal energy of three clear skies [Wh/m2]."""

    site: Site
    day_of_year: int
    ours_wh: float
    ineichen_wh: float
    solis_wh: float


def compare() -> list[Insolation]:
    """Daily energies at five sites in four seasons.

    The sun's path is the same for all three models, so that the skies alone are compared. Ineichen
    takes its monthly Linke turbidity from pvlib's climatology; simplified Solis pvlib's defaults
    (aerosol depth 0.1 at 700 nm, 1 cm of water).

    Raises
    ------
    ModuleNotFoundError
        If pvlib is not installed.
    """
    return [_insolation(site, day) for site in SITES for day in DAYS]


def _insolation(site: Site, day: int) -> Insolation:
    cosine = cos_zenith(site.latitude_deg, declination(day + 0.5), hour_angle(_TIME_H))
    ours = global_horizontal(
        clear_sky(day + 0.5, site.latitude_deg, cosine, site.altitude_m), cosine
    )
    ineichen, solis = _pvlib_skies(site, day, np.degrees(np.arccos(cosine)))
    return Insolation(site, day, *(_daily_wh(sky) for sky in (ours, ineichen, solis)))


def _pvlib_skies(site: Site, day: int, zenith_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
    import pandas as pd
    import pvlib

    noon = pd.DatetimeIndex(
        [pd.Timestamp("2015-01-01 12:00", tz="UTC") + pd.Timedelta(days=day - 1)]
    )
    turbidity = pvlib.clearsky.lookup_linke_turbidity(noon, site.latitude_deg, site.longitude_deg)
    pressure = pvlib.atmosphere.alt2pres(site.altitude_m)
    relative = pvlib.atmosphere.get_relative_airmass(zenith_deg)
    absolute = pvlib.atmosphere.get_absolute_airmass(relative, pressure)
    extra = pvlib.irradiance.get_extra_radiation(day)
    with np.errstate(divide="ignore"):  # pvlib divides by zero at the horizon itself
        ineichen = pvlib.clearsky.ineichen(
            zenith_deg, absolute, float(turbidity.iloc[0]), site.altitude_m, extra
        )["ghi"]
        solis = pvlib.clearsky.simplified_solis(
            90.0 - zenith_deg, pressure=pressure, dni_extra=extra
        )["ghi"]
    return np.nan_to_num(np.asarray(ineichen)), np.nan_to_num(np.asarray(solis))


def _daily_wh(ghi: FloatArray) -> float:
    return float(np.trapezoid(ghi, _TIME_H))


def clear_sky_table(rows: list[Insolation]) -> Table:
    """Daily energies, and how far ours is from each of pvlib's."""
    columns = (
        Column("site"),
        Column("date"),
        *(
            Column(name, unit="Wh/m²", form=".0f")
            for name in ("this clear sky", "Ineichen, climatology", "simplified Solis")
        ),
        Column("vs Ineichen", form="{:+.1f} %"),
        Column("vs Solis", form="{:+.1f} %"),
    )
    cells = [
        (
            r.site.name,
            date_label(r.day_of_year),
            *(r.ours_wh, r.ineichen_wh, r.solis_wh),
            100.0 * (r.ours_wh / r.ineichen_wh - 1.0),
            100.0 * (r.ours_wh / r.solis_wh - 1.0),
        )
        for r in rows
    ]
    return Table("daily horizontal energy of clear skies", columns, tuple(cells))
