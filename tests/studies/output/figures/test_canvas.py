"""Figures on their canvas: what is saved, and how often it is drawn."""

import io
from typing import Any

import pytest
from builders import AS2, shipped_mission
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sizing import analyse
from studies.output.cycle_plots import plot_cycle
from studies.output.figures.layout import StyledFigure


@pytest.mark.parametrize("kind", ["svg", "png", "pdf"])
@pytest.mark.parametrize("box", [None, "tight"])
def test_axes_are_drawn_once(kind: str, box: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[Axes] = []
    draw = Axes.draw

    def counted(axes: Axes, renderer: Any) -> None:
        drawn.append(axes)
        draw(axes, renderer)

    figure = plot_cycle(analyse(AS2, shipped_mission()))
    monkeypatch.setattr(Axes, "draw", counted)
    figure.savefig(io.BytesIO(), format=kind, bbox_inches=box)
    assert sorted(map(id, drawn)) == sorted(map(id, figure.axes))


def test_a_figure_is_saved_as_matplotlib_would_in_two_passes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Matplotlib's own way draws all twice; the picture is the same to the last byte."""

    def saved() -> bytes:
        file = io.BytesIO()
        plot_cycle(analyse(AS2, shipped_mission())).savefig(file, format="png")
        return file.getvalue()

    once = saved()
    monkeypatch.setattr(StyledFigure, "draw", Figure.draw)
    assert once == saved()
