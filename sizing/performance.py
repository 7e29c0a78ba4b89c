"""Performance of an aircraft on a mission: solar power, load and battery put together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.dates import days_of_year
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.balance import blocks
from sizing.day.battery import Store
from sizing.day.cycle import simulate_cycle
from sizing.day.flight import Course, Endurance, Launches
from sizing.day.heights import FlightLevels, flight_levels
from sizing.day.light import (
    DEFAULT_STEP_H,
    UNCORRECTED_CAM,
    SolarDay,
    SolarModel,
    module_power_w,
    solar_day,
)
from sizing.day.load import Load
from sizing.day.metrics import Cycle, Status, joined
from sizing.design import Design, DesignVariables, each, picked
from sizing.mass_budget import closed_design, design_of
from solar.schema import spell_ends
from solar.types import BoolArray, FloatArray

if TYPE_CHECKING:
    from sizing.program.climbing_flights import ClimbFlights
    from sizing.program.schedule import Climbs

# Arrays of the batch; the last two are of climbs.
_ARRAYS = ("solar_power_w", "load_w", "nominal_load_w", "altitude_m", "program_excess_h")
# Scenarios whose best launch is searched for together.
_SCENARIOS_AT_ONCE = 2048


@dataclass(frozen=True, repr=False)
class Performance:
    """Converged cycles of a design in its scenarios, and what went in.

    Arrays have the scenarios on their last batch axis; with a batch of designs those come first.
    Of a mission with climbs the cycles are those of the flight with climbs, and ``altitude_m`` its
    altitude at the nodes of the day; so are the longest flights, by their ``levels``.
    ``program_excess_h``: excess time of these heights as the program that chose them has it.
    """

    design: Design
    mission: Mission
    solar: SolarModel
    day: SolarDay
    solar_power_w: FloatArray
    load_w: FloatArray
    nominal_load_w: FloatArray
    store: Store
    cycle: Cycle
    altitude_m: FloatArray | None = None
    levels: FlightLevels | None = None
    program_excess_h: FloatArray | None = None

    def __repr__(self) -> str:
        excess_h = np.asarray(self.cycle.excess_time_h)
        designs = "x".join(map(str, excess_h.shape[:-1])) or "1"
        return (
            f"<Performance of {designs} design(s) in {excess_h.shape[-1]} scenario(s): excess time "
            f"{spell_ends(excess_h.ravel().round(2))} h>"
        )

    def worst_scenario(self) -> int:
        """Return the scenario of least excess time, of equals that of least solar energy.

        Of a single design.
        """
        cycle = self.cycle
        least = cycle.excess_time_h == np.min(cycle.excess_time_h)
        energy_wh = np.asarray(cycle.energy_budget.solar_wh)
        return int(np.argmin(np.where(least, energy_wh, np.inf)))

    @property
    def worst_label(self) -> str:
        """Return the scenario of least excess time in words."""
        return self.day.scenarios.label(self.worst_scenario())

    @property
    def maximum_altitude_m(self) -> FloatArray | None:
        """Return the highest altitude of every flight with climbs [m]; None without climbs."""
        return None if self.altitude_m is None else np.asarray(self.altitude_m.max(axis=-1))

    def _mapped(self, function: Callable[[FloatArray], FloatArray], **others: Any) -> Performance:
        """Return the flights with a function of the arrays that they have."""
        arrays = {name: each(getattr(self, name), function) for name in _ARRAYS}
        return replace(self, **arrays, cycle=self.cycle.mapped(function), **others)

    def of_designs(self, designs: int | slice | BoolArray) -> Performance:
        """Return the flights of a part of a batch of designs; of one without an axis for it."""
        shape = self.cycle.status.shape
        energy_wh = np.broadcast_to(self.store.battery_energy_wh, shape)
        elements = np.arange(self.cycle.status.size).reshape(shape)[designs].ravel()
        return self._mapped(
            lambda values: values[designs],
            design=picked(self.design, designs),
            levels=each(self.levels, lambda levels: levels.select(elements)),
            store=replace(self.store, battery_energy_wh=energy_wh[designs]),
        )

    def reshaped(self, shape: tuple[int, int]) -> Performance:
        """Return flights of designs that are each in a scenario as a batch in several.

        Parameters
        ----------
        shape : tuple of int
            Number of designs, each of which follows itself so often, and of their scenarios.

        Returns
        -------
        Performance
        """
        energy_wh = self.store.battery_energy_wh.reshape(shape)
        return self._mapped(
            lambda values: values.reshape(shape + values.shape[1:]),
            design=picked(self.design, slice(None, None, shape[1])),
            store=replace(self.store, battery_energy_wh=energy_wh),
        )

    def replaced_in(self, scenarios: BoolArray, other: Performance) -> Performance:
        """Return the flights of a single design, in marked scenarios those of another schedule.

        Parameters
        ----------
        scenarios : ndarray of bool, shape (scenario,)
            Where the design flies otherwise.
        other : Performance
            Flights of the same design along other heights.

        Returns
        -------
        Performance
        """

        def chosen(values: list[Any]) -> Any:
            marked = scenarios.reshape(-1, *(1,) * (values[0].ndim - 1))
            return np.where(marked, values[1], values[0])

        cycle, names = joined([self.cycle, other.cycle], chosen), ("solar_power_w", "load_w")
        powers = {n: chosen([getattr(self, n), getattr(other, n)]) for n in names}
        altitude_m = each(self.altitude_m, lambda known: chosen([known, other.altitude_m]))
        # Of other heights nothing is known.
        program_h = each(self.program_excess_h, lambda known: np.where(scenarios, np.nan, known))
        return replace(
            self, **powers, cycle=cycle, altitude_m=altitude_m, program_excess_h=program_h
        )

    @cached_property
    def endurances(self) -> Endurance:
        """Return the longest flights of a single design by scenario, infinite where unlimited."""
        return self._longest_flights()

    @property
    def endurance_h(self) -> FloatArray:
        """Return the longest flight of a single design in every scenario [h]."""
        return self.endurances.endurance_h

    @property
    def least_excess_time_h(self) -> float:
        """Least excess time of all scenarios [h]."""
        return float(np.min(self.cycle.excess_time_h))

    @cached_property
    def worst_endurance_h(self) -> FloatArray:
        """Return the longest flight of each design in its scenario of least excess time [h].

        Infinite where that is perpetual; NaN for designs that cannot carry their own mass.
        """
        shape = self.cycle.excess_time_h.shape
        worst = np.argmin(self.cycle.excess_time_h, axis=-1, keepdims=True)
        flies = np.broadcast_to(np.isfinite(self.nominal_load_w), shape)
        in_worst = (np.arange(shape[-1]) == worst) & flies
        hours = self._longest_flights(in_worst & ~self.cycle.perpetual).endurance_h
        hours = np.where(flies, hours, np.nan)
        return np.take_along_axis(hours, worst, axis=-1)[..., 0]

    def flight_time_h(self, scenario: int, launch_h: ArrayLike) -> FloatArray:
        """Return flight times in a scenario of a single design from launches with a full battery.

        Parameters
        ----------
        scenario : int
            Index of the scenario.
        launch_h : array_like, shape (launch,)
            Solar time of the launches [h].

        Returns
        -------
        ndarray, shape (launch,)
            Hours of flight, infinite beyond 366 days [h].
        """
        launches = np.asarray(launch_h, float)
        return self._flights([scenario]).hours(np.zeros(len(launches), int), launches)

    def course(self, scenario: int, launch_h: float, hours: float) -> Course:
        """Return a flight in a scenario of a single design, launched with a full battery.

        Parameters
        ----------
        scenario : int
            Index of the scenario.
        launch_h, hours : float
            Solar time of the launch, and how long the flight is looked at [h].

        Returns
        -------
        Course
            Over solar time since the midnight before the launch; the state of charge is zero from
            when the battery is empty.
        """
        return self._flights([scenario]).course(0, launch_h, hours)

    def _longest_flights(self, limited: BoolArray | None = None) -> Endurance:
        """Return the longest flights of limited or marked elements; infinite elsewhere."""
        shape = self.cycle.status.shape
        indices = np.flatnonzero(~self.cycle.perpetual if limited is None else limited)
        hours, launch = np.full((2, self.cycle.status.size), np.inf)
        for block in blocks(len(indices), _SCENARIOS_AT_ONCE) if len(indices) else ():
            flights = self._flights(indices[block]).longest()
            hours[indices[block]], launch[indices[block]] = flights.endurance_h, flights.launch_h
        return Endurance(hours.reshape(shape), launch.reshape(shape))

    def _flights(self, elements: ArrayLike) -> Launches | ClimbFlights:
        """Return the flights of a part of all elements in the light of their first day."""
        rows, shape = np.asarray(elements, int), self.cycle.status.shape
        store = self.store.flat(shape).select(rows)
        if self.levels is not None:
            from sizing.program.climbing_flights import ClimbFlights

            return ClimbFlights(self.day.time_h, self.levels.select(rows), store)
        time_h = self.day.time_h[: (len(self.day.time_h) - 1) // self.mission.days_of_light + 1]
        at, batch = np.unravel_index(rows, shape), (*shape, len(time_h))
        solar_w, load_w = (
            np.broadcast_to(power_w[..., : len(time_h)], batch)[at]
            for power_w in (self.solar_power_w, self.load_w)
        )
        altitude_m = self.mission.altitude_m
        return Launches.of(time_h, solar_w, load_w, store, altitude_m=altitude_m)


def performance(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    day: SolarDay | None = None,
    step_h: float = DEFAULT_STEP_H,
    keep_trajectory: bool = True,
    design: Design | None = None,
) -> Performance:
    """Simulate an aircraft, as its file describes it, in every scenario of a mission.

    ``day``: sunlight in other scenarios, or known already; ``solar`` is then a label alone.
    ``step_h``: largest step of the time axis [h]; that of ``day`` if it is given. Returns arrays of
    the scenarios.
    """
    known = design_of(aircraft, mission) if design is None else design
    light = solar_day(aircraft, mission, solar, step_h=step_h, design=known) if day is None else day
    return fly(aircraft, mission, solar, known, light, keep_trajectory=keep_trajectory)


def performance_of_designs(
    aircraft: Aircraft,
    mission: Mission,
    variables: DesignVariables,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    day: SolarDay | None = None,
    step_h: float = DEFAULT_STEP_H,
) -> Performance:
    """Simulate a batch of designs of a parametric aircraft in every scenario of a mission.

    Parameters
    ----------
    aircraft : Aircraft
        Technology of the designs.
    mission, solar, day, step_h
        As for :func:`performance`.
    variables : DesignVariables
        Arrays that broadcast to the shape of the batch.

    Returns
    -------
    Performance
        Arrays of the batch with a last axis of scenarios. A design that cannot carry itself has an
        excess time of -24 h.
    """
    light = solar_day(aircraft, mission, solar, step_h=step_h) if day is None else day
    return fly(aircraft, mission, solar, closed_design(aircraft, mission, variables), light)


def fly(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    design: Design,
    day: SolarDay,
    *,
    keep_trajectory: bool = True,
    paired: bool = False,
    heights_m: FloatArray | None = None,
    of_others: bool = False,
) -> Performance:
    """Simulate every design of a batch in every scenario, or ``paired``: each in its own.

    ``heights_m``: of a mission with climbs, above the floor, ``(element, time)``, instead of the
    best of each. ``of_others``: those of another design, of which each flies the share that it can.
    """
    flights = design if paired else design.over_scenarios()
    store = Store.of(aircraft.battery, flights.battery_energy_wh)
    if mission.climb is not None:
        from sizing.program import schedule  # likewise

        levels = flight_levels(aircraft, mission, flights, day)
        batch = np.broadcast_shapes(np.shape(flights.total_mass_kg), (len(day.scenarios),))
        case = day.time_h, levels, store.flat(batch)
        if heights_m is None:
            climbs = schedule.best_climbs(*case)
        else:
            climbs = schedule.flown_along(*case, heights_m, of_others=of_others)
        return _performance_along(design, mission, solar, day, store, levels, climbs, batch)
    solar_w = module_power_w(day, flights, mission)
    load = Load.of(aircraft, mission, flights, day.scenarios)
    load_w = load.along(mission, day.time_h, day.sunrise_h, day.sunset_h)
    nominal_w = load.without_thermals(mission)
    cycle = simulate_cycle(
        day.time_h,
        solar_w,
        load_w,
        store,
        nominal_load_w=nominal_w,
        keep_trajectory=keep_trajectory,
        window_h=mission.flight_window_h(day.scenarios),
    )
    load_w = np.broadcast_to(load_w, np.broadcast_shapes(load_w.shape, solar_w.shape))
    return Performance(design, mission, solar, day, solar_w, load_w, nominal_w, store, cycle)


def _performance_along(
    design: Design,
    mission: Mission,
    solar: SolarModel,
    day: SolarDay,
    store: Store,
    levels: FlightLevels,
    climbs: Climbs,
    batch: tuple[int, ...],
) -> Performance:
    """Return the performance of a batch whose elements fly along heights."""
    arrays = (climbs.solar_w, climbs.load_w, levels.altitude_m[0] + climbs.height_m)
    solar_w, load_w, altitude_m = (values.reshape(*batch, -1) for values in arrays)
    nominal_w, cycle = levels.nominal_load_w.reshape(batch), climbs.cycle.reshaped(batch)
    simulated = (design, mission, solar, day, solar_w, load_w, nominal_w, store, cycle)
    program_h = None if climbs.program_h is None else climbs.program_h.reshape(batch)
    return Performance(*simulated, altitude_m=altitude_m, levels=levels, program_excess_h=program_h)


def perpetual_days(
    aircraft: Aircraft,
    mission: Mission,
    latitude_deg: float,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    days: ArrayLike | None = None,
) -> NDArray[np.int_]:
    """Return the days of the year on which an aircraft flies perpetually at a latitude.

    Parameters
    ----------
    aircraft, mission, solar
        As for :func:`performance`; the mission's own latitudes and dates play no part.
    latitude_deg : float
        Latitude [deg].
    days : array_like of int, optional
        Days to look at, 1 to 365, or dates; all by default.

    Returns
    -------
    ndarray of int
        Those of them, in their order.
    """
    every = np.arange(1, 366) if days is None else np.asarray(days_of_year(days), int)
    scenarios = Scenarios(np.full(len(every), float(latitude_deg)), every)
    design = design_of(aircraft, mission)
    light = solar_day(aircraft, mission, solar, scenarios=scenarios, design=design)
    result = performance(aircraft, mission, solar, day=light, design=design)
    return every[result.cycle.sufficient]


# ---- Measures of a flight in every scenario, by the keys of records and frames


def _in_daylight(flight: Performance, hours: Any) -> Any:
    """Return instants of the sun; NaN where it does not rise or does not set."""
    return np.where(flight.day.sunset_h > flight.day.sunrise_h, hours, np.nan)


def _status_names(flight: Performance) -> list[str]:
    """Return the status for users; a cycle without any solar power is one of the limited ones."""
    every = (Status(int(number)) for number in flight.cycle.status)
    return [(Status.limited if end is Status.never_lit else end).name for end in every]


MEASURES: dict[str, Callable[[Performance], Any]] = {
    "excess_time_h": attrgetter("cycle.excess_time_h"),
    "charge_margin_h": attrgetter("cycle.charge_margin_h"),
    "endurance_h": attrgetter("endurance_h"),
    "best_launch_h": lambda flight: np.where(
        flight.cycle.perpetual, np.nan, flight.endurances.launch_h
    ),
    "minimum_state_of_charge": attrgetter("cycle.minimum_state_of_charge"),
    "status": _status_names,
    "sunrise_h": lambda flight: _in_daylight(flight, flight.day.sunrise_h),
    "sunset_h": lambda flight: _in_daylight(flight, flight.day.sunset_h),
    "day_length_h": lambda flight: flight.day.sunset_h - flight.day.sunrise_h,
    "equal_power_morning_h": attrgetter("cycle.equal_power_morning_h"),
    "equal_power_evening_h": attrgetter("cycle.equal_power_evening_h"),
    "full_charge_h": attrgetter("cycle.full_charge_h"),
    "power_out_w": lambda flight: np.broadcast_to(flight.nominal_load_w, flight.cycle.status.shape),
    "solar_energy_wh": attrgetter("cycle.energy_budget.solar_wh"),
    "load_energy_wh": attrgetter("cycle.energy_budget.load_wh"),
    "curtailed_energy_wh": attrgetter("cycle.energy_budget.curtailed_wh"),
}
# Those of the record of a scenario.
OF_SCENARIO = tuple(key for key in MEASURES if key != "day_length_h")
