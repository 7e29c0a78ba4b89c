"""Technology of the solar modules and their power tracker: what turns light into power."""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, Strict, model_validator

from solar.curves import Curve, shipped_curve
from solar.schema import Fraction, NonNegativeReal, Record
from solar.sun import FloatArray

STC_TEMPERATURE_C = 25.0
STC_IRRADIANCE_W_PER_M2 = 1000.0


_AngleDeg = Annotated[float, Strict(), Field(ge=0.0, le=90.0, allow_inf_nan=False)]
_RelativeEfficiency = Annotated[float, Strict(), Field(ge=0.0, le=1.1, allow_inf_nan=False)]


class IncidenceTable(Record):
    """Relative efficiency against the angle of incidence, given by the user."""

    aoi_deg: tuple[_AngleDeg, ...] = Field(min_length=2)
    relative_efficiency: tuple[_RelativeEfficiency, ...] = Field(min_length=2)

    @model_validator(mode="after")
    def _check_table(self) -> IncidenceTable:
        if len(self.aoi_deg) != len(self.relative_efficiency):
            raise ValueError("aoi_deg and relative_efficiency must have the same length")
        if np.any(np.diff(self.aoi_deg) <= 0.0):
            raise ValueError("aoi_deg must increase strictly")
        return self


class SolarCell(Record):
    """Efficiencies of module and maximum-power-point tracker (eq. 6-13 of the report).

    The defaults are those of AtlantikSolar AS-2: SunPower E60 cells, foil covered.
    """

    efficiency_stc: Fraction = 0.237
    camber_efficiency: Fraction = 0.97
    mppt_efficiency: Fraction = 0.95
    temperature_coefficient_per_k: NonNegativeReal = 0.003
    diffuse_efficiency: Fraction = 0.83
    incidence: IncidenceTable | None = None

    def temperature_efficiency(self, module_temperature_c: ArrayLike) -> FloatArray:
        """Component efficiency ``eps_T`` [-]: linear in the temperature above 25 C (eq. 9)."""
        excess_k = np.asarray(module_temperature_c, float) - STC_TEMPERATURE_C
        return np.asarray(np.maximum(1.0 - self.temperature_coefficient_per_k * excess_k, 0.0))

    def incidence_efficiency(self, cos_aoi: ArrayLike) -> FloatArray:
        """Component efficiency ``eps_gamma`` [-] of direct light; zero for light from behind."""
        cosine = np.asarray(cos_aoi, float)
        angle_deg = np.degrees(np.arccos(np.clip(cosine, 0.0, 1.0)))
        return np.where(cosine > 0.0, _incidence_curve(self.incidence)(angle_deg), 0.0)


@cache
def _incidence_curve(table: IncidenceTable | None) -> Curve:
    if table is None:
        return shipped_curve("incidence_sunpower_glass")
    return Curve(x=table.aoi_deg, y=table.relative_efficiency)
