import json

import numpy as np
import pytest
from weather_files import clear_record

import sizing
import studies
from missions.files.errors import InputError
from missions.library import load_mission
from missions.weather.files import load_weather
from missions.weather.record import Site
from sizing.library import load_aircraft
from studies.weather.battery_map import battery_map_record

AS2 = load_aircraft("atlantiksolar-as2")
MISSION = load_mission("rafz-july")


@pytest.fixture(scope="module")
def data():
    weather = load_weather("colorado-2023")
    return studies.battery_map(AS2, MISSION, weather, (0.5, 1.0), mission_chosen=False)


def test_with_its_own_battery_the_days_are_those_of_the_analysis(data):
    flown = sizing.analyse_weather(
        AS2, MISSION, load_weather("colorado-2023"), mission_chosen=False
    ).to_frame()
    own = data["closes"].sel(battery_factor=1.0).to_numpy()
    assert own.tolist() == flown["closes"].astype(int).tolist()
    months = [date[:2] for date in flown["date"]]
    june = flown["closes"][np.array(months) == "06"].mean()
    halves = data["share"].sel(battery_factor=1.0, half_month=["Jun 1-15", "Jun 16-30"])
    assert float(halves.mean()) == pytest.approx(june)


def test_half_the_battery_is_lighter_and_closes_fewer_days(data):
    record = json.loads(json.dumps(battery_map_record(data), allow_nan=False))
    assert record["days_that_close"][0] < record["days_that_close"][1]
    assert sum(record["days"]) == 364  # the last day's night is not in the record
    half_kg = AS2.battery.mass_kg / 2.0
    assert np.diff(record["total_mass_kg"]) == pytest.approx(half_kg)


def test_figure_and_bad_batteries(data):
    figure = studies.plot_battery_map(data)
    assert any("days that close" in axes.get_ylabel() for axes in figure.axes)
    with pytest.raises(ValueError, match="multiples above 0"):
        studies.battery_map(AS2, MISSION, load_weather("colorado-2023"), (0.0,))


def test_a_record_without_a_night_is_refused():
    weather = clear_record(1, site=Site("Somewhere", 46.8, 6.9, 491.0, 0.0))
    with pytest.raises(InputError, match="has one day: a map needs the night"):
        studies.battery_map(AS2, MISSION, weather, (1.0,), mission_chosen=False)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--weather", "colorado-2023", "--latitudes", "0:10:5"), "has its own site"),
        (("--weather", "colorado-2023", "--resize", "min_mass"), "solar-uav size --weather"),
        (("--weather", "colorado-2023", "--endurance"), "solar-uav analyse --weather"),
        (("--batteries", "1:2:1"), "--batteries needs --weather as well"),
        (("--weather", "colorado-2023", "-m", "rafz-july"), "km from the mission rafz-july"),
    ],
)
def test_mistakes_end_with_two_and_one_line(run, options, message):
    done = run("map", "atlantiksolar-as2", *options)
    assert done.code == 2
    assert message in " ".join(done.err.split())
