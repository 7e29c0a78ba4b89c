"""Commented starter files: a parametric aircraft and a mission to edit."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path

from missions.files.errors import InputError, Problem
from missions.files.writing import write_text_atomically


def write_starters(name: str, folder: Path) -> list[Path]:
    """Write ``NAME.yaml`` and ``NAME-mission.yaml``; existing files are never overwritten.

    Raises
    ------
    InputError
        If the name is not one for a file, or one of the files exists.
    """
    if re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}", name) is None:
        raise InputError(
            [_problem(name, "a name has letters, digits, '-', '_' and '.', at most 64 of them")]
        )
    contents = {
        folder / f"{name}.yaml": _template("aircraft").replace("NAME", name),
        folder / f"{name}-mission.yaml": _template("mission").replace("NAME", name),
    }
    taken = [path for path in contents if path.exists()]
    if taken:
        raise InputError(
            [_problem(path.name, "exists already and is not overwritten") for path in taken]
        )
    for path, text in contents.items():
        write_text_atomically(path, text)
    return list(contents)


def _template(kind: str) -> str:
    folder = resources.files("studies").joinpath("templates")
    return folder.joinpath(f"{kind}.yaml").read_text(encoding="utf-8")


def _problem(source: str, message: str) -> Problem:
    return Problem(source=source, line=None, column=None, key="", message=message)
