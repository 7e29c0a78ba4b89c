"""Missions: what is accepted, what is refused, and the scenarios that a mission expands to."""

import ambiance
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from missions.dates import date_code, day_of_year
from missions.files.shipped import find_document, shipped_names
from missions.library import load_mission
from missions.mission import Mission
from missions.mission.flight import Launch
from missions.mission.scenarios import SOLSTICES, Dates, LatitudeRange, latitude_label

LAUNCH = {"date": "06-30", "time_local": "11:14", "utc_offset_h": 2.0, "duration_h": 28.35}


def mission(**changes):
    """Return a plain mission, changed."""
    return Mission(**{"name": "test", "latitude_deg": 47.6, "dates": {"on": "07-15"}, **changes})


def dates(first, last, count=None):
    return Dates.model_validate({"from": first, "to": last, "count": count})


@pytest.mark.parametrize(
    ("chosen", "days"),
    [
        (Dates(on="07-15"), [196]),
        (dates("07-15", "07-15"), [196]),
        # A range is represented by its ends and its middle, also across the end of the year.
        (dates("05-01", "05-31"), [121, 136, 151]),
        (dates("12-30", "01-03", 5), [364, 365, 1, 2, 3]),
        # 123 days from 1 November to 3 March; the middle one, 1 January, is moved to the solstice.
        (dates("11-01", "03-03"), [305, 355, 62]),
        (dates("01-01", "12-31"), [1, 172, 355, 365]),
        (dates("03-01", "10-31", 2), [60, 304]),  # asked for the ends alone
        (dates("09-01", "10-31"), [244, 274, 304]),
        (dates("01-01", "01-10", 1), [1]),
        (dates("01-01", "01-10", 2), [1, 10]),
        (dates("01-01", "01-10", 4), [1, 4, 7, 10]),
        (dates("01-01", "01-10", 100), [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]),
    ],
)
def test_days_that_stand_for_the_dates(chosen, days):
    assert chosen.days() == days


@given(st.integers(1, 365), st.integers(1, 365), st.integers(2, 365))
def test_days_are_distinct_members_of_their_range_with_both_ends(first, last, count):
    chosen = dates(date_code(first), date_code(last), count)
    every, days = chosen.range(), chosen.days()
    assert (days[0], days[-1]) == (first, last)
    assert len(days) == min(count, len(every)) == len(set(days))
    even = np.round(np.linspace(0, len(every) - 1, len(days))).astype(int)
    moved = {days[i] for i in range(len(days)) if every.index(days[i]) not in even}
    assert moved <= set(SOLSTICES)  # evenly spaced but for the solstices
    assert all(day in days for day in SOLSTICES if day in every) or count < 4


def test_dates_are_normalised():
    assert Dates(on=" 7-5 ").on == Dates(on="2015-07-05").on == "07-05"


@pytest.mark.parametrize(
    ("ends", "values"), [((45, 50, 3), [45.0, 47.5, 50.0]), ((10, -10, 5), [10, 5, 0, -5, -10])]
)
def test_latitude_range_includes_its_ends_and_may_lead_south(ends, values):
    first, last, count = ends
    assert LatitudeRange(from_deg=first, to_deg=last, count=count).values() == values


@pytest.mark.parametrize(
    ("latitude", "label"),
    [(47.6, "47.6° N"), (-33, "33° S"), (0, "0°"), (-0.25, "0.25° S"), (-90, "90° S")],
)
def test_latitudes_are_accepted_and_labelled(latitude, label):
    assert mission(latitude_deg=latitude).latitudes() == [float(latitude)]
    assert latitude_label(float(latitude)) == label


def test_temperature_offset_thins_the_air():
    reference = ambiance.Atmosphere(500.0)
    warm = mission(altitude_m=500.0, air={"temperature_offset_k": 15.0})
    expected = reference.density[0] * reference.temperature[0] / (reference.temperature[0] + 15.0)
    assert warm.air_state().density_kg_per_m3 == pytest.approx(expected, rel=1e-5)  # see above
    assert warm.module_temperature_c() == pytest.approx(reference.temperature_in_celsius[0] + 15.0)


def test_ambient_temperature_overrides_the_density():
    flight = mission(altitude_m=536.0, air={"ambient_temperature_c": 22.7}).air_state()
    pressure = ambiance.Atmosphere(536.0).pressure[0]
    assert flight.temperature_c == pytest.approx(22.7)
    assert flight.pressure_pa == pytest.approx(pressure, rel=1e-5)  # see above
    # Ideal gas of dry air, 287.05 J/(kg K).
    assert flight.density_kg_per_m3 == pytest.approx(pressure / (287.05287 * 295.85), rel=1e-5)


def test_module_temperature_is_that_of_the_air_unless_given():
    assert mission(air={"ambient_temperature_c": 22.7}).module_temperature_c() == pytest.approx(
        22.7
    )
    both = mission(air={"ambient_temperature_c": 22.7, "module_temperature_c": 37.0})
    assert both.module_temperature_c() == 37.0
    assert both.air_state().temperature_c == pytest.approx(22.7)
    assert mission(altitude_m=0.0).module_temperature_c() == pytest.approx(15.0)  # sea level


