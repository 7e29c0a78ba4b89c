"""Catalogue of parameters, and reading and replacing parameters of aircraft and missions.

A parameter is a number named by its key in the aircraft's file; keys of the mission have the prefix
``mission.``, as on the command line. Units, symbols, labels and sensible ranges are in
``data/parameters.csv``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypeVar, cast

from missions.files.data_rows import data_rows

if TYPE_CHECKING:
    from pydantic import BaseModel

    from missions.mission import Mission
    from sizing.smooth import Value

    M = TypeVar("M", bound=BaseModel)


MISSION_PREFIX = "mission."
BUILD_KEY = "airframe.structure.build"
# Numbers of a structural model that the build factor multiplies.
FITTED_KEYS = frozenset(f"airframe.structure.{key}" for key in ("calibration", "coefficient_kg"))

Kind = Literal["design", "quantity", "technology", "mission", "bound"]


@dataclass(frozen=True)
class Parameter:
    """Parameter of the catalogue.

    ``key``: key in the aircraft's file, with ``mission.`` in the mission's, or name of a quantity.
    ``kind``: ``design`` variable, ``quantity`` of a design, ``technology`` of the aircraft,
    ``mission`` or ``bound`` of the design space. ``unit``: for instance ``Wh/kg``; ``1`` for none.
    ``symbol``: in LaTeX, may be empty. ``label``: words for axes and tables. ``minimum``,
    ``maximum``: sensible range of values built or in sight. ``relaxable``: direction of
    relaxations, ``up`` or ``down``, else empty. ``sensitive``: whether tables of sensitivities
    have it. ``about``: explanation for the choice of its value, may be empty.
    """

    key: str
    name: str
    kind: Kind
    unit: str
    symbol: str
    label: str
    minimum: float
    maximum: float
    relaxable: Literal["up", "down", ""]
    sensitive: bool
    about: str = ""


@cache
def catalogue() -> Mapping[str, Parameter]:
    """Return the parameters by their keys, in the order of the file."""
    known = {}
    for row in data_rows("parameters", "sizing"):
        ends = {end: float(row[end]) for end in ("minimum", "maximum")}
        words = {"name": row["name"] or row["key"], "about": row["about"] or ""}
        values: dict[str, Any] = row | ends | words | {"sensitive": row["sensitive"] == "yes"}
        known[row["key"]] = Parameter(**values)
    return MappingProxyType(known)


@cache
def design_keys() -> Mapping[str, str]:
    """Return the keys of the design variables by their short names, such as ``wingspan_m``."""
    return MappingProxyType({p.name: p.key for p in catalogue().values() if p.kind == "design"})


@cache
def parameter(key: str) -> Parameter:
    """Return a parameter by its key or its name in results."""
    row = catalogue().get(key) or next((p for p in catalogue().values() if p.name == key), None)
    if row is None:
        raise KeyError(f"the catalogue of parameters has no {key}")
    return row


def label(key: str) -> str:
    """Return the name of a parameter in words."""
    return parameter(key).label


def unit_text(unit: str) -> str:
    """Return a unit for texts: ``m²`` for ``m2``, ``°C`` for ``C``, nothing for ``1``."""
    plain = {"1": "", "C": "°C"}
    return plain.get(unit, unit.replace("m2", "m²").replace("m3", "m³"))


def unit(key: str) -> str:
    """Return the unit of a parameter, ``1`` for none."""
    return parameter(key).unit


def parameter_value(owner: BaseModel, mission: Mission | None, key: str) -> float | None:
    """Return the value of a parameter in its unit; None if neither record has it."""
    on_mission = key.startswith(MISSION_PREFIX)
    value = value_at(mission if on_mission else owner, key.removeprefix(MISSION_PREFIX))
    if isinstance(value, str):  # a word in place of a number
        value = value_at(owner, f"{key}_factor")
    return float(value) if isinstance(value, int | float) else None


def build_scales(owner: BaseModel, key: str) -> bool:
    """Return whether the file's ``build`` scales the same mass as a parameter."""
    return key in FITTED_KEYS and parameter_value(owner, None, BUILD_KEY) is not None


def value_at(node: Any, key: str) -> Any:
    """Return the value at a key with dots below a record; None if there is none."""
    for part in key.split("."):
        if isinstance(node, list | tuple) and part.isdecimal():
            node = dict(enumerate(node)).get(int(part))
        else:
            node = node.get(part) if isinstance(node, Mapping) else getattr(node, part, None)
    return node


def with_parameter(owner: M, mission: Mission, key: str, value: Value) -> tuple[M, Mission]:
    """Return aircraft and mission with a parameter replaced; see :func:`all_replaced`."""
    if key.startswith(MISSION_PREFIX):
        return owner, all_replaced(mission, {key.removeprefix(MISSION_PREFIX): value})
    return all_replaced(owner, {key: value}), mission


def all_replaced(node: M, values: Mapping[str, Value]) -> M:
    """Return a copy of a record with values replaced by their keys with dots, not validated.

    The copy does not share cached properties with the original. Values may be numbers, arrays or
    symbols.
    """
    inner: dict[str, dict[str, Value]] = {}
    names = getattr(type(node), "model_fields", None)  # None for a mapping of records
    fields = dict(node) if names is None else {name: getattr(node, name) for name in names}
    for key, value in values.items():
        head, _, rest = key.partition(".")
        if rest:
            inner.setdefault(head, {})[rest] = value
        else:
            fields[head] = value
    fields |= {head: all_replaced(fields[head], changes) for head, changes in inner.items()}
    return cast("M", fields if names is None else type(node).model_construct(**fields))
