"""Means of samples over a few minutes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solar.types import BoolArray, FloatArray, IntArray

BIN_S = 300.0


def long_stretches(time_s: FloatArray, run: IntArray, shortest_s: float) -> BoolArray:
    """Samples of stretches that are long enough."""
    first = np.concatenate(([0], np.flatnonzero(np.diff(run)) + 1))
    last = np.concatenate((first[1:], [len(run)])) - 1
    long = time_s[last] - time_s[first] >= shortest_s
    return np.asarray(np.repeat(long, last - first + 1))


@dataclass(frozen=True)
class Bins:
    """Samples dealt out to bins of time; ``number`` is the bin of each, ``run`` that of a bin."""

    number: IntArray
    counts: IntArray
    run: IntArray

    @classmethod
    def of(cls, time_s: FloatArray, run: IntArray, use: BoolArray) -> Bins:
        """Bins of the used samples; the end of a stretch or a bin without samples ends a run."""
        slot = np.floor(time_s[use] / BIN_S).astype(int)
        stretch = run[use]
        if not len(slot):
            nothing = np.zeros(0, int)
            return cls(nothing, nothing, nothing)
        step, new = np.diff(slot), np.diff(stretch) != 0
        number = np.concatenate(([0], np.cumsum((step != 0) | new)))
        first = np.concatenate(([0], np.flatnonzero(np.diff(number)) + 1))
        broken = (np.diff(slot[first]) > 1) | (np.diff(stretch[first]) != 0)
        return cls(
            number=number,
            counts=np.bincount(number),
            run=np.concatenate(([0], np.cumsum(broken))),
        )

    def mean(self, values: FloatArray) -> FloatArray:
        """Mean of the samples of each bin."""
        if not len(self.counts):
            return np.zeros(0)
        return np.asarray(np.bincount(self.number, values) / self.counts)
