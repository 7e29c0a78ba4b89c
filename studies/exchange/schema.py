"""JSON Schema of aircraft and mission files, for completion and checks in an editor.

Made of the classes that read the files, with labels and units of the catalogue of parameters. It
refuses nothing that ``solar-uav validate`` accepts, but lacks rules between keys.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.parameters import MISSION_PREFIX, Parameter, catalogue
from solar._version import __version__

_DIALECT = "https://json-schema.org/draft/2020-12/schema"
_CLASSES: dict[str, tuple[type[Aircraft] | type[Mission], str]] = {
    "aircraft": (Aircraft, ""),
    "mission": (Mission, MISSION_PREFIX),
}

# Record of an aircraft's file, its key that whole cells give, and the key that describes them.
_FROM_CELLS = (("modules", "area_m2", "layout"), ("battery", "mass_kg", "pack"))


def file_schema(kind: Literal["aircraft", "mission"]) -> dict[str, Any]:
    """Return the JSON Schema, draft 2020-12, of a file.

    Parameters
    ----------
    kind : {"aircraft", "mission"}

    Returns
    -------
    dict
        JSON-ready.
    """
    record, prefix = _CLASSES[kind]
    schema = record.model_json_schema()
    for key, known in catalogue().items():
        if key.startswith(MISSION_PREFIX) == bool(prefix) and "." in prefix + key:
            _describe_node(schema, schema, key.removeprefix(prefix).split("."), known)
    if record is Aircraft:
        del schema["$defs"]["BatteryPack"]["required"]  # voltage, mass and catalogue give them
        schema["$defs"]["Strings"]["required"].remove("mppt")  # `mppt_board` may give it
    for name, key, instead in _FROM_CELLS if record is Aircraft else ():
        for node in _alternatives(schema, schema["properties"][name]):
            if key in node.get("required", ()):
                node["required"].remove(key)
                node["anyOf"] = [{"required": [required]} for required in (key, instead)]
    text = f"{kind.capitalize()} file of solar-uav {__version__}."
    return {"$schema": _DIALECT, **schema, "title": f"solar-uav {kind}", "description": text}


def _describe_node(root: Mapping[str, Any], node: Any, parts: list[str], known: Parameter) -> None:
    """Set a key's label and unit in all alternatives of a node."""
    for part in _alternatives(root, node):
        place = part.get("properties", {}).get(parts[0])
        if place is None:
            continue
        if len(parts) > 1:
            _describe_node(root, place, parts[1:], known)
        else:
            unit = "" if known.unit == "1" else f" [{known.unit}]"
            place["description"] = f"{known.label[:1].upper()}{known.label[1:]}{unit}"


def _alternatives(root: Mapping[str, Any], node: Any) -> list[dict[str, Any]]:
    """Return the objects that a part of the schema stands for, references resolved."""
    if not isinstance(node, dict):
        return []
    if "$ref" in node:
        return _alternatives(root, root["$defs"][node["$ref"].rsplit("/", 1)[-1]])
    choices = [*node.get("anyOf", ()), *node.get("oneOf", ()), *node.get("allOf", ())]
    return [node, *(choice for other in choices for choice in _alternatives(root, other))]
