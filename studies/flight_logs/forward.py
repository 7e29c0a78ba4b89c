"""Solar power models at the samples of a log, also with offsets of clock, attitude and sky.

Every sample with the sun above the horizon gets the power of all models that the log and the
aircraft allow: VM and FM need the attitude and the module surfaces.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M, standard_air
from missions.files.errors import file_error
from missions.logs.table import FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from solar.attitude_models import ModulePower, full_model, verification_model
from solar.clearsky import Irradiance
from solar.geometry import ModuleGeometry, direction_cosines
from solar.horizontal_models import HORIZONTAL_MODELS, conceptual_analysis_model
from solar.names import MODELS, ModelName
from solar.schema import spell
from solar.sun import SECONDS_PER_DAY, SunPosition, sun_position
from solar.types import FloatArray, IntArray

# Kasten, F., Young, A. T. (1989), Applied Optics 28(22), 4735-4738; below the horizon its limit.
_LEAST_ELEVATION_DEG = 1.0
# Of the light that haze takes from the beam, 0.9 are scattered, and 0.84 of that forwards: Bird,
# R. E., Hulstrom, R. L. (1981), SERI/TR-642-761.
_SCATTERED_DOWN = 0.9 * 0.84
# Samples computed at once: a long log times its surfaces would fill the memory.
_CHUNK = 16_384
_LEAST_COSINE = 0.17  # 80 deg: beyond, hardly any direct light is left


class Offsets(NamedTuple):
    """Errors of the log, clock ahead [s] and angles too large [rad], and of the model [-].

    ``haze``: extinction per air mass beyond the sky's. ``diffuse``: logarithm of diffuse light over
    the sky's. ``incidence``: direct light lost per ``1/cos(angle of incidence) - 1``.
    ``low_light``: power gained per logarithm of the light over 1000 W/m2. ``drift``: of the power
    sensor from the middle of the log to its end.
    """

    clock_s: float | FloatArray = 0.0
    heading: float | FloatArray = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    haze: float = 0.0
    diffuse: float = 0.0
    incidence: float = 0.0
    low_light: float = 0.0
    drift: float = 0.0


AS_LOGGED = Offsets()


class Sunlight(NamedTuple):
    """Sun, clear sky, sine of elevation (zero at night) and rotation from body axes, by sample."""

    sun: SunPosition
    light: Irradiance
    sine: FloatArray
    to_ned: FloatArray | None


@dataclass(frozen=True)
class Forward:
    """Full Model, or CAM without attitude or module surfaces, at some samples of a log."""

    log: FlightLog
    aircraft: Aircraft
    mission: Mission
    index: IntArray

    @property
    def geometry(self) -> ModuleGeometry | None:
        """Module surfaces of the aircraft, None without."""
        return self.aircraft.modules.geometry

    def of(self, index: IntArray) -> Forward:
        """Return the model at other samples."""
        return replace(self, index=index)

    @property
    def measured_w(self) -> FloatArray:
        """Measured solar power [W]."""
        return self.log.solar_power_w[self.index]

    @property
    def knows_angles(self) -> bool:
        """True if the power depends on the attitude."""
        return self.geometry is not None and self.log.attitude is not None

    def chunks(self) -> Iterator[Forward]:
        """Yield the model at parts of the samples that fit into the memory."""
        for start in range(0, len(self.index), _CHUNK):
            yield self.of(self.index[start : start + _CHUNK])

    def ambient_c(self) -> tuple[FloatArray, str]:
        """Return the air temperature [C], of the log, else the mission, and its source."""
        air, logged_m = self.mission.air, self.log.altitude_m[self.index]
        altitude_m = np.clip(logged_m, MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M)
        if air.ambient_temperature_c is not None:
            other = np.full(len(altitude_m), air.ambient_temperature_c)
            name = f"{spell(air.ambient_temperature_c)} C of the mission"
        else:
            other = standard_air(altitude_m, air.temperature_offset_k or 0.0).temperature_c
            name = "standard air"
        if self.log.ambient_temperature_c is None:
            return other, f"ambient temperature: {name}"
        logged = self.log.ambient_temperature_c[self.index]
        missing = np.isnan(logged)
        rest = f", {name} in {missing.sum()} samples without" if missing.any() else ""
        return np.where(missing, other, logged), f"ambient temperature: logged{rest}"

    def module_c(self) -> tuple[float, str]:
        """Return the constant module temperature [C] of CDM, CAM and VM, and its source."""
        mission_c = self.mission.air.module_temperature_c
        if mission_c is not None:
            return mission_c, f"constant module temperature: {spell(mission_c)} C of the mission"
        mean = float(self.ambient_c()[0].mean())
        return mean, f"constant module temperature: mean of the ambient one, {mean:.1f} C"

    def sunlight(self, offsets: Offsets = AS_LOGGED) -> Sunlight:
        """Compute sun, sky and attitude with offsets of the log subtracted."""
        log, index = self.log, self.index
        time_s, latitude = log.time_s[index] - offsets.clock_s, log.latitude_deg[index]
        sun = sun_position(time_s, latitude, log.longitude_deg[index])
        sine = np.maximum(-sun.vector_ned[:, 2], 0.0)
        instants = time_s.astype("datetime64[s]")
        years = instants.astype("datetime64[Y]").astype("datetime64[s]").astype(np.int64)
        day_of_year = 1.0 + (time_s - years) / SECONDS_PER_DAY  # 1.0 at the start of 1 January
        sky = self.mission.sky(day_of_year, latitude, sine, log.altitude_m[index])
        light = Irradiance(self.mission.clearness * sky.dni, self.mission.clearness * sky.dhi)
        if offsets.haze or offsets.diffuse:
            # Most of the direct light lost by more haze comes down diffuse.
            height = np.maximum(np.degrees(sun.elevation_rad), _LEAST_ELEVATION_DEG)
            mass = 1.0 / (np.sin(np.radians(height)) + 0.50572 * (height + 6.07995) ** -1.6364)
            dni = light.dni * np.exp(-offsets.haze * mass)
            dhi = light.dhi + _SCATTERED_DOWN * (light.dni - dni) * sine
            light = Irradiance(dni, np.maximum(dhi, 0.1 * light.dhi) * np.exp(offsets.diffuse))
        if log.attitude is None or not self.knows_angles:
            return Sunlight(sun, light, sine, None)
        roll, pitch, yaw = (angle[index] for angle in log.attitude)
        angles = (roll - offsets.roll, pitch - offsets.pitch, yaw - offsets.heading)
        return Sunlight(sun, light, sine, direction_cosines(*angles))

    def full(self, sunlight: Sunlight) -> ModulePower:
        """Compute the Full Model."""
        assert self.geometry is not None
        assert sunlight.to_ned is not None  # the caller checked
        return full_model(
            sunlight.light,
            sunlight.sun.vector_ned,
            sunlight.to_ned,
            self.geometry,
            self.aircraft.modules,
            self.ambient_c()[0],
            shading=self.aircraft.modules.shading,
        )

    def power_w(self, offsets: Offsets = AS_LOGGED) -> FloatArray:
        """Compute the power of all modules with offsets of the log subtracted [W]."""
        if len(self.index) > _CHUNK:
            return np.concatenate([part.power_w(offsets) for part in self.chunks()])
        modules, sunlight = self.aircraft.modules, self.sunlight(offsets)
        if sunlight.to_ned is None:
            module_c = self.module_c()[0]
            specific = conceptual_analysis_model(sunlight.light, sunlight.sine, modules, module_c)
            cosine, falling = sunlight.sine, sunlight.light.dni * sunlight.sine + sunlight.light.dhi
        else:
            assert self.geometry is not None
            full = self.full(sunlight)
            specific, falling = full.specific_power_w_per_m2, full.irradiance_w_per_m2
            cosine = full.cos_aoi_by_surface @ self.geometry.area_shares
        if offsets.incidence or offsets.low_light:
            beam = sunlight.light.dni * cosine / np.maximum(falling, 1e-9)
            lost = offsets.incidence * (1.0 / np.maximum(cosine, _LEAST_COSINE) - 1.0) * beam
            gained = offsets.low_light * np.log(np.maximum(falling, 1.0) / 1000.0)
            specific = specific * (1.0 - lost + gained)
        if offsets.drift:
            start_s, end_s = self.log.time_s[[0, -1]]
            course = 2.0 * (self.log.time_s[self.index] - start_s) / (end_s - start_s) - 1.0
            specific = specific * (1.0 + offsets.drift * course)
        return np.where(sunlight.sun.elevation_rad > 0.0, modules.area_m2 * specific, 0.0)

    def power_by_surface_w(self) -> FloatArray:
        """Compute the power of each module surface [W], shape ``(sample, surface)``."""
        assert self.geometry is not None
        modules, sunlight = self.aircraft.modules, self.sunlight()
        full, diffuse = self.full(sunlight), np.asarray(sunlight.light.dhi)[:, np.newaxis]
        beam = (full.irradiance_by_surface_w_per_m2 - diffuse) * modules.camber_efficiency
        useful = beam * full.incidence_efficiency_by_surface + diffuse * modules.diffuse_efficiency
        useful = useful * full.low_light_efficiency_by_surface * self.geometry.area_shares
        power = modules.area_m2 * np.asarray(full.specific_power_w_per_m2)[:, np.newaxis]
        return np.asarray(power * useful / np.maximum(useful.sum(axis=1, keepdims=True), 1e-9))


@dataclass(frozen=True)
class Samples:
    """Samples of a log with the sun above the horizon, and all models on them.

    ``index``: indices in the log. ``time_s``, ``time_solar_h``: universal time [s since 1970] and
    true solar time [h]. ``solar_day``: day by local solar time, days since 1970-01-01. ``run``:
    number of the stretch without gap or night. ``elevation_deg``, ``bearing_deg``: the sun's
    elevation, and its bearing from the nose, clockwise, 0 to 360, zero without attitude.
    ``modelled_w``: power of each computed model. ``detail``: mean angle of incidence, light and
    module temperature of the Full Model; empty without it.
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
    detail: Mapping[str, FloatArray]

    @property
    def models(self) -> list[ModelName]:
        """Computed models, the most detailed last."""
        return list(self.modelled_w)

    @property
    def best_model(self) -> ModelName:
        """Most detailed of the computed models."""
        return self.models[-1]


