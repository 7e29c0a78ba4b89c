"""What looks wrong in a flight, by periods: losses, a full battery, missing data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from missions.logs.table import GAP_STEPS, FlightLog, Gap
from sizing.aircraft import Aircraft
from solar.sun import sun_position
from solar.types import BoolArray, FloatArray
from studies.flight_logs.causes.diagnosis import Diagnosis, Finding
from studies.flight_logs.errors import moving_average
from studies.flight_logs.log_view import (
    BRIGHT,
    LOW_LIGHT_W_PER_M2,
    MERGE_S,
    SMOOTH_S,
    Anomaly,
    Kind,
    clusters,
    severity_of,
)
from studies.flight_logs.samples import Samples
from studies.flight_logs.verdict import words_of

# Share of the expected power that is left where a battery limits it, with and without attitude, and
# from which it is whole;
# docs/verify.md gives the reason of each.
LIMITED, LIMITED_CAM, UNLIMITED = 0.90, 0.75, 0.97
LIMITED_LEAST_S = 120.0
_KINDS: dict[str, Kind] = {
    "modules": "modules_missing",
    "mppt": "mppt_not_tracking",
    "mppt at low light": "mppt_not_tracking",
    "power loss": "power_loss",
    "cloud": "cloud",
    "shading": "shading",
}


@dataclass(frozen=True)
class Anomalies:
    """Finds what looks wrong in a log; ``earlier_s`` was taken off its clock [s]."""

    log: FlightLog
    samples: Samples
    diagnosis: Diagnosis
    aircraft: Aircraft
    earlier_s: float

    def every(self) -> list[Anomaly]:
        """All that looks wrong, in the order of time."""
        found = [*self._missing(), *self._stuck()]
        found += [self._full(part) for part in self._full_periods()]
        found += [self._loss(f) for f in self.diagnosis.findings if f.best.name in _KINDS]
        return sorted(found, key=lambda one: (one.start_s, one.kind))

    def excluded(self) -> BoolArray:
        """Samples with limited charging, which say nothing of the models."""
        mask = np.zeros(len(self.samples.time_s), bool)
        for part in self._full_periods():
            mask |= part
        for finding in self.diagnosis.findings:
            if finding.normal:
                mask |= self._inside(finding)
        return mask

    def _smooth(self, values: FloatArray) -> FloatArray:
        return moving_average(values, self.samples.run, self.samples.time_s, SMOOTH_S)

    @property
    def _expected_w(self) -> FloatArray:
        return self.diagnosis.expected_w[self.samples.index]

    def _full_periods(self) -> Iterator[BoolArray]:
        """Samples of each period in which the battery limits the power."""
        modules = self.aircraft.modules
        rated = modules.full_load_w_per_m2 * modules.area_m2
        detail, counts = self.samples.detail, np.ones(len(self.samples.time_s))
        if detail is not None:  # a limit never acts on little light, where MPPTs may fail
            counts = np.where(detail.irradiance_w_per_m2 >= LOW_LIGHT_W_PER_M2, 1.0, 0.0)
        powers = (self._expected_w, self.samples.measured_w)
        share = np.maximum(self._smooth(counts), 1e-9)
        expected, measured = (self._smooth(counts * power) / share for power in powers)
        may_be = self.diagnosis.limited[self.samples.index] & (expected >= BRIGHT * rated)
        left = LIMITED if detail is not None else LIMITED_CAM
        flagged = may_be & (measured < left * expected)
        not_whole = may_be & (measured < UNLIMITED * expected)
        time_s = self.samples.time_s
        for period in clusters(flagged, time_s):
            if flagged[period].sum() * self.log.step_s < LIMITED_LEAST_S:
                continue
            # To where the power is whole, and what the average hides.
            whole_s = time_s[~not_whole]
            start = whole_s[whole_s < time_s[period.start]].max(initial=-np.inf)
            end = whole_s[whole_s > time_s[period.stop - 1]].min(initial=np.inf)
            yield (time_s >= start - SMOOTH_S) & (time_s <= end + SMOOTH_S)

    def _full(self, inside: BoolArray) -> Anomaly:
        charge = self.log.state_of_charge
        why = "power follows the load"
        if charge is not None:
            mean = float(np.nanmean(charge[self.samples.index][inside]))
            why = f"state of charge {100 * mean:.0f} % on average"
        expected = np.maximum(self._smooth(self._expected_w), 1.0)
        ratio = self._smooth(self.samples.measured_w) / expected
        text = (
            f"power down to {100 * ratio[inside].min():.0f} % of the model; the battery is full "
            f"({why}), which is normal; not counted in the errors"
        )
        return self._anomaly("battery_full", inside, text)

    def _anomaly(self, kind: Kind, inside: BoolArray, text: str) -> Anomaly:
        """Something that looks wrong in some samples; a full battery is normal."""
        time_s, step_s = self.samples.time_s[inside], self.log.step_s
        missing_w = (self._expected_w - self.samples.measured_w)[inside]
        lost_wh = max(float(missing_w.sum()) * step_s / 3600.0, 0.0)
        whole_wh = float(self._expected_w.sum()) * step_s / 3600.0
        severity = severity_of(lost_wh / max(whole_wh, 1e-9))
        severity = "normal" if kind == "battery_full" else severity
        start_s, end_s = float(time_s[0]), float(time_s[-1])
        affected_s = float(inside.sum() * step_s)
        return Anomaly(kind, start_s, end_s, severity, text, affected_s, lost_wh)

    def _inside(self, finding: Finding) -> BoolArray:
        """Samples that a loss acts on."""
        losses = finding.best.fit.hypothesis.losses
        loss, time_s = losses[-1], self.samples.time_s
        acts = (time_s >= loss.start_s - self.earlier_s) & (time_s <= loss.end_s - self.earlier_s)
        detail = self.samples.detail
        if detail is not None and loss.form == "low_light":
            acts &= loss.acts(time_s + self.earlier_s, detail.irradiance_w_per_m2)
        if detail is not None and loss.form == "shadow" and detail.shaded_m2 is not None:
            acts &= detail.shaded_m2 > 0.0
        return acts

    def _loss(self, finding: Finding) -> Anomaly:
        """A loss that was found, as an anomaly over its period."""
        inside = self._inside(finding)
        if not inside.any():
            inside[:1] = True
        text = words_of(finding.best, self.aircraft)
        if finding.normal:
            text = f"battery nearly full ({finding.battery}), which is normal; or {text}"
            return self._anomaly("battery_full", inside, text)
        if finding.battery:
            text = f"{text}; or the battery is nearly full ({finding.battery})"
        if volts := self._volts(inside):
            text = f"{text}; {volts}"
        return self._anomaly(_KINDS[finding.best.name], inside, text)

    def _volts(self, inside: BoolArray) -> str:
        """What the MPPTs' voltage did meanwhile."""
        if self.log.mppt_voltage_v is None:
            return ""
        volts = self.log.mppt_voltage_v[self.samples.index]
        if not (np.isfinite(volts[inside]).any() and np.isfinite(volts[~inside]).any()):
            return ""
        usual, then = np.nanmedian(volts[~inside]), np.nanmedian(volts[inside])
        return f"MPPT voltage {then:.1f} V, {usual:.1f} V else"

    def _stuck(self) -> Iterator[Anomaly]:
        """Channels that repeated one value, which has been left out."""
        whole_s = len(self.log) * self.log.step_s
        for one in self.log.left_out:
            if one.kind in ("frozen", "saturated"):
                lasted_s = sum(end - start for start, end in one.periods)
                severity = severity_of(lasted_s / (whole_s + lasted_s))
                start_s, end_s = one.periods[0][0], one.periods[-1][1]
                yield Anomaly("frozen_channel", start_s, end_s, severity, one.told(), lasted_s, 0.0)

    def _missing(self) -> Iterator[Anomaly]:
        """Stretches without samples in sunlight that were not left out; close ones are one."""
        log, known_s = self.log, len(self.samples.time_s) * self.log.step_s
        spans = [span for one in log.left_out for span in one.periods]
        starts, ends = (np.array([span[i] for span in spans]) for i in (0, 1))
        step_s = GAP_STEPS * log.step_s
        groups: list[list[tuple[Gap, float]]] = []
        for gap in log.gaps:
            told = np.any((starts <= gap.start_s + step_s) & (ends >= gap.end_s - step_s))
            if told or not (sunlit := _sunlit_s(log, gap)) > 0.0:
                continue
            if not groups or gap.start_s - groups[-1][-1][0].end_s > MERGE_S:
                groups.append([])
            groups[-1].append((gap, sunlit))
        for group in groups:
            total = sum(sunlit for _, sunlit in group)
            count = "1 gap" if len(group) == 1 else f"{len(group)} gaps"
            text = f"{count}, {total:.0f} s without samples while the sun is up"
            severity = severity_of(total / (known_s + total))
            start_s, end_s = group[0][0].start_s, group[-1][0].end_s
            yield Anomaly("missing_data", start_s, end_s, severity, text, total, 0.0)


def _sunlit_s(log: FlightLog, gap: Gap) -> float:
    """Part of a gap with the sun above the horizon, seen from where it begins [s]."""
    at = int(np.searchsorted(log.time_s, gap.start_s))
    steps = np.linspace(gap.start_s, gap.end_s, 201)
    sun = sun_position(steps, log.latitude_deg[at], log.longitude_deg[at])
    return float(np.mean(sun.elevation_rad > 0.0) * gap.duration_s)
