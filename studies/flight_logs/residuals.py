"""Errors of a model over time, over the sun's elevation and bearing, and by module groups."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from missions.logs.plausible import utc_text
from sizing.results.tables import Column, Table
from solar.types import BoolArray, FloatArray
from studies.flight_logs.samples import Samples

_MOST_ROWS = 14
_HOURS = (0.5, 1.0, 2.0, 3.0, 6.0, 12.0, 24.0)
_STEP_DEG, _SECTOR_DEG = 10.0, 30.0
_LEAST_SAMPLES, _LEAST_SHARE = 10, 0.01  # of a bin, and its mean power over the highest


class Residual(NamedTuple):
    """Errors of the model in a bin, relative to its mean measured power: modelled less measured.

    ``low``, ``high``: ends of the bin, in seconds since 1970 or in degrees. ``estimated``: with
    clock, heading and factor as they are estimated.
    """

    low: float
    high: float
    samples: int
    measured_w: float
    as_logged: float | None
    estimated: float | None


class Residuals(NamedTuple):
    """Errors by time, by the sun's elevation before and after noon, and by its bearing."""

    time: tuple[Residual, ...]
    morning: tuple[Residual, ...]
    afternoon: tuple[Residual, ...]
    bearing: tuple[Residual, ...]


def residuals(samples: Samples, counts: BoolArray, estimated_w: FloatArray | None) -> Residuals:
    """Errors of samples that count, in bins."""
    powers = (samples.measured_w, samples.modelled_w[samples.best_model], estimated_w)

    def binned(values: FloatArray, step: float, mask: BoolArray) -> tuple[Residual, ...]:
        number = np.floor(values / step).astype(int)
        every = (
            _residual(step, int(one), mask & (number == one), powers)
            for one in np.unique(number[mask])
        )
        least_w = _LEAST_SHARE * float(samples.measured_w.max())
        return tuple(
            one for one in every if one.samples >= _LEAST_SAMPLES and one.measured_w > least_w
        )

    for hours in _HOURS:
        step_s = 3600.0 * hours
        if len(np.unique(np.floor(samples.time_s[counts] / step_s))) <= _MOST_ROWS:
            break
    morning = samples.time_solar_h < 12.0
    turns = samples.bearing_deg if samples.detail is not None else np.zeros(0)
    return Residuals(
        time=binned(samples.time_s, step_s, counts),
        morning=binned(samples.elevation_deg, _STEP_DEG, counts & morning),
        afternoon=binned(samples.elevation_deg, _STEP_DEG, counts & ~morning),
        bearing=binned(turns, _SECTOR_DEG, counts) if len(turns) else (),
    )


def _residual(
    step: float,
    number: int,
    inside: BoolArray,
    powers: tuple[FloatArray, FloatArray, FloatArray | None],
) -> Residual:
    measured, logged, estimated = (None if p is None else float(p[inside].mean()) for p in powers)
    assert measured is not None
    assert logged is not None
    relative = [
        None if power is None or measured <= 0.0 else power / measured - 1.0
        for power in (logged, estimated)
    ]
    ends = (step * number, step * (number + 1))
    return Residual(*ends, int(inside.sum()), measured, *relative)


def residual_tables(found: Residuals, model: str) -> list[Table]:
    """The same as tables."""
    numbers = (
        Column("measured_w", "measured", "W", ".1f"),
        Column("as_logged_percent", "as logged", "%", "+.1f"),
        Column("estimated_percent", "estimated", "%", "+.1f"),
    )
    tables = []
    if found.time:
        rows = [
            (f"{utc_text(r.low)[5:16]} to {utc_text(r.high)[11:16]}", *_cells(r))
            for r in found.time
        ]
        tables.append(Table(f"{model} by time", (Column("UTC"), *numbers), tuple(rows)))
    rows = [
        (f"{r.low:.0f} to {r.high:.0f} {when}", *_cells(r))
        for when, part in (("morning", found.morning), ("afternoon", found.afternoon))
        for r in part
    ]
    if rows:
        head = Column("elevation", "elevation [deg]")
        tables.append(Table(f"{model} by the sun's elevation", (head, *numbers), tuple(rows)))
    if found.bearing:
        rows = [(f"{r.low:.0f} to {r.high:.0f}", *_cells(r)) for r in found.bearing]
        head = Column("bearing", "azimuth [deg]")
        title = f"{model} by the sun's azimuth from the nose, clockwise"
        tables.append(Table(title, (head, *numbers), tuple(rows)))
    return tables


def _cells(one: Residual) -> tuple[float | None, ...]:
    shares = (one.as_logged, one.estimated)
    return (one.measured_w, *(None if s is None else 100.0 * s for s in shares))
