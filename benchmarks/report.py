"""The page on performance, written from the results."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

_MEASURED = Path(__file__).with_name("measured.json")

_HEAD = """# Performance

`python -m benchmarks --markdown docs/performance.md` measures and writes this page;
`python -m benchmarks [--json]` prints the same. `python -m benchmarks --only PART` measures one
part again; the other parts keep their last measurement (`benchmarks/measured.json`).
Peers are optional: `pip install ".[bench]"` brings AeroSandbox and pvlib.

Times depend on the machine and its other load. They are processor times unless a column says
otherwise, and the least of several runs. Ratios are more reliable, since both sides run one after
the other.

"""

_COMMANDS = """## Commands, as a user waits for them

Every command runs in a fresh process, from its start to its end. Processor time is that of the
command alone: a map that is sized computes in workers, so that its wall time counts. Modules are
those imported at its end. Two parts cannot be avoided: *computing* is the time of the result in a
warm process, and *imports* is the time of a process that only imports the same modules. The last
column is the whole time over the sum of the two.

"""

_GALLERY = """## Scripts of the gallery

Every script of `examples/` in a fresh process, with its figure. These were measured on a machine
about three times as fast as that of the other tables, and before all sizings were one program:
`climb_gain.py` and `span_for_a_season.py` take a minute or two now.

"""

_COMPUTING = """## Computing

The times are those of a warm process. The ratio is the peer's time over the time of this project:
above one this project is faster, below one it is slower.

"""

_EXPLAINED = {
    "module power": """Sun, clear sky and module power for every combination of latitude, day and
time in one call. CAM includes the diffuse light and the loss by incidence; the peers compute only
the irradiance on a horizontal plane. pvlib is called in its fastest way, with its analytic sun and
plain NumPy arrays; its usual one (SPA, pandas, time zones) is slower and more exact.""",
    "day and night, in a batch": """One repeated day, to its fixed point, with all metrics. Hundreds
of scenarios are marched together, as in maps and sizings, so that they share NumPy's overhead for
each step. The times are for one scenario of the batch. The peers march one or two days and find no
fixed point and no metrics.""",
    "day and night, alone": """The same for a single scenario. A plain Python loop without metrics
or charge limit is then much faster. One case takes about a millisecond in any case; thousands of
cases should be passed together.""",
    "sizing, build and solve": """Least wingspan of perpetual flight with 3 h of excess time on
three dates. Both sides use the same formulas for masses and power (AeroSandbox's program calls the
functions of this project), the same solar power as data, a power-law structure and no charge limit.
AeroSandbox's program is a direct collocation with slack for surplus power, logarithmic design
variables and good guesses; it is linear in the battery's state. Ours is one too, of 22 intervals
that follow the day, whose light and load the simulator gives; it is reused after the first sizing
of its kind of aircraft. Our time includes the simulations, until both agree on the optimum. The run
fails if the optima differ by more than 0.3 %. AeroSandbox is in addition a general language for
optimisation with its own aerodynamics, which is not measured here.""",
    "sizing, first of its kind": """The same with nothing kept: expressions, derivatives and solver
are built anew, as in a process that sizes once. AeroSandbox builds its program every time.""",
    "sizing, solve again": """More requirements for the same aircraft. AeroSandbox keeps its
program, sets the parameter and starts from the last solution. Ours does the same by sequential
quadratic programming (`sizing.program.cells`); the simulator confirms every design.""",
    "map of 240 sizings": """Twenty latitudes times twelve payloads, three dates each; in the
southern winter there is no design for heavy payloads. Ours simulates all cells at
once and solves them one after the other, with the requirements penalised: an infeasible cell takes
some times a feasible one, while IPOPT searches the peer's collocation for a feasible point until it
stops. AeroSandbox has a limit of 150 iterations and 1 s for each cell, which determines most of its
time in infeasible ones; without it some of them took up to 30 s. Its program is built once; its
user could penalise requirements too. Our time includes sun, simulation and cross-check of every
cell.""",
    "its feasible cells": """Only the feasible cells of that map, which do not depend on the choice
of a limit.""",
    "sizing, with simulation": """A whole call of `size_aircraft` for nine scenarios and the spar
structure, with the charge limit of the aircraft file.""",
    "sizing, solver alone": """The part of it that the solver takes.""",
    "map": """Feasibility map of AtlantikSolar AS-2 by CAM with 5 min steps, all metrics. The map is
