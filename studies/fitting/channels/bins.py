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
        slot, stretch = np.floor(time_s[use] / BIN_S).astype(int), run[use]

        def steps(values: IntArray) -> IntArray:
            return np.diff(values, prepend=values[:1])

        number = np.cumsum((steps(slot) != 0) | (steps(stretch) != 0))
        first = np.flatnonzero(np.diff(number, prepend=-1))
        broken = (steps(slot[first]) > 1) | (steps(stretch[first]) != 0)
        return cls(number=number, counts=np.bincount(number), run=np.cumsum(broken))

    def mean(self, values: FloatArray) -> FloatArray:
        """Mean of the samples of each bin."""
        return np.asarray(np.bincount(self.number, values) / self.counts)
