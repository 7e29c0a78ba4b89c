"""The flight envelope against CS-23 by hand, and against what the structure is sized for."""

import numpy as np
import pytest

import missions
import sizing
import studies

MISSION = missions.load_mission("rafz-july")


def analysed(**changes):
    keys = {f"airframe.structure.{key}": value for key, value in changes.items()}
    return sizing.analyse(sizing.load_aircraft("atlantiksolar-design", keys), MISSION)


def envelope(**changes):
    return analysed(**changes).structure.flight_envelope


def test_numbers_by_hand():
    analysis = analysed()
    limits, mass_kg = analysis.structure.flight_envelope, analysis.total_mass_kg
    area_m2 = 5.65**2 / 18.5
    # Lift at C_L max 1.4 carries the weight at the stall, in air of sea level.
    assert 0.5 * 1.225 * limits.stall_speed_m_per_s**2 * area_m2 * 1.4 == pytest.approx(
        mass_kg * 9.80665, rel=1e-6
    )
    air = MISSION.air_state()
    ratio = float(air.density_kg_per_m3) / 1.225
    assert limits.cruise_speed_m_per_s == pytest.approx(analysis.airspeed_m_per_s * ratio**0.5)
    assert limits.dive_speed_m_per_s == pytest.approx(1.5 * limits.cruise_speed_m_per_s)
    assert limits.manoeuvre_load_factor == pytest.approx(2.1 + 10900.0 / (mass_kg + 4536.0))
    # CS 23.341 with the lift slope of the lifting line.
    slope, chord = 2.0 * np.pi * 18.5 / 20.5, 5.65 / 18.5
    mu = 2.0 * mass_kg / (float(air.density_kg_per_m3) * area_m2 * chord * slope)
    alleviation = 0.88 * mu / (5.3 + mu)
    for speed, gust, increment in (
        (limits.cruise_speed_m_per_s, 15.25, limits.cruise_gust_increment),
        (limits.dive_speed_m_per_s, 7.6, limits.dive_gust_increment),
    ):
        pressure = mass_kg * 9.80665 / area_m2
        by_hand = alleviation * 1.225 * slope * gust * speed / (2.0 * pressure)
        assert increment == pytest.approx(by_hand, rel=1e-6)


@pytest.mark.parametrize("gust", [0.0, 5.0, 15.25, 25.0])
def test_structure_is_sized_for_the_outline(gust):
    limits = envelope(cruise_gust_m_per_s=gust)
    most = max(limits.cruise_gust_increment, limits.dive_gust_increment)
    # The smooth maximum lies above both by a few hundredths.
    up = max(limits.manoeuvre_load_factor, 1.0 + most)
    down = max(limits.negative_manoeuvre_load_factor, most - 1.0)
    assert up - 1e-9 <= limits.limit_load_factor <= 1.05 * up
    assert down - 1e-9 <= limits.negative_limit_load_factor <= 1.1 * down


def test_manoeuvres_are_limited_by_lift_and_code():
    limits = envelope()
    up, down = limits.manoeuvre([0.0, limits.stall_speed_m_per_s, limits.dive_speed_m_per_s, 1e3])
    dive_ratio = limits.dive_speed_m_per_s / limits.stall_speed_m_per_s
    assert up == pytest.approx([0.0, 1.0, dive_ratio**2, limits.manoeuvre_load_factor])
    assert down == pytest.approx([0.0, -1.0, 0.0, 0.0])


def test_another_structure_has_no_envelope():
    spar = sizing.load_aircraft("atlantiksolar-design", {"airframe.structure": {"model": "spar"}})
    with pytest.raises(ValueError, match="has no rib_wing"):
        studies.plot_flight_envelope(sizing.analyse(spar, MISSION))
    axes = studies.plot_flight_envelope(analysed()).axes[0]
    manoeuvres, gusts, limits = axes.get_legend_handles_labels()[1]
    assert (manoeuvres, limits) == ("manoeuvres", "limit loads of the structure")
    assert gusts == "gusts at cruise and dive speed"
