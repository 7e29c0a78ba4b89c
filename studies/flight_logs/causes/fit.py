"""The most likely errors of log, model and sky under one hypothesis, and how well they fit.

Measured power is the modelled one under small errors that every log has, each with a known standard
deviation, and a few that a hypothesis leaves free. ``docs/verify.md`` has the equations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from solar.types import BoolArray, FloatArray
from studies.flight_logs.causes.data import LOG_SIGMAS, Data
from studies.flight_logs.causes.forward import LogError, Parts
from studies.flight_logs.log_view import LOW_LIGHT_W_PER_M2

# Standard deviations of what every log, model and sky may be off by; docs/verify.md gives sources.
MODEL_SIGMAS = {
    "level": 0.03,
    "haze": 0.1,
    "diffuse": 0.5,
    "scatter": 0.3,
    "circumsolar": 0.3,
    "incidence": 0.05,
    "oblique": 0.05,
    "grazing": 0.05,
    "warmth": 0.03,
    "low_light": 0.03,
}
# 1/cos of the incidence, less one, to 60, 75 and 80 deg: published curves of glass bend there, and
# each part is off by a slope of its own.
_SLANTS = {"incidence": (0.0, 1.0), "oblique": (1.0, 2.86), "grazing": (2.86, 5.0)}
_STEPS = {"clock_s": 30.0, "heading": 0.01, "roll": 0.005, "pitch": 0.005}
_LARGEST_STEPS = {"clock_s": 1800.0, "heading": 0.5, "roll": 0.1, "pitch": 0.1}
# Share of the light lost to haze that comes down as diffuse light: 0.9 are scattered, 0.84 of that
# forwards. Bird, R. E., Hulstrom, R. L. (1981), SERI/TR-642-761. Some is always left.
_FORWARD, _LEAST_DIFFUSE = 0.84 * 0.9, 0.1
# Student's t with four degrees of freedom: Lange, Little & Taylor (1989), JASA 84(408), 881-896.
_FREEDOM = 4.0
_SIGMA_OF_MAD = 1.4826
LEAST_SIGMA = 2e-3  # of the peak: below, tables and rounding of the model decide
_ROUNDS, _HALVINGS, _LEAST_GAIN = 60, 8, 0.02
# What is free: standard deviations, and lengths of what may be anything within a range.
_FREE = {"haze": 0.3, "level": 0.5}
_TILT = float(np.radians(30.0))
_RANGES = {"clock_s": 28.0 * 3600.0, "heading": 2.0 * np.pi, "roll": _TILT, "pitch": _TILT}
_UNBOUNDED = 1e3

Form = Literal["share", "direct", "low_light", "shadow"]


@dataclass(frozen=True)
class Loss:
    """Power missing from one time to another [s], as logged.

    A share of all light, of direct light (a cloud), or of light that is low, of some surfaces; or
    of ``shadow_w``, what the tail's shadow takes of the samples in proportion to its area [W].
    ``whole``: all of it is lost, as by a dead string, so that no size is fitted.
    """

    form: Form
    start_s: float
    end_s: float
    surfaces: tuple[bool, ...]
    shadow_w: FloatArray | None = None
    whole: bool = False

    def acts(self, time_s: FloatArray, light: FloatArray) -> BoolArray:
        """Samples that it acts on."""
        inside = self._inside(time_s)
        return inside & (light < LOW_LIGHT_W_PER_M2) if self.form == "low_light" else inside

    def is_unsure(self, time_s: FloatArray, light: FloatArray) -> BoolArray:
        """Samples that it may act on or not: light near the limit is known to its level only."""
        if self.form != "low_light":
            return np.zeros(len(time_s), bool)
        near = np.abs(light / LOW_LIGHT_W_PER_M2 - 1.0) < MODEL_SIGMAS["level"]
        return np.asarray(self._inside(time_s) & near)

    def _inside(self, time_s: FloatArray) -> BoolArray:
        return np.asarray((time_s >= self.start_s) & (time_s <= self.end_s))


class Hypothesis(NamedTuple):
    """What is taken to be wrong: an error of the log to start from, what is free, what is lost."""

    start: LogError = LogError()
    free: tuple[str, ...] = ()
    losses: tuple[Loss, ...] = ()
    sizes: tuple[float, ...] = ()  # of the losses, to start from
    cap_w: float | None = None
    parameters: int = 0  # that were fitted on the way: ends of periods, a cap
    choices: float = 0.0  # twice the logarithm of the number of equals that it is the best of


@dataclass(frozen=True)
class Fit:
    """Most likely errors under a hypothesis.

    ``values``, ``sigmas``: the errors by name, amplitudes of losses by ``loss0``, ``loss1`` ...
    ``error``: that of the log. ``residual``: measured minus fitted power [W]. ``ranges``: standard
    deviations of all errors, of those within a range that of a normal one as likely at its peak.
    """

    hypothesis: Hypothesis
    error: LogError
    values: Mapping[str, float]
    sigmas: Mapping[str, float]
    fitted: FloatArray
    residual: FloatArray
    penalty: float
    theta: FloatArray
    jacobian: FloatArray
    prior: FloatArray
    ranges: FloatArray

    @cached_property
    def scale(self) -> float:
        """Robust standard deviation of the residual [W]."""
        return _SIGMA_OF_MAD * float(np.median(np.abs(self.residual)))

    def cost(self, noise: Noise) -> float:
        """Misfit of as many residuals as are independent, and of what has a known spread."""
        u2 = (self.residual / noise.sigma) ** 2
        loss = (_FREEDOM + 1.0) * np.log1p(u2 / _FREEDOM)
        return float(noise.worth * loss.sum() + self.penalty)

    def score(self, noise: Noise) -> float:
        """Minus twice the logarithm of the evidence by Laplace's method."""
        if noise not in self._scores:
            normal = _squared(self.jacobian * self.ranges, weights(self.residual, noise))
            volume = np.linalg.slogdet(normal + np.eye(len(normal)))[1]
            ends = self.hypothesis.parameters * np.log(noise.worth * len(self.residual))
            found = self.cost(noise) + volume + ends + self.hypothesis.choices
            self._scores[noise] = float(found)
        return self._scores[noise]

    @cached_property
    def _scores(self) -> dict[Noise, float]:
        return {}


