"""Structure and aspect ratio: what is computed against what is published.

``python -m benchmarks.validation.slender_wings`` prints the tables of docs/validation.md
(structures) and docs/structure.md (aspect ratios).
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, replace
from typing import Any

from benchmarks.validation.built_aircraft import (
    ATLANTIKSOLAR,
    SKY_SAILOR,
    BuiltAircraft,
    calibrated_rib_wing,
)
from benchmarks.validation.found_designs import CASES
from missions.library import load_mission
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.library import load_aircraft
from sizing.program.objectives import Objective
from sizing.program.size import size_aircraft
from sizing.sized_structure import structure_assessment
from sizing.structures.assessment import assess
from studies.output.terminal import show
from studies.render.tables import Column, Table

# AC Propulsion's SoLong, flown 48 h in June 2005: 4.75 m, 28 lb, 44 % of it battery (The Engineer,
# July 2005). Assumptions: 1.5 m2 of wing (76 cells alone are 1.2 m2), battery in the fuselage,
# modules of 0.6 kg/m2, lift coefficient 0.8. Its structure was not published: it is less than what
# battery and modules leave.
SOLONG = BuiltAircraft(
    name="SoLong",
    wingspan_m=4.75,
    aspect_ratio=4.75**2 / 1.5,
    total_mass_kg=12.7,
    battery_mass_kg=0.44 * 12.7,
    module_area_m2=1.2,
    span_load_kg=0.6 * 1.2,
    lift_coefficient=0.8,
    density_kg_per_m3=1.10,
    level_flight_w=95.0,
)
LARGEST_ASPECT_RATIO = 40.0
TIP_DEFLECTIONS = (0.05, 0.1, 0.2)
_STRUCTURE = "airframe.structure"
_NO_TORSION = f"{_STRUCTURE}.torsion=null"
_NO_REYNOLDS = "airframe.aerodynamics.reynolds_exponent=0.0"
_ANY_BATTERY = f"{_STRUCTURE}.spar_battery_density_kg_per_m3=null"
# Aspect ratios of AtlantikSolar's class from elsewhere.
PUBLISHED_ASPECT_RATIOS = {
    "AtlantikSolar as built": 18.5,
    "design chart published with AtlantikSolar, least mass": 18.5,
    "design tool published with AtlantikSolar, least mass": 21.0,
}


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


def structure_table() -> Table:
    """Structure of aircraft with published masses, by the calibrated rib wing."""
    model = calibrated_rib_wing()
    cases: list[tuple[BuiltAircraft, str, str]] = [
        (ATLANTIKSOLAR, "1.30 to 1.40", "calibrated on it"),
        (SKY_SAILOR, "0.725; first version about 0.6", _relative(SKY_SAILOR)),
        (SOLONG, f"below {_left(SOLONG):.1f}", "not published"),
    ]
    rows: list[tuple[Any, ...]] = []
    for case, published, difference in cases:
        found = assess(model, case.inputs())
        rows.append(
            (
                case.name,
                case.wingspan_m,
                case.aspect_ratio,
                case.total_mass_kg,
                published,
                float(case.mass_kg(model)),
                difference,
                next(iter(found.spar_caps)).replace("_", " "),
                found.nose.replace("_", " "),
            )
        )
    columns = (
        Column("aircraft"),
        Column("wingspan", unit="m", form=".3g"),
        Column("aspect ratio", form=".3g"),
        Column("total mass", unit="kg", form=".3g"),
        Column("structure, published", unit="kg"),
        Column("computed", unit="kg", form=".2f"),
        Column("difference"),
        Column("caps sized by"),
        Column("nose sized by"),
    )
    return Table("structure against published masses", columns, tuple(rows))


def _relative(case: BuiltAircraft) -> str:
    return f"{100.0 * (float(case.mass_kg(calibrated_rib_wing())) / case.built_kg - 1.0):+.0f} %"


def _left(case: BuiltAircraft) -> float:
    """What battery and modules leave of the mass [kg]."""
    return float(case.total_mass_kg - case.battery_mass_kg - case.span_load_kg)


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
    rows += [
        (name, value, None, None, None, None) for name, value in PUBLISHED_ASPECT_RATIOS.items()
    ]
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
    """Print both tables."""
    for table in (structure_table(), aspect_ratio_table()):
        show(table)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
