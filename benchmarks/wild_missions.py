"""Wild sizing problems held against a search that only simulates.

``python -m benchmarks.wild_missions --count 500 --seed 0``. Each problem is drawn from the seed and
its number (:mod:`benchmarks.wild_problems`), sized, and searched for a better or, where it is said
to be infeasible, for any feasible design (:mod:`benchmarks.simulated_search`). With ``--rows``
every row is kept as it is made, a line of JSON each: run again, the command goes on where it
stopped.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np

from benchmarks.wild_problems import WildProblem, wild_problem
from benchmarks.wild_verdicts import (
    AGREE,
    BETTER,
    PASSED,
    at_the_edge,
    checked_relaxations,
    claim_of,
    judged,
)
from missions.files.writing import to_yaml

_NEAR = 0.02  # of an optimum, where a search with coarse steps counts as having found it
_RELAXED_EVERY = 2  # of the infeasible problems, one in so many has its relaxations tried


def row_of(
    number: int, seed: int = 0, earlier: dict[str, Any] | None = None, *, climb: bool = False
) -> tuple[dict[str, Any], WildProblem]:
    """Row of one problem, and the problem as it was sized.

    Parameters
    ----------
    number, seed : int
        Of the problem, and of the series.
    earlier : dict, optional
        Row of an earlier run: its required excess time and its design, without a new search.
    climb : bool
        Whether the aircraft climb by day.

    Returns
    -------
    dict
        See :func:`benchmarks.wild_verdicts.judged`; ``relaxations`` where they were tried.
    WildProblem
    """
    drawn = wild_problem(seed, number, climb=climb)
    problem = at_the_edge(drawn) if earlier is None else drawn.requiring(earlier["required_h"])
    claim = claim_of(problem)
    row = judged(problem, claim, seed=number, earlier=earlier)
    single = not problem.objective.of_range
    if claim.status == "infeasible" and single and number % _RELAXED_EVERY == 0:
        row["relaxations"] = checked_relaxations(problem, claim)
    return row, problem


def failed(row: dict[str, Any]) -> bool:
    """Whether a row speaks against the product."""
    return row["verdict"] not in PASSED or bool(refused(row))


def refused(row: dict[str, Any]) -> list[dict[str, Any]]:
    """Relaxations of a row that do not solve at their printed value, or solve with less."""
    return [
        one
        for one in row.get("relaxations", ())
        if one["status"] != "optimal" or one.get("with_less") == "optimal"
    ]


def line(row: dict[str, Any]) -> str:
    """Row in words, for one line."""
    required = f"{row['required_h']:.6g} h"
    said = row["status"] if row["value"] is None else f"{_short(row['value'])}"
    found = "nothing" if row["found"] is None else _short(row["found"])
    text = f"{row['number']}: {row['verdict']}; {row['objective']} {required}: product {said}"
    if row["says"]:
        text += f" ({row['says']})"
    text += f", search {found}"
    if row["gain_percent"] not in (None, 0.0):
        text += f" ({_short(row['gain_percent'])} % better)"
    bad = "; ".join(
        f"{one['text']}: {one['status']}, with less {one.get('with_less')}" for one in refused(row)
    )
    return f"{text}; relaxations refused: {bad}" if bad else text


def _short(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.5g}"


def write_case(folder: Path, row: dict[str, Any], problem: WildProblem) -> None:
    """Write aircraft and mission of a problem, with what was found in the first lines.

    Parameters
    ----------
    folder : Path
        Where ``N-aircraft.yaml`` and ``N-mission.yaml`` go.
    row : dict
        Of the problem.
    problem : WildProblem
        As it was sized.
    """
    folder.mkdir(parents=True, exist_ok=True)
    number = problem.seed
    how = (
        f"solar-uav size {number}-aircraft.yaml -m {number}-mission.yaml "
        f"--objective {row['objective']} --required-excess-time {problem.required_h!r} "
        f"--model {row['model']} --correction {row['correction']}"
    )
    notes = [line(row), how, f"found {row['found_design']}", ", ".join(row["tags"])]
    head = "".join(f"# {' '.join(note.split())}\n" for note in notes)
    for kind, record in (("aircraft", problem.aircraft), ("mission", problem.mission)):
        data = record.model_dump(by_alias=True, exclude_none=True, mode="json")
        (folder / f"{number}-{kind}.yaml").write_text(head + to_yaml(data), encoding="utf-8")


def summary(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Lines that sum rows up."""
    verdicts = Counter(row["verdict"] for row in rows)
    statuses = Counter(row["status"] for row in rows)
    lines = [f"{len(rows)} problems: {_counted(statuses)}", f"verdicts: {_counted(verdicts)}"]
    relaxed = [one for row in rows for one in row.get("relaxations", ())]
    kept = sum(one["status"] == "optimal" for one in relaxed)
    lines.append(f"relaxations that solve at their printed value: {kept} of {len(relaxed)}")
    less = sum(one.get("with_less") == "optimal" for one in relaxed)
    lines.append(f"relaxations that solve with 1 % less as well: {less}")
    for status in statuses:
        times = [row["product_cpu_s"] for row in rows if row["status"] == status]
        lines.append(f"{status}: {np.mean(times):.3f} s of processor time on average")
    times = [row["search_cpu_s"] for row in rows]
    lines.append(f"search by simulation: {np.mean(times):.2f} s on average" if rows else "")
    lines.append(_alone(rows))
    better = [-row["gain_percent"] for row in rows if row["verdict"] == BETTER]
    better = [gain for gain in better if isinstance(gain, float) and gain > 0.0]
    if better:
        lines.append(f"where the product is better, by {np.median(better):.2f} % in the median")
    return [text for text in lines if text]


