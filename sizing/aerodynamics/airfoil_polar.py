"""Smooth polar of an airfoil section, fitted to a table.

The fit covers the branch of attached flow up to the stall, with drag as a smooth function of lift
coefficient and Reynolds number. It is evaluated by arithmetic alone, for floats, arrays and
symbolic expressions, and has derivatives of every order.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import e, pi
from typing import NamedTuple, TypeAlias

import numpy as np

from missions.files.errors import file_error
from missions.files.texts import read_text
from sizing.aerodynamics.polar_table import (
    POLAR_SUFFIXES,
    PolarTable,
    is_table_path,
    parse_polar,
    shipped_table,
)
from sizing.smooth import Value, chebyshev_series
from solar.schema import spell
from solar.types import FloatArray

# The branch ends where the slope of lift falls to a tenth of a thin airfoil's, 2 pi/rad [1/deg].
_LEAST_SLOPE_PER_DEG = 0.1 * 2.0 * pi * pi / 180.0
# Window of that slope [deg]: within finer steps lift scatters as much as it rises.
_WINDOW_DEG = 0.5
# Ratio of maximum lifts of neighbouring low Reynolds numbers that shows laminar separation, where
# drag does not continue the branch.
_STALLED_RATIO = 0.85
_LEAST_REYNOLDS_NUMBERS, _LEAST_ANGLES = 4, 12  # for a fit
_LIFT_DEGREE, _REYNOLDS_DEGREE, _MAXIMUM_LIFT_DEGREE = 14, 6, 4  # errors: docs/aerodynamics.md
_RIDGE = 1e-4  # regularises coefficients that the table does not determine
_REFUSED_MEDIAN, _REFUSED_MAXIMUM = 0.05, 0.3  # relative errors of a fit
# The fit ends this far below the maximum lift, as drag rises steeply there.
_STALL_DISTANCE = 0.03
# Half-widths of the smooth clamps, of lift and of the normalised Reynolds coordinate.
_LIFT_BLEND, _REYNOLDS_BLEND = 0.02, 0.02
# Excess at which drag has doubled: lift beyond the stall, lift below the branch, and Reynolds.
_STALL_SCALE, _NEGATIVE_SCALE, _REYNOLDS_SCALE = 0.1, 0.5, 1.0
_CHECKED_LIFT = 0.2  # the fit error counts from here ...
_CHECKED_DISTANCE = 0.1  # ... to this far below the maximum lift


class _Branch(NamedTuple):
    """Attached flow at one Reynolds number: lift rises with every step."""

    reynolds: float
    alpha_deg: FloatArray
    cl: FloatArray
    cd: FloatArray

    @property
    def maximum_lift(self) -> float:
        return float(np.max(self.cl))

    def refined(self) -> tuple[FloatArray, FloatArray]:
        """Return lift and log of drag between the rows, by cubic splines over the angle."""
        from scipy.interpolate import CubicSpline

        width_deg = float(self.alpha_deg[-1] - self.alpha_deg[0])
        # At most 16 points a degree: finer tables have no more information, and equal weight.
        count = min(8 * len(self.alpha_deg), round(16.0 * width_deg) + 8)
        alpha = np.linspace(self.alpha_deg[0], self.alpha_deg[-1], count)
        lift = CubicSpline(self.alpha_deg, self.cl)(alpha)
        return np.asarray(lift), np.asarray(CubicSpline(self.alpha_deg, np.log(self.cd))(alpha))


# Middle and half width of Re^-1/4 over the Reynolds numbers of a table.
_Scale: TypeAlias = tuple[float, float]


def _coordinate(scale: _Scale, reynolds: Value) -> Value:
    """Return the coordinate of a Reynolds number: from 1 at the lowest to -1 at the highest.

    It is nearly linear in log Re over the range of a table, by arithmetic alone.
    """
    return (reynolds**-0.25 - scale[0]) / scale[1]


@dataclass(frozen=True)
class AirfoilPolar:
    """Smooth drag and maximum lift of an airfoil section.

    ``log c_d`` is a tensor product of Chebyshev polynomials in the lift, scaled between the lower
    end of the branch and the stall at that Reynolds number, and in Re^-1/4. Outside the table both
    coordinates are clamped smoothly, and drag grows with the square of the excess: below the lowest
    Reynolds number, beyond the stall, and below the branch. Above the highest Reynolds number drag
    is constant. Drag is positive everywhere. Values outside the table are a penalty for optimisers,
    not physics.

    ``reynolds_range``: of the fit; rows at the low end whose maximum lift collapses (laminar
    separation without reattachment) are left out. ``least_lift``: lift coefficient at which the
    branch starts at all these Reynolds numbers. ``notes``: rows left out, and on the format.
    """

    name: str
    reynolds_range: tuple[float, float]
    least_lift: float
    _scale: _Scale
    _maximum_lift: tuple[float, ...]
    _log_drag: tuple[tuple[float, ...], ...]
    _branches: tuple[_Branch, ...]
    notes: tuple[str, ...] = ()

    @classmethod
    def load(cls, airfoil: str) -> AirfoilPolar:
        """Read a polar by the name of a shipped one, or by the path of a file or folder.

        Unknown names raise ValueError; files that are no polar table raise
        :class:`missions.files.errors.InputError`, with line numbers.
        """
        if not is_table_path(airfoil):
            return _shipped_polar(airfoil)
        return cls.from_table(parse_polar(read_text(airfoil, POLAR_SUFFIXES), airfoil))

    @classmethod
    def from_table(cls, table: PolarTable) -> AirfoilPolar:
        """Fit a table; raise InputError where it is rough or has no branch of attached flow."""
        branches = _attached_branches(table)
        least_lift = max(float(b.cl[0]) for b in branches)
        low, high = branches[0].reynolds ** -0.25, branches[-1].reynolds ** -0.25
        scale = (low + high) / 2.0, (low - high) / 2.0
        z = [_coordinate(scale, branch.reynolds) for branch in branches]
        highest = [branch.maximum_lift for branch in branches]
        degree = min(_MAXIMUM_LIFT_DEGREE, len(branches) - 2)
        peak = tuple(np.polynomial.chebyshev.chebfit(z, highest, degree).tolist())
        polar = cls(
            name=table.name,
            reynolds_range=(branches[0].reynolds, branches[-1].reynolds),
            least_lift=least_lift,
            _scale=scale,
            _maximum_lift=peak,
            _log_drag=_fit_log_drag(branches, scale, peak, least_lift),
            _branches=branches,
            notes=table.notes,
        )
        middle, highest_error = polar.fit_error
        # Refuses NaN as well.
        if not (middle <= _REFUSED_MEDIAN and highest_error <= _REFUSED_MAXIMUM):
            median, most = (spell(100.0 * missed, 3) for missed in polar.fit_error)
            raise file_error(
                table.source,
                f"too rough for a smooth polar: the fit misses the table by {median} % in the "
                f"median and {most} % at most",
            )
        return polar

    def maximum_lift(self, reynolds: Value) -> Value:
        """Return the maximum lift coefficient of the section [-]; Reynolds numbers above zero."""
        inside, below = self._reynolds_coordinates(reynolds)
        return chebyshev_series(self._maximum_lift, inside) / (1.0 + below * below)

    def profile_drag(self, cl: Value, reynolds: Value) -> Value:
        """Return the drag coefficient of the section on the branch up to the stall [-].

        It is positive for every lift coefficient, and every Reynolds number above zero.
        """
        inside, below = self._reynolds_coordinates(reynolds)
        top = chebyshev_series(self._maximum_lift, inside) - _STALL_DISTANCE
        lifted = self.least_lift + _ramp(cl - self.least_lift, _LIFT_BLEND)
        clamped = top - _ramp(top - lifted, _LIFT_BLEND)
        share = 2.0 * (clamped - self.least_lift) / (top - self.least_lift) - 1.0
        rows = [chebyshev_series(row, inside) for row in self._log_drag]
        stalled = _ramp(cl - top, _LIFT_BLEND) / _STALL_SCALE
        negative = _ramp(self.least_lift - cl, _LIFT_BLEND) / _NEGATIVE_SCALE
        fence = (1.0 + stalled * stalled) * (1.0 + negative * negative)
        return e ** chebyshev_series(rows, share) * fence * (1.0 + below * below)

    def _reynolds_coordinates(self, reynolds: Value) -> tuple[Value, Value]:
        """Return the clamped coordinate, and the excess below the lowest Reynolds number."""
        z = _coordinate(self._scale, reynolds)
        inside = -1.0 + _ramp(z + 1.0, _REYNOLDS_BLEND)
        inside = 1.0 - _ramp(1.0 - inside, _REYNOLDS_BLEND)
        return inside, _ramp(z - 1.0, _REYNOLDS_BLEND) / _REYNOLDS_SCALE

    @cached_property
    def fit_error(self) -> tuple[float, float]:
        """Median and maximum relative error of drag, from ``c_l`` 0.2 to 0.1 below the maximum."""
        errors = []
        for branch in self._branches:
            top = branch.maximum_lift - _CHECKED_DISTANCE
            used = (branch.cl >= max(_CHECKED_LIFT, self.least_lift)) & (branch.cl <= top)
            fitted = self.profile_drag(branch.cl[used], branch.reynolds)
            errors.append(np.abs(fitted / branch.cd[used] - 1.0))
        joined = np.concatenate(errors)
        return float(np.median(joined)), float(np.max(joined))


@lru_cache(maxsize=32)
def _shipped_polar(name: str) -> AirfoilPolar:
    return AirfoilPolar.from_table(shipped_table(name))


def _ramp(x: Value, width: float) -> Value:
    """Return the smooth maximum of ``x`` and 0: a hyperbola, ``width / 2`` high at 0."""
    return (x + (x * x + width * width) ** 0.5) / 2.0


def _attached_branches(table: PolarTable) -> tuple[_Branch, ...]:
    columns = table.columns
    branches = []
    for reynolds in np.unique(columns["reynolds"]):
        rows = np.flatnonzero(columns["reynolds"] == reynolds)
        rows = rows[np.argsort(columns["alpha_deg"][rows])]
        if len(rows) < _LEAST_ANGLES:
            angles = f"{len(rows)} angles of attack at Reynolds number {spell(reynolds)}"
            raise file_error(table.source, f"{angles}; at least {_LEAST_ANGLES} are needed")
        alpha, cl, cd = (columns[name][rows] for name in ("alpha_deg", "cl", "cd"))
        # The branch of rising lift around half the greatest lift.
        start = int(np.argmax(cl >= 0.5 * np.max(cl)))
        first, last = (_end_of_rise(sign * alpha, sign * cl, start, sign) for sign in (-1, 1))
        kept_rows = slice(first, last + 1)
        branches.append(_Branch(float(reynolds), alpha[kept_rows], cl[kept_rows], cd[kept_rows]))
    while len(branches) > 1 and (
        branches[0].maximum_lift < _STALLED_RATIO * branches[1].maximum_lift
    ):
        branches.pop(0)
    if len(branches) < _LEAST_REYNOLDS_NUMBERS:
        numbers = f"attached flow at {len(branches)} Reynolds numbers"
        raise file_error(table.source, f"{numbers}; at least {_LEAST_REYNOLDS_NUMBERS} are needed")
    # Branches at low Reynolds numbers that end early are not attached flow.
    for first in range(len(branches) - _LEAST_REYNOLDS_NUMBERS + 1):
        kept = branches[first:]
        if max(b.cl[0] for b in kept) <= 0.5 * min(b.maximum_lift for b in kept):
            return tuple(kept)
    raise file_error(table.source, "the branch of attached flow is too short; extend alpha_deg")


def _end_of_rise(alpha_deg: FloatArray, cl: FloatArray, row: int, step: int) -> int:
    """Return the last row from ``row`` on, in steps of ``step``, up to which lift rises."""
    while 0 <= row + step < len(cl):
        ahead = np.arange(row + step, len(cl) if step > 0 else -1, step)
        width = alpha_deg[ahead] - alpha_deg[row]
        near = (width <= _WINDOW_DEG + 1e-6) | (ahead == row + step)
        rising = ahead[near & (cl[ahead] - cl[row] > _LEAST_SLOPE_PER_DEG * width)]
        if not len(rising):
            break
        row = int(rising[0])
    return row


def _fit_log_drag(
    branches: tuple[_Branch, ...], scale: _Scale, peak: tuple[float, ...], least_lift: float
) -> tuple[tuple[float, ...], ...]:
    """Return Chebyshev coefficients of log drag, by lift (outer) and Reynolds number (inner)."""
    shares, coordinates, logs = [], [], []
    for branch in branches:
        z = _coordinate(scale, branch.reynolds)
        top = chebyshev_series(peak, z) - _STALL_DISTANCE
        lift, log_drag = branch.refined()
        used = (lift >= least_lift) & (lift <= top)
        shares.append(2.0 * (lift[used] - least_lift) / (top - least_lift) - 1.0)
        coordinates.append(np.full(np.count_nonzero(used), z))
        logs.append(log_drag[used])
    u, v, target = (np.concatenate(parts) for parts in (shares, coordinates, logs))
    degrees = (_LIFT_DEGREE, min(_REYNOLDS_DEGREE, len(branches) - 2))
    basis = np.polynomial.chebyshev.chebvander2d(u, v, degrees)
    ridge = _RIDGE * np.sqrt(len(target)) * np.eye(basis.shape[1])
    fitted, *_ = np.linalg.lstsq(
        np.vstack((basis, ridge)), np.concatenate((target, np.zeros(len(ridge)))), rcond=None
    )
    table = fitted.reshape(degrees[0] + 1, degrees[1] + 1)
    return tuple(map(tuple, table.tolist()))
