"""Geometry of an aircraft as the models have it, and what is drawn where they have none.

Every length is from the aircraft's file, or by a rule that its structure model uses. What no model
has a number for is drawn by a proportion that is chosen here for its looks; a note says so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from sizing.aircraft import Aircraft, MeasuredAirframe, ParametricAirframe
from sizing.balance.surfaces import QUARTER, Tail, Wing, wing_of
from sizing.structures.rib_wing import RibWingStructure
from solar.geometry import ModuleGeometry
from solar.shading import TailGeometry

# The tail volumes of docs/structure.md: S_h = 0.35 c A/L and S_v = 0.045 c A/L with L = 4 c.
_RULE = RibWingStructure(model="rib_wing")
# Looks alone: aspect ratios of tail planes, the place of the spar, nose and pod in chords.
_HORIZONTAL_RATIO, _VERTICAL_RATIO = 5.0, 2.0
_NOSE_CHORDS, _POD_CHORDS, _POD_DEPTH_CHORDS = 0.7, 1.5, 0.32
_SPAR_CHORD_FRACTION = 0.3  # where a section is thickest, as in the rib wing's model
# Outlines that give the module area to this are those of this aircraft.
_AREA_TOLERANCE = 0.05
_TAIL_TOLERANCE = 0.1


@dataclass(frozen=True)
class Drawing:
    """What is drawn of an aircraft; positions are from the leading edge of the wing root [m].

    ``wingspan_m``, ``chord_m``, ``thickness_ratio``: wing, a rectangle, and its section.
    ``incidence_deg``: pitch of the chord line to the body [deg]. ``dihedral_deg``,
    ``dihedral_from_m``: rise of the outer wing, and where it begins. ``spar_m``: spar behind the
    leading edge. ``modules``: solar modules on the wing, or every cell; ``modules_are``: which of
    both. ``outline``: places along the wing with leading and trailing edge. ``tail``: tail
    planes and the height of the boom. ``nose_m``, ``pod_m``, ``pod_depth_m``, ``boom_m``: nose
    ahead of the leading edge, length and depth of the pod, diameter of the boom. ``schematic``:
    parts that no model has numbers for: ``modules``, ``tail``, ``spar``, ``section``, ``pod``.
    ``notes``: where every part comes from. ``chords``: places right of the middle, from root to
    tip, with the chord there as the models have it; its quarter line is straight. ``booms_m``:
    places of the booms, each with a fin.
    """

    wingspan_m: float
    chord_m: float
    thickness_ratio: float
    incidence_deg: float
    dihedral_deg: float
    dihedral_from_m: float
    spar_m: float
    modules: tuple[Rectangle, ...]
    modules_are: str
    outline: tuple[tuple[float, float, float], ...]
    tail: TailGeometry
    nose_m: float
    pod_m: float
    pod_depth_m: float
    boom_m: float
    schematic: frozenset[str]
    notes: tuple[str, ...]
    chords: tuple[tuple[float, float], ...]
    booms_m: tuple[float, ...] = (0.0,)

    def chord_at(self, right_m: float) -> float:
        """Return the chord of the wing at a place of the span [m]."""
        places, chords = zip(*self.chords, strict=True)
        return float(np.interp(abs(right_m), places, chords))

    def front_at(self, right_m: float) -> float:
        """Return the leading edge behind that of the root at a place of the span [m]."""
        return QUARTER * (self.chord_at(0.0) - self.chord_at(right_m))

    @property
    def tail_end_m(self) -> float:
        """Rearmost point of the tail."""
        tail = self.tail
        return max(
            tail.horizontal_aft_m + tail.horizontal_chord_m,
            tail.vertical_aft_m + tail.vertical_chord_m,
        )

    def height_m(self, right_m: float) -> float:
        """Return the height of the wing over its root at a place of the span [m]."""
        rise = max(abs(right_m) - self.dihedral_from_m, 0.0)
        return rise * math.tan(math.radians(self.dihedral_deg))


def aircraft_drawing(aircraft: Aircraft) -> Drawing:
    """Return what is drawn of an aircraft."""
    airframe, geometry = aircraft.airframe, aircraft.modules.geometry
    span_m = airframe.wingspan_m
    chord_m = span_m / airframe.aspect_ratio
    structure = airframe.structure if isinstance(airframe, ParametricAirframe) else None
    rib_wing = structure if isinstance(structure, RibWingStructure) else None
    rule = rib_wing or _RULE
    layout = aircraft.modules.layout
    # Cells lie on the tail of the file, whatever size a rule gives it.
    sizing_rule = None if layout is not None and layout.tail_cells else rib_wing
    balanced = balanced_surfaces(airframe)
    if balanced.tail is None:
        tail, tail_note, tail_known = _tail(aircraft.modules.tail, sizing_rule, span_m, chord_m)
    else:
        tail, tail_known = balanced.tail, True
        tail_note = "Tail: airframe.tail of the aircraft file; the booms end at its quarter chord."
    modules, modules_note, modules_known = _module_places(aircraft, span_m, chord_m)
    if not modules_known and balanced.tapered:
        modules = tapered_band(balanced.chords, aircraft.modules.area_m2)
    dihedral_deg, from_m = _dihedral(geometry, span_m)
    notes = [
        balanced.wing_note
        if layout is None or layout.planform is None or balanced.tapered
        else "Wing: modules.layout.planform and its mean chord; the models take a rectangle.",
        modules_note,
        tail_note,
    ]
    if rib_wing is None:
        notes.append("Spar line and section: schematic, no structure model of the file gives them.")
    else:
        notes.append(
            f"Section {100.0 * rib_wing.thickness_ratio:g} % thick, boom of "
            f"{rib_wing.boom_diameter_chords:g} chords and box spar: as the structure model has "
            "them, the spar at 30 % of the chord, where the section is thickest."
        )
    if geometry is None:
        notes.append("Dihedral and incidence: the file has none; drawn without.")
    notes.append(f"Nose and pod (dashed): schematic. {_propeller_note(aircraft)}")
    schematic = {"pod"} | ({"section", "spar"} if rib_wing is None else set())
    schematic |= (set() if tail_known else {"tail"}) | (set() if modules_known else {"modules"})
    return Drawing(
        wingspan_m=span_m,
        chord_m=chord_m,
        thickness_ratio=rule.thickness_ratio,
        incidence_deg=0.0 if geometry is None else geometry.wing_incidence_deg,
        dihedral_deg=dihedral_deg,
        dihedral_from_m=from_m,
        spar_m=_SPAR_CHORD_FRACTION * chord_m,
        modules=modules,
        modules_are="areas of solar modules" if layout is None else "solar cells",
        outline=balanced.outline if layout is None else tuple(layout.outline(aircraft.wing)),
        tail=tail,
        nose_m=_NOSE_CHORDS * chord_m,
        pod_m=(_NOSE_CHORDS + _POD_CHORDS) * chord_m,
        pod_depth_m=_POD_DEPTH_CHORDS * chord_m,
        boom_m=rule.boom_diameter_chords * chord_m,
        schematic=frozenset(schematic),
        notes=tuple(notes),
        chords=balanced.chords,
        booms_m=balanced.booms_m,
    )


def _propeller_note(aircraft: Aircraft) -> str:
    """Return why no propeller is drawn, and its diameter where the file has one."""
    if (propulsion := aircraft.propulsion_by_parts) is None:
        return "Propeller: not drawn, the file has no diameter."
    count, diameter_m = propulsion.propulsors, propulsion.propeller.propeller.diameter_m
    what = "Propeller" if count == 1 else f"{count} propellers"
    return f"{what} of {diameter_m:.3g} m diameter: not drawn, no model has the place."


def _tail(
    of_file: TailGeometry | None, structure: RibWingStructure | None, span_m: float, chord_m: float
) -> tuple[TailGeometry, str, bool]:
    """Return the tail, where it comes from, and whether a model has its numbers.

    The file's own, unless the structure model of another wing has a tail of another size: that of a
    sized aircraft grows with its wing, while the file keeps that of the built one.
    """
    rule = structure or _RULE
    arm_m = rule.fuselage_chords * chord_m
    volume = chord_m * span_m * chord_m / arm_m
    horizontal_m2, vertical_m2 = (
        rule.horizontal_tail_ratio * volume,
        rule.vertical_tail_ratio * volume,
    )
    if of_file is not None:
        ratio = of_file.horizontal_span_m * of_file.horizontal_chord_m / horizontal_m2
        if structure is None or abs(ratio - 1.0) <= _TAIL_TOLERANCE:
            return of_file, "Tail: modules.tail of the aircraft file.", True
    tall = (
        _VERTICAL_RATIO if of_file is None else of_file.vertical_height_m / of_file.vertical_chord_m
    )
    wide = (
        _HORIZONTAL_RATIO
        if of_file is None
        else of_file.horizontal_span_m / of_file.horizontal_chord_m
    )
    chord_h, chord_v = (horizontal_m2 / wide) ** 0.5, (vertical_m2 / abs(tall)) ** 0.5
    on_top = of_file is None or of_file.horizontal_height_m is None
    tail = TailGeometry(
        horizontal_span_m=wide * chord_h,
        horizontal_chord_m=chord_h,
        horizontal_aft_m=arm_m + 0.25 * (chord_m - chord_h),
        vertical_height_m=tall * chord_v,
        vertical_chord_m=chord_v,
        vertical_aft_m=arm_m + 0.25 * (chord_m - chord_v),
        horizontal_height_m=0.0 if of_file is None or not on_top else None,
    )
    areas = (
        f"areas {horizontal_m2:.3g} and {vertical_m2:.3g} m², {rule.fuselage_chords:g} chords "
        "behind the wing"
    )
    if structure is None:
        return tail, f"Tail: schematic, by a common tail volume ({areas}).", False
    shape = "proportions schematic" if of_file is None else "proportions of modules.tail"
    return (
        tail,
        f"Tail: by the rule of the structure model ({areas}); {shape}.",
        of_file is not None,
    )


def _module_places(
    aircraft: Aircraft, span_m: float, chord_m: float
) -> tuple[tuple[Rectangle, ...], str, bool]:
    """Return modules, where they come from, and whether the file has their places."""
    area_m2, geometry = aircraft.modules.area_m2, aircraft.modules.geometry
    if aircraft.modules.layout is not None:
        cells = tuple(Rectangle(*cell) for cell in aircraft.placed_cells())
        return cells, f"Solar modules: {len(cells)} cells of modules.layout.", True
    outlines = _outlines(geometry)
    drawn_m2 = sum((m.right_m - m.left_m) * (m.rear_m - m.front_m) for m in outlines)
    fits = (
        bool(outlines)
        and abs(drawn_m2 - area_m2) <= _AREA_TOLERANCE * area_m2
        and all(max(-m.left_m, m.right_m) <= span_m / 2.0 and m.rear_m <= chord_m for m in outlines)
    )
    if fits:
        return outlines, "Solar modules: the outlines of the aircraft file.", True
    if area_m2 == 0.0:
        return (), "Solar modules: none.", True
    share = min(area_m2 / (span_m * chord_m), 1.0)
    along = max(0.98, share) * span_m / 2.0
    deep = area_m2 / (2.0 * along)
    front = (chord_m - deep) / 2.0
    band = (Rectangle(-along, 0.0, front, front + deep), Rectangle(0.0, along, front, front + deep))
    why = (
        "the file's outlines are those of another area" if outlines else "the file has no outlines"
    )
    return band, f"Solar modules: {area_m2:.3g} m² as a band, schematic: {why}.", False


def _outlines(geometry: ModuleGeometry | None) -> tuple[Rectangle, ...]:
    """Return the outlines of all modules; none where one of them has none."""
    outlines = []
    for surface in () if geometry is None else geometry.surfaces:
        outline = surface.outline
        if outline is None:
            return ()
        left, right = outline.inboard_m, outline.outboard_m
        if surface.side == "left":
            left, right = -right, -left
        outlines.append(Rectangle(left, right, outline.front_m, outline.rear_m))
    return tuple(outlines)


def _dihedral(geometry: ModuleGeometry | None, span_m: float) -> tuple[float, float]:
    """Return the dihedral of the outer wing [deg], and where it begins [m]."""
    outer = [s for s in (() if geometry is None else geometry.surfaces) if s.side != "centre"]
    if not outer:
        return 0.0, span_m / 2.0
    angle = sum(s.dihedral_deg * s.area_m2 for s in outer) / sum(s.area_m2 for s in outer)
    known = [s.outline for s in outer if s.outline is not None]
    if not known:
        return angle, span_m / 6.0
    begins, ends = min(o.inboard_m for o in known), max(o.outboard_m for o in known)
    return angle, begins if ends <= span_m / 2.0 <= 1.1 * ends else begins / ends * span_m / 2.0


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
    """Return the surfaces of an airframe; without keys a rectangle and no tail."""
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
    """Return tail planes as rectangles with their quarter chords at their arms."""
    planes = tail.planes(wing)
    aft_m, fins_m = (float(wing.quarter_m + arm) for arm in (planes.arm_m, planes.vertical_arm_m))
    return TailGeometry(
        horizontal_span_m=float(planes.horizontal_span_m),
        horizontal_chord_m=float(planes.horizontal_chord_m),
        horizontal_aft_m=aft_m - QUARTER * float(planes.horizontal_chord_m),
        vertical_height_m=float(planes.fin_height_m),
        vertical_chord_m=float(planes.fin_chord_m),
        vertical_aft_m=fins_m - QUARTER * float(planes.fin_chord_m),
        horizontal_height_m=float(tail.horizontal_height_m),
    )


def tapered_band(chords: tuple[tuple[float, float], ...], area_m2: float) -> tuple[Rectangle, ...]:
    """Return modules as a rectangle on every panel, of the same share of it."""
    panels = list(pairwise(chords))
    wing_m2 = sum(
        (out - into) * (chord_m + next_chord_m) for (into, chord_m), (out, next_chord_m) in panels
    )
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
