"""Power of each MPPT beside that of its own modules."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from missions.logs.table import FlightLog
from sizing.results.tables import Column, Table
from solar.geometry import ModuleGeometry
from solar.types import BoolArray, FloatArray
from studies.flight_logs.forward import Forward

_PLACES = {"center": "centre", "middle": "centre"}


class Trackers(NamedTuple):
    """MPPTs of a log: ``members`` has the surfaces of each, ``how`` says how that is known."""

    names: tuple[str, ...]
    members: BoolArray
    how: str

    @classmethod
    def of(cls, log: FlightLog, geometry: ModuleGeometry | None) -> tuple[Trackers | None, str]:
        """MPPTs whose modules are known, or why they are not; no words without several of them."""
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
            return cls(names, found, "by name"), ""
        wired = sorted({s.mppt for s in surfaces if s.mppt is not None})
        if len(wired) == len(names) and all(s.mppt is not None for s in surfaces):
            members = np.array([[s.mppt == number for s in surfaces] for number in wired])
            return cls(names, members, "by the surfaces' mppt"), ""
        if len(names) == len(surfaces) and not wired:
            return cls(names, np.eye(len(names), dtype=bool), "in the order of the surfaces"), ""
        return None, (
            f"MPPTs are not compared one by one: {len(names)} columns, {len(surfaces)} surfaces of "
            "modules.geometry; say with their key mppt which number each is connected to"
        )

    def power_w(self, log: FlightLog) -> FloatArray:
        """Power of each as logged [W], shape (samples, MPPTs)."""
        return np.stack([log.tracker_power_w[name] for name in self.names], axis=1)

    def modelled_w(self, forward: Forward) -> FloatArray:
        """Power that the Full Model gives the modules of each [W], shape (samples, MPPTs)."""
        parts = [chunk.power_by_surface_w() @ self.members.T for chunk in forward.chunks()]
        return np.asarray(np.concatenate(parts), float)

    def compared(
        self, forward: Forward, measured: FloatArray, modelled: FloatArray
    ) -> tuple[TrackerPower, ...]:
        """Each beside the Full Model of its modules, in the mean of some samples."""
        assert forward.geometry is not None
        surfaces = forward.geometry.surfaces
        modules = [
            tuple(s.name for s, own in zip(surfaces, mine, strict=True) if own)
            for mine in self.members
        ]
        means = measured.mean(axis=0).tolist(), modelled.mean(axis=0).tolist()
        return tuple(map(TrackerPower, self.names, modules, *means))


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


def tracker_table(every: Sequence[TrackerPower], how: str) -> Table:
    """Power of each MPPT over that of its modules, and that over the median of all."""
    columns = (
        Column("MPPT"),
        Column("modules"),
        Column("measured_w", "measured", "W", ".2f"),
        Column("modelled_w", "FM", "W", ".2f"),
        Column("ratio_percent", "ratio", "%", ".1f"),
        Column("of_usual_percent", "of the median", "%", ".1f"),
    )
    ratios = 100.0 * np.array([one.ratio for one in every])
    usual = 100.0 * ratios / max(float(np.median(ratios)), 1e-9)
    rows = [
        (one.name, ", ".join(one.modules), one.measured_w, one.modelled_w, *map(float, relative))
        for one, *relative in zip(every, ratios, usual, strict=True)
    ]
    return Table(f"power of the MPPTs; their modules {how}", columns, tuple(rows))


def _words(name: str) -> set[str]:
    """Words of a name that say where on the wing something is."""
    found = re.findall(r"left|right|cent(?:re|er)|middle|front|rear|inner|outer", name.lower())
    return {_PLACES.get(word, word) for word in found}
