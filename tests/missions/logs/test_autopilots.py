"""Logs of autopilots: DataFlash of ArduPilot, and ULog whose power is not where it is expected."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from log_layouts import FORMATS, FORMATS_2014, formats_of, message
from ulog_files import EPOCH_S, topics, ulog_bytes

from missions.files.errors import InputError
from missions.logs.autopilots import Streams
from missions.logs.columns import ColumnMap, parse_column
from missions.logs.csv import read_flight_log

COUNT = 24
SOLAR = "BAT[1].Volt * BAT[1].Curr"


def layout(power=SOLAR):
    return ColumnMap().with_options(dict([parse_column(f"solar_power_w={power}")]))


def dataflash(*, formats=True, epoch_s=EPOCH_S, leap_s=17.0):
    """Twelve seconds at 2 Hz of each message, booted 100 s before the first."""
    out = formats_of() if formats else b""
    # 2015-07-01T05:30:00Z, 17 s after GPS time had been set back by the leap second of that day.
    gps_s = epoch_s + leap_s - 315964800.0
    week, seconds = divmod(gps_s, 604800.0)
    for i in range(COUNT):
        time_us = 100_000_000 + 500_000 * i
        ms = round(1e3 * seconds) + 500 * i
        out += message("ATT", time_us, 0, 1000, 0, -250, 0, 27000)
        place = (900, 476000000, 85300000, 53600)
        out += message("GPS", time_us, 0, 3, ms, int(week), 12, *place)
        out += message("BAT", time_us, 0, 24.0, 2.0, 80)
        out += message("BAT", time_us, 1, 20.0, 5.0 + 0.1 * i, 0)
        out += message("MSG", time_us, b"hello")
    return out


def read(folder, content, columns=None):
    file = folder / "flight.bin"
    file.write_bytes(content)
    return read_flight_log(file, columns)


def test_dataflash_becomes_a_log(tmp_path):
    log = read(tmp_path, dataflash(), layout())
    assert log.time_s == pytest.approx(EPOCH_S + 0.5 * np.arange(COUNT), abs=1e-3)
    assert log.solar_power_w == pytest.approx(20.0 * (5.0 + 0.1 * np.arange(COUNT)))
    assert log.latitude_deg == pytest.approx(47.6)
    assert log.longitude_deg == pytest.approx(8.53)
    assert log.altitude_m == pytest.approx(536.0)
    angles = [float(np.degrees(angle[0])) for angle in log.attitude]
    assert angles == pytest.approx([10.0, -2.5, 270.0])
    assert log.load_w == pytest.approx(48.0)
    assert log.state_of_charge == pytest.approx(0.8)


def test_a_value_that_is_ignored_is_not_taken(tmp_path):
    columns = {"solar_power_w": SOLAR, "state_of_charge": {"value": 0.3}}
    said = ColumnMap.model_validate({"columns": columns})
    assert read(tmp_path, dataflash(), said).state_of_charge == pytest.approx(0.3)
    ignored = said.model_copy(update={"ignore": ("state_of_charge",)})
    assert read(tmp_path, dataflash(), ignored).state_of_charge is None


@pytest.mark.extra
def test_dataflash_agrees_with_pymavlink(tmp_path):
    reader = pytest.importorskip("pymavlink.DFReader")
    file = tmp_path / "flight.bin"
    file.write_bytes(dataflash())
    log = read_flight_log(file, layout())
    other = reader.DFReader_binary(str(file))
    volts, yaws, times = [], [], []
    while (message := other.recv_match(type=["BAT", "ATT", "GPS"])) is not None:
        if message.get_type() == "BAT" and message.Inst == 1:
            volts.append(message.Volt * message.Curr)
        elif message.get_type() == "ATT":
            yaws.append(message.Yaw)
        elif message.get_type() == "GPS":
            times.append(message._timestamp)
    assert log.solar_power_w == pytest.approx(volts)
    assert np.degrees(log.attitude.yaw_rad) == pytest.approx(yaws)
    assert log.time_s == pytest.approx(
        times, abs=1.5
    )  # it counts 16 s of leap seconds at all times


def test_dataflash_of_2014(tmp_path):
    content = formats_of(FORMATS_2014)
    week, seconds = divmod(EPOCH_S + 17.0 - 315964800.0, 604800.0)
    for i in range(COUNT):
        boot_ms = 100_000 + 500 * i
        ms = round(1e3 * seconds) + 500 * i
        angles = (0, 1000, 0, -250, 0, 27000)
        gps = (3, ms, int(week), 12, 90, 476000000, 85300000, 0, 53600, 0, 0, 0.0, boot_ms)
        content += message("ATT", boot_ms, *angles, formats=FORMATS_2014)
        content += message("GPS", *gps, formats=FORMATS_2014)
        content += message("CURR", boot_ms, 0, 2000, 500 + i, formats=FORMATS_2014)
    log = read(tmp_path, content, layout("CURR.Volt * CURR.Curr"))
    assert log.time_s == pytest.approx(EPOCH_S + 0.5 * np.arange(COUNT), abs=1e-3)
    assert log.solar_power_w == pytest.approx(20.0 * (5.0 + 0.01 * np.arange(COUNT)))
    assert log.altitude_m == pytest.approx(536.0)


def test_dataflash_that_does_not_say_where_the_power_is(tmp_path):
    with pytest.raises(InputError) as caught:
        read(tmp_path, dataflash())
    message = str(caught.value)
    assert "--column 'solar_power_w=BAT[1].Volt * BAT[1].Curr'" in message
    assert "read: ATT, GPS, BAT, BAT[1]" in message
    with pytest.raises(InputError, match="no such column"):
        read(tmp_path, dataflash(), layout("BAT[2].Volt * BAT[2].Curr"))


@pytest.mark.parametrize("content", [b"", b"no log", b"\xa3\x95" * 50, dataflash(formats=False)])
def test_what_is_no_dataflash(tmp_path, content):
    with pytest.raises(InputError, match="is not a DataFlash log"):
        read(tmp_path, content, layout())


def test_damage_is_told(tmp_path):
    head = b"\xa3\x95" + bytes([FORMATS["GPS"][0]])
    first = dataflash().index(head)
    content = dataflash()[:first] + b"\0" * 10 + dataflash()[first:]
    log = read(tmp_path, content, layout())
    assert len(log) == COUNT
    assert f"the log is damaged: 10 of {len(content)} bytes are no messages" in log.notes


@settings(max_examples=60)
@given(
    st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(0, 255)), min_size=1, max_size=4),
    st.floats(0.3, 1.0),
)
def test_damaged_dataflash_is_read_or_refused_in_words(tmp_path_factory, changes, kept):
    content = bytearray(dataflash())
    content = content[: int(kept * len(content))]
    for place, value in changes:
        content[min(int(place * len(content)), len(content) - 1)] = value
    folder = tmp_path_factory.mktemp("log")
    try:
        log = read(folder, bytes(content), layout())
    except InputError:
        return
    assert np.all(np.isfinite(log.solar_power_w))


def test_ulog_with_solar_power_on_a_second_battery_monitor(tmp_path):
    content = topics(old_position=True)
    del content["sensor_mppt"]
    file = tmp_path / "flight.ulg"
    file.write_bytes(ulog_bytes(content))
    power = "battery_status.voltage_v * battery_status.current_a"
    log = read_flight_log(file, layout(power))
    assert log.solar_power_w == pytest.approx(48.0)
    with pytest.raises(InputError, match="does not say where the solar power is"):
        read_flight_log(file)


def test_a_quaternion_a_little_off_the_unit_is_the_same_attitude(tmp_path):
    logs = []
    for length in (1.0, 1.05):
        content = topics()
        for i in range(4):
            content["vehicle_attitude"][f"q[{i}]"] = length * content["vehicle_attitude"][f"q[{i}]"]
        (tmp_path / "a.ulg").write_bytes(ulog_bytes(content))
        logs.append(read_flight_log(tmp_path / "a.ulg"))
    # A log holds single precision.
    np.testing.assert_allclose(logs[1].attitude, logs[0].attitude, atol=1e-5)


@pytest.mark.parametrize(
    ("instant", "leap_s"),
    [
        # Leap seconds of 2005, 2008, 2012, 2015 and 2016, each at the end of June or December.
        ("2008-12-31T20:00", 14.0),
        ("2009-01-01T04:00", 15.0),
        ("2012-06-30T20:00", 15.0),
        ("2012-07-01T04:00", 16.0),
        ("2015-06-30T20:00", 16.0),
        ("2016-12-31T20:00", 17.0),
        ("2017-01-01T04:00", 18.0),
    ],
)
def test_time_of_gps_is_ahead_by_the_leap_seconds(tmp_path, instant, leap_s):
    epoch_s = float(np.datetime64(instant, "s").astype(np.int64))
    log = read(tmp_path, dataflash(epoch_s=epoch_s, leap_s=leap_s), layout())
    assert log.time_s[0] == pytest.approx(epoch_s, abs=1e-3)


def test_an_empty_battery_is_known_and_a_charge_that_cannot_be_is_not():
    shares = pd.DataFrame({"RemPct": [-1.0, 0.0, 55.0, 100.0, 101.0]})
    every = Streams({"BAT": shares}, ColumnMap(), "flight.bin", "message")
    known = every.battery("BAT", "Volt", "Curr", "RemPct", 0.01, 1.0)
    nan = np.nan
    assert list(known) == ["state_of_charge"]
    assert known["state_of_charge"].values == pytest.approx([nan, 0.0, 0.55, 1.0, nan], nan_ok=True)
