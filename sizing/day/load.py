"""Load of an aircraft whose propulsion has the efficiency of the moment.

With parts at their operating point the electric power follows the thrust power of turbulence and
thermals. The bus has the voltage of a half charged battery.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.air import ZERO_CELSIUS_K, Air, air_at
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarDay
from sizing.design import NO_FLIGHT_W, Design, FlightConditions
from sizing.held_station import flight_against_wind
from sizing.mass_budget import ImpossibleDesignError
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.propulsion.part_load import PROPORTIONAL, AnyPartLoad, PartLoad, load_range
from sizing.smooth import Value
from solar.sun import HOURS_PER_DAY
from solar.types import BoolArray, FloatArray, IntArray


def part_load_of(
    aircraft: Aircraft,
    mission: Mission,
    design: Design,
) -> AnyPartLoad:
    """Power of the propulsion over load.

    The load is that of the mission's turbulence and thermals. Raises
    :class:`ImpossibleDesignError` for a single design whose propeller's data end before.
    """
    if aircraft.propulsion_by_parts is None:
        return PROPORTIONAL
    turbulence = mission.turbulence
    ends = load_range(turbulence.all_day, turbulence.thermal)
    level_w = np.asarray(design.propulsion_power_w, float)
    own, flight = flight_of(aircraft, mission, design)
    bus_v, flies = aircraft.battery.nominal_voltage_v, np.isfinite(level_w)
    if not (own.is_exact and level_w.ndim == 0 and flies):
        return part_load_over(own, flight, np.where(flies, level_w, np.inf), ends, bus_v)
    numbers = Flight(
        float(flight.thrust_w),
        float(flight.airspeed_m_per_s),
        Air(*(float(one) for one in flight.air)),  # type: ignore[arg-type]  # as a cache's key
    )
    load = float(ends[0]), float(ends[1])
    found = _part_load_of_one(own, numbers, float(level_w), load, bus_v)
    if found.beyond:
        reason = own.point(flight.thrust_w * load[1], *flight[1:], (bus_v, bus_v)).reason
        raise ImpossibleDesignError(
            f"the propulsion of {aircraft.name} cannot do {load[1]:.3g} times the power of level "
            f"flight, in turbulence and thermals of {mission.name}: {reason}"
        )
    return found


def interpolation_error(aircraft: Aircraft, mission: Mission, design: Design) -> float:
    """Largest relative error of a single design's table, half-way between its nodes."""
    part = part_load_of(aircraft, mission, design)
    assert isinstance(part, PartLoad)
    own, flight = flight_of(aircraft, mission, design)
    load, bus_v = part.between(), aircraft.battery.nominal_voltage_v
    exact_w = own.bus_power_w(flight.thrust_w * load, *flight[1:], bus_v)
    return float(np.max(np.abs(part.at(load) * design.propulsion_power_w / exact_w - 1.0)))


class Flight(NamedTuple):
    """Thrust power of level flight [W], airspeed [m/s] and air."""

    thrust_w: Any
    airspeed_m_per_s: Any
    air: Air

    @classmethod
    def where(cls, flies: BoolArray, thrust_w: Any, airspeed_m_per_s: Any, air: Air) -> Flight:
        """Flight of designs, of which those that cannot fly have 1 W and 1 m/s."""
        return cls(np.where(flies, thrust_w, 1.0), np.where(flies, airspeed_m_per_s, 1.0), air)


def flight_of(
    aircraft: Aircraft, mission: Mission, design: Design
) -> tuple[OperatingPointPropulsion, Flight]:
    """Propulsion of a design's size, and its level flight."""
    propulsion = aircraft.propulsion_by_parts
    assert propulsion is not None
    with np.errstate(invalid="ignore"):
        thrust_w = np.asarray(design.thrust_power_w)
    air = FlightConditions.of(mission, aircraft).air
    variables = design.variables.mapped(lambda one: float(one) if np.ndim(one) == 0 else one)
    flight = Flight.where(np.isfinite(thrust_w), thrust_w, design.airspeed_m_per_s, air)
    return propulsion.sized(*variables.of_propulsion), flight


