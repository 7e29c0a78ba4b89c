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

What a user waits for, and how fast the models are beside those of peers. One command measures and
writes this page, `python -m benchmarks --markdown docs/performance.md`; `--only PART` measures one
part again. Peers are optional: `pip install ".[bench]"` brings AeroSandbox and pvlib.

Times depend on the machine and its other load. They are processor times unless a column says
otherwise, and the least of several runs.

"""

_COMMANDS = """## Commands, as a user waits for them

Every command runs in a fresh process. Processor time is that of the command alone, without its
workers; modules are those imported at its end. *Computing* is the time of the result in a warm
process, *imports* that of a process that only imports the same modules.

"""

_COMPUTING = """## Computing

In a warm process. The ratio is the peer's time over the time of this project.

"""

_EXPLAINED = {
    "module power": """Sun, clear sky and module power for every combination of latitude, day and
time in one call. CAM includes the diffuse light and the loss by incidence; the peers compute only
the irradiance on a horizontal plane. pvlib is called in its fastest way, with its analytic sun and
plain NumPy arrays.""",
    "day and night": """One repeated day, to its fixed point, with all metrics; the peers find
neither. In a batch hundreds of scenarios share NumPy's overhead for each step.""",
    "sizing": """Both sides use the same formulas for masses and power (AeroSandbox's program calls
the functions of this project), the same solar power as data, a power-law structure and no charge
limit. AeroSandbox's program is a direct collocation with slack for surplus power, logarithmic
design variables and good guesses. Ours has 22 intervals that follow the day; its time includes the
simulations, until both agree on the optimum. The run fails if the optima differ by more than
0.3 %. AeroSandbox is in addition a general language for optimisation with its own aerodynamics,
which is not measured here. To solve again it sets a parameter and starts from the last solution;
ours does the same by sequential quadratic programming (`sizing.program.cells`).""",
    "map of 240 sizings": """Twenty latitudes times twelve payloads, three dates each; in the
southern winter there is no design for heavy payloads. Ours penalises the requirements: an
infeasible cell takes some times a feasible one, while IPOPT searches the peer's collocation for a
feasible point until it stops. Its limit is 150 iterations and 1 s for each cell, which determines
most of its time in infeasible ones; its user could penalise requirements too.""",
    "map": """Feasibility map of AtlantikSolar AS-2 by CAM with 5 min steps, all metrics. Work is
done once (half a day of sun, whose mirror is the other half, sums that several metrics need,
deficits of the night in one step), in blocks of cells that fit the processor's cache.""",
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
    others = [r for r in rows if "wall_s" not in r]
    named = {r["name"] for r in others}
    notes = [
        f"**{start}.** {text}"
        for start, text in _EXPLAINED.items()
        if any(name.startswith(start) for name in named)
    ]
    tables = (
        (_COMMANDS, _COMMAND_HEADS, map(_command_cells, commands)),
        (_COMPUTING, ("name", "work", "ours", "peer", "its time", "ratio"), map(_cells, others)),
    )
    return (
        _HEAD
        + "".join(text + _table(heads, cells) + "\n" for text, heads, cells in tables)
        + _machines(parts)
        + "\n\n### What the lines mean\n\n"
        + "\n\n".join(notes)
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
