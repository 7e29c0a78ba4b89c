"""Logs as different loggers write them: each is the same flight, and what is guessed is told."""

import zipfile

import numpy as np
import pandas as pd
import pytest
from log_layouts import LAYOUTS, OWN_NAMES_MAP

from missions.files.errors import InputError
from missions.logs.clock import parse_span, parse_zone
from missions.logs.columns import (
    ColumnMap,
    column_name,
    parse_column,
    read_column_map,
    recipes_for,
)
from missions.logs.csv import read_flight_log
from missions.logs.table import log_from_table
from missions.logs.units import in_radians, recognised, surely_radians
from missions.units import SCALES, UNITS, known_unit

COUNT = 200
MINUTE = "2015-06-30T09:{:02d}:{:06.3f}Z"


def table():
    """A minute and forty seconds of circling, at 2 Hz."""
    elapsed = 0.5 * np.arange(COUNT)
    return pd.DataFrame(
        {
            "time_utc": [MINUTE.format(int(t // 60), t % 60) for t in elapsed],
            "latitude_deg": np.round(47.6 + 1e-4 * np.sin(elapsed), 7),
            "longitude_deg": np.round(8.53 + 1e-4 * np.cos(elapsed), 7),
            "altitude_m": np.round(536.0 + np.sin(0.1 * elapsed), 2),
            "roll_deg": np.round(8.0 + np.sin(elapsed), 3),
            "pitch_deg": np.round(np.cos(elapsed), 3),
            "yaw_deg": np.round((12.0 * elapsed + 180.0) % 360.0 - 180.0, 3),
            "solar_power_w": np.round(200.0 + 20.0 * np.sin(elapsed), 3),
            "ambient_temperature_c": 22.7,
            "mppt_voltage_v": np.round(20.0 + 0.1 * np.sin(elapsed), 3),
            "state_of_charge": np.round(0.5 + 1e-4 * elapsed, 4),
        }
    )


def layout_of(name, folder):
    if name == "spreadsheet":
        return ColumnMap(timezone="Europe/Zurich")
    if name == "own_names":
        (folder / "map.yaml").write_text(OWN_NAMES_MAP)
        return read_column_map(str(folder / "map.yaml"))
    return ColumnMap()


def read(folder, text, layout=None):
    (folder / "log.csv").write_text(text, encoding="utf-8")
    return read_flight_log(folder / "log.csv", layout)


def refused(folder, text, layout=None):
    with pytest.raises(InputError) as caught:
        read(folder, text, layout)
    return str(caught.value).replace(f"{folder}/", "")


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_layout_is_the_same_flight(tmp_path, name):
    expected = log_from_table(table(), "x")
    log = read(tmp_path, LAYOUTS[name](table()), layout_of(name, tmp_path))
    assert log.time_s == pytest.approx(expected.time_s, abs=1e-5)
    assert log.latitude_deg == pytest.approx(expected.latitude_deg, abs=1e-7)
    assert log.altitude_m == pytest.approx(expected.altitude_m, abs=1e-3)
    assert log.solar_power_w == pytest.approx(expected.solar_power_w, abs=1e-6)
    for angle, true in zip(log.attitude, expected.attitude, strict=True):
        # Written to a millionth of a radian in one of the layouts.
        assert np.angle(np.exp(1j * (angle - true))) == pytest.approx(0.0, abs=1e-6)
    if log.state_of_charge is not None:
        assert log.state_of_charge == pytest.approx(expected.state_of_charge)
    if log.ambient_temperature_c is not None:
        assert log.ambient_temperature_c == pytest.approx(22.7)


def test_what_is_guessed_is_told(tmp_path):
    notes = " ".join(read(tmp_path, LAYOUTS["telemetry"](table())).notes)
    for told in (
        "solar_power_w = V_pv * I_pv_mA [mA]",
        "gps_lat read as degE7",
        "gps_alt read as mm",
        "read as radians",
        "separated by tabs",
    ):
        assert told in notes
    plain = read(tmp_path, table().to_csv(index=False))
    assert plain.notes == ()


def test_radians_in_columns_called_degrees_are_recognised(tmp_path):
    lying = table()
    lying[["roll_deg", "pitch_deg", "yaw_deg"]] = np.radians(
        lying[["roll_deg", "pitch_deg", "yaw_deg"]]
    )
    log = read(tmp_path, lying.to_csv(index=False))
    assert np.degrees(log.attitude.roll_rad).max() == pytest.approx(9.0, abs=0.01)
    assert "read as radians" in log.notes[0]


def test_options_precede_the_file_and_guesses(tmp_path):
    text = table().rename(columns={"solar_power_w": "P_solar"}).assign(other=100.0)
    options = dict([parse_column("solar_power_w=other [mW]")])
    layout = ColumnMap(columns={"solar_power_w": "P_solar"}).with_options(options)
    log = read(tmp_path, text.to_csv(index=False), layout)
    assert log.solar_power_w == pytest.approx(0.1)


def test_times_from_the_start_need_the_start(tmp_path):
    text = table().drop(columns="time_utc").assign(t=0.5 * np.arange(COUNT)).to_csv(index=False)
    for name in ("t", "time_s", "time_utc_s", "t [ms]"):
        told = refused(tmp_path, text.replace("t\n", f"{name}\n", 1))
        assert f"log.csv:1: {name}: counts from the start of the log, not from 1970" in told
        assert "--start 2015-06-30T11:14:00+02:00" in told
    log = read(tmp_path, text, ColumnMap(start="2015-06-30T11:14:00+02:00"))
    assert log.time_s[0] == pytest.approx(1435655640.0)


def test_times_without_a_zone_need_one(tmp_path):
    bare = table().assign(time_utc=table()["time_utc"].str.rstrip("Z"))
    assert "log.csv:2: time_utc: has no time zone" in refused(tmp_path, bare.to_csv(index=False))
    log = read(tmp_path, bare.to_csv(index=False), ColumnMap(timezone="+02:00"))
    assert log.time_s[0] == pytest.approx(1435655640.0 - 840.0 - 7200.0)


def test_two_columns_of_time_are_one_too_many(tmp_path):
    seconds = 1435654800.0 + 0.5 * np.arange(COUNT)  # 2015-06-30T09:00:00Z
    both = table().assign(time_utc_s=seconds)
    told = refused(tmp_path, both.to_csv(index=False))
    assert "time_utc_s: give time_utc or time_utc_s, not both" in told
    log = read(tmp_path, both.drop(columns="time_utc").to_csv(index=False))
    assert log.time_s == pytest.approx(seconds)


def test_constants_stand_in_for_columns(tmp_path):
    text = table().drop(columns=["latitude_deg", "longitude_deg", "altitude_m"])
    place = {"latitude_deg": 47.6, "longitude_deg": 8.53, "altitude_m": 416.0}
    layout = ColumnMap.model_validate({"columns": {k: {"value": v} for k, v in place.items()}})
    log = read(tmp_path, text.to_csv(index=False), layout)
    assert log.altitude_m == pytest.approx(416.0)


def test_row_of_units(tmp_path):
    lines = table().rename(columns={"solar_power_w": "Psolar"}).to_csv(index=False).split("\n")
    units = "iso,deg,deg,m,deg,deg,deg,[mW],c,v,-"
    log = read(tmp_path, "\n".join([lines[0], units, *lines[1:]]))
    assert log.solar_power_w.max() < 1.0
    assert "units are those of the row below the header" in log.notes


IN_SUMS = "columns.load_w: in a sum or product the unit stands behind each column"


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ({"solar_power": "P"}, "columns.solar_power: unknown quantity; did you mean 'solar_power"),
        ({"solar_power_w": "P"}, "columns.solar_power_w: no such column"),
        ({"solar_power_w": "solar_power_w [lx]"}, "unknown unit 'lx'; allowed: W, watt"),
        ({"load_w": {"unit": "W"}}, "columns.load_w: needs the name of a column, or a value"),
        ({"load_w": {"name": "a", "value": 1.0}}, "give a name or a value, not both"),
        ({"load_w": "a * b * c"}, "a product is that of a voltage and a current"),
        ({"time": "solar_power_w * load"}, "columns.time: no such column"),
        ({"load_w": {"name": "solar_power_w + mppt_voltage_v", "unit": "W"}}, IN_SUMS),
        ({"load_w": {"name": "solar_power_w * mppt_voltage_v", "unit": "W"}}, IN_SUMS),
    ],
)
def test_wrong_maps_are_refused(tmp_path, columns, expected):
    layout = ColumnMap.model_validate({"columns": columns})
    assert expected in refused(tmp_path, table().to_csv(index=False), layout)


def test_mistakes_in_a_sum_name_the_sum(tmp_path):
    columns = {"load_w": "near [W] + far [W]"}
    text = table().assign(near=9e9, far=1.0).to_csv(index=False)
    log = read(tmp_path, text, ColumnMap.model_validate({"columns": columns}))
    assert log.load_w is None
    assert any(note.startswith("near + far: 200 values left out") for note in log.notes)


@pytest.mark.parametrize(
    ("parse", "texts", "message"),
    [
        (parse_column, ["solar_power_w", "solar_power_w="], "QUANTITY=COLUMN"),
        (parse_column, ["power=P"], "no such quantity"),
        (
            parse_zone,
            ["Europe", "../etc/passwd", "+25:00", "noon", "\0", "a" * 5000],
            "must be UTC",
        ),
        (parse_span, ["11:20", "11:20-25:00", "noon", "", "24:00-01:00"], "must be times like 11"),
        (parse_span, ["2015-13-01@11:20-11:45"], "must be times like 11:20-11:45"),
        (column_name, ["", "  ", "\n"], "must be the name of a column or quantity"),
    ],
)
def test_wrong_options_are_refused(parse, texts, message):
    for text in texts:
        with pytest.raises(ValueError, match=message):
            parse(text)


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("P_solar", "solar_power_w"), ("PvPower (kW)", "solar_power_w"), ("alt_msl", "altitude_m"),
        ("Battery_SoC", "state_of_charge"), ("psi", "yaw_deg"),
        ("OAT [K]", "ambient_temperature_c"), ("load / W", "load_w"), ("TimeUTC", "time"),
    ],
)  # fmt: skip
def test_names_are_known(name, quantity):
    others = ["roll", "pitch"] if quantity == "yaw_deg" else []
    assert recipes_for([name, *others]).by_quantity[quantity].columns == [name]


