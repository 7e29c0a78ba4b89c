"""Stretches of a log that tell nothing about modules and models, and why."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from missions.logs.plausible import Kind
from missions.logs.table import GAP_STEPS, FlightLog, Gap
from missions.weather.record import runs_of
from sizing.aircraft import Aircraft
from sizing.battery.battery import NoChargeLimit, charge_rate_per_h
from solar.sun import sun_position
from solar.types import BoolArray, FloatArray
from studies.flight_logs.errors import moving_average
from studies.flight_logs.estimates import Fit, fit_log
from studies.flight_logs.forward import Forward, Samples
from studies.render.words import amount, percent

Reason = Literal["battery_full", "no_power", "frozen", "implausible", "excluded", "missing_data"]
_OF_VALUES: Mapping[Kind, Reason] = {
    "frozen": "frozen", "saturated": "frozen", "excluded": "excluded",
}  # fmt: skip

# docs/verify.md has the reasons of all thresholds. State of charge from which a battery may take
# less, and share of the power of load and battery from which they may limit the modules.
_NEAR_FULL, _OF_LIMIT = 0.85, 0.8
# Without a logged charge: largest difference of power and load, as a share of rated power, and the
# time before in which the charging power may have been falling.
_AS_LOAD, _TAPER_S, _TAPER_MEAN_S = 0.05, 3.0 * 3600.0, 600.0
# Share of the expected power below which a battery limits it, with and without attitude, and from
# which nothing does; share of the highest power from which samples are judged.
_LIMITED, _LIMITED_CAM, _WHOLE, _BRIGHT = 0.90, 0.75, 0.97, 0.25
_LEAST_S, _MERGE_S, _SMOOTH_S = 120.0, 600.0, 60.0
_DARK = 0.02  # share of the peak below which there is nothing to fit
# Shares of the peak: below the first there is no power; no dusk has the second a minute before.
_NONE, _ABRUPT = 0.02, 0.25


@dataclass(frozen=True)
class Stretch:
    """Period that is left out [s since 1970]; ``count``: samples, or values of a column."""

    reason: Reason
    start_s: float
    end_s: float
    count: int
    evidence: str


def _may_be_limited(log: FlightLog, aircraft: Aircraft) -> BoolArray:
    """Flag samples in which the battery may limit the power, by logged values alone."""
    battery = aircraft.battery
    power = _smooth(log, log.solar_power_w)
    load = None if log.load_w is None else _smooth(log, np.nan_to_num(log.load_w))
    if log.state_of_charge is None:
        if load is None or log.load_w is None:
            return np.zeros(len(log), bool)
        rated_w = aircraft.modules.full_load_w_per_m2 * aircraft.modules.area_m2
        as_load = (np.abs(power - load) < _AS_LOAD * rated_w) & (power > 0.0)
        # From the highest charging power in three hours on, while it falls to the load.
        surplus = log.solar_power_w - np.nan_to_num(log.load_w)
        surplus, result = _smooth(log, surplus, _TAPER_MEAN_S), as_load.copy()
        for part in _clusters(as_load, log.time_s):
            if as_load[part].sum() * log.step_s >= _LEAST_S:
                first = int(np.searchsorted(log.time_s, log.time_s[part.start] - _TAPER_S))
                highest = first + int(np.argmax(surplus[first : part.start + 1]))
                result[highest : part.stop] = True
        return result
    # Where the sun is low, power may be held in a part of each circle while its mean is below.
    power = np.maximum(power, log.solar_power_w)
    charge = np.clip(np.nan_to_num(log.state_of_charge, nan=0.0), 0.0, 1.0)
    if load is None:
        return charge >= _NEAR_FULL
    if isinstance(battery.charge_limit, NoChargeLimit):
        return (charge >= _NEAR_FULL) & (power > _OF_LIMIT * load)
    taken = charge_rate_per_h(battery.charge_limit, charge) * battery.battery_energy_wh
    taken = taken / float(battery.mean_charge_efficiency)
    taken = np.where(taken < load, 0.0, taken)  # as good as full
    return np.asarray((charge >= _NEAR_FULL) & (power > _OF_LIMIT * (taken + load)))


def _without_power(log: FlightLog) -> tuple[BoolArray, list[Stretch]]:
    """Return flags and stretches of samples without power right after or before bright power."""
    power, time_s = log.solar_power_w, log.time_s
    peak = float(np.quantile(power, 0.98))
    none, mask = power < _NONE * peak, np.zeros(len(log), bool)
    for start, stop in runs_of(none).tolist():
        if time_s[stop - 1] - time_s[start] < _SMOOTH_S:
            continue
        before = int(np.searchsorted(time_s, time_s[start] - _SMOOTH_S))
        after = int(np.searchsorted(time_s, time_s[stop - 1] + _SMOOTH_S, side="right"))
        neighbours = np.concatenate((power[before:start], power[stop:after]))
        mask[start:stop] = neighbours.max(initial=0.0) > _ABRUPT * peak
    text = f"below {percent(_NONE, '.0f')} of the peak, from or to bright power at once"
    every = (np.isin(np.arange(len(log)), np.r_[part]) for part in _clusters(mask, time_s))
    return mask, [_stretch("no_power", time_s, inside & mask, text) for inside in every]


def _battery_full(
    log: FlightLog, samples: Samples, limited: BoolArray, expected_w: FloatArray
) -> Iterator[tuple[Stretch, BoolArray]]:
    """Yield periods in which the battery limits the power, with a flag per sample.

    ``limited``: flags of samples in which it may. ``expected_w``: power without that limit.
    """
    run, time_s, charge = samples.run, samples.time_s, log.state_of_charge
    expected, measured = (
        moving_average(power, run, time_s, _SMOOTH_S) for power in (expected_w, samples.measured_w)
    )
    may_be = limited & (expected >= _BRIGHT * float(expected.max(initial=0.0)))
    left = _LIMITED if samples.detail else _LIMITED_CAM
    flagged, not_whole = (may_be & (measured < share * expected) for share in (left, _WHOLE))
    for period in _clusters(flagged, time_s):
        if flagged[period].sum() * log.step_s < _LEAST_S:
            continue
        # Until nothing limits the power, plus the width of the average.
        whole_s = time_s[~not_whole]
        start = whole_s[whole_s < time_s[period.start]].max(initial=-np.inf)
        end = whole_s[whole_s > time_s[period.stop - 1]].min(initial=np.inf)
        inside = (time_s >= start - _SMOOTH_S) & (time_s <= end + _SMOOTH_S)
        least = float((measured / np.maximum(expected, 1.0))[flagged & inside].min())
        why = "no charge is logged; power falls to the load"
        if charge is not None:
            mean = float(np.nanmean(charge[samples.index][inside]))
            why = f"state of charge {percent(mean, '.0f')} on average"
        text = f"power down to {percent(least, '.0f')} of what is expected; {why}"
        yield _stretch("battery_full", time_s, inside, text), inside


def _value_stretches(log: FlightLog) -> Iterator[Stretch]:
    """Yield stretches of impossible values, and other gaps in daylight, close gaps joined."""
    spans = [span for omission in log.left_out for span in omission.periods]
    for omission in log.left_out:
        yield Stretch(
            _OF_VALUES.get(omission.kind, "implausible"),
            *omission.ends,
            omission.values,
            omission.sentence(),
        )
    slack_s = GAP_STEPS * log.step_s
    groups: list[list[Gap]] = []
    for gap in log.gaps:
        at = int(np.searchsorted(log.time_s, gap.start_s))
        middle_s = 0.5 * (gap.start_s + gap.end_s)
        sun = sun_position(np.array([middle_s]), log.latitude_deg[at], log.longitude_deg[at])
        covered = any(a <= gap.start_s + slack_s and b >= gap.end_s - slack_s for a, b in spans)
        if sun.elevation_rad[0] > 0.0 and not covered:
            if not groups or gap.start_s - groups[-1][-1].end_s > _MERGE_S:
                groups.append([])
            groups[-1].append(gap)
    for group in groups:
        total_s = sum(gap.duration_s for gap in group)
        text = f"{amount(total_s, 's', '.0f')} without samples while the sun is up"
        yield Stretch("missing_data", group[0].start_s, group[-1].end_s, 0, text)


def fit_and_left_out(
    forward: Forward, samples: Samples
) -> tuple[Fit | None, list[Stretch], BoolArray]:
    """Return the fit, the stretches left out, and a flag per sample that is left out.

    The first fit is without samples in which the battery may limit the power; it decides whether
    the battery does.
    """
    log, index, aircraft = forward.log, samples.index, forward.aircraft
    modelled, measured, (dead, gone) = forward.power_w(), log.solar_power_w, _without_power(log)
    peak = float(np.quantile(measured, 0.98))
    dark = (measured <= _DARK * peak) & (modelled <= _DARK * modelled.max(initial=0.0))

    def fit_without(left_out: BoolArray) -> Fit | None:
        return fit_log(forward.of(np.flatnonzero(~(dark | left_out))))

    limited, full = _may_be_limited(log, aircraft), np.zeros(len(log), bool)
    fit, stretches = fit_without(dead | limited), [*gone, *_value_stretches(log)]
    if fit is not None and limited[index].any():
        expected = fit.expected_w(forward.of(index))
        may_be = (limited & ~dead)[index]
        for stretch, inside in _battery_full(log, samples, may_be, expected):
            stretches.append(stretch)
            full[index[inside]] = True
        if np.any(limited & ~full):
            fit = fit_without(dead | full) or fit
    return fit, stretches, (full | dead)[index]


def _stretch(reason: Reason, time_s: FloatArray, inside: BoolArray, text: str) -> Stretch:
    times = time_s[inside]
    return Stretch(reason, float(times[0]), float(times[-1]), int(inside.sum()), text)


def _smooth(log: FlightLog, values: FloatArray, semi_s: float = _SMOOTH_S) -> FloatArray:
    return moving_average(values, log.segment(), log.time_s, semi_s)


def _clusters(flagged: BoolArray, time_s: FloatArray) -> list[slice]:
    """Return slices from the first to the last of flagged samples close to each other."""
    places = np.flatnonzero(flagged)
    cuts = np.flatnonzero(np.diff(time_s[places]) > _MERGE_S) + 1
    clusters = np.split(places, cuts)
    return [slice(int(part[0]), int(part[-1]) + 1) for part in clusters if len(part)]
