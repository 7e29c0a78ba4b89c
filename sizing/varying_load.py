"""Load of an aircraft whose propulsion has the efficiency of the moment.

With parts at their operating point the electric power follows the thrust power of turbulence and
thermals, and the voltage of the battery. The voltage follows the charge, which follows the load: a
day is marched with the voltages of the march before, until they stay.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from missions.air import Air
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import NO_FLIGHT_W, Design, FlightConditions, bus_voltage_v
from sizing.energy.battery import Battery, Store
from sizing.energy.battery_voltage import CHARGE_SHARES, FIRST_CHARGE
from sizing.energy.cycle import Cycle, simulate_cycle, simulate_flight
from sizing.held_station import flight_against_wind
from sizing.mass_budget import ImpossibleDesignError
from sizing.propulsion.chain import OperatingPointPropulsion
from sizing.propulsion.part_load import PartLoad, load_range
from sizing.smooth import Value
from sizing.sunlight import SolarDay
from solar.sun import HOURS_PER_DAY
from solar.types import BoolArray, FloatArray

# A day is marched again until load and nominal load stay within this, relative, which is 1e-5 h of
# excess time. Each march leaves less than a hundredth of the error of the one before.
_SETTLED, _ROUNDS = 1e-6, 6

Flown = TypeVar("Flown")


def part_load_of(
    aircraft: Aircraft,
    mission: Mission,
    design: Design,
) -> PartLoad | None:
    """Power of the propulsion over load and voltage; None where its efficiencies are constants.

    The load is that of the mission's turbulence and thermals. Raises
    :class:`ImpossibleDesignError` for a single design whose propeller's data end before.
    """
    if aircraft.propulsion_by_parts is None:
        return None
    turbulence = mission.turbulence
    ends = load_range(turbulence.all_day, turbulence.thermal)
    level_w = np.asarray(design.propulsion_power_w, float)
    own, flight = flight_of(aircraft, mission, design)
    volts, flies = bus_voltage_v(aircraft), np.isfinite(level_w)
    if not (own.is_exact and level_w.ndim == 0 and flies):
        return part_load_over(own, flight, np.where(flies, level_w, np.inf), ends, volts)
    numbers = Flight(
        float(flight.thrust_w),
        float(flight.airspeed_m_per_s),
        Air(*(float(one) for one in flight.air)),  # type: ignore[arg-type]  # as a cache's key
    )
    load = float(ends[0]), float(ends[1])
    found = _part_load_of_one(own, numbers, float(level_w), load, volts)
    if found.beyond:
        reason = own.point(flight.thrust_w * load[1], *flight[1:], volts).reason
        raise ImpossibleDesignError(
            f"the propulsion of {aircraft.name} cannot do {load[1]:.3g} times the power of level "
            f"flight, in turbulence and thermals of {mission.name}: {reason}"
        )
    return found


def by_own_charge(
    load_w: Callable[[FloatArray], FloatArray],
    fly: Callable[[FloatArray], tuple[Flown, FloatArray]],
    battery: Battery,
) -> Flown:
    """Flight whose load has the voltages of its own charge.

    ``load_w``: of voltages; ``fly``: flight of a load, and its state of charge where that is.
    """
    load = load_w(battery.bus_voltage_v(np.array(FIRST_CHARGE)))
    for _ in range(_ROUNDS):
        flown, charge = fly(load)
        before, load = load, load_w(battery.bus_voltage_v(charge))
        if np.all(np.abs(load - before) <= _SETTLED * before):
            break
    return flown


def interpolation_error(aircraft: Aircraft, mission: Mission, design: Design) -> float:
    """Largest relative error of a single design's table, half-way between its nodes."""
    part = part_load_of(aircraft, mission, design)
    assert part is not None
    own, flight = flight_of(aircraft, mission, design)
    load, bus_v = part.between()
    load = load[:, np.newaxis]
    exact_w = own.bus_power_w(flight.thrust_w * load, *flight[1:], bus_v)
    return float(np.max(np.abs(part.at(load, bus_v) * design.propulsion_power_w / exact_w - 1.0)))


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
    volts: tuple[float, float],
) -> PartLoad:
    """Power of a propulsion over loads and voltages, relative to that of a level flight.

    ``level_w``: electric power of that flight [W], of the shape of what ``flight`` has.
    """

    def power_w(load: FloatArray, bus_v: FloatArray) -> Any:
        return own.bus_power_w(flight.thrust_w * load, *flight[1:], bus_v)

    return PartLoad.of(power_w, level_w, loads, volts)


