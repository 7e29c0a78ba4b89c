import pytest
from figure_checks import heading

import sizing
import studies
from missions.library import load_mission
from sizing.library import load_aircraft


def test_spread_and_causes_are_drawn(tmp_path):
    aircraft = load_aircraft("atlantiksolar-design")
    analysis = sizing.analyse_uncertainty(aircraft, load_mission("rafz-july"), samples=256)
    figure = studies.plot_uncertainty(analysis)
    spread, causes = figure.axes
    assert spread.get_xlabel() == "excess time [h]"
    assert sum(bar.get_height() for bar in spread.patches[:60]) == pytest.approx(100.0)
    names = [tick.get_text() for tick in causes.get_yticklabels()]
    assert names[-1].startswith("specific energy of the battery, ")
    assert names[-1].endswith("variance")
    assert len(names) == len(analysis.inputs)
    studies.save_figure(figure, tmp_path / "a.png")


def test_a_single_input_is_named_and_has_no_bars():
    analysis = sizing.analyse_uncertainty(
        load_aircraft("atlantiksolar-as2"), load_mission("rafz-july"), samples=256
    )
    assert len(analysis.inputs) == 1
    figure = studies.plot_uncertainty(analysis)
    (spread,) = figure.axes
    assert spread.get_ylabel() == "draws [%]"
    assert "one input scatters: error of the solar model" in heading(figure)
