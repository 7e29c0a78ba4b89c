"""Sunlight on an aircraft: specific power of its solar modules over a mission's scenarios.

A solar power model gives the power per area of module; its systematic error is corrected, and the
mission's uncertainty margin is taken off.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from missions.loiter_power import mean_power_on_path
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.energy.power_balance import FloatArray
from solar.correction import correction
from solar.names import ATTITUDE_MODELS, CorrectionName, ModelName
from solar.power import horizontal_specific_power
from solar.sun import declination, sun_times

DEFAULT_STEP_H = 1.0 / 12.0


@dataclass(frozen=True)
class SolarModel:
    """Which solar power model is believed, and how its systematic error is treated."""

    model: ModelName = "CAM"
    correction: CorrectionName = "none"

    @property
    def rms_relative(self) -> float:
        """RMS error of the model relative to the mean measured power [-]."""
        return correction(self.model, self.correction).rms_relative


UNCORRECTED_CAM = SolarModel()


@dataclass(frozen=True)
class SolarDay:
    """Specific power over the day in each scenario: all that a design needs of the sun.

    ``specific_power_w_per_m2`` has the shape ``(scenario, time)``; ``sunrise_h`` and ``sunset_h``
    are those of the geometric sun [solar h].
    """

    scenarios: Scenarios
    time_h: FloatArray
    specific_power_w_per_m2: FloatArray
    sunrise_h: FloatArray
    sunset_h: FloatArray

    def scaled(self, factor: float) -> SolarDay:
        """Same day with all power multiplied by a factor."""
        return replace(self, specific_power_w_per_m2=self.specific_power_w_per_m2 * factor)

    def at(self, indices: ArrayLike) -> SolarDay:
        """Same day in some of its scenarios."""
        some = np.asarray(indices, int)
        of = self.scenarios
        return SolarDay(
            Scenarios(of.latitude_deg[some], of.day_of_year[some]),
            self.time_h,
            self.specific_power_w_per_m2[some],
            np.asarray(self.sunrise_h)[some],
            np.asarray(self.sunset_h)[some],
        )


def day_axis_h(step_h: float = DEFAULT_STEP_H) -> FloatArray:
    """Nodes from 0 to 24 h, at most ``step_h`` apart.

    Raises
    ------
    ValueError
        If the step is not between 1 s and 1 h.
    """
    if not 1.0 / 3600.0 <= step_h <= 1.0:
        raise ValueError(f"step_h must be from 1/3600 to 1 (got {step_h:g})")
    return np.linspace(0.0, 24.0, int(np.ceil(24.0 / step_h - 1e-9)) + 1)


def solar_day(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    scenarios: Scenarios | None = None,
    step_h: float = DEFAULT_STEP_H,
) -> SolarDay:
    """Specific power of an aircraft's modules in the mission's (or other) scenarios."""
    chosen = mission.scenarios() if scenarios is None else scenarios
    time_h = day_axis_h(step_h)
    times = sun_times(chosen.latitude_deg, declination(chosen.noon_day))
    power = modelled_power(aircraft, mission, solar.model, chosen, time_h)
    if solar.correction == "loiter":
        power = power * loiter_ratio(aircraft, mission, solar.model, chosen, time_h, power)
    factor = correction_and_margin_factor(mission, solar)
    corrected = power if factor == 1.0 else power * factor
    return SolarDay(chosen, time_h, corrected, times.sunrise_h, times.sunset_h)


def correction_and_margin_factor(mission: Mission, solar: SolarModel) -> float:
    """Factor on a model's power: its correction, and the low end of the mission's band."""
    factor = correction(solar.model, solar.correction).factor
    return factor * mission.bands.solar_factor(solar.rms_relative)


def modelled_power(
    aircraft: Aircraft, mission: Mission, model: ModelName, scenarios: Scenarios, time_h: FloatArray
) -> FloatArray:
    """Specific power of a model, uncorrected, over scenarios and time [W/m2].

    VM and FM are averaged over the mission's flight path.

    Raises
    ------
    ValueError
        If VM or FM lack the aircraft's module geometry or the mission's flight path.
    """
    if model not in ATTITUDE_MODELS:
        latitude, day = scenarios.latitude_deg, scenarios.noon_day
        # In memory the time comes first: the simulator marches over it, all scenarios at once.
        column = time_h[:, np.newaxis]
        return _horizontal_power(aircraft, mission, model, latitude, day, column).T
    pairs = zip(scenarios.latitude_deg, scenarios.noon_day, strict=True)
    return np.stack(
        [_power_on_path(aircraft, mission, model, float(lat), day, time_h) for lat, day in pairs]
    )


def power_on_calendar(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    day_of_year: FloatArray,
    time_solar_h: FloatArray,
) -> FloatArray:
    """Specific power at a mission's single latitude while the date advances, corrected [W/m2].

    Parameters
    ----------
    day_of_year, time_solar_h : ndarray, shape (time,)
        Fractional day of year and local solar time [h] at each instant.
    """
    latitude = mission.latitudes()[0]
    if solar.model in ATTITUDE_MODELS:
        power = _power_on_path(aircraft, mission, solar.model, latitude, day_of_year, time_solar_h)
    else:
        power = _horizontal_power(
            aircraft, mission, solar.model, latitude, day_of_year, time_solar_h
        )
    if solar.correction == "loiter":
        days, place = np.unique(np.floor(day_of_year).astype(int), return_inverse=True)
        scenarios = Scenarios(np.full(len(days), latitude), (days - 1) % 365 + 1)
        axis = day_axis_h()
        repeated = modelled_power(aircraft, mission, solar.model, scenarios, axis)
        ratio = loiter_ratio(aircraft, mission, solar.model, scenarios, axis, repeated)
        power = power * ratio[place, 0]
    return power * correction_and_margin_factor(mission, solar)


def _horizontal_power(
    aircraft: Aircraft,
    mission: Mission,
    model: ModelName,
    latitude_deg: ArrayLike,
    day_of_year: ArrayLike,
    time_solar_h: ArrayLike,
) -> FloatArray:
    return horizontal_specific_power(
        latitude_deg,
        day_of_year,
        time_solar_h,
        cell=aircraft.modules,
        module_temperature_c=mission.module_temperature_c(),
        altitude_m=mission.altitude_m,
        clearness=mission.judged_clearness,
        model=model,
    )


def _power_on_path(
    aircraft: Aircraft,
    mission: Mission,
    model: ModelName,
    latitude_deg: float,
    day_of_year: ArrayLike,
    time_solar_h: FloatArray,
) -> FloatArray:
    geometry, path = aircraft.modules.geometry, mission.flight_path
    if geometry is None:
        raise ValueError(f"model {model} needs modules.geometry on the aircraft {aircraft.name}")
    if path is None:
        raise ValueError(f"model {model} needs a flight_path on the mission {mission.name}")
    return mean_power_on_path(
        model,
        latitude_deg,
        day_of_year,
        time_solar_h,
        geometry=geometry,
        cell=aircraft.modules,
        path=path,
        wind=mission.wind,
        ambient_temperature_c=float(mission.air_state().temperature_c),
        module_temperature_c=mission.module_temperature_c(),
        altitude_m=mission.altitude_m,
        clearness=mission.judged_clearness,
        shading=aircraft.modules.shading,
    )


def loiter_ratio(
    aircraft: Aircraft,
    mission: Mission,
    model: ModelName,
    scenarios: Scenarios,
    time_h: FloatArray,
    power: FloatArray,
) -> FloatArray:
    """Daily energy of the Full Model on the flight path over that of a model, per scenario.

    The single numbers of the report hold for one morning; this ratio holds for the latitude, the
    day, the wind and the path at hand. It is 1 where no sun is seen. Shape ``(scenario, 1)``.
    """
    if model == "FM":
        return np.ones((len(scenarios), 1))
    full = modelled_power(aircraft, mission, "FM", scenarios, time_h)
    ours = np.trapezoid(power, time_h, axis=-1)
    theirs = np.trapezoid(full, time_h, axis=-1)
    lit = ours > 0.0
    return np.where(lit, theirs / np.where(lit, ours, 1.0), 1.0)[:, np.newaxis]
