"""Load of designs along a day or a record: level flight, turbulence, thermals, consumers.

With parts at their operating point the electric power follows the thrust power of turbulence and
thermals. The bus has the voltage of a half charged battery.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.air import ZERO_CELSIUS_K, Air, air_at
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import NO_FLIGHT_W, Design, FlightConditions
from sizing.held_station import held_flight
from sizing.mass_budget import ImpossibleDesignError
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.propulsion.part_load import PROPORTIONAL, PartLoad, load_range
from sizing.smooth import Value
from solar.sun import HOURS_PER_DAY
from solar.types import FloatArray


class Flight(NamedTuple):
    """Thrust power [W], airspeed [m/s] and air of level flight; 1 W, 1 m/s where there is none."""

    thrust_w: Any
    airspeed_m_per_s: Any
    air: Air


def flight_of(
    aircraft: Aircraft, mission: Mission, design: Design
) -> tuple[OperatingPointPropulsion, Flight]:
    """Return the propulsion of a design's size, and its level flight."""
    propulsion = aircraft.propulsion_by_parts
    assert propulsion is not None
    with np.errstate(invalid="ignore"):
        thrust_w = np.asarray(design.thrust_power_w)
    flies = np.isfinite(thrust_w)
    variables = design.variables.mapped(lambda value: value if np.ndim(value) else float(value))
    return propulsion.sized(*variables.of_propulsion), Flight(
        np.where(flies, thrust_w, 1.0),
        np.where(flies, design.airspeed_m_per_s, 1.0),
        FlightConditions.of(mission, aircraft).air,
    )


def part_load_of(aircraft: Aircraft, mission: Mission, design: Design) -> PartLoad:
    """Return the power over the load in the mission's turbulence and thermals.

    Raises :class:`ImpossibleDesignError` for a single design whose propeller's data end before.
    """
    if aircraft.propulsion_by_parts is None:
        return PROPORTIONAL
    loads = load_range(mission.turbulence.all_day, mission.turbulence.thermal)
    level_w, bus_v = np.asarray(design.propulsion_power_w), aircraft.battery.nominal_voltage_v
    propulsion, flight = flight_of(aircraft, mission, design)
    if not propulsion.is_exact or level_w.ndim or not np.isfinite(level_w):
        return _part_load(propulsion, flight, level_w, loads, bus_v)
    air = Air(*map(float, flight.air))  # type: ignore[arg-type]  # as a cache's key
    numbers = Flight(float(flight.thrust_w), float(flight.airspeed_m_per_s), air)
    most = float(loads[1])
    part = _single_part_load(propulsion, numbers, float(level_w), (float(loads[0]), most), bus_v)
    if part.beyond:
        reason = propulsion.point(flight.thrust_w * most, *flight[1:], (bus_v,)).reason
        raise ImpossibleDesignError(
            f"the propulsion of {aircraft.name} cannot do {most:.3g} times the power of level "
            f"flight, in turbulence and thermals of {mission.name}: {reason}"
        )
    return part


def _part_load(
    propulsion: OperatingPointPropulsion,
    flight: Flight,
    level_w: FloatArray,
    loads: tuple[FloatArray, FloatArray],
    bus_v: float,
) -> PartLoad:
    """Return the power over the load, relative to that of level flight."""

    def power_w(load: FloatArray) -> Any:
        return propulsion.bus_power_w(propulsion.shaft(flight.thrust_w * load, *flight[1:]), bus_v)

    return PartLoad.of(power_w, np.where(np.isfinite(level_w), level_w, np.inf), loads)


@lru_cache(maxsize=16)
def _single_part_load(
    propulsion: OperatingPointPropulsion,
    flight: Flight,
    level_w: float,
    loads: tuple[float, float],
    bus_v: float,
) -> PartLoad:
    """Return the power over the load of one design: its flights share the search of rotations."""
    ends = np.asarray(loads[0]), np.asarray(loads[1])
    return _part_load(propulsion, flight, np.asarray(level_w), ends, bus_v)


class Load(NamedTuple):
    """Electric load of designs over the thrust power of the moment, the time last.

    ``level_w``: propulsion in level flight and calm air; ``constant_w``: avionics, payload and
    heater [W], both of shape ``(..., scenario, 1)``. ``part``: power over the thrust ratio.
    """

    level_w: FloatArray
    constant_w: FloatArray
    part: PartLoad

    @classmethod
    def of(
        cls,
        aircraft: Aircraft,
        mission: Mission,
        design: Design,
        scenarios: Scenarios | None = None,
    ) -> Load:
        """Return the load of designs, whose last axis broadcasts with the scenarios.

        ``scenarios``: with the winds of a place that is held; flight as fast as they are has the
        efficiency of that airspeed.
        """
        if mission.holds_station:
            winds = mission.scenario_winds_m_per_s(scenarios)
            design = held_flight(aircraft, mission, design, winds)
        part = part_load_of(aircraft, mission, design).spread(1)
        # An impossible design draws infinite power; a huge finite one keeps NaN out of the rest.
        level_w = np.asarray(design.propulsion_power_w)
        level_w = np.where(np.isfinite(level_w), level_w, NO_FLIGHT_W)
        constant_w = np.asarray(design.constant_power_w)
        return cls(level_w[..., np.newaxis], constant_w[..., np.newaxis], part)

    def at(self, thrust_ratio: FloatArray) -> FloatArray:
        """Return the load at thrust powers over that of level flight [W], ``(..., time)``."""
        return np.asarray(self.level_w * self.part.at(thrust_ratio) + self.constant_w)

    def without_thermals(self, mission: Mission) -> FloatArray:
        """Return the load in the turbulence of all hours [W], ``(..., scenario)``."""
        calm = 1.0 + np.asarray(mission.turbulence.all_day, float)
        return np.atleast_1d(self.at(calm[..., np.newaxis])[..., 0])

    def along(
        self, mission: Mission, time_h: ArrayLike, sunrise_h: ArrayLike, sunset_h: ArrayLike
    ) -> FloatArray:
        """Return the load over the day in turbulence and thermals [W], ``(..., time)``.

        ``mission``: with its turbulence; draws of it are arrays of the batch.
        """
        load_w = self.at(load_shape(mission, time_h, sunrise_h, sunset_h))
        shape = (*np.shape(sunrise_h), np.shape(time_h)[-1] if np.ndim(time_h) else 1)
        return np.broadcast_to(load_w, np.broadcast_shapes(load_w.shape, shape))


