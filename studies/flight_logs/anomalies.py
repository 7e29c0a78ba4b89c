"""Anomalies in a flight log, sought by rules: tracking, shading, bias by side, missing data.

The thresholds are the constants below; ``docs/verify.md`` gives the reason of each.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from missions.logs.table import FlightLog, Gap
from solar.sun import sun_position
from solar.types import BoolArray, FloatArray
from studies.flight_logs.log_view import (
    BRIGHT,
    LOW_LIGHT_W_PER_M2,
    MERGE_S,
    Anomaly,
    LogView,
    Period,
    clusters,
    mask_of,
    severity_of,
)

# Low-light tracking: the share of the modelled power that must be missing, and the same in rated
# power and in noise.
LOW_LIGHT_DEFICIT, LOW_LIGHT_DEFICIT_RATED, LOW_LIGHT_SIGMAS = 0.2, 0.01, 5.0
LOW_LIGHT_SHARE, LOW_LIGHT_LEAST_S = 0.1, 30.0
VOLTAGE_OFF, VOLTAGE_SHARE = 0.05, 0.3

# Shading: least loss in modelled power, rated power, its error and the expected one.
SHADING_LOSS, SHADING_LOSS_RATED, SHADING_T = 0.02, 0.005, 4.0
SHADING_OF_EXPECTED = 0.2

# Bias by sun side: least difference, its significance, blocks in which it must have one sign.
SIDE_BIAS, SIDE_T, SIDE_SAME_SIGN, SIDE_BLOCK_S = 0.03, 5.0, 0.8, 1200.0
SIDE_ELEVATIONS_DEG = (10.0, 75.0)

_SIDES = ("front", "right", "rear", "left")
_NEAR_S = 5.0
# Standard deviation over median absolute deviation of a normal distribution.
_SIGMA_OF_MAD = 1.4826


def other_anomalies(view: LogView, limited: BoolArray) -> list[Anomaly]:
    """All but limited charging; those that compare with the Full Model need it."""
    anomalies = _missing(view)
    if view.samples.detail is None:
        return anomalies
    tracking, dark = _not_tracking(view, limited)
    return [*anomalies, *tracking, *_shading(view, limited), *_side_bias(view, limited | dark)]


def _not_tracking(view: LogView, limited: BoolArray) -> tuple[list[Anomaly], BoolArray]:
    """Periods in which the MPPT loses the maximum power point at low light."""
    detail = view.samples.detail
    assert detail is not None  # the caller checked
    low = (detail.irradiance_w_per_m2 < LOW_LIGHT_W_PER_M2) & ~limited
    low &= view.reference_w >= LOW_LIGHT_DEFICIT_RATED * view.rated_w
    if detail.shaded_m2 is not None:
        low &= detail.shaded_m2 <= 0.0
    modelled = view.smooth(view.reference_w, _NEAR_S)
    deficit = modelled - view.smooth(view.samples.measured_w, _NEAR_S)
    averaged = 2 * round(_NEAR_S / view.step_s) + 1
    noise = LOW_LIGHT_SIGMAS * _noise_w(view) / np.sqrt(averaged)
    least = max(LOW_LIGHT_DEFICIT_RATED * view.rated_w, noise)
    flagged = low & (deficit > np.maximum(LOW_LIGHT_DEFICIT * modelled, least))
    odd_voltage = _odd_voltage(view)
    anomalies, lost = [], np.zeros(len(low), bool)
    for period in clusters(flagged, view.samples.time_s, MERGE_S):
        anomaly = _tracking_anomaly(view, period, flagged, low, odd_voltage)
        if anomaly is not None:
            anomalies.append(anomaly)
            lost |= flagged & mask_of(len(low), period)
    return anomalies, lost


def _tracking_anomaly(
    view: LogView,
    period: Period,
    flagged: BoolArray,
    low: BoolArray,
    odd_voltage: BoolArray | None,
) -> Anomaly | None:
    inside = mask_of(len(flagged), period)
    bad = flagged & inside
    affected = float(bad.sum() * view.step_s)
    if affected < LOW_LIGHT_LEAST_S or bad.sum() < LOW_LIGHT_SHARE * (low & inside).sum():
        return None
    voltage = "no MPPT voltage logged"
    if odd_voltage is not None:
        share = float(odd_voltage[bad].mean())
        if share < VOLTAGE_SHARE:
            return None
        voltage = f"MPPT voltage off or unsteady in {share:.0%} of them"
    missing = 1.0 - float(view.samples.measured_w[bad].sum() / view.reference_w[bad].sum())
    lost = view.lost_wh(bad)
    return view.anomaly(
        "mppt_not_tracking",
        period,
        view.severity_of_loss(lost),
        f"{missing:.0%} of the modelled power missing in {affected:.0f} s below "
        f"{LOW_LIGHT_W_PER_M2:g} W/m² on the modules; {voltage}",
        affected,
        lost,
    )


def _odd_voltage(view: LogView) -> BoolArray | None:
    """Samples whose MPPT voltage is away from its median at good light, or unsteady."""
    volts = view.logged(view.log.mppt_voltage_v)
    if volts is None:
        return None
    good = np.isfinite(volts) & (view.reference_w >= BRIGHT * view.rated_w)
    if good.sum() < 10:
        good = np.isfinite(volts)
    median = float(np.median(volts[good]))
    spread = _SIGMA_OF_MAD * float(np.median(np.abs(volts[good] - median)))
    allowed = max(5.0 * spread, VOLTAGE_OFF * median)
    filled = np.where(np.isfinite(volts), volts, median)
    mean = view.smooth(filled, _NEAR_S)
    variance = view.smooth((filled - median) ** 2, _NEAR_S) - (mean - median) ** 2
    unsteady = np.sqrt(np.maximum(variance, 0.0)) > allowed
    return np.asarray((np.abs(filled - median) > allowed) | unsteady, bool)


def _noise_w(view: LogView) -> float:
    """Scatter of the error from sample to sample, robust against everything slower [W]."""
    error = view.samples.measured_w - view.reference_w
    steps = np.diff(error)[np.diff(view.samples.run) == 0]
    if not len(steps):
        return 0.0
    return float(_SIGMA_OF_MAD * np.median(np.abs(steps - np.median(steps))) / np.sqrt(2.0))


def _shading(view: LogView, limited: BoolArray) -> list[Anomaly]:
    """Dips of the power that coincide with the modelled shadow of the tail."""
    detail = view.samples.detail
    assert detail is not None  # the caller checked
    if detail.shaded_m2 is None or detail.shading_loss_w is None:
        return []
    # Shadows too small to cost what would be told apart from noise are left out.
    least = 0.5 * SHADING_LOSS_RATED * view.rated_w
    shaded = (detail.shading_loss_w > least) & ~limited
    clear = (detail.shaded_m2 <= 0.0) & ~limited
    deficit = view.reference_w - view.samples.measured_w
    anomalies = []
    for period in clusters(shaded, view.samples.time_s, MERGE_S):
        dips = _dips(view, period, shaded, clear, deficit)
        bad = shaded & mask_of(len(shaded), period)
        if (anomaly := _shading_anomaly(view, period, dips, bad)) is not None:
            anomalies.append(anomaly)
    return anomalies


def _dips(
    view: LogView, period: Period, shaded: BoolArray, clear: BoolArray, deficit: FloatArray
) -> FloatArray:
    """Deficit of each passage of the shadow above that right before and after it [W]."""
    time_s, inside = view.samples.time_s, np.flatnonzero(shaded[period.slice()]) + period.first
    passages = np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1)
    dips = []
    for passage in passages:
        low = int(np.searchsorted(time_s, time_s[passage[0]] - 3 * _NEAR_S))
        high = int(np.searchsorted(time_s, time_s[passage[-1]] + 3 * _NEAR_S, side="right"))
        beside = clear[low:high]
        if beside.any():
            dips.append(deficit[passage].mean() - deficit[low:high][beside].mean())
    return np.array(dips)


def _shading_anomaly(
    view: LogView, period: Period, dips: FloatArray, bad: BoolArray
) -> Anomaly | None:
    detail = view.samples.detail
    assert detail is not None
    assert detail.shading_loss_w is not None
    assert detail.shaded_m2 is not None
    if len(dips) < 3:
        return None
    mean = float(dips.mean())
    error = float(dips.std(ddof=1)) / np.sqrt(len(dips))
    modelled = float(view.reference_w[bad].mean())
    expected = float(detail.shading_loss_w[bad].mean())
    least = max(
        SHADING_LOSS * modelled,
        SHADING_LOSS_RATED * view.rated_w,
        SHADING_OF_EXPECTED * expected,
        SHADING_T * error,
    )
    if mean < least:
        return None
    affected = float(bad.sum() * view.step_s)
    lost = mean * affected / 3600.0
    return view.anomaly(
        "shading",
        period,
        view.severity_of_loss(lost),
        f"power drops by {mean:.1f} W ({mean / modelled:.0%}) in {len(dips)} passages of the "
        f"tail's shadow, of up to {detail.shaded_m2[bad].max():.3f} m²; in proportion to the area "
        f"it would be {expected:.1f} W",
        affected,
        lost,
    )


def _side_bias(view: LogView, left_out: BoolArray) -> list[Anomaly]:
    """Sides of the nose on which the sun makes the error differ from that on the others."""
    samples = view.samples
    low, high = SIDE_ELEVATIONS_DEG
    good = ~left_out & (samples.elevation_deg > low) & (samples.elevation_deg < high)
    good &= view.reference_w >= 0.1 * view.rated_w
    if samples.detail is not None and samples.detail.shaded_m2 is not None:
        good &= samples.detail.shaded_m2 <= 0.0
    if not good.any():
        return []
    side = (np.floor((samples.bearing_deg + 45.0) / 90.0).astype(int) % 4)[good]
    block = np.floor(samples.time_s[good] / SIDE_BLOCK_S).astype(int)
    _, block = np.unique(block, return_inverse=True)
    cell = 4 * block + side
    size = 4 * (int(block.max()) + 1)
    error = np.bincount(cell, (view.reference_w - samples.measured_w)[good], minlength=size)
    power = np.bincount(cell, samples.measured_w[good], minlength=size)
    counts = np.bincount(cell, minlength=size)
    enough = (counts >= 10) & (power > 0.0)
    relative = np.where(enough, error / np.where(enough, power, 1.0), np.nan).reshape(-1, 4)
    places = np.flatnonzero(good)
    period = Period(int(places[0]), int(places[-1]))
    anomalies = []
    for number, name in enumerate(_SIDES):
        bad = np.zeros(len(good), bool)
        bad[places[side == number]] = True
        difference = _against_others(relative, number)
        if (anomaly := _side_anomaly(view, period, name, difference, bad)) is not None:
            anomalies.append(anomaly)
    return anomalies


def _against_others(relative: FloatArray, number: int) -> FloatArray:
    """Error on one side less the median of the other sides, for blocks that have three others."""
    whole = relative[~np.isnan(relative).any(axis=1)]
    others = np.delete(whole, number, axis=1)
    # The median: a fault on one side must not show as an opposite one on the others.
    return np.asarray(whole[:, number] - np.median(others, axis=1))


def _side_anomaly(
    view: LogView, period: Period, name: str, difference: FloatArray, bad: BoolArray
) -> Anomaly | None:
    if len(difference) < 3:
        return None
    mean = float(difference.mean())
    error = float(difference.std(ddof=1)) / np.sqrt(len(difference))
    same_sign = float(np.mean(np.sign(difference) == np.sign(mean)))
    if abs(mean) < max(SIDE_BIAS, SIDE_T * error) or same_sign < SIDE_SAME_SIGN:
        return None
    where = {"front": "ahead", "right": "on the right", "rear": "behind", "left": "on the left"}
    word = "over" if mean > 0.0 else "under"
    return view.anomaly(
        "side_bias",
        period,
        severity_of(abs(mean), SIDE_BIAS, 3.0),
        f"with the sun {where[name]} the model {word}estimates by {abs(mean):.1%} more than with "
        f"the sun elsewhere, alike in {same_sign:.0%} of {len(difference)} blocks of "
        f"{SIDE_BLOCK_S / 60:g} min",
        float(bad.sum() * view.step_s),
        max(view.lost_wh(bad), 0.0),
    )


def _missing(view: LogView) -> list[Anomaly]:
    """Stretches without samples while the sun is up; those close together are one finding."""
    lit = [(gap, sunlit) for gap in view.log.gaps if (sunlit := _sunlit_s(view.log, gap)) > 0.0]
    groups: list[list[tuple[Gap, float]]] = []
    for gap, sunlit in lit:
        if groups and gap.start_s - groups[-1][-1][0].end_s <= MERGE_S:
            groups[-1].append((gap, sunlit))
        else:
            groups.append([(gap, sunlit)])
    known_s = len(view.samples.time_s) * view.step_s
    return [_missing_anomaly(group, known_s) for group in groups]


def _missing_anomaly(group: Sequence[tuple[Gap, float]], known_s: float) -> Anomaly:
    total = sum(sunlit for _, sunlit in group)
    count = "1 gap" if len(group) == 1 else f"{len(group)} gaps"
    return Anomaly(
        "missing_data",
        group[0][0].start_s,
        group[-1][0].end_s,
        severity_of(total / (known_s + total), 0.01),
        f"{count}, {total:.0f} s without samples while the sun is up",
        total,
        0.0,
    )


def _sunlit_s(log: FlightLog, gap: Gap) -> float:
    """Part of a gap with the sun above the horizon, seen from where it begins [s]."""
    at = int(np.searchsorted(log.time_s, gap.start_s))
    steps = np.linspace(gap.start_s, gap.end_s, 201)
    sun = sun_position(steps, log.latitude_deg[at], log.longitude_deg[at])
    return float(np.mean(sun.elevation_rad > 0.0) * gap.duration_s)
