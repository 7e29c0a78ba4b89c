"""Missions: where, when and in which air an aircraft flies, and the scenarios this expands to."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, cast

import numpy as np
from pydantic import Field, Strict, field_validator, model_validator

from missions import dates
from missions.air import (
    MAXIMUM_ALTITUDE_M,
    MINIMUM_ALTITUDE_M,
    ZERO_CELSIUS_K,
    Air,
    air_at,
    standard_air,
)
from missions.files.errors import InputError
from missions.flight_path import FlightPath, Heading, Wind
from missions.uncertainty import Uncertainty
from missions.winds.statistics import WindStatistics
from solar.clearsky import ClearSky, named_clear_sky
from solar.names import CorrectionName, ModelName
from solar.schema import (
    FileRecord,
    Fraction,
    Name,
    NonNegativeReal,
    Record,
    Text,
    UnitInterval,
    wrong_value,
)
from solar.sun import HOURS_PER_DAY, NOON_H, declination, solar_time_h, sun_times
from solar.systematic_errors import correction
from solar.types import BoolArray, FloatArray, IntArray

Latitude = Annotated[float, Strict(), Field(ge=-90.0, le=90.0, allow_inf_nan=False)]
Longitude = Annotated[float, Strict(), Field(ge=-180.0, le=180.0, allow_inf_nan=False)]
UtcOffset = Annotated[float, Strict(), Field(ge=-12.0, le=14.0, allow_inf_nan=False)]
Altitude = Annotated[
    float, Strict(), Field(ge=MINIMUM_ALTITUDE_M, le=MAXIMUM_ALTITUDE_M, allow_inf_nan=False)
]
TemperatureOffset = Annotated[float, Strict(), Field(ge=-60.0, le=60.0, allow_inf_nan=False)]
ExcessTime = Annotated[float, Strict(), Field(ge=0.0, le=1000.0, allow_inf_nan=False)]
Temperature = Annotated[float, Strict(), Field(ge=-100.0, le=100.0, allow_inf_nan=False)]


MAXIMUM_SCENARIOS = 5000
SOLSTICES = (172, 355)  # 21 June and 21 December
# Of a flight with climbs: between levels everything is linear.
LEVEL_SPACING_M = 500.0
MAXIMUM_LEVELS = 21


def _plain_number(value: Any) -> float:
    """Plain number; draws of uncertain inputs are arrays, and stay so."""
    return float(value) if np.ndim(value) == 0 else cast("float", value)


def _date(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"must be a date MM-DD, for instance 07-15 (got {value!r})")
    return dates.date_code(dates.day_of_year(value))


class LatitudeRange(Record):
    """Latitudes from one to another, evenly spaced."""

    from_deg: Latitude
    to_deg: Latitude
    count: Annotated[int, Strict(), Field(ge=2, le=181)] = 3

    @model_validator(mode="after")
    def _check_ends(self) -> LatitudeRange:
        if self.from_deg == self.to_deg:
            raise ValueError(
                f"from_deg and to_deg must differ (got {self.from_deg:g} twice): a single latitude "
                "is written latitude_deg: 47.6"
            )
        return self

    def values(self) -> list[float]:
        """Latitudes [deg], ends included."""
        return [float(v) for v in np.linspace(self.from_deg, self.to_deg, self.count)]


def _move_pick(picks: list[int], wanted: int, kept: set[int]) -> bool:
    """Move the nearest pick between the ends to the wanted one; false where none may move."""
    movable = [i for i in range(1, len(picks) - 1) if picks[i] not in kept]
    if not movable:
        return False
    picks[min(movable, key=lambda i: abs(picks[i] - wanted))] = wanted
    return True


class Dates(Record):
    """One date (``on``) or a range (``from`` to ``to``, across the year's end if need be).

    A range stands for ``count`` of its days (default 3), evenly spaced with both ends. The longest
    and the shortest day drive a design: a pick between the ends is moved to a solstice within the
    range, or the solstice is added where no count was asked for. Dates are MM-DD.
    """

    on: str | None = None
    first: str | None = Field(default=None, alias="from")
    last: str | None = Field(default=None, alias="to")
    count: Annotated[int, Strict(), Field(ge=1, le=365)] | None = None

    @field_validator("on", "first", "last", mode="before")
    @classmethod
    def _check_date(cls, value: Any) -> str | None:
        return None if value is None else _date(value)

    @model_validator(mode="after")
    def _check_form(self) -> Dates:
        one = self.on is not None
        if one and (self.first or self.last or self.count):
            raise ValueError("give either 'on: MM-DD' or 'from: MM-DD' and 'to: MM-DD', not both")
        if not one and (self.first is None or self.last is None):
            raise ValueError("empty date range: give 'on: MM-DD', or 'from: MM-DD' and 'to: MM-DD'")
        return self

    def range(self) -> list[int]:
        """Every day of year that the dates cover."""
        if self.on is not None:
            return [dates.day_of_year(self.on)]
        assert self.first is not None  # both checked on construction
        assert self.last is not None
        return dates.days_in_range(dates.day_of_year(self.first), dates.day_of_year(self.last))

    def days(self) -> list[int]:
        """Days of year that stand for the range, in its order."""
        every = self.range()
        count = min(self.count or 3, len(every))
        picks = np.unique(np.round(np.linspace(0, len(every) - 1, count)).astype(int)).tolist()
        inside = {every.index(day) for day in SOLSTICES if count > 1 and day in every}
        for solstice in sorted(inside - set(picks)):
            if not _move_pick(picks, solstice, inside) and self.count is None:
                picks.append(solstice)
        return [every[i] for i in sorted(set(picks))]


class AirConditions(Record):
    """Air at flight altitude: standard, standard with an offset, or of a given temperature.

    ``albedo``: share of the light that the earth and its clouds send back up; given, it lights
    modules that face down (VM, FM).
    """

    temperature_offset_k: TemperatureOffset | None = None
    ambient_temperature_c: Temperature | None = None
    module_temperature_c: Temperature | None = None
    albedo: UnitInterval | None = None

    @model_validator(mode="after")
    def _check_temperatures(self) -> AirConditions:
        if self.temperature_offset_k is not None and self.ambient_temperature_c is not None:
            raise ValueError("give temperature_offset_k or ambient_temperature_c, not both")
        return self


class Payload(Record):
    """What the aircraft carries for its mission."""

    mass_kg: NonNegativeReal = 0.0
    power_w: NonNegativeReal = 0.0


class Turbulence(Record):
    """Extra propulsion power relative to level flight.

    ``all_day`` acts at every hour; ``thermal`` is added by day: nothing at sunrise and sunset,
    the full value at solar noon, linear in between.
    """

    all_day: Annotated[float, Strict(), Field(ge=0.0, le=5.0)] = 0.0
    thermal: Annotated[float, Strict(), Field(ge=0.0, le=5.0)] = 0.0


class UncertaintyMargins(Record):
    """What may turn out worse than assumed: performance is computed at the worst of every margin.

    Less sun and less capacity never help, so that the worst case of all combinations is the one
    with the worst of each.

    ``solar_model_sigmas`` is how many RMS errors of the solar power model are taken off the power;
    ``clearness_minimum`` replaces a higher clearness; ``battery_capacity`` is the fraction of the
    capacity that is left at the end of the battery's life.
    """

    solar_model_sigmas: Annotated[float, Strict(), Field(ge=0.0, le=4.0)] = 0.0
    clearness_minimum: Fraction | None = None
    battery_capacity: Fraction = 1.0

    @property
    def given(self) -> bool:
        """Whether there is any margin."""
        return self != UncertaintyMargins()

    def solar_factor(self, rms_relative: float) -> float:
        """Factor on the solar power of a model with this RMS error."""
        return max(1.0 - self.solar_model_sigmas * rms_relative, 0.0)


class Launch(Record):
    """Start of a flight to replay: local date and clock time, state of charge, duration."""

    date: str
    time_local: str
    utc_offset_h: UtcOffset = 0.0
    state_of_charge: UnitInterval = 1.0
    duration_h: Annotated[float, Strict(), Field(gt=0.0, le=24.0 * 366)]

    @field_validator("date", mode="before")
    @classmethod
    def _check_date(cls, value: Any) -> str:
        return _date(value)

    @field_validator("time_local")
    @classmethod
    def _check_time(cls, value: str) -> str:
        return _clock_time(value)

    @property
    def clock_h(self) -> float:
        """Local clock time of the launch [h]."""
        return _clock_h(self.time_local)


def _clock_time(value: str, others: str = "") -> str:
    if re.fullmatch(r"([01]?\d|2[0-3]):[0-5]\d", value) is None:
        raise ValueError(f"must be {others}a time HH:MM, for instance 11:14 (got {value!r})")
    return value


def _clock_h(value: str) -> float:
    hours, minutes = value.split(":")
    return int(hours) + int(minutes) / 60.0


class Flight(Record):
    """Flight from a launch with a full battery to a landing, which need not survive a night.

    ``launch``: ``sunrise`` or HH:MM, of solar time, or with ``utc_offset_h`` of the local clock.
    It ends at ``land: sunset`` or after ``hours``, and ``reserve_h`` is for how long what is left
    then must last: the mission's required excess time by another name.
    """

    launch: str = "sunrise"
    land: Literal["sunset"] | None = None
    hours: Annotated[float, Strict(), Field(gt=0.0, le=24.0 * 30)] | None = None
    reserve_h: ExcessTime | None = None
    utc_offset_h: UtcOffset | None = None

    @field_validator("launch")
    @classmethod
    def _check_launch(cls, value: str) -> str:
        return value if value == "sunrise" else _clock_time(value, "sunrise or ")

    @model_validator(mode="after")
    def _check_end(self) -> Flight:
        if (self.land is None) == (self.hours is None):
            given = "neither" if self.land is None else "both"
            raise ValueError(f"give either 'land: sunset' or 'hours: 14' (got {given})")
        if self.launch == "sunrise" and self.utc_offset_h is not None:
            raise wrong_value("utc_offset_h", "is that of a launch HH:MM by the local clock")
        return self

    @property
    def text(self) -> str:
        """The flight in words."""
        launch = self.launch if self.launch == "sunrise" else f"launch at {self.launch}"
        return f"{launch} to sunset" if self.hours is None else f"{self.hours:g} h from {launch}"

    @property
    def days(self) -> int:
        """Days whose light it may see, from the midnight before its launch."""
        latest_h = NOON_H if self.launch == "sunrise" else HOURS_PER_DAY
        end_h = latest_h + (NOON_H if self.hours is None else self.hours)
        return max(int(np.ceil(end_h / HOURS_PER_DAY)), 1)


class Climb(Record):
    """Surplus power stored as height by day, to sink to the mission's altitude in the evening.

    The height profile is the best there is: ``strategy``, when to climb, is read and ignored.
    ``minimum_altitude_m``: the night's floor, which the aircraft does not sink below; another name
    for the mission's altitude, which need not be given beside it.
    """

    explained_keys: ClassVar[Mapping[str, str]] = {
        "maximum_altitude_m": "the highest altitude is climb.ceiling_m",
        "design_space": "altitudes are not chosen by size: give climb.ceiling_m, and vary it with "
        "sweep --resize --vary mission.climb.ceiling_m=...",
    }

    ceiling_m: Altitude
    minimum_altitude_m: Altitude | None = None
    strategy: Literal["battery_full", "surplus"] | None = None

    @property
    def record(self) -> dict[str, Any]:
        """Ceiling, JSON-ready; the floor is the mission's altitude."""
        return {"ceiling_m": self.ceiling_m}


class Mission(FileRecord):
    """Where, when and how an aircraft flies."""

    name: Name
    description: str = ""
    latitude_deg: Latitude | LatitudeRange
    longitude_deg: Longitude | None = None
    dates: Dates
    altitude_m: Altitude = 0.0
    air: AirConditions = AirConditions()
    clear_sky: Text = "ashrae"
    clearness: Fraction = 1.0
    uncertainty_margins: UncertaintyMargins = UncertaintyMargins()
    turbulence: Turbulence = Turbulence()
    payload: Payload = Payload()
    wind_m_per_s: NonNegativeReal = 0.0
    # The key of the file is that of the property `wind`, which is older.
    wind_statistics: WindStatistics | None = Field(default=None, alias="wind")
    wind_from_deg: Heading = 90.0
    flight_path: FlightPath | None = None
    required_excess_time_h: ExcessTime = 0.0
    launch: Launch | None = None
    flight: Flight | None = None
    climb: Climb | None = None
    uncertainty: Uncertainty | None = None

    def facts(self) -> dict[str, Any]:
        """Name, place and time."""
        every = self.dates.range()
        return {
            "name": self.name,
            "latitude": " to ".join(
                map(latitude_label, self.latitudes()[:: len(self.latitudes()) - 1 or 1])
            ),
            "dates": " to ".join(map(dates.date_label, every[:: len(every) - 1 or 1])),
            "altitude [m]": self.altitude_m,
        }

    @field_validator("clear_sky")
    @classmethod
    def _check_sky(cls, value: str) -> str:
        named_clear_sky(value)
        return value

    @model_validator(mode="before")
    @classmethod
    def _altitude_of_floor(cls, data: Any) -> Any:
        """The night's floor is the mission's altitude, where the file gives that instead.

        An altitude of null leaves that of a file to the floor.
        """
        if not isinstance(data, Mapping) or data.get("altitude_m") is not None:
            return data
        climb = data.get("climb")
        if isinstance(climb, Climb):
            floor_m: Any = climb.minimum_altitude_m
        else:
            floor_m = climb.get("minimum_altitude_m") if isinstance(climb, Mapping) else None
        # What is no altitude is told once, at its own key.
        if not isinstance(floor_m, int | float) or isinstance(floor_m, bool):
            return data
        allowed = MINIMUM_ALTITUDE_M <= floor_m <= MAXIMUM_ALTITUDE_M
        return {**data, "altitude_m": floor_m} if allowed else data

    @model_validator(mode="after")
    def _check_climb(self) -> Mission:
        if self.climb is None:
            return self
        floor_m = self.climb.minimum_altitude_m
        if floor_m is not None and floor_m > self.climb.ceiling_m:
            raise wrong_value(
                "climb.minimum_altitude_m",
                f"must be at most climb.ceiling_m of {self.climb.ceiling_m:g} (got {floor_m:g})",
            )
        if floor_m is not None and floor_m != self.altitude_m:
            raise wrong_value(
                "climb.minimum_altitude_m",
                "is the mission's altitude_m by another name: leave one of them out (got "
                f"{floor_m:g}, altitude_m is {self.altitude_m:g})",
            )
        if floor_m is not None:
            # Not a value of its own, or a study that varies the one would contradict the other.
            self.model_fields_set.discard("altitude_m")
        if self.climb.ceiling_m < self.altitude_m:
            raise wrong_value(
                "climb.ceiling_m",
                f"must be at least the mission's altitude_m of {self.altitude_m:g} (got "
                f"{self.climb.ceiling_m:g})",
            )
        if self.launch is not None:
            raise wrong_value(
                "climb", "a replayed flight keeps its altitude: give launch or climb, not both"
            )
        return self

    @model_validator(mode="after")
    def _check_launch(self) -> Mission:
        if self.launch is None:
            return self
        if self.longitude_deg is None:
            raise wrong_value("launch", "a launch by clock time needs longitude_deg on the mission")
        if isinstance(self.latitude_deg, LatitudeRange):
            raise wrong_value("latitude_deg", "a launch needs a single latitude")
        return self

    @model_validator(mode="after")
    def _check_flight(self) -> Mission:
        """Refuse what contradicts a flight; its reserve is the excess time that it requires."""
        flight = self.flight
        if flight is None:
            return self
        for name, other in (("launch", self.launch), ("climb", self.climb)):
            if other is not None:
                raise wrong_value("flight", f"give flight or {name}, not both")
        if flight.utc_offset_h is not None and self.longitude_deg is None:
            raise wrong_value("flight.utc_offset_h", "needs longitude_deg on the mission")
        if flight.reserve_h is None:
            return self
        if self.required_excess_time_h not in (0.0, flight.reserve_h):
            raise wrong_value(
                "flight.reserve_h",
                f"is required_excess_time_h by another name: leave one of them out (got "
                f"{flight.reserve_h:g}, required_excess_time_h is {self.required_excess_time_h:g})",
            )
        object.__setattr__(self, "required_excess_time_h", flight.reserve_h)
        self.model_fields_set.discard("required_excess_time_h")
        return self

    @property
    def days_of_light(self) -> int:
        """Days of the time axis: one that repeats itself, or all that a flight may see."""
        return 1 if self.flight is None else self.flight.days

    def flight_window_h(self, scenarios: Scenarios) -> tuple[FloatArray, FloatArray] | None:
        """Solar time of launch and landing in every scenario [h]; None where a day is repeated.

        Counted from the midnight before the launch. A flight to a sunset that has passed lands at
        the next one.
        """
        flight = self.flight
        if flight is None:
            return None
        times = sun_times(scenarios.latitude_deg, declination(scenarios.noon_day))
        if flight.launch == "sunrise":
            launch_h = np.asarray(times.sunrise_h)
        else:
            launch_h = np.full(len(scenarios), _clock_h(flight.launch))
            if flight.utc_offset_h is not None:
                assert self.longitude_deg is not None
                utc_h = launch_h - flight.utc_offset_h
                launch_h = solar_time_h(utc_h, scenarios.noon_day, self.longitude_deg)
            launch_h = launch_h % HOURS_PER_DAY
        if flight.hours is not None:
            return launch_h, launch_h + flight.hours
        sunset_h = np.asarray(times.sunset_h)
        return launch_h, np.where(sunset_h < launch_h, sunset_h + HOURS_PER_DAY, sunset_h)

    @model_validator(mode="after")
    def _check_scenario_count(self) -> Mission:
        count = len(self.latitudes()) * len(self.dates.days())
        if count > MAXIMUM_SCENARIOS:
            raise wrong_value(
                "latitude_deg",
                f"latitudes times days must be at most {MAXIMUM_SCENARIOS} scenarios (got {count})",
            )
        return self

    @model_validator(mode="after")
    def _check_margins(self) -> Mission:
        lowest = self.uncertainty_margins.clearness_minimum
        if lowest is not None and lowest > self.clearness:
            raise wrong_value(
                "uncertainty_margins.clearness_minimum",
                f"must be at most the mission's clearness of {self.clearness:g} (got {lowest:g})",
            )
        return self

    @model_validator(mode="after")
    def _check_wind(self) -> Mission:
        """After the count of scenarios: each has its wind."""
        given = self.wind_statistics
        if given is None:
            return self
        try:
            if self.wind_m_per_s:
                raise ValueError(
                    f"give wind or wind_m_per_s (got {self.wind_m_per_s:g} m/s), not both: "
                    "wind_m_per_s: 0 leaves it to wind, wind: null to the constant one"
                )
            for altitude_m in self._altitudes_in_wind_m():
                self.model_copy(update={"altitude_m": altitude_m}).scenario_winds_m_per_s()
            if given.hold_station and self.launch is not None:
                raise ValueError(
                    "hold_station holds a place in the wind of a month: give it without launch"
                )
        except InputError as error:
            first = error.problems[0]
            if first.line is None:
                raise wrong_value("wind", f"{first.source} {first.message}") from error
            why = "the table has a mistake"
            raise wrong_value("wind", why, problems=error.problems) from error
        except OSError as error:
            why = f"cannot read {given.file!r}: {error.strerror or error}"
            raise wrong_value("wind", why) from error
        except ValueError as error:
            raise wrong_value("wind", str(error)) from error
        return self

    def _altitudes_in_wind_m(self) -> list[float]:
        """Altitudes of flight, whose wind must be known.

        Above the floor the wind plays a part where the place is held, and on a flight path.
        """
        found = [self.altitude_m]
        if self.climb is not None and (self.holds_station or self.flight_path is not None):
            found.append(self.climb.ceiling_m)
        return found

    @property
    def pessimistic_clearness(self) -> float:
        """Clearness of all light, at the worst of its uncertainty margin [-]."""
        lowest = self.uncertainty_margins.clearness_minimum
        return self.clearness if lowest is None else lowest

    def pessimistic_power_factor(self, model: ModelName, correct: CorrectionName = "none") -> float:
        """Factor on the power of a solar model in this mission's light [-].

        With :attr:`pessimistic_clearness` this is all that corrections and uncertainty margins do
        to modelled power, in every study.

        Parameters
        ----------
        model : {"CDM", "CAM", "VM", "FM"}
            Solar power model.
        correct : {"none", "report", "loiter"}
            Correction of its systematic error; of ``loiter`` the part that is the same everywhere.

        Returns
        -------
        float
            Factor of the correction, less the margin of the model's RMS error.
        """
        known = correction(model, correct)
        return known.factor * self.uncertainty_margins.solar_factor(known.rms_relative)

    def without_margins(self) -> Mission:
        """Same mission with everything as assumed."""
        return self.model_copy(update={"uncertainty_margins": UncertaintyMargins()})

    @property
    def sky(self) -> ClearSky:
        """Clear-sky model."""
        return named_clear_sky(self.clear_sky)

    @property
    def wind(self) -> Wind:
        """Steady wind that the flight path is flown in: the strongest of scenarios and heights."""
        speed = self.wind_m_per_s
        if self.wind_statistics is not None:
            speed = _plain_number(self.winds_on_path_m_per_s(self.scenarios()).max(axis=0))
        return Wind(speed_m_per_s=speed, from_deg=self.wind_from_deg)

    def winds_on_path_m_per_s(self, scenarios: Scenarios) -> FloatArray:
        """Strongest wind of each scenario at the heights of flight [m/s]."""
        higher = [self.at_altitude(level_m) for level_m in self.climb_levels_m[1:]]
        winds = [one.scenario_winds_m_per_s(scenarios) for one in (self, *higher)]
        return np.asarray(np.max(winds, axis=0))

    @property
    def strongest_wind_m_per_s(self) -> float:
        """Wind that an aircraft must be faster than in all scenarios [m/s]."""
        if self.wind_statistics is None:
            return self.wind_m_per_s
        return _plain_number(self.scenario_winds_m_per_s().max(axis=0))

    def scenario_winds_m_per_s(self, scenarios: Scenarios | None = None) -> FloatArray:
        """Wind of each scenario, by default of the mission's own [m/s]."""
        some = self.scenarios() if scenarios is None else scenarios
        if self.wind_statistics is None:
            return np.full(len(some), self.wind_m_per_s)
        return self.wind_statistics.speeds(
            *(some.latitude_deg, some.day_of_year, self.altitude_m, self.longitude_deg)
        )

    @property
    def holds_station(self) -> bool:
        """Whether the aircraft flies faster where the wind is faster than its own airspeed."""
        return self.wind_statistics is not None and self.wind_statistics.hold_station

    @property
    def wind_latitudes_deg(self) -> tuple[float, float]:
        """Latitudes between which the wind is known [deg]."""
        if self.wind_statistics is None:
            return -90.0, 90.0
        known = self.wind_statistics.table(self.longitude_deg).latitude_deg
        return float(np.min(known)), float(np.max(known))

    def wind_to_beat_m_per_s(self, wind_m_per_s: FloatArray | float) -> FloatArray | float:
        """Part of a wind that the design's own airspeed must exceed: none where a place is held."""
        return 0.0 * wind_m_per_s if self.holds_station else wind_m_per_s

    def in_wind(self, wind_m_per_s: float) -> Mission:
        """Same mission in a wind that is the same everywhere and all year."""
        update = {"wind_m_per_s": wind_m_per_s, "wind_statistics": None}
        return self.model_copy(update=update)

    def latitudes(self) -> list[float]:
        """Latitudes of the mission [deg]."""
        if isinstance(self.latitude_deg, LatitudeRange):
            return self.latitude_deg.values()
        return [self.latitude_deg]

    def air_state(self) -> Air:
        """Air at the flight altitude."""
        offset_k = self.air.temperature_offset_k
        standard = standard_air(self.altitude_m, 0.0 if offset_k is None else offset_k)
        if self.air.ambient_temperature_c is None:
            return standard
        return air_at(self.air.ambient_temperature_c + ZERO_CELSIUS_K, standard.pressure_pa)

    @property
    def climb_levels_m(self) -> list[float]:
        """Altitudes between which a flight with climbs is linear, from its floor to its ceiling.

        At most 500 m apart, where the curvature of the pressure is 0.05 %; of more than 10 km of
        climb there are 21. A single one without climbs.
        """
        if self.climb is None:
            return [self.altitude_m]
        floor_m, ceiling_m = self.altitude_m, self.climb.ceiling_m
        count = int(np.ceil((ceiling_m - floor_m) / LEVEL_SPACING_M - 1e-9)) + 1
        levels = np.linspace(floor_m, ceiling_m, min(max(count, 2), MAXIMUM_LEVELS))
        return [float(level) for level in levels]

    @property
    def climb_label(self) -> str:
        """Climbs in words, for captions; empty without any."""
        if self.climb is None:
            return ""
        return f"climbs from {self.altitude_m:g} to {self.climb.ceiling_m:g} m"

    def reading_notes(self) -> list[str]:
        """What its file says that plays no part, in words."""
        if self.climb is None or self.climb.strategy is None:
            return []
        return ["climb.strategy is ignored: the height profile is the best there is"]

    def at_altitude(self, altitude_m: float) -> Mission:
        """Same mission at one constant other altitude, through the same weather.

        Air warmer than standard stays so by as many kelvin at every altitude, and modules of a
        given temperature stay as much warmer than the air.
        """
        here = self.air_state()
        standard = standard_air(self.altitude_m)
        offset_k = _plain_number(here.temperature_k - standard.temperature_k)
        update: dict[str, float | None] = {
            "temperature_offset_k": offset_k,
            "ambient_temperature_c": None,
        }
        if self.air.module_temperature_c is not None:
            warmer_k = self.air.module_temperature_c - _plain_number(here.temperature_c)
            there = standard_air(altitude_m, offset_k)
            update["module_temperature_c"] = _plain_number(there.temperature_c) + warmer_k
        air = self.air.model_copy(update=update)
        return self.model_copy(update={"altitude_m": float(altitude_m), "air": air, "climb": None})

    def climbing_from(self, floor_m: float) -> Mission:
        """Same mission with another night's floor, through the same weather; its ceiling stays."""
        level = self.at_altitude(floor_m)
        if self.climb is None:
            return level
        climb = self.climb.model_copy(update={"minimum_altitude_m": level.altitude_m})
        return level.model_copy(update={"climb": climb})

    def module_temperature_c(self) -> float:
        """Constant module temperature of CDM and CAM [C]: as given, else that of the air."""
        if self.air.module_temperature_c is not None:
            return self.air.module_temperature_c
        return _plain_number(self.air_state().temperature_c)

    def scenarios(self) -> Scenarios:
        """Every latitude on every day that stands for the dates, latitude by latitude."""
        days = self.dates.days()
        latitudes = self.latitudes()
        return Scenarios(
            latitude_deg=np.repeat(np.asarray(latitudes, float), len(days)),
            day_of_year=np.tile(np.asarray(days, int), len(latitudes)),
        )


@dataclass(frozen=True)
class Scenarios:
    """Latitude and day of year of each scenario, two arrays of one length.

    The days may be given as dates, ``["06-21"]`` or a ``DatetimeIndex``.
    """

    latitude_deg: FloatArray
    day_of_year: IntArray

    def __post_init__(self) -> None:
        if getattr(self.day_of_year, "dtype", np.dtype(object)).kind in "MUO":  # dates
            object.__setattr__(self, "day_of_year", dates.days_of_year(self.day_of_year))

    def __len__(self) -> int:
        return len(self.latitude_deg)

    @property
    def noon_day(self) -> FloatArray:
        """Fractional day of year of each scenario's noon, for the sun."""
        return np.asarray(self.day_of_year + 0.5)

    def label(self, index: int) -> str:
        """Readable name of a scenario, for instance ``47.6° N, 21 Jun``."""
        date = dates.date_label(int(self.day_of_year[index]))
        return f"{latitude_label(float(self.latitude_deg[index]))}, {date}"

    def in_polar_night(self) -> BoolArray:
        """Mark the scenarios in which the sun never rises."""
        times = sun_times(self.latitude_deg, declination(self.noon_day))
        return np.asarray(times.day_length_h <= 0.0)


def latitude_label(latitude_deg: float) -> str:
    """Readable latitude, for instance ``47.6° N``."""
    hemisphere = "" if latitude_deg == 0 else " S" if latitude_deg < 0 else " N"
    return f"{abs(float(latitude_deg)):g}\N{DEGREE SIGN}{hemisphere}"
