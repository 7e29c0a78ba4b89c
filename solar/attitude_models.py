"""Verification Model (VM) and Full Model (FM): solar power of an aircraft in any attitude.

Source: Oettershagen's report on solar power models, eq. 2 to 13 and table 2. Both return power per
module area like the horizontal models of :mod:`solar.horizontal_models`; the Full Model also
returns every component efficiency, which show what drives the power.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from solar.clearsky import Irradiance, global_horizontal
from solar.geometry import ModuleGeometry, cos_angle_of_incidence
from solar.heat_balance import Surroundings, balanced_temperature_c
from solar.horizontal_models import PowerModel, conceptual_analysis_model, in_surroundings
from solar.modules import SolarCell
from solar.shading import Shading, apply_losses, no_losses, shaded_fraction
from solar.types import FloatArray

_ITERATIONS = 60
_TOLERANCE = 1e-12


@dataclass(frozen=True)
class ModulePower:
    """Power of the Full Model and its component efficiencies.

    Arrays without a surface have the shape of sun and attitude together, those ``_by_surface`` one
    more axis. Power and irradiance are per module area [W/m2]; temperatures in degrees Celsius;
    efficiencies relative, except ``module_efficiency`` (electric power before the MPPT over the
    light that falls on the modules).
    """

    specific_power_w_per_m2: FloatArray
    irradiance_w_per_m2: FloatArray
    module_efficiency: FloatArray
    mppt_efficiency: FloatArray
    temperature_efficiency: FloatArray
    module_temperature_c: FloatArray
    cos_aoi_by_surface: FloatArray
    irradiance_by_surface_w_per_m2: FloatArray
    incidence_efficiency_by_surface: FloatArray
    low_light_efficiency_by_surface: FloatArray


def verification_model(
    irradiance: Irradiance,
    sun_vector: ArrayLike,
    to_ned: ArrayLike,
    geometry: ModuleGeometry,
    cell: SolarCell,
    module_temperature_c: ArrayLike,
    *,
    surroundings: Surroundings | None = None,
    albedo: float = 0.0,
) -> FloatArray:
    """Compute the specific power of the Verification Model: CAM on the central wing's flat surface.

    Parameters
    ----------
    irradiance : Irradiance
        Direct normal and diffuse horizontal irradiance [W/m2].
    sun_vector : array_like, shape (..., 3)
        Unit vector to the sun, North-East-Down.
    to_ned : array_like, shape (..., 3, 3)
        Rotation from body axes to North-East-Down, see :func:`solar.geometry.direction_cosines`.
    geometry : ModuleGeometry
        Module surfaces; the central wing's mean normal is used.
    cell : SolarCell
        Module and MPPT efficiencies.
    module_temperature_c : array_like
        Constant module temperature [C].
    surroundings : Surroundings, optional
        Air and radiation by which the modules find their temperature.
    albedo : float
        Share of the light that the earth sends back up [-].

    Returns
    -------
    ndarray
        Specific power [W/m2], broadcast shape of irradiance, sun and attitude.
    """
    normal = np.asarray(to_ned, float) @ geometry.central_wing_normal()
    cosine = cos_angle_of_incidence(normal, sun_vector)
    if albedo:
        up = _from_below(irradiance, np.asarray(sun_vector, float), normal, albedo)
        irradiance = Irradiance(irradiance.dni, irradiance.dhi + up)
    convert: PowerModel = conceptual_analysis_model
    if surroundings is not None:
        convert = in_surroundings(convert, surroundings, -np.asarray(sun_vector, float)[..., 2])
    return convert(irradiance, cosine, cell, module_temperature_c)


def full_model(
    irradiance: Irradiance,
    sun_vector: ArrayLike,
    to_ned: ArrayLike,
    geometry: ModuleGeometry,
    cell: SolarCell,
    ambient_temperature_c: ArrayLike,
    *,
    shading: Shading | None = None,
    surroundings: Surroundings | None = None,
    albedo: float = 0.0,
) -> ModulePower:
    """Compute the specific power and component efficiencies of the Full Model.

    Every surface meets the light at its own angle; its efficiency falls with little light and at
    flat angles; the modules warm up with the power they give (eq. 9 and 10), and the MPPT's
    efficiency follows its load. Power, temperature and load are solved for together.

    Parameters
    ----------
    irradiance : Irradiance
        Direct normal and diffuse horizontal irradiance [W/m2].
    sun_vector : array_like, shape (..., 3)
        Unit vector to the sun, North-East-Down.
    to_ned : array_like, shape (..., 3, 3)
        Rotation from body axes to North-East-Down, see :func:`solar.geometry.direction_cosines`.
    geometry : ModuleGeometry
        Module surfaces.
    cell : SolarCell
        Module and MPPT efficiencies.
    ambient_temperature_c : array_like
        Temperature of the air [C].
    shading : Shading, optional
        Shading by the tail with its losses (the report only shows the shaded area).
    surroundings : Surroundings, optional
        Air and radiation by which the modules find their temperature, instead of eq. 10.
    albedo : float
        Share of the light that the earth reflects, seen by surfaces as far as they face down [-].

    Returns
    -------
    ModulePower
        Arrays of the broadcast shape of irradiance, sun and attitude; by surface one more axis.
    """
    rotation = np.asarray(to_ned, float)
    normals = np.einsum("...ij,sj->...si", rotation, geometry.normals())
    sun = np.asarray(sun_vector, float)
    cosine = cos_angle_of_incidence(normals, sun[..., np.newaxis, :])
    on_each = Irradiance(*(np.asarray(part)[..., np.newaxis] for part in irradiance))
    direct = on_each.dni * np.maximum(cosine, 0.0)
    if shading is not None and shading.model is not no_losses:
        sun_body = np.einsum("...ji,...j->...i", rotation, sun)
        shaded = shaded_fraction(geometry, shading.tail, sun_body)
        direct = apply_losses(direct, shaded, shading.model)
    diffuse = on_each.dhi
    if geometry.face_down.any():
        # The lower face sees the part of the sky that its tilt leaves (Liu & Jordan 1963).
        seen = np.where(geometry.face_down, (1.0 - normals[..., 2]) / 2.0, 1.0)
        diffuse = diffuse * seen
    if albedo:
        diffuse = diffuse + _from_below(on_each, sun[..., np.newaxis, :], normals, albedo)
    light = direct + diffuse
    low_light = cell.low_light_efficiency(light)
    incidence = cell.incidence_efficiency(cosine)
    useful = direct * incidence * cell.camber_efficiency + diffuse * cell.diffuse_efficiency
    shares = geometry.area_shares
    at_25_c = (useful * low_light) @ shares * cell.efficiency_stc
    falling = light @ shares
    ambient_c = np.asarray(ambient_temperature_c, float)
    if surroundings is None:
        power, temperature = _balanced_power(at_25_c, cell, ambient_c)
        before_mppt = at_25_c * cell.temperature_efficiency(temperature)
    else:
        level = global_horizontal(irradiance, -sun[..., 2])
        temperature = balanced_temperature_c(falling, level, at_25_c, cell, surroundings)
        before_mppt = at_25_c * cell.temperature_efficiency(temperature)
        power = before_mppt * cell.mppt_efficiency_at(before_mppt / cell.full_load_w_per_m2)
    return ModulePower(
        specific_power_w_per_m2=power,
        irradiance_w_per_m2=falling,
        module_efficiency=_quotient(before_mppt, falling),
        mppt_efficiency=_quotient(power, before_mppt),
        temperature_efficiency=cell.temperature_efficiency(temperature),
        module_temperature_c=temperature,
        cos_aoi_by_surface=cosine,
        irradiance_by_surface_w_per_m2=light,
        incidence_efficiency_by_surface=incidence,
        low_light_efficiency_by_surface=low_light,
    )


def _from_below(
    irradiance: Irradiance, sun_vector: FloatArray, normals: FloatArray, albedo: float
) -> FloatArray:
    """Return light that the earth reflects to surfaces, ``A GHI (1 - cos b) / 2`` by tilt [W/m2].

    Source: Liu, B. Y. H. and Jordan, R. C. (1963), The long-term average performance of flat-plate
    solar-energy collectors, Solar Energy 7, 53-74; a plain that is lit evenly.
    """
    level = global_horizontal(irradiance, -sun_vector[..., 2])
    return np.asarray(albedo * level * (1.0 + normals[..., 2]) / 2.0)


def _balanced_power(
    at_25_c: FloatArray, cell: SolarCell, ambient_c: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Solve for the power behind the MPPT and the module temperature, by plain iteration.

    It converges within a few rounds: a rise of temperature changes the power by a few per cent of
    itself, and the curve of a loaded MPPT is flat.
    """
    rated = cell.full_load_w_per_m2
    power = at_25_c * cell.mppt_efficiency
    for _ in range(_ITERATIONS):
        temperature = ambient_c + cell.temperature_rise_k * power / rated
        before = at_25_c * cell.temperature_efficiency(temperature)
        reached = before * cell.mppt_efficiency_at(before / rated)
        settled = np.max(np.abs(reached - power), initial=0.0) <= _TOLERANCE * rated
        power = reached
        if settled:
            break
    return power, np.asarray(ambient_c + cell.temperature_rise_k * power / rated)


def _quotient(numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    """Divide; zero where there is no light at all."""
    daylight = denominator > 0.0
    return np.where(daylight, numerator / np.where(daylight, denominator, 1.0), 0.0)
