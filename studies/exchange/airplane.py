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
    airplane: asb.Airplane = _airplane(_library(), aircraft, gravity_m)
    return airplane


def _airplane(asb: Any, aircraft: Aircraft, gravity_m: float | None) -> Any:
    """Make the airplane; ``asb``: AeroSandbox, or what writes its calls."""
    surfaces = lifting_surfaces(aircraft, gravity_m)
    return asb.Airplane(
        name=_script_name(aircraft.name),
        xyz_ref=[surfaces.reference_x_m, 0.0, 0.0],
        wings=[_wing(asb, surface) for surface in surfaces.surfaces],
        s_ref=surfaces.wing_area_m2,
        c_ref=surfaces.chord_m,
        b_ref=surfaces.wingspan_m,
        **_for_avl(asb, profile_drag_coefficient=surfaces.other_drag_coefficient),
    )


def _wing(asb: Any, surface: LiftingSurface) -> Any:
    lift, drag = surface.drag or ((-1.0, 0.0, 1.0), (0.0, 0.0, 0.0))
    polar = {f"CL{i}": value for i, value in enumerate(lift, 1)}
    polar |= {f"CD{i}": value for i, value in enumerate(drag, 1)}
    if surface.airfoil is not None:
        airfoil = asb.Airfoil(surface.airfoil)
    else:
        coordinates = asb.geometry.airfoil.airfoil_families.get_NACA_coordinates
        thickness = surface.thickness_ratio
        points = coordinates(max_camber=0.0, camber_loc=0.4, thickness=thickness)
        name = f"symmetric {spell(100.0 * thickness)} %"
        airfoil = asb.Airfoil(name, coordinates=points)
    of_section = _for_avl(asb, cl_alpha_factor=_NEUTRAL_SLOPE, drag_polar=polar)
    sections = [
        asb.WingXSec(
            xyz_le=[section.x_m, section.y_m, section.z_m],
            chord=section.chord_m,
            twist=section.twist_deg,
            airfoil=airfoil,
            **of_section,
        )
        for section in surface.sections
    ]
    lattice = {"spanwise_resolution": _SPANWISE, "chordwise_resolution": _CHORDWISE}
    return asb.Wing(
        name=surface.name,
        symmetric=surface.symmetric,
        xsecs=sections,
        **_for_avl(asb, **lattice, drag_polar=polar),
    )


def _for_avl(asb: Any, **options: Any) -> dict[str, Any]:
    """Return what AVL alone is told, which a script leaves out."""
    told = not isinstance(asb, _Script)
    return {"analysis_specific_options": {asb.AVL: options}} if told else {}


def _library() -> Any:
    """Import AeroSandbox on demand, which takes seconds."""
    import aerosandbox

    return aerosandbox


def airplane_text(aircraft: Aircraft, file_format: str, gravity_m: float | None = None) -> str:
    """Return the text of a geometry file: ``avl``, ``vspscript``, or ``py`` for a script."""
    notes = lifting_surfaces(aircraft, gravity_m).notes
    if file_format == "py":
        head = f"{_script_name(aircraft.name)}: wing and tail planes."
        made = _airplane(_Script("asb"), aircraft, gravity_m)
        text = f"import aerosandbox as asb\n\nairplane = {made}\n"
        return _commented(text, "#", (head, *notes))
    airplane, asb = to_aerosandbox(aircraft, gravity_m), _library()
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
