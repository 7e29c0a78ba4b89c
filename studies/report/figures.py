"""Figures of matplotlib as part of a page: SVG whose colours follow the page's theme.

Texts stay texts, in the page's type and read by a screen reader; colours become variables of the
style sheet, so that a dark page has light axes. Cells of maps are an image within the drawing.
"""

from __future__ import annotations

import html
import io
import re
from importlib import resources
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from matplotlib.collections import QuadMesh

from studies.output.figures.options import FigureOptions
from studies.report.blocks import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Plot

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
_SVG, _XLINK = "http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"
_COLOUR = re.compile(r"#[0-9a-fA-F]{6}\b")
_FAMILY = re.compile(r"font-family:[^;]*;?\s*")
_FONT = re.compile(r"font:\s*(?P<looks>[^;]*?)(?P<size>[\d.]+px)\s+[^;]*")
_REFERENCE = re.compile(r"(url\(#)([^)]+)")
# White that lies on cells of a map stays white; where it fills, it is the page.
_DRAWN_WHITE = re.compile(r"(stroke:\s*)#ffffff", re.IGNORECASE)


def page_options(width_in: float, height_in: float | None = None) -> FigureOptions:
    """Return options of a figure on a page: without a title, which is the caption's."""
    style = resources.files("studies.report").joinpath("templates", "page.mplstyle")
    return FigureOptions(
        size_in=(width_in, height_in), dots_per_inch=_DOTS_PER_INCH, style=str(style), title=False
    )


def page_figure(figure: Plot, caption: str, *, title: str, description: str, key: str) -> Figure:
    """Return a figure of matplotlib as a block, which scrolls on a telephone."""
    markup = figure_markup(figure, title=title, description=description, key=key)
    return Figure(markup, caption)


def figure_markup(figure: Plot, *, title: str, description: str, key: str) -> str:
    """Make a figure an element of a page."""
    # Cells of maps become an image: thousands of paths would be slow, with seams between them.
    for artist in (artist for axes in figure.axes for artist in axes.collections):
        if isinstance(artist, QuadMesh) and artist.get_array() is not None:
            artist.set_rasterized(True)
    buffer = io.BytesIO()
    figure.savefig(
        buffer, format="svg", dpi=_DOTS_PER_INCH, transparent=True, metadata={"Date": None}
    )
    return inline_svg(buffer.getvalue(), title=title, description=description, key=f"drawn-{key}")


def inline_svg(svg: bytes, *, title: str, description: str, key: str) -> str:
    """Make a drawing of matplotlib's part of a page."""
    root = ElementTree.fromstring(svg)
    for parent in root.iter():
        for child in list(parent):
            if child.tag in (f"{{{_SVG}}}metadata", f"{{{_SVG}}}style", f"{{{_SVG}}}title"):
                parent.remove(child)
    _rename(root, key)
    drawing = ElementTree.tostring(root, encoding="unicode")
    drawing = re.sub(r"<(/?)(?:ns\d+|svg):", r"<\1", drawing)
    inside = drawing[drawing.index(">") + 1 : drawing.rindex("</svg>")]
    _, _, width, height = root.attrib["viewBox"].split()
    title_element = f'<title id="{key}-title">{html.escape(title)}</title>'
    title_element += f'<desc id="{key}-desc">{html.escape(description)}</desc>'
    return (
        f'<svg class="figure" role="img" aria-labelledby="{key}-title {key}-desc" '
        f'viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
        f"{title_element}{inside}</svg>"
    )


def _rename(root: ElementTree.Element, key: str) -> None:
    """Give every id that is referred to a name of its own on the page, and colours theirs."""
    referred: set[str] = set()
    for node in root.iter():
        for name, value in node.attrib.items():
            referred.update(match[2] for match in _REFERENCE.finditer(value))
            if name == f"{{{_XLINK}}}href" and value.startswith("#"):
                referred.add(value[1:])
    for node in root.iter():
        for name, value in list(node.attrib.items()):
            if name == "id":
                del node.attrib[name]
                if value in referred:
                    node.attrib[name] = f"{key}-{value}"
            elif name == f"{{{_XLINK}}}href":
                del node.attrib[name]
                node.attrib["href"] = f"#{key}-{value[1:]}" if value.startswith("#") else value
            else:
                node.attrib[name] = _themed(_REFERENCE.sub(rf"\1{key}-\2", value))


def _themed(value: str) -> str:
    """Return a style with the page's colours and type."""

    def variable(match: re.Match[str]) -> str:
        name = COLOURS.get(match[0].lower())
        return match[0] if name is None else f"var(--{name})"

    def font(match: re.Match[str]) -> str:
        slanted = "italic" in match["looks"] or "oblique" in match["looks"]
        looks = "font-style: italic; " if slanted else ""
        weight = "font-weight: 600; " if "bold" in match["looks"] else ""
        return f"{looks}{weight}font-size: {match['size']}"

    value = _DRAWN_WHITE.sub(r"\1white", value)
    return _FAMILY.sub("", _FONT.sub(font, _COLOUR.sub(variable, value)))
