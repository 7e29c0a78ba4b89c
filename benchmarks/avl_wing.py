"""Lift of the exported wings by AVL beside that of the models: ``python -m benchmarks.avl_wing``.

AVL is run by optvl on the file that ``solar-uav export --out wing.avl`` writes: another program, on
the file as a user gets it. Both are extras: ``pip install ".[exchange]" optvl``.
"""

from __future__ import annotations

import math
import sys
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from sizing import load_aircraft
from sizing.aircraft import Aircraft
from sizing.results.tables import Column, Table
from sizing.structures.loads import lift_curve_slope
from studies.exchange.airplane import airplane_text
from studies.exchange.geometry import lifting_surfaces

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import optvl

AIRCRAFT = ("atlantiksolar-design", "sky-sailor", "solong")
ANGLES_DEG = (-6.0, -4.0, -2.0, 0.0, 2.0, 4.0)


@dataclass(frozen=True)
class WingLift:
    """Lift coefficients of a wing at angles of attack of the body.

    Attributes
    ----------
    aircraft : str
    aspect_ratio, incidence_deg : float
        Of the wing.
    angles_deg : tuple of float
    by_avl, by_model : tuple of float
        Lift coefficients on the wing area.
    span_efficiency : float
        Of the whole aircraft, in AVL's Trefftz plane, at the last angle.
    """

    aircraft: str
    aspect_ratio: float
    incidence_deg: float
    angles_deg: tuple[float, ...]
    by_avl: tuple[float, ...]
    by_model: tuple[float, ...]
    span_efficiency: float

    @property
    def avl_slope(self) -> float:
        """Slope of AVL's curve [1/rad]."""
        return (self.by_avl[-1] - self.by_avl[0]) / math.radians(
            self.angles_deg[-1] - self.angles_deg[0]
        )

    @property
    def model_slope(self) -> float:
        """Slope that the models take [1/rad]."""
        return float(lift_curve_slope(self.aspect_ratio))


def wing_lift(aircraft: Aircraft, angles_deg: Sequence[float] = ANGLES_DEG) -> WingLift:
    """Lift of the wing by AVL and by the models, whose wing has no camber.

    Parameters
    ----------
    aircraft : Aircraft
    angles_deg : sequence of float
        Angles of attack of the body.

    Returns
    -------
    WingLift
    """
    with _solver(aircraft) as solver:
        by_avl = []
        for angle in angles_deg:
            solver.set_variable("alpha", angle)
            solver.execute_run()
            parts = solver.get_surface_forces()
            # AVL has the mirrored half as a surface of its own.
            by_avl.append(sum(float(parts[name]["CL"]) for name in parts if "wing" in name))
        efficiency = float(solver.get_total_forces()["e"])
    incidence = lifting_surfaces(aircraft).surfaces[0].sections[0].twist_deg
    slope = float(lift_curve_slope(aircraft.airframe.aspect_ratio))
    return WingLift(
        aircraft.name,
        aircraft.airframe.aspect_ratio,
        incidence,
        tuple(angles_deg),
        tuple(by_avl),
        tuple(slope * math.radians(angle + incidence) for angle in angles_deg),
        efficiency,
    )


@contextmanager
def _solver(aircraft: Aircraft) -> Iterator[optvl.OVLSolver]:
    """AVL with the exported file."""
    import optvl

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "w.avl"  # AVL's paths have at most a few dozen characters
        path.write_text(airplane_text(aircraft, "avl"), encoding="utf-8")
        yield optvl.OVLSolver(geo_file=str(path))


def slope_table(found: Sequence[WingLift]) -> Table:
    """Slopes of all aircraft, and AVL's span efficiency."""
    columns = (
        Column("aircraft"),
        Column("aspect_ratio", "aspect ratio", form=".1f"),
        Column("avl", "slope, AVL", "1/rad", ".3f"),
        Column("model", "2π AR/(AR + 2)", "1/rad", ".3f"),
        Column("ratio", "AVL over model", form=".3f"),
        Column("efficiency", "span efficiency, AVL", form=".3f"),
    )
    rows = tuple(
        (w.aircraft, w.aspect_ratio, w.avl_slope, w.model_slope,
         w.avl_slope / w.model_slope, w.span_efficiency)
        for w in found
    )  # fmt: skip
    return Table("lift slope of the wing", columns, rows)


def curve_table(found: WingLift) -> Table:
    """Lift curve of one aircraft."""
    columns = (
        Column("alpha", "angle of attack", "deg", ".0f"),
        Column("avl", "wing, AVL", form=".3f"),
        Column("model", "model", form=".3f"),
    )
    rows = tuple(zip(found.angles_deg, found.by_avl, found.by_model, strict=True))
    return Table(f"lift curve of {found.aircraft}", columns, rows)


def main() -> None:
    """Print both tables."""
    found = [wing_lift(load_aircraft(name)) for name in AIRCRAFT]
    for table in (slope_table(found), curve_table(found[0])):
        sys.stdout.write(f"{table.to_markdown()}\n")


if __name__ == "__main__":
    main()
