"""Reading flight logs: values, and what is said about mistakes."""

import contextlib
import io
import struct
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from ulog_files import EPOCH_S, EULER_DEG, topics, ulog_bytes

from missions.files.errors import InputError
from missions.logs.csv import read_flight_log

HEADER = (
    "time_utc,latitude_deg,longitude_deg,altitude_m,roll_deg,pitch_deg,yaw_deg,solar_power_w,"
    "state_of_charge"
)


def row(second, **changes):
    time = f"2015-07-01T05:30:{second:06.3f}Z"
    values = (time, "47.6", "8.53", "536", "10", "2", "270", "100.5", "0.5")
    return ",".join((dict(zip(HEADER.split(","), values, strict=True)) | changes).values())


ROWS = tuple(row(0.5 * i) for i in range(10))


def read(tmp_path, lines, header=HEADER):
    file = tmp_path / "log.csv"
    file.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
    return read_flight_log(file)


def messages(tmp_path, lines, header=HEADER):
    with pytest.raises(InputError) as caught:
        read(tmp_path, lines, header)
    return [str(p).replace(f"{tmp_path}/", "") for p in caught.value.problems]


def test_values_are_read_and_angles_converted(tmp_path):
    log = read(tmp_path, ROWS)
    assert log.time_s == pytest.approx(EPOCH_S + 0.5 * np.arange(10), abs=1e-6)
    assert log.attitude.yaw_rad == pytest.approx(1.5 * np.pi)
    assert log.solar_power_w == pytest.approx(100.5)
    assert log.state_of_charge == pytest.approx(0.5)
    assert log.load_w is None
    assert log.step_s == pytest.approx(0.5)
    assert (log.gaps, log.notes, log.rows_dropped) == ((), (), 0)


@pytest.mark.parametrize(
    "text", ["2015-07-01T07:30:00+02:00", "2015-07-01 05:30:00Z", "2015-07-01T05:30:00.000+0000"]
)
def test_any_time_zone_is_converted_to_utc(tmp_path, text):
    log = read(tmp_path, [row(0, time_utc=text), *ROWS[1:]])
    assert log.time_s[0] == pytest.approx(EPOCH_S)


def test_byte_order_mark_blank_lines_and_windows_line_ends_are_harmless(tmp_path):
    file = tmp_path / "log.csv"
    file.write_bytes(b"\xef\xbb\xbf" + "\r\n".join([HEADER, "", *ROWS, "", ""]).encode())
    assert len(read_flight_log(file)) == 10


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"time_utc": "2015-07-01T05:30:00"}, "time_utc: has no time zone"),
        ({"time_utc": "2015-07-01"}, "time_utc: has no time zone"),
        ({"time_utc": "noon"}, "time_utc: must be ISO 8601"),
        ({"time_utc": "1815-07-01T05:30:00Z"}, "time_utc: must be from 1950 to 2049"),
        ({"roll_deg": "left"}, "roll_deg: must be a number (got 'left')"),
        ({"roll_deg": "inf"}, "roll_deg: must be finite"),
        ({"roll_deg": "True"}, "roll_deg: must be a number"),
        ({"latitude_deg": "95"}, "latitude_deg: must be from -90 to 90 (got 95.0)"),
        ({"solar_power_w": "#DIV/0!"}, "solar_power_w: must be a number (got '#DIV/0!')"),
    ],
)
def test_wrong_values_are_left_out_and_named_where_they_are_most(tmp_path, changes, expected):
    lines = ["", *ROWS]
    lines[4] = row(1.5, **changes)
    log = read(tmp_path, lines)
    (column,) = changes
    assert (len(log), log.rows_dropped) == (9, 1)
    assert any(n.startswith(f"{column}: 1 value left out") and "line 6" in n for n in log.notes)
    wrong = [row(0.5 * i, **changes) for i in range(6)]
    problems = messages(tmp_path, [*ROWS[:4], *wrong])
    assert problems[0].startswith(f"log.csv:6: {expected}")


