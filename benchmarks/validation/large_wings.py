"""What makes a wing of tens of metres heavy, step by step: a table of docs/structure.md."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from benchmarks.validation.structures import PublishedStructure, published_structures
from sizing.structures.rib_wing import RIB_WING_CALIBRATION, RibWingStructure
from studies.render.tables import Column, Table

AIRCRAFT = ("atlantiksolar", "zephyr-7", "zephyr-8", "phasa-35", "heliplat", "helios")
_CARBON = {"cloth_shear_modulus_pa": 33e9, "cloth_density_kg_per_m3": 1600.0}
# Each step keeps the keys of those above it.
STEPS: Mapping[str, Mapping[str, Any]] = {
    "strength, gusts and torsion, as `init` wrote it in 1.0": {"torsion": {}},
    "tip deflection 0.05 at the limit load": {
        "maximum_tip_deflection": 0.05,
        "deflection_load_case": "limit_load",
    },
    "no limit of the deflection, `narrow_caps`": {
        "maximum_tip_deflection": None,
        "narrow_caps": True,
    },
    "`web_core`": {"web_core": {}},
    "carbon cloth in the nose": {"torsion": _CARBON},
}
# Keys of an aircraft of its own that are no construction.
_OWN = ("booms", "thickness_ratio")


def _steps() -> dict[str, dict[str, Any]]:
    base: dict[str, Any] = {
        "model": "rib_wing",
        "calibration": RIB_WING_CALIBRATION,
        "gusts_fall_with_altitude": True,
    }
    steps = {}
    for name, keys in STEPS.items():
        base = {**base, **keys}
        steps[name] = base
    return steps


def _structure_text(one: PublishedStructure, keys: Mapping[str, Any]) -> str:
    own = {key: getattr(one.models[0], key) for key in _OWN}
    return one.computed_structure_kg((RibWingStructure.model_validate({**keys, **own}),)).text(2)


def large_wings_table() -> Table:
    """Structure at the published total mass, with one key more from row to row."""
    chosen = [published_structures()[key] for key in AIRCRAFT]
    columns = (Column("rib_wing"), *(Column(one.name, f"{one.name} [kg]") for one in chosen))
    rows = [
        (name, *(_structure_text(one, keys) for one in chosen)) for name, keys in _steps().items()
    ]
    with_own = [one.computed_structure_kg(one.models).text(2) for one in chosen]
    rows.append(("loads, landing gear as published or unknown", *with_own))
    rows.append(("published", *(one.structure_kg.text(2) for one in chosen)))
    return Table("", columns, tuple(rows))