def test_a_course_alone_is_no_attitude(tmp_path):
    text = table().drop(columns=["roll_deg", "pitch_deg"]).rename(columns={"yaw_deg": "heading"})
    log = read(tmp_path, text.to_csv(index=False))
    assert log.attitude is None
    assert "columns not used: heading" in log.notes


@pytest.mark.parametrize(
    ("name", "inside", "outside"),
    [
        *[(f"{angle}_deg", s * 89.9, s * 90.2) for angle in ("latitude", "pitch") for s in (1, -1)],
        *[(f"{a}_deg", s * 179.9, s * 180.2) for a in ("longitude", "roll") for s in (1, -1)],
        ("state_of_charge", 1.0, 1.2),
        ("state_of_charge", 0.0, -0.2),
        # A load of less than nothing is what an offset of the sensor makes of none.
        ("load_w", -5.0, -2e6),
        ("battery_power_w", -300.0, -2e6),
        ("ambient_temperature_c", 56.7, 60.0),
    ],
)
def test_values_end_where_their_quantities_do(name, inside, outside):
    flight = table().assign(load_w=20.0, battery_power_w=50.0)
    rows = flight.assign(**{name: inside})
    assert log_from_table(rows, "x").left_out == ()
    rows.loc[7:8, name] = outside
    (omission,) = log_from_table(rows, "x").left_out
    assert (omission.column, omission.kind, omission.values) == (name, "outside", 2)