def _part_load_against_wind(
    aircraft: Aircraft,
    mission: Mission,
    design: Design,
    power_w: FloatArray,
    thrust_w: FloatArray,
    airspeed_m_per_s: FloatArray,
) -> PartLoad | None:
    """Power over load and voltage of flight at airspeeds of its own; None by constants.

    ``power_w``: of level flight at them; of scenarios, ``design`` with an axis for them.
    """
    if (propulsion := aircraft.propulsion_by_parts) is None:
        return None
    own = propulsion.sized(*design.variables.of_propulsion)
    air = FlightConditions.of(mission, aircraft).air
    flight = Flight.where(np.isfinite(power_w), thrust_w, airspeed_m_per_s, air)
    loads = load_range(mission.turbulence.all_day, mission.turbulence.thermal)
    return part_load_over(own, flight, power_w, loads, bus_voltage_v(aircraft))


@lru_cache(maxsize=16)
def _part_load_of_one(
    own: OperatingPointPropulsion,
    flight: Flight,
    level_w: float,
    loads: tuple[float, float],
    volts: tuple[float, float],
) -> PartLoad:
    """Table of one design, which several flights share: its rotations are searched for once."""
    ends = np.asarray(loads[0]), np.asarray(loads[1])
    return part_load_over(own, flight, np.asarray(level_w), ends, volts)


@dataclass(frozen=True)
class DesignLoads:
    """Solar power and load of every design in every scenario of a day.

    ``part_load``: None for an efficiency that is constant. ``paired``: each design flies in its own
    scenario. ``own_solar_w``: power of the modules, where it is not that of the day.
    ``own_propulsion_w``: of level flight in every scenario, where it is not that of the design.
    """

    design: Design
    mission: Mission
    day: SolarDay
    part_load: PartLoad | None = None
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

    @property
    def follows_voltage(self) -> bool:
        """Whether the charge makes a difference to the load."""
        return self.part_load is not None and self.part_load.follows_voltage

    def load_w(self, bus_v: FloatArray | None = None) -> FloatArray:
        """Load at voltages at the nodes [W], by default those of the end that takes more."""
        day, part = self.day, self._part
        load: FloatArray = load_profile(
            day.time_h, self._in_scenarios, self.mission, day.sunrise_h, day.sunset_h, part, bus_v
        )
        return np.broadcast_to(load, np.broadcast_shapes(load.shape, self.solar_w.shape))

    def nominal_w(self, bus_v: FloatArray | None = None) -> FloatArray:
        """Nominal load [W], ``(..., scenario)``; at voltages ``(..., scenario, step)``."""
        flown, part = self._in_scenarios, self._part
        if part is None:
            return np.asarray(flown.nominal_load_w(self.mission))
        load, _ = load_range(self.mission.turbulence.all_day, 0.0)
        ratio = part.at(load[..., np.newaxis], bus_v)
        level_w, constant_w = (
            np.asarray(one)[..., np.newaxis]
            for one in (flown.propulsion_power_w, flown.constant_power_w)
        )
        nominal: FloatArray = level_w * ratio + constant_w
        return nominal[..., 0] if bus_v is None else nominal

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
    def _part(self) -> PartLoad | None:
        """Part load with axes for scenarios and time."""
        if self.part_load is None:
            return None
        # As fast as the wind every scenario has its own already.
        return self.part_load.spread(1 if self.own_propulsion_w is not None else 2 - self.paired)

    def _over_scenarios(self, value: ArrayLike) -> FloatArray:
        return np.asarray(value) if self.paired else np.asarray(value)[..., np.newaxis]


