import pytest
from builders import AS2, DESIGN
from propulsors import VOLTAGE, aircraft

import sizing
from missions.library import load_mission
from sizing.mass_budget import parametric_design
from sizing.results.design_result import requirement_margins

MISSION = load_mission("rafz-july", {"wind_m_per_s": 4.0})


def margins(aircraft, **mission):
    flown = sizing.analyse(aircraft, load_mission("rafz-july", {"wind_m_per_s": 4.0} | mission))
    return {one.name: one for one in requirement_margins(aircraft, flown.performance, 3.0)}


def test_every_requirement_has_its_margin():
    limits = {"airspeed_m_per_s": {"maximum": 12.0}}
    own = sizing.load_aircraft("atlantiksolar-design", {"design_space.limits": limits})
    found, analysis = margins(own), sizing.analyse(own, MISSION)
    design = analysis.performance.design
    assert found["excess_time_h"].margin == pytest.approx(analysis.excess_time_h - 3.0)
    speed = design.airspeed_m_per_s
    assert found["airspeed_above_wind"].margin == pytest.approx(speed / 4.0 - 1.0)
    assert found["airspeed_m_per_s_maximum"].margin == pytest.approx(1.0 - speed / 12.0)
    # Lift at the stall over lift in flight, 1.15 and 0.8 in the file.
    polar = own.airframe.aerodynamics  # type: ignore[union-attr]
    ratio = (polar.maximum_lift_coefficient / polar.lift_coefficient) ** 0.5
    stall = found["stall_margin"]
    assert (stall.value, stall.limit, stall.recommended) == (pytest.approx(ratio), 1.2, True)
    given = sizing.load_aircraft("atlantiksolar-design", {"design_space.minimum_stall_margin": 1.1})
    assert margins(given)["stall_margin_minimum"].limit == 1.1
    assert "stall_margin" not in margins(given)


def test_the_wind_of_a_percentile_has_its_margin():
    design = sizing.load_aircraft("stratosphere-design")
    for held in (False, True):
        windy = {"wind": {"percentile": 95, "hold_station": held}}
        mission = load_mission("stratosphere-mission", windy)
        flown = sizing.analyse(design, mission).performance
        found = {one.name: one for one in requirement_margins(design, flown, 1.0)}
        assert ("airspeed_above_wind" in found) is not held
        if not held:
            one, strongest = found["airspeed_above_wind"], mission.strongest_wind_m_per_s
            assert (one.limit, one.margin) == (strongest, one.value / strongest - 1.0)


def test_climb_is_that_of_the_highest_altitude():
    low = margins(DESIGN)["climb_rate_at_highest_altitude_m_per_s"]
    own = sizing.design_of(DESIGN, MISSION)
    chain = own.chain
    # What the rated power, so many times that of level flight, has to spare lifts the weight.
    spare_w = (chain.climb_power_ratio - 1.0) * own.propulsion_power_w
    climb = spare_w * chain.efficiency / own.total_mass_kg / 9.80665
    assert low.value == pytest.approx(climb, rel=1e-6)
    high = margins(DESIGN, climb={"strategy": "surplus", "ceiling_m": 4000.0})
    aloft = high["climb_rate_at_highest_altitude_m_per_s"]
    assert "4000 m" in aloft.label
    assert 0.0 < aloft.value < low.value


def test_an_empty_battery_climbs_with_what_its_voltage_allows():
    empty, full = (
        VOLTAGE | {"state_of_charge": [0.0, 1.0], "cell_voltage_v": [least_v, 4.2]}
        for least_v in (3.2, 3.6)
    )
    own = aircraft(voltage=empty)
    found, better = margins(own), margins(aircraft(voltage=full))
    climb = found["climb_rate_with_empty_battery_m_per_s"].value
    assert climb > 0.0
    assert better["climb_rate_with_empty_battery_m_per_s"].value > climb
    assert better["duty"].value < found["duty"].value < 1.0
    assert found["motor_current"].limit == 6.0
    # The thrust of that climb can be had with the empty battery, 4 % more cannot: a step is 1.4 %.
    design = sizing.design_of(own, MISSION)
    weight_n = design.total_mass_kg * 9.80665
    drag_n = design.propulsion_power_w * design.chain.efficiency / design.airspeed_m_per_s  # type: ignore[union-attr]
    thrust_n = drag_n + climb * weight_n / design.airspeed_m_per_s
    parts = own.airframe.propulsion  # type: ignore[union-attr]
    for factor, able in ((0.999, True), (1.04, False)):
        point = sizing.operating_point(
            parts.propulsor, factor * thrust_n, design.airspeed_m_per_s, MISSION.air_state(), 19.2
        )
        assert bool(point.feasible) is able


def test_a_measured_aircraft_has_what_is_known_of_it():
    assert {"excess_time_h", "minimum_state_of_charge"} <= margins(AS2).keys()
    assert "module_coverage" not in margins(AS2)


def test_mass_growth_is_a_share_of_what_is_built():
    plain = sizing.design_of(DESIGN, MISSION)
    grown = sizing.load_aircraft("atlantiksolar-design", {"airframe.mass_growth": 0.1})
    same = parametric_design(grown, MISSION, plain.variables, plain.total_mass_kg)
    assert same.masses.structure == pytest.approx(1.1 * plain.masses.structure, rel=1e-9)
    assert same.masses.other == pytest.approx(1.1 * plain.masses.other, rel=1e-9)
    assert same.masses.propulsion == pytest.approx(plain.masses.propulsion, rel=1e-9)
    heavier = sizing.design_of(grown, MISSION)
    # The structure carries its own growth.
    assert heavier.total_mass_kg - plain.total_mass_kg > 0.1 * plain.masses.structure
    known = sizing.with_total_mass(grown, MISSION, 7.5)
    assert sizing.design_of(known, MISSION).total_mass_kg == pytest.approx(7.5, rel=1e-9)
