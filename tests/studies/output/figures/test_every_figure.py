"""Every figure at its own size and as wide as a page of a journal: texts whole, lines apart."""

import pytest
from figure_checks import alike_lines, drawings, text_faults

from studies.output.figures.options import FigureOptions, read_size

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", drawings())
def test_texts_are_whole_at_their_own_size_and_on_a_page(name):
    for options in (FigureOptions(), FigureOptions(size_in=read_size("170mm"), style="paper")):
        figure = drawings()[name](figure=options)
        assert not text_faults(figure)
        assert not alike_lines(figure)
