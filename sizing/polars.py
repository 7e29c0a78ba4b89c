"""Airfoil polars from table files, and the drag of an aircraft whose wing has such a section.

A polar is a CSV table, whoever made it: a program, a wind tunnel, a paper. From the table the
linear branch up to the stall is taken, and drag is fitted once as a smooth function of lift
coefficient and Reynolds number. The fit is evaluated by arithmetic only, so that floats, arrays and
symbolic expressions pass alike, and it has derivatives of every order everywhere.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib import resources
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from pydantic import Field, Strict, model_validator

from missions.air import GRAVITY_M_PER_S2
from missions.problems import InputError, Problem, file_error
from sizing.structure import Value
from solar.schema import Fraction, NonNegativeReal, PositiveReal, Record, Text
from solar.sun import FloatArray

COLUMNS = ("alpha_deg", "reynolds", "cl", "cd", "cm", "confidence")

_PI = 3.141592653589793
_E = 2.718281828459045

# The branch ends where the slope of lift falls to a tenth of a thin airfoil's, 2 pi/rad [1/deg].
_LEAST_SLOPE_PER_DEG = 0.1 * 2.0 * _PI * _PI / 180.0
# A Reynolds number at the low end whose maximum lift lies this far below the next one's has stalled
# by laminar separation; drag there is no continuation of the branch.
_STALLED_RATIO = 0.85
_LEAST_REYNOLDS_NUMBERS, _LEAST_ANGLES = 4, 12
_LIFT_DEGREE, _REYNOLDS_DEGREE, _MAXIMUM_LIFT_DEGREE = 14, 6, 4
_RIDGE = 1e-4  # keeps coefficients small that the table does not determine
_REFUSED_MEDIAN, _REFUSED_MAXIMUM = 0.05, 0.3
# The fit ends this far below the maximum lift, where drag turns upwards ever more steeply.
_STALL_DISTANCE = 0.03
# Half-widths of the smooth clamps, of lift and of the normalised Reynolds coordinate.
_LIFT_BLEND, _REYNOLDS_BLEND = 0.02, 0.02
# Excess at which drag has doubled: lift beyond the stall, lift below the branch, and Reynolds.
_STALL_SCALE, _NEGATIVE_SCALE, _REYNOLDS_SCALE = 0.1, 0.5, 1.0
_CHECKED_LIFT = 0.2  # the fit error counts from here ...
_CHECKED_DISTANCE = 0.1  # ... to this far below the maximum lift


@dataclass(frozen=True)
class PolarTable:
    """Rows of a polar file, with what its header says (keys of :attr:`header` in lower case)."""

    source: str
    header: dict[str, str]
    columns: dict[str, FloatArray]

    @property
    def name(self) -> str:
        """Airfoil as the header names it."""
        return self.header["airfoil"]


class FitError(NamedTuple):
    """Relative error of the fitted drag against the table, over the branch that aircraft use."""

    median: float
    maximum: float


class _Branch(NamedTuple):
    """Attached flow at one Reynolds number: lift rises with every step."""

    reynolds: float
    alpha_deg: FloatArray
    cl: FloatArray
    cd: FloatArray

    @property
    def maximum_lift(self) -> float:
        return float(self.cl[-1])

    def refined(self) -> tuple[FloatArray, FloatArray]:
        """Lift and logarithm of drag between the rows, by cubic splines over the angle."""
        from scipy.interpolate import CubicSpline

        alpha = np.linspace(self.alpha_deg[0], self.alpha_deg[-1], 8 * len(self.alpha_deg))
        lift = CubicSpline(self.alpha_deg, self.cl)(alpha)
        return np.asarray(lift), np.asarray(CubicSpline(self.alpha_deg, np.log(self.cd))(alpha))


class _ReynoldsScale(NamedTuple):
    """Coordinate of the Reynolds number: Re^-1/4, from 1 at the lowest to -1 at the highest.

    Over the range of a table it is nearly linear in log Re, and it takes arithmetic only.
    """

    middle: float
    half: float

    @classmethod
    def between(cls, lowest: float, highest: float) -> _ReynoldsScale:
        low, high = lowest**-0.25, highest**-0.25
        return cls((low + high) / 2.0, (low - high) / 2.0)

    def at(self, reynolds: Value) -> Value:
        return (reynolds**-0.25 - self.middle) / self.half


@dataclass(frozen=True)
class AirfoilPolar:
    """Smooth drag and maximum lift of an airfoil section.

    ``log c_d`` is a tensor product of Chebyshev polynomials in the lift, scaled between the lower
    end of the branch and the stall at that Reynolds number, and in Re^-1/4. Outside the table both
    coordinates are clamped, smoothly, and drag grows with the square of the excess: below the
    lowest Reynolds number, beyond the stall, and below the branch. Above the highest Reynolds
    number drag keeps its last value. Drag is never zero and never negative. What lies outside the
    table is a fence for optimisers, not physics.

    Attributes
    ----------
    name : str
        Airfoil as the table names it.
    reynolds_range : tuple of float
        Lowest and highest Reynolds number of the fit. Rows at the low end whose maximum lift
        collapses (laminar separation without reattachment) are left out.
    least_lift : float
        Lift coefficient at which the branch starts at all these Reynolds numbers.
    """

    name: str
    reynolds_range: tuple[float, float]
    least_lift: float
    _scale: _ReynoldsScale
    _maximum_lift: tuple[float, ...]
    _log_drag: tuple[tuple[float, ...], ...]
    _branches: tuple[_Branch, ...]

    @classmethod
    def load(cls, airfoil: str) -> AirfoilPolar:
        """Read a polar: the name of a shipped one, or the path of a CSV file.

        Raises
        ------
        ValueError
            If no shipped polar has that name, or the file is no polar table
            (:class:`missions.problems.InputError`, with line numbers).
        OSError
            If the file cannot be read.
        """
        if airfoil.endswith(".csv"):
            text = Path(airfoil).read_text(encoding="utf-8")
            return cls.from_table(parse_polar_table(text, airfoil))
        return _shipped_polar(airfoil)

    @classmethod
    def from_table(cls, table: PolarTable) -> AirfoilPolar:
        """Fit a table.

        Raises
        ------
        InputError
            If the table has no branch of attached flow at enough Reynolds numbers, or is too rough
            for a smooth fit.
        """
        branches = _attached_branches(table)
        least_lift = max(float(b.cl[0]) for b in branches)
        scale = _ReynoldsScale.between(branches[0].reynolds, branches[-1].reynolds)
        peak = _fit_maximum_lift(branches, scale)
        polar = cls(
            name=table.name,
            reynolds_range=(branches[0].reynolds, branches[-1].reynolds),
            least_lift=least_lift,
            _scale=scale,
            _maximum_lift=peak,
            _log_drag=_fit_log_drag(branches, scale, peak, least_lift),
            _branches=branches,
        )
        error = polar.fit_error
        if error.median > _REFUSED_MEDIAN or error.maximum > _REFUSED_MAXIMUM:
            raise file_error(
                table.source,
                f"too rough for a smooth polar: the fit misses the table by {error.median:.1%} in "
                f"the median and {error.maximum:.1%} at most",
            )
        return polar

    def maximum_lift(self, reynolds: Value) -> Value:
        """Maximum lift coefficient of the section [-], for Reynolds numbers above zero."""
        inside, below = self._reynolds_coordinates(reynolds)
        return _chebyshev(self._maximum_lift, inside) / (1.0 + below * below)

    def profile_drag(self, cl: Value, reynolds: Value) -> Value:
        """Drag coefficient of the section [-] on the branch up to the stall.

        Parameters
        ----------
        cl
            Lift coefficient of the section [-].
        reynolds
            Reynolds number of the chord [-], above zero.
        """
        inside, below = self._reynolds_coordinates(reynolds)
        top = _chebyshev(self._maximum_lift, inside) - _STALL_DISTANCE
        lifted = self.least_lift + _ramp(cl - self.least_lift, _LIFT_BLEND)
        clamped = top - _ramp(top - lifted, _LIFT_BLEND)
        share = 2.0 * (clamped - self.least_lift) / (top - self.least_lift) - 1.0
        rows = [_chebyshev(row, inside) for row in self._log_drag]
        stalled = _ramp(cl - top, _LIFT_BLEND) / _STALL_SCALE
        negative = _ramp(self.least_lift - cl, _LIFT_BLEND) / _NEGATIVE_SCALE
        fence = (1.0 + stalled * stalled) * (1.0 + negative * negative)
        return _E ** _chebyshev(rows, share) * fence * (1.0 + below * below)

    def _reynolds_coordinates(self, reynolds: Value) -> tuple[Value, Value]:
        """Coordinate clamped to the table, and the excess below the lowest Reynolds number."""
        z = self._scale.at(reynolds)
        inside = -1.0 + _ramp(z + 1.0, _REYNOLDS_BLEND)
        inside = 1.0 - _ramp(1.0 - inside, _REYNOLDS_BLEND)
        return inside, _ramp(z - 1.0, _REYNOLDS_BLEND) / _REYNOLDS_SCALE

    @cached_property
    def fit_error(self) -> FitError:
        """Error against the rows of the table from ``c_l`` 0.2 to 0.1 below the maximum."""
        errors = []
        for branch in self._branches:
            top = branch.maximum_lift - _CHECKED_DISTANCE
            used = (branch.cl >= max(_CHECKED_LIFT, self.least_lift)) & (branch.cl <= top)
            fitted = self.profile_drag(branch.cl[used], branch.reynolds)
            errors.append(np.abs(fitted / branch.cd[used] - 1.0))
        joined = np.concatenate(errors)
        return FitError(float(np.median(joined)), float(np.max(joined)))


def _ramp(x: Value, width: float) -> Value:
    """Smooth maximum of ``x`` and 0: a hyperbola, ``width / 2`` high at 0."""
    return (x + (x * x + width * width) ** 0.5) / 2.0


def _chebyshev(coefficients: Iterable[Value], x: Value) -> Value:
    """Chebyshev series by Clenshaw's recurrence; coefficients may be expressions themselves."""
    first, *others = coefficients
    one: Value = 0.0
    two: Value = 0.0
    for coefficient in reversed(others):
        one, two = coefficient + 2.0 * x * one - two, one
    return first + x * one - two


