"""Aircraft and missions of the command line: validated, with the lines they came from."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

import click
from click.core import ParameterSource

from missions.dates import date_code
from missions.files.errors import OVERRIDE, InputError, Problem, file_error, printable
from missions.files.overrides import with_overrides
from missions.files.shipped import Kind, find_document, shipped_names, shipped_text
from missions.files.validation import located_error, validate
from missions.files.writing import names_a_device, write_files_atomically
from missions.files.yaml import Document
from missions.library import MISSION_PREFIX
from missions.mission import Mission
from missions.weather.files import weather_file
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import ImpossibleDesignError, with_total_mass
from sizing.parameters import design_keys
from sizing.sunlight import SolarModel
from studies.cli.options import CaseOptions, PlaceOptions
from studies.cli.telling import tell_error
from studies.output.run_folder import InputFile, RunFolder, RunInputs

T = TypeVar("T")

DEFAULT_MISSION = " (default mission)"  # behind the name of one that nobody chose
_AIRCRAFT_PREFIX = "aircraft."
_YAML = (".yaml", ".yml")
_A_KIND: dict[Kind, str] = {"aircraft": "an aircraft", "mission": "a mission"}
_OTHER: dict[Kind, Kind] = {"aircraft": "mission", "mission": "aircraft"}


@dataclass(frozen=True)
class LoadedAircraft:
    """A validated aircraft, the document it came from, and the checksum of its file."""

    aircraft: Aircraft
    document: Document
    sha256: str | None = None


@dataclass(frozen=True)
class LoadedMission:
    """A validated mission, the document it came from, and the checksum of its file."""

    mission: Mission
    document: Document
    sha256: str | None = None


@dataclass(frozen=True)
class Case:
    """What a command is asked about: an aircraft on a mission under a solar power model."""

    craft: LoadedAircraft
    where: LoadedMission
    mission_is_default: bool = False
    solar: SolarModel = dataclasses.field(default_factory=SolarModel)
    as_json: bool = False

    @property
    def aircraft(self) -> Aircraft:
        """Validated aircraft."""
        return self.craft.aircraft

    @property
    def mission(self) -> Mission:
        """Validated mission."""
        return self.where.mission

    @property
    def title(self) -> str:
        """Aircraft and mission in one line, which says so where nobody chose the mission."""
        chosen = DEFAULT_MISSION if self.mission_is_default else ""
        return f"{self.aircraft.name} on {self.mission.name}{chosen}"

    def named(self, record: Mapping[str, Any]) -> dict[str, Any]:
        """Record of a result with the names of aircraft and mission, JSON-ready."""
        return {
            **record,
            "aircraft": self.aircraft.name,
            "mission": self.mission.name,
            "mission_is_default": self.mission_is_default,
        }

    def with_mission(self, **values: Any) -> Case:
        """Case on a mission with other values, checked as the file's own are."""
        document = with_overrides(self.where.document, values, prefix=MISSION_PREFIX)
        mission = LoadedMission(validate(document, Mission), document, self.where.sha256)
        return dataclasses.replace(self, where=mission)

    def at(self, place: PlaceOptions) -> Case:
        """Case at another place or on another day; the mission's launch is one at its own."""
        moved: dict[str, Any] = {}
        if place.latitude is not None:
            moved["latitude_deg"] = place.latitude
        if place.day is not None:
            moved["dates"] = {"on": date_code(place.day)}
        return self.with_mission(**moved, launch=None) if moved else self

    def holding_station(self, percentile: float) -> Case:
        """Case of a mission flown as fast as a percentile of the wind of each scenario."""
        given = self.where.document.data.get("wind")
        file = {"file": given["file"]} if isinstance(given, dict) and "file" in given else {}
        return self.with_mission(wind={"percentile": percentile, "hold_station": True, **file})

    def with_total_mass(self, total_mass_kg: float) -> Case:
        """Case of an aircraft of a known total mass; the rest is told on standard error."""
        try:
            aircraft = with_total_mass(self.aircraft, self.mission, total_mass_kg)
        except ImpossibleDesignError as error:
            raise click.BadParameter(str(error), param_hint="--mass") from None
        key = aircraft.airframe.unaccounted_mass_key
        now, before = (getattr(one.airframe, key) for one in (aircraft, self.aircraft))
        rest = f"{now:.4g} instead of {before:.4g}"
        tell_error(f"solar-uav: --mass {total_mass_kg:g}: airframe.{key} is {rest}")
        craft = dataclasses.replace(self.craft, aircraft=aircraft)
        return dataclasses.replace(self, craft=craft)

    def inputs(self, weather: str | None = None, **others: Path) -> RunInputs:
        """Everything that a folder of results keeps of what went in.

        ``weather``: weather record, by its file or a shipped one's name. ``**others``: further
        files that were read, by what they are.
        """
        craft, where = self.craft, self.where
        files = {
            "aircraft": InputFile(craft.document.source, craft.sha256),
            "mission": InputFile(where.document.source, where.sha256),
            **{kind: InputFile.of(path) for kind, path in others.items()},
        }
        if weather is not None:
            with weather_file(weather) as (path, source):
                files["weather"] = InputFile(source, InputFile.of(path).sha256)
        return RunInputs(craft.document.data, where.document.data, self.solar, files)


