"""The catalogue of parameters, and how to read and replace one of an aircraft or a mission.

A parameter is a number named by its key in the aircraft's file; keys of the mission carry the
prefix ``mission.``, as on the command line. What is known of each, its unit, symbol, label and
sensible range, stands once in ``data/parameters.csv``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypeVar, cast

from sizing.data_rows import data_rows

if TYPE_CHECKING:
    from pydantic import BaseModel

    from missions.mission import Mission
    from sizing.smooth import Value

    M = TypeVar("M", bound=BaseModel)


MISSION_PREFIX = "mission."
BUILD_KEY = "airframe.structure.build"
# Numbers of a model that build multiplies.
FITTED_KEYS = frozenset(f"airframe.structure.{key}" for key in ("calibration", "coefficient_kg"))

Kind = Literal["design", "quantity", "technology", "mission", "bound"]


@dataclass(frozen=True)
class Parameter:
    """A row of the catalogue.

    ``key``: in the aircraft's file, behind ``mission.`` in the mission's, or the name of a
    quantity. ``kind``: ``design`` variable, ``quantity`` of a design, ``technology`` of the
    aircraft, ``mission`` or ``bound`` of the design space. ``unit``: for instance ``Wh/kg``; ``1``
    for none. ``symbol``: in LaTeX, as in the literature; may be empty. ``label``: for people: axes
    and tables. ``minimum``, ``maximum``: sensible range, about what has been built or is in sight.
    ``relaxable``: ``up`` or ``down`` where a relaxation may move it that way, else empty.
    ``sensitive``: whether its sensitivity is worth a row. ``about``: what it is and does, for those
    who choose its value; may be empty.
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
    """Every parameter by its key, in the order of the file."""
    rows = data_rows("parameters")
    return MappingProxyType({row["key"]: _from_row(row) for row in rows})


def _from_row(row: dict[str, Any]) -> Parameter:
    return Parameter(
        **(
            row
            | {end: float(row[end]) for end in ("minimum", "maximum")}
            | {"name": row["name"] or row["key"], "sensitive": row["sensitive"] == "yes"}
            | {"about": row["about"] or ""}
        )
    )


@cache
def design_keys() -> Mapping[str, str]:
    """Keys of the design variables by their short names, such as ``wingspan_m``."""
    return MappingProxyType({p.name: p.key for p in catalogue().values() if p.kind == "design"})


@cache
def parameter(key: str) -> Parameter:
    """Parameter by its key or its name in results."""
    found = catalogue().get(key) or next((p for p in catalogue().values() if p.name == key), None)
    if found is None:
        raise KeyError(f"the catalogue of parameters has no {key}")
    return found


def label(key: str) -> str:
    """Parameter in words."""
    return parameter(key).label


def unit_text(unit: str) -> str:
    """Unit as people write it: ``m²`` for ``m2``, ``°C`` for ``C``, nothing for ``1``."""
    plain = {"1": "", "C": "°C"}
    return plain.get(unit, unit.replace("m2", "m²").replace("m3", "m³"))


def unit(key: str) -> str:
    """Unit of a parameter, ``1`` for none."""
    return parameter(key).unit


def parameter_value(owner: BaseModel, mission: Mission | None, key: str) -> float | None:
    """Value of a parameter.

    Returns in the parameter's unit; None where neither has one.
    """
    on_mission = key.startswith(MISSION_PREFIX)
    found = value_at(mission if on_mission else owner, key.removeprefix(MISSION_PREFIX))
    if isinstance(found, str):  # a word that stands for a number
        found = value_at(owner, f"{key}_factor")
    return float(found) if isinstance(found, int | float) else None


def is_doubled(owner: BaseModel, key: str) -> bool:
    """Whether the parameter ``build`` of the file moves the same."""
    return key in FITTED_KEYS and parameter_value(owner, None, BUILD_KEY) is not None


def value_at(node: Any, key: str) -> Any:
    """What stands below a record at a key with dots; None where nothing does."""
    for part in key.split("."):
        node = node.get(part) if isinstance(node, Mapping) else getattr(node, part, None)
    return node


def with_parameter(owner: M, mission: Mission, key: str, value: Value) -> tuple[M, Mission]:
    """Aircraft and mission with one parameter replaced, unchecked; see :func:`replaced`."""
    parts = key.removeprefix(MISSION_PREFIX).split(".")
    if key.startswith(MISSION_PREFIX):
        return owner, replaced(mission, parts, value)
    return replaced(owner, parts, value), mission


def replaced(node: M, parts: Sequence[str], value: Value) -> M:
    """Copy of a description with one value replaced, without validation.

    The copy is built anew, because a plain copy would take over what the original has cached.

    ``parts``: names of the fields that lead to the value. ``value``: the formulas use arithmetic
    only, so that any of them will do.
    """
    return all_replaced(node, {".".join(parts): value})


def all_replaced(node: M, values: Mapping[str, Value]) -> M:
    """Copy of a description with some values replaced, without validation; see :func:`replaced`.

    ``values``: by their keys, with a dot between the names of fields; numbers, texts or symbols.
    """
    inner: dict[str, dict[str, Value]] = {}
    names = getattr(type(node), "model_fields", None)  # none: some descriptions, by their names
    fields = dict(node) if names is None else {name: getattr(node, name) for name in names}
    for key, value in values.items():
        head, _, rest = key.partition(".")
        if rest:
            inner.setdefault(head, {})[rest] = value
        else:
            fields[head] = value
    fields |= {head: all_replaced(fields[head], some) for head, some in inner.items()}
    return cast("M", fields if names is None else type(node).model_construct(**fields))
