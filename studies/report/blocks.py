"""What a report consists of: sections of what summaries have, figures, bars and listings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from studies.render.tables import Line, Table

if TYPE_CHECKING:
    from studies.render.tables import Block as SummaryBlock


def sentence(line: Line) -> Line:
    """Return a line of a summary as a paragraph; strong ones begin with a name."""
    if line.emphasis == "strong":
        return line
    end = "" if line.text.endswith((".", ":")) else "."
    return replace(line, text=f"{line.text[:1].upper()}{line.text[1:]}{end}")


@dataclass(frozen=True)
class Figure:
    """A drawing as markup, which scrolls on a telephone, and its caption."""

    markup: str
    caption: str


class Bar(NamedTuple):
    """Row of a table with bars: its texts, and begin and width of its bar [%]."""

    label: str
    amount: str
    share: str
    begin: float
    width: float
    is_sum: bool


@dataclass(frozen=True)
class Bars:
    """Amounts that add up, or a chain of losses, as a table with a bar each.

    ``rows``: label and amount. ``sums``: labels of the rows that say at which amount a chain of
    losses has arrived; without any the amounts add up to ``total``.
    """

    title: str
    unit: str
    form: str
    rows: tuple[tuple[str, float], ...]
    total: str = ""
    note: str = ""
    sums: frozenset[str] = frozenset()

    @property
    def sum(self) -> float:
        """Sum of all amounts, or the first of a chain."""
        return self.rows[0][1] if self.sums else sum(amount for _, amount in self.rows)

    def bars(self) -> Iterator[Bar]:
        """Yield the rows; a loss begins where the step before it has arrived."""
        whole, level = self.sum or 1.0, 0.0
        for label, amount in self.rows:
            is_sum = label in self.sums
            low, high = (0.0, amount) if is_sum or not self.sums else (level + amount, level)
            level = amount if is_sum else level + amount
            ends = sorted(min(max(100.0 * end / whole, 0.0), 100.0) for end in (low, high))
            yield Bar(
                label,
                format(amount, self.form),
                f"{100.0 * amount / whole:.{1 if self.sums else 0}f}",
                round(ends[0], 2),
                round(ends[1] - ends[0], 2),
                is_sum,
            )


@dataclass(frozen=True)
class Fact:
    """A key number: its label, value with its unit, and what it is measured by."""

    label: str
    value: str
    note: str = ""


@dataclass(frozen=True)
class Listing:
    """A text file as it stands."""

    title: str
    text: str


Block: TypeAlias = "SummaryBlock | Figure | Bars | Listing"


@dataclass(frozen=True)
class Section:
    """A section under a heading, also that of tables without a title of their own."""

    key: str
    title: str
    blocks: Sequence[Block]

    def shown(self) -> list[tuple[str, Any]]:
        """Return kind and content of what is shown: items and indented lines are one list."""
        shown: list[tuple[str, Any]] = []
        for block in self.blocks:
            if isinstance(block, Table | tuple):
                tables = (block,) if isinstance(block, Table) else block
                shown.append(("tables", [replace(t, title=t.title or self.title) for t in tables]))
            elif not isinstance(block, str | Line):
                shown.append((type(block).__name__.lower(), block))
            else:
                line = Line(block) if isinstance(block, str) else block
                if not line.text.startswith(("- ", "  ")):
                    shown.append(("text", sentence(line)))
                    continue
                if not shown or shown[-1][0] != "items":
                    shown.append(("items", []))
                shown[-1][1].append(line.text[2:])
        return shown
