"""The repeated day with climbs: against plain repetition from a full battery."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import builders
import numpy as np
import pytest
from builders import AS2

from sizing.altitude.climb_day import Day
from sizing.altitude.climb_march import March
from sizing.altitude.climb_repetition import repeated_day
from sizing.altitude.climb_run import Stored
from sizing.performance import performance

_DAYS, _SETTLED = 300, 1e-13


def march_of(strategy: str, number: int) -> March:
    """Days of AS-2 with other batteries, modules, avionics and climbs, from spring to summer."""
    climb = {"ceiling_m": 9000.0, "strategy": strategy}
    mission = builders.mission(climb=climb, dates={"from": "03-21", "to": "06-21", "count": 3})
    flight, random = performance(AS2, mission), np.random.default_rng(5)
    assert flight.levels is not None
    which = random.integers(0, 3, number)
    levels, store = flight.levels.select(which), flight.store.flat((3,)).select(which)
    scale = {
        "module_area_m2": random.uniform(0.45, 1.0, number),
        "constant_power_w": random.uniform(0.5, 2.0, number),
        "maximum_power_w": random.uniform(0.3, 1.0, number),
    }
    levels = replace(levels, **{name: getattr(levels, name) * by for name, by in scale.items()})
    energy_wh = store.battery_energy_wh * random.uniform(0.2, 1.3, number)
    store = replace(store, battery_energy_wh=energy_wh)
    return March(flight.day.time_h, levels, store, flight.mission.climb.strategy, 1)


def repeated(march: March) -> Stored:
    """What is stored at midnight after many days from a full battery; NaN where it still moves."""
    full = march.store.battery_energy_wh
    found, moving = np.full((2, march.count), np.nan), np.arange(march.count)
    stored = Stored(full, np.zeros_like(full))
    for _ in range(_DAYS):
        end = march.end_of_day(stored)
        moves = [np.abs(a - b) for a, b in zip(stored, end, strict=True)]
        still = np.maximum(*moves) <= _SETTLED * march.store.battery_energy_wh
        found[:, moving[still]] = [one[still] for one in end]
        if still.all():
            break
        march, moving = march.select(~still), moving[~still]
        stored = Stored(*(one[~still] for one in end))
    return Stored(*found)


@pytest.mark.parametrize("strategy", ["battery_full", "surplus"])
def test_day_is_the_one_that_plain_repetition_ends_in(strategy: str) -> None:
    march = march_of(strategy, 200)
    plain, day, scale = repeated(march), Day(march), march.store.battery_energy_wh
    known = np.isfinite(plain.battery_wh)
    assert known.mean() > 0.95
    assert np.any(plain.potential_wh[known] > 0.0)
    assert np.any(day.energy[:, known].min(axis=0) == 0.0)
    for ours, theirs in ((day.energy[0], plain.battery_wh), (day.potential[0], plain.potential_wh)):
        np.testing.assert_allclose((ours / scale)[known], (theirs / scale)[known], atol=1e-9)


class Geometric:
    """Days that end nearer to one state by a constant ratio; they are counted."""

    def __init__(self, ratio: float) -> None:
        self.ratio, self.days, self.state = ratio, 0, Stored(np.array([60.0]), np.array([5.0]))
        self.store = SimpleNamespace(battery_energy_wh=np.array([100.0]))
        self.potential_max_wh = np.array([20.0])

    def select(self, some: object) -> Geometric:
        return self

    def empty_run(self) -> None:
        return None

    def end_of_day(self, stored: Stored, run: None = None) -> Stored:
        self.days += 1
        pairs = zip(stored, self.state, strict=True)
        return Stored(*(there + self.ratio * (one - there) for one, there in pairs))


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.85])
def test_gains_in_a_geometric_series_are_extrapolated_at_once(ratio: float) -> None:
    days: Any = Geometric(ratio)
    repeated_day(days)
    # From a full battery, three days of a series, the one that it leads to, and that day's record.
    assert days.days == 6