# ---- From a table to the fit


def _attached_branches(table: PolarTable) -> tuple[_Branch, ...]:
    columns = table.columns
    branches = []
    for reynolds in np.unique(columns["reynolds"]):
        rows = np.flatnonzero(columns["reynolds"] == reynolds)
        rows = rows[np.argsort(columns["alpha_deg"][rows])]
        if len(rows) < _LEAST_ANGLES:
            raise file_error(
                table.source,
                f"{len(rows)} angles of attack at Reynolds number {reynolds:g}; "
                f"at least {_LEAST_ANGLES} are needed",
            )
        alpha, cl, cd = (columns[name][rows] for name in ("alpha_deg", "cl", "cd"))
        branches.append(_attached_branch(float(reynolds), alpha, cl, cd))
    while len(branches) > 1 and (
        branches[0].maximum_lift < _STALLED_RATIO * branches[1].maximum_lift
    ):
        branches.pop(0)
    if len(branches) < _LEAST_REYNOLDS_NUMBERS:
        raise file_error(
            table.source,
            f"attached flow at {len(branches)} Reynolds numbers; "
            f"at least {_LEAST_REYNOLDS_NUMBERS} are needed",
        )
    if max(b.cl[0] for b in branches) > 0.5 * min(b.maximum_lift for b in branches):
        raise file_error(table.source, "the branch of attached flow is too short; extend alpha_deg")
    return tuple(branches)


