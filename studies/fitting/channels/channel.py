"""A measured quantity of a flight and a model of it, in means over some minutes.

A loiter turns the modules through the light about once a minute: means over
:data:`~studies.fitting.channels.bins.BIN_S` know nothing of that, nor of most of the noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from missions.logs.table import FlightLog
from missions.mission import AirConditions, Mission
from sizing.aircraft import Aircraft
from solar.types import FloatArray, IntArray
from studies.fitting.parameters import ChannelName
from studies.flight_logs.verification import Verification

Predict = Callable[[Aircraft, float], FloatArray]


@dataclass(frozen=True)
class Channel:
    """A measured quantity in bins, and a model of it.

    ``time_s``: mean time of each bin's samples [s since 1970, UTC]. ``run``: number of the
    uninterrupted stretch. ``predict``: modelled value of each bin, from an aircraft and a factor on
    the light. ``floating``: whether only differences count: every stretch has a level of its own.
    ``notes``: what was left out.
    """

    name: ChannelName
    label: str
    unit: str
    time_s: FloatArray
    measured: FloatArray
    run: IntArray
    predict: Predict
    floating: bool = False
    notes: tuple[str, ...] = ()

    def residual(self, aircraft: Aircraft, light: float = 1.0) -> FloatArray:
        """Measured less modelled; of a floating channel without the mean of each stretch."""
        apart = self.measured - self.predict(aircraft, light)
        return self.centred(apart) if self.floating else apart

    def centred(self, values: FloatArray) -> FloatArray:
        """Values without the mean of each stretch."""
        counts = np.bincount(self.run)
        means = np.bincount(self.run, values) / np.maximum(counts, 1)
        return np.asarray(values - means[self.run])

    @property
    def levels(self) -> int:
        """Unknown levels: one for each stretch of a floating channel."""
        return int(self.run[-1]) + 1 if self.floating else 0


@dataclass(frozen=True)
class Flown:
    """A log, the mission in its place and air, and which samples may be used."""

    log: FlightLog
    mission: Mission
    found: Verification

    @classmethod
    def of(cls, verification: Verification, mission: Mission) -> Flown:
        """Mission in the place and the mean air of a log.

        ``mission``: clearness, payload, turbulence, and air where the log has none.
        """
        return cls(verification.log, mission_of_log(verification.log, mission), verification)


def mission_of_log(log: FlightLog, mission: Mission) -> Mission:
    """Mission at the mean place, altitude and air temperature of a log.

    Returns without launch and climb; not validated.
    """
    place = {
        "latitude_deg": float(np.median(log.latitude_deg)),
        "longitude_deg": float(np.median(log.longitude_deg)),
        "altitude_m": float(np.median(log.altitude_m)),
    }
    changed = mission.model_copy(update={**place, "launch": None, "climb": None})
    air = mission.air
    if log.ambient_temperature_c is not None:
        mean_c = float(np.nanmean(log.ambient_temperature_c))
        air = AirConditions(
            ambient_temperature_c=mean_c, module_temperature_c=air.module_temperature_c
        )
    return changed.model_copy(update={"air": air})


def ambient_c(flown: Flown, index: IntArray) -> FloatArray:
    """Air temperature at samples of a log: logged, else of the mission."""
    mean_c = float(flown.mission.air_state().temperature_c)
    logged = flown.log.ambient_temperature_c
    if logged is None:
        return np.full(len(index), mean_c)
    return np.where(np.isnan(logged[index]), mean_c, logged[index])
