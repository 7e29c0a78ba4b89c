"""Exported aircraft by AVL and by the models: ``python -m benchmarks.avl_wing``.

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
from typing import TYPE_CHECKING, Any

import missions
import sizing
from sizing import load_aircraft
from sizing.aircraft import Aircraft
from sizing.structures.loads import lift_curve_slope
from studies.exchange.airplane import airplane_text, to_aerosandbox
from studies.render.tables import Column, Table

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import optvl

AIRCRAFT = ("atlantiksolar-design", "sky-sailor", "solong")
# The tail of AtlantikSolar's modules.tail, at full pressure as AVL has it; the other as shipped.
BALANCED: dict[str, dict[str, Any]] = {
    "atlantiksolar-design": {
        "airframe.tail": {
            "arm_m": 1.2199,
            "horizontal_area_m2": 0.87 * 0.173,
            "horizontal_aspect_ratio": 0.87 / 0.173,
            "horizontal_height_m": 0.3,
            "vertical_area_m2": 0.30 * 0.065,
            "vertical_aspect_ratio": 0.30 / 0.065,
            "dynamic_pressure_ratio": 1.0,
        },
        "airframe.balance": {},
    },
    "twin-boom-design": {"airframe.tail.dynamic_pressure_ratio": 1.0, "airframe.drag.pods": []},
}
# Strips along the span for the downwash at the tail: with the 24 of the exported file the neutral
# point of atlantiksolar-design is 0.7 % of the chord ahead of that with 60, with 40 0.1 %.
_FINE = (5, 60)
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
    incidence = float(to_aerosandbox(aircraft).wings[0].xsecs[0].twist)
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
def _solver(
    aircraft: Aircraft, gravity_m: float | None = None, lattice: tuple[int, int] = (8, 24)
) -> Iterator[optvl.OVLSolver]:
    """AVL with the exported file; ``lattice``: vortices along the chord and the span."""
    import optvl

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "w.avl"  # AVL's paths have at most a few dozen characters
        text = airplane_text(aircraft, "avl", gravity_m)
        text = text.replace("8   1   24   1", "{}   1   {}   1".format(*lattice))
        path.write_text(text, encoding="utf-8")
        yield optvl.OVLSolver(geo_file=str(path))


@dataclass(frozen=True)
class Stability:
    """Neutral point and derivatives by AVL and by the models.

    Attributes
    ----------
    aircraft : str
    by_avl, by_model : dict of float
        ``neutral_point`` behind the leading edge of the mean aerodynamic chord over that chord,
        ``static_margin`` of the balance, ``lift_slope`` of the aircraft and
        ``directional_slope`` [1/rad], ``downwash_slope`` at the tail.
    """

    aircraft: str
    by_avl: dict[str, float]
    by_model: dict[str, float]


def stability(aircraft: Aircraft, alpha_deg: float = 0.0, step_deg: float = 1.0) -> Stability:
    """Static stability of an aircraft with tail and balance; AVL's without bodies.

    Parameters
    ----------
    aircraft : Aircraft
    alpha_deg : float
        Angle of attack of the body about which the derivatives are taken.
    step_deg : float
        Half of the difference of angles for the downwash.

    Returns
    -------
    Stability
    """
    found = sizing.analyse(aircraft, missions.load_mission("rafz-july"), replay=False).balance
    assert found is not None
    wing, planes = found.wing, found.planes
    with _solver(aircraft, found.gravity_m, _FINE) as solver:
        solver.set_variable("alpha", alpha_deg)
        solver.execute_run()
        derivatives = {k: float(v) for k, v in solver.get_stab_derivs().items()}
        tail = []
        for angle in (alpha_deg - step_deg, alpha_deg + step_deg):
            solver.set_variable("alpha", angle)
            solver.execute_run()
            parts = solver.get_surface_forces()
            tail.append(sum(float(parts[name]["CL"]) for name in parts if "horizontal" in name))
    slope = (tail[1] - tail[0]) / math.radians(2.0 * step_deg) * wing.area_m2 / planes.horizontal_m2
    neutral_m = derivatives["neutral point"]
    return Stability(
        aircraft.name,
        {
            "neutral_point": found.in_chord(neutral_m),
            "static_margin": (neutral_m - found.gravity_m) / wing.aerodynamic_chord_m,
            "lift_slope": derivatives["dCL/dalpha"],
            "downwash_slope": 1.0 - slope / found.neutral_point.tail_slope,
            "directional_slope": derivatives["dCn'/dbeta"],
        },
        {
            "neutral_point": found.in_chord(found.neutral_point.x_m),
            "static_margin": found.static_margin,
            "lift_slope": float(found.neutral_point.slope),
            "downwash_slope": float(found.neutral_point.downwash),
            "directional_slope": found.directional_slope,
        },
    )


def stability_table(found: Sequence[Stability]) -> Table:
    """Derivatives of all aircraft."""
    columns = (
        Column("aircraft"),
        Column("quantity"),
        Column("avl", "AVL", form=".4f"),
        Column("model", "model", form=".4f"),
        Column("difference", "model less AVL", form="+.4f"),
    )
    rows = tuple(
        (one.aircraft, name.replace("_", " "), avl, one.by_model[name], one.by_model[name] - avl)
        for one in found
        for name, avl in one.by_avl.items()
    )
    return Table("static stability", columns, rows)


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
    """Print all tables."""
    found = [wing_lift(load_aircraft(name)) for name in AIRCRAFT]
    for table in (slope_table(found), curve_table(found[0])):
        sys.stdout.write(f"{table.to_markdown()}\n")
    balanced = [stability(load_aircraft(name, changes)) for name, changes in BALANCED.items()]
    sys.stdout.write(f"{stability_table(balanced).to_markdown()}\n")


if __name__ == "__main__":
    main()
