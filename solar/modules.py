"""Technology of the solar modules and their power tracker: what turns light into power."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, Strict, model_validator

from solar.curves import Curve, shipped_curve
from solar.schema import Fraction, NonNegativeReal, PositiveReal, Record
from solar.types import FloatArray

STC_TEMPERATURE_C = 25.0
STC_IRRADIANCE_W_PER_M2 = 1000.0
# Oettershagen's report: about 265 W at the largest insolation, from 1.35 m2 of 23.7 % cells.
_AS2_RATED_W_PER_M2 = 265.0 / 1.35
_AS2_EFFICIENCY = 0.237


_AngleDeg = Annotated[float, Strict(), Field(ge=0.0, le=90.0, allow_inf_nan=False)]
_RelativeEfficiency = Annotated[float, Strict(), Field(ge=0.0, le=1.1, allow_inf_nan=False)]


class _Table(Record):
    """A curve given by the user as two lists of equal length."""

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        (x_name, x), (y_name, y) = ((name, getattr(self, name)) for name in type(self).model_fields)
        if len(x) != len(y):
            raise ValueError(f"{x_name} and {y_name} must have the same length")
        if np.any(np.diff(x) <= 0.0):
            raise ValueError(f"{x_name} must increase strictly")
        return self


class IncidenceTable(_Table):
    """Relative efficiency against the angle of incidence of direct light."""

    aoi_deg: tuple[_AngleDeg, ...] = Field(min_length=2)
    relative_efficiency: tuple[_RelativeEfficiency, ...] = Field(min_length=2)


class LowLightTable(_Table):
    """Relative efficiency at 25 C against the irradiance on the module."""

    irradiance_w_per_m2: tuple[NonNegativeReal, ...] = Field(min_length=2)
    relative_efficiency: tuple[_RelativeEfficiency, ...] = Field(min_length=2)


class MpptTable(_Table):
    """Tracker efficiency against its load relative to the rated power."""

    relative_load: tuple[NonNegativeReal, ...] = Field(min_length=2)
    mppt_efficiency: tuple[Fraction, ...] = Field(min_length=2)


class SolarCell(Record):
    """Efficiencies of module and maximum-power-point tracker (eq. 6-13 of the report).

    The defaults are those of AtlantikSolar AS-2: SunPower E60 cells, foil covered. The constants
    ``mppt_efficiency`` and the curves ``mppt`` and ``low_light`` exclude each other: the simple
    models use the former, the Full Model the latter. ``rated_power_w_per_m2`` is the power at which
    the modules are ``temperature_rise_k`` warmer than the air and to which the tracker's load is
    related; left out it is that of AS-2 (265 W of 1.35 m2, 12 K) in proportion to the efficiency,
    because modules heat up by the light, not by the power they make of it.
    """

    efficiency_stc: Fraction = 0.237
    camber_efficiency: Fraction = 0.97
    mppt_efficiency: Fraction = 0.95
    temperature_coefficient_per_k: NonNegativeReal = 0.003
    diffuse_efficiency: Fraction = 0.83
    incidence: IncidenceTable | None = None
    low_light: LowLightTable | None = None
    mppt: MpptTable | None = None
    rated_power_w_per_m2: PositiveReal | None = None
    temperature_rise_k: NonNegativeReal = 12.0

    @property
    def full_load_w_per_m2(self) -> float:
        """Specific power at which the modules are ``temperature_rise_k`` warmer than the air."""
        if self.rated_power_w_per_m2 is not None:
            return self.rated_power_w_per_m2
        return _AS2_RATED_W_PER_M2 * self.efficiency_stc / _AS2_EFFICIENCY

    def temperature_efficiency(self, module_temperature_c: ArrayLike) -> FloatArray:
        """Component efficiency ``eps_T`` [-]: linear in the temperature above 25 C (eq. 9)."""
        excess_k = np.asarray(module_temperature_c, float) - STC_TEMPERATURE_C
        return np.asarray(np.maximum(1.0 - self.temperature_coefficient_per_k * excess_k, 0.0))

    def incidence_efficiency(self, cos_aoi: ArrayLike) -> FloatArray:
        """Component efficiency ``eps_gamma`` [-] of direct light; zero for light from behind."""
        cosine = np.asarray(cos_aoi, float)
        angle_deg = np.degrees(np.arccos(np.clip(cosine, 0.0, 1.0)))
        return np.where(cosine > 0.0, self._incidence_curve(angle_deg), 0.0)

    def low_light_efficiency(self, irradiance_w_per_m2: ArrayLike) -> FloatArray:
        """Component efficiency ``eps_I`` [-] of the irradiance on a module."""
        return self._low_light_curve(irradiance_w_per_m2)

    def tracker_efficiency(self, relative_load: ArrayLike) -> FloatArray:
        """Efficiency of the power tracker [-] at a load relative to the rated power."""
        return self._mppt_curve(relative_load)

    @cached_property
    def _incidence_curve(self) -> Curve:
        table = self.incidence
        if table is None:
            return shipped_curve("incidence_sunpower_glass")
        return Curve(x=table.aoi_deg, y=table.relative_efficiency)

    @cached_property
    def _low_light_curve(self) -> Curve:
        table = self.low_light
        if table is None:
            return shipped_curve("low_light_sunpower_c60")
        return Curve(x=table.irradiance_w_per_m2, y=table.relative_efficiency)

    @cached_property
    def _mppt_curve(self) -> Curve:
        table = self.mppt
        if table is None:
            return shipped_curve("mppt_atlantiksolar")
        return Curve(x=table.relative_load, y=table.mppt_efficiency)
