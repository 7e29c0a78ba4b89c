"""Cases of aircraft and mission files, ``--set``, polar tables and folders of results."""

from __future__ import annotations

import json
import random
from functools import cache
from importlib import resources
from typing import Any

import yaml

from benchmarks.reliability.inputs.cases import Case
from benchmarks.reliability.inputs.mutations import (
    HOSTILE,
    bytes_changed,
    data_changed,
    number_text,
    text_changed,
)
from missions.files.shipped import shipped_names, shipped_text
from studies.cli.completion import Key, known_keys

__all__ = ["aircraft_file", "folder", "mission_file", "override", "polar_table"]

_TEMPLATES = {"aircraft": "aircraft.yaml", "mission": "mission.yaml"}
_Dumper = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
_MEASURED, _PARAMETRIC = "atlantiksolar-as2", "atlantiksolar-design"


def aircraft_file(rng: random.Random) -> Case:
    """Aircraft file, changed as data, as text or as bytes."""
    content = _document("aircraft", rng)
    call = rng.choices(_AIRCRAFT_CALLS, _AIRCRAFT_WEIGHTS)[0]
    return _called(call, {"a.yaml": content})


def mission_file(rng: random.Random) -> Case:
    """Mission file, changed as data, as text or as bytes."""
    content = _document("mission", rng)
    call = rng.choices(_MISSION_CALLS, _MISSION_WEIGHTS)[0]
    return _called(call, {"m.yaml": content})


def override(rng: random.Random) -> Case:
    """Values of the command line in place of those of the files."""
    aircraft = rng.choice(shipped_names("aircraft"))
    mission = rng.choice(shipped_names("mission"))
    texts = [_override(rng) for _ in range(rng.choice((1, 1, 1, 2, 3)))]
    given = [part for text in texts for part in ("--set", text)]
    if rng.random() < 0.1:
        coarse = ("--latitudes", "0:60:30", "--days", "100:200:50", "--workers", "1")
        return Case(("map", aircraft, "-m", mission, *coarse, *given))
    as_json = rng.random() < 0.7
    return Case(
        ("analyse", aircraft, "-m", mission, *given, *(("--json",) if as_json else ())),
        json=as_json,
    )


def polar_table(rng: random.Random) -> Case:
    """Polar table of an airfoil, changed as text or as bytes."""
    name = rng.choice(_polars())
    text = (resources.files("sizing") / "data" / "polars" / name).read_text(encoding="utf-8")
    if rng.random() < 0.5:  # a small table: each line weighs more
        lines = text.split("\n")
        text = "\n".join([*lines[:12], *lines[12 :: rng.choice((2, 3, 5, 20))]])
    content = text_changed(text, rng).encode("utf-8", "replace")
    if rng.random() < 0.15:
        content = bytes_changed(content, rng)
    files = {"polar.csv": content, "a.yaml": _with_polar("polar.csv")}
    return _called(rng.choices(_AIRCRAFT_CALLS[:3], (3, 2, 2))[0], files)


def folder(rng: random.Random) -> Case:
    """Folder that ``--out`` wrote, with something in it changed."""
    record = {
        "command": "solar-uav size",
        "model": "CAM",
        "correction": "none",
        "files": ["aircraft.yaml", "mission.yaml", "results.json", "run.json"],
    }
    files = {
        "r/aircraft.yaml": shipped_text(_PARAMETRIC).encode(),
        "r/mission.yaml": shipped_text("rafz-july").encode(),
        "r/run.json": json.dumps(record).encode(),
        "r/results.json": b"{}",
    }
    links: dict[str, str] = {}
    victim = rng.choice(sorted(files))
    way = rng.random()
    if way < 0.1:
        del files[victim]
    elif way < 0.2:
        del files[victim]
        links[victim] = rng.choice(("/etc/passwd", "/dev/zero", "nowhere", victim.split("/")[1]))
    elif way < 0.6:
        changed = data_changed(record, rng)
        if rng.random() < 0.5:
            changed["files"] = [rng.choice(HOSTILE), "../outside.txt", "/tmp", 7, None]
        files["r/run.json"] = json.dumps(changed).encode()
    else:
        files[victim] = bytes_changed(files[victim], rng)
    files["outside.txt"] = b"untouched"
    if rng.random() < 0.9:
        return Case(("analyse", "r", "--json"), files, links, json=True)
    return Case(("size", "r", "--out", "r", "--json"), files, links, json=True)


# ---- contents


@cache
def _contents(kind: str) -> tuple[Any, ...]:
    names = shipped_names("aircraft" if kind == "aircraft" else "mission")
    found = [yaml.safe_load(shipped_text(name)) for name in names]
    # YAML 1.1 takes dates of files for days; ours are text.
    return tuple(json.loads(json.dumps(one, default=str)) for one in found)


@cache
def _polars() -> tuple[str, ...]:
    folder = resources.files("sizing") / "data" / "polars"
    return tuple(sorted(f.name for f in folder.iterdir() if f.name.endswith(".csv")))


@cache
def _keys() -> tuple[Key, ...]:
    return tuple(known_keys())


def _document(kind: str, rng: random.Random) -> bytes:
    """Content of a file: most of them are still YAML, many still valid."""
    way = rng.random()
    if way < 0.6:
        data = rng.choice(_contents(kind))
        for _ in range(rng.choice((0, 0, 0, 1, 1, 2))):
            data = _with_key(data, kind, rng)
        data = data_changed(data, rng, donors=_contents(kind))
        return _dumped(data)
    name = rng.choice(shipped_names("aircraft" if kind == "aircraft" else "mission"))
    text = shipped_text(name)
    if way < 0.65:
        text = (resources.files("studies") / "templates" / _TEMPLATES[kind]).read_text("utf-8")
    changed = text_changed(text, rng, separator=rng.choice((": ", " ", ",")))
    content = changed.encode("utf-8", "surrogatepass")
    if way > 0.9:
        content = bytes_changed(content, rng)
    return content


