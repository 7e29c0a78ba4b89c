"""Entries of the catalogues: a source for every number, and physics that no product escapes."""

from importlib import resources
from math import sqrt
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import yaml
from pydantic import ValidationError
from refusals import refusals

from sizing.aircraft import SolarModules
from sizing.catalogues.choice import KINDS, Kind, entries
from sizing.catalogues.entries import (
    BatteryEntry,
    CellEntry,
    Entry,
    MotorEntry,
    MpptEntry,
    PropellerEntry,
)
from sizing.propulsion.propeller_files import PropellerChoice

ALL = [(kind, name, product) for kind in get_args(Kind) for name, product in entries(kind).items()]
CELLS = [product for _, _, product in ALL if isinstance(product, CellEntry)]
BATTERIES = [product for _, _, product in ALL if isinstance(product, BatteryEntry)]
MOTORS = [product for _, _, product in ALL if isinstance(product, MotorEntry)]
MPPTS = [product for _, _, product in ALL if isinstance(product, MpptEntry)]
PROPELLERS = [product for _, _, product in ALL if isinstance(product, PropellerEntry)]


def label(product):
    return product.label if isinstance(product, Entry) else ""


def test_every_catalogue_has_entries_of_its_kind():
    assert set(get_args(Kind)) == set(KINDS)
    assert len(CELLS) >= 8
    assert len(BATTERIES) >= 20
    assert len(MOTORS) >= 20
    assert len(PROPELLERS) >= 20
    assert len(MPPTS) >= 4
    labels = [product.label for _, _, product in ALL]
    assert len(set(labels)) == len(labels)
    # 1/2368 kg per W of peak power; the mass of the entry has three digits.
    board = entries("mppts")["atlantiksolar-mppt"]
    assert board.parameters({})["mppt_mass_kg_per_w"] == pytest.approx(1.0 / 2368.0, rel=0.001)
    # Modules without a word on MPPTs have the board that `init` writes.
    starter = resources.files("studies").joinpath("templates", "aircraft.yaml").read_text()
    assert "mppt_board: genasun-gvb-8-board" in starter
    board = entries("mppts")["genasun-gvb-8-board"]
    assert SolarModules(area_m2=1.0).mppt_mass_kg_per_w == board.mass_kg_per_w


@pytest.mark.parametrize(("kind", "name", "product"), ALL, ids=lambda value: label(value) or value)
def test_every_number_has_a_source_that_says_what_it_is(kind, name, product):
    assert product.numbers()
    for key in product.numbers():
        assert len(product.source_of(key)) > 15
    assert name == name.lower()
    assert "." not in name


@pytest.mark.parametrize("cell", CELLS, ids=label)
def test_cells_obey_detailed_balance_and_their_own_data_sheet(cell):
    # Shockley and Queisser (1961), one junction under one sun: 33.7 %. De Vos (1980), three
    # junctions under one sun: 49 %.
    space = cell.efficiency_am0 is not None
    limit = 0.49 if "triple junction" in cell.label else 0.337
    for efficiency in (cell.efficiency_stc, cell.efficiency_am0):
        assert efficiency is None or 0.1 < efficiency < limit
    assert space or cell.efficiency_stc is not None
    # Silicon modules of the CEC data base lose 0.26 (heterojunction) to 0.45 %/K; GaAs, of a wider
    # band gap, loses a fraction of it.
    lost = cell.temperature_coefficient_per_k
    assert lost is None or (lost < 0.001 if "GaAs" in cell.label else 0.0025 < lost < 0.0045)
    power, area = cell.mpp_power_w, cell.area_m2
    if power is not None and area is not None:
        light = (cell.am0_irradiance_w_per_m2 if space else 1000.0) or np.nan
        efficiency = cell.efficiency_am0 if space else cell.efficiency_stc
        # Efficiencies have three digits.
        assert power == pytest.approx(efficiency * area * light, rel=0.005)
    voltage, current = cell.open_circuit_voltage_v, cell.short_circuit_current_a
    if power is not None and voltage is not None and current is not None:
        assert 0.7 < power / (voltage * current) < 0.9  # fill factor
    assert cell.mass_kg_per_m2 is None or 0.05 < cell.mass_kg_per_m2 < 1.0


def test_cells_are_compared_on_what_their_data_sheets_guarantee():
    batteries = entries("batteries")
    # LG: 3100 mAh or more, 44.5 g and 1.0 g of tolerance; Samsung: 3350 mAh or more, 50 g or less.
    for name, wh, kg in (
        ("lg-mh1", 3.7 * 3.1, 0.0455),
        ("samsung-35e", 3.6 * 3.35, 0.050),
        ("molicel-p45b", 15.5, 0.070),
        ("lg-m50lt", 17.6, 0.0685),
    ):
        battery = batteries[name]
        assert battery.basis == "min/max"
        assert battery.specific_energy == pytest.approx(wh / kg)


