"""Changes of the code that were tried, as they are kept, judged and told."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

__all__ = ["Key", "Row", "harmless", "kept", "table"]

Key = tuple[str, str, str]
_COLUMNS = ("package", "tried", "found", "of these since", "harmless", "survived", "share found")
_HARMLESS = Path(__file__).with_name("mutants_harmless.csv")


class Row(NamedTuple):
    """A change that was tried.

    Attributes
    ----------
    module : str
        Path below the root of the project.
    line : int
        Of the token.
    start : int
        Place of the token in the module, in bytes.
    new : str
        What stood there instead.
    code : str
        The line before the change.
    change : str
        The change in words.
    found : str or None
        Test that found it, ``"hung"``, how the process ended, or None.
    tests : int
        How many tests were run.
    since : bool
        Whether it had survived before, and tests were written since.
    """

    module: str
    line: int
    start: int
    new: str
    code: str
    change: str
    found: str | None
    tests: int
    since: bool = False

    @property
    def key(self) -> Key:
        """What tells the change from others, wherever in its module the line stands."""
        return self.module, self.code, self.change

    @property
    def package(self) -> str:
        """Package of the module; of ``sizing`` also the sub-package."""
        package, *inner = self.module.split("/")[:-1]
        return f"{package}.{inner[0]}" if package == "sizing" and inner else package

    @property
    def reason(self) -> str | None:
        """Why the change, which survived, cannot be observed; None if it can."""
        known = harmless().get(self.key)
        return known if self.found is None else None

    @property
    def survived(self) -> bool:
        """Whether no test found the change, though it can be observed."""
        return self.found is None and self.reason is None

    def keep(self, path: Path) -> None:
        """Append the row to a file of them."""
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(self._asdict(), ensure_ascii=False) + "\n")


def kept(path: Path | None) -> dict[Key, Row]:
    """Rows of a file, the last one of each change; none if there is no file.

    Parameters
    ----------
    path : Path, optional
        A line of JSON each.

    Returns
    -------
    dict
    """
    rows: dict[Key, Row] = {}
    if path is None or not path.exists():
        return rows
    for text in path.read_text(encoding="utf-8").splitlines():
        row = Row(**json.loads(text))
        before = rows.get(row.key)
        survived = before is not None and (before.since or before.found is None)
        rows[row.key] = row._replace(since=survived and row.found is not None)
    return rows


@cache
def harmless() -> dict[tuple[str, str, str], str]:
    """Reasons why changes cannot be observed, by module, line as it is, and change."""
    with _HARMLESS.open(encoding="utf-8", newline="") as file:
        return {
            (row["module"], row["code"], row["change"]): row["reason"]
            for row in csv.DictReader(file)
        }


def table(rows: Iterable[Row]) -> Iterator[str]:
    """Lines of a Markdown table by package, and of the survivors.

    Parameters
    ----------
    rows : iterable of Row
        Changes that were tried.

    Yields
    ------
    str
    """
    yield f"| {' | '.join(_COLUMNS)} |"
    yield f"| {' | '.join('---' for _ in _COLUMNS)} |"
    ordered = sorted(rows, key=lambda row: (row.package, row.module, row.line))
    for package, some in groupby(ordered, key=lambda row: row.package):
        yield _line(package, list(some))
    yield _line("all", ordered)
    left = [row for row in ordered if row.survived]
    if left:
        yield from ("", "These survived:", "")
        for row in left:
            never = "" if row.tests else ", which no test executes"
            yield f"- {row.module}:{row.line}: {row.change} in `{row.code}`{never}"


def _line(package: str, rows: Sequence[Row]) -> str:
    """Line of the table."""
    found = sum(row.found is not None for row in rows)
    since = sum(row.since for row in rows)
    same = sum(row.reason is not None for row in rows)
    counted = len(rows) - same
    share = f"{100.0 * found / counted:.1f} %" if counted else "-"
    cells = (package, len(rows), found, since, same, counted - found, share)
    return f"| {' | '.join(map(str, cells))} |"
