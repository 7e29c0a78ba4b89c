"""Aircraft that name entries of catalogues: what they take, from where, and what wins."""

from pathlib import Path

import pytest
import yaml
from refusals import refusals

from missions.files.errors import InputError
from missions.files.overrides import with_values
from missions.files.texts import texts_as_read
from missions.files.writing import to_yaml
from sizing.aircraft import Aircraft
from sizing.library import load_aircraft

DESIGN = "atlantiksolar-design"
NCR18650B = 3.6 * 3.25 / 0.0485  # Wh/kg: minimum capacity at 25 C and largest mass of its sheet
CELL = """\
label: Cell of a friend
source: measured in the garden
efficiency_stc: 0.21
mass_kg_per_m2: 0.5
"""


def written(folder, **changes):
    """File of the shipped design without what catalogues give, and with changes by section."""
    data = load_aircraft(DESIGN).model_dump(mode="json", exclude_unset=True)
    for key in ("efficiency_stc", "temperature_coefficient_per_k", "mass_kg_per_m2"):
        del data["modules"][key]
    del data["battery"]["charge_limit"], data["battery"]["specific_energy_wh_per_kg"]
    del data["airframe"]["propulsion"]["motor_efficiency"]
    data["battery"]["cell"] = "panasonic-ncr18650b"
    data["modules"] |= changes.get("modules", {})
    data["battery"] |= changes.get("battery", {})
    data["airframe"]["propulsion"] |= changes.get("propulsion", {})
    path = folder / "aircraft.yaml"
    path.write_text(to_yaml(data), encoding="utf-8")
    return path


def test_names_give_parameters_and_say_where_they_come_from(tmp_path):
    path = written(
        tmp_path,
        modules={"cell": "sunpower-e60"},
        propulsion={"motor": "axi-4130-16", "motor_voltage_v": 22.2},
    )
    aircraft = load_aircraft(path)
    assert aircraft.modules.efficiency_stc == 0.237
    assert aircraft.modules.temperature_coefficient_per_k == 0.003
    assert aircraft.modules.mass_kg_per_m2 == pytest.approx(0.59)
    assert aircraft.battery.specific_energy_wh_per_kg == pytest.approx(NCR18650B, rel=1e-5)
    limit = aircraft.battery.charge_limit
    assert limit.c_rate_per_h == pytest.approx(1.625 / 3.25, rel=1e-5)
    expected = (1.0 - (1.3 * 0.063 / 22.2) ** 0.5) ** 2
    assert aircraft.airframe.propulsion.motor_efficiency == pytest.approx(expected, rel=1e-5)
    taken = {value.key: value for value in aircraft.from_catalogues()}
    assert set(taken) == {
        "modules.efficiency_stc",
        "modules.temperature_coefficient_per_k",
        "modules.mass_kg_per_m2",
        "battery.specific_energy_wh_per_kg",
        "battery.charge_limit",
        "airframe.propulsion.motor_efficiency",
    }
    assert "High-Fidelity" in taken["modules.temperature_coefficient_per_k"].source
    assert taken["battery.charge_limit"].label == "Panasonic NCR18650B"
    assert taken["battery.charge_limit"].text == "{kind: rule, c_rate_per_h: 0.5}"


