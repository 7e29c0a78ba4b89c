"""Solar power models on the samples of a flight log.

Every sample with the sun above the horizon gets the power of all models that the log and the
aircraft allow: VM and FM need the attitude and the module surfaces.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, TypeAlias

import numpy as np

from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M, standard_air
from missions.files.errors import file_error
from missions.logs.table import FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from solar.attitude import direction_cosines
from solar.attitude_models import ModulePower, full_model, verification_model
from solar.clearsky import ClearSky, Irradiance
from solar.geometry import ModuleGeometry
from solar.horizontal_models import HORIZONTAL_MODELS
from solar.names import ModelName
from solar.shading import shaded_area
from solar.sun import SECONDS_PER_DAY, sun_position
from solar.types import FloatArray, IntArray

ShadedArea: TypeAlias = Callable[[FloatArray], FloatArray]
"""Shaded area of every module surface [m2] from sun vectors in body axes."""

# Samples handled at once: a long log times its surfaces would fill the memory.
_CHUNK = 16_384


@dataclass(frozen=True)
class Detail:
    """What the Full Model says beside the power, averaged over the surfaces by area.

    Angles in degrees, temperatures in degrees Celsius, irradiance on the modules in W/m2; relative
    efficiencies. ``shaded_m2`` is the shaded module area, ``shading_loss_w`` the power that the
    shadow takes if direct light is lost in proportion; both are None without a tail.
    """

    incidence_deg: FloatArray
    irradiance_w_per_m2: FloatArray
    module_efficiency: FloatArray
    incidence_efficiency: FloatArray
    low_light_efficiency: FloatArray
    temperature_efficiency: FloatArray
    mppt_efficiency: FloatArray
    module_temperature_c: FloatArray
    shaded_m2: FloatArray | None
    shading_loss_w: FloatArray | None

    def mapped(self, change: Callable[[str, FloatArray], FloatArray]) -> Detail:
        """Every array changed by a function of its name and itself."""
        arrays: dict[str, Any] = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(self, **{n: change(n, v) for n, v in arrays.items() if v is not None})


@dataclass(frozen=True)
class Samples:
    """Samples of a log with the sun above the horizon, and all models on them.

    ``index``: their places in the log. ``time_s``, ``time_solar_h``: universal time [s since 1970]
    and true solar time [h]. ``solar_day``: day by local solar time, days since 1970-01-01. ``run``:
    number of the uninterrupted stretch; neither gap nor night lies within one. ``elevation_deg``,
    ``bearing_deg``: the sun's elevation, and its bearing from the nose, clockwise, 0 to 360; the
    latter zero without attitude. ``modelled_w``: power of each model that could be computed.
    ``detail``: more of the Full Model, if that could be computed.
    """

    index: IntArray
    time_s: FloatArray
    time_solar_h: FloatArray
    solar_day: IntArray
    run: IntArray
    elevation_deg: FloatArray
    bearing_deg: FloatArray
    measured_w: FloatArray
    modelled_w: Mapping[ModelName, FloatArray]
    detail: Detail | None


def day_of_year(time_s: FloatArray) -> FloatArray:
    """Fractional day of year, 1.0 at the start of 1 January (UTC)."""
    instants = np.asarray(time_s).astype("datetime64[s]")
    years = instants.astype("datetime64[Y]").astype("datetime64[s]")
    return np.asarray(1.0 + (np.asarray(time_s) - years.astype(np.int64)) / SECONDS_PER_DAY, float)


def module_geometry(log: FlightLog, aircraft: Aircraft) -> tuple[ModuleGeometry | None, list[str]]:
    """Module geometry if VM and FM can be computed, else why they cannot."""
    without = "VM and FM are not computed"
    if log.attitude is None:
        return None, [f"{without}: the log has no attitude (roll_deg, pitch_deg, yaw_deg)"]
    if aircraft.modules.geometry is None:
        return None, [f"{without}: {aircraft.name} has no modules.geometry"]
    return aircraft.modules.geometry, []


def tail_shading(
    aircraft: Aircraft, geometry: ModuleGeometry
) -> tuple[ShadedArea | None, str | None]:
    """Shading by the aircraft's tail, or why it is left out."""
    tail = aircraft.modules.tail
    if tail is None:
        return None, f"shading is not modelled: {aircraft.name} has no modules.tail"
    if any(surface.outline is None for surface in geometry.surfaces):
        return None, "shading is not modelled: a surface of modules.geometry has no outline"
    return lambda sun: np.asarray(shaded_area(geometry, tail, sun)), None


