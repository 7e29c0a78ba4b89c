"""Flight logs of autopilots: messages at different times, joined into one table.

PX4 ULog files are read by the package pyulog, which is imported when one is read. ArduPilot's
DataFlash files (``.bin``) describe themselves: a file is a row of messages, two bytes 0xA3 0x95, a
type, and a body whose fields a message of type 128 (FMT) has described before. Source: ArduPilot,
Logging data interpretation (dev documentation of the DataFlash log format); the scales of the
letters are those of the library AP_Logger.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from missions.files.errors import InputError, Problem, printable, refused
from missions.files.texts import open_plain, read_plain_file
from missions.logs.columns import ColumnMap, Recipe, Source, recipes_for
from missions.logs.table import REQUIRED, FlightLog, log_from_table, sampled
from missions.logs.units import ATTITUDE, EPOCH, MPPT
from solar.types import FloatArray

_FIX_3D = 3
_STREAM = re.compile(r"([A-Za-z0-9_]+)(?:\[\d+\])?\.")


def kinds_named(layout: ColumnMap) -> set[str]:
    """Return the kinds of messages that a layout names."""
    texts = [s.name or "" if isinstance(s, Source) else s for s in layout.columns.values()]
    return {match[1] for text in texts for match in _STREAM.finditer(text)}


class Streams:
    """Messages by their name over time since boot [s], and what a layout makes of ``NAME.FIELD``.

    ``kind``: what the format calls messages of a name.
    """

    def __init__(
        self, streams: Mapping[str, pd.DataFrame], layout: ColumnMap, source: str, kind: str
    ) -> None:
        self.streams, self.layout, self.source, self.kind = streams, layout, source, kind
        header = [f"{name}.{field}" for name, stream in streams.items() for field in stream]
        recipes = recipes_for(header, layout, guess=False)
        if recipes.problems:
            raise InputError(Problem("", None, None, "", text) for text in recipes.problems)
        self.mapped: dict[str, pd.Series] = {}
        for name, recipe in recipes.by_quantity.items():
            self.mapped |= {} if name == "time" else self._make_series(recipe)

    def _make_series(self, recipe: Recipe) -> dict[str, pd.Series]:
        """Make a quantity at the times of its first stream, with the power of each MPPT."""
        if recipe.value is not None:
            return {recipe.quantity: pd.Series([recipe.value], [np.nan])}
        first = self.streams[recipe.columns[0].rpartition(".")[0]].index.to_numpy()

        def column(name: str) -> FloatArray:
            stream, _, field = name.rpartition(".")
            return sampled(self.streams[stream][field], first)

        return {name: pd.Series(values, first) for name, values in recipe.values(column).items()}

    def needed(self, names: Sequence[str], use: str = "") -> str:
        """Return the first of the names that has messages."""
        for name in names:
            if name in self.streams:
                return name
        raise refused(f"has no {self.kind} {' or '.join(names)}{use}")

    def field(self, name: str, *fields: str) -> pd.Series:
        """Return the first of the named fields that exists."""
        for field in fields:
            if field in self.streams[name]:
                return self.streams[name][field].astype(float)
        raise refused(f"{self.kind} {printable(name)} has no field {' or '.join(fields)}")

    def fixed(self, name: str, status: str) -> pd.Series:
        """Flag messages with a 3D position; all of them where no field says so."""
        stream = self.streams[name]
        return stream.get(status, pd.Series(_FIX_3D, stream.index)) >= _FIX_3D

    def boot_s(self, name: str, universal_s: pd.Series) -> float:
        """Return the universal time of the boot [s since 1970] by the satellites, where known."""
        if universal_s.isna().all():
            raise refused(f"{self.kind} {printable(name)} never knows the universal time")
        return float((universal_s - universal_s.index).median())

    def battery(
        self, name: str, volts: str, amps: str, charge: str, unit: float, most: float = np.inf
    ) -> dict[str, pd.Series]:
        """Return load [W] and state of charge by a battery monitor, as far as it knows them.

        ``charge``: field of the state of charge in parts of ``unit``, unknown below 0 or beyond
        ``most``.
        """
        stream, made = self.streams.get(name, ()), {}
        if volts in stream and amps in stream:
            made["load_w"] = self.field(name, volts) * self.field(name, amps)
        if charge in stream:
            share = unit * self.field(name, charge)
            made["state_of_charge"] = share.where(share.between(0.0, most))
        return made

    def no_power(self, example: str) -> InputError:
        """Return the error of a log that does not say which message has the solar power."""
        names = ", ".join(printable(name) for name in list(self.streams)[:12]) or "nothing"
        return refused(
            f"does not say where the solar power is; give it, for instance --column "
            f"'solar_power_w={example}'; read: {names}"
        )

    def log(
        self, made: Mapping[str, pd.Series], boot_s: float, notes: list[str], battery: str
    ) -> FlightLog:
        """Join quantities at the times of the solar power; the layout's precede ``made``."""
        ignored = self.layout.ignore
        if needed := set(REQUIRED) & set(ignored):
            raise refused(f"{min(needed)} cannot be ignored: it is needed")
        if "load_w" in made and "load_w" not in self.mapped:
            notes.append(f"load_w is voltage times current of {battery}")
        every = {name: s for name, s in {**made, **self.mapped}.items() if name not in ignored}
        time_s = every["solar_power_w"].index.to_numpy(float)
        columns = {name: sampled(series, time_s, name) for name, series in every.items()}
        table = pd.DataFrame({EPOCH: time_s + boot_s, **columns})
        return log_from_table(table, self.source, notes, self.layout.exclude)


