"""Structural mass over wingspan: the models beside each other and beside built aircraft.

``python -m benchmarks.validation.structure_comparison --out docs/images/structural-mass.png`` drew
the figure of docs/structure.md. One aircraft, AtlantikSolar, gives the calibration; any other is a
test.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.validation.built_aircraft import (
    ATLANTIKSOLAR,
    SKY_SAILOR,
    BuiltAircraft,
    calibrated_rib_wing,
)
from benchmarks.validation.figure_script import write_figure
from missions.air import gust_speed_fraction, standard_air
from sizing.smooth import Value
from sizing.structures.models import (
    SPAR_CALIBRATION,
    AllPowerLawStructure,
    PowerLawStructure,
    SparStructure,
    StructureModel,
)
from sizing.structures.rib_wing import RibWingStructure, StructureParts
from studies.output.figures.drawing import (
    CHARGE,
    LOAD,
    PURPLE,
    SUN,
    Canvas,
    ink,
    new_figure,
    styled,
    to_bytes,
)
from studies.output.figures.options import DEFAULT, FigureOptions
from studies.render.tables import Column, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BUILT = (ATLANTIKSOLAR, SKY_SAILOR)


def family(wingspan_m: Value) -> BuiltAircraft:
    """AtlantikSolar at another span [m]: same aspect ratio, wing loading and shares of mass."""
    scale = (wingspan_m / ATLANTIKSOLAR.wingspan_m) ** 2
    return replace(
        ATLANTIKSOLAR,
        wingspan_m=wingspan_m,
        total_mass_kg=scale * ATLANTIKSOLAR.total_mass_kg,
        battery_mass_kg=scale * ATLANTIKSOLAR.battery_mass_kg,
        wing_battery_kg=scale * ATLANTIKSOLAR.wing_battery_kg,
        span_load_kg=scale * ATLANTIKSOLAR.span_load_kg,
        structure_kg=None,
    )


def models() -> dict[str, StructureModel]:
    """Models that are compared."""
    calibrated = calibrated_rib_wing()
    return {
        f"rib_wing, calibration {calibrated.calibration:g}": calibrated,
        "rib_wing, calibration 1": calibrated.model_copy(update={"calibration": 1.0}),
        f"spar, calibration {SPAR_CALIBRATION:g}": SparStructure(calibration=SPAR_CALIBRATION),
        "power_law: Noth, best 5 %": PowerLawStructure(),
        "power_law_all: Noth, all 415": AllPowerLawStructure(model="power_law_all"),
    }


@styled
def structure_figure(*, figure: Canvas = DEFAULT) -> Figure:
    """Structural mass over wingspans of 2 to 30 m, with the aircraft that are known."""
    loading = ATLANTIKSOLAR.total_mass_kg * ATLANTIKSOLAR.aspect_ratio / 5.65**2
    drawn, (axes,) = new_figure(
        canvas=figure,
        title="Structural mass of wings by five models",
        notes=(f"aspect ratio {ATLANTIKSOLAR.aspect_ratio:g}, wing loading {loading:.1f} kg/m²",),
        size_in=(8.0, 5.4),
    )
    span_m = np.geomspace(2.0, 30.0, 120)
    cases = family(span_m)
    styles = ((LOAD, "-"), (LOAD, ":"), (CHARGE, "--"), (SUN, "-."), (PURPLE, (0, (8, 2))))
    for (name, model), (colour, line) in zip(models().items(), styles, strict=True):
        axes.plot(span_m, cases.mass_kg(model), color=colour, linestyle=line, label=in_words(name))
    axes.plot(
        span_m, cases.total_mass_kg, color="0.5", linewidth=1, label="total mass, for comparison"
    )
    for case, marker in zip(BUILT, "os", strict=True):
        label = f"{case.name}, AR {case.aspect_ratio:g}, as built"
        axes.plot([case.wingspan_m], [case.built_kg], marker, color=ink(), label=label)
    axes.plot(
        [SKY_SAILOR.wingspan_m],
        [SKY_SAILOR.mass_kg(calibrated_rib_wing())],
        "s",
        color=LOAD,
        fillstyle="none",
        label=f"rib wing for {SKY_SAILOR.name}, not recalibrated",
    )
    ticks = (2, 3, 4, 5, 7, 10, 15, 20, 30)
    axes.set(xscale="log", yscale="log", xlabel="wingspan [m]", ylabel="structural mass [kg]")
    axes.set_xticks(ticks, [str(t) for t in ticks])
    axes.set_xticks([], minor=True)
    axes.set_ylim(0.05, 2000.0)
    axes.legend(loc="upper left")
    return drawn


def in_words(name: str) -> str:
    """Model without the key that chooses it in an aircraft file."""
    return name.rpartition(": ")[2].replace("_", " ")


def structure_image(drawn_as: str = "png", figure: FigureOptions = DEFAULT) -> bytes:
    """Image of the comparison.

    Parameters
    ----------
    drawn_as : str
        One of :data:`studies.output.formats.IMAGE_FORMATS`.
    figure : FigureOptions
        How it looks.

    Returns
    -------
    bytes
    """
    return to_bytes(structure_figure(figure=figure), drawn_as)


def structure_tables() -> tuple[Table, Table, Table]:
    """Models against built aircraft; the rib wing part by part, and what varies it."""
    cases = (*BUILT, family(12.0), family(25.0))
    names = tuple(Column(name) for name in ("AtlantikSolar", "Sky-Sailor", "at 12 m", "at 25 m"))
    mass = tuple(replace(name, unit="kg", form=".3f") for name in names)
    against = tuple(Column(f"{c.name}, {c.built_kg:g} kg as built") for c in BUILT)
    by_model = [
        (
            name,
            *(_against(case, model) for case in BUILT),
            *(float(family(span_m).mass_kg(model)) for span_m in (12.0, 25.0)),
        )
        for name, model in models().items()
    ]
    parts = [calibrated_rib_wing().breakdown(case.inputs()) for case in cases]
    by_part = [
        (part.replace("_", " "), *(float(getattr(p, part)) for p in parts))
        for part in StructureParts._fields
    ]
    by_part.append(("structure", *(float(p.total_kg) for p in parts)))
    wide = tuple(Column(name, unit="kg", form=".1f") for name in ("at 12 m", "at 25 m"))
    return (
        Table("structural mass", (Column("model"), *against, *wide), tuple(by_model)),
        Table("parts of the rib wing", (Column("part"), *mass), tuple(by_part)),
        Table("assumptions", (Column("assumption"), *names), tuple(_variation_rows(cases))),
    )


GUST_ALTITUDES_M = (500.0, 6096.0, 9000.0, 12000.0, 15240.0, 20000.0)


def gust_table() -> Table:
    """What gust speeds that fall with altitude make of load factor and structure."""
    rows = []
    for altitude_m in GUST_ALTITUDES_M:
        row: list[float] = [altitude_m / 1000.0]
        for span_m in (ATLANTIKSOLAR.wingspan_m, 25.0):
            wing = replace(
                family(span_m),
                density_kg_per_m3=float(standard_air(altitude_m).density_kg_per_m3),
            ).inputs()
            wing = wing._replace(gust_fraction=float(gust_speed_fraction(altitude_m)))
            falling = calibrated_rib_wing()
            full = falling.model_copy(update={"gusts_fall_with_altitude": False})
            full_kg, falling_kg = float(full.mass_kg(wing)), float(falling.mass_kg(wing))
            row += [
                float(full.wing(wing).factor_up),
                float(falling.wing(wing).factor_up),
                100.0 * (full_kg / falling_kg - 1.0),
            ]
        rows.append(tuple(row))
    columns = [Column("altitude", unit="km", form=".3g")]
    for span in ("5.65 m", "25 m"):
        columns += [
            Column(f"{span}: limit load, full gust", unit="g", form=".1f"),
            Column(f"{span}: falling gust", unit="g", form=".1f"),
            Column(f"{span}: structure with full gust", unit="% more", form=".1f"),
        ]
    return Table("gusts at altitude", tuple(columns), tuple(rows))


def variations() -> dict[str, RibWingStructure]:
    """The rib wing with one assumption changed at a time."""
    changes: dict[str, dict[str, Any]] = {
        "as shipped": {},
        "no gusts": {"cruise_gust_m_per_s": 0.0, "dive_gust_m_per_s": 0.0},
        "no landing case": {"landing_load_factor": 0.0},
        "no gusts, no landing case": {
            "cruise_gust_m_per_s": 0.0,
            "dive_gust_m_per_s": 0.0,
            "landing_load_factor": 0.0,
        },
        "caps half as wide": {"cap_width_fraction": 0.03},
        "caps twice as wide": {"cap_width_fraction": 0.12},
        "compressive strength +50 %": {"compressive_strength_pa": 1.5 * 368e6},
        "webs from 0.3 mm": {"minimum_web_thickness_m": 0.3e-3},
        **{
            f"tip deflection up to {f:g} at the limit load": {
                "maximum_tip_deflection": f,
                "deflection_load_case": "limit_load",
            }
            for f in (0.05, 0.1, 0.2)
        },
        "slope of the tip up to 10 deg at the limit load": {
            "maximum_tip_slope_deg": 10.0,
            "deflection_load_case": "limit_load",
        },
        "no torsion": {"torsion": None},
        "any battery fits the spar": {"spar_battery_density_kg_per_m3": None},
        "battery in the pod needs no mount": {"pod_battery_mount_fraction": 0.0},
        "covering, tails and pod +50 %": {
            "covering_kg_per_m2": 0.075,
            "tail_kg_per_m2": 0.525,
            "pod_kg_per_m2": 0.6,
        },
        "sheet 1 mm instead of 1.5 mm": {"minimum_sheet_thickness_m": 1e-3},
        "joints 10 % instead of 15 %": {"joint_fraction": 0.1},
    }
    shipped = calibrated_rib_wing()
    return {name: shipped.model_copy(update=change) for name, change in changes.items()}


def _variation_rows(cases: Sequence[BuiltAircraft]) -> Iterator[tuple[str, ...]]:
    model = calibrated_rib_wing()
    shipped = [float(case.mass_kg(model)) for case in cases]
    alone = [replace(case, span_load_kg=_modules_kg(case), wing_battery_kg=0.0) for case in cases]
    masses = {name: [c.mass_kg(varied) for c in cases] for name, varied in variations().items()}
    masses["battery in the fuselage"] = [case.mass_kg(model) for case in alone]
    for name, of_cases in masses.items():
        yield name, *map(_beside, of_cases, shipped)


def _beside(mass_kg: Value, other_kg: float, digits: int = 1) -> str:
    """Mass, and how far it is from another."""
    kg = float(mass_kg)
    return f"{kg:.2f} ({100.0 * (kg / other_kg - 1.0):+.{digits}f} %)"


def _modules_kg(case: BuiltAircraft) -> Value:
    """What Sky-Sailor carries along the span anyway; AtlantikSolar without its battery."""
    if case.name == SKY_SAILOR.name:
        return case.span_load_kg
    share = 0.59 * 1.35 / ATLANTIKSOLAR.total_mass_kg
    return share * case.total_mass_kg


def _against(case: BuiltAircraft, model: StructureModel) -> str:
    return _beside(case.mass_kg(model), case.built_kg, 0)


def main(arguments: list[str] | None = None) -> int:
    """Command line: write the figure; the exit code is 1 where it cannot."""
    prog = "python -m benchmarks.validation.structure_comparison"
    return write_figure(structure_image, arguments, prog=prog, description=__doc__)


if __name__ == "__main__":
    raise SystemExit(main())
