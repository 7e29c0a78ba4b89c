"""Flight logs from ArduPilot's DataFlash files (``.bin``), which describe themselves.

A file is a row of messages: two bytes 0xA3 0x95, a type, and a body whose fields a message of type
128 (FMT) has described before. Source: ArduPilot, Logging data interpretation (dev documentation of
the DataFlash log format); the scales of the letters are those of the library AP_Logger.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from missions.files.errors import refused
from missions.files.texts import read_plain_file
from missions.logs.columns import ColumnMap
from missions.logs.streams import Stream, Streams, kinds_named
from missions.logs.table import FlightLog
from missions.logs.units import ATTITUDE

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
_EXAMPLE = "BAT[1].Volt * BAT[1].Curr"
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
    every = Streams(streams, layout, source)
    if "solar_power_w" not in every.mapped:
        raise every.no_power(_EXAMPLE)
    gps = every.needed(("GPS",), "has no messages GPS")
    place = {name: gps.field(field) for name, field in _GPS_FIELDS.items()}
    fixed = gps.has_fix("Status")
    series = gps.series({name: np.where(fixed, v, np.nan) for name, v in place.items()})
    if not all(name in every.mapped for name in ATTITUDE):
        attitude = every.needed(("ATT",), "has no messages ATT")
        angles = (attitude.field(name) for name in ("Roll", "Pitch", "Yaw"))
        series |= attitude.series(dict(zip(ATTITUDE, angles, strict=True)))
    series |= _first_battery(streams)
    notes = []
    if skipped:
        notes.append(f"the log is damaged: {skipped} of {len(content)} bytes are no messages")
    # Universal time of the boot [s since 1970], from GPS weeks and milliseconds.
    week, ms = gps.field("GWk", "Week"), gps.field("GMS", "TimeMS")
    known, gps_s = fixed & (week > 0.0), _GPS_EPOCH_S + _WEEK_S * week + 1e-3 * ms
    boot_s, middle = gps.boot_s(known, gps_s), float(np.median(gps_s[known]))
    boot_s -= max((ahead for since, ahead in _LEAP if middle - ahead >= since), default=14.0)
    return every.log(series, boot_s, notes, "the first battery monitor")


def _read_streams(content: bytes, names: set[str]) -> tuple[dict[str, Stream], int]:
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


def _split_by_instance(kind: _Kind, content: bytes) -> dict[str, Stream]:
    """Return the streams of a kind of message by name, one for each instance."""
    raw, at = np.frombuffer(content, np.uint8), np.array(kind.places)
    rows = raw[at[:, np.newaxis] + np.arange(kind.dtype.itemsize)]
    table = np.ascontiguousarray(rows).view(kind.dtype)[:, 0]
    fields = {f: table[f].astype(float) * s for f, s in kind.scales.items()}
    clock, step = ("TimeUS", 1e-6) if "TimeUS" in fields else ("TimeMS", 1e-3)
    if "Week" in fields and "T" in fields:  # GPS until 2014: TimeMS counts from the week's start
        clock = "T"
    if clock not in fields:
        return {}
    instance = next((fields[n] for n in _INSTANCES if n in fields), np.zeros(len(at)))
    streams = {}
    for number in np.unique(instance)[:16]:
        rows_of = instance == number
        name = kind.name if number == 0 else f"{kind.name}[{int(number)}]"
        rows_fields = {f: v[rows_of] for f, v in fields.items()}
        streams[name] = Stream(name, rows_fields[clock] * step, rows_fields).rising()
    return streams


def _first_battery(streams: Mapping[str, Stream]) -> dict[str, pd.Series]:
    """Return load [W] and state of charge by the first battery monitor."""
    battery = streams.get("BAT", streams.get("CURR"))
    if battery is None:
        return {}
    fields, result = battery.fields, {}
    if "Volt" in fields and "Curr" in fields:
        result["load_w"] = fields["Volt"] * fields["Curr"]
    if "RemPct" in fields:
        share = np.asarray(fields["RemPct"], float) / 100.0
        known = (share >= 0.0) & (share <= 1.0)
        result["state_of_charge"] = np.where(known, share, np.nan)
    return battery.series(result)