def _attached_branch(
    reynolds: float, alpha_deg: FloatArray, cl: FloatArray, cd: FloatArray
) -> _Branch:
    """Rows around half the greatest lift between which lift keeps rising."""
    rising = np.diff(cl) > _LEAST_SLOPE_PER_DEG * np.diff(alpha_deg)
    first = last = int(np.argmax(cl >= 0.5 * np.max(cl)))
    while last < len(rising) and rising[last]:
        last += 1
    while first > 0 and rising[first - 1]:
        first -= 1
    rows = slice(first, last + 1)
    return _Branch(reynolds, alpha_deg[rows], cl[rows], cd[rows])


def _fit_maximum_lift(branches: tuple[_Branch, ...], scale: _ReynoldsScale) -> tuple[float, ...]:
    z = [scale.at(b.reynolds) for b in branches]
    degree = min(_MAXIMUM_LIFT_DEGREE, len(branches) - 2)
    fitted = chebyshev.chebfit(z, [b.maximum_lift for b in branches], degree)
    return tuple(float(value) for value in fitted)


def _fit_log_drag(
    branches: tuple[_Branch, ...],
    scale: _ReynoldsScale,
    peak: tuple[float, ...],
    least_lift: float,
) -> tuple[tuple[float, ...], ...]:
    """Chebyshev coefficients of log drag, by lift (outer) and Reynolds number (inner)."""
    shares, coordinates, logs = [], [], []
    for branch in branches:
        z = scale.at(branch.reynolds)
        top = _chebyshev(peak, z) - _STALL_DISTANCE
        lift, log_drag = branch.refined()
        used = (lift >= least_lift) & (lift <= top)
        shares.append(2.0 * (lift[used] - least_lift) / (top - least_lift) - 1.0)
        coordinates.append(np.full(np.count_nonzero(used), z))
        logs.append(log_drag[used])
    u, v, target = (np.concatenate(parts) for parts in (shares, coordinates, logs))
    degrees = (_LIFT_DEGREE, min(_REYNOLDS_DEGREE, len(branches) - 2))
    basis = chebyshev.chebvander2d(u, v, degrees)
    ridge = _RIDGE * np.sqrt(len(target)) * np.eye(basis.shape[1])
    fitted, *_ = np.linalg.lstsq(
        np.vstack((basis, ridge)), np.concatenate((target, np.zeros(len(ridge)))), rcond=None
    )
    table = fitted.reshape(degrees[0] + 1, degrees[1] + 1)
    return tuple(tuple(float(value) for value in row) for row in table)


