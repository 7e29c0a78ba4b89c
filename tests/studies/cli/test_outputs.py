"""What commands make of a figure: its file, and what is said of it."""

import warnings

import pytest

from studies.cli.outputs import figure_of
from studies.output.figures.drawing import new_figure
from studies.output.figures.options import FigureOptions


def titled(title, size_in=(6.0, 4.0)):
    return new_figure(canvas=FigureOptions(size_in=size_in), title=title)[0]


def test_glyphs_that_a_font_lacks_are_warned_of():
    with pytest.warns(UserWarning, match="missing from font"):
        figure_of(titled, "\u592a\u967d\u98db\u884c\u6a5f")("a.png")


def test_a_figure_too_small_for_its_texts_is_told_in_words(capsys):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert figure_of(titled, "long " * 200, (1.6, 1.6))("a.png")
    assert "a.png: the figure is too small for its axes and texts" in capsys.readouterr().err
