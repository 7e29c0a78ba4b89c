"""Power of each MPPT beside that of its own modules."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from missions.logs.table import FlightLog
from sizing.results.tables import Column, Table
from solar.geometry import ModuleGeometry
from solar.types import BoolArray, FloatArray
from studies.flight_logs.forward import Forward

_PLACES = {"center": "centre", "middle": "centre"}


class TrackerPower(NamedTuple):
    """Mean power of an MPPT [W] and what its modules should give."""

    name: str
    modules: tuple[str, ...]
    measured_w: float
    modelled_w: float

    @property
    def ratio(self) -> float:
        """Measured over modelled power."""
        return self.measured_w / max(self.modelled_w, 1e-9)


class Trackers(NamedTuple):
    """MPPTs in the mean and at every sample, shape (samples, MPPTs); ``how`` modules are known."""

    each: tuple[TrackerPower, ...]
    measured_w: FloatArray
    modelled_w: FloatArray
    how: str

    def table(self) -> Table:
        """Power of each MPPT over that of its modules, and that over the median of all."""
        columns = (
            Column("MPPT"),
            Column("modules"),
            Column("measured_w", "measured", "W", ".2f"),
            Column("modelled_w", "FM", "W", ".2f"),
            Column("ratio_percent", "ratio", "%", ".1f"),
            Column("of_usual_percent", "of the median", "%", ".1f"),
        )
        usual = max(float(np.median([one.ratio for one in self.each])), 1e-9)
        rows = [
            (one.name, ", ".join(one.modules), *one[2:], 100 * one.ratio, 100 * one.ratio / usual)
            for one in self.each
        ]
        return Table(f"power of the MPPTs; their modules {self.how}", columns, tuple(rows))


def surfaces_of(log: FlightLog, geometry: ModuleGeometry | None) -> tuple[BoolArray | None, str]:
    """Surfaces of each MPPT and how that is known, or why not; no words without several MPPTs."""
    names = tuple(log.tracker_power_w)
    if not names:
        return None, ""
    if geometry is None or log.attitude is None:
        return None, "MPPTs are not compared one by one: that needs VM and FM"
    surfaces = geometry.surfaces
    found = np.array(
        [[_words(name) <= _words(f"{s.name} {s.side}") for s in surfaces] for name in names]
    )
    if all(_words(name) for name in names) and np.all(found.sum(axis=0) == 1):
        return found, "by name"
    wired = sorted({s.mppt for s in surfaces if s.mppt is not None})
    if len(wired) == len(names) and all(s.mppt is not None for s in surfaces):
        return np.array([[s.mppt == one for s in surfaces] for one in wired]), (
            "by the surfaces' mppt"
        )
    if len(names) == len(surfaces) and not wired:
        return np.eye(len(names), dtype=bool), "in the order of the surfaces"
    return None, (
        f"MPPTs are not compared one by one: {len(names)} columns, {len(surfaces)} surfaces of "
        "modules.geometry; say with their key mppt which number each is connected to"
    )


def compared(lit: Forward, own: BoolArray, how: str, counts: BoolArray) -> Trackers:
    """Each MPPT beside the Full Model of its modules, in the mean of the samples that count."""
    assert lit.geometry is not None  # so are its surfaces
    power, surfaces = lit.log.tracker_power_w, lit.geometry.surfaces
    measured = np.stack([one[lit.index] for one in power.values()], axis=1)
    modelled = np.concatenate([part.power_by_surface_w() @ own.T for part in lit.chunks()])
    modules = [tuple(s.name for s, is_own in zip(surfaces, row, strict=True) if is_own)
               for row in own]  # fmt: skip
    means = (values[counts].mean(axis=0).tolist() for values in (measured, modelled))
    return Trackers(tuple(map(TrackerPower, power, modules, *means)), measured, modelled, how)


def _words(name: str) -> set[str]:
    """Words of a name that say where on the wing something is."""
    found = re.findall(r"left|right|cent(?:re|er)|middle|front|rear|inner|outer", name.lower())
    return {_PLACES.get(word, word) for word in found}
