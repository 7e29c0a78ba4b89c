"""Aircraft between their lowest altitude and their ceiling: power, sunlight, potential energy.

A height is one more axis, before those of the designs and scenarios: level flight, winds and light
are arrays over the levels of a mission, and linear between them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.chain_at_heights import ClimbChain, ConstantChain
from sizing.day.light import SolarDay
from sizing.day.load import load_shape
from sizing.day.module_power import convection_of
from sizing.design import Design, FlightConditions
from sizing.held_station import against_wind
from sizing.mass_budget import (
    ImpossibleDesignError,
    design_of,
    level_flight,
    measured_design,
    operating_trouble,
)
from sizing.smooth import Value
from solar.types import BoolArray, FloatArray, IntArray


class ClimbLimitError(ValueError):
    """An aircraft that cannot climb; ``key``: missing in its file, or too small there."""

    def __init__(self, key: tuple[str, ...], message: str) -> None:
        super().__init__(f"{'.'.join(key)}: {message}")
        self.key, self.message = key, message


@dataclass(frozen=True)
class FlightLevels:
    """Flights of aircraft of known mass between the lowest altitude and the ceiling.

    All elements share the first four: ``altitude_m`` of the levels, ``day`` with the light at them,
    ``thrust_ratio``, thrust power in turbulence over that of level flight, ``(scenario, time)``
    [-], and ``chain``, propulsion of every ``design`` at all levels.

    An element is an aircraft in a scenario: ``nominal_ratio`` is its thrust ratio without thermals,
    ``constant_power_w`` that of avionics and payload [W], ``efficiency`` and ``maximum_power_w``
    those of the propulsion, ``flies`` whether it does at all levels, and ``reach_m`` the height
    above the lowest altitude that it may climb to: that of the ceiling, or of where the wind takes
    all its power. ``convection_w_per_m2k`` of its modules: ``(element, level)``.
    """

    altitude_m: FloatArray
    day: SolarDay
    thrust_ratio: FloatArray
    chain: ConstantChain | ClimbChain
    scenario: IntArray
    design: IntArray
    module_area_m2: FloatArray
    nominal_ratio: FloatArray
    constant_power_w: FloatArray
    efficiency: FloatArray
    maximum_power_w: FloatArray
    flies: BoolArray
    weight_n: FloatArray
    reach_m: FloatArray
    convection_w_per_m2k: FloatArray

    @cached_property
    def nominal_load_w(self) -> FloatArray:
        """Return the load at the lowest altitude without thermals [W]."""
        motor_w = self.chain.power_w(np.array(0), self.design, self.nominal_ratio)
        return np.asarray(motor_w + self.constant_power_w)

    @cached_property
    def most_power_w(self) -> FloatArray:
        """Return the electric power that the propulsion gives at all levels [W]."""
        return np.asarray(np.minimum(self.maximum_power_w, self.chain.most_w[self.design]))

    def powers_along(
        self, time_h: FloatArray, height_m: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the solar power and the load of elements along heights [W], ``(element, time)``.

        Light and power of level flight are linear between levels. A climb takes ``m g dz/dt`` of
        thrust power, which a descent gives back.

        ``height_m``: above the lowest altitude at the nodes of the day, which repeats itself.
        """
        element = np.arange(len(self.scenario))[:, np.newaxis]
        rate = np.diff(height_m, axis=-1) / (3600.0 * np.diff(time_h))
        rate = np.concatenate([rate[:, -1:], rate, rate[:, :1]], axis=-1)
        climb_w = self.weight_n[:, np.newaxis] * (rate[:, 1:] + rate[:, :-1]) / 2.0
        ratio, design = self.thrust_ratio[self.scenario], self.design[:, np.newaxis]

        def motor_w(level: IntArray) -> FloatArray:
            load = ratio + climb_w / self.chain.thrust_w[level, design]
            return self.chain.power_w(level, design, load)

        load_w = self._between(height_m, motor_w) + self.constant_power_w[:, np.newaxis]
        solar_w = self._between(height_m, lambda level: self._light_at(level, element))
        return solar_w * self.module_area_m2[:, np.newaxis], load_w

    def at_heights(self, element: int, height_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the solar power, ``(height, time)``, and that of level flight of an element."""
        design = self.design[element]
        power_w = self._between(
            height_m, lambda level: self.chain.power_w(level, design, np.ones(level.shape))
        )
        light = self._between(
            height_m[:, np.newaxis], lambda level: self._light_at(level, np.array(element))
        )
        return light * self.module_area_m2[element], power_w

    def select(self, elements: slice | IntArray | BoolArray) -> FlightLevels:
        """Return the flights of a part of the elements."""
        names = [field.name for field in fields(self)][4:]
        return replace(self, **{name: getattr(self, name)[elements] for name in names})

    def _between(self, height_m: FloatArray, rows: Callable[[IntArray], FloatArray]) -> FloatArray:
        """Return values at heights [m], linear between levels, whose numbers ``rows`` takes."""
        known = self.altitude_m - self.altitude_m[0]
        below = np.clip(np.searchsorted(known, height_m, side="right") - 1, 0, len(known) - 2)
        apart = known[below + 1] - known[below]
        upper = (height_m - known[below]) / np.where(apart > 0.0, apart, 1.0)
        return np.asarray((1.0 - upper) * rows(below) + upper * rows(below + 1))

    def _light_at(self, level: IntArray, element: IntArray) -> FloatArray:
        """Return the specific power of elements at a level of every time; both broadcast."""
        times = np.arange(self.day.power_w_per_m2.shape[-1])
        place = level, self.scenario[element], times
        power, cooling = self.day.power_w_per_m2[place], self.day.cooling
        if cooling is not None:
            flow = self.convection_w_per_m2k[element, level]
            power = power * cooling.mapped(lambda values: values[place]).factor(flow)
        return np.asarray(power)


def climb_limits(aircraft: Aircraft, design: Design) -> tuple[Value, Value]:
    """Return efficiency [-] and largest electric power [W] of the propulsion of designs.

    Parametric: the rated power of the propulsion, sized at the mission's altitude. Measured: as
    the file says. ``design``: with its mass and the power of its level flight at that altitude.
    """
    airframe = aircraft.airframe
    if not isinstance(airframe, MeasuredAirframe):
        assert design.chain is not None
        return design.chain.efficiency, design.rated_power_w
    flight = airframe.level_flight
    for name in ("maximum_electric_power_w", "propulsion_efficiency"):
        if getattr(flight, name) is None:
            message = "required key is missing: the mission has climb"
            raise ClimbLimitError(("airframe", "level_flight", name), message)
    return flight.propulsion_efficiency, flight.maximum_electric_power_w


def check_climb_limits(aircraft: Aircraft, mission: Mission, design: Design | None = None) -> None:
    """Refuse climbs of a design, by default the file's, with no power beyond level flight's."""
    if mission.climb is None:
        return
    design = design or design_of(aircraft, mission)
    most_w = float(climb_limits(aircraft, design)[1])
    level_w = float(design.propulsion_power_w)
    if most_w <= level_w:
        measured = isinstance(aircraft.airframe, MeasuredAirframe)
        key = ("level_flight", "maximum_electric_power_w")
        raise ClimbLimitError(
            ("airframe", *(key if measured else ("propulsion", "climb_power_ratio"))),
            f"{most_w:.3g} W in all leaves nothing to climb with: level "
            f"flight takes {level_w:.3g} W; it must be more",
        )


def flight_levels(
    aircraft: Aircraft, mission: Mission, design: Design, day: SolarDay
) -> FlightLevels:
    """Return power and sunlight between a mission's altitude and its ceiling, of known masses.

    ``design``: one, or a batch whose last axis broadcasts with the scenarios; elements are in this
    order. ``day``: with the light at altitude.
    """
    altitudes = np.array(mission.climb_levels_m)
    scenarios, batch = np.arange(len(day.scenarios)), np.shape(design.total_mass_kg)
    shape = np.broadcast_shapes(batch, scenarios.shape)

    def each(value: object) -> FloatArray:
        return np.broadcast_to(np.asarray(value, float), shape).ravel()

    def each_level(values: Any) -> FloatArray:
        return np.stack([each(value) for value in values])

    missions = [mission.at_altitude(float(h)) for h in altitudes]
    own_air = FlightConditions.of_levels(missions, aircraft, len(batch))
    level = _level_flights(aircraft, missions, own_air, design)
    flights, held, air = level, np.ones((len(altitudes), *shape), bool), own_air
    if mission.holds_station:
        air = FlightConditions.of_levels(missions, aircraft, len(shape))
        flights, held = _against_winds(aircraft, missions, air, level, design, day)
    power_w, held = each_level(flights.propulsion_power_w), each_level(held) > 0.0
    weight_n = each(np.asarray(design.total_mass_kg) * GRAVITY_M_PER_S2)
    flies = np.isfinite(power_w).all(axis=0) & np.isfinite(weight_n) & held[0]
    efficiency, rated_w = climb_limits(aircraft, design)
    most_w = each(rated_w)
    cases = np.shape(flights.propulsion_power_w)[1:]
    parts, cooling = aircraft.propulsion_by_parts, day.cooling
    convection = np.zeros((len(flies), len(altitudes)))
    if cooling is not None:
        unknown = cooling.convection.reshape(-1, *(1,) * len(batch))
        flow = convection_of(level, own_air.air, cooling.transition_reynolds, unknown)
        convection = each_level(flow).T
    thrust = load_shape(mission, day.time_h, day.sunrise_h, day.sunset_h)
    return FlightLevels(
        altitude_m=altitudes,
        day=day,
        thrust_ratio=np.broadcast_to(thrust, day.specific_power_w_per_m2.shape),
        chain=ConstantChain.of(flights, efficiency)
        if parts is None
        else ClimbChain.of(parts, aircraft, flights, air.air),
        scenario=np.broadcast_to(scenarios, shape).ravel(),
        design=np.asarray(each(np.arange(max(math.prod(cases), 1)).reshape(cases)), int),
        module_area_m2=each(design.variables.module_area_m2),
        nominal_ratio=each(1.0 + np.asarray(mission.turbulence.all_day, float)),
        constant_power_w=each(design.constant_power_w),
        efficiency=each(efficiency),
        maximum_power_w=np.where(flies, most_w, 0.0),
        flies=np.asarray(flies),
        weight_n=np.where(flies, weight_n, 0.0),
        reach_m=_reach_m(altitudes - altitudes[0], power_w, held, most_w),
        convection_w_per_m2k=convection,
    )


def _level_flights(
    aircraft: Aircraft, missions: list[Mission], air: FlightConditions, design: Design
) -> Design:
    """Return the level flight of a known mass at all levels; infinite power where there is none."""
    if isinstance(aircraft.airframe, MeasuredAirframe):
        flight = measured_design(aircraft, air)
        return design._replace(
            propulsion_power_w=flight.propulsion_power_w, airspeed_m_per_s=flight.airspeed_m_per_s
        )
    with np.errstate(over="ignore", invalid="ignore"):
        chain, power_w, speed = level_flight(aircraft, air, design.variables, design.total_mass_kg)
    able = np.isfinite(power_w)
    if np.ndim(design.total_mass_kg) == 0 and not able.all():
        raise ImpossibleDesignError(operating_trouble(aircraft, missions[int(np.argmin(able))]))
    return design._replace(propulsion_power_w=power_w, airspeed_m_per_s=speed, chain=chain)


def _against_winds(
    aircraft: Aircraft,
    missions: list[Mission],
    air: FlightConditions,
    level: Design,
    design: Design,
    day: SolarDay,
) -> tuple[Design, BoolArray]:
    """Return flights as fast as the winds of all levels, and whether they can, by scenarios.

    ``level``: at the levels in calm air; ``design``: its rated power.
    """
    winds = np.stack([there.scenario_winds_m_per_s(day.scenarios) for there in missions])
    axes = np.ndim(design.total_mass_kg)
    winds = winds.reshape(len(winds), *(1,) * (axes - 1), -1)
    calm = level if axes else level.over_scenarios()
    flights, held = against_wind(aircraft, air, calm, winds, design.rated_power_w)
    # A floor that is not held is no flight, of which a chain of parts knows by its power.
    power_w = np.array(flights.propulsion_power_w)
    power_w[0] = np.where(held[0], power_w[0], np.inf)
    return flights._replace(propulsion_power_w=power_w), held


def _reach_m(
    height_m: FloatArray, power_w: FloatArray, held: BoolArray, most_w: FloatArray
) -> FloatArray:
    """Return the height below the first level whose wind is not held [m], ``(element,)``.

    Where the power, linear between levels, is the largest; at the level below where that of the
    first is not known.
    """
    columns, first = np.arange(len(most_w)), np.argmin(held, axis=0)
    below = np.maximum(first - 1, 0)
    low_w, beyond_w = power_w[below, columns], power_w[first, columns]
    with np.errstate(invalid="ignore", divide="ignore"):  # of designs that do not fly
        rise_w = np.where(beyond_w > most_w, beyond_w - low_w, np.inf)
        share = np.clip((most_w - low_w) / rise_w, 0.0, 1.0)
    share = np.where(held[0], share, 0.0)  # a floor that is not held has no power to compare
    short_m = height_m[below] + share * (height_m[first] - height_m[below])
    return np.asarray(np.where(held.all(axis=0), height_m[-1], short_m))
