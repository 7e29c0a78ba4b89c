"""Flight logs with known truth, made without the project's sun, sky, cells or temperatures.

Sun: SPA (Reda & Andreas 2004). Sky: Ineichen & Perez (2002) with a Linke turbidity of 2 to 5, light
from the sky by Hay & Davies (1980). Incidence: refraction and absorption of a glass cover (De Soto
2006). Temperature: Faiman (2008). All are those of pvlib. Each flight has its place, day, circle,
wind, turbulence, a bias of the attitude of 0.3 deg and a drift of the power sensor of 1 %.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
import pvlib
from scipy.signal import lfilter

from sizing.aircraft import Aircraft
from solar.types import BoolArray, FloatArray

STEP_S = 4.0
_GRAVITY = 9.81
_ALBEDO = 0.2
_BATTERY_WH = 732.0
COEFFICIENT_PER_K = 0.0032
_U1, _WIND_M_PER_S = 3.0, 8.0  # of Faiman's temperature
_LOAD_W = 42.0


class Truth(NamedTuple):
    """What is wrong in a log: name of the cause, its size and where it acts."""

    cause: str = "nothing"
    size: float = 0.0
    start: float = 0.0  # share of the flight
    end: float = 1.0
    where: tuple[str, ...] = ()  # module surfaces, or a channel
    full: bool = False  # the battery becomes full


@dataclass(frozen=True)
class Flight:
    """One flight: rows as logged, and what is wrong with them."""

    rows: pd.DataFrame
    truth: Truth


def made(aircraft: Aircraft, truth: Truth, seed: int, *, by_side: bool = False) -> Flight:
    """Fly once; ``seed`` decides place, day, weather, circle and noise.

    ``by_side``: an MPPT for each side of the wing, each with a gain of its own, 1 %.
    """
    rng = np.random.default_rng(seed)
    place = drawn_place(rng)
    hours = rng.uniform(6.0, 10.0)
    elapsed = np.arange(0.0, 3600.0 * hours, STEP_S)
    start = place.noon + pd.Timedelta(hours=rng.uniform(-0.62, -0.4) * hours)
    times = start + pd.to_timedelta(elapsed, unit="s")
    share = elapsed / elapsed[-1]
    inside = (share >= truth.start) & (share <= truth.end)
    angles = angles_on_circles(elapsed, rng)
    air_c = rng.uniform(0.0, 28.0) + 4.0 * np.sin(np.pi * share)
    each = power_of_modules(aircraft, place, times, angles, air_c, truth, inside)
    whole = each.sum(axis=1)
    power = whole * (1.0 + 0.01 * rng.standard_normal() * (2.0 * share - 1.0))
    load = _LOAD_W + 1.5 * lasting_noise(rng.standard_normal(len(elapsed)), 60.0)
    power, charge, volts = _charged(power, load, truth, rng)
    power = power + rng.normal(0.0, 1.0, len(power))
    logged = biased(angles, rng)
    rows = pd.DataFrame(
        {
            "time_utc_s": times.as_unit("ns").asi8 / 1e9,
            "latitude_deg": place.latitude + rng.normal(0.0, 1e-5, len(elapsed)),
            "longitude_deg": place.longitude + rng.normal(0.0, 1e-5, len(elapsed)),
            "altitude_m": place.altitude + rng.normal(0.0, 3.0, len(elapsed)),
            **logged,
            "solar_power_w": power,
            "ambient_temperature_c": air_c,
            "mppt_voltage_v": volts,
            "load_w": load,
            "state_of_charge": charge,
        }
    )
    rows = _wrongly_logged(rows, truth, inside)
    if by_side:
        assert aircraft.modules.geometry is not None
        sides = np.array([surface.side for surface in aircraft.modules.geometry.surfaces])
        share = rows.pop("solar_power_w").to_numpy() / np.maximum(whole, 1e-9)
        for side in ("left", "centre", "right"):
            gain = 1.0 + 0.01 * rng.standard_normal()
            rows[f"solar_power_{side}_w"] = gain * share * each[:, sides == side].sum(axis=1)
    return Flight(rows, truth)


class Place(NamedTuple):
    """Where and when is flown, and under which sky."""

    latitude: float
    longitude: float
    noon: pd.Timestamp
    altitude: float
    turbidity: float


def drawn_place(rng: np.random.Generator) -> Place:
    """Place and day with the sun at 20 deg or higher at noon, and the sky of that day."""
    while True:
        latitude, longitude = rng.uniform(-50.0, 60.0), rng.uniform(-170.0, 170.0)
        day = pd.Timestamp("2024-01-01", tz="UTC") + pd.Timedelta(days=int(rng.uniform(0, 366)))
        noon = day + pd.Timedelta(hours=12.0 - longitude / 15.0)
        sun = pvlib.solarposition.spa_python(pd.DatetimeIndex([noon]), latitude, longitude)
        if float(sun["elevation"].iloc[0]) > 20.0 and abs(longitude) > 5.0:
            break
    return Place(latitude, longitude, noon, rng.uniform(200.0, 1500.0), rng.uniform(2.0, 5.0))


def lasting_noise(white: FloatArray, seconds: float) -> FloatArray:
    """Noise of unit variance that lasts so long."""
    keep = float(np.exp(-STEP_S / seconds))
    return np.asarray(lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], white), float)


def angles_on_circles(elapsed: FloatArray, rng: np.random.Generator) -> dict[str, FloatArray]:
    """Roll, pitch and yaw [deg] on circles in turbulence, to one side all the time."""
    speed, bank = rng.uniform(8.0, 12.0), rng.uniform(4.0, 15.0) * rng.choice([-1.0, 1.0])
    rate = np.degrees(_GRAVITY * np.tan(np.radians(bank)) / speed)
    gusts = [
        rng.uniform(0.5, 2.0) * lasting_noise(rng.standard_normal(len(elapsed)), 8.0) for _ in "abc"
    ]
    varied = 1.0 + 0.1 * lasting_noise(rng.standard_normal(len(elapsed)), 600.0)
    return {
        "roll": bank * varied + gusts[0],
        "pitch": rng.uniform(1.5, 4.0) + 0.5 * gusts[1],
        "yaw": rng.uniform(0.0, 360.0) + np.cumsum(rate * varied) * STEP_S + gusts[2],
    }


def biased(angles: dict[str, FloatArray], rng: np.random.Generator) -> dict[str, FloatArray]:
    """Angles as logged [deg], each with a bias of the whole flight."""
    wrong = {n: a + rng.normal(0.0, 0.3) + rng.normal(0.0, 0.2, len(a)) for n, a in angles.items()}
    wrong["yaw"] = wrong["yaw"] % 360.0
    return {f"{name}_deg": values for name, values in wrong.items()}


class Cells(NamedTuple):
    """Faiman's constant of the temperature, and light at which the efficiency is halved."""

    u0: float = 25.0
    halved_w_per_m2: float = 8.0

    @property
    def heat_transfer(self) -> float:
        """Light over the temperature above the air [W/(m2 K)]."""
        return self.u0 + _U1 * _WIND_M_PER_S


