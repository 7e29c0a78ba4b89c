"""Sunlight on an aircraft: specific power of its solar modules over a mission's scenarios.

A solar power model gives the power per area of module; its systematic error is corrected, and the
mission's uncertainty margin is taken off. A height is one more axis, before the scenarios.
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
    SLOWER,
    Cooling,
    balances_heat,
    convection_in_flight,
    convection_of,
    modelled_power,
    path_troubles,
    specific_power,
    surroundings,
    surroundings_in_flight,
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
    """Solar power model, and correction of its systematic error."""

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
        """Return model and correction in words, for instance ``CAM, uncorrected``."""
        by = "uncorrected" if self.correction == "none" else f"correction {self.correction}"
        return f"{self.model}, {by}"

    @property
    def needs_path(self) -> bool:
        """Return whether module surfaces and a flight path are needed."""
        return self.model in ATTITUDE_MODELS or self.correction == "loiter"

    def meets_wind(self, mission: Mission) -> bool:
        """Return whether the wind plays a part in the light or the load of a flight."""
        return self.needs_path or mission.holds_station

    def has_many_paths(self, mission: Mission) -> bool:
        """Return whether places and months have paths of their own, each in another wind."""
        return self.needs_path and mission.wind_statistics is not None

    def path_troubles(
        self, aircraft: Aircraft, mission: Mission, scenarios: Scenarios | None = None
    ) -> list[str | None]:
        """Return :func:`sizing.day.module_power.path_troubles`; none for models without a path.

        Parameters
        ----------
        aircraft : Aircraft
            Aircraft that flies the path.
        mission : Mission
            Mission with the path and its winds.
        scenarios : Scenarios, optional
            Latitudes and days, each with a wind of its own; left out, the strongest wind alone.

        Returns
        -------
        list of str or None
            Why the path cannot be held in the wind of each scenario; None where it can.
        """
        if self.needs_path:
            return path_troubles(aircraft, mission, scenarios)
        return [None] * (1 if scenarios is None else len(scenarios))

    def latitudes_with_wind_deg(self, mission: Mission) -> tuple[float, float]:
        """Return the ends of the latitudes for which all winds of a flight are known [deg]."""
        return mission.wind_latitudes_deg if self.meets_wind(mission) else (-90.0, 90.0)

    @property
    def rms_relative(self) -> float:
        """Return the RMS error of the model relative to the mean measured power [-]."""
        return correction(self.model, self.correction).rms_relative


UNCORRECTED_CAM = SolarModel()


@dataclass(frozen=True)
class SolarDay:
    """Specific power over the day in each scenario: all that a design needs of the sun.

    ``power_w_per_m2``: of shape ``(level, scenario, time)``, at the levels of a mission
    (:attr:`missions.mission.Mission.climb_levels_m`), the lowest first. It is that in the flow of
    the aircraft's file; ``cooling``: its change with the flow of a design, where the modules
    balance their heat. ``sunrise_h``, ``sunset_h``: of the geometric sun [solar h].
    """

    scenarios: Scenarios
    time_h: FloatArray
    power_w_per_m2: FloatArray
    sunrise_h: FloatArray
    sunset_h: FloatArray
    cooling: Cooling | None = None

    @classmethod
    def joined(cls, days: Sequence[SolarDay]) -> SolarDay:
        """Return the scenarios of several days with one time axis, one day after the other."""
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
            Cooling.joined(coolings) if coolings else None,
        )

    @property
    def specific_power_w_per_m2(self) -> FloatArray:
        """Return the power at the lowest level, ``(scenario, time)``."""
        return np.asarray(self.power_w_per_m2[0])

    def _mapped(self, function: Callable[[FloatArray], FloatArray]) -> SolarDay:
        """Return the day with a function of all its arrays of light."""
        cooling = None if self.cooling is None else self.cooling.mapped(function)
        return replace(self, power_w_per_m2=function(self.power_w_per_m2), cooling=cooling)

    def scaled(self, factor: float | FloatArray) -> SolarDay:
        """Return the day with all power times a factor, a number or of shape ``(scenario, 1)``."""
        return replace(self, power_w_per_m2=self.power_w_per_m2 * factor)

    def over_days(self, count: int) -> SolarDay:
        """Return the day repeated, its nodes of time going on over the midnights."""
        steps = len(self.time_h) - 1
        nodes = np.arange(count * steps + 1) % steps
        time_h = np.concatenate([self.time_h[:-1] + 24.0 * k for k in range(count)])
        repeated = self._mapped(lambda values: values[..., nodes])
        return replace(repeated, time_h=np.append(time_h, 24.0 * count))

    def at(self, indices: ArrayLike) -> SolarDay:
        """Return the day in a part of its scenarios, by their indices."""
        rows, of = np.asarray(indices, int), self.scenarios
        return replace(
            self._mapped(lambda values: values[:, rows]),
            scenarios=Scenarios(of.latitude_deg[rows], of.day_of_year[rows]),
            sunrise_h=np.asarray(self.sunrise_h)[rows],
            sunset_h=np.asarray(self.sunset_h)[rows],
        )


def module_power_w(day: SolarDay, design: Design, mission: Mission) -> FloatArray:
    """Return the power of designs' modules, which the flow of each of them cools [W].

    The last axis of designs is that of the scenarios, with which they broadcast; the time is
    behind it.
    """
    power = day.specific_power_w_per_m2
    if day.cooling is not None:
        floor = day.cooling.mapped(lambda values: values[0])
        flow = convection_of(
            design, mission.air_state(), floor.transition_reynolds, floor.convection[0]
        )
        power = power * floor.factor(flow[..., np.newaxis])
    return np.asarray(np.asarray(design.variables.module_area_m2)[..., np.newaxis] * power)


def day_axis_h(step_h: float = DEFAULT_STEP_H) -> FloatArray:
    """Return nodes from 0 to 24 h, at most ``step_h`` apart."""
    if not 1.0 / 3600.0 <= step_h <= 1.0:
        raise ValueError(f"step_h must be from 1/3600 to 1 (got {step_h:g})")
    return np.linspace(0.0, 24.0, int(np.ceil(24.0 / step_h - 1e-9)) + 1)


class Sunlight:
    """Sunlight on an aircraft in scenarios, by any solar power model.

    Each model is evaluated once, however many days are made of it; corrections only scale.

    ``scenarios``: latitudes and days of the year; those of the mission by default. ``design``: of
    whose flow alone the power is, else of any design's; with climbs it plays no part.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        scenarios: Scenarios | None = None,
        *,
        step_h: float = DEFAULT_STEP_H,
        design: Design | None = None,
    ) -> None:
        self.aircraft, self.mission = aircraft, mission
        self._design = design if mission.climb is None else None
        self.scenarios = mission.scenarios() if scenarios is None else scenarios
        self.time_h = day_axis_h(step_h)
        self._levels = [mission, *map(mission.at_altitude, mission.climb_levels_m[1:])]
        self._power: dict[ModelName, FloatArray] = {}
        self._cooling: dict[ModelName, Cooling] = {}

    @cached_property
    def _convection(self) -> FloatArray | None:
        """Return the convection at all levels; None where modules do not balance their heat."""
        if not balances_heat(self.mission):
            return None
        if self._design is not None:
            transition = self.aircraft.modules.thermal.transition_reynolds
            flow = convection_of(self._design, self.mission.air_state(), transition, np.nan)
            if np.isfinite(flow):
                return flow.reshape(1)
        # At all levels at the same lift coefficient.
        speed = airspeed_in_flight(self.aircraft, self.mission)
        density = np.array([float(m.air_state().density_kg_per_m3) for m in self._levels])
        speeds = speed * np.sqrt(density[0] / density)
        flights = zip(self._levels, speeds.tolist(), strict=True)
        return np.array([convection_in_flight(self.aircraft, *flight) for flight in flights])

    def _power_of(self, model: ModelName) -> FloatArray:
        """Return the uncorrected specific power [W/m2], ``(level, scenario, time)``."""
        if model not in self._power:
            self._power[model] = self._at_levels(model, self._convection)
        return self._power[model]

    def _at_levels(self, model: ModelName, convection: FloatArray | None) -> FloatArray:
        """Return the power in a convection at all levels, or of modules as cold as the air."""
        flows = [None] * len(self._levels) if convection is None else convection.tolist()
        powers = []
        for there, flow in zip(self._levels, flows, strict=True):
            around = None if flow is None else surroundings(there, flow)
            powers.append(
                modelled_power(self.aircraft, there, model, self.scenarios, self.time_h, around)
            )
        # A single level keeps its layout in memory.
        return powers[0][np.newaxis] if len(powers) == 1 else np.stack(powers)

    def _cooling_of(self, model: ModelName) -> Cooling | None:
        """Return the change of the power with the flow; None where it is that of one flow."""
        convection = self._convection
        if convection is None or self._design is not None:
            return None
        if isinstance(self.aircraft.airframe, MeasuredAirframe):
            return None
        if model not in self._cooling:
            slower, faster = (self._at_levels(model, by * convection) for by in (SLOWER, FASTER))
            transition = self.aircraft.modules.thermal.transition_reynolds
            self._cooling[model] = Cooling.of(
                self._power_of(model), slower, faster, convection, transition
            )
        return self._cooling[model]

    def loiter_ratio(self, model: ModelName) -> FloatArray:
        """Return the daily energy of the Full Model on the flight path over that of a model.

        The single numbers of the report hold for one morning; this ratio holds for the latitude,
        the day, the wind and the path at hand. It is 1 where no sun is seen. Shape
        ``(level, scenario, 1)``.
        """
        if model == "FM":
            return np.ones((len(self._levels), len(self.scenarios), 1))
        modelled_wh, full_wh = (
            np.trapezoid(self._power_of(name), self.time_h, axis=-1) for name in (model, "FM")
        )
        has_light = modelled_wh > 0.0
        ratio = np.where(has_light, full_wh / np.where(has_light, modelled_wh, 1.0), 1.0)
        return ratio[..., np.newaxis]

    def day(self, solar: SolarModel) -> SolarDay:
        """Return the specific power by a model, corrected and less the mission's margin."""
        power = self._power_of(solar.model)
        if solar.correction == "loiter":
            power = power * self.loiter_ratio(solar.model)
        factor = self.mission.pessimistic_power_factor(solar.model, solar.correction)
        times = sun_times(self.scenarios.latitude_deg, declination(self.scenarios.noon_day))
        day = SolarDay(
            self.scenarios,
            self.time_h,
            power if factor == 1.0 else power * factor,
            times.sunrise_h,
            times.sunset_h,
            self._cooling_of(solar.model),
        )
        return day if self.mission.flight is None else day.over_days(self.mission.days_of_light)


