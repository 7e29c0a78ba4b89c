"""Solar modules and their MPPT: efficiencies, constant or as curves, shipped or user-defined."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, lru_cache
from importlib import resources
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, Strict

from solar.schema import (
    Fraction,
    NonNegativeReal,
    PositiveReal,
    Real,
    Record,
    UnitInterval,
)
from solar.types import FloatArray

STC_TEMPERATURE_C = 25.0
STC_IRRADIANCE_W_PER_M2 = 1000.0
# Oettershagen's report: about 265 W at the largest insolation, from 1.35 m2 of 23.7 % cells.
_AS2_RATED_W_PER_M2 = 265.0 / 1.35
_AS2_EFFICIENCY = 0.237


_AngleDeg = Annotated[float, Strict(), Field(ge=0.0, le=90.0, allow_inf_nan=False)]
_RelativeEfficiency = Annotated[float, Strict(), Field(ge=0.0, le=1.1, allow_inf_nan=False)]


class _Table(Record):
    """Curve of a file, as two lists of equal length."""


class IncidenceTable(_Table):
    """Relative efficiency against the angle of incidence of direct light."""

    _column_over: ClassVar[Mapping[str, str]] = {"relative_efficiency": "aoi_deg"}

    aoi_deg: tuple[_AngleDeg, ...] = Field(min_length=2)
    relative_efficiency: tuple[_RelativeEfficiency, ...] = Field(min_length=2)


class LowLightTable(_Table):
    """Relative efficiency at 25 C against the irradiance on the module."""

    _column_over: ClassVar[Mapping[str, str]] = {"relative_efficiency": "irradiance_w_per_m2"}

    irradiance_w_per_m2: tuple[NonNegativeReal, ...] = Field(min_length=2)
    relative_efficiency: tuple[_RelativeEfficiency, ...] = Field(min_length=2)


class MpptTable(_Table):
    """MPPT efficiency against its load relative to the rated power."""

    _column_over: ClassVar[Mapping[str, str]] = {"mppt_efficiency": "relative_load"}

    relative_load: tuple[NonNegativeReal, ...] = Field(min_length=2)
    mppt_efficiency: tuple[Fraction, ...] = Field(min_length=2)


class Curve(_Table):
    """Tabulated curve ``y(x)``, interpolated monotonically and constant outside.

    The interpolant is a piecewise cubic that is monotone by the criterion of Fritsch & Carlson
    (1980): it passes through every point and never over- or undershoots between two of them. It is
    SciPy's ``PchipInterpolator`` to the last bit, without the half second that its import takes.
    """

    _column_over: ClassVar[Mapping[str, str]] = {"y": "x"}

    x: tuple[Real, ...] = Field(min_length=2)
    y: tuple[Real, ...] = Field(min_length=2)

    @cached_property
    def _pieces(self) -> tuple[FloatArray, FloatArray]:
        """Ends of the pieces but the last, and their coefficients."""
        x = np.asarray(self.x)
        return x[1:-1], _cubics(x, np.asarray(self.y))

    def __call__(self, x: ArrayLike) -> FloatArray:
        """Return the value of the curve at ``x``, shape of ``x``."""
        inside = np.minimum(np.maximum(x, self.x[0]), self.x[-1])
        ends, cubic = self._pieces
        piece = np.searchsorted(ends, inside, side="right")
        along = inside - np.asarray(self.x).take(piece)
        value = cubic[0].take(piece)
        for coefficient in cubic[1:]:
            value *= along
            value += coefficient.take(piece)
        return np.asarray(value)


def _cubics(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the coefficients of the pieces, the highest power first; shape (4, points - 1).

    Cubic Hermite polynomials, de Boor, A Practical Guide to Splines (1978), chapter IV.
    """
    h = np.diff(x)
    secant = np.diff(y) / h
    slope = _slopes(h, secant)
    excess = (slope[:-1] + slope[1:] - 2.0 * secant) / h
    return np.stack((excess / h, (secant - slope[:-1]) / h - excess, slope[:-1], y[:-1]))


