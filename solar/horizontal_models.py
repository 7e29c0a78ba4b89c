"""Conceptual Design Model (CDM) and Conceptual Analysis Model (CAM): horizontal solar modules.

Every function returns power per module area [W/m2] behind the MPPT; times the module
area it is what reaches battery and load. Source: Oettershagen, "High-Fidelity Solar Power Income
Modeling for Solar-Electric UAVs" (the report), table 2 and the equations named below.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

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
from solar.sun import NOON_H, cos_zenith, declination, hour_angle, sun_arc
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
    convert, corrected = _power_model(model, correct)
    factor = corrected * np.asarray(clearness, float)
    time = np.asarray(time_solar_h, float)
    if sky is not clear_sky:
        cos_z = cos_zenith(latitude_deg, declination(day_of_year), hour_angle(time))
        light = sky(day_of_year, latitude_deg, cos_z, altitude_m)
        return np.where(
            cos_z > 0.0, factor * convert(light, cos_z, cell, module_temperature_c), 0.0
        )
    # In blocks, and with the constants of a day computed once.
    skies = _Skies(
        *sun_arc(latitude_deg, declination(day_of_year)),
        *coefficients(day_of_year, latitude_deg),
        pressure_ratio(altitude_m),
        factor,
        np.asarray(module_temperature_c, float),
    )

    def power(part: _Skies, cosine: FloatArray) -> FloatArray:
        of_day = Coefficients(part.a, part.b, part.c, part.extraterrestrial)
        irradiance = irradiance_under(of_day, cosine, part.pressure)
        return part.factor * convert(irradiance, cosine, cell, part.temperature_c)

    return _over_the_day(power, skies, time)


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


def _power_model(
    model: ModelName | PowerModel, correct: CorrectionName
) -> tuple[PowerModel, float]:
    """Return the model, and the factor of its correction."""
    if not isinstance(model, str):
        if correct != "none":
            raise ValueError(f"the correction {correct!r} is none of the user's own model")
        return model, 1.0
    if model not in HORIZONTAL_MODELS:
        allowed = ", ".join(HORIZONTAL_MODELS)
        raise ValueError(f"unknown horizontal solar power model {model!r}; choose from {allowed}")
    if correct == "loiter":
        raise ValueError("the correction 'loiter' needs a flight path; choose none or report")
    return HORIZONTAL_MODELS[model], correction(model, correct).factor


class _Skies(NamedTuple):
    """Constants of sun, air and modules on each day; arrays that broadcast with the time."""

    mean: FloatArray
    amplitude: FloatArray
    a: FloatArray
    b: FloatArray
    c: FloatArray
    extraterrestrial: FloatArray
    pressure: FloatArray
    factor: FloatArray
    temperature_c: FloatArray


# Points computed at once: what a formula needs stays near the processor.
_POINTS_AT_ONCE = 16384


def _over_the_day(
    power: Callable[[_Skies, FloatArray], FloatArray], skies: _Skies, time_h: FloatArray
) -> FloatArray:
    """Compute the power of every sky at every time, in blocks, of a symmetric day only a half.

    Points do not depend on each other, so that the result is independent of the blocks.
    """
    shape = np.broadcast_shapes(time_h.shape, *(v.shape for v in skies))
    axis = _axis_of_a_symmetric_day(time_h, skies)
    if axis is None:
        result = np.zeros(shape)
        _fill(result, power, skies, np.cos(hour_angle(time_h)), None)
        return result
    count = shape[axis]
    half = (count + 1) // 2
    hours = np.cos(hour_angle(time_h.take(range(half), axis)))
    result = np.zeros(shape)
    morning = np.moveaxis(result, axis, 0)[:half]
    _fill(np.moveaxis(morning, 0, axis), power, skies, hours, axis)
    np.moveaxis(result, axis, 0)[half:] = morning[: count - half][::-1]
    return result


def _axis_of_a_symmetric_day(time_h: FloatArray, skies: _Skies) -> int | None:
    """Return the axis of time, counted from the last, of a symmetric day, else None."""
    axes = [axis for axis in range(-time_h.ndim, 0) if time_h.shape[axis] > 1]
    if len(axes) != 1 or any(v.ndim >= -axes[0] and v.shape[axes[0]] > 1 for v in skies):
        return None
    line = time_h.ravel()
    # Nodes of an even axis are symmetric to rounding.
    mirrored = np.abs(line + line[::-1] - 2.0 * NOON_H).max() <= 1e-12
    return axes[0] if mirrored and np.all(np.diff(line) > 0.0) else None


def _fill(
    result: FloatArray,
    power: Callable[[_Skies, FloatArray], FloatArray],
    skies: _Skies,
    cos_hour: FloatArray,
    time_axis: int | None,
) -> None:
    """Compute a result block by block along its first axis of more than one element."""
    if not result.size:
        return
    first = next((axis for axis in range(-result.ndim, 0) if result.shape[axis] > 1), -1)
    count = result.shape[first] if result.ndim else 1
    step = max(1, _POINTS_AT_ONCE * count // result.size)
    for start in range(0, count, step):
        cut = slice(start, start + step)
        block_skies = _Skies._make(_cut(v, first, cut) for v in skies)
        hours, block = _cut(cos_hour, first, cut), _cut(result, first, cut)
        cosine = np.asarray(block_skies.mean + block_skies.amplitude * hours)
        daylight = cosine > 0.0
        if time_axis is not None and cosine.ndim:
            others = tuple(a for a in range(-cosine.ndim, 0) if a != time_axis)
            nodes = np.flatnonzero(daylight.any(axis=others))
            if not len(nodes):
                continue
            day = slice(int(nodes[0]), int(nodes[-1]) + 1)
            cosine, block = _cut(cosine, time_axis, day), _cut(block, time_axis, day)
        elif not np.any(daylight):
            continue
        block[...] = power(block_skies, cosine)


def _cut(values: FloatArray, axis: int, part: slice) -> FloatArray:
    """Return part of an array along an axis counted from the last, if it has that axis."""
    if values.ndim < -axis or values.shape[axis] == 1:
        return values
    index = [slice(None)] * values.ndim
    index[axis] = part
    return values[tuple(index)]