# ---- Reading tables


def shipped_airfoils() -> tuple[str, ...]:
    """Names of the polars that ship with the package."""
    folder = resources.files("sizing").joinpath("data", "polars")
    names = (item.name for item in folder.iterdir())
    return tuple(sorted(name.removesuffix(".csv") for name in names if name.endswith(".csv")))


def shipped_table(name: str) -> PolarTable:
    """Read one of the tables that ship with the package.

    Raises
    ------
    ValueError
        If there is none of that name; the message lists the names.
    """
    if name not in shipped_airfoils():
        known = ", ".join(shipped_airfoils())
        raise ValueError(
            f"unknown airfoil {name!r}; shipped are {known}, and a path ending in .csv is read"
        )
    file = resources.files("sizing").joinpath("data", "polars", f"{name}.csv")
    return parse_polar_table(file.read_text(encoding="utf-8"), f"{name}.csv")


@lru_cache(maxsize=32)
def _shipped_polar(name: str) -> AirfoilPolar:
    return AirfoilPolar.from_table(shipped_table(name))


def parse_polar_table(text: str, source: str) -> PolarTable:
    """Read the text of a polar table.

    The header is comment lines ``# key: value``, of which ``airfoil`` and ``source`` are required;
    then come the line of column names and the rows, in any order.

    Parameters
    ----------
    text : str
        Contents of the file.
    source : str
        File name, for messages.

    Raises
    ------
    InputError
        With every line that is wrong.
    """
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1)]
    comments = [(number, line) for number, line in lines if line.startswith("#")]
    content = [(number, line) for number, line in lines if line and not line.startswith("#")]
    header = dict(_header_entries(comments))
    problems = [
        Problem(source, None, None, "", f"the header has no line '# {key}: ...'")
        for key in ("airfoil", "source")
        if not header.get(key)
    ]
    expected = ",".join(COLUMNS)
    if not content or content[0][1].replace(" ", "") != expected:
        line = content[0][0] if content else None
        problems.append(Problem(source, line, None, "", f"column names must be {expected}"))
        raise InputError(problems)
    rows, mistakes = _read_rows(content[1:], source)
    if problems or mistakes:
        raise InputError([*problems, *mistakes])
    if not rows:
        raise file_error(source, "the table has no rows")
    values = np.asarray(rows)
    return PolarTable(source, header, {name: values[:, i] for i, name in enumerate(COLUMNS)})


def _header_entries(comments: list[tuple[int, str]]) -> Iterable[tuple[str, str]]:
    for _, line in comments:
        key, colon, value = line.lstrip("# ").partition(":")
        if colon:
            yield key.strip().lower(), value.strip()


