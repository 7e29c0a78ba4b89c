"""Batteries of whole cells: mass, energy, voltage and charge current, and what is refused."""

from pathlib import Path

import pytest
from builders import DESIGN

from sizing.aircraft import Aircraft
from sizing.battery.battery import Battery

# A cell of 3.2 Ah, 3.7 V and 44.5 g that is charged with 3.1 A.
ENTRY = """\
label: a cell
source: numbers of this test
nominal_voltage_v: 3.7
capacity_ah: 3.2
mass_kg: 0.0445
maximum_charge_current_a: 3.1
"""
NINE = {"cells_in_series": 6, "cells_in_parallel": 9}
VOLTAGE = {
    "cells_in_series": 6,
    "state_of_charge": [0.0, 0.2, 1.0],
    "cell_voltage_v": [3.0, 3.4, 4.2],
}


@pytest.fixture
def cell(tmp_path):
    file = tmp_path / "cell.yaml"
    file.write_text(ENTRY, encoding="utf-8")
    return str(file)


def battery(**data):
    return Battery.model_validate(data)


def test_mass_energy_voltage_and_current_are_those_of_the_cells(cell):
    packed = battery(cell=cell, pack={"cells_in_parallel": 9}, voltage=VOLTAGE)
    assert packed.mass_kg == pytest.approx(54 * 0.0445, rel=1e-12)
    # The catalogue keeps six digits of the energy over mass.
    assert packed.battery_energy_wh == pytest.approx(54 * 3.2 * 3.7, rel=1e-5)
    assert packed.ends_v == pytest.approx((18.0, 25.2))
    assert packed.pack.charge_current_a == pytest.approx(9 * 3.1)
    limit = packed.charge_limit
    assert limit.c_rate_per_h == pytest.approx(3.1 / 3.2, rel=1e-5)
    # Wiring and housing add to the mass and not to the energy.
    packed = battery(cell=cell, cell_mass_fraction=0.9, pack=NINE)
    assert packed.mass_kg == pytest.approx(54 * 0.0445 / 0.9, rel=1e-12)
    assert packed.battery_energy_wh == pytest.approx(54 * 3.2 * 3.7, rel=1e-5)
    # Cells in parallel follow from a mass of whole cells, or the mass from the specific energy.
    packed = battery(cell=cell, mass_kg=2.403, pack={"cells_in_series": 6})
    assert packed.pack.cells_in_parallel == 9
    assert packed.mass_kg == pytest.approx(2.403, rel=1e-12)
    Path(cell).write_text(ENTRY.replace("mass_kg: 0.0445", "specific_energy_wh_per_kg: 250"))
    packed = battery(cell=cell, pack=NINE)
    assert packed.mass_kg == pytest.approx(54 * 3.2 * 3.7 / 250.0, rel=1e-12)


def test_window_leaves_a_part_of_the_energy_at_the_current_of_the_cells(cell):
    window = {"minimum_state_of_charge": 0.1, "maximum_state_of_charge": 0.9}
    packed = battery(cell=cell, pack={"cells_in_parallel": 9} | window, voltage=VOLTAGE)
    assert packed.mass_kg == pytest.approx(54 * 0.0445, rel=1e-12)
    assert packed.battery_energy_wh == pytest.approx(0.8 * 54 * 3.2 * 3.7, rel=1e-5)
    assert packed.ends_v == pytest.approx((6 * 3.2, 6 * 4.1))
    # Stored power at the largest current is the same: 9 times 3.1 A at the nominal voltage.
    limit = packed.charge_limit
    power_w = limit.c_rate_per_h * packed.battery_energy_wh
    assert power_w == pytest.approx(9 * 3.1 * 6 * 3.7, rel=1e-4)


def test_what_follows_is_not_written_and_follows_again(cell):
    data = DESIGN.model_dump(mode="json", exclude_unset=True)
    data["battery"] = {"cell": cell, "voltage": VOLTAGE, "pack": {"cells_in_parallel": 9}}
    plane = Aircraft.model_validate(data)
    written = plane.model_dump(mode="json", exclude_unset=True)
    assert "mass_kg" not in written["battery"]
    assert Aircraft.model_validate(written) == plane
