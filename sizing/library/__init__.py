"""Shipped aircraft, and reading an aircraft by its name or path."""

from __future__ import annotations

import os

from missions.files.overrides import Overrides, with_overrides
from missions.files.shipped import find_document
from missions.files.validation import validate
from sizing.aircraft import Aircraft


def load_aircraft(name_or_path: str | os.PathLike[str], overrides: Overrides = ()) -> Aircraft:
    """Load an aircraft.

    Parameters
    ----------
    name_or_path : str or path
        Name of a shipped aircraft, or path of a YAML file. Files that it names by a relative path
        are looked for beside it.
    overrides : mapping or sequence of str
        Values that replace or add keys of the file: ``{"power.avionics_w": 8}`` or
        ``["power.avionics_w=8"]``. Relative paths among them start from the working folder.

    Returns
    -------
    Aircraft

    Raises
    ------
    InputError
        With file, line, column and allowed values of every mistake.
    """
    document = find_document("aircraft", os.fspath(name_or_path))
    return validate(with_overrides(document, overrides), Aircraft)
