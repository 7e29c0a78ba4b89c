"""Geometry of an aircraft for AeroSandbox, AVL and OpenVSP.

AeroSandbox, the extra ``exchange``, writes the files of AVL and OpenVSP. AVL is Mark Drela's vortex
lattice code (Drela, M., and Youngren, H., AVL User Primer); its sections get the lift slope of thin
airfoils, 2 pi, as in this package's models.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from textwrap import indent
from typing import TYPE_CHECKING, Any

import numpy as np

from sizing.aerodynamics.parabolic import UserDragPolar
from sizing.aerodynamics.wing_polar import WingPolar
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.balance.in_design import drag_by_parts
from sizing.balance.surfaces import QUARTER, wing_of
from solar.schema import spell
from studies.report.geometry import Drawing

if TYPE_CHECKING:
    import aerosandbox as asb

_SPANWISE, _CHORDWISE = 24, 8  # vortices of a surface
_NEUTRAL_SLOPE = 1.0  # factor on a section's slope of 2 pi
_TAIL_THICKNESS = 0.08  # as WingPolar's default, where the file has none


# Three ascending lift coefficients of a section, and their profile drag, as AVL takes them.
ProfileDrag = tuple[tuple[float, float, float], tuple[float, float, float]]
# Leading edge [m], chord [m] and twist, nose up [deg], of a section of a wing or tail plane.
Section = tuple[list[float], float, float]


def _notes(aircraft: Aircraft, drawing: Drawing, gravity_m: float | None) -> list[str]:
    """Return where the numbers come from."""
    airfoil, thickness = _airfoil(aircraft), spell(100.0 * drawing.thickness_ratio)
    is_table = isinstance(getattr(aircraft.airframe, "aerodynamics", None), WingPolar)
    why = "the table has no coordinates" if is_table else "the file names none"
    return [
        drawing.notes[0],
        f"Section: symmetric, {thickness} % thick, as {why}: angles of attack count from zero lift."
        if airfoil is None
        else f"Section: {airfoil}.",
        *(note for note in drawing.notes if note.startswith(("Tail", "Dihedral"))),
        "Drag: profile drag of the wing, all else as a constant, from the file's drag polar."
        if _drag(aircraft)[0] is not None
        else "Drag: induced drag alone, as the drag model of the user's own knows no parts."
        if isinstance(aircraft.airframe, ParametricAirframe)
        else "Drag: induced drag alone, as a measured aircraft has no drag polar.",
        "No fuselage, no control surfaces, no centre of gravity: the models have none."
        if gravity_m is None
        else f"Moments refer to the centre of gravity, {gravity_m:.4f} m behind the leading edge "
        "of the wing root. No fuselage, no control surfaces.",
    ]


def _airfoil(aircraft: Aircraft) -> str | None:
    """Return the name of the wing's airfoil, where it is one with known coordinates."""
    polar = getattr(aircraft.airframe, "aerodynamics", None)
    if isinstance(polar, WingPolar) and polar.contents_read() is None:
        return polar.airfoil
    return None


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
        _, _, other = polar.parts(polar.design_aspect_ratio, reynolds)
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
        wing = wing_of(airframe.planform, airframe.wingspan_m, airframe.aspect_ratio)
        shares = drag_by_parts(airframe, polar, wing, reynolds)
        assert shares is not None
        other = shares.parasitic
    return profile, float(other)


def missing_library() -> str | None:
    """Return the missing library and how to install it, None if installed."""
    if find_spec("aerosandbox") is not None:
        return None
    return "needs AeroSandbox: pip install aerosandbox (the extra 'exchange')"


def to_aerosandbox(aircraft: Aircraft, gravity_m: float | None = None) -> asb.Airplane:
    """Convert wing and tail planes to an airplane of AeroSandbox, in its axes and units.

    Parameters
    ----------
    aircraft : Aircraft
        Parametric or measured; the wing gets a symmetric section if AeroSandbox's database lacks
        its airfoil.
    gravity_m : float, optional
        Centre of gravity behind the leading edge of the wing root [m], such as
        ``analysis.balance.gravity_m``.

    Returns
    -------
    aerosandbox.Airplane
        With the reference quantities of the models, about the centre of gravity, or without it
        about the quarter chord of the wing.

    Raises
    ------
    ImportError
        Without AeroSandbox.
    """
    missing = missing_library()
    if missing is not None:
        raise ImportError(missing)
    import aerosandbox  # which takes seconds

    airplane: asb.Airplane = _airplane(aerosandbox, aircraft, Drawing(aircraft), gravity_m)
    return airplane