def test_night_floor_is_the_altitude():
    climb = {"ceiling_m": 18000.0, "minimum_altitude_m": 12000.0}
    floor = mission(climb=climb)
    assert floor.altitude_m == 12000.0
    assert floor == mission(climb=climb, altitude_m=12000.0)
    assert floor == mission(climb=climb, altitude_m=None)
    assert Mission.model_validate(floor.model_dump(by_alias=True)) == floor
    assert mission(climb={"ceiling_m": 18000.0}).altitude_m == 0.0


def test_a_flight_path_is_flown_in_the_winds_of_all_heights():
    where = {"latitude_deg": 40.0, "altitude_m": 20000.0, "wind": {"percentile": 95}}
    path = {"kind": "circle", "radius_m": 1000.0, "airspeed_m_per_s": 16.0}
    there = mission(**where, climb={"ceiling_m": 26000.0}, flight_path=path)
    high = there.at_altitude(26000.0).strongest_wind_m_per_s
    assert there.strongest_wind_m_per_s < 16.0 < high == pytest.approx(there.wind.speed_m_per_s)


def test_winds_of_all_heights_must_be_known_where_the_place_is_held():
    wind = {"percentile": 95, "hold_station": True}
    held = mission(altitude_m=15000.0, climb={"ceiling_m": 18000.0}, wind=wind)
    assert held.holds_station
    # The shipped table begins at 9.1 km and ends at 33 km.
    low = {"altitude_m": 8000.0, "climb": {"ceiling_m": 12000.0}}
    with pytest.raises(ValidationError, match="altitude"):
        mission(**low, wind=wind)
    with pytest.raises(ValidationError, match="give it without launch"):
        mission(altitude_m=15000.0, longitude_deg=8.5, launch=LAUNCH, wind=wind)


@pytest.mark.parametrize(
    ("text", "hours"),
    [("00:00", 0.0), ("9:30", 9.5), ("11:14", 11.0 + 14.0 / 60.0), ("23:59", 23.9833333)],
)
def test_launch_is_read(text, hours):
    launch = Launch.model_validate({**LAUNCH, "time_local": text})
    assert launch.clock_h == pytest.approx(hours)
    assert (launch.date, launch.state_of_charge) == ("06-30", 1.0)
    assert mission(longitude_deg=0.0, launch=LAUNCH).launch is not None


def test_scenarios_run_through_the_days_of_each_latitude():
    scenarios = mission(
        latitude_deg={"from_deg": 45.0, "to_deg": 50.0, "count": 2},
        dates={"from": "12-31", "to": "01-02", "count": 3},
    ).scenarios()
    assert len(scenarios) == 6
    assert scenarios.latitude_deg.tolist() == [45.0, 45.0, 45.0, 50.0, 50.0, 50.0]
    assert scenarios.day_of_year.tolist() == [365, 1, 2, 365, 1, 2]
    assert scenarios.noon_day.tolist() == [365.5, 1.5, 2.5, 365.5, 1.5, 2.5]
    assert [scenarios.label(i) for i in (0, 4)] == ["45° N, 31 Dec", "50° N, 1 Jan"]


@pytest.mark.parametrize(
    ("latitude", "date", "dark"),
    [
        # Tromso's polar night: the geometric sun stays down at midwinter, not at midsummer.
        ({"from_deg": 60.0, "to_deg": 75.0, "count": 4}, "12-21", [False, False, True, True]),
        (90.0, "12-21", [True]),
        (90.0, "06-21", [False]),
        (-90.0, "06-21", [True]),
        (-90.0, "12-21", [False]),
        (-70.0, "06-21", [True]),
        (0.0, "12-21", [False]),
    ],
)
def test_polar_night_by_hemisphere(latitude, date, dark):
    scenarios = mission(latitude_deg=latitude, dates={"on": date}).scenarios()
    assert scenarios.in_polar_night().tolist() == dark


@pytest.mark.parametrize("name", shipped_names("mission"))
def test_shipped_missions_are_valid(name):
    data = find_document("mission", name).data
    # YAML takes some dates and times for numbers; those in the files must remain text.
    assert all(isinstance(data["dates"].get(key, ""), str) for key in ("on", "from", "to"))
    assert isinstance(data.get("launch", {}).get("time_local", ""), str)
    read = Mission.model_validate(data)
    assert read.name == name
    assert len(read.scenarios()) == len(read.latitudes()) * len(read.dates.days()) > 0
    assert 0.0 < read.air_state().density_kg_per_m3 < 1.5  # denser than on any coast in winter
    assert not read.scenarios().in_polar_night().any()


def test_the_flights_are_the_published_ones():
    flight = load_mission("rafz-28h")
    assert (flight.latitude_deg, flight.longitude_deg) == (47.6, 8.53)
    # 30 June, 11:14, with a charge of 57.7 %; landing on 1 July at 15:35.
    assert (flight.launch.date, flight.launch.time_local) == ("06-30", "11:14")
    assert flight.launch.state_of_charge == 0.577
    landing_h = flight.launch.clock_h + flight.launch.duration_h
    assert landing_h == pytest.approx(24.0 + 15.0 + 35.0 / 60.0, abs=1.0 / 60.0)  # to the minute
    assert flight.dates.days() == [day_of_year("07-01")]
    longer = load_mission("rafz-81h")
    assert (longer.launch.date, longer.launch.duration_h) == ("07-14", 81.4)
