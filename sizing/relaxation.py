"""What suffices of one parameter, all else unchanged."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

Direction = Literal["at least", "at most"]


@dataclass(frozen=True)
class Relaxation:
    """A parameter, and the value from which on the mission is feasible, all else unchanged.

    ``parameter``: key of the aircraft's or, behind ``mission.``, of the mission's file, or the
    whole load, ``load_w``. ``unit``: of the values. ``direction``: ``at least`` or ``at most``.
    ``value``: value that suffices, rounded to three digits away from the edge. ``excess_time_h``:
    worst excess time that the simulator finds there.
    """

    parameter: str
    unit: str
    present: float
    direction: Direction
    value: float
    excess_time_h: float

    @property
    def text(self) -> str:
        """Relaxation in words, for instance ``battery.specific_energy_wh_per_kg >= 287 Wh/kg``."""
        sign = ">=" if self.direction == "at least" else "<="
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.parameter} {sign} {self.value:g}{unit} (now {self.present:g})"

    @property
    def relative_change(self) -> float:
        """Size of the change relative to the present value, to compare relaxations."""
        return abs(self.value - self.present) / max(abs(self.present), 1e-12)


def rounded(value: float, direction: Direction) -> float:
    """Value with three digits, on the safe side."""
    if value <= 0.0:
        return 0.0
    digits = 10.0 ** (math.floor(math.log10(value)) - 2)
    steps = value / digits
    return float(
        f"{(math.ceil(steps) if direction == 'at least' else math.floor(steps)) * digits:.6g}"
    )
