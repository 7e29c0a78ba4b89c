"""Field types shared by every description of an aircraft or a mission."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict

__all__ = [
    "Flag",
    "Fraction",
    "Integer",
    "NonNegativeInteger",
    "NonNegativeReal",
    "PositiveInteger",
    "PositiveReal",
    "Real",
    "Record",
    "Text",
    "UnitInterval",
]


class Record(BaseModel):
    """Immutable description that refuses unknown keys and non-finite numbers."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True
    )


def _at_least(limit: float) -> AfterValidator:
    """Refuse positive numbers too small for anything that flies."""

    def check(value: float) -> float:
        if value < limit:
            raise ValueError(f"must be at least {limit:g} (got {value:g})")
        return value

    return AfterValidator(check)


# Bounds far outside all that flies keep the arithmetic free of overflow.
# Strict: neither `true` nor a quoted number passes for a number; an integer passes for a real.
Real = Annotated[float, Strict(), Field(allow_inf_nan=False)]
PositiveReal = Annotated[
    float, Strict(), Field(gt=0, le=1e12, allow_inf_nan=False), _at_least(1e-9)
]
NonNegativeReal = Annotated[float, Strict(), Field(ge=0, le=1e12, allow_inf_nan=False)]
Fraction = Annotated[float, Strict(), Field(gt=0, le=1, allow_inf_nan=False), _at_least(1e-3)]
UnitInterval = Annotated[float, Strict(), Field(ge=0, le=1, allow_inf_nan=False)]

Integer = Annotated[int, Strict()]
PositiveInteger = Annotated[int, Strict(), Field(gt=0)]
NonNegativeInteger = Annotated[int, Strict(), Field(ge=0)]

Flag = Annotated[bool, Strict()]
Text = Annotated[str, Strict(), Field(min_length=1, pattern=r"\S")]
