"""What looks wrong in a flight, and periods of samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from solar.types import BoolArray, FloatArray

Kind = Literal[
    "mppt_not_tracking",
    "power_loss",
    "modules_missing",
    "cloud",
    "shading",
    "battery_full",
    "frozen_channel",
    "missing_data",
]
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
    """Something that looks wrong in the flight; ``lost_wh`` is zero where that means nothing."""

    kind: Kind
    start_s: float
    end_s: float
    severity: Severity
    evidence: str
    affected_s: float
    lost_wh: float


def severity_of(share: float, minor: float, factor: float = 5.0) -> Severity:
    """Severity of a share: minor below ``minor``, major from ``factor`` times that on."""
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
