"""Processor time of single verdicts, and whether they are those of an earlier run.

``python -m benchmarks.verdict_times --count 300 --rows new.jsonl --against old.jsonl``. Problems
are those of :mod:`benchmarks.random_missions`, or with ``--wild`` of
:mod:`benchmarks.wild_problems` but for the objectives that are a range.
"""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from benchmarks.random_missions import random_case
from benchmarks.wild_problems import wild_problem
from benchmarks.wild_verdicts import at_the_edge
from sizing.optimisation.objectives import Objective
from sizing.optimisation.search import size_aircraft

_SLOW_S = 3.0  # what a user waits for without wondering
_SAME = 1e-6  # relative difference of optima, that of the solver


def timed(number: int, *, wild: bool) -> dict[str, Any] | None:
    """Verdict and processor time [s] of one problem; None for an objective that is a range."""
    if wild:
        problem = wild_problem(0, number)
        if problem.objective.of_range:
            return None
        problem = at_the_edge(problem)
        given: list[Any] = [problem.aircraft, problem.mission, problem.objective, problem.solar]
        required_h = problem.required_h
    else:
        *given, required_h = random_case(number)
    begun = time.process_time()
    result = size_aircraft(*given, required_excess_time_h=required_h)
    return {
        "number": number,
        "objective": result.objective.value,
        "status": result.status.name,
        "value": result.objective_value,
        "cpu_s": time.process_time() - begun,
    }


def summary(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Verdicts, the largest processor time, and how many are slow."""
    slowest = max(rows, key=lambda row: row["cpu_s"])
    slow = sum(row["cpu_s"] > _SLOW_S for row in rows)
    statuses = Counter(row["status"] for row in rows)
    return [
        ", ".join(f"{count} {name}" for name, count in statuses.most_common()),
        f"processor time: {sum(row['cpu_s'] for row in rows) / len(rows):.3f} s on average, "
        f"largest {slowest['cpu_s']:.2f} s (problem {slowest['number']}), "
        f"{slow} of {len(rows)} beyond {_SLOW_S:g} s",
    ]


def differences(rows: Sequence[dict[str, Any]], earlier: Sequence[dict[str, Any]]) -> list[str]:
    """Verdicts and optima that are not those of an earlier run."""
    before = {row["number"]: row for row in earlier}
    pairs = [(before[row["number"]], row) for row in rows if row["number"] in before]
    lines = [
        f"{new['number']}: {old['status']} became {new['status']}"
        for old, new in pairs
        if old["status"] != new["status"]
    ]
    gains = []
    for old, new in pairs:
        if old["value"] is None or new["value"] is None or old["value"] == new["value"]:
            continue
        sign = 1.0 if Objective(new["objective"]).maximised else -1.0
        gains.append((sign * (new["value"] - old["value"]) / max(abs(old["value"]), 1e-9), new))
    moved = [(gain, row) for gain, row in gains if abs(gain) > _SAME]
    lines.append(f"{len(moved)} of {len(pairs)} optima differ by more than {_SAME:g}")
    for word, which in (("worst", min), ("best", max)):
        if moved:
            gain, row = which(moved, key=lambda one: one[0])
            lines.append(f"{word} change {100.0 * gain:+.3g} % (problem {row['number']})")
    return lines


def _rows_of(path: Path) -> list[dict[str, Any]]:
    """Rows of a file."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


@click.command()
@click.option("--count", default=300, show_default=True, help="Number of problems.")
@click.option("--first", default=0, show_default=True, help="Number of the first one.")
@click.option("--wild", is_flag=True, help="Wild problems instead of random missions.")
@click.option("--rows", "rows_file", type=click.Path(path_type=Path), help="Keep rows here.")
@click.option(
    "--against", type=click.Path(path_type=Path, exists=True), help="Rows of an earlier run."
)
def main(count: int, first: int, wild: bool, rows_file: Path | None, against: Path | None) -> None:
    """Size problems, print the processor time of every verdict, and what has changed."""
    rows = []
    for number in range(first, first + count):
        row = timed(number, wild=wild)
        if row is None:
            continue
        rows.append(row)
        click.echo(f"{number}: {row['status']}, {row['cpu_s']:.3f} s")
        if rows_file is not None:
            with rows_file.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
    for line in [*summary(rows), *(differences(rows, _rows_of(against)) if against else [])]:
        click.echo(line)


if __name__ == "__main__":
    main()