def _slopes(h: FloatArray, secant: FloatArray) -> FloatArray:
    """Return the slopes at the points, from the steps between them and the slopes of the secants.

    Weighted harmonic mean of the neighbouring secants where both rise or both fall, else zero:
    Fritsch & Butland, A Method for Constructing Local Monotone Piecewise Cubic Interpolants (1984),
    as in Moler, Numerical Computing with MATLAB (2004), chapter 3.
    """
    if len(h) == 1:
        return np.repeat(secant, 2)
    before, after = secant[:-1], secant[1:]
    weight_before, weight_after = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
    slope = np.zeros(len(h) + 1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        mean = (weight_before / before + weight_after / after) / (weight_before + weight_after)
        monotone = np.sign(before) * np.sign(after) > 0.0
        slope[1:-1][monotone] = 1.0 / mean[monotone]
    slope[0] = _end_slope(h[0], h[1], secant[0], secant[1])
    slope[-1] = _end_slope(h[-1], h[-2], secant[-1], secant[-2])
    return slope


def _end_slope(h: float, next_h: float, secant: float, next_secant: float) -> float:
    """Return the slope of a parabola at an end, limited to keep the shape (Moler, chapter 3)."""
    slope = ((2.0 * h + next_h) * secant - h * next_secant) / (h + next_h)
    if np.sign(slope) != np.sign(secant):
        return 0.0
    if np.sign(secant) != np.sign(next_secant) and abs(slope) > 3.0 * abs(secant):
        return 3.0 * secant
    return slope


def shipped_curve(name: str) -> Curve:
    """Read a shipped curve, such as ``low_light_sunpower_c60``; FileNotFoundError for others."""
    text = resources.files("solar").joinpath("data", f"{name}.csv").read_text(encoding="utf-8")
    _, *rows = (line for line in text.splitlines() if line and not line.startswith("#"))
    x, y = np.loadtxt(rows, delimiter=",", unpack=True)
    return Curve(x=tuple(x.tolist()), y=tuple(y.tolist()))


class ModuleHeat(Record):
    """Thermal properties of a module, see :mod:`solar.heat_balance`.

    ``absorptance`` of light: Mermoud & Wittmer, PVsyst User's Manual, array thermal losses.
    ``emissivity``: Driesse, Stein & Theristis (2022), Improving common PV module temperature models
    by incorporating radiative losses to the sky, SAND2022-11604. ``underside_share``: the modules'
    share of the heat exchange of the wing's lower face; 1 on a thin film, 0 on foam.
    ``underside_absorptance``: of light from below; a white film, assumption.
    ``transition_reynolds``: Reynolds number at which the flow along the wing turns turbulent;
    Incropera et al., section 6.3, flat plate.
    """

    absorptance: Fraction = 0.9
    emissivity: Fraction = 0.88
    underside_share: UnitInterval = 1.0
    underside_absorptance: UnitInterval = 0.2
    transition_reynolds: Annotated[PositiveReal, Field(ge=1e4, le=3e6)] = 5e5


# Infinitely many cells in series under the most concentrated sunlight: De Vos, A. (1980), Detailed
# balance limit of the efficiency of tandem solar cells, J. Phys. D 13, 839-846.
HIGHEST_EFFICIENCY = 0.868


class SolarCell(Record):
    """Efficiencies of module and maximum power point tracker (MPPT; eq. 6-13 of the report).

    Defaults: AtlantikSolar AS-2, SunPower E60 cells, foil covered. The simple models use the
    constant ``mppt_efficiency``, the Full Model the curves ``mppt`` and ``low_light``.
    ``rated_power_w_per_m2``: power at which the modules are ``temperature_rise_k`` warmer than the
    air, and full load of the MPPT; by default AS-2's (265 W of 1.35 m2, 12 K) in proportion to the
    efficiency, because modules heat up by the light, not by their power. On missions without a
    module temperature a heat balance with ``thermal`` replaces ``temperature_rise_k``.
    """

    efficiency_stc: Annotated[Fraction, Field(le=HIGHEST_EFFICIENCY)] = 0.237
    camber_efficiency: Fraction = 0.97
    mppt_efficiency: Fraction = 0.95
    temperature_coefficient_per_k: NonNegativeReal = 0.003
    diffuse_efficiency: Fraction = 0.83
    incidence: IncidenceTable | None = None
    low_light: LowLightTable | None = None
    mppt: MpptTable | None = None
    rated_power_w_per_m2: PositiveReal | None = None
    temperature_rise_k: NonNegativeReal = 12.0
    thermal: ModuleHeat = ModuleHeat()

    @property
    def full_load_w_per_m2(self) -> float:
        """Specific power at which the modules are ``temperature_rise_k`` warmer than the air."""
        if self.rated_power_w_per_m2 is not None:
            return self.rated_power_w_per_m2
        return _AS2_RATED_W_PER_M2 * self.efficiency_stc / _AS2_EFFICIENCY

    def temperature_efficiency(self, module_temperature_c: ArrayLike) -> FloatArray:
        """Return ``eps_T`` [-]: linear in the temperature above 25 C (eq. 9)."""
        excess_k = np.asarray(module_temperature_c, float) - STC_TEMPERATURE_C
        return np.asarray(np.maximum(1.0 - self.temperature_coefficient_per_k * excess_k, 0.0))

    def incidence_efficiency(self, cos_aoi: ArrayLike) -> FloatArray:
        """Return ``eps_gamma`` [-] of direct light; zero for light from behind."""
        cosine = np.asarray(cos_aoi, float)
        angle_deg = np.degrees(np.arccos(np.clip(cosine, 0.0, 1.0)))
        efficiency = _curve(self.incidence, "incidence_sunpower_glass")(angle_deg)
        return np.where(cosine > 0.0, efficiency, 0.0)

    def low_light_efficiency(self, irradiance_w_per_m2: ArrayLike) -> FloatArray:
        """Return ``eps_I`` [-] of the irradiance on a module."""
        return _curve(self.low_light, "low_light_sunpower_c60")(irradiance_w_per_m2)

    def mppt_efficiency_at(self, relative_load: ArrayLike) -> FloatArray:
        """Return the efficiency of the MPPT [-] at a load relative to the rated power."""
        return _curve(self.mppt, "mppt_atlantiksolar")(relative_load)


@lru_cache
def _curve(table: _Table | None, shipped: str) -> Curve:
    """Return the curve of a table, by default the shipped one."""
    if table is None:
        return shipped_curve(shipped)
    x, y = (getattr(table, name) for name in type(table).model_fields)
    return Curve(x=x, y=y)
