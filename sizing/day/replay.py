"""A flight on the calendar: launched at a date and clock time with a state of charge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions import dates
from missions.mission import Mission
from missions.mission.flight import Launch
from sizing.aircraft import Aircraft
from sizing.day.balance import PowerBalance
from sizing.day.battery import Store
from sizing.day.light import UNCORRECTED_CAM, SolarModel, power_at_instants
from sizing.day.load import Load
from sizing.day.march import ChargingDay, full_after_h
from sizing.day.metrics import FULL
from sizing.day.module_power import clear_daylight
from sizing.design import Design
from sizing.mass_budget import design_of
from solar.sun import HOURS_PER_DAY, declination, solar_time_h, sun_times
from solar.types import FloatArray

CALENDAR_STEP_H = 1.0 / 60.0


@dataclass(frozen=True)
class CalendarRun:
    """Trajectory of one flight on the calendar.

    Attributes
    ----------
    clock_h : ndarray
        Local clock time [h], counted on from 00:00 of the launch date without wrapping.
    time_solar_h, day_of_year : ndarray
        Local solar time [h] and fractional day of year (UTC) at each node.
    solar_power_w, load_w, energy_wh, state_of_charge : ndarray
        Power [W], stored energy [Wh] and state of charge [-] at each node.
    full_charge_clock_h : tuple of float
        First instant of full charge on each local day that has one (clock as above).
    empty_clock_h : float or None
        When the battery ran empty; the run ends there.
    """

    launch: Launch
    design: Design
    clock_h: FloatArray
    time_solar_h: FloatArray
    day_of_year: FloatArray
    solar_power_w: FloatArray
    load_w: FloatArray
    energy_wh: FloatArray
    state_of_charge: FloatArray
    full_charge_clock_h: tuple[float, ...]
    empty_clock_h: float | None

    @property
    def duration_h(self) -> float:
        """Flight time [h]."""
        return float(self.clock_h[-1] - self.clock_h[0])

    @property
    def final_state_of_charge(self) -> float:
        """State of charge at the end [-]."""
        return float(self.state_of_charge[-1])

    @property
    def minimum_state_of_charge(self) -> float:
        """Return the least state of charge after the first full charge, or of all without one."""
        begin = self.full_charge_clock_h[0] if self.full_charge_clock_h else self.clock_h[0]
        return float(self.state_of_charge[self.clock_h >= begin].min())


def calendar_run(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    step_h: float = CALENDAR_STEP_H,
) -> CalendarRun:
    """Simulate a mission that has a launch; the date advances and the sun with it.

    Parameters
    ----------
    aircraft, mission
        The mission has ``launch`` and a longitude.
    solar : SolarModel
        Solar power model and its correction.
    step_h : float
        Largest time step [h].

    Returns
    -------
    CalendarRun
        Ends early where the battery runs empty.

    Raises
    ------
    ValueError
        If the mission has no launch.
    """
    launch = mission.launch
    if launch is None or mission.longitude_deg is None:
        raise ValueError(f"mission {mission.name} has no launch date and time to fly from")
    latitude = mission.latitudes()[0]
    count = int(np.ceil(launch.duration_h / step_h - 1e-9)) + 1
    clock = launch.clock_h + np.linspace(0.0, launch.duration_h, count)
    utc = clock - launch.utc_offset_h
    day = dates.day_of_year(launch.date) + utc / 24.0
    solar_clock = solar_time_h(utc, day, mission.longitude_deg)
    light = clear_daylight(mission, latitude, day, solar_clock % 24.0)
    power = aircraft.modules.area_m2 * power_at_instants(aircraft, mission, solar, light)
    design = design_of(aircraft, mission)
    times = sun_times(latitude, declination(day))
    store = Store.of(aircraft.battery, [design.battery_energy_wh])
    times_h = (solar_clock % 24.0)[:, np.newaxis], times.sunrise_h, times.sunset_h
    load = Load.of(aircraft, mission, design).along(mission, *times_h)[:, 0]
    balance = PowerBalance.of(clock, (power - load)[:, np.newaxis])
    stored, full, empty = _charge_until_empty(ChargingDay.of(balance), store, launch)
    nodes = slice(len(stored))
    return CalendarRun(
        launch=launch,
        design=design,
        clock_h=clock[nodes],
        time_solar_h=solar_clock[nodes] % 24.0,
        day_of_year=day[nodes],
        solar_power_w=power[nodes],
        load_w=load[nodes],
        energy_wh=stored,
        state_of_charge=stored / store.battery_energy_wh,
        full_charge_clock_h=full,
        empty_clock_h=empty,
    )


def _charge_until_empty(
    day: ChargingDay, store: Store, launch: Launch
) -> tuple[FloatArray, tuple[float, ...], float | None]:
    """Return the energy at the nodes until the battery is empty [Wh], when it is full and empty."""
    balance, run = day.balance, day.run(store, launch.state_of_charge * store.battery_energy_wh)
    empty_h = float(run.empty_h()[0])
    until_h = np.inf if np.isnan(empty_h) else empty_h
    before_wh, after_wh = np.maximum(run.drained_wh[:, 0], 0.0), run.after_charge_wh[:, 0]
    reached = (after_wh >= store.battery_energy_wh * FULL) & (after_wh > before_wh)
    number = day.first + np.flatnonzero(reached)
    interval = balance.interval(number, np.zeros(1, int))
    instants_h = interval.start_h + full_after_h(interval, store, before_wh[reached])
    full: dict[int, float] = {}  # the first instant of each local day
    for instant_h in instants_h[instants_h < until_h].tolist():
        full.setdefault(int(instant_h // HOURS_PER_DAY), instant_h)
    stop = int(np.searchsorted(balance.time_h, until_h)) + 1  # up to the node after it
    stored_wh = run.energy_at_nodes_wh()[:stop, 0]
    return stored_wh, tuple(full.values()), None if np.isnan(empty_h) else empty_h