def part_load_over(
    own: OperatingPointPropulsion,
    flight: Flight,
    level_w: FloatArray,
    loads: tuple[FloatArray, FloatArray],
    bus_v: float,
) -> PartLoad:
    """Power of a propulsion over loads at a voltage, relative to that of a level flight.

    ``level_w``: electric power of that flight [W], of the shape of what ``flight`` has.
    """

    def power_w(load: FloatArray) -> Any:
        return own.bus_power_w(flight.thrust_w * load, *flight[1:], bus_v)

    return PartLoad.of(power_w, level_w, loads)


def _part_load_against_wind(
    aircraft: Aircraft,
    mission: Mission,
    design: Design,
    power_w: FloatArray,
    thrust_w: FloatArray,
    airspeed_m_per_s: FloatArray,
) -> AnyPartLoad:
    """Power over load of flight at airspeeds of its own.

    ``power_w``: of level flight at them; of scenarios, ``design`` with an axis for them.
    """
    if (propulsion := aircraft.propulsion_by_parts) is None:
        return PROPORTIONAL
    own = propulsion.sized(*design.variables.of_propulsion)
    air = FlightConditions.of(mission, aircraft).air
    flight = Flight.where(np.isfinite(power_w), thrust_w, airspeed_m_per_s, air)
    loads = load_range(mission.turbulence.all_day, mission.turbulence.thermal)
    return part_load_over(own, flight, power_w, loads, aircraft.battery.nominal_voltage_v)


@lru_cache(maxsize=16)
def _part_load_of_one(
    own: OperatingPointPropulsion,
    flight: Flight,
    level_w: float,
    loads: tuple[float, float],
    bus_v: float,
) -> PartLoad:
    """Table of one design, which several flights share: its rotations are searched for once."""
    ends = np.asarray(loads[0]), np.asarray(loads[1])
    return part_load_over(own, flight, np.asarray(level_w), ends, bus_v)


@dataclass(frozen=True)
class DesignLoads:
    """Solar power and load of every design in every scenario of a day.

    ``paired``: each design flies in its own scenario. ``own_solar_w``: power of the modules, where
    it is not that of the day. ``own_propulsion_w``: of level flight in every scenario, where it is
    not that of the design.
    """

    design: Design
    mission: Mission
    day: SolarDay
    part_load: AnyPartLoad = PROPORTIONAL
    paired: bool = False
    own_solar_w: FloatArray | None = None
    own_propulsion_w: FloatArray | None = None

    @classmethod
    def of(
        cls,
        aircraft: Aircraft,
        mission: Mission,
        design: Design,
        day: SolarDay,
        *,
        paired: bool = False,
    ) -> DesignLoads:
        """Loads with the efficiency of the moment where the aircraft's parts say what it is.

        Flight as fast as the wind of a scenario has the efficiency of that airspeed.
        """
        if mission.holds_station:
            return cls(design, mission, day, paired=paired).against_wind(aircraft)
        return cls(design, mission, day, part_load_of(aircraft, mission, design), paired)

    def against_wind(self, aircraft: Aircraft) -> DesignLoads:
        """Same flight, as fast as the wind of each scenario."""
        winds = self.mission.scenario_winds_m_per_s(self.day.scenarios)
        spread = self.design.mapped(self._over_scenarios)
        flown = flight_against_wind(aircraft, self.mission, spread, winds)
        power_w, part = flown[0], _part_load_against_wind(aircraft, self.mission, spread, *flown)
        return replace(self, own_propulsion_w=power_w, part_load=part)

    @cached_property
    def solar_w(self) -> FloatArray:
        """Power of the modules [W], ``(..., scenario, time)``."""
        if self.own_solar_w is not None:
            return self.own_solar_w
        area = self._over_scenarios(self.design.variables.module_area_m2)[..., np.newaxis]
        power = self.day.power_of(self.design, self.mission, paired=self.paired)
        return np.asarray(area * power)

    def load_w(self) -> FloatArray:
        """Load at the nodes [W]."""
        day = self.day
        times = day.time_h, day.sunrise_h, day.sunset_h
        load: FloatArray = load_profile(self._in_scenarios, self.mission, *times, self._part)
        return np.broadcast_to(load, np.broadcast_shapes(load.shape, self.solar_w.shape))

    def nominal_w(self) -> FloatArray:
        """Nominal load [W], ``(..., scenario)``."""
        flown = self._in_scenarios
        load, _ = load_range(self.mission.turbulence.all_day, 0.0)
        ratio = self._part.at(load[..., np.newaxis])
        level_w, constant_w = (
            np.asarray(one)[..., np.newaxis]
            for one in (flown.propulsion_power_w, flown.constant_power_w)
        )
        return np.asarray((level_w * ratio + constant_w)[..., 0])

    @cached_property
    def _in_scenarios(self) -> Design:
        """Design with an axis for the scenarios."""
        # An impossible design draws infinite power; a huge finite one keeps NaN out of the rest.
        power_w = self.own_propulsion_w
        if power_w is None:
            power_w = self._over_scenarios(self.design.propulsion_power_w)
        return self.design._replace(
            propulsion_power_w=np.where(np.isfinite(power_w), power_w, NO_FLIGHT_W),
            constant_power_w=self._over_scenarios(self.design.constant_power_w),
        )

    @cached_property
    def _part(self) -> AnyPartLoad:
        """Part load with axes for scenarios and time."""
        # As fast as the wind every scenario has its own already.
        return self.part_load.spread(1 if self.own_propulsion_w is not None else 2 - self.paired)

    def _over_scenarios(self, value: ArrayLike) -> FloatArray:
        return np.asarray(value) if self.paired else np.asarray(value)[..., np.newaxis]


