"""What sizes a rib wing, and how far it bends and twists: for numbers, after the sizing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from sizing.smooth import Value
from sizing.structures.loads import StructureInputs, limit_load_factor
from sizing.structures.parts import Wing, largest
from sizing.structures.rib_wing import RibWingStructure
from sizing.structures.stations import Station, along_the_span
from sizing.structures.torsion import WingTorsion

_LABELS = {
    "compression": "compression strength",
    "buckling": "buckling",
    "tension": "tensile strength",
    "shear": "shear strength",
    "gauge": "minimum gauge",
    "tip_deflection": "tip deflection",
    "flutter": "flutter",
    "divergence": "divergence",
    "twist_in_dive": "twist in a dive",
    "twist_at_limit_load": "twist at limit load",
}


@dataclass(frozen=True)
class Torsion:
    """Torsional stiffness of a wing and the speeds it is good for.

    Attributes
    ----------
    stiffness_nm2, needed_nm2 : float
        Torsional stiffness GJ, at least, and what the criteria ask for [N m2].
    divergence_speed_ratio : float or None
        Speed of torsional divergence over dive speed [-]; None where the wing cannot diverge.
    flutter_flexibility_ratio : float
        Torsional flexibility over the largest that Report 45 allows [-].
    twist_at_limit_load_deg : float
        Of the tip [deg].
    """

    stiffness_nm2: float
    needed_nm2: float
    divergence_speed_ratio: float | None
    flutter_flexibility_ratio: float
    twist_at_limit_load_deg: float


@dataclass(frozen=True)
class StructureAssessment:
    """What sizes the spar and the nose, and the stiffness that follows.

    Attributes
    ----------
    limit_load_factor : float
        Upwards [-].
    load_case : str
        What that is: ``gust`` or ``manoeuvre``.
    spar_caps, spar_web : dict
        Share of the mass of caps and webs that each criterion sizes [-], largest first.
    nose : str
        Criterion that sizes the sheet of the nose.
    tip_deflection_1g, tip_deflection_limit : float
        Of the tip over the half-span, in level flight and at the upward limit load [-].
    torsion : Torsion or None
        None where the file asks for no torsional stiffness.
    wing_battery_kg, pod_battery_kg : float
        Battery in the spar and in the pod [kg].
    """

    limit_load_factor: float
    load_case: str
    spar_caps: dict[str, float]
    spar_web: dict[str, float]
    nose: str
    tip_deflection_1g: float
    tip_deflection_limit: float
    torsion: Torsion | None
    wing_battery_kg: float
    pod_battery_kg: float

    def to_dict(self) -> dict[str, Any]:
        """All of it, JSON-ready."""
        torsion = None if self.torsion is None else dict(vars(self.torsion))
        return {**vars(self), "torsion": torsion, "text": self.headline()}

    def headline(self) -> str:
        """What sizes the structure, in a line."""
        caps, web = next(iter(self.spar_caps)), next(iter(self.spar_web))
        return (
            f"structure: spar caps sized by {_LABELS[caps]} ({100.0 * self.spar_caps[caps]:.0f} % "
            f"of their mass), webs by {_LABELS[web]}, nose by {_LABELS[self.nose]}; limit load "
            f"{self.limit_load_factor:.1f} g from a {self.load_case}; tip deflection "
            f"{100.0 * self.tip_deflection_1g:.1f} % of the half-span at 1 g, "
            f"{100.0 * self.tip_deflection_limit:.1f} % at limit load"
        )


def assess(model: RibWingStructure, inputs: StructureInputs) -> StructureAssessment:
    """What sizes a rib wing.

    Parameters
    ----------
    model : RibWingStructure
        The model that sized it.
    inputs : StructureInputs
        Of floats.

    Returns
    -------
    StructureAssessment
    """
    inputs = StructureInputs(*(float(value) for value in inputs))
    wing = model.wing(inputs)
    station, integral = along_the_span(wing.wingspan_m)
    forces = model.forces(wing, station)
    upper = model.cap_needs_m2(wing, forces.up, forces.down)
    lower = model.cap_needs_m2(wing, forces.down, forces.up)
    limit = _tip_deflection(model, wing, station, integral, upper=upper, lower=lower)
    up = float(wing.factors.up)
    return StructureAssessment(
        limit_load_factor=up,
        load_case="gust" if up > 1.01 * limit_load_factor(wing.total_mass_kg) else "manoeuvre",
        spar_caps=_shares((upper, lower), station),
        spar_web=_shares((model.web_needs_m(wing, forces.shear),), station),
        nose=_nose(model, wing),
        tip_deflection_1g=limit / up,
        tip_deflection_limit=limit,
        torsion=None if model.torsion is None else _torsion(model, model.torsion, wing),
        wing_battery_kg=inputs.wing_battery_kg + inputs.pod_battery_kg - float(wing.pod_battery_kg),
        pod_battery_kg=float(wing.pod_battery_kg),
    )


def _shares(needs: tuple[dict[str, Value], ...], station: Station) -> dict[str, float]:
    """Share of the material where each criterion asks for the most, largest first."""
    found: dict[str, float] = {}
    for each in needs:
        table = np.array([np.broadcast_to(need, station.weight.shape) for need in each.values()])
        for name, size, weight in zip(
            np.array(list(each))[table.argmax(axis=0)],
            table.max(axis=0),
            station.weight,
            strict=True,
        ):
            found[str(name)] = found.get(str(name), 0.0) + float(size * weight)
    total = sum(found.values())
    return {name: found[name] / total for name in sorted(found, key=lambda n: -found[n])}


def _tip_deflection(
    model: RibWingStructure,
    wing: Wing,
    station: Station,
    integral: Any,
    *,
    upper: dict[str, Value],
    lower: dict[str, Value],
) -> float:
    """Deflection of the tip over the half-span at the upward limit load, by beam theory."""
    upper_m2, lower_m2 = largest(upper), largest(lower)
    lifted = wing.total_mass_kg * station.lift_moment - wing.relief_kg * station.mass_moment
    half_span = wing.wingspan_m / 2.0
    moment = wing.factors.up * GRAVITY_M_PER_S2 / 2.0 * half_span * lifted
    section = upper_m2 * lower_m2 / (upper_m2 + lower_m2)
    curvature = moment / (model.modulus_pa * wing.depth_m**2 * section)
    return float(integral(curvature * (1.0 - station.fraction)) * half_span)


def _nose(model: RibWingStructure, wing: Wing) -> str:
    """Criterion that sizes the nose's sheet."""
    if model.torsion is None:
        return "gauge"
    needed = model.torsion.needed_nm2(model.twisting(wing))
    name = max(needed, key=lambda each: float(needed[each]))
    return name if _at_gauge_nm2(model, model.torsion, wing) < needed[name] else "gauge"


