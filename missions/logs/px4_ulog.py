"""Flight logs from PX4 ULog files, by the package pyulog, which is imported when one is read."""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from missions.files.errors import file_error, printable
from missions.logs.table import ATTITUDE, EPOCH, FlightLog, log_from_table
from solar.types import BoolArray, FloatArray

# A sample of a topic stands for a time no further from it than this [s].
_ATTITUDE_AGE_S, _POSITION_AGE_S, _BATTERY_AGE_S = 0.5, 2.0, 5.0
_FIX_3D = 3
_POWER_TOPIC = "sensor_mppt"
_POSITION_TOPICS = ("vehicle_gps_position", "sensor_gps")
_POWER_HELP = (
    f"the power is read from a topic {_POWER_TOPIC} with mppt_volt[i] and mppt_amp[i]; "
    "logs that have it elsewhere must be exported to CSV"
)
# How often a log is read over before its reader is taken to go round in circles.
_MOST_PASSES = 20
_DAMAGED = "the log is damaged; what of it could be read is used"


class _Topic(NamedTuple):
    """Fields of one topic over time since boot [s]."""

    name: str
    time_s: FloatArray
    fields: dict[str, NDArray[Any]]


@np.errstate(invalid="ignore", over="ignore")  # damaged numbers need not be any
def read_ulog(path: str | os.PathLike[str]) -> FlightLog:
    """Read a PX4 ULog; needs the package pyulog.

    Power and MPPT voltage come from ``sensor_mppt``, whose times are the log's; of the other
    topics the nearest sample is taken, none if that is too old. Boot time becomes universal time by
    the median difference to the time of the satellites.

    Raises
    ------
    InputError
        If the package, the file, a topic or a field is missing, or a value is wrong.
    """
    import pandas as pd

    source = os.fspath(path)
    topics, damaged = _ulog_topics(source)
    power = _topic(topics, (_POWER_TOPIC,), source, _POWER_HELP)
    attitude = _topic(topics, ("vehicle_attitude",), source, "needed for the attitude")
    position = _topic(topics, _POSITION_TOPICS, source, "needed for position and universal time")
    time_s = power.time_s
    volts, watts = _mppt(power, source)
    columns = {
        EPOCH: time_s + _boot_s(position, source),
        "solar_power_w": watts,
        "mppt_voltage_v": volts,
    }
    columns |= _sampled(position, time_s, _POSITION_AGE_S, _place(position, source))
    columns |= _sampled(attitude, time_s, _ATTITUDE_AGE_S, _euler_deg(attitude, source))
    if "battery_status" in topics:
        battery = topics["battery_status"]
        columns |= _sampled(battery, time_s, _BATTERY_AGE_S, _battery(battery))
    table = pd.DataFrame(columns)
    notes = [_DAMAGED] if damaged else []
    if "load_w" in table:
        notes.append("load_w is voltage times current of battery_status")
    return log_from_table(table, source, notes=notes)


class _EndlessError(Exception):
    """More was read of a file than any of its contents could need."""