# By the definitions of their names.
@pytest.mark.parametrize(
    ("written", "units", "value"),
    [
        (1.0, "s deg m W V A C - W/m^2 m/s Pa", 1.0),
        (1000.0, "ms mm mW mV mA", 1.0),
        (0.001, "km kW kV", 1.0),
        (100.0, "cdeg cm cA %", 1.0),
        (1e6, "us µs", 1.0),
        (1e9, "ns", 1.0),
        (60.0, "min", 3600.0),
        (24.0, "h", 86400.0),
        (np.pi, "rad radians", 180.0),
        (1000.0 * np.pi, "mrad", 180.0),
        (1e7, "degE7 E7 1e-7deg", 1.0),
        (1.0, "ft feet", 12.0 * 0.0254),
        (0.0, "K kelvin", -273.15),
        (32.0, "F degF", 0.0),
        (212.0, "F degF", 100.0),
        (3600.0, "knots kt", 1852.0),
        (3.6, "km/h kmh**-1", 1.0),
        (1013.25, "hPa mbar", 101325.0),
        (3600.0, "Jm**-2 J/m^2", 1.0),
        (3.6, "MJ/m^2 MJ/hr", 1000.0),
        (9.80665, "m**2s**-2 m^2/s^2", 1.0),
    ],
)
def test_units_are_those_of_their_definitions(written, units, value):
    for text in units.split():
        scale = SCALES[known_unit(f"[{text}]", *UNITS)]
        assert scale.factor * written + scale.offset == pytest.approx(value, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("largest", "unit"), [(1.0, None), (1.5, None), (2.0, "%"), (105.0, "%"), (106.0, None)]
)
def test_per_cent_are_told_from_shares_by_their_size(largest, unit):
    assert recognised("state_of_charge", "share", np.array([0.4, largest, np.nan])) == unit


