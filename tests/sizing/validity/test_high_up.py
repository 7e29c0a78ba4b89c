"""What is assumed high up is told, with its worth: warm battery, cold modules, error, record."""

import numpy as np
import pytest
from builders import AS2, DESIGN, mission
from builders import aircraft as shipped_aircraft
from weather_files import clear_record

import sizing
from sizing.aircraft import Aircraft
from sizing.results.analysis import analyse
from sizing.results.sizing import size
from studies.maps.study import feasibility_map
from studies.output.gridded import extrapolations_of

# Perpetual there on the longest day, by less than the assumptions are worth.
HIGH = mission(altitude_m=10000.0, dates={"on": "06-21"})
MODULES = ("altitude_m", "module_temperature")
BATTERY = ("altitude_m", "battery")
COLD_BATTERY = ("air_temperature_c", "battery")
ERROR = ("altitude_m", "model_error")
CORRECTION = ("altitude_m", "correction")
RECORD = ("height_above_record_m", "weather_record")
HIGH_UP = {MODULES, BATTERY, COLD_BATTERY, ERROR, CORRECTION, RECORD}


def notes(result):
    """Notes of a result on what is assumed high up."""
    extrapolations = result if isinstance(result, tuple) else result.extrapolations
    every = {(note.quantity, note.model): note for note in extrapolations}
    return {key: note for key, note in every.items() if key in HIGH_UP}


def test_the_worth_of_warm_modules_is_the_flight_with_cold_ones():
    note = notes(analyse(DESIGN, HIGH))[MODULES]
    cold = analyse(DESIGN, mission(**HIGH_WITH_COLD_MODULES))
    assert note.excess_time_h == pytest.approx(cold.excess_time_h, abs=1e-9)
    before = analyse(DESIGN, HIGH)
    assert before.excess_time_h < cold.excess_time_h
    by_range = f"excess time is {cold.excess_time_h:.2f} h instead of {before.excess_time_h:.2f} h"
    assert by_range in note.text
    assert "by a balance of heat at most" in note.text
    wh = [float(a.performance.cycle.energy_budget.solar_wh[0]) for a in (cold, before)]
    assert f"they would give {100 * (wh[0] / wh[1] - 1):.0f} % more solar energy" in note.text


# Standard air there, rounded: modules without a balance of heat.
HIGH_WITH_COLD_MODULES = {
    "altitude_m": 10000.0,
    "dates": {"on": "06-21"},
    "air": {"module_temperature_c": float(HIGH.air_state().temperature_c)},
}


@pytest.mark.parametrize("aircraft", [DESIGN, AS2], ids=["parametric", "measured"])
def test_the_worth_of_a_warm_battery_is_the_flight_with_an_unheated_one(aircraft):
    result = analyse(aircraft, HIGH)
    note = notes(result)[BATTERY]
    cold = shipped_aircraft(aircraft.name, "battery.temperature={}")
    unheated = analyse(cold, HIGH).excess_time_h
    assert unheated < result.excess_time_h
    assert note.excess_time_h == pytest.approx(unheated, abs=1e-9)
    assert f"excess time is {unheated:.2f} h instead of {result.excess_time_h:.2f} h" in note.text


def test_climbs_say_what_their_worth_is_of():
    climbing = mission(dates={"on": "06-21"}, climb={"ceiling_m": 10000.0})
    climbs = analyse(AS2, climbing)
    assert climbs.climb.altitude_m.max() == pytest.approx(10000.0)
    high = notes(analyse(AS2, mission(altitude_m=10000.0, dates={"on": "06-21"})))
    noted = notes(climbs)
    assert set(noted) == {MODULES, BATTERY, ERROR}
    for key in (MODULES, BATTERY):
        assert "excess time in level flight at 10000 m" in noted[key].text
        assert noted[key].excess_time_h == pytest.approx(high[key].excess_time_h, abs=1e-6)


def test_each_assumption_is_told_but_what_a_file_gives():
    noted = notes(analyse(DESIGN, HIGH))
    assert set(noted) == {MODULES, BATTERY, ERROR}
    assert noted[BATTERY].value == HIGH.altitude_m
    assert "assumed heated to 25 °C with" in noted[BATTERY].text
    assert "measured at 0.5 km" in noted[ERROR].text
    # The other models balance heat as well.
    path = {"kind": "circle", "radius_m": 500.0, "airspeed_m_per_s": 17.0}
    high = mission(altitude_m=10000.0, dates={"on": "06-21"}, flight_path=path)
    for options in ({"model": "FM"}, {"model": "VM"}, {"correction": "loiter"}):
        assert MODULES in notes(analyse(DESIGN, high, **options))
    warm = mission(**HIGH_WITH_COLD_MODULES)
    assert set(notes(analyse(DESIGN, warm))) == {BATTERY, ERROR}
    heated = shipped_aircraft(
        "atlantiksolar-design", "battery.temperature={held_c: 10, heat_loss_w_per_k: 0.1}"
    )
    assert set(notes(analyse(heated, HIGH))) == {MODULES, ERROR}


