"""Modelled power of a log's samples if clock, attitude or sky were a little different."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

import numpy as np

from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M, standard_air
from missions.logs.table import FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from solar.attitude_models import ModulePower, full_model
from solar.clearsky import Irradiance
from solar.geometry import ModuleGeometry, direction_cosines
from solar.horizontal_models import conceptual_analysis_model
from solar.sun import SECONDS_PER_DAY, SunPosition, sun_position
from solar.types import FloatArray, IntArray

ShadedArea: TypeAlias = Callable[[FloatArray], FloatArray]
"""Shaded area of every module surface [m2] from sun vectors in body axes."""

# Kasten, F., Young, A. T. (1989), Applied Optics 28(22), 4735-4738; below the horizon its limit.
_LEAST_ELEVATION_DEG = 1.0
# Of the light that haze takes from the beam, 0.9 are scattered, and 0.84 of that forwards: Bird,
# R. E., Hulstrom, R. L. (1981), SERI/TR-642-761.
_SCATTERED_DOWN = 0.9 * 0.84
# Samples handled at once: a long log times its surfaces would fill the memory.
_CHUNK = 16_384
_LEAST_COSINE = 0.17  # 80 deg: beyond, hardly any direct light is left


class Offsets(NamedTuple):
    """How much the logged clock is ahead [s] and the logged angles are too large [rad].

    What the model may be off by: ``haze``: extinction per air mass beyond the sky's [-].
    ``diffuse``: logarithm of diffuse light over the sky's. ``incidence``: direct light lost per
    ``1/cos(angle of incidence) - 1``. ``low_light``: power gained per logarithm of the light over
    1000 W/m2. ``drift``: of the power sensor from the middle of the log to its end.
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
    """Sun, clear sky and rotation from body axes of some samples."""

    sun: SunPosition
    light: Irradiance
    to_ned: FloatArray | None

    @property
    def sine(self) -> FloatArray:
        """Sine of the sun's elevation, zero below the horizon."""
        return np.maximum(-self.sun.vector_ned[:, 2], 0.0)

    def shaded_m2(self, shade: ShadedArea) -> FloatArray:
        """Area of each surface in the shadow of the tail [m2]."""
        assert self.to_ned is not None  # so is the geometry
        return shade(np.einsum("...ji,...j->...i", self.to_ned, self.sun.vector_ned))