def modelled(
    parts: Parts,
    values: Mapping[str, float],
    losses: Sequence[Loss] = (),
    acts: Sequence[BoolArray] = (),
) -> FloatArray:
    """Power [W] with errors of model and sky, and what is lost where losses act."""
    slant = np.minimum(1.0 / np.maximum(parts.cosine, 0.1) - 1.0, 5.0)
    passed = np.exp(-values["haze"] * parts.air_mass)
    direct = parts.direct * passed[:, None]
    less = sum(values[n] * (slant.clip(*ends) - ends[0]) for n, ends in _SLANTS.items())
    direct = direct * (1.0 - less)
    # Light from around the sun comes as direct light does: Hay & Davies (1980), whose share is that
    # of the direct light that is left.
    circumsolar = (parts.passed * passed + values["circumsolar"])[:, None]
    toward = np.maximum(parts.cosine, 0.0) * np.minimum(parts.air_mass, 10.0)[:, None] - 1.0
    scatter = np.exp(values["diffuse"] + values["scatter"] * (parts.air_mass - 1.0).clip(0.0, 4.0))
    scatter *= np.maximum(1.0 + _FORWARD * parts.beam_over_diffuse * (1.0 - passed), _LEAST_DIFFUSE)
    diffuse = parts.diffuse * scatter[:, None] * (1.0 + circumsolar * toward)
    shadow: FloatArray | float = 0.0
    for number, (loss, on) in enumerate(zip(losses, acts, strict=True)):
        if loss.shadow_w is not None:
            shadow = values[f"loss{number}"] * loss.shadow_w
            continue
        lost = 1.0 if loss.whole else values[f"loss{number}"]
        left = 1.0 - lost * (on[:, None] & np.array(loss.surfaces))
        direct = direct * left
        diffuse = diffuse if loss.form == "direct" else diffuse * left
    power = (direct + diffuse).sum(axis=1) - shadow
    bright = np.log(np.maximum(parts.light, 20.0) / 1000.0)
    curve = values["low_light"] * bright - values["warmth"] * np.exp(bright)
    return np.asarray((1.0 + values["level"]) * power * (1.0 + curve))


class Noise(NamedTuple):
    """Deviation of the residuals [W], zero: unknown; how many of each sample are independent."""

    sigma: float = 0.0
    worth: float = 0.2


UNKNOWN_NOISE = Noise()


def weights(residual: FloatArray, noise: Noise) -> FloatArray:
    """Weights of residuals [1/W2]: of outliers less."""
    size = (residual / noise.sigma) ** 2
    return np.asarray(noise.worth / noise.sigma**2 * (_FREEDOM + 1.0) / (_FREEDOM + size), float)