class _BoundedFile:
    """File for a parser that may go round in circles where a byte is wrong."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._left = _MOST_PASSES * (os.fstat(file.fileno()).st_size + 1000)

    def read(self, size: int = -1) -> bytes:
        data = self._file.read(size)
        self._left -= len(data) + 1  # a read at the end counts as well
        if self._left < 0:
            raise _EndlessError("its messages lead back to themselves")
        return data

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def close(self) -> None:
        self._file.close()


def _ulog_topics(source: str) -> tuple[dict[str, _Topic], bool]:
    """First instance of every topic in the log; whether the log is damaged."""
    try:
        from pyulog import ULog
    except ImportError:
        raise file_error(
            source, "reading a ULog needs the package pyulog: pip install pyulog (the extra 'log')"
        ) from None
    if not Path(source).is_file():
        raise file_error(source, "cannot be read: no such file")
    names = [_POWER_TOPIC, "vehicle_attitude", *_POSITION_TOPICS, "battery_status"]
    # What pyulog prints of damaged logs would stand among the results.
    with contextlib.redirect_stdout(io.StringIO()):
        try:
            with open(source, "rb") as file:  # noqa: PTH123
                log = ULog(_BoundedFile(file), names)
        except OSError as error:
            raise file_error(source, f"cannot be read: {error.strerror}") from None
        except Exception as error:  # pyulog raises whatever its parsing trips over
            raise file_error(source, f"is not a ULog: {printable(str(error))[:200]}") from None
    topics: dict[str, _Topic] = {}
    for data in sorted(log.data_list, key=lambda d: int(d.multi_id)):
        fields = {str(k): np.asarray(v) for k, v in data.data.items()}
        if "timestamp" not in fields:
            raise file_error(source, f"topic {printable(str(data.name))} has no field timestamp")
        if len(fields["timestamp"]):
            topic = _Topic(str(data.name), fields["timestamp"] / 1e6, fields)
            topics.setdefault(topic.name, topic)
    return topics, bool(log.file_corruption)


def _topic(topics: dict[str, _Topic], names: Sequence[str], source: str, purpose: str) -> _Topic:
    for name in names:
        if name in topics:
            return topics[name]
    raise file_error(source, f"has no topic {' or '.join(names)}: {purpose}")


def _field(topic: _Topic, source: str, *names: str) -> NDArray[Any]:
    for name in names:
        if name in topic.fields:
            return topic.fields[name]
    raise file_error(source, f"topic {topic.name} has no field {' or '.join(names)}")


def _mppt(power: _Topic, source: str) -> tuple[FloatArray, FloatArray]:
    """Mean voltage [V] of the MPPTs in use, and power of all [W]."""
    _field(power, source, "mppt_volt[0]")
    _field(power, source, "mppt_amp[0]")
    count = sum(name.startswith("mppt_volt[") for name in power.fields)
    volt = np.array([power.fields[f"mppt_volt[{i}]"] for i in range(count)], float)
    amp = np.array([_field(power, source, f"mppt_amp[{i}]") for i in range(count)], float)
    used = np.any(volt != 0.0, axis=1)
    mean = volt[used].mean(axis=0) if used.any() else np.full(volt.shape[1], np.nan)
    return np.asarray(mean), np.asarray((volt * amp).sum(axis=0))


def _boot_s(position: _Topic, source: str) -> float:
    """Universal time of the boot [s since 1970]."""
    utc = np.asarray(_field(position, source, "time_utc_usec"), float) / 1e6
    known = (utc > 0.0) & _has_fix(position)
    if not known.any():
        raise file_error(source, f"topic {position.name} never knows the universal time")
    return float(np.median((utc - position.time_s)[known]))


def _has_fix(position: _Topic) -> BoolArray:
    fix = position.fields.get("fix_type")
    if fix is None:
        return np.ones(len(position.time_s), bool)
    return np.asarray(fix >= _FIX_3D)


def _place(position: _Topic, source: str) -> dict[str, FloatArray]:
    """Position in degrees and metres, from floating-point fields or the integers of old logs."""
    columns = {
        "latitude_deg": ("latitude_deg", "lat", 1e-7),
        "longitude_deg": ("longitude_deg", "lon", 1e-7),
        "altitude_m": ("altitude_msl_m", "alt", 1e-3),
    }
    fixed = _has_fix(position)
    result = {}
    for column, (new, old, unit) in columns.items():
        values = np.asarray(_field(position, source, new, old), float)
        scaled = values if new in position.fields else values * unit
        result[column] = np.where(fixed, scaled, np.nan)
    return result


def _euler_deg(attitude: _Topic, source: str) -> dict[str, FloatArray]:
    """Roll, pitch and yaw [deg] from the quaternion body (FRD) to North-East-Down.

    Source: Beard & McLain, Small Unmanned Aircraft (2012), eq. B.1 to B.3.
    """
    w, x, y, z = (np.asarray(_field(attitude, source, f"q[{i}]"), float) for i in range(4))
    # Normalised: single precision and estimators leave a quaternion a little off the unit.
    norm = np.sqrt(w * w + x * x + y * y + z * z)
    norm = np.where(norm > 0.0, norm, np.nan)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return dict(zip(ATTITUDE, map(np.degrees, (roll, pitch, yaw)), strict=True))


def _battery(battery: _Topic) -> dict[str, FloatArray]:
    """Load [W] and state of charge, where they are known (negative: unknown)."""
    fields, result = battery.fields, {}
    if "voltage_v" in fields and "current_a" in fields:
        volt, amp = (np.asarray(fields[name], float) for name in ("voltage_v", "current_a"))
        result["load_w"] = np.where(amp == -1.0, np.nan, volt * amp)
    if "remaining" in fields:
        remaining = np.asarray(fields["remaining"], float)
        result["state_of_charge"] = np.where(remaining < 0.0, np.nan, remaining)
    return result


def _sampled(
    topic: _Topic, time_s: FloatArray, age_s: float, columns: dict[str, FloatArray]
) -> dict[str, FloatArray]:
    """Nearest sample of a topic at other times, NaN if it is older or younger than allowed."""
    after = np.clip(np.searchsorted(topic.time_s, time_s), 1, max(len(topic.time_s) - 1, 1))
    after = np.minimum(after, len(topic.time_s) - 1)
    before = np.maximum(after - 1, 0)
    earlier = np.abs(time_s - topic.time_s[before]) <= np.abs(topic.time_s[after] - time_s)
    nearest = np.where(earlier, before, after)
    fresh = np.abs(topic.time_s[nearest] - time_s) <= age_s
    return {name: np.where(fresh, values[nearest], np.nan) for name, values in columns.items()}
