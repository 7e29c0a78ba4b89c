"""Wing and tail planes of an aircraft's file that has a planform or a tail, for drawings."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

from sizing.aircraft import MeasuredAirframe, ParametricAirframe
from sizing.balance.surfaces import QUARTER, Tail, Wing, wing_of
from sizing.structures.rib_wing import RibWingStructure
from solar.shading import TailGeometry


class Rectangle(NamedTuple):
    """Rectangle in the plan view: right of the symmetry plane, and behind the leading edge [m]."""

    left_m: float
    right_m: float
    front_m: float
    rear_m: float


class BalancedSurfaces(NamedTuple):
    """What the keys of balance and trim say of the surfaces.

    ``chords``: places right of the middle, from root to tip, with the chord there [m]. ``tail``:
    none where the file has no ``airframe.tail``. ``booms_m``: places of the booms, each with a fin
    where there are two.
    """

    chords: tuple[tuple[float, float], ...]
    tail: TailGeometry | None
    booms_m: tuple[float, ...]
    wing_note: str

    @property
    def outline(self) -> tuple[tuple[float, float, float], ...]:
        """Wing from left to right: place, leading and trailing edge [m]."""
        root_m = self.chords[0][1]
        right = [(y, QUARTER * (root_m - c)) for y, c in self.chords[1:]]
        edges = [(y, x, x + c) for (y, x), (_, c) in zip(right, self.chords[1:], strict=True)]
        return (*((-y, front, rear) for y, front, rear in reversed(edges)), *edges)

    @property
    def tapered(self) -> bool:
        """Whether the wing is no rectangle."""
        return len(self.chords) > 2


def balanced_surfaces(airframe: MeasuredAirframe | ParametricAirframe) -> BalancedSurfaces:
    """Surfaces of an airframe; a rectangle without a tail where the file says nothing of them."""
    parametric = airframe if isinstance(airframe, ParametricAirframe) else None
    planform = None if parametric is None else parametric.planform
    half_m = airframe.wingspan_m / 2.0
    wing = wing_of(planform, airframe.wingspan_m, airframe.aspect_ratio)
    root_m = float(wing.root_chord_m)
    chords: tuple[tuple[float, float], ...] = ((0.0, root_m), (half_m, root_m))
    note = "Wing: a rectangle of wingspan and aspect ratio, as all models take it."
    if planform is not None:
        ends = ((planform.inner_fraction * half_m, root_m), (half_m, planform.taper_ratio * root_m))
        chords = ((0.0, root_m), *ends)
        note = (
            "Wing: two panels of airframe.planform, the quarter chord straight; structure and "
            "Reynolds number have the mean chord."
        )
    tail = None if parametric is None else parametric.tail
    if parametric is None or tail is None:
        return BalancedSurfaces(chords, None, (0.0,), note)
    assert isinstance(parametric.structure, RibWingStructure)  # others are refused at validation
    planes = tail.planes(wing)
    apart_m = float(planes.horizontal_span_m) / 2.0
    booms = (-apart_m, apart_m) if max(parametric.structure.booms, tail.fins) == 2 else (0.0,)
    return BalancedSurfaces(chords, _tail_geometry(tail, wing), booms, note)


def _tail_geometry(tail: Tail, wing: Wing) -> TailGeometry:
    """Tail planes as rectangles with their quarter chords at the arm; fins upwards."""
    planes = tail.planes(wing)
    aft_m = float(wing.quarter_m + planes.arm_m)
    return TailGeometry(
        horizontal_span_m=float(planes.horizontal_span_m),
        horizontal_chord_m=float(planes.horizontal_chord_m),
        horizontal_aft_m=aft_m - QUARTER * float(planes.horizontal_chord_m),
        vertical_height_m=float(planes.fin_height_m),
        vertical_chord_m=float(planes.fin_chord_m),
        vertical_aft_m=aft_m - QUARTER * float(planes.fin_chord_m),
        horizontal_height_m=float(tail.horizontal_height_m),
    )


def tapered_band(chords: tuple[tuple[float, float], ...], area_m2: float) -> tuple[Rectangle, ...]:
    """Modules as a rectangle on every panel, of the same share of it; schematic."""
    panels = list(pairwise(chords))
    wing_m2 = sum((out - into) * (one + other) for (into, one), (out, other) in panels)
    bands = []
    for (into, root_m), (out, tip_m) in panels:
        if out == into:
            continue
        deep = min(area_m2 / wing_m2 * (root_m + tip_m) / 2.0, tip_m)
        front = QUARTER * (chords[0][1] - tip_m) + (tip_m - deep) / 2.0
        bands += [
            Rectangle(-out, -into, front, front + deep),
            Rectangle(into, out, front, front + deep),
        ]
    return tuple(bands)
