"""Drag of tails, booms, pods and gaps by handbook formulas, in place of a parasitic constant.

``C_D = C_f F Q S_wet/S``: skin friction, form factor, interference (Raymer, D. P., Aircraft Design:
A Conceptual Approach, eq. 12.24). Arithmetic alone, for floats, arrays and symbols.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from math import asin, pi
from typing import ClassVar, NamedTuple

from pydantic import model_validator

from sizing.aerodynamics.wing_polar import plane_form_factor
from sizing.balance.surfaces import Tail, Wing
from sizing.roots import bisect
from sizing.smooth import Value
from sizing.structures.rib_wing import RibWingStructure
from solar.schema import (
    NonNegativeReal,
    PositiveInteger,
    PositiveReal,
    Record,
    UnitInterval,
    spell,
    wrong_value,
)


def skin_friction(reynolds: Value, laminar_fraction: float) -> Value:
    """Return the skin friction coefficient of a partly laminar flat plate [-].

    ``1.328 Re^-1/2`` and ``0.074 Re^-1/5`` (Schlichting, Boundary-Layer Theory), weighted by the
    laminar fraction (Raymer, section 12.5.3).
    """
    laminar, turbulent = 1.328 * reynolds**-0.5, 0.074 * reynolds**-0.2
    return laminar_fraction * laminar + (1.0 - laminar_fraction) * turbulent


def _body_form(slenderness: Value) -> Value:
    """Return a body's form factor ``1 + 60/f^3 + f/400``, f length over diameter: Raymer, 12.31."""
    return 1.0 + 60.0 / slenderness**3 + slenderness / 400.0


def _ellipsoid_m2(length_m: float, diameter_m: float) -> float:
    """Return the surface of an elongated ellipsoid of revolution [m2]."""
    slenderness = length_m / diameter_m
    eccentricity = (1.0 - slenderness**-2) ** 0.5
    stretched = slenderness / eccentricity * asin(eccentricity)
    return float(pi / 2.0 * diameter_m**2 * (1.0 + stretched))


class Pod(Record):
    """Pod or nacelle as an ellipsoid of revolution along the airspeed.

    ``wetted_area_m2`` of a pod replaces its diameter; if any pod has it, the surface of all pods is
    that of the structure's pod. ``interference`` is 1.3 for a body on the wing (Raymer, section
    12.5.5).
    """

    _above: ClassVar[Mapping[str, str]] = {"length_m": "diameter_m"}
    _either: ClassVar[Mapping[str, str]] = {"wetted_area_m2": "diameter_m"}

    length_m: PositiveReal
    diameter_m: PositiveReal | None = None
    wetted_area_m2: PositiveReal | None = None
    count: PositiveInteger = 1
    laminar_fraction: UnitInterval = 0.0
    interference: PositiveReal = 1.3

    @model_validator(mode="after")
    def _check_slender(self) -> Pod:
        if self.wetted_area_m2 is not None and self.wetted_area_m2 >= pi * self.length_m**2:
            most = spell(pi * self.length_m**2, 3)
            text = f"must be below {most} m², that of a ball of this length"
            raise wrong_value("wetted_area_m2", text, got=self.wetted_area_m2)
        return self

    @cached_property
    def thick_m(self) -> float:
        """Diameter, given or by the wetted area [m]."""
        if self.diameter_m is not None:
            return self.diameter_m
        assert self.wetted_area_m2 is not None
        area_m2, tolerance_m = self.wetted_area_m2, 1e-12 * self.length_m
        return bisect(
            self.length_m,
            0.0,
            lambda thick_m: _ellipsoid_m2(self.length_m, thick_m) < area_m2,
            lambda _: tolerance_m,
        )

    @property
    def volume_m3(self) -> float:
        """Volume of all these pods [m3]."""
        return float(self.count * pi / 6.0 * self.thick_m**2 * self.length_m)

    @property
    def wetted_m2(self) -> float:
        """Surface of all these pods [m2]."""
        return float(self.count * _ellipsoid_m2(self.length_m, self.thick_m))


class DragComponents(Record):
    """Components with drag besides the wing; sizes of tails and booms come from the tail.

    ``gaps_fraction`` is the drag of gaps at control surfaces, leaks and protuberances over the
    profile drag of wing and components (Raymer, section 12.5.7: 5 to 10 % for propeller aircraft).
    """

    pods: tuple[Pod, ...] = ()
    tail_laminar_fraction: UnitInterval = 0.5
    tail_interference: PositiveReal = 1.05
    boom_laminar_fraction: UnitInterval = 0.0
    boom_interference: PositiveReal = 1.0
    gaps_fraction: NonNegativeReal = 0.05

    @property
    def volume_m3(self) -> float:
        """Volume of all pods [m3]."""
        return sum(pod.volume_m3 for pod in self.pods)

    @property
    def built_m2(self) -> float | None:
        """Surface of all pods for the structure; None if no pod has a wetted area [m2]."""
        is_given = any(pod.wetted_area_m2 is not None for pod in self.pods)
        return sum(pod.wetted_m2 for pod in self.pods) if is_given else None

    def coefficients(
        self, wing: Wing, tail: Tail, structure: RibWingStructure, reynolds: Value
    ) -> dict[str, Value]:
        """Return the drag coefficients of tail planes, booms and pods on the wing area [-]."""
        planes, per_m, area_m2 = tail.planes(wing), reynolds / wing.mean_chord_m, wing.area_m2
        wetted = 1.977 + 0.52 * tail.thickness_ratio  # over the plane's area: Raymer, eq. 7.11
        plane = plane_form_factor(tail.thickness_ratio) * wetted
        plane = plane * self.tail_interference / area_m2
        sizes = {
            "horizontal_tail": (planes.horizontal_m2, planes.horizontal_chord_m),
            "vertical_tail": (planes.vertical_m2, planes.fin_chord_m),
        }
        parts = {
            name: plane * m2 * skin_friction(per_m * chord_m, self.tail_laminar_fraction)
            for name, (m2, chord_m) in sizes.items()
        }
        thick_m = structure.boom_diameter_chords * wing.mean_chord_m
        booms = structure.booms * pi * thick_m * planes.boom_m / area_m2
        booms = booms * self.boom_interference * _body_form(planes.boom_m / thick_m)
        booms = booms * skin_friction(per_m * planes.boom_m, self.boom_laminar_fraction)
        pods: Value = 0.0
        for pod in self.pods:
            factor = _body_form(pod.length_m / pod.thick_m) * pod.interference
            friction = skin_friction(per_m * pod.length_m, pod.laminar_fraction)
            pods = pods + friction * factor * pod.wetted_m2 / area_m2
        return parts | {"booms": booms, "pods": pods}


class DragShares(NamedTuple):
    """Drag coefficients of the parts on the wing area; their sum is the aircraft's [-].

    ``other``: constants of the file's polar. ``trim``: trim drag at the required static margin.
    """

    wing_profile: Value
    wing_induced: Value
    horizontal_tail: Value = 0.0
    vertical_tail: Value = 0.0
    booms: Value = 0.0
    pods: Value = 0.0
    gaps: Value = 0.0
    other: Value = 0.0
    trim: Value = 0.0

    @property
    def total(self) -> Value:
        """Sum of the parts."""
        return sum(self[1:], self[0])

    @property
    def parasitic(self) -> Value:
        """Drag of all parts but wing and trim [-]."""
        return sum(self[3:-1], self[2])