def _read_rows(
    content: list[tuple[int, str]], source: str
) -> tuple[list[list[float]], list[Problem]]:
    rows: list[list[float]] = []
    problems: list[Problem] = []
    seen: dict[tuple[float, float], int] = {}
    for number, line in content:
        row = line.split(",")
        try:
            values = [float(field) for field in row]
        except ValueError:
            values = []
        complaint = _complaint(values, line)
        if not complaint:
            earlier = seen.setdefault((values[0], values[1]), number)
            if earlier != number:
                complaint = f"same alpha_deg and reynolds as in line {earlier}"
        if complaint:
            problems.append(Problem(source, number, None, "", complaint))
        else:
            rows.append(values)
    return rows, problems


def _complaint(values: list[float], line: str) -> str:
    if len(values) != len(COLUMNS) or not np.all(np.isfinite(values)):
        return f"{len(COLUMNS)} finite numbers are needed (got {line[:60]!r})"
    _, reynolds, _, cd, _, confidence = values
    if reynolds <= 0.0:
        return f"reynolds must be above 0 (got {reynolds:g})"
    if cd <= 0.0:
        return f"cd must be above 0 (got {cd:g})"
    if not 0.0 <= confidence <= 1.0:
        return f"confidence must be from 0 to 1 (got {confidence:g})"
    return ""


# ---- The aircraft


class DragBuildUp(NamedTuple):
    """Drag coefficients of the parts, on the wing area [-]; before any calibration."""

    profile: Value
    induced: Value
    tail: Value
    fuselage: Value
    parasitic: Value

    @property
    def total(self) -> Value:
        """Sum of the parts."""
        return sum(self[1:], self[0])