def daylight_samples(forward: Forward) -> tuple[Samples, list[str]]:
    """Compute all models at samples with the sun up; return them and notes on the models."""
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
    daylight = forward.of(index)
    module_c, of_modules = daylight.module_c()  # of all chunks
    parts = [_compute_chunk(chunk, module_c) for chunk in daylight.chunks()]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    modelled: dict[ModelName, FloatArray] = {m: columns.pop(m) for m in MODELS if m in columns}
    # Mean and true solar time differ by a quarter of an hour at most, and so decide the day.
    mean_h = log.time_s[index] / 3600.0 + log.longitude_deg[index] / 15.0
    bearing = np.zeros(len(index))
    if log.attitude is not None:
        bearing = np.degrees(sun.azimuth_rad[index] - log.attitude.yaw_rad[index]) % 360.0
    samples = Samples(
        index=index,
        time_s=log.time_s[index],
        time_solar_h=sun.time_solar_h[index],
        solar_day=np.round((mean_h - sun.time_solar_h[index]) / 24.0).astype(int),
        run=numbered_runs(index, log.segment()[index]),
        elevation_deg=np.degrees(sun.elevation_rad[index]),
        bearing_deg=bearing,
        measured_w=daylight.measured_w,
        modelled_w=modelled,
        detail=columns,
    )
    modules, name, missing = forward.aircraft.modules, forward.aircraft.name, []
    if log.attitude is None:
        lacking = "the log has no attitude (roll_deg, pitch_deg, yaw_deg)"
        missing = [f"VM and FM are not computed: {lacking}"]
    elif modules.geometry is None:
        missing = [f"VM and FM are not computed: {name} has no modules.geometry"]
    elif modules.tail is None:
        missing = [f"shading is not modelled: {name} has no modules.tail"]
    return samples, [*missing, daylight.ambient_c()[1], of_modules]


