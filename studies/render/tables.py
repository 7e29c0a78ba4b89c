"""Tables and summaries of results: one description, rendered for every reader.

A :class:`Table` holds plain values with a name, a label and a unit for every column. It renders
itself as text, Markdown, HTML, CSV or a pandas frame. A :class:`Summary` is a few lines and
tables in the order in which they are read.
"""

from __future__ import annotations

import csv
import io
import math
import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from sizing.parameters import unit_text
from sizing.results.result import data_frame

if TYPE_CHECKING:
    import pandas as pd

    Block: TypeAlias = "str | Line | Table | tuple[Table, ...]"

SUMMARY, ALL = 1, 2  # levels of a result
UNLIMITED = "unlimited"
MISSING = "-"
CLOCK = "clock"  # form of hours of a day
_WIDTH = 80
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

Emphasis = Literal["plain", "strong", "faint", "warning", "good"]
StyledLine: TypeAlias = tuple[str, Emphasis]


@dataclass(frozen=True)
class Column:
    """A column of a table.

    ``name``: name in frames and CSV, with its unit: ``excess_time_h``. ``label``: words for people;
    the name without underscores if left out; ``head``: in headings, where they are shorter.
    ``form``: format of numbers, such as ``.2f``; ``.1%`` for shares in per cent, ``clock`` for
    hours of a day; ``{:+.1f} kg`` where text surrounds them. ``missing``: what stands for a value
    that does not exist. ``to_right``: whether its cells are aligned to the right; by default
    numbers and the values of facts are. ``digits``: significant digits that numbers are rounded to
    before they are formatted; all by default.
    """

    name: str
    label: str = ""
    unit: str = ""
    form: str = ""
    missing: str = MISSING
    to_right: bool | None = None
    digits: int | None = None
    head: str = ""

    @property
    def shown_unit(self) -> str:
        """Unit as people read it: per cent of shares."""
        return "%" if self.is_share else unit_text(self.unit)

    @property
    def is_share(self) -> bool:
        """Whether numbers are written in per cent."""
        return self.form.endswith("%") and "{" not in self.form

    @property
    def heading(self) -> str:
        """Heading of a table, with the unit."""
        label = self.head or self.label or self.name.replace("_", " ")
        return f"{label} [{self.shown_unit}]" if self.shown_unit else label

    def text(self, value: Any) -> str:
        """Return a value as people read it: in the column's format, infinity as ``unlimited``."""
        if value is None or (isinstance(value, float) and math.isnan(value)):
            return self.missing
        if isinstance(value, str):
            return value
        if isinstance(value, Mapping):
            return ", ".join(map(self.text, value.values()))
        # Of an array or a spread both ends; a list of names imports neither.
        ends = value
        if getattr(value, "ndim", 0):
            from sizing.results.design_result import Spread

            ends = Spread.of(value)
        if hasattr(ends, "lowest"):
            return " to ".join(dict.fromkeys(map(self.text, (ends.lowest, ends.highest))))
        if isinstance(value, bool):
            return "yes" if value else "no"
        if math.isinf(value):
            return UNLIMITED if value > 0 else f"-{UNLIMITED}"
        if self.form == CLOCK:
            return clock_label(value)
        if self.digits is not None:
            value = float(f"{value:.{self.digits}g}")
        if "{" in self.form:
            return self.form.format(value)
        text = format(value, self.form)
        return text[:-1] if self.is_share else text


