"""Flights that begin at a launch: one to replay by the clock, and one that lands."""

from __future__ import annotations

import re
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, Strict, model_validator

from missions.mission.scenarios import OTHER_NAME, Date, Scenarios
from solar.schema import Record, UnitInterval, refusal, spell, wrong_value
from solar.sun import HOURS_PER_DAY, NOON_H, declination, solar_time_h, sun_times
from solar.types import FloatArray

UtcOffset = Annotated[float, Strict(), Field(ge=-12.0, le=14.0, allow_inf_nan=False)]
ExcessTime = Annotated[float, Strict(), Field(ge=0.0, le=1000.0, allow_inf_nan=False)]


def _clock_time(value: str, others: str = "") -> str:
    if re.fullmatch(r"([01]?\d|2[0-3]):[0-5]\d", value) is None:
        raise ValueError(f"must be {others}a time HH:MM, for instance 11:14 (got {value!r})")
    return value


def _sunrise_or_clock(value: str) -> str:
    return value if value == "sunrise" else _clock_time(value, "sunrise or ")


class Launch(Record):
    """Start of a flight to replay: local date and clock time, state of charge, duration."""

    date: Date
    time_local: Annotated[str, AfterValidator(_clock_time)]
    utc_offset_h: UtcOffset = 0.0
    state_of_charge: UnitInterval = 1.0
    duration_h: Annotated[float, Strict(), Field(gt=0.0, le=24.0 * 366)]

    @property
    def text(self) -> str:
        """Return date and local clock time."""
        return f"{self.date} {self.time_local}"

    @property
    def clock_h(self) -> float:
        """Return the local clock time of the launch [h]."""
        return _clock_h(self.time_local)


def _clock_h(value: str) -> float:
    hours, minutes = value.split(":")
    return int(hours) + int(minutes) / 60.0


class Flight(Record):
    """Flight from a launch with a full battery to a landing, which need not survive a night.

    ``launch``: ``sunrise`` or HH:MM, of solar time, or with ``utc_offset_h`` of the local clock.
    It ends at ``land: sunset`` or after ``hours``, and ``reserve_h`` is for how long what is left
    then must last: the mission's required excess time by another name.
    """

    launch: Annotated[str, AfterValidator(_sunrise_or_clock)] = "sunrise"
    land: Literal["sunset"] | None = None
    hours: Annotated[float, Strict(), Field(gt=0.0, le=24.0 * 30)] | None = None
    reserve_h: ExcessTime | None = None
    utc_offset_h: UtcOffset | None = None

    @model_validator(mode="after")
    def _check_end(self) -> Flight:
        if (self.land is None) == (self.hours is None):
            got = "neither" if self.land is None else "both"
            raise ValueError(refusal("give either 'land: sunset' or 'hours: 14'", got))
        if self.launch == "sunrise" and self.utc_offset_h is not None:
            raise wrong_value("utc_offset_h", "is that of a launch HH:MM by the local clock")
        return self

    def check(self, longitude_deg: float | None, required_excess_time_h: float) -> None:
        """Refuse a clock without a place, and a reserve that is not the required excess time."""
        if self.utc_offset_h is not None and longitude_deg is None:
            raise wrong_value("flight.utc_offset_h", "needs longitude_deg on the mission")
        if self.reserve_h is not None and required_excess_time_h not in (0.0, self.reserve_h):
            text = OTHER_NAME.format("required_excess_time_h", spell(required_excess_time_h))
            raise wrong_value("flight.reserve_h", text, got=self.reserve_h)

    @property
    def text(self) -> str:
        """Return the flight in words."""
        launch = self.launch if self.launch == "sunrise" else f"launch at {self.launch}"
        if self.hours is None:
            return f"{launch} to sunset"
        return f"{spell(self.hours)} h from {launch}"

    @property
    def days(self) -> int:
        """Return the days whose light it may see, from the midnight before its launch."""
        latest_h = NOON_H if self.launch == "sunrise" else HOURS_PER_DAY
        end_h = latest_h + (NOON_H if self.hours is None else self.hours)
        return max(int(np.ceil(end_h / HOURS_PER_DAY)), 1)

    def window_h(
        self, scenarios: Scenarios, longitude_deg: float | None
    ) -> tuple[FloatArray, FloatArray]:
        """Return the solar time of launch and landing in every scenario [h].

        Counted from the midnight before the launch. A flight to a sunset that has passed lands at
        the next one.
        """
        times = sun_times(scenarios.latitude_deg, declination(scenarios.noon_day))
        if self.launch == "sunrise":
            launch_h = np.asarray(times.sunrise_h)
        else:
            launch_h = np.full(len(scenarios), _clock_h(self.launch))
            if self.utc_offset_h is not None:
                assert longitude_deg is not None
                utc_h = launch_h - self.utc_offset_h
                launch_h = solar_time_h(utc_h, scenarios.noon_day, longitude_deg)
            launch_h = launch_h % HOURS_PER_DAY
        if self.hours is not None:
            return launch_h, launch_h + self.hours
        sunset_h = np.asarray(times.sunset_h)
        return launch_h, np.where(sunset_h < launch_h, sunset_h + HOURS_PER_DAY, sunset_h)
