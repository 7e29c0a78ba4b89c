"""A figure in a style: matplotlib's constrained layout below a heading in two sizes of type."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.legend import Legend
from matplotlib.text import Text

from studies.output.figures import options as settings
from studies.output.figures.options import FigureOptions

_HIGHEST_HEADING = 0.9  # of the figure: constraints must have a solution
_NOTES_SIZE = 0.8  # of the title's
_SMALLEST_TYPE = 5.0  # [pt], which journals still print
_SMALLER = 0.85  # step of the type where there is no room for the axes
_LEAST_LINES = 5.0  # height of a panel, in lines of type
_LONGEST_LABEL = 1.1  # of the height of its panel


class HeadedLayout(ConstrainedLayoutEngine):
    """Constrained layout of what lies below a heading, in smaller type where there is no room.

    ``collapsed``: whether there was none for the axes in the smallest type either.
    """

    collapsed = False

    def __init__(self) -> None:
        super().__init__()
        self._legends: list[BelowAxes] = []

    def add_legend(self, legend: BelowAxes) -> None:
        """Write a legend, and keep it to be written anew in smaller type."""
        self._legends.append(legend)
        legend.write()

    def execute(self, fig: Figure) -> Any:
        """Lay a figure out; what does not fit is noted, not warned of."""
        done = self._lay_out(fig)
        while (self.collapsed or _is_cramped(fig)) and _shrink_type(fig):
            for legend in self._legends:
                legend.write(_SMALLER)
            done = self._lay_out(fig)
        self.collapsed |= _is_cramped(fig)
        return done

    def _lay_out(self, figure: Figure) -> Any:
        """Lay a figure out in its present type."""
        high = figure.place_heading() if isinstance(figure, StyledFigure) else 0.0
        self.set(rect=(0.0, 0.0, 1.0, 1.0 - min(high, _HIGHEST_HEADING)))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            done = super().execute(figure)
        for axes in figure.axes:
            _thin_labels(axes.get_xticklabels())
            _thin_labels(axes.get_yticklabels())
        self.collapsed = any("collapsed" in str(warning.message) for warning in caught)
        for warning in caught:
            if "collapsed" not in str(warning.message):
                warnings.warn_explicit(
                    warning.message, warning.category, warning.filename, warning.lineno
                )
        return done


@dataclass
class BelowAxes:
    """Legend below the axes of a figure, in no more columns than there is room for.

    ``side``: ``center`` or ``right``. ``looks``: as matplotlib's legend takes them.
    """

    figure: Figure
    handles: Sequence[Any]
    columns: int
    side: str
    looks: Mapping[str, Any]
    _written: Legend | None = None

    def write(self, smaller: float = 1.0) -> None:
        """Write the legend in a type so many times as large as before."""
        looks: dict[str, Any] = {**self.looks, "loc": f"outside lower {self.side}"}
        if self._written is not None:
            looks["fontsize"] = smaller * _size_of(self._written.get_texts()[0])
            self._written.remove()
        for columns in range(self.columns, 0, -1):
            self._written = self.figure.legend(handles=self.handles, ncols=columns, **looks)
            if columns == 1 or self._written.get_window_extent().width <= self.figure.bbox.width:
                return
            self._written.remove()


def _is_cramped(figure: Figure) -> bool:
    """Return whether a panel is lower than a few lines of type, or than its label is long."""
    for axes in (axes for axes in figure.axes if axes.axison):
        label = axes.yaxis.label
        lines = axes.bbox.height / (_size_of(label) * figure.dpi / 72.0)
        length = label.get_window_extent().height if label.get_text() else 0.0
        if lines < _LEAST_LINES or length > _LONGEST_LABEL * axes.bbox.height:
            return True
    return False


def _size_of(text: Text) -> float:
    """Return the size of a text's type [pt]."""
    return float(text.get_fontsize())


def _shrink_type(figure: Figure) -> bool:
    """Make all texts of a figure smaller; return whether that was still possible."""
    texts = [t for t in figure.findobj(Text) if t.get_text() and t.get_visible()]
    if min((_size_of(text) for text in texts), default=0.0) * _SMALLER < _SMALLEST_TYPE:
        return False
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            labels = axis.get_ticklabels()
            size = _size_of(labels[0]) if labels else _SMALLEST_TYPE
            axis.set_tick_params(labelsize=_SMALLER * size)
            texts = [text for text in texts if text not in labels]
    for text in texts:
        text.set_fontsize(_SMALLER * _size_of(text))
    return True


def _thin_labels(ticks: Sequence[Text]) -> None:
    """Leave out labels along an axis, evenly, where they would meet."""
    labels = [label for label in ticks if label.get_text()]
    boxes = [label.get_window_extent() for label in labels]
    strides = range(1, len(labels) + 1)
    apart = (n for n in strides if not any(a.overlaps(b) for a, b in pairwise(boxes[::n])))
    stride = next(apart, 1)
    for number, label in enumerate(labels):
        label.set_visible(number % stride == 0)


class StyledFigure(Figure):
    """Figure in a style."""

    def __init__(self, options: FigureOptions, size_in: tuple[float, float]) -> None:
        super().__init__(figsize=size_in, layout=HeadedLayout())
        self.options = options
        self.notes = ""
        self._heading: list[Text] = []

    def set_heading(self, title: str, notes: str) -> None:
        """Write a title, and notes below it in smaller type, both in lines that fit."""
        self.notes = notes
        above = self.suptitle(title, va="top", wrap=True)
        size = _NOTES_SIZE * float(above.get_fontsize())
        below = self.text(0.5, 1.0, notes, ha="center", va="top", fontsize=size, wrap=True)
        self._heading = [above, below]

    def place_heading(self) -> float:
        """Place the lines of the heading below each other; return their share of the height."""
        top_px = self.bbox.height
        for text in self._heading:
            text.set_in_layout(False)
            text.set_visible(bool(self.get_suptitle()))
            if self.get_suptitle() and text.get_text():
                pad_px = 0.3 * _size_of(text) * self.dpi / 72.0
                text.set_y((top_px - pad_px) / self.bbox.height)
                top_px -= text.get_window_extent().height + 2.0 * pad_px
        return float(1.0 - top_px / self.bbox.height)

    def draw(self, renderer: Any) -> None:
        """Draw the figure in its style: its layout writes texts anew, in a notebook as well."""
        with settings.in_style(self.options):
            layout = self.get_layout_engine()
            if isinstance(layout, HeadedLayout) and self.canvas.is_saving():
                # Matplotlib draws twice to save: first for the layout alone, the strokes going
                # nowhere, then without a layout engine. The first time needs no strokes.
                layout.execute(self)
            else:
                super().draw(renderer)

    def savefig(self, fname: Any, **kwargs: Any) -> None:
        """Write the figure as :meth:`matplotlib.figure.Figure.savefig` does, in its style.

        ``**kwargs``: as there; the resolution is by default that of the options.
        """
        kwargs.setdefault("dpi", self.options.dots_per_inch or settings.DOTS_PER_INCH)
        with settings.in_style(self.options):
            super().savefig(fname, **kwargs)
