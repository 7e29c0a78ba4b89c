"""Geometry of an aircraft for AeroSandbox, AVL and OpenVSP.

AeroSandbox, the extra ``exchange``, writes the files of AVL and OpenVSP. AVL is Mark Drela's vortex
lattice code (Drela, M., and Youngren, H., AVL User Primer); its sections get the lift slope of thin
airfoils, 2 pi, as in this package's models.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sizing.aircraft import Aircraft
from solar.schema import spell
from studies.exchange.geometry import LiftingSurface, lifting_surfaces

if TYPE_CHECKING:
    import aerosandbox as asb

_SPANWISE, _CHORDWISE = 24, 8  # vortices of a surface
_NEUTRAL_SLOPE = 1.0  # factor on a section's slope of 2 pi


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
    asb = _library()
    surfaces = lifting_surfaces(aircraft, gravity_m)
    return asb.Airplane(
        name=_script_name(aircraft.name),
        xyz_ref=[surfaces.reference_x_m, 0.0, 0.0],
        wings=[_wing(surface) for surface in surfaces.surfaces],
        s_ref=surfaces.wing_area_m2,
        c_ref=surfaces.chord_m,
        b_ref=surfaces.wingspan_m,
        analysis_specific_options={
            asb.AVL: {"profile_drag_coefficient": surfaces.other_drag_coefficient}
        },
    )


def _library() -> Any:
    """Import AeroSandbox on demand, which takes seconds."""
    import aerosandbox

    return aerosandbox


def airplane_text(aircraft: Aircraft, file_format: str, gravity_m: float | None = None) -> str:
    """Return the text of a geometry file: ``avl``, ``vspscript``, or ``py`` for a script."""
    return _WRITERS[file_format](aircraft, gravity_m)


def _avl(aircraft: Aircraft, gravity_m: float | None) -> str:
    asb = _library()
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "wing.avl"
        asb.AVL(to_aerosandbox(aircraft, gravity_m), asb.OperatingPoint()).write_avl(target)
        text = target.read_text(encoding="utf-8")
        # AVL ignores camber without the airfoils' files in its folder: put coordinates in the text.
        for file in sorted(Path(folder).glob("wing.avl.*")):
            _, _, points = file.read_text(encoding="utf-8").partition("\n")
            text = text.replace(f"AFIL\n{file}\n", f"AIRFOIL\n{points.strip()}\n")
    return _commented(text, "!", lifting_surfaces(aircraft, gravity_m).notes)


def _vspscript(aircraft: Aircraft, gravity_m: float | None) -> str:
    with tempfile.TemporaryDirectory() as folder:
        airplane = to_aerosandbox(aircraft, gravity_m)
        text = airplane.export_OpenVSP_vspscript(Path(folder) / "wing.vspscript")
    return _commented(text, "//", lifting_surfaces(aircraft, gravity_m).notes)


def _script(aircraft: Aircraft, gravity_m: float | None) -> str:
    """Return a Python script that makes the airplane."""
    surfaces = lifting_surfaces(aircraft, gravity_m)
    lines = [
        f"# {note}"
        for note in (f"{_script_name(aircraft.name)}: wing and tail planes.", *surfaces.notes)
    ]
    lines += ["import aerosandbox as asb"]
    if any(surface.shape.airfoil is None for surface in surfaces.surfaces):
        families = "aerosandbox.geometry.airfoil.airfoil_families"
        lines += [f"from {families} import get_NACA_coordinates"]
    lines += ["", "wings = ["]
    for surface in surfaces.surfaces:
        lines += _wing_lines(surface)
    lines += [
        "]",
        "airplane = asb.Airplane(",
        f"    name={_script_name(aircraft.name)!r},",
        f"    xyz_ref=[{spell(surfaces.reference_x_m)}, 0.0, 0.0],",
        "    wings=wings,",
        f"    s_ref={spell(surfaces.wing_area_m2)},",
        f"    c_ref={spell(surfaces.chord_m)},",
        f"    b_ref={spell(surfaces.wingspan_m)},",
        ")",
    ]
    return "\n".join(lines) + "\n"


_WRITERS: dict[str, Callable[[Aircraft, float | None], str]] = {
    "avl": _avl,
    "vspscript": _vspscript,
    "py": _script,
}


def _wing_lines(surface: LiftingSurface) -> list[str]:
    shape = surface.shape
    airfoil = f"asb.Airfoil({shape.airfoil!r})"
    if shape.airfoil is None:
        numbers = f"max_camber=0.0, camber_loc=0.4, thickness={spell(shape.thickness_ratio)}"
        points = f"get_NACA_coordinates({numbers})"
        airfoil = f'asb.Airfoil("symmetric", coordinates={points})'
    lines = [
        "    asb.Wing(",
        f"        name={surface.name!r},",
        f"        symmetric={surface.symmetric},",
        "        xsecs=[",
    ]
    for x_m, y_m, z_m, chord_m, twist_deg in surface.sections:
        lines += [
            "            asb.WingXSec(",
            f"                xyz_le=[{spell(x_m)}, {spell(y_m)}, {spell(z_m)}],",
            f"                chord={spell(chord_m)},",
            f"                twist={spell(twist_deg)},",
            f"                airfoil={airfoil},",
            "            ),",
        ]
    return [*lines, "        ],", "    ),"]


def _wing(surface: LiftingSurface) -> asb.Wing:
    asb = _library()
    shape, (lift, drag) = surface.shape, surface.drag or ((-1.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    name, points = shape.airfoil, None
    if name is None:
        name = f"symmetric {spell(100.0 * shape.thickness_ratio)} %"
        coordinates = asb.geometry.airfoil.airfoil_families.get_NACA_coordinates
        points = coordinates(max_camber=0.0, camber_loc=0.4, thickness=shape.thickness_ratio)
    airfoil = asb.Airfoil(name, coordinates=points)
    polar = {f"CL{i}": value for i, value in enumerate(lift, 1)}
    options = {"drag_polar": polar | {f"CD{i}": value for i, value in enumerate(drag, 1)}}
    slope = {asb.AVL: {"cl_alpha_factor": _NEUTRAL_SLOPE, **options}}
    sections = [
        asb.WingXSec(
            xyz_le=[section.x_m, section.y_m, section.z_m],
            chord=section.chord_m,
            twist=section.twist_deg,
            airfoil=airfoil,
            analysis_specific_options=slope,
        )
        for section in surface.sections
    ]
    lattice = {"spanwise_resolution": _SPANWISE, "chordwise_resolution": _CHORDWISE, **options}
    return asb.Wing(
        name=surface.name,
        symmetric=surface.symmetric,
        xsecs=sections,
        analysis_specific_options={asb.AVL: lattice},
    )


def _commented(text: str, mark: str, lines: Sequence[str]) -> str:
    """Insert notes as comments, in AVL behind the title."""
    first, _, rest = text.partition("\n")
    notes = "".join(f"{mark} {note}\n" for note in lines)
    return f"{first}\n{notes}{rest}" if mark == "!" else f"{notes}{text}"


def _script_name(name: str) -> str:
    """Replace characters of a name that mean something in a script."""
    return re.sub(r"[^A-Za-z0-9 _.-]", "_", name).strip() or "aircraft"
