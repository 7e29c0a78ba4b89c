"""Shading of the solar modules by the tail.

All positions are in body axes (x forward, y right, z down) from the leading edge of the wing root;
aft positions are ``-x``, heights are ``-z``. The shadow is exact for flat rectangles. The power it
costs depends on the wiring of the cells, by a :data:`LossModel`, shipped or user-defined.

Source: Oettershagen's report on solar power models, section on geometric modelling (shaded area of
every module by rays along the sun vector; the loss is left to plug-ins). See ``docs/shading.md``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from pydantic import field_validator

from solar.geometry import ModuleGeometry, direction_cosines
from solar.schema import PositiveReal, Real, Record
from solar.shadows import covered_area, module_frame
from solar.types import FloatArray


class TailGeometry(Record):
    """Horizontal and vertical tail as flat rectangles, parallel to the body's planes.

    Attributes
    ----------
    horizontal_span_m, horizontal_chord_m : float
        Extent of the horizontal tail along y (symmetric to the fuselage) and x [m].
    horizontal_aft_m : float
        Its leading edge behind the leading edge of the wing root [m].
    vertical_height_m : float
        Height of the vertical tail from the boom upwards [m]; negative where it hangs down.
    vertical_chord_m, vertical_aft_m : float
        Its chord, and its leading edge behind the leading edge of the wing root [m].
    boom_height_m : float
        Height of the boom, the root of the vertical tail, above the leading edge of the wing
        root [m].
    horizontal_height_m : float, optional
        Height of the horizontal tail above the leading edge of the wing root, where it is not the
        free end of the vertical tail (T-tail, the default) [m].

    Notes
    -----
    The report shades with the two tail planes only; the boom, the fuselage, the propeller and the
    outer wing cast no shadow.
    """

    horizontal_span_m: PositiveReal
    horizontal_chord_m: PositiveReal
    horizontal_aft_m: Real
    vertical_height_m: Real
    vertical_chord_m: PositiveReal
    vertical_aft_m: Real
    boom_height_m: Real = 0.0
    horizontal_height_m: Real | None = None

    @field_validator("vertical_height_m")
    @classmethod
    def _check_height(cls, height_m: float) -> float:
        if height_m == 0.0:
            raise ValueError("vertical_height_m must not be zero")
        return height_m

    @property
    def height_m(self) -> float:
        """Height of the horizontal tail above the leading edge of the wing root [m]."""
        if self.horizontal_height_m is not None:
            return self.horizontal_height_m
        return self.boom_height_m + self.vertical_height_m

    @property
    def is_t_tail(self) -> bool:
        """True for a horizontal tail on the upper half of the vertical tail."""
        above_boom = (self.height_m - self.boom_height_m) / self.vertical_height_m
        return self.vertical_height_m > 0.0 and above_boom > 0.5

    def panels(self) -> tuple[FloatArray, FloatArray]:
        """Return the corners of horizontal and vertical tail in body axes, each ``(4, 3)``."""
        front, side, z = -self.horizontal_aft_m, 0.5 * self.horizontal_span_m, -self.height_m
        rear = front - self.horizontal_chord_m
        horizontal = [(front, -side, z), (front, side, z), (rear, side, z), (rear, -side, z)]
        front, root = -self.vertical_aft_m, -self.boom_height_m
        rear, end = front - self.vertical_chord_m, root - self.vertical_height_m
        vertical = [(front, 0.0, root), (front, 0.0, end), (rear, 0.0, end), (rear, 0.0, root)]
        return np.array(horizontal), np.array(vertical)


def shaded_fraction(
    geometry: ModuleGeometry, tail: TailGeometry | None, sun_vector_body: ArrayLike
) -> FloatArray:
    """Return the shaded part of every module's outline, between zero and one.

    Parameters
    ----------
    geometry : ModuleGeometry
        Module surfaces; all need an outline, unless there is no tail.
    tail : TailGeometry or None
        Tail that casts the shadow; nothing is shaded without it.
    sun_vector_body : array_like, shape (..., 3)
        Unit vectors to the sun in body axes.

    Returns
    -------
    ndarray, shape (..., surface)
        Union of the shadows of both tail planes over the area of the outline. Zero where the sun
        is behind a module or within 0.06 degrees of its plane: no direct light is there to lose.

    Raises
    ------
    ValueError
        If a surface has no outline, or the vectors do not have three components.
    """
    sun = np.asarray(sun_vector_body, float)
    if sun.ndim == 0 or sun.shape[-1] != 3:
        raise ValueError(f"sun vectors need three components on the last axis, not {sun.shape}")
    fractions = np.zeros((sun.size // 3, len(geometry.surfaces)))
    if tail is not None:
        for index, surface in enumerate(geometry.surfaces):
            frame = module_frame(surface, geometry)
            covered = covered_area(frame, frame.panels_above(tail.panels()), sun.reshape(-1, 3))
            fractions[:, index] = np.clip(covered / frame.area_m2, 0.0, 1.0)
    return fractions.reshape((*sun.shape[:-1], len(geometry.surfaces)))


def shaded_area(
    geometry: ModuleGeometry, tail: TailGeometry | None, sun_vector_body: ArrayLike
) -> FloatArray:
    """Return the shaded area of every module [m2], shape ``(..., surface)``.

    The shaded fraction of the outline times the module's area, which is smaller than the outline's
    by gaps and by the cut corners of the cells. Arguments and errors as of :func:`shaded_fraction`.
    """
    areas = np.array([surface.area_m2 for surface in geometry.surfaces])
    return np.asarray(shaded_fraction(geometry, tail, sun_vector_body) * areas)


def elevation_free_of_shading_deg(
    geometry: ModuleGeometry, tail: TailGeometry | None, roll: float = 0.0, pitch: float = 0.0
) -> float:
    """Return the least sun elevation [deg] above which no module is shaded, at any azimuth.

    Zero if nothing is shaded by a sun above the horizon. ``roll``, ``pitch``: attitude of the
    aircraft [rad]; its heading does not matter. Other arguments as of :func:`shaded_fraction`.

    The directions from any point of a module to any point of a panel form a convex cone, spanned
    by the directions from corner to corner. Its steepest direction is the projection of the
    vertical on the cone, a problem of non-negative least squares (Lawson & Hanson 1974, chapter
    23); the length of the projection is the sine of the elevation.
    """
    if tail is None:
        return 0.0
    from scipy.optimize import nnls

    up, sine = -direction_cosines(roll, pitch, 0.0)[2], 0.0
    for surface in geometry.surfaces:
        frame = module_frame(surface, geometry)
        for panel in frame.panels_above(tail.panels()):
            rays = (panel @ frame.axes + frame.middle)[:, np.newaxis] - frame.corners()
            rays = rays.reshape(-1, 3)
            sine = max(sine, float(np.linalg.norm(nnls(rays.T, up)[0] @ rays)))
    return float(np.degrees(np.arcsin(min(sine, 1.0))))


LossModel = Callable[[FloatArray], FloatArray]
"""Function of each surface's shaded fraction that returns the lost fraction of its direct light.

