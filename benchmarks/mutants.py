"""Random changes of one token each, and whether the tests find them.

``python -m benchmarks.mutants --count 300 --seed 1``. A module of ``solar``, ``missions`` or
``sizing`` is changed in a copy of the project (:mod:`benchmarks.mutations`), and the tests of the
mirror folder are run, ``tests/solar`` for ``solar`` and so on, up to the first that fails. A test
that runs for ever has found the change.

Only those tests are run that execute the changed statement: the others would do what they did
before. ``coverage`` tells which they are (:mod:`benchmarks.covering_tests`). A line that runs at
import has its effect where other lines of the module run: tests of these come first, and then the
rest of the tests of the module's own folder. What was computed for one test and kept for others, in
a fixture or a cache, is counted to the first of them: before a change is said to have survived, the
rest of the test files that execute it is run too. So the answer is that of all tests of the folder.
A statement that no test executes has survived at once.

A change that cannot be observed is *harmless*. Those that were judged so are listed with the reason
in ``mutants_harmless.csv``.

With ``--rows`` every change tried is kept, a line of JSON each: run again, the command goes on
where it stopped. Needs Linux or macOS, and ``coverage``, which comes with the extra ``dev``.
"""

from __future__ import annotations

import csv
import json
import random
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby, islice
from pathlib import Path
from typing import Any, NamedTuple

import click

from benchmarks.covering_tests import (
    PACKAGES,
    CoveredTests,
    copy_of_project,
    run_tests,
    sources,
)
from benchmarks.mutations import Mutation, changed_source, mutations

_PROJECT = Path(__file__).parents[1]
_HARMLESS = Path(__file__).with_name("mutants_harmless.csv")
# Beside the time under coverage, which slows tests down: another load of the machine is no hang.
_PATIENCE, _AT_LEAST_S = 5.0, 60.0


class Mutant(NamedTuple):
    """A change of a module."""

    module: Path
    change: Mutation
    old: str
    code: str  # the line as it is

    @property
    def key(self) -> tuple[str, int, str]:
        """What tells it from every other one."""
        return self.module.as_posix(), self.change.start, self.change.new

    @property
    def words(self) -> str:
        """The change in a few words."""
        return f"`{self.old}` to `{self.change.new}`" if self.change.new else f"no `{self.old}`"


def drawn(project: Path, seed: int, only: str) -> Iterator[Mutant]:
    """Draw mutants without end of the modules whose path holds a text, each token once.

    Parameters
    ----------
    project : Path
        Root of the project.
    seed : int
        Of the series.
    only : str
        Text.

    Yields
    ------
    Mutant
    """
    places: list[tuple[Path, str, list[Mutation]]] = []
    for module in sources(project):
        if not module.as_posix().startswith(only):
            continue
        source = (project / module).read_text(encoding="utf-8")
        for _, changes in groupby(mutations(source), key=lambda one: (one.start, one.end)):
            places.append((module, source, list(changes)))
    dice = random.Random(seed)
    dice.shuffle(places)
    for module, source, choices in places:
        change = dice.choice(choices)
        old = source.encode()[change.start : change.end].decode()
        code = source.splitlines()[change.line - 1].strip()
        yield Mutant(module, change, old, code)


def folders_of(module: Path) -> tuple[str, str]:
    """Folder of the tests of a module's package, and that of its sub-package where it has one.

    Parameters
    ----------
    module : Path
        Below the root of the project.

    Returns
    -------
    (str, str)
    """
    package, *inner, _ = module.parts
    own = f"tests/{package}/{inner[0]}" if package == "sizing" and inner else f"tests/{package}"
    return f"tests/{package}", own


def row_of(tree: Path, mutant: Mutant, tests: CoveredTests) -> dict[str, Any]:
    """Row of a mutant: what it is, and the test that finds it.

    Parameters
    ----------
    tree : Path
        Copy of the project, which is changed and changed back.
    mutant : Mutant
        The change.
    tests : CoveredTests
        Of the copy.

    Returns
    -------
    dict
        ``found`` is the test, ``"hung"``, or None; ``tests`` how many were run.
    """
    path = tree / mutant.module
    source = path.read_text(encoding="utf-8")
    run, found = 0, None
    path.write_text(changed_source(source, mutant.change), encoding="utf-8")
    try:
        for batch in _batches(mutant, tests):
            run += len(batch)
            found = run_tests(tree, batch, _AT_LEAST_S + _PATIENCE * tests.seconds_of(batch))
            if found is not None:
                break
    finally:
        path.write_text(source, encoding="utf-8")
    module, start, new = mutant.key
    return {
        "module": module,
        "start": start,
        "new": new,
        "line": mutant.change.line,
        "code": mutant.code,
        "change": mutant.words,
        "found": found,
        "tests": run,
    }


