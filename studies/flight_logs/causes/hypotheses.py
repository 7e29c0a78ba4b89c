"""The table of causes that compete, each a small model of what it does to the power."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np

from solar.types import FloatArray
from studies.flight_logs.causes.data import Data
from studies.flight_logs.causes.fit import Fit, Hypothesis, Loss, Noise, fitted
from studies.flight_logs.causes.forward import LogError
from studies.flight_logs.causes.losses import Shape, best_losses, subsets

Family = Literal["time", "attitude", "level", "modules", "period"]

# Clocks are searched for to both sides [s]; beyond, the date would be another.
MOST_CLOCK_S = 14 * 3600.0
_SHIFT_S, _TURNS, _COARSE, _CANDIDATES, _AT_ONCE = 1800.0, 12, 250, 3, 24
_ALIKE = 1.1  # misfits of starts that are worth a fit
_ALL_LOST, _MOSTLY_LOST = 0.97, 0.8
_LEAST_SHADOW = 0.0025  # of the peak: smaller shadows drown in the noise
# At low light models are off by up to 9 % (Oettershagen's report): a fault is twice that.
_LOW_LIGHT = 0.18


class Row(NamedTuple):
    """A cause: what is free, which signs are wrong, which losses are searched for.

    ``least``: size below which nobody could do anything about it, in the unit of the first free
    error, or the share of the power that is lost.
    """

    name: str
    family: Family
    free: tuple[str, ...] = ()
    least: float = 0.0
    signs: tuple[str, ...] = ()
    form: Literal["", "modules", "share", "direct", "low_light", "shadow", "cap"] = ""


LOSSES = ("modules", "share", "direct", "low_light", "shadow")
_DEG = float(np.pi / 180.0)
ROWS = (
    Row("clock", "time", ("clock_s",), 120.0),
    Row("heading", "attitude", ("heading",), 3.0 * _DEG),
    Row("clock and heading", "time", ("clock_s", "heading"), 120.0),
    Row("roll", "attitude", ("roll",), 1.5 * _DEG),
    Row("pitch", "attitude", ("pitch",), 1.5 * _DEG),
    Row("sign of roll", "attitude", signs=("roll",)),
    Row("sign of pitch", "attitude", signs=("pitch",)),
    Row("sign of yaw", "attitude", signs=("yaw",)),
    Row("sign of longitude", "time", signs=("longitude",)),
    Row("gain", "level", ("level",), 0.1),
    Row("sky", "level", ("haze",), 0.2),
    Row("saturation", "level", form="cap", least=0.03),
    Row("modules", "modules", form="modules", least=0.05),
    Row("mppt", "period", form="share", least=0.05),
    Row("cloud", "period", form="direct", least=0.05),
    Row("mppt at low light", "period", form="low_light", least=_LOW_LIGHT),
    Row("shading", "period", form="shadow", least=0.2),
)


@dataclass(frozen=True)
class Candidate:
    """A row of the table and its best fit; ``offsets``: clock and heading with their deviations."""

    row: Row
    fit: Fit
    offsets: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def _offset(self) -> tuple[float, float] | None:
        """Mean and deviation of the first free error, if it is one of the offsets."""
        return self.offsets.get(self.row.free[0]) if self.row.free else None

    @property
    def _whole(self) -> bool:
        """Whether nothing is left of what is lost, which then has no size that is fitted."""
        return self.row.form == "modules" and self.fit.hypothesis.losses[-1].whole

    @property
    def size(self) -> float:
        """How large it is: of the first free error, or the share that is lost."""
        if self._offset is not None:
            return self._offset[0]
        if self.row.form == "cap":
            cap = self.fit.hypothesis.cap_w
            assert cap is not None
            return float(np.mean(self.fit.fitted >= cap))
        if self._whole:
            return 1.0
        if self.row.form:
            return self.fit.values[f"loss{len(self.fit.hypothesis.losses) - 1}"]
        if not self.row.free:
            return 1.0
        name = self.row.free[0]
        return float(getattr(self.fit.error, name, 0.0)) + self.fit.values[name]

    @property
    def sigma(self) -> float:
        """Standard deviation of the size."""
        if self._offset is not None:
            return self._offset[1]
        if self._whole or self.row.form == "cap" or not (self.row.free or self.row.form):
            return 0.0
        name = self.row.free[0] if self.row.free else f"loss{len(self.fit.hypothesis.losses) - 1}"
        return self.fit.sigmas[name]

    @property
    def name(self) -> str:
        """Name of the cause: an MPPT that gives nothing at all is a loss of power."""
        lost = self.row.name == "mppt" and self.size > _ALL_LOST
        return "power loss" if lost else self.row.name

    @property
    def jumps(self) -> bool:
        """Whether the level of the power jumps within the log."""
        if self.row.form not in LOSSES[:3]:
            return False
        return self.fit.hypothesis.parameters > 0

    def of_each(self) -> list[Candidate]:
        """The same for each of several free errors alone."""
        if len(self.row.free) < 2:
            return [self]
        rows = [row for row in ROWS if len(row.free) == 1 and row.free[0] in self.row.free]
        return [replace(self, row=row) for row in rows]

    def counts(self) -> bool:
        """Whether it is large enough to matter, and to be no chance."""
        return all(abs(one.size) >= max(one.row.least, 3.0 * one.sigma) for one in self.of_each())


def candidates(data: Data, known: Hypothesis, base: Fit, noise: Noise) -> Iterator[Candidate]:
    """The best fit of every row on top of what is known already."""
    used = {*known.free, *known.start.signs}
    for row in ROWS:
        if used & {*row.free, *row.signs} or not _applies(row, data):
            continue
        fits = [fitted(data, h, noise, base) for h in _hypotheses(row, data, known, base, noise)]
        fits = [f for f in fits if abs(f.error.clock_s) <= MOST_CLOCK_S]
        if fits:
            yield Candidate(row, min(fits, key=lambda fit: fit.score(noise_or(base, noise))))


def noise_or(base: Fit, noise: Noise) -> Noise:
    """The noise, or that of a fit."""
    return noise if noise.sigma else Noise(base.scale, noise.worth)


def _applies(row: Row, data: Data) -> bool:
    """Whether the power depends on what the row is about."""
    about = {*row.free, *row.signs} & {"heading", "roll", "pitch", "yaw"}
    if row.form == "modules" or about:
        return data.forward.knows_angles
    return True


def _hypotheses(
    row: Row, data: Data, known: Hypothesis, base: Fit, noise: Noise
) -> Iterator[Hypothesis]:
    """Hypotheses of one row that are fitted, to take the best of."""
    error = base.error
    if row.signs:
        yield known._replace(start=replace(error, signs=error.signs | set(row.signs)))
    elif row.form == "cap":
        cap = float(np.median(np.sort(data.measured)[-max(len(data.measured) // 50, 1) :]))
        yield known._replace(cap_w=cap, parameters=known.parameters + 1)
    elif row.form:
        yield from _with_losses(row, data, known, base, noise)
    else:
        free = (*known.free, *row.free)
        for start in _starts(row, data, error):
            yield known._replace(start=start, free=free)


def _with_losses(
    row: Row, data: Data, known: Hypothesis, base: Fit, noise: Noise
) -> Iterator[Hypothesis]:
    geometry = data.forward.geometry
    count = len(geometry.surfaces) if geometry is not None and data.forward.knows_angles else 1
    if row.form == "shadow":
        shadow = data.shadow_w(base.error)
        if shadow is not None and shadow.max() > _LEAST_SHADOW * data.peak:
            shaded = data.time_s[shadow > _LEAST_SHADOW * data.peak]
            loss = Loss("shadow", float(shaded[0]), float(shaded[-1]), (True,) * count, shadow)
            losses, sizes = (*known.losses, loss), (*sizes_of(base), 0.5)
            yield known._replace(start=base.error, losses=losses, sizes=sizes)
        return
    own = [tuple(map(bool, mine)) for mine in data.members] if data.trackers > 1 else []
    if row.form == "modules":
        groups = dict.fromkeys((*subsets(geometry), *own))
        shapes = [Shape("share", group, for_a_while=False) for group in groups]
    else:
        groups = {(True,) * count: None}
        if row.form == "share":  # and one MPPT
            groups |= dict.fromkeys(own)
        shapes = [
            Shape(row.form, group, for_a_while=True)  # type: ignore[arg-type]
            for group in groups
        ]
    noise = noise_or(base, noise)
    choices = 2.0 * float(np.log(len(shapes)))  # the best of several costs their logarithm
    found = sorted(
        best_losses(data, base, shapes, noise.sigma, noise.worth),
        key=lambda one: one.ends * np.log(noise.worth * len(data.time_s)) - one.gain,
    )
    for one in found[:_CANDIDATES]:
        if one.ends == 0 and row.form != "modules":
            continue  # missing all the time: that is a gain, or the sky
        every = [(one.loss, one.size)]
        if row.form == "modules" and one.size > _MOSTLY_LOST:
            every.append((replace(one.loss, whole=True), 1.0))
        for loss, size in every:
            yield known._replace(
                start=base.error,
                losses=(*known.losses, loss),
                sizes=(*sizes_of(base), size),
                parameters=known.parameters + one.ends,
                choices=known.choices + choices,
            )


def sizes_of(fit: Fit) -> tuple[float, ...]:
    """Sizes of the losses of a fit."""
    return tuple(fit.values[f"loss{i}"] for i in range(len(fit.hypothesis.losses)))


def _starts(row: Row, data: Data, error: LogError) -> Iterator[LogError]:
    """Where fits of clock and heading start: as they are, and at the best of a coarse grid."""
    yield error
    if "clock_s" not in row.free and row.free != ("heading",):
        return
    shifts = (
        np.arange(-MOST_CLOCK_S, MOST_CLOCK_S + 1.0, _SHIFT_S)
        if row.free[0] == "clock_s"
        else [0.0]
    )
    turns = 2.0 * np.pi * np.arange(_TURNS) / _TURNS if "heading" in row.free else [0.0]
    coarse = data.some(_COARSE)
    grid = np.array([(0.0, 0.0), *((s, t) for s in shifts for t in turns)])
    misfits = np.array(list(_misfits(coarse, error, grid)))
    for place in np.argsort(misfits[1:])[:_CANDIDATES] + 1:
        if misfits[place] < _ALIKE * misfits[0]:
            shift_s, turn = grid[place].tolist()
            turned = (error.heading + turn + np.pi) % (2.0 * np.pi) - np.pi
            yield replace(error, clock_s=error.clock_s + shift_s, heading=turned)


def _misfits(data: Data, error: LogError, grid: FloatArray) -> Iterator[float]:
    """Misfit at every shift and turn of a grid, some of them at once."""
    index = data.forward.index
    for some in np.array_split(grid, len(grid) // _AT_ONCE + 1):
        forward = data.forward.of(np.tile(index, len(some)))
        shift_s, turn = np.repeat(some, len(index), axis=0).T
        power = forward.parts(error.plus({"clock_s": shift_s, "heading": turn})).power
        for one in power.reshape(len(some), -1):
            yield _misfit(data.measured, one, data.peak)


def _misfit(measured: FloatArray, power: FloatArray, peak: float) -> float:
    """Mean of the differences at the best level, none counted for more than a tenth of the peak."""
    bright = power > 0.25 * max(float(power.max()), 1e-9)
    level = float(np.median(measured[bright] / power[bright])) if bright.any() else 1.0
    level = min(max(level, 0.5), 1.6)
    return float(np.minimum(np.abs(measured - level * power) / peak, 0.1).mean())
