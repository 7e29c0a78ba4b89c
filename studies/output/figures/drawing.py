"""How every figure begins and ends: its canvas in the style that was asked for, palette, file.

Figures are drawn on their own canvas and returned, never shown.
"""

from __future__ import annotations

import functools
import inspect
import io
import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, ParamSpec, TypeAlias

from missions.files.writing import write_bytes_atomically
from sizing.program.objectives import Objective
from solar.names import MODEL_NAMES
from studies.output.figures.options import (
    DEFAULT,
    DOTS_PER_INCH,
    SETTINGS,
    SHIPPED_STYLES,
    FigureOptions,
    check_dots,
    in_style,
    library,
    style_settings,
    type_within,
)
from studies.output.formats import IMAGE_FORMATS, format_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# Where a figure is drawn: on a canvas of its own as these options ask for, or on one that is given.
Canvas: TypeAlias = "FigureOptions | Figure"
Arguments = ParamSpec("Arguments")

# Okabe & Ito's palette: told apart by readers with any colour vision, and in grey.
ORANGE, BLUE, GREEN, VERMILLION = "#E69F00", "#0072B2", "#009E73", "#D55E00"
SKY, PURPLE = "#56B4E9", "#CC79A7"
GREY, DARK_GREY = "#DDDDDD", "#808080"
SUN, LOAD, CHARGE = ORANGE, BLUE, GREEN
# A line style for each colour, so that print in grey is read as well.
_LOOKS = (ORANGE, ":"), (SKY, "-."), (GREEN, "--"), (VERMILLION, "-")
MODEL_LOOKS: dict[str, dict[str, Any]] = {
    model: {"color": colour, "linestyle": line}
    for model, (colour, line) in zip(MODEL_NAMES, _LOOKS, strict=True)
}
_DARK_NIGHT = "#404040"
_USUAL_TYPE = 10.0  # [pt], for which the sizes of figures are meant
_NARROW_IN = 6.5  # in the usual type
_OF_FIGURES = """\
figure : FigureOptions or Figure
    How the figure looks, or one that is drawn on.

Returns
-------
Figure"""