@dataclass(frozen=True)
class Table:
    """Rows of plain values under described columns.

    Parameters
    ----------
    title : str
        Heading of the table; may be empty.
    columns : sequence of Column
    rows : sequence of sequences
        One value per column: numbers, texts, truth values, or None where there is none.
    notes : sequence of str
        Lines below the table.
    headings : bool
        Whether the columns' headings are shown; without them a table reads as a list of facts.
    sections : sequence of int
        Rows above which a line is drawn.
    """

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Any, ...], ...]
    notes: tuple[str, ...] = ()
    headings: bool = True
    sections: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        count = len(self.columns)
        for row in self.rows:
            if len(row) != count:
                words = f"a row has {len(row)} values for {count} columns"
                raise ValueError(f"{self.title or 'table'}: {words}")

    def texts(self) -> list[list[str]]:
        """Return the cells as people read them, row by row."""
        return [
            [column.text(value) for column, value in zip(self.columns, row, strict=True)]
            for row in self.rows
        ]

    def is_numeric(self, index: int) -> bool:
        """Return whether a column is aligned to the right, as numbers and facts are."""
        if (to_right := self.columns[index].to_right) is not None:
            return to_right
        if not self.headings:
            return index > 0
        values = [row[index] for row in self.rows if row[index] is not None]
        return bool(values) and not any(isinstance(value, str) for value in values)

    def to_text(self, width: int = _WIDTH) -> str:
        """Return the table as text of at most that many columns of characters."""
        return Summary((self,)).to_text(width)

    def to_markdown(self) -> str:
        """Return the table in GitHub's Markdown, its notes below."""
        rule = ["---:" if self.is_numeric(i) else "---" for i in range(len(self.columns))]
        head = [column.heading if self.headings else "" for column in self.columns]
        rows = [head, rule, *([c.replace("|", "\\|") for c in cells] for cells in self.texts())]
        lines = ["| " + " | ".join(cells) + " |" for cells in rows]
        if self.notes:
            lines += ["", *self.notes]
        return "\n".join(lines) + "\n"

    def to_csv(self) -> str:
        """Return the table as CSV under its columns' names, numbers with all their digits."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow([column.name for column in self.columns])
        writer.writerows(["" if value is None else value for value in row] for row in self.rows)
        return out.getvalue()

    def to_html(self) -> str:
        """Return the table as an HTML fragment."""
        import html  # which a terminal does not need

        parts = ["<table>"]
        if self.title:
            parts.append(f"<caption>{html.escape(self.title)}</caption>")
        if self.headings:
            heads = "".join(f"<th>{html.escape(c.heading)}</th>" for c in self.columns)
            parts.append(f"<thead><tr>{heads}</tr></thead>")
        parts.append("<tbody>")
        for cells in self.texts():
            parts.append("<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in cells) + "</tr>")
        parts.append("</tbody></table>")
        parts += [f"<p>{html.escape(note)}</p>" for note in self.notes]
        return "".join(parts)

    def to_frame(self) -> pd.DataFrame:
        """Return the table as a pandas frame under its columns' names."""
        frame = data_frame(list(self.rows), [column.name for column in self.columns])
        frame.attrs["title"] = self.title
        frame.attrs["units"] = {c.name: c.unit for c in self.columns if c.unit}
        return frame

    def styled_lines(self, width: int = _WIDTH) -> list[StyledLine]:
        """Return the lines of the table with their emphasis: title, cells and notes."""
        title = paragraph(self.title, width) if self.title else []
        notes = [line for note in self.notes for line in paragraph(note, width)]
        heads = [column.heading for column in self.columns] if self.headings else None
        to_right = [self.is_numeric(i) for i in range(len(self.columns))]
        grid = Grid(heads, self.texts(), to_right, self.sections)
        return [
            *((line, "strong") for line in title),
            *((line, "plain") for line in (*grid.lines(width), *notes)),
        ]

    def __str__(self) -> str:
        return self.to_text()

    def _repr_html_(self) -> str:
        return self.to_html()


@dataclass(frozen=True)
class Line:
    """A line of a summary with its emphasis; plain lines may be plain strings."""

    text: str
    emphasis: Emphasis = "plain"


@dataclass(frozen=True)
class Summary:
    """Lines and tables in the order in which they are read; tables in a tuple stand side by side.

    Parameters
    ----------
    blocks : sequence of str, Line, Table or tuple of Table
    """

    blocks: tuple[Block, ...] = field(default=())

    def __add__(self, other: Summary) -> Summary:
        return Summary((*self.blocks, *other.blocks))

    def styled_lines(self, width: int = _WIDTH) -> list[StyledLine]:
        """Return lines with their emphasis; a titled table stands apart from what is before it."""
        lines: list[StyledLine] = []
        for block in self.blocks:
            if isinstance(block, str | Line):
                line = Line(block) if isinstance(block, str) else block
                lines += [(text, line.emphasis) for text in paragraph(line.text, width)]
            elif isinstance(block, Table):
                lines += [("", "plain")] if block.title and lines else []
                lines += block.styled_lines(width)
            else:
                lines += [("", "plain")] if any(table.title for table in block) and lines else []
                lines += _beside(block, width)
        return lines

    def to_text(self, width: int = _WIDTH) -> str:
        """Return the summary as text of at most that many columns; words are never broken."""
        return "\n".join(line for line, _ in self.styled_lines(width))

    def to_html(self) -> str:
        """Return the summary as an HTML fragment."""
        import html  # likewise

        parts = []
        for block in self.blocks:
            if isinstance(block, str | Line):
                text = block.text if isinstance(block, Line) else block
                parts.append(f"<p>{html.escape(text)}</p>")
            else:
                parts += [t.to_html() for t in ((block,) if isinstance(block, Table) else block)]
        return "".join(parts)

    def __str__(self) -> str:
        return self.to_text()

    def _repr_html_(self) -> str:
        return self.to_html()


