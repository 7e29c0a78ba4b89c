"""Height as a second store: climb with surplus power by day, sink back in the evening.

The state is the stored electric energy ``E`` and the stored height ``W = m g h_e``, with the
energy height ``h_e = h + V^2 / 2g`` above that of level flight at the lowest altitude. With the
solar power ``S``, the constant load ``C`` and the propulsion power of level flight ``R``, all at
the height of the moment, and ``eta`` the efficiency of the propulsion:

* Surplus, ``S > C + R``: the battery is charged as fast as it can be. What is left over climbs,
  ``dW/dt = eta P_climb``, up to the propulsion's largest power and the ceiling: once the battery is
  full, or at any time (:class:`missions.mission.Climb`). The rest is not used.
* Deficit, ``S < C + R``, while there is height: the motor gets ``S - C`` or nothing, and the
  aircraft sinks, ``dW/dt = -eta (R - P_motor)``. The battery gives what the avionics lack.
* Deficit at the lowest altitude: the battery gives it all.

This is the energy-height method: Rutowski, E. S. (1954), Energy Approach to the General Aircraft
Performance Problem, J. Aeronaut. Sci. 21 (3). Drag is that of level flight, which shallow paths
keep to (1 - cos of 3 degrees is 0.1 %); efficiencies do not depend on the load.

Solar power and load are piecewise linear in time between the nodes of the day and linear in the
stored height between levels. A step takes both at the height extrapolated to its middle, so that
the error is of second order; without height it is the step of :mod:`sizing.energy_balance`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from missions.air import GRAVITY_M_PER_S2
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.cycle import Cycle, EnergyAccount, Status, equal_power
from sizing.design import Design, measured_design, parametric_design
from sizing.energy_balance import (
    BoolArray,
    FloatArray,
    Store,
    crossing_fraction,
    positive_part_wh,
)
from sizing.performance import (
    UNCORRECTED_CAM,
    Performance,
    SolarDay,
    SolarModel,
    performance,
    solar_day,
)

Strategy = Literal["battery_full", "surplus"]

STEPS_PER_NODE = 5  # of the day's axis: 1 min
# Between levels everything is linear: the pressure's curvature over 500 m is 0.05 %.
_LEVEL_SPACING_M = 500.0
_MAXIMUM_LEVELS = 21
_FULL = 1.0 - 1e-9  # of the capacity, as in sizing.cycle
_TOLERANCE = 1e-10  # of the capacity: gain of a cycle that repeats itself
_MAXIMUM_ROUNDS = 160
_PLAIN_ROUNDS = 4  # before an extrapolation
_LAST_ROUNDS = 40  # without any, for what extrapolating does not settle
_GLIDE_POINTS = 2001


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
    """One aircraft, of one mass, between the lowest altitude and the ceiling.

    ``altitude_m``, ``height_wh`` (stored height above the lowest level) and ``propulsion_power_w``
    (electric, level flight in calm air) have one entry per level, ``solar_power_w`` the shape
    ``(level, scenario, time)``; ``turbulence_factor`` on the propulsion power has the shape
    ``(scenario, time)``. ``nominal_factor`` is the factor without thermals.
    """

    altitude_m: FloatArray
    height_wh: FloatArray
    propulsion_power_w: FloatArray
    solar_power_w: FloatArray
    turbulence_factor: FloatArray
    nominal_factor: float
    constant_power_w: float
    limits: ClimbLimits

    def altitude_at(self, height_wh: FloatArray) -> FloatArray:
        """Altitude [m] of a stored height [Wh]."""
        return np.asarray(np.interp(height_wh, self.height_wh, self.altitude_m))

    @property
    def nominal_load_w(self) -> float:
        """Load at the lowest altitude without thermals [W]."""
        return float(self.propulsion_power_w[0]) * self.nominal_factor + self.constant_power_w

    def glide_h(self, height_wh: FloatArray) -> FloatArray:
        """Hours of gliding from a stored height with the motor off [h]."""
        heights = np.linspace(0.0, self.height_wh[-1], _GLIDE_POINTS)
        power = np.interp(heights, self.height_wh, self.propulsion_power_w) * self.nominal_factor
        slowness = 1.0 / (self.limits.efficiency * power)
        hours = np.concatenate(
            ([0.0], np.cumsum(np.diff(heights) * (slowness[1:] + slowness[:-1]) / 2.0))
        )
        return np.asarray(np.interp(height_wh, heights, hours))


@dataclass(frozen=True)
class ClimbAccount:
    """Where the energy of one cycle goes [Wh]; arrays of the scenarios.

    ``solar + unserved = constant_load + level_flight + propulsion_loss + stored + stored_height
    + charge_loss + discharge_loss + curtailed``. ``level_flight`` is the aerodynamic work of
    staying up (drag times airspeed), whether motor or height does it; ``climb_electric`` and
    ``glide_height`` are parts of the flows: electric energy spent on climbing, height given back.
    """

    solar_wh: FloatArray
    unserved_wh: FloatArray
    constant_load_wh: FloatArray
    level_flight_wh: FloatArray
    propulsion_loss_wh: FloatArray
    stored_wh: FloatArray
    stored_height_wh: FloatArray
    charge_loss_wh: FloatArray
    discharge_loss_wh: FloatArray
    curtailed_wh: FloatArray
    climb_electric_wh: FloatArray
    glide_height_wh: FloatArray

    @property
    def imbalance_wh(self) -> FloatArray:
        """What the account leaves unexplained [Wh]: rounding."""
        sources = self.solar_wh + self.unserved_wh
        uses = self.constant_load_wh + self.level_flight_wh + self.propulsion_loss_wh
        stores = self.stored_wh + self.stored_height_wh
        return (
            sources
            - uses
            - stores
            - self.charge_loss_wh
            - self.discharge_loss_wh
            - (self.curtailed_wh)
        )


@dataclass(frozen=True)
class ClimbCycle:
    """Converged cycles with height as a second store.

    ``cycle`` has the metrics of :mod:`sizing.cycle`, on the nodes of the day, with two extensions:
    excess time counts the glide from whatever height is left at the morning's equal power before
    the battery takes over, and the load is what motor and avionics draw in fact. Arrays of the
    trajectory have the shape ``(scenario, step)`` with the nodes ``time_h``; power is the mean of
    the step that begins there. ``gliding_h`` is the time of sinking after the last climb of the
    day.
    """

    cycle: Cycle
    account: ClimbAccount
    time_h: FloatArray
    altitude_m: FloatArray
    energy_wh: FloatArray
    solar_power_w: FloatArray
    load_w: FloatArray
    maximum_altitude_m: FloatArray
    maximum_height_wh: FloatArray
    gliding_h: FloatArray


@dataclass(frozen=True)
class ClimbPerformance:
    """Flight with climbs beside the flight at the mission's constant altitude.

    ``performance`` has the cycles, solar power and load of the flight with climbs.
    """

    performance: Performance
    constant: Performance
    climb: ClimbCycle
    limits: ClimbLimits

    @property
    def gain_h(self) -> FloatArray:
        """Excess time that climbing adds [h]; 0 where both are infinite."""
        ours, theirs = self.performance.cycle.excess_time_h, self.constant.cycle.excess_time_h
        endless = np.isinf(ours) & np.isinf(theirs)
        return np.where(endless, 0.0, ours - np.where(endless, 0.0, theirs))


def climb_limits(aircraft: Aircraft, design: Design) -> ClimbLimits:
    """Efficiency and largest power of the propulsion.

    Parametric: the rated power of the propulsion, sized at the mission's altitude. Measured: as
    the file says.

    Raises
    ------
    ClimbLimitError
        If the aircraft's file does not say how it climbs, or leaves no power for it.
    """
    airframe = aircraft.airframe
    if isinstance(airframe, MeasuredAirframe):
        flight = airframe.level_flight
        place = ("airframe", "level_flight")
        for name in ("maximum_electric_power_w", "propulsion_efficiency"):
            if getattr(flight, name) is None:
                message = "required key is missing: the mission has climb"
                raise ClimbLimitError((*place, name), message)
        assert flight.propulsion_efficiency is not None
        assert flight.maximum_electric_power_w is not None
        found = ClimbLimits(flight.propulsion_efficiency, flight.maximum_electric_power_w)
        key = (*place, "maximum_electric_power_w")
    else:
        weight_n = float(design.total_mass_kg) * GRAVITY_M_PER_S2
        level_w = float(design.propulsion_power_w)
        rated = float(airframe.propulsion.rated_power_w(level_w, weight_n=weight_n))
        found = ClimbLimits(airframe.propulsion.efficiency, rated)
        key = ("airframe", "propulsion", "climb_power_ratio")
    if found.maximum_power_w <= float(design.propulsion_power_w):
        raise ClimbLimitError(
            key,
            f"{found.maximum_power_w:.3g} W in all leaves nothing to climb with: level flight "
            f"takes {float(design.propulsion_power_w):.3g} W; it must be more",
        )
    return found


def climb_performance(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    solar_factor: float = 1.0,
) -> ClimbPerformance:
    """Simulate an aircraft on a mission with ``climb`` in every scenario.

    Parameters
    ----------
    aircraft, mission, solar
        As for :func:`sizing.performance.performance`.
    solar_factor : float
        Factor on all solar power, for what an error of the model does.

    Raises
    ------
    ValueError
        If the mission has no climb.
    ClimbLimitError
        If the aircraft has no power to climb with.
    """
    if mission.climb is None:
        raise ValueError(f"mission {mission.name} has no climb")
    lowest = mission.at_altitude(mission.altitude_m)
    day = solar_day(aircraft, lowest, solar).scaled(solar_factor)
    constant = performance(aircraft, lowest, solar, day=day)
    levels = flight_levels(aircraft, mission, solar, constant, solar_factor)
    flown = simulate_climb(day.time_h, levels, constant.store, mission.climb.strategy)
    nodes = slice(None, None, STEPS_PER_NODE)
    ours = replace(
        constant,
        mission=mission,
        solar_power_w=flown.solar_power_w[:, nodes],
        load_w=flown.load_w[:, nodes],
        cycle=flown.cycle,
    )
    return ClimbPerformance(ours, constant, flown, levels.limits)


def flight_levels(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    constant: Performance,
    solar_factor: float = 1.0,
) -> FlightLevels:
    """Power and sunlight between a mission's altitude and its ceiling, for the mass built."""
    assert mission.climb is not None
    design, day = constant.design, constant.day
    floor_m, ceiling_m = mission.altitude_m, mission.climb.ceiling_m
    count = int(np.ceil((ceiling_m - floor_m) / _LEVEL_SPACING_M - 1e-9)) + 1
    altitudes = np.linspace(floor_m, ceiling_m, min(max(count, 2), _MAXIMUM_LEVELS))
    flown = [_same_aircraft_at(aircraft, mission, design, float(h)) for h in altitudes]
    speed = np.array([0.0 if d.airspeed_m_per_s is None else d.airspeed_m_per_s for d in flown])
    energy_height_m = altitudes + speed**2 / (2.0 * GRAVITY_M_PER_S2)
    weight_n = float(design.total_mass_kg) * GRAVITY_M_PER_S2
    area_m2 = float(design.variables.module_area_m2)
    return FlightLevels(
        altitude_m=altitudes,
        height_wh=weight_n * (energy_height_m - energy_height_m[0]) / 3600.0,
        propulsion_power_w=np.array([float(d.propulsion_power_w) for d in flown]),
        solar_power_w=area_m2
        * np.stack(
            [
                _specific_power(aircraft, mission.at_altitude(float(h)), solar, day, solar_factor)
                for h in altitudes
            ]
        ),
        turbulence_factor=(constant.load_w - float(design.constant_power_w))
        / float(design.propulsion_power_w),
        nominal_factor=1.0 + mission.turbulence.all_day,
        constant_power_w=float(design.constant_power_w),
        limits=climb_limits(aircraft, design),
    )


