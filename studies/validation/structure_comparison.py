"""Structural mass over wingspan: the models beside each other and beside built aircraft.

``python -m studies.validation.structure_comparison --out docs/images/structural-mass.png`` drew
the figure of
docs/structure.md. One aircraft, AtlantikSolar, gives the calibration; any other is a test.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from sizing.smooth import Value
from sizing.structures.models import (
    AllPowerLawStructure,
    PowerLawStructure,
    SparStructure,
    StructureModel,
)
from sizing.structures.rib_wing import RibWingStructure, StructureParts
from studies.output.figure_script import write_figure
from studies.output.plots import CHARGE, LOAD, SUN, to_bytes
from studies.validation.known_structures import (
    ATLANTIKSOLAR,
    KNOWN,
    SKY_SAILOR,
    StructureCase,
    calibrated_rib_wing,
    family,
)

# The calibration of the simpler model, fitted to the same number.
SPAR_CALIBRATION = 1.109


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


def structure_figure() -> Figure:
    """Structural mass over wingspans of 2 to 30 m, with the aircraft that are known."""
    figure = Figure(figsize=(8.0, 5.4), layout="constrained")
    axes = figure.subplots()
    span_m = np.geomspace(2.0, 30.0, 120)
    cases = family(span_m)
    styles = ((LOAD, "-"), (LOAD, ":"), (CHARGE, "--"), (SUN, "-."), ("#CC79A7", (0, (8, 2))))
    for (name, model), (colour, line) in zip(models().items(), styles, strict=True):
        axes.plot(span_m, cases.mass_kg(model), color=colour, linestyle=line, label=name)
    axes.plot(
        span_m, cases.total_mass_kg, color="0.5", linewidth=1, label="total mass, for comparison"
    )
    for case, marker in zip(KNOWN, "os", strict=True):
        label = f"{case.name}, AR {case.aspect_ratio:g}, as built"
        axes.plot([case.wingspan_m], [case.built_kg], marker, color="black", label=label)
    axes.plot(
        [SKY_SAILOR.wingspan_m],
        [SKY_SAILOR.mass_kg(calibrated_rib_wing())],
        "s",
        color=LOAD,
        markerfacecolor="white",
        label=f"rib_wing for {SKY_SAILOR.name}, not recalibrated",
    )
    ticks = (2, 3, 4, 5, 7, 10, 15, 20, 30)
    axes.set(xscale="log", yscale="log", xlabel="wingspan [m]", ylabel="structural mass [kg]")
    axes.set_xticks(ticks, [str(t) for t in ticks])
    axes.set_xticks([], minor=True)
    axes.set_ylim(0.05, 2000.0)
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left", fontsize="small")
    loading = ATLANTIKSOLAR.total_mass_kg * ATLANTIKSOLAR.aspect_ratio / 5.65**2
    axes.set_title(f"aspect ratio {ATLANTIKSOLAR.aspect_ratio:g}, wing loading {loading:.1f} kg/m²")
    return figure


def structure_image(drawn_as: str = "png") -> bytes:
    """Image of the comparison in a format of :data:`studies.output.formats.IMAGE_FORMATS`."""
    return to_bytes(structure_figure(), drawn_as)


def markdown() -> str:
    """Tables: models against built aircraft; the rib wing part by part, and what varies it."""
    head = " | ".join(f"{c.name}, {c.built_kg:g} kg as built" for c in KNOWN)
    lines = [f"| model | {head} | at 12 m | at 25 m |", "|---|" + "---|" * (len(KNOWN) + 2)]
    for name, model in models().items():
        cells = [_against(case, model) for case in KNOWN]
        cells += [f"{family(span).mass_kg(model):.1f}" for span in (12.0, 25.0)]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    parts = [case.parts(calibrated_rib_wing()) for case in (*KNOWN, family(12.0), family(25.0))]
    lines += ["", "| part [kg] | AtlantikSolar | Sky-Sailor | at 12 m | at 25 m |"]
    lines += ["|---|---|---|---|---|"]
    for part in StructureParts._fields:
        cells = [f"{getattr(p, part):.3f}" for p in parts]
        lines.append(f"| {part.replace('_', ' ')} | " + " | ".join(cells) + " |")
    lines.append("| structure | " + " | ".join(f"{p.total_kg:.3f}" for p in parts) + " |")
    lines += ["", *_variation_lines()]
    return "\n".join(lines) + "\n"


def variations() -> dict[str, RibWingStructure]:
    """The rib wing with one assumption changed at a time."""
    changes: dict[str, dict[str, float]] = {
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
        "tip deflection up to 10 % of the half-span": {"maximum_tip_deflection": 0.1},
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


def _variation_lines() -> list[str]:
    cases = (*KNOWN, family(12.0), family(25.0))
    shipped = [float(case.mass_kg(calibrated_rib_wing())) for case in cases]
    lines = [
        "| assumption | AtlantikSolar | Sky-Sailor | at 12 m | at 25 m |",
        "|---|---|---|---|---|",
    ]
    fuselage = "battery in the fuselage"
    alone = [case._replace(span_load_kg=_modules_kg(case)) for case in cases]
    rows = {name: [c.mass_kg(model) for c in cases] for name, model in variations().items()}
    rows[fuselage] = [case.mass_kg(calibrated_rib_wing()) for case in alone]
    for name, masses in rows.items():
        cells = (
            f"{float(kg):.2f} ({100.0 * (float(kg) / own - 1.0):+.1f} %)"
            for kg, own in zip(masses, shipped, strict=True)
        )
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return lines


def _modules_kg(case: StructureCase) -> Value:
    """What Sky-Sailor carries along the span anyway; AtlantikSolar without its battery."""
    if case.name == SKY_SAILOR.name:
        return case.span_load_kg
    share = 0.59 * 1.35 / ATLANTIKSOLAR.total_mass_kg
    return share * case.total_mass_kg


def _against(case: StructureCase, model: StructureModel) -> str:
    mass_kg = float(case.mass_kg(model))
    return f"{mass_kg:.2f} ({100.0 * (mass_kg / case.built_kg - 1.0):+.0f} %)"


def main(arguments: list[str] | None = None) -> int:
    """Command line: write the figure; the exit code is 1 where it cannot."""
    prog = "python -m studies.validation.structure_comparison"
    return write_figure(structure_image, arguments, prog=prog, description=__doc__)


if __name__ == "__main__":
    raise SystemExit(main())
