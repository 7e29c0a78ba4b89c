"""Tests of a design as a table, and of its LaTeX."""

import re

import pytest
from builders import AS2, DESIGN, SKY_SAILOR, mission

from sizing.results.analysis import analyse
from studies.exchange.files import escaped, latex_table
from studies.render.design_sheet import design_sheet

SHEETS = [design_sheet(analyse(a, mission(), replay=False)) for a in (AS2, DESIGN, SKY_SAILOR)]


@pytest.mark.parametrize("sheet", SHEETS, ids=lambda sheet: sheet.title)
def test_quantities_agree_with_each_other(sheet):
    values = {entry.quantity.name: entry.value for entry in sheet.quantities}
    masses = [entry for entry in sheet.quantities if entry.group == "masses"]
    parts = [entry.value for entry in masses if entry.quantity.label.startswith("mass:")]
    assert sum(parts) == pytest.approx(values["total_mass_kg"])
    assert values["wing_loading_kg_per_m2"] == pytest.approx(
        values["total_mass_kg"] / values["wing_area_m2"]
    )
    assert values["wing_area_m2"] == pytest.approx(values["wingspan_m"] * values["chord_m"])
    assert values["battery_energy_wh"] == pytest.approx(
        values["battery_mass_kg"] * values["battery.specific_energy_wh_per_kg"]
    )
    assert len(values) == len(sheet.quantities)  # every key once


@pytest.mark.parametrize("sheet", SHEETS, ids=lambda sheet: sheet.title)
def test_latex_is_balanced_and_has_four_columns(sheet):
    text = latex_table(sheet)
    bare = re.sub(r"\\.", "", text)
    assert bare.count("{") == bare.count("}")
    assert bare.count("$") % 2 == 0
    rows = [line for line in text.splitlines() if line.endswith(r"\\")]
    assert len(rows) == len(sheet.quantities) + 1
    assert all(row.count("&") == 3 for row in rows)
    assert text.isascii()


def test_latex_is_drawn_by_mathtext():
    # Matplotlib reads the same symbols; what it cannot read, LaTeX is not given.
    from matplotlib.mathtext import MathTextParser

    parser = MathTextParser("path")
    for sheet in SHEETS:
        for quantity in sheet.quantities:
            parser.parse(f"${quantity.quantity.symbol}$")


def test_special_characters():
    assert escaped("50 % of A_B & {C} #1 ~^\\ $") == (
        r"50 \% of A\_B \& \{C\} \#1 \textasciitilde{}\textasciicircum{}\textbackslash{} \$"
    )
