"""The verdict of a report in one sentence, and the numbers that it rests on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sizing.results.records import hours
from sizing.results.tables import UNLIMITED
from studies.report.blocks import Fact
from studies.report.subject import Subject

__all__ = ["Verdict", "key_facts", "verdict"]


@dataclass(frozen=True)
class Verdict:
    """A sentence, and whether what it says is ``good``, on the ``edge`` or ``bad``."""

    state: str
    sentence: str

    @property
    def word(self) -> str:
        """State in a word, for those who see no colour."""
        return {"good": "Holds", "edge": "On the edge", "bad": "Fails"}[self.state]


def verdict(subject: Subject) -> Verdict:
    """Whether the flight is perpetual, by how much, where it is weakest, and how sure that is."""
    if subject.verification is not None:
        return _of_verification(subject)
    analysis, mission = subject.analysis, subject.mission
    lows, highs = (float(np.min(p.cycle.excess_time_h)) for p in (analysis.low, analysis.high))
    required, excess = mission.required_excess_time_h, analysis.excess_time_h
    several = len(analysis.performance.cycle.status) > 1
    where = analysis.performance.day.scenarios.label(analysis.worst)
    weakest = f"in its weakest scenario, {where}," if several else f"at {where}"
    who = f"{subject.aircraft.name} on {mission.name}"
    error = f"one RMS error of the solar model ({100.0 * subject.solar.rms_relative:.0f} %)"
    fails = f"{who} does not fly perpetually: {weakest}"
    if not analysis.is_perpetual:
        flight = analysis.endurances[analysis.worst]
        longest = (
            "" if flight is None else f" it stays up for {hours(float(flight.endurance_h))} at most"
        )
        told = f"{fails}{longest}, {hours(max(-float(excess), 0.0))} of every day without power"
        if highs > 0.0:
            return Verdict("edge", f"{told}; with {error} more sun it would fly perpetually.")
        return Verdict("bad", f"{told}; {error} more sun would not change that.")
    if np.isinf(excess):
        return Verdict("good", f"{who} flies perpetually: {weakest} the sun always carries it.")
    told = f"{who} flies perpetually: {weakest} {hours(excess)} of excess time remain"
    if excess < required:
        return Verdict("bad", f"{told}, less than the required {required:g} h.")
    if required > 0.0:
        told += f", {hours(excess - required)} more than required"
    if lows <= 0.0:
        return Verdict("edge", f"{told}, but {error} less sun ends perpetual flight.")
    if lows < required:
        return Verdict("edge", f"{told}, but {error} less sun leaves {hours(lows)}, too little.")
    left = UNLIMITED if np.isinf(lows) else hours(lows)
    return Verdict("good", f"{told}, and with {error} less sun {left}.")


def _of_verification(subject: Subject) -> Verdict:
    """Which model comes closest to the flight, and whether the log looks sound."""
    found = subject.verification
    assert found is not None
    known = [
        (abs(errors.average_w), model, errors)
        for section in found.days[:1]
        for model, errors in section.errors.items()
    ]
    count = len(found.anomalies)
    looks = "no anomaly" if count == 0 else f"{count} anomal{'y' if count == 1 else 'ies'}"
    if not known:
        return Verdict("edge", f"{found.log.source}: no sample to compare with, {looks}.")
    _, model, errors = min(known)
    average, rms = (errors.relative(e) for e in (errors.average_w, errors.rms_w))
    told = "" if average is None else f" by {100.0 * average:+.1f} % on average"
    told += "" if rms is None else f", RMS {100.0 * rms:.1f} %"
    return Verdict(
        "good" if count == 0 else "edge",
        f"{model} comes closest to the flight of {found.aircraft}: it errs{told} on "
        f"{found.days[0].label}; {looks} in the log.",
    )


def key_facts(subject: Subject) -> Iterator[Fact]:
    """Key numbers, the most important first."""
    if subject.verification is not None:
        yield from _facts_of_verification(subject)
        return
    record, aircraft = subject.record, subject.aircraft
    excess, margin = record["excess_time_h"], record["charge_margin_h"]
    required = subject.mission.required_excess_time_h
    yield _hours("excess time", excess, f"required: {required:g} h" if required else "")
    yield _hours("charge margin", margin, "first to last full charge")
    charge = 100.0 * record["minimum_state_of_charge"]
    yield Fact("minimum state of charge", f"{charge:.1f}", "%", "in the morning")
    span, ratio = aircraft.airframe.wingspan_m, aircraft.airframe.aspect_ratio
    yield Fact("wingspan", f"{span:.2f}", "m", f"aspect ratio {ratio:.1f}")
    yield Fact("total mass", f"{record['total_mass_kg']:.2f}", "kg",
               f"battery {aircraft.battery.mass_kg:.2f} kg")  # fmt: skip
    yield Fact("battery", f"{record['battery_energy_wh']:.0f}", "Wh",
               f"{aircraft.battery.specific_energy_wh_per_kg:g} Wh/kg")  # fmt: skip
    coverage = aircraft.modules.area_m2 * ratio / span**2
    yield Fact("modules", f"{aircraft.modules.area_m2:.3g}", "m²",
               f"{100.0 * coverage:.0f} % of the wing")  # fmt: skip
    yield Fact("load", f"{record['power_out_w']:.1f}", "W",
               f"sun: {record['solar_energy_wh']:.0f} Wh a day")  # fmt: skip


def _hours(label: str, value: float | None, note: str) -> Fact:
    return Fact(label, UNLIMITED if value is None else f"{value:.2f}", "" if value is None else "h",
                note)  # fmt: skip


def _facts_of_verification(subject: Subject) -> Iterator[Fact]:
    found = subject.verification
    assert found is not None
    log = found.log
    yield Fact("samples", f"{len(found.samples.time_s)}", "", f"of {len(log)} with the sun up")
    yield Fact("flight", f"{(log.time_s[-1] - log.time_s[0]) / 3600.0:.1f}", "h",
               f"every {log.step_s:g} s")  # fmt: skip
    for section in found.days[:1]:
        for model, errors in section.errors.items():
            average, rms = (errors.relative(e) for e in (errors.average_w, errors.rms_w))
            if average is not None and rms is not None:
                yield Fact(f"error of {model}", f"{100.0 * average:+.1f}", "%",
                           f"RMS {100.0 * rms:.1f} %")  # fmt: skip
    yield Fact("anomalies", f"{len(found.anomalies)}")
