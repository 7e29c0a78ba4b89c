"""Attitude of the aircraft, its solar module surfaces, and the angle at which light meets them.

Body axes are x forward, y right, z down; the inertial frame is North-East-Down. Source:
Oettershagen's report, eq. 2 and 3 and table 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, Strict, model_validator

from solar.schema import Name, PositiveInteger, PositiveReal, Real, Record
from solar.types import BoolArray, FloatArray


def direction_cosines(roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> FloatArray:
    """Return the rotation matrix that takes a vector from body axes to North-East-Down.

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


_Angle = Annotated[float, Strict(), Field(ge=-60.0, le=60.0, allow_inf_nan=False)]


class ModuleOutline(Record):
    """Rectangle of a module on the wing, in body axes from the wing root's leading edge [m].

    ``inboard_m`` and ``outboard_m`` count along the span from the symmetry plane (a central module
    reaches from minus to plus), ``front_m`` and ``rear_m`` aft along the chord.
    """

    _above: ClassVar[Mapping[str, str]] = {"outboard_m": "inboard_m", "rear_m": "front_m"}

    inboard_m: Real
    outboard_m: Real
    front_m: Real
    rear_m: Real


class ModuleSurface(Record):
    """Flat, module-covered surface of the wing; ``facing`` is ``down`` on its lower face.

    ``pitch_deg`` is relative to the chord line, positive where the surface faces aft (nose up).
    The dihedral of a left or right surface raises its outer end. ``mppt``: number of its MPPT.
    """

    name: Name
    area_m2: PositiveReal
    side: Literal["left", "centre", "right"]
    dihedral_deg: _Angle = 0.0
    pitch_deg: _Angle = 0.0
    facing: Literal["up", "down"] = "up"
    outline: ModuleOutline | None = None
    mppt: PositiveInteger | None = None

    @model_validator(mode="after")
    def _check_side(self) -> ModuleSurface:
        if self.side == "centre" and self.dihedral_deg != 0.0:
            raise ValueError("a surface in the centre has no dihedral: give side: left or right")
        return self


class ModuleGeometry(Record):
    """Module surfaces, and the pitch of the wing's chord line to the body's x axis."""

    wing_incidence_deg: _Angle = 0.0
    surfaces: tuple[ModuleSurface, ...] = Field(min_length=1)

    @property
    def area_m2(self) -> float:
        """Area of all surfaces [m2]."""
        return sum(s.area_m2 for s in self.surfaces)

    @property
    def area_shares(self) -> FloatArray:
        """Share of each surface in the whole area [-]."""
        return np.array([s.area_m2 for s in self.surfaces]) / self.area_m2

    @property
    def face_down(self) -> BoolArray:
        """Flags of the surfaces on the lower face of the wing, shape ``(surface,)``."""
        return np.array([s.facing == "down" for s in self.surfaces])

    def rotations(self) -> FloatArray:
        """Return rotations from the axes of surfaces to those of the body, ``(surface, 3, 3)``.

        A module is pitched in its wing panel, the panel has a dihedral, and the whole wing is set
        on the body at its incidence. Report, eq. 2.
        """
        sides = {"left": 1.0, "centre": 0.0, "right": -1.0}
        roll = np.radians([sides[s.side] * s.dihedral_deg for s in self.surfaces])
        pitch = np.radians([s.pitch_deg for s in self.surfaces])
        panel = direction_cosines(roll, np.radians(self.wing_incidence_deg), 0.0)
        return panel @ direction_cosines(0.0, pitch, 0.0)

    def normals(self) -> FloatArray:
        """Return the unit normals of the surfaces in body axes, shape ``(surface, 3)``.

        Outwards: a level surface has the normal ``[0, 0, -1]``, one that faces down its opposite.
        """
        return np.where(self.face_down, 1.0, -1.0)[:, np.newaxis] * self.rotations()[..., 2]

    def central_wing_normal(self) -> FloatArray:
        """Return the central wing's unit normal in body axes: the mean of its module surfaces.

        An aircraft without surfaces in the centre takes the mean of all, in which the dihedral of
        the two sides cancels. Surfaces of the lower face count where there are no others.
        """
        upper = ~self.face_down if not self.face_down.all() else self.face_down
        central = upper & np.array([s.side == "centre" for s in self.surfaces])
        counted = central if central.any() else upper
        mean = np.where(counted, self.area_shares, 0.0) @ self.normals()
        return np.asarray(mean / np.linalg.norm(mean))


def cos_angle_of_incidence(normals: ArrayLike, sun_vector: ArrayLike) -> FloatArray:
    """Return the cosine of the angle between normals and the sun, negative from behind.

    Scalar product of unit vectors on the last axis, in the same frame; the other axes broadcast.
    Report, eq. 3.
    """
    normal, sun = np.asarray(normals, float), np.asarray(sun_vector, float)
    # Component by component: a sum over an axis of three takes ten times as long.
    north, east, down = (normal[..., axis] * sun[..., axis] for axis in range(3))
    return np.asarray(north + east + down)
