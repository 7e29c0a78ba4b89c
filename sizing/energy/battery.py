"""The battery: capacity, efficiencies, and how fast it may be charged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, Strict, model_validator

from solar.schema import Fraction, PositiveReal, Record, UnitInterval
from solar.types import FloatArray

# Fine enough that integrating 1/rate over it by the trapezoidal rule errs by less than 1e-6 h.
_TABLE_POINTS = 4001


class NoChargeLimit(Record):
    """The battery takes whatever the sun leaves over."""

    kind: Literal["none"] = "none"


class RuleChargeLimit(Record):
    """Constant current, then an exponential taper up to full charge.

    The design rule used for AtlantikSolar where no measurement exists: 0.5 C up to 90 % state of
    charge, falling exponentially to 4.6 % of that at full charge.
    """

    kind: Literal["rule"] = "rule"
    c_rate_per_h: PositiveReal = 0.5
    taper_start: Annotated[float, Strict(), Field(ge=0.0, lt=1.0)] = 0.9
    relative_rate_at_full: Fraction = 0.046


class TableChargeLimit(Record):
    """Charge current measured over the state of charge; held constant outside the table."""

    kind: Literal["table"] = "table"
    state_of_charge: tuple[UnitInterval, ...] = Field(min_length=2)
    current_a: tuple[PositiveReal, ...] = Field(min_length=2)
    voltage_v: PositiveReal
    pack_energy_wh: PositiveReal

    @model_validator(mode="after")
    def _check_table(self) -> TableChargeLimit:
        if len(self.state_of_charge) != len(self.current_a):
            raise ValueError("state_of_charge and current_a must have the same length")
        if np.any(np.diff(self.state_of_charge) <= 0.0):
            raise ValueError("state_of_charge must increase strictly")
        if np.any(np.diff(self.current_a) > 0.0):
            raise ValueError("current_a must not rise with the state of charge")
        return self


ChargeLimit = Annotated[
    NoChargeLimit | RuleChargeLimit | TableChargeLimit, Field(discriminator="kind")
]


def constant_up_to(limit: ChargeLimit) -> float:
    """State of charge up to which a charge limit has the rate of an empty battery."""
    if isinstance(limit, RuleChargeLimit):
        return limit.taper_start
    return limit.state_of_charge[0] if isinstance(limit, TableChargeLimit) else 1.0


def charge_rate_per_h(limit: ChargeLimit, state_of_charge: ArrayLike) -> FloatArray:
    """Largest stored power relative to the capacity [1/h] at a state of charge.

    Raises
    ------
    ValueError
        For :class:`NoChargeLimit`, which has no finite rate.
    """
    soc = np.asarray(state_of_charge, float)
    if isinstance(limit, RuleChargeLimit):
        decay = -np.log(limit.relative_rate_at_full) / (1.0 - limit.taper_start)
        beyond = np.maximum(soc - limit.taper_start, 0.0)
        return np.asarray(limit.c_rate_per_h * np.exp(-decay * beyond))
    if isinstance(limit, TableChargeLimit):
        power_w = np.asarray(limit.current_a) * limit.voltage_v
        return np.asarray(np.interp(soc, limit.state_of_charge, power_w / limit.pack_energy_wh))
    raise ValueError("a battery without charge limit has no finite charge rate")


@dataclass(frozen=True)
class ChargeClock:
    """How the charge limit alone would charge the battery over time.

    ``hours[i]`` is the time the limit needs from empty to ``state_of_charge[i]``. Because the
    limit depends on nothing but the state of charge, following it for a while is a shift along
    this clock: exact for any step length. Up to ``constant_up_to`` the rate is constant and no
    table is needed.
    """

    state_of_charge: FloatArray
    hours: FloatArray
    constant_up_to: float
    constant_rate_per_h: float

    @classmethod
    def of(cls, limit: ChargeLimit) -> ChargeClock | None:
        """Clock of a limit; none where charging is not limited."""
        if isinstance(limit, NoChargeLimit):
            return None
        soc = np.linspace(0.0, 1.0, _TABLE_POINTS)
        if isinstance(limit, TableChargeLimit):
            soc = np.union1d(soc, limit.state_of_charge)
        slowness = 1.0 / charge_rate_per_h(limit, soc)
        hours = np.concatenate(
            ([0.0], np.cumsum(np.diff(soc) * (slowness[1:] + slowness[:-1]) / 2.0))
        )
        return cls(soc, hours, constant_up_to(limit), float(charge_rate_per_h(limit, 0.0)))

    def after(self, state_of_charge: FloatArray, duration_h: ArrayLike) -> FloatArray:
        """State of charge after following the limit for ``duration_h`` hours, at most 1."""
        start_h = np.interp(state_of_charge, self.state_of_charge, self.hours)
        end_h = np.asarray(start_h + np.asarray(duration_h, float))
        return np.asarray(np.interp(end_h, self.hours, self.state_of_charge))

    def hours_to_full(self, state_of_charge: FloatArray) -> FloatArray:
        """Hours that the limit alone needs to full charge."""
        return np.asarray(
            self.hours[-1] - np.interp(state_of_charge, self.state_of_charge, self.hours)
        )


class Battery(Record):
    """A battery pack described by its mass."""

    mass_kg: PositiveReal
    specific_energy_wh_per_kg: PositiveReal
    charge_efficiency: Fraction = 0.95
    discharge_efficiency: Fraction = 0.97
    charge_limit: ChargeLimit = NoChargeLimit()

    @property
    def battery_energy_wh(self) -> float:
        """Energy at full charge [Wh]."""
        return self.mass_kg * self.specific_energy_wh_per_kg