def _alone(rows: Iterable[dict[str, Any]]) -> str:
    """How near the search comes to optima that it agrees with from random designs alone."""
    pairs = [
        (row["found_by_chance"], row["value"])
        for row in rows
        if row["status"] == "optimal" and row["verdict"] == AGREE and row["value"]
    ]
    near = [
        one == value or (_numbers_both(one, value) and abs(one - value) <= _NEAR * abs(value))
        for one, value in pairs
    ]
    return f"within {100 * _NEAR:g} % of the optimum by chance alone: {sum(near)} of {len(near)}"


def _numbers_both(*values: Any) -> bool:
    return all(isinstance(value, float) for value in values)


def _counted(counter: Counter[str]) -> str:
    return ", ".join(f"{count} {name}" for name, count in counter.most_common())


def _numbers(only: Iterable[int], first: int, count: int) -> list[int]:
    return list(only) or list(range(first, first + count))


def _kept(rows_file: Path | None) -> dict[int, dict[str, Any]]:
    """Rows of an earlier run, the last one of each problem."""
    if rows_file is None or not rows_file.exists():
        return {}
    texts = rows_file.read_text(encoding="utf-8").splitlines()
    return {row["number"]: row for row in map(json.loads, texts)}


@click.command()
@click.option("--count", default=500, show_default=True, help="Number of problems.")
@click.option("--first", default=0, show_default=True, help="Number of the first one.")
@click.option("--seed", default=0, show_default=True, help="Of the series.")
@click.option("--only", multiple=True, type=int, help="Number of a problem; may be repeated.")
@click.option("--climb", is_flag=True, help="Let the aircraft climb by day.")
@click.option(
    "--rows", "rows_file", type=click.Path(path_type=Path), help="Keep rows here; go on from them."
)
@click.option(
    "--against",
    type=click.Path(path_type=Path, exists=True),
    help="Rows of an earlier run; their designs stand for new searches.",
)
@click.option(
    "--cases", type=click.Path(path_type=Path), help="Folder for the files of problems that fail."
)
def main(
    count: int,
    first: int,
    seed: int,
    only: tuple[int, ...],
    climb: bool,
    rows_file: Path | None,
    against: Path | None,
    cases: Path | None,
) -> None:
    """Size wild problems, search for better designs by simulation, print what does not agree."""
    numbers = _numbers(only, first, count)
    known = {} if only else _kept(rows_file)
    earlier = _kept(against)
    for number in numbers:
        if number in known:
            continue
        row, problem = row_of(number, seed, earlier.get(number), climb=climb)
        known[number] = row
        if rows_file is not None:
            with rows_file.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row, allow_nan=False) + "\n")
        if failed(row):
            click.echo(line(row))
            if cases is not None:
                write_case(cases, row, problem)
    for text in summary([known[number] for number in numbers]):
        click.echo(text)


if __name__ == "__main__":
    main()
