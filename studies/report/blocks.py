"""What a report consists of: sections of texts, tables, bars, figures and listings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, TypeAlias

from studies.render.tables import Table


@dataclass(frozen=True)
class Text:
    """A paragraph; ``looks`` is ``plain``, ``faint``, ``warning`` or ``good``."""

    text: str
    looks: str = "plain"
    kind: ClassVar[str] = "text"


def sentence(clause: str, looks: str = "plain") -> Text:
    """Return a clause of a summary as a paragraph."""
    return Text(f"{clause[:1].upper()}{clause[1:]}.", looks)


@dataclass(frozen=True)
class Items:
    """A list of lines."""

    items: tuple[str, ...]
    kind: ClassVar[str] = "items"


@dataclass(frozen=True)
class Figure:
    """A drawing as markup, which scrolls on a telephone, and its caption."""

    markup: str
    caption: str
    kind: ClassVar[str] = "figure"


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
    kind: ClassVar[str] = "bars"

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
    """A key number: its label, value, unit, and what it is measured by."""

    label: str
    value: str
    unit: str = ""
    note: str = ""


@dataclass(frozen=True)
class Listing:
    """A text file as it stands."""

    title: str
    text: str
    kind: ClassVar[str] = "listing"


@dataclass(frozen=True)
class Tables:
    """Tables; two of them stand side by side where there is room."""

    tables: tuple[Table, ...]
    kind: ClassVar[str] = "tables"


Block: TypeAlias = "Text | Items | Figure | Bars | Listing | Tables"


@dataclass(frozen=True)
class Section:
    """A section under a heading."""

    key: str
    title: str
    blocks: Sequence[Block]
