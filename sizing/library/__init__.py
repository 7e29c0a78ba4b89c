"""Shipped aircraft, and loading of an aircraft by its name or path."""

from __future__ import annotations

import os

from missions.files.errors import InputError, Problem, printable, shortened
from missions.files.overrides import Overrides, with_overrides
from missions.files.shipped import find_document
from missions.files.validation import located_error, validate
from missions.files.yaml import ENTRY_KEYS, Document, Place
from sizing.aircraft import Aircraft
from sizing.catalogues.choice import Kind, known_entry
from sizing.parameters import value_at

# Keys of an aircraft's file that name an entry of a catalogue.
NAMED_KEYS: dict[str, Kind] = {
    "modules.cell": "cells",
    "modules.mppt_board": "mppts",
    "battery.cell": "batteries",
    "airframe.propulsion.motor": "motors",
    "airframe.propulsion.propeller.product": "propellers",
}


def load_aircraft(name_or_path: str | os.PathLike[str], overrides: Overrides = ()) -> Aircraft:
    """Load an aircraft.

    Parameters
    ----------
    name_or_path : str or path
        Name of a shipped aircraft, or path of a YAML file. Relative paths in the file start from
        its folder.
    overrides : mapping or sequence of str
        Values that replace or add keys of the file: ``{"power.avionics_w": 8}`` or
        ``["power.avionics_w=8"]``. Their relative paths start from the working folder.

    Returns
    -------
    Aircraft

    Raises
    ------
    InputError
        With file, line, column and allowed values of every mistake.
    """
    document = find_document("aircraft", os.fspath(name_or_path))
    changed = with_overrides(document, overrides)
    aircraft = validate(changed, Aircraft)
    refuse_named_twice(changed)
    return aircraft


def refuse_named_twice(document: Document) -> None:
    """Refuse an aircraft's file with an entry of a catalogue and values that the entry gives.

    Overrides may replace the values of an entry.
    """
    problems: list[Problem] = []
    for named, kind in NAMED_KEYS.items():
        path, data = tuple(named.split(".")), value_at(document.data, named.rpartition(".")[0])
        known = known_entry(kind, data, path[-1]) if isinstance(data, dict) else None
        # A motor at its operating point needs no voltage of its own, which an efficiency would.
        if known is None or not any(name in data for name in ENTRY_KEYS[path[-1]]):
            continue
        for key in known.parameters(data):
            twice = (*path[:-1], key)
            if all(document.places.get(place, Place()).key for place in (path, twice)):
                message = (
                    f"give one of {path[-1]} and {key}: {printable(shortened(data[path[-1]]))} of "
                    "the catalogue has a value of its own for it"
                )
                problems += located_error(document, twice, message).problems
    if problems:
        raise InputError(problems)
