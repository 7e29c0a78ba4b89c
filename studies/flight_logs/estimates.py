"""Four numbers that a log tells, each with its interval and what applies it: no verdict."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from sizing.parameters import parameter_value
from sizing.results.tables import Column, Table
from solar.types import BoolArray
from studies.flight_logs.fit import CONFIDENCE, Fit
from studies.flight_logs.forward import Forward
from studies.flight_logs.level_power import level_power, level_power_key

# Half-widths of intervals beyond which nothing is said to be known [min, deg].
_UNKNOWN_MIN, _UNKNOWN_DEG = 120.0, 45.0
_LEVEL_DEG = 3.0  # bank below which circles do not turn the modules through the light
# What a factor on power this far from one is by: a unit, and no sensor or module.
_UNITS = ((1e-3, "kW"), (1e3, "mW"))
_EFFICIENCY = "modules.efficiency_stc"


class Estimate(NamedTuple):
    """A number with the ends of its interval; None with ``why`` where the log does not tell it.

    ``apply``: options that apply it, empty where none does.
    """

    name: str
    value: float | None
    low: float | None
    high: float | None
    unit: str
    apply: tuple[str, ...]
    why: str


class Applied(NamedTuple):
    """Offsets that were taken off the log already: minutes, degrees."""

    clock_min: float = 0.0
    heading_deg: float = 0.0


def estimates(
    forward: Forward, lit: BoolArray, fit: Fit | None, applied: Applied
) -> tuple[Estimate, ...]:
    """Clock, heading, factor on solar power, power of level flight."""
    return (*_of_fit(forward, fit, applied), _of_load(forward, lit))


def _of_fit(forward: Forward, fit: Fit | None, applied: Applied) -> Iterator[Estimate]:
    if fit is None:
        why = "too few samples with power count"
        if forward.log.solar_power_w.sum() < 0.0:
            why = "the power is negative: give its column a factor of -1 (--columns)"
        for name, unit in (
            ("clock_offset", "min"),
            ("heading_offset", "deg"),
            ("solar_factor", ""),
        ):
            yield _unknown(name, unit, why)
        return
    known, log = fit.of("clock_s"), forward.log
    assert known is not None
    value, wide = known[0] / 60.0, known[1] / 60.0
    if wide > _UNKNOWN_MIN:
        hours = (log.time_s[-1] - log.time_s[0]) / 3600.0
        why = f"known to ± {wide:.0f} min only: the power of these {hours:.1f} h does not tell it"
        yield _unknown("clock_offset", "min", why)
    else:
        option = ("--clock-offset", f"{applied.clock_min + value:.1f}")
        yield Estimate("clock_offset", value, value - wide, value + wide, "min", option, "")
    yield _heading(forward, fit, applied)
    factor, low, high = fit.factor
    apply: tuple[str, ...] = ()
    other = next((name for one, name in _UNITS if 0.1 < factor / one < 10.0), None)
    why = f"as if the power was logged in {other}: --column 'solar_power_w=NAME [{other}]'"
    efficiency = parameter_value(forward.aircraft, None, _EFFICIENCY)
    if other is None:
        assert efficiency is not None  # every aircraft has one
        apply, why = ("--set", f"{_EFFICIENCY}={factor * efficiency:.4g}"), ""
    yield Estimate("solar_factor", factor, low, high, "", apply, why)


def _heading(forward: Forward, fit: Fit, applied: Applied) -> Estimate:
    known, attitude = fit.of("heading"), forward.log.attitude
    if known is None or attitude is None:
        lacking = "the log has no attitude" if attitude is None else "no modules.geometry"
        return _unknown("heading_offset", "deg", lacking)
    value, wide = (float(np.degrees(one)) for one in known)
    if wide > _UNKNOWN_DEG:
        bank = float(np.degrees(np.sqrt(np.mean(attitude.roll_rad**2))))
        why = "the power hardly changes with the heading"
        if bank < _LEVEL_DEG:
            why = f"the wings are level to {bank:.1f} deg, so the heading hardly changes the power"
        return _unknown("heading_offset", "deg", f"known to ± {wide:.0f} deg only: {why}")
    value = (value + 180.0) % 360.0 - 180.0
    total = (applied.heading_deg + value + 180.0) % 360.0 - 180.0
    option = ("--heading-offset", f"{total:.1f}")
    return Estimate("heading_offset", value, value - wide, value + wide, "deg", option, "")


def _of_load(forward: Forward, lit: BoolArray) -> Estimate:
    found = level_power(forward, lit)
    if isinstance(found, str):
        return _unknown("level_power", "W", found)
    key = level_power_key(forward.aircraft, forward.mission, found.value_w)
    ends = (found.value_w, found.low_w, found.high_w)
    if isinstance(key, str):
        return Estimate("level_power", *ends, "W", (), key)
    return Estimate("level_power", *ends, "W", ("--set", f"{key[0]}={key[1]:.4g}"), "")


def _unknown(name: str, unit: str, why: str) -> Estimate:
    return Estimate(name, None, None, None, unit, (), why)


_LABELS = {
    "clock_offset": ("clock ahead of universal time", "+.1f"),
    "heading_offset": ("heading logged too large", "+.1f"),
    "solar_factor": ("measured over modelled power", ".3f"),
    "level_power": ("power of level flight", ".1f"),
}


def estimates_table(every: tuple[Estimate, ...]) -> Table:
    """The four numbers with their intervals."""
    columns = (
        Column("estimate"),
        Column("value", to_right=True),
        Column("interval", f"{CONFIDENCE:.0%} interval", to_right=True),
    )
    rows = []
    for one in every:
        label, form = _LABELS[one.name]
        if one.value is None or one.low is None or one.high is None:
            rows.append((label, "-", "-"))
            continue
        value = f"{one.value:{form}} {one.unit}".strip()
        rows.append((label, value, f"{one.low:{form}} to {one.high:{form}}"))
    notes = [f"{_LABELS[one.name][0]}: {one.why}" for one in every if one.why]
    return Table("estimates, none of them applied", columns, tuple(rows), notes=tuple(notes))


def options_that_apply(every: tuple[Estimate, ...]) -> list[str]:
    """One option each, as it is written on the command line."""
    return [" ".join(one.apply) for one in every if one.apply]
