"""Aircraft and missions of the command line: validated, with the lines they came from.

What a command needs of them is told in terms of their files.
"""

from __future__ import annotations

import gc
import hashlib
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Generic, NoReturn, TypeVar

import click
from click.core import ParameterSource

from missions.files.errors import (
    OVERRIDE,
    InputError,
    Problem,
    did_you_mean,
    dotted,
    file_error,
    printable,
)
from missions.files.overrides import with_overrides
from missions.files.shipped import Kind, find_document, shipped_names, shipped_text
from missions.files.validation import located_error, validate
from missions.files.yaml import Document
from missions.library import MISSION_PREFIX
from missions.mission import Mission
from missions.weather.files import weather_file
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.heights import ClimbLimitError, check_climb_limits
from sizing.day.light import SolarModel
from sizing.day.module_power import path_troubles
from sizing.library import refuse_named_twice
from sizing.mass_budget import ImpossibleDesignError, with_total_mass
from sizing.parameters import design_keys
from solar.names import ATTITUDE_MODELS, CorrectionName, ModelName
from solar.schema import spell
from studies.cli.telling import tell_error
from studies.output.run_folder import InputFile, RunFolder, RunInputs

R = TypeVar("R", Aircraft, Mission)

DEFAULT_MISSION = " (default mission)"  # behind the name of one that nobody chose
_AIRCRAFT_PREFIX = "aircraft."
_A_KIND: dict[Kind, str] = {"aircraft": "an aircraft", "mission": "a mission"}
_OTHER: dict[Kind, Kind] = {"aircraft": "mission", "mission": "aircraft"}


