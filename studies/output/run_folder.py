"""Folders of results: what was asked, of what, by which software, and what came out.

Every command that has ``--out FOLDER`` writes these files, beside tables and figures of its own:

* ``aircraft.yaml`` and ``mission.yaml``: as analysed or sized, overrides applied
* ``run.json``: command line, versions, date, and the checksums of the files that went in
* ``results.json``: what ``--json`` prints

Such a folder stands for its aircraft on its mission wherever a command takes an aircraft.
"""

from __future__ import annotations

import copy
import datetime
import hashlib
import json
import os
import platform
import re
import shlex
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from missions.files.errors import InputError, Problem, file_error
from missions.files.texts import read_plain_file, read_text
from missions.files.writing import file_text, to_json, write_folder
from missions.files.yaml import PATH_SUFFIXES
from sizing.aerodynamics.polar_table import POLAR_SUFFIXES
from sizing.day.light import SolarModel
from solar._version import __version__
from solar.names import CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName
from solar.versions import FORMAT_KEY, format_trouble, software_record

AIRCRAFT, MISSION, RUN, RESULTS = "aircraft.yaml", "mission.yaml", "run.json", "results.json"
POLAR = "polar"
_NAME = re.compile(r"[A-Za-z0-9][\w.-]*", re.ASCII)  # of the files that commands write
_MOST_BYTES = 10_000_000
_LIBRARIES = ("casadi", "numpy", "pandas", "pydantic", "scipy", "xarray")


@dataclass(frozen=True)
class InputFile:
    """A file that went in: its name, and its SHA-256 where it can be read again."""

    source: str
    sha256: str | None

    @classmethod
    def of(cls, path: Path) -> InputFile:
        """Return the file at a path; one that is no plain file has no checksum."""
        data = path.read_bytes() if path.is_file() else None
        return cls(str(path), None if data is None else hashlib.sha256(data).hexdigest())


@dataclass(frozen=True)
class RunInputs:
    """What a command computed from."""

    aircraft: Mapping[str, Any]
    mission: Mapping[str, Any]
    solar: SolarModel
    files: Mapping[str, InputFile]


@dataclass(frozen=True)
class RunFolder:
    """What a folder of results offers to other commands: two files, model and correction."""

    aircraft: str
    mission: str
    model: ModelName
    correction: CorrectionName

    @classmethod
    def at(cls, path: str) -> RunFolder | None:
        """Read a folder of results; None where the path is not one."""
        folder = Path(path)
        if not os.path.isfile(folder / RUN):  # noqa: PTH113 - takes any text for a path
            return None
        try:
            text = _read(folder / RUN).decode("utf-8")
            record = json.loads(text)
            version = record.get(FORMAT_KEY, 1) if isinstance(record, dict) else 1
            if (trouble := format_trouble(version)) is not None:
                lines = enumerate(text.splitlines(), start=1)
                line = next((number for number, row in lines if f'"{FORMAT_KEY}"' in row), None)
                raise InputError([Problem(str(folder / RUN), line, None, FORMAT_KEY, trouble)])
            model, correction = record["model"], record["correction"]
        except InputError:
            raise
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            model = correction = None
        if model not in MODEL_NAMES or correction not in CORRECTION_NAMES:
            raise file_error(str(folder / RUN), "is not the record of a run of solar-uav")
        return cls(str(folder / AIRCRAFT), str(folder / MISSION), model, correction)


def write_run_folder(
    folder: Path,
    inputs: RunInputs,
    record: Any,
    extra: Mapping[str, bytes],
    figures: Mapping[str, Callable[[str], bytes]],
) -> None:
    """Write a folder of results whole or not at all; without figures where one cannot be drawn.

    Existing files of these names are replaced; what an earlier run wrote besides is removed.

    ``inputs``: what the command computed from, or made: a sized aircraft. ``figures``: functions
    that draw figures, given the names of their files. What one of them raises is raised again when
    everything else is written.
    """
    aircraft, named = _with_named_files(inputs.aircraft)
    files, contents, trouble = dict(inputs.files), dict(extra), None
    for name, path in named.items():
        polars = path.is_dir()
        text = read_text(f"{path}/", POLAR_SUFFIXES).encode() if polars else path.read_bytes()
        contents[name] = text
        files["airfoil" if Path(name).stem == POLAR else Path(name).stem] = InputFile.of(path)
    try:
        contents |= {name: draw(name) for name, draw in figures.items()}
    except Exception as error:
        trouble = error
    contents |= {
        AIRCRAFT: _described_file(aircraft, files["aircraft"]),
        MISSION: _described_file(inputs.mission, files["mission"]),
        RESULTS: _json_bytes(record),
    }
    run = run_record(inputs.solar, files) | {"files": sorted([*contents, RUN])}
    earlier = _files_of_run(folder)
    write_folder(folder, contents | {RUN: _json_bytes(run)})
    for name in earlier - {RUN, *contents}:
        with suppress(OSError):  # a folder of that name is none of ours
            (folder / name).unlink(missing_ok=True)
    if trouble is not None:
        raise trouble


def _read(path: Path) -> bytes:
    return read_plain_file(path, most_bytes=_MOST_BYTES)


def _files_of_run(folder: Path) -> set[str]:
    """Return the files that an earlier run wrote into a folder."""
    try:
        names = json.loads(_read(folder / RUN))["files"]
        return {name for name in names if _NAME.fullmatch(name)}
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return set()


def _json_bytes(record: Any) -> bytes:
    """Return a record as strict JSON."""
    return (to_json(record, indent=2) + "\n").encode()


def _described_file(data: Mapping[str, Any], file: InputFile) -> bytes:
    return file_text(f"Written by solar-uav {__version__} from {file.source}", data).encode()


def _with_named_files(aircraft: Mapping[str, Any]) -> tuple[Mapping[str, Any], dict[str, Path]]:
    """Return the aircraft with the files that it names beside it, and those files.

    The files are named by their role, a folder of polars by the one file that holds them all.
    """
    data = copy.deepcopy(dict(aircraft))
    files: dict[str, Path] = {}
    propulsion = data["airframe"].get("propulsion") or {}
    for holder, key, role in (
        (data["airframe"].get("aerodynamics") or {}, "airfoil", POLAR),
        (propulsion, "motor", "motor"),
        (data["modules"], "cell", "cell"),
        (data["battery"], "cell", "battery-cell"),
    ):
        path = holder.get(key)
        if isinstance(path, str) and path.lower().endswith(PATH_SUFFIXES):
            holder[key] = f"{role}{'.txt' if path.endswith('/') else Path(path).suffix}"
            files[holder[key]] = Path(path)
    propeller = propulsion.get("propeller") or {}
    if table := propeller.get("table"):
        # Names of runs in a wind tunnel hold size and speed.
        paths = [Path(name) for name in ([table] if isinstance(table, str) else table)]
        propeller["table"] = [path.name for path in paths]
        files |= {path.name: path for path in paths}
    return (data, files) if files else (aircraft, files)


def run_record(solar: SolarModel, files: Mapping[str, InputFile]) -> dict[str, Any]:
    """Return what ``run.json`` holds of a run, but for the files that it wrote."""
    return {
        "command": shlex.join(["solar-uav", *sys.argv[1:]]),
        **software_record(),
        "date_utc": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "model": solar.model,
        "correction": solar.correction,
        "inputs": {kind: vars(file) for kind, file in files.items()},
        "python": platform.python_version(),
        "libraries": {name: metadata.version(name) for name in _LIBRARIES},
    }