@pytest.mark.parametrize("battery", BATTERIES, ids=label)
def test_every_battery_says_its_basis(battery):
    if battery.kind == "pack":
        assert battery.basis == "pack"
    elif battery.mass_kg and (battery.capacity_ah or battery.energy_wh):
        assert battery.basis == "min/max"
    elif battery.mass_kg or (battery.typical_mass_kg and battery.nominal_voltage_v):
        assert battery.basis == "typical"
    else:
        assert battery.basis == "stated"
        assert battery.specific_energy == battery.specific_energy_wh_per_kg
    # Typical values are never the worse ones.
    for less, more in (
        (battery.capacity_ah, battery.typical_capacity_ah),
        (battery.energy_wh, battery.typical_energy_wh),
        (battery.typical_mass_kg, battery.mass_kg),
    ):
        assert less is None or more is None or less < more


def test_typical_values_count_where_there_are_no_guaranteed_ones():
    def entry(**numbers):
        typical = {"typical_capacity_ah": 3.5, "typical_mass_kg": 0.048, "nominal_voltage_v": 3.6}
        return BatteryEntry.model_validate({**SOUND, **typical, **numbers})

    battery = entry(maximum_charge_current_a=1.75, dc_resistance_ohm=0.036)
    assert (battery.basis, battery.capacity, battery.mass) == ("typical", 3.5, 0.048)
    assert battery.specific_energy == pytest.approx(3.6 * 3.5 / 0.048)
    assert battery.charge_rate_per_h == pytest.approx(0.5)
    assert battery.loss_at_1c == pytest.approx(0.036 * 3.5 / 3.6)
    half = entry(mass_kg=0.049)
    assert (half.basis, half.mass) == ("typical", 0.049)
    whole = entry(mass_kg=0.049, capacity_ah=3.4)
    assert (whole.basis, whole.capacity) == ("min/max", 3.4)
    assert whole.specific_energy == pytest.approx(3.6 * 3.4 / 0.049)
    # What a maker states may be the typical value: here 7 % above the least energy over mass.
    stated = entry(mass_kg=0.049, capacity_ah=3.3, specific_energy_wh_per_kg=259.0)
    assert stated.specific_energy == pytest.approx(3.6 * 3.3 / 0.049)


@pytest.mark.parametrize("motor", MOTORS, ids=label)
def test_best_efficiency_is_the_maximum_over_the_current(motor):
    voltage = motor.nominal_voltage_v or 22.2
    current = np.linspace(1.001 * motor.no_load_current_a, voltage / motor.resistance_ohm, 200_001)
    loaded = voltage - current * motor.resistance_ohm
    efficiency = (current - motor.no_load_current_a) * loaded / (current * voltage)
    best = motor.best_efficiency(voltage)
    assert best == pytest.approx(float(efficiency.max()), rel=1e-6)
    at = sqrt(voltage * motor.no_load_current_a / motor.resistance_ohm)
    assert at == pytest.approx(float(current[efficiency.argmax()]), rel=1e-2)
    assert 0.75 < best < 0.95
    assert motor.best_efficiency(2.0 * voltage) > best


def test_motor_of_a_data_sheet_with_its_maximum_efficiency():
    # maxon, RE 40, 148867: maximum efficiency 92 %, no-load 7580 rpm, stall 80.2 A, at 24 V.
    motor = entries("motors")["maxon-re40-148867"]
    assert motor.best_efficiency(24.0) == pytest.approx(0.92, abs=0.005)
    no_load_rpm = motor.speed_constant_rpm_per_v * (
        24.0 - motor.no_load_current_a * motor.resistance_ohm
    )
    assert no_load_rpm == pytest.approx(7580.0, rel=0.005)
    assert 24.0 / motor.resistance_ohm == pytest.approx(80.2, rel=0.005)


@pytest.mark.parametrize("propeller", PROPELLERS, ids=label)
def test_a_propeller_is_as_large_as_its_name_says(propeller):
    inches = propeller.label.split()[-1].rstrip("EFS").split("x")
    assert [float(inch) * 0.0254 for inch in inches] == pytest.approx(
        [propeller.diameter_m, propeller.pitch_m], rel=1e-4
    )


def test_what_the_file_says_of_a_propeller_wins():
    taken = PropellerChoice.model_validate({"product": "apc-10x4-7sf"})
    assert (taken.diameter_m, taken.chords) == (0.254, "slow_flyer")
    choice = PropellerChoice.model_validate({"product": "apc-10x4-7sf", "pitch_m": 0.2})
    assert (choice.diameter_m, choice.pitch_m) == (0.254, 0.2)
    assert choice.model_dump(exclude_unset=True) == {"product": "apc-10x4-7sf", "pitch_m": 0.2}
    with pytest.raises(ValidationError, match="did you mean apc-19x12e"):
        PropellerChoice.model_validate({"product": "apc-19x12"})


SOUND = {"label": "mine", "source": "measured on the bench"}


@pytest.mark.parametrize(
    ("kind", "numbers", "words"), refusals(Path(__file__).with_name("contradictions.txt"))
)
def test_what_contradicts_itself_is_refused(kind, numbers, words):
    with pytest.raises(ValidationError, match=words):
        globals()[kind].model_validate({**SOUND, **yaml.safe_load(numbers)})
    own = {"sources": {"area_m2": "a drawing of the cell"}}
    cell = CellEntry(**SOUND, **own, efficiency_stc=0.2, area_m2=0.01)
    assert cell.source_of("area_m2") == "a drawing of the cell"
    assert cell.source_of("efficiency_stc") == SOUND["source"]