faster than a plain march because it does work only once (the half of a day that mirrors the other,
sums that several metrics need, deficits of the night in one step) and because blocks of cells fit
the processor's cache. Results are the same to the last bit for any block. The other lines give the
cost against the number of cells, a process pool of two, the memory, and the map with the longest
flight of every cell with limited flight.""",
}


Parts = Mapping[str, Mapping[str, Any]]
"""Rows of every part of the benchmarks and the machine they were measured on, by its name."""


def measured_before() -> Parts:
    """Parts as they were measured last."""
    return dict(json.loads(_MEASURED.read_text(encoding="utf-8"))) if _MEASURED.exists() else {}


def remember(parts: Parts) -> None:
    """Keep parts for pages on which only some of them are measured anew."""
    _MEASURED.write_text(json.dumps(parts, indent=1) + "\n", encoding="utf-8")


def markdown(parts: Parts) -> str:
    """Page with the tables of all lines and an explanation of each."""
    rows = [r for part in parts.values() for r in part["rows"]]
    commands = [r for r in rows if "modules" in r or r["name"] == "start-up"]
    gallery = [r for r in rows if r["name"] == "gallery script"]
    others = [r for r in rows if "wall_s" not in r]
    named = dict.fromkeys(r["name"] for r in others)
    told = [f"**{name}.** {_EXPLAINED[name]}" for name in named if name in _EXPLAINED]
    tables = (
        (_COMMANDS, _COMMAND_HEADS, map(_command_cells, commands)),
        (_GALLERY, ("script", "processor time", "wall time"), map(_script_cells, gallery)),
        (_COMPUTING, ("name", "work", "ours", "peer", "its time", "ratio"), map(_cells, others)),
    )
    return (
        _HEAD
        + "".join(text + _table(heads, cells) + "\n" for text, heads, cells in tables)
        + _machines(parts)
        + "\n\n### What the lines mean\n\n"
        + "\n\n".join(told)
        + "\n"
    )


_COMMAND_HEADS = (
    *("command", "modules", "processor time", "wall time", "computing", "imports"),
    "whole / (computing + imports)",
)


def _command_cells(r: Mapping[str, Any]) -> Sequence[str]:
    computing_s, imports_s = r.get("computing_s"), r.get("imports_s")
    share = "-"
    if computing_s is not None and imports_s is not None:
        share = f"{r['ours_s'] / (computing_s + imports_s):.2f}"
    times = [r["ours_s"], r["wall_s"], computing_s, imports_s]
    shown = ["-" if t is None else duration(t) for t in times]
    return f"`{r['work']}`", str(r.get("modules", "-")), *shown, share


def _script_cells(r: Mapping[str, Any]) -> Sequence[str]:
    return f"`{r['work']}`", duration(r["ours_s"]), duration(r["wall_s"])


def _cells(r: Mapping[str, Any]) -> Sequence[str]:
    peer_s = "-" if r["peer_s"] is None else duration(r["peer_s"])
    ratio = "-" if r["ratio"] is None else plain(r["ratio"])
    return r["name"], r["work"], duration(r["ours_s"]), r["peer"] or "-", peer_s, ratio


def _table(heads: Sequence[str], cells: Iterable[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *cells]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def plain(number: float) -> str:
    """Number with two digits and without an exponent."""
    return f"{float(f'{number:.1e}'):g}"


def duration(seconds: float) -> str:
    """Time with three digits and a fitting unit."""
    for factor, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= factor:
            return f"{seconds / factor:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def this_machine() -> str:
    """System, cores and versions of this process."""
    versions = [f"Python {platform.python_version()}"]
    for package in ("numpy", "casadi", "scipy", "pvlib", "aerosandbox"):
        try:
            versions.append(f"{package} {metadata.version(package)}")
        except metadata.PackageNotFoundError:
            continue
    return (
        f"{platform.system()} {platform.machine()} with {os.cpu_count()} cores: "
        f"{', '.join(versions)}"
    )


def _machines(parts: Parts) -> str:
    """Where the parts were measured; by name where not all on one machine."""
    names: dict[str, list[str]] = {}
    for name, part in parts.items():
        names.setdefault(part["machine"], []).append(f"`{name}`")
    if len(names) == 1:
        return f"Measured on {next(iter(names))}."
    lines = [f"{', '.join(some)} on {machine}" for machine, some in names.items()]
    return f"Measured {'; '.join(lines)}."
