"""Trade studies over entries of the catalogues: names in place of numbers."""

import json

import matplotlib.pyplot as plt
import pandas as pd
import pytest

from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.results.analysis import analyse
from studies.output.gridded import to_table
from studies.sweeps.axes import axis_label, parse_axis, points, shown_value, unit_of
from studies.sweeps.plots import plot_sweep
from studies.sweeps.study import sweep

AS2 = load_aircraft("atlantiksolar-as2")
JULY = load_mission("rafz-july")
CELLS = ["sunpower-c60", "sunpower-e60", "sky-sailor-silicon"]
PACKS = ["samsung-35e", "amprius-450"]


def test_an_axis_takes_names():
    axis = parse_axis("modules.cell=sunpower-c60, sunpower-e60")
    assert axis.names == ("sunpower-c60", "sunpower-e60")
    assert axis.values == (0.0, 1.0)
    assert [shown_value(axis, value) for value in (1.0, -1.0)] == ["sunpower-e60", ""]
    assert (axis_label(axis.key), unit_of(axis.key)) == ("solar cell", "1")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("modules.cell=sunpower-c6", "did you mean sunpower-c60"),
        ("modules.cell=1:2:3", "no entry of the catalogue"),
        ("modules.cell=mine.yaml", "no entry of the catalogue"),
        ("battery.cell=samsung-35e,samsung-35e", "has a value twice"),
        ("airframe.propulsion.motor=", "write KEY="),
    ],
)
def test_bad_names_are_refused(text, words):
    with pytest.raises(ValueError, match=words):
        parse_axis(text)
    with pytest.raises(ValueError, match="none can be drawn"):
        points([parse_axis("modules.cell=sunpower-c60,sunpower-e60")], "lhs", samples=4)


def test_each_point_is_the_aircraft_with_that_entry():
    data = sweep(AS2, JULY, {"modules.cell": CELLS, "battery.cell": PACKS})
    assert data["excess_time"].dims == ("modules_cell", "battery_cell")
    for cell in CELLS:
        for pack in PACKS:
            overrides = {"modules.cell": cell, "battery.cell": pack}
            alone = analyse(load_aircraft("atlantiksolar-as2", overrides), JULY)
            found = data["excess_time"].sel(modules_cell=cell, battery_cell=pack)
            assert float(found) == pytest.approx(alone.excess_time_h)
    assert json.loads(data.attrs["vary"]) == {"modules.cell": CELLS, "battery.cell": PACKS}
    assert set(to_table(data)["modules_cell"]) == set(CELLS)
    figure = plot_sweep(data)
    shown = {label.get_text() for axes in figure.axes for label in axes.get_yticklabels()}
    assert set(PACKS) <= shown
    plt.close(figure)


def test_one_key_at_a_time_starts_from_the_files_own():
    vary = {"modules.cell": CELLS[:2], "power.avionics_w": [6.0, 8.0]}
    data = sweep(AS2, JULY, vary, sample="one-at-a-time")
    assert list(data["modules_cell"].to_numpy()) == ["", *CELLS[:2], "", ""]
    own = analyse(AS2, JULY).excess_time_h
    assert data["excess_time"].to_numpy()[[0, 3]] == pytest.approx(own)
    with pytest.raises(ValueError, match="has names"):
        plot_sweep(data)


def test_names_on_the_command_line(run, tmp_path):
    vary = ("--vary", "battery.cell=samsung-35e,amprius-450")
    calls = ("sweep", "atlantiksolar-design", "-m", "rafz-july", "--resize", "min_mass", *vary)
    outcome = run(
        *calls, "--out", "found.csv", "--plot", "found.png", "--sort", "battery_cell"
    ).good()
    assert "amprius-450" in outcome.out
    assert (tmp_path / "found.png").stat().st_size > 1_000
    table = pd.read_csv(tmp_path / "found.csv", comment="#")
    masses = dict(zip(table["battery_cell"], table["total_mass"], strict=True))
    assert masses["amprius-450"] < 0.8 * masses["samsung-35e"]
    refused = run(*calls, "--pareto", "battery_cell", "total_mass")
    assert refused.code == 2
    assert "is not one of" in refused.err