# ---- PX4 ULog

_POWER_TOPIC = "sensor_mppt"
_POSITION_TOPICS = ("vehicle_gps_position", "sensor_gps")
# Fields in degrees and metres, and the integers of old logs with their unit.
_POSITION_FIELDS = {
    "latitude_deg": ("latitude_deg", "lat", 1e-7),
    "longitude_deg": ("longitude_deg", "lon", 1e-7),
    "altitude_m": ("altitude_msl_m", "alt", 1e-3),
}
_PX4_EXAMPLE = "battery_status[1].voltage_v * battery_status[1].current_a"
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
    every, series = Streams(topics, layout, source, "topic"), dict[str, pd.Series]()
    if "solar_power_w" not in every.mapped:
        if _POWER_TOPIC not in topics:
            raise every.no_power(_PX4_EXAMPLE)
        # Mean voltage of the MPPTs in use, power of all of them and of each.
        power = topics[_POWER_TOPIC]
        count = max(sum(str(name).startswith("mppt_volt[") for name in power), 1)
        volt, amp = (
            pd.concat([every.field(_POWER_TOPIC, f"{name}[{i}]") for i in range(count)], axis=1)
            for name in ("mppt_volt", "mppt_amp")
        )
        volt.columns = amp.columns = pd.RangeIndex(count)
        used, each = volt.loc[:, (volt != 0.0).any()], volt * amp
        series["mppt_voltage_v"] = used.mean(axis=1, skipna=False)
        series["solar_power_w"] = each.sum(axis=1, skipna=False)
        if used.shape[1] > 1:
            series |= {f"{MPPT}mppt {i}": each[i] for i in used}
    position = every.needed(_POSITION_TOPICS, ": needed for position and universal time")
    fixed = every.fixed(position, "fix_type")
    for column, (new, old, unit) in _POSITION_FIELDS.items():
        values = every.field(position, new, old)
        series[column] = (values if new in topics[position] else values * unit).where(fixed)
    if not all(name in every.mapped for name in ATTITUDE):
        series |= _euler_deg(
            every, every.needed(("vehicle_attitude",), ": needed for the attitude")
        )
    series |= every.battery("battery_status", "voltage_v", "current_a", "remaining", 1.0)
    utc = every.field(position, "time_utc_usec") / 1e6
    boot_s = every.boot_s(position, utc.where(fixed & (utc > 0.0)))
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


def _ulog_topics(source: str, others: Iterable[str]) -> tuple[dict[str, pd.DataFrame], list[str]]:
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
        file = _BoundedFile(source)
        try:
            with file:
                log = _bounded_reader(ULog)(file, sorted(names))
        except RecursionError:
            raise refused("is not a ULog: its formats are nested too deeply") from None
        except Exception as error:  # pyulog raises whatever its parsing trips over
            raise refused(f"is not a ULog: {printable(str(error))[:200]}") from None
    topics: dict[str, pd.DataFrame] = {}
    for data in sorted(log.data_list, key=lambda d: int(d.multi_id)):
        name, topic = str(data.name), pd.DataFrame(data.data)
        if "timestamp" not in topic:
            raise refused(f"topic {printable(name)} has no field timestamp")
        topic.index = pd.Index(topic["timestamp"].to_numpy(float) / 1e6)
        if name == "battery_status" and "current_a" in topic:  # unknown where it is -1
            topic["current_a"] = topic["current_a"].where(topic["current_a"] != -1.0)
        if len(topic):
            # Instances are counted by where they first stand: some logs begin at 1.
            name = name if name not in topics else f"{name}[{int(data.multi_id)}]"
            topics.setdefault(name, topic)
    lost = [_DAMAGED] if log.file_corruption else []
    if dropouts := getattr(log, "dropouts", ()):
        whole_s = 1e-3 * sum(dropout.duration for dropout in dropouts)
        lost.append(f"the logger fell out {len(dropouts)} times, for {round(whole_s, 1)} s in all")
    return topics, lost