def load_shape(
    mission: Mission, time_h: ArrayLike, sunrise_h: ArrayLike, sunset_h: ArrayLike
) -> FloatArray:
    """Return the thrust power over that of level flight [-], ``(..., time)``."""
    all_day, most = (
        np.asarray(value, float)[..., np.newaxis]
        for value in (mission.turbulence.all_day, mission.turbulence.thermal)
    )
    if not np.any(most):
        return 1.0 + all_day
    return np.asarray(1.0 + all_day + most * thermal_shape(time_h, sunrise_h, sunset_h))


def thermal_shape(time_h: ArrayLike, sunrise_h: ArrayLike, sunset_h: ArrayLike) -> Value:
    """Return the share of thermals [-]: 0 at sunrise and sunset, 1 half-way between, by night 0."""
    rise = np.asarray(sunrise_h, float)[..., np.newaxis]
    half = (np.asarray(sunset_h, float)[..., np.newaxis] - rise) / 2.0
    distance = np.abs(np.asarray(time_h, float) % HOURS_PER_DAY - (rise + half))
    has_light = half > 0.0
    shape = np.maximum(1.0 - distance / np.where(has_light, half, 1.0), 0.0)
    return np.where(has_light, shape, 0.0)


def power_in_air_w(
    aircraft: Aircraft,
    mission: Mission,
    design: Design,
    load: FloatArray,
    air_c: FloatArray,
    range_c: tuple[float, float],
    wind_m_per_s: FloatArray | None = None,
) -> FloatArray:
    """Return the propulsion power in air that changes its temperature [W], ``(day, node)``.

    At the pressure of an altitude, airspeed and drag times airspeed go with the square root of the
    absolute temperature (Anderson, Aircraft Performance and Design, equation 5.56); of parts at
    their operating point a parabola passes through three temperatures of the range.

    ``load``: thrust power over that of level flight in the air of the moment [-]. ``wind_m_per_s``:
    of each day, where the mission holds its place; where it is too strong there is no flight.
    Raises :class:`ImpossibleDesignError` where the propeller's data end before the greatest load.
    """
    if wind_m_per_s is not None:
        # Days of equal wind, and of less than the airspeed, are one flight.
        speeds = np.maximum(wind_m_per_s, np.asarray(design.airspeed_m_per_s, float))
        speeds, day = np.unique(speeds, return_inverse=True)
        design = held_flight(aircraft, mission, design, speeds)
    warm_k = air_c + ZERO_CELSIUS_K
    if aircraft.propulsion_by_parts is None:
        ratio = load * np.sqrt(warm_k / float(mission.air_state().temperature_k))
    else:
        known_k, part = _part_load_in_air(aircraft, mission, design, range_c)
        if wind_m_per_s is not None:
            part = replace(part, coefficients=part.coefficients[..., day])
        powers = part.spread(2 - np.ndim(design.propulsion_power_w)).at(load)
        ratio = np.zeros(air_c.shape)
        for k, power in enumerate(powers):
            apart = [(warm_k - other) / (known_k[k] - other) for other in np.delete(known_k, k)]
            ratio += math.prod(apart, start=power)
    level_w = np.atleast_1d(np.asarray(design.propulsion_power_w))
    level_w = np.where(np.isfinite(level_w), level_w, NO_FLIGHT_W)
    return np.asarray((level_w if wind_m_per_s is None else level_w[day])[:, np.newaxis] * ratio)


def _part_load_in_air(
    aircraft: Aircraft, mission: Mission, design: Design, range_c: tuple[float, float]
) -> tuple[FloatArray, PartLoad]:
    """Return temperatures of a range [K], and the power over the load at each, designs behind."""
    level_w = np.asarray(design.propulsion_power_w)
    if not level_w.ndim:
        part_load_of(aircraft, mission, design)  # whose error names the mission's air
    propulsion, flight = flight_of(aircraft, mission, design)
    known_k = ZERO_CELSIUS_K + np.linspace(*range_c, 3 if range_c[1] > range_c[0] else 1)
    air_k = known_k.reshape(-1, *(1,) * level_w.ndim)
    faster = np.sqrt(air_k / flight.air.temperature_k)
    there = Flight(
        np.asarray(flight.thrust_w * faster),
        flight.airspeed_m_per_s * faster,
        air_at(air_k, flight.air.pressure_pa),
    )
    loads = load_range(mission.turbulence.all_day, mission.turbulence.thermal)
    wide_w = np.broadcast_to(level_w, there.thrust_w.shape)
    part = _part_load(propulsion, there, wide_w, loads, aircraft.battery.nominal_voltage_v)
    if not level_w.ndim and np.any(part.beyond):
        raise ImpossibleDesignError(
            f"the propulsion of {aircraft.name} cannot do {float(loads[1]):.3g} times the "
            f"power of level flight in air of {range_c[0]:.0f} to {range_c[1]:.0f} C"
        )
    return known_k, part