@dataclass(frozen=True)
class Loaded(Generic[R]):
    """A validated aircraft or mission, the document it came from, and the checksum of its file."""

    record: R
    document: Document
    sha256: str | None = None


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
        document = with_overrides(self.mission_file.document, values, prefix=MISSION_PREFIX)
        file = replace(self.mission_file, record=validate(document, Mission), document=document)
        return replace(self, mission_file=file)

    def holding_station(self, percentile: float) -> Case:
        """Return the case of flight as fast as a percentile of the wind of each scenario."""
        wind = self.mission_file.document.data.get("wind")
        file = {"file": wind["file"]} if isinstance(wind, dict) and "file" in wind else {}
        return self.with_mission(wind={"percentile": percentile, "hold_station": True, **file})

    def with_total_mass(self, total_mass_kg: float) -> Case:
        """Return the case of an aircraft of a known total mass; print the rest as a note."""
        try:
            aircraft = with_total_mass(self.aircraft, self.mission, total_mass_kg)
        except ImpossibleDesignError as error:
            raise click.BadParameter(str(error), param_hint="--mass") from None
        key = aircraft.airframe.unaccounted_mass_key
        now, before = (getattr(version.airframe, key) for version in (aircraft, self.aircraft))
        rest = f"{spell(now, 4)} instead of {spell(before, 4)}"
        tell_error(f"solar-uav: --mass {spell(total_mass_kg)}: airframe.{key} is {rest}")
        file = self.aircraft_file
        document = with_overrides(file.document, {f"airframe.{key}": now})
        file = replace(file, record=validate(document, Aircraft), document=document)
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

    def refuse_climb(self) -> None:
        """Refuse a mission with climbs where percentiles of the wind are those of one altitude."""
        if self.mission.climb is not None:
            why = "the percentiles of the winds at several heights have none in common"
            message = f"station flies at constant altitude, as {why}; remove climb"
            self.refuse("mission.climb", message)

    def require_climber(self) -> None:
        """Refuse an aircraft that cannot climb on a mission that has climbs."""
        try:
            check_climb_limits(self.aircraft, self.mission)
        except ClimbLimitError as error:
            self.refuse(dotted(error.key), error.message)

    def require_climb_power(self) -> None:
        """Refuse a parametric aircraft that is sized for climbs without any power for them."""
        ratio = self.aircraft.propulsion.climb_power_ratio
        if self.mission.climb is not None and ratio is not None and ratio <= 1.0:
            message = (
                f"a mission with climb needs more power than level flight takes; allowed: above 1 "
                f"(got {spell(ratio)}), or climb_rate_m_per_s"
            )
            self.refuse("airframe.propulsion.climb_power_ratio", message)

    def require_path(self, option: str | None = None, *, in_winds_of_cells: bool = False) -> None:
        """Refuse an aircraft without module surfaces and a mission without a path it can fly.

        ``option``: what needs both, for the message; if left out, VM, FM and the loiter correction
        do. ``in_winds_of_cells``: percentiles of the wind are those of cells, not of the mission.
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

    def require_whole_cells(self) -> None:
        """Refuse an aircraft whose file lays no solar cells, or has no cells in its battery."""
        message = "required key is missing: --whole-cells needs it"
        if self.aircraft.modules.layout is None:
            self.refuse("modules.layout", message)
        if self.aircraft.battery.pack is None:
            self.refuse("battery.pack", message)

    @contextmanager
    def uncertain_inputs(self) -> Iterator[None]:
        """Tell what is wrong with uncertain inputs by the lines of the files."""
        try:
            yield
        except InputError as error:
            files = (self.mission_file, self.aircraft_file)
            documents = {file.record.name: file.document for file in files}
            placed = []
            for problem in error.problems:
                document = documents.get(problem.source)
                if document is not None:
                    path = tuple(problem.key.split(".", 2))
                    line, column = document.key_marks.get(path) or (None, None)
                    problem = Problem(document.source, line, column, problem.key, problem.message)
                placed.append(problem)
            raise InputError(placed) from error
        except ValueError as error:
            raise click.UsageError(str(error)) from error


class WrongKindError(InputError):
    """A mission given as an aircraft, or the reverse."""

    def __init__(self, source: str, kind: Kind) -> None:
        self.source, self.found = source, kind
        message = f"is {_A_KIND[kind]}, not {_A_KIND[_OTHER[kind]]}"
        hint = "missions are given with --mission" if kind == "mission" else "AIRCRAFT comes first"
        super().__init__([Problem(source, None, None, "", f"{message}: {hint}")])


def opened(
    kind: Kind, name_or_path: str, overrides: Sequence[str] = (), *, of_run: bool = False
) -> Loaded[Any]:
    """Read an aircraft or a mission by its shipped name, or the path of a file; refuse the other.

    ``overrides``: texts ``key=value`` of both kinds, which replace or add keys of the file.
    ``of_run``: whether a run wrote it, with its overrides in it.
    """
    if not gc.isenabled():  # as the command was started: what is imported stays
        gc.freeze()
        gc.enable()
    is_aircraft = kind == "aircraft"
    record, other = (Aircraft, Mission) if is_aircraft else (Mission, Aircraft)
    mine = [
        _with_whole_key(text.removeprefix(_AIRCRAFT_PREFIX))
        if is_aircraft
        else text.removeprefix(MISSION_PREFIX)
        for text in overrides
        if text.startswith(MISSION_PREFIX) is not is_aircraft
    ]
    if is_aircraft:
        _refuse_keys_of_missions(mine)
    document = find_document(kind, name_or_path)
    keys = set(document.data)
    if len(keys & set(other.model_fields)) > len(keys & set(record.model_fields)):
        raise WrongKindError(document.source, _OTHER[kind])
    document = with_overrides(document, mine, prefix="" if is_aircraft else MISSION_PREFIX)
    checked = validate(document, record)
    if is_aircraft and not of_run:
        refuse_named_twice(document)
    if name_or_path in shipped_names(kind) and not Path(name_or_path).is_file():
        sha256: str | None = hashlib.sha256(shipped_text(name_or_path).encode()).hexdigest()
    else:
        sha256 = InputFile.of(Path(name_or_path)).sha256
    return Loaded(checked, document, sha256)


def _with_whole_key(override: str) -> str:
    """Return an override with the whole key of a design variable's short name."""
    key, equals, value = override.partition("=")
    return f"{design_keys().get(key, key)}{equals}{value}"


