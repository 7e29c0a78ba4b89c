"""Tables and summaries of results: one description, rendered for every reader.

A :class:`Table` holds plain values with a name, a label and a unit for every column. It renders
itself as text (rich), Markdown, HTML, CSV or a pandas frame. A :class:`Summary` is a few lines and
tables in the order in which they are read. Results describe themselves in these terms and know
nothing of terminals, pages or files.
"""

from __future__ import annotations

import csv
import html
import io
import math
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

if TYPE_CHECKING:
    import pandas as pd
    from rich.console import RenderableType

    Block: TypeAlias = "str | Line | Table | tuple[Table, ...]"

UNLIMITED = "unlimited"
MISSING = "-"
_WIDTH = 80

Emphasis = Literal["plain", "strong", "faint", "warning"]
_STYLES: dict[Emphasis, str] = {
    "plain": "",
    "strong": "bold",
    "faint": "dim",
    "warning": "bold red",
}


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Parameters
    ----------
    name : str
        Name in frames and CSV, with its unit: ``excess_time_h``.
    label : str
        Heading for people; the name without underscores if left out.
    unit : str
        Unit that the heading shows in brackets.
    form : str
        Format of numbers, such as ``.2f``; ``{:+.1f} %`` where text surrounds them.
    missing : str
        What stands for a value that does not exist.
    """

    name: str
    label: str = ""
    unit: str = ""
    form: str = ""
    missing: str = MISSING

    @property
    def heading(self) -> str:
        """Label with its unit."""
        label = self.label or self.name.replace("_", " ")
        return f"{label} [{self.unit}]" if self.unit else label

    def text(self, value: Any) -> str:
        """Value as people read it: numbers in the column's format, infinity as ``unlimited``."""
        if value is None or (isinstance(value, float) and math.isnan(value)):
            return self.missing
        if isinstance(value, str):
            return value
        if isinstance(value, bool):
            return "yes" if value else "no"
        if math.isinf(value):
            return UNLIMITED if value > 0 else f"-{UNLIMITED}"
        return self.form.format(value) if "{" in self.form else format(value, self.form)


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
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(
                    f"{self.title or 'table'}: a row has {len(row)} values for "
                    f"{len(self.columns)} columns"
                )

    def texts(self) -> list[list[str]]:
        """Cells as people read them, row by row."""
        return [
            [column.text(value) for column, value in zip(self.columns, row, strict=True)]
            for row in self.rows
        ]

    def is_numeric(self, index: int) -> bool:
        """Whether a column is aligned to the right: it holds numbers, or facts beside labels."""
        if not self.headings:
            return index > 0
        values = [row[index] for row in self.rows if row[index] is not None]
        return bool(values) and not any(isinstance(value, str) for value in values)

    def to_text(self, width: int = _WIDTH) -> str:
        """Table as text of at most that many columns of characters."""
        return Summary((self,)).to_text(width)

    def to_markdown(self) -> str:
        """Table in GitHub's Markdown, its notes below."""
        rule = ["---:" if self.is_numeric(i) else "---" for i in range(len(self.columns))]
        head = [column.heading if self.headings else "" for column in self.columns]
        rows = [head, rule, *([c.replace("|", "\\|") for c in cells] for cells in self.texts())]
        lines = ["| " + " | ".join(cells) + " |" for cells in rows]
        if self.notes:
            lines += ["", *self.notes]
        return "\n".join(lines) + "\n"

    def to_csv(self) -> str:
        """Table as CSV under its columns' names, numbers with all their digits."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow([column.name for column in self.columns])
        writer.writerows(["" if value is None else value for value in row] for row in self.rows)
        return out.getvalue()

    def to_html(self) -> str:
        """Table as an HTML fragment."""
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
        """Table as a pandas frame under its columns' names."""
        import pandas as pd

        frame = pd.DataFrame(list(self.rows), columns=[column.name for column in self.columns])
        frame.attrs["title"] = self.title
        frame.attrs["units"] = {c.name: c.unit for c in self.columns if c.unit}
        return frame

    def renderable(self) -> RenderableType:
        """Table for a rich console."""
        from rich import box
        from rich.table import Table as RichTable
        from rich.text import Text

        table = RichTable(
            title=Text(self.title, style="bold") if self.title else None,
            title_justify="left",
            show_header=self.headings,
            box=box.SIMPLE_HEAD if self.headings else None,
            pad_edge=False,
            show_edge=False,
            header_style="",
        )
        for i, heading in enumerate(self._headings()):
            justify: Literal["right", "left"] = "right" if self.is_numeric(i) else "left"
            table.add_column(Text(heading), justify=justify, overflow="fold")
        for i, cells in enumerate(self.texts()):
            if i in self.sections and i > 0:
                table.add_section()
            table.add_row(*map(Text, cells))
        return table

    def _headings(self) -> list[str]:
        """Headings, broken between words where the table would be too wide: cells stay whole."""
        headings = [column.heading for column in self.columns]
        cells = [max(map(len, column), default=0) for column in zip(*self.texts(), strict=True)]
        widths = map(max, map(len, headings), cells)
        if not cells or sum(widths) + 2 * len(cells) <= _WIDTH:
            return headings
        return [
            textwrap.fill(heading, max(width, 1, *map(len, heading.split())))
            for heading, width in zip(headings, cells, strict=True)
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

    def renderables(self) -> list[RenderableType]:
        """Blocks for a rich console; a titled table stands apart from what comes before it."""
        return list(_renderables(self.blocks))

    def to_text(self, width: int = _WIDTH) -> str:
        """Summary as text of at most that many columns of characters."""
        from rich.console import Console

        console = Console(
            file=io.StringIO(), width=width, highlight=False, markup=False, emoji=False,
            color_system=None, legacy_windows=False, force_terminal=False,
        )  # fmt: skip
        console.print(*self.renderables(), sep="\n")
        text: str = console.file.getvalue()  # type: ignore[attr-defined]  # it is a StringIO
        return "\n".join(line.rstrip() for line in text.rstrip("\n").split("\n"))

    def to_html(self) -> str:
        """Summary as an HTML fragment."""
        parts = []
        for block in self.blocks:
            for one in block if isinstance(block, tuple) else (block,):
                if isinstance(one, Table):
                    parts.append(one.to_html())
                else:
                    text = one.text if isinstance(one, Line) else one
                    parts.append(f"<p>{html.escape(text)}</p>")
        return "".join(parts)

    def __str__(self) -> str:
        return self.to_text()

    def _repr_html_(self) -> str:
        return self.to_html()


class Result:
    """A result that describes itself: as text, in a notebook, and in one line."""

    def headline(self) -> str:
        """Result in one line."""
        raise NotImplementedError

    def summary(self) -> Summary:
        """Result as people read it."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.headline()}>"

    def __str__(self) -> str:
        return self.summary().to_text()

    def _repr_html_(self) -> str:
        return self.summary().to_html()


def facts(title: str, rows: Iterable[tuple[str, str]], notes: Sequence[str] = ()) -> Table:
    """Table of labels and their values, already as text.

    Parameters
    ----------
    title : str
        Heading; may be empty.
    rows : iterable of (label, text)
    notes : sequence of str
        Lines below.

    Returns
    -------
    Table
    """
    columns = (Column("quantity"), Column("value"))
    return Table(title, columns, tuple(tuple(row) for row in rows), tuple(notes), headings=False)


def _renderables(blocks: Iterable[Block]) -> Iterable[RenderableType]:
    from rich.columns import Columns
    from rich.text import Text

    for i, block in enumerate(blocks):
        first = i == 0
        if isinstance(block, str):
            yield Text(block)
        elif isinstance(block, Line):
            yield Text(block.text, style=_STYLES[block.emphasis])
        elif isinstance(block, Table):
            if block.title and not first:
                yield Text("")
            yield block.renderable()
            yield from map(Text, block.notes)
        else:
            yield Columns([one.renderable() for one in block], padding=(0, 5))
            for one in block:
                yield from map(Text, one.notes)
