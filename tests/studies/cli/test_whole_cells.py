"""Tests of whole cells from the command line: output, files, reports and mistakes."""

import json

import pytest
from command_line import files

LAYOUT = "modules.layout={cell_span_m: 0.125, cell_chord_m: 0.125, bays: [{cells: [22, 22]}]}"
PACK = "battery.pack={cells_in_series: 6, cell_mass_kg: 0.0486}"
SIZE = (
    *("size", "atlantiksolar-design", "-m", "central-europe-summer"),
    *("--objective", "min_mass", "--required-excess-time", "3", "--whole-cells"),
)
CELLS = ("--set", "modules.cell=sunpower-e60", "--set", LAYOUT, "--set", PACK)


@pytest.mark.slow
def test_folder_has_the_figure_and_a_file_that_flies_the_same(run, tmp_path):
    folder = tmp_path / "sized"
    run(*SIZE, *CELLS, "--out", str(folder), "--report", str(tmp_path / "page.html")).good()
    assert "cells.png" in files(folder)
    record = json.loads((folder / "results.json").read_text())
    flown = run("analyse", str(folder), "--json").json()
    assert flown["total_mass_kg"] == pytest.approx(record["total_mass_kg"], rel=1e-12)
    assert flown["whole_cells"]["solar_cells"] == record["whole_cells"]["solar_cells"]
    page = (tmp_path / "page.html").read_text()
    assert "Loss by whole cells" in page
    assert f"{record['whole_cells']['chosen']['cells']} solar cells; horizontal tail" in page
    # Every cell is drawn.
    _, _, views = page.partition('aria-labelledby="views-drawn')
    drawn = views.partition("</svg>")[0]
    assert drawn.count("<path") >= record["whole_cells"]["chosen"]["cells"]


def test_analysis_of_a_file_with_cells_tells_them(run):
    voltage = (
        "battery.voltage={cells_in_series: 6, state_of_charge: [0, 1], cell_voltage_v: [3, 4.2]}"
    )
    outcome = run("analyse", "atlantiksolar-design", *CELLS, "--set", voltage, "-v").good()
    text = " ".join(outcome.out.split())
    assert "solar cells: 88, each half of the wing 2 rows of 22" in text
    for fact in ("cells in series 6", "cells in parallel 10", "empty 18.0 V", "full 25.2 V"):
        assert fact in text


def test_no_design_of_whole_cells_has_exit_code_1(run):
    layout = (
        "modules.layout={cell_span_m: 2.5, cell_chord_m: 0.125, cell_area_m2: 0.3125, "
        "bays: [{cells: [1, 1]}]}"
    )
    outcome = run(
        *SIZE,
        *("--set", layout, "--set", "modules.area_m2=1.25", "--set", PACK),
        *("--set", "design_space.module_area_m2.maximum=0.6"),
        *("--set", "design_space.wingspan_m.maximum=6"),
    )
    assert outcome.code == 1
    assert "no design of whole cells" in outcome.out
