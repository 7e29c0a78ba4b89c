"""Technology parameters: numbers of an aircraft or a mission, named by their key in its file.

Keys of the mission carry the prefix ``mission.``, as on the command line.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

from pydantic import BaseModel

from missions.mission import Mission
from sizing.smooth import Value

MISSION_PREFIX = "mission."

M = TypeVar("M", bound=BaseModel)


def parameter_value(owner: BaseModel, mission: Mission | None, key: str) -> float | None:
    """Value of a parameter of an aircraft or a mission; None where it has none."""
    on_mission = key.startswith(MISSION_PREFIX)
    node: Any = mission if on_mission else owner
    for part in key.removeprefix(MISSION_PREFIX).split("."):
        node = getattr(node, part, None)
    return float(node) if isinstance(node, (int, float)) else None


def with_parameter(owner: M, mission: Mission, key: str, value: Value) -> tuple[M, Mission]:
    """Aircraft and mission with one parameter replaced, unchecked; see :func:`replaced`."""
    parts = key.removeprefix(MISSION_PREFIX).split(".")
    if key.startswith(MISSION_PREFIX):
        return owner, replaced(mission, parts, value)
    return replaced(owner, parts, value), mission


def replaced(node: M, parts: Sequence[str], value: Value) -> M:
    """Copy of a description with one value replaced, without validation.

    The value may be a symbol or an array: the formulas use arithmetic only. The copy is built
    anew, because a plain copy would take over what the original has cached.
    """
    head, *rest = parts
    new = value if not rest else replaced(getattr(node, head), rest, value)
    fields = {name: getattr(node, name) for name in type(node).model_fields}
    return type(node).model_construct(**(fields | {head: new}))