def clock_label(clock_h: float | None) -> str:
    """Return hours as a clock reading; ``-`` where there is no such time."""
    if clock_h is None or not math.isfinite(clock_h):
        return MISSING
    days, rest = divmod(round(clock_h * 60.0), 24 * 60)
    return "24:00" if days == 1 and rest == 0 else f"{rest // 60:02d}:{rest % 60:02d}"


def facts(title: str, rows: Iterable[tuple[str, str]], notes: Sequence[str] = ()) -> Table:
    """Return a table of labels and their values, already as text."""
    columns = (Column("quantity"), Column("value"))
    return Table(title, columns, tuple(tuple(row) for row in rows), tuple(notes), headings=False)


def _beside(tables: Sequence[Table], width: int) -> list[StyledLine]:
    """Return tables side by side as far as there is room, their notes below."""
    first, *others = (replace(t, notes=()).to_text(width).split("\n") for t in tables)
    for block in others:
        first = side_by_side(first, block, width)
    notes = [line for table in tables for note in table.notes for line in paragraph(note, width)]
    return [(line, "plain") for line in (*first, *notes)]


# ---- Text in a given width, broken between words and never within
#
# What does not fit is given room step by step: headings are broken over lines, columns move closer
# together, texts of cells are broken over lines, and in the end the columns are dealt out to
# several blocks, each of which begins with the columns that name a row.


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
        gaps = (_GAP_OF_FACTS,) if self.headings is None else _GAPS
        for gap in gaps:
            widths = self._widths(every, width, gap, (True,))
            if sum(widths) + gap * (len(widths) - 1) <= width:
                return self._block(every, widths, gap)
        blocks = (
            self._block(columns, self._widths(columns, width, gaps[-1], (True, False)), gaps[-1])
            for columns in self._dealt(width, gaps[-1])
        )
        return [line for block in blocks for line in ("", *block)][1:]

    def _texts(self, i: int) -> list[str]:
        """Return the heading of a column, empty where there is none, and its cells."""
        return ["" if self.headings is None else self.headings[i], *(row[i] for row in self.rows)]

    def _least_width(self, i: int, *, whole_cell: bool) -> int:
        """Return the least width of a column: its longest word, or its longest cell."""
        heading, *cells = self._texts(i)
        if not (whole_cell or self.to_right[i]):
            cells = [word for cell in cells for word in _unbroken(cell)]
        return max([1, *map(len, cells), *map(len, _unbroken(heading))])

    def _widths(
        self, columns: Sequence[int], width: int, gap: int, stages: Sequence[bool]
    ) -> list[int]:
        """Return widths of columns, the widest of which give until they fit, or cannot.

        ``stages``: whether cells remain whole while they give: headings are broken before cells.
        """
        widths = [max([1, *map(len, self._texts(i))]) for i in columns]
        room = width - gap * (len(columns) - 1)
        for whole_cell in stages:
            least = [self._least_width(i, whole_cell=whole_cell) for i in columns]
            while sum(widths) > room and widths != least:
                slack = [(w, k) for k, w in enumerate(widths) if w > least[k]]
                widths[max(slack)[1]] -= 1
        return widths

    def _dealt(self, width: int, gap: int) -> list[list[int]]:
        """Return the columns of each block: those that name a row, and as many others as fit."""
        count = len(self.to_right)
        named = 2 if count > 2 and not any(self.to_right[:2]) else 1
        names = list(range(named))
        least = [self._least_width(i, whole_cell=False) + gap for i in range(count)]
        blocks = [[*names]]
        for i in range(named, count):
            needed = sum(least[k] for k in (*blocks[-1], i)) - gap
            if needed > width and len(blocks[-1]) > named:
                blocks.append([*names])
            blocks[-1].append(i)
        return blocks

    def _block(self, columns: Sequence[int], allowed: Sequence[int], gap: int) -> list[str]:
        """Return the lines of columns, each no wider than its longest line."""
        broken = [
            [_broken(text, w) for text in self._texts(i)]
            for i, w in zip(columns, allowed, strict=True)
        ]
        widths = [max(len(line) for cell in column for line in cell) for column in broken]

        def line(parts: Sequence[str]) -> str:
            placed = (
                part.rjust(w) if self.to_right[i] else part.ljust(w)
                for i, part, w in zip(columns, parts, widths, strict=True)
            )
            return (" " * gap).join(placed).rstrip()

        heads, *rows = zip(*broken, strict=True)
        lines = []
        if self.headings is not None:
            low = zip_longest(*(head[::-1] for head in heads), fillvalue="")
            lines = [line(parts) for parts in low][::-1]
            lines.append(RULE * (sum(widths) + gap * (len(widths) - 1)))
        for number, row in enumerate(rows):
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
