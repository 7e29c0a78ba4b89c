"""A flight on the calendar: launched at a date and clock time with a given state of charge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions import dates
from missions.mission import Launch, Mission
from sizing.aircraft import Aircraft
from sizing.design import Design, design_of, load_profile
from sizing.energy.battery import Store
from sizing.energy.march import Step, empty_after_h, full_after_h, march
from sizing.energy.power_balance import PowerBalance
from sizing.sunlight import UNCORRECTED_CAM, SolarModel, power_on_calendar
from solar.sun import declination, solar_time_h, sun_times
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
    def minimum_state_of_charge(self) -> float:
        """Least state of charge after the first full charge (of the whole run if there is none)."""
        begin = self.full_charge_clock_h[0] if self.full_charge_clock_h else self.clock_h[0]
        return float(self.state_of_charge[self.clock_h >= begin].min())

    def state_of_charge_at(self, clock_h: float) -> float:
        """State of charge at a local clock time [h]."""
        return float(np.interp(clock_h, self.clock_h, self.state_of_charge))


def calendar_run(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    step_h: float = CALENDAR_STEP_H,
) -> CalendarRun:
    """Fly a mission that has a launch; the date advances and the sun with it.

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
    power = aircraft.modules.area_m2 * power_on_calendar(
        aircraft, mission, solar, day, solar_clock % 24.0
    )
    design = design_of(aircraft, mission)
    times = sun_times(latitude, declination(day))
    load = load_profile(
        (solar_clock % 24.0)[:, np.newaxis], design, mission, times.sunrise_h, times.sunset_h
    )[:, 0]
    return _fly(aircraft, launch, design, clock, solar_clock % 24.0, day, power, load)


def _fly(
    aircraft: Aircraft,
    launch: Launch,
    design: Design,
    clock: FloatArray,
    solar_clock: FloatArray,
    day: FloatArray,
    power: FloatArray,
    load: FloatArray,
) -> CalendarRun:
    store = Store.of(aircraft.battery)
    energy = np.asarray(launch.state_of_charge * store.battery_energy_wh)
    trajectory = [float(energy)]
    full: dict[int, float] = {}
    empty: float | None = None
    for step in march(PowerBalance.of(clock, power, load), store, energy):
        trajectory.append(float(step.end_wh))
        _note_full_charge(step, store, full)
        if step.unserved_wh > 1e-9 * store.battery_energy_wh:
            empty = float(step.interval.start_h + empty_after_h(step.interval, step.unserved_wh))
            break
    flown = len(trajectory)
    stored = np.asarray(trajectory)
    return CalendarRun(
        launch=launch,
        design=design,
        clock_h=clock[:flown],
        time_solar_h=solar_clock[:flown],
        day_of_year=day[:flown],
        solar_power_w=power[:flown],
        load_w=load[:flown],
        energy_wh=stored,
        state_of_charge=stored / float(store.battery_energy_wh),
        full_charge_clock_h=tuple(full[d] for d in sorted(full)),
        empty_clock_h=empty,
    )


def _note_full_charge(step: Step, store: Store, full: dict[int, float]) -> None:
    """Remember the first full charge of each local day."""
    reached = step.after_charge_wh >= store.battery_energy_wh * (1.0 - 1e-9)
    if reached and step.after_charge_wh > step.before_charge_wh:
        after_h = full_after_h(step.interval, store, step.before_charge_wh)
        instant_h = float(step.interval.start_h + after_h)
        full.setdefault(int(instant_h // 24.0), instant_h)