def test_an_optional_column_that_is_mostly_wrong_is_not_used_at_all(tmp_path):
    log = read(tmp_path, [row(0.5 * i, state_of_charge=str(i)) for i in range(10)])  # per cent
    assert log.state_of_charge is None
    assert "state_of_charge: 10 values left out, cannot be (0 in line 2, must be" in log.notes[0]
    assert "it is a share, not a percentage" in log.notes[0]


def test_many_wrong_rows_of_each_column_are_counted_not_listed(tmp_path):
    wrong = [row(i, roll_deg="x", longitude_deg="east") for i in range(10)]
    problems = messages(tmp_path, wrong)
    assert sorted(m.split(": ")[1] for m in problems) == 3 * ["longitude_deg"] + 3 * ["roll_deg"]
    assert sum(m.endswith("(and 7 more rows)") for m in problems) == 2


@pytest.mark.parametrize(
    ("second", "note"),
    [
        (1.0, "1 row has the time of another: the first one is used"),
        (0.25, "time goes back once: the rows are sorted"),
    ],
)
def test_rows_are_sorted_by_time_and_used_once(tmp_path, second, note):
    lines = [*ROWS]
    lines[3] = row(second, solar_power_w="99")
    log = read(tmp_path, lines)
    assert note in log.notes
    assert np.all(np.diff(log.time_s) > 0.0)
    assert (99.0 in log.solar_power_w.tolist()) is (second == 0.25)
    # Beside a time that cannot be read.
    again = read(tmp_path, [*ROWS[:2], row(0, time_utc="noon"), *lines[3:]])
    assert np.all(np.diff(again.time_s) > 0.0)
    assert len(again) == 9


def test_gap_splits_the_log(tmp_path):
    log = read(tmp_path, [*ROWS, *(row(20 + 0.5 * i) for i in range(5))])
    (gap,) = log.gaps
    assert gap.duration_s == pytest.approx(15.5)
    assert log.segment().tolist() == [0] * 10 + [1] * 5
    assert log.notes == ("1 gap splits the log, the longest of 15.5 s",)


def test_rows_without_a_required_value_are_dropped_and_counted(tmp_path):
    lines = [*ROWS]
    lines[2], lines[5] = row(1.0, solar_power_w=""), row(2.5, roll_deg="NaN")
    lines[6] = row(3.0, state_of_charge="")
    log = read(tmp_path, lines)
    assert (len(log), log.rows_read, log.rows_dropped) == (8, 10, 2)
    assert "2 of 10 rows left out" in log.notes[0]
    # An optional value may be missing.
    assert np.flatnonzero(np.isnan(log.state_of_charge)).tolist() == [4]


def test_more_than_half_missing_is_an_error(tmp_path):
    lines = [*ROWS[:4]] + [row(2 + 0.5 * i, solar_power_w="") for i in range(5)]
    (problems,) = messages(tmp_path, lines)
    assert "5 of 9 rows lack a required value (solar_power_w in 5); allowed: at most 50" in problems


def test_log_without_values_of_the_attitude_is_read(tmp_path):
    lines = [row(i, roll_deg="", pitch_deg="", yaw_deg="") for i in range(4)]
    assert read(tmp_path, lines).attitude is None


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("roll_deg", "rol_deg", "1: roll_deg: required column is missing; is it 'rol_deg'?"),
        ("roll_deg", "remark", "1: roll_deg: required column is missing"),
        ("altitude_m", "altitudes_q", "1: altitude_m: required column is missing"),
        ("time_utc", "gust", "1: time_utc: required column is missing; allowed: time_utc or"),
        ("time_utc", "gust", "1: has the columns gust, "),
        ("pitch_deg", "roll_deg", "1: roll_deg: column appears more than once"),
        (",", ";", "2: has 1 fields, the header 9"),
    ],
)
def test_wrong_header(tmp_path, old, new, expected):
    problems = messages(tmp_path, ROWS, HEADER.replace(old, new))
    assert any(m.startswith(f"log.csv:{expected}") for m in problems)


