"""Which cause wins, which fit as well, and what may be corrected."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from missions.logs.table import FlightLog
from sizing.aircraft import Aircraft
from sizing.energy.battery import NoChargeLimit, charge_rate_per_h
from solar.types import BoolArray, FloatArray, IntArray
from studies.flight_logs.causes.data import Data
from studies.flight_logs.causes.fit import UNKNOWN_NOISE, Fit, Hypothesis, Noise, fitted
from studies.flight_logs.causes.fit import modelled as modelled_power
from studies.flight_logs.causes.forward import Forward, LogError
from studies.flight_logs.causes.hypotheses import LOSSES, ROWS, Candidate, candidates, sizes_of
from studies.flight_logs.causes.noise import noise_of
from studies.flight_logs.errors import moving_average
from studies.flight_logs.log_view import SMOOTH_S
from studies.flight_logs.trackers import Trackers

# Differences of the criterion: Kass, R. E., Raftery, A. E. (1995), Journal of the American
# Statistical Association 90(430), 773-795. Strong evidence for a cause, very strong evidence
# against those that fit worse, and what is worth no more than a bare mention.
CLEAR, ALIKE, BARE = 6.0, 10.0, 2.0
# Extinction per air mass that no clear day with a Linke turbidity of 2 to 5 has.
UNUSUAL_HAZE = 0.2
# Clouds: nothing is known where the power scatters by more than this share of its peak.
MOST_SCATTER = 0.1
_SAMPLES, _LEAST_SAMPLES = 1200, 60
_DARK = 0.02  # share of the peak below which there is nothing to compare
_ROUNDS = 3
# Steps to either side on which the evidence of an offset is taken, until it is this much worse.
_MOST_STEPS, UNLIKELY = 8, 9.0
_MOSTLY = 0.8
_SECONDS_PER_DEG, _DAY_S, _ALIKE_S = 240.0, 86400.0, 120.0
_UNITS = {1.0: "W", 1e-3: "kW", 1e3: "mW"}
# State of charge from which a battery may take less; share of what load and battery take from which
# power may be limited by them: batteries of one type differ, and so does the logged charge.
NEAR_FULL, OF_LIMIT = 0.85, 0.8
# Load and power that are alike, as a share of rated power, where no charge is logged.
_AS_LOAD = 0.05
# Offsets of time zones from universal time that exist [h].
_ZONES_H = (*range(-12, 15), -9.5, -3.5, 3.5, 4.5, 5.5, 5.75, 6.5, 8.75, 9.5, 10.5, 12.75)


@dataclass(frozen=True)
class Finding:
    """A cause that clearly explains the log better than nothing, and those that fit alike.

    ``battery``: why a nearly full battery might be behind missing power; empty if it cannot.
    ``alike``: whether all give the same sun: a clock and a longitude of wrong sign may.
    """

    best: Candidate
    others: tuple[Candidate, ...] = ()
    battery: str = ""
    alike: bool = False

    @property
    def normal(self) -> bool:
        """Whether the battery is the likeliest cause: a full one is no fault."""
        return self.battery.startswith("charge")


@dataclass(frozen=True)
class Diagnosis:
    """What the power says of log, modules and sky.

    ``factor``: logged power over that in watts. ``findings``: causes in the order of what they
    explain. ``clock``, ``heading``: how far they are off, with standard deviations [s, rad]; None
    if the power does not tell. ``fit``: all that is known. ``expected_w``: power of all samples if
    nothing were lost; ``limited``: those in which charging may be limited.
    """

    factor: float
    limited: BoolArray
    expected_w: FloatArray
    findings: tuple[Finding, ...] = ()
    clock: tuple[float, float] | None = None
    heading: tuple[float, float] | None = None
    fit: Fit | None = None
    notes: tuple[str, ...] = ()

    @property
    def unit(self) -> str:
        """Unit of the power."""
        return _UNITS[abs(self.factor)]

    @property
    def sky(self) -> tuple[float, float] | None:
        """Extinction per air mass beyond the model's, if clear days do not have it, and sigma."""
        if self.fit is None or self.named("haze"):
            return None
        value, sigma = self.fit.values["haze"], self.fit.sigmas["haze"]
        return (value, sigma) if abs(value) > max(UNUSUAL_HAZE, 3.0 * sigma) else None

    def named(self, free: str) -> bool:
        """Whether an error of the log is among what may be wrong."""
        every = [c for one in self.findings for c in (one.best, *one.others)]
        return any(free in one.row.free for one in every)

    @property
    def offsets(self) -> dict[str, tuple[float, float]]:
        """Clock and heading as far as they are known."""
        both = {"clock_s": self.clock, "heading": self.heading}
        return {name: offset for name, offset in both.items() if offset is not None}

    def with_offset(self, finding: Finding) -> Finding:
        """A finding with the clock or heading that all findings together leave."""
        return replace(finding, best=replace(finding.best, offsets=self.offsets))

    @property
    def certain(self) -> bool:
        """Whether errors of the log won alone, well known, and the level does not jump."""
        return not any(
            f.best.jumps or not _well_known(f.best) or (f.others and not f.alike)
            for f in self.findings
        )

    @property
    def correction(self) -> LogError:
        """What is wrong with the log, as far as that is certain."""
        error = LogError(factor=self.factor)
        if self.fit is None or not self.certain:
            return error
        for one in self.findings:
            row = one.best.row
            for name in row.free:
                if hasattr(error, name):
                    value = self.offsets.get(name, (getattr(self.fit.error, name),))[0]
                    error = error.plus({name: value - getattr(error, name)})
            error = replace(error, signs=error.signs | set(row.signs))
        sigma_s = 0.0 if self.clock is None else self.clock[1]
        return replace(error, clock_s=snapped(error.clock_s, sigma_s))


