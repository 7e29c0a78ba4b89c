"""Any result as data for JSON, and the keys of the table of records."""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import pytest

import missions
import sizing
from studies import serialise as of
from studies.serialise import serialise


class Colour(IntEnum):
    red = 1


class Place(NamedTuple):
    x_m: float
    y_m: float = 2.0


@dataclass(frozen=True)
class Outer:
    inner: Place | None
    word: str = "x"

    def twice_m(self):
        return 0.0 if self.inner is None else 2.0 * self.inner.x_m


@pytest.mark.parametrize(
    ("value", "written"),
    [
        *((one, None) for one in (None, math.nan, math.inf, np.float64("inf"))),
        *((one, one) for one in (True, 3, 2.5, "word")),
        (np.array([1.0, np.nan]), [1.0, None]),
        (np.int64(4), 4),
        (Colour.red, "red"),
        ({"a": (1.0, Place(1.0))}, {"a": [1.0, {"x_m": 1.0, "y_m": 2.0}]}),
        (Outer(Place(1.0)), {"inner": {"x_m": 1.0, "y_m": 2.0}, "word": "x"}),
    ],
)
def test_values_become_data(value, written):
    assert serialise(value) == written
    assert type(serialise(value)) is type(written)


@pytest.mark.parametrize(
    ("entry", "inner", "written"),
    [
        ("+ -word -inner at.x=inner.x_m at.y=twice_m", Place(1.0), {"at": {"x": 1.0, "y": 2.0}}),
        ("*inner", Place(1.0), {"x_m": 1.0, "y_m": 2.0}),
        ("inner=inner:Short", Place(1.0), {"inner": {"x_m": 1.0}}),
        # What is behind nothing is null, or left out.
        ("x_m=inner.x_m", None, {"x_m": None}),
        ("x_m?=inner.x_m", None, {}),
    ],
)
def test_entries_name_keys_and_paths(entry, inner, written, monkeypatch):
    monkeypatch.setattr(of, "RECORDS", {"Entry": entry, "Short": "x_m"})
    of._keys.cache_clear()
    assert serialise(Outer(inner), "Entry") == written


@pytest.mark.parametrize("clearness", [1.0, 0.05])
def test_a_sizing_with_and_without_a_design_has_the_same_keys_of_it(clearness):
    aircraft = sizing.load_aircraft("atlantiksolar-design")
    mission = missions.load_mission("rafz-july", {"clearness": clearness})
    record = sizing.size(aircraft, mission).to_dict()
    design = ("wingspan_m", "total_mass_kg", "masses_kg", "simulated", "power_budget")
    none = record["status"] == "infeasible"
    assert none == (clearness < 1.0)
    assert all((record[key] is None) == none for key in design)
    assert bool(record["margins"]) != none
