"""Aircraft and missions are what their files say, whether or not they were used."""

from __future__ import annotations

import pickle

import pytest

from missions.library import load_mission
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.library import load_aircraft
from sizing.performance import performance
from sizing.sunlight import SolarModel

AIRCRAFT = ("atlantiksolar-as2", "atlantiksolar-design", "sky-sailor")


def _used(aircraft: Aircraft, mission: Mission) -> None:
    performance(aircraft, mission)
    if aircraft.modules.geometry is not None:
        performance(aircraft, mission, SolarModel("FM"), step_h=1.0)


@pytest.mark.parametrize("name", AIRCRAFT)
def test_a_simulated_aircraft_equals_its_file(name: str) -> None:
    mission = load_mission("rafz-july")
    first, second, unused = (load_aircraft(name) for _ in range(3))
    _used(first, mission)
    assert first == unused
    assert unused == first
    _used(second, mission)
    assert first == second
    assert hash(first) == hash(second) == hash(unused)
    assert len({first, second, unused}) == 1
    assert mission == load_mission("rafz-july")
    assert hash(mission) == hash(load_mission("rafz-july"))


@pytest.mark.parametrize("name", AIRCRAFT)
def test_a_simulated_aircraft_survives_a_journey_to_another_process(name: str) -> None:
    aircraft = load_aircraft(name)
    _used(aircraft, load_mission("rafz-july"))
    copied = pickle.loads(pickle.dumps(aircraft))
    assert copied == aircraft
    assert hash(copied) == hash(aircraft)
    assert copied.model_dump() == aircraft.model_dump()


def test_aircraft_that_differ_are_told_apart_after_use() -> None:
    mission = load_mission("rafz-july")
    plain = load_aircraft("atlantiksolar-design")
    other = load_aircraft("atlantiksolar-design", ["modules.efficiency_stc=0.2"])
    for aircraft in (plain, other):
        _used(aircraft, mission)
    assert plain != other
    assert len({plain, other}) == 2
