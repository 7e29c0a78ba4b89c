"""Figures of matplotlib as part of a page."""

import pytest

from studies.report.blocks import _themed


@pytest.mark.parametrize(
    "style",
    [
        "font: italic bold 8px 'DejaVu Sans', sans-serif; text-anchor: end; fill: #262626",
        "font-style: italic; font-weight: 600; font-size: 8px; font-family: 'DejaVu Sans'; "
        "text-anchor: end; fill: #262626",
    ],
)
def test_type_is_that_of_the_page_whichever_way_matplotlib_writes_it(style):
    drawn = _themed(f' style="{style}"')
    looks = "font-style: italic; font-weight: 600; font-size: 8px"
    assert drawn == f' style="{looks}; text-anchor: end; fill: var(--ink)"'
