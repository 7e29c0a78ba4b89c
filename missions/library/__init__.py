"""Shipped missions; missions by name or path."""

from __future__ import annotations

import os

from missions.files.overrides import Overrides, with_overrides
from missions.files.shipped import find_document
from missions.files.validation import validate
from missions.mission import Mission

MISSION_PREFIX = "mission."


def load_mission(name_or_path: str | os.PathLike[str], overrides: Overrides = ()) -> Mission:
    """Load a mission.

    Parameters
    ----------
    name_or_path : str or path
        Name of a shipped mission, or path of a YAML file.
    overrides : mapping or sequence of str
        Values that replace or add keys of the file: ``{"clearness": 0.9}`` or
        ``["clearness=0.9"]``; keys of keys are dotted.

    Returns
    -------
    Mission

    Raises
    ------
    InputError
        With file, line, column and allowed values of every mistake.
    """
    document = find_document("mission", os.fspath(name_or_path))
    return validate(with_overrides(document, overrides, prefix=MISSION_PREFIX), Mission)
