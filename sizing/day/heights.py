"""Aircraft between their lowest altitude and their ceiling: power, sunlight, potential energy."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.chain_at_heights import ClimbChain, ConstantChain
from sizing.day.light import SolarDay
from sizing.day.load import load_shape
from sizing.day.module_power import Cooling, convection_of
from sizing.design import Design
from sizing.held_station import against_wind
from sizing.mass_budget import (
    ImpossibleDesignError,
    measured_design,
    operating_trouble,
    parametric_design,
)
from sizing.propulsion.part_load import load_range
from solar.types import BoolArray, FloatArray, IntArray

# What is the same for all elements.
_SHARED = ("altitude_m", "power_w_per_m2", "cooling", "turbulence_factor", "chain")


class ClimbLimitError(ValueError):
    """An aircraft that cannot climb; ``key`` is what its file lacks or has too small."""

    def __init__(self, key: tuple[str, ...], message: str) -> None:
        super().__init__(f"{'.'.join(key)}: {message}")
        self.key, self.message = key, message


class ClimbLimits(NamedTuple):
    """What the propulsion can do: efficiency [-] and largest electric power [W]."""

    efficiency: float
    maximum_power_w: float


@dataclass(frozen=True)
class FlightLevels:
    """Flights of aircraft of some mass between the lowest altitude and the ceiling.

    One element is one aircraft in one scenario. ``altitude_m``, ``power_w_per_m2`` and ``cooling``:
    of every level, the light as a day has it; ``module_area_m2``, ``scenario`` and
    ``convection_w_per_m2k``, of shape ``(element, level)``, say how much of which.
    ``turbulence_factor``, of shape ``(scenario, time)``: factor on the propulsion power [-]. Of
    every element: ``nominal_factor`` is that without thermals, ``constant_power_w`` of avionics
    and payload [W], ``efficiency`` and ``maximum_power_w`` of the propulsion, whether it ``flies``
    at all levels, its weight, and ``reach_m``, the height above the lowest altitude that it may
    climb to: that of the ceiling, or of where the wind takes all its power. ``chain``: propulsion
    of every ``design`` at all levels.
    """

    altitude_m: FloatArray
    power_w_per_m2: FloatArray
    cooling: Cooling | None
    module_area_m2: FloatArray
    scenario: IntArray
    turbulence_factor: FloatArray
    nominal_factor: FloatArray
    constant_power_w: FloatArray
    efficiency: FloatArray
    maximum_power_w: FloatArray
    flies: BoolArray
    design: IntArray
    weight_n: FloatArray
    reach_m: FloatArray
    chain: ConstantChain | ClimbChain
    convection_w_per_m2k: FloatArray

    @property
    def level_power_w(self) -> FloatArray:
        """Electric propulsion power of level flight in calm air [W], ``(level, element)``."""
        levels = np.arange(len(self.altitude_m))[:, np.newaxis]
        return self.chain.power_w(levels, self.design, np.ones(self.design.shape))

    @cached_property
    def nominal_load_w(self) -> FloatArray:
        """Load at the lowest altitude without thermals [W]."""
        motor_w = self.chain.power_w(np.array(0), self.design, self.nominal_factor)
        return np.asarray(motor_w + self.constant_power_w)

    @cached_property
    def most_power_w(self) -> FloatArray:
        """Electric power that the propulsion gives at all levels [W]."""
        return np.asarray(np.minimum(self.maximum_power_w, self.chain.most_w[self.design]))

    def _place(self, height_m: FloatArray) -> tuple[IntArray, FloatArray]:
        """Level below heights above the lowest altitude [m], and the share of the next one."""
        known = self.altitude_m - self.altitude_m[0]
        below = np.clip(np.searchsorted(known, height_m, side="right") - 1, 0, len(known) - 2)
        apart = known[below + 1] - known[below]
        return below, (height_m - known[below]) / np.where(apart > 0.0, apart, 1.0)

    def powers_along(
        self, time_h: FloatArray, height_m: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Solar power and load of elements along heights above the lowest altitude [W].

        Light and power of level flight are linear between levels. A climb takes ``m g dz/dt`` of
        thrust power, which a descent gives back.

        ``height_m``: at the nodes of the day, which repeats itself, ``(element, time)``.
        """
        below, upper = self._place(height_m)
        element = np.arange(len(self.scenario))[:, np.newaxis]

        def between(rows: Callable[[IntArray], FloatArray]) -> FloatArray:
            return np.asarray((1.0 - upper) * rows(below) + upper * rows(below + 1))

        rate = np.diff(height_m, axis=-1) / (3600.0 * np.diff(time_h))
        rate = np.concatenate([rate[:, -1:], rate, rate[:, :1]], axis=-1)
        climb_w = self.weight_n[:, np.newaxis] * (rate[:, 1:] + rate[:, :-1]) / 2.0
        factor, design = self.turbulence_factor[self.scenario], self.design[:, np.newaxis]

        def motor_w(level: IntArray) -> FloatArray:
            load = factor + climb_w / self.chain.thrust_w[level, design]
            return self.chain.power_w(level, design, load)

        load_w = between(motor_w) + self.constant_power_w[:, np.newaxis]
        solar_w = between(lambda level: self._light_at(level, element))
        return solar_w * self.module_area_m2[:, np.newaxis], load_w

    def _light_at(self, level: IntArray, element: IntArray) -> FloatArray:
        """Specific power of elements at a level of every time; both broadcast."""
        times = np.arange(self.power_w_per_m2.shape[-1])
        place = level, self.scenario[element], times
        power = self.power_w_per_m2[place]
        if self.cooling is not None:
            flow = self.convection_w_per_m2k[element, level]
            power = power * self.cooling.mapped(lambda values: values[place]).factor(flow)
        return np.asarray(power)

    def at_heights(self, element: int, height_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Solar power, ``(height, time)``, and power of level flight of an element at heights."""
        levels = np.arange(len(self.altitude_m))[:, np.newaxis]
        power_w, light = self.level_power_w[:, element], self._light_at(levels, np.array(element))
        below, upper = self._place(height_m)
        power_w = (1.0 - upper) * power_w[below] + upper * power_w[below + 1]
        share = upper[:, np.newaxis]
        solar_w = (1.0 - share) * light[below] + share * light[below + 1]
        return solar_w * self.module_area_m2[element], power_w

    def select(self, elements: slice | IntArray | BoolArray) -> FlightLevels:
        """Flights of a part of the elements."""
        rows = (field.name for field in fields(self) if field.name not in _SHARED)
        return replace(self, **{name: getattr(self, name)[elements] for name in rows})


def climb_limits(aircraft: Aircraft, design: Design) -> ClimbLimits:
    """Efficiency and largest power of the propulsion of designs.

    Parametric: the rated power of the propulsion, sized at the mission's altitude. Measured: as
    the file says.

    ``design``: its mass and the power of its level flight at the mission's altitude. Returns
    efficiency [-] and largest electric power [W].
    """
    airframe = aircraft.airframe
    if isinstance(airframe, MeasuredAirframe):
        flight = airframe.level_flight
        for name in ("maximum_electric_power_w", "propulsion_efficiency"):
            if getattr(flight, name) is None:
                message = "required key is missing: the mission has climb"
                raise ClimbLimitError(("airframe", "level_flight", name), message)
        assert flight.propulsion_efficiency is not None
        assert flight.maximum_electric_power_w is not None
        return ClimbLimits(flight.propulsion_efficiency, flight.maximum_electric_power_w)
    assert design.chain is not None
    return ClimbLimits(design.chain.efficiency, design.rated_power_w)


def checked_climb_limits(aircraft: Aircraft, design: Design) -> ClimbLimits:
    """Limits of one design whose largest power must be above that of level flight."""
    limits = climb_limits(aircraft, design)
    level_w = float(design.propulsion_power_w)
    if float(limits.maximum_power_w) <= level_w:
        measured = isinstance(aircraft.airframe, MeasuredAirframe)
        raise ClimbLimitError(
            ("airframe", "level_flight", "maximum_electric_power_w")
            if measured
            else ("airframe", "propulsion", "climb_power_ratio"),
            f"{float(limits.maximum_power_w):.3g} W in all leaves nothing to climb with: level "
            f"flight takes {level_w:.3g} W; it must be more",
        )
    return ClimbLimits(float(limits.efficiency), float(limits.maximum_power_w))


def flight_levels(
    aircraft: Aircraft, mission: Mission, design: Design, day: SolarDay, *, paired: bool = False
) -> FlightLevels:
    """Power and sunlight between a mission's altitude and its ceiling, for the masses built.

    ``design``: one, or a batch; ``day``: with the light aloft. ``paired``: every design flies in
    its own scenario, else in every one. Returns elements in the order of designs, then scenarios.
    """
    assert mission.climb is not None
    altitudes = np.array(mission.climb_levels_m)
    scenarios = np.arange(len(day.scenarios))
    batch = np.shape(design.total_mass_kg)
    shape = batch if paired else (*batch, len(scenarios))

    def each(value: object) -> FloatArray:
        """Value of every element, from those of the designs or of the elements."""
        array = np.asarray(value, float)
        if not paired and array.ndim < len(shape):
            array = np.broadcast_to(array, batch)[..., np.newaxis]
        return np.broadcast_to(array, shape).ravel()

    missions = [mission.at_altitude(float(h)) for h in altitudes]
    slow = [_same_aircraft_at(aircraft, there, design) for there in missions]
    flights, held = _against_winds(aircraft, missions, slow, design, day, each, paired=paired)
    weight_n = each(np.asarray(design.total_mass_kg) * GRAVITY_M_PER_S2)
    power_w = np.stack([each(d.propulsion_power_w) for d in flights])
    flies = np.isfinite(power_w).all(axis=0) & np.isfinite(weight_n) & held[0]
    parts = aircraft.propulsion_by_parts
    limits, cases = (
        climb_limits(aircraft, design),
        np.shape(flights[0].propulsion_power_w),
    )
    most_w = each(limits.maximum_power_w)
    thrust = load_shape(mission, day.time_h, day.sunrise_h, day.sunset_h)
    return FlightLevels(
        altitude_m=altitudes,
        power_w_per_m2=day.power_w_per_m2,
        cooling=day.cooling,
        module_area_m2=each(design.variables.module_area_m2),
        scenario=np.broadcast_to(scenarios, shape).ravel(),
        turbulence_factor=np.broadcast_to(thrust, day.specific_power_w_per_m2.shape),
        nominal_factor=each(load_range(mission.turbulence.all_day, 0.0)[0]),
        constant_power_w=each(design.constant_power_w),
        efficiency=each(limits.efficiency),
        maximum_power_w=np.where(flies, most_w, 0.0),
        flies=np.asarray(flies),
        design=np.asarray(each(np.arange(max(math.prod(cases), 1)).reshape(cases)), int),
        weight_n=np.where(flies, weight_n, 0.0),
        reach_m=_reach_m(altitudes - altitudes[0], power_w, held, most_w),
        chain=ConstantChain.of(flights, limits.efficiency)
        if parts is None
        else ClimbChain.of(parts, aircraft, missions, flights),
        convection_w_per_m2k=_convection(day.cooling, missions, slow, each),
    )


def _against_winds(
    aircraft: Aircraft,
    missions: Sequence[Mission],
    slow: list[Design],
    design: Design,
    day: SolarDay,
    each: Callable[[object], FloatArray],
    *,
    paired: bool,
) -> tuple[list[Design], BoolArray]:
    """Flight at all levels as fast as their winds where the place is held, and where it can be.

    Returns designs with an axis of scenarios where the place is held, and of shape ``(level,
    element)`` whether it can be.
    """

    def spread(value: Any) -> Any:
        return np.asarray(value) if paired else np.asarray(value)[..., np.newaxis]

    if not missions[0].holds_station:
        return slow, np.stack([each(1.0)] * len(slow)) > 0.0
    rated_w = spread(design.rated_power_w)
    pairs = [
        against_wind(
            *(aircraft, there, flight.mapped(spread)),
            *(there.scenario_winds_m_per_s(day.scenarios), rated_w),
        )
        for there, flight in zip(missions, slow, strict=True)
    ]
    flights = [flight for flight, _ in pairs]
    # A floor that is not held is no flight, of which a chain of parts knows by its power.
    floor_w = np.where(pairs[0][1], flights[0].propulsion_power_w, np.inf)
    flights[0] = flights[0]._replace(propulsion_power_w=floor_w)
    return flights, np.stack([each(able) for _, able in pairs]) > 0.0


def _reach_m(
    height_m: FloatArray, power_w: FloatArray, held: BoolArray, most_w: FloatArray
) -> FloatArray:
    """Height below the first level whose wind is not held [m], ``(element,)``.

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


def _convection(
    cooling: Cooling | None,
    missions: Sequence[Mission],
    designs: Sequence[Design],
    each: Callable[[object], FloatArray],
) -> FloatArray:
    """Convection of every element at all levels, ``(element, level)``; zero where none cools."""
    if cooling is None:
        return np.zeros((len(each(0.0)), len(missions)))
    flights = zip(designs, missions, cooling.convection.tolist(), strict=True)
    transition = cooling.transition_reynolds
    return np.stack(
        [each(convection_of(*flight[:2], transition, flight[2])) for flight in flights], axis=-1
    )


def _same_aircraft_at(aircraft: Aircraft, there: Mission, design: Design) -> Design:
    """Level flight of given mass at another altitude, of a batch infinite power without any."""
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return measured_design(aircraft, there)
    with np.errstate(over="ignore", invalid="ignore"):
        flight = parametric_design(aircraft, there, design.variables, design.total_mass_kg)
    if np.ndim(design.total_mass_kg) == 0 and not np.isfinite(flight.propulsion_power_w):
        raise ImpossibleDesignError(operating_trouble(aircraft, there))
    return flight
