"""Power of level flight that a log's load tells, and the key of an aircraft that has it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.stats import t

from missions.air import (
    MAXIMUM_ALTITUDE_M,
    MINIMUM_ALTITUDE_M,
    ZERO_CELSIUS_K,
    air_at,
    standard_air,
)
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.parameters import all_replaced, parameter_value
from solar.types import BoolArray, FloatArray
from studies.flight_logs.autocorrelation import correlation_time
from studies.flight_logs.fit import CONFIDENCE
from studies.flight_logs.forward import Forward

_BIN_S = 300.0
# Faster climbs need power of their own; 0.1 m/s of an aircraft of 7 kg takes 11 W; assumption.
_FASTEST_CLIMB_M_PER_S = 0.05
_SHORTEST_NIGHT_S, _LEAST_BINS = 3600.0, 6
_DRAG = "airframe.aerodynamics"


class LevelPower(NamedTuple):
    """Electric power of level flight in the air of the mission [W], its interval and its source."""

    value_w: float
    low_w: float
    high_w: float
    source: str


def level_power(forward: Forward, lit: BoolArray) -> LevelPower | str:
    """Power of level flight by the load, less that of avionics and payload; or why it is unknown.

    By night if there is one: thermals and work are of the day. At the density of the mission's air:
    the power of level flight falls with its square root.
    """
    log, mission = forward.log, forward.mission
    if log.load_w is not None:
        load, source = log.load_w, "load"
    elif log.battery_power_w is not None:
        load, source = log.solar_power_w - log.battery_power_w, "solar less battery power"
    else:
        return "neither load_w nor battery_power_w is logged"
    slot = np.floor((log.time_s - log.time_s[0]) / _BIN_S).astype(int)
    use, known = _level(log.time_s, log.altitude_m, slot), np.isfinite(load)
    if np.count_nonzero(known & ~lit) * log.step_s >= _SHORTEST_NIGHT_S:
        use, source = use & ~lit, f"{source} by night"
    use &= known
    height_m = np.clip(log.altitude_m[use], MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M)
    kelvin = forward.of(np.flatnonzero(use)).ambient_c()[0] + ZERO_CELSIUS_K
    density = air_at(kelvin, standard_air(height_m).pressure_pa).density_kg_per_m3
    mean_density = float(mission.air_state().density_kg_per_m3)
    rising = np.sqrt(mean_density / density) * (1.0 + mission.turbulence.all_day)
    try:
        constant_w = float(design_of(forward.aircraft, mission).constant_power_w)
    except ImpossibleDesignError as error:
        return str(error)
    means, bins = _means((load[use] - constant_w) / rising, slot[use])
    if len(means) < _LEAST_BINS:
        return f"less than {_LEAST_BINS * _BIN_S / 60:.0f} min of level flight with a load"
    mean = float(means.mean())
    run = np.cumsum(np.diff(bins, prepend=bins[0]) > 1).astype(int)
    count = len(means) / correlation_time(means - mean, run, 1)
    freedom = max(count - 1.0, 1.0)
    wide = float(t.ppf(0.5 + 0.5 * CONFIDENCE, freedom) * means.std() / np.sqrt(freedom))
    return LevelPower(mean, mean - wide, mean + wide, source)


def _means(values: FloatArray, slot: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean of the values in each slot that has some, and these slots."""
    slots, number = np.unique(slot, return_inverse=True)
    return np.bincount(number, values) / np.bincount(number), slots


def _level(time_s: FloatArray, altitude_m: FloatArray, slot: FloatArray) -> BoolArray:
    """Samples in slots over which the altitude changes no faster than in level flight."""
    mean_m, slots = _means(altitude_m, slot)
    mean_s, _ = _means(time_s, slot)
    if len(slots) < 2:
        return np.ones(len(slot), bool)
    slow = np.abs(np.gradient(mean_m, mean_s)) <= _FASTEST_CLIMB_M_PER_S
    return np.asarray(slow[np.searchsorted(slots, slot)])


def level_power_key(
    aircraft: Aircraft, mission: Mission, power_w: float
) -> tuple[str, float] | str:
    """Key of the aircraft's file, and its value that gives a power of level flight; or why none."""
    airframe = aircraft.airframe
    if isinstance(airframe, MeasuredAirframe):
        key = "airframe.level_flight.electric_power_w"
    elif airframe.aerodynamics.model == "parabolic":
        key = f"{_DRAG}.profile_drag_coefficient"
    else:
        key = f"{_DRAG}.calibration"
    value = parameter_value(aircraft, None, key)
    if value is None:
        return f"{aircraft.name} has no {key}"

    def apart(factor: float) -> float:
        changed = all_replaced(aircraft, {key: factor * value})
        return float(design_of(changed, mission).propulsion_power_w) - power_w

    try:
        return key, value * float(brentq(apart, 0.1, 10.0, xtol=1e-6))
    except ValueError:  # no sign changes between them
        return f"no {key} from a tenth to ten times that of the file gives it"