def _well_known(found: Candidate) -> bool:
    """Whether a clock or heading is known to what matters, or is that of a zone."""
    known = [one for one in found.of_each() if set(one.row.free) & {*one.offsets}]
    return not known or (found.counts() and all(map(_is_precise, known)))


def _is_precise(offset: Candidate) -> bool:
    """Whether a clock or heading alone is known to what matters, or is that of a zone."""
    zone = offset.row.name == "clock" and snapped(offset.size, offset.sigma) != offset.size
    return zone or offset.sigma <= offset.row.least


def snapped(ahead_s: float, sigma_s: float) -> float:
    """A clock's error, or that of the time zone that it is nearer to than it is known."""
    zone = 3600.0 * min(_ZONES_H, key=lambda hours: abs(3600.0 * hours - ahead_s))
    return zone if abs(ahead_s - zone) <= sigma_s else ahead_s


def diagnose(
    forward: Forward, trackers: Trackers | None = None, *, search: bool = True
) -> Diagnosis:
    """Let all causes compete, or without ``search`` fit the level of the model alone."""
    log = forward.log
    modelled = np.concatenate([part.parts(LogError()).power for part in forward.chunks()])
    factor = _factor(log.solar_power_w, modelled) if search else 1.0
    measured = log.solar_power_w / factor
    limited = may_be_limited(replace(log, solar_power_w=measured), forward.aircraft)
    known = Diagnosis(factor, limited, modelled)
    peak = float(np.quantile(measured, 0.98))
    sunlit = (measured > _DARK * peak) | (modelled > _DARK * modelled.max(initial=0.0))
    usable = np.flatnonzero(sunlit & ~limited)
    if len(usable) < _LEAST_SAMPLES or not peak > 0.0:
        note = "clock, angles and modules are not checked: too little power"
        return replace(known, notes=(note,) if search else ())
    if trackers is None:
        index = _some(usable, _SAMPLES)
        data = Data.of(forward.of(index), measured[index])
    else:
        index = _some(usable, _SAMPLES // (1 + len(trackers.names) // 3))
        data = Data.of(forward.of(index), trackers.power_w(log)[index] / factor, trackers.members)
    findings, fit, noise = _findings(data) if search else ((), fitted(data, Hypothesis()), None)
    if noise is not None and noise.sigma > MOST_SCATTER * data.peak:
        note = "clock, angles and modules are not checked: the power scatters too much (clouds?)"
        return replace(known, notes=(note,))
    expected = [modelled_power(p.parts(fit.error), fit.values) for p in forward.chunks()]
    known = replace(
        known,
        expected_w=np.concatenate(expected),
        findings=findings,
        fit=fit,
    )
    if noise is None:
        return known

    known = replace(
        known,
        clock=_offset(data, fit, "clock_s", noise),
        heading=_offset(data, fit, "heading", noise),
    )
    return replace(known, findings=tuple(map(known.with_offset, findings)))


def may_be_limited(log: FlightLog, aircraft: Aircraft) -> BoolArray:
    """Samples in which the battery may hold power back, by what is logged; no model decides."""
    modules, battery = aircraft.modules, aircraft.battery
    rated = modules.full_load_w_per_m2 * modules.area_m2
    run = log.segment()

    def smooth(values: FloatArray) -> FloatArray:
        return moving_average(values, run, log.time_s, SMOOTH_S)

    power = smooth(log.solar_power_w)
    load = None if log.load_w is None else smooth(np.nan_to_num(log.load_w))
    if log.state_of_charge is None:
        if load is None:
            return np.zeros(len(log), bool)
        return np.asarray((np.abs(power - load) < _AS_LOAD * rated) & (power > 0.0))
    # Where the sun is low, power may be held in a part of each circle while its mean is below.
    power = np.maximum(power, log.solar_power_w)
    charge = np.clip(np.nan_to_num(log.state_of_charge, nan=0.0), 0.0, 1.0)
    if load is None:
        return charge >= NEAR_FULL
    if isinstance(battery.charge_limit, NoChargeLimit):
        return (charge >= NEAR_FULL) & (power > OF_LIMIT * load)
    taken = charge_rate_per_h(battery.charge_limit, charge) * battery.battery_energy_wh
    taken = taken / float(battery.mean_charge_efficiency)
    taken = np.where(taken < load, 0.0, taken)  # as good as full
    return np.asarray((charge >= NEAR_FULL) & (power > OF_LIMIT * (taken + load)))


def _battery(log: FlightLog, finding: Finding) -> str:
    """Why a nearly full battery might be behind a loss: it takes less than expected."""
    if finding.best.name not in ("mppt", "modules", "cloud") or not finding.best.jumps:
        return ""
    loss = finding.best.fit.hypothesis.losses[-1]
    inside = (log.time_s >= loss.start_s) & (log.time_s <= loss.end_s)
    if log.state_of_charge is None:
        return "no state of charge is logged"
    high = float(np.mean(log.state_of_charge[inside] >= NEAR_FULL))
    return f"charge above {100 * NEAR_FULL:.0f} % all the time" if high > _MOSTLY else ""


def _findings(data: Data) -> tuple[tuple[Finding, ...], Fit, Noise]:
    """Causes one after the other, as long as one clearly explains more."""
    findings: list[Finding] = []
    known, base = Hypothesis(), fitted(data, Hypothesis())
    for _ in range(_ROUNDS):
        found, base, noise = _round(data, known, base)
        if found is None:
            break
        findings.append(replace(found, battery=_battery(data.forward.log, found)))
        base = found.best.fit
        known = base.hypothesis._replace(start=base.error)
        # What else is wrong does not depend on which loss it is, but on all other causes.
        if not all(one.row.form in LOSSES for one in found.others):
            break
    findings, base = _weighed_again(data, findings, base, noise)
    return tuple(findings), base, noise


def _weighed_again(
    data: Data, findings: list[Finding], base: Fit, noise: Noise
) -> tuple[list[Finding], Fit]:
    """Findings and fit when losses that fitted alike are compared with all else that is known.

    Errors of the log that were found after a loss make another of those losses the likeliest.
    """
    lost = [number for number, one in enumerate(findings) if one.best.row.form in LOSSES]
    if not lost or lost[-1] == len(findings) - 1 or not findings[lost[-1]].others:
        return findings, base
    found, known = findings[lost[-1]], base.hypothesis
    of_best = found.best.fit.hypothesis
    every = []
    for one in (found.best, *found.others):
        mine = one.fit.hypothesis
        hypothesis = known._replace(
            start=base.error,
            losses=(*known.losses[:-1], mine.losses[-1]),
            sizes=(*sizes_of(base)[:-1], one.size),
            parameters=known.parameters + mine.parameters - of_best.parameters,
            choices=known.choices + mine.choices - of_best.choices,
        )
        every.append(replace(one, fit=fitted(data, hypothesis, noise, base)))
    every = _alike(every, noise)
    found = Finding(every[0], tuple(every[1:]))
    findings[lost[-1]] = replace(found, battery=_battery(data.forward.log, found))
    return findings, every[0].fit


def _alike(few: list[Candidate], noise: Noise) -> list[Candidate]:
    """The best and what fits about as well: in the order of the table where that says nothing."""
    least = min(one.fit.score(noise) for one in few)
    alike = [one for one in few if one.fit.score(noise) < least + ALIKE]
    order = [row.name for row in ROWS]
    alike.sort(key=lambda one: (max(one.fit.score(noise) - least, BARE), order.index(one.row.name)))
    return alike


def _round(data: Data, known: Hypothesis, base: Fit) -> tuple[Finding | None, Fit, Noise]:
    """The cause that explains most of what is left, if any clearly does."""
    every = list(candidates(data, known, base, UNKNOWN_NOISE))
    guess = Noise(min([base.scale, *(one.fit.scale for one in every)]))
    best = min([base, *(one.fit for one in every)], key=lambda fit: fit.score(guess))
    noise = noise_of(data, best)
    base = _again(data, base, noise)
    few = sorted(every, key=lambda one: one.fit.score(noise))[:6]
    few = [replace(one, fit=_again(data, one.fit, noise)) for one in few]
    # A cause that changes nothing must not win by a fit of sky and model that got further.
    known = base.hypothesis._replace(start=base.error, sizes=())
    others = (one.fit for one in few if one.fit.error == base.error)
    further = [fitted(data, known, noise, other) for other in others]
    base = min([base, *further], key=lambda fit: fit.score(noise))
    none = base.score(noise)
    few = [one for one in few if one.counts() and none - one.fit.score(noise) > CLEAR]
    if not few:
        return None, base, noise
    alike = _alike(few, noise)
    # Two errors are not blamed where one of them is enough.
    alike = [
        a for a in alike if not any(set(b.row.free) < set(a.row.free) for b in alike if b.row.free)
    ]
    return Finding(alike[0], tuple(alike[1:]), alike=_same_sun(data, alike)), base, noise


def _same_sun(data: Data, alike: list[Candidate]) -> bool:
    """Whether a clock and the sign of the longitude put the sun in one place, to two minutes."""
    if {one.name for one in alike} != {"clock", "sign of longitude"}:
        return False
    clock = next(one.size for one in alike if one.name == "clock")
    turned = 2.0 * float(np.mean(data.forward.log.longitude_deg)) * _SECONDS_PER_DEG
    apart = (np.array([clock - turned, clock + turned]) + 0.5 * _DAY_S) % _DAY_S - 0.5 * _DAY_S
    return bool(np.min(np.abs(apart)) < _ALIKE_S)


def _offset(data: Data, base: Fit, name: str, noise: Noise) -> tuple[float, float] | None:
    """Clock [s] or heading [rad] with its standard deviation, left free.

    By the evidence at fixed values of it (Tierney & Kadane 1986): haze and diffuse light make that
    far wider than the curvature at its peak where the sun rose by a few degrees only.
    """
    if name not in data.geometric:
        return None
    free = tuple(dict.fromkeys((*base.hypothesis.free, name)))
    known = base.hypothesis._replace(start=base.error, free=free, sizes=())
    fit = fitted(data, known, noise, base)
    peak, sigma = float(getattr(fit.error, name)) + fit.values[name], fit.sigmas[name]
    known = known._replace(free=tuple(n for n in free if n != name))
    scores: dict[float, float] = {}
    for direction in (1.0, -1.0):
        last = fit
        for step in range(_MOST_STEPS):
            value = peak + direction * step * sigma
            error = last.error.plus({name: value - getattr(last.error, name)})
            # All else is nearly as it was at the last one.
            last = replace(last, error=error, hypothesis=known)
            last = _again(data, last, noise)
            scores[value] = last.score(noise)
            if scores[value] > min(scores.values()) + UNLIKELY:
                break
    likely = np.exp(-0.5 * (np.array(list(scores.values())) - min(scores.values())))
    mean, square = (
        float(np.average(np.array(list(scores)) ** power, weights=likely)) for power in (1, 2)
    )
    return mean, max(float(np.sqrt(max(square - mean**2, 0.0))), sigma)


def _factor(measured: FloatArray, modelled: FloatArray) -> float:
    """Measured power over that in watts: a power of thousand, and a sign."""
    sign = -1.0 if measured.sum() < 0.0 else 1.0
    typical, usual = (float(np.quantile(np.abs(p), 0.9)) for p in (measured, modelled))
    typical /= max(usual, 1e-9)
    for factor in _UNITS:
        if 0.1 < typical / factor < 10.0:
            return sign * factor
    return sign


def _some(places: IntArray, most: int) -> IntArray:
    """At most so many places, spread evenly but not regularly: a stride could meet the orbits."""
    if len(places) <= most:
        return places
    edges = np.linspace(0, len(places), most + 1)
    within = edges[:-1] + np.random.default_rng(0).random(most) * np.diff(edges)
    return np.asarray(places[np.unique(within.astype(int))], int)


def _again(data: Data, fit: Fit, noise: Noise) -> Fit:
    """The same from where it ended, with another noise."""
    return fitted(data, fit.hypothesis._replace(start=fit.error, sizes=()), noise, fit)
