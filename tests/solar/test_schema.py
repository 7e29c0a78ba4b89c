from __future__ import annotations

import copy
import math
import pickle
import pydoc
from functools import cached_property

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

import solar
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
def test_field_types(kind, good, bad):
    adapter = TypeAdapter(kind)
    for value in good:
        assert adapter.validate_python(value) == value
    for value in bad:
        with pytest.raises(ValidationError):
            adapter.validate_python(value)


@pytest.mark.parametrize("kind", [PositiveReal, Fraction])
@pytest.mark.parametrize("value", [0.0, -0.5])
def test_numbers_that_are_not_positive_are_told_so(kind, value):
    # The least number that is allowed, 1e-9 or 1e-3, is told to those who wrote a positive one.
    with pytest.raises(ValidationError, match="should be greater than 0 "):
        TypeAdapter(kind).validate_python(value)
    with pytest.raises(ValidationError, match="must be at least"):
        TypeAdapter(kind).validate_python(1e-10)


def test_records_are_frozen_and_check_their_defaults():
    class Right(Record):
        mass_kg: PositiveReal

    class Wrong(Record):
        mass_kg: PositiveReal = -1.0

    with pytest.raises(ValidationError):
        Right(mass_kg=1.0).mass_kg = 2.0
    with pytest.raises(ValidationError):
        Wrong()


class _Half(Record):
    """A record that derives an array, and has one of its own kind inside."""

    values: tuple[Real, ...]
    inner: _Half | None = None

    @cached_property
    def halved(self):
        return np.array(self.values) / 2.0


def test_derived_data_play_no_part_in_what_a_record_is():
    values = st.lists(st.floats(-1e6, 1e6), max_size=3).map(tuple)

    @given(values, values, st.booleans(), st.booleans())
    def check(some, others, first, second):
        a, b = (_Half(values=v, inner=_Half(values=v)) for v in (some, others))
        for record, used in ((a, first), (b, second)):
            if used:
                assert len(record.halved) == len(record.inner.halved)
        assert (a == b) is (some == others)
        assert (b == a) is (some == others)
        assert len({a, b}) == (1 if some == others else 2)
        assert pickle.loads(pickle.dumps(a)) == a

    check()
    assert _Half(values=()) != ()
    assert _Half(values=(1.0,)) == _Half(values=(1,))

    class Other(_Half):
        pass

    assert Other(values=()) != _Half(values=())


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda record: pickle.loads(pickle.dumps(record))]
)
def test_copies_are_equal(copied):
    record = _Half(values=(2.0,), inner=_Half(values=(3.0,)))
    assert record.halved.tolist() == [1.0]
    same = copied(record)
    assert same == record
    assert hash(same) == hash(record)
    assert same.halved.tolist() == [1.0]
    assert same.model_fields_set == record.model_fields_set
    # A changed copy derives its own data.
    for deep in (False, True):
        changed = same.model_copy(update={"values": (4.0,)}, deep=deep)
        assert changed.halved.tolist() == [2.0]


def test_help_is_about_the_record():
    text = pydoc.render_doc(solar.SolarCell, renderer=pydoc.plaintext)
    assert "SolarCell(*, efficiency_stc=0.237, camber_efficiency=0.97," in text
    assert "temperature_efficiency(self, module_temperature_c" in text
    for internal in ("__pydantic", "Strict(", "AfterValidator", "model_json_schema"):
        assert internal not in text
    assert len(text.splitlines()) < 80
    # What pydantic offers is there all the same.
    assert solar.SolarCell().model_dump()["efficiency_stc"] == 0.237
    assert "efficiency_stc" in solar.SolarCell.model_json_schema()["properties"]
