"""Every figure at large type and in the column of a journal: nothing cut off, all lines apart."""

from pathlib import Path

import pytest
from figure_checks import alike_lines, drawings, text_faults

from studies.output.figures.options import FigureOptions, read_size

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("name", drawings())
def test_texts_are_whole_at_large_type_and_in_a_column(name: str, tmp_path: Path) -> None:
    large = tmp_path / "large.mplstyle"
    large.write_text("font.size: 18\n")
    for options in (
        FigureOptions(style=str(large)),
        FigureOptions(size_in=read_size("85mm"), style="paper"),
    ):
        figure = drawings()[name](figure=options)
        assert not text_faults(figure)
        assert not alike_lines(figure)
