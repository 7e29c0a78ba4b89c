"""Aircraft and missions are what their files say, whether or not they were used."""

import pickle

import pytest

from missions.library import load_mission
from sizing.day.light import SolarModel
from sizing.library import load_aircraft
from sizing.performance import performance

AIRCRAFT = ("atlantiksolar-as2", "atlantiksolar-design", "sky-sailor")


def _used(aircraft, mission):
    performance(aircraft, mission)
    if aircraft.modules.geometry is not None:
        performance(aircraft, mission, SolarModel("FM"), step_h=1.0)


@pytest.mark.parametrize("name", AIRCRAFT)
def test_a_simulated_aircraft_equals_its_file(name):
    mission = load_mission("rafz-july")
    first, second, unused = (load_aircraft(name) for _ in range(3))
    _used(first, mission)
    assert first == unused
    assert unused == first
    _used(second, mission)
    assert first == second
    # Another process gets the same.
    copied = pickle.loads(pickle.dumps(first))
    assert copied == unused
    assert hash(first) == hash(second) == hash(unused) == hash(copied)
    assert len({first, second, unused, copied}) == 1
    assert copied.model_dump() == unused.model_dump()
    assert mission == load_mission("rafz-july")
    assert hash(mission) == hash(load_mission("rafz-july"))
    other = load_aircraft(name, ["modules.efficiency_stc=0.2"])
    _used(other, mission)
    assert len({first, other}) == 2
