"""Limited charging in a flight log: solar power held back because the battery is nearly full."""

from __future__ import annotations

import numpy as np

from solar.types import BoolArray, FloatArray
from studies.flight_logs.log_view import (
    BRIGHT,
    LOW_LIGHT_W_PER_M2,
    MERGE_S,
    SMOOTH_S,
    Anomaly,
    LogView,
    Period,
    clusters,
    mask_of,
)

# Share of the modelled power that is left, with charge and attitude logged and without one of
# them; from which share on it counts as whole again; and charge that counts as nearly full.
# docs/verify.md gives the reason of each.
LIMITED, LIMITED_UNSURE, UNLIMITED = 0.90, 0.75, 0.97
NEAR_FULL = 0.85
LIMITED_LEAST_S = 120.0
LOAD_MATCH = 0.1
LEAST_JUDGED = 0.2  # share of the samples around one that must not be low light
# How far around a period whole power is looked for.
_WIDEN_S = 300.0


def battery_full(view: LogView) -> tuple[list[Anomaly], BoolArray]:
    """Periods in which power is limited because the battery is nearly full."""
    ratio, bright = _power_ratio(view)
    charge = view.logged(view.log.state_of_charge)
    sure = charge is not None and view.samples.detail is not None
    flagged = bright & (ratio < (LIMITED if sure else LIMITED_UNSURE))
    if charge is not None:
        # NaN compares false: samples without a charge are judged by neither rule.
        flagged &= charge >= NEAR_FULL
    spans, limited = [], np.zeros(len(ratio), bool)
    for period in clusters(flagged, view.samples.time_s, MERGE_S):
        if flagged[period.slice()].sum() * view.step_s < LIMITED_LEAST_S:
            continue
        reason = _why_limited(view, period, charge, ratio)
        if reason is None:
            continue
        whole = _widened(view, period, ratio)
        limited[whole.slice()] = True
        spans.append(_limitation(view, whole, ratio, reason))
    return spans, limited


def _power_ratio(view: LogView) -> tuple[FloatArray, BoolArray]:
    """Measured over modelled power around each sample, and where there is enough to judge it.

    Samples at low light are left out: there the MPPT may fail, which is another finding, and
    a limit never acts on little power.
    """
    detail = view.samples.detail
    counts = np.ones(len(view.reference_w))
    if detail is not None:
        counts = (detail.irradiance_w_per_m2 >= LOW_LIGHT_W_PER_M2).astype(float)
    share = np.maximum(view.smooth(counts, SMOOTH_S), 1e-9)
    measured = view.smooth(counts * view.samples.measured_w, SMOOTH_S) / share
    modelled = view.smooth(counts * view.reference_w, SMOOTH_S) / share
    comparable = (share >= LEAST_JUDGED) & (modelled >= BRIGHT * view.rated_w)
    return np.where(comparable, measured / np.maximum(modelled, 1e-9), 1.0), comparable


def _why_limited(
    view: LogView, period: Period, charge: FloatArray | None, ratio: FloatArray
) -> str | None:
    """Evidence that the battery is behind the missing power, none if there is none."""
    if charge is not None:
        mean = float(np.nanmean(charge[period.slice()]))
        return f"the battery is full (state of charge {mean:.0%} on average), which is normal"
    load = view.logged(view.log.load_w)
    if load is not None:
        apart = np.abs(view.samples.measured_w - load)[period.slice()]
        known = apart[np.isfinite(apart)]
        if len(known) and np.median(known) < LOAD_MATCH * view.rated_w:
            return "power follows the load (no state of charge logged)"
    time_s = view.samples.time_s
    before = slice(int(np.searchsorted(time_s, time_s[period.first] - _WIDEN_S)), period.first)
    if np.any(ratio[before] >= LIMITED):
        return "sudden drop at high light (no state of charge logged, so clouds are not ruled out)"
    return None


def _widened(view: LogView, period: Period, ratio: FloatArray) -> Period:
    """Extend a period to where the power is whole again, plus what the smoothing hides."""
    time_s = view.samples.time_s
    whole = ratio >= UNLIMITED
    before = np.flatnonzero(whole[: period.first])
    after = np.flatnonzero(whole[period.last :])
    start = time_s[before[-1]] if len(before) else time_s[0]
    end = time_s[period.last + after[0]] if len(after) else time_s[-1]
    start = max(start, time_s[period.first] - _WIDEN_S) - SMOOTH_S
    end = min(end, time_s[period.last] + _WIDEN_S) + SMOOTH_S
    return Period(
        int(np.searchsorted(time_s, start)), int(np.searchsorted(time_s, end, side="right")) - 1
    )


def _limitation(view: LogView, period: Period, ratio: FloatArray, reason: str) -> Anomaly:
    inside = period.slice()
    lost = view.lost_wh(mask_of(len(ratio), period))
    lowest = float(ratio[inside].min())
    return view.anomaly(
        "battery_full",
        period,
        "normal",  # a full battery takes no more, which no aircraft is to blame for
        f"power down to {lowest:.0%} of the model while {BRIGHT:.0%} of rated power or more is "
        f"there; {reason}; not counted in the errors",
        (inside.stop - inside.start) * view.step_s,
        lost,
    )
