"""Missions with a percentile of the wind: what is accepted, and the wind of each before_change."""

import gzip
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from missions.files.errors import InputError
from missions.files.validation import validate
from missions.files.yaml import parse_yaml
from missions.mission import Mission, Scenarios
from missions.winds.table import COLUMNS, shipped_winds

HIGH = {"name": "high", "latitude_deg": 47.6, "dates": {"on": "07-15"}, "altitude_m": 20000.0}
P95 = {"percentile": 95.0}


def mission(**changes):
    """Return a mission in the stratosphere, changed."""
    return Mission.model_validate({**HIGH, "wind": P95, **changes})


def test_wind_of_each_scenario_is_that_of_its_latitude_and_month():
    latitudes = {"from_deg": 40.0, "to_deg": 50.0, "count": 2}
    there = mission(latitude_deg=latitudes, dates={"from": "07-01", "to": "08-31", "count": 2})
    expected = [
        float(shipped_winds().at(latitude, 20000.0, month, 95.0))
        for latitude in (40.0, 50.0)
        for month in (7, 8)
    ]
    assert there.scenario_winds_m_per_s().tolist() == expected
    assert there.strongest_wind_m_per_s == max(expected)
    assert there.wind.speed_m_per_s == max(expected)
    days = Scenarios(np.full(4, 47.6), np.array([31, 32, 59, 60]))  # 31 Jan, 1 Feb, 28 Feb, 1 Mar
    january, february, also_february, march = mission().scenario_winds_m_per_s(days).tolist()
    assert february == also_february
    assert len({january, february, march}) == 3


def test_another_altitude_has_its_own_wind():
    there = mission().at_altitude(12000.0)
    expected = shipped_winds().at(47.6, 12000.0, 7, 95.0)
    assert there.strongest_wind_m_per_s == pytest.approx(float(expected))
    with pytest.raises(ValueError, match="altitude_m 9126 to 33043"):
        _ = mission().at_altitude(500.0).strongest_wind_m_per_s


def test_altitudes_may_be_draws():
    there = mission().model_copy(update={"altitude_m": np.array([12000.0, 20000.0])})
    both = [mission().at_altitude(h).strongest_wind_m_per_s for h in (12000.0, 20000.0)]
    assert np.asarray(there.strongest_wind_m_per_s) == pytest.approx(both)


def test_a_given_wind_stays_as_it_is_and_one_of_zero_may_stand_beside_a_percentile():
    given = Mission.model_validate({**HIGH, "wind_m_per_s": 7.5})
    assert given.strongest_wind_m_per_s == 7.5
    assert given.scenario_winds_m_per_s().tolist() == [7.5]
    assert mission().in_wind(7.5).strongest_wind_m_per_s == 7.5
    # Files say so to begin with, and ``--set mission.wind...`` is to work on them.
    assert mission(wind_m_per_s=0.0).strongest_wind_m_per_s > 0.0


def table(folder, wind=12.0):
    path = folder / "winds.csv"
    rows = [
        f"{latitude},{altitude},7,{p},{wind * p / 50}"
        for latitude in (40, 50)
        for altitude in (0, 21000)
        for p in (50, 80)
    ]
    path.write_text("\n".join([",".join(COLUMNS), *rows]))
    return str(path)


def test_a_table_of_ones_own(tmp_path):
    user_table = {"percentile": 65.0, "file": table(tmp_path)}
    assert mission(altitude_m=100.0, wind=user_table).strongest_wind_m_per_s == pytest.approx(15.6)
    with pytest.raises(ValidationError, match="lacks the month Jan"):
        mission(wind=user_table, dates={"on": "01-01"})


def test_a_mistake_in_a_table_is_told_with_its_line(tmp_path):
    path = Path(table(tmp_path))
    path.write_text(path.read_text().replace("50,0,7,80", "50,0,13,80"))
    text = (
        f"name: a\nlatitude_deg: 47\ndates: {{on: 07-15}}\nwind: {{percentile: 60, file: {path}}}"
    )
    with pytest.raises(InputError) as refused:
        validate(parse_yaml(text, "mine.yaml"), Mission)
    assert str(refused.value).startswith(f"mine.yaml:4:1: wind: {path}:7: month: must be")


def test_a_changed_table_makes_another_mission(tmp_path):
    before_change = mission(wind={"percentile": 65.0, "file": table(tmp_path)})
    before = before_change.strongest_wind_m_per_s
    context = {"contents": True}
    written = before_change.model_dump_json(context=context)
    table(tmp_path, wind=24.0)
    again = mission(wind={"percentile": 65.0, "file": before_change.wind_statistics.file})
    assert again.strongest_wind_m_per_s == pytest.approx(2.0 * before)
    assert again.model_dump_json(context=context) != written


def test_the_shipped_file_says_where_it_is_from():
    file = resources.files("missions").joinpath("winds", "data", "zonal-p95.csv.gz")
    head = gzip.decompress(file.read_bytes()).decode()[:1500]
    assert "contains modified Copernicus Climate Change Service information" in head
    assert "MIT License" in head
    licence = file.parent.joinpath("aerosandbox.LICENSE").read_text()
    assert "this permission notice shall be included in all" in licence
    assert len(file.read_bytes()) < 300_000
