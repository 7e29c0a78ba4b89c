"""What the search for anomalies looks at: the flight, a levelled model, and what was found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from missions.logs.table import FlightLog
from sizing.aircraft import Aircraft
from solar.types import BoolArray, FloatArray
from studies.flight_logs.errors import moving_average
from studies.flight_logs.samples import Samples

Kind = Literal["mppt_not_tracking", "battery_full", "shading", "side_bias", "missing_data"]
Severity = Literal["normal", "minor", "moderate", "major"]

# Load of the modules, as a share of rated power, from which power is judged; docs/verify.md gives
# the reason of this and all other thresholds.
BRIGHT = 0.25
# Irradiance on the modules below which MPPTs are known to fail.
LOW_LIGHT_W_PER_M2 = 250.0
# Periods of one anomaly that are closer than this are one finding.
MERGE_S = 600.0
SMOOTH_S = 60.0


@dataclass(frozen=True)
class Anomaly:
    """Something that looks wrong in the flight.

    ``lost_wh`` is the energy between model and measurement in it, zero if that means nothing.
    """

    kind: Kind
    start_s: float
    end_s: float
    severity: Severity
    evidence: str
    affected_s: float
    lost_wh: float


@dataclass(frozen=True)
class LogView:
    """Samples and the best model on them, levelled to the log's own good samples."""

    log: FlightLog
    samples: Samples
    reference_w: FloatArray
    rated_w: float
    step_s: float

    @classmethod
    def of(cls, log: FlightLog, samples: Samples, aircraft: Aircraft) -> LogView:
        """Level the model: a constant bias of it is an error to report, not an anomaly.

        ``samples``: its samples with the sun up, and all models on them.
        """
        modules = aircraft.modules
        model = samples.modelled_w.get("FM", samples.modelled_w["CAM"])
        rated = modules.full_load_w_per_m2 * modules.area_m2
        view = cls(log, samples, model, rated, log.step_s)
        measured, smooth = view.smooth(samples.measured_w, SMOOTH_S), view.smooth(model, SMOOTH_S)
        bright = smooth >= BRIGHT * rated
        level = 1.0
        if bright.any():
            # The upper quartile, since limited power lowers up to three quarters of the samples.
            level = float(np.clip(np.quantile(measured[bright] / smooth[bright], 0.75), 0.7, 1.3))
        return cls(log, samples, level * model, rated, log.step_s)

    def smooth(self, values: FloatArray, seconds: float) -> FloatArray:
        """Moving average over so many seconds to either side."""
        return moving_average(values, self.samples.run, self.samples.time_s, seconds)

    def logged(self, values: FloatArray | None) -> FloatArray | None:
        """Values of the log at the sunlit samples."""
        return None if values is None else values[self.samples.index]

    def lost_wh(self, mask: NDArray[Any]) -> float:
        """Energy between the model and the measurement in some samples [Wh]."""
        missing = (self.reference_w - self.samples.measured_w)[mask]
        return float(missing.sum() * self.step_s / 3600.0)

    def anomaly(
        self,
        kind: Kind,
        period: Period,
        severity: Severity,
        evidence: str,
        affected_s: float,
        lost_wh: float,
    ) -> Anomaly:
        """Anomaly over a period of samples.

        ``affected_s``, ``lost_wh``: time of the affected samples [s], and the energy missing in
        them [Wh].
        """
        start, end = (float(self.samples.time_s[place]) for place in period)
        return Anomaly(kind, start, end, severity, evidence, affected_s, lost_wh)

    def severity_of_loss(self, lost_wh: float) -> Severity:
        """By the share of the energy of the whole log."""
        whole_wh = float(self.reference_w.sum()) * self.step_s / 3600.0
        return severity_of(lost_wh / max(whole_wh, 1e-9), 0.01)


def severity_of(share: float, minor: float, factor: float = 5.0) -> Severity:
    """Severity by a share.

    ``share``, ``minor``: share that is judged, and that below which it is minor [-]. ``factor``:
    from so many times the latter on it is major.
    """
    if share < minor:
        return "minor"
    return "moderate" if share < factor * minor else "major"


class Period(NamedTuple):
    """Samples from the first to the last of a cluster, the latter included."""

    first: int
    last: int

    def slice(self) -> slice:
        """Period as an index of the samples."""
        return slice(self.first, self.last + 1)


def clusters(flagged: BoolArray, time_s: FloatArray, merge_s: float) -> list[Period]:
    """Join flagged samples."""
    places = np.flatnonzero(flagged)
    if not len(places):
        return []
    cuts = np.flatnonzero(np.diff(time_s[places]) > merge_s)
    firsts = places[np.concatenate(([0], cuts + 1))]
    lasts = places[np.concatenate((cuts, [len(places) - 1]))]
    return [Period(int(a), int(b)) for a, b in zip(firsts, lasts, strict=True)]


def mask_of(count: int, period: Period) -> BoolArray:
    """Mark a period among so many samples."""
    mask = np.zeros(count, bool)
    mask[period.slice()] = True
    return mask