def _dumped(data: Any) -> bytes:
    try:
        text: str = yaml.dump(
            data, Dumper=_Dumper, allow_unicode=True, sort_keys=False, width=10**6
        )
    except (yaml.YAMLError, ValueError):  # an integer of too many digits to be written
        return b"name: [1"
    return text.encode("utf-8", "surrogatepass")


def _with_key(data: Any, kind: str, rng: random.Random) -> Any:
    """Data with one more known key of their kind of file."""
    keys = [k for k in _keys() if k.key.startswith("mission.") == (kind == "mission")]
    key = rng.choice(keys)
    path = key.key.removeprefix("mission.").split(".")
    changed = json.loads(json.dumps(data, default=str))
    holder = changed
    for part in path[:-1]:
        if not isinstance(holder.get(part), dict):
            holder[part] = {}
        holder = holder[part]
    holder[path[-1]] = _value_of(key, rng)
    return changed


def _value_of(key: Key, rng: random.Random) -> Any:
    if key.values and rng.random() < 0.9:
        return rng.choice(key.values)
    if key.number:
        ready = (0, 0.1, 0.5, 0.9, 1, 1.2, 2, 5, 20, 45, 100, 300, 1000, 1e5, 1e9, -1, 1e-6)
        return rng.choice(ready)
    return rng.choice(("e214", "mh114", "x.csv", [0.5, 0.9], [1, 2, 3], "06-21", {}, 3))


def _override(rng: random.Random) -> str:
    key = rng.choice(_keys())
    name, way = key.key, rng.random()
    if way < 0.1:
        name = rng.choice((f"{name}.more", name.replace(".", "..", 1), f"{name}s", name[:-1], ""))
    elif way < 0.2:
        name = f"modules.geometry.surfaces.{rng.randint(-1, 8)}.{rng.choice(('area_m2', 'name'))}"
    elif way < 0.25:
        name = rng.choice(("uncertainty.inputs", "mission.uncertainty.inputs", "uncertainty"))
    value = str(_value_of(key, rng)) if rng.random() < 0.6 else number_text(rng)
    if rng.random() < 0.15:
        value = rng.choice(HOSTILE)
    if rng.random() < 0.1:
        value = rng.choice(
            ("[1, 2]", "{a: 1}", "[", "{minimum: 1, maximum: 2}", "[" * 60, "&a [*a]")
        )
    equals = "" if rng.random() < 0.02 else "="
    return f"{name}{equals}{value}".replace("\0", "")  # no shell passes a null character on


@cache
def _with_polar(path: str) -> bytes:
    data = yaml.safe_load(shipped_text(_PARAMETRIC))
    data["airframe"]["aerodynamics"] = {
        **{"model": "wing_polar", "airfoil": path, "lift_coefficient": 1.0},
        **{"design_aspect_ratio": 18.5, "design_reynolds": 158000},
    }
    return _dumped(data)


# ---- calls


def _called(arguments: tuple[str, ...], files: dict[str, bytes]) -> Case:
    outputs = tuple(word for word in arguments if word.startswith("out."))
    as_json = "--json" in arguments and arguments[0] != "validate"
    return Case(arguments, files, json=as_json, outputs=outputs)


_MAP = ("--latitudes", "0:60:30", "--days", "100:200:50", "--workers", "1")
_AIRCRAFT_CALLS: tuple[tuple[str, ...], ...] = (
    ("validate", "a.yaml"),
    ("analyse", "a.yaml", "--json"),
    ("analyse", "a.yaml", "--model", "CDM", "--csv", "out.csv"),
    ("analyse", "a.yaml", "-m", "rafz-loiter", "--model", "FM", "--json"),
    ("analyse", "a.yaml", "-m", "rafz-28h", "--json"),
    ("map", "a.yaml", *_MAP, "--json"),
    ("size", "a.yaml", "-m", "rafz-july", "--json"),
    ("ceiling", "a.yaml", "--step", "5000", "--csv", "out.csv"),
    ("uncertainty", "a.yaml", "--samples", "64", "--json"),
    ("sweep", "a.yaml", "--vary", "battery_mass_kg=1:3:1", "--workers", "1", "--out", "out.csv"),
    ("compare", "a.yaml", "--models", "CDM,CAM", "--no-design", "--csv", "out.csv"),
    ("efficiencies", "a.yaml", "--csv", "out.csv"),
)
_AIRCRAFT_WEIGHTS = (40, 22, 6, 2, 4, 4, 2, 2, 3, 3, 1, 1)
_MISSION_CALLS: tuple[tuple[str, ...], ...] = (
    ("validate", "m.yaml"),
    ("analyse", _MEASURED, "-m", "m.yaml", "--json"),
    ("analyse", _PARAMETRIC, "-m", "m.yaml"),
    ("analyse", _MEASURED, "-m", "m.yaml", "--model", "VM", "--json"),
    ("analyse", "solong", "-m", "m.yaml", "--csv", "out.csv"),
    ("map", _MEASURED, "-m", "m.yaml", *_MAP, "--json"),
    ("size", _PARAMETRIC, "-m", "m.yaml", "--json"),
    ("ceiling", _MEASURED, "-m", "m.yaml", "--step", "5000", "--json"),
    ("uncertainty", _PARAMETRIC, "-m", "m.yaml", "--samples", "64", "--csv", "out.csv"),
    ("sweep", "sky-sailor", "-m", "m.yaml", "--vary", "mission.altitude_m=0:2000:1000"),
)
_MISSION_WEIGHTS = (40, 25, 6, 3, 4, 4, 2, 2, 2, 2)
