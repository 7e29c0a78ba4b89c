"""How fast a battery may be charged, over its state of charge."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, Strict, model_validator

from solar.schema import (
    Fraction,
    PositiveReal,
    Record,
    UnitInterval,
    check_columns,
)
from solar.types import FloatArray


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
    def _check_limits(self) -> TableChargeLimit:
        check_columns(self, "state_of_charge", "current_a")
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
    """Largest stored power relative to the energy at full charge [1/h].

    Parameters
    ----------
    limit : ChargeLimit
        Rule or table; a table is held constant outside its range.
    state_of_charge : array_like
        State of charge, 0 to 1 [-].

    Returns
    -------
    ndarray
        Of the shape of ``state_of_charge`` [1/h].

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
