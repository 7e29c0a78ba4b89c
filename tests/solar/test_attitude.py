"""Body axes against the rotations of scipy and against hand-held aircraft."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from solar.geometry import direction_cosines

# Sums of products of sines and cosines, each good to a few units in the last place of 1.
ROUNDING = 1e-14

angles = st.floats(-2.0 * np.pi, 2.0 * np.pi)


@given(angles, angles, angles)
def test_matrix_agrees_with_scipy(roll: float, pitch: float, yaw: float) -> None:
    expected = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    assert direction_cosines(roll, pitch, yaw) == pytest.approx(expected, rel=0.0, abs=ROUNDING)


@given(angles, angles, angles)
def test_matrix_is_a_rotation(roll: float, pitch: float, yaw: float) -> None:
    matrix = direction_cosines(roll, pitch, yaw)
    assert matrix @ matrix.T == pytest.approx(np.eye(3), abs=ROUNDING)
    assert np.linalg.det(matrix) == pytest.approx(1.0, abs=ROUNDING)


@pytest.mark.parametrize(
    ("roll_deg", "pitch_deg", "yaw_deg", "forward", "right"),
    [
        (0.0, 0.0, 0.0, (1, 0, 0), (0, 1, 0)),  # level, northwards
        (0.0, 0.0, 90.0, (0, 1, 0), (-1, 0, 0)),  # level, eastwards: right wing to the south
        (90.0, 0.0, 0.0, (1, 0, 0), (0, 0, 1)),  # right wing straight down
        (0.0, 90.0, 0.0, (0, 0, -1), (0, 1, 0)),  # nose straight up
    ],
)
def test_axes_of_simple_attitudes(
    roll_deg: float,
    pitch_deg: float,
    yaw_deg: float,
    forward: tuple[int, int, int],
    right: tuple[int, int, int],
) -> None:
    matrix = direction_cosines(*np.radians([roll_deg, pitch_deg, yaw_deg]))
    assert matrix @ [1, 0, 0] == pytest.approx(forward, abs=ROUNDING)
    assert matrix @ [0, 1, 0] == pytest.approx(right, abs=ROUNDING)


def test_angles_broadcast() -> None:
    roll, yaw = np.linspace(-1.0, 1.0, 4), np.linspace(0.0, 6.0, 5)
    matrices = direction_cosines(roll[:, None], 0.1, yaw)
    assert matrices.shape == (4, 5, 3, 3)
    assert np.array_equal(matrices[2, 3], direction_cosines(roll[2], 0.1, yaw[3]))
