import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from solar.geometry import (
    ModuleGeometry,
    ModuleSurface,
    cos_angle_of_incidence,
    direction_cosines,
)

angles = st.floats(-1.4, 1.4)


def surface(side, dihedral=0.0, pitch=0.0, area=1.0):
    return ModuleSurface(name=side, area_m2=area, side=side, dihedral_deg=dihedral, pitch_deg=pitch)


def test_dihedral_turns_the_outer_surfaces_inwards():
    geometry = ModuleGeometry(surfaces=(surface("left", 6.0), surface("right", 6.0)))
    left, right = geometry.normals()
    # The left wing's upper side faces right (y positive), the right wing's faces left.
    assert left[1] == pytest.approx(np.sin(np.radians(6.0)))
    assert right == pytest.approx(left * [1.0, -1.0, 1.0])


def test_incidence_turns_the_whole_wing():
    geometry = ModuleGeometry(wing_incidence_deg=5.7, surfaces=(surface("left", 6.0, 9.4),))
    # Module pitch about y, dihedral about x, incidence about y: rotations of an independent tool.
    turns = Rotation.from_euler("yxy", [9.4, 6.0, 5.7], degrees=True)
    assert geometry.normals()[0] == pytest.approx(turns.apply([0.0, 0.0, -1.0]), abs=1e-12)


def test_central_wing_is_the_mean_of_the_centre():
    outer = [surface(side, 6.0, 30.0) for side in ("left", "right")]
    centre = [surface("centre", pitch=pitch) for pitch in (-0.5, 9.4)]
    geometry = ModuleGeometry(wing_incidence_deg=5.7, surfaces=(*outer, *centre))
    # Two equal surfaces: their mean normal lies half-way between both pitches.
    expected = Rotation.from_euler("y", 5.7 + 4.45, degrees=True).apply([0.0, 0.0, -1.0])
    assert geometry.central_wing_normal() == pytest.approx(expected, abs=1e-12)
    # Without a centre the dihedral cancels.
    plain = ModuleGeometry(surfaces=tuple(outer))
    assert plain.central_wing_normal()[1] == pytest.approx(0.0, abs=1e-15)


def test_area_shares_add_up_of_what_is_a_geometry():
    geometry = ModuleGeometry(surfaces=(surface("left", area=0.5), surface("right", area=1.5)))
    assert geometry.area_m2 == pytest.approx(2.0)
    assert geometry.area_shares == pytest.approx([0.25, 0.75])
    with pytest.raises(ValidationError, match="no dihedral"):
        surface("centre", dihedral=3.0)
    with pytest.raises(ValidationError):
        ModuleGeometry(surfaces=())


@given(*[st.floats(-2.0 * np.pi, 2.0 * np.pi)] * 3)
def test_matrix_agrees_with_scipy(roll, pitch, yaw):
    # Sums of products of sines and cosines, each good to a few units in the last place of 1.
    expected = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    assert direction_cosines(roll, pitch, yaw) == pytest.approx(expected, rel=0.0, abs=1e-14)


@given(angles, angles, st.floats(0.0, 6.28), angles, angles)
def test_angle_of_incidence_is_that_of_the_chord_between_unit_vectors(roll, pitch, yaw, dip, turn):
    normal = direction_cosines(roll, pitch, yaw) @ [0.0, 0.0, -1.0]
    sun = direction_cosines(dip, turn, 1.0) @ [0.0, 0.0, -1.0]
    chord = np.linalg.norm(normal - sun)
    assert cos_angle_of_incidence(normal, sun) == pytest.approx(1.0 - chord**2 / 2.0, abs=1e-12)
