"""Random changes of one token each, and whether the tests find them.

``python -m benchmarks.mutants --count 300 --seed 1``. A module of ``solar``, ``missions`` or
``sizing`` is changed in a copy of the project (:mod:`benchmarks.mutations`), and the tests of the
mirror folder are run up to the first that fails: ``tests/solar`` for ``solar``, ``tests/missions``
for ``missions``, and for ``sizing`` the folder of the sub-package and those files of
``tests/sizing`` that name the module. A test that runs for ever has found the change.

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

import tempfile
from collections.abc import Container, Iterable, Iterator, Mapping
from hashlib import sha256
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

import click

from benchmarks.covering_tests import (
    PACKAGES,
    CoveredTests,
    copy_of_project,
    run_tests,
    sources,
)
from benchmarks.mutant_rows import Key, Row, kept, table
from benchmarks.mutations import Mutation, changed_source, mutations

_PROJECT = Path(__file__).parents[1]
# Beside the time under coverage, which slows tests down: another load of the machine is no hang.
_PATIENCE, _AT_LEAST_S = 5.0, 60.0


class Mutant(NamedTuple):
    """A change of a module."""

    module: Path
    change: Mutation
    old: str
    code: str  # the line as it is

    @property
    def key(self) -> Key:
        """What tells it from others, wherever in its module the line stands."""
        return self.module.as_posix(), self.code, self.words

    @property
    def words(self) -> str:
        """The change in a few words."""
        return f"`{self.old}` to `{self.change.new}`" if self.change.new else f"no `{self.old}`"


def drawn(project: Path, seed: int, only: str, known: Container[Key] = ()) -> list[Mutant]:
    """Mutants of the modules below ``only``, each token once, in an order that looks random.

    The order of two of them does not change with the rest of the code. Those that are known come
    first: whatever else was drawn at the time, they are random too.
    """
    found: dict[bytes, Mutant] = {}
    for module in sources(project):
        if not module.as_posix().startswith(only):
            continue
        source = (project / module).read_text(encoding="utf-8")
        lines, encoded = source.splitlines(), source.encode()
        for (start, end), changes in groupby(
            mutations(source), key=lambda one: (one.start, one.end)
        ):
            old, choices = encoded[start:end].decode(), list(changes)
            code = lines[choices[0].line - 1].strip()
            place = sha256("\n".join([str(seed), module.as_posix(), code, old]).encode()).digest()
            mutants = [Mutant(module, change, old, code) for change in choices]
            new = mutants[place[0] % len(mutants)]
            # Of equal tokens of a line the first one.
            found.setdefault(place, next((one for one in mutants if one.key in known), new))
    return sorted((found[place] for place in sorted(found)), key=lambda one: one.key not in known)


def files_of(tree: Path, module: Path) -> tuple[list[str], list[str]]:
    """Test files that must find a change of a module.

    Parameters
    ----------
    tree : Path
        Copy of the project.
    module : Path
        Below its root.

    Returns
    -------
    (list of str, list of str)
        Those of the mirror folder, and others of the package; of ``sizing``, only those that name
        the module.
    """
    package, mirror = module.parts[0], tree / "tests" / module.parent
    dotted = ".".join(module.with_suffix("").parts)
    own, others = [], []
    for path in sorted((tree / "tests" / package).rglob("test_*.py")):
        name = path.relative_to(tree).as_posix()
        if path.parent == mirror:
            own.append(name)
        elif package != "sizing" or dotted in path.read_text(encoding="utf-8"):
            others.append(name)
    return own, others


def row_of(tree: Path, mutant: Mutant, tests: CoveredTests) -> Row:
    """Try a mutant.

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
    Row
    """
    path = tree / mutant.module
    source = path.read_text(encoding="utf-8")
    for files in files_of(tree, mutant.module):
        tests.record(files)  # of the module as it is
    run, found = 0, None
    path.write_text(changed_source(source, mutant.change), encoding="utf-8")
    try:
        for batch in _batches(tree, mutant, tests):
            run += len(batch)
            found = run_tests(tree, batch, _AT_LEAST_S + _PATIENCE * tests.seconds_of(batch))
            if found is not None:
                break
    finally:
        path.write_text(source, encoding="utf-8")
    line, start, new = mutant.change.line, mutant.change.start, mutant.change.new
    module = mutant.module.as_posix()
    return Row(module, line, start, new, mutant.code, mutant.words, found, tests=run)


def _batches(tree: Path, mutant: Mutant, tests: CoveredTests) -> Iterator[list[str]]:
    """Tests to run: those that execute the change, then those that share what these compute."""
    module, change = mutant.module, mutant.change
    own, others = files_of(tree, module)
    lines = None if change.at_import else change.lines
    known: list[str] = []
    for files in (own, others):
        executing = tests.executing(module, lines, files)
        known += executing
        if executing:
            yield executing
    sharing = {test.partition("::")[0] for test in known}
    rest = tests.of_files(sharing.union(own) if change.at_import else sharing)
    if left := [test for test in rest if test not in set(known)]:
        yield left


def _rows(
    mutants: Iterable[Mutant],
    known: Mapping[Key, Row],
    work: Path,
    rows_file: Path | None,
    again: bool,
) -> Iterator[Row]:
    """Rows of mutants, each kept as it is made; what is known is not tried again."""
    tree = copy_of_project(_PROJECT, work)
    tests = CoveredTests(tree, work / "covered", click.echo)
    for mutant in mutants:
        before = known.get(mutant.key)
        if before is not None and not (again and before.survived):
            yield before
            continue
        row = row_of(tree, mutant, tests)
        if rows_file is not None:
            row.keep(rows_file)
        verdict = "survived" if row.found is None else f"found by {row.found}"
        click.echo(f"{row.module}:{row.line}: {row.change}: {verdict}")
        yield row._replace(since=before is not None and row.found is not None)


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
    known = kept(rows_file)
    mutants = drawn(_PROJECT, seed, only, known)[:count]
    for text in table(list(_rows(mutants, known, work, rows_file, again))):
        click.echo(text)


if __name__ == "__main__":
    main()
