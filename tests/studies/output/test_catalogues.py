"""Lists of the catalogues: a basis for every battery, and nothing in place of what is unknown."""

import pytest

from sizing.catalogues.choice import entries
from studies.output.catalogues import catalogue_record, catalogue_table

BASES = {"min/max", "typical", "stated", "pack"}


@pytest.mark.parametrize("kind", ["batteries", "cells"])
def test_a_list_has_all_entries_in_one_table_of_a_terminal(kind):
    lines = catalogue_table(kind).to_text(80).splitlines()
    assert max(map(len, lines)) <= 80
    rules = [line for line in lines if set(line) == {"\N{BOX DRAWINGS LIGHT HORIZONTAL}"}]
    assert len(rules) == 1  # a second one begins a second block
    assert {line.split()[0] for line in lines if line and line[0] != " "} >= set(entries(kind))


def test_every_battery_has_its_basis_in_the_list_and_in_json():
    table = catalogue_table("batteries")
    at = [column.name for column in table.columns].index("basis")
    record = catalogue_record("batteries")
    for name, row in zip(entries("batteries"), table.rows, strict=True):
        assert row[at] in BASES
        assert record[name]["basis"] == row[at]
    assert {row[at] for row in table.rows} == BASES
    for basis in BASES:
        assert basis in table.notes[0]  # says what each of them is


def test_what_is_not_known_of_a_cell_is_said_to_be_unknown():
    table = catalogue_table("cells")
    names = [column.name for column in table.columns]
    texts = dict(zip(entries("cells"), table.texts(), strict=True))
    lost, mass = names.index("temperature_coefficient_per_k"), names.index("mass_kg_per_m2")
    assert texts["sunpower-c60"][lost] == "0.32"
    assert texts["sunpower-c60"][mass] == "unknown"
    assert texts["sunpower-maxeon-gen3-me1"][mass] == "0.62"
    assert "mass_kg_per_m2" not in catalogue_record("cells")["sunpower-c60"]
