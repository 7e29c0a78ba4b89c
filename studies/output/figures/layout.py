"""A figure in a style, laid out by matplotlib's constraints."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from studies.output.figures import options as settings
from studies.output.figures.options import FigureOptions


class StyledFigure(Figure):
    """Figure in a style, which it keeps when it is drawn later."""

    def __init__(self, options: FigureOptions, size_in: tuple[float, float]) -> None:
        super().__init__(figsize=size_in, layout="constrained")
        self.options = options

    def draw(self, renderer: Any) -> None:
        """Draw the figure in its style, in a notebook as well."""
        with settings.in_style(self.options):
            layout = self.get_layout_engine()
            if isinstance(layout, ConstrainedLayoutEngine) and self.canvas.is_saving():
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
