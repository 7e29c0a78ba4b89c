"""The loops that the benchmark times are independent implementations of a run through weather."""

import shutil

import numpy as np
import pytest
from weather_files import clear_record

from benchmarks.weather_year import CYear, PythonYear, Year, ours
from missions.library import load_mission
from missions.weather.site import mission_at_site
from sizing.library import load_aircraft


@pytest.fixture(scope="module")
def year():
    """Forty days of broken clouds, their share changing from hour to hour and from day to day."""
    random = np.random.default_rng(5)
    days = 40
    share = np.repeat(random.uniform(0.3, 1.0, days), 24) * random.uniform(0.3, 1.3, 24 * days)
    record = clear_record(days, first="2001-04-14")
    cold = ["battery.temperature={}"]
    record = clear_record(
        days,
        first="2001-04-14",
        dni=record.dni * np.minimum(share, 1.0),
        dhi=record.dhi * share,
        temperature_c=np.repeat(random.uniform(-10.0, 20.0, days), 24),
    )
    mission = mission_at_site(load_mission("rafz-july"), record, chosen=False)[0]
    return Year.of(load_aircraft("atlantiksolar-as2", cold), mission, record)


def same(found, known):
    assert 5 < known.closes.sum() < 35
    assert np.array_equal(found.closes, known.closes)
    assert found.dawn_h == pytest.approx(known.dawn_h, abs=1e-9)
    assert found.endurance_h == pytest.approx(known.endurance_h, abs=1e-6)


def test_a_loop_in_python_flies_the_same(year):
    same(PythonYear(year).fly(), ours(year))


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no compiler")
def test_a_loop_in_c_flies_the_same(year, tmp_path):
    same(CYear.compiled(tmp_path, year).fly(), ours(year))
