"""Errors of solar power models over the windows and days of a flight log.

Errors are those of Oettershagen's report on solar power models, section 4: modelled minus measured
power, negative where the model underestimates; relative to the mean measured power; RMS and maximum
of data that passed a two-sided moving average.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from missions.files.errors import file_error
from solar.names import ModelName
from solar.schema import spell
from solar.sun import SECONDS_PER_DAY
from solar.types import BoolArray, FloatArray, IntArray
from studies.flight_logs.forward import Samples, numbered_runs

# Times of samples are written to the millisecond.
_TOLERANCE_S = 2e-3
_WINDOW = re.compile(r"(?:(\d{4}-\d\d-\d\d)@)?(\d+(?:\.\d*)?):(\d+(?:\.\d*)?)")


@dataclass(frozen=True)
class Window:
    """Period of solar time [h], on every day or on one (days since 1970-01-01)."""

    start_h: float
    end_h: float
    day: int | None = None

    @property
    def label(self) -> str:
        """Readable name."""
        hours = f"{spell(self.start_h)} to {spell(self.end_h)} h"
        return hours if self.day is None else f"{_iso_date(self.day)}, {hours}"


def parse_window(text: str) -> Window:
    """Read a window ``5.71:5.79``, or ``2015-07-01@5.71:5.79`` of one day."""
    match = _WINDOW.fullmatch(text.strip())
    form = "a:b in solar hours, for instance 5.71:5.79 or 2015-07-01@5.71:5.79"
    if match is None:
        raise ValueError(f"must be {form} (got {text!r})")
    start, end = float(match[2]), float(match[3])
    if not start < end <= 24.0:
        raise ValueError(f"must be {form}, a below b and both from 0 to 24 (got {text!r})")
    if match[1] is None:
        return Window(start, end)
    try:
        date = datetime.date.fromisoformat(match[1])
    except ValueError:
        raise ValueError(f"there is no date {match[1]}") from None
    return Window(start, end, (date - datetime.date(1970, 1, 1)).days)


@dataclass(frozen=True)
class Section:
    """Errors over a window or day without ``excluded`` samples; ``filter_s`` to either side.

    ``mask``: flags of its samples; ``clock``: clock of its label. ``errors``: average, RMS and
    largest error of each model [W], and relative to the mean measured power, as JSON has them.
    """

    label: str
    clock: str
    mask: BoolArray
    start_s: float
    end_s: float
    samples: int
    excluded: int
    filter_s: float
    measured_mean_w: float | None
    errors: Mapping[ModelName, Mapping[str, Any]]


def moving_average(
    values: FloatArray, run: IntArray, time_s: FloatArray, semi_s: float
) -> FloatArray:
    """Average over ``semi_s`` to either side, both ends included, cut at the ends of a run."""
    width = pd.Timedelta(seconds=2.0 * (semi_s + _TOLERANCE_S))
    runs = pd.Series(values, pd.to_datetime(time_s, unit="s")).groupby(run)
    return np.asarray(runs.rolling(width, center=True, closed="both").mean(), float)


def _iso_date(day: int) -> str:
    return (datetime.date(1970, 1, 1) + datetime.timedelta(days=day)).isoformat()


def filtered(
    samples: Samples, excluded: BoolArray, filter_s: float, modelled_w: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the errors [W] of a power in samples not excluded, and their moving average."""
    used = ~excluded
    run = numbered_runs(np.flatnonzero(used), samples.run[used])
    raw = (modelled_w - samples.measured_w)[used]
    return raw, moving_average(raw, run, samples.time_s[used], filter_s)


def in_windows(
    samples: Samples, windows: Iterable[Window], source: str
) -> Iterator[tuple[str, BoolArray]]:
    """Yield windows with flags of their samples; refuse a window without samples."""
    hours, days = samples.time_solar_h, samples.solar_day
    for window in windows:
        mask = (hours >= window.start_h) & (hours <= window.end_h)
        if window.day is not None:
            mask &= days == window.day
        if not mask.any():
            by_day = ((_iso_date(int(day)), hours[days == day]) for day in np.unique(days))
            spans = (f"{date} {h.min():.2f} to {h.max():.2f} h" for date, h in by_day)
            message = f"no sample with the sun up lies in the window {window.label} (solar time)"
            raise file_error(source, f"{message}; allowed: {', '.join(spans)}")
        yield window.label, mask


def on_days(samples: Samples) -> Iterator[tuple[str, BoolArray]]:
    """Yield the log's days (UTC) with flags of their samples."""
    days = np.floor(samples.time_s / SECONDS_PER_DAY).astype(int)
    for day in np.unique(days).tolist():
        yield _iso_date(day), days == day


def sections(
    samples: Samples,
    excluded: BoolArray,
    filter_s: float,
    clock: str,
    masks: Iterable[tuple[str, BoolArray]],
) -> tuple[Section, ...]:
    """Return the errors of all models in parts of a log; RMS and maximum are of filtered errors."""
    used, models = ~excluded, samples.modelled_w.items()
    every = {m: filtered(samples, excluded, filter_s, power) for m, power in models}
    result = []
    for label, mask in masks:
        inside, times = mask[used], samples.time_s[mask]
        measured = samples.measured_w[mask & used]
        mean_w = float(measured.mean()) if len(measured) else None
        errors: dict[ModelName, dict[str, Any]] = {}
        for model, both in every.items() if mean_w is not None else ():
            raw, smooth = (values[inside] for values in both)
            errors[model] = {"modelled_mean_w": float((measured + raw).mean())}
            for name, error in (
                ("average", raw.mean()),
                ("rms", np.sqrt(np.mean(smooth**2))),
                ("maximum", np.abs(smooth).max()),
            ):
                relative = float(error) / mean_w if mean_w and mean_w > 0.0 else None
                errors[model][f"{name}_error_w"] = float(error)
                errors[model][f"{name}_error_relative"] = relative
        ends = float(times[0]), float(times[-1])
        counts = len(measured), int((mask & excluded).sum())
        result.append(Section(label, clock, mask, *ends, *counts, filter_s, mean_w, errors))
    return tuple(result)
