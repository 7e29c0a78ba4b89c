"""Errors of a model over time, over the sun's elevation and bearing, and MPPT by MPPT."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from missions.logs.plausible import utc_text
from missions.logs.table import FlightLog
from solar.geometry import ModuleGeometry
from solar.types import BoolArray, FloatArray
from studies.flight_logs.forward import Forward, Samples
from studies.render.tables import Column, Table

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
    numbers = (
        Column("measured_w", "measured", "W", ".1f"),
        Column("as_logged_percent", "as logged", "%", "+.1f"),
        Column("estimated_percent", "estimated", "%", "+.1f"),
    )

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
        columns = (
            Column("MPPT"),
            Column("modules"),
            Column("measured_w", "measured", "W", ".2f"),
            Column("modelled_w", "FM", "W", ".2f"),
            Column("ratio_percent", "ratio", "%", ".1f"),
            Column("of_usual_percent", "of the median", "%", ".1f"),
        )
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