def styled(draw: Callable[Arguments, Figure]) -> Callable[Arguments, Figure]:
    """Make a function draw in the style of its keyword ``figure``.

    A figure that is given in its place is drawn on as it is, in the settings of its owner; so is
    the place of axes that are given as ``ax``, in smaller type where it is small. The docstring
    gets ``figure`` as its last parameter, and what is returned.
    """

    @functools.wraps(draw)
    def drawn(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Figure:
        axes: Any = kwargs.pop("ax", None)
        if axes is not None:
            kwargs["figure"] = part = _in_place_of(axes)
            with _in_type_of(part):
                return draw(*args, **kwargs)
        canvas = kwargs.get("figure", DEFAULT)
        if not isinstance(canvas, FigureOptions):
            return draw(*args, **kwargs)
        with in_style(canvas):
            return draw(*args, **kwargs)

    if "Parameters\n" in (text := inspect.getdoc(draw) or ""):
        described, raises, errors = text.partition("\n\nRaises\n")
        drawn.__doc__ = f"{described}\n{_OF_FIGURES}{raises}{errors}"
    return drawn


@contextmanager
def _in_type_of(part: Any) -> Iterator[None]:
    """Draw in type that fits a part of a figure; its ticks are made later, and are told theirs."""
    from matplotlib.font_manager import FontProperties

    size = type_within(_setting("font.size"), *(part.bbox.size / part.dpi))
    with SETTINGS, library().rc_context({"font.size": size}):
        yield
        for axis in (axis for axes in part.axes for axis in (axes.xaxis, axes.yaxis)):
            size = FontProperties(size=_setting(f"{axis.axis_name}tick.labelsize")).get_size()
            axis.set_tick_params(labelsize=size)


def _in_place_of(axes: Axes) -> Any:
    """Return the part of a figure where axes were: a drawing may have panels and a heading.

    The figure is laid out by constraints where its owner has chosen no layout: heading and legend
    of the part then stay within it. Its heading is the title of the axes until it has another.
    """
    place = axes.get_subplotspec()
    figure = axes.figure
    if place is None or figure is None:
        raise ValueError("ax must be axes of a grid, as plt.subplots makes them")
    whole: Any = figure.figure
    if whole.get_layout_engine() is None:
        whole.set_layout_engine("constrained")
    part = figure.add_subfigure(place)
    if axes.get_title():
        part.suptitle(axes.get_title())
    axes.remove()
    return part


def new_figure(
    rows: int = 1,
    columns: int = 1,
    *,
    canvas: Canvas = DEFAULT,
    title: str = "",
    notes: Sequence[str] = (),
    size_in: tuple[float, float] = (8.0, 4.8),
    grid: str = "both",
    lines: bool = False,
    **options: Any,
) -> tuple[Figure, list[Axes]]:
    """Return a figure and its panels.

    ``canvas``: how the figure looks, or a figure that is drawn on. ``title``: over all panels;
    names from files are text in it, never formulas. ``notes``: line below the title, in smaller
    type; empty ones are left out. ``size_in``: width and height [in] where the options have none.
    ``grid``: lines of the grid: ``x``, ``y``, ``both``, or none if empty. ``lines``: whether the
    figure is lines of text, such as named bars: its height goes with the type.
    """
    # An escaped dollar begins no formula.
    heading = title, " \N{MIDDLE DOT} ".join(filter(None, notes))
    title, line = (text.replace("$", r"\$") for text in heading)
    below: Any
    if not isinstance(canvas, FigureOptions):
        figure = below = canvas
        if title:  # else its owner's stays
            figure.suptitle(f"{title}\n{line}".strip(), wrap=True)
    else:
        figure = below = _blank_figure(canvas, size_in, lines=lines)
        if title and canvas.title:
            figure.suptitle(title, wrap=True)
            below = figure.subfigures()
            below.suptitle(line, wrap=True, fontsize="small")
    panels = list(below.subplots(rows, columns, squeeze=False, **options).ravel())
    for axes in panels:
        axes.xaxis.label.set_wrap(True)
        if grid:
            axes.grid(alpha=0.3, axis=grid)
    return figure, panels


def _blank_figure(options: FigureOptions, size_in: tuple[float, float], *, lines: bool) -> Figure:
    """Return a canvas of the size of the options.

    A figure without a size grows with its type, by half as much. One of a given width has the
    height between that of its proportions and that of its lines of text, their geometric mean.
    """
    from studies.output.figures.layout import StyledFigure  # half a second, for those who draw

    type_size = _setting("font.size") / _USUAL_TYPE
    width, height = options.size_in or (size_in[0] * math.sqrt(type_size), None)
    if height is None:
        stretch = 1.0 if lines else min(width / size_in[0] / type_size, 1.0)
        height = size_in[1] * type_size * math.sqrt(stretch)
    return StyledFigure(options, (width, height))


def add_legend(
    figure: Figure, handles: Sequence[Any], columns: int, *, side: str = "center", **looks: Any
) -> None:
    """Write a legend below the axes of a figure, in no more columns than there is room for.

    ``side``: ``center`` or ``right``. ``**looks``: as matplotlib's legend takes them.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgba_array
    from matplotlib.patches import Patch

    # Matplotlib 3.10 and before refuse bands of a sub-figure in the legend of the whole one.
    entries = list(handles)
    for i, band in enumerate(handles):
        if isinstance(band, PolyCollection):
            (colour,) = to_rgba_array(band.get_facecolor())
            entries[i] = Patch(facecolor=tuple(colour), linewidth=0, label=str(band.get_label()))
    looks |= {"handles": entries, "loc": f"outside lower {side}"}
    for count in range(columns, 0, -1):
        legend = figure.legend(ncols=count, **looks)
        if count == 1 or legend.get_window_extent().width <= figure.bbox.width:
            return
        legend.remove()


def to_bytes(figure: Figure, image_format: str) -> bytes:
    """Return a figure in a format of :data:`studies.output.formats.IMAGE_FORMATS`."""
    buffer = io.BytesIO()
    options = getattr(figure, "options", DEFAULT)
    dots_per_inch = options.dots_per_inch or DOTS_PER_INCH
    if image_format == "png":
        width_in, height_in = figure.get_size_inches()
        check_dots(width_in, height_in, dots_per_inch)
    figure.savefig(buffer, format=image_format, dpi=dots_per_inch)
    return buffer.getvalue()


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure to a file, whole or not at all.

    Parameters
    ----------
    figure : Figure
    path : str or path
        File name; its ending, png, svg or pdf, chooses the format.

    Raises
    ------
    ValueError
        For another ending.
    OutputError
        If the file cannot be written.
    """
    if (chosen := format_of(os.fspath(path), IMAGE_FORMATS)) is None:
        allowed = ", ".join(f".{name}" for name in IMAGE_FORMATS)
        raise ValueError(f"{os.fspath(path)!r} must end in one of {allowed}")
    write_bytes_atomically(path, to_bytes(figure, chosen))


# ---- Words of headings


def objective_caption(objective: str | Objective) -> str:
    """Return an objective in words, for instance ``smallest wingspan``."""
    sought = Objective(objective)
    return f"{'largest' if sought.maximised else 'smallest'} {sought.label}"


# ---- Colours of the style, and what is drawn with them


def is_narrow(canvas: Canvas, size_in: tuple[float, float]) -> bool:
    """Return whether there is so little width that panels stand below each other."""
    if not isinstance(canvas, FigureOptions):
        width = canvas.bbox.width / canvas.dpi
    else:
        width = size_in[0] if canvas.size_in is None else canvas.size_in[0]
    return bool(width * _USUAL_TYPE / _setting("font.size") < _NARROW_IN)


def _setting(name: str) -> Any:
    """Return a setting of matplotlib, as the style has it."""
    return library().rcParams[name]


def ink() -> str:
    """Colour of text and of lines without a meaning of their own, dark or light as the style is."""
    return str(_setting("text.color"))


def paper() -> str:
    """Colour of the ground that is drawn on."""
    return str(_setting("axes.facecolor"))


def night() -> str:
    """Colour of the night, and of what is not shown: grey, a little off the ground."""
    return GREY if sum(library().colors.to_rgb(paper())) > 1.5 else _DARK_NIGHT


def shade(axes: Axes, spans: Iterable[tuple[float, float]]) -> None:
    """Shade spans of the horizontal axis over the whole height, in grey."""
    for start, end in spans:
        axes.axvspan(start, end, color=night(), zorder=0, linewidth=0)


def note(
    axes: Axes,
    text: str,
    place: tuple[Any, Any],
    shift: tuple[float, float] = (0.0, 0.0),
    *,
    across: bool = False,
    **looks: Any,
) -> None:
    """Write a text some points beside a place, whose first number may be a share ``across``."""
    coordinates: Any = ("axes fraction", "data") if across else "data"
    looks = {"xycoords": coordinates, "textcoords": "offset points", "fontsize": "small", **looks}
    axes.annotate(text, place, shift, **looks)


def arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], colour: str) -> None:
    """Draw an arrow with two heads between places."""
    looks = {"arrowstyle": "<->", "color": colour, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=looks)


def box(left: float, right: float, low: float, high: float) -> list[tuple[float, float]]:
    """Return the corners of a rectangle."""
    return [(left, low), (right, low), (right, high), (left, high)]


def read_style(text: str) -> str:
    """Check that a style exists and can be read."""
    if text in SHIPPED_STYLES:
        return text
    style_settings(text)
    # Matplotlib finds many a mistake of a style only when it draws.
    options = FigureOptions(size_in=(4.0, 3.0), dots_per_inch=50.0, style=text)
    try:
        with in_style(options):
            figure, (axes,) = new_figure(canvas=options, title="Title", notes=("note",))
            axes.plot([0.0, 1.0], [0.0, 1.0], "o-", label="line")
            axes.bar([0.0], [1.0], label="bar")
            axes.set(xlabel="x", ylabel="y")
            axes.legend()
            to_bytes(figure, "png")
    except Exception as error:  # whatever matplotlib comes across in a user's settings
        words = str(error).partition("\n")[0]
        raise ValueError(f"{text}: matplotlib cannot draw with it: {words}") from None
    return text
