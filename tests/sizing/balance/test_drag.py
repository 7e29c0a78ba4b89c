"""Tests of drag by components: surfaces integrated, sums that are the power's drag."""

import math

import numpy as np
import pytest
from builders import aircraft, shipped_mission

from missions.files.errors import InputError
from sizing.balance.assessment import drag_shares
from sizing.balance.drag import Pod, skin_friction
from sizing.balance.in_design import structure_with_tail
from sizing.library import load_aircraft
from sizing.mass_budget import design_of

TWIN = aircraft("twin-boom-design")
MISSION = shipped_mission()
TAIL = "airframe.tail={arm_chords: 4, horizontal_volume: 0.35, vertical_volume: 0.02}"


def test_friction_of_plates():
    # Blasius at Re 1e5, and Schlichting's power law at 1e6: 0.0042, 0.0047.
    assert skin_friction(1e5, 1.0) == pytest.approx(0.00420, abs=5e-6)
    assert skin_friction(1e6, 0.0) == pytest.approx(0.00467, abs=5e-6)
    assert skin_friction(1e6, 0.5) == pytest.approx((0.001328 + 0.004669) / 2.0, rel=1e-3)


@pytest.mark.parametrize(("length", "diameter"), [(0.9, 0.13), (1.0, 0.99)])
def test_pods_have_volume_and_surface_of_ellipsoids(length, diameter):
    pod = Pod(length_m=length, diameter_m=diameter, count=2)
    angle = np.linspace(0.0, math.pi, 200_001)
    radius, arc = (
        diameter / 2.0 * np.sin(angle),
        np.hypot(length / 2.0 * np.sin(angle), diameter / 2.0 * np.cos(angle)),
    )
    assert pod.wetted_m2 == pytest.approx(
        2.0 * np.trapezoid(2.0 * math.pi * radius * arc, angle), rel=1e-8
    )
    x = length / 2.0 * np.cos(angle[::-1])
    volume = np.trapezoid(math.pi * radius[::-1] ** 2, x)
    assert pod.volume_m3 == pytest.approx(2.0 * volume, rel=1e-8)


@pytest.mark.parametrize(
    "polar",
    [
        "airframe.avionics_mass_kg=1.0",
        "airframe.aerodynamics={model: wing_polar, airfoil: mh115, design_aspect_ratio: 15, "
        "design_reynolds: 150000}",
    ],
)
def test_the_parts_are_all_of_the_drag(polar):
    loaded = aircraft("twin-boom-design", polar)
    design = design_of(loaded, MISSION)
    shares = drag_shares(loaded, design)
    pressure = 0.5 * design.conditions.density_kg_per_m3 * design.airspeed_m_per_s**2
    drag_n = design.thrust_power_w / design.airspeed_m_per_s
    assert drag_n == pytest.approx(pressure * design.wing_area_m2 * shares.total, rel=1e-9)
    parts = [value for name, value in shares._asdict().items() if name not in ("other", "trim")]
    assert min(parts) > 0.0
    assert shares.other == 0.0
    assert shares.parasitic == pytest.approx(
        shares.total - shares.wing_profile - shares.wing_induced - shares.trim
    )


def test_a_tail_by_hand():
    """Horizontal tail by Raymer's method, with his wetted area and Hoerner's form factor."""
    loaded = aircraft("atlantiksolar-design", TAIL, "airframe.drag={gaps_fraction: 0}")
    design = design_of(loaded, MISSION)
    shares = drag_shares(loaded, design)
    chord = 5.65 / 18.5
    area = 0.35 / 4.0 * 5.65 * chord
    tail_chord = math.sqrt(area / 5.0)
    reynolds = design.reynolds_number * tail_chord / chord
    friction = 0.5 * 1.328 / math.sqrt(reynolds) + 0.5 * 0.074 / reynolds**0.2
    form = 1.0 + 2.0 * 0.08 + 60.0 * 0.08**4
    wetted = (1.977 + 0.52 * 0.08) * area
    expected = friction * form * 1.05 * wetted / (5.65 * chord)
    assert shares.horizontal_tail == pytest.approx(expected, rel=1e-9)
    assert shares.gaps == 0.0


def test_a_pod_by_its_surface_is_that_of_its_diameter_and_has_the_mass_of_the_pod():
    thick = Pod(length_m=0.9, diameter_m=0.13)
    pod = {"length_m": 0.9, "wetted_area_m2": thick.wetted_m2}
    assert Pod(**pod).thick_m == pytest.approx(0.13)
    plain, built = (
        load_aircraft("twin-boom-design", {"airframe.drag.pods": [shape]})
        for shape in ({"length_m": 0.9, "diameter_m": 0.13}, pod)
    )
    masses = []
    for subject in (plain, built):
        design = design_of(subject, MISSION)
        keys = structure_with_tail(subject.parametric, subject.parametric.wingspan_m, 15.0)
        masses.append((design, keys.pod_wetted_area_ratio))
    assert masses[0][1] == 0.08
    area_m2 = built.parametric.wingspan_m**2 / 15.0
    assert masses[1][1] == pytest.approx(thick.wetted_m2 / area_m2)
    assert masses[1][0].masses.structure > masses[0][0].masses.structure
    twice = {"airframe.drag.pods": [pod], "airframe.structure.pod_wetted_area_ratio": 0.1}
    with pytest.raises(InputError, match="give one"):
        load_aircraft("twin-boom-design", twice)


def test_constants_that_the_file_gives_stay():
    coefficient = "airframe.aerodynamics.parasitic_drag_coefficient=0.002"
    loaded = aircraft("atlantiksolar-design", TAIL, "airframe.drag={}", coefficient)
    shares = drag_shares(loaded, design_of(loaded, MISSION))
    assert shares.other == 0.002
    assert drag_shares(aircraft("atlantiksolar-design"), design_of(TWIN, MISSION)) is None
