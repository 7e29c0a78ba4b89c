"""Geometry of an aircraft as the models have it, and what is drawn where they have none.

Every length is from the aircraft's file, or by a rule that its structure model uses. What no model
has a number for is drawn by a proportion that is chosen here for its looks; a note says so.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np

from sizing.aircraft import Aircraft
from sizing.balance.surfaces import QUARTER, Tail, Wing, wing_of
from sizing.structures.rib_wing import RibWingStructure
from solar.geometry import ModuleGeometry
from solar.shading import TailGeometry
from studies.render.words import amount, given, percent

# The tail volumes of docs/structure.md: S_h = 0.35 c A/L and S_v = 0.045 c A/L with L = 4 c.
_RULE = RibWingStructure(model="rib_wing")
_HORIZONTAL_RATIO, _VERTICAL_RATIO = 5.0, 2.0  # aspect ratios of tail planes, for their looks
# Outlines that give the module area to this are those of this aircraft.
_AREA_TOLERANCE = 0.05
_TAIL_TOLERANCE = 0.1

Chords: TypeAlias = tuple[tuple[float, float], ...]


class Rectangle(NamedTuple):
    """Rectangle in the plan view: right of the symmetry plane, and behind the leading edge [m]."""

    left_m: float
    right_m: float
    front_m: float
    rear_m: float


class Drawing:
    """What is drawn of an aircraft; positions are from the leading edge of the wing root [m].

    ``wingspan_m``, ``chord_m``, ``thickness_ratio``: wing, its mean chord, and its section.
    ``chords``: places right of the middle, from root to tip, with the chord there as the models
    have it; its quarter line is straight. ``outline``: places along the wing with leading and
    trailing edge, as it is drawn. ``incidence_deg``: pitch of the chord line to the body [deg].
    ``dihedral_deg``, ``dihedral_from_m``: rise of the outer wing, and where it begins.
    ``modules``: solar modules, or every cell; ``modules_are``: which of both. ``tail``: tail planes
    and the height of the boom. ``booms_m``: places of the booms, each with a fin; ``boom_m``: their
    diameter. ``schematic``: parts that no model has numbers for: ``modules``, ``tail``, ``spar``,
    ``section``, ``pod``. ``notes``: where every part comes from.
    """

    def __init__(self, aircraft: Aircraft) -> None:
        airframe, modules = aircraft.airframe, aircraft.modules
        geometry, layout = modules.geometry, modules.layout
        structure = getattr(airframe, "structure", None)
        rib_wing = structure if isinstance(structure, RibWingStructure) else None
        rule = rib_wing or _RULE
        self.wingspan_m, self.thickness_ratio = airframe.wingspan_m, rule.thickness_ratio
        self.chord_m = airframe.wingspan_m / airframe.aspect_ratio
        self.boom_m = rule.boom_diameter_chords * self.chord_m
        planform = getattr(airframe, "planform", None)
        wing = wing_of(planform, airframe.wingspan_m, airframe.aspect_ratio)
        root_m, half_m = float(wing.root_chord_m), airframe.wingspan_m / 2.0
        self.chords: Chords = ((0.0, root_m), (half_m, root_m))
        wing_note = "Wing: a rectangle of wingspan and aspect ratio, as all models take it."
        if planform is not None:
            tip = half_m, planform.taper_ratio * root_m
            self.chords = ((0.0, root_m), (planform.inner_fraction * half_m, root_m), tip)
            wing_note = (
                "Wing: two panels of airframe.planform, the quarter chord straight; structure and "
                "Reynolds number have the mean chord."
            )
        elif layout is not None and layout.planform is not None:
            wing_note = (
                "Wing: modules.layout.planform and its mean chord; the models take a rectangle."
            )
        places = [y for y, _ in self.chords[1:]]
        places = [*(-y for y in reversed(places)), *places]
        edges = tuple((y, self.front_at(y), self.front_at(y) + self.chord_at(y)) for y in places)
        self.outline = edges if layout is None else tuple(layout.outline(aircraft.wing))
        self.incidence_deg = 0.0 if geometry is None else geometry.wing_incidence_deg
        self.dihedral_deg, self.dihedral_from_m = _dihedral(geometry, airframe.wingspan_m)
        self.tail, tail_note, tail_known = _tail(aircraft, wing, rib_wing)
        self.modules, modules_note, modules_known = _module_places(aircraft, self.chords)
        self.modules_are = "areas of solar modules" if layout is None else "solar cells"
        by_keys, side_m = getattr(airframe, "tail", None), self.tail.horizontal_span_m / 2.0
        twin = by_keys is not None and max(rule.booms, by_keys.fins) == 2
        self.booms_m = (-side_m, side_m) if twin else (0.0,)
        by_structure = rib_wing is not None
        parts = {"section": by_structure, "spar": by_structure}
        parts |= {"tail": tail_known, "modules": modules_known, "pod": False}
        self.schematic = frozenset(part for part, known in parts.items() if not known)
        section = "Spar line and section: schematic, no structure model of the file gives them."
        if rib_wing is not None:
            section = (
                f"Section {percent(rib_wing.thickness_ratio, 'g')} thick, boom of "
                f"{given(rib_wing.boom_diameter_chords)} chords and box spar: as the structure "
                "model has them, the spar at 30 % of the chord, where the section is thickest."
            )
        angles = [] if geometry else ["Dihedral and incidence: the file has none; drawn without."]
        pod_note = f"Nose and pod (dashed): schematic. {_propeller_note(aircraft)}"
        self.notes = [wing_note, modules_note, tail_note, section, *angles, pod_note]

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


def _propeller_note(aircraft: Aircraft) -> str:
    """Return why no propeller is drawn, and its diameter where the file has one."""
    if (propulsion := aircraft.propulsion_by_parts) is None:
        return "Propeller: not drawn, the file has no diameter."
    count, diameter_m = propulsion.propulsors, propulsion.propeller.propeller.diameter_m
    what = "Propeller" if count == 1 else f"{count} propellers"
    return (
        f"{what} of {amount(diameter_m, 'm', '.3g')} diameter: not drawn, no model has the place."
    )


def _tail(
    aircraft: Aircraft, wing: Wing, structure: RibWingStructure | None
) -> tuple[TailGeometry, str, bool]:
    """Return the tail, where it comes from, and whether a model has its numbers.

    That of ``airframe.tail``, else the one that shades the modules, unless the structure model of
    another wing has a tail of another size: that of a sized aircraft grows with its wing, while the
    file keeps that of the built one. Cells lie on the tail of the file, whatever the rule.
    """
    by_keys = getattr(aircraft.airframe, "tail", None)
    if by_keys is not None:
        note = "Tail: airframe.tail of the aircraft file; the booms end at its quarter chord."
        return _tail_geometry(by_keys, wing), note, True
    of_file, layout, rule = aircraft.modules.tail, aircraft.modules.layout, structure or _RULE
    wide, tall, hangs = _HORIZONTAL_RATIO, _VERTICAL_RATIO, False
    if of_file is not None:
        wide = of_file.horizontal_span_m / of_file.horizontal_chord_m
        tall = abs(of_file.vertical_height_m) / of_file.vertical_chord_m
        hangs = of_file.vertical_height_m < 0.0
    by_rule = Tail(
        arm_chords=rule.fuselage_chords,
        horizontal_volume=rule.horizontal_tail_ratio,
        vertical_volume=rule.vertical_tail_ratio / wing.aspect_ratio,
        horizontal_aspect_ratio=wide,
        vertical_aspect_ratio=tall,
    )
    rectangle = wing_of(None, wing.wingspan_m, wing.aspect_ratio)
    planes, tail = by_rule.planes(rectangle), _tail_geometry(by_rule, rectangle)
    if of_file is not None:
        ratio = of_file.horizontal_span_m * of_file.horizontal_chord_m / planes.horizontal_m2
        kept = structure is None or (layout is not None and layout.tail_cells)
        if kept or abs(ratio - 1.0) <= _TAIL_TOLERANCE:
            return of_file, "Tail: modules.tail of the aircraft file.", True
        on_top = None if of_file.horizontal_height_m is None else 0.0
        changes = {"horizontal_height_m": on_top}
        changes |= {"vertical_height_m": -tail.vertical_height_m} if hangs else {}
        tail = tail.model_copy(update=changes)
    horizontal, vertical = amount(planes.horizontal_m2, form=".3g"), planes.vertical_m2
    areas = (
        f"areas {horizontal} and {amount(vertical, 'm2', '.3g')}, {given(rule.fuselage_chords)} "
        "chords behind the wing"
    )
    if structure is None:
        return tail, f"Tail: schematic, by a common tail volume ({areas}).", False
    shape = "proportions schematic" if of_file is None else "proportions of modules.tail"
    note = f"Tail: by the rule of the structure model ({areas}); {shape}."
    return tail, note, of_file is not None


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


def _module_places(aircraft: Aircraft, chords: Chords) -> tuple[tuple[Rectangle, ...], str, bool]:
    """Return modules, where they come from, and whether the file has their places."""
    area_m2, airframe = aircraft.modules.area_m2, aircraft.airframe
    if aircraft.modules.layout is not None:
        cells = tuple(Rectangle(*cell) for cell in aircraft.placed_cells())
        return cells, f"Solar modules: {len(cells)} cells of modules.layout.", True
    outlines = _outlines(aircraft.modules.geometry)
    drawn_m2 = sum((m.right_m - m.left_m) * (m.rear_m - m.front_m) for m in outlines)
    half_m, chord_m = airframe.wingspan_m / 2.0, airframe.wingspan_m / airframe.aspect_ratio
    within = all(max(-m.left_m, m.right_m) <= half_m and m.rear_m <= chord_m for m in outlines)
    if outlines and within and abs(drawn_m2 - area_m2) <= _AREA_TOLERANCE * area_m2:
        return outlines, "Solar modules: the outlines of the aircraft file.", True
    if area_m2 == 0.0:
        return (), "Solar modules: none.", True
    of_another = "the file's outlines are those of another area"
    why = of_another if outlines else "the file has no outlines"
    note = f"Solar modules: {amount(area_m2, 'm2', '.3g')} as a band, schematic: {why}."
    return _band(chords, area_m2), note, False


def _outlines(geometry: ModuleGeometry | None) -> tuple[Rectangle, ...]:
    """Return the outlines of all modules; none where one of them has none."""
    outlines = []
    for surface in () if geometry is None else geometry.surfaces:
        if (outline := surface.outline) is None:
            return ()
        ends = outline.inboard_m, outline.outboard_m
        ends = (-ends[1], -ends[0]) if surface.side == "left" else ends
        outlines.append(Rectangle(*ends, outline.front_m, outline.rear_m))
    return tuple(outlines)


def _band(chords: Chords, area_m2: float) -> tuple[Rectangle, ...]:
    """Return modules as a rectangle on every panel, of the same share of it."""
    panels = [(a, b, (root + tip) / 2.0, tip) for (a, root), (b, tip) in pairwise(chords) if b > a]
    share = area_m2 / sum(2.0 * (b - a) * mean_m for a, b, mean_m, _ in panels)
    bands = []
    for inner, outer, mean_m, tip_m in panels:
        deep = min(share * mean_m, tip_m)
        front = QUARTER * (chords[0][1] - tip_m) + (tip_m - deep) / 2.0
        for ends in ((-outer, -inner), (inner, outer)):
            bands.append(Rectangle(*ends, front, front + deep))
    return tuple(bands)


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
