"""Shadows of flat panels on flat rectangles, by rays along the sun vector: geometry alone.

Positions are in body axes, or in a module's axes: right, aft, and height over its plane.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from solar.geometry import ModuleGeometry, ModuleSurface, direction_cosines
from solar.types import FloatArray, IntArray

# A sun closer than 0.06 degrees to the plane of a module gives it less than 1 W/m2 of direct light;
# the shadows would be hundreds of metres long, and their corners inexact.
_GRAZING_COSINE = 1e-3

# Panels and shadows below this are lines: the panel is seen edge on.
_NO_AREA_M2 = 1e-9


@dataclass(frozen=True)
class ModuleFrame:
    """Axes of a module (right, aft, normal; the rows of ``axes``), its middle and half size."""

    axes: FloatArray
    middle: FloatArray
    half_span_m: float
    half_chord_m: float

    @property
    def area_m2(self) -> float:
        """Area of the outline [m2]."""
        return 4.0 * self.half_span_m * self.half_chord_m

    def corners(self) -> FloatArray:
        """Return front left, front right, rear right, rear left corner, in body axes [m]."""
        signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
        return np.asarray(
            self.middle + (signs * (self.half_span_m, self.half_chord_m)) @ self.axes[:2]
        )

    def panels_above(self, panels: Iterable[FloatArray]) -> list[FloatArray]:
        """Return the parts of panels above the module's plane, in its axes."""
        local = ((panel - self.middle) @ self.axes.T for panel in panels)
        parts = (_clipped(panel[np.newaxis], panel[np.newaxis, :, 2])[0] for panel in local)
        return [part for part in parts if np.linalg.norm(_vector_area(part)) > _NO_AREA_M2]


def module_frame(surface: ModuleSurface, geometry: ModuleGeometry) -> ModuleFrame:
    """Place a module in space, from the leading edge of the wing root.

    The chord line is turned by the wing's incidence about the root's leading edge. The dihedral
    begins at the outer edge of the central modules (at the symmetry plane if there are none), and
    span is counted along the bent wing, so that outlines keep their size. The middle of a module
    lies on the chord line, and the module's pitch turns it about its middle: the thickness of the
    wing, a centimetre or two, is left out. The surface needs an outline.
    """
    outline = surface.outline
    if outline is None:
        raise ValueError(f"module surface {surface.name} needs an outline for its shading")
    side = {"left": -1.0, "centre": 0.0, "right": 1.0}[surface.side]
    dihedral = np.radians(surface.dihedral_deg)
    # The wing's kink is the outer edge of the central modules.
    central = [s.outline for s in geometry.surfaces if s.side == "centre"]
    hinge = max((outline.outboard_m for outline in central if outline is not None), default=0.0)
    incidence = np.radians(geometry.wing_incidence_deg)
    module_to_body = geometry.rotations()[geometry.surfaces.index(surface)]
    # The middle in the wing's axes: body axes turned by the incidence.
    along, aft = outline.inboard_m + outline.outboard_m, outline.front_m + outline.rear_m
    middle = np.array((-0.5 * aft, 0.5 * along, 0.0))
    if side:
        bent = 0.5 * along - hinge
        middle[1:] = side * (hinge + bent * np.cos(dihedral)), -bent * np.sin(dihedral)
    return ModuleFrame(
        axes=np.stack((module_to_body[:, 1], -module_to_body[:, 0], -module_to_body[:, 2])),
        middle=direction_cosines(0.0, incidence, 0.0) @ middle,
        half_span_m=0.5 * (outline.outboard_m - outline.inboard_m),
        half_chord_m=0.5 * (outline.rear_m - outline.front_m),
    )


