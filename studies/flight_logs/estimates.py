"""Estimates of clock, heading and powers of a log, with intervals and the options to apply them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.stats import t

from missions import air
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.parameters import all_replaced, parameter_value
from solar.schema import spell
from solar.types import FloatArray, IntArray
from studies.flight_logs.fit import CONFIDENCE, Fit, correlation_time
from studies.flight_logs.forward import Forward

# Half-widths of intervals beyond which a value counts as unknown [min, deg].
_UNKNOWN_MIN, _UNKNOWN_DEG = 120.0, 45.0
_LEVEL_DEG = 3.0  # bank below which circles do not turn the modules through the light
# Factors on power that are due to a unit, not to a sensor or module.
_UNITS = ((1e-3, "kW"), (1e3, "mW"))
_EFFICIENCY, _DRAG = "modules.efficiency_stc", "airframe.aerodynamics"
# Faster climbs need extra power: 11 W for 0.1 m/s at 7 kg; assumption.
_FASTEST_CLIMB_M_PER_S = 0.05
_BIN_S, _SHORTEST_NIGHT_S, _LEAST_BINS = 300.0, 3600.0, 6
LABELS = {
    "clock_offset": ("clock ahead of universal time", "min", "+.1f"),
    "heading_offset": ("heading logged too large", "deg", "+.1f"),
    "solar_factor": ("measured over modelled power", "", ".3f"),
    "level_power": ("power of level flight", "W", ".1f"),
}


class Estimate(NamedTuple):
    """Estimated number with the ends of its interval; None and ``why`` if unknown.

    ``apply``: options that apply it, empty without.
    """

    name: str
    value: float | None
    low: float | None
    high: float | None
    unit: str
    apply: tuple[str, ...]
    why: str

    def texts(self) -> tuple[str, str, str]:
        """Return words, value and interval."""
        label, unit, form = LABELS[self.name]
        if self.value is None:
            return label, "-", "-"
        interval = f"{self.low:{form}} to {self.high:{form}}"
        return label, f"{self.value:{form}} {unit}".strip(), interval


class Applied(NamedTuple):
    """Offsets that were subtracted from the log: minutes, degrees."""

    clock_min: float = 0.0
    heading_deg: float = 0.0


def estimates(
    forward: Forward, daylight: IntArray, fit: Fit | None, applied: Applied
) -> tuple[Estimate, ...]:
    """Estimate clock, heading, factor on solar power, and power of level flight."""
    return (*_estimates_of_fit(forward, fit, applied), _estimate_level_power(forward, daylight))


def _estimate(name: str, *interval: float, apply: tuple[str, ...] = (), why: str = "") -> Estimate:
    """Make an estimate of a value and the ends of its interval, or of none."""
    value, low, high = interval or (None, None, None)
    return Estimate(name, value, low, high, LABELS[name][1], apply, why)


def _estimates_of_fit(forward: Forward, fit: Fit | None, applied: Applied) -> Iterator[Estimate]:
    log = forward.log
    if fit is None:
        why = "too few samples with power count"
        if log.solar_power_w.sum() < 0.0:
            why = "the power is negative: give its column a factor of -1 (--columns)"
        yield from (_estimate(name, why=why) for name in list(LABELS)[:3])
        return
    value, wide = (number / 60.0 for number in fit.of("clock_s"))
    if wide > _UNKNOWN_MIN:
        hours = (log.time_s[-1] - log.time_s[0]) / 3600.0
        why = f"known to ± {wide:.0f} min only: the power of these {hours:.1f} h does not tell it"
        yield _estimate("clock_offset", why=why)
    else:
        option = ("--clock-offset", f"{applied.clock_min + value:.1f}")
        yield _estimate("clock_offset", value, value - wide, value + wide, apply=option)
    yield _estimate_heading(forward, fit, applied)
    factor, *ends = fit.factor
    other = next((name for number, name in _UNITS if 0.1 < factor / number < 10.0), None)
    apply: tuple[str, ...] = ()
    why = f"as if the power was logged in {other}: --column 'solar_power_w=NAME [{other}]'"
    if other is None:
        efficiency = parameter_value(forward.aircraft, None, _EFFICIENCY)
        assert efficiency is not None  # every aircraft has one
        apply, why = ("--set", f"{_EFFICIENCY}={spell(factor * efficiency, 4)}"), ""
    yield _estimate("solar_factor", factor, *ends, apply=apply, why=why)


def _estimate_heading(forward: Forward, fit: Fit, applied: Applied) -> Estimate:
    attitude = forward.log.attitude
    if attitude is None or "heading" not in fit.names:
        lacking = "the log has no attitude" if attitude is None else "no modules.geometry"
        return _estimate("heading_offset", why=lacking)
    value, wide = (float(np.degrees(angle)) for angle in fit.of("heading"))
    if wide > _UNKNOWN_DEG:
        bank = float(np.degrees(np.sqrt(np.mean(attitude.roll_rad**2))))
        why = "the power hardly changes with the heading"
        if bank < _LEVEL_DEG:
            why = f"the wings are level to {bank:.1f} deg, so the heading hardly changes the power"
        return _estimate("heading_offset", why=f"known to ± {wide:.0f} deg only: {why}")
    value = (value + 180.0) % 360.0 - 180.0
    total = (applied.heading_deg + value + 180.0) % 360.0 - 180.0
    option = ("--heading-offset", f"{total:.1f}")
    return _estimate("heading_offset", value, value - wide, value + wide, apply=option)


def _estimate_level_power(forward: Forward, daylight: IntArray) -> Estimate:
    """Estimate the power of level flight [W]: the load without avionics and payload.

    At night if there is one, without thermals and work of the day. Converted to the density of the
    mission's air, with whose square root the power falls.
    """
    log, mission, name = forward.log, forward.mission, "level_power"
    if log.load_w is not None:
        load = log.load_w
    elif log.battery_power_w is not None:
        load = log.solar_power_w - log.battery_power_w
    else:
        return _estimate(name, why="neither load_w nor battery_power_w is logged")
    slot = np.floor((log.time_s - log.time_s[0]) / _BIN_S).astype(int)
    use, night = np.isfinite(load), np.ones(len(log), bool)
    night[daylight] = False
    if np.count_nonzero(use & night) * log.step_s >= _SHORTEST_NIGHT_S:
        use &= night
    # Samples in slots over which the altitude changes no faster than in level flight.
    (mean_m, slots), (mean_s, _) = _means(log.altitude_m, slot), _means(log.time_s, slot)
    if len(slots) > 1:
        slow = np.abs(np.gradient(mean_m, mean_s)) <= _FASTEST_CLIMB_M_PER_S
        use &= slow[np.searchsorted(slots, slot)]
    height_m = np.clip(log.altitude_m[use], air.MINIMUM_ALTITUDE_M, air.MAXIMUM_ALTITUDE_M)
    kelvin = forward.of(np.flatnonzero(use)).ambient_c()[0] + air.ZERO_CELSIUS_K
    density = air.air_at(kelvin, air.standard_air(height_m).pressure_pa).density_kg_per_m3
    mean_density = float(mission.air_state().density_kg_per_m3)
    rising = np.sqrt(mean_density / density) * (1.0 + mission.turbulence.all_day)
    try:
        constant_w = float(design_of(forward.aircraft, mission).constant_power_w)
    except ImpossibleDesignError as error:
        return _estimate(name, why=str(error))
    means, bins = _means((load[use] - constant_w) / rising, slot[use])
    if len(means) < _LEAST_BINS:
        least_min = _LEAST_BINS * _BIN_S / 60
        return _estimate(name, why=f"less than {least_min:.0f} min of level flight with a load")
    mean = float(means.mean())
    run = np.cumsum(np.diff(bins, prepend=bins[0]) > 1).astype(int)
    count = len(means) / correlation_time(means - mean, run, 1)
    freedom = max(count - 1.0, 1.0)
    wide = float(t.ppf(0.5 + 0.5 * CONFIDENCE, freedom) * means.std() / np.sqrt(freedom))
    key = level_power_key(forward.aircraft, mission, mean)
    interval = (mean, mean - wide, mean + wide)
    if isinstance(key, str):
        return _estimate(name, *interval, why=key)
    return _estimate(name, *interval, apply=("--set", f"{key[0]}={spell(key[1], 4)}"))


def _means(values: FloatArray, slot: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the mean of the values in each slot that has some, and these slots."""
    slots, number = np.unique(slot, return_inverse=True)
    return np.bincount(number, values) / np.bincount(number), slots


def level_power_key(
    aircraft: Aircraft, mission: Mission, power_w: float
) -> tuple[str, float] | str:
    """Return a key and its value for a power of level flight, or why there is none."""
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
