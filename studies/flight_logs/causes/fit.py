"""The most likely errors of log, model and sky under one hypothesis, and how well they fit.

Measured power is the modelled one under small errors that every log has, each with a known standard
deviation, and a few that a hypothesis leaves free. ``docs/verify.md`` has the equations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from solar.types import BoolArray, FloatArray, IntArray
from studies.flight_logs.autocorrelation import correlation_time
from studies.flight_logs.causes.forward import Forward, LogError, Parts
from studies.flight_logs.log_view import LOW_LIGHT_W_PER_M2

# Standard deviations of what every log, model and sky may be off by; docs/verify.md gives sources.
MODEL_SIGMAS = {
    "level": 0.03,
    "haze": 0.1,
    "diffuse": 0.5,
    "scatter": 0.3,
    "circumsolar": 0.7,
    "incidence": 0.05,
    "warmth": 0.03,
    "low_light": 0.03,
}
ATTITUDE_BIAS = float(np.radians(0.5))
LOG_SIGMAS = {
    "clock_s": 10.0,
    "heading": ATTITUDE_BIAS,
    "roll": ATTITUDE_BIAS,
    "pitch": ATTITUDE_BIAS,
}
_STEPS = {"clock_s": 30.0, "heading": 0.01, "roll": 0.005, "pitch": 0.005}
_LARGEST_STEPS = {"clock_s": 1800.0, "heading": 0.5, "roll": 0.1, "pitch": 0.1}
# What changes within hours: level, swing with the bearing, and its part across. CAM does not know
# how wind tilts the wing: in the report it is off by 7 % with another sign in the afternoon.
_DRIFT, _SWING, _ACROSS, CAM_DRIFT = 0.02, 0.1, 0.005, 0.1
_OF_TRACKERS = 0.02  # level of each MPPT: its sensor, and cells that are sorted to a few per cent
_KNOT_S = 7200.0
# Student's t with four degrees of freedom: Lange, Little & Taylor (1989), JASA 84(408), 881-896.
_FREEDOM = 4.0
_SIGMA_OF_MAD = 1.4826
_LEAST_SIGMA = 2e-3  # of the peak: below, tables and rounding of the model decide
_ROUNDS, _HALVINGS, _LEAST_GAIN = 60, 8, 0.02
_SECTORS, _CLUSTER_S = 12, 3600.0
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
        inside = (time_s >= self.start_s) & (time_s <= self.end_s)
        return inside & (light < LOW_LIGHT_W_PER_M2) if self.form == "low_light" else inside


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
            scaled = self.jacobian * self.ranges
            normal = (scaled * weights(self.residual, noise)[:, None]).T @ scaled
            volume = np.linalg.slogdet(normal + np.eye(len(normal)))[1]
            ends = self.hypothesis.parameters * np.log(noise.worth * len(self.residual))
            found = self.cost(noise) + volume + ends + self.hypothesis.choices
            self._scores[noise] = float(found)
        return self._scores[noise]

    @cached_property
    def _scores(self) -> dict[Noise, float]:
        return {}


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


def modelled(
    parts: Parts, values: Mapping[str, float], hypothesis: Hypothesis, time_s: FloatArray
) -> FloatArray:
    """Power [W] with errors of model and sky, and what is lost."""
    slant = np.minimum(1.0 / np.maximum(parts.cosine, 0.1) - 1.0, 5.0)
    direct = parts.direct * np.exp(-values["haze"] * parts.air_mass)[:, None]
    direct = direct * (1.0 - values["incidence"] * slant)
    # Light from around the sun comes as direct light does: Hay & Davies (1980).
    toward = np.maximum(parts.cosine, 0.0) * np.minimum(parts.air_mass, 10.0)[:, None] - 1.0
    scatter = np.exp(values["diffuse"] + values["scatter"] * (parts.air_mass - 1.0).clip(0.0, 4.0))
    diffuse = parts.diffuse * scatter[:, None] * (1.0 + values["circumsolar"] * toward)
    shadow: FloatArray | float = 0.0
    for number, loss in enumerate(hypothesis.losses):
        if loss.shadow_w is not None:
            shadow = values[f"loss{number}"] * loss.shadow_w
            continue
        acts = loss.acts(time_s, parts.light)[:, None] & np.array(loss.surfaces)
        left = np.where(acts, 0.0 if loss.whole else 1.0 - values[f"loss{number}"], 1.0)
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
    """Where a fit is: error of the log, other errors and drifts, columns, residual [W]."""

    error: LogError
    theta: FloatArray
    columns: FloatArray
    spread: FloatArray
    residual: FloatArray


@dataclass(frozen=True)
class _Problem:
    """Names of the errors of one hypothesis, and which of them are free."""

    data: Data
    hypothesis: Hypothesis
    names: tuple[str, ...]
    moving: tuple[str, ...]
    sigmas: FloatArray
    spreads: FloatArray

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
        return cls(data, hypothesis, names, moving, sigmas, spreads)

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

    def _state(self, error: LogError, theta: FloatArray) -> _State:
        data, count = self.data, len(self.names)
        values = dict(zip(self.names, theta[:count].tolist(), strict=True))

        def at(other: LogError, **changed: float) -> FloatArray:
            parts = data.parts(other)
            return modelled(parts, values | changed, self.hypothesis, data.time_s)

        power = at(error)
        columns = []
        for name in self.names:
            step = _STEPS.get(name, 1e-4)
            other = error.plus({name: step}) if name in _STEPS else error
            changed = {} if name in _STEPS else {name: values[name] + step}
            columns.append((at(other, **changed) - power) / step)
        drifts, spread = data.drifts(data.parts(error), power)
        every = np.concatenate([np.stack(columns, axis=1), drifts], axis=1)
        theta = np.resize(np.append(theta, np.zeros(len(spread))), count + len(spread))
        # Small errors of clock and angles act in proportion; the rest is in the power already.
        linear = np.array([n in _STEPS for n in self.names] + [True] * len(spread))
        whole = power + every[:, linear] @ theta[linear]
        if (cap := self.hypothesis.cap_w) is not None:
            every = np.where((whole > cap)[:, None], 0.0, every)
            whole = np.minimum(whole, cap)
        return _State(error, theta, every, spread, data.measured - whole)

    def prior(self, state: _State) -> FloatArray:
        """Standard deviations of all errors and drifts."""
        return np.concatenate([self.sigmas, state.spread])

    def scale(self, state: _State) -> float:
        """Robust standard deviation of the residual [W]."""
        mad = _SIGMA_OF_MAD * float(np.median(np.abs(state.residual)))
        return max(mad, _LEAST_SIGMA * self.data.peak)

    def objective(self, state: _State, scale: float, worth: float) -> float:
        """What is made small: misfit and, by their known spread, all errors."""
        loss = (_FREEDOM + 1.0) * np.log1p((state.residual / scale) ** 2 / _FREEDOM)
        return float(worth * loss.sum() + np.sum((state.theta / self.prior(state)) ** 2))

    def step(self, state: _State, scale: float, worth: float) -> tuple[FloatArray, FloatArray]:
        """The next step, and the normal matrix."""
        weight = weights(state.residual, Noise(scale, worth))
        inverse = 1.0 / self.prior(state) ** 2
        normal = (state.columns * weight[:, None]).T @ state.columns + np.diag(inverse)
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
        return self._state(state.error.plus(changes), theta)


def noise_of(data: Data, fit: Fit) -> Noise:
    """Scatter of the residuals, and how many of them are independent; outliers count less.

    Errors of a model last, and return on every circle: the design effect of clusters (Kish, L.
    (1965), Survey Sampling, section 5.4) of one hour and one sector of the sun's bearing.
    """
    sigma = max(fit.scale, _LEAST_SIGMA * data.peak)
    residual = np.clip(fit.residual, -3.0 * sigma, 3.0 * sigma)
    sector = np.floor(data.parts(fit.error).bearing * _SECTORS / (2.0 * np.pi)) % _SECTORS
    hour = np.floor((data.time_s - data.time_s[0]) / _CLUSTER_S)
    tracker = np.tile(np.arange(data.trackers), len(data.run))
    power = max(float(np.sum(residual**2)), 1e-300)
    effects = []
    for own in {0, data.trackers}:  # of all MPPTs together, and of each
        group = _SECTORS * hour + sector + 1e6 * np.minimum(tracker, own)
        cluster = np.unique(group, return_inverse=True)[1]
        effects.append(float(np.sum(np.bincount(cluster, residual) ** 2)) / power)
    by_tracker = residual.reshape(-1, data.trackers).T.ravel()
    runs = np.concatenate([data.run + (data.run.max() + 1) * i for i in range(data.trackers)])
    time = correlation_time(by_tracker, runs, fit.jacobian.shape[1])
    return Noise(sigma, 1.0 / max(*effects, time, 1.0))
