"""Modelled power of a log's samples if its clock, angles or position were off."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M, standard_air
from missions.logs.table import EulerAngles, FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from solar.attitude_models import ModulePower, full_model
from solar.clearsky import Irradiance, extraterrestrial_irradiance
from solar.geometry import ModuleGeometry, direction_cosines
from solar.horizontal_models import conceptual_analysis_model
from solar.sun import SECONDS_PER_DAY, SunPosition, sun_position
from solar.types import FloatArray, IntArray

ShadedArea: TypeAlias = Callable[[FloatArray], FloatArray]
"""Shaded area of every module surface [m2] from sun vectors in body axes."""

# Kasten, F., Young, A. T. (1989), Applied Optics 28(22), 4735-4738; below the horizon its limit.
_LEAST_ELEVATION_DEG = 1.0


def day_of_year(time_s: FloatArray) -> FloatArray:
    """Fractional day of year, 1.0 at the start of 1 January (UTC)."""
    instants = np.asarray(time_s).astype("datetime64[s]")
    years = instants.astype("datetime64[Y]").astype("datetime64[s]")
    return np.asarray(1.0 + (np.asarray(time_s) - years.astype(np.int64)) / SECONDS_PER_DAY, float)


@dataclass(frozen=True)
class LogError:
    """What is wrong with a log: clock ahead [s], angles too large [rad], channels of wrong sign.

    ``signs`` has some of ``roll``, ``pitch``, ``yaw`` and ``longitude``; the power is ``factor``
    times that in watts.
    """

    clock_s: float = 0.0
    heading: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    signs: frozenset[str] = frozenset()
    factor: float = 1.0

    def plus(self, changes: Mapping[str, Any]) -> LogError:
        """The same with some numbers larger by so much, or by so much in each sample."""
        return replace(self, **{name: getattr(self, name) + v for name, v in changes.items()})

    def near(self, other: LogError, steps: Mapping[str, float]) -> bool:
        """Whether some numbers of another are no further away than these steps."""
        return all(abs(getattr(self, n) - getattr(other, n)) <= step for n, step in steps.items())

    def sign(self, channel: str) -> float:
        """-1 for a channel of wrong sign."""
        return -1.0 if channel in self.signs else 1.0

    def angles(self, roll: FloatArray, pitch: FloatArray, yaw: FloatArray) -> EulerAngles:
        """True angles of logged ones."""
        return EulerAngles(
            self.sign("roll") * roll - self.roll,
            self.sign("pitch") * pitch - self.pitch,
            self.sign("yaw") * yaw - self.heading,
        )

    def removed(self, log: FlightLog) -> FlightLog:
        """Log without this error."""
        changes: dict[str, Any] = {
            "solar_power_w": log.solar_power_w / self.factor,
            "tracker_power_w": {n: v / self.factor for n, v in log.tracker_power_w.items()},
            "longitude_deg": self.sign("longitude") * log.longitude_deg,
        }
        if log.attitude is not None:
            changes["attitude"] = self.angles(*log.attitude)
        if ahead := self.clock_s:
            changes["time_s"] = log.time_s - ahead
            changes["gaps"] = tuple(
                gap._replace(start_s=gap.start_s - ahead, end_s=gap.end_s - ahead)
                for gap in log.gaps
            )
            changes["left_out"] = tuple(one.earlier(ahead) for one in log.left_out)
        return replace(log, **changes)


class Parts(NamedTuple):
    """Power of each surface [W] from direct and from diffuse light, shape (samples, surfaces).

    ``cosine`` of the angle of incidence, relative ``air_mass``, ``bearing`` of the sun from the
    nose [rad], ``light`` on the modules [W/m2], ``beam_over_diffuse`` on the horizontal, and the
    share ``passed`` of the direct light outside the atmosphere.
    """

    direct: FloatArray
    diffuse: FloatArray
    cosine: FloatArray
    air_mass: FloatArray
    bearing: FloatArray
    light: FloatArray
    beam_over_diffuse: FloatArray
    passed: FloatArray

    @property
    def power(self) -> FloatArray:
        """Power of all surfaces [W]."""
        return np.asarray((self.direct + self.diffuse).sum(axis=1))


class Sunlight(NamedTuple):
    """Sun, clear sky, rotation from body axes and heading [rad] of some samples."""

    sun: SunPosition
    light: Irradiance
    to_ned: FloatArray | None
    yaw: FloatArray

    @property
    def sine(self) -> FloatArray:
        """Sine of the sun's elevation, zero below the horizon."""
        return np.maximum(-self.sun.vector_ned[:, 2], 0.0)

    def shaded_m2(self, shade: ShadedArea) -> FloatArray:
        """Area of each surface in the shadow of the tail [m2]."""
        assert self.to_ned is not None  # so is the geometry
        return shade(np.einsum("...ji,...j->...i", self.to_ned, self.sun.vector_ned))