def solar_day(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    scenarios: Scenarios | None = None,
    step_h: float = DEFAULT_STEP_H,
    design: Design | None = None,
) -> SolarDay:
    """Return the specific power of an aircraft's modules in the mission's (or other) scenarios.

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
    """Return the corrected specific power at a single latitude while the date advances [W/m2].

    Under the clear sky, or in the light of a weather record: the mission's clearness then plays no
    part, its margin of the model's error does. The loiter ratio is that of each instant's day
    under the clear sky.
    """
    if solar.has_many_paths(mission):
        message = "needs one wind from day to day: give wind_m_per_s in place of wind"
        raise file_error(mission.name, f"{solar.label} on a flight path {message}")
    around = surroundings_in_flight(aircraft, mission)
    power = specific_power(aircraft, mission, solar.model, light, around, air_c, module_c)
    if solar.correction == "loiter":
        dates = np.floor(np.asarray(light.day_of_year, float)).astype(int)
        days, place = np.unique(dates, return_inverse=True)
        scenarios = Scenarios(np.full(len(days), mission.latitudes()[0]), (days - 1) % 365 + 1)
        ratio = Sunlight(aircraft, mission, scenarios).loiter_ratio(solar.model)
        power = power * ratio[0, place, 0]
    return power * mission.pessimistic_power_factor(solar.model, solar.correction)