def test_a_board_gives_mass_and_efficiency_and_the_window_of_strings(tmp_path):
    path = written(tmp_path, modules={"cell": "sunpower-c60"})
    aircraft = load_aircraft(path, ["modules.mppt_board=genasun-gvb-8-board"])
    modules = aircraft.modules
    assert modules.mppt_efficiency == 0.95
    assert modules.mppt_mass_kg_per_w == pytest.approx(0.108 / 118.0, rel=1e-5)
    cells = {"cell_span_m": 0.125, "cell_chord_m": 0.125, "bays": [{"cells": [20, 20]}]}
    strings = {"cells_in_series": 20, "coldest_c": -10.0, "hottest_c": 60.0}
    data = aircraft.model_dump(mode="json", exclude_unset=True)
    del data["modules"]["area_m2"]
    data["modules"]["layout"] = cells | {"strings": strings}
    voltage = {"cells_in_series": 6, "state_of_charge": [0, 1], "cell_voltage_v": [3.0, 4.2]}
    data["battery"]["voltage"] = voltage
    path.write_text(to_yaml(data), encoding="utf-8")
    modules = load_aircraft(path).modules
    mppt = modules.layout.strings.mppt
    assert (mppt.conversion, mppt.maximum_voltage_v, mppt.maximum_current_a) == ("step_up", 60, 8)
    # One of 108 g for each of the four strings.
    rated_w = 1000.0 * modules.efficiency_stc * modules.area_m2
    assert modules.mppt_mass_kg_per_w * rated_w == pytest.approx(4 * 0.108)


@pytest.mark.parametrize(
    ("section", "changes", "key"),
    [
        ("modules", {"cell": "sunpower-e60", "efficiency_stc": 0.2}, "efficiency_stc"),
        ("battery", {"charge_limit": {"kind": "none"}}, "charge_limit"),
        ("battery", {"specific_energy_wh_per_kg": 240.0}, "specific_energy_wh_per_kg"),
        ("propulsion", {"motor": "axi-4130-16", "motor_efficiency": 0.8}, "motor_efficiency"),
    ],
)
def test_an_entry_beside_values_of_ones_own_is_refused(tmp_path, section, changes, key):
    path = written(tmp_path, **{section: changes})
    with pytest.raises(InputError, match=f"{section}.{key}: give one of .* and {key}: ") as caught:
        load_aircraft(path)
    assert all(problem.line is not None for problem in caught.value.problems)
    aircraft = load_aircraft(DESIGN)
    assert (aircraft.from_catalogues(), aircraft.texts_read) == ((), {})
    # An override is meant to replace the value, and so is what the entry does not give.
    bare = written(tmp_path, **{section: {k: v for k, v in changes.items() if k != key}})
    where = "airframe.propulsion" if section == "propulsion" else section
    load_aircraft(bare, {f"{where}.{key}": changes[key]})
    load_aircraft(written(tmp_path, modules={"cell": "azur-3g30c", "efficiency_stc": 0.28}))


def test_an_entry_named_by_an_override_replaces_what_the_file_says():
    aircraft = load_aircraft(DESIGN, {"modules.cell": "sunpower-c60"})
    assert aircraft.modules.efficiency_stc == 0.225
    assert aircraft.modules.temperature_coefficient_per_k == 0.0032
    other = load_aircraft(DESIGN, {"modules.cell": "sunpower-a300"}).modules
    assert other.temperature_coefficient_per_k == 0.003  # the default of modules
    # Whatever else is overridden stays, in any order.
    for overrides in (
        ["modules.cell=sunpower-c60", "modules.efficiency_stc=0.23"],
        ["modules.efficiency_stc=0.23", "modules.cell=sunpower-c60"],
    ):
        assert load_aircraft(DESIGN, overrides).modules.efficiency_stc == 0.23
    limited = ["battery.charge_limit.c_rate_per_h=0.3", "battery.cell=samsung-35e"]
    limit = load_aircraft(DESIGN, limited).battery.charge_limit
    assert limit.c_rate_per_h == 0.3


def test_a_copy_with_another_entry_takes_that_ones_values(tmp_path):
    aircraft = load_aircraft(written(tmp_path, modules={"cell": "sunpower-e60"}))
    other = with_values(aircraft, {"modules.cell": "sky-sailor-silicon"})
    assert other.modules.efficiency_stc == 0.169
    # A record made anew from its data, with or without what was not given, is the same.
    assert Aircraft.model_validate(aircraft.model_dump()) == aircraft
    assert Aircraft.model_validate(aircraft.model_dump(exclude_unset=True)) == aircraft


