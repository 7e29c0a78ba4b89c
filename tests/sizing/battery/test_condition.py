"""Temperature, internal resistance and age of the battery, against hand values and invariants."""

from math import exp

import numpy as np
import pytest
from builders import aircraft, mission
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from sizing.battery.battery import Battery
from sizing.battery.condition import Ageing, BatteryTemperature, InternalResistance
from sizing.day.battery import Store
from sizing.parameters import with_parameter
from sizing.program.objectives import Objective
from sizing.program.size import size_aircraft
from sizing.results.analysis import analyse
from sizing.results.design_result import battery_condition
from studies.render.analysis import part_tables

PLAIN = Battery(mass_kg=3.0, specific_energy_wh_per_kg=250.0)
temperatures = st.floats(-60.0, 60.0)


def heated(**changes):
    return BatteryTemperature(**({"held_c": 10.0, "heat_loss_w_per_k": 0.4} | changes))


def test_capacity_is_that_of_the_specification():
    # Samsung INR18650-15L, section 7.5; linear between, constant beyond.
    points = np.array([-40.0, -20.0, -10.0, 0.0, 12.5, 25.0, 60.0, 90.0])
    expected = [0.6, 0.6, 0.75, 0.8, 0.9, 1.0, 1.0, 1.0]
    assert BatteryTemperature().capacity_fraction(points) == pytest.approx(expected)
    # An unlimited heater holds the temperature.
    air_c = np.array([-30.0, 0.0, 10.0, 20.0])
    assert heated().pack_c(air_c) == pytest.approx([10.0, 10.0, 10.0, 20.0])
    assert heated().heater_parts_w(air_c)[0] == pytest.approx([16.0, 4.0, 0.0, 0.0])


@given(temperatures, st.floats(-5.0, 10.0), st.floats(0.1, 30.0))
def test_the_heater_gives_what_the_pack_loses(air_c, offset_k, most_w):
    pack = heated(ambient_offset_k=offset_k, heater_power_w=most_w)
    lost_w = 0.4 * (pack.pack_c(air_c) - air_c - offset_k)
    heater_w, _ = pack.heater_parts_w(air_c)
    assert heater_w == pytest.approx(lost_w, abs=1e-9)
    assert 0.0 <= heater_w <= most_w * (1.0 + 1e-12)
    assert pack.pack_c(air_c) <= max(10.0, air_c + offset_k) + 1e-9


def test_fade_is_the_published_law():
    aged = Ageing(cycles=100.0, months=12.0, depth_of_discharge=0.8, mean_voltage_v=3.7)
    calendar = (7.543 * 3.7 - 23.75) * 1e6 * exp(-6976.0 / 298.15) * 365.0**0.75
    cycle = (7.348e-3 * 0.033**2 + 7.6e-4 + 4.081e-3 * 0.8) * (100 * 2 * 0.8 * 2.05) ** 0.5
    assert aged.calendar_fade() == pytest.approx(calendar, rel=1e-12)
    assert aged.cycle_fade() == pytest.approx(cycle, rel=1e-12)
    assert aged.capacity_fraction() == pytest.approx(1.0 - calendar - cycle, rel=1e-12)
    assert calendar == pytest.approx(0.0239, abs=1e-3)
    assert cycle == pytest.approx(0.073, abs=1e-3)
    # A season is its cycles and a year.
    season = Ageing(seasons_flown=2.0, cycles_per_season=150.0)
    assert season.capacity_fraction() == Ageing(cycles=300.0, months=24.0).capacity_fraction()
    assert Ageing().capacity_fraction() == Ageing().resistance_factor() == 1.0


@given(st.floats(0.0, 500.0), st.floats(0.0, 36.0), st.floats(1.0, 300.0), st.floats(0.05, 1.0))
def test_capacity_falls_and_resistance_rises_with_age(cycles, months, more, depth):
    young = Ageing(cycles=cycles, months=months, depth_of_discharge=depth)
    for older in (
        young.model_copy(update={"cycles": cycles + more}),
        young.model_copy(update={"months": months + more / 30.0}),
    ):
        assert older.capacity_fraction() < young.capacity_fraction()
        assert older.resistance_factor() > young.resistance_factor()


def test_efficiencies_are_the_voltage_that_is_left():
    law = InternalResistance(loss_at_1c=0.05, discharge_rate_per_h=0.1, charge_rate_per_h=0.3)
    assert law.discharge_efficiency(1.0) == pytest.approx(1.0 - 0.005)
    assert law.charge_efficiency(1.0) == pytest.approx(1.0 / 1.015)
    cold = law.model_copy(update={"temperature_c": 0.0})
    assert cold.discharge_efficiency(1.0) < law.discharge_efficiency(1.0)
    faster = law.model_copy(update={"discharge_rate_per_h": 0.2, "charge_rate_per_h": 0.5})
    assert faster.discharge_efficiency(1.0) < law.discharge_efficiency(1.0)
    assert faster.charge_efficiency(1.0) < law.charge_efficiency(1.0)


