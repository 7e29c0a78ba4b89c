"""The explorer without its server: settings, day, season, files; equal to the command line's."""

import math

import numpy as np
import pytest
from map_blocks import map_block
from numpy.testing import assert_allclose

from missions.files.overrides import with_overrides
from missions.files.shipped import find_document, shipped_text
from missions.files.validation import validate
from missions.library import load_mission
from missions.mission import Mission, Scenarios
from sizing.day.light import SolarModel
from sizing.library import load_aircraft
from sizing.parameters import catalogue
from sizing.results.analysis import analyse
from studies.case import Case, Loaded
from studies.cli.files import opened
from studies.explorer.fields import DAY, LATITUDE, Field
from studies.explorer.session import COARSE_STEP_H, DAYS, LATITUDES_DEG, Session
from studies.explorer.settings import RefusedError

MOVED = {
    LATITUDE: 52.5,
    DAY: 130,
    "airframe.wingspan_m": 6.1,
    "battery.mass_kg": 3.25,
    "modules.area_m2": 1.5,
    "mission.payload.mass_kg": 0.2,
    "mission.payload.power_w": 1.5,
    "mission.clearness": 0.93,
    "modules.efficiency_stc": 0.22,
    "battery.specific_energy_wh_per_kg": 240.0,
}


def session(aircraft="atlantiksolar-design", mission="rafz-july"):
    return Session(Case(opened("aircraft", aircraft), opened("mission", mission)))


DESIGN = session()


@pytest.mark.parametrize(
    ("aircraft", "mission", "changed"),
    [
        ("atlantiksolar-design", "rafz-july", MOVED),
        ("atlantiksolar-design", "central-europe-summer", {}),
        ("atlantiksolar-design", "rafz-81h", {"battery.mass_kg": 2.5}),
        ("atlantiksolar-as2", "rafz-81h", {"battery.mass_kg": 2.5, "correction": "report"}),
        ("atlantiksolar-as2", "rafz-july", {LATITUDE: -33.0, DAY: 2, "model": "FM"}),
    ],
)
def test_saved_files_give_the_same_numbers(tmp_path, aircraft, mission, changed):
    one = session(aircraft, mission)
    settings = one.settings(changed)
    for kind, text in one.files(settings).items():
        (tmp_path / f"{kind}.yaml").write_text(text, encoding="utf-8")
    loaded = analyse(
        load_aircraft(tmp_path / "aircraft.yaml"),
        load_mission(tmp_path / "mission.yaml"),
        model=settings.solar.model,
        correction=settings.solar.correction,
        replay=False,
    ).to_dict()
    loaded.pop("scenarios")
    assert one.day(settings)["numbers"] == loaded


def test_command_of_saved_files_names_them_and_the_model():
    saved = DESIGN.saved(DESIGN.settings({"model": "CDM"}))
    assert saved["command"] == (
        "solar-uav analyse atlantiksolar-design-explored.yaml "
        "--mission atlantiksolar-design-explored-mission.yaml --model CDM --correction none"
    )
    assert [file["name"] for file in saved["files"]] == saved["command"].split()[2:5:2]


def test_page_begins_at_the_worst_scenario():
    several = session(mission="central-europe-summer")
    assert len(several.scenarios) == 9
    start = several.settings()
    worst = analyse(several.aircraft, several.mission).to_dict()
    assert start.values[LATITUDE] == worst["latitude_deg"]
    assert start.values[DAY] == worst["day_of_year"]


def test_curve_is_that_of_the_analysis():
    settings = DESIGN.settings(MOVED)
    curve = DESIGN.day(settings)["curve"]
    table = DESIGN.analysis(settings).trajectory()
    # Five digits are sent.
    assert_allclose(curve["time_h"], table["time_solar_h"], rtol=5e-5)
    for key in ("solar_power_w", "load_w", "state_of_charge"):
        assert_allclose(curve[key], table[key], rtol=5e-5)


def test_limited_flight_is_shown_from_its_launch_until_it_is_empty():
    settings = DESIGN.settings({"mission.latitude_deg": 60.0, "mission.day_of_year": 300})
    view = DESIGN.day(settings)
    flight = view["numbers"]["limited_flight"]
    charge, time_h = view["curve"]["flight_charge"], view["curve"]["time_h"]
    assert flight["endurance_h"] < 24.0
    flown = [hour for hour, c in zip(time_h, charge, strict=True) if c is not None]
    step_h = time_h[1]
    assert len(flown) * step_h == pytest.approx(flight["endurance_h"], abs=2 * step_h)
    assert max(c for c in charge if c is not None) == pytest.approx(1.0, abs=0.01)
    assert set(DESIGN.day(DESIGN.settings())["curve"]["flight_charge"]) == {None}
    for one in (DESIGN, session("atlantiksolar-as2")):
        view = one.day(one.settings({"mission.payload.mass_kg": 0.3}))
        total = sum(view["masses_kg"].values())
        assert total == pytest.approx(view["numbers"]["total_mass_kg"], rel=1e-6)


