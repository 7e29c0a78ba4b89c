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


def test_angles_broadcast() -> None:
    roll, yaw = np.linspace(-1.0, 1.0, 4), np.linspace(0.0, 6.0, 5)
    matrices = direction_cosines(roll[:, None], 0.1, yaw)
    assert matrices.shape == (4, 5, 3, 3)
    assert np.array_equal(matrices[2, 3], direction_cosines(roll[2], 0.1, yaw[3]))