def load_profile(
    design: Design,
    mission: Mission,
    time_h: ArrayLike,
    sunrise_h: ArrayLike,
    sunset_h: ArrayLike,
    part_load: AnyPartLoad = PROPORTIONAL,
) -> Value:
    """Load over the day: level flight, turbulence and thermals.

    ``mission``: with its turbulence; draws of it are arrays of the batch. ``part_load``: with axes
    for scenarios and time. Returns power that the aircraft draws [W].
    """
    propulsion = np.asarray(design.propulsion_power_w)[..., np.newaxis]
    constant = np.asarray(design.constant_power_w)[..., np.newaxis]
    if not np.any(mission.turbulence.thermal):
        steady = 1.0 + np.asarray(mission.turbulence.all_day, float)[..., np.newaxis]
        load = propulsion * part_load.at(steady) + constant
        shape = np.broadcast_shapes(load.shape, (*np.shape(sunrise_h), np.size(time_h)))
        return np.broadcast_to(load, shape)
    thrust = load_shape(mission, time_h, sunrise_h, sunset_h)
    return propulsion * part_load.at(thrust) + constant


def load_shape(
    mission: Mission, time_h: ArrayLike, sunrise_h: ArrayLike, sunset_h: ArrayLike
) -> FloatArray:
    """Thrust power over that of level flight at the nodes [-], with the time as last axis."""
    all_day, most = (
        np.asarray(value, float)[..., np.newaxis]
        for value in (mission.turbulence.all_day, mission.turbulence.thermal)
    )
    return np.asarray(1.0 + all_day + most * thermal_shape(time_h, sunrise_h, sunset_h))


def thermal_shape(time_h: ArrayLike, sunrise_h: ArrayLike, sunset_h: ArrayLike) -> Value:
    """Triangle over the lit day: 0 at sunrise and sunset, 1 half-way between.

    Returns share of the thermals' extra power [-].
    """
    rise = np.asarray(sunrise_h, float)[..., np.newaxis]
    half = (np.asarray(sunset_h, float)[..., np.newaxis] - rise) / 2.0
    distance = np.abs(np.asarray(time_h, float) % HOURS_PER_DAY - (rise + half))
    sunlit = half > 0.0
    return np.where(sunlit, np.maximum(1.0 - distance / np.where(sunlit, half, 1.0), 0.0), 0.0)


@dataclass(frozen=True)
class ConstantInAir:
    """As :class:`LoadInAir`, by a constant efficiency.

    Power of level flight at a lift coefficient goes with ``density^-0.5``; at the pressure of an
    altitude that is the square root of the absolute temperature (Anderson, Aircraft Performance and
    Design, equation 5.56).
    """

    level_w: FloatArray
    air_k: float

    @classmethod
    def of(
        cls,
        aircraft: Aircraft,
        mission: Mission,
        design: Design,
        wind_m_per_s: FloatArray | None = None,
    ) -> ConstantInAir:
        """Power of the design's airspeed, or of the wind of each day."""
        level_w: FloatArray = np.asarray(design.propulsion_power_w)
        if wind_m_per_s is not None:
            level_w = flight_against_wind(aircraft, mission, design, wind_m_per_s)[0]
        return cls(level_w, float(mission.air_state().temperature_k))

    def at(self, load: FloatArray, air_c: FloatArray) -> FloatArray:
        """Power over that of level flight in the mission's air [-]; arguments broadcast."""
        return np.asarray(load * np.sqrt((air_c + ZERO_CELSIUS_K) / self.air_k))