def _squared(columns: FloatArray, weight: FloatArray) -> FloatArray:
    """Columns times columns, rows weighted: of one factor, whose product takes half the time."""
    scaled = columns * np.sqrt(weight)[:, None]
    return np.asarray(scaled.T @ scaled)


def fitted(
    data: Data, hypothesis: Hypothesis, noise: Noise = UNKNOWN_NOISE, known: Fit | None = None
) -> Fit:
    """Most likely errors by reweighted Gauss-Newton steps, from ``known`` at the same log error."""
    problem = _Problem.of(data, hypothesis)
    state = problem.start(known)
    for _ in range(_ROUNDS):
        scale = noise.sigma or problem.scale(state)
        step, normal = problem.step(state, scale, noise.worth)
        least = problem.objective(state, scale, noise.worth)
        gained = 0.0
        for _ in range(_HALVINGS):
            tried = problem.moved(state, step)
            gained = least - problem.objective(tried, scale, noise.worth)
            if gained > 0.0:
                state = tried
                break
            step = 0.5 * step
        if gained < _LEAST_GAIN:
            break
    _, normal = problem.step(state, noise.sigma or problem.scale(state), noise.worth)
    theta, prior = state.theta, problem.prior(state)
    names, covariance = problem.names, np.linalg.inv(normal)
    # What is found of an angle holds the bias that every log has.
    bias = np.array([LOG_SIGMAS[n] if n in problem.moving else 0.0 for n in names])
    sigmas = np.hypot(np.sqrt(np.diag(covariance))[: len(names)], bias)
    values = dict(zip(names, theta[: len(names)].tolist(), strict=True))
    return Fit(
        hypothesis=hypothesis,
        error=state.error,
        values=values,
        sigmas=dict(zip(names, sigmas.tolist(), strict=True)),
        fitted=data.measured - state.residual,
        residual=state.residual,
        penalty=float(np.sum((theta / prior) ** 2)),
        theta=theta,
        jacobian=state.columns,
        prior=prior,
        ranges=np.concatenate([problem.spreads, state.spread]),
    )


class _State(NamedTuple):
    """Where a fit is: error of the log, other errors and drifts, columns, residual [W].

    ``slopes``: columns of clock and angles, at the error of the log ``near``.
    """

    error: LogError
    theta: FloatArray
    columns: FloatArray
    spread: FloatArray
    residual: FloatArray
    slopes: Mapping[str, FloatArray]
    near: LogError


