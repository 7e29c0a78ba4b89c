"""A mission: the records of its file, and what follows from them for a study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, Field, Strict, model_validator

from missions import dates as calendar
from missions.air import MAXIMUM_ALTITUDE_M, MINIMUM_ALTITUDE_M, Air, AirConditions, plain_number
from missions.files.validation import wrong_file
from missions.flight_path import FlightPath, Heading, Wind
from missions.mission.flight import ExcessTime, Flight, Launch
from missions.mission.scenarios import (
    OTHER_NAME,
    Altitude,
    Dates,
    Latitude,
    LatitudeRange,
    Longitude,
    Scenarios,
    latitude_label,
)
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
    spell,
    spell_ends,
    wrong_value,
)
from solar.systematic_errors import correction
from solar.types import FloatArray

MAXIMUM_SCENARIOS = 5000
_LEVEL_SPACING_M, _MAXIMUM_LEVELS = 500.0, 21  # of a flight with climbs


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
    def is_set(self) -> bool:
        """Return whether there is any margin."""
        return self != UncertaintyMargins()

    def check(self, clearness: float) -> None:
        """Refuse a worst clearness above the one that is assumed."""
        lowest = self.clearness_minimum
        if lowest is not None and lowest > clearness:
            text = f"must be at most the mission's clearness of {spell(clearness)}"
            raise wrong_value("uncertainty_margins.clearness_minimum", text, got=lowest)


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

    def check(self, altitude_m: float) -> None:
        """Refuse a floor or a ceiling that contradicts the mission's altitude."""
        floor_m, key = self.minimum_altitude_m, "climb.minimum_altitude_m"
        if floor_m is not None and floor_m > self.ceiling_m:
            text = f"must be at most climb.ceiling_m of {spell(self.ceiling_m)}"
            raise wrong_value(key, text, got=floor_m)
        if floor_m is not None and floor_m != altitude_m:
            raise wrong_value(key, OTHER_NAME.format("altitude_m", spell(altitude_m)), got=floor_m)
        if self.ceiling_m < altitude_m:
            text = f"must be at least the mission's altitude_m of {spell(altitude_m)}"
            raise wrong_value("climb.ceiling_m", text, got=self.ceiling_m)

    @property
    def record(self) -> dict[str, Any]:
        """Return the ceiling, JSON-ready; the floor is the mission's altitude."""
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
    clear_sky: Annotated[Text, AfterValidator(lambda n: named_clear_sky(n) and n)] = "ashrae"
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
        """Return name, place and time."""
        places, every = self.latitudes(), self.dates.range()
        return {
            "name": self.name,
            "latitude": " to ".join(map(latitude_label, places[:: len(places) - 1 or 1])),
            "dates": " to ".join(map(calendar.date_label, every[:: len(every) - 1 or 1])),
            "altitude [m]": self.altitude_m,
        }

    # ---- Records that contradict each other

    @model_validator(mode="before")
    @classmethod
    def _altitude_of_floor(cls, data: Any) -> Any:
        """Take the night's floor as the altitude, where there is none or it is null."""
        climb = data.get("climb") if isinstance(data, Mapping) else None
        keys = vars(climb) if isinstance(climb, Climb) else climb
        if not isinstance(keys, Mapping) or data.get("altitude_m") is not None:
            return data
        floor_m = keys.get("minimum_altitude_m")
        # What is no altitude is refused once, at its key.
        if not isinstance(floor_m, int | float) or isinstance(floor_m, bool):
            return data
        allowed = MINIMUM_ALTITUDE_M <= floor_m <= MAXIMUM_ALTITUDE_M
        return {**data, "altitude_m": floor_m} if allowed else data

    @model_validator(mode="after")
    def _check_together(self) -> Mission:
        """Refuse what contradicts itself, the wind last: each scenario has its own.

        Of a value with two names that of the other record is none of its own, or a study that
        varies the one would contradict the other.
        """
        if self.climb:
            self.climb.check(self.altitude_m)
            if self.climb.minimum_altitude_m is not None:
                self.model_fields_set.discard("altitude_m")
            if self.launch:
                raise wrong_value(
                    "climb", "a replayed flight keeps its altitude: give launch or climb, not both"
                )
        if self.launch:
            if self.longitude_deg is None:
                text = "a launch by clock time needs longitude_deg on the mission"
                raise wrong_value("launch", text)
            if isinstance(self.latitude_deg, LatitudeRange):
                raise wrong_value("latitude_deg", "a launch needs a single latitude")
        if self.flight:
            for name, other in (("launch", self.launch), ("climb", self.climb)):
                if other is not None:
                    raise wrong_value("flight", f"give flight or {name}, not both")
            self.flight.check(self.longitude_deg, self.required_excess_time_h)
            if self.flight.reserve_h is not None:
                object.__setattr__(self, "required_excess_time_h", self.flight.reserve_h)
                self.model_fields_set.discard("required_excess_time_h")
        count = len(self.latitudes()) * len(self.dates.days())
        if count > MAXIMUM_SCENARIOS:
            text = f"latitudes times days must be at most {MAXIMUM_SCENARIOS} scenarios"
            raise wrong_value("latitude_deg", text, got=count)
        self.uncertainty_margins.check(self.clearness)
        if self.wind_statistics:
            self._check_wind(self.wind_statistics)
        return self

    def _check_wind(self, statistics: WindStatistics) -> None:
        """Refuse statistics that do not tell the wind of every flight of the mission."""
        try:
            if self.wind_m_per_s:
                raise ValueError(
                    f"give wind or wind_m_per_s (got {spell(self.wind_m_per_s)} m/s), not both: "
                    "wind_m_per_s: 0 leaves it to wind, wind: null to the constant one"
                )
            # Above the floor the wind plays a part where the place is held, and on a flight path.
            at_altitude = statistics.hold_station or self.flight_path is not None
            for altitude_m in {self.altitude_m, self.ceiling_m if at_altitude else self.altitude_m}:
                self.model_copy(update={"altitude_m": altitude_m}).scenario_winds_m_per_s()
            if statistics.hold_station and self.launch is not None:
                raise ValueError(
                    "hold_station holds a place in the wind of a month: give it without launch"
                )
        except ValueError as error:
            raise wrong_file("wind", error) from error

    def reading_notes(self) -> list[str]:
        """Return notes on keys of its file that play no part."""
        if not (self.climb and self.climb.strategy):
            return []
        return ["climb.strategy is ignored: the height profile is the best there is"]

    # ---- Scenarios

    def latitudes(self) -> list[float]:
        """Return the latitudes [deg]."""
        if isinstance(self.latitude_deg, LatitudeRange):
            return self.latitude_deg.values()
        return [self.latitude_deg]

    def scenarios(self) -> Scenarios:
        """Return every latitude on every day that stands for the dates, latitude by latitude."""
        latitudes, days = self.latitudes(), self.dates.days()
        return Scenarios(
            latitude_deg=np.repeat(np.asarray(latitudes, float), len(days)),
            day_of_year=np.tile(np.asarray(days, int), len(latitudes)),
        )

    @property
    def days_of_light(self) -> int:
        """Return the days of the time axis: one that repeats, or all that a flight may see."""
        return 1 if self.flight is None else self.flight.days

    def flight_window_h(self, scenarios: Scenarios) -> tuple[FloatArray, FloatArray] | None:
        """Return the solar time of launch and landing [h]; None where a day repeats."""
        flight = self.flight
        return None if flight is None else flight.window_h(scenarios, self.longitude_deg)

    # ---- Light

    @property
    def sky(self) -> ClearSky:
        """Return the clear-sky model."""
        return named_clear_sky(self.clear_sky)

    @property
    def pessimistic_clearness(self) -> float:
        """Return the clearness of all light, at the worst of its uncertainty margin [-]."""
        lowest = self.uncertainty_margins.clearness_minimum
        return self.clearness if lowest is None else lowest

    def pessimistic_power_factor(self, model: ModelName, correct: CorrectionName = "none") -> float:
        """Return the factor on the power of a solar model in this mission's light [-].

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
        less = self.uncertainty_margins.solar_model_sigmas * known.rms_relative
        return known.factor * max(1.0 - less, 0.0)

    def without_margins(self) -> Mission:
        """Return the mission without margins."""
        return self.model_copy(update={"uncertainty_margins": UncertaintyMargins()})

    # ---- Heights and their air

    @property
    def ceiling_m(self) -> float:
        """Return the highest altitude of flight [m]."""
        return self.climb.ceiling_m if self.climb else self.altitude_m

    @property
    def highest_floor_m(self) -> float:
        """Return the highest altitude that flights may begin from, infinite without climbs [m]."""
        return self.climb.ceiling_m if self.climb else np.inf

    @property
    def climb_levels_m(self) -> list[float]:
        """Return the altitudes between which a flight is linear; a single one without climbs.

        At most 500 m apart, where the curvature of the pressure is 0.05 %; of more than 10 km of
        climb there are 21.
        """
        floor_m, ceiling_m = self.altitude_m, self.ceiling_m
        if not self.climb:
            return [floor_m]
        count = int(np.ceil((ceiling_m - floor_m) / _LEVEL_SPACING_M - 1e-9)) + 1
        levels = np.linspace(floor_m, ceiling_m, min(max(count, 2), _MAXIMUM_LEVELS))
        return [float(level) for level in levels]

    @property
    def climb_label(self) -> str:
        """Return the climbs in words, for captions; empty without any."""
        levels = spell_ends((self.altitude_m, self.ceiling_m))
        return f"climbs from {levels} m" if self.climb else ""

    def air_state(self) -> Air:
        """Return the air at the flight altitude."""
        return self.air.state(self.altitude_m)

    def module_temperature_c(self) -> float:
        """Return the constant module temperature of CDM and CAM, else that of the air [C]."""
        if self.air.module_temperature_c is not None:
            return self.air.module_temperature_c
        air_c: float = plain_number(self.air_state().temperature_c)
        return air_c

    def at_altitude(self, altitude_m: float) -> Mission:
        """Return the mission at another constant altitude, through the same weather."""
        air = self.air.moved(self.altitude_m, altitude_m)
        return self.model_copy(update={"altitude_m": float(altitude_m), "air": air, "climb": None})

    def climbing_from(self, floor_m: float) -> Mission:
        """Return the mission with another night's floor and the same ceiling and weather."""
        level = self.at_altitude(floor_m)
        climb = self.climb and self.climb.model_copy(
            update={"minimum_altitude_m": level.altitude_m}
        )
        return level.model_copy(update={"climb": climb})

    # ---- Wind

    @property
    def holds_station(self) -> bool:
        """Return whether the aircraft flies as fast as winds above its calm airspeed."""
        return self.wind_statistics is not None and self.wind_statistics.hold_station

    def scenario_winds_m_per_s(self, scenarios: Scenarios | None = None) -> FloatArray:
        """Return the wind of each scenario, by default of the mission's [m/s]."""
        scenarios = self.scenarios() if scenarios is None else scenarios
        if self.wind_statistics is None:  # the same everywhere and all year
            return np.full(len(scenarios), self.wind_m_per_s)
        place = (scenarios.latitude_deg, scenarios.day_of_year, self.altitude_m, self.longitude_deg)
        return self.wind_statistics.speeds(*place)

    @property
    def strongest_wind_m_per_s(self) -> float:
        """Return the wind that an aircraft must be faster than in all scenarios [m/s]."""
        if self.wind_statistics is None:
            return self.wind_m_per_s
        strongest: float = plain_number(self.scenario_winds_m_per_s().max(axis=0))
        return strongest

    def winds_on_path_m_per_s(self, scenarios: Scenarios) -> FloatArray:
        """Return the strongest wind of each scenario at the heights of flight [m/s]."""
        higher = [self.at_altitude(level_m) for level_m in self.climb_levels_m[1:]]
        winds = [level.scenario_winds_m_per_s(scenarios) for level in (self, *higher)]
        return np.asarray(np.max(winds, axis=0))

    @property
    def wind(self) -> Wind:
        """Return the steady wind of the flight path: the strongest of scenarios and heights."""
        speed = plain_number(self.winds_on_path_m_per_s(self.scenarios()).max(axis=0))
        return Wind(speed_m_per_s=speed, from_deg=self.wind_from_deg)

    @property
    def wind_latitudes_deg(self) -> tuple[float, float]:
        """Return the latitudes between which the wind is known [deg]."""
        if self.wind_statistics is None:
            return -90.0, 90.0
        known = self.wind_statistics.table(self.longitude_deg).latitude_deg
        return float(np.min(known)), float(np.max(known))

    def wind_to_beat_m_per_s(self, wind_m_per_s: FloatArray | float) -> FloatArray | float:
        """Return the wind that the calm airspeed must exceed: 0 where a place is held."""
        return (not self.holds_station) * wind_m_per_s

    def in_wind(self, wind_m_per_s: float) -> Mission:
        """Return the mission in a wind that is the same everywhere and all year."""
        update = {"wind_m_per_s": wind_m_per_s, "wind_statistics": None}
        return self.model_copy(update=update)