def covered_area(frame: ModuleFrame, panels: Sequence[FloatArray], sun: FloatArray) -> FloatArray:
    """Return the area of a module in the shadows of at most two panels [m2], shape ``(sun,)``."""
    covered = np.zeros(len(sun))
    local = sun @ frame.axes.T
    above = np.flatnonzero(local[:, 2] > _GRAZING_COSINE)
    half = np.array((frame.half_span_m, frame.half_chord_m))
    shadows = [_shadow_corners(panel, local[above], half) for panel in panels]
    parts = []
    for corners, reached in shadows:
        part = corners
        for axis in (0, 1):
            part = _clipped(part, half[axis] - part[..., axis])
            part = _clipped(part, half[axis] + part[..., axis])
        parts.append(part)
        covered[above[reached]] += np.abs(_areas(part))
    if len(panels) == 2:
        (_, reached), (other, also_reached) = shadows
        both, first, second = np.intersect1d(reached, also_reached, return_indices=True)
        # What both cover counts once: the first shadow, cut along the edges of the other.
        common, other = parts[0][first], other[second]
        turn = np.sign(_areas(other))[:, np.newaxis]
        for corner in range(other.shape[1]):
            start = other[:, corner - 1, np.newaxis]
            edge = other[:, corner, np.newaxis] - start
            common = _clipped(common, turn * _cross(edge, common - start))
        covered[above[both]] -= np.abs(_areas(common))
    return covered


def _shadow_corners(
    panel: FloatArray, sun: FloatArray, half: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return shadows that may reach a module around the origin, and indices of their suns.

    All in the axes of the module, the sun above its plane. A corner at the height ``w`` falls at
    ``(u, v) - w (a, b) / c`` for the sun ``(a, b, c)``. Shadows are dropped if their bounding box
    misses the module, and if the sun sees the panel edge on.
    """
    slopes = sun[:, :2] / sun[:, 2:]
    area = np.abs(sun @ _vector_area(panel)) / sun[:, 2]
    reached = area > _NO_AREA_M2
    for axis in (0, 1):
        falls = panel[:, axis, np.newaxis] - slopes[:, axis] * panel[:, 2, np.newaxis]
        reached &= (falls.min(axis=0) < half[axis]) & (falls.max(axis=0) > -half[axis])
    kept = np.flatnonzero(reached)
    corners = panel[:, :2] - slopes[kept, np.newaxis, :] * panel[:, 2:]
    return corners, kept


def _clipped(polygons: FloatArray, heights: FloatArray) -> FloatArray:
    """Clip convex polygons to corners with non-negative heights (Sutherland & Hodgman).

    Of the shapes ``(polygon, corner, axis)`` and ``(polygon, corner)``. A polygon with fewer
    corners than others repeats its last one; nothing is left of a polygon that is one point.
    """
    following = np.roll(heights, -1, axis=1)
    crossing = heights * following < 0.0
    share = np.divide(heights, heights - following, out=np.zeros_like(heights), where=crossing)
    shape = (len(polygons), 2 * polygons.shape[1], polygons.shape[2])
    cuts = polygons + (np.roll(polygons, -1, axis=1) - polygons) * share[..., np.newaxis]
    corners = np.stack((polygons, cuts), axis=2).reshape(shape)
    kept = np.stack((heights >= 0.0, crossing), axis=2).reshape(corners.shape[:2])
    count = kept.sum(axis=1, keepdims=True)
    place = np.minimum(np.arange(count.max(initial=0)), count - 1)
    order = np.take_along_axis(np.argsort(~kept, axis=1, kind="stable"), place, axis=1)
    return np.take_along_axis(corners, order[..., np.newaxis], axis=1)


def _areas(polygons: FloatArray) -> FloatArray:
    """Return areas of plane polygons, shape ``(polygon, corner, 2)``, negative if clockwise."""
    arms = polygons - polygons[:, :1]
    return np.asarray(0.5 * _cross(arms[:, :-1], arms[:, 1:]).sum(axis=1))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _vector_area(polygon: FloatArray) -> FloatArray:
    """Return a flat polygon's area times its unit normal, zero below three corners."""
    if len(polygon) < 3:
        return np.zeros(3)
    arms = polygon[1:] - polygon[0]
    return np.asarray(0.5 * np.cross(arms[:-1], arms[1:]).sum(axis=0))