class WrongKindError(InputError):
    """A mission given as an aircraft, or the reverse."""

    def __init__(self, source: str, kind: Kind) -> None:
        self.source, self.found = source, kind
        message = f"is {_A_KIND[kind]}, not {_A_KIND[_OTHER[kind]]}"
        hint = "missions are given with --mission" if kind == "mission" else "AIRCRAFT comes first"
        super().__init__([Problem(source, None, None, "", f"{message}: {hint}")])


def split_overrides(overrides: Sequence[str]) -> tuple[list[str], list[str]]:
    """Sort ``key=value`` overrides into those of the aircraft and those of the mission."""
    of_mission = [o for o in overrides if o.startswith(MISSION_PREFIX)]
    of_aircraft = [
        _with_whole_key(o.removeprefix(_AIRCRAFT_PREFIX)) for o in overrides if o not in of_mission
    ]
    return of_aircraft, [o.removeprefix(MISSION_PREFIX) for o in of_mission]


def _with_whole_key(override: str) -> str:
    """Override with the key of a design variable that is given by its short name."""
    key, equals, value = override.partition("=")
    return f"{design_keys().get(key, key)}{equals}{value}"


def open_aircraft(name_or_path: str, overrides: Sequence[str] = ()) -> LoadedAircraft:
    """Read an aircraft by name or path.

    ``name_or_path``: name of a shipped one, or path of a file. ``overrides``: texts
    ``dotted.key=value`` that replace or add keys of the file.
    """
    _refuse_keys_of_missions(overrides)
    document = with_overrides(_find("aircraft", name_or_path), overrides)
    return LoadedAircraft(
        validate(document, Aircraft), document, _checksum("aircraft", name_or_path)
    )


def open_mission(name_or_path: str, overrides: Sequence[str] = ()) -> LoadedMission:
    """Read a mission by name or path.

    ``name_or_path``: name of a shipped one, or path of a file. ``overrides``: texts
    ``dotted.key=value`` that replace or add keys of the file.
    """
    document = with_overrides(_find("mission", name_or_path), overrides, prefix=MISSION_PREFIX)
    return LoadedMission(validate(document, Mission), document, _checksum("mission", name_or_path))


def load(
    options: CaseOptions,
    place: PlaceOptions | None = None,
    *,
    required_excess_time_h: float | None = None,
) -> Case:
    """Load what the options of a command name, and report what is wrong with it together.

    A folder that ``--out`` wrote stands for an aircraft, and its mission, model and correction for
    options that are not given. ``required_excess_time_h``: what the mission requires instead of its
    own.
    """
    aircraft, mission = options.aircraft, options.mission
    model, correction = options.model, options.correction
    is_default = _is_default("mission")
    folder = RunFolder.at(aircraft)
    if folder is None and os.path.isdir(aircraft):  # noqa: PTH112 - takes any text for a path
        message = "is a folder without run.json; allowed: a folder that --out wrote, or a file"
        raise file_error(printable(aircraft), message)
    if folder is not None:
        aircraft = folder.aircraft
        if is_default:
            mission, is_default = folder.mission, False
        model = folder.model if _is_default("model") else model
        correction = folder.correction if _is_default("correction") else correction
    if mission is None:
        raise click.UsageError("Missing option '--mission' / '-m'.")
    of_aircraft, of_mission = split_overrides(options.overrides)
    errors: list[InputError] = []
    craft = _attempt(partial(open_aircraft, aircraft, of_aircraft), errors)
    where = _attempt(partial(open_mission, mission, of_mission), errors)
    if craft is None or where is None:
        raise _joined_errors(errors)
    solar = SolarModel(model, correction)  # type: ignore[arg-type]  # click checked both
    case = Case(craft, where, is_default, solar, options.as_json)
    if case.mission.holds_station and isinstance(case.aircraft.airframe, MeasuredAirframe):
        message = "needs a parametric aircraft: this one's power is known at one airspeed"
        raise located_error(case.where.document, ("wind", "hold_station"), message)
    beside = Path(aircraft).with_name(f"{Path(aircraft).stem}-mission.yaml")
    if is_default and os.path.isfile(beside):  # noqa: PTH113 - takes any text for a path
        tell_error(f"solar-uav: the default mission is flown; beside it lies -m {beside}")
    case = case if place is None else case.at(place)
    if required_excess_time_h is None:
        return case
    return case.with_mission(required_excess_time_h=required_excess_time_h)


