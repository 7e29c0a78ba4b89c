"""What a sizing may be asked for."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple


class Objective(StrEnum):
    """What the optimiser is asked for.

    The last two are no costs of one program but searches over many: the longest run of days and the
    widest band of latitudes that one design keeps up. See :mod:`sizing.optimisation.coverage`.
    """

    max_excess_time = "max_excess_time"
    min_wingspan = "min_wingspan"
    min_mass = "min_mass"
    max_payload_mass = "max_payload_mass"
    max_payload_power = "max_payload_power"
    longest_season = "longest_season"
    widest_latitude_band = "widest_latitude_band"

    @classmethod
    def _missing_(cls, value: object) -> Objective | None:
        """Short name of the usual payload objective."""
        return cls.max_payload_mass if value == "max_payload" else None

    @property
    def unit(self) -> str:
        """Unit of the objective."""
        return _SPECIFICATIONS[self].unit

    @property
    def label(self) -> str:
        """Quantity in words, for axes and tables."""
        return _SPECIFICATIONS[self].label

    @property
    def maximised(self) -> bool:
        """Whether more is better."""
        return _SPECIFICATIONS[self].maximised

    @property
    def variable(self) -> str:
        """Quantity that the objective is the largest or least of."""
        return _SPECIFICATIONS[self].variable

    @property
    def of_range(self) -> bool:
        """Whether the objective is a range of days or latitudes."""
        return self in (Objective.longest_season, Objective.widest_latitude_band)


class _Specification(NamedTuple):
    variable: str
    label: str
    unit: str
    maximised: bool


_SPECIFICATIONS = {
    Objective.max_excess_time: _Specification("worst_excess_time_h", "excess time", "h", True),
    Objective.min_wingspan: _Specification("wingspan_m", "wingspan", "m", False),
    Objective.min_mass: _Specification("total_mass_kg", "total mass", "kg", False),
    Objective.max_payload_mass: _Specification("payload_mass_kg", "payload mass", "kg", True),
    Objective.max_payload_power: _Specification("payload_power_w", "payload power", "W", True),
    Objective.longest_season: _Specification("season_days", "season", "days", True),
    Objective.widest_latitude_band: _Specification(
        "latitude_band_deg", "latitude band", "deg", True
    ),
}


def without_battery(objective: Objective) -> Objective:
    """What is asked of designs that never need a battery: their excess time has no end anyway."""
    return Objective.min_mass if objective is Objective.max_excess_time else objective
