"""Light of a sun below the horizontal plane, which the models leave out: ``python -m`` this module.

From the altitude ``h`` the horizon lies ``arccos(R / (R + h))`` lower, so that the sun is seen for
some minutes more. Its beam is integrated over the wavelengths that silicon uses, with Rayleigh
scattering and ozone along straight rays through a spherical atmosphere. Clouds, aerosol and
refraction are left out: the light is an upper bound.

Sources: Rayleigh optical depth of the atmosphere: Hansen, J. E. and Travis, L. D. (1974), Light
scattering in planetary atmospheres, Space Sci. Rev. 16, 527-610, equation 2.30. Spectrum: a black
body of 5772 K. Ozone: 300 Dobson units around 22 km, Chappuis band of 4.8e-25 m2 at 602 nm
(Serdyuchenko et al. 2014, Atmos. Meas. Tech. 7, 625-636), as a bell curve.
"""

from __future__ import annotations

import numpy as np

from solar.clearsky import (
    SOLAR_CONSTANT_W_PER_M2,
    pressure_ratio,
    thin_air_irradiance,
)
from solar.sun import HOURS_PER_DAY
from solar.types import FloatArray

EARTH_RADIUS_M = 6371000.0
_WAVELENGTH_UM = np.linspace(0.3, 1.1, 81)
_PATH_M = np.linspace(0.0, 1.2e6, 6001)
_ELEVATIONS = 60
_ALBEDO = 0.3
FACES = ("horizontal", "banked 5 deg", "banked 10 deg", "vertical", "downwards")


def spectrum() -> FloatArray:
    """Light outside the atmosphere [W/m2/um] at the wavelengths that silicon uses."""

    def black_body(um: FloatArray) -> FloatArray:
        return np.asarray(um**-5.0 / np.expm1(14387.769 / (um * 5772.0)))

    every = np.linspace(0.2, 10.0, 20000)
    whole = np.trapezoid(black_body(every), every)
    return np.asarray(SOLAR_CONSTANT_W_PER_M2 * black_body(_WAVELENGTH_UM) / whole)


def transmitted(altitude_m: float, elevation_rad: float) -> FloatArray:
    """Share of the beam that arrives, by wavelength; zero where the earth is in the way."""
    around = EARTH_RADIUS_M + altitude_m
    height_m = np.sqrt(around**2 + _PATH_M**2 + 2.0 * around * _PATH_M * np.sin(elevation_rad))
    height_m -= EARTH_RADIUS_M
    if height_m.min() < 0.0:
        return np.zeros(len(_WAVELENGTH_UM))
    density = (pressure_ratio(height_m - 50.0) - pressure_ratio(height_m + 50.0)) / 100.0
    air = np.trapezoid(density, _PATH_M)
    layer = np.exp(-0.5 * ((height_m - 22e3) / 5e3) ** 2) / (5e3 * np.sqrt(2.0 * np.pi))
    ozone = np.trapezoid(layer, _PATH_M)
    bell = np.exp(-0.5 * ((_WAVELENGTH_UM - 0.602) / 0.05) ** 2)
    chappuis = 0.3 * 2.687e19 * 4.8e-21 * bell
    return np.asarray(np.exp(-rayleigh_depth() * air - chappuis * ozone))


def rayleigh_depth() -> FloatArray:
    """Optical depth of the air above sea level, by wavelength."""
    um = _WAVELENGTH_UM
    return np.asarray(0.008569 * um**-4 * (1.0 + 0.0113 * um**-2 + 0.00013 * um**-4))


def dip_rad(altitude_m: float) -> float:
    """Angle of the horizon below the horizontal plane."""
    return float(np.arccos(EARTH_RADIUS_M / (EARTH_RADIUS_M + altitude_m)))


def beam_below(altitude_m: float, elevation_rad: FloatArray) -> FloatArray:
    """Direct normal light of a sun at or below the horizontal plane [W/m2]; zero above it."""
    low = np.linspace(-dip_rad(altitude_m), 0.0, _ELEVATIONS)
    light = spectrum()
    dni = [np.trapezoid(light * transmitted(altitude_m, e), _WAVELENGTH_UM) for e in low.tolist()]
    return np.asarray(np.interp(elevation_rad, low, dni, left=0.0) * (elevation_rad < 0.0))


def left_out(
    altitude_m: float, latitude_deg: float, declination_deg: float
) -> tuple[float, dict[str, float]]:
    """Minutes a day, and the light left out over the day's light of each face, in per cent.

    Banked faces have all headings alike, vertical ones all directions. Scattered light counts with
    its bound, half of what the air above the aircraft scatters of an undimmed beam.
    """
    latitude, declination = np.radians([latitude_deg, declination_deg])
    time_h = np.linspace(0.0, HOURS_PER_DAY / 2.0, 21601)
    sine = np.sin(latitude) * np.sin(declination)
    sine = sine + np.cos(latitude) * np.cos(declination) * np.cos(np.radians(15.0 * time_h))
    elevation = np.arcsin(sine)
    below = beam_below(altitude_m, elevation)
    above = thin_air_irradiance(SOLAR_CONSTANT_W_PER_M2, sine, pressure_ratio(altitude_m))
    level = above.dni * np.maximum(sine, 0.0) + above.dhi
    headings = np.radians(np.arange(0.0, 360.0, 2.0))

    def on_face(tilt_deg: float, beam: FloatArray) -> float:
        tilt = np.radians(tilt_deg)
        cosine = np.cos(tilt) * sine + np.outer(np.cos(headings), np.sin(tilt) * np.cos(elevation))
        return float(2.0 * np.trapezoid(np.maximum(cosine, 0.0).mean(axis=0) * beam, time_h))

    low = (elevation < 0.0) & (elevation > -dip_rad(altitude_m))
    hours = float(2.0 * np.trapezoid(low, time_h))
    scattered = np.trapezoid(spectrum() * rayleigh_depth(), _WAVELENGTH_UM)
    scattered_w = 0.5 * float(scattered * pressure_ratio(altitude_m))
    share = {}
    for face, tilt_deg in zip(FACES, (0.0, 5.0, 10.0, 90.0, 180.0), strict=True):
        seen = (1.0 + np.cos(np.radians(tilt_deg))) / 2.0
        diffuse = 2.0 * np.trapezoid(above.dhi, time_h) * seen
        reflected = _ALBEDO * 2.0 * np.trapezoid(level, time_h) * (face == "downwards")
        day = on_face(tilt_deg, above.dni) + diffuse + reflected
        share[face] = 100.0 * (on_face(tilt_deg, below) + seen * scattered_w * hours) / day
    return 60.0 * hours, share


def main() -> None:
    """Print what is left out, by altitude, latitude and season."""
    print("altitude  latitude  declination  minutes  " + "  ".join(f"{f:>13}" for f in FACES))
    for altitude_m in (10e3, 20e3, 25e3):
        for latitude_deg, declination_deg in (
            (0.0, 0.0),
            (47.0, 23.44),
            (47.0, 0.0),
            (47.0, -23.44),
        ):
            minutes, share = left_out(altitude_m, latitude_deg, declination_deg)
            shown = "  ".join(f"{share[face]:11.3f} %" for face in FACES)
            print(
                f"{altitude_m / 1e3:5.0f} km  {latitude_deg:6.0f} N  {declination_deg:11.2f}  "
                f"{minutes:7.0f}  {shown}"
            )


if __name__ == "__main__":
    main()
