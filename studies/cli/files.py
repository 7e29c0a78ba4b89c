"""Aircraft and missions of the command line: validated, with the lines they came from.

What a command needs of them is told in terms of their files.
"""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from missions.dates import date_code
from missions.files.errors import (
    OVERRIDE,
    InputError,
    Problem,
    did_you_mean,
    file_error,
    printable,
)
from missions.files.overrides import with_overrides
from missions.files.shipped import Kind, find_document, shipped_file, shipped_names
from missions.files.validation import validate
from missions.files.yaml import Place
from missions.library import MISSION_PREFIX
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.light import SolarModel
from sizing.library import refuse_named_twice
from sizing.mass_budget import ImpossibleDesignError
from sizing.parameters import design_keys
from solar.schema import spell
from studies.case import Case, Loaded
from studies.cli.telling import tell_error
from studies.output.run_folder import InputFile, RunFolder

_AIRCRAFT_PREFIX = "aircraft."
_A_KIND: dict[Kind, str] = {"aircraft": "an aircraft", "mission": "a mission"}
_OTHER: dict[Kind, Kind] = {"aircraft": "mission", "mission": "aircraft"}


@contextmanager
def uncertain_inputs(case: Case) -> Iterator[None]:
    """Tell what is wrong with uncertain inputs by the lines of the files."""
    try:
        yield
    except InputError as error:
        files = (case.mission_file, case.aircraft_file)
        documents = {file.record.name: file.document for file in files}
        placed = []
        for problem in error.problems:
            document = documents.get(problem.source)
            if document is not None:
                path = tuple(problem.key.split(".", 2))
                line, column = document.places.get(path, Place()).key or (None, None)
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
    prefix = _AIRCRAFT_PREFIX if is_aircraft else MISSION_PREFIX
    of_kind = (text for text in overrides if text.startswith(MISSION_PREFIX) is not is_aircraft)
    mine = [text.removeprefix(prefix) for text in of_kind]
    if is_aircraft:
        each = [text.partition("=") for text in mine]
        mine = [f"{design_keys().get(key, key)}{equals}{value}" for key, equals, value in each]
        problems = []
        for key in (text.partition("=")[0].strip() for text in mine):
            message = ""
            if key.partition(".")[0] in Mission.model_fields.keys() - Aircraft.model_fields.keys():
                message = f"is a key of the mission: write {MISSION_PREFIX}{key}"
            elif "." not in key and key not in {*Aircraft.model_fields, *Aircraft.explained_keys}:
                meant = did_you_mean(key, [*design_keys(), *Aircraft.model_fields])
                message = f"unknown key{meant}" if meant else ""
            if message:
                problems.append(Problem(f"{OVERRIDE}{key}", None, None, "", message))
        if problems:
            raise InputError(problems)
    document = find_document(kind, name_or_path)
    keys = set(document.data)
    if len(keys & set(other.model_fields)) > len(keys & set(record.model_fields)):
        raise WrongKindError(document.source, _OTHER[kind])
    document = with_overrides(document, mine, prefix="" if is_aircraft else MISSION_PREFIX)
    checked = validate(document, record)
    if is_aircraft and not of_run:
        refuse_named_twice(document)
    path = Path(name_or_path)
    if name_or_path in shipped_names(kind) and not path.is_file():
        path = Path(str(shipped_file(kind, name_or_path)))
    return Loaded(checked, document, InputFile.of(path).sha256)


def load(options: Any) -> Case:
    """Load what the options of a command name, and report what is wrong with it together.

    ``options``: of a command that has a case. A folder that ``--out`` wrote stands for an aircraft,
    and its mission, model and correction for options that are not given. A known total mass is that
    on the mission as it is flown.
    """
    aircraft, mission = options.aircraft, options.mission
    model, correction = options.model, options.correction
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
    files, errors = list[Loaded[Any]](), list[InputError]()
    named: dict[Kind, str] = {"aircraft": aircraft, "mission": mission}
    for kind, name in named.items():
        try:
            files.append(opened(kind, name, options.overrides, of_run=folder is not None))
        except InputError as error:
            errors.append(error)
    swapped = [error for error in errors if isinstance(error, WrongKindError)]
    if len(swapped) == 2:  # in each other's place: one mistake
        first, second = (_A_KIND[error.found] for error in swapped)
        message = f"is {first}, and {swapped[1].source} is {second}: swap the two"
        raise file_error(swapped[0].source, message)
    if errors:
        raise InputError([problem for error in errors for problem in error.problems])
    aircraft_file, mission_file = files
    case = Case(aircraft_file, mission_file, is_default, SolarModel(model, correction))
    if case.mission.holds_station and isinstance(case.aircraft.airframe, MeasuredAirframe):
        message = "needs a parametric aircraft: this one's power is known at one airspeed"
        case.refuse("mission.wind.hold_station", message)
    if is_default and mission != beside and beside is not None:
        tell_error(f"solar-uav: the default mission is used; the one beside: -m {beside}")
    changes: dict[str, Any] = {}
    if options.latitude is not None:
        changes["latitude_deg"] = options.latitude
    day = options.day_of_year if options.date is None else options.date
    if day is not None:
        changes["dates"] = {"on": date_code(day)}
    if changes:
        changes["launch"] = None  # which is at the mission's own place and date
    if options.required_h is not None:
        changes["required_excess_time_h"] = options.required_h
    case = case.with_mission(**changes) if changes else case
    return case if options.mass_kg is None else _of_known_mass(case, options.mass_kg)


def _of_known_mass(case: Case, mass_kg: float) -> Case:
    """Return the case with a known total mass; note what was changed for it."""
    try:
        known = case.with_total_mass(mass_kg)
    except ImpossibleDesignError as error:
        raise click.BadParameter(str(error), param_hint="--mass") from None
    key = known.aircraft.airframe.unaccounted_mass_key
    now, before = (spell(getattr(of.aircraft.airframe, key), 4) for of in (known, case))
    tell_error(f"solar-uav: --mass {spell(mass_kg)}: airframe.{key} is {now} instead of {before}")
    return known


def mission_beside(aircraft: str) -> str | None:
    """Return the mission file that ``init`` writes beside an aircraft's; None without one."""
    beside = f"{os.path.splitext(aircraft)[0]}-mission.yaml"  # noqa: PTH122 - takes any text
    return beside if os.path.isfile(beside) else None  # noqa: PTH113


def _is_default(option: str) -> bool:
    """Return whether an option of the running command has its default value."""
    context = click.get_current_context()
    return context.get_parameter_source(option) is ParameterSource.DEFAULT