def _at_gauge_nm2(model: RibWingStructure, torsion: WingTorsion, wing: Wing) -> float:
    """Torsional stiffness with the nose's sheet at its gauge."""
    wall = torsion.sheet_shear_modulus_pa * wing.sheet_m
    nose = model.nose_cell(wing.chord_m).stiffness_nm2(wall)
    return float(nose + model.box_torsional_stiffness_nm2(wing))


def _torsion(model: RibWingStructure, torsion: WingTorsion, wing: Wing) -> Torsion:
    needed = {k: float(v) for k, v in torsion.needed_nm2(model.twisting(wing)).items()}
    stiff = wing._replace(sheet_m=wing.sheet_m + model.stiffening_sheet_m(wing))
    stiffness = _at_gauge_nm2(model, torsion, stiff)
    twist = torsion.maximum_twist_deg * needed["twist_at_limit_load"] / stiffness
    diverging = needed["divergence"] / torsion.speed_margin**2
    return Torsion(
        stiffness_nm2=stiffness,
        needed_nm2=max(needed.values()),
        divergence_speed_ratio=None if diverging == 0.0 else (stiffness / diverging) ** 0.5,
        flutter_flexibility_ratio=needed["flutter"] / stiffness,
        twist_at_limit_load_deg=twist,
    )
