"""Modelled power of a log's samples if its clock and its heading were off."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M, standard_air
from missions.logs.table import FlightLog
from missions.mission import Mission
from sizing.aircraft import Aircraft
from solar.attitude import direction_cosines
from solar.attitude_models import full_model
from solar.clearsky import Irradiance
from solar.geometry import ModuleGeometry
from solar.horizontal_models import conceptual_analysis_model
from solar.sun import SunPosition, sun_position
from solar.types import FloatArray, IntArray
from studies.flight_logs.samples import day_of_year


@dataclass(frozen=True)
class ShiftedPower:
    """Power of the Full Model, or of CAM without attitude or module surfaces, at some samples.

    ``time_s``, ``latitude_deg``, ``longitude_deg``, ``altitude_m``, ``ambient_c``: samples: time as
    logged [s since 1970], place, temperature of the air [C]. ``angles_rad``: roll, pitch and yaw as
    logged, shape (3, samples).
    """

    aircraft: Aircraft
    mission: Mission
    geometry: ModuleGeometry | None
    time_s: FloatArray
    latitude_deg: FloatArray
    longitude_deg: FloatArray
    altitude_m: FloatArray
    ambient_c: FloatArray
    angles_rad: FloatArray | None

    @classmethod
    def of(
        cls,
        log: FlightLog,
        aircraft: Aircraft,
        mission: Mission,
        geometry: ModuleGeometry | None,
        index: IntArray,
    ) -> ShiftedPower:
        """Take some samples of a log.

        ``mission``: clearness, and the temperature that the log does not have. ``geometry``: module
        surfaces, where the Full Model can be computed.
        """
        altitude = log.altitude_m[index]
        flown = np.clip(altitude, MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M)
        given = mission.air.ambient_temperature_c
        offset = mission.air.temperature_offset_k or 0.0
        ambient = standard_air(flown, offset).temperature_c if given is None else given
        ambient = np.broadcast_to(np.asarray(ambient, float), flown.shape)
        if log.ambient_temperature_c is not None:
            logged = log.ambient_temperature_c[index]
            ambient = np.where(np.isnan(logged), ambient, logged)
        angles = None
        if geometry is not None and log.attitude is not None:
            angles = np.stack(log.attitude)[:, index]
        return cls(
            aircraft=aircraft,
            mission=mission,
            geometry=None if angles is None else geometry,
            time_s=log.time_s[index],
            latitude_deg=log.latitude_deg[index],
            longitude_deg=log.longitude_deg[index],
            altitude_m=altitude,
            ambient_c=ambient,
            angles_rad=angles,
        )

    @cached_property
    def _to_ned(self) -> FloatArray:
        assert self.angles_rad is not None  # power_w checked
        return direction_cosines(*self.angles_rad)

    @property
    def knows_heading(self) -> bool:
        """Whether the power depends on the heading at all."""
        return self.geometry is not None

    def tilted(self, roll_rad: float, pitch_rad: float) -> ShiftedPower:
        """Same samples with other angles of roll and pitch."""
        assert self.angles_rad is not None  # the caller asked
        added = np.array([[roll_rad], [pitch_rad], [0.0]])
        return replace(self, angles_rad=self.angles_rad + added)

    def power_w(self, ahead_s: float, turned_rad: ArrayLike = 0.0) -> FloatArray:
        """Power [W] if clock and heading are wrong by so much.

        ``ahead_s``: how far the clock of the log is ahead of universal time [s]. ``turned_rad``:
        how far the logged heading is clockwise of the true one [rad]. Returns shape of
        ``turned_rad`` and one axis for the samples.
        """
        true_s = self.time_s - ahead_s
        sun = sun_position(true_s, self.latitude_deg, self.longitude_deg)
        sine = np.maximum(-sun.vector_ned[:, 2], 0.0)
        sky = self.mission.sky(day_of_year(true_s), self.latitude_deg, sine, self.altitude_m)
        light = Irradiance(*(self.mission.clearness * part for part in sky))
        modules, up = self.aircraft.modules, sun.elevation_rad > 0.0
        if self.geometry is None or self.angles_rad is None:
            given = self.mission.air.module_temperature_c
            module_c = float(self.ambient_c.mean()) if given is None else given
            power = conceptual_analysis_model(light, sine, modules, module_c)
            shape = (*np.shape(turned_rad), len(true_s))
            return np.broadcast_to(np.where(up, modules.area_m2 * power, 0.0), shape)
        full = full_model(
            light,
            _turned(sun, np.asarray(turned_rad, float)[..., np.newaxis]),
            self._to_ned,
            self.geometry,
            modules,
            self.ambient_c,
            shading=modules.shading,
        )
        return np.where(up, modules.area_m2 * full.specific_power_w_per_m2, 0.0)


def _turned(sun: SunPosition, angle: FloatArray) -> FloatArray:
    """Vector to the sun, turned clockwise: seen from the nose, a yaw less by that angle."""
    north, east, down = np.moveaxis(sun.vector_ned, -1, 0)
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = (cosine * north - sine * east, sine * north + cosine * east, down + 0.0 * angle)
    return np.stack(np.broadcast_arrays(*turned), axis=-1)