def _batches(mutant: Mutant, tests: CoveredTests) -> Iterator[list[str]]:
    """Tests to run: those that execute the change, then those that share what these compute."""
    module, change = mutant.module, mutant.change
    folder, own = folders_of(module)
    files = tests.below([folder])
    lines = None if change.at_import else change.lines
    first = tests.executing(module, lines, files)
    if first:
        yield first
    rest_of = {test.partition("::")[0] for test in first}
    if change.at_import:
        rest_of.update(tests.below([own]))
    known = set(first)
    rest = [test for test in tests.of_files(rest_of) if test not in known]
    if rest:
        yield rest


def package_of(module: str) -> str:
    """Package of a module in the table: of sizing also the sub-package.

    Parameters
    ----------
    module : str
        Path below the root of the project.

    Returns
    -------
    str
    """
    package, *inner = module.split("/")[:-1]
    return f"{package}.{inner[0]}" if package == "sizing" and inner else package


def harmless() -> dict[tuple[str, str, str], str]:
    """Reasons why changes cannot be observed, by module, line as it is, and change."""
    with _HARMLESS.open(encoding="utf-8", newline="") as file:
        return {
            (row["module"], row["code"], row["change"]): row["reason"]
            for row in csv.DictReader(file)
        }


def table(
    rows: Sequence[Mapping[str, Any]], reasons: Mapping[tuple[str, str, str], str]
) -> Iterator[str]:
    """Lines of a Markdown table by package, and of the survivors.

    Parameters
    ----------
    rows : sequence of mapping
        See :func:`row_of`.
    reasons : mapping
        See :func:`harmless`.

    Yields
    ------
    str
    """
    yield "| package | tried | found | harmless | survived | found of those not harmless |"
    yield "| --- | --- | --- | --- | --- | --- |"
    ordered = sorted(rows, key=lambda row: (package_of(row["module"]), row["module"], row["line"]))
    for package, some in groupby(ordered, key=lambda row: package_of(row["module"])):
        yield _line(package, list(some), reasons)
    yield _line("all", ordered, reasons)
    left = [row for row in ordered if row["found"] is None and not _known(row, reasons)]
    if left:
        yield ""
        yield "These survived:"
        yield ""
        for row in left:
            never = "" if row["tests"] else ", which no test executes"
            yield f"- {row['module']}:{row['line']}: {row['change']} in `{row['code']}`{never}"


def _known(row: Mapping[str, Any], reasons: Mapping[tuple[str, str, str], str]) -> bool:
    return (row["module"], row["code"], row["change"]) in reasons


def _line(
    package: str,
    rows: Sequence[Mapping[str, Any]],
    reasons: Mapping[tuple[str, str, str], str],
) -> str:
    found = sum(row["found"] is not None for row in rows)
    same = sum(row["found"] is None and _known(row, reasons) for row in rows)
    counted = len(rows) - same
    share = f"{100.0 * found / counted:.0f} %" if counted else "-"
    return f"| {package} | {len(rows)} | {found} | {same} | {counted - found} | {share} |"


def _kept(path: Path | None) -> dict[tuple[str, int, str], dict[str, Any]]:
    """Rows of an earlier run, the last one of each mutant."""
    if path is None or not path.exists():
        return {}
    rows = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return {(row["module"], row["start"], row["new"]): row for row in rows}


def _rows(
    mutants: Iterable[Mutant],
    known: Mapping[tuple[str, int, str], dict[str, Any]],
    work: Path,
    rows_file: Path | None,
    again: bool,
) -> Iterator[dict[str, Any]]:
    """Rows of mutants, each kept as it is made; what is known is not tried again."""
    tree = copy_of_project(_PROJECT, work)
    tests = CoveredTests(tree, work / "covered", click.echo)
    for mutant in mutants:
        row = known.get(mutant.key)
        same = row is not None and row["code"] == mutant.code
        if row is not None and same and not (again and row["found"] is None):
            yield row
            continue
        tests.record(folders_of(mutant.module)[0])
        row = row_of(tree, mutant, tests)
        if rows_file is not None:
            with rows_file.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
        verdict = "survived" if row["found"] is None else f"found by {row['found']}"
        click.echo(f"{row['module']}:{row['line']}: {row['change']}: {verdict}")
        yield row


@click.command()
@click.option("--count", default=300, show_default=True, help="Number of changes.")
@click.option("--seed", default=1, show_default=True, help="Of the series.")
@click.option(
    "--only", default="", metavar="PATH", help=f"Modules below this: {', '.join(PACKAGES)} ..."
)
@click.option(
    "--rows", "rows_file", type=click.Path(path_type=Path), help="Keep rows here; go on from them."
)
@click.option("--again", is_flag=True, help="Try kept changes that survived once more.")
@click.option(
    "--work",
    type=click.Path(path_type=Path),
    default=Path(tempfile.gettempdir()) / "mutants",
    show_default=True,
    help="Folder for the copy, and for what its tests execute.",
)
def main(count: int, seed: int, only: str, rows_file: Path | None, again: bool, work: Path) -> None:
    """Change one token of the code at a time and run the tests; print what they do not find."""
    mutants = islice(drawn(_PROJECT, seed, only), count)
    rows = list(_rows(mutants, _kept(rows_file), work, rows_file, again))
    for text in table(rows, harmless()):
        click.echo(text)


if __name__ == "__main__":
    main()