class WingPolar(Record):
    """Drag of an aircraft from its airfoil's polar, its tail and its fuselage.

    ``C_D = calibration (c_d(c_l, Re) + C_L^2 / (pi e AR) + C_D,tail + C_D,fuselage + C_D,other)``

    * Wing: the polar at ``c_l = section_lift_ratio C_L`` and the Reynolds number of the mean chord.
      The ratio is that of the most loaded section to the whole wing. Prandtl's lifting line at
      aspect ratio 18.5 gives 1.05 for a straight centre section with tips tapered to 0.6 over the
      outer 40 % of the span, and 1.08 for a rectangle; an elliptic wing has 1.
    * Tail: laminar flat plate with the form factor of a section, Hoerner, S. F. (1965),
      Fluid-Dynamic Drag, chapters 2 and 6: ``2 x 1.328 Re^-1/2 (1 + 2 t/c + 60 (t/c)^4)``, on
      tails of (0.35 + 0.045)/4 of the wing area (AtlantikSolar's volume ratios with a fuselage of
      four chords). About 0.0105 at a wing Reynolds number of 158 000.
    * Fuselage: turbulent flat plate ``0.074 Re^-1/5`` (Schlichting, Boundary-Layer Theory) on its
      length and wetted area with a form factor (Raymer, D. P., Aircraft Design, section 12.5).
    * Other: whatever the build-up misses, such as interference, gaps, antennas, sensors.

    A lift coefficient of null means the best one: least power of level flight at the design point,
    no slower than ``stall_margin`` times the stall speed. Like a given one it stays the same for
    whatever aircraft is sized. ``design_reynolds`` is the Reynolds number at ``C_L = 1``: at one
    weight level flight keeps ``Re C_L^1/2`` constant (XFOIL's polars of type 2).
    """

    model: Literal["wing_polar"]
    airfoil: Text
    design_aspect_ratio: PositiveReal
    design_reynolds: PositiveReal
    lift_coefficient: PositiveReal | None = None
    stall_margin: Annotated[float, Strict(), Field(ge=1.0, allow_inf_nan=False)] = 1.1
    section_lift_ratio: PositiveReal = 1.05
    span_efficiency: Fraction = 0.92
    tail_area_ratio: NonNegativeReal = (0.35 + 0.045) / 4.0
    tail_chord_ratio: PositiveReal = 0.57
    tail_thickness_ratio: NonNegativeReal = 0.08
    fuselage_wetted_area_ratio: NonNegativeReal = 0.15
    fuselage_length_chords: PositiveReal = 4.0
    fuselage_form_factor: PositiveReal = 1.2
    parasitic_drag_coefficient: NonNegativeReal = 0.0
    calibration: PositiveReal = 1.0

    @model_validator(mode="after")
    def _check_airfoil_and_stall(self) -> WingPolar:
        try:
            highest = self.highest_lift_coefficient
        except OSError as error:
            raise ValueError(f"cannot read {self.airfoil!r}: {error.strerror}") from error
        if self.lift_coefficient is not None and self.lift_coefficient > highest:
            raise ValueError(
                f"lift_coefficient must be at most {highest:.3g}, which is {self.stall_margin:g} "
                f"times the stall speed (got {self.lift_coefficient:g})"
            )
        return self

    @cached_property
    def polar(self) -> AirfoilPolar:
        """Polar of the section."""
        return AirfoilPolar.load(self.airfoil)

    @cached_property
    def maximum_lift_coefficient(self) -> float:
        """Lift coefficient of the wing at the stall, at the design point [-]."""
        lift = 1.0
        # Maximum lift hardly changes with the Reynolds number, so that this settles at once.
        for _ in range(40):
            reynolds = self.design_reynolds / lift**0.5
            lift = float(self.polar.maximum_lift(reynolds)) / self.section_lift_ratio
        return lift

    @property
    def highest_lift_coefficient(self) -> float:
        """Lift coefficient that keeps the stall margin, at the design point [-]."""
        return self.maximum_lift_coefficient / self.stall_margin**2

    @cached_property
    def flight_lift_coefficient(self) -> float:
        """Lift coefficient of level flight: the given one, or the best at the design point [-]."""
        if self.lift_coefficient is not None:
            return self.lift_coefficient
        from scipy.optimize import minimize_scalar

        highest = self.highest_lift_coefficient
        grid = np.linspace(0.1 * highest, highest, 200)
        best = int(np.argmin(self._power_measure(grid)))
        bounds = (float(grid[max(best - 1, 0)]), float(grid[min(best + 1, len(grid) - 1)]))
        found = minimize_scalar(
            self._power_measure, bounds=bounds, method="bounded", options={"xatol": 1e-9}
        )
        candidates = (float(found.x), highest)
        return min(candidates, key=lambda lift: float(self._power_measure(lift)))

    def _power_measure(self, lift: Value) -> Value:
        """Power of level flight up to a factor, ``C_D / C_L^1.5``, at the design point."""
        reynolds = self.design_reynolds * lift**-0.5
        return self.drag_at(lift, self.design_aspect_ratio, reynolds) * lift**-1.5

    def drag_coefficient(self, aspect_ratio: Value, reynolds: Value) -> Value:
        """Drag coefficient of the aircraft in level flight [-]."""
        return self.drag_at(self.flight_lift_coefficient, aspect_ratio, reynolds)

    def drag_at(self, lift_coefficient: Value, aspect_ratio: Value, reynolds: Value) -> Value:
        """Drag coefficient of the aircraft at a lift coefficient [-]."""
        return self.calibration * self.build_up(lift_coefficient, aspect_ratio, reynolds).total

    def build_up(
        self, lift_coefficient: Value, aspect_ratio: Value, reynolds: Value
    ) -> DragBuildUp:
        """Drag of the parts before calibration."""
        thickness = self.tail_thickness_ratio
        tail_form = 1.0 + 2.0 * thickness + 60.0 * thickness**4
        tail = 2.0 * 1.328 * (self.tail_chord_ratio * reynolds) ** -0.5 * tail_form
        fuselage = 0.074 * (self.fuselage_length_chords * reynolds) ** -0.2
        return DragBuildUp(
            profile=self.polar.profile_drag(self.section_lift_ratio * lift_coefficient, reynolds),
            induced=lift_coefficient**2 / (_PI * self.span_efficiency * aspect_ratio),
            tail=self.tail_area_ratio * tail,
            fuselage=self.fuselage_wetted_area_ratio * self.fuselage_form_factor * fuselage,
            parasitic=self.parasitic_drag_coefficient,
        )

    def airspeed_m_per_s(self, *, mass_kg: Value, wing_area_m2: Value, density: Value) -> Value:
        """Airspeed of level flight [m/s]."""
        pressure = mass_kg * GRAVITY_M_PER_S2 / (wing_area_m2 * self.flight_lift_coefficient)
        return (2.0 * pressure / density) ** 0.5

    def stall_speed_m_per_s(self, airspeed_m_per_s: Value) -> Value:
        """Stall speed [m/s] that belongs to an airspeed of level flight, at the design point."""
        ratio = self.flight_lift_coefficient / self.maximum_lift_coefficient
        return airspeed_m_per_s * ratio**0.5
