"""What the shadow of the tail costs: the plug-in point, and three models of losses.

What a shadow costs depends on how the cells are wired, which is the user's to say; the report
(Oettershagen, on solar power models) leaves it to plug-ins. See ``docs/shading.md``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from solar.types import FloatArray

LossModel = Callable[[FloatArray], FloatArray]
"""From the shaded fraction of each surface to the lost fraction of its direct light.

Both have the shape ``(..., surface)`` and lie between zero and one.
"""


def no_losses(shaded: FloatArray) -> FloatArray:
    """Leave the light as it is: the report's Full Model, which only shows the shaded area."""
    return np.zeros_like(shaded)


def proportional_losses(shaded: FloatArray) -> FloatArray:
    """Lose direct light in proportion to the shaded area: the least a shadow can cost.

    It would be so if every cell had its own tracker.
    """
    return shaded


def string_losses(substrings: int = 4, threshold: float = 0.005) -> LossModel:
    """Example of a loss by wiring: a series string with a bypass diode for each sub-string.

    Parameters
    ----------
    substrings : int
        Equal sub-strings of a module, each with a bypass diode.
    threshold : float
        Shaded fraction of the module up to which nothing is lost; the default is a tenth of a cell
        in a module of twenty.

    Returns
    -------
    LossModel
        Above the threshold, the share of the sub-strings that the shadow can fill, rounded up.

    Raises
    ------
    ValueError
        If there is no sub-string, or the threshold is not in ``[0, 1)``.

    Notes
    -----
    Cells in series carry the current of the weakest one, and a bypass diode takes its whole
    sub-string out. Assumptions: the shadow is in one piece and covers one sub-string after the
    other; diodes drop no voltage; the tracker finds the greatest of several maxima. A long, thin
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
    """Make the user's own loss model known by a name.

    The name holds in this process alone: others, such as the workers of a long map, must register
    the model themselves.

    Raises
    ------
    ValueError
        If the name is taken.
    """
    if name in LOSS_MODELS:
        raise ValueError(f"there is a loss model {name} already")
    LOSS_MODELS[name] = model


def loss_model(name: str) -> LossModel:
    """Loss model of that name.

    Raises
    ------
    ValueError
        If there is none.
    """
    if name not in LOSS_MODELS:
        raise ValueError(f"unknown loss model {name}; choose from {', '.join(LOSS_MODELS)}")
    return LOSS_MODELS[name]


def apply_losses(
    direct_by_surface: ArrayLike, shaded: ArrayLike, model: LossModel = no_losses
) -> FloatArray:
    """Direct light of every surface that is left after shading.

    Parameters
    ----------
    direct_by_surface : array_like, shape (..., surface)
        Direct light on the unshaded surfaces, in any unit.
    shaded : array_like, shape (..., surface)
        Shaded fractions, see :func:`shaded_fraction`.
    model : LossModel
        What a shadow costs.

    Returns
    -------
    ndarray, shape (..., surface)
        Direct light in the same unit; diffuse light is not touched by any loss model.

    Raises
    ------
    ValueError
        If the model returns another shape, or a loss that is not between zero and one.
    """
    fractions = np.asarray(shaded, float)
    lost = np.asarray(model(fractions), float)
    if lost.shape != fractions.shape:
        raise ValueError(f"loss model: shape {lost.shape} returned, {fractions.shape} needed")
    if not np.all((lost >= 0.0) & (lost <= 1.0)):
        raise ValueError("loss model: every lost fraction must be between 0 and 1")
    return np.asarray(direct_by_surface, float) * (1.0 - lost)
