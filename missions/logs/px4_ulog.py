"""Flight logs from PX4 ULog files, by the package pyulog, which is imported when one is read."""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from missions.files.errors import InputError, printable, refused
from missions.files.texts import open_plain
from missions.logs.columns import ColumnMap
from missions.logs.streams import Stream, Streams, kinds_named
from missions.logs.table import FlightLog
from missions.logs.units import ATTITUDE, MPPT

_POWER_TOPIC = "sensor_mppt"
_POSITION_TOPICS = ("vehicle_gps_position", "sensor_gps")
# Fields in degrees and metres, and the integers of old logs with their unit.
_POSITION_FIELDS = {
    "latitude_deg": ("latitude_deg", "lat", 1e-7),
    "longitude_deg": ("longitude_deg", "lon", 1e-7),
    "altitude_m": ("altitude_msl_m", "alt", 1e-3),
}
_EXAMPLE = "battery_status[1].voltage_v * battery_status[1].current_a"
# How often a log is read over before its reader is taken to go round in circles.
_MOST_PASSES = 20
# Characters in the names of all fields of all topics: some hundred topics have some 100,000.
_MOST_CHARACTERS = 2_000_000
_DAMAGED = "the log is damaged; what of it could be read is used"


@np.errstate(invalid="ignore", over="ignore")  # damaged numbers need not be any
def read_ulog(path: str | os.PathLike[str], columns: ColumnMap | None = None) -> FlightLog:
    """Read a PX4 ULog; needs the package pyulog.

    Power and MPPT voltage come from ``sensor_mppt``, or where ``columns`` says; their times are
    the log's. Boot time becomes universal time by the median difference to the satellites' time.
    """
    source, layout = os.fspath(path), columns or ColumnMap()
    topics, damage = _ulog_topics(source, kinds_named(layout))
    every, series = Streams(topics, layout, source), dict[str, pd.Series]()
    if "solar_power_w" not in every.mapped:
        if _POWER_TOPIC not in topics:
            raise every.no_power(_EXAMPLE)
        # Mean voltage of the MPPTs in use, power of all of them and of each.
        power = topics[_POWER_TOPIC]
        count = max(sum(name.startswith("mppt_volt[") for name in power.fields), 1)
        volt, amp = (
            np.array([power.field(f"{name}[{i}]") for i in range(count)])
            for name in ("mppt_volt", "mppt_amp")
        )
        used = np.any(volt != 0.0, axis=1)
        mean = volt[used].mean(axis=0) if used.any() else np.full(volt.shape[1], np.nan)
        mppts = {"mppt_voltage_v": mean, "solar_power_w": (volt * amp).sum(axis=0)}
        if used.sum() > 1:
            mppts |= {f"{MPPT}mppt {i}": volt[i] * amp[i] for i in np.flatnonzero(used)}
        series |= power.series(mppts)
    lack = f"has no topic {' or '.join(_POSITION_TOPICS)}: needed for position and universal time"
    position = every.needed(_POSITION_TOPICS, lack)
    fixed = position.has_fix("fix_type")
    for column, (new, old, unit) in _POSITION_FIELDS.items():
        values = position.field(new, old) * (1.0 if new in position.fields else unit)
        series |= position.series({column: np.where(fixed, values, np.nan)})
    if not all(name in every.mapped for name in ATTITUDE):
        lack = "has no topic vehicle_attitude: needed for the attitude"
        series |= _euler_deg(every.needed(("vehicle_attitude",), lack))
    if battery := topics.get("battery_status"):
        # Load and state of charge are not known where they are negative.
        fields = {name: np.asarray(values, float) for name, values in battery.fields.items()}
        if "voltage_v" in fields and "current_a" in fields:
            amp = np.where(fields["current_a"] == -1.0, np.nan, fields["current_a"])
            series |= battery.series({"load_w": fields["voltage_v"] * amp})
        if "remaining" in fields:
            share = np.where(fields["remaining"] < 0.0, np.nan, fields["remaining"])
            series |= battery.series({"state_of_charge": share})
    utc = position.field("time_utc_usec") / 1e6
    boot_s = position.boot_s((utc > 0.0) & fixed, utc)
    return every.log(series, boot_s, damage, "battery_status")


class _EndlessError(Exception):
    """The parser reads or lays out more of a file than any flight could need."""


