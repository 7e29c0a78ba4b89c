"""Conceptual Design Model (CDM) and Conceptual Analysis Model (CAM): horizontal solar modules.

Every function returns power per module area [W/m2] behind the MPPT; times the module
area it is what reaches battery and load. Source: Oettershagen, "High-Fidelity Solar Power Income
Modeling for Solar-Electric UAVs" (the report), table 2 and the equations named below.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from solar.clearsky import (
    ClearSky,
    Coefficients,
    Irradiance,
    clear_sky,
    coefficients,
    global_horizontal,
    irradiance_under,
    pressure_ratio,
)
from solar.heat_balance import Surroundings, balanced_temperature_c
from solar.modules import STC_TEMPERATURE_C, SolarCell
from solar.names import CorrectionName, ModelName
from solar.sun import NOON_H, declination, hour_angle, sun_arc
from solar.systematic_errors import correction
from solar.types import FloatArray


def conceptual_design_model(
    irradiance: Irradiance, cos_aoi: ArrayLike, cell: SolarCell, module_temperature_c: ArrayLike
) -> FloatArray:
    """Compute the specific power of the Conceptual Design Model (CDM): a constant efficiency.

    Equation 4 of the report with ``eta = eta_STC eps_T eps_cbr`` and a constant MPPT
    efficiency.

    Parameters
    ----------
    irradiance : Irradiance
        Direct normal and diffuse horizontal irradiance [W/m2].
    cos_aoi : array_like
        Cosine of the angle of incidence; for a horizontal module that of the zenith angle.
    cell : SolarCell
        Module and MPPT efficiencies.
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
    irradiance: Irradiance, cos_aoi: ArrayLike, cell: SolarCell, module_temperature_c: ArrayLike
) -> FloatArray:
    """Compute the specific power of the Conceptual Analysis Model (CAM), by kind of light.

    Equation 5 of the report; the efficiency of direct light depends on its angle of incidence,
    that of diffuse light is constant and knows no camber (eq. 12 and 13).

    Parameters
    ----------
    irradiance : Irradiance
        Direct normal and diffuse horizontal irradiance [W/m2].
    cos_aoi : array_like
        Cosine of the angle of incidence; for a horizontal module that of the zenith angle.
    cell : SolarCell
        Module and MPPT efficiencies.
    module_temperature_c : array_like
        Constant module temperature [C].

    Returns
    -------
    ndarray
        Specific power [W/m2], broadcast shape of the arguments.
    """
    cosine = np.maximum(np.asarray(cos_aoi, float), 0.0)
    common = (
        cell.efficiency_stc
        * cell.temperature_efficiency(module_temperature_c)
        * cell.mppt_efficiency
    )
    direct = irradiance.dni * cosine * cell.incidence_efficiency(cosine) * cell.camber_efficiency
    return np.asarray((direct + irradiance.dhi * cell.diffuse_efficiency) * common)


PowerModel: TypeAlias = Callable[[Irradiance, ArrayLike, SolarCell, ArrayLike], FloatArray]
"""Specific power [W/m2] of irradiance, cosine of incidence, cell and module temperature [C].

As :func:`conceptual_design_model`: everything broadcasts, and no light gives no power.
"""

HORIZONTAL_MODELS: dict[ModelName, PowerModel] = {
    "CDM": conceptual_design_model,
    "CAM": conceptual_analysis_model,
}


def horizontal_specific_power(
    latitude_deg: ArrayLike,
    day_of_year: ArrayLike,
    time_solar_h: ArrayLike,
    *,
    cell: SolarCell,
    module_temperature_c: ArrayLike,
    altitude_m: ArrayLike = 0.0,
    clearness: ArrayLike = 1.0,
    model: ModelName | PowerModel = "CAM",
    correct: CorrectionName = "none",
    sky: ClearSky = clear_sky,
) -> FloatArray:
    """Compute the specific power of horizontal modules under the clear sky, latitude x day x time.

    Parameters
    ----------
    latitude_deg, day_of_year, time_solar_h : array_like
        Latitude [deg], fractional day of year and local solar time [h]; they broadcast, so that
        shapes ``(lat, 1, 1)``, ``(day, 1)`` and ``(time,)`` give a whole map. For a repeated day
        pass the day's noon, ``day + 0.5``.
    cell : SolarCell
        Module and MPPT efficiencies.
    module_temperature_c : array_like
        Constant module temperature [C].
    altitude_m : array_like
        Altitude above mean sea level [m].
    clearness : array_like
        Factor on the clear-sky irradiance, 0 to 1 (1: no clouds).
    model : {"CDM", "CAM"} or PowerModel
        Solar power model, or a user-defined one, such as with the modules' heat balance:
        :func:`in_surroundings`.
    correct : {"none", "report"}
        Systematic correction of CDM or CAM, see :mod:`solar.systematic_errors`.
    sky : ClearSky
        Clear-sky model, :func:`solar.clearsky.clear_sky` or a user-defined one.

    Returns
    -------
    ndarray
        Specific power [W/m2], never negative.

    Raises
    ------
    ValueError
        If the model or the correction does not exist, or needs a flight path.
    """
    if isinstance(model, str):
        convert, corrected = _named_model(model, correct)
    elif correct == "none":
        convert, corrected = model, 1.0
    else:
        raise ValueError(f"the correction {correct!r} is none of the user's own model")
    factor = corrected * np.asarray(clearness, float)
    time, temperature_c = (np.asarray(v, float) for v in (time_solar_h, module_temperature_c))
    arc = sun_arc(latitude_deg, declination(day_of_year))
    if sky is clear_sky:
        of_day = coefficients(day_of_year, latitude_deg)
        days = [*arc, *of_day, pressure_ratio(altitude_m), factor, temperature_c]
        if time.ndim == 1 and all(v.shape[-1:] in ((), (1,)) for v in days):
            return _over_days(convert, cell, days, time)
    cos_z = np.asarray(arc.mean + arc.amplitude * np.cos(hour_angle(time)))
    light = sky(day_of_year, latitude_deg, cos_z, altitude_m)
    return np.where(cos_z > 0.0, factor * convert(light, cos_z, cell, temperature_c), 0.0)


