"""Aircraft between their lowest altitude and their ceiling: power, sunlight, potential energy."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.chain_at_heights import ClimbChain, ConstantChain
from sizing.day.light import Light, SolarDay
from sizing.day.load import load_shape
from sizing.day.module_power import convection_of
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

# Fields of the levels that every element has one of.
_OF_EACH = (
    *("module_area_m2", "scenario", "nominal_factor", "constant_power_w"),
    *("efficiency", "maximum_power_w", "flies", "design", "weight_n", "reach_m"),
)


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

    One element is one aircraft in one scenario. ``altitude_m`` and ``light``: of every level;
    ``module_area_m2`` and ``scenario`` of every element say how much of which.
    ``turbulence_factor``, of shape ``(scenario, time)``: factor on the propulsion power [-]. Of
    every element: ``nominal_factor`` is that without thermals, ``constant_power_w`` of avionics
    and payload [W], ``efficiency`` and ``maximum_power_w`` of the propulsion, whether it ``flies``
    at all levels, its weight, and ``reach_m``, the height above the lowest altitude that it may
    climb to: that of the ceiling, or of where the wind takes all its power. ``chain``: propulsion
    of every ``design`` at all levels.
    """

    altitude_m: FloatArray
    light: tuple[Light, ...]
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
    convection_w_per_m2k: FloatArray | None = None

    def cooling_factor(self, level: int, some: slice = slice(None)) -> FloatArray | None:
        """Factor on the specific power by elements' own flow, ``(element, time)``; None: 1."""
        if (cooling := self.light[level].cooling) is None:
            return None
        assert self.convection_w_per_m2k is not None
        own = cooling.with_arrays([one[self.scenario[some]] for one in cooling.arrays()])
        return own.factor(self.convection_w_per_m2k[level, some, np.newaxis])

    @cached_property
    def _rows(self) -> IntArray:
        """Rows of the chain's tables, ``(level, element)``."""
        levels = np.arange(len(self.altitude_m))[:, np.newaxis]
        return np.asarray(levels * self.chain.count + self.design)

    @property
    def level_power_w(self) -> FloatArray:
        """Electric propulsion power of level flight in calm air [W], ``(level, element)``."""
        return self.chain.power_w(self._rows, np.ones(self._rows.shape))

    @cached_property
    def nominal_load_w(self) -> FloatArray:
        """Load at the lowest altitude without thermals [W]."""
        motor_w = self.chain.power_w(self._rows[0], self.nominal_factor)
        return np.asarray(motor_w + self.constant_power_w)

    @cached_property
    def most_power_w(self) -> FloatArray:
        """Electric power that the propulsion gives at all levels [W]."""
        most_w = self.chain.most_w(self._rows).min(axis=0)
        return np.asarray(np.minimum(self.maximum_power_w, most_w))

    @cached_property
    def _specific_power_w_per_m2(self) -> FloatArray:
        """Light of all levels, ``(level, scenario, time)``."""
        return np.stack([one.power_w_per_m2 for one in self.light])

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
        factor = self.turbulence_factor[self.scenario]

        def motor_w(level: IntArray) -> FloatArray:
            load = factor + climb_w / self.chain.thrust_w[level, self.design[:, np.newaxis]]
            return self.chain.power_w(self._rows[level, element], load)

        load_w = between(motor_w) + self.constant_power_w[:, np.newaxis]
        solar_w = between(self._light_at) * self.module_area_m2[:, np.newaxis]
        return solar_w, load_w

    def _light_at(self, level: IntArray, some: slice = slice(None)) -> FloatArray:
        """Specific power of some elements at a level of every time."""
        light = self._specific_power_w_per_m2
        power = light[level, self.scenario[some, np.newaxis], np.arange(light.shape[-1])]
        for number in np.unique(level).tolist() if self.light[0].cooling else ():
            if (factor := self.cooling_factor(number, some)) is not None:
                power = np.where(level == number, power * factor, power)
        return np.asarray(power)

    def at_heights(self, element: int, height_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Solar power, ``(height, time)``, and power of level flight of an element at heights."""
        some, levels = slice(element, element + 1), len(self.altitude_m)
        power_w = self.level_power_w[:, element]
        every = np.zeros((1, self._specific_power_w_per_m2.shape[-1]), int)
        light = np.concatenate([self._light_at(every + n, some) for n in range(levels)])
        below, upper = self._place(height_m)
        power_w = (1.0 - upper) * power_w[below] + upper * power_w[below + 1]
        share = upper[:, np.newaxis]
        solar_w = (1.0 - share) * light[below] + share * light[below + 1]
        return solar_w * self.module_area_m2[element], power_w

    def select(self, some: slice | IntArray | BoolArray) -> FlightLevels:
        """Flights of a part of the elements."""
        rows: dict[str, Any] = {}
        if self.convection_w_per_m2k is not None:
            rows["convection_w_per_m2k"] = self.convection_w_per_m2k[:, some]
        rows |= {name: getattr(self, name)[some] for name in _OF_EACH}
        return replace(self, **rows)


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
    flown, held = _against_winds(aircraft, missions, slow, design, day, each, paired=paired)
    weight_n = each(np.asarray(design.total_mass_kg) * GRAVITY_M_PER_S2)
    power_w = np.stack([each(d.propulsion_power_w) for d in flown])
    flies = np.isfinite(power_w).all(axis=0) & np.isfinite(weight_n) & held[0]
    parts = aircraft.propulsion_by_parts
    limits, own = climb_limits(aircraft, design), np.shape(flown[0].propulsion_power_w)
    most_w = each(limits.maximum_power_w)
    thrust = load_shape(mission, day.time_h, day.sunrise_h, day.sunset_h)
    return FlightLevels(
        altitude_m=altitudes,
        light=day.levels,
        module_area_m2=each(design.variables.module_area_m2),
        scenario=np.broadcast_to(scenarios, shape).ravel(),
        turbulence_factor=np.broadcast_to(thrust, day.specific_power_w_per_m2.shape),
        nominal_factor=each(load_range(mission.turbulence.all_day, 0.0)[0]),
        constant_power_w=each(design.constant_power_w),
        efficiency=each(limits.efficiency),
        maximum_power_w=np.where(flies, most_w, 0.0),
        flies=np.asarray(flies),
        design=np.asarray(each(np.arange(max(math.prod(own), 1)).reshape(own)), int),
        weight_n=np.where(flies, weight_n, 0.0),
        reach_m=_reach_m(altitudes - altitudes[0], power_w, held, most_w),
        chain=ConstantChain.of(flown, limits.efficiency)
        if parts is None
        else ClimbChain.of(parts, aircraft, missions, flown),
        convection_w_per_m2k=_convection(day, missions, slow, each),
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
    found = [
        against_wind(
            *(aircraft, there, own.mapped(spread)),
            *(there.scenario_winds_m_per_s(day.scenarios), rated_w),
        )
        for there, own in zip(missions, slow, strict=True)
    ]
    flown = [one for one, _ in found]
    # A floor that is not held is no flight, of which a chain of parts knows by its power.
    floor_w = np.where(found[0][1], flown[0].propulsion_power_w, np.inf)
    flown[0] = flown[0]._replace(propulsion_power_w=floor_w)
    return flown, np.stack([each(able) for _, able in found]) > 0.0


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
    day: SolarDay,
    missions: Sequence[Mission],
    flown: Sequence[Design],
    each: Callable[[object], FloatArray],
) -> FloatArray | None:
    """Convection of every element at all levels; None of a day without it."""
    if not day.is_cooled:
        return None
    known = [
        0.0
        if (cooling := light.cooling) is None
        else convection_of(one, there, cooling.transition_reynolds, cooling.convection)
        for light, one, there in zip(day.levels, flown, missions, strict=True)
    ]
    return np.stack([each(one) for one in known])


def _same_aircraft_at(aircraft: Aircraft, there: Mission, design: Design) -> Design:
    """Level flight of given mass at another altitude, of a batch infinite power without any."""
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return measured_design(aircraft, there)
    with np.errstate(over="ignore", invalid="ignore"):
        flown = parametric_design(aircraft, there, design.variables, design.total_mass_kg)
    if np.ndim(design.total_mass_kg) == 0 and not np.isfinite(flown.propulsion_power_w):
        raise ImpossibleDesignError(operating_trouble(aircraft, there))
    return flown