def _euler_deg(every: Streams, attitude: str) -> dict[str, pd.Series]:
    """Return roll, pitch and yaw [deg] from the quaternion body (FRD) to North-East-Down.

    Source: Beard & McLain, Small Unmanned Aircraft (2012), eq. B.1 to B.3.
    """
    w, x, y, z = (every.field(attitude, f"q[{i}]") for i in range(4))
    # Normalised: single precision and estimators leave a quaternion a little off the unit.
    norm = np.sqrt(w * w + x * x + y * y + z * z)
    norm = norm.where(norm > 0.0)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return dict(zip(ATTITUDE, map(np.degrees, (roll, pitch, yaw)), strict=True))


# ---- ArduPilot DataFlash

_MOST_BYTES = 500_000_000
_HEAD, _FMT, _FMT_LENGTH = b"\xa3\x95", 128, 89
# Letter of a field: type of the file, and what a step is worth.
_LETTERS: Mapping[str, tuple[str, float]] = {
    "b": ("i1", 1.0), "B": ("u1", 1.0), "M": ("u1", 1.0), "h": ("<i2", 1.0), "H": ("<u2", 1.0),
    "i": ("<i4", 1.0), "I": ("<u4", 1.0), "q": ("<i8", 1.0), "Q": ("<u8", 1.0),
    "f": ("<f4", 1.0), "d": ("<f8", 1.0), "g": ("<f2", 1.0), "c": ("<i2", 0.01),
    "C": ("<u2", 0.01), "e": ("<i4", 0.01), "E": ("<u4", 0.01), "L": ("<i4", 1e-7),
    "n": ("S4", 0.0), "N": ("S16", 0.0), "Z": ("S64", 0.0), "a": ("(32,)<i2", 0.0),
}  # fmt: skip
_INSTANCES = ("I", "Inst", "Instance")
_GPS_FIELDS = {"latitude_deg": "Lat", "longitude_deg": "Lng", "altitude_m": "Alt"}
_KINDS = ("ATT", "GPS", "BAT", "CURR")
_ARDUPILOT_EXAMPLE = "BAT[1].Volt * BAT[1].Curr"
# GPS time began on 1980-01-06; it is ahead of UTC by so many seconds from each of these instants
# on [s since 1970], by 14 s before: IERS, Bulletin C 28 to 52.
_GPS_EPOCH_S, _WEEK_S = 315964800.0, 604800.0
_LEAP = ((1230768000.0, 15.0), (1341100800.0, 16.0), (1435708800.0, 17.0), (1483228800.0, 18.0))


class _Kind(NamedTuple):
    """Kind of message: name, fields with the head, their scales, places of messages [bytes]."""

    name: str
    dtype: np.dtype[Any]
    scales: dict[str, float]
    places: list[int]


def read_dataflash(path: str | os.PathLike[str], columns: ColumnMap | None = None) -> FlightLog:
    """Read a DataFlash log of ArduPilot.

    ``columns`` must say where the solar power is, for instance ``BAT[1].Volt * BAT[1].Curr`` where
    the second battery monitor measures it; its times are the log's.
    """
    source, layout = os.fspath(path), columns or ColumnMap()
    content = read_plain_file(source, most_bytes=_MOST_BYTES)
    streams, skipped = _read_streams(content, {*_KINDS, *kinds_named(layout)})
    every = Streams(streams, layout, source, "message")
    if "solar_power_w" not in every.mapped:
        raise every.no_power(_ARDUPILOT_EXAMPLE)
    every.needed(("GPS",))
    fixed = every.fixed("GPS", "Status")
    series = {name: every.field("GPS", field).where(fixed) for name, field in _GPS_FIELDS.items()}
    if not all(name in every.mapped for name in ATTITUDE):
        every.needed(("ATT",))
        angles = zip(ATTITUDE, ("Roll", "Pitch", "Yaw"), strict=True)
        series |= {name: every.field("ATT", field) for name, field in angles}
    battery = "BAT" if "BAT" in streams else "CURR"
    series |= every.battery(battery, "Volt", "Curr", "RemPct", 0.01, 1.0)
    notes = []
    if skipped:
        notes.append(f"the log is damaged: {skipped} of {len(content)} bytes are no messages")
    # Universal time of the boot [s since 1970], from GPS weeks and milliseconds.
    week, ms = every.field("GPS", "GWk", "Week"), every.field("GPS", "GMS", "TimeMS")
    gps_s = (_GPS_EPOCH_S + _WEEK_S * week + 1e-3 * ms).where(fixed & (week > 0.0))
    boot_s, middle = every.boot_s("GPS", gps_s), float(gps_s.median())
    boot_s -= max((ahead for since, ahead in _LEAP if middle - ahead >= since), default=14.0)
    return every.log(series, boot_s, notes, "the first battery monitor")