@pytest.mark.parametrize(("half_turn", "sure"), [(np.pi, True), (0.97 * np.pi, True), (2.9, False)])
def test_a_yaw_that_fills_a_turn_can_be_in_nothing_but_radians(half_turn, sure):
    level = np.full(400, 0.1)
    turns = np.linspace(0.0, 3.0, 400) % 1.0
    assert surely_radians(level, level, half_turn * (2.0 * turns - 1.0)) is sure
    # Without jumps by a turn it may be in degrees.
    to_and_fro = np.pi * np.sin(np.linspace(0.0, 20.0, 400))
    assert in_radians(level, level, to_and_fro)
    assert not surely_radians(level, level, to_and_fro)


# ---- texts as spreadsheets and loggers write them


def same_power(log):
    assert log.solar_power_w == pytest.approx(table()["solar_power_w"], abs=1e-6)
    assert log.time_s[0] == pytest.approx(1435654800.0)


def test_names_of_streams(tmp_path):
    names = {"roll_deg": "ATT.Roll", "pitch_deg": "ATT.Pitch", "yaw_deg": "ATT.Yaw"}
    places = {"latitude_deg": "GPS.Lat", "longitude_deg": "GPS.Lng", "altitude_m": "GPS.Alt"}
    text = table().rename(columns=names | places).to_csv(index=False)
    same_power(read(tmp_path, text))
    # A wrong value is named by its column in the file.
    wrong = table().assign(latitude_deg=95.0).rename(columns=places)
    assert "log.csv:2: GPS.Lat: must be from -90" in refused(tmp_path, wrong.to_csv(index=False))


@pytest.mark.parametrize(
    ("times", "zone", "message"),
    [
        # An hour that there is not; the 7th of January, or the first of July.
        ("2015-03-29 02:30:{:06.3f}", "Europe/Zurich", "does not exist, or comes twice"),
        ("07/01/2015 09:00:{:06.3f}", "UTC", "must be ISO 8601"),
    ],
)
def test_times_that_could_be_others_are_refused(tmp_path, times, zone, message):
    text = table().assign(time_utc=[times.format(i / 10) for i in range(COUNT)])
    assert message in refused(tmp_path, text.to_csv(index=False), ColumnMap(timezone=zone))


@pytest.mark.parametrize(
    ("encoding", "guessed"),
    [("utf-8-sig", False), ("utf-16", False), ("cp1252", True), ("latin-1", True)],
)
def test_encodings_of_spreadsheets(tmp_path, encoding, guessed):
    text = table().rename(columns={"ambient_temperature_c": "T_amb [°C]"}).to_csv(index=False)
    (tmp_path / "log.csv").write_bytes(text.encode(encoding))
    log = read_flight_log(tmp_path / "log.csv")
    same_power(log)
    assert log.ambient_temperature_c == pytest.approx(22.7)
    assert any("code page 1252" in note for note in log.notes) is guessed


def test_first_line_that_names_the_separator(tmp_path):
    short = table()[["time_utc", "latitude_deg", "longitude_deg", "altitude_m", "solar_power_w"]]
    for sign in "|!":
        same_power(read(tmp_path, f"sep={sign}\n" + short.to_csv(index=False, sep=sign)))
    told = refused(
        tmp_path, "sep=;\n" + short.assign(solar_power_w="x").to_csv(index=False, sep=";")
    )
    assert told.startswith("log.csv:3: solar_power_w")  # lines are those of the file


def test_excel_sheet(tmp_path):
    pytest.importorskip("python_calamine")
    sheet = table()
    sheet["time_utc"] = pd.to_datetime(sheet["time_utc"]).dt.tz_localize(None)
    sheet.to_excel(tmp_path / "log.xlsx", index=False)
    log = read_flight_log(tmp_path / "log.xlsx", ColumnMap(timezone="UTC"))
    assert log.solar_power_w == pytest.approx(table()["solar_power_w"], abs=1e-6)
    # Excel keeps times to about a millisecond.
    assert log.time_s == pytest.approx(1435654800.0 + 0.5 * np.arange(COUNT), abs=2e-3)
    assert "the first sheet is read" in log.notes
    (tmp_path / "no.xlsx").write_bytes(b"no sheet")
    with pytest.raises(InputError, match="is not an Excel file"):
        read_flight_log(tmp_path / "no.xlsx")
    # Two cells, between which the reader would lay out 17 thousand million.
    cells = '<row r="1"><c r="A1"/></row><row r="1048576"><c r="XFD1048576"/></row>'
    with zipfile.ZipFile(tmp_path / "far.xlsx", "w") as book:
        book.writestr("xl/worksheets/sheet1.xml", f"<worksheet>{cells}</worksheet>")
    with pytest.raises(InputError, match="up to row 1048576 and column 16384, 17,179,869,184 in"):
        read_flight_log(tmp_path / "far.xlsx")