def _same_aircraft_at(
    aircraft: Aircraft, mission: Mission, design: Design, altitude_m: float
) -> Design:
    """Level flight of an aircraft of given mass at another altitude."""
    there = mission.at_altitude(altitude_m)
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return measured_design(aircraft, there)
    return parametric_design(aircraft, there, design.variables, design.total_mass_kg)


def _specific_power(
    aircraft: Aircraft, there: Mission, solar: SolarModel, day: SolarDay, factor: float
) -> FloatArray:
    found = solar_day(aircraft, there, solar, scenarios=day.scenarios)
    return found.scaled(factor).specific_power_w_per_m2


def simulate_climb(
    time_h: FloatArray, levels: FlightLevels, store: Store, strategy: Strategy
) -> ClimbCycle:
    """Converge the cycle with height as a second store and measure it.

    Parameters
    ----------
    time_h : ndarray, shape (time,)
        Nodes over one day, 0 to 24 [h], both ends included.
    levels : FlightLevels
        Solar power, propulsion power and stored height over altitude.
    store : Store
        Batteries; ``energy_max_wh`` broadcasts with the scenarios.
    strategy : {"battery_full", "surplus"}
        When surplus power may be spent on climbing.

    Returns
    -------
    ClimbCycle
        Arrays of the scenarios.
    """
    scenarios = levels.solar_power_w.shape[1]
    energy_max = np.broadcast_to(store.energy_max_wh, (scenarios,)).astype(float)
    march = _March(time_h, levels, replace(store, energy_max_wh=energy_max), strategy)
    energy, height = _periodic_state(march)
    record = _Record(march)
    march.fly(energy, height, record)
    return record.result()


