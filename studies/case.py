"""Aircraft on a mission as their files have them: what a command or a page computes from.

What a study needs of them is refused in terms of their files.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Generic, NoReturn, Self, TypeVar

from missions.files.errors import dotted
from missions.files.overrides import with_overrides
from missions.files.validation import located_error, validate
from missions.files.yaml import Document
from missions.library import MISSION_PREFIX
from missions.mission import Mission
from missions.weather.files import weather_file
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.heights import ClimbLimitError, check_climb_limits
from sizing.day.light import SolarModel
from sizing.day.module_power import path_troubles
from sizing.mass_budget import with_total_mass
from solar.names import ATTITUDE_MODELS
from solar.schema import spell
from studies.output.run_folder import InputFile, RunInputs

R = TypeVar("R", Aircraft, Mission)

DEFAULT_MISSION = " (default mission)"  # behind the name of one that nobody chose


@dataclass(frozen=True)
class Loaded(Generic[R]):
    """A validated aircraft or mission, the document it came from, and the checksum of its file."""

    record: R
    document: Document
    sha256: str | None = None

    def changed(self, values: Mapping[str, Any], *, prefix: str = "") -> Self:
        """Return it with other values by their dotted keys, checked as the file's are.

        ``prefix``: before each key, for the problems that name it.
        """
        document = with_overrides(self.document, values, prefix=prefix)
        record = validate(document, type(self.record))
        return replace(self, record=record, document=document)


@dataclass(frozen=True)
class Case:
    """What a command is asked about: an aircraft on a mission under a solar power model."""

    aircraft_file: Loaded[Aircraft]
    mission_file: Loaded[Mission]
    mission_is_default: bool = False
    solar: SolarModel = field(default_factory=SolarModel)
    total_mass_kg: float | None = None

    @property
    def aircraft(self) -> Aircraft:
        """Validated aircraft."""
        return self.aircraft_file.record

    @property
    def mission(self) -> Mission:
        """Validated mission."""
        return self.mission_file.record

    @property
    def title(self) -> str:
        """Aircraft and mission in one line, which says so where nobody chose the mission."""
        chosen = DEFAULT_MISSION if self.mission_is_default else ""
        return f"{self.aircraft.name} on {self.mission.name}{chosen}"

    @property
    def arguments(self) -> dict[str, Any]:
        """Arguments that all studies of the case have, by name."""
        return {"aircraft": self.aircraft, "mission": self.mission} | vars(self.solar)

    def named(self, record: Mapping[str, Any]) -> dict[str, Any]:
        """Return the record of a result with the names of aircraft and mission, JSON-ready."""
        return {
            **record,
            "aircraft": self.aircraft.name,
            "mission": self.mission.name,
            "mission_is_default": self.mission_is_default,
        }

    def refuse(self, key: str, message: str) -> NoReturn:
        """Refuse the value of a key, which is the mission's behind ``mission.``, by its line."""
        file = self.mission_file if key.startswith(MISSION_PREFIX) else self.aircraft_file
        path = key.removeprefix(MISSION_PREFIX).split(".")
        raise located_error(file.document, path, message) from None

    def with_mission(self, **values: Any) -> Case:
        """Return the case on a mission with other values, checked as the file's are."""
        file = self.mission_file.changed(values, prefix=MISSION_PREFIX)
        return replace(self, mission_file=file)

    def with_total_mass(self, total_mass_kg: float) -> Case:
        """Return the case of an aircraft of a known total mass, or raise ImpossibleDesignError."""
        airframe = with_total_mass(self.aircraft, self.mission, total_mass_kg).airframe
        key = airframe.unaccounted_mass_key
        file = self.aircraft_file.changed({f"airframe.{key}": getattr(airframe, key)})
        return replace(self, aircraft_file=file, total_mass_kg=total_mass_kg)

    def inputs(self, weather: str | None = None, **others: Path) -> RunInputs:
        """Return everything that a folder of results keeps of what went in.

        ``weather``: weather record, by its file or a shipped one's name. ``**others``: further
        files that were read, by what they are.
        """
        aircraft, mission = self.aircraft_file, self.mission_file
        files = {
            "aircraft": InputFile(aircraft.document.source, aircraft.sha256),
            "mission": InputFile(mission.document.source, mission.sha256),
            **{kind: InputFile.of(path) for kind, path in others.items()},
        }
        if weather is not None:
            with weather_file(weather) as (path, source):
                files["weather"] = InputFile(source, InputFile.of(path).sha256)
        return RunInputs(aircraft.document.data, mission.document.data, self.solar, files)

    def flyable(self, *, sized: bool = False, in_winds_of_cells: bool = False) -> Case:
        """Return the case; refuse an aircraft that cannot fly the mission's path and climbs.

        ``sized``: whether masses and rated power are yet to be found. ``in_winds_of_cells``:
        percentiles of the wind are those of cells, not of the mission.
        """
        self.require_path(in_winds_of_cells=in_winds_of_cells)
        if not sized:
            try:
                check_climb_limits(self.aircraft, self.mission)
            except ClimbLimitError as error:
                self.refuse(dotted(error.key), error.message)
            return self
        ratio = self.aircraft.propulsion.climb_power_ratio
        if self.mission.climb is not None and ratio is not None and ratio <= 1.0:
            message = "a mission with climb needs more power than level flight takes"
            got = f"allowed: above 1 (got {spell(ratio)}), or climb_rate_m_per_s"
            self.refuse("airframe.propulsion.climb_power_ratio", f"{message}; {got}")
        return self

    def require_path(self, option: str | None = None, *, in_winds_of_cells: bool = False) -> None:
        """Refuse an aircraft without module surfaces and a mission without a path it can fly.

        ``option``: what needs both, for the message; if left out, VM, FM and the loiter correction
        do. ``in_winds_of_cells``: see :meth:`flyable`.
        """
        solar = self.solar
        if option is None:
            if not solar.needs_path:
                return
            attitude = solar.model in ATTITUDE_MODELS
            option = f"--model {solar.model}" if attitude else "--correction loiter"
        if self.aircraft.modules.geometry is None:
            message = f"{option} needs the module surfaces: add geometry with its surfaces"
            self.refuse("modules", message)
        if self.mission.flight_path is None:
            message = f"{option} needs a flight path: add flight_path with kind, radius_m, ..."
            self.refuse("mission.name", message)
        if in_winds_of_cells and self.mission.wind_statistics is not None:
            return
        (trouble,) = path_troubles(self.aircraft, self.mission)
        if trouble is not None:
            self.refuse("mission.flight_path", trouble)

    def refuse_polar_night(self) -> None:
        """Refuse scenarios in which the sun never rises: no design could fly through them."""
        scenarios = self.mission.scenarios()
        dark = scenarios.in_polar_night()
        if dark.any():
            label = scenarios.label(int(dark.argmax()))
            message = f"polar night: the sun never rises at {label}"
            self.refuse("mission.latitude_deg", f"{message}; allowed: latitudes and dates with sun")

    def require_parametric(self, message: str) -> None:
        """Refuse a measured aircraft where masses and power must follow from the design."""
        if isinstance(self.aircraft.airframe, MeasuredAirframe):
            self.refuse("airframe.kind", message)
