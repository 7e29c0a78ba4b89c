"""Text laid out in a given width: paragraphs and columns, broken between words and never within.

What does not fit is given room step by step: headings are broken over lines, columns move closer
together, texts of cells are broken over lines, and in the end the columns are dealt out to several
blocks, each of which begins with the columns that name a row.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest

RULE = "\u2500"
_GAPS = (3, 2)  # between columns with headings: the wider one where there is room
_GAP_OF_FACTS = 2
_BESIDE = 5  # between tables that stand side by side
# Spaces at which no line is broken: between a number and its unit, a day and its month.
_GLUED = re.compile(
    r"(?<=\d) (?=(?:%|°|(?:deg|g|h|kg|m|m/s|ms|C|K|N|S|W|Wh|Wh/kg|"
    r"Jan|Feb|Mar|Apr|May|Jun|Jul|Aug|Sep|Oct|Nov|Dec)(?![\w/])))"
)
_GLUE = "\0"


def paragraph(text: str, width: int) -> list[str]:
    """Return a text as lines; after the first of an indented or itemised one they are indented.

    ``width``: characters of a line; only a longer word is longer.
    """
    indent = text[: len(text) - len(text.lstrip())]
    further = indent + ("  " if indent or text.startswith("- ") else "")
    return _broken(text.strip(), width, indent, further)


@dataclass(frozen=True)
class Grid:
    """Cells under headings, all as text.

    ``to_right``: whether a column is aligned to the right; its cells, numbers, are never broken.
    """

    headings: Sequence[str] | None
    rows: Sequence[Sequence[str]]
    to_right: Sequence[bool]
    sections: Sequence[int] = ()

    def lines(self, width: int) -> list[str]:
        """Return the grid as lines of at most that width, wider only where a word is."""
        every = list(range(len(self.to_right)))
        if not every:
            return []
        for gap in self._column_gaps():
            widths = self._widths(every, width, gap, whole_cells=True)
            if widths is not None:
                return self._block(every, widths, gap)
        gap = self._column_gaps()[-1]
        lines: list[str] = []
        for columns in self._dealt(width, gap):
            widths = self._widths(columns, width, gap, whole_cells=False)
            least = [self._least_width(i, whole_cell=False) for i in columns]
            lines += [""] if lines else []
            lines += self._block(columns, widths or least, gap)
        return lines

    def _column_gaps(self) -> tuple[int, ...]:
        return (_GAP_OF_FACTS,) if self.headings is None else _GAPS

    def _heading(self, i: int) -> str:
        return "" if self.headings is None else self.headings[i]

    def _least_width(self, i: int, *, whole_cell: bool) -> int:
        """Return the least width of a column: its longest word, or its longest cell."""
        whole = whole_cell or self.to_right[i]
        cells = [row[i] for row in self.rows]
        words = [len(word) for cell in cells for word in ([cell] if whole else _unbroken(cell))]
        return max([1, *words, *map(len, _unbroken(self._heading(i)))])

    def _widths(
        self, columns: Sequence[int], width: int, gap: int, *, whole_cells: bool
    ) -> list[int] | None:
        """Return widths of columns that together fit: the widest give first. None if none do.

        Headings are broken before cells are.
        """
        widths = [
            max([1, len(self._heading(i)), *(len(row[i]) for row in self.rows)]) for i in columns
        ]
        room = width - gap * (len(columns) - 1)
        for whole in (True, False)[: 1 if whole_cells else 2]:
            least = [self._least_width(i, whole_cell=whole) for i in columns]
            while sum(widths) > room and widths != least:
                slack = [(w, k) for k, w in enumerate(widths) if w > least[k]]
                widths[max(slack)[1]] -= 1
        return widths if sum(widths) <= room else None

    def _dealt(self, width: int, gap: int) -> list[list[int]]:
        """Return the columns of each block: those that name a row, and as many others as fit."""
        count = len(self.to_right)
        names = [0]
        if count > 2 and not self.to_right[0] and not self.to_right[1]:
            names = [0, 1]

        def needed(columns: Sequence[int]) -> int:
            return sum(self._least_width(i, whole_cell=False) + gap for i in columns) - gap

        blocks = [list(names)]
        for i in range(len(names), count):
            if needed([*blocks[-1], i]) > width and len(blocks[-1]) > len(names):
                blocks.append(list(names))
            blocks[-1].append(i)
        return blocks

    def _block(self, columns: Sequence[int], allowed: Sequence[int], gap: int) -> list[str]:
        """Return the lines of columns, each no wider than its longest line."""
        heads = [_broken(self._heading(i), w) for i, w in zip(columns, allowed, strict=True)]
        cells = [
            [_broken(row[i], w) for i, w in zip(columns, allowed, strict=True)] for row in self.rows
        ]
        texts = zip(heads, *cells, strict=True)
        widths = [max(len(line) for cell in column for line in cell) for column in texts]

        def line(parts: Sequence[str]) -> str:
            placed = (
                part.rjust(w) if self.to_right[i] else part.ljust(w)
                for i, part, w in zip(columns, parts, widths, strict=True)
            )
            return (" " * gap).join(placed).rstrip()

        lines = []
        if self.headings is not None:
            tallest = max(map(len, heads))
            low = [[""] * (tallest - len(head)) + head for head in heads]
            lines += [line(parts) for parts in zip(*low, strict=True)]
            lines.append(RULE * (sum(widths) + gap * (len(widths) - 1)))
        for number, row in enumerate(cells):
            if number in self.sections and number > 0:
                lines.append("")
            lines += [line(parts) for parts in zip_longest(*row, fillvalue="")]
        return lines


def side_by_side(left: Sequence[str], right: Sequence[str], width: int) -> list[str]:
    """Return two blocks of lines beside each other where there is room, else below each other."""
    widest = max(map(len, left), default=0) + _BESIDE
    if widest + max(map(len, right), default=0) > width:
        return [*left, "", *right]
    return [
        f"{first.ljust(widest)}{other}".rstrip()
        for first, other in zip_longest(left, right, fillvalue="")
    ]


def _broken(text: str, width: int, indent: str = "", further: str = "") -> list[str]:
    """Return the lines of a text; a number and its unit remain on one."""
    lines = textwrap.wrap(
        _GLUED.sub(_GLUE, text),
        width,
        initial_indent=indent,
        subsequent_indent=further,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(_GLUE, " ") for line in lines] or [""]


def _unbroken(text: str) -> list[str]:
    """Return the pieces of a text that are not broken over lines."""
    return _GLUED.sub(_GLUE, text).split()