# ---- Marching


class _Flows(NamedTuple):
    """Energy that moved within one step [Wh]; per scenario."""

    solar_wh: FloatArray
    level_electric_wh: FloatArray
    charged_wh: FloatArray
    drawn_wh: FloatArray
    curtailed_wh: FloatArray
    climb_wh: FloatArray
    glide_wh: FloatArray
    unserved_wh: FloatArray
    missing_h: FloatArray


class _Balance(NamedTuple):
    """Power at both ends of a step, at the height of its middle [W]; per scenario."""

    solar_left: FloatArray
    solar_right: FloatArray
    motor_left: FloatArray
    motor_right: FloatArray


class _March:
    """Steps through the day with two stores."""

    def __init__(
        self, time_h: FloatArray, levels: FlightLevels, store: Store, strategy: Strategy
    ) -> None:
        self.node_h, self.levels, self.store = np.asarray(time_h, float), levels, store
        self.always_climb = strategy == "surplus"
        self.height_max = float(levels.height_wh[-1])
        self.solar = np.ascontiguousarray(np.moveaxis(levels.solar_power_w, -1, 0))
        self.factor = np.ascontiguousarray(levels.turbulence_factor.T)
        self.places = np.arange(levels.solar_power_w.shape[1])
        rises = np.diff(levels.height_wh)
        self.per_wh = 1.0 / np.where(rises > 0.0, rises, np.inf)
        self.full_wh = _FULL * store.energy_max_wh

    @property
    def time_h(self) -> FloatArray:
        """Nodes of the steps [h]."""
        parts = np.arange(STEPS_PER_NODE) / STEPS_PER_NODE
        fine = self.node_h[:-1, np.newaxis] + np.diff(self.node_h)[:, np.newaxis] * parts
        return np.append(fine.ravel(), self.node_h[-1])

    def fly(
        self, energy: FloatArray, height: FloatArray, record: _Record | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """State at the end of the day from that at its start."""
        before = height
        number = 0
        for node in range(len(self.node_h) - 1):
            hours = (self.node_h[node + 1] - self.node_h[node]) / STEPS_PER_NODE
            for part in range(STEPS_PER_NODE):
                middle = np.clip(1.5 * height - 0.5 * before, 0.0, self.height_max)
                balance = self._balance(node, part, middle)
                new_energy, new_height, flows = self._step(energy, height, balance, hours)
                if record is not None:
                    record.note(number, energy, height, balance, flows)
                before, energy, height = height, new_energy, new_height
                number += 1
        if record is not None:
            record.close(energy, height)
        return energy, height

    def _balance(self, node: int, part: int, height: FloatArray) -> _Balance:
        levels = self.levels
        below = np.searchsorted(levels.height_wh, height, side="right") - 1
        below = np.clip(below, 0, len(self.per_wh) - 1)
        share = (height - levels.height_wh[below]) * self.per_wh[below]
        lower, upper = 1.0 - share, share
        left, right = self.solar[node], self.solar[node + 1]
        start = lower * left[below, self.places] + upper * left[below + 1, self.places]
        end = lower * right[below, self.places] + upper * right[below + 1, self.places]
        power = levels.propulsion_power_w
        motor = lower * power[below] + upper * power[below + 1]
        a, b = part / STEPS_PER_NODE, (part + 1) / STEPS_PER_NODE
        first, last = self.factor[node], self.factor[node + 1]
        return _Balance(
            start + (end - start) * a,
            start + (end - start) * b,
            motor * (first + (last - first) * a),
            motor * (first + (last - first) * b),
        )

    def _step(
        self, energy: FloatArray, height: FloatArray, balance: _Balance, hours: float
    ) -> tuple[FloatArray, FloatArray, _Flows]:
        constant = self.levels.constant_power_w
        solar_left, solar_right, motor_left, motor_right = balance
        left = solar_left - motor_left - constant
        right = solar_right - motor_right - constant
        surplus = positive_part_wh(left, right, hours)
        deficit = positive_part_wh(-left, -right, hours)
        of_avionics = positive_part_wh(constant - solar_left, constant - solar_right, hours)
        early = np.where(left < 0.0, 1.0, 0.0)
        lit_h = hours * _surplus_share(left, right)
        first = self._drawn(energy, height, early * deficit, early * of_avionics)
        charged = self.store.charged(first.energy, surplus, hours)
        left_over = surplus - (charged - first.energy) / self.store.charge_efficiency
        room_w = self.levels.limits.maximum_power_w - (motor_left + motor_right) / 2.0
        usable = self._usable_wh(first.energy, charged, surplus, left_over, hours)
        climb = self._climb_wh(first.height, usable, room_w * lit_h)
        higher = first.height + self.levels.limits.efficiency * climb
        second = first
        if np.any((left >= 0.0) & (right < 0.0)):
            late = 1.0 - early
            second = self._drawn(charged, higher, late * deficit, late * of_avionics)
            end_energy, end_height = second.energy, second.height
            drawn, glide, unserved = (
                first.drawn + second.drawn,
                first.glide + second.glide,
                first.unserved + second.unserved,
            )
        else:
            end_energy, end_height = charged, higher
            drawn, glide, unserved = first.drawn, first.glide, first.unserved
        dark_h = hours - lit_h
        flows = _Flows(
            solar_wh=(solar_left + solar_right) / 2.0 * hours,
            level_electric_wh=(motor_left + motor_right) / 2.0 * hours,
            charged_wh=charged - first.energy,
            drawn_wh=drawn,
            curtailed_wh=left_over - climb,
            climb_wh=climb,
            glide_wh=glide,
            unserved_wh=unserved,
            missing_h=dark_h * unserved / np.maximum(deficit, 1e-300),
        )
        return end_energy, end_height, flows

    def _usable_wh(
        self,
        energy: FloatArray,
        charged: FloatArray,
        surplus: FloatArray,
        left_over: FloatArray,
        hours: float,
    ) -> FloatArray:
        """Part of the left-over surplus that the strategy lets climb [Wh]."""
        if self.always_climb:
            return left_over
        full = charged >= self.full_wh
        clock = self.store.clock
        if clock is None or not np.any(full & (energy < self.full_wh)):
            return np.where(full, left_over, 0.0)
        # In the step that fills the battery, only what comes after that instant; a step that
        # counted as a whole would make the day's gain jump with the state of charge.
        soc = np.minimum(energy / self.store.energy_max_wh, 1.0)
        after = np.clip(1.0 - clock.hours_to_full(soc) / hours, 0.0, 1.0)
        return np.where(full, np.minimum(left_over, after * surplus), 0.0)

    def _climb_wh(
        self, height: FloatArray, usable_wh: FloatArray, room_wh: FloatArray
    ) -> FloatArray:
        """Electric energy spent on climbing [Wh]."""
        to_ceiling = (self.height_max - height) / self.levels.limits.efficiency
        energy = np.minimum(np.minimum(usable_wh, np.maximum(room_wh, 0.0)), to_ceiling)
        return np.maximum(energy, 0.0)

    def _drawn(
        self, energy: FloatArray, height: FloatArray, deficit: FloatArray, of_avionics: FloatArray
    ) -> _Drawn:
        """Meet a deficit: what the motor lacks from height first, all else from the battery."""
        of_motor = deficit - of_avionics
        glide = np.minimum(np.maximum(of_motor, 0.0), height / self.levels.limits.efficiency)
        wanted = deficit - glide
        eta = self.store.discharge_efficiency
        drawn = np.minimum(wanted / eta, energy)
        # Rounding must leave no height that is no height.
        lower = np.maximum(height - self.levels.limits.efficiency * glide, 0.0)
        return _Drawn(energy - drawn, lower, drawn, glide, np.maximum(wanted - eta * drawn, 0.0))


class _Drawn(NamedTuple):
    """Stores after a deficit, and what they gave [Wh]; ``glide`` is electric, that it saved."""

    energy: FloatArray
    height: FloatArray
    drawn: FloatArray
    glide: FloatArray
    unserved: FloatArray


def _surplus_share(left: FloatArray, right: FloatArray) -> FloatArray:
    """Share of a step in which a power that is linear over it is not negative."""
    crossing = crossing_fraction(left, right)
    begin = np.where(left < 0.0, np.where(right < 0.0, 1.0, crossing), 0.0)
    end = np.where((right < 0.0) & (left >= 0.0), crossing, 1.0)
    return end - begin


def _periodic_state(march: _March) -> tuple[FloatArray, FloatArray]:
    """Stored energy and height at midnight of a day that repeats itself.

    The cycle is repeated from a full battery, which settles at once where the battery is filled or
    emptied every day. A small gain from day to day takes many days: every few of them the energy
    is extrapolated to where a geometric series of the gains would end (Aitken), or halved between
    the energies that are known to rise and to fall if the series leaves them. Where height is left
    at midnight the battery was full in the evening, and plain repetition settles fast.
    """
    capacity = march.store.energy_max_wh
    energy, height = capacity.copy(), np.zeros_like(capacity)
    scale = np.maximum(capacity, march.height_max)
    bracket = _EnergyBracket(capacity)
    previous = np.zeros_like(capacity)
    low = np.ones(capacity.shape, bool)
    for number in range(1, _MAXIMUM_ROUNDS + 1):
        new_energy, new_height = march.fly(energy, height)
        gain, shift = new_energy - energy, np.abs(new_height - height)
        low = low & (height == 0.0) & (new_height == 0.0)
        bracket.learn(energy, gain, low)
        energy, height = new_energy, new_height
        if np.all(np.maximum(np.abs(gain), shift) <= _TOLERANCE * scale):
            break
        if number % _PLAIN_ROUNDS == 0 and number <= _MAXIMUM_ROUNDS - _LAST_ROUNDS:
            energy = np.where(low, bracket.extrapolated(energy, gain, previous), energy)
            low = np.ones_like(low)
        previous = gain
    return energy, height


class _EnergyBracket:
    """Energies below and above that of the repeating day, per scenario."""

    def __init__(self, capacity: FloatArray) -> None:
        self.capacity = capacity
        self.lower, self.upper = np.zeros_like(capacity), capacity.copy()

    def learn(self, energy: FloatArray, gain: FloatArray, low: BoolArray) -> None:
        """Narrow by the gain of a day, or start anew where height was left at midnight."""
        rises, falls = gain > 0.0, gain < 0.0
        self.lower = np.where(rises, np.maximum(self.lower, energy), self.lower)
        self.upper = np.where(falls, np.minimum(self.upper, energy), self.upper)
        void = ~low | (self.lower > self.upper)
        self.lower = np.where(void, 0.0, self.lower)
        self.upper = np.where(void, self.capacity, self.upper)

    def extrapolated(
        self, energy: FloatArray, gain: FloatArray, previous: FloatArray
    ) -> FloatArray:
        """Next energy to try, from the gains of two days one after the other."""
        ratio = gain / np.where(previous == 0.0, np.inf, previous)
        shrinks = (ratio > 0.0) & (ratio < 1.0 - 1e-9)
        ahead = energy + gain * ratio / np.where(shrinks, 1.0 - ratio, 1.0)
        halved = (self.lower + self.upper) / 2.0
        inside = shrinks & (ahead > self.lower) & (ahead < self.upper)
        trial = np.where(inside, ahead, halved)
        return np.where(np.abs(gain) > _TOLERANCE * self.capacity, trial, energy)


# ---- Measuring


class _Record:
    """Collects trajectory, flows and metrics of one day."""

    def __init__(self, march: _March) -> None:
        self.march = march
        self.time_h = march.time_h
        shape = (len(self.time_h), len(march.places))
        self.energy, self.height = np.empty(shape), np.empty(shape)
        self.solar_w, self.load_w = np.empty(shape), np.empty(shape)
        self.lowest = np.full(shape[1], np.inf)
        self.sums = _Flows(*(np.zeros(shape[1]) for _ in _Flows._fields))

    def note(
        self,
        number: int,
        energy: FloatArray,
        height: FloatArray,
        balance: _Balance,
        flows: _Flows,
    ) -> None:
        """Take down one step."""
        self.energy[number], self.height[number] = energy, height
        hours = self.time_h[number + 1] - self.time_h[number]
        self.solar_w[number] = balance.solar_left
        motor_wh = flows.level_electric_wh + flows.climb_wh - flows.glide_wh
        self.load_w[number] = motor_wh / hours + self.march.levels.constant_power_w
        self.sums = _Flows(*(a + b for a, b in zip(self.sums, flows, strict=True)))

    def close(self, energy: FloatArray, height: FloatArray) -> None:
        """Take down the end of the day; its power is that of the beginning."""
        self.energy[-1], self.height[-1] = energy, height
        self.solar_w[-1], self.load_w[-1] = self.solar_w[0], self.load_w[0]

    def result(self) -> ClimbCycle:
        """Metrics of the whole day."""
        levels = self.march.levels
        return ClimbCycle(
            cycle=self._cycle(),
            account=self._account(),
            time_h=self.time_h,
            altitude_m=levels.altitude_at(self.height.T),
            energy_wh=self.energy.T.copy(),
            solar_power_w=self.solar_w.T.copy(),
            load_w=self.load_w.T.copy(),
            maximum_altitude_m=levels.altitude_at(self.height.max(axis=0)),
            maximum_height_wh=self.height.max(axis=0),
            gliding_h=_gliding_h(self.time_h, self.height),
        )

    def _account(self) -> ClimbAccount:
        sums, march = self.sums, self.march
        eta = march.levels.limits.efficiency
        electric = sums.level_electric_wh + sums.climb_wh - sums.glide_wh
        return ClimbAccount(
            solar_wh=sums.solar_wh,
            unserved_wh=sums.unserved_wh,
            constant_load_wh=np.full_like(sums.solar_wh, 24.0 * march.levels.constant_power_w),
            level_flight_wh=eta * sums.level_electric_wh,
            propulsion_loss_wh=(1.0 - eta) * electric,
            stored_wh=self.energy[-1] - self.energy[0],
            stored_height_wh=self.height[-1] - self.height[0],
            charge_loss_wh=sums.charged_wh * (1.0 / march.store.charge_efficiency - 1.0),
            discharge_loss_wh=sums.drawn_wh * (1.0 - march.store.discharge_efficiency),
            curtailed_wh=sums.curtailed_wh,
            climb_electric_wh=sums.climb_wh,
            glide_height_wh=eta * sums.glide_wh,
        )

    def _cycle(self) -> Cycle:
        """Metrics as :mod:`sizing.cycle` defines them, with the height that is left at dawn."""
        march, sums = self.march, self.sums
        capacity, levels = march.store.energy_max_wh, march.levels
        floor_w = levels.solar_power_w[0].T
        equal = equal_power(march.node_h, floor_w - levels.nominal_load_w)
        lit = equal.always_above
        starved = sums.unserved_wh > 1e-9 * capacity
        dark = np.isnan(equal.morning_h) & ~lit
        excess = np.where(starved | dark, -sums.missing_h, self._reserve_h(equal.morning_h))
        excess = np.where(lit & ~starved, np.inf, excess)
        status = np.where(excess > 0.0, Status.perpetual, Status.limited)
        status = np.where(lit & ~starved, Status.always_lit, status)
        status = np.where(~np.any(floor_w > 0.0, axis=0), Status.never_lit, status)
        lowest = self.energy.min(axis=0) / capacity
        first_full, last_full = self._full_h()
        account = self._account()
        motor_wh = sums.level_electric_wh + sums.climb_wh - sums.glide_wh
        return Cycle(
            status=status,
            excess_time_h=excess,
            minimum_state_of_charge=np.where(excess > 0.0, lowest, 0.0),
            charge_margin_h=np.where(np.isnan(first_full), 0.0, last_full - first_full),
            equal_power_morning_h=equal.morning_h,
            equal_power_evening_h=equal.evening_h,
            full_charge_h=first_full,
            missing_h=sums.missing_h,
            account=EnergyAccount(
                solar_wh=sums.solar_wh,
                load_wh=account.constant_load_wh + motor_wh,
                unserved_wh=sums.unserved_wh,
                stored_wh=account.stored_wh,
                charge_loss_wh=account.charge_loss_wh,
                discharge_loss_wh=account.discharge_loss_wh,
                curtailed_wh=sums.curtailed_wh,
            ),
            time_h=march.node_h,
            energy_wh=self.energy[::STEPS_PER_NODE].T.copy(),
        )

    def _reserve_h(self, dawn_h: FloatArray) -> FloatArray:
        """Hours that height and battery left at dawn would last without any sun.

        The aircraft glides first, while the battery feeds the avionics alone.
        """
        levels, eta = self.march.levels, self.march.store.discharge_efficiency
        at = np.where(np.isnan(dawn_h), 0.0, dawn_h)
        energy = _at_times(self.time_h, self.energy, at) * eta
        glide_h = levels.glide_h(_at_times(self.time_h, self.height, at))
        for_avionics = levels.constant_power_w * glide_h
        with np.errstate(divide="ignore", invalid="ignore"):
            level_h = np.maximum(energy - for_avionics, 0.0) / levels.nominal_load_w
            shortened = np.where(energy < for_avionics, energy / levels.constant_power_w, glide_h)
        return shortened + level_h

    def _full_h(self) -> tuple[FloatArray, FloatArray]:
        """First and last instant of full charge [h], NaN without one."""
        full = self.energy >= self.march.full_wh
        ever = full.any(axis=0)
        first = self.time_h[np.argmax(full, axis=0)]
        last = self.time_h[len(full) - 1 - np.argmax(full[::-1], axis=0)]
        return np.where(ever, first, np.nan), np.where(ever, last, np.nan)


def _at_times(time_h: FloatArray, values: FloatArray, at_h: FloatArray) -> FloatArray:
    """Columns of a trajectory, each at its own time."""
    pairs = zip(values.T, at_h, strict=True)
    return np.array([np.interp(hour, time_h, column) for column, hour in pairs])


def _gliding_h(time_h: FloatArray, height_wh: FloatArray) -> FloatArray:
    """Hours of sinking between the last climb of the day and the next one."""
    hours = np.diff(time_h)
    change = np.diff(height_wh, axis=0)
    result = np.zeros(height_wh.shape[1])
    for place in range(len(result)):
        climbs: NDArray[np.intp] = np.flatnonzero(change[:, place] > 0.0)
        if not len(climbs):
            continue
        sinks: BoolArray = change[:, place] < 0.0
        # The glide may last beyond midnight, to the first climb of the next day.
        result[place] = hours[sinks & _outside(len(sinks), climbs[0], climbs[-1])].sum()
    return result


def _outside(count: int, first: np.intp, last: np.intp) -> BoolArray:
    place = np.arange(count)
    return np.asarray((place < first) | (place > last))
