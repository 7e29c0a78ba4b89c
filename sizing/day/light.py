"""Sunlight on an aircraft: specific power of its solar modules over a mission's scenarios.

A solar power model gives the power per area of module; its systematic error is corrected, and the
mission's uncertainty margin is taken off.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from missions.files.errors import file_error
from missions.loiter_power import Daylight
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.module_power import (
    FASTER,
    Cooling,
    balances_heat,
    convection_in_flight,
    convection_of,
    modelled_power,
    own_surroundings,
    specific_power,
    surroundings,
)
from sizing.design import Design
from sizing.mass_budget import airspeed_in_flight
from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName
from solar.sun import declination, sun_times
from solar.systematic_errors import correction
from solar.types import FloatArray

DEFAULT_STEP_H = 1.0 / 12.0
FINE_STEP_H = 1.0 / 60.0  # confirms what the default step finds


@dataclass(frozen=True)
class SolarModel:
    """Which solar power model is believed, and how its systematic error is treated."""

    model: ModelName = "CAM"
    correction: CorrectionName = "none"

    def __post_init__(self) -> None:
        """Refuse unknown names."""
        for word, name, allowed in (
            ("model", self.model, MODEL_NAMES),
            ("correction", self.correction, CORRECTION_NAMES),
        ):
            if name not in allowed:
                raise ValueError(f"unknown {word} {name!r}; allowed: {', '.join(allowed)}")

    @property
    def label(self) -> str:
        """Model and correction in words, for instance ``CAM, uncorrected``."""
        by = "uncorrected" if self.correction == "none" else f"correction {self.correction}"
        return f"{self.model}, {by}"

    @property
    def needs_path(self) -> bool:
        """Whether module surfaces and a flight path are needed: VM, FM, loiter correction."""
        return self.model in ATTITUDE_MODELS or self.correction == "loiter"

    def flown_latitudes_deg(self, mission: Mission) -> tuple[float, float]:
        """Latitudes whose wind is known, where the flight depends on the wind [deg]."""
        in_wind = self.needs_path or mission.holds_station
        return mission.wind_latitudes_deg if in_wind else (-90.0, 90.0)

    @property
    def rms_relative(self) -> float:
        """RMS error of the model relative to the mean measured power [-]."""
        return correction(self.model, self.correction).rms_relative


UNCORRECTED_CAM = SolarModel()


@dataclass(frozen=True)
class SolarDay:
    """Specific power over the day in each scenario: all that a design needs of the sun.

    ``power_w_per_m2``: of shape ``(level, scenario, time)``, at the levels of a mission with climbs
    (:attr:`missions.mission.Mission.climb_levels_m`), the lowest one first; at the mission's
    altitude alone without climbs. It is that of the aircraft's own flow; ``cooling``: how it
    changes with that of another design, where the modules balance their heat. ``sunrise_h`` and
    ``sunset_h`` are those of the geometric sun [solar h].
    """

    scenarios: Scenarios
    time_h: FloatArray
    power_w_per_m2: FloatArray
    sunrise_h: FloatArray
    sunset_h: FloatArray
    cooling: Cooling | None = None

    @classmethod
    def joined(cls, days: Sequence[SolarDay]) -> SolarDay:
        """Scenarios of several days with the same time axis, one day after the other."""
        coolings = [day.cooling for day in days if day.cooling is not None]
        return cls(
            Scenarios(
                np.concatenate([d.scenarios.latitude_deg for d in days]),
                np.concatenate([d.scenarios.day_of_year for d in days]),
            ),
            days[0].time_h,
            np.concatenate([d.power_w_per_m2 for d in days], axis=1),
            np.concatenate([d.sunrise_h for d in days]),
            np.concatenate([d.sunset_h for d in days]),
            Cooling.joined(coolings, axis=1) if coolings else None,
        )

    @property
    def specific_power_w_per_m2(self) -> FloatArray:
        """Power at the lowest level, ``(scenario, time)``."""
        return np.asarray(self.power_w_per_m2[0])

    def _mapped(self, function: Callable[[FloatArray], FloatArray]) -> SolarDay:
        """Same day with a function of all its arrays of light."""
        cooling = None if self.cooling is None else self.cooling.mapped(function)
        return replace(self, power_w_per_m2=function(self.power_w_per_m2), cooling=cooling)

    def scaled(self, factor: float | FloatArray) -> SolarDay:
        """Same day with all power multiplied by a factor, or one of shape ``(scenario, 1)``."""
        return replace(self, power_w_per_m2=self.power_w_per_m2 * factor)

    def less(self, other: SolarDay) -> SolarDay:
        """Same day with the power of another one taken off."""
        return replace(self, power_w_per_m2=self.power_w_per_m2 - other.power_w_per_m2)

    def over_days(self, count: int) -> SolarDay:
        """Same day, repeated; its nodes of time go on over the midnights."""
        steps = len(self.time_h) - 1
        nodes = np.arange(count * steps + 1) % steps
        time_h = np.concatenate([self.time_h[:-1] + 24.0 * k for k in range(count)])
        repeated = self._mapped(lambda values: values[..., nodes])
        return replace(repeated, time_h=np.append(time_h, 24.0 * count))

    def at(self, indices: ArrayLike) -> SolarDay:
        """Same day in some of its scenarios."""
        rows, of = np.asarray(indices, int), self.scenarios
        return replace(
            self._mapped(lambda values: values[:, rows]),
            scenarios=Scenarios(of.latitude_deg[rows], of.day_of_year[rows]),
            sunrise_h=np.asarray(self.sunrise_h)[rows],
            sunset_h=np.asarray(self.sunset_h)[rows],
        )

    def module_power_w(
        self, design: Design, mission: Mission, *, paired: bool = False
    ) -> FloatArray:
        """Power of designs' modules, which the flow of each of them cools.

        Parameters
        ----------
        design : Design
            One, or a batch.
        mission : Mission
            With the air.
        paired : bool
            Whether every design flies in its own scenario, else in all of them.

        Returns
        -------
        ndarray
            With the scenarios and the time as last axes [W].
        """
        axes = (..., np.newaxis) if paired else (..., np.newaxis, np.newaxis)
        power = self.specific_power_w_per_m2
        if self.cooling is not None:
            floor = self.cooling.mapped(lambda values: values[0])
            flow = convection_of(
                design, mission.air_state(), floor.transition_reynolds, floor.convection[0]
            )
            power = power * floor.factor(flow[axes])
        return np.asarray(np.asarray(design.variables.module_area_m2)[axes] * power)


def day_axis_h(step_h: float = DEFAULT_STEP_H) -> FloatArray:
    """Nodes from 0 to 24 h, at most ``step_h`` apart."""
    if not 1.0 / 3600.0 <= step_h <= 1.0:
        raise ValueError(f"step_h must be from 1/3600 to 1 (got {step_h:g})")
    return np.linspace(0.0, 24.0, int(np.ceil(24.0 / step_h - 1e-9)) + 1)


class Sunlight:
    """Sunlight on an aircraft in some scenarios, by any solar power model.

    Each model is evaluated once, however many days are asked of it; corrections only scale.

    ``scenarios``: latitudes and days of the year; those of the mission by default. ``design``: of
    whose flow alone the power is, else of any design's; with climbs it plays no part. ``lowest``:
    sunlight at the lowest level of a mission with climbs.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        scenarios: Scenarios | None = None,
        *,
        step_h: float = DEFAULT_STEP_H,
        design: Design | None = None,
        lowest: Sunlight | None = None,
    ) -> None:
        self.aircraft, self.mission = aircraft, mission
        self._design = design if mission.climb is None else None
        self._lowest = self if lowest is None else lowest
        self.scenarios = mission.scenarios() if scenarios is None else scenarios
        self.time_h = day_axis_h(step_h)
        self._power: dict[ModelName, FloatArray] = {}
        self._cooling: dict[ModelName, Cooling] = {}

    @cached_property
    def _convection(self) -> float | None:
        """Of the aircraft's own flow; none where modules do not balance their heat."""
        if not balances_heat(self.mission):
            return None
        if self._design is not None:
            transition = self.aircraft.modules.thermal.transition_reynolds
            flow = float(convection_of(self._design, self.mission.air_state(), transition, np.nan))
            if np.isfinite(flow):
                return flow
        low, here = (m.air_state().density_kg_per_m3 for m in (self._lowest.mission, self.mission))
        speed = self._lowest._airspeed_m_per_s * np.sqrt(low / here)
        return convection_in_flight(self.aircraft, self.mission, float(speed))

    @cached_property
    def _airspeed_m_per_s(self) -> float:
        """Of level flight; at other levels that of the same lift coefficient is flown."""
        return airspeed_in_flight(self.aircraft, self.mission)

    def modelled_power(self, model: ModelName) -> FloatArray:
        """Uncorrected specific power [W/m2], shape ``(scenario, time)``."""
        if model not in self._power:
            self._power[model] = self._in_flow(model, self._convection)
        return self._power[model]

    def _in_flow(self, model: ModelName, convection: float | None) -> FloatArray:
        around = None if convection is None else surroundings(self.mission, convection)
        axes = self.scenarios, self.time_h
        return modelled_power(self.aircraft, self.mission, model, *axes, around)

    def _cooling_of(self, model: ModelName) -> Cooling | None:
        """How the power changes with the flow; of VM and FM in the proportions of CAM."""
        if self._convection is None or self._design is not None:
            return None
        if isinstance(self.aircraft.airframe, MeasuredAirframe):
            return None
        convection = self._convection
        if model not in self._cooling and model in ATTITUDE_MODELS:
            known = self.modelled_power(model)
            faster = self._in_flow(model, FASTER * convection) / np.where(
                known > 0.0, known, np.inf
            )
            like = self._cooling_of("CAM")
            assert like is not None
            self._cooling[model] = like.scaled_to(faster)
        if model not in self._cooling:
            cold, power = self._in_flow(model, None), self.modelled_power(model)
            around = surroundings(self.mission, convection)
            self._cooling[model] = Cooling.of(cold, power, self.aircraft.modules, around)
        return self._cooling[model]

    def loiter_ratio(self, model: ModelName) -> FloatArray:
        """Daily energy of the Full Model on the flight path over that of a model, per scenario.

        The single numbers of the report hold for one morning; this ratio holds for the latitude,
        the day, the wind and the path at hand. It is 1 where no sun is seen. Shape
        ``(scenario, 1)``.
        """
        if model == "FM":
            return np.ones((len(self.scenarios), 1))
        modelled_wh, full_wh = (
            np.trapezoid(self.modelled_power(name), self.time_h, axis=-1) for name in (model, "FM")
        )
        has_light = modelled_wh > 0.0
        return np.where(has_light, full_wh / np.where(has_light, modelled_wh, 1.0), 1.0)[
            :, np.newaxis
        ]

    def day(self, solar: SolarModel) -> SolarDay:
        """Specific power by a model, corrected and less the mission's margin."""
        power = self.modelled_power(solar.model)
        if solar.correction == "loiter":
            power = power * self.loiter_ratio(solar.model)
        factor = self.mission.pessimistic_power_factor(solar.model, solar.correction)
        corrected = power if factor == 1.0 else power * factor
        times = sun_times(self.scenarios.latitude_deg, declination(self.scenarios.noon_day))
        cooling = self._cooling_of(solar.model)
        day = SolarDay(
            self.scenarios,
            self.time_h,
            corrected[np.newaxis],
            times.sunrise_h,
            times.sunset_h,
            None if cooling is None else cooling.mapped(lambda values: values[np.newaxis]),
        )
        if self.mission.climb is not None:
            days = [day, *(level.day(solar) for level in self._levels)]
            coolings = [each.cooling for each in days if each.cooling is not None]
            day = replace(
                day,
                power_w_per_m2=np.concatenate([each.power_w_per_m2 for each in days]),
                cooling=Cooling.joined(coolings, axis=0) if coolings else None,
            )
        return day if self.mission.flight is None else day.over_days(self.mission.days_of_light)

    @cached_property
    def _levels(self) -> list[Sunlight]:
        """Sunlight of the same scenarios at the higher levels of the climbs."""
        higher = map(self.mission.at_altitude, self.mission.climb_levels_m[1:])
        return [self._sunlight_at(there) for there in higher]

    def _sunlight_at(self, there: Mission) -> Sunlight:
        """Sunlight of the same scenarios at another altitude."""
        step_h = float(self.time_h[1])
        return Sunlight(self.aircraft, there, self.scenarios, step_h=step_h, lowest=self)


