"""The page on reliability, of kept records and of the lists of defects."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from benchmarks.mutant_rows import kept, table
from benchmarks.reliability.record import FOLDER, Record

__all__ = ["Defect", "defects", "markdown"]

_HERE = Path(__file__).parent
_TITLES = {"faults": "Faults during the work", "inputs": "Wrong inputs"}
_DEFECTS = {
    "faults": "Interruptions and full disks",
    "inputs": "Files, options and requests",
}


class Defect(NamedTuple):
    """A defect that was found by attack and mended."""

    subject: str
    was: str
    now: str
    test: str  # path::name of the test that guards it


def defects(part: str) -> list[Defect]:
    """Defects of a part, as ``defects_PART.csv`` lists them."""
    path = _HERE / f"defects_{part}.csv"
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return [Defect(**row) for row in csv.DictReader(file)]


def markdown(records: Mapping[str, Record]) -> str:
    """Page of the records that were kept, as Markdown.

    Parameters
    ----------
    records : mapping
        Records by their part.

    Returns
    -------
    str
    """
    parts = [_text("intro"), *(_cases(records[part]) for part in _TITLES if part in records)]
    parts += [_text("mutants"), "\n".join(table(kept(FOLDER / "mutants.jsonl").values()))]
    parts.append(
        "## Defects found and corrected\n\nEach is guarded by a test, which `pytest -k NAME` runs."
    )
    parts += [_mended(part) for part in _DEFECTS if defects(part)]
    parts.append(_text("remains"))
    return "\n\n".join(parts) + "\n"


def _text(name: str) -> str:
    """Part of the page that is written by hand."""
    return (_HERE / f"{name}.md").read_text(encoding="utf-8").rstrip("\n")


def _cases(record: Record) -> str:
    lines = [
        f"## {_TITLES[record.part]}",
        "",
        f"{_number(record.held)} of {_number(record.cases)} cases held, on Python {record.python}, "
        f"NumPy {record.numpy}, {record.system}; `{record.command}`.",
        "",
        "| part | attack | cases | held |",
        "| --- | --- | --- | --- |",
    ]
    for _, rows in groupby(record.rows, key=lambda row: row.subject):
        for number, row in enumerate(rows):
            subject = "" if number else row.subject
            attack = row.attack if not row.notes else f"{row.attack} ({row.notes})"
            lines.append(f"| {subject} | {attack} | {_number(row.cases)} | {_number(row.held)} |")
    return "\n".join([*lines, *_broken(record)])


def _broken(record: Record) -> Iterator[str]:
    broken = [text for row in record.rows for text in row.broken]
    if broken:
        yield "\nFailed cases:\n"
        yield from (f"- {text}" for text in broken)


def _mended(part: str) -> str:
    lines = [
        f"### {_DEFECTS[part]}",
        "",
        "| where | what happened | what happens now | test |",
        "| --- | --- | --- | --- |",
    ]
    for one in defects(part):
        name = one.test.rpartition("::")[2]
        lines.append(f"| {one.subject} | {one.was} | {one.now} | `{name}` |")
    return "\n".join(lines)


def _number(count: int) -> str:
    return f"{count:,}".replace(",", " ") if count >= 10_000 else str(count)
