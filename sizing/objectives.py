"""What a sizing may be asked for."""

from __future__ import annotations

from enum import StrEnum


class Objective(StrEnum):
    """What the optimiser is asked for."""

    max_excess_time = "max_excess_time"
    min_wingspan = "min_wingspan"
    min_mass = "min_mass"