def test_row_of_another_length(tmp_path):
    lines = [*ROWS]
    lines[1] += ",1"
    assert "1 line is left out: line 3 has 10 fields, the header 9" in read(tmp_path, lines).notes
    problems = messages(tmp_path, [f"{line},1" for line in lines])
    assert problems[0] == "log.csv:2: has 10 fields, the header 9"


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "is empty"),
        (HEADER.encode(), "has a header but no rows"),
        (b"\xff\xfe\x00", "is not UTF-16 text"),
        (b"\x80\x00\x01\x02" * 9, "is not a text table: it holds control characters"),
        (b"\x7fELF\x02\x01", "is not a text table"),
        (b"FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns", "use the .bin that it was"),
        ("\n".join([HEADER, row(0)]).encode(), "fewer than two complete rows"),
    ],
)
def test_file_that_is_no_log(tmp_path, content, expected):
    file = tmp_path / "log.csv"
    file.write_bytes(content)
    with pytest.raises(InputError, match=expected):
        read_flight_log(file)


def test_paths_that_are_no_plain_files_and_lines_without_end_are_refused(tmp_path):
    refused = {tmp_path / "none.csv": "no such file", tmp_path: "is a folder, not a file"}
    for path, words in (refused | {"/dev/zero": "is not a plain file"}).items():
        with pytest.raises(InputError, match=words):
            read_flight_log(path)
    assert messages(tmp_path, [*ROWS, "9" * 200_000]) == [
        "log.csv:12: is longer than 100000 characters"
    ]


def test_radians_are_suspected(tmp_path):
    lines = [row(i, roll_deg="0.1", pitch_deg="0.02", yaw_deg=str(0.5 * i)) for i in range(12)]
    assert "are these radians?" in read(tmp_path, lines).notes[0]


# ---- ULog


@pytest.fixture
def ulog(tmp_path):
    """Reader of topics, which are written to a file first."""

    def reader(content):
        file = tmp_path / "flight.ulg"
        file.write_bytes(ulog_bytes(content))
        return read_flight_log(file)

    return reader


@pytest.mark.parametrize("old_position", [False, True])
def test_ulog_topics_become_a_log(ulog, old_position):
    log = ulog(topics(old_position=old_position))
    # Satellite times are microseconds; a millisecond is far below the step.
    assert log.time_s == pytest.approx(EPOCH_S + 0.5 * np.arange(24), abs=1e-3)
    assert log.latitude_deg == pytest.approx(47.6)
    assert log.longitude_deg == pytest.approx(8.53)
    assert log.altitude_m == pytest.approx(536.0)
    assert log.solar_power_w == pytest.approx(106.0)
    assert log.mppt_voltage_v == pytest.approx(21.0)  # of the two trackers in use
    assert log.load_w == pytest.approx(48.0)
    assert np.isnan(log.state_of_charge[:4]).all()
    # Single precision of the quaternion.
    for angle, expected in zip(reversed(log.attitude), EULER_DEG.T, strict=True):
        turn = np.degrees(angle[:3]) - expected
        assert (turn + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=1e-4)


def test_ulog_rows_without_a_fix_or_with_a_stale_attitude_are_dropped(ulog):
    content = topics()
    content["vehicle_gps_position"]["fix_type"][:10] = 0
    assert ulog(content).rows_dropped == 10
    content = topics()
    content["vehicle_attitude"] = {k: v[:20] for k, v in content["vehicle_attitude"].items()}
    # The sample half a second after the last attitude still counts, the next three do not.
    assert ulog(content).rows_dropped == 3


@pytest.mark.parametrize(
    ("topic", "field", "expected"),
    [
        ("sensor_mppt", None, "does not say where the solar power is"),
        ("vehicle_attitude", None, "has no topic vehicle_attitude"),
        ("vehicle_attitude", "q[3]", r"vehicle_attitude has no field q\[3\]"),
        ("vehicle_gps_position", None, "has no topic vehicle_gps_position or sensor_gps"),
        ("vehicle_gps_position", "time_utc_usec", "never knows the universal time"),
    ],
)
def test_ulog_without_what_is_needed(ulog, topic, field, expected):
    content = topics()
    if field is None:
        del content[topic]
    elif field == "time_utc_usec":
        content[topic][field][:] = 0
    else:
        del content[topic][field]
    with pytest.raises(InputError, match=expected):
        ulog(content)


