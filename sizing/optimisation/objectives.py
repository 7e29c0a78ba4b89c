"""What a sizing may be for, and how it may end."""

from __future__ import annotations

from enum import IntEnum, StrEnum

from sizing import parameters


class Objective(StrEnum):
    """What the optimiser makes as large or as small as possible.

    The last two are no costs of one program but searches over many: the longest run of days and the
    widest band of latitudes in which one design flies perpetually. See
    :mod:`sizing.optimisation.coverage`.
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
    def variable(self) -> str:
        """Quantity that the objective is the largest or least of."""
        return _VARIABLES[self]

    @property
    def unit(self) -> str:
        """Unit of the objective."""
        return parameters.unit(self.variable)

    @property
    def label(self) -> str:
        """Quantity in words, for axes and tables."""
        return parameters.label(self.variable)

    @property
    def maximised(self) -> bool:
        """Whether more is better."""
        return self not in (Objective.min_wingspan, Objective.min_mass)

    @property
    def of_range(self) -> bool:
        """Whether the objective is a range of days or latitudes."""
        return self in (Objective.longest_season, Objective.widest_latitude_band)


_VARIABLES = {
    Objective.max_excess_time: "worst_excess_time_h",
    Objective.min_wingspan: "wingspan_m",
    Objective.min_mass: "total_mass_kg",
    Objective.max_payload_mass: "payload_mass_kg",
    Objective.max_payload_power: "payload_power_w",
    Objective.longest_season: "season_days",
    Objective.widest_latitude_band: "latitude_band_deg",
}


class SizingStatus(IntEnum):
    """How a sizing ends; the numbers are the flags of gridded results, the names those of JSON.

    ``failed`` stands for an error of the program, ``invalid`` for values that no aircraft or
    mission can have, ``not_converged`` says nothing about feasibility. An optimum is one that the
    simulator confirms; it is ``cross_checked`` where neighbouring designs were tried and none is
    better.
    """

    failed = -1
    optimal = 0
    infeasible = 1
    not_converged = 2
    invalid = 3
    cross_checked = 4

    @property
    def label(self) -> str:
        """Name in words."""
        return self.name.replace("_", " ")

    @property
    def sized(self) -> bool:
        """Whether there is a design."""
        return self in (SizingStatus.optimal, SizingStatus.cross_checked)
