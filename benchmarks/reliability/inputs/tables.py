"""Cases of flight logs and of weather files of every layout."""

from __future__ import annotations

import gzip
import random
import struct
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.reliability.inputs.cases import Case
from benchmarks.reliability.inputs.mutations import bytes_changed, text_changed

__all__ = ["example_log", "log_csv", "log_ulog", "weather", "weather_layouts"]

_AIRCRAFT = "atlantiksolar-as2"


# ---- logs


def example_log() -> bytes:
    """A log that nothing is wrong with."""
    return _log_text(20, 2.0).encode()


def log_csv(rng: random.Random) -> Case:
    """Flight log as CSV, changed as text or as bytes."""
    text = _log_text(rng.choice((20, 60, 200)), rng.choice((0.5, 2.0, 60.0, 600.0)))
    if rng.random() < 0.1:
        text = text.replace(",", rng.choice((";", "\t", " ")))
    content = text_changed(text, rng).encode("utf-8", "surrogatepass")
    if rng.random() < 0.15:
        content = bytes_changed(content, rng)
    return _verified("log.csv", content, rng)


def log_ulog(rng: random.Random) -> Case:
    """PX4 ULog with other topics, fields, values or bytes."""
    content = _ulog(_topics(rng))
    if rng.random() < 0.7:
        content = bytes_changed(content, rng)
    return _verified("log.ulg", content, rng)


def _verified(name: str, content: bytes, rng: random.Random) -> Case:
    way = rng.random()
    arguments = ("verify", _AIRCRAFT, name)
    if way < 0.7:
        return Case((*arguments, "--json"), {name: content}, json=True)
    if way < 0.9:
        return Case((*arguments, "--window", "0:24", "--filter", "1"), {name: content})
    return Case((*arguments, "--filter", "0", "--json"), {name: content}, json=True)


@cache
def _log_text(count: int, step_s: float) -> str:
    lines = [
        "time_utc,latitude_deg,longitude_deg,altitude_m,roll_deg,pitch_deg,yaw_deg,"
        "ambient_temperature_c,solar_power_w,mppt_voltage_v,load_w,state_of_charge"
    ]
    begin = np.datetime64("2015-07-01T07:30:00.000")
    for i in range(count):
        time = begin + np.timedelta64(round(1000.0 * i * step_s), "ms")
        yaw = (i * step_s * 5.0) % 360.0
        values = [47.6, 8.53, 536.0, 10.0, 2.0, round(yaw, 2), 25.0, 150.0 + i / 10, 22.0, 40.0]
        lines.append(",".join([f"{time}Z", *map(str, values), f"{0.5 + i / 1000:.4f}"]))
    return "\n".join(lines) + "\n"


def _topics(rng: random.Random) -> dict[str, dict[str, Any]]:
    """Topics of a flight, some of them lacking, doubled or strange."""
    count = rng.choice((1, 2, 24, 60))
    micros = (100_000_000 + 500_000 * np.arange(count)).astype(np.uint64)
    full = np.ones(count)
    utc = np.uint64(1435735800_000000) + micros
    position: dict[str, Any] = {
        **{"timestamp": micros, "time_utc_usec": utc, "fix_type": np.full(count, 3, np.uint8)},
        **{"latitude_deg": 47.6 * full, "longitude_deg": 8.53 * full, "altitude_msl_m": 536 * full},
    }
    if rng.random() < 0.3:
        position |= {"lat": (476000000 * full).astype(np.int32)}
        position |= {"lon": (85300000 * full).astype(np.int32)}
        position |= {"alt": (536000 * full).astype(np.int32)}
    found: dict[str, dict[str, Any]] = {
        "sensor_mppt": {
            **{"timestamp": micros, "mppt_volt[0]": 20.0 * full, "mppt_amp[0]": 2.0 * full}
        },
        "vehicle_attitude": {
            **{"timestamp": micros, "q[0]": full, "q[1]": 0 * full},
            **{"q[2]": 0.0 * full, "q[3]": 0.1 * full},
        },
        "vehicle_gps_position": position,
        "battery_status": {
            **{"timestamp": micros, "voltage_v": 24.0 * full, "current_a": 2.0 * full},
            "remaining": 0.8 * full,
        },
        "airspeed": {"timestamp": micros, "true_airspeed_m_s": 9.0 * full},
    }
    for _ in range(rng.choice((0, 1, 1, 2, 3))):
        topic = rng.choice(sorted(found))
        field = rng.choice(sorted(found[topic]))
        way, values = rng.random(), found[topic][field]
        if way < 0.1 and len(found) > 1:
            del found[topic]
        elif way < 0.3 and len(found[topic]) > 1:
            del found[topic][field]
        elif values.dtype.kind == "f":
            odd = rng.choice((np.nan, np.inf, -np.inf, 0.0, -1.0, 1e38, 1e-40, 1e6))
            where = rng.choice((slice(None), slice(0, 1), slice(None, None, 2)))
            found[topic][field] = values.copy()
            found[topic][field][where] = odd
        else:
            whole = np.roll(values, 1) if way < 0.6 else values * np.int64(rng.choice((0, 1, 1000)))
            found[topic][field] = whole.astype(values.dtype)
    return found


