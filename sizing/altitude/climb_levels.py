"""Aircraft between their lowest altitude and their ceiling: power, sunlight, potential energy."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.altitude.climb_chain import ClimbChain
from sizing.design import NO_FLIGHT_W, Design, parametric_design
from sizing.held_station import against_wind
from sizing.mass_budget import ImpossibleDesignError, measured_design, operating_trouble
from sizing.module_power import Cooling, convection_of, joined_cooling
from sizing.sunlight import SolarDay
from sizing.varying_load import thermal_shape
from solar.types import BoolArray, FloatArray, IntArray

_GLIDE_POINTS = 2001
_DESIGNS_AT_ONCE = 512  # whose propulsion is tabulated together
# Fields of the levels that every element has one of.
_OF_EACH = (
    *("module_area_m2", "scenario", "nominal_factor", "constant_power_w"),
    *("efficiency", "maximum_power_w", "flies", "design", "highest_wh"),
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

    One element is one aircraft in one scenario. ``altitude_m``, of shape ``(level,)``;
    ``potential_energy_wh``, ``propulsion_power_w``, of shape ``(level, element)``: energy of
    altitude and speed above that of the lowest level [Wh], and electric propulsion power of level
    flight in calm air [W]. ``specific_power_w_per_m2``: of the solar modules, of shape ``(level,
    scenario, time)``; ``module_area_m2`` and ``scenario`` of every element say how much of which.
    ``turbulence_factor``, of shape ``(scenario, time)``: factor on the propulsion power [-]. Of
    every element: ``nominal_factor`` is that without thermals, ``constant_power_w`` of avionics
    and payload [W], ``efficiency`` and ``maximum_power_w`` of the propulsion, whether it ``flies``
    at all levels, and ``highest_wh``, the potential energy that it may climb to: that of the
    ceiling, or of where the wind takes all its power. ``chain``: propulsion of every ``design``
    whose efficiency is that of the moment; None where it is the constant ``efficiency``.
    """

    altitude_m: FloatArray
    potential_energy_wh: FloatArray
    propulsion_power_w: FloatArray
    specific_power_w_per_m2: FloatArray
    module_area_m2: FloatArray
    scenario: IntArray
    turbulence_factor: FloatArray
    nominal_factor: FloatArray
    constant_power_w: FloatArray
    efficiency: FloatArray
    maximum_power_w: FloatArray
    flies: BoolArray
    design: IntArray
    highest_wh: FloatArray
    chain: ClimbChain | None = None
    cooling: tuple[Cooling | None, ...] = ()
    convection_w_per_m2k: FloatArray | None = None

    def cooling_factor(self, level: int) -> FloatArray | None:
        """Factor on the specific power by an element's own flow, ``(element, time)``; None: 1."""
        cooling = self.cooling[level] if self.cooling else None
        if cooling is None:
            return None
        assert self.convection_w_per_m2k is not None
        own = cooling.with_arrays([one[self.scenario] for one in cooling.arrays()])
        return own.factor(self.convection_w_per_m2k[level, :, np.newaxis])

    @property
    def thrust_power_w(self) -> FloatArray:
        """Drag times airspeed of level flight in calm air [W], ``(level, element)``."""
        if self.chain is None:
            return self.efficiency * self.propulsion_power_w
        return self.chain.thrust_w[:, self.design]

    @property
    def nominal_load_w(self) -> FloatArray:
        """Load at the lowest altitude without thermals [W]."""
        return np.asarray(self.propulsion_power_w[0] * self.nominal_factor + self.constant_power_w)

    def select(self, some: slice | IntArray | BoolArray) -> FlightLevels:
        """Flights of a part of the elements."""
        by_level = ("potential_energy_wh", "propulsion_power_w")
        rows = {name: getattr(self, name)[:, some] for name in by_level}
        if self.convection_w_per_m2k is not None:
            rows["convection_w_per_m2k"] = self.convection_w_per_m2k[:, some]
        rows |= {name: getattr(self, name)[some] for name in _OF_EACH}
        chain = self.chain
        if chain is not None and chain.count > _DESIGNS_AT_ONCE:
            designs, rows["design"] = np.unique(rows["design"], return_inverse=True)
            chain = chain.select(designs)
        return replace(self, **rows, chain=chain)

    @classmethod
    def joined(cls, several: Sequence[FlightLevels]) -> FlightLevels:
        """Flights at the same levels, each in its own scenarios."""
        first = [0, *np.cumsum([one.specific_power_w_per_m2.shape[1] for one in several])]
        along = {
            1: ("potential_energy_wh", "propulsion_power_w", "specific_power_w_per_m2"),
            0: ("turbulence_factor", *_OF_EACH),
        }
        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(one, name) for one in several], axis=axis)
            for axis, names in along.items()
            for name in names
        }
        places = [one.scenario + n for one, n in zip(several, first, strict=False)]
        arrays["scenario"] = np.concatenate(places)
        known = (one.convection_w_per_m2k for one in several)
        flows = [one for one in known if one is not None]
        if flows:
            arrays["convection_w_per_m2k"] = np.concatenate(flows, axis=1)
            levels = zip(*(one.cooling for one in several), strict=True)
            arrays["cooling"] = tuple(joined_cooling(one, np.concatenate) for one in levels)
        chains = [one.chain for one in several if one.chain is not None]
        if len(chains) < len(several):
            return cls(several[0].altitude_m, **arrays)
        before = np.cumsum([0, *(one.count for one in chains)])
        own = [one.design + n for one, n in zip(several, before, strict=False)]
        arrays["design"] = np.concatenate(own)
        return cls(several[0].altitude_m, **arrays, chain=ClimbChain.joined(chains))

    def altitude_at(self, potential_energy_wh: FloatArray) -> FloatArray:
        """Altitude of potential energies, elements first [m]."""
        rows = zip(potential_energy_wh, self.potential_energy_wh.T, strict=True)
        found = [np.interp(row, energies, self.altitude_m) for row, energies in rows]
        # Without any flight all levels have the same energy.
        return np.where(self.flies[:, np.newaxis], np.array(found), self.altitude_m[0])

    def glide_h(self, potential_energy_wh: FloatArray) -> FloatArray:
        """Hours of gliding from the potential energy of every element with the motor off [h]."""
        hours, scale, power_w = (
            np.zeros(np.shape(potential_energy_wh)),
            *(
                (self.efficiency, self.propulsion_power_w)
                if self.chain is None
                else (np.ones(len(self.design)), self.thrust_power_w)
            ),
        )
        for place in np.flatnonzero(potential_energy_wh):
            known = self.potential_energy_wh[:, place]
            energies = np.linspace(0.0, known[-1], _GLIDE_POINTS)
            level_w = np.interp(energies, known, power_w[:, place])
            slowness = 1.0 / (scale[place] * (level_w * self.nominal_factor[place]))
            each = np.diff(energies) * (slowness[1:] + slowness[:-1]) / 2.0
            summed = np.concatenate(([0.0], np.cumsum(each)))
            hours[place] = np.interp(potential_energy_wh[place], energies, summed)
        return hours


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
    light = day.aloft_w_per_m2
    assert mission.climb is not None
    assert light is not None  # the day is that of the mission
    altitudes = np.array(mission.climb_levels_m)
    scenarios = np.arange(light.shape[1])
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
    potential_wh = _potential_wh(altitudes, flown, weight_n, each)
    power_w = np.stack([each(d.propulsion_power_w) for d in flown])
    flies = np.isfinite(power_w).all(axis=0) & np.isfinite(potential_wh).all(axis=0) & held[0]
    # Never falling: levels are looked up by it, and a wind may fall faster than height stores.
    potential_wh = np.maximum.accumulate(np.where(flies, potential_wh, 0.0))
    limits, own = climb_limits(aircraft, design), np.shape(flown[0].propulsion_power_w)
    most_w = each(limits.maximum_power_w)
    thermal = thermal_shape(day.time_h, day.sunrise_h, day.sunset_h)
    # Draws of uncertain inputs are arrays of the elements.
    all_day, most = (
        np.asarray(value, float)[..., np.newaxis]
        for value in (mission.turbulence.all_day, mission.turbulence.thermal)
    )
    steady = 1.0 + all_day
    return FlightLevels(
        altitude_m=altitudes,
        potential_energy_wh=potential_wh,
        propulsion_power_w=np.where(flies, power_w, NO_FLIGHT_W),
        specific_power_w_per_m2=light,
        module_area_m2=each(design.variables.module_area_m2),
        scenario=np.broadcast_to(scenarios, shape).ravel(),
        turbulence_factor=np.broadcast_to(steady + most * thermal, light.shape[1:]),
        nominal_factor=each(steady[..., 0]),
        constant_power_w=each(design.constant_power_w),
        efficiency=each(limits.efficiency),
        maximum_power_w=np.where(flies, most_w, 0.0),
        flies=np.asarray(flies),
        design=np.asarray(each(np.arange(max(math.prod(own), 1)).reshape(own)), int),
        highest_wh=_highest_wh(potential_wh, power_w, held, most_w),
        chain=ClimbChain.of(aircraft, missions, flown),
        cooling=day.aloft_cooling,
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


def _potential_wh(
    altitude_m: FloatArray,
    flown: Sequence[Design],
    weight_n: FloatArray,
    each: Callable[[object], FloatArray],
) -> FloatArray:
    """Energy of height and speed above that of the lowest level, ``(level, element)``."""
    speeds = [0.0 if one.airspeed_m_per_s is None else one.airspeed_m_per_s for one in flown]
    height_m = np.stack(
        [each(h + np.square(v) / _TWICE_GRAVITY) for h, v in zip(altitude_m, speeds, strict=True)]
    )
    with np.errstate(invalid="ignore"):  # of designs that cannot carry themselves
        return np.asarray(weight_n * (height_m - height_m[0]) / 3600.0)


def _highest_wh(
    potential_wh: FloatArray, power_w: FloatArray, held: BoolArray, most_w: FloatArray
) -> FloatArray:
    """Potential energy below the first level whose wind is not held, ``(element,)``.

    Where the power, linear between levels, is the largest; at the level below where that of the
    first is not known.
    """
    columns, first = np.arange(len(most_w)), np.argmin(held, axis=0)
    below = np.maximum(first - 1, 0)
    (low_w, beyond_w), (low_wh, beyond_wh) = (
        (rows[below, columns], rows[first, columns]) for rows in (power_w, potential_wh)
    )
    with np.errstate(invalid="ignore", divide="ignore"):  # of designs that do not fly
        rise_w = np.where(beyond_w > most_w, beyond_w - low_w, np.inf)
        share = np.clip((most_w - low_w) / rise_w, 0.0, 1.0)
    share = np.where(held[0], share, 0.0)  # a floor that is not held has no power to compare
    short_wh = low_wh + share * (beyond_wh - low_wh)
    return np.asarray(np.where(held.all(axis=0), potential_wh[-1], short_wh))


def _convection(
    day: SolarDay,
    missions: Sequence[Mission],
    flown: Sequence[Design],
    each: Callable[[object], FloatArray],
) -> FloatArray | None:
    """Convection of every element at all levels; None of a day without it."""
    if not day.aloft_cooling:
        return None
    known = [
        0.0
        if cooling is None
        else convection_of(one, there, cooling.transition_reynolds, cooling.convection)
        for cooling, one, there in zip(day.aloft_cooling, flown, missions, strict=True)
    ]
    return np.stack([each(one) for one in known])


_TWICE_GRAVITY = 2.0 * GRAVITY_M_PER_S2


def _same_aircraft_at(aircraft: Aircraft, there: Mission, design: Design) -> Design:
    """Level flight of given mass at another altitude, of a batch infinite power without any."""
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return measured_design(aircraft, there)
    with np.errstate(over="ignore", invalid="ignore"):
        flown = parametric_design(aircraft, there, design.variables, design.total_mass_kg)
    if np.ndim(design.total_mass_kg) == 0 and not np.isfinite(flown.propulsion_power_w):
        raise ImpossibleDesignError(operating_trouble(aircraft, there))
    return flown
