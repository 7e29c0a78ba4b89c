import functools

import numpy as np
import pytest
from weather_files import clear_record
from wind_tables import winds_file

import sizing
from missions.files.errors import InputError
from missions.library import load_mission
from sizing.day.record import weather_performance
from sizing.library import load_aircraft
from sizing.program.margin import MarginCase
from sizing.program.objectives import Objective
from sizing.program.survival import SurvivalSizing
from sizing.results.sizing_study import SeasonDays

pytestmark = pytest.mark.slow

DESIGN = load_aircraft("atlantiksolar-design")
PLACE = {"latitude_deg": 46.8, "altitude_m": 491.0}
SEASON = {"dates": {"from": "06-10", "to": "07-09"}}
MISSION = load_mission("rafz-july", PLACE | SEASON)
STEP_S = 1800.0


def clouded(days=40, first="2001-06-05", seed=4, **changes):
    """Record whose days have light of their own: half of them nearly clear, the others less so."""
    record = clear_record(days=days, first=first, interval_s=STEP_S, **changes)
    shares = 1.0 - 0.6 * np.random.default_rng(seed).random(days + 2) ** 2
    day = ((record.start_s - record.start_s[0]) // 86400.0).astype(int)
    light = {name: getattr(record, name) * shares[day] for name in ("ghi", "dni", "dhi")}
    return functools.partial(clear_record, days=days, first=first, interval_s=STEP_S)(
        **light, **changes
    )


@pytest.fixture(scope="module", autouse=True)
def _wide_nodes():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sizing.program.survival.NODE_STEP_S", STEP_S)
        yield


RECORD = clouded()
CLIMBING = load_mission("rafz-july", PLACE | {"climb": {"ceiling_m": 5000.0}})


def sized(survive, objective="min_wingspan", mission=MISSION, weather=RECORD, aircraft=DESIGN):
    return sizing.size_in_weather(aircraft, mission, weather, objective, survive=survive)


TOLD = []  # progress of the sizing that most tests share


@pytest.fixture(scope="module")
def most():
    return sizing.size_in_weather(
        *(DESIGN, MISSION, RECORD, "min_wingspan"),
        survive=0.9,
        progress=lambda done, total: TOLD.append((done, total)),
    )


@pytest.mark.usefixtures("most")
def test_progress_only_rises_and_ends_with_all_steps_done():
    steps, totals = zip(*TOLD, strict=True)
    assert list(steps) == sorted(steps)
    assert list(totals) == sorted(totals)
    assert steps[0] == 0
    assert TOLD[-1][0] == TOLD[-1][1]
    assert len(set(steps)) > 4


def test_an_analysis_of_the_sized_aircraft_confirms_the_days(most, monkeypatch):
    found = most.survival
    assert most.status.name == "optimal"
    assert len(found.days) == 30
    assert found.days.that_close == 27
    assert found.achieved == 0.9
    step = functools.partial(sizing.day.record.weather_performance, step_s=STEP_S)
    monkeypatch.setattr("sizing.results.weather.weather_performance", step)
    frame = sizing.analyse_weather(most.sized_aircraft(), most.mission, RECORD).to_frame()
    season = frame[frame["day_of_year"].between(161, 190)]
    assert season["closes"].tolist() == found.days.closes.tolist()


def windy(folder, wind_m_per_s):
    file = winds_file(folder, lambda *_: wind_m_per_s)
    wind = {"percentile": 95.0, "hold_station": True, "file": file}
    return load_mission("rafz-july", PLACE | SEASON | {"wind": wind})


def test_a_held_place_costs_span_and_the_record_confirms_it(most, tmp_path):
    calm, held = (sized(0.9, mission=windy(tmp_path, wind)) for wind in (3.0, 12.0))
    # The search walks by designs of the program, which are within 0.1 % of each other.
    assert calm.result.objective_value == pytest.approx(most.result.objective_value, rel=2e-3)
    assert held.result.objective_value > 1.05 * most.result.objective_value
    craft = held.sized_aircraft()
    again = weather_performance(craft, held.mission, RECORD, held.solar, step_s=STEP_S)
    inside = np.isin(again.recorded.axis.day_of_year, held.mission.dates.range())
    assert again.recorded.closes[inside].sum() >= 27


def test_a_larger_share_costs_more_and_is_reached(most):
    less, all_of_them = sized(0.5), sized(1.0)
    spans = [one.result.objective_value for one in (less, most, all_of_them)]
    assert spans == sorted(spans)
    assert 0.5 <= less.survival.achieved < 0.9
    assert all_of_them.survival.achieved == 1.0


@pytest.mark.parametrize("objective", ["min_wingspan", "min_mass"])
def test_all_days_of_a_clear_record_are_the_ordinary_sizing(objective):
    """Perpetual flight on the darkest clear day of the season is what all of its days ask for.

    What differs: the days follow each other instead of one repeating itself, and their light comes
    from means of half-hours. Both searches have tolerances of their own besides.
    """
    weather = clear_record(days=20, first="2001-06-20", interval_s=STEP_S)
    mission = load_mission("rafz-july", PLACE | {"dates": {"from": "06-24", "to": "07-06"}})
    found = sized(1.0, objective, mission, weather)
    ordinary = sizing.size(DESIGN, found.mission, objective)
    assert found.survival.achieved == 1.0
    assert found.survival.days.longest_gap_days == 0
    assert found.result.objective_value == pytest.approx(ordinary.result.objective_value, rel=2e-3)
    clear = found.survival.clear_sky
    assert clear.objective_value == pytest.approx(ordinary.result.objective_value)


def test_payload_is_what_the_edge_leaves():
    aircraft = load_aircraft(
        "atlantiksolar-design", {"design_space.wingspan_m": {"minimum": 2.0, "maximum": 5.65}}
    )
    found = sized(0.9, "max_payload_mass", aircraft=aircraft)
    assert found.survival.achieved >= 0.9
    assert found.result.objective_value > 0.1
    assert found.sized_mission().payload.mass_kg == pytest.approx(found.result.objective_value)
    # With the payload of that optimum the smallest aircraft is as large as it was.
    payload = {"payload": {"mass_kg": found.result.objective_value}}
    carrying = load_mission("rafz-july", PLACE | SEASON | payload)
    again = sized(0.9, "min_wingspan", carrying)
    assert again.result.objective_value == pytest.approx(5.65, rel=3e-3)


def test_years_are_told_apart_and_a_season_may_cross_the_new_year():
    weather = clear_record(days=800, first="2001-06-01", interval_s=3 * 3600.0, share=0.9)
    mission = load_mission(
        "rafz-july", PLACE | {"dates": {"from": "12-30", "to": "01-02"}, "latitude_deg": 46.0}
    )
    solar = sizing.SolarModel("CAM", "none")
    case = MarginCase(DESIGN, mission, Objective.min_mass, solar)
    search = SurvivalSizing(case, weather, 0.5)
    axis = search.days.axis
    assert np.count_nonzero(search.season) == 8
    assert set(axis.day_of_year[search.season]) == {364, 365, 1, 2}
    days = SeasonDays.of(axis, search.season, np.arange(len(axis)) % 2 == 0)
    by_year = [(one["year"], one["days"]) for one in days.by_year()]
    assert by_year == [(2001, 2), (2002, 4), (2003, 2)]
    assert sum(one["days_that_close"] for one in days.by_year()) == days.that_close


def test_out_of_reach_says_what_is_reached():
    small = load_aircraft(
        "atlantiksolar-design", {"design_space.wingspan_m": {"minimum": 2.0, "maximum": 4.4}}
    )
    found = sized(0.9, aircraft=small)
    assert found.status.name == "infeasible"
    (missed,) = found.result.violations
    assert missed.requirement == "days_that_close"
    assert "27 of the season's 30 days are out of reach" in missed.text
    assert 0 < found.survival.days.that_close < 27
    assert missed.shortfall == pytest.approx(0.9 - found.survival.days.that_close / 30.0)
    assert found.to_dict()["nearest"]["wingspan_m"] == pytest.approx(4.4, rel=1e-2)


WINTER = load_mission("rafz-july", PLACE | {"dates": {"on": "01-01"}})
ELSEWHERE = load_mission("rafz-july", {"latitude_deg": 20.0})


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        *[({"survive": x}, ValueError, "above 0 and at most 1") for x in (0.0, 1.2, float("nan"))],
        ({"objective": "max_excess_time"}, ValueError, "that of a repeated clear day"),
        ({"objective": "longest_season"}, ValueError, "counts days or degrees"),
        ({"aircraft": load_aircraft("atlantiksolar-as2")}, TypeError, "measured aircraft"),
        ({"mission": CLIMBING}, InputError, "keep their altitude: leave out climb"),
        ({"mission": WINTER}, InputError, "has no day .* rafz-july, 1 Jan: the record covers"),
        ({"mission": ELSEWHERE}, InputError, "set the mission's latitude_deg"),
    ],
)
def test_what_cannot_be_asked(call, error, message):
    with pytest.raises(error, match=message):
        sized(**({"survive": 0.9} | call))