@pytest.mark.parametrize(
    ("form", "note"),
    [
        ("%Y-%m-%d %I:%M:%S.%f %p", None),
        ("%m/%d/%Y %I:%M:%S.%f %p", "month/day/year"),
        ("%m/%d/%Y %H:%M:%S.%f", "month/day/year"),  # the 30th
        ("%d/%m/%Y %H:%M:%S.%f", "day/month/year"),
    ],
)
def test_american_and_british_times(tmp_path, form, note):
    evening = pd.to_datetime(table()["time_utc"]) + pd.Timedelta(hours=12)
    text = table().assign(time_utc=evening.dt.strftime(form)).to_csv(index=False)
    log = read(tmp_path, text, ColumnMap(timezone="UTC"))
    assert log.time_s == pytest.approx(1435698000.0 + 0.5 * np.arange(COUNT), abs=1e-5)
    assert (f"dates are read as {note}" in log.notes) is (note is not None)


@pytest.mark.parametrize(
    ("sign", "decimal", "separator"),
    [(",", ".", ","), (",", ".", ";"), (".", ",", ";"), ("'", ".", ";"), (" ", ",", "\t")],
)
def test_signs_between_thousands(tmp_path, sign, decimal, separator):
    large = table().drop(columns="mppt_voltage_v")
    large["solar_power_w"] *= 10.0

    def written(value):
        text = f"{value:,.3f}".replace(".", "#").replace(",", sign)
        return text.replace("#", decimal)

    numbers = large.drop(columns="time_utc").map(written)
    text = large[["time_utc"]].join(numbers).to_csv(index=False, sep=separator)
    log = read(tmp_path, text)
    assert log.solar_power_w == pytest.approx(10.0 * table()["solar_power_w"], abs=1e-3)
    assert f"numbers have {sign!r} between thousands" in log.notes


def test_numbers_with_three_decimals_are_no_thousands(tmp_path):
    text = table().to_csv(index=False, sep=";", float_format="%.3f")
    assert not any("thousands" in note for note in read(tmp_path, text).notes)


def test_a_last_line_that_is_cut_off_is_left_out(tmp_path):
    text = table().to_csv(index=False).rstrip("\n")
    log = read(tmp_path, text[: text.rindex(",") - 12])
    assert len(log) == COUNT - 1
    assert any(n.startswith(f"1 line is left out: line {COUNT + 1} has") for n in log.notes)


def test_columns_written_at_their_own_times(tmp_path):
    whole = table()
    groups = [["latitude_deg", "longitude_deg", "altitude_m"], ["roll_deg", "pitch_deg", "yaw_deg"]]
    parts = [whole[["time_utc", "solar_power_w"]]]
    for number, names in enumerate(groups):
        part = whole[["time_utc", *names]].copy()
        shift = pd.Timedelta(milliseconds=100 * (number + 1))
        times = pd.to_datetime(part["time_utc"]) + shift
        part["time_utc"] = times.dt.strftime("%Y-%m-%dT%H:%M:%S.%fZ")
        parts.append(part)
    text = pd.concat(parts).sort_values("time_utc").to_csv(index=False)
    log = read(tmp_path, text)
    same_power(log)
    # The nearest angle was logged 0.2 s later.
    assert np.degrees(log.attitude.roll_rad) == pytest.approx(whole["roll_deg"], abs=1e-9)
    assert any(note.startswith("columns are written at times of their own") for note in log.notes)
    # Positions that are too far away stand for nothing.
    late = whole.assign(latitude_deg=np.where(np.arange(COUNT) == 0, 47.6, np.nan))
    assert "lack a required value" in refused(tmp_path, late.to_csv(index=False))


@pytest.mark.parametrize("name", ["mppt{}_power_w", "MPPT {} power [W]", "P_mppt_{} [W]"])
def test_power_of_several_mppts_is_summed(tmp_path, name):
    power = table()["solar_power_w"]
    several = table().drop(columns="solar_power_w")
    for number, share in enumerate((0.5, 0.3, 0.2), start=1):
        several[name.format(number)] = share * power
    log = read(tmp_path, several.to_csv(index=False))
    assert log.solar_power_w == pytest.approx(power)
    assert " + ".join(name.format(i).split(" [")[0] for i in (1, 2)) in log.notes[0].replace(
        " [W]", ""
    )
