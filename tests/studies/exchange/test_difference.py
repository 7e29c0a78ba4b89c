"""Tests of two designs side by side."""

from __future__ import annotations

import json

import pytest
from builders import AS2, DESIGN, aircraft, mission

from sizing.results.analysis import analyse
from studies.exchange.difference import compare_designs, difference

HEAVIER = aircraft("atlantiksolar-design", "battery.mass_kg=3.5", "power.avionics_w=8.0")
ONE, TWO, BUILT = (analyse(craft, mission(), replay=False) for craft in (DESIGN, HEAVIER, AS2))


def test_a_design_differs_in_nothing_from_itself() -> None:
    found = compare_designs(ONE, ONE)
    assert found.keys == ()
    assert all(step["difference"] in (0.0, None) for step in found.to_dict()["quantities"])
    assert "No key of the files differs" in str(found)


def test_exactly_the_changed_keys_are_told() -> None:
    found = compare_designs(ONE, TWO)
    assert {(k.key, k.first, k.second) for k in found.keys} == {
        ("battery.mass_kg", 2.918, 3.5),
        ("power.avionics_w", 6.0, 8.0),
    }
    record = {q["key"]: q for q in found.to_dict()["quantities"]}
    step = record["battery_energy_wh"]
    assert step["difference"] == pytest.approx((3.5 - 2.918) * 251.0)
    assert (step["a"], step["b"]) == pytest.approx((2.918 * 251.0, 3.5 * 251.0))
    back = compare_designs(TWO, ONE)
    for there, again in zip(record.values(), back.to_dict()["quantities"], strict=True):
        if there["difference"] is not None:
            assert there["difference"] == pytest.approx(-again["difference"])


def test_keys_of_the_mission_have_their_prefix() -> None:
    later = analyse(DESIGN, mission(dates={"on": "08-15"}, payload={"mass_kg": 0.2}), replay=False)
    keys = {k.key: (k.first, k.second) for k in compare_designs(ONE, later).keys}
    assert keys["mission.dates.on"] == ("07-15", "08-15")
    assert keys["mission.payload.mass_kg"] == (0.0, 0.2)
    # Without a mission's name in the way: names are not compared.
    assert not any(key.endswith("name") for key in keys)


def test_designs_of_two_kinds() -> None:
    found = compare_designs(ONE, BUILT)
    keys = {k.key: (k.first, k.second) for k in found.keys}
    assert keys["airframe.kind"] == ("parametric", "measured")
    # What only one of both has is one key, not a page of them.
    assert keys["airframe.structure"][1] is None
    assert not any(key.startswith("airframe.structure.") for key in keys)
    rows = {q.key: (a, b) for q, a, b in found.rows()}
    assert rows["structure_mass_kg"][1] is None
    assert rows.keys() == {q.key for q in (*found.first.quantities, *found.second.quantities)}
    json.dumps(found.to_dict(), allow_nan=False)
    assert max(map(len, str(found).splitlines())) <= 80
    assert len(found.to_frame()) == len(rows)


@pytest.mark.parametrize(
    ("one", "two", "step"),
    [
        (1.0, 3.0, 2.0),
        (1.0, 1.0 + 1e-12, 0.0),
        (float("inf"), float("inf"), 0.0),
        (float("inf"), 3.0, float("-inf")),
        (None, 3.0, None),
        ("a", "a", None),
    ],
)
def test_difference(one: float | str | None, two: float | str | None, step: float | None) -> None:
    assert difference(one, two) == step
