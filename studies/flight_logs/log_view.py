"""What looks wrong in a flight, and periods of samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

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


def severity_of(share: float) -> Severity:
    """Severity of a share: minor below one per cent, major from five on."""
    if share < 0.01:
        return "minor"
    return "moderate" if share < 0.05 else "major"


def clusters(flagged: BoolArray, time_s: FloatArray) -> list[slice]:
    """Stretches of samples from the first to the last of those that are flagged and close."""
    places = np.flatnonzero(flagged)
    cuts = np.flatnonzero(np.diff(time_s[places]) > MERGE_S) + 1
    return [slice(int(one[0]), int(one[-1]) + 1) for one in np.split(places, cuts) if len(one)]