def _ulog(content: dict[str, dict[str, Any]]) -> bytes:
    """ULog file after the format's specification: header, definitions, data."""
    types = {"u8": ("uint64_t", "Q"), "u1": ("uint8_t", "B"), "i4": ("int32_t", "i")}
    types |= {"f8": ("float", "f")}
    out = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)
    heads: list[tuple[bytes, bytes]] = []
    bodies: list[tuple[bytes, bytes]] = []
    for number, (name, fields) in enumerate(content.items()):
        kinds = [np.asarray(v).dtype.str[1:] for v in fields.values()]
        bases = [field.split("[")[0] for field in fields]
        spelled = []
        for field, base, kind in zip(fields, bases, kinds, strict=True):
            if "[" not in field:
                spelled.append(f"{types[kind][0]} {field}")
            elif field == next(f for f in fields if f.startswith(f"{base}[")):
                spelled.append(f"{types[kind][0]}[{bases.count(base)}] {base}")
        heads.append((b"F", f"{name}:{';'.join(spelled)};".encode()))
        bodies.append((b"A", struct.pack("<BH", 0, number) + name.encode()))
        layout = "<" + "".join(types[kind][1] for kind in kinds)
        for values in zip(*(np.asarray(v).tolist() for v in fields.values()), strict=True):
            bodies.append((b"D", struct.pack("<H", number) + _packed(layout, values)))
    for kind_byte, body in (*heads, *bodies):
        out += struct.pack("<H", len(body)) + kind_byte + body
    return out


def _packed(layout: str, values: tuple[Any, ...]) -> bytes:
    return struct.pack(
        layout, *(float(np.float32(v)) if isinstance(v, float) else v for v in values)
    )


# ---- weather


def weather_layouts() -> tuple[str, ...]:
    """Names of the layouts that are written."""
    return tuple(_seeds())


def weather(layout: str) -> Callable[[random.Random], Case]:
    """Maker of cases of one layout.

    Parameters
    ----------
    layout : str
        One of :func:`weather_layouts`.
    """

    def made(rng: random.Random) -> Case:
        name, content = _seeds()[layout]
        separator = ":" if name.endswith(".json") else " " if layout in ("BSRN", "TMY2") else ","
        if rng.random() < 0.85:
            text = content.decode("latin-1")
            if name.endswith(".json") and rng.random() < 0.8:
                text = text.replace(", ", ",\n")
            content = text_changed(text, rng, separator=separator).encode("utf-8", "surrogatepass")
        else:
            content = bytes_changed(content, rng)
        if rng.random() < 0.05:
            content = gzip.compress(content, 1)
            if rng.random() < 0.5:
                content = bytes_changed(content, rng)
        return Case(("analyse", _AIRCRAFT, "--weather", name, "--json"), {name: content}, json=True)

    return made


