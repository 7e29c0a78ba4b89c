"""Synthetic flight logs with known truth, to test what a verification finds.

The flight is that of Oettershagen's report: AtlantikSolar AS-2 on 30 June and 1 July 2015,
loitering on a circle in an easterly wind of 2 m/s. The Full Model is the truth; bias, noise and
faults are put on it on purpose. The log is what instruments would write: its attitude carries a
measurement error that the truth does not know.
"""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from scipy.signal import lfilter

from missions.flight_path import Circle, orbit
from missions.logs.table import EulerAngles, FlightLog
from sizing.day.module_power import on_path
from studies.flight_logs.forward import Forward

Period = tuple[float, float]

START_UTC_S = 1435655640.0  # 30 June 2015, 09:14 UTC: the launch
DURATION_H = 28.35
_EARTH_RADIUS_M = 6371000.0
_NIGHT_LOAD_W = 43.0
_BATTERY_ENERGY_WH = 732.0
_MPPT_V = 20.0
_GUST_S = 2.0  # over which gusts are correlated


@dataclass(frozen=True)
class Faults:
    """What to put into a log; periods are hours since its start.

    ``mppt``: the MPPT loses the maximum power point while the irradiance is below 250 W/m2.
    ``battery_full``: power is limited to load and a dwindling charge, with the charge near full.
    """

    mppt: Period | None = None
    battery_full: Period | None = None
    missing: Period | None = None


@dataclass(frozen=True)
class Settings:
    """Length, rate and noise of a log; modelled is ``1 + bias`` times measured power."""

    start_utc_s: float = START_UTC_S
    duration_h: float = DURATION_H
    rate_hz: float = 2.0
    seed: int = 0
    bias: float = 0.0
    jitter_deg: float = 1.5
    attitude_error_deg: float = 0.2
    power_noise_w: float = 1.0
    faults: Faults = field(default_factory=Faults)


def synthetic_log(aircraft, mission, settings):
    """Rows in the CSV format of what instruments would write on the mission's circle, or on one."""
    rng = np.random.default_rng(settings.seed)
    count = int(settings.duration_h * 3600.0 * settings.rate_hz) + 1
    time_s = settings.start_utc_s + np.arange(count) / settings.rate_hz
    mission = on_path(aircraft, mission)
    flown = _flown(mission, time_s, settings, rng)
    truth = _truth(aircraft, mission, flown)
    return _instruments(flown, truth, settings, rng)


def _flown(mission, time_s, settings, rng):
    """The truth of the flight but for its power."""
    path, elapsed = mission.flight_path, time_s - time_s[0]
    if not isinstance(path, Circle):
        path = Circle(radius_m=100.0, airspeed_m_per_s=8.6)
    path = path.model_copy(update={"direction": "clockwise"})
    loop = orbit(path, mission.wind, samples=360)

    def at(values):
        return np.asarray(np.interp(elapsed, loop.time_s, values, period=loop.duration_s), float)

    def jitter(share):
        return np.asarray(np.radians(share * settings.jitter_deg) * _gusts(elapsed, rng))

    # Sine and cosine, since the angle itself jumps by a turn.
    yaw = np.arctan2(at(np.sin(loop.yaw_rad)), at(np.cos(loop.yaw_rad)))
    attitude = (at(loop.roll_rad) + jitter(1.0), at(loop.pitch_rad) + jitter(0.5))
    latitude, metres_per_deg = float(np.mean(mission.latitudes())), np.radians(_EARTH_RADIUS_M)
    east = at(loop.east_m) / (metres_per_deg * np.cos(np.radians(latitude)))
    none, air_c = np.zeros(len(time_s)), float(mission.air_state().temperature_c)
    return FlightLog(
        source="truth", time_s=time_s, latitude_deg=latitude + at(loop.north_m) / metres_per_deg,
        longitude_deg=(mission.longitude_deg or 0.0) + east, altitude_m=none + mission.altitude_m,
        solar_power_w=none, attitude=EulerAngles(*attitude, yaw + jitter(1.0)),
        ambient_temperature_c=none + air_c, rows_read=0, rows_dropped=0, gaps=(), notes=(),
    )  # fmt: skip


def _gusts(elapsed, rng):
    """Noise of unit variance that keeps most of itself from sample to sample."""
    keep = float(np.exp(-(elapsed[1] - elapsed[0]) / _GUST_S))
    white = rng.standard_normal(len(elapsed))
    return np.asarray(lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], white), float)


def _truth(aircraft, mission, flown):
    """Power [W] and irradiance [W/m2] of the Full Model in the true attitude, without shading."""
    modules = aircraft.modules.model_copy(update={"shading_loss": "none"})
    bare = aircraft.model_copy(update={"modules": modules})
    parts = []
    for part in Forward(flown, bare, mission, np.arange(len(flown))).chunks():
        power, light = part.power_w(), part.full(part.sunlight()).irradiance_w_per_m2
        parts.append((power, np.where(power > 0.0, light, 0.0)))
    power, light = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return power, light


def _instruments(flown, truth, settings, rng):
    count, faults = len(flown), settings.faults
    elapsed = flown.time_s - flown.time_s[0]
    hours, attitude, (power, light) = elapsed / 3600.0, flown.attitude, truth
    power, load = power / (1.0 + settings.bias), _NIGHT_LOAD_W + 2.0 * _gusts(elapsed, rng)
    volts = _MPPT_V + 0.15 * rng.standard_normal(count)
    lost = _within(hours, faults.mppt) & (light < 250.0)
    power = np.where(lost, 0.45 * power, power)
    volts = np.where(lost, volts - 4.0 - 3.0 * np.abs(_gusts(elapsed, rng)), volts)
    full = _within(hours, faults.battery_full)
    if faults.battery_full is not None:
        begin, end = faults.battery_full
        charge_w = 60.0 * np.clip((end - hours) / (end - begin), 0.0, 1.0)
        power = np.where(full, np.minimum(power, load + charge_w), power)
    noisy = power + settings.power_noise_w * rng.standard_normal(count)
    stored = 0.577 + np.cumsum(noisy - load) / (_BATTERY_ENERGY_WH * 3600.0 * settings.rate_hz)
    # Near full without limited power as well: the charge alone must not make a finding.
    charge = np.where(full, 0.97, np.clip(stored, 0.05, 0.95))

    def measured_deg(angle):
        error = settings.attitude_error_deg * rng.standard_normal(count)
        return np.round((np.degrees(angle) + error + 180.0) % 360.0 - 180.0, 3)

    utc = np.round(flown.time_s * 1e3).astype("datetime64[ms]")
    table = pd.DataFrame(
        {
            "time_utc": np.strings.add(np.datetime_as_string(utc), "Z"),
            "latitude_deg": np.round(flown.latitude_deg, 7),
            "longitude_deg": np.round(flown.longitude_deg, 7),
            "altitude_m": np.round(flown.altitude_m + rng.normal(0.0, 1.0, count), 2),
            "roll_deg": measured_deg(attitude.roll_rad),
            "pitch_deg": measured_deg(attitude.pitch_rad),
            "yaw_deg": measured_deg(attitude.yaw_rad),
            "solar_power_w": np.round(noisy, 3),
            "ambient_temperature_c": flown.ambient_temperature_c,
            "mppt_voltage_v": np.round(volts, 3),
            "load_w": np.round(load, 2),
            "state_of_charge": np.round(charge, 4),
        }
    )
    return table[~_within(hours, faults.missing)].reset_index(drop=True)


def _within(hours, period):
    if period is None:
        return np.zeros(len(hours), bool)
    return np.asarray((hours >= period[0]) & (hours < period[1]), bool)
