"""Values that cannot be are found where they are, and nothing is found in logs of clean sensors."""

import datetime
from functools import cache
from zoneinfo import ZoneInfo

import numpy as np
import pandas as pd
import pytest
from synthetic_logs import Settings, synthetic_log

from benchmarks.independent_logs import TRUTHS, TUNING, made
from missions.files.errors import InputError
from missions.library import load_mission
from missions.logs.clock import parse_span
from missions.logs.columns import ColumnMap
from missions.logs.csv import read_flight_log
from missions.logs.plausible import codes
from missions.logs.table import log_from_table
from sizing.library import load_aircraft


@cache
def flown():
    """A day of an independent simulation, every 4 s."""
    return made(load_aircraft("atlantiksolar-as2"), TRUTHS[3], TUNING[0] + 3).rows


def found(table):
    left = log_from_table(table, "x").left_out
    return [(omission.column, omission.kind, omission.values) for omission in left]


def with_values(column, rows, value):
    table = flown().copy()
    table.loc[rows, column] = value
    return table


@pytest.mark.parametrize(
    ("column", "rows", "value", "kind"),
    [
        ("solar_power_w", range(100, 900, 7), 9999.0, "code"),
        ("solar_power_w", range(100, 900), -999.0, "code"),
        ("solar_power_w", range(100, 900), 65.535, "code"),  # an integer of mW, far from others
        ("altitude_m", range(50), 9999.0, "code"),
        ("state_of_charge", range(50), -0.01, "code"),  # MAVLink: not estimated
        ("solar_power_w", range(100, 900, 70), 2345.6, "spike"),
        ("ambient_temperature_c", range(100, 200), 60.0, "outside"),
        ("latitude_deg", range(9), 91.0, "outside"),
        ("solar_power_w", range(1000, 1100), 77.7, "frozen"),
        ("yaw_deg", range(1000, 1100), 77.7, "frozen"),
        ("load_w", range(1000, 1100), 41.7, "frozen"),
    ],
)
def test_values_that_cannot_be_are_left_out(column, rows, value, kind):
    table = with_values(column, rows, value)
    if value == 65.535:  # far from others only by day
        table = table[table["solar_power_w"] > 150.0].reset_index(drop=True)
        table.loc[rows, column] = value
    assert found(table) == [(column, kind, len(rows))]
    (omission,) = log_from_table(table, "x").left_out
    assert omission.periods[0][0] == pytest.approx(table["time_utc_s"][rows[0]], abs=1e-3)
    assert omission.periods[-1][1] == pytest.approx(table["time_utc_s"][rows[-1]], abs=1e-3)


def test_a_code_among_other_values_is_a_value():
    power = np.linspace(0.0, 1200.0, 400)
    power[200:210] = 999.0
    assert not codes("power", power).any()
    assert not codes("power", np.full(20, 999.0)).any()
    assert codes("power", np.append(np.linspace(0.0, 300.0, 400), 999.0)).sum() == 1


def test_rows_of_a_receiver_before_its_first_fix_and_before_its_clock_was_set():
    place, clock = flown().copy(), flown().copy()
    place.loc[:49, ["latitude_deg", "longitude_deg"]] = 0.0
    assert found(place) == [("latitude_deg", "code", 50), ("longitude_deg", "code", 50)]
    clock.loc[:29, "time_utc_s"] = 315964800.0 + np.arange(30)  # 1980-01-06, where GPS begins
    assert found(clock) == [("time_utc_s", "outside", 30)]


def test_a_sensor_at_its_highest_value_for_minutes():
    table = tables()["own"].copy()
    highest = float(table["solar_power_w"].quantile(0.8))
    table["solar_power_w"] = table["solar_power_w"].clip(upper=highest)
    ((column, kind, count),) = found(table)
    assert (column, kind) == ("solar_power_w", "saturated")
    assert count <= (table["solar_power_w"] == highest).sum()


def test_rows_that_are_written_twice():
    table = flown().copy()
    content = table.columns[1:]
    table.loc[1000:1199, content] = table.loc[500:699, content].to_numpy()
    assert found(table) == [("", "repeated", 200)]
    note = next(n for n in log_from_table(table, "x").notes if "copies" in n)
    assert note.startswith("200 rows left out, copies of earlier rows, 2024-")


def constant(table):
    """A battery full for hours, altitude held to the metre, constant load and temperature."""
    charge = np.minimum(1.3 * table["state_of_charge"], 1.0)
    power = table["solar_power_w"].clip(lower=0.0)
    return table.assign(
        solar_power_w=power,
        state_of_charge=charge,
        altitude_m=600.0,
        load_w=43.0,
        ambient_temperature_c=22.0,
    )


def rounded(decimals):
    def change(table):
        places = {"latitude_deg": 3 + decimals, "longitude_deg": 3 + decimals}
        places |= {"state_of_charge": 2, "time_utc_s": 3}
        names = table.select_dtypes("number").columns
        return table.assign(**{n: table[n].round(places.get(n, decimals)) for n in names})

    return change


CHANGES = {
    "as it is": lambda table: table,
    "constant": constant,
    "whole numbers": rounded(0),
    "tenths": rounded(1),
}


