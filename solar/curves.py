"""Component-efficiency curves: shipped as data files, replaceable by tables of the user."""

from __future__ import annotations

import io
from functools import cached_property
from importlib import resources
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from solar.schema import Real, Record
from solar.sun import FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator


class Curve(Record):
    """A tabulated curve ``y(x)``, interpolated monotonically and held constant outside.

    The interpolant is the piecewise cubic of Fritsch & Carlson (1980): it passes through every
    point and never over- or undershoots between two of them.
    """

    x: tuple[Real, ...] = Field(min_length=2)
    y: tuple[Real, ...] = Field(min_length=2)

    @model_validator(mode="after")
    def _check_table(self) -> Curve:
        if len(self.x) != len(self.y):
            raise ValueError(f"x has {len(self.x)} values and y has {len(self.y)}; they must match")
        if np.any(np.diff(self.x) <= 0.0):
            raise ValueError("x must increase strictly")
        return self

    @cached_property
    def _interpolant(self) -> PchipInterpolator:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(np.asarray(self.x), np.asarray(self.y))

    def __call__(self, x: ArrayLike) -> FloatArray:
        """Value of the curve at ``x``, shape of ``x``."""
        clipped = np.clip(np.asarray(x, float), self.x[0], self.x[-1])
        return np.asarray(self._interpolant(clipped))


def shipped_curve(name: str) -> Curve:
    """Read one of the curves that ship with the package, for instance ``low_light_sunpower_c60``.

    Raises
    ------
    FileNotFoundError
        If there is no curve of that name.
    """
    text = resources.files("solar").joinpath("data", f"{name}.csv").read_text(encoding="utf-8")
    table = np.loadtxt(io.StringIO(_without_header(text)), delimiter=",")
    return Curve(x=tuple(table[:, 0].tolist()), y=tuple(table[:, 1].tolist()))


def _without_header(text: str) -> str:
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    return "\n".join(lines[1:])