def _airplane(asb: Any, aircraft: Aircraft, drawing: Drawing, gravity_m: float | None) -> Any:
    """Make the airplane; ``asb``: AeroSandbox, or what writes its calls.

    Moments refer to the centre of gravity, else to the quarter chord; drag of all but the wing is
    on the wing area.
    """
    airframe, tail, span_m = aircraft.airframe, drawing.tail, drawing.wingspan_m
    chords = wing_of(getattr(airframe, "planform", None), span_m, airframe.aspect_ratio)
    profile_drag, other_drag = _drag(aircraft)
    # Sections at root, planform breaks, begin of the dihedral, and tip.
    places = {0.0, span_m / 2.0, *(y for y, _ in drawing.chords)}
    if drawing.dihedral_deg and 0.0 < drawing.dihedral_from_m < span_m / 2.0:
        places.add(drawing.dihedral_from_m)
    wing: list[Section] = [
        (
            [drawing.front_at(y), y, drawing.height_m(y)],
            drawing.chord_at(y),
            drawing.incidence_deg,
        )
        for y in sorted(places)
    ]
    polar, sized = getattr(airframe, "aerodynamics", None), getattr(airframe, "tail", None)
    thickness = polar.tail_thickness_ratio if isinstance(polar, WingPolar) else _TAIL_THICKNESS
    thickness = thickness if sized is None else float(sized.thickness_ratio)
    horizontal: list[Section] = [
        ([tail.horizontal_aft_m, y, tail.height_m], tail.horizontal_chord_m, 0.0)
        for y in (0.0, 0.5 * tail.horizontal_span_m)
    ]
    root_m, apart_m = tail.boom_height_m, max(drawing.booms_m)
    vertical: list[Section] = [
        ([tail.vertical_aft_m, apart_m, z], tail.vertical_chord_m, 0.0)
        for z in sorted((root_m, root_m + tail.vertical_height_m))
    ]
    reference_m = QUARTER * drawing.chord_at(0.0) if gravity_m is None else gravity_m
    return asb.Airplane(
        name=_script_name(aircraft.name),
        xyz_ref=[reference_m, 0.0, 0.0],
        wings=[
            _wing(
                asb, "wing", wing, drawing.thickness_ratio, _airfoil(aircraft), drag=profile_drag
            ),
            _wing(asb, "horizontal tail", horizontal, thickness),
            _wing(asb, "vertical tail", vertical, thickness, symmetric=apart_m > 0.0),
        ],
        s_ref=span_m * drawing.chord_m,
        c_ref=float(chords.aerodynamic_chord_m),
        b_ref=span_m,
        **_for_avl(asb, profile_drag_coefficient=other_drag),
    )


def _wing(
    asb: Any,
    name: str,
    sections: Sequence[Section],
    thickness: float,
    airfoil_name: str | None = None,
    *,
    symmetric: bool = True,
    drag: ProfileDrag | None = None,
) -> Any:
    """Make a wing or tail plane of sections from root to tip, of its right half if symmetric."""
    lifts, drags = drag or ((-1.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    polar = {f"CL{i}": value for i, value in enumerate(lifts, 1)}
    polar |= {f"CD{i}": value for i, value in enumerate(drags, 1)}
    if airfoil_name is not None:
        airfoil = asb.Airfoil(airfoil_name)
    else:
        coordinates = asb.geometry.airfoil.airfoil_families.get_NACA_coordinates
        points = coordinates(max_camber=0.0, camber_loc=0.4, thickness=thickness)
        airfoil = asb.Airfoil(f"symmetric {spell(100.0 * thickness)} %", coordinates=points)
    of_section = _for_avl(asb, cl_alpha_factor=_NEUTRAL_SLOPE, drag_polar=polar)
    lattice = {"spanwise_resolution": _SPANWISE, "chordwise_resolution": _CHORDWISE}
    return asb.Wing(
        name=name,
        symmetric=symmetric,
        xsecs=[
            asb.WingXSec(xyz_le=place, chord=chord, twist=twist, airfoil=airfoil, **of_section)
            for place, chord, twist in sections
        ],
        **_for_avl(asb, **lattice, drag_polar=polar),
    )


def _for_avl(asb: Any, **options: Any) -> dict[str, Any]:
    """Return what AVL alone is told, which a script leaves out."""
    told = not isinstance(asb, _Script)
    return {"analysis_specific_options": {asb.AVL: options}} if told else {}


def airplane_text(aircraft: Aircraft, file_format: str, gravity_m: float | None = None) -> str:
    """Return the text of a geometry file: ``avl``, ``vspscript``, or ``py`` for a script."""
    drawing = Drawing(aircraft)
    notes = _notes(aircraft, drawing, gravity_m)
    if file_format == "py":
        head = f"{_script_name(aircraft.name)}: wing and tail planes."
        made = _airplane(_Script("asb"), aircraft, drawing, gravity_m)
        text = f"import aerosandbox as asb\n\nairplane = {made}\n"
        return _commented(text, "#", (head, *notes))
    airplane = to_aerosandbox(aircraft, gravity_m)
    import aerosandbox as asb

    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / f"wing.{file_format}"
        if file_format == "vspscript":
            return _commented(airplane.export_OpenVSP_vspscript(target), "//", notes)
        asb.AVL(airplane, asb.OperatingPoint()).write_avl(target)
        text = target.read_text(encoding="utf-8")
        # AVL ignores camber without the airfoils' files in its folder: put coordinates in the text.
        for file in sorted(Path(folder).glob("wing.avl.*")):
            _, _, points = file.read_text(encoding="utf-8").partition("\n")
            text = text.replace(f"AFIL\n{file}\n", f"AIRFOIL\n{points.strip()}\n")
    return _commented(text, "!", notes)


class _Text(str):
    """A call as it stands in a script."""


class _Script:
    """AeroSandbox as its calls are written in a script, instead of made."""

    def __init__(self, path: str) -> None:
        self._path = path

    def __getattr__(self, name: str) -> _Script:
        return _Script(f"{self._path}.{name}")

    def __call__(self, *values: Any, **options: Any) -> _Text:
        every = [*map(_written, values), *(f"{k}={_written(v)}" for k, v in options.items())]
        lines = ",\n".join(every)
        return _Text(f"{self._path}(\n{indent(lines, '    ')},\n)")


def _written(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_written, value))}]"
    if isinstance(value, _Text):
        return value
    return spell(value) if isinstance(value, float) else repr(value)


def _commented(text: str, mark: str, lines: Sequence[str]) -> str:
    """Insert notes as comments, in AVL behind the title."""
    first, _, rest = text.partition("\n")
    notes = "".join(f"{mark} {note}\n" for note in lines)
    return f"{first}\n{notes}{rest}" if mark == "!" else f"{notes}{text}"


def _script_name(name: str) -> str:
    """Replace characters of a name that mean something in a script."""
    return re.sub(r"[^A-Za-z0-9 _.-]", "_", name).strip() or "aircraft"
