"""In which air an aircraft flies: its temperature by altitude, and a steady wind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, Strict, model_validator

from missions.air import ZERO_CELSIUS_K, Air, air_at, plain_number, standard_air
from solar.schema import Record, UnitInterval
from solar.types import FloatArray

TemperatureOffset = Annotated[float, Strict(), Field(ge=-60.0, le=60.0, allow_inf_nan=False)]
Temperature = Annotated[float, Strict(), Field(ge=-100.0, le=100.0, allow_inf_nan=False)]


class AirConditions(Record):
    """Air at flight altitude: standard, standard with an offset, or of a given temperature.

    ``albedo``: share of the light that the earth and its clouds send back up; given, it lights
    modules that face down (VM, FM).
    """

    temperature_offset_k: TemperatureOffset | None = None
    ambient_temperature_c: Temperature | None = None
    module_temperature_c: Temperature | None = None
    albedo: UnitInterval | None = None

    @model_validator(mode="after")
    def _check_temperatures(self) -> AirConditions:
        if self.temperature_offset_k is not None and self.ambient_temperature_c is not None:
            raise ValueError("give temperature_offset_k or ambient_temperature_c, not both")
        return self

    def state(self, altitude_m: float) -> Air:
        """Air at the altitude that the temperatures hold for."""
        offset_k = self.temperature_offset_k
        standard = standard_air(altitude_m, 0.0 if offset_k is None else offset_k)
        if self.ambient_temperature_c is None:
            return standard
        return air_at(self.ambient_temperature_c + ZERO_CELSIUS_K, standard.pressure_pa)

    def modules_c(self, altitude_m: float) -> float:
        """Constant module temperature of CDM and CAM [C]: as given, else that of the air."""
        if self.module_temperature_c is not None:
            return self.module_temperature_c
        air_c: float = plain_number(self.state(altitude_m).temperature_c)
        return air_c

    def moved(self, from_m: float, to_m: float) -> AirConditions:
        """Same weather at another altitude.

        Air warmer than standard stays so by as many kelvin at every altitude, and modules of a
        given temperature stay as much warmer than the air.
        """
        here = self.state(from_m)
        offset_k = here.temperature_k - standard_air(from_m).temperature_k
        update = {"temperature_offset_k": offset_k, "ambient_temperature_c": None}
        if self.module_temperature_c is not None:
            warmer_k = self.module_temperature_c - here.temperature_c
            update["module_temperature_c"] = standard_air(to_m, offset_k).temperature_c + warmer_k
        return self.model_copy(update=update)


@dataclass(frozen=True)
class SteadyWind:
    """Wind that is the same everywhere and all year; answers as wind statistics do."""

    speed_m_per_s: float
    hold_station: ClassVar[bool] = False

    def speeds(self, latitude_deg: FloatArray, *_elsewhere: object) -> FloatArray:
        """Wind speed in each scenario [m/s]."""
        return np.full(len(latitude_deg), self.speed_m_per_s)

    def strongest_m_per_s(self, *_elsewhere: object) -> float:
        """Strongest wind of scenarios [m/s]."""
        return self.speed_m_per_s

    def known_between_deg(self, _longitude_deg: float | None) -> tuple[float, float]:
        """Latitudes between which the wind is known [deg]."""
        return -90.0, 90.0
