"""Lifting surfaces of an aircraft, as other aerodynamic tools describe them.

Axes as in AeroSandbox and AVL: x aft, y to the right, z up, from the leading edge of the wing root
[m]. The planform is this package's: a rectangle, or the panels of ``airframe.planform``, with
dihedral and incidence of the module geometry if there is one, and rectangular tail planes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sizing.aerodynamics.parabolic import UserDragPolar
from sizing.aerodynamics.wing_polar import WingPolar
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.balance.drag import BuiltUpPolar
from sizing.balance.in_design import polar_with_tail
from sizing.balance.surfaces import QUARTER, wing_of
from solar.schema import spell
from studies.report.geometry import Drawing

_TAIL_THICKNESS = 0.08  # as WingPolar's default, where the file has none


class Section(NamedTuple):
    """Section of a surface: its leading edge, chord [m] and twist, nose up [deg]."""

    x_m: float
    y_m: float
    z_m: float
    chord_m: float
    twist_deg: float


# Three ascending lift coefficients of a section, and their profile drag, as AVL takes them.
ProfileDrag = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True)
class LiftingSurface:
    """Wing or tail plane.

    ``symmetric``: the sections describe the right half alone. ``sections``: from root to tip, of an
    airfoil by its name, or symmetric with a thickness ratio.
    """

    name: str
    symmetric: bool
    sections: tuple[Section, ...]
    thickness_ratio: float
    airfoil: str | None = None
    drag: ProfileDrag | None = None


@dataclass(frozen=True)
class Surfaces:
    """Lifting surfaces, reference quantities of coefficients, and notes on sources.

    ``reference_x_m``: reference of moments, the centre of gravity, else the wing's quarter chord.
    ``chord_m``: mean aerodynamic chord.
    ``other_drag_coefficient``: drag of everything but the wing, on the wing area [-].
    """

    surfaces: tuple[LiftingSurface, ...]
    wing_area_m2: float
    chord_m: float
    wingspan_m: float
    reference_x_m: float
    other_drag_coefficient: float
    notes: tuple[str, ...]


def lifting_surfaces(aircraft: Aircraft, gravity_m: float | None = None) -> Surfaces:
    """Return wing and tail planes of an aircraft.

    ``gravity_m``: centre of gravity behind the leading edge of the wing root, None if unknown.
    """
    drawing = Drawing(aircraft)
    polar, thickness = getattr(aircraft.airframe, "aerodynamics", None), drawing.thickness_ratio
    airfoil, is_airfoil = None, isinstance(polar, WingPolar)
    why = "the table has no coordinates" if is_airfoil else "the file names none"
    shape_note = (
        f"Section: symmetric, {spell(100.0 * thickness)} % thick, as {why}: angles of attack count "
        "from zero lift."
    )
    if isinstance(polar, WingPolar) and polar.contents_read() is None:
        airfoil, shape_note = polar.airfoil, f"Section: {polar.airfoil}."
    profile_drag, other_drag = _drag(aircraft)
    # Sections at root, planform breaks, begin of the dihedral, and tip.
    half = drawing.wingspan_m / 2.0
    places = {0.0, half, *(y for y, _ in drawing.chords)}
    if drawing.dihedral_deg and 0.0 < drawing.dihedral_from_m < half:
        places.add(drawing.dihedral_from_m)
    sections = tuple(
        Section(
            drawing.front_at(y), y, drawing.height_m(y), drawing.chord_at(y), drawing.incidence_deg
        )
        for y in sorted(places)
    )
    wing = LiftingSurface("wing", True, sections, thickness, airfoil, profile_drag)
    notes = [
        drawing.notes[0],
        shape_note,
        *(note for note in drawing.notes if note.startswith(("Tail", "Dihedral"))),
        "Drag: profile drag of the wing, all else as a constant, from the file's drag polar."
        if wing.drag is not None
        else "Drag: induced drag alone, as the drag model of the user's own knows no parts."
        if isinstance(aircraft.airframe, ParametricAirframe)
        else "Drag: induced drag alone, as a measured aircraft has no drag polar.",
        "No fuselage, no control surfaces, no centre of gravity: the models have none."
        if gravity_m is None
        else f"Moments refer to the centre of gravity, {gravity_m:.4f} m behind the leading edge "
        "of the wing root. No fuselage, no control surfaces.",
    ]
    span, area_m2 = drawing.wingspan_m, drawing.wingspan_m * drawing.chord_m
    planform = getattr(aircraft.airframe, "planform", None)
    wing_chords = wing_of(planform, span, aircraft.airframe.aspect_ratio)
    quarter_m = QUARTER * drawing.chord_at(0.0)
    return Surfaces(
        surfaces=(wing, *_tail_surfaces(aircraft, drawing)),
        wing_area_m2=area_m2,
        chord_m=float(wing_chords.aerodynamic_chord_m),
        wingspan_m=span,
        reference_x_m=quarter_m if gravity_m is None else gravity_m,
        other_drag_coefficient=other_drag,
        notes=tuple(notes),
    )


def _tail_surfaces(aircraft: Aircraft, drawing: Drawing) -> list[LiftingSurface]:
    tail, sized = drawing.tail, getattr(aircraft.airframe, "tail", None)
    polar = getattr(aircraft.airframe, "aerodynamics", None)
    thickness = polar.tail_thickness_ratio if isinstance(polar, WingPolar) else _TAIL_THICKNESS
    thickness = thickness if sized is None else float(sized.thickness_ratio)
    half, height = 0.5 * tail.horizontal_span_m, tail.height_m
    horizontal = tuple(
        Section(tail.horizontal_aft_m, y, height, tail.horizontal_chord_m, 0.0) for y in (0.0, half)
    )
    root = tail.boom_height_m
    ends = sorted((root, root + tail.vertical_height_m))
    apart = max(drawing.booms_m)
    vertical = tuple(
        Section(tail.vertical_aft_m, apart, z, tail.vertical_chord_m, 0.0) for z in ends
    )
    return [
        LiftingSurface("horizontal tail", True, horizontal, thickness),
        LiftingSurface("vertical tail", apart > 0.0, vertical, thickness),
    ]


def _drag(aircraft: Aircraft) -> tuple[ProfileDrag | None, float]:
    """Return the wing section's profile drag, and the drag of all else on the wing area [-].

    None and 0 for measured aircraft or user-defined drag. Of a parabolic polar at its reference
    Reynolds number, for all lift; of a wing's polar at zero lift, least drag and stall, at the
    Reynolds number of level flight at the design point.
    """
    airframe = aircraft.airframe
    if not isinstance(airframe, ParametricAirframe) or isinstance(
        polar := airframe.aerodynamics, UserDragPolar
    ):
        return None, 0.0
    if isinstance(polar, WingPolar):
        at_lift = polar.flight_lift_coefficient
        reynolds = float(polar.design_reynolds * at_lift**-0.5)
        parts = polar.build_up(at_lift, polar.design_aspect_ratio, reynolds)
        other = polar.calibration * (parts.tail + parts.fuselage + parts.parasitic)
        lift = np.linspace(0.0, polar.section_lift_ratio * polar.maximum_lift_coefficient, 101)
        drags = polar.calibration * np.asarray(polar.polar.profile_drag(lift, reynolds))
        least = 1 + int(np.argmin(drags[1:-1]))
        low, middle, high = (float(drags[i]) for i in (0, least, -1))
        lifts = 0.0, float(lift[least]), float(lift[-1])
        profile: ProfileDrag = (lifts, (max(low, middle), middle, max(high, middle)))
    else:
        reynolds, other = polar.reference_reynolds, polar.parasitic_drag_coefficient
        drag, highest = polar.profile_drag_coefficient, polar.maximum_lift_coefficient
        profile = ((-highest, 0.0, highest), (drag, drag, drag))
    if airframe.drag is not None:
        built = polar_with_tail(airframe, polar, airframe.wingspan_m, airframe.aspect_ratio)
        assert isinstance(built, BuiltUpPolar)
        other = built.shares(reynolds).parasitic
    return profile, float(other)
