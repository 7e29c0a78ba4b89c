"""The page on performance, written from the results."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from typing import Any

_HEAD = """# Performance

`python -m benchmarks --markdown docs/performance.md` measures and writes this page;
`python -m benchmarks [--json]` prints the same. Peers are optional: `pip install ".[bench]"` brings
AeroSandbox and pvlib.

Times are CPU times of one process. They depend on the machine and on what else it does. Ratios
hold up better: both sides of one run one after the other, and the least time of several runs
counts. A ratio above one says how many times faster this project is, one below one how many times
slower.

"""

_EXPLAINED = {
    "module power": """Sun, clear sky and module power for every combination of latitude, day and
time in one call. CAM counts direct and diffuse light apart, with the loss by incidence; the peers
stop at the irradiance on a horizontal plane. pvlib is called with its analytic sun and plain
NumPy arrays, which is its fastest way; its usual one (SPA, pandas, time zones) is slower and more
exact.""",
    "day and night, in a batch": """One repeated day, to its fixed point, with all metrics.
Hundreds of scenarios are marched together, so that NumPy's overhead for each step is shared: maps
and sizings are made of such batches. The times are for one scenario of the batch. The peers march
one or two days and find no fixed point and no metrics.""",
    "day and night, alone": """The same for a single scenario, where nothing is shared. A plain
Python loop without metrics or charge limit is then faster by far. Whoever simulates one case does
not wait for it; whoever simulates thousands should pass them together.""",
    "sizing, build and solve": """Least wingspan of perpetual flight with 3 h of excess time on
three dates. Both sides use the same formulas for masses and power (AeroSandbox's program calls
the functions of this project), the same solar power as data, a power-law structure and no charge
limit. AeroSandbox's program is a direct collocation with slack for surplus power, logarithmic
design variables and good guesses; it is linear in the battery's state. Ours has a handful of
variables, as the night's deficit and the day's surplus are integrated in closed form, and
includes the simulation that confirms the optimum. The run fails if the optima differ by more than
0.3 %. Both are fast; what AeroSandbox gives beyond this, a general language for optimisation with
its own aerodynamics, is not measured here.""",
    "sizing, solve again": """More requirements for the same aircraft. AeroSandbox keeps its
program, sets the parameter and starts from the last solution. Ours keeps its program as well and
goes from one solution to the next by sequential quadratic programming
(`sizing.optimisation.cells`); the simulator confirms every design.""",
    "map of 240 sizings": """Twenty latitudes times twelve payloads, three dates each; in the
southern winter there is no design for heavy payloads. Ours sizes all cells at once, with the
requirements penalised: an infeasible cell says what is missing in about the time of a feasible
one, while IPOPT searches the collocation for a feasible point until it gives up. AeroSandbox is
given 150 iterations and 1 s for each cell, and this limit makes most of its time in infeasible
ones; without it some of them took up to 30 s. Its program is built once. An AeroSandbox user could
penalise its requirements too. Our time includes sun, simulation and cross-check of every cell.""",
    "its feasible cells": """The feasible cells of that map alone: what the choice of a limit has
no part in.""",
    "sizing, with simulation": """A whole call of `size_aircraft` for nine scenarios and the spar
structure, with the charge limit of the aircraft file.""",
    "sizing, solver alone": """The part of it that IPOPT takes.""",
    "map": """Feasibility map of AtlantikSolar AS-2 by CAM with 5 min steps, all metrics. The C loop
does the same arithmetic in one thread, compiled where a compiler is found, and its numbers are
checked against ours. The other lines give the cost against the number of cells, a process pool of
two, the memory, and the map with the longest flight of every cell that is not perpetual.""",
    "weather year": """AtlantikSolar AS-2 through the shipped year. Both loops get the same power at
the same nodes and compute the same: dawns, the charge carried over, the charge limit, days that
close, and a flight from every dawn; flights that have become equal share the rest of their way in
all three. The run fails if a day closes in one and not in another, or an endurance differs by more
than 1e-6 h. Ours marches all days at once and again the few whose start is not known before; a loop
that is compiled has no need of that. The lines without a peer are whole runs from the record.""",
    "uncertain inputs": """The mass budget, the day and its metrics of every draw, all at once. The
peer builds each draw's aircraft and calls `sizing.analyse`, which also prepares what is printed;
excess times agree to 1e-6 h.""",
}


def markdown(rows: list[dict[str, Any]]) -> str:
    """Page with the table of all lines and an explanation of each."""
    lines = [
        "| name | work | ours | peer | its time | ratio |",
        "|---|---|---|---|---|---|",
    ]
    for r in rows:
        peer_s = "-" if r["peer_s"] is None else duration(r["peer_s"])
        ratio = "-" if r["ratio"] is None else plain(r["ratio"])
        lines.append(
            f"| {r['name']} | {r['work']} | {duration(r['ours_s'])} | {r['peer'] or '-'} | "
            f"{peer_s} | {ratio} |"
        )
    named = dict.fromkeys(r["name"] for r in rows)
    told = [f"**{name}.** {_EXPLAINED[name]}" for name in named if name in _EXPLAINED]
    return (
        _HEAD
        + "\n".join([*lines, "", _machine(), "", "## What the lines mean", ""])
        + ("\n" + "\n\n".join(told) + "\n")
    )


def plain(number: float) -> str:
    """Number with two digits and without an exponent."""
    return f"{float(f'{number:.1e}'):g}"


def duration(seconds: float) -> str:
    """Time with three digits and a fitting unit."""
    for factor, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= factor:
            return f"{seconds / factor:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def _machine() -> str:
    versions = [f"Python {platform.python_version()}"]
    for package in ("numpy", "casadi", "scipy", "pvlib", "aerosandbox"):
        try:
            versions.append(f"{package} {metadata.version(package)}")
        except metadata.PackageNotFoundError:
            continue
    return (
        f"Measured on {platform.system()} {platform.machine()} with {os.cpu_count()} cores: "
        f"{', '.join(versions)}."
    )
