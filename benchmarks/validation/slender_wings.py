"""What limits the aspect ratio: designs of least mass with it free.

``python -m benchmarks.validation.slender_wings`` prints the table of docs/structure.md.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from typing import Any

from benchmarks.validation.built_aircraft import (
    ATLANTIKSOLAR,
)
from benchmarks.validation.found_designs import CASES
from missions.library import load_mission
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.library import load_aircraft
from sizing.program.objectives import Objective
from sizing.program.size import size_aircraft
from sizing.sized_structure import structure_assessment
from studies.output.terminal import show
from studies.render.tables import Column, Table

LARGEST_ASPECT_RATIO = 40.0
TIP_DEFLECTIONS = (0.05, 0.1, 0.2)
_STRUCTURE = "airframe.structure"
_NO_TORSION = f"{_STRUCTURE}.torsion=null"
_NO_REYNOLDS = "airframe.aerodynamics.reynolds_exponent=0.0"
_ANY_BATTERY = f"{_STRUCTURE}.spar_battery_density_kg_per_m3=null"


@dataclass(frozen=True)
class StiffnessCase:
    """A requirement, and what is changed of the shipped structure."""

    label: str
    mission: Mission
    required_excess_time_h: float
    changes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Slenderness:
    """Design of least mass with the aspect ratio free."""

    aspect_ratio: float
    wingspan_m: float
    total_mass_kg: float
    structure_kg: float
    caps_sized_by: str


def stiffness_cases() -> tuple[StiffnessCase, ...]:
    """The requirements of AtlantikSolar's class, and the stiffness varied for one of them."""
    structure = _STRUCTURE
    summer = load_mission("central-europe-summer")
    plain = StiffnessCase("central-europe-summer, as shipped", summer, 0.0)
    built = [case for case in CASES if case.built is ATLANTIKSOLAR and "mass" in case.label]
    named = [
        StiffnessCase(
            case.label,
            Mission.model_validate({"name": "requirements", **case.mission}),
            case.required_excess_time_h,
        )
        for case in built
    ]
    stiffness = f"{structure}.maximum_tip_deflection"
    in_flight = f"{structure}.deflection_load_case=level_flight"
    at_limit = f"{structure}.deflection_load_case=limit_load"
    variations = {
        **{
            f"tip deflection {f:g} in level flight": (f"{stiffness}={f:g}", in_flight)
            for f in TIP_DEFLECTIONS
        },
        **{
            f"tip deflection {f:g} at the limit load": (f"{stiffness}={f:g}", at_limit)
            for f in TIP_DEFLECTIONS
        },
        "slope of the tip 10 deg at the limit load": (
            f"{structure}.maximum_tip_slope_deg=10.0",
            at_limit,
        ),
        "tip deflection 0.1 in landing": (f"{structure}.maximum_landing_deflection=0.1",),
        # What ends the aspect ratio where nothing limits the deflection, one cause after another.
        "no torsion": (_NO_TORSION,),
        "profile drag without the Reynolds number": (_NO_REYNOLDS,),
        "any battery fits the spar": (_ANY_BATTERY,),
        "no torsion, no Reynolds number": (_NO_TORSION, _NO_REYNOLDS),
        "none of the three": (_NO_TORSION, _NO_REYNOLDS, _ANY_BATTERY),
        # Two rows of cells of 125 mm with their gaps; one row.
        "chord at least 0.28 m": ("design_space.limits={chord_m: {minimum: 0.28}}",),
        "chord at least 0.15 m": ("design_space.limits={chord_m: {minimum: 0.15}}",),
        "Reynolds number at least 100,000": (
            "design_space.limits={reynolds_number: {minimum: 1e5}}",
        ),
    }
    varied = [replace(plain, label=name, changes=changes) for name, changes in variations.items()]
    return (plain, *named, *varied)


def slenderness(case: StiffnessCase) -> Slenderness | None:
    """Design of least mass with the aspect ratio free up to 40; None where there is none."""
    free = f"design_space.aspect_ratio={{minimum: 8, maximum: {LARGEST_ASPECT_RATIO:g}}}"
    aircraft: Aircraft = load_aircraft("atlantiksolar-design", [free, *case.changes])
    result = size_aircraft(
        aircraft,
        case.mission,
        Objective.min_mass,
        required_excess_time_h=case.required_excess_time_h,
    )
    if result.design is None:
        return None
    sized = structure_assessment(aircraft, result.design)
    assert sized is not None
    return Slenderness(
        float(result.design.variables.aspect_ratio),
        float(result.design.variables.wingspan_m),
        float(result.design.total_mass_kg),
        float(result.design.masses.structure),
        next(iter(sized.spar_caps)).replace("_", " "),
    )


def aspect_ratio_table() -> Table:
    """Aspect ratio of least mass, and what ends it, beside published ones."""
    rows: list[tuple[Any, ...]] = []
    for case in stiffness_cases():
        found = slenderness(case)
        values = (None,) * 5 if found is None else astuple(found)
        rows.append((case.label, *values))
    columns = (
        Column("requirement"),
        Column("aspect ratio", form=".1f"),
        Column("wingspan", unit="m", form=".2f"),
        Column("total mass", unit="kg", form=".2f"),
        Column("structure", unit="kg", form=".2f"),
        Column("caps sized by"),
    )
    return Table("aspect ratio of least mass", columns, tuple(rows))


def main() -> int:
    """Print the table."""
    show(aspect_ratio_table())
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
