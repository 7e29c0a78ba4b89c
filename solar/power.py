"""Specific electric power of horizontal solar modules: the models CDM and CAM.

Every function returns power per module area [W/m2] behind the power tracker; times the module
area it is what reaches battery and load. Source: Oettershagen, "High-Fidelity Solar Power Income
Modeling for Solar-Electric UAVs" (the report), table 2 and the equations named below.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from solar.clearsky import Irradiance, clear_sky
from solar.correction import correction
from solar.modules import SolarCell
from solar.names import CorrectionName, ModelName
from solar.sun import FloatArray, cos_zenith, declination, hour_angle


def conceptual_design_model(
    irradiance: Irradiance,
    cos_aoi: ArrayLike,
    cell: SolarCell,
    module_temperature_c: ArrayLike,
) -> FloatArray:
    """Specific power of the Conceptual Design Model (CDM): one efficiency for all light.

    Equation 4 of the report with ``eta = eta_STC eps_T eps_cbr`` and a constant tracker
    efficiency.

    Parameters
    ----------
    irradiance : Irradiance
        Direct normal and diffuse horizontal irradiance [W/m2].
    cos_aoi : array_like
        Cosine of the angle of incidence; for a horizontal module that of the zenith angle.
    cell : SolarCell
        Module and tracker efficiencies.
    module_temperature_c : array_like
        Constant module temperature [C].

    Returns
    -------
    ndarray
        Specific power [W/m2], broadcast shape of the arguments.
    """
    direct = irradiance.dni * np.maximum(np.asarray(cos_aoi, float), 0.0)
    efficiency = (
        cell.efficiency_stc
        * cell.temperature_efficiency(module_temperature_c)
        * cell.camber_efficiency
        * cell.mppt_efficiency
    )
    return np.asarray((direct + irradiance.dhi) * efficiency)


def conceptual_analysis_model(
    irradiance: Irradiance,
    cos_aoi: ArrayLike,
    cell: SolarCell,
    module_temperature_c: ArrayLike,
) -> FloatArray:
    """Specific power of the Conceptual Analysis Model (CAM): direct and diffuse light apart.

    Equation 5 of the report; the efficiency of direct light depends on its angle of incidence,
    that of diffuse light is constant and knows no camber (eq. 12 and 13). Parameters and result
    are those of :func:`conceptual_design_model`.
    """
    cosine = np.maximum(np.asarray(cos_aoi, float), 0.0)
    common = (
        cell.efficiency_stc
        * cell.temperature_efficiency(module_temperature_c)
        * cell.mppt_efficiency
    )
    direct = irradiance.dni * cosine * cell.incidence_efficiency(cosine) * cell.camber_efficiency
    return np.asarray((direct + irradiance.dhi * cell.diffuse_efficiency) * common)


HORIZONTAL_MODELS = {"CDM": conceptual_design_model, "CAM": conceptual_analysis_model}


def horizontal_specific_power(
    latitude_deg: ArrayLike,
    day_of_year: ArrayLike,
    time_solar_h: ArrayLike,
    *,
    cell: SolarCell,
    module_temperature_c: ArrayLike,
    altitude_m: ArrayLike = 0.0,
    clearness: ArrayLike = 1.0,
    model: ModelName = "CAM",
    correct: CorrectionName = "none",
) -> FloatArray:
    """Specific power of horizontal modules under the clear sky, over latitude x day x time.

    Parameters
    ----------
    latitude_deg, day_of_year, time_solar_h : array_like
        Latitude [deg], fractional day of year and local solar time [h]; they broadcast, so that
        shapes ``(lat, 1, 1)``, ``(day, 1)`` and ``(time,)`` give a whole map. For a repeated day
        pass the day's noon, ``day + 0.5``.
    cell : SolarCell
        Module and tracker efficiencies.
    module_temperature_c : array_like
        Constant module temperature [C].
    altitude_m : array_like
        Altitude above mean sea level [m].
    clearness : array_like
        Factor on the clear-sky irradiance, 0 to 1 (1: no clouds).
    model : {"CDM", "CAM"}
        Solar power model.
    correct : {"none", "report"}
        Systematic correction, see :mod:`solar.correction`.

    Returns
    -------
    ndarray
        Specific power [W/m2], never negative.

    Raises
    ------
    ValueError
        If the model or the correction does not exist, or needs a flight path.
    """
    if model not in HORIZONTAL_MODELS:
        allowed = ", ".join(HORIZONTAL_MODELS)
        raise ValueError(f"unknown horizontal solar power model {model!r}; choose from {allowed}")
    if correct == "loiter":
        raise ValueError("the correction 'loiter' needs a flight path; choose none or report")
    factor = correction(model, correct).factor * np.asarray(clearness, float)
    cosine = cos_zenith(latitude_deg, declination(day_of_year), hour_angle(time_solar_h))
    irradiance = clear_sky(day_of_year, latitude_deg, cosine, altitude_m)
    return np.asarray(
        factor * HORIZONTAL_MODELS[model](irradiance, cosine, cell, module_temperature_c)
    )