@dataclass(frozen=True)
class Forward:
    """The Full Model, or CAM without attitude or module surfaces, at some samples of a log."""

    log: FlightLog
    aircraft: Aircraft
    mission: Mission
    geometry: ModuleGeometry | None
    shade: ShadedArea | None
    index: IntArray

    def of(self, index: IntArray) -> Forward:
        """The same at other samples."""
        return replace(self, index=index)

    @property
    def knows_angles(self) -> bool:
        """Whether the power depends on the attitude."""
        return self.geometry is not None and self.log.attitude is not None

    def chunks(self) -> Iterator[Forward]:
        """The same in parts that fit into the memory."""
        for start in range(0, len(self.index), _CHUNK):
            yield self.of(self.index[start : start + _CHUNK])

    def ambient_c(self) -> tuple[FloatArray, str]:
        """Air temperature: of the log, else of the mission, else standard; and which it is."""
        air, altitude = self.mission.air, self.log.altitude_m[self.index]
        flown = np.clip(altitude, MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M)
        if air.ambient_temperature_c is not None:
            other = np.full(len(flown), air.ambient_temperature_c)
            name = f"{air.ambient_temperature_c:g} C of the mission"
        else:
            other = standard_air(flown, air.temperature_offset_k or 0.0).temperature_c
            name = "standard air"
        if self.log.ambient_temperature_c is None:
            return other, f"ambient temperature: {name}"
        logged = self.log.ambient_temperature_c[self.index]
        missing = np.isnan(logged)
        rest = f", {name} in {missing.sum()} samples without" if missing.any() else ""
        return np.where(missing, other, logged), f"ambient temperature: logged{rest}"

    def module_c(self) -> tuple[float, str]:
        """Constant module temperature of CDM, CAM and VM, and where it is from."""
        given = self.mission.air.module_temperature_c
        if given is not None:
            return given, f"constant module temperature: {given:g} C of the mission"
        mean = float(self.ambient_c()[0].mean())
        return mean, f"constant module temperature: mean of the ambient one, {mean:.1f} C"

    def sunlight(self, offsets: Offsets = AS_LOGGED) -> Sunlight:
        """Sun, sky and attitude without some offsets of the log."""
        log, index = self.log, self.index
        time_s, latitude = log.time_s[index] - offsets.clock_s, log.latitude_deg[index]
        sun = sun_position(time_s, latitude, log.longitude_deg[index])
        sine = np.maximum(-sun.vector_ned[:, 2], 0.0)
        sky = self.mission.sky(_day_of_year(time_s), latitude, sine, log.altitude_m[index])
        light = Irradiance(*(self.mission.clearness * part for part in sky))
        if offsets.haze or offsets.diffuse:
            light = _other_sky(light, sun, sine, offsets)
        if self.geometry is None or log.attitude is None:
            return Sunlight(sun, light, None)
        roll, pitch, yaw = (angle[index] for angle in log.attitude)
        angles = (roll - offsets.roll, pitch - offsets.pitch, yaw - offsets.heading)
        return Sunlight(sun, light, direction_cosines(*angles))

    def full(self, given: Sunlight) -> ModulePower:
        """The Full Model in some sunlight."""
        assert self.geometry is not None
        assert given.to_ned is not None  # the caller checked
        return full_model(
            *(given.light, given.sun.vector_ned, given.to_ned, self.geometry),
            *(self.aircraft.modules, self.ambient_c()[0]),
            shading=self.aircraft.modules.shading,
        )

    def power_w(self, offsets: Offsets = AS_LOGGED) -> FloatArray:
        """Power of all modules without some offsets of the log [W]."""
        modules, given = self.aircraft.modules, self.sunlight(offsets)
        if given.to_ned is None:
            module_c = self.module_c()[0]
            specific = conceptual_analysis_model(given.light, given.sine, modules, module_c)
            cosine, falling = given.sine, given.light.dni * given.sine + given.light.dhi
        else:
            assert self.geometry is not None
            full = self.full(given)
            specific, falling = full.specific_power_w_per_m2, full.irradiance_w_per_m2
            cosine = full.cos_aoi_by_surface @ self.geometry.area_shares
        if offsets.incidence or offsets.low_light:
            beam = given.light.dni * cosine / np.maximum(falling, 1e-9)
            lost = offsets.incidence * (1.0 / np.maximum(cosine, _LEAST_COSINE) - 1.0) * beam
            gained = offsets.low_light * np.log(np.maximum(falling, 1.0) / 1000.0)
            specific = specific * (1.0 - lost + gained)
        if offsets.drift:
            start_s, end_s = self.log.time_s[[0, -1]]
            course = 2.0 * (self.log.time_s[self.index] - start_s) / (end_s - start_s) - 1.0
            specific = specific * (1.0 + offsets.drift * course)
        return np.where(given.sun.elevation_rad > 0.0, modules.area_m2 * specific, 0.0)

    def power_by_surface_w(self) -> FloatArray:
        """Power of each module surface, by the light that becomes power [W]."""
        assert self.geometry is not None
        modules, given = self.aircraft.modules, self.sunlight()
        full, diffuse = self.full(given), np.asarray(given.light.dhi)[:, np.newaxis]
        beam = (full.irradiance_by_surface_w_per_m2 - diffuse) * modules.camber_efficiency
        useful = beam * full.incidence_efficiency_by_surface + diffuse * modules.diffuse_efficiency
        useful = useful * full.low_light_efficiency_by_surface * self.geometry.area_shares
        power = modules.area_m2 * np.asarray(full.specific_power_w_per_m2)[:, np.newaxis]
        return np.asarray(power * useful / np.maximum(useful.sum(axis=1, keepdims=True), 1e-9))


def _other_sky(
    light: Irradiance, sun: SunPosition, sine: FloatArray, offsets: Offsets
) -> Irradiance:
    """Light of a sky with more haze; most of what the beam loses comes down diffuse."""
    height = np.maximum(np.degrees(sun.elevation_rad), _LEAST_ELEVATION_DEG)
    mass = 1.0 / (np.sin(np.radians(height)) + 0.50572 * (height + 6.07995) ** -1.6364)
    dni = light.dni * np.exp(-offsets.haze * mass)
    scattered = _SCATTERED_DOWN * (light.dni - dni) * sine
    dhi = np.maximum(light.dhi + scattered, 0.1 * light.dhi) * np.exp(offsets.diffuse)
    return Irradiance(dni, dhi)


def _day_of_year(time_s: FloatArray) -> FloatArray:
    """Fractional day of year, 1.0 at the start of 1 January (UTC)."""
    instants = np.asarray(time_s).astype("datetime64[s]")
    years = instants.astype("datetime64[Y]").astype("datetime64[s]")
    return np.asarray(1.0 + (np.asarray(time_s) - years.astype(np.int64)) / SECONDS_PER_DAY, float)
