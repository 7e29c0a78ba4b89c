"""Figures on their canvas: what is saved, and how often it is drawn."""

import io

import pytest
from builders import AS2, shipped_mission
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from sizing import analyse
from studies.output.cycle_plots import plot_cycle
from studies.output.figures.drawing import new_figure, styled
from studies.output.figures.layout import StyledFigure
from studies.output.figures.options import FigureOptions, read_size


def test_a_figure_is_saved_as_matplotlib_would_in_two_passes(monkeypatch):
    """Matplotlib's own way draws all twice; the picture is the same to the last byte."""

    def saved():
        file = io.BytesIO()
        plot_cycle(analyse(AS2, shipped_mission())).savefig(file, format="png")
        return file.getvalue()

    once = saved()
    monkeypatch.setattr(StyledFigure, "draw", Figure.draw)
    assert once == saved()


def test_small_figures_have_smaller_type_and_their_title_above_the_axes():
    options = FigureOptions(size_in=read_size("85x60mm"))
    figure = plot_cycle(analyse(AS2, shipped_mission()), figure=options)
    figure.savefig(io.BytesIO(), format="png")
    title = next(text for text in figure.texts if text.get_text())
    highest = max(axes.get_window_extent().y1 for axes in figure.axes)
    assert title.get_window_extent().y0 > highest
    sizes = [text.get_fontsize() for text in figure.findobj(Text) if text.get_text()]
    assert 4.0 < min(sizes) < 8.0


def drawn_on_the_right(*size_in):
    """Axes on the left of a figure, and the part of it where those on the right were."""
    figure = Figure(figsize=size_in)
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    plot_cycle(analyse(AS2, shipped_mission()), ax=right)
    figure.savefig(io.BytesIO(), format="png")
    (part,) = figure.subfigs
    return left, part


def test_a_drawing_in_the_place_of_axes_stays_there():
    left, part = drawn_on_the_right(7.0, 2.8)
    (legend,) = part.legends
    assert legend.get_window_extent().x0 >= left.get_window_extent().x1
    lowest = min(axes.get_tightbbox().y0 for axes in part.axes)
    assert legend.get_window_extent().y1 <= lowest + 1.0


def test_type_of_a_drawing_in_the_place_of_axes_fits_it():
    """Ticks are labelled when they are drawn, after the drawing's settings have gone."""
    left, part = drawn_on_the_right(8.0, 2.5)
    labels = [text for axes in part.axes for text in (axes.yaxis.label, *axes.get_yticklabels())]
    (size,) = {text.get_fontsize() for text in labels}
    assert size == pytest.approx(2.6 * 2.5)
    assert size < left.get_yticklabels()[0].get_fontsize() == 10.0


def test_titles_of_the_user_stay_where_a_drawing_has_none():
    figure = Figure()
    figure.suptitle("mine")
    new_figure(canvas=figure, notes=("note",))
    assert figure.get_suptitle() == "mine"
    whole = Figure()
    axes = whole.subplots()
    axes.set_title("also mine")
    styled(lambda figure: new_figure(canvas=figure)[0])(ax=axes)
    assert whole.subfigs[0].get_suptitle() == "also mine"