def test_cells_count_for_their_share_of_the_pack(tmp_path):
    aircraft = load_aircraft(written(tmp_path, battery={"cell_mass_fraction": 0.9}))
    assert aircraft.battery.specific_energy_wh_per_kg == pytest.approx(0.9 * NCR18650B, rel=1e-5)
    with pytest.raises(InputError, match="goes with cell"):
        load_aircraft(DESIGN, {"battery.cell_mass_fraction": 0.9})
    again = with_values(aircraft, {"battery.cell_mass_fraction": 0.8})
    assert again.battery.specific_energy_wh_per_kg == pytest.approx(0.8 * NCR18650B, rel=1e-5)


def test_a_file_of_ones_own_beside_the_aircraft(tmp_path):
    cell = tmp_path / "cell.yaml"
    cell.write_text(CELL, encoding="utf-8")
    path = written(tmp_path, modules={"cell": "cell.yaml"})
    aircraft = load_aircraft(path)
    assert aircraft.modules.efficiency_stc == 0.21
    assert aircraft.modules.mass_kg_per_m2 == pytest.approx(0.7)
    (efficiency, mass) = aircraft.from_catalogues()[:2]
    assert (efficiency.key, efficiency.source) == ("modules.efficiency_stc", SOURCE)
    assert mass.entry == str(cell)
    # Where the file is gone the aircraft is made anew from what was read.
    texts = aircraft.texts_read
    cell.unlink()
    with texts_as_read(texts):
        assert Aircraft.model_validate(aircraft.model_dump()) == aircraft


SOURCE = "measured in the garden"


@pytest.mark.parametrize(
    ("_", "changes", "told"), refusals(Path(__file__).with_name("mistakes.txt"))
)
def test_mistakes_are_told_at_their_line(tmp_path, _, changes, told):
    with pytest.raises(InputError) as caught:
        load_aircraft(written(tmp_path, **yaml.safe_load(changes)))
    problems = caught.value.problems
    words = " | ".join(f"{one.key}: {one.message}" for one in problems)
    assert words.replace(f"{tmp_path}/", "") == told
    assert all(problem.line is not None for problem in problems)


def test_mistakes_of_ones_own_file_have_the_lines_of_that_file(tmp_path):
    cell = tmp_path / "cell.yaml"
    cell.write_text("label: mine\nefficiency_stc: 2\nmas: 1\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_aircraft(written(tmp_path, modules={"cell": "cell.yaml"}))
    of_cell = {p.line: p.message for p in caught.value.problems if p.source == str(cell)}
    assert "at most" in of_cell[2]
    assert "did you mean" in of_cell[3] or "unknown key" in of_cell[3]
    assert any("3 mistakes" in p.message for p in caught.value.problems)
    cell.write_text("a: [" * 50, encoding="utf-8")
    with pytest.raises(InputError, match=r"cell\.yaml:1"):
        load_aircraft(tmp_path / "aircraft.yaml")


def test_a_cell_brings_the_curve_of_its_voltage(tmp_path):
    usual = ((0.0, 0.1, 0.9, 1.0), (3.0, 3.4, 4.0, 4.2))
    file = tmp_path / "mine.yaml"
    file.write_text(
        "label: Mine\nsource: measured on the bench\nspecific_energy_wh_per_kg: 200\n"
        "state_of_charge: [0, 1]\ncell_voltage_v: [2.8, 4.1]\n"
    )
    for cell, curve in (("samsung-50e", usual), (str(file), ((0.0, 1.0), (2.8, 4.1)))):
        path = written(tmp_path, battery={"cell": cell, "voltage": {"cells_in_series": 6}})
        voltage = load_aircraft(path).battery.voltage
        assert (voltage.state_of_charge, voltage.cell_voltage_v) == curve
        ends_v = voltage.voltage_v([0.0, 1.0])
        assert ends_v == pytest.approx([6 * curve[1][0], 6 * curve[1][-1]])