def test_wind_above_the_airspeed_is_told_and_leaves_the_light_of_cam():
    one = session()
    calm = one.season(one.settings(), coarse=True)
    settings = one.settings({"mission.wind_m_per_s": 20.0})
    assert one.day(settings)["notes"][0] == "airspeed 8.5 m/s is below the wind of 20 m/s"
    assert one.season(settings, coarse=True) == calm
    assert one._light.cache_info().currsize == 1


def test_a_held_place_is_mapped_where_the_wind_is_known():
    """The shipped winds end at 88 degrees; below the design's airspeed they change nothing."""
    aloft = {"altitude_m": 20000.0, "wind": {"percentile": 95.0}, "air": {}}
    file = opened("mission", "rafz-july").changed(aloft)
    held = file.changed({"wind": {"percentile": 95.0, "hold_station": True}})
    plane = opened("aircraft", "stratosphere-design")
    maps = []
    for document in (file, held):
        one = Session(Case(plane, document))
        maps.append(one.season(one.settings(), coarse=True))
        if document is held:
            winter = one.settings({"mission.day_of_year": 15})
            assert "is raised to the wind of" in one.day(winter)["notes"][0]
    free, there = (one["excess_time_h"] for one in maps)
    assert there[0] is None
    assert there[-1] is None
    assert all(one["complete"] for one in maps)
    pairs = [
        (a, b)
        for one, other in zip(free[1:-1], there[1:-1], strict=True)
        for a, b in zip(one, other, strict=True)
        if a is not None and b is not None
    ]
    assert all(b <= a for a, b in pairs)
    assert 0 < sum(a == b for a, b in pairs) < len(pairs)


def test_season_is_the_map_of_the_command_line():
    settings = DESIGN.settings({"battery.mass_kg": 3.1})
    made = DESIGN.inputs(settings)
    exact = DESIGN.season(settings)
    cells = map_block(made.aircraft, made.mission, LATITUDES_DEG, DAYS, made.solar)["excess_time"]
    shown = as_array(exact)
    # Three decimals are sent.
    assert_allclose(shown, cells, rtol=0.0, atol=5.1e-4)
    coarse = DESIGN.season(settings, coarse=True)
    assert coarse["step_h"] == COARSE_STEP_H
    assert (coarse["latitudes_deg"], coarse["days"]) == (
        LATITUDES_DEG[::2].tolist(),
        DAYS[::2].tolist(),
    )
    cells = cells[::2, ::2]
    finite = np.isfinite(cells)
    assert np.array_equal(np.isfinite(as_array(coarse)), finite)
    # What docs/explorer.md says of the coarse map.
    error = np.abs(as_array(coarse)[finite] - cells[finite])
    assert np.quantile(error, 0.99) < 0.05
    assert error.max() < 0.15


def as_array(season):
    rows = season["excess_time_h"]
    return np.array([[math.inf if value is None else value for value in row] for row in rows])


def test_kept_light_is_that_of_the_technology_at_hand():
    one = session()
    first = one.season(one.settings(), coarse=True)
    better = one.season(one.settings({"modules.efficiency_stc": 0.26}), coarse=True)
    again = one.season(one.settings(), coarse=True)
    assert first == again != better
    assert better == session().season(one.settings({"modules.efficiency_stc": 0.26}), coarse=True)


@pytest.mark.long
def test_slow_model_fills_its_map_turn_by_turn():
    one = session("atlantiksolar-as2")
    settings = one.settings({"model": "VM"})
    known = []
    for _ in range(60):
        found = one.season(settings)
        known.append(sum(row is not None for row in found["excess_time_h"]))
        if found["complete"]:
            break
    assert found["complete"]
    assert known[0] >= 1
    assert known == sorted(known)
    row = int(np.flatnonzero(np.array(found["latitudes_deg"]) == 45.0)[0])
    days = np.array(found["days"])
    made = one.inputs(settings)
    from sizing.day.light import solar_day
    from sizing.performance import performance

    lit = solar_day(
        *(made.aircraft, made.mission, SolarModel("VM")),
        scenarios=Scenarios(np.full(len(days), 45.0), days),
        step_h=COARSE_STEP_H,
    )
    alone = performance(made.aircraft, made.mission, made.solar, day=lit).cycle.excess_time_h
    assert_allclose(found["excess_time_h"][row], alone, atol=5.1e-4)


