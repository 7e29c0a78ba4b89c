"""Tests of planforms and tail planes against integrals over the span."""

import math

import numpy as np
import pytest

from sizing.balance.surfaces import Planform, Tail, lift_slope, wing_of


@pytest.mark.parametrize(("inner", "taper"), [(0.0, 1.0), (0.0, 0.4), (0.6, 0.6), (0.9, 0.2)])
def test_chords_are_those_of_the_integrals(inner, taper):
    wing = Planform(inner_fraction=inner, taper_ratio=taper).wing(5.0, 15.0)
    x = np.linspace(0.0, 1.0, 200_001)
    chord = wing.root_chord_m * np.interp(x, [0.0, inner, 1.0], [1.0, 1.0, taper])
    area = 5.0 * np.trapezoid(chord, x)
    square = 5.0 * np.trapezoid(chord**2, x)
    assert area == pytest.approx(25.0 / 15.0, rel=1e-8)
    assert wing.area_m2 == pytest.approx(area, rel=1e-8)
    assert wing.aerodynamic_chord_m == pytest.approx(square / area, rel=1e-8)
    # Without a planform it is a rectangle.
    wing = wing_of(None, 5.65, 18.5)
    assert wing.root_chord_m == wing.aerodynamic_chord_m == 5.65 / 18.5
    assert wing.at_chord(0.25) == wing.quarter_m
    # Thin airfoils have 2 pi; slender wings pi/2 AR (Jones, NACA TR 835).
    assert lift_slope(1e6) == pytest.approx(2.0 * math.pi, rel=1e-5)
    assert lift_slope(1e-3) == pytest.approx(0.5 * math.pi * 1e-3, rel=1e-3)


def test_tail_has_its_volume_coefficients():
    wing = wing_of(None, 5.0, 15.0)
    by_volume = Tail(arm_chords=4.0, horizontal_volume=0.5, vertical_volume=0.02, fins=2)
    planes = by_volume.planes(wing)
    assert planes.arm_m == pytest.approx(4.0 / 3.0)
    volume = planes.horizontal_m2 * planes.arm_m / (wing.area_m2 * wing.aerodynamic_chord_m)
    assert volume == pytest.approx(0.5)
    assert planes.vertical_m2 * planes.arm_m / (wing.area_m2 * 5.0) == pytest.approx(0.02)
    assert planes.horizontal_span_m * planes.horizontal_chord_m == pytest.approx(
        planes.horizontal_m2
    )
    assert 2.0 * planes.fin_height_m * planes.fin_chord_m == pytest.approx(planes.vertical_m2)
    areas = {"horizontal_area_m2": planes.horizontal_m2, "vertical_area_m2": planes.vertical_m2}
    by_area = Tail(arm_m=4.0 / 3.0, fins=2, **areas)
    assert by_area.planes(wing) == pytest.approx(planes)
    # The defaults in the table of docs/balance.md.
    tail = Tail(arm_m=1.0, horizontal_volume=0.4, vertical_volume=0.02)
    assert (tail.dynamic_pressure_ratio, tail.thickness_ratio) == (0.9, 0.08)
    assert (tail.elevator_chord_fraction, tail.elevator_deflection_deg) == (0.3, 20.0)
    assert (tail.rudder_chord_fraction, tail.rudder_deflection_deg) == (0.4, 25.0)
    assert (tail.horizontal_aspect_ratio, tail.vertical_aspect_ratio, tail.fins) == (5.0, 2.0, 1)


@pytest.mark.parametrize("keys", [{"vertical_arm_m": 2.4}, {"vertical_arm_chords": 8.0}])
def test_fins_may_have_an_arm_of_their_own(keys):
    wing = wing_of(None, 6.0, 20.0)
    both = Tail(arm_m=1.2, horizontal_volume=0.4, vertical_volume=0.02)
    tail = Tail(arm_m=1.2, horizontal_volume=0.4, vertical_volume=0.02, **keys)
    planes = tail.planes(wing)
    # V_v = S_v l/(S b): twice the arm, half the area; the boom is as long as the farther arm.
    assert planes.vertical_m2 == pytest.approx(0.02 * 1.8 * 6.0 / 2.4)
    assert planes.horizontal_m2 == both.planes(wing).horizontal_m2
    assert planes.boom_m == pytest.approx(2.4, rel=1e-3)  # a smooth maximum
    assert (both.planes(wing).vertical_arm_m, both.planes(wing).boom_m) == (1.2, 1.2)
    structure = tail.structure_keys(wing)
    ratios = structure["horizontal_tail_ratio"] + structure["vertical_tail_ratio"]
    area_m2 = ratios / structure["fuselage_chords"] * wing.area_m2
    assert area_m2 == pytest.approx(planes.horizontal_m2 + planes.vertical_m2)