@dataclass(frozen=True)
class LoadInAir:
    """Electric power of a design in air that changes its temperature, relative to its own.

    ``level_w``: propulsion power of level flight in the mission's air [W], of every day where each
    has an airspeed of its own. ``part_load``: power over it at some temperatures,
    ``temperatures_k``, between which a parabola passes.
    """

    level_w: FloatArray
    part_load: PartLoad
    temperatures_k: FloatArray

    @classmethod
    def of(
        cls,
        aircraft: Aircraft,
        mission: Mission,
        design: Design,
        air_c: ArrayLike,
        wind_m_per_s: FloatArray | None = None,
    ) -> LoadInAir | ConstantInAir:
        """Power between the ends of temperatures [C].

        At the pressure of an altitude airspeed and drag times airspeed go with the square root of
        the absolute temperature. ``wind_m_per_s``: of each day, where the mission holds its place;
        power is then over that of the day's airspeed. Raises :class:`ImpossibleDesignError` where
        the propeller's data end before the greatest load of level flight; a day whose wind is too
        strong has no power instead.
        """
        if aircraft.propulsion_by_parts is None:
            return ConstantInAir.of(aircraft, mission, design, wind_m_per_s)
        if wind_m_per_s is None:
            part_load_of(aircraft, mission, design)  # which says what its own air is too much for
        own, flight = flight_of(aircraft, mission, design)
        level_w: FloatArray = np.asarray(design.propulsion_power_w)
        day: IntArray | None = None
        if wind_m_per_s is not None:
            # Days of equal wind, and of less than the airspeed, are one flight.
            each = np.maximum(wind_m_per_s, np.asarray(design.airspeed_m_per_s, float))
            some, day = np.unique(each, return_inverse=True)
            level_w, thrust_w, speed = flight_against_wind(aircraft, mission, design, some)
            flight = Flight.where(np.isfinite(level_w), thrust_w, speed, flight.air)
        least_c, most_c = float(np.min(air_c)), float(np.max(air_c))
        warm_k = ZERO_CELSIUS_K + np.linspace(least_c, most_c, 3 if most_c > least_c else 1)
        # Temperatures first, then the days.
        of_each = warm_k.reshape(-1, *(1,) * level_w.ndim)
        faster = np.sqrt(of_each / flight.air.temperature_k)
        there = Flight(
            np.asarray(flight.thrust_w * faster),
            flight.airspeed_m_per_s * faster,
            air_at(of_each, flight.air.pressure_pa),
        )
        turbulence = mission.turbulence
        loads = load_range(turbulence.all_day, turbulence.thermal)
        wide = np.broadcast_to(level_w, there.thrust_w.shape)
        part = part_load_over(own, there, wide, loads, aircraft.battery.nominal_voltage_v)
        if wind_m_per_s is None and np.any(part.beyond):
            raise ImpossibleDesignError(
                f"the propulsion of {aircraft.name} cannot do {float(loads[1]):.3g} times the "
                f"power of level flight in air of {least_c:.0f} to {most_c:.0f} C"
            )
        if day is None:
            return cls(level_w, part, warm_k)
        part = replace(part, coefficients=part.coefficients[..., day])
        return cls(level_w[day], part, warm_k)

    def at(self, load: FloatArray, air_c: FloatArray) -> FloatArray:
        """Power over that of level flight in the mission's air [-]; arguments broadcast."""
        wide = np.broadcast_arrays(load, air_c)
        axes = wide[0].ndim - (self.part_load.coefficients.ndim - 2)  # less that of the days
        powers = self.part_load.spread(axes).at(wide[0])
        known_k, warm_k = self.temperatures_k, wide[1] + ZERO_CELSIUS_K
        total = np.zeros(wide[0].shape)
        for k, one in enumerate(powers):
            apart = [(warm_k - other) / (known_k[k] - other) for other in np.delete(known_k, k)]
            total += math.prod(apart, start=one)
        return total