def flown_cycle(
    loads: DesignLoads | Sequence[DesignLoads],
    store: Store,
    battery: Battery,
    *,
    keep_trajectory: bool = True,
) -> tuple[Cycle, FloatArray, FloatArray]:
    """Cycle, load and nominal load [W]; of a sequence stacked on a first axis.

    Of a mission with a flight from launch to landing the cycle is that flight's.

    A load that follows the voltage has that of its own charge. Its nominal load, by which a battery
    lasts for the excess time, is the mean over the voltages from the charge at the morning's equal
    power down to the empty battery.
    """
    variants = [loads] if isinstance(loads, DesignLoads) else list(loads)

    def joined(parts: Sequence[FloatArray]) -> FloatArray:
        return parts[0] if isinstance(loads, DesignLoads) else np.stack(parts)

    def each(voltages: FloatArray) -> Iterator[tuple[DesignLoads, FloatArray]]:
        parts = [voltages] if isinstance(loads, DesignLoads) else list(voltages)
        return zip(variants, parts, strict=True)

    time_h, solar_w = variants[0].day.time_h, joined([one.solar_w for one in variants])
    window_h = variants[0].mission.flight_window_h(variants[0].day.scenarios)

    def flown(load_w: FloatArray, nominal_w: FloatArray, *, keep: bool) -> Cycle:
        powers = time_h, solar_w, load_w, store
        if window_h is None:
            return simulate_cycle(*powers, nominal_load_w=nominal_w, keep_trajectory=keep)
        return simulate_flight(*powers, window_h, nominal_load_w=nominal_w, keep_trajectory=keep)

    if not any(one.follows_voltage for one in variants):
        load_w = joined([one.load_w() for one in variants])
        nominal_w = joined([one.nominal_w() for one in variants])
        return flown(load_w, nominal_w, keep=keep_trajectory), load_w, nominal_w
    first_v = battery.bus_voltage_v(np.array([FIRST_CHARGE]))
    load_w = joined([one.load_w(first_v) for one in variants])
    nominal_w = joined([one.nominal_w(first_v)[..., 0] for one in variants])
    for _ in range(_ROUNDS):
        cycle = flown(load_w, nominal_w, keep=True)
        charge = cycle.energy_wh / np.asarray(store.battery_energy_wh)[..., np.newaxis]
        by_night = _charge_at_dawn(cycle, nominal_w, store)[..., np.newaxis] * CHARGE_SHARES
        here, later = (battery.bus_voltage_v(one) for one in (charge, by_night))
        next_w = joined([one.load_w(bus_v) for one, bus_v in each(here)])
        over_night = joined([one.nominal_w(bus_v) for one, bus_v in each(later)])
        next_nominal_w = 1.0 / np.mean(1.0 / over_night, axis=-1)
        # Element by element: what becomes of one does not depend on the others.
        moved = np.any(np.abs(next_w - load_w) > _SETTLED * load_w, axis=-1)
        moved |= np.abs(next_nominal_w - nominal_w) > _SETTLED * nominal_w
        if not np.any(moved):
            return cycle, load_w, nominal_w
        before_w, before_nominal_w = load_w, nominal_w
        load_w = np.where(moved[..., np.newaxis], next_w, load_w)
        nominal_w = np.where(moved, next_nominal_w, nominal_w)
    # On the edge of perpetual flight a day leaps to and fro with its voltages: the heavier counts.
    load_w, nominal_w = np.maximum(load_w, before_w), np.maximum(nominal_w, before_nominal_w)
    return flown(load_w, nominal_w, keep=keep_trajectory), load_w, nominal_w


def _charge_at_dawn(cycle: Cycle, nominal_w: FloatArray, store: Store) -> FloatArray:
    """State of charge at the morning's equal power, which the excess time was taken from."""
    hours = np.where(np.isfinite(cycle.excess_time_h), np.maximum(cycle.excess_time_h, 0.0), 0.0)
    usable_wh = np.asarray(store.battery_energy_wh) * store.discharge_efficiency
    return np.clip(hours * nominal_w / usable_wh, 0.0, 1.0)


def load_profile(
    time_h: ArrayLike,
    design: Design,
    mission: Mission,
    sunrise_h: ArrayLike,
    sunset_h: ArrayLike,
    part_load: PartLoad | None = None,
    bus_v: FloatArray | None = None,
) -> Value:
    """Load over the day: level flight, turbulence and thermals.

    ``mission``: with its turbulence; draws of it are arrays of the batch. ``part_load``: power of a
    propulsion whose efficiency is that of the moment, with axes for scenarios and time; ``bus_v``:
    voltage at the nodes, by default that of :meth:`PartLoad.at`. Returns power that the aircraft
    draws [W].
    """
    propulsion = np.asarray(design.propulsion_power_w)[..., np.newaxis]
    constant = np.asarray(design.constant_power_w)[..., np.newaxis]
    if part_load is None and not np.any(mission.turbulence.thermal):
        load = propulsion * (1.0 + np.asarray(mission.turbulence.all_day, float)[..., np.newaxis])
        load = load + constant
        shape = np.broadcast_shapes(load.shape, (*np.shape(sunrise_h), np.size(time_h)))
        return np.broadcast_to(load, shape)
    thrust = load_shape(mission, time_h, sunrise_h, sunset_h)
    return propulsion * (thrust if part_load is None else part_load.at(thrust, bus_v)) + constant


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