def test_ulog_without_the_package(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyulog", None)
    with pytest.raises(InputError, match="needs the package pyulog: pip install"):
        read_flight_log(tmp_path / "flight.ulg")


@given(
    st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(0, 255)), min_size=1, max_size=3),
    st.floats(0.5, 1.0),
)
def test_damaged_ulog_is_read_or_refused_in_words(tmp_path_factory, changes, kept):
    content = bytearray(ulog_bytes(topics()))
    content = content[: int(kept * len(content))] if kept < 0.9 else content
    for place, value in changes:
        content[min(int(place * len(content)), len(content) - 1)] = value
    file = tmp_path_factory.mktemp("log") / "flight.ulg"
    file.write_bytes(content)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.suppress(InputError):
        read_flight_log(file)
    assert not printed.getvalue()


def test_ulog_that_leads_back_to_itself_is_refused(tmp_path):
    file = tmp_path / "flight.ulg"
    content = bytearray(ulog_bytes(topics())[:16])
    note = b"\x0achar[4] abcnote"
    content += 5000 * (struct.pack("<H", len(note)) + b"I" + note)
    # A message that claims to be longer than the file, of no known kind: pyulog steps back.
    content += struct.pack("<H", 65535) + b"\x00" + b"tail"
    file.write_bytes(content)
    with pytest.raises(InputError, match=r"is not a ULog|has no topic"):
        read_flight_log(file)
    file.write_bytes(b"not a log at all")
    with pytest.raises(InputError, match="is not a ULog"):
        read_flight_log(file)


def ulog_messages(*messages):
    head = ulog_bytes({})
    return head + b"".join(struct.pack("<H", len(body)) + kind + body for kind, body in messages)


def multiplying(deep, times):
    """Formats of which each holds so many of the next one."""
    nested = [(b"F", f"t{i}:t{i + 1}[{times}] x;".encode()) for i in range(deep)]
    return [*nested, (b"F", f"t{deep}:uint8_t y;".encode())]


SUBSCRIBED = (b"A", struct.pack("<BH", 0, 0) + b"t0")
FORMATS_TWO_WAYS = [
    *((b"F", f"{a}{i}:t{i + 1} x;u{i + 1} y;".encode()) for i in range(60) for a in "tu"),
    *((b"F", b"t60:float x;"), (b"F", b"u60:float x;")),
]


@pytest.mark.parametrize(
    ("formats", "expected"),
    [
        (multiplying(30, 100), "have more fields than any log"),
        ([*multiplying(30, 100)[:-1], (b"F", b"t30:")], "have more fields than any log"),
        ([*multiplying(2, 100), *(999 * [SUBSCRIBED])], "have more fields than any log"),
        ([(b"F", b"t0:t0 x;")], "contain each other: t0 holds t0"),
        ([(b"F", b"t0:u z;"), (b"F", b"u:t0 x;")], "contain each other: t0 holds u holds t0"),
        ([(b"F", b"t0:uint8_t[60000] " + 60_000 * b"y" + b";")], "have more fields than any log"),
        (FORMATS_TWO_WAYS, "have more fields than any log"),
        (multiplying(3000, 1), "are nested too deeply"),
    ],
    ids=["of powers", "of nothing", "often", "in itself", "each other", "long", "two ways", "deep"],
)
def test_ulog_formats_without_end_are_refused_in_a_line(tmp_path, formats, expected):
    file = tmp_path / "flight.ulg"
    file.write_bytes(ulog_messages(*formats, SUBSCRIBED))
    with pytest.raises(InputError) as caught:
        read_flight_log(file)
    assert str(caught.value).startswith(f"{file}: is not a ULog: its formats {expected}")
    assert "\n" not in str(caught.value)
