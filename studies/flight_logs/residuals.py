"""Errors of a model over time, over the sun's elevation and bearing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from missions.logs.plausible import utc_text
from sizing.results.tables import Column, Table
from solar.types import BoolArray, FloatArray
from studies.flight_logs.forward import Samples

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
    as_logged: float
    estimated: float | None

    def cells(self) -> tuple[float | None, ...]:
        """Power, and errors in percent, of a row of a table."""
        estimated = None if self.estimated is None else 100.0 * self.estimated
        return self.measured_w, 100.0 * self.as_logged, estimated


class Residuals(NamedTuple):
    """Errors by time, by the sun's elevation before and after noon, and by its bearing."""

    time: tuple[Residual, ...]
    morning: tuple[Residual, ...]
    afternoon: tuple[Residual, ...]
    bearing: tuple[Residual, ...]


def residuals(samples: Samples, counts: BoolArray, estimated_w: FloatArray | None) -> Residuals:
    """Errors of samples that count, in bins that have enough samples and power."""
    powers = [samples.measured_w, samples.modelled_w[samples.best_model]]
    powers += [] if estimated_w is None else [estimated_w]
    least_w = max(_LEAST_SHARE * float(samples.measured_w.max()), 0.0)

    def binned(values: FloatArray, step: float, mask: BoolArray) -> tuple[Residual, ...]:
        frame = pd.DataFrame(np.stack(powers, axis=1)[mask])
        groups = frame.groupby(np.floor(values[mask] / step))
        result = []
        for number, count, measured, *modelled in (
            groups.mean().assign(n=groups.size())[["n", *frame]].itertuples()
        ):
            if count >= _LEAST_SAMPLES and measured > least_w:
                logged, estimated = ([w / measured - 1.0 for w in modelled] + [None])[:2]
                ends = step * number, step * (number + 1.0)
                result.append(Residual(*ends, int(count), measured, logged, estimated))
        return tuple(result)

    for hours in _HOURS:
        step_s = 3600.0 * hours
        if len(np.unique(np.floor(samples.time_s[counts] / step_s))) <= _MOST_ROWS:
            break
    morning = samples.time_solar_h < 12.0
    return Residuals(
        time=binned(samples.time_s, step_s, counts),
        morning=binned(samples.elevation_deg, _STEP_DEG, counts & morning),
        afternoon=binned(samples.elevation_deg, _STEP_DEG, counts & ~morning),
        bearing=binned(samples.bearing_deg, _SECTOR_DEG, counts) if samples.detail else (),
    )


def residual_tables(found: Residuals, model: str) -> list[Table]:
    """The same as tables."""
    numbers = (
        Column("measured_w", "measured", "W", ".1f"),
        Column("as_logged_percent", "as logged", "%", "+.1f"),
        Column("estimated_percent", "estimated", "%", "+.1f"),
    )
    time = [
        (f"{utc_text(r.low)[5:16]} to {utc_text(r.high)[11:16]}", *r.cells()) for r in found.time
    ]
    halves = (("morning", found.morning), ("afternoon", found.afternoon))
    elevation = [
        (f"{r.low:.0f} to {r.high:.0f} {when}", *r.cells()) for when, half in halves for r in half
    ]
    bearing = [(f"{r.low:.0f} to {r.high:.0f}", *r.cells()) for r in found.bearing]
    tables = (
        ("time", Column("UTC"), time),
        ("the sun's elevation", Column("elevation", "elevation [deg]"), elevation),
        ("the sun's azimuth from the nose, clockwise",
         Column("bearing", "azimuth [deg]"), bearing),
    )  # fmt: skip
    return [
        Table(f"{model} by {what}", (head, *numbers), tuple(rows))
        for what, head, rows in tables
        if rows
    ]
