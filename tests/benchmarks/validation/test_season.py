"""Season of perpetual flight under changed conditions."""

import pytest

from benchmarks.validation import season as study
from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.performance import perpetual_days


@pytest.fixture(scope="module")
def result():
    return study.seasons(
        [
            study.Condition("plain"),
            study.Condition("dim", ("clearness=0.8",)),
            study.Condition("rough", ("turbulence.all_day=0.2",)),
            study.Condition("never", ("clearness=0.1",)),
        ]
    )


def test_season_is_that_of_the_simulator(result):
    plain = result[0]
    aircraft, mission = load_aircraft(study.AIRCRAFT), load_mission(study.MISSION)
    assert plain.days == len(perpetual_days(aircraft, mission, 47.6))
    # A full battery asks for more than a closed cycle does.
    assert 0 < plain.full_days <= plain.days
    assert plain.gaps == 0


def test_less_light_and_rough_air_shorten_it(result):
    plain, dim, rough, never = result
    assert max(dim.days, rough.days) < plain.days
    assert (never.days, never.first, never.last, never.full_days) == (0, None, None, 0)
