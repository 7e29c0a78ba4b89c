"""Solar power models on the samples of a flight log.

Every sample with the sun above the horizon gets the power of all models that the log and the
aircraft allow: VM and FM need the attitude and the module surfaces.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from missions.files.errors import file_error
from missions.logs.table import FlightLog
from sizing.aircraft import Aircraft
from solar.attitude_models import verification_model
from solar.geometry import ModuleGeometry
from solar.horizontal_models import HORIZONTAL_MODELS
from solar.names import ModelName
from solar.shading import shaded_area
from solar.sun import sun_position
from solar.types import FloatArray, IntArray
from studies.flight_logs.forward import Forward, ShadedArea


class Detail(NamedTuple):
    """What the Full Model says beside the power, averaged over the surfaces by area.

    Angles in degrees, temperatures in degrees Celsius, irradiance on the modules in W/m2; relative
    efficiencies. ``shaded_m2`` is the shaded module area, None without a tail.
    """

    incidence_deg: FloatArray
    irradiance_w_per_m2: FloatArray
    module_efficiency: FloatArray
    mppt_efficiency: FloatArray
    module_temperature_c: FloatArray
    shaded_m2: FloatArray | None


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

    @property
    def best_model(self) -> ModelName:
        """The most detailed model of those that could be computed."""
        return list(self.modelled_w)[-1]


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


def lit_samples(forward: Forward) -> tuple[Samples, list[str]]:
    """Sunlit samples with all models on them, and where their temperatures are from."""
    log = forward.log
    sun = sun_position(log.time_s, log.latitude_deg, log.longitude_deg)
    index = np.flatnonzero(sun.elevation_rad > 0.0)
    if not len(index):
        highest = np.degrees(sun.elevation_rad.max())
        raise file_error(
            log.source,
            f"the sun never rises in this log (highest {highest:.1f} deg): there is no solar power "
            "to verify; are time_utc and longitude_deg right? --clock-offset corrects a clock",
        )
    lit = forward.of(index)
    modelled, detail = _modelled(lit)
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
        [lit.ambient_c()[1], lit.module_c()[1]],
    )


def numbered_runs(index: IntArray, segment: IntArray) -> IntArray:
    """Number stretches of consecutive places within one segment between gaps."""
    breaks = (np.diff(index) > 1) | (np.diff(segment) > 0)
    return np.concatenate(([0], np.cumsum(breaks))).astype(int)


def _modelled(lit: Forward) -> tuple[dict[ModelName, FloatArray], Detail | None]:
    """All models on sunlit samples."""
    module_c = lit.module_c()[0]  # of all of them
    parts, details = zip(*(_of_chunk(chunk, module_c) for chunk in lit.chunks()), strict=True)
    power = {model: np.concatenate([part[model] for part in parts]) for model in parts[0]}
    if details[0] is None:
        return power, None
    columns = zip(*details, strict=True)
    joined: list[Any] = [None if c[0] is None else np.concatenate(c) for c in columns]
    return power, Detail(*joined)


def _of_chunk(lit: Forward, module_c: float) -> tuple[dict[ModelName, FloatArray], Detail | None]:
    """Power of the models [W], and more of the Full Model."""
    modules, geometry, given = lit.aircraft.modules, lit.geometry, lit.sunlight()
    power: dict[ModelName, FloatArray] = {
        name: modules.area_m2 * model(given.light, given.sine, modules, module_c)
        for name, model in HORIZONTAL_MODELS.items()
    }
    if geometry is None or given.to_ned is None:
        return power, None
    full, shares = lit.full(given), geometry.area_shares
    level = verification_model(
        *(given.light, given.sun.vector_ned, given.to_ned), geometry, modules, module_c
    )
    power |= {"VM": modules.area_m2 * level, "FM": modules.area_m2 * full.specific_power_w_per_m2}
    angles = np.degrees(np.arccos(np.clip(full.cos_aoi_by_surface, -1.0, 1.0)))
    return power, Detail(
        incidence_deg=angles @ shares,
        irradiance_w_per_m2=full.irradiance_w_per_m2,
        module_efficiency=full.module_efficiency,
        mppt_efficiency=full.mppt_efficiency,
        module_temperature_c=full.module_temperature_c,
        shaded_m2=None if lit.shade is None else given.shaded_m2(lit.shade).sum(axis=-1),
    )
