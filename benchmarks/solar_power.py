"""Module power over latitude x day x time, against the clear skies of pvlib and AeroSandbox."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.measuring import best_time_s, missing, optional, row
from solar.horizontal_models import horizontal_specific_power
from solar.modules import SolarCell

_LATITUDES = np.linspace(-70.0, 70.0, 60)[:, None, None]
_DAYS = np.linspace(1.5, 365.5, 37)[:, None]
_HOURS = np.linspace(0.0, 24.0, 241)
_POINTS = _LATITUDES.size * _DAYS.size * _HOURS.size
_ALTITUDE_M = 500.0
_RUNS = 25  # milliseconds each, so that a few would catch one state of the machine


def module_power() -> list[dict[str, Any]]:
    """Module power: ours with incidence losses, peers without."""
    cell = SolarCell()
    ours = best_time_s(
        lambda: horizontal_specific_power(
            _LATITUDES,
            _DAYS,
            _HOURS,
            cell=cell,
            module_temperature_c=25.0,
            altitude_m=_ALTITUDE_M,
        ),
        _RUNS,
    )
    work = (
        f"{_POINTS} points; electric power by CAM, {_POINTS / ours / 1e6:.1f} million a second; "
        "the peer gives irradiance only"
    )
    rows = []
    pvlib = optional("pvlib")
    if pvlib is None:
        rows.append(missing("module power", work, ours, "pvlib"))
    else:
        name = "pvlib, analytic sun and Ineichen"
        peer_s = best_time_s(lambda: _pvlib_ghi(pvlib), _RUNS)
        rows.append(row("module power", work, ours, name, peer_s))
    power_solar = optional("aerosandbox.library.power_solar")
    if power_solar is None:
        rows.append(missing("module power", work, ours, "AeroSandbox"))
    else:
        peer_s = best_time_s(lambda: _aerosandbox_flux(power_solar), _RUNS)
        rows.append(row("module power", work, ours, "AeroSandbox solar_flux", peer_s))
    return rows


def _aerosandbox_flux(power_solar: Any) -> Any:
    return power_solar.solar_flux(
        latitude=_LATITUDES,
        day_of_year=_DAYS,
        time=(_HOURS - 12.0) * 3600.0,
        altitude=_ALTITUDE_M,
    )


def _pvlib_ghi(pvlib: Any) -> Any:
    position = pvlib.solarposition
    zenith = position.solar_zenith_analytical(
        np.radians(_LATITUDES),
        np.radians((_HOURS - 12.0) * 15.0),
        position.declination_spencer71(_DAYS),
    )
    zenith_deg = np.degrees(zenith)
    with np.errstate(all="ignore"):
        mass = pvlib.atmosphere.get_relative_airmass(zenith_deg)
        return pvlib.clearsky.ineichen(zenith_deg, mass, 3.0, _ALTITUDE_M, 1366.0)["ghi"]
