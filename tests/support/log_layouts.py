"""Logs as different loggers write them: columns, units, separators, clocks, messages."""

import struct
from pathlib import Path
from zoneinfo import ZoneInfo

import numpy as np
import pandas as pd

CURRENT_A = 4.0  # of the first of two MPPTs that share the power


def _utc(table):
    return pd.to_datetime(table["time_utc"], utc=True)


def _epoch_us(table):
    return _utc(table).dt.tz_localize(None).astype("datetime64[us]").astype(np.int64)


def ground_station(table):
    """Commas, plain names without units, milliseconds since 1970."""
    columns = {
        "timestamp": _epoch_us(table) // 1000,
        "lat": table["latitude_deg"],
        "lon": table["longitude_deg"],
        "alt": table["altitude_m"],
        "roll": table["roll_deg"],
        "pitch": table["pitch_deg"],
        "heading": table["yaw_deg"] % 360.0,
        "P_solar": table["solar_power_w"],
        "SoC": table["state_of_charge"],
    }
    return pd.DataFrame(columns).to_csv(index=False)


def spreadsheet(table):
    """Semicolons, decimal commas, local date and time in two columns, kW and per cent."""
    local = _utc(table).dt.tz_convert(ZoneInfo("Europe/Zurich"))
    columns = {
        "Date": local.dt.strftime("%d.%m.%Y"),
        "Time": local.dt.strftime("%H:%M:%S.%f").str[:-3].str.replace(".", ","),
        "Latitude [°]": table["latitude_deg"],
        "Longitude [°]": table["longitude_deg"],
        "Altitude [ft]": table["altitude_m"] / 0.3048,
        "Bank angle [°]": table["roll_deg"],
        "Pitch [°]": table["pitch_deg"],
        "Heading [°]": table["yaw_deg"],
        "Solar power [kW]": table["solar_power_w"] / 1000.0,
        "SOC [%]": 100.0 * table["state_of_charge"],
        "Remark": "",
    }
    return pd.DataFrame(columns).to_csv(index=False, sep=";", decimal=",")


def telemetry(table):
    """Tabs, radians, integers of autopilots, voltage and milliamperes, microseconds."""
    volts = table["mppt_voltage_v"]
    columns = {
        "time_us": _epoch_us(table),
        "gps_lat": (1e7 * table["latitude_deg"]).round().astype(np.int64),
        "gps_lon": (1e7 * table["longitude_deg"]).round().astype(np.int64),
        "gps_alt": (1e3 * table["altitude_m"]).round().astype(np.int64),
        "phi": np.radians(table["roll_deg"]).round(6),
        "theta": np.radians(table["pitch_deg"]).round(6),
        "psi": np.radians(table["yaw_deg"]).round(6),
        "V_pv": volts,
        "I_pv_mA": 1e3 * table["solar_power_w"] / volts,
        "T_amb_K": table["ambient_temperature_c"] + 273.15,
    }
    return pd.DataFrame(columns).to_csv(index=False, sep="\t")


def own_names(table):
    """Bars, names that nobody can guess, American dates by a clock of India, two MPPTs."""
    local = _utc(table).dt.tz_convert("Asia/Kolkata")
    volts, first = table["mppt_voltage_v"], CURRENT_A
    columns = {
        "A": local.dt.strftime("%m/%d/%Y %I:%M:%S.%f %p"),
        "B": table["longitude_deg"],
        "C": table["latitude_deg"],
        "D": table["altitude_m"] / 1000.0,
        "E": np.radians(table["roll_deg"]),
        "F": -np.radians(table["pitch_deg"]),
        "G": np.radians(table["yaw_deg"]),
        "U1": volts,
        "I1": np.full(len(table), first),
        "U2": 1e3 * volts,
        "I2": table["solar_power_w"] / volts - first,
    }
    return pd.DataFrame(columns).to_csv(index=False, sep="|")


OWN_NAMES_MAP = Path(__file__).with_name("own_names.yaml").read_text("utf-8")

LAYOUTS = {
    "ground_station": ground_station,
    "spreadsheet": spreadsheet,
    "telemetry": telemetry,
    "own_names": own_names,
}


# Name: number, letters, fields.
Formats = dict[str, tuple[int, str, str]]
FORMATS = {
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "ATT": (130, "QccccCC", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
    "GPS": (131, "QBBIHBcLLe", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt"),
    "BAT": (132, "QBffB", "TimeUS,Inst,Volt,Curr,RemPct"),
    "MSG": (133, "QZ", "TimeUS,Message"),
}
# ArduPilot until 2014: milliseconds since boot, but those of the week in GPS.
FORMATS_2014 = {
    "FMT": FORMATS["FMT"],
    "ATT": (1, "IccccCC", "TimeMS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
    "GPS": (2, "BIHBcLLeeEefI", "Status,TimeMS,Week,NSats,HDop,Lat,Lng,RelAlt,Alt,Spd,GCrs,VZ,T"),
    "CURR": (9, "Ihhh", "TimeMS,Thr,Volt,Curr"),
}
PACKED = {"b": "b", "B": "B", "h": "h", "H": "H", "i": "i", "I": "I", "Q": "Q", "f": "f"}
PACKED |= {"c": "h", "C": "H", "e": "i", "L": "i", "E": "I", "n": "4s", "N": "16s", "Z": "64s"}


def message(name, *values, formats=FORMATS):
    number, letters, _ = formats[name]
    body = struct.pack("<" + "".join(PACKED[letter] for letter in letters), *values)
    return b"\xa3\x95" + bytes([number]) + body


def formats_of(formats=FORMATS):
    """Messages that describe all kinds of a DataFlash log."""
    out = b""
    for name, (number, letters, labels) in formats.items():
        length = 3 + struct.calcsize("<" + "".join(PACKED[letter] for letter in letters))
        row = (number, length, name.encode(), letters.encode(), labels.encode())
        out += message("FMT", *row)
    return out