@dataclass(frozen=True)
class _Problem:
    """Names of the errors of one hypothesis, which of them are free, and where losses act.

    That is decided where the hypothesis starts: with samples that move in and out of a loss, or
    only nearly so, a few would tell clock and angles far better than they can.
    """

    data: Data
    hypothesis: Hypothesis
    names: tuple[str, ...]
    moving: tuple[str, ...]
    sigmas: FloatArray
    spreads: FloatArray
    acts: tuple[BoolArray, ...]
    unsure: BoolArray

    @classmethod
    def of(cls, data: Data, hypothesis: Hypothesis) -> _Problem:
        losses = tuple(f"loss{i}" for i in range(len(hypothesis.losses)))
        names = (*MODEL_SIGMAS, *losses, *data.geometric)
        free = {*hypothesis.free, *losses}
        usual = {**MODEL_SIGMAS, **LOG_SIGMAS, **dict.fromkeys(losses, 1.0)}
        wide = {n: _FREE.get(n, _UNBOUNDED * usual[n]) for n in free}
        sized = (n for n, one in zip(losses, hypothesis.losses, strict=True) if not one.whole)
        ranges = {n: _RANGES[n] for n in free if n in _RANGES} | dict.fromkeys(sized, 1.0)
        as_normal = {n: length / np.sqrt(2.0 * np.pi) for n, length in ranges.items()}
        known = {**usual, **wide}
        sigmas = np.array([known[n] for n in names])
        spreads = np.array([as_normal.get(n, known[n]) for n in names])
        moving = tuple(n for n in data.geometric if n in free)
        given = data.time_s, data.parts(hypothesis.start).light
        acts = tuple(one.acts(*given) for one in hypothesis.losses)
        unsure = np.zeros(len(data.time_s), bool)
        for one in hypothesis.losses:
            unsure |= one.is_unsure(*given)
        return cls(data, hypothesis, names, moving, sigmas, spreads, acts, unsure)

    def start(self, known: Fit | None) -> _State:
        """What is known already, and the losses by their size."""
        values = dict.fromkeys(self.names, 0.0)
        error, drift = self.hypothesis.start, np.zeros(0)
        if known is not None and known.error == error:
            values |= {n: v for n, v in known.values.items() if n in values}
            drift = known.theta[len(known.values) :]
        values |= {f"loss{place}": size for place, size in enumerate(self.hypothesis.sizes)}
        # What a fit is free to move is an error of the log from the start, not a small one beside.
        error = error.plus({name: values[name] for name in self.moving})
        values |= dict.fromkeys(self.moving, 0.0)
        return self._state(error, np.concatenate([list(values.values()), drift]))

    def _state(self, error: LogError, theta: FloatArray, last: _State | None = None) -> _State:
        data, count = self.data, len(self.names)
        slopes, near = dict[str, FloatArray](), error
        # Clock and angles act alike nearby; at the same ones their power is kept.
        if last is not None and error != last.near and error.near(last.near, _STEPS):
            slopes, near = dict(last.slopes), last.near
        values = dict(zip(self.names, theta[:count].tolist(), strict=True))

        def at(other: LogError, **changed: float) -> FloatArray:
            parts = data.parts(other)
            return modelled(parts, values | changed, self.hypothesis.losses, self.acts)

        power = at(error)
        columns = []
        for name in self.names:
            if name not in _STEPS:
                columns.append((at(error, **{name: values[name] + 1e-4}) - power) / 1e-4)
                continue
            if name not in slopes:
                slopes[name] = (at(error.plus({name: _STEPS[name]})) - power) / _STEPS[name]
            columns.append(slopes[name])
        drifts, spread = data.drifts(data.parts(error), power)
        every = np.concatenate([np.stack(columns, axis=1), drifts], axis=1)
        theta = np.resize(np.append(theta, np.zeros(len(spread))), count + len(spread))
        # Small errors of clock and angles act in proportion; the rest is in the power already.
        linear = np.array([n in _STEPS for n in self.names] + [True] * len(spread))
        whole = power + every[:, linear] @ theta[linear]
        if (cap := self.hypothesis.cap_w) is not None:
            every = np.where((whole > cap)[:, None], 0.0, every)
            whole = np.minimum(whole, cap)
        if self.unsure.any():
            every = np.where(self.unsure[:, None], 0.0, every)
            whole = np.where(self.unsure, data.measured, whole)
        return _State(error, theta, every, spread, data.measured - whole, slopes, near)

    def prior(self, state: _State) -> FloatArray:
        """Standard deviations of all errors and drifts."""
        return np.concatenate([self.sigmas, state.spread])

    def scale(self, state: _State) -> float:
        """Robust standard deviation of the residual [W]."""
        mad = _SIGMA_OF_MAD * float(np.median(np.abs(state.residual)))
        return max(mad, LEAST_SIGMA * self.data.peak)

    def objective(self, state: _State, scale: float, worth: float) -> float:
        """What is made small: misfit and, by their known spread, all errors."""
        loss = (_FREEDOM + 1.0) * np.log1p((state.residual / scale) ** 2 / _FREEDOM)
        return float(worth * loss.sum() + np.sum((state.theta / self.prior(state)) ** 2))

    def step(self, state: _State, scale: float, worth: float) -> tuple[FloatArray, FloatArray]:
        """The next step, and the normal matrix."""
        weight = weights(state.residual, Noise(scale, worth))
        inverse = 1.0 / self.prior(state) ** 2
        normal = _squared(state.columns, weight) + np.diag(inverse)
        pull = state.columns.T @ (weight * state.residual) - inverse * state.theta
        step = np.asarray(np.linalg.solve(normal, pull))
        lost = np.flatnonzero([name.startswith("loss") for name in self.names])
        if len(lost):  # no more than all is lost: the others answer to what is left of that step
            bounded = np.clip(state.theta[lost] + step[lost], -0.5, 1.0) - state.theta[lost]
            rest = np.setdiff1d(np.arange(len(step)), lost)
            known = pull[rest] - normal[np.ix_(rest, lost)] @ bounded
            step[lost], step[rest] = bounded, np.linalg.solve(normal[np.ix_(rest, rest)], known)
        return step, normal

    def moved(self, state: _State, step: FloatArray) -> _State:
        """After a step, no longer than the errors are near to straight lines."""
        count = len(self.names)
        limits = np.array([_LARGEST_STEPS.get(n, 0.5) for n in self.names])
        longest = float(np.max(np.abs(step[:count]) / limits))
        theta = state.theta + step / max(longest, 1.0)
        changes = {}
        for place, name in enumerate(self.names):
            if name in self.moving:
                changes[name], theta[place] = float(theta[place]), 0.0
        return self._state(state.error.plus(changes), theta, state)
