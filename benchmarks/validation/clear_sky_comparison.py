"""The clear sky against pvlib's models, on the ground and high up (needs the extra ``pvlib``).

On the ground one definition holds for every page: the sun is that of the project, with the
declination of the day's noon and without refraction, for all skies, so that the skies alone are
compared. pvlib gets the sun's zenith angle, Kasten and Young's air mass, the site's altitude and
the pressure of the standard atmosphere there.

* Ineichen: Linke turbidity from pvlib's monthly climatology, interpolated to the day.
* Simplified Solis: pvlib's defaults, an aerosol depth of 0.1 at 700 nm and 1 cm of water.

With pvlib's own sun (SPA at every instant, refracted) the energies at Rafz differ by up to 0.8 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missions.air import standard_air
from missions.dates import date_label
from solar.clearsky import clear_sky, extraterrestrial_irradiance, global_horizontal
from solar.sun import cos_zenith, declination, hour_angle
from solar.types import FloatArray
from studies.render.tables import Column, Table


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
    """Daily horizontal energy of three clear skies [Wh/m2], and Ineichen's Linke turbidity [-]."""

    site: Site
    day_of_year: int
    linke_turbidity: float
    ours_wh: float
    ineichen_wh: float
    solis_wh: float


def compare() -> list[Insolation]:
    """Daily energies at five sites in four seasons, by the module's definition.

    Returns
    -------
    list of Insolation

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
    turbidity, ineichen, solis = _pvlib_skies(site, day, np.degrees(np.arccos(cosine)))
    return Insolation(site, day, turbidity, *(_daily_wh(sky) for sky in (ours, ineichen, solis)))


def _pvlib_skies(
    site: Site, day: int, zenith_deg: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """Linke turbidity [-], and irradiance by Ineichen and by simplified Solis [W/m2]."""
    import pandas as pd
    import pvlib

    noon = pd.DatetimeIndex(
        [pd.Timestamp("2015-01-01 12:00", tz="UTC") + pd.Timedelta(days=day - 1)]
    )
    monthly = pvlib.clearsky.lookup_linke_turbidity(noon, site.latitude_deg, site.longitude_deg)
    turbidity = float(monthly.iloc[0])
    pressure = pvlib.atmosphere.alt2pres(site.altitude_m)
    relative = pvlib.atmosphere.get_relative_airmass(zenith_deg)
    absolute = pvlib.atmosphere.get_absolute_airmass(relative, pressure)
    extra = pvlib.irradiance.get_extra_radiation(day)
    with np.errstate(divide="ignore"):  # pvlib divides by zero at the horizon itself
        ineichen = pvlib.clearsky.ineichen(zenith_deg, absolute, turbidity, site.altitude_m, extra)[
            "ghi"
        ]
        solis = pvlib.clearsky.simplified_solis(
            90.0 - zenith_deg, pressure=pressure, dni_extra=extra
        )["ghi"]
    return turbidity, np.nan_to_num(np.asarray(ineichen)), np.nan_to_num(np.asarray(solis))


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
        Column("linke_turbidity", "Linke turbidity", form=".1f"),
        Column("vs Ineichen", form="{:+.1f} %"),
        Column("vs Solis", form="{:+.1f} %"),
    )
    cells = [
        (
            r.site.name,
            date_label(r.day_of_year),
            *(r.ours_wh, r.ineichen_wh, r.solis_wh, r.linke_turbidity),
            100.0 * (r.ours_wh / r.ineichen_wh - 1.0),
            100.0 * (r.ours_wh / r.solis_wh - 1.0),
        )
        for r in rows
    ]
    return Table("daily horizontal energy of clear skies", columns, tuple(cells))


@dataclass(frozen=True)
class Light:
    """Light at noon: direct normal, diffuse and global horizontal [W/m2]; of the day [Wh/m2]."""

    dni: float
    dhi: float
    ghi: float
    day_wh: float


@dataclass(frozen=True)
class LightAt:
    """Light of two skies at an altitude."""

    altitude_m: float
    ours: Light
    solis: Light


ALTITUDES_M = (0.0, 5000.0, 9000.0, 12000.0, 15000.0, 18000.0, 20000.0, 25000.0)
# Simplified Solis at altitude: water and dust at sea level, and the height over which both fall by
# e. Assumptions, of the order of the US standard atmosphere's water (1.4 cm) and pvlib's default.
_WATER_CM, _DUST_700NM, _FADING_HEIGHT_M = 1.5, 0.1, 2000.0


def light_up_to(
    altitudes_m: Sequence[float] = ALTITUDES_M,
    *,
    latitude_deg: float = 47.6,
    day_of_year: int = 172,
) -> list[LightAt]:
    """Light of a clear day at several altitudes, ours and that of simplified Solis.

    Solis takes the pressure of the standard atmosphere, and water and dust that fall off by e every
    2 km, its water not below 0.2 cm. Its range ends at 7 km; it fits direct, diffuse and global
    light apart from each other.

    Parameters
    ----------
    altitudes_m : sequence of float
        Altitudes above mean sea level [m].
    latitude_deg : float
        Latitude [deg].
    day_of_year : int
        Day of the year.

    Returns
    -------
    list of LightAt
        One per altitude.

    Raises
    ------
    ModuleNotFoundError
        If pvlib is not installed.
    """
    noon = day_of_year + 0.5
    cosine = cos_zenith(latitude_deg, declination(noon), hour_angle(_TIME_H))
    rows = []
    for altitude_m in altitudes_m:
        sky = clear_sky(noon, latitude_deg, cosine, altitude_m)
        ours = _light(sky.dni, sky.dhi, global_horizontal(sky, cosine))
        rows.append(LightAt(altitude_m, ours, _solis(noon, cosine, altitude_m)))
    return rows


def _solis(noon: float, cosine: FloatArray, altitude_m: float) -> Light:
    import pvlib

    lit = cosine > 1e-3  # at the horizon itself Solis is infinite high up
    fading = np.exp(-altitude_m / _FADING_HEIGHT_M)
    sky = pvlib.clearsky.simplified_solis(
        np.degrees(np.arcsin(cosine[lit])),
        aod700=_DUST_700NM * fading,
        precipitable_water=_WATER_CM * fading,
        pressure=float(standard_air(altitude_m).pressure_pa),
        dni_extra=float(extraterrestrial_irradiance(noon)),
    )
    parts = np.zeros((3, len(cosine)))
    parts[:, lit] = sky["dni"], sky["dhi"], sky["ghi"]
    return _light(*parts)


def _light(dni: FloatArray, dhi: FloatArray, ghi: FloatArray) -> Light:
    noon = len(_TIME_H) // 2
    return Light(float(dni[noon]), float(dhi[noon]), float(ghi[noon]), _daily_wh(ghi))


def light_table(rows: list[LightAt]) -> Table:
    """Both skies side by side, and how far the light on a horizontal surface is apart."""
    parts = ("direct", "diffuse", "horizontal")
    columns = (
        Column("altitude", unit="km", form=".0f"),
        *(Column(part, unit="W/m²", form=".0f") for part in parts),
        *(Column(f"Solis {part}", unit="W/m²", form=".0f") for part in parts),
        Column("vs Solis, noon", form="{:+.1f} %"),
        Column("day", unit="Wh/m²", form=".0f"),
        Column("vs Solis, day", form="{:+.1f} %"),
    )
    cells = [
        (
            r.altitude_m / 1000.0,
            *(r.ours.dni, r.ours.dhi, r.ours.ghi, r.solis.dni, r.solis.dhi, r.solis.ghi),
            100.0 * (r.ours.ghi / r.solis.ghi - 1.0),
            r.ours.day_wh,
            100.0 * (r.ours.day_wh / r.solis.day_wh - 1.0),
        )
        for r in rows
    ]
    return Table("clear skies up to 25 km", columns, tuple(cells))