class _BoundedFile(io.BufferedReader):
    """File with a bound on bytes read, for a parser that loops on damaged bytes."""

    def __init__(self, path: str) -> None:
        super().__init__(open_plain(path).detach())
        self._left = _MOST_PASSES * (os.fstat(self.fileno()).st_size + 1000)

    def read(self, size: int | None = -1) -> bytes:
        data = super().read(size)
        self._left -= len(data) + 1  # a read at the end counts as well
        if self._left < 0:
            raise _EndlessError("its messages lead back to themselves")
        return data


def _bounded_reader(reader: Any) -> Any:
    """Return pyulog's reader with a bound on the fields of subscribed topics.

    pyulog lays a topic out field by field as soon as it is subscribed, however often its format
    holds others; a few hundred bytes can ask for more fields than any memory has.
    """
    known: dict[str, int] = {}

    class Bounded(reader):  # type: ignore[misc]  # pyulog has no types
        _characters = 0

        def _MessageAddLogged(self, data: bytes, header: Any, formats: Any) -> Any:  # noqa: N802
            self._characters += _characters_of(self.parse_string(data[3:]), formats, known)
            if self._characters > _MOST_CHARACTERS:
                raise _EndlessError("its formats have more fields than any log")
            return reader._MessageAddLogged(data, header, formats)

    return Bounded


def _characters_of(
    name: str, formats: Mapping[str, Any], known: dict[str, int], above: tuple[str, ...] = ()
) -> int:
    """Count the characters in the names of all fields of a format, an upper bound."""
    if name in above:
        circle = " holds ".join((*above[above.index(name) :], name))
        raise _EndlessError(f"its formats contain each other: {circle}")
    if name not in known:
        within = (*above, name)
        known[name] = sum(
            max(times, 1) * len(f"{field}[{times}].")
            * (1 + (_characters_of(kind, formats, known, within) if kind in formats else 0))
            for kind, times, field in formats[name].fields
        )  # fmt: skip
    return known[name]


def _ulog_topics(source: str, others: Iterable[str]) -> tuple[dict[str, Stream], list[str]]:
    """Return the topics of the log, the first instance without a number, and notes on losses."""
    try:
        from pyulog import ULog
    except ImportError:
        raise refused(
            "reading a ULog needs the package pyulog: pip install pyulog (the extra 'log')"
        ) from None
    names = {_POWER_TOPIC, "vehicle_attitude", "battery_status", *_POSITION_TOPICS, *others}
    # What pyulog prints of damaged logs would stand among the results.
    with contextlib.redirect_stdout(io.StringIO()):
        try:
            with _BoundedFile(source) as file:
                log = _bounded_reader(ULog)(file, sorted(names))
        except InputError:
            raise
        except RecursionError:
            raise refused("is not a ULog: its formats are nested too deeply") from None
        except Exception as error:  # pyulog raises whatever its parsing trips over
            raise refused(f"is not a ULog: {printable(str(error))[:200]}") from None
    topics: dict[str, Stream] = {}
    for data in sorted(log.data_list, key=lambda d: int(d.multi_id)):
        fields = {str(k): np.asarray(v) for k, v in data.data.items()}
        name = str(data.name)
        if "timestamp" not in fields:
            raise refused(f"topic {printable(name)} has no field timestamp")
        if len(fields["timestamp"]):
            # Instances are counted by where they first stand: some logs begin at 1.
            name = name if name not in topics else f"{name}[{int(data.multi_id)}]"
            topic = Stream(name, np.asarray(fields["timestamp"], float) / 1e6, fields, "topic")
            topics.setdefault(name, topic)
    lost = [_DAMAGED] if log.file_corruption else []
    if dropouts := getattr(log, "dropouts", ()):
        whole_s = 1e-3 * sum(dropout.duration for dropout in dropouts)
        lost.append(f"the logger fell out {len(dropouts)} times, for {round(whole_s, 1)} s in all")
    return topics, lost


def _euler_deg(attitude: Stream) -> dict[str, pd.Series]:
    """Return roll, pitch and yaw [deg] from the quaternion body (FRD) to North-East-Down.

    Source: Beard & McLain, Small Unmanned Aircraft (2012), eq. B.1 to B.3.
    """
    w, x, y, z = (attitude.field(f"q[{i}]") for i in range(4))
    # Normalised: single precision and estimators leave a quaternion a little off the unit.
    norm = np.sqrt(w * w + x * x + y * y + z * z)
    norm = np.where(norm > 0.0, norm, np.nan)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    degrees = map(np.degrees, (roll, pitch, yaw))
    return attitude.series(dict(zip(ATTITUDE, degrees, strict=True)))