def lit_samples(
    log: FlightLog,
    aircraft: Aircraft,
    mission: Mission,
    geometry: ModuleGeometry | None,
    shade: ShadedArea | None,
) -> tuple[Samples, list[str]]:
    """Sunlit samples with all models on them, and where their temperatures are from.

    ``mission``: clearness, and temperatures that the log does not have. ``geometry``: surfaces for
    VM and FM; without, only CDM and CAM are computed.
    """
    sun = sun_position(log.time_s, log.latitude_deg, log.longitude_deg)
    index = np.flatnonzero(sun.elevation_rad > 0.0)
    if not len(index):
        highest = np.degrees(sun.elevation_rad.max())
        raise file_error(
            log.source,
            f"the sun never rises in this log (highest {highest:.1f} deg): there is no solar power "
            "to verify; are time_utc and longitude_deg right?",
        )
    ambient, source = _ambient_c(log, mission, index)
    module_c, module_source = _constant_module_c(log, mission, ambient)
    sunlit = _Lit(
        aircraft=aircraft,
        sky=mission.sky,
        clearness=mission.clearness,
        day=day_of_year(log.time_s[index]),
        latitude_deg=log.latitude_deg[index],
        altitude_m=log.altitude_m[index],
        sun=sun.vector_ned[index],
        attitude=None
        if geometry is None or log.attitude is None
        else np.stack(log.attitude)[:, index],
        ambient_c=ambient,
        module_c=module_c,
    )
    modelled, detail = _modelled(sunlit, geometry, shade)
    # Mean and true solar time differ by a quarter of an hour at most, and so decide the day.
    mean_h = log.time_s[index] / 3600.0 + log.longitude_deg[index] / 15.0
    bearing = np.zeros(len(index))
    if log.attitude is not None:
        bearing = np.degrees(sun.azimuth_rad[index] - log.attitude.yaw_rad[index]) % 360.0
    return (
        Samples(
            index=index,
            time_s=log.time_s[index],
            time_solar_h=sun.time_solar_h[index],
            solar_day=np.round((mean_h - sun.time_solar_h[index]) / 24.0).astype(int),
            run=numbered_runs(index, log.segment()[index]),
            elevation_deg=np.degrees(sun.elevation_rad[index]),
            bearing_deg=bearing,
            measured_w=log.solar_power_w[index],
            modelled_w=modelled,
            detail=detail,
        ),
        [source, module_source],
    )


@dataclass(frozen=True)
class _Lit:
    """Sunlit samples as the models need them; ``attitude`` has the rows roll, pitch, yaw."""

    aircraft: Aircraft
    sky: ClearSky
    clearness: float
    day: FloatArray
    latitude_deg: FloatArray
    altitude_m: FloatArray
    sun: FloatArray
    attitude: FloatArray | None
    ambient_c: FloatArray
    module_c: float

    def part(self, chunk: slice) -> _Lit:
        """Some of the samples."""
        arrays: dict[str, Any] = {
            n: v[..., chunk] for n, v in vars(self).items() if isinstance(v, np.ndarray)
        }
        return replace(self, **arrays | {"sun": self.sun[chunk]})

    def light(self) -> Irradiance:
        """Light of the sky, by the mission's clearness."""
        sky = self.sky(self.day, self.latitude_deg, -self.sun[:, 2], self.altitude_m)
        return Irradiance(*(self.clearness * part for part in sky))


def _ambient_c(log: FlightLog, mission: Mission, index: IntArray) -> tuple[FloatArray, str]:
    """Air temperature: of the log, else of the mission, else standard at the flown altitude."""
    given = mission.air.ambient_temperature_c
    if given is not None:
        other, name = np.full(len(index), given), f"{given:g} C of the mission"
    else:
        offset = mission.air.temperature_offset_k or 0.0
        flown = np.clip(log.altitude_m[index], MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M)
        other, name = standard_air(flown, offset).temperature_c, "standard air"
    if log.ambient_temperature_c is None:
        return other, f"ambient temperature: {name}"
    logged = log.ambient_temperature_c[index]
    missing = np.isnan(logged)
    rest = f", {name} in {missing.sum()} samples without" if missing.any() else ""
    return np.where(missing, other, logged), f"ambient temperature: logged{rest}"