# Samples handled at once: a long log times its surfaces would fill the memory.
_CHUNK = 16_384


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

    def sunlight(self, error: LogError) -> Sunlight:
        """Sun, sky and attitude if the log has such an error."""
        log, index = self.log, self.index
        time_s, latitude = log.time_s[index] - error.clock_s, log.latitude_deg[index]
        sun = sun_position(time_s, latitude, error.sign("longitude") * log.longitude_deg[index])
        sine = np.maximum(-sun.vector_ned[:, 2], 0.0)
        sky = self.mission.sky(day_of_year(time_s), latitude, sine, log.altitude_m[index])
        light = Irradiance(*(self.mission.clearness * part for part in sky))
        if self.geometry is None or log.attitude is None:
            return Sunlight(sun, light, None, np.zeros(len(index)))
        angles = error.angles(*(a[index] for a in log.attitude))
        return Sunlight(sun, light, direction_cosines(*angles), angles.yaw_rad)

    def full(self, given: Sunlight, ambient_c: FloatArray | None = None) -> ModulePower:
        """The Full Model in some sunlight, and at another temperature of the air."""
        assert self.geometry is not None
        assert given.to_ned is not None  # the caller checked
        return full_model(
            *(given.light, given.sun.vector_ned, given.to_ned, self.geometry),
            *(self.aircraft.modules, self.ambient_c()[0] if ambient_c is None else ambient_c),
            shading=self.aircraft.modules.shading,
        )

    def parts(self, error: LogError) -> Parts:
        """Power of all surfaces if the log has such an error."""
        modules, given = self.aircraft.modules, self.sunlight(error)
        light, sine = given.light, given.sine
        up = given.sun.elevation_rad > 0.0
        height = np.maximum(np.degrees(given.sun.elevation_rad), _LEAST_ELEVATION_DEG)
        mass = 1.0 / (np.sin(np.radians(height)) + 0.50572 * (height + 6.07995) ** -1.6364)
        bearing = given.sun.azimuth_rad - given.yaw
        if given.to_ned is None:
            whole = conceptual_analysis_model(light, sine, modules, self.module_c()[0])
            beam, rest = (light.dni * sine)[:, np.newaxis], np.asarray(light.dhi)[:, np.newaxis]
            cosine, falling = sine[:, np.newaxis], light.dni * sine + light.dhi
        else:
            full = self.full(given)
            whole = full.specific_power_w_per_m2
            beam, rest = self._useful(full, light)
            cosine, falling = full.cos_aoi_by_surface, full.irradiance_w_per_m2
        share = np.where(up, modules.area_m2 * whole, 0.0) / np.maximum((beam + rest).sum(1), 1e-9)
        scale = share[:, np.newaxis]
        falling = np.where(up, falling, 0.0)
        ratio = light.dni * sine / np.maximum(light.dhi, 1e-9)
        day = day_of_year(self.log.time_s[self.index] - error.clock_s)
        passed = light.dni / extraterrestrial_irradiance(day)
        return Parts(scale * beam, scale * rest, cosine, mass, bearing, falling, ratio, passed)

    def _useful(self, full: ModulePower, light: Irradiance) -> tuple[FloatArray, FloatArray]:
        """Light of each surface that becomes power, direct and diffuse, by their areas."""
        assert self.geometry is not None
        modules, diffuse = self.aircraft.modules, np.asarray(light.dhi)[:, np.newaxis]
        efficiency = full.low_light_efficiency_by_surface * self.geometry.area_shares
        beam = (full.irradiance_by_surface_w_per_m2 - diffuse) * modules.camber_efficiency
        beam = beam * full.incidence_efficiency_by_surface * efficiency
        return beam, diffuse * modules.diffuse_efficiency * efficiency

    def shadowed(self, error: LogError) -> FloatArray | None:
        """Share of each surface in the shadow of the tail."""
        if self.shade is None or self.geometry is None or self.log.attitude is None:
            return None
        covered = self.sunlight(error).shaded_m2(self.shade)
        return np.asarray(covered / np.array([one.area_m2 for one in self.geometry.surfaces]))