def refusals(data, one=DESIGN):
    with pytest.raises(RefusedError) as caught:
        one.day(one.settings(data))
    return {refusal.field: refusal for refusal in caught.value.refusals}


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("battery.mass_kg", math.nan, "out of range"),
        ("battery.mass_kg", math.inf, "out of range"),
        ("battery.mass_kg", -1.0, "out of range"),
        ("battery.mass_kg", 1e300, "out of range"),
        ("battery.mass_kg", 10**400, "out of range"),
        ("battery.mass_kg", "3", "must be a number"),
        ("battery.mass_kg", True, "must be a number"),
        ("battery.mass_kg", None, "must be a number"),
        ("battery.mass_kg", [3.0], "must be a number"),
        *[(DAY, day, "out of range") for day in (0, 366, 10**400, -(10**400))],
        *[(DAY, day, "must be a") for day in (True, "196", [196])],
        (DAY, 196.5, "whole number"),
        (LATITUDE, 90.5, "out of range"),
        ("model", "cam", "not one of the names"),
        ("correction", ["none"], "not one of the names"),
        ("name", "x", "not a field"),
        ("airframe.kind", "measured", "not a field"),
    ],
)
def test_bad_field_is_refused_in_words(key, value, words):
    refused = refusals({key: value})[key]
    assert words in refused.message
    assert refused.allowed


def test_everything_that_is_wrong_is_told_together(tmp_path):
    wrong = {"battery.mass_kg": "x", "model": 1, "unknown": 2}
    assert set(refusals(wrong)) == set(wrong)
    assert "object" in refusals([1, 2])["settings"].message
    assert "wing area" in refusals({"modules.area_m2": 5.0})["modules.area_m2"].message
    plain = session("sky-sailor")
    for key, value in (("model", "FM"), ("correction", "loiter")):
        assert "module surfaces" in refusals({key: value}, plain)[key].message
    text = shipped_text("atlantiksolar-design").replace("calibration: 1.188", "calibration: 5")
    (tmp_path / "heavy.yaml").write_text(text, encoding="utf-8")
    heavy = session(str(tmp_path / "heavy.yaml"))
    wide = {"airframe.wingspan_m": 40.0, "mission.payload.mass_kg": 50.0}
    with pytest.raises(RefusedError) as caught:
        heavy.day(heavy.settings(wide | {"airframe.aspect_ratio": 40.0}))
    assert caught.value.kind == "impossible"


def test_measured_airframe_keeps_its_wing():
    built = session("atlantiksolar-as2")
    key = "airframe.wingspan_m"
    assert "measured" in built.fields[key].fixed
    assert "measured" in refusals({key: 5.0}, built)[key].message
    assert built.settings({key: 5.65}).values[key] == 5.65
    assert "cannot be sized" in built.describe()["cannot_size"]


def test_fields_are_those_of_the_catalogue():
    for key, field in DESIGN.fields.items():
        if isinstance(field, Field) and key not in (LATITUDE, DAY):
            assert key in catalogue()
            assert field.minimum <= field.slider[0] <= field.value <= field.slider[1]
            assert field.slider[1] <= field.maximum


def climbing(**changes):
    climb = {"ceiling_m": 3536.0} | changes.pop("climb", {})
    document = find_document("mission", "rafz-july")
    values = {"launch": None, "climb": climb} | changes
    if "minimum_altitude_m" in climb:
        del document.data["altitude_m"]
    document = with_overrides(document, values)
    mission = Loaded(validate(document, Mission), document)
    return Session(Case(opened("aircraft", "atlantiksolar-as2"), mission))


def test_day_with_climbs_has_its_altitude_and_its_limits_as_fields():
    one = climbing()
    view = one.day(one.settings({"mission.climb.ceiling_m": 2000.0, "mission.altitude_m": 600.0}))
    altitude_m = view["curve"]["altitude_m"]
    assert len(altitude_m) == len(view["curve"]["time_h"])
    assert max(altitude_m) == pytest.approx(2000.0, abs=1.0)
    assert min(altitude_m) == 600.0
    assert view["numbers"]["climb"]["ceiling_m"] == 2000.0
    assert one.describe()["mission"]["climbs"]
    assert "altitude_m" not in DESIGN.day(DESIGN.settings())["curve"]
    assert "mission.climb.ceiling_m" not in DESIGN.fields


def test_floor_that_a_file_names_moves_with_its_slider():
    one = climbing(climb={"minimum_altitude_m": 536.0})
    settings = one.settings({"mission.altitude_m": 1500.0})
    assert one.inputs(settings).mission.altitude_m == 1500.0
    assert "minimum_altitude_m: 1500" in one.files(settings)["mission"]
    with pytest.raises(RefusedError) as caught:
        one.inputs(one.settings({"mission.altitude_m": 4000.0}))
    assert caught.value.refusals[0].field == "mission.altitude_m"
