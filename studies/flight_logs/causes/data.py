"""Power of a flight log as it is compared, and the errors that change within hours."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solar.types import BoolArray, FloatArray, IntArray
from studies.flight_logs.causes.forward import Forward, LogError, Parts

# Standard deviations of what every log may be off by; docs/verify.md gives sources.
ATTITUDE_BIAS = float(np.radians(0.5))
LOG_SIGMAS = {
    "clock_s": 10.0,
    "heading": ATTITUDE_BIAS,
    "roll": ATTITUDE_BIAS,
    "pitch": ATTITUDE_BIAS,
}
# What changes within hours: level, swing with the bearing, and its part across. CAM does not know
# how wind tilts the wing: in the report it is off by 7 % with another sign in the afternoon.
_DRIFT, _SWING, _ACROSS, CAM_DRIFT = 0.02, 0.1, 0.005, 0.1
_OF_TRACKERS = 0.02  # level of each MPPT: its sensor, and cells that are sorted to a few per cent
_KNOT_S = 7200.0


@dataclass(frozen=True)
class Data:
    """Power that is compared [W, by the unit that was found], a row for each MPPT at each sample.

    ``members``: surfaces of each MPPT whose power is known; of one, all of them.
    """

    forward: Forward
    measured: FloatArray
    members: BoolArray
    _cache: dict[LogError, Parts]

    @classmethod
    def of(cls, forward: Forward, measured: FloatArray, members: BoolArray | None = None) -> Data:
        """Samples of a log that are compared; with ``members`` by MPPTs, in columns."""
        whole = np.ones((1, 1), bool) if members is None else members
        return cls(forward, measured.ravel(), whole, {})

    @property
    def trackers(self) -> int:
        """Rows of each sample."""
        return len(self.members)

    @cached_property
    def time_s(self) -> FloatArray:
        """Times as logged."""
        return np.repeat(self.forward.log.time_s[self.forward.index], self.trackers)

    @cached_property
    def run(self) -> IntArray:
        """Number of the uninterrupted stretch of each sample."""
        return np.asarray(self.forward.log.segment()[self.forward.index], int)

    def some(self, count: int) -> Data:
        """The whole power at a few samples."""
        index = self.forward.index
        places = np.linspace(0, len(index) - 1, count).astype(int)
        whole = self.measured.reshape(-1, self.trackers).sum(axis=1)
        return Data.of(self.forward.of(index[places]), whole[places])

    @cached_property
    def peak(self) -> float:
        """Power that two in a hundred samples exceed: spikes do not count [W]."""
        return float(np.quantile(self.measured, 0.98))

    @property
    def geometric(self) -> tuple[str, ...]:
        """Errors of the log that the power depends on."""
        return tuple(LOG_SIGMAS) if self.forward.knows_angles else ("clock_s",)

    def parts(self, error: LogError) -> Parts:
        """Power of the surfaces, kept for the next that asks."""
        if error not in self._cache:
            if len(self._cache) > 40:
                self._cache.clear()
            self._cache[error] = self._rows(self.forward.parts(error))
        return self._cache[error]

    def _rows(self, parts: Parts) -> Parts:
        """Rows for each MPPT, with light on its own surfaces alone."""
        if self.trackers == 1:
            return parts
        every = Parts(*(np.repeat(values, self.trackers, axis=0) for values in parts))
        mine = np.tile(self.members, (len(self.forward.index), 1))
        return every._replace(direct=mine * every.direct, diffuse=mine * every.diffuse)

    def shadow_w(self, error: LogError) -> FloatArray | None:
        """Power of each row that the tail's shadow takes if it costs its area of direct light."""
        covered = self.forward.shadowed(error)
        if covered is None:
            return None
        covered = np.repeat(covered, self.trackers, axis=0)
        return np.asarray((self.parts(error).direct * covered).sum(axis=1))

    @cached_property
    def _hats(self) -> FloatArray:
        """Piecewise linear functions of time with a knot every two hours."""
        first, last = float(self.time_s.min()), float(self.time_s.max())
        knots = np.linspace(first, last, max(2, round((last - first) / _KNOT_S) + 1))
        eye = np.eye(len(knots))
        hats = np.stack([np.interp(self.time_s, knots, row) for row in eye], axis=1)
        return hats[:, hats.max(axis=0) > 0.0]

    def drifts(self, parts: Parts, power: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What changes within hours: columns of power [W] and their standard deviations."""
        hats = self._hats
        if not self.forward.knows_angles:
            hours = (self.time_s - self.time_s.mean()) / max(float(self.time_s.std()), 1.0)
            columns = np.column_stack([hats, hours]) * power[:, None]
            return columns, np.full(columns.shape[1], CAM_DRIFT)
        mean = np.maximum((parts.cosine * parts.direct).sum(axis=1), 1e-9)
        mean = np.maximum(mean / np.maximum(parts.direct.sum(axis=1), 1e-9), 0.05)
        swing = parts.direct.sum(axis=1) * np.clip(1.0 - 1.0 / (parts.air_mass * mean), -1.0, 1.0)
        shapes = (power, swing, power * np.cos(parts.bearing), power * np.sin(parts.bearing))
        columns = np.concatenate([hats * shape[:, None] for shape in shapes], axis=1)
        sigmas = np.repeat([_DRIFT, _SWING, _ACROSS, _ACROSS], hats.shape[1])
        if self.trackers > 1:
            own = np.tile(np.eye(self.trackers), (len(self.forward.index), 1)) * power[:, None]
            columns = np.concatenate([columns, own], axis=1)
            sigmas = np.append(sigmas, np.full(self.trackers, _OF_TRACKERS))
        return columns, sigmas