def numbered_runs(index: IntArray, segment: IntArray) -> IntArray:
    """Number stretches of consecutive places within one segment between gaps."""
    breaks = (np.diff(index) > 1) | (np.diff(segment) > 0)
    return np.concatenate(([0], np.cumsum(breaks))).astype(int)


def _compute_chunk(chunk: Forward, module_c: float) -> dict[str, FloatArray]:
    """Compute the power of the models by their names [W], and details of the Full Model."""
    modules, geometry, sunlight = chunk.aircraft.modules, chunk.geometry, chunk.sunlight()
    power: dict[str, FloatArray] = {
        name: modules.area_m2 * model(sunlight.light, sunlight.sine, modules, module_c)
        for name, model in HORIZONTAL_MODELS.items()
    }
    if geometry is None or sunlight.to_ned is None:
        return power
    full = chunk.full(sunlight)
    level = verification_model(
        sunlight.light, sunlight.sun.vector_ned, sunlight.to_ned, geometry, modules, module_c
    )
    angles = np.degrees(np.arccos(np.clip(full.cos_aoi_by_surface, -1.0, 1.0)))
    return power | {
        "VM": modules.area_m2 * level,
        "FM": modules.area_m2 * full.specific_power_w_per_m2,
        "angle_of_incidence_deg": angles @ geometry.area_shares,
        "irradiance_w_per_m2": full.irradiance_w_per_m2,
        "module_temperature_c": full.module_temperature_c,
    }