def test_the_march_takes_the_efficiencies_of_the_aged_resistance():
    law = InternalResistance(loss_at_1c=0.05, discharge_rate_per_h=0.1, charge_rate_per_h=0.3)
    new = PLAIN.model_copy(update={"resistance": law})
    old = new.model_copy(update={"ageing": Ageing(cycles=300.0, months=24.0)})
    assert Store.of(new).discharge_efficiency == law.discharge_efficiency(1.0)
    assert Store.of(old).discharge_efficiency < Store.of(new).discharge_efficiency
    assert Store.of(old).charge_efficiency < Store.of(new).charge_efficiency


FALLING = {"table_c": (10.0, 0.0), "table_capacity_fraction": (0.9, 1.0)}
FAST = {"loss_at_1c": 1.0, "discharge_rate_per_h": 1.0, "charge_rate_per_h": 0.1}


@pytest.mark.parametrize(
    ("record", "values", "message"),
    [
        (BatteryTemperature, {"held_c": 5.0}, "needs held_c and either"),
        (BatteryTemperature, {"heater_power_w": 5.0}, "needs held_c"),
        (BatteryTemperature, {"table_c": (0.0, 10.0)}, "same length"),
        (BatteryTemperature, FALLING, "increase"),
        (Ageing, {"cycles": 1e6}, "nothing is left"),
        (InternalResistance, FAST, "of the voltage"),
    ],
)
def test_what_cannot_be_is_refused(record, values, message):
    with pytest.raises(ValidationError, match=message):
        record(**values)


IN_FLIGHT = (
    "battery.temperature={held_c: 10, heat_loss_w_per_k: 0.2}",
    "battery.resistance={loss_at_1c: 0.05, discharge_rate_per_h: 0.06, charge_rate_per_h: 0.2}",
    "battery.ageing={seasons_flown: 1}",
)
COLD = mission(air={"ambient_temperature_c": -5.0})


def spelled_out(name):
    """Aircraft whose plain keys say what IN_FLIGHT makes of it in the cold."""
    battery = aircraft(name, *IN_FLIGHT).battery
    plain = aircraft(name)
    for key, value in {
        "battery.specific_energy_wh_per_kg": plain.battery.specific_energy_wh_per_kg
        * battery.capacity_fraction(-5.0),
        "battery.charge_efficiency": battery.mean_charge_efficiency,
        "battery.discharge_efficiency": battery.mean_discharge_efficiency,
        "power.avionics_w": plain.power.avionics_w + 0.2 * 15.0 * plain.power.supply_efficiency,
    }.items():
        plain, _ = with_parameter(plain, COLD, key, float(value))
    return plain


@pytest.mark.long
@pytest.mark.parametrize("flight", [{}, {"climb": {"ceiling_m": 1500.0}}], ids=["level", "climb"])
def test_an_analysis_is_that_of_the_plain_keys_that_say_the_same(flight):
    where = mission(air={"ambient_temperature_c": -5.0}, **flight)
    analysis = analyse(aircraft("atlantiksolar-as2", *IN_FLIGHT), where)
    plain = analyse(spelled_out("atlantiksolar-as2"), where)
    assert analysis.excess_time_h == pytest.approx(plain.excess_time_h, abs=1e-9)
    assert analysis.excess_time_h < analyse(aircraft("atlantiksolar-as2"), where).excess_time_h


def test_a_sizing_is_that_of_the_plain_keys_that_say_the_same():
    sized = [
        size_aircraft(loaded, COLD, Objective.min_mass)
        for loaded in (
            aircraft("atlantiksolar-design", *IN_FLIGHT),
            spelled_out("atlantiksolar-design"),
            aircraft("atlantiksolar-design"),
        )
    ]
    masses = [result.objective_value for result in sized]
    # Rounding lays an interval of the day elsewhere, which moves an optimum by some 1e-5.
    assert masses[0] == pytest.approx(masses[1], rel=5e-5)
    assert masses[0] > 1.02 * masses[2]
    assert float(np.min(sized[0].simulated.cycle.excess_time_h)) >= 0.0


def test_facts_have_temperature_age_and_what_is_left():
    loaded = aircraft("atlantiksolar-as2", *IN_FLIGHT)
    air = COLD.air_state().temperature_c, COLD.altitude_m
    analysis = analyse(loaded, COLD)
    (table,) = part_tables(analysis, "battery")
    facts = dict(table.rows)
    assert facts["temperature"] == "10 °C"
    assert (facts["cycles"], facts["age in months"]) == ("180", "12")
    assert (facts["capacity left"], facts["heater"]) == ("80 %", "3.0 W")
    assert "capacity left" in analysis.at_level(2).to_text()
    record = battery_condition(loaded, *air)._asdict()
    assert record["capacity_fraction"] == loaded.battery.capacity_fraction(-5.0)
    plain = aircraft("atlantiksolar-as2")
    assert battery_condition(plain, *air) is None
    assert "battery_condition" not in analyse(aircraft("atlantiksolar-as2"), COLD).to_dict()