@cache
def _seeds() -> dict[str, tuple[str, bytes]]:
    """A few days of every layout, as their makers write them: file name and content."""
    # The tests' writers of weather files: they stand beside the benchmarks in the source tree.
    import importlib.util

    place = Path(__file__).parents[3] / "tests" / "support" / "weather_files.py"
    spec = importlib.util.spec_from_file_location("weather_files", place)
    if spec is None or spec.loader is None:
        raise RuntimeError(f"{place} is needed")
    writers = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(writers)
    days = writers.clear_record(days=3)
    minutes = writers.clear_record(days=1, first="2001-06-20", interval_s=600.0)
    utc = writers.clear_record(days=3, site=replace(writers.SITE, utc_offset_h=0.0))
    # pvlib's reader takes whole years alone.
    year = writers.clear_record(days=365, first="2001-01-01", site=utc.site)
    made: dict[str, tuple[str, bytes]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for layout, name, write, record in (
            ("CSV", "w.csv", writers.write_plain, days),
            ("EPW", "w.epw", writers.write_epw, days),
            ("PVGIS EPW", "p.epw", writers.write_pvgis_tmy_epw, days),
            ("PVGIS typical year", "t.csv", writers.write_pvgis_tmy, year),
            ("PVGIS typical year, JSON", "t.json", writers.write_pvgis_tmy_json, utc),
            ("PVGIS hourly", "h.csv", writers.write_pvgis_hourly, utc),
            ("NSRDB PSM", "n.csv", writers.write_psm, minutes),
            ("BSRN", "b.dat", writers.write_bsrn, _of_a_month(writers)),
        ):
            made[layout] = name, write(Path(folder) / name, record).read_bytes()
    made["TMY2"] = "w.tm2", _tmy2(days)
    made["TMY3"] = "w.tmy3.csv", _tmy3(days)
    return made


def _of_a_month(writers: Any) -> Any:
    """Minutes of the first two days of a month."""
    site = replace(writers.SITE, utc_offset_h=0.0)
    return writers.clear_record(days=2, first="2001-06-01", interval_s=60.0, site=site)


def _local(record: Any) -> Any:
    return (
        (record.start_s + 3600.0 * record.site.utc_offset_h).astype("datetime64[s]").astype(object)
    )


def _tmy2(record: Any) -> bytes:
    """TMY2, fixed columns: Marion and Urban (1995), User's Manual for TMY2s, table 3-2."""
    lines = [" 13963 SOMEWHERE              ZH   1 N 46 48 E   6 54   491"]
    for t, g, b, d in zip(_local(record), record.ghi, record.dni, record.dhi, strict=True):
        line = f" {t.year % 100:2d}{t.month:2d}{t.day:2d}{t.hour + 1:2d}{1300:4d}{1000:4d}"
        for value in (g, b, d):
            line += f"{round(value):4d}A7"
        line += "".join(f"{0:4d}A7" for _ in range(4))  # four illuminances
        line += " 0A7 0A7 150A7  50A7 50A7 950A7180A7 30A7 241A777777A7"
        line += "9999999999200E7 50F8  0A7 0A7"
        lines.append(line)
    return ("\n".join(lines) + "\n").encode()


def _tmy3(record: Any) -> bytes:
    """TMY3: Wilcox and Marion (2008), Users Manual for TMY3 Data Sets, table 1-1."""
    site = record.site
    names = (
        "Date (MM/DD/YYYY),Time (HH:MM),ETR (W/m^2),ETRN (W/m^2),GHI (W/m^2),GHI source,"
        "GHI uncert (%),DNI (W/m^2),DNI source,DNI uncert (%),DHI (W/m^2),DHI source,"
        "DHI uncert (%),Dry-bulb (C),Dry-bulb source,Dry-bulb uncert (code),Wspd (m/s),"
        "Wspd source,Wspd uncert (code)"
    )
    lines = [f'700000,"SOMEWHERE",ZH,1.0,{site.latitude_deg},{site.longitude_deg},491', names]
    for t, g, b, d in zip(_local(record), record.ghi, record.dni, record.dhi, strict=True):
        light = f"{g:.0f},1,8,{b:.0f},1,8,{d:.0f},1,8"
        stamp = f"{t:%m/%d/%Y},{t.hour + 1:02d}:00"
        lines.append(f"{stamp},1300,1360,{light},15.0,A,7,3.0,A,7")
    return ("\n".join(lines) + "\n").encode()
