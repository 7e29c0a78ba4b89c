"""Periods and modules with missing power that explain the residuals of a fit best."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from solar.geometry import ModuleGeometry
from solar.types import FloatArray, IntArray
from studies.flight_logs.causes.data import Data
from studies.flight_logs.causes.fit import Fit, Form, Loss
from studies.flight_logs.log_view import LOW_LIGHT_W_PER_M2

_EDGES = 40
_LEAST_SAMPLES = 5


class Shape(NamedTuple):
    """What may be lost: of which light and surfaces, for a while or from a time on."""

    form: Form
    surfaces: tuple[bool, ...]
    for_a_while: bool


class Candidate(NamedTuple):
    """A loss that explains something, and how many of its ends were searched for."""

    loss: Loss
    size: float
    ends: int
    gain: float


def subsets(geometry: ModuleGeometry | None) -> list[tuple[bool, ...]]:
    """Groups of modules that fail together: one, those of a side, a row, both outer ones."""
    if geometry is None:
        return []
    names = [(s.name, s.side, s.pitch_deg) for s in geometry.surfaces]
    groups = [tuple(one == other for other in names) for one in names]
    for part in (1, 2):
        for value in {name[part] for name in names}:
            inside = tuple(name[part] == value for name in names)
            groups += [inside, tuple(not one for one in inside)]
    unique = dict.fromkeys(g for g in groups if any(g) and not all(g))
    return list(unique)


class _Sums:
    """Sums over the samples up to each, from which those of any period follow."""

    def __init__(self, data: Data, fit: Fit, base: FloatArray, sigma: float, worth: float) -> None:
        jacobian, variance = fit.jacobian, sigma**2 / worth
        # Residuals of the log as it is: the errors that the fit took out come back.
        whole = fit.residual + jacobian @ fit.theta
        normal = jacobian.T @ jacobian / variance + np.diag(1.0 / fit.prior**2)
        inverse = np.linalg.inv(normal)
        self.answer = inverse @ (jacobian.T @ whole) / variance
        self.root = np.linalg.cholesky(inverse) / np.sqrt(variance)
        self.variance = variance
        zero = np.zeros(1)
        self.seen = np.concatenate([zero, np.cumsum(np.abs(base) > 0.0)])
        self.power = np.concatenate([zero, np.cumsum(base**2)])
        self.product = np.concatenate([zero, np.cumsum(base * whole)])
        rows = np.cumsum(base[:, None] * jacobian, axis=0)
        self.mixed = np.concatenate([np.zeros((1, jacobian.shape[1])), rows])

    def gains(self, first: IntArray, last: IntArray) -> tuple[FloatArray, FloatArray]:
        """Less misfit by a loss of the best size from one sample to before another, and that."""
        mixed = self.mixed[last] - self.mixed[first]
        product = mixed @ self.answer - self.product[last] + self.product[first]
        power = self.power[last] - self.power[first]
        power = power - np.sum((mixed @ self.root) ** 2, axis=1)
        enough = self.seen[last] - self.seen[first] >= _LEAST_SAMPLES
        usable = enough & (power > 1e-9) & (product > 0.0)  # power is lost, never won
        size = np.where(usable, product / np.where(usable, power, 1.0), 0.0)
        return size * product / self.variance, size


def best_losses(
    data: Data, fit: Fit, shapes: list[Shape], sigma: float, worth: float
) -> Iterator[Candidate]:
    """The best period of each shape; ``worth``: independent residuals for each sample."""
    count = len(data.time_s)
    edges = np.unique(np.linspace(0, count, _EDGES + 1).astype(int))
    parts = data.parts(fit.error)
    scale = fit.fitted / np.maximum(parts.power, 1e-9)
    for shape in shapes:
        light = parts.direct if shape.form == "direct" else parts.direct + parts.diffuse
        base = scale * light[:, np.array(shape.surfaces)].sum(axis=1)
        if shape.form == "low_light":
            base = np.where(parts.light < LOW_LIGHT_W_PER_M2, base, 0.0)
        sums = _Sums(data, fit, base, sigma, worth)
        first, last = _best(sums, edges, edges if shape.for_a_while else np.array([count]))
        width = int(count / _EDGES) + 1
        near = np.arange(max(first - width, 0), min(first + width, count))
        ends = np.arange(max(last - width, 1), min(last + width, count) + 1)
        first, last = _best(sums, near, ends if shape.for_a_while else np.array([count]))
        gain, size = (float(v[0]) for v in sums.gains(np.array([first]), np.array([last])))
        searched = int(first > 0) + int(last < count)
        start = data.time_s[first] if first > 0 else data.forward.log.time_s[0]
        end = data.time_s[last - 1] if last < count else data.forward.log.time_s[-1]
        loss = Loss(shape.form, float(start), float(end), shape.surfaces)
        yield Candidate(loss, min(size, 1.0), searched, gain)


def _best(sums: _Sums, firsts: IntArray, lasts: IntArray) -> tuple[int, int]:
    first, last = (a.ravel() for a in np.meshgrid(firsts, lasts, indexing="ij"))
    later = last > first
    first, last = first[later], last[later]
    best = int(np.argmax(sums.gains(first, last)[0]))
    return int(first[best]), int(last[best])