USUAL_CELLS = Cells()


def _normals(aircraft: Aircraft, angles: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Upward normals of the module surfaces, North-East-Down; from rotations about the axes."""
    geometry = aircraft.modules.geometry
    assert geometry is not None
    roll, pitch, yaw = (np.radians(angles[name]) for name in ("roll", "pitch", "yaw"))

    def turned_up(vector: FloatArray, angle: FloatArray | float) -> FloatArray:
        x, y, z = np.moveaxis(vector, -1, 0)
        c, s = np.cos(angle), np.sin(angle)
        return np.stack(np.broadcast_arrays(c * x + s * z, y, c * z - s * x), axis=-1)

    def rolled(vector: FloatArray, angle: FloatArray | float) -> FloatArray:
        x, y, z = np.moveaxis(vector, -1, 0)
        c, s = np.cos(angle), np.sin(angle)
        return np.stack(np.broadcast_arrays(x, c * y - s * z, s * y + c * z), axis=-1)

    found = {}
    for surface in geometry.surfaces:
        side = {"left": 1.0, "centre": 0.0, "right": -1.0}[surface.side]
        normal = turned_up(np.array([0.0, 0.0, -1.0]), np.radians(surface.pitch_deg))
        normal = rolled(normal, side * np.radians(surface.dihedral_deg))
        normal = turned_up(normal, np.radians(geometry.wing_incidence_deg))
        x, y, z = np.moveaxis(turned_up(rolled(normal, roll), pitch), -1, 0)
        c, s = np.cos(yaw), np.sin(yaw)
        found[surface.name] = np.stack([c * x - s * y, s * x + c * y, z], axis=-1)
    return found


def power_of_modules(
    aircraft: Aircraft,
    place: Place,
    times: pd.DatetimeIndex,
    angles: dict[str, FloatArray],
    air_c: FloatArray,
    truth: Truth,
    inside: BoolArray,
    cells: Cells = USUAL_CELLS,
) -> FloatArray:
    """Power of each surface behind the MPPTs [W] while the battery takes all of it."""
    where = (times, place.latitude, place.longitude, place.altitude)
    sun = pvlib.solarposition.spa_python(*where)
    zenith = sun["apparent_zenith"].to_numpy()
    mass = pvlib.atmosphere.get_relative_airmass(zenith)
    pressure = pvlib.atmosphere.alt2pres(place.altitude)
    extra = pvlib.irradiance.get_extra_radiation(times).to_numpy()
    turbidity = truth.size if truth.cause == "sky" else place.turbidity
    sky = pvlib.clearsky.ineichen(
        zenith,
        pvlib.atmosphere.get_absolute_airmass(mass, pressure),
        turbidity,
        altitude=place.altitude,
        dni_extra=extra,
    )
    dni, dhi = np.nan_to_num(sky["dni"]), np.nan_to_num(sky["dhi"])
    height, azimuth = np.radians(90.0 - zenith), np.radians(sun["azimuth"].to_numpy())
    to_sun = np.stack(
        [np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth), -np.sin(height)], -1
    )
    circumsolar = dni / extra  # Hay and Davies' anisotropy index
    modules = aircraft.modules
    assert modules.geometry is not None
    each = []
    for surface in modules.geometry.surfaces:
        normal = _normals(aircraft, angles)[surface.name]
        cosine = np.clip((normal * to_sun).sum(axis=-1), 0.0, 1.0)
        tilt = np.arccos(np.clip(-normal[:, 2], -1.0, 1.0))
        ratio = cosine / np.maximum(np.sin(height), 0.02)
        beam = (dni * cosine + dhi * circumsolar * ratio) * pvlib.iam.physical(
            np.degrees(np.arccos(cosine))
        )
        rest = dhi * (1.0 - circumsolar) * (1.0 + np.cos(tilt)) / 2.0
        ground = _ALBEDO * (dni * np.sin(height) + dhi) * (1.0 - np.cos(tilt)) / 2.0
        light = beam + 0.95 * (rest + ground)
        cell_c = pvlib.temperature.faiman(
            light, air_c, wind_speed=_WIND_M_PER_S, u0=cells.u0, u1=_U1
        )
        power = surface.area_m2 * modules.efficiency_stc * 0.97 * light
        power = power * (1.0 - COEFFICIENT_PER_K * (cell_c - 25.0))
        power = power * light / (light + cells.halved_w_per_m2)
        lost = inside & (surface.name in truth.where) & (truth.cause == "modules")
        each.append(np.where(lost, 1.0 - truth.size, 1.0) * power)
    rated = modules.efficiency_stc * modules.area_m2 * 1000.0
    left = _mppt(sum(each) / rated)
    if truth.cause in ("mppt", "power_loss"):
        left = np.where(inside, (1.0 - truth.size) * left, left)
    return np.asarray(np.maximum(left[:, np.newaxis] * np.stack(each, axis=1), 0.0))


def _mppt(load: FloatArray) -> FloatArray:
    """Efficiency of the MPPTs at a share of the rated power."""
    return np.asarray(0.965 - 0.9 / (1.0 + 400.0 * load))


MPPT_AT_STC = float(_mppt(np.array(1.0)))


def _charged(
    power: FloatArray, load: FloatArray, truth: Truth, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Power that load and battery take, state of charge and voltage of the MPPTs.

    The current falls from 88 % of charge on as at constant voltage; the state of charge is logged
    with an error of a per cent.
    """
    taken, charge = np.empty(len(power)), np.empty(len(power))
    capacity = _BATTERY_WH
    if not truth.full:  # never so full that it matters
        capacity = max(capacity, 1.9 * float((power - load).sum()) * STEP_S / 3600.0)
    state = 0.45 if truth.full else 0.3
    for i, (available, used) in enumerate(zip(power, load, strict=True)):
        limit = capacity * min(1.0, max(0.0, (1.0 - state) / 0.12))
        taken[i] = min(available, used + limit)
        state += 0.95 * (taken[i] - used) * STEP_S / 3600.0 / capacity
        charge[i] = state
    volts = 28.0 + 0.05 * rng.standard_normal(len(power)) + 3.0 * (taken < power - 1e-9)
    error = rng.normal(0.0, 0.01)
    return taken, np.clip(charge + error, 0.0, 1.0), volts


def _wrongly_logged(rows: pd.DataFrame, truth: Truth, inside: BoolArray) -> pd.DataFrame:
    """Rows with an error of clock, angles, units or a channel."""
    cause, size = truth.cause, truth.size
    if cause == "clock":
        rows["time_utc_s"] += 60.0 * size
    elif cause == "heading":
        rows["yaw_deg"] = (rows["yaw_deg"] + size) % 360.0
    elif cause in ("roll", "pitch"):
        rows[f"{cause}_deg"] += size
    elif cause in ("roll_sign", "pitch_sign"):
        rows[f"{cause.removesuffix('_sign')}_deg"] *= -1.0
    elif cause == "yaw_sign":
        rows["yaw_deg"] = -rows["yaw_deg"] % 360.0
    elif cause == "longitude_sign":
        rows["longitude_deg"] *= -1.0
    elif cause in ("gain", "unit", "power_sign"):
        rows["solar_power_w"] *= size
    elif cause == "saturation":
        highest = size * np.quantile(rows["solar_power_w"], 0.98)
        rows["solar_power_w"] = np.minimum(rows["solar_power_w"], highest)
    elif cause == "frozen":
        (channel,) = truth.where
        rows.loc[inside, channel] = rows.loc[inside, channel].iloc[0]
    return rows


_LEFT, _RIGHT = ("left front", "left rear"), ("right front", "right rear")
_CENTRE = ("centre front", "centre rear")

# Truths of a series of logs; other seeds are the same causes on other flights.
TRUTHS: tuple[Truth, ...] = (
    *(Truth() for _ in range(12)),
    *(Truth(full=True) for _ in range(7)),
    Truth("clock", 37.0),
    Truth("clock", 12.0),
    Truth("clock", -60.0),
    Truth("clock", 120.0),
    Truth("clock", 330.0),
    Truth("clock", 45.0, full=True),
    Truth("heading", 8.0),
    Truth("heading", -20.0),
    Truth("heading", 12.0, full=True),
    Truth("heading", 90.0),
    Truth("roll", 4.0),
    Truth("roll", -3.0),
    Truth("pitch", 4.0),
    Truth("pitch", -5.0),
    Truth("roll_sign"),
    Truth("pitch_sign"),
    Truth("yaw_sign"),
    Truth("longitude_sign"),
    Truth("unit", 1e-3),
    Truth("unit", 1e3),
    Truth("power_sign", -1.0),
    Truth("modules", 1.0, 0.35, where=_LEFT),
    Truth("modules", 1.0, 0.5, where=_CENTRE),
    Truth("modules", 1.0, 0.6, where=("right rear",)),
    Truth("modules", 1.0, 0.4, where=("centre front",), full=True),
    Truth("modules", 1.0, where=_RIGHT),
    Truth("modules", 0.5, 0.3, where=_RIGHT),
    Truth("modules", 0.4, where=_LEFT),
    Truth("mppt", 0.4, 0.4, 0.52),
    Truth("mppt", 0.2, 0.55, 0.7),
    Truth("mppt", 0.6, 0.3, 1.0),
    Truth("power_loss", 1.0, 0.5, 0.56),
    Truth("power_loss", 1.0, 0.3, 0.33),
    Truth("gain", 0.8),
    Truth("gain", 1.25),
    Truth("saturation", 0.8),
    Truth("frozen", where=("solar_power_w",), start=0.4, end=0.5),
    Truth("frozen", where=("yaw_deg",), start=0.6, end=0.7),
    Truth("frozen", where=("roll_deg",), start=0.3, end=0.5),
    Truth("sky", 8.0),
    Truth("sky", 7.0),
)
# First seeds: of series that were looked at while the causes were tuned, and of one that was not.
TUNING, HOLD_OUT = (1000, 2000, 3000), 4000
