"""Quantities of a log: possible ranges, names elsewhere, units, and units told by the values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np

from solar.types import FloatArray

Dimension = Literal[
    "time", "angle", "length", "power", "voltage", "current", "temperature", "share"
]
TIME, EPOCH = "time_utc", "time_utc_s"
ATTITUDE = ("roll_deg", "pitch_deg", "yaw_deg")
MPPT = "solar_power_w: "  # power of one of several MPPTs, before its own name


class Quantity(NamedTuple):
    """Quantity of a log: dimension, lowest and highest possible value in its unit.

    ``rests``: whether one value may stay for minutes in flight. ``aliases``: names that it goes by
    elsewhere, likeliest first, in lower case without anything between words and without a unit.
    """

    dimension: Dimension
    low: float
    high: float
    rests: bool
    aliases: str


def quantity_of(column: str) -> str:
    """Return the quantity of a column; the power of an MPPT has its name behind it."""
    return column.partition(":")[0]


# Position, an altitude held to the metre, a full battery, the air and an MPPT's voltage may be
# constant; power and attitude never are. Times: range of the almanac of the sun's position. Air:
# the highest on record is 56.7 C (World Meteorological Organization).
QUANTITIES: Mapping[str, Quantity] = {
    "time": Quantity("time", -631152000.0, 2524608000.0, False,
        "time timestamp datetime utc timeutc utctime gpstime timegps epoch unixtime timeunix unix "
        "localtime timelocal clock t"),
    "latitude_deg": Quantity("angle", -90.0, 90.0, True,
        "latitude lat gpslat gpslatitude latgps poslat"),
    "longitude_deg": Quantity("angle", -180.0, 180.0, True,
        "longitude lon lng long gpslon gpslongitude longps gpslng poslon"),
    "altitude_m": Quantity("length", -500.0, 32000.0, True,
        "altitude alt altitudemsl altmsl amsl gpsalt gpsaltitude altgps altitudeamsl "
        "altamsl posalt"),
    "roll_deg": Quantity("angle", -180.0, 180.0, False,
        "roll rollangle phi bank bankangle attroll attituderoll"),
    "pitch_deg": Quantity("angle", -90.0, 90.0, False,
        "pitch pitchangle theta attpitch attitudepitch"),
    "yaw_deg": Quantity("angle", -360.0, 360.0, False,
        "yaw yawangle psi heading trueheading hdg attyaw attitudeyaw"),
    "solar_power_w": Quantity("power", -1e3, 1e6, False,
        "solarpower powersolar psolar pvpower powerpv ppv mpptpower powermppt pmppt solar "
        "arraypower parray solararraypower psun"),
    "solar_voltage_v": Quantity("voltage", -1.0, 1e4, True,
        "solarvoltage voltagesolar vsolar usolar pvvoltage vpv upv mpptvoltage mpptvolt vmppt"),
    "solar_current_a": Quantity("current", -1e3, 1e5, False,
        "solarcurrent currentsolar isolar pvcurrent ipv mpptcurrent mpptamp imppt"),
    "ambient_temperature_c": Quantity("temperature", -100.0, 57.0, True,
        "ambienttemperature ambienttemp airtemperature airtemp tamb tambient tair oat "
        "outsideairtemperature outsideairtemp temperature temp"),
    "mppt_voltage_v": Quantity("voltage", -1.0, 1e4, True,
        "mpptvoltage mpptvolt vmppt umppt"),
    "load_w": Quantity("power", -1e6, 1e6, False,
        "load loadpower powerload pload consumption powerconsumption consumedpower pout ptotal"),
    "state_of_charge": Quantity("share", -0.05, 1.05, True,
        "stateofcharge soc batterysoc socbattery batsoc batteryremaining remaining chargestate "
        "batterypercent batpercent batterylevel"),
    "battery_power_w": Quantity("power", -1e6, 1e6, False,
        "batterychargepower chargepower"),
}  # fmt: skip


class Unit(NamedTuple):
    """Unit: written values times ``factor`` plus ``offset`` are in the unit of the log format."""

    factor: float
    offset: float = 0.0


_DEG = 180.0 / np.pi
_FOOT = 0.3048  # international foot of 1959
# Usual spellings; files may have them in any case. Angles are degrees in log files.
_SPELLINGS: Mapping[Dimension, Mapping[str, Unit]] = {
    "time": {
        "s sec seconds": Unit(1.0), "ms": Unit(1e-3), "us µs": Unit(1e-6), "ns": Unit(1e-9),
        "min": Unit(60.0), "h": Unit(3600.0),
    },
    "angle": {
        "deg degree degrees °": Unit(1.0), "rad radian radians": Unit(_DEG),
        "mrad": Unit(1e-3 * _DEG), "cdeg": Unit(1e-2), "degE7 E7 1e-7deg": Unit(1e-7),
    },
    "length": {
        "m metre metres meter meters": Unit(1.0), "km": Unit(1e3), "cm": Unit(1e-2),
        "mm": Unit(1e-3), "ft feet": Unit(_FOOT),
    },
    "power": {"W watt watts": Unit(1.0), "kW": Unit(1e3), "mW": Unit(1e-3)},
    "voltage": {"V volt volts": Unit(1.0), "mV": Unit(1e-3), "kV": Unit(1e3)},
    "current": {"A amp amps ampere": Unit(1.0), "mA": Unit(1e-3), "cA": Unit(1e-2)},
    "temperature": {
        "C degC °C celsius": Unit(1.0), "K kelvin": Unit(1.0, -273.15),
        "F degF": Unit(5.0 / 9.0, -160.0 / 9.0),
    },
    "share": {"- 1 share": Unit(1.0), "% percent pct": Unit(1e-2)},
}  # fmt: skip
# Units of a dimension, and of all, which share no spelling, in lower case; None is the log
# format's unit.
UNITS: Mapping[Dimension, Mapping[str, Unit]] = {
    dimension: {name.lower(): unit for names, unit in known.items() for name in names.split()}
    for dimension, known in _SPELLINGS.items()
}
SCALES: Mapping[str | None, Unit] = {
    None: Unit(1.0), **{name: unit for known in UNITS.values() for name, unit in known.items()}
}  # fmt: skip
SPELLED = {n.lower(): n for known in _SPELLINGS.values() for names in known for n in names.split()}
_TWO_PI = 2.0 * np.pi


def known_unit(text: str, *dimensions: Dimension) -> str | None:
    """Return the spelling of a unit in :data:`UNITS`, None if of none of the dimensions."""
    plain = text.strip().strip("[]()").strip()
    if plain == "MW":  # else it would be read as mW
        return None
    plain = plain.lower().replace("°deg", "°")
    return plain if any(plain in UNITS[dimension] for dimension in dimensions) else None


def split_unit(name: str) -> tuple[str, str | None]:
    """Split a column's name from the unit behind it, in brackets or after a spaced slash."""
    for pattern in (r"(.*\S)\s*[\[(]([^\[\]()]*)[\])]", r"(.*\S)\s+/\s+(\S+)"):
        if match := re.fullmatch(pattern, name.strip()):
            return match[1], match[2].strip()
    return name.strip(), None


