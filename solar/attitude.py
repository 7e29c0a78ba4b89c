"""Attitude of the aircraft: from body axes to the local horizon.

The body's axes are x forward, y to the right, z down; the horizon's are North, East, Down.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from solar.types import FloatArray


def direction_cosines(roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> FloatArray:
    """Rotation matrix that takes a vector from body axes to North-East-Down.

    Its columns are the body axes x, y and z seen in North-East-Down. Its transpose takes a vector
    the other way, for instance the one to the sun.

    Parameters
    ----------
    roll, pitch, yaw : array_like
        Euler angles of the sequence 3-2-1 [rad]: yaw from north, clockwise seen from above, then
        nose up, then right wing down. They broadcast against each other.

    Returns
    -------
    ndarray
        Matrices on the last two axes: the broadcast shape of the angles plus ``(3, 3)``.

    Notes
    -----
    Source: Beard & McLain, Small Unmanned Aircraft: Theory and Practice (2012), section 2.2,
    transpose of the rotation from vehicle to body frame.
    """
    phi, theta, psi = np.broadcast_arrays(
        np.asarray(roll, float), np.asarray(pitch, float), np.asarray(yaw, float)
    )
    s_phi, c_phi = np.sin(phi), np.cos(phi)
    s_theta, c_theta = np.sin(theta), np.cos(theta)
    s_psi, c_psi = np.sin(psi), np.cos(psi)
    forward = (c_theta * c_psi, c_theta * s_psi, -s_theta)
    right = (
        s_phi * s_theta * c_psi - c_phi * s_psi,
        s_phi * s_theta * s_psi + c_phi * c_psi,
        s_phi * c_theta,
    )
    down = (
        c_phi * s_theta * c_psi + s_phi * s_psi,
        c_phi * s_theta * s_psi - s_phi * c_psi,
        c_phi * c_theta,
    )
    axes = [np.stack(axis, axis=-1) for axis in (forward, right, down)]
    return np.stack(axes, axis=-1)