def load(
    aircraft: str,
    mission: str | None,
    overrides: Sequence[str],
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
) -> Case:
    """Load what the options of a command name, and report what is wrong with it together.

    A folder that ``--out`` wrote stands for an aircraft, and its mission, model and correction for
    options that are not given.
    """
    is_default = _is_default("mission")
    is_folder = os.path.isdir(aircraft)  # noqa: PTH112 - takes any text for a path
    folder = RunFolder.at(aircraft) if is_folder else None
    if is_folder and folder is None:
        message = "is a folder without run.json; allowed: a folder that --out wrote, or a file"
        raise file_error(printable(aircraft), message)
    if folder is not None:
        aircraft = folder.aircraft
        if is_default:
            mission, is_default = folder.mission, False
        model = folder.model if _is_default("model") else model
        correction = folder.correction if _is_default("correction") else correction
    beside = mission_beside(aircraft)
    if mission is None and beside is not None:
        mission, is_default = beside, False
        tell_error(f"solar-uav: flown is the mission beside it, -m {beside}")
    if mission is None:
        raise click.UsageError("Missing option '--mission' / '-m'.")
    files: list[Loaded[Any]] = []
    errors: list[InputError] = []
    named: dict[Kind, str] = {"aircraft": aircraft, "mission": mission}
    for kind, name in named.items():
        try:
            files.append(opened(kind, name, overrides, of_run=folder is not None))
        except InputError as error:
            errors.append(error)
    if errors:
        raise _joined_errors(errors)
    aircraft_file, mission_file = files
    case = Case(aircraft_file, mission_file, is_default, SolarModel(model, correction))
    if case.mission.holds_station and isinstance(case.aircraft.airframe, MeasuredAirframe):
        message = "needs a parametric aircraft: this one's power is known at one airspeed"
        case.refuse("mission.wind.hold_station", message)
    if is_default and mission != beside and beside is not None:
        tell_error(f"solar-uav: the default mission is used; the one beside: -m {beside}")
    return case


def mission_beside(aircraft: str) -> str | None:
    """Return the mission file that ``init`` writes beside an aircraft's; None without one."""
    beside = f"{os.path.splitext(aircraft)[0]}-mission.yaml"  # noqa: PTH122 - takes any text
    return beside if os.path.isfile(beside) else None  # noqa: PTH113


def _joined_errors(errors: Sequence[InputError]) -> InputError:
    """Return all problems as one error; two files in each other's place are one mistake."""
    swapped = [error for error in errors if isinstance(error, WrongKindError)]
    if len(swapped) == 2:
        first, second = (_A_KIND[error.found] for error in swapped)
        message = f"is {first}, and {swapped[1].source} is {second}: swap the two"
        return file_error(swapped[0].source, message)
    return InputError([problem for error in errors for problem in error.problems])


def _is_default(option: str) -> bool:
    """Return whether an option of the running command has its default value."""
    context = click.get_current_context(silent=True)
    if context is None:
        return False
    return context.get_parameter_source(option) is ParameterSource.DEFAULT


def _refuse_keys_of_missions(overrides: Sequence[str]) -> None:
    """Tell a key of the mission that lacks its prefix, and a short name that is misspelt."""
    of_missions = Mission.model_fields.keys() - Aircraft.model_fields.keys()
    problems = []
    for override in overrides:
        key = override.partition("=")[0].strip()
        message = ""
        if key.partition(".")[0] in of_missions:
            message = f"is a key of the mission: write {MISSION_PREFIX}{key}"
        elif "." not in key and key not in {*Aircraft.model_fields, *Aircraft.explained_keys}:
            meant = did_you_mean(key, [*design_keys(), *Aircraft.model_fields])
            message = f"unknown key{meant}" if meant else ""
        if message:
            problems.append(Problem(f"{OVERRIDE}{key}", None, None, "", message))
    if problems:
        raise InputError(problems)