@cache
def tables():
    aircraft, mission = load_aircraft("atlantiksolar-as2"), load_mission("rafz-28h")
    calm = Settings(rate_hz=0.25, jitter_deg=0.0, attitude_error_deg=0.0, power_noise_w=0.0)
    independent = {
        f"independent {n}": made(aircraft, TRUTHS[n], TUNING[0] + n).rows for n in (0, 15)
    }
    return independent | {
        "own": synthetic_log(aircraft, mission, Settings(rate_hz=0.25)),
        "own, calm": synthetic_log(aircraft, mission, calm),
        "own, with a night": synthetic_log(
            aircraft, mission, Settings(duration_h=28.35, rate_hz=1 / 30)
        ),
    }


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize(
    "name", ["independent 0", "independent 15", "own", "own, calm", "own, with a night"]
)
def test_nothing_is_found_in_logs_of_clean_sensors(name, change):
    assert found(CHANGES[change](tables()[name])) == []


def test_a_loss_of_power_is_no_frozen_sensor():
    assert found(with_values("solar_power_w", range(1000, 1400), 0.0)) == []


def test_spans_are_by_the_clock_of_their_zone():
    zone = ZoneInfo("Europe/Zurich")
    noon = datetime.datetime(2015, 7, 1, 12, tzinfo=zone).timestamp()
    hours = noon + 3600.0 * np.arange(-24.0, 25.0, 6.0)  # noon, 18, 0, 6 ... to noon
    assert parse_span("11:20-12:45").holds(hours, zone).tolist() == [
        *([True, False, False, False] * 2),
        True,
    ]
    assert parse_span("2015-07-01@9:20-11:45:30").holds(hours, datetime.UTC).sum() == 1
    over_midnight = parse_span("2015-06-30@23:00-06:30").holds(hours, zone)
    assert np.flatnonzero(over_midnight).tolist() == [2, 3]


def read(folder, table, **layout):
    table.to_csv(folder / "log.csv", index=False)
    return read_flight_log(folder / "log.csv", ColumnMap.model_validate(layout))


def test_times_and_columns_are_left_out_by_hand(tmp_path):
    start = pd.to_datetime(flown()["time_utc_s"][0], unit="s").ceil("h")
    span = f"{start:%H:%M}-{start + pd.Timedelta(minutes=30):%H:%M}"
    log = read(tmp_path, flown(), exclude=[span, "2001-01-01@10:00-11:00"])
    assert [(o.kind, o.values) for o in log.left_out] == [("excluded", 450), ("excluded", 0)]
    assert (len(log), log.rows_dropped) == (len(flown()) - 450, 0)
    log = read(tmp_path, flown().assign(x="?", load_w="?"), ignore=["x", "load_w", "yaw_deg"])
    assert (log.load_w, log.attitude, log.left_out) == (None, None, ())
    with pytest.raises(InputError, match="solar_power_w: required column is missing"):
        read(tmp_path, flown(), ignore=["solar_power_w"])
    log = read(tmp_path, flown(), ignore=["lod_w"])
    assert "nothing is called lod_w, to ignore it; did you mean 'load_w'?" in log.notes
    # A date that is nobody's: with it the times of day would be no times.
    log = read(tmp_path, flown().assign(date="?"), ignore=["date"])
    assert len(log) == len(flown())


def test_a_day_that_is_left_out_ends_at_midnight():
    hours = 3600.0 * np.arange(48.0)
    day = parse_span("00:00-24:00").holds(hours, datetime.UTC)
    assert day.all()
    half = parse_span("1970-01-02@12:00-24:00").holds(hours, datetime.UTC)
    assert np.flatnonzero(half).tolist() == list(range(36, 48))
    night = parse_span("22:00-02:00").holds(hours, datetime.UTC)
    assert set((np.flatnonzero(night) % 24).tolist()) == {22, 23, 0, 1, 2}


def test_power_of_an_mppt_that_cannot_be_leaves_its_row_out(tmp_path):
    rows = flown().head(300)
    power = rows.pop("solar_power_w")
    rows = rows.assign(P_solar_left=0.25 * power, P_solar_right=0.75 * power)
    rows.loc[20, "P_solar_right"] = 9999.0
    log = read(tmp_path, rows)
    assert list(log.mppt_power_w) == ["P_solar_left", "P_solar_right"]
    assert len(log) == 299
    assert sum(log.mppt_power_w.values()) == pytest.approx(log.solar_power_w)
    assert [(o.column, o.kind, o.values) for o in log.left_out] == [("P_solar_right", "code", 1)]


def test_columns_that_nobody_needs_make_no_log_unreadable(tmp_path):
    text = flown().head(50).assign(a="#REF!", b="").to_csv(index=False)
    text = text.replace(",a,b\n", ",a b,a b\n", 1)
    (tmp_path / "log.csv").write_text(text)
    log = read_flight_log(tmp_path / "log.csv")
    assert log.notes == ("columns not used: a b, a b",)
    log = read(tmp_path, flown().rename(columns={"load_w": "laod_w"}))
    assert "columns not used: laod_w (did you mean 'load_w'?)" in log.notes
