"""Write airfoil polar tables with NeuralFoil (needs the extra ``airfoil``).

``python -m benchmarks.validation.make_polars --airfoil mh114 --out sizing/data/polars/mh114.csv``
wrote one of
the tables that ship with the package. NeuralFoil is a neural network trained on XFOIL: Sharpe, P.
and Hansman, R. J. (2025), NeuralFoil: An Airfoil Aerodynamics Analysis Tool Using Physics-Informed
Machine Learning, arXiv:2503.16323. Nothing else imports this module: a polar is a table, whoever
made it.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from importlib import import_module, metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sizing.aerodynamics.polar_table import COLUMNS
from solar.types import FloatArray

# Of NeuralFoil's eight networks, from xxsmall to xxxlarge.
MODEL_SIZE = "xlarge"
CRITICAL_EXPONENT = 9.0  # e^N transition: clean, low-turbulence air


class Grid(NamedTuple):
    """Angles of attack [deg] and Reynolds numbers [-] of a table."""

    alpha_deg: FloatArray
    reynolds: FloatArray


def default_grid() -> Grid:
    """Grid of the shipped tables: -4 to 14 deg by 0.5, 60 000 to 600 000 in twelve log steps."""
    return Grid(np.arange(-4.0, 14.25, 0.5), np.round(np.geomspace(60e3, 600e3, 12), -2))


def polar_table(airfoil: str, grid: Grid, *, critical_exponent: float = CRITICAL_EXPONENT) -> str:
    """Text of a polar table.

    Parameters
    ----------
    airfoil : str
        Name in AeroSandbox's coordinate database (a collection of the UIUC type).
    grid : Grid
        Angles of attack and Reynolds numbers.
    critical_exponent : float
        Ncrit of the e^N transition method.

    Returns
    -------
    str

    Raises
    ------
    ModuleNotFoundError
        If NeuralFoil is not installed.
    ValueError
        If the database has no airfoil of that name.
    """
    section, neuralfoil = _section(airfoil)
    reynolds, alpha = (a.ravel() for a in np.meshgrid(grid.reynolds, grid.alpha_deg, indexing="ij"))
    result = neuralfoil.get_aero_from_airfoil(
        section, alpha=alpha, Re=reynolds, n_crit=critical_exponent, model_size=MODEL_SIZE
    )
    columns = [alpha, reynolds]
    columns += [np.asarray(result[k]) for k in ("CL", "CD", "CM", "analysis_confidence")]
    rows = zip(*(c.tolist() for c in columns), strict=True)
    body = [f"{a:g},{re:.0f},{cl:.4f},{cd:.5f},{cm:.4f},{q:.3f}" for a, re, cl, cd, cm, q in rows]
    return "\n".join([*_header(airfoil, section, critical_exponent), *body]) + "\n"


def _section(airfoil: str) -> tuple[Any, Any]:
    try:
        aerosandbox, neuralfoil = (import_module(name) for name in ("aerosandbox", "neuralfoil"))
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f"{error.name} is not installed; it comes with the extra 'airfoil': "
            "pip install neuralfoil",
            name=error.name,
        ) from error
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about missing coordinates, reported below
        section = aerosandbox.Airfoil(airfoil)
    if section.coordinates is None:
        raise ValueError(f"AeroSandbox's coordinate database has no airfoil {airfoil!r}")
    return section, neuralfoil


def _header(airfoil: str, section: Any, critical_exponent: float) -> list[str]:
    versions = {name: metadata.version(name) for name in ("neuralfoil", "aerosandbox")}
    shape = f"thickness {section.max_thickness():.3f}, camber {section.max_camber():.3f} of chord"
    return [
        f"# airfoil: {airfoil} ({shape})",
        f"# source: computed, not measured; NeuralFoil, model {MODEL_SIZE}, trained on XFOIL",
        f"# coordinates: airfoil database of AeroSandbox, file {airfoil}.dat",
        f"# ncrit: {critical_exponent:g}",
        "# mach: 0",
        f"# tool: neuralfoil {versions['neuralfoil']}, aerosandbox {versions['aerosandbox']}",
        "# confidence: NeuralFoil's own estimate of its trustworthiness, 0 to 1",
        ",".join(COLUMNS),
    ]


def main(arguments: list[str] | None = None) -> int:
    """Command line: write one table; the exit code is 1 where it cannot."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.validation.make_polars", description=__doc__
    )
    parser.add_argument("--airfoil", required=True, help="name in AeroSandbox's database")
    parser.add_argument("--out", required=True, type=Path, help="CSV file to write")
    parser.add_argument("--ncrit", type=float, default=CRITICAL_EXPONENT, help="default 9")
    given = parser.parse_args(arguments)
    try:
        text = polar_table(given.airfoil, default_grid(), critical_exponent=given.ncrit)
        given.out.write_text(text, encoding="utf-8")
    except (ModuleNotFoundError, ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
