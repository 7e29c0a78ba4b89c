import numpy as np
import pytest
from builders import DESIGN
from propulsors import PARTS, PROPULSOR, VOLTAGE, aircraft

import sizing
from missions.files.errors import InputError
from missions.library import load_mission
from sizing.mass_budget import level_point, parametric_design
from sizing.propulsion.operating_point import operating_point
from sizing.results.design_result import power_budget
from studies.serialise import serialise

MISSION = load_mission("rafz-july")


def test_power_is_that_of_the_chain_at_the_worse_end_of_the_battery():
    design = sizing.design_of(aircraft(), MISSION)
    thrust_w = design.propulsion_power_w * design.chain.efficiency
    speed = float(design.airspeed_m_per_s)
    # The library by itself, at the thrust of this mass, with an empty and with a full battery.
    both = operating_point(
        PROPULSOR, thrust_w / speed, speed, MISSION.air_state(), [6 * 3.0, 6 * 4.2]
    )
    assert design.propulsion_power_w == pytest.approx(both.bus_power_w.max(), rel=1e-9)
    assert both.bus_power_w[0] != pytest.approx(both.bus_power_w[1], rel=1e-3)
    # Drag does not know of the propulsion: that of the constants' design at this mass.
    same = parametric_design(DESIGN, MISSION, design.variables, design.total_mass_kg)
    assert thrust_w == pytest.approx(same.propulsion_power_w * same.chain.efficiency, rel=1e-12)


@pytest.mark.parametrize("bus_v", [(18.0, 25.2), (25.2, 18.0)])
def test_the_worse_end_of_the_battery_counts_in_either_order(bus_v):
    parts = aircraft().propulsion_by_parts
    air = MISSION.air_state()
    point = parts.point(20.0, 9.0, air, bus_v)
    # The library by itself, with an empty and with a full battery.
    each = operating_point(PROPULSOR, 20.0 / 9.0, 9.0, air, list(bus_v))
    assert point.bus_power_w == pytest.approx(max(each.bus_power_w), rel=1e-9)
    assert point.reason == ""
    # An end at which the motor does not turn fast enough counts before one at which it does.
    for low in ((2.0, bus_v[1]), (bus_v[0], 2.0)):
        assert "bus voltage 2 V is below" in str(parts.point(20.0, 9.0, air, low).reason)


def test_masses_of_the_parts_count_for_every_propulsor():
    light = sizing.design_of(aircraft(), MISSION)
    assert light.masses.propulsion == pytest.approx(0.48)  # of the catalogue's motor
    two = aircraft(
        propulsors=2,
        propeller=PARTS["propeller"] | {"mass_kg": 0.03},
        gear=PARTS["gear"] | {"mass_kg": 0.1},
        controller=PARTS["controller"] | {"mass_kg": 0.05},
        mass_kg_per_w=0.001,
    )
    heavy = sizing.design_of(two, MISSION)
    weighed, rated_w = 2 * (0.48 + 0.03 + 0.1 + 0.05), 5.0 * heavy.propulsion_power_w
    assert heavy.masses.propulsion == pytest.approx(weighed + 0.001 * rated_w, rel=1e-9)
    assert heavy.masses.total_kg == pytest.approx(heavy.total_mass_kg, rel=1e-9)
    # Half of the thrust each.
    point = level_point(two, MISSION, heavy)
    assert 2.0 * point.bus_power_w == pytest.approx(heavy.propulsion_power_w, rel=1e-9)


def test_what_cannot_fly_has_a_reason_and_no_number():
    weak = aircraft(voltage=VOLTAGE | {"cells_in_series": 4})
    with pytest.raises(sizing.ImpossibleDesignError, match=r"bus voltage 12 V is below 1\d"):
        sizing.analyse(weak, MISSION)
    with pytest.raises(sizing.ImpossibleDesignError, match="bus voltage 12 V"):
        sizing.size(weak, MISSION)


@pytest.mark.parametrize("name", ["sky-sailor", "atlantiksolar-design", "solong", "parts"])
def test_the_power_budget_adds_up(name):
    subject = aircraft() if name == "parts" else sizing.load_aircraft(name)
    mission = load_mission("rafz-july", {"turbulence.all_day": 0.1, "payload.power_w": 1.5})
    design = sizing.design_of(subject, mission)
    budget = power_budget(subject, mission, design)
    assert budget.bus_w == pytest.approx(design.nominal_load_w(mission), rel=1e-9)
    assert serialise(budget)["payload_w"] == 1.5
    assert (budget.point is not None) == (name == "parts")
    if name == "sky-sailor":
        # The losses of its constants, one after the other from the battery.
        left = float(design.propulsion_power_w)
        for link, efficiency in (
            *(("controller", 0.95), ("motor", 0.85), ("gearbox", 0.97), ("propeller", 0.85)),
        ):
            assert budget.watts[f"{link}_loss_w"] == pytest.approx(left * (1.0 - efficiency))
            left *= efficiency
        assert budget.watts["aerodynamic_w"] == pytest.approx(left)


def test_a_table_with_one_speed_is_refused_with_its_file(tmp_path):
    table = tmp_path / "own.csv"
    table.write_text("# diameter_m: 0.66\nJ,CT,CP,rpm\n0.5,0.1,0.07,900\n1.1,0.02,0.04,900\n")
    with pytest.raises(InputError, match=r"own\.csv: has 900 rpm alone"):
        aircraft(propeller={"table": str(table)})
    held = aircraft(propeller={"table": str(table), "any_speed": True})
    design = sizing.design_of(held, MISSION)
    # Between the two rows: J CT / CP, both linear in J.
    advance = float(level_point(held, MISSION, design).advance_ratio)
    thrust, power = (np.interp(advance, [0.5, 1.1], ends) for ends in ([0.1, 0.02], [0.07, 0.04]))
    assert design.chain.propeller_efficiency == pytest.approx(advance * thrust / power)
    assert held.texts_read == {str(table): table.read_text()}


def test_constants_of_the_catalogue_have_their_source():
    values = {value.key: value for value in aircraft().from_catalogues()}
    resistance = values["airframe.propulsion.motor.resistance_ohm"]
    assert resistance.value == 0.299
    assert "148867" in resistance.source
