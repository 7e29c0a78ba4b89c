"""Modelled power of a log's samples if its clock, angles or position were off."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M, standard_air
from missions.logs.table import EulerAngles, FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from solar.attitude import direction_cosines
from solar.attitude_models import full_model
from solar.clearsky import Irradiance
from solar.geometry import ModuleGeometry
from solar.horizontal_models import conceptual_analysis_model
from solar.sun import sun_position
from solar.types import FloatArray, IntArray
from studies.flight_logs.samples import ShadedArea, day_of_year

# Kasten, F., Young, A. T. (1989), Applied Optics 28(22), 4735-4738; below the horizon its limit.
_LEAST_ELEVATION_DEG = 1.0


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

    def plus(self, changes: dict[str, float]) -> LogError:
        """The same with some numbers larger by so much."""
        return replace(self, **{name: getattr(self, name) + v for name, v in changes.items()})

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
        return replace(log, **changes)


class Parts(NamedTuple):
    """Power of each surface [W] from direct and from diffuse light, shape (samples, surfaces).

    ``cosine`` of the angle of incidence, relative ``air_mass``, ``bearing`` of the sun from the
    nose [rad], and ``light`` on the modules [W/m2].
    """

    direct: FloatArray
    diffuse: FloatArray
    cosine: FloatArray
    air_mass: FloatArray
    bearing: FloatArray
    light: FloatArray

    @property
    def power(self) -> FloatArray:
        """Power of all surfaces [W]."""
        return np.asarray((self.direct + self.diffuse).sum(axis=1))


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

    def shadow_w(self, error: LogError) -> FloatArray | None:
        """Power that the tail's shadow takes if it costs its area of direct light [W]."""
        if self.shade is None or self.geometry is None or self.log.attitude is None:
            return None
        time_s = self.log.time_s[self.index] - error.clock_s
        place = self.log.latitude_deg[self.index], self.log.longitude_deg[self.index]
        sun = sun_position(time_s, place[0], error.sign("longitude") * place[1]).vector_ned
        angles = error.angles(*(a[self.index] for a in self.log.attitude))
        body = np.einsum("...ji,...j->...i", direction_cosines(*angles), sun)
        covered = self.shade(body) / np.array([one.area_m2 for one in self.geometry.surfaces])
        return np.asarray((self.parts(error).direct * covered).sum(axis=1))

    def ambient_c(self) -> FloatArray:
        """Temperature of the air: of the log, else of the mission, else of standard air."""
        air, altitude = self.mission.air, self.log.altitude_m[self.index]
        flown = np.clip(altitude, MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M)
        given: Any = air.ambient_temperature_c
        if given is None:
            given = standard_air(flown, air.temperature_offset_k or 0.0).temperature_c
        logged = self.log.ambient_temperature_c
        if logged is None:
            return np.broadcast_to(np.asarray(given, float), flown.shape)
        return np.where(np.isnan(logged[self.index]), given, logged[self.index])

    def parts(self, error: LogError) -> Parts:
        """Power of all surfaces if the log has such an error."""
        log, modules = self.log, self.aircraft.modules
        time_s = log.time_s[self.index] - error.clock_s
        latitude = log.latitude_deg[self.index]
        sun = sun_position(
            time_s, latitude, error.sign("longitude") * log.longitude_deg[self.index]
        )
        up = (sun.elevation_rad > 0.0)[:, np.newaxis]
        sine = np.maximum(-sun.vector_ned[:, 2], 0.0)
        sky = self.mission.sky(day_of_year(time_s), latitude, sine, log.altitude_m[self.index])
        light = Irradiance(*(self.mission.clearness * part for part in sky))
        height = np.maximum(np.degrees(sun.elevation_rad), _LEAST_ELEVATION_DEG)
        mass = 1.0 / (np.sin(np.radians(height)) + 0.50572 * (height + 6.07995) ** -1.6364)
        if self.geometry is None or log.attitude is None:
            given = self.mission.air.module_temperature_c
            ambient = self.ambient_c()
            module_c = float(ambient.mean()) if given is None else given
            power = modules.area_m2 * conceptual_analysis_model(light, sine, modules, module_c)
            falling = light.dni * sine + light.dhi
            share = light.dni * sine / np.maximum(falling, 1e-9)
            direct = np.where(up, (power * share)[:, np.newaxis], 0.0)
            rest = np.where(up, (power * (1.0 - share))[:, np.newaxis], 0.0)
            none = np.zeros(len(time_s))
            return Parts(direct, rest, sine[:, np.newaxis], mass, none, falling)
        angles = error.angles(*(a[self.index] for a in log.attitude))
        full = full_model(
            light,
            sun.vector_ned,
            direction_cosines(*angles),
            self.geometry,
            modules,
            self.ambient_c(),
            shading=modules.shading,
        )
        diffuse = np.asarray(light.dhi)[:, np.newaxis]
        efficiency = full.low_light_efficiency_by_surface * self.geometry.area_shares
        beam = (full.irradiance_by_surface_w_per_m2 - diffuse) * modules.camber_efficiency
        beam = beam * full.incidence_efficiency_by_surface * efficiency
        rest = diffuse * modules.diffuse_efficiency * efficiency
        whole = modules.area_m2 * full.specific_power_w_per_m2
        scale = np.where(up, (whole / np.maximum((beam + rest).sum(axis=1), 1e-9))[:, None], 0.0)
        return Parts(
            scale * beam,
            scale * rest,
            full.cos_aoi_by_surface,
            mass,
            sun.azimuth_rad - angles.yaw_rad,
            np.where(up[:, 0], full.irradiance_w_per_m2, 0.0),
        )
