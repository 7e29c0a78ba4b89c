"""Seasons: windows around the solstice, and days found with few simulations."""

import numpy as np
import pytest

from missions.flight_path import Circle
from missions.library import load_mission
from missions.mission import Mission, Scenarios
from missions.mission.mission import UncertaintyMargins
from sizing.day.light import SolarModel, solar_day
from sizing.day.module_power import path_troubles
from sizing.library import load_aircraft
from sizing.performance import perpetual_days
from studies.maps.results import season_text
from studies.maps.season import Season, perpetual_flags, season_of
from studies.models.solar_models import combinations

AS2 = load_aircraft("atlantiksolar-as2")
LOITER = load_mission("rafz-loiter")


def flags(*spans):
    result = np.zeros(365, bool)
    for first, last in spans:
        result[first - 1 : last] = True
    return result


@pytest.mark.parametrize(
    ("spans", "latitude", "season"),
    [
        ([(100, 250)], 47.6, Season(151, 151, 100, 250)),
        ([(172, 172)], 47.6, Season(1, 1, 172, 172)),
        ([(173, 250)], 47.6, Season(78, 0, None, None)),
        ([(100, 250), (260, 269)], 47.6, Season(161, 151, 100, 250)),
        ([(1, 60), (300, 365)], -40.0, Season(126, 126, 300, 60)),
        ([(1, 60), (300, 365)], 40.0, Season(126, 0, None, None)),
        ([(1, 365)], -40.0, Season(365, 365, 1, 365)),
        ([(2, 365)], 0.0, Season(364, 364, 2, 365)),
        ([(1, 200), (202, 365)], 0.0, Season(364, 364, 202, 200)),
        ([], 0.0, Season(0, 0, None, None)),
    ],
)
def test_window_around_the_summer_solstice(spans, latitude, season):
    assert season_of(flags(*spans), latitude) == season


@pytest.mark.parametrize("latitude", [-47.6, 0.0, 35.0, 70.0])
def test_sampled_days_are_those_of_the_whole_year(latitude):
    models = [SolarModel("CDM"), SolarModel("CAM", "report")]
    sampled = perpetual_flags(AS2, LOITER, latitude, models)
    for model in models:
        every = perpetual_days(AS2, LOITER, latitude, model)
        np.testing.assert_array_equal(np.flatnonzero(sampled[model]) + 1, every)


@pytest.mark.parametrize(
    ("model", "avionics_w"),
    [(SolarModel("CDM"), 18.75), pytest.param(SolarModel("FM"), 17.75, marks=pytest.mark.long)],
)
def test_two_windows_between_the_tropics_are_both_found(model, avionics_w):
    """At the equator the sun is highest at the equinoxes: the solstices are the dark seasons."""
    hungry = load_aircraft("atlantiksolar-as2", {"power.avionics_w": avionics_w})
    result = perpetual_flags(hungry, LOITER, 0.0, [model])[model]
    every = perpetual_days(hungry, LOITER, 0.0, model)
    np.testing.assert_array_equal(np.flatnonzero(result) + 1, every)
    assert np.count_nonzero(result != np.roll(result, 1)) == 4


def test_margin_of_the_solar_model_shortens_the_season_as_it_does_in_an_analysis():
    wary = LOITER.model_copy(
        update={"uncertainty_margins": UncertaintyMargins(solar_model_sigmas=2.0)}
    )
    model = SolarModel("CAM", "report")
    result = perpetual_flags(AS2, wary, 47.6, [model])[model]
    every = perpetual_days(AS2, wary, 47.6, model)
    np.testing.assert_array_equal(np.flatnonzero(result) + 1, every)
    assert result.sum() < perpetual_flags(AS2, LOITER, 47.6, [model])[model].sum()


def test_full_model_on_the_loiter_is_one_case_with_the_report():
    every = combinations()
    assert len(every) == 11
    assert combinations(("FM",), ("loiter",)) == [SolarModel("FM", "report")]
    assert combinations((SolarModel("CAM"),), ()) == [SolarModel("CAM")]  # with its own
    assert combinations(("FM",), ("report", "loiter")) == [SolarModel("FM", "report")]
    fm_by_report, fm_by_loiter = (
        solar_day(AS2, LOITER, SolarModel("FM", c)).specific_power_w_per_m2
        for c in ("report", "loiter")
    )
    np.testing.assert_allclose(fm_by_loiter, fm_by_report, rtol=1e-12)


@pytest.mark.parametrize(
    ("days", "perpetual", "text"),
    [
        (range(1, 366), lambda day: True, "on all mapped days"),
        (range(1, 366), lambda day: False, "none"),
        (range(1, 366), lambda day: 91 <= day <= 212, "1 Apr to 31 Jul"),
        # The southern summer goes through the end of the year.
        (range(1, 366, 4), lambda day: day < 60 or day > 300, "28 Oct to 26 Feb"),
        # A part of the year is no circle.
        (range(100, 201, 10), lambda day: day in (100, 200), "10 Apr, 19 Jul"),
        (range(1, 366), lambda day: day % 100 == 50, "19 Feb, 30 May, ..."),
    ],
)
def test_a_season_is_told_by_its_ends(days, perpetual, text):
    marks = np.array([perpetual(day) for day in days])
    assert season_text(np.array(days), marks) == text


def test_days_on_which_the_wind_is_too_strong_for_the_path_are_not_flown():
    """The stratosphere's winters blow harder than the path's airspeed, its summers do not."""
    path = {"flight_path": {"kind": "circle", "radius_m": 1000.0, "airspeed_m_per_s": 28.0}}
    aircraft, mission = (
        load_aircraft("stratosphere-design"),
        load_mission("stratosphere-mission", path),
    )
    models = [SolarModel("CAM", "loiter"), SolarModel("FM")]
    flags = perpetual_flags(aircraft, mission, 50.0, models)
    year = Scenarios(np.full(365, 50.0), np.arange(1, 366))
    windy = mission.scenario_winds_m_per_s(year) >= 28.0
    assert 30 < windy.sum() < 335
    for model in models:
        assert not flags[model][windy].any()
        # 21 June is flown by every model.
        assert flags[model][171]


@pytest.mark.long
def test_days_with_a_wind_aloft_too_strong_for_the_path_are_not_flown():
    path = Circle(kind="circle", radius_m=1000.0, airspeed_m_per_s=18.0)
    plain = load_mission("stratosphere-mission").model_dump(by_alias=True, exclude_none=True)
    windy = plain | {"climb": {"ceiling_m": 26000.0}, "flight_path": path}
    there = Mission.model_validate(windy)
    aircraft, models = load_aircraft("stratosphere-design"), [SolarModel("VM")]
    days = np.arange(1, 366, 7)
    perpetual = perpetual_flags(aircraft, there, 40.0, models)[models[0]][days - 1]
    scenarios = Scenarios(np.full(len(days), 40.0), days)

    def kept(where):
        return np.array([trouble is None for trouble in path_troubles(aircraft, where, scenarios)])

    able = kept(there)
    assert not (perpetual & ~able).any()
    assert kept(there.at_altitude(20000.0)).sum() > able.sum() > 0