def solar_day(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    scenarios: Scenarios | None = None,
    step_h: float = DEFAULT_STEP_H,
    design: Design | None = None,
) -> SolarDay:
    """Specific power of an aircraft's modules in the mission's (or other) scenarios.

    Parameters
    ----------
    aircraft, mission, scenarios, step_h, design
        As for :class:`Sunlight`.
    solar : SolarModel
        Solar power model and its correction.

    Returns
    -------
    SolarDay
        Power corrected and less the mission's margin.

    Raises
    ------
    ValueError
        If the model or its correction lacks the aircraft's module geometry or the mission's flight
        path, or the step is not between 1 s and 1 h.
    """
    return Sunlight(aircraft, mission, scenarios, step_h=step_h, design=design).day(solar)


def power_at_instants(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    light: Daylight,
    air_c: FloatArray | None = None,
    module_c: FloatArray | None = None,
) -> FloatArray:
    """Specific power at a mission's single latitude while the date advances, corrected.

    Under the clear sky, or in the light of a weather record: the mission's own clearness then plays
    no part, its margin of the model's error does. The loiter ratio is that of each instant's day
    under the clear sky. Returns electric power per area of module [W/m2].
    """
    if solar.needs_path and mission.wind_statistics is not None:
        message = "needs one wind from day to day: give wind_m_per_s in place of wind"
        raise file_error(mission.name, f"{solar.label} on a flight path {message}")
    around = own_surroundings(aircraft, mission)
    power = specific_power(aircraft, mission, solar.model, light, around, air_c, module_c)
    if solar.correction == "loiter":
        dates = np.floor(np.asarray(light.day_of_year, float)).astype(int)
        days, place = np.unique(dates, return_inverse=True)
        scenarios = Scenarios(np.full(len(days), mission.latitudes()[0]), (days - 1) % 365 + 1)
        ratio = Sunlight(aircraft, mission, scenarios).loiter_ratio(solar.model)
        power = power * ratio[place, 0]
    return power * mission.pessimistic_power_factor(solar.model, solar.correction)
