"""What a report consists of: sections of texts, tables, bars, figures and listings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from studies.render.tables import Table


@dataclass(frozen=True)
class Text:
    """A paragraph; ``looks`` is ``plain``, ``faint``, ``warning`` or ``good``."""

    text: str
    looks: str = "plain"
    kind: ClassVar[str] = "text"


def sentence(clause: str, looks: str = "plain") -> Text:
    """A clause of a summary as a paragraph."""
    return Text(f"{clause[:1].upper()}{clause[1:]}.", looks)


@dataclass(frozen=True)
class Items:
    """A list of lines."""

    items: tuple[str, ...]
    kind: ClassVar[str] = "items"


@dataclass(frozen=True)
class Figure:
    """A drawing as markup, and its caption.

    ``scrolls`` says that it is too wide for a telephone and is moved there under the finger.
    """

    markup: str
    caption: str
    scrolls: bool = False
    kind: ClassVar[str] = "figure"


@dataclass(frozen=True)
class Bars:
    """Amounts that add up, as a table with a bar each."""

    title: str
    unit: str
    form: str
    rows: tuple[tuple[str, float], ...]
    total: str = "total"
    note: str = ""
    kind: ClassVar[str] = "bars"

    @property
    def sum(self) -> float:
        """Sum of all amounts."""
        return sum(amount for _, amount in self.rows)

    def cells(self) -> list[tuple[str, str, str, float]]:
        """Label, amount, share in per cent as text, and width of the bar in per cent."""
        whole = self.sum or 1.0
        longest = max((amount for _, amount in self.rows), default=0.0) or 1.0
        return [
            (
                label,
                format(amount, self.form),
                f"{100.0 * amount / whole:.0f}",
                round(100.0 * max(amount, 0.0) / longest, 1),
            )
            for label, amount in self.rows
        ]


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
