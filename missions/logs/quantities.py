"""Quantities of a log: dimension, what they can be, whether they may rest, names elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from missions.logs.units import Dimension

TIME, EPOCH = "time_utc", "time_utc_s"
ATTITUDE = ("roll_deg", "pitch_deg", "yaw_deg")
TRACKER = "solar_power_w: "  # power of one of several MPPTs, before its own name


class Quantity(NamedTuple):
    """What may be in a log, least and most that it can be in the unit of the log format.

    ``rests``: whether one value may stay for minutes in flight. ``aliases``: names that it goes by
    elsewhere, likeliest first, in lower case without anything between words and without a unit.
    """

    dimension: Dimension
    low: float
    high: float
    rests: bool
    aliases: str


def quantity_of(column: str) -> str:
    """Quantity of a column: the power of one of several MPPTs has its name behind that."""
    return column.partition(":")[0]


# A place, an altitude held to the metre, a full battery, the air and the voltage of an MPPT may
# rest; power and attitude never do. Times: where the almanac behind the sun's position
# holds. Air: the highest on record is 56.7 C (World Meteorological Organization).
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
