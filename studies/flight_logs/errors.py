"""Errors of solar power models over windows, days and bins of a flight log, and by MPPT.

Errors are those of Oettershagen's report on solar power models, section 4: modelled minus measured
power, negative where the model underestimates; relative to the mean measured power; RMS and maximum
of data that passed a two-sided moving average.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from missions.files.errors import file_error
from missions.logs.plausible import utc_text
from missions.logs.table import FlightLog
from solar.geometry import ModuleGeometry
from solar.names import ModelName
from solar.schema import spell
from solar.sun import SECONDS_PER_DAY
from solar.types import BoolArray, FloatArray, IntArray
from studies.flight_logs.forward import Forward, Samples, numbered_runs
from studies.quantities import group
from studies.render.tables import Column, Table

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
    """Errors over a window or day without excluded samples; ``filter_s`` to either side.

    ``mask``: flags of its samples; ``clock``: clock of its label. ``models``: average, RMS and
    largest error of each model [W], and relative to the mean measured power. Names as in JSON.
    """

    label: str
    clock: str
    mask: BoolArray
    start_s: float
    end_s: float
    samples: int
    excluded_samples: int
    filter_s: float
    measured_mean_w: float | None
    models: Mapping[ModelName, Mapping[str, Any]]


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


# ---- Errors in bins, and MPPT by MPPT

_MOST_ROWS = 14
_HOURS = (0.5, 1.0, 2.0, 3.0, 6.0, 12.0, 24.0)
_STEP_DEG, _SECTOR_DEG = 10.0, 30.0
_LEAST_SAMPLES, _LEAST_SHARE = 10, 0.01  # of a bin, and its mean power over the highest

_PLACES = {"center": "centre", "middle": "centre"}


def residuals(
    samples: Samples, counts: BoolArray, estimated_w: FloatArray | None
) -> dict[str, pd.DataFrame]:
    """Compute errors by time, by elevation before and after noon, and by the sun's bearing.

    Bins have enough samples and power. Columns: ends ``low`` and ``high`` of a bin, in seconds
    since 1970 or in degrees, ``samples``, ``measured_w``, and modelled less measured power over the
    measured one, ``as_logged`` and ``estimated``, with the estimated clock, heading and factor.
    """
    powers = pd.DataFrame(
        {
            "measured_w": samples.measured_w,
            "as_logged": samples.modelled_w[samples.best_model],
            "estimated": np.nan if estimated_w is None else estimated_w,
        }
    )
    least_w = max(_LEAST_SHARE * float(samples.measured_w.max()), 0.0)

    def binned(values: FloatArray, step: float, mask: BoolArray) -> pd.DataFrame:
        groups = powers[mask].groupby(np.floor(values[mask] / step))
        means, count = groups.mean(), groups.size()
        measured_w, number = means["measured_w"], means.index.to_numpy(float)
        ends = {"low": step * number, "high": step * (number + 1.0), "samples": count}
        bins = pd.DataFrame({**ends, "measured_w": measured_w})
        for name in ("as_logged", "estimated"):
            bins[name] = means[name] / measured_w - 1.0
        return bins[(count >= _LEAST_SAMPLES) & (measured_w > least_w)]

    for hours in _HOURS:
        step_s = 3600.0 * hours
        if len(np.unique(np.floor(samples.time_s[counts] / step_s))) <= _MOST_ROWS:
            break
    morning, with_bearing = samples.time_solar_h < 12.0, counts & bool(samples.detail)
    return {
        "time": binned(samples.time_s, step_s, counts),
        "morning": binned(samples.elevation_deg, _STEP_DEG, counts & morning),
        "afternoon": binned(samples.elevation_deg, _STEP_DEG, counts & ~morning),
        "bearing": binned(samples.bearing_deg, _SECTOR_DEG, with_bearing),
    }


def residual_tables(bins: Mapping[str, pd.DataFrame], model: str) -> list[Table]:
    """Return tables of the residuals."""
    numbers = group("measured_w as_logged_percent estimated_percent")

    def rows_of(name: str, when: str = "") -> Iterator[tuple[Any, ...]]:
        for low, high, _, measured_w, *errors in bins[name].to_numpy().tolist():
            label = f"{low:.0f} to {high:.0f}{when}"
            if name == "time":
                label = f"{utc_text(low)[5:16]} to {utc_text(high)[11:16]}"
            yield label, measured_w, *(100 * error for error in errors)

    halves = (*rows_of("morning", " morning"), *rows_of("afternoon", " afternoon"))
    tables = (
        ("time", Column("UTC"), tuple(rows_of("time"))),
        ("the sun's elevation", Column("elevation", "elevation [deg]"), halves),
        (
            "the sun's azimuth from the nose, clockwise",
            Column("bearing", "azimuth [deg]"),
            tuple(rows_of("bearing")),
        ),
    )
    return [Table(f"{model} by {what}", (h, *numbers), rows) for what, h, rows in tables if rows]


class MpptPower(NamedTuple):
    """Mean power of an MPPT [W], measured and modelled for its modules."""

    name: str
    modules: tuple[str, ...]
    measured_w: float
    modelled_w: float

    @property
    def ratio(self) -> float:
        """Measured over modelled power."""
        return self.measured_w / max(self.modelled_w, 1e-9)


class MpptPowers(NamedTuple):
    """Power of MPPTs, mean and by sample, shape (samples, MPPTs); ``how``: source of the wiring."""

    each: tuple[MpptPower, ...]
    measured_w: FloatArray
    modelled_w: FloatArray
    how: str

    def table(self) -> Table:
        """Return a table of measured over modelled power by MPPT."""
        modules, *numbers = group("modules measured_w modelled_w ratio_percent of_usual_percent")
        numbers[0] = replace(numbers[0], form=".2f")
        columns = (Column("MPPT"), modules, *numbers)
        usual = max(float(np.median([mppt.ratio for mppt in self.each])), 1e-9)
        rows = [
            (m.name, ", ".join(m.modules), *m[2:], 100 * m.ratio, 100 * m.ratio / usual)
            for m in self.each
        ]
        return Table(f"power of the MPPTs; their modules {self.how}", columns, tuple(rows))


def surfaces_of(log: FlightLog, geometry: ModuleGeometry | None) -> tuple[BoolArray | None, str]:
    """Return the wiring, shape (MPPTs, surfaces), and its source; None and the reason without."""
    names = tuple(log.mppt_power_w)
    if not names:
        return None, ""
    if geometry is None or log.attitude is None:
        return None, "MPPTs are not compared one by one: that needs VM and FM"
    surfaces = geometry.surfaces
    named = np.array(
        [[_words(name) <= _words(f"{s.name} {s.side}") for s in surfaces] for name in names]
    )
    if all(_words(name) for name in names) and np.all(named.sum(axis=0) == 1):
        return named, "by name"
    wired = sorted({s.mppt for s in surfaces if s.mppt is not None})
    if len(wired) == len(names) and all(s.mppt is not None for s in surfaces):
        return np.array([[s.mppt == number for s in surfaces] for number in wired]), (
            "by the surfaces' mppt"
        )
    if len(names) == len(surfaces) and not wired:
        return np.eye(len(names), dtype=bool), "in the order of the surfaces"
    return None, (
        f"MPPTs are not compared one by one: {len(names)} columns, {len(surfaces)} surfaces of "
        "modules.geometry; say with their key mppt which number each is connected to"
    )


def compare_mppts(forward: Forward, wiring: BoolArray, how: str, counts: BoolArray) -> MpptPowers:
    """Compute each MPPT's mean power and the Full Model of its modules."""
    assert forward.geometry is not None  # so are its surfaces
    power, surfaces = forward.log.mppt_power_w, forward.geometry.surfaces
    measured = np.stack([power_w[forward.index] for power_w in power.values()], axis=1)
    modelled = np.concatenate([part.power_by_surface_w() @ wiring.T for part in forward.chunks()])
    modules = [tuple(s.name for s, connected in zip(surfaces, row, strict=True) if connected)
               for row in wiring]  # fmt: skip
    means = (values[counts].mean(axis=0).tolist() for values in (measured, modelled))
    return MpptPowers(tuple(map(MpptPower, power, modules, *means)), measured, modelled, how)


def _words(name: str) -> set[str]:
    """Return the words of a name that say where on the wing something is."""
    words = re.findall(r"left|right|cent(?:re|er)|middle|front|rear|inner|outer", name.lower())
    return {_PLACES.get(word, word) for word in words}
