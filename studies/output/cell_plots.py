"""Figure of a wing with its solar cells."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from sizing.aircraft import Aircraft
from sizing.results.parts import cells_lines, cells_record
from studies.output.figures.drawing import DARK_GREY, GREY, LOAD, Canvas, ink, new_figure, styled
from studies.output.figures.options import DEFAULT

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_WIDTH_IN, _AROUND_IN = 9.0, 1.3  # of the figure, and what title and axis take of its height


@styled
def plot_cells(aircraft: Aircraft, *, figure: Canvas = DEFAULT) -> Figure:
    """Wing, and tail where it bears cells, from above with every solar cell and keep-out."""
    from matplotlib import collections, patches, ticker

    def drawn_as(shapes: Sequence[patches.Patch], **style: Any) -> None:
        axes.add_collection(collections.PatchCollection(shapes, **style))

    layout, wing, tail = aircraft.modules.layout, aircraft.wing, aircraft.modules.tail
    if layout is None:
        raise ValueError(f"{aircraft.name} has no modules.layout")
    notes = cells_lines(cells_record(aircraft))[:1]
    aft_m = wing.chord_m
    if layout.tail_cells and tail is not None:
        aft_m = tail.horizontal_aft_m + tail.horizontal_chord_m
    height_in = _AROUND_IN + _WIDTH_IN * aft_m / wing.wingspan_m
    drawn, (axes,) = new_figure(
        canvas=figure,
        title=f"{aircraft.name}: solar cells",
        notes=notes,
        size_in=(_WIDTH_IN, height_in),
        grid="",
    )
    edges = layout.outline(wing)
    around = [(y, front) for y, front, _ in edges] + [(y, rear) for y, _, rear in reversed(edges)]
    outlines: list[patches.Patch] = [patches.Polygon(around)]
    if tail is not None and layout.tail_cells:
        half, chord_m = tail.horizontal_span_m / 2.0, tail.horizontal_chord_m
        outlines.append(patches.Rectangle((-half, tail.horizontal_aft_m), 2.0 * half, chord_m))
    drawn_as(outlines, facecolor=GREY, edgecolor=ink(), linewidth=0.8, alpha=0.5)
    taken = [
        patches.Polygon([(side * y, x) for y, x in corners])
        for corners in layout.kept_out_corners(wing)
        for side in (-1.0, 1.0)
    ]
    drawn_as(taken, facecolor="none", edgecolor=DARK_GREY, hatch="////", linewidth=0.6)
    cells = [
        patches.Rectangle((c.left_m, c.front_m), c.right_m - c.left_m, c.rear_m - c.front_m)
        for c in aircraft.placed_cells()
    ]
    drawn_as(cells, facecolor=LOAD, edgecolor="white", linewidth=0.3)
    axes.set_aspect("equal")
    axes.margins(0.01)
    axes.autoscale_view()
    axes.invert_yaxis()
    axes.yaxis.set_major_locator(ticker.MaxNLocator(3))
    axes.set(xlabel="right of the middle [m]", ylabel="aft [m]")
    return drawn
