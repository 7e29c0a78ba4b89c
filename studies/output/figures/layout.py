"""A figure in a style: matplotlib's constrained layout below a heading in two sizes of type."""

from __future__ import annotations

import warnings
from itertools import pairwise
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.legend import Legend
from matplotlib.text import Text

from studies.output.figures import options as settings
from studies.output.figures.options import FigureOptions, library

_HIGHEST_HEADING = 0.9  # of the figure: constraints must have a solution
_NOTES_SIZE = 0.8  # of the title's
_COLUMN = 16.0  # width of a column of a legend, in sizes of type


class HeadedLayout(ConstrainedLayoutEngine):
    """Constrained layout of what lies below a heading.

    ``collapsed``: whether the figure was too small for its axes when it was laid out last.
    """

    collapsed = False

    def execute(self, fig: Figure) -> Any:
        """Lay a figure out; where there is no room for axes, that is noted and not warned of."""
        high = fig.place_heading() if isinstance(fig, StyledFigure) else 0.0
        self.set(rect=(0.0, 0.0, 1.0, 1.0 - min(high, _HIGHEST_HEADING)))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            done = super().execute(fig)
        for axes in fig.axes:
            _thin_ticks(axes)
        self.collapsed = any("collapsed" in str(one.message) for one in caught)
        for one in caught:
            if "collapsed" not in str(one.message):
                warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
        return done


def _thin_ticks(axes: Axes) -> None:
    """Leave out labels along the horizontal axis, evenly, where they would meet."""
    labels = [label for label in axes.get_xticklabels() if label.get_text()]
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

    def legend(self, *args: Any, **kwargs: Any) -> Legend:
        """Add a legend as matplotlib does, in no more columns than there is room for."""
        size = float(library().rcParams["font.size"])
        room = int(self.get_figwidth() * 72.0 / size / _COLUMN)
        return super().legend(*args, **kwargs | {"ncols": max(1, min(kwargs["ncols"], room))})

    def place_heading(self) -> float:
        """Place the lines of the heading below each other; return their share of the height."""
        top_px = self.bbox.height
        for text in self._heading:
            text.set_in_layout(False)
            text.set_visible(bool(self.get_suptitle()))
            if self.get_suptitle() and text.get_text():
                pad_px = 0.3 * float(text.get_fontsize()) * self.dpi / 72.0
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
