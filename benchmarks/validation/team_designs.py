"""Aircraft that flew, from the files of ``init``: data in ``team_designs.yaml``."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import resources
from types import MappingProxyType
from typing import Any

import numpy as np
import yaml

from benchmarks.validation.structures import build_ratio, published_structures
from missions.files.overrides import with_overrides
from missions.files.validation import validate
from missions.files.yaml import Document, parse_yaml
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import Design, variables_of
from sizing.library import refuse_named_twice
from sizing.mass_budget import closed_design
from sizing.parameters import BUILD_KEY
from sizing.results.sizing import size
from sizing.sized_structure import structure_parts
from sizing.structures.build import build_qualities
from studies.render.tables import Column, Table


@cache
def team_designs() -> Mapping[str, Mapping[str, Any]]:
    """Records of ``team_designs.yaml`` by their keys."""
    text = resources.files(__package__).joinpath("team_designs.yaml").read_text(encoding="utf-8")
    records: Mapping[str, Mapping[str, Any]] = yaml.safe_load(text)
    return records


def _starter(kind: str) -> Document:
    """File that ``init`` writes."""
    template = resources.files("studies").joinpath("templates", f"{kind}.yaml")
    return parse_yaml(template.read_text(encoding="utf-8").replace("NAME", "team"), f"{kind}.yaml")


def starters(
    record: Mapping[str, Any], build: str | float, parts: Mapping[str, Any] = MappingProxyType({})
) -> tuple[Aircraft, Mission]:
    """What ``init`` writes, with what a record changes in it."""
    own = record.get("geometry", record.get("aircraft"))
    changes = {BUILD_KEY: build, **own, **parts}
    document = with_overrides(_starter("aircraft"), changes)
    aircraft = validate(document, Aircraft)
    refuse_named_twice(document)
    return aircraft, validate(with_overrides(_starter("mission"), record["mission"]), Mission)


def computed(
    record: Mapping[str, Any], build: str | float, parts: Mapping[str, Any] = MappingProxyType({})
) -> Design | None:
    """Optimum of least mass, or the aircraft of the given geometry; None where none closes."""
    aircraft, mission = starters(record, build, parts)
    if "geometry" in record:
        return closed_design(aircraft, mission, variables_of(aircraft))
    return size(aircraft, mission).design


def factor_without(record: Mapping[str, Any]) -> float:
    """Factor of the class as the other aircraft give it: the geometric mean of their ratios [-]."""
    known = [*published_structures().values(), *published_structures("hand_built").values()]
    others = [
        np.log(build_ratio(one))
        for one in known
        if one.name in build_qualities()[record["build"]].aircraft
        and not one.name.startswith(record["structure"])
    ]
    return float(np.exp(np.mean(others)))


def team_designs_table() -> Table:
    """Published beside computed sizes; with the class, and with that without the aircraft."""
    columns = (
        *(Column("aircraft"), Column("build"), Column("requirement"), Column("parts")),
        Column("span", "wingspan [m]"),
        Column("mass", "total mass [kg]"),
        Column("battery", "battery [kg]"),
        Column("without", "total mass [kg], class without it"),
    )
    rows = []
    for one in team_designs().values():
        known: Mapping[str, Any] = one["published"]
        every: dict[str, Any] = {"of `init`": {}, "its own": one.get("own_parts")}
        for name, parts in every.items():
            if parts is None:
                continue
            found, apart = (
                computed(one, build, parts) for build in (one["build"], factor_without(one))
            )
            rows.append(
                (
                    *(one["name"], f"`{one['build']}`", one["requirement"], name),
                    _text(known["wingspan_m"], found and found.variables.wingspan_m),
                    _text(known["total_mass_kg"], found and found.total_mass_kg),
                    _battery(one, found),
                    _text(known["total_mass_kg"], apart and apart.total_mass_kg),
                )
            )
    return Table("", columns, tuple(rows))


def weighed_parts_table() -> Table:
    """Structures that were weighed part by part beside those computed with their class."""
    rows = []
    for one in team_designs().values():
        if "weighed_kg" not in one:
            continue
        aircraft, mission = starters(one, one["build"])
        built = structure_parts(aircraft, closed_design(aircraft, mission, variables_of(aircraft)))
        assert built is not None
        found = {name: float(mass) for name, mass in built._asdict().items()}
        # Glue and fittings are a share of all.
        joined = sum(found.values()) / (sum(found.values()) - found.pop("joints"))
        parts = {key: found.pop(key) for key in ("tails", "boom", "pod")}
        parts["wing"] = sum(found.values())
        for name, weighed in one["weighed_kg"].items():
            rows.append((one["name"], name, _text(weighed, joined * parts[name])))
    return Table("", (Column("aircraft"), Column("part"), Column("mass", "mass [kg]")), tuple(rows))


def _battery(record: Mapping[str, Any], found: Design | None) -> str:
    """Published and computed battery; that of a given geometry is given."""
    published = record["published"].get("battery_mass_kg")
    if "geometry" in record:
        return "given"
    if published is None:
        return (
            "-" if found is None else f"not published: {float(found.variables.battery_mass_kg):.2f}"
        )
    return _text(published, found and found.variables.battery_mass_kg)


def _text(published: float, found: Any) -> str:
    """Published and computed value, and their difference."""
    if found is None:
        return f"{published:g}: no design"
    value = float(found)
    if value == published:
        return f"{published:g}: given"
    return f"{published:g}: {value:.2f} ({100.0 * (value / published - 1.0):+.0f} %)"
