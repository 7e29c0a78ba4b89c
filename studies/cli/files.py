"""Aircraft and missions of the command line: validated, with the lines they came from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from missions.files.errors import OVERRIDE, InputError, Problem
from missions.files.overrides import with_overrides
from missions.files.shipped import find_document
from missions.files.validation import validate
from missions.files.yaml import Document
from missions.library import MISSION_PREFIX

if TYPE_CHECKING:
    from missions.mission import Mission
    from sizing.aircraft import Aircraft

_AIRCRAFT_PREFIX = "aircraft."


@dataclass(frozen=True)
class LoadedAircraft:
    """A validated aircraft and the document it came from."""

    aircraft: Aircraft
    document: Document


@dataclass(frozen=True)
class LoadedMission:
    """A validated mission and the document it came from."""

    mission: Mission
    document: Document


def split_overrides(overrides: Sequence[str]) -> tuple[list[str], list[str]]:
    """Sort ``key=value`` overrides into those of the aircraft and those of the mission."""
    of_mission = [o for o in overrides if o.startswith(MISSION_PREFIX)]
    of_aircraft = [o.removeprefix(_AIRCRAFT_PREFIX) for o in overrides if o not in of_mission]
    return of_aircraft, [o.removeprefix(MISSION_PREFIX) for o in of_mission]


def open_aircraft(name_or_path: str, overrides: Sequence[str] = ()) -> LoadedAircraft:
    """Read an aircraft by name or path; ``overrides`` are ``dotted.key=value`` texts."""
    from sizing.aircraft import Aircraft

    _refuse_keys_of_missions(overrides)
    document = with_overrides(find_document("aircraft", name_or_path), overrides)
    return LoadedAircraft(validate(document, Aircraft), document)


def open_mission(name_or_path: str, overrides: Sequence[str] = ()) -> LoadedMission:
    """Read a mission by name or path; ``overrides`` are ``dotted.key=value`` texts."""
    from missions.mission import Mission

    document = with_overrides(
        find_document("mission", name_or_path), overrides, prefix=MISSION_PREFIX
    )
    return LoadedMission(validate(document, Mission), document)


def _refuse_keys_of_missions(overrides: Sequence[str]) -> None:
    """Tell a key of the mission that lacks its prefix from one that is misspelt."""
    from missions.mission import Mission
    from sizing.aircraft import Aircraft

    of_missions = Mission.model_fields.keys() - Aircraft.model_fields.keys()
    problems = []
    for override in overrides:
        key = override.partition("=")[0].strip()
        if key.partition(".")[0] in of_missions:
            message = f"is a key of the mission: write {MISSION_PREFIX}{key}"
            problems.append(Problem(f"{OVERRIDE}{key}", None, None, "", message))
    if problems:
        raise InputError(problems)
