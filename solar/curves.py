"""Component-efficiency curves: shipped as data files, replaceable by tables of the user."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from solar.schema import Real, Record
from solar.types import FloatArray, IntArray

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
    def _pieces(self) -> _Pieces:
        from scipy.interpolate import PchipInterpolator

        return _Pieces.of(PchipInterpolator(np.asarray(self.x), np.asarray(self.y)))

    def __call__(self, x: ArrayLike) -> FloatArray:
        """Value of the curve at ``x``, shape of ``x``."""
        return self._pieces.at(np.minimum(np.maximum(x, self.x[0]), self.x[-1]))


# Beyond so many bins a piece is searched for instead of looked up.
_MOST_BINS = 4096


@dataclass(frozen=True)
class _Pieces:
    """Cubic pieces, evaluated several times faster than by SciPy's general class.

    The axis is divided into equal bins, of which none holds more than one end of a piece: the bin
    of a value and one comparison tell its piece.
    """

    begin: FloatArray
    end: FloatArray
    cubic: FloatArray
    bins_per_x: float
    piece_of_bin: IntArray | None

    @classmethod
    def of(cls, interpolant: PchipInterpolator) -> _Pieces:
        begin, end = interpolant.x[:-1], np.append(interpolant.x[1:-1], np.inf)
        span = interpolant.x[-1] - interpolant.x[0]
        bins = 2.0 * np.ceil(span / np.diff(interpolant.x).min())
        scale = float(bins / span)
        piece_of_bin = None
        if bins <= _MOST_BINS:
            bin_of_end = ((end[:-1] - begin[0]) * scale).astype(np.intp)
            piece_of_bin = np.searchsorted(bin_of_end, np.arange(int(bins) + 1), side="left")
        return cls(begin, end, np.asarray(interpolant.c), scale, piece_of_bin)

    def at(self, x: FloatArray) -> FloatArray:
        """Value at points within the axis."""
        if self.piece_of_bin is None:
            piece = np.searchsorted(self.end, x, side="right")
        else:
            place = ((x - self.begin[0]) * self.bins_per_x).astype(np.intp)
            piece = self.piece_of_bin.take(place, mode="clip")
            piece = piece + (x >= self.end.take(piece))
        along = x - self.begin.take(piece)
        value = self.cubic[0].take(piece)
        for coefficient in self.cubic[1:]:
            value = value * along + coefficient.take(piece)
        return np.asarray(value)


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
