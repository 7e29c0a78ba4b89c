"""What a run of attacks found, and where such records are kept."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

from missions.files.writing import write_text_atomically
from solar._version import __version__

__all__ = ["FOLDER", "Record", "Row", "kept", "merged", "of_cases"]

FOLDER = Path(__file__).parent / "records"


@dataclass(frozen=True)
class Row:
    """Cases of one kind.

    Attributes
    ----------
    subject : str
        What is attacked: a command, a reader, a way to compute.
    attack : str
        What is done to it.
    cases : int
        How often.
    held : int
        How often everything was as it must be.
    broken : tuple of str
        What was not, in a few words with what repeats it; the first ten.
    notes : str
        What the cases show besides, such as how many chunks were kept.
    """

    subject: str
    attack: str
    cases: int
    held: int
    broken: tuple[str, ...] = ()
    notes: str = ""


@dataclass(frozen=True)
class Record:
    """A run of one part: ``faults`` or ``inputs``."""

    part: str
    command: str
    seed: int
    seconds: float
    rows: tuple[Row, ...]
    version: str = __version__
    python: str = field(default_factory=platform.python_version)
    numpy: str = np.__version__
    system: str = field(default_factory=platform.system)

    @property
    def cases(self) -> int:
        """All cases."""
        return sum(row.cases for row in self.rows)

    @property
    def held(self) -> int:
        """Cases in which everything was as it must be."""
        return sum(row.held for row in self.rows)

    def keep(self, folder: Path = FOLDER) -> None:
        """Write this record in place of the one that was kept of the same part, if there is one."""
        folder.mkdir(exist_ok=True)
        text = json.dumps(asdict(self), indent=1, ensure_ascii=False)
        write_text_atomically(folder / f"{self.part}.json", text + "\n")


def merged(old: Record | None, new: Record) -> Record:
    """Record of all kinds of cases, of some of which there are newer ones.

    Parameters
    ----------
    old : Record or None
        What was kept.
    new : Record
        A run of some kinds.

    Returns
    -------
    Record
        Rows of the old one, each replaced by the new one of its kind; others stand at the end.
    """
    if old is None:
        return new
    rows = {(row.subject, row.attack): row for row in (*old.rows, *new.rows)}
    return replace(new, seconds=old.seconds + new.seconds, rows=tuple(rows.values()))


def kept(folder: Path = FOLDER) -> dict[str, Record]:
    """Records that were kept, by their part."""
    found = {}
    for path in sorted(folder.glob("*.json")):
        data = json.loads(path.read_text(encoding="utf-8"))
        rows = tuple(Row(**{**row, "broken": tuple(row["broken"])}) for row in data.pop("rows"))
        found[path.stem] = Record(**data, rows=rows)
    return found


def of_cases(subject: str, attack: str, found: Iterable[str | None], notes: str = "") -> Row:
    """Row of cases that were told one by one.

    Parameters
    ----------
    subject, attack : str
        As in :class:`Row`.
    found : iterable of str or None
        For each case what was wrong, None where nothing was.
    notes : str
        As in :class:`Row`.

    Returns
    -------
    Row
    """
    cases = list(found)
    broken = [one for one in cases if one is not None]
    return Row(subject, attack, len(cases), len(cases) - len(broken), tuple(broken[:10]), notes)