@pytest.mark.parametrize(
    ("altitude_m", "offset_k", "expected"),
    [
        (500.0, 0.0, set()),
        (2999.0, 0.0, set()),
        (3001.0, 0.0, {MODULES, BATTERY}),
        # Standard air of 11.8 C at 500 m.
        (500.0, -31.0, set()),
        (500.0, -33.0, {COLD_BATTERY}),
        (8999.0, 0.0, {MODULES, BATTERY}),
        (9001.0, 0.0, {MODULES, BATTERY, ERROR}),
    ],
)
def test_each_note_begins_where_its_range_ends(altitude_m, offset_k, expected):
    where = mission(altitude_m=altitude_m, air={"temperature_offset_k": offset_k})
    assert set(notes(analyse(DESIGN, where))) == expected


def test_a_sizing_tells_the_worth_of_its_own_design():
    study = size(DESIGN, HIGH, "max_excess_time")
    noted = notes(study)
    assert set(noted) == {MODULES, BATTERY, ERROR}
    data = study.sized_aircraft().model_dump()
    data["battery"]["temperature"] = {}
    cold = analyse(Aircraft.model_validate(data), HIGH).excess_time_h
    # The design's flow is known from three others, to 0.003 % of the sun.
    assert noted[BATTERY].excess_time_h == pytest.approx(cold, abs=1e-3)
    warm = analyse(study.sized_aircraft(), mission(**HIGH_WITH_COLD_MODULES))
    assert noted[MODULES].excess_time_h == pytest.approx(warm.excess_time_h, abs=1e-5)


def test_a_map_tells_the_worth_in_its_best_cell():
    data = feasibility_map(DESIGN, HIGH, latitudes=[35.0, 45.0], days=[80, 172])
    noted = notes(extrapolations_of(data))
    assert set(noted) == {MODULES, BATTERY, ERROR}
    at = np.unravel_index(int(np.argmax(data["excess_time"].to_numpy())), (2, 2))
    best = mission(
        altitude_m=10000.0,
        latitude_deg=[35.0, 45.0][at[0]],
        dates={"on": ["03-21", "06-21"][at[1]]},
    )
    cold = shipped_aircraft("atlantiksolar-design", "battery.temperature={}")
    unheated = analyse(cold, best).excess_time_h
    assert noted[BATTERY].excess_time_h == pytest.approx(unheated, abs=1e-9)
    assert f"at {best.latitudes()[0]:g}° N, 21 Jun" in noted[BATTERY].text
    dark = feasibility_map(DESIGN, HIGH, latitudes=[85.0], days=[355])
    assert set(notes(extrapolations_of(dark))) == {MODULES, BATTERY, ERROR}


@pytest.mark.parametrize(("height_m", "is_told"), [(1990.0, False), (2010.0, True)])
def test_a_record_far_below_the_flight_is_told(height_m, is_told):
    record = clear_record(3, first="2001-07-14")
    where = mission(latitude_deg=46.8, altitude_m=record.site.altitude_m + height_m)
    noted = notes(sizing.analyse_weather(AS2, where, record))
    assert (RECORD in noted) is is_told
    if is_told:
        assert noted[RECORD].value == pytest.approx(height_m)
        assert "% of the clear sky's light" in noted[RECORD].text


def test_the_error_of_the_sun_is_not_told_as_known_high_up():
    known, unknown = (
        str(analyse(DESIGN, mission(altitude_m=h, dates={"on": "06-21"}))) for h in (8999.0, 9001.0)
    )
    assert "the model's RMS error of 7 %" in " ".join(known.split())
    assert "its error at 9001 m is not known" in " ".join(unknown.split())


def test_a_record_tells_the_cold_of_its_days():
    cold = np.full(40 * 24, -30.0)
    record = clear_record(40, first="2001-07-14", share=0.75, temperature_c=cold)
    where = mission(latitude_deg=46.8, altitude_m=record.site.altitude_m + 3000.0)
    result = sizing.analyse_weather(AS2, where, record)
    noted = notes(result)
    assert set(noted) == {MODULES, BATTERY, RECORD}
    assert "as cold as the air they would give +" in noted[MODULES].text
    unheated = shipped_aircraft(AS2.name, "battery.temperature={}")
    closes = sizing.analyse_weather(unheated, where, record).to_dict()["days_that_close"]
    before = result.to_dict()["days_that_close"]
    assert closes < before
    assert f"unheated {closes} instead of {before} days close" in noted[BATTERY].text