def recognised(quantity: str, dimension: Dimension, values: FloatArray) -> str | None:
    """Return the unit that the values prove, None if they may be in the log format's."""
    known = values[np.isfinite(values)]
    if not len(known):
        return None
    largest, median = float(np.abs(known).max()), float(np.median(known))
    whole = bool(np.all(known == np.round(known)))
    if quantity in ("latitude_deg", "longitude_deg"):
        # Integers of 1e-7 degrees are what GPS receivers and autopilots write.
        return "dege7" if whole and 1e4 < largest <= 1.8e9 else None
    if dimension == "length":
        return "mm" if whole and largest > 32_000.0 else None
    if dimension == "share":
        return "%" if 1.5 < largest <= 105.0 else None
    if dimension == "temperature":
        return "k" if median > 150.0 else None
    return None


def in_radians(roll: FloatArray, pitch: FloatArray, yaw: FloatArray) -> bool:
    """Return true if three columns without a unit can be an attitude in radians."""
    angles = [a[np.isfinite(a)] for a in (roll, pitch, yaw)]
    if any(not len(a) for a in angles):
        return False
    within = all(float(np.abs(a).max()) <= _TWO_PI + 1e-3 for a in angles)
    return within and float(np.ptp(angles[2])) > 3.0


def surely_radians(roll: FloatArray, pitch: FloatArray, yaw: FloatArray) -> bool:
    """Return true if the yaw fills and jumps by a turn of 2 pi: surely radians."""
    if not in_radians(roll, pitch, yaw):
        return False
    known = yaw[np.isfinite(yaw)]
    edge = float(np.abs(known).max())
    full = 0.95 * np.pi < edge <= np.pi + 1e-3 or 1.9 * np.pi < edge <= _TWO_PI + 1e-3
    jumps = np.abs(np.abs(np.diff(known)) - _TWO_PI) < 0.25 * _TWO_PI
    return bool(full and jumps.sum() >= 2 and np.ptp(known) > 0.9 * _TWO_PI)