def _constant_module_c(
    log: FlightLog, mission: Mission, ambient_c: FloatArray
) -> tuple[float, str]:
    """Constant module temperature of CDM, CAM and VM."""
    given = mission.air.module_temperature_c
    if given is not None:
        return given, f"constant module temperature: {given:g} C of the mission"
    mean = float(ambient_c.mean())
    return mean, f"constant module temperature: mean of the ambient one, {mean:.1f} C"


def numbered_runs(index: IntArray, segment: IntArray) -> IntArray:
    """Number stretches of consecutive places within one segment.

    ``segment``: number of the segment between gaps that each belongs to.
    """
    breaks = (np.diff(index) > 1) | (np.diff(segment) > 0)
    return np.concatenate(([0], np.cumsum(breaks))).astype(int)


def _modelled(
    sunlit: _Lit, geometry: ModuleGeometry | None, shade: ShadedArea | None
) -> tuple[dict[ModelName, FloatArray], Detail | None]:
    """All models, chunk by chunk: a long log times its surfaces would fill the memory."""
    chunks = [sunlit.part(slice(i, i + _CHUNK)) for i in range(0, len(sunlit.day), _CHUNK)]
    models = _concatenated([_horizontal(chunk) for chunk in chunks])
    if geometry is None:
        return models, None
    flown, details = zip(*(_with_attitude(c, geometry, shade) for c in chunks), strict=True)
    detail = details[0].mapped(lambda name, _: np.concatenate([getattr(d, name) for d in details]))
    return models | _concatenated(flown), detail


def _concatenated(parts: Sequence[dict[ModelName, FloatArray]]) -> dict[ModelName, FloatArray]:
    return {model: np.concatenate([part[model] for part in parts]) for model in parts[0]}


def _horizontal(sunlit: _Lit) -> dict[ModelName, FloatArray]:
    modules, light = sunlit.aircraft.modules, sunlit.light()
    given = (light, -sunlit.sun[:, 2], modules, sunlit.module_c)
    return {name: modules.area_m2 * model(*given) for name, model in HORIZONTAL_MODELS.items()}


def _with_attitude(
    sunlit: _Lit, geometry: ModuleGeometry, shade: ShadedArea | None
) -> tuple[dict[ModelName, FloatArray], Detail]:
    """Power of the models that know the attitude [W], and more of the Full Model."""
    assert sunlit.attitude is not None  # so is the geometry
    modules, light, shares = sunlit.aircraft.modules, sunlit.light(), geometry.area_shares
    to_ned = direction_cosines(*sunlit.attitude)
    given = (light, sunlit.sun, to_ned, geometry, modules)
    full = full_model(*given, sunlit.ambient_c, shading=modules.shading)
    power: dict[ModelName, FloatArray] = {
        "VM": modules.area_m2 * verification_model(*given, sunlit.module_c),
        "FM": modules.area_m2 * full.specific_power_w_per_m2,
    }
    shaded = lost = None
    if shade is not None:
        by_surface = shade(np.einsum("...ji,...j->...i", to_ned, sunlit.sun))
        shaded = by_surface.sum(axis=-1)
        lost = power["FM"] * _lost_share(full, light, by_surface, geometry, sunlit.aircraft)
    angles = np.degrees(np.arccos(np.clip(full.cos_aoi_by_surface, -1.0, 1.0)))
    return power, Detail(
        incidence_deg=angles @ shares,
        irradiance_w_per_m2=full.irradiance_w_per_m2,
        module_efficiency=full.module_efficiency,
        incidence_efficiency=full.incidence_efficiency_by_surface @ shares,
        low_light_efficiency=full.low_light_efficiency_by_surface @ shares,
        temperature_efficiency=full.temperature_efficiency,
        mppt_efficiency=full.mppt_efficiency,
        module_temperature_c=full.module_temperature_c,
        shaded_m2=shaded,
        shading_loss_w=lost,
    )


def _lost_share(
    full: ModulePower,
    light: Irradiance,
    shaded_m2: FloatArray,
    geometry: ModuleGeometry,
    aircraft: Aircraft,
) -> FloatArray:
    """Share of the useful light that shadows take if they cost their area of direct light."""
    cell, shares = aircraft.modules, geometry.area_shares
    diffuse = light.dhi[:, np.newaxis]
    direct = full.irradiance_by_surface_w_per_m2 - diffuse
    useful = direct * full.incidence_efficiency_by_surface * cell.camber_efficiency
    total = (useful + diffuse * cell.diffuse_efficiency) @ shares
    covered = shaded_m2 / np.array([surface.area_m2 for surface in geometry.surfaces])
    return np.asarray((useful * covered) @ shares / np.maximum(total, 1e-12))
