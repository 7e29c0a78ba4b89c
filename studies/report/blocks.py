"""What a report consists of: sections of what summaries have, figures, bars and listings.

Figures of matplotlib are SVG whose colours follow the page's theme. Texts stay texts, in the page's
type and read by a screen reader; colours become variables of the style sheet, so that a dark page
has light axes. Cells of maps are an image within the drawing.
"""

from __future__ import annotations

import html
import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from matplotlib.collections import QuadMesh

from studies.output.figures.options import FigureOptions
from studies.render.tables import Line, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Plot

    from studies.render.tables import Block as SummaryBlock


@dataclass(frozen=True)
class Figure:
    """A drawing as markup, which scrolls on a telephone, and its caption."""

    markup: str
    caption: str


class Fact(NamedTuple):
    """A key number: its label, value with its unit, and what it is measured by."""

    label: str
    value: str
    note: str = ""


@dataclass(frozen=True)
class Listing:
    """A text file as it stands."""

    title: str
    text: str


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
    sums: frozenset[str] = frozenset()

    @property
    def sum(self) -> float:
        """Sum of all amounts, or the first of a chain."""
        return self.rows[0][1] if self.sums else sum(amount for _, amount in self.rows)

    def bars(self) -> Iterator[tuple[str, str, str, float, float, bool]]:
        """Yield label, amount, share, begin and width of its bar [%], and whether it is a sum.

        A loss begins where the step before it has arrived.
        """
        whole, level, digits = self.sum or 1.0, 0.0, 1 if self.sums else 0
        for label, amount in self.rows:
            is_sum = label in self.sums
            before = level if self.sums and not is_sum else 0.0
            level = before + amount
            shares = (100.0 * end / whole for end in sorted((before, level)))
            low, high = (min(max(share, 0.0), 100.0) for share in shares)
            texts = label, format(amount, self.form), f"{100.0 * amount / whole:.{digits}f}"
            yield *texts, round(low, 2), round(high - low, 2), is_sum


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
            if isinstance(block, Figure | Bars | Listing):
                shown.append((type(block).__name__.lower(), block))
            elif isinstance(block, Table | tuple):
                tables = (block,) if isinstance(block, Table) else block
                shown.append(("tables", [replace(t, title=t.title or self.title) for t in tables]))
            else:
                line = Line(block) if isinstance(block, str) else block
                text = line.text
                if text.startswith(("- ", "  ")):
                    if not shown or shown[-1][0] != "items":
                        shown.append(("items", []))
                    shown[-1][1].append(text[2:])
                    continue
                if line.emphasis != "strong":  # which begin with a name
                    end = "" if text.endswith((".", ":")) else "."
                    text = f"{text[:1].upper()}{text[1:]}{end}"
                shown.append(("text", replace(line, text=text)))
        return shown


# ---- Figures of matplotlib

# Colours of the figures, and the variables of the style sheet that stand for them.
COLOURS = {
    "#000000": "ink",
    "#ffffff": "paper",
    "#262626": "ink",
    "#b0b0b0": "rule",
    "#cccccc": "rule",
    "#dddddd": "night",
    "#808080": "faint",
    "#404040": "soft",
    "#e69f00": "orange",
    "#0072b2": "blue",
    "#009e73": "green",
    "#d55e00": "vermillion",
    "#56b4e9": "sky",
    "#cc79a7": "purple",
    "#f0e442": "yellow",
}
_DOTS_PER_INCH = 110  # of images within a figure
_NOT_DRAWN = re.compile(r"<(metadata|style|title)\b.*?</\1>", re.S)
_GROUP = re.compile(r'<g id="[^"]*"')
_REFERRED = re.compile(r'(\bid="|url\(#|href="#)')  # what is left of ids, and what refers to them
_STYLE = re.compile(r' style="[^"]*"')
_COLOUR = re.compile(r"#[0-9a-fA-F]{6}\b")
_FAMILY = re.compile(r"font-family:[^;\"]*;?\s*")
# Matplotlib 3.9 writes size, style and family of a type in one.
_FONT = re.compile(r"font:\s*(?P<looks>[^;\"]*?)(?P<size>[\d.]+px)\s+[^;\"]*")
# White that lies on cells of a map stays white; where it fills, it is the page.
_DRAWN_WHITE = re.compile(r"(stroke:\s*)#ffffff", re.IGNORECASE)


def page_options(width_in: float, height_in: float | None = None) -> FigureOptions:
    """Return options of a figure on a page: without a title, which is the caption's."""
    style = resources.files("studies.report").joinpath("templates", "page.mplstyle")
    return FigureOptions(
        size_in=(width_in, height_in), dots_per_inch=_DOTS_PER_INCH, style=str(style), title=False
    )


def page_figure(plot: Plot, caption: str, *, title: str, key: str, words: str = "") -> Figure:
    """Return a figure of matplotlib as a block; ``words``: more for those who cannot see it."""
    # Cells of maps become an image: thousands of paths would be slow, with seams between them.
    for artist in (artist for axes in plot.axes for artist in axes.collections):
        if isinstance(artist, QuadMesh) and artist.get_array() is not None:
            artist.set_rasterized(True)
    buffer = io.StringIO()
    plot.savefig(
        buffer, format="svg", dpi=_DOTS_PER_INCH, transparent=True, metadata={"Date": None}
    )
    drawing = _NOT_DRAWN.sub("", buffer.getvalue())
    drawing = _GROUP.sub("<g", drawing).replace("xlink:href", "href")
    drawing = _REFERRED.sub(rf"\g<1>drawn-{key}-", drawing)
    drawing = _STYLE.sub(lambda style: _themed(style[0]), drawing)
    head, _, inside = drawing[drawing.index("<svg") :].partition(">")
    _, _, width, height = re.findall(r'viewBox="(\S+) (\S+) (\S+) (\S+)"', head)[0]
    markup = (
        f'<svg class="figure" role="img" aria-labelledby="{key}-drawn {key}-words" '
        f'viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
        f'<title id="{key}-drawn">{html.escape(title)}</title>'
        f'<desc id="{key}-words">{html.escape(f"{caption} {words}".strip())}</desc>{inside}'
    )
    return Figure(markup, caption)


def _themed(style: str) -> str:
    """Return a style with the page's colours and type."""

    def variable(match: re.Match[str]) -> str:
        name = COLOURS.get(match[0].lower())
        return match[0] if name is None else f"var(--{name})"

    def font(match: re.Match[str]) -> str:
        slanted = "italic" in match["looks"] or "oblique" in match["looks"]
        looks = "font-style: italic; " if slanted else ""
        weight = "font-weight: 600; " if "bold" in match["looks"] else ""
        return f"{looks}{weight}font-size: {match['size']}"

    style = _COLOUR.sub(variable, _DRAWN_WHITE.sub(r"\1white", style))
    return _FAMILY.sub("", _FONT.sub(font, style))