def write_starters(name: str, folder: Path) -> list[Path]:
    """Write ``NAME.yaml`` and ``NAME-mission.yaml``; existing files are never overwritten.

    Returns the aircraft's file and the mission's.
    """
    suffix = next((s for s in _YAML if name.lower().endswith(s)), "")
    name = name[: len(name) - len(suffix)]
    if re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}", name) is None:
        raise file_error(name, "a name has letters, digits, '-', '_' and '.', at most 64 of them")
    if names_a_device(name):
        message = "names a device of Windows, not a file: choose another name"
        raise file_error(name, message)
    contents = {
        folder / f"{name}.yaml": _template("aircraft").replace("NAME", name),
        folder / f"{name}-mission.yaml": _template("mission").replace("NAME", name),
    }
    taken = [path for path in contents if os.path.lexists(path)]
    if taken:
        message = "exists already and is not overwritten"
        raise _joined_errors([file_error(path.name, message) for path in taken])
    write_files_atomically({path: text.encode() for path, text in contents.items()})
    return list(contents)


def _template(kind: Kind) -> str:
    folder = resources.files("studies").joinpath("templates")
    return folder.joinpath(f"{kind}.yaml").read_text(encoding="utf-8")


def _attempt(read: Callable[[], T], errors: list[InputError]) -> T | None:
    try:
        return read()
    except InputError as error:
        errors.append(error)
        return None


def _joined_errors(errors: Sequence[InputError]) -> InputError:
    """All problems as one error; two files in each other's place are one mistake."""
    swapped = [error for error in errors if isinstance(error, WrongKindError)]
    if len(swapped) == 2:
        first, second = (_A_KIND[error.found] for error in swapped)
        message = f"is {first}, and {swapped[1].source} is {second}: swap the two"
        return file_error(swapped[0].source, message)
    return InputError([problem for error in errors for problem in error.problems])


def _is_default(option: str) -> bool:
    """Whether nobody gave an option of the command that runs."""
    context = click.get_current_context(silent=True)
    if context is None:
        return False
    return context.get_parameter_source(option) is ParameterSource.DEFAULT


def _find(kind: Kind, name_or_path: str) -> Document:
    """Document of an aircraft or a mission; one of the other kind is refused by its keys."""
    document = find_document(kind, name_or_path)
    own, other = (Aircraft, Mission) if kind == "aircraft" else (Mission, Aircraft)
    keys = set(document.data)
    if len(keys & set(other.model_fields)) > len(keys & set(own.model_fields)):
        raise WrongKindError(document.source, _OTHER[kind])
    return document


def _checksum(kind: Kind, name_or_path: str) -> str | None:
    """SHA-256 of a file that was read; None for a pipe, which cannot be read again."""
    if name_or_path in shipped_names(kind) and not Path(name_or_path).is_file():
        return hashlib.sha256(shipped_text(name_or_path).encode()).hexdigest()
    return InputFile.of(Path(name_or_path)).sha256


def _refuse_keys_of_missions(overrides: Sequence[str]) -> None:
    """Tell a key of the mission that lacks its prefix from one that is misspelt."""
    of_missions = Mission.model_fields.keys() - Aircraft.model_fields.keys()
    problems = []
    for override in overrides:
        key = override.partition("=")[0].strip()
        if key.partition(".")[0] in of_missions:
            message = f"is a key of the mission: write {MISSION_PREFIX}{key}"
            problems.append(Problem(f"{OVERRIDE}{key}", None, None, "", message))
    if problems:
        raise InputError(problems)