Both have the shape ``(..., surface)`` and lie between zero and one.
"""


def no_losses(shaded: FloatArray) -> FloatArray:
    """Leave the light as it is: the report's Full Model, which only shows the shaded area."""
    return np.zeros_like(shaded)


def proportional_losses(shaded: FloatArray) -> FloatArray:
    """Lose direct light in proportion to the shaded area: the least a shadow can cost.

    It would be so if every cell had its own MPPT.
    """
    return shaded


def string_losses(substrings: int = 4, threshold: float = 0.005) -> LossModel:
    """Return a loss by wiring: a series string of equal sub-strings, each with a bypass diode.

    Above the threshold, a shaded fraction of the module (by default a tenth of a cell in a module
    of twenty), the share of the sub-strings is lost that the shadow can fill, rounded up.

    Cells in series carry the current of the weakest one, and a bypass diode takes its whole
    sub-string out. Assumptions: the shadow is in one piece and covers one sub-string after the
    other; diodes drop no voltage; the MPPT finds the greatest of several maxima. A long, thin
    shadow that grazes many cells costs more than this.
    """
    if substrings < 1:
        raise ValueError(f"a module has at least one sub-string, not {substrings}")
    if not 0.0 <= threshold < 1.0:
        raise ValueError(f"the threshold must be at least 0 and below 1, not {threshold}")

    def losses(shaded: FloatArray) -> FloatArray:
        # The small number keeps rounding from bypassing one sub-string too many.
        bypassed = np.ceil(substrings * np.asarray(shaded) - 1e-9) / substrings
        return np.where(shaded > threshold, np.maximum(bypassed, 0.0), 0.0)

    return losses


LOSS_MODELS: dict[str, LossModel] = {
    "none": no_losses,
    "proportional": proportional_losses,
    "string": string_losses(),
}


def register_loss_model(name: str, model: LossModel) -> None:
    """Register a user-defined loss model by a name.

    The name holds in this process alone: others, such as the workers of a long map, must register
    the model themselves.

    Parameters
    ----------
    name : str
        A name that is not taken.
    model : LossModel
        From shaded to lost fractions of the direct light.

    Raises
    ------
    ValueError
        If the name is taken.
    """
    if name in LOSS_MODELS:
        raise ValueError(f"there is a loss model {name} already")
    LOSS_MODELS[name] = model


def loss_model(name: str) -> LossModel:
    """Return the loss model of a name; ValueError if there is none."""
    if name not in LOSS_MODELS:
        raise ValueError(f"unknown loss model {name}; choose from {', '.join(LOSS_MODELS)}")
    return LOSS_MODELS[name]


def apply_losses(
    direct_by_surface: ArrayLike, shaded: ArrayLike, model: LossModel = no_losses
) -> FloatArray:
    """Return the direct light of every surface after shading, in the unit of ``direct_by_surface``.

    Light and ``shaded`` fractions have the shape ``(..., surface)``. ValueError if the model
    returns another shape, or a loss outside of 0 to 1. No loss model changes diffuse light.
    """
    fractions = np.asarray(shaded, float)
    lost = np.asarray(model(fractions), float)
    if lost.shape != fractions.shape:
        raise ValueError(f"loss model: shape {lost.shape} returned, {fractions.shape} needed")
    if not np.all((lost >= 0.0) & (lost <= 1.0)):
        raise ValueError("loss model: every lost fraction must be between 0 and 1")
    return np.asarray(direct_by_surface, float) * (1.0 - lost)


@dataclass(frozen=True)
class Shading:
    """Tail that shades the modules, and the loss by its shadows."""

    tail: TailGeometry
    model: LossModel = no_losses
