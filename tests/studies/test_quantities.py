"""Tests of the catalogue of quantities: what is declared once agrees with what is computed."""

import math

import numpy as np
import pytest

import missions
import sizing
from sizing.parameters import parameter
from sizing.performance import OF_SCENARIO
from studies import quantities
from studies.quantities import Quantity

EVERY = [one for one in quantities.TABLE.values() if one.meaning or one.path]
LOSS = Quantity("loss_m_per_s", "loss", "m/s", ".2f")


@pytest.fixture(scope="module")
def analysis():
    mission = missions.load_mission("central-europe-summer")
    return sizing.analyse(sizing.load_aircraft("atlantiksolar-as2"), mission, replay=False)


def test_no_quantity_is_declared_twice():
    names = [one.name for one in EVERY]
    assert len(names) == len(set(names))
    assert len({one.variable for one in EVERY}) == len(names)


@pytest.mark.parametrize(
    ("value", "text"), [(2.0, "2.00 m/s"), (math.inf, "unlimited"), (math.nan, "-"), (None, "-")]
)
def test_a_unit_stands_behind_numbers_alone(value, text):
    assert LOSS.fact(value) == ("loss", text)
    assert LOSS.variable == "loss"


def test_shares_are_told_in_per_cent():
    share = quantities.TABLE["minimum_state_of_charge"]
    table = quantities.table_of("", [share], [{share.name: 0.1234}, {share.name: 1.0}])
    assert table.to_text().split() == ["min.", "SoC", "[%]", "─" * 12, "12.3", "100.0"]
    assert quantities.MINIMUM_CHARGE.fact(0.1234) == ("minimum state of charge", "12.3 %")
    assert quantities.MINIMUM_CHARGE.described[0] == "1"


def test_an_analysis_has_the_values_of_its_cycles(analysis):
    cycle, values = analysis.performance.cycle, analysis.scenario()
    worst = int(np.argmin(cycle.excess_time_h))
    assert list(values) == list(OF_SCENARIO)
    assert values["excess_time_h"] == cycle.excess_time_h[worst]
    assert values["load_energy_wh"] == cycle.energy_budget.load_wh[worst]
    other = analysis.scenario(1)
    assert other["sunrise_h"] == analysis.performance.day.sunrise_h[1]


def test_keys_of_a_record_and_columns_of_a_frame_are_those_of_their_groups(analysis):
    record, frame = analysis.to_dict()["scenarios"][1], analysis.to_frame()
    assert record.keys() > set(OF_SCENARIO)
    assert set(list(frame)[2:]) < set(record)
    assert frame["charge_margin_h"][1] == record["charge_margin_h"]


def test_quantities_of_a_design_have_the_words_of_the_catalogue_of_parameters():
    for one in (
        *quantities.DESIGN_COLUMNS,
        *quantities.OF_AIRCRAFT,
        quantities.TABLE["wing_loading_kg_per_m2"],
    ):
        known = parameter(one.name)
        assert (one.label, one.unit or "1", one.symbol) == (known.label, known.unit, known.symbol)
