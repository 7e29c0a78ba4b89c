"""Tests of the field types of descriptions."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from solar.schema import (
    Flag,
    Fraction,
    Integer,
    NonNegativeInteger,
    NonNegativeReal,
    PositiveInteger,
    PositiveReal,
    Real,
    Record,
    Text,
    UnitInterval,
)


@pytest.mark.parametrize(
    ("kind", "good", "bad"),
    [
        (Real, [-1.5, 0, 3], [True, "1", math.inf, math.nan, None]),
        (PositiveReal, [1, 0.1], [0, -1, True, math.inf]),
        (NonNegativeReal, [0, 1], [-1e-9, "0"]),
        (Fraction, [1, 0.5], [0, 1.01, True]),
        (UnitInterval, [0, 1, 0.5], [-0.01, 1.01, False]),
        (Integer, [0, -3], [1.0, True, "3"]),
        (PositiveInteger, [1], [0, 1.0, True]),
        (NonNegativeInteger, [0, 2], [-1, 1.0, False]),
        (Flag, [True, False], [1, "true"]),
        (Text, ["a"], ["", 1]),
    ],
)
def test_field_types(kind: Any, good: list[object], bad: list[object]) -> None:
    adapter = TypeAdapter(kind)
    for value in good:
        assert adapter.validate_python(value) == value
    for value in bad:
        with pytest.raises(ValidationError):
            adapter.validate_python(value)


def test_records_are_frozen_and_check_their_defaults() -> None:
    class Right(Record):
        mass_kg: PositiveReal

    class Wrong(Record):
        mass_kg: PositiveReal = -1.0

    with pytest.raises(ValidationError):
        Right(mass_kg=1.0).mass_kg = 2.0  # type: ignore[misc]
    with pytest.raises(ValidationError):
        Wrong()
