"""Keys of aircraft and mission files, written down for shell completion so that it is quick.

Reading them from the classes takes half a second; ``python -m benchmarks.completion_keys`` writes
``studies/cli/completion_keys.csv`` anew, and a test compares it with the classes.
"""

from __future__ import annotations

import csv
import io
import types
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from missions.library import MISSION_PREFIX
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.catalogues.choice import entry_names
from sizing.parameters import catalogue
from studies.cli.completion import KEYS_FILE, Key
from studies.sweeps.axes import NAMED_KEYS

_SWITCH = ("false", "true")


def keys_of_classes() -> list[Key]:
    """All keys, as the classes of the files have them."""
    labels = {key: one.label for key, one in catalogue().items()}
    keys: dict[str, tuple[set[str], bool]] = {}
    for prefix, owner in (("", Aircraft), (MISSION_PREFIX, Mission)):
        for key, values, number in _fields(owner, prefix):
            before = keys.get(key, (set(), False))
            keys[key] = (before[0] | set(values), before[1] or number)
    for key, kind in NAMED_KEYS.items():
        keys[key] = (set(entry_names(kind)), False)
    return [
        Key(key, tuple(sorted(values)), number, labels.get(key, ""))
        for key, (values, number) in sorted(keys.items())
    ]


def _fields(owner: Any, prefix: str) -> Iterator[tuple[str, tuple[str, ...], bool]]:
    for name, field in owner.model_fields.items():
        # The keys of `uncertainty` are those of the file, and nobody varies the format.
        if name not in ("uncertainty", "format_version"):
            yield from _leaves(field.annotation, f"{prefix}{field.alias or name}")


def _leaves(annotation: Any, key: str) -> Iterator[tuple[str, tuple[str, ...], bool]]:
    """Keys below a key, each with its values and whether it is a number."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        yield from _leaves(arguments[0], key)
    elif origin in (Union, types.UnionType):
        for one in arguments:
            yield from _leaves(one, key)
    elif origin is Literal:
        yield key, tuple(map(str, arguments)), False
    elif isinstance(origin, type) and issubclass(origin, Mapping):
        of, value = arguments
        if get_origin(of) is Literal:
            for name in get_args(of):
                yield from _leaves(value, f"{key}.{name}")
    elif hasattr(annotation, "model_fields"):
        yield from _fields(annotation, f"{key}.")
    elif annotation is bool:
        yield key, _SWITCH, False
    elif annotation is not type(None):
        yield key, (), annotation in (int, float)


def to_text(keys: list[Key]) -> str:
    """Keys as the file has them."""
    out = io.StringIO()
    rows = [
        (one.key, "|".join(one.values), "number" if one.number else "", one.label) for one in keys
    ]
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


if __name__ == "__main__":
    place = Path(__file__).parents[1] / "studies" / "cli" / KEYS_FILE
    place.write_text(to_text(keys_of_classes()), encoding="utf-8")
