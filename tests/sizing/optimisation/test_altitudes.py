"""Floor and ceiling of climbs as design variables, beside sizings at fixed ones."""

from __future__ import annotations

import math
from typing import Any

import pytest
from builders import DESIGN
from builders import shipped_mission as mission

from missions.mission import Mission
from sizing import size
from sizing.aircraft import Aircraft
from sizing.optimisation.altitudes import with_best_altitudes
from sizing.optimisation.search import size_aircraft
from sizing.optimisation.sensitivity import altitude_multipliers
from sizing.program.objectives import Objective
from sizing.sunlight import UNCORRECTED_CAM


def climbing(floor_m: float, ceiling_m: float, **changes: object) -> Mission:
    climb = {"minimum_altitude_m": floor_m, "ceiling_m": ceiling_m}
    return mission(altitude_m=None, climb=climb, **changes)


def choosing(space: dict[str, Any], **changes: object) -> Mission:
    climb = {"minimum_altitude_m": 1000.0, "ceiling_m": 5000.0, "design_space": space}
    return mission(altitude_m=None, climb=climb, **changes)


def merit(there: Mission, objective: Objective = Objective.min_mass) -> float:
    return size_aircraft(DESIGN, there, objective, explain=False).merit


def chosen(there: Mission, objective: Objective = Objective.min_mass) -> tuple[float, float]:
    found = with_best_altitudes(DESIGN, there, objective, UNCORRECTED_CAM)
    assert found.climb is not None
    return found.altitude_m, found.climb.ceiling_m


def test_without_ranges_the_mission_is_itself() -> None:
    there = climbing(1000.0, 3000.0)
    assert with_best_altitudes(DESIGN, there, Objective.min_mass, UNCORRECTED_CAM) is there


@pytest.mark.slow
def test_floor_between_wind_and_thin_air_is_that_of_fixed_floors() -> None:
    # The wind asks for speed, which thin air gives and dense air only with a heavier wing loading.
    windy = {"wind_m_per_s": 12.0}
    floors = {"minimum_altitude_m": {"minimum": 1000.0, "maximum": 4000.0}}
    there = choosing(floors, **windy)
    fixed = {float(f): merit(there.flown_between(float(f), 5000.0)) for f in range(1000, 4001, 250)}
    best_m = max(fixed, key=lambda one: fixed[one])
    assert 1000.0 < best_m < 4000.0
    floor_m, ceiling_m = chosen(there)
    assert ceiling_m == 5000.0
    assert abs(floor_m - best_m) <= 250.0
    # 0.3 % is what optima are held to.
    assert merit(there.flown_between(floor_m, ceiling_m)) > 1.003 * fixed[best_m]


@pytest.mark.slow
def test_floor_and_ceiling_end_where_that_is_best() -> None:
    space = {
        "minimum_altitude_m": {"minimum": 500.0, "maximum": 1500.0},
        "ceiling_m": {"minimum": 1200.0, "maximum": 3000.0},
    }
    assert chosen(choosing(space)) == (500.0, 3000.0)


@pytest.mark.slow
def test_ceiling_that_no_day_reaches_is_lower() -> None:
    space = {"ceiling_m": {"minimum": 6000.0, "maximum": 14000.0}}
    there = choosing(space, dates={"on": "10-01"}, required_excess_time_h=0.5)
    floor_m, ceiling_m = chosen(there)
    flown = size_aircraft(DESIGN, there.flown_between(floor_m, ceiling_m), Objective.min_mass)
    assert flown.simulated is not None
    assert flown.simulated.maximum_altitude_m is not None
    highest_m = float(max(flown.simulated.maximum_altitude_m))
    # From 12.7 to 13.2 km the least mass is the same to 0.05 %: what is reached may be either.
    assert highest_m == pytest.approx(ceiling_m, abs=500.0) or ceiling_m == 6000.0
    assert flown.merit >= 1.003 * merit(there.flown_between(floor_m, 14000.0))


def test_sizing_says_what_it_chose_and_what_more_would_gain() -> None:
    space = {"ceiling_m": {"minimum": 2000.0, "maximum": 3000.0}}
    study = size(DESIGN, choosing(space), with_sensitivities=True)
    assert study.mission.climb is not None
    assert study.mission.climb.ceiling_m == 3000.0
    assert "chosen altitudes: ceiling 3000 m (from 2000 to 3000 m)" in str(study)
    record = study.to_dict()["climb"]
    assert record["ceiling_m"] == 3000.0
    assert record["minimum_altitude_m"] == 1000.0
    assert record["design_space"] == {"ceiling_m": {"minimum": 2000.0, "maximum": 3000.0}}
    sized = study.sized_mission()
    assert sized.climb is not None
    assert not sized.climb.design_space.ranges()
    assert sized.climb.ceiling_m == 3000.0
    # The multiplier is the slope of fixed ceilings.
    (gain,) = altitude_multipliers(DESIGN, study.mission, study.result)
    assert gain.constraint == "mission.climb.ceiling_m at its bound"
    slope = (merit(climbing(1000.0, 3500.0)) - merit(climbing(1000.0, 2500.0))) / 10.0
    assert gain.gain == pytest.approx(slope, rel=0.15)  # over 1000 m it falls


@pytest.mark.slow
def test_reasons_are_those_of_the_easiest_altitudes() -> None:
    space = {"minimum_altitude_m": {"minimum": 500.0, "maximum": 2500.0}}
    there = choosing(space, required_excess_time_h=40.0)
    assert math.isinf(merit(there))
    assert chosen(there)[0] == 500.0


def test_a_reliability_is_asked_of_the_chosen_altitudes(monkeypatch: pytest.MonkeyPatch) -> None:
    there = choosing({"ceiling_m": {"minimum": 2000.0, "maximum": 3000.0}})
    best = there.flown_between(1000.0, 3000.0)
    asked: list[Mission] = []

    def size_reliably(aircraft: Aircraft, mission: Mission, *_: object, **__: object) -> Any:
        asked.append(mission)
        raise InterruptedError

    monkeypatch.setattr("sizing.results.sizing.with_best_altitudes", lambda *_, **__: best)
    monkeypatch.setattr("sizing.results.sizing.size_reliably", size_reliably)
    with pytest.raises(InterruptedError):
        size(DESIGN, there, "min_mass", reliability=0.9, required_excess_time_h=2.0)
    (mission,) = asked
    assert mission.climb == best.climb
    assert mission.required_excess_time_h == 2.0