def _read_streams(content: bytes, names: set[str]) -> tuple[dict[str, pd.DataFrame], int]:
    """Read the messages of the named kinds, by instance, and count bytes outside messages."""
    kinds: dict[int, _Kind] = {}
    lengths = {_FMT: _FMT_LENGTH}
    at, end, skipped = 0, len(content) - 3, 0
    while at <= end:
        number = content[at + 2]
        length = lengths.get(number)
        if content[at] != 0xA3 or content[at + 1] != 0x95 or length is None:
            head = content.find(_HEAD, at + 1)
            head = len(content) if head < 0 else head
            skipped += head - at
            at = head
            continue
        if at + length > len(content):
            break
        if number in kinds:
            kinds[number].places.append(at)
        body, at = content[at + 3 : at + length], at + length
        if number != _FMT or (described := body[0]) == _FMT or described in lengths or body[1] < 4:
            continue
        name, letters, labels = (
            part.split(b"\0")[0].decode("ascii", "replace")
            for part in (body[2:6], body[6:22], body[22:86])
        )
        fields, lengths[described] = labels.split(","), body[1]
        known = all(letter in _LETTERS for letter in letters)
        if not known or len(fields) != len(letters) or len(set(fields)) != len(fields):
            continue
        kind_of = dict(zip(fields, letters, strict=True))
        dtype = np.dtype([("head", "S3"), *((f, _LETTERS[c][0]) for f, c in kind_of.items())])
        if dtype.itemsize == body[1] and name in names:
            scales = {f: _LETTERS[c][1] for f, c in kind_of.items()}
            if name == "CURR":  # until 2016 hundredths of volts and amperes, as plain integers
                scales |= {f: 0.01 for f in ("Volt", "Curr") if kind_of.get(f, "") in ("h", "H")}
            kinds[described] = _Kind(name, dtype, {f: s for f, s in scales.items() if s}, [])
    if len(lengths) == 1:
        raise refused("is not a DataFlash log: it describes no messages")
    by_instance = (_split_by_instance(kind, content) for kind in kinds.values() if kind.places)
    return {name: stream for part in by_instance for name, stream in part.items()}, skipped


def _split_by_instance(kind: _Kind, content: bytes) -> dict[str, pd.DataFrame]:
    """Return the messages of a kind by name, one for each instance, without falling times."""
    raw, at = np.frombuffer(content, np.uint8), np.array(kind.places)
    rows = raw[at[:, np.newaxis] + np.arange(kind.dtype.itemsize)]
    table = np.ascontiguousarray(rows).view(kind.dtype)[:, 0]
    fields = pd.DataFrame({f: table[f].astype(float) * s for f, s in kind.scales.items()})
    clock, step = ("TimeUS", 1e-6) if "TimeUS" in fields else ("TimeMS", 1e-3)
    if "Week" in fields and "T" in fields:  # GPS until 2014: TimeMS counts from the week's start
        clock = "T"
    if clock not in fields:
        return {}
    fields.index = pd.Index(fields[clock] * step)
    instance = next((fields[n] for n in _INSTANCES if n in fields), pd.Series(0.0, fields.index))
    streams = {}
    for number in np.unique(instance)[:16]:
        part = fields[(instance == number).to_numpy() & np.isfinite(fields.index)]
        # Times fall in damaged logs.
        rising = np.diff(part.index.to_series().cummax(), prepend=-np.inf) > 0.0
        name = kind.name if number == 0 else f"{kind.name}[{int(number)}]"
        streams[name] = part[rising]
    return streams