# Points computed at once: what a formula needs stays near the processor.
_POINTS_AT_ONCE = 16384


def _over_days(
    convert: PowerModel, cell: SolarCell, constants: Sequence[FloatArray], time_h: FloatArray
) -> FloatArray:
    """Compute the power of days at the same times, in blocks of days, at night nothing.

    ``constants`` of each day, with a last axis of length 1: mean and amplitude of the sun's path,
    coefficients of the sky, pressure ratio, factor and temperature. Of a day whose times mirror
    each other about noon, to rounding, the morning is computed alone.
    """
    shape = np.broadcast_shapes((1,), *(v.shape for v in constants))
    days = [np.broadcast_to(v, shape).reshape(-1, 1) for v in constants]
    # In memory the time comes first: simulators march over it, all days at once.
    result = np.zeros((len(time_h), len(days[0]))).T
    mirrored = np.abs(time_h + time_h[::-1] - 2.0 * NOON_H).max(initial=0.0) <= 1e-12
    half = (len(time_h) + 1) // 2 if mirrored and np.all(np.diff(time_h) > 0.0) else len(time_h)
    hours = np.cos(hour_angle(time_h[:half]))
    step = max(1, _POINTS_AT_ONCE // max(half, 1))
    for start in range(0, len(result), step):
        mean, amplitude, *sky, pressure, factor, temperature_c = (
            v[start : start + step] for v in days
        )
        cosine = mean + amplitude * hours
        nodes = np.flatnonzero((cosine > 0.0).any(axis=0))
        if len(nodes):
            day = slice(int(nodes[0]), int(nodes[-1]) + 1)
            light = irradiance_under(Coefficients(*sky), cosine[:, day], pressure)
            power = factor * convert(light, cosine[:, day], cell, temperature_c)
            result[start : start + step, day] = power
    if half < len(time_h):
        result[:, half:] = result[:, : len(time_h) - half][:, ::-1]
    return result.reshape((*shape[:-1], len(time_h)))


def in_surroundings(
    convert: PowerModel, around: Surroundings, cos_zenith: ArrayLike | None = None
) -> PowerModel:
    """Return the model with module temperatures by the heat balance, instead of its argument.

    ``convert``: CDM or CAM, whose power is proportional to the component efficiency of the
    temperature. ``cos_zenith``: of the sun, for modules that are not horizontal.
    """

    def power(
        irradiance: Irradiance, cos_aoi: ArrayLike, cell: SolarCell, module_c: ArrayLike
    ) -> FloatArray:
        at_25_c = convert(irradiance, cos_aoi, cell, STC_TEMPERATURE_C)
        light = global_horizontal(irradiance, cos_aoi)
        level = light if cos_zenith is None else global_horizontal(irradiance, cos_zenith)
        electric = at_25_c / cell.mppt_efficiency
        balanced_c = balanced_temperature_c(light, level, electric, cell, around)
        return at_25_c * cell.temperature_efficiency(balanced_c)

    return power


def _named_model(model: ModelName, correct: CorrectionName) -> tuple[PowerModel, float]:
    """Return CDM or CAM, and the factor of its correction."""
    if model not in HORIZONTAL_MODELS:
        allowed = ", ".join(HORIZONTAL_MODELS)
        raise ValueError(f"unknown horizontal solar power model {model!r}; choose from {allowed}")
    if correct == "loiter":
        raise ValueError("the correction 'loiter' needs a flight path; choose none or report")
    return HORIZONTAL_MODELS[model], correction(model, correct).factor
