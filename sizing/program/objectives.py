"""What a sizing may be for, and how it may end."""

from __future__ import annotations

from enum import IntEnum, StrEnum

from sizing import parameters


class Objective(StrEnum):
    """What the optimiser makes as large or as small as possible.

    The last three are no costs of one program but searches over many: the longest run of days and
    the widest band of latitudes in which one design flies perpetually
    (:mod:`sizing.program.ranges`), and the longest flight (:mod:`sizing.program.endurance`).

    ``variable``: quantity that is as large or as small as possible. ``weight``: of its logarithm in
    what the program minimises, of an excess time in days. ``column``: of tables and gridded
    results; ``beside``: another one that is worth a look beside it.
    """

    _value_: str
    variable: str
    weight: float
    column: str
    beside: str

    max_excess_time = "max_excess_time", "worst_excess_time_h", -1 / 24, "excess_time", "total_mass"
    min_wingspan = "min_wingspan", "wingspan_m", 1.0, "wingspan", "total_mass"
    min_mass = "min_mass", "total_mass_kg", 1.0, "total_mass", "wingspan"
    max_payload_mass = "max_payload_mass", "payload_mass_kg", -1.0, "payload_mass", "wingspan"
    max_payload_power = "max_payload_power", "payload_power_w", -1.0, "payload_power", "wingspan"
    longest_season = "longest_season", "season_days"
    widest_latitude_band = "widest_latitude_band", "latitude_band_deg"
    max_endurance = "max_endurance", "endurance_h"

    def __new__(
        cls, value: str, variable: str = "", weight: float = 0.0, column: str = "", beside: str = ""
    ) -> Objective:
        """Make an objective of its value and what is known of it."""
        objective = str.__new__(cls, value)
        objective._value_, objective.variable, objective.weight = value, variable, weight
        objective.column, objective.beside = column, beside
        return objective

    @classmethod
    def _missing_(cls, value: object) -> Objective | None:
        """Short name of the usual payload objective."""
        return cls.max_payload_mass if value == "max_payload" else None

    @property
    def cost(self) -> dict[str, float]:
        """Weights of the program's variables in what it minimises."""
        return {self.variable: self.weight}

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
        return self.weight <= 0.0

    @property
    def of_range(self) -> bool:
        """Whether the objective is a range of days or latitudes."""
        return self.weight == 0.0

    @property
    def payload_key(self) -> str | None:
        """Key of the mission's payload that is as large as possible; None where none is."""
        kind, _, quantity = self.variable.partition("_")
        return f"{parameters.MISSION_PREFIX}payload.{quantity}" if kind == "payload" else None

    @property
    def of_design(self) -> bool:
        """Whether the design alone tells its value, without a flight."""
        return not (self.of_range or self is Objective.max_excess_time)


OBJECTIVE_NAMES = tuple(objective.value for objective in Objective)
# Those of a single program, which a map or a trade study can have in every cell.
SINGLE_OBJECTIVES = tuple(objective for objective in Objective if not objective.of_range)
RESIZE_NAMES = (*(objective.value for objective in SINGLE_OBJECTIVES), "max_payload")


def refuse_range(objective: Objective, why: str) -> None:
    """Refuse a range, for which nothing is known of a single program."""
    if objective.of_range:
        raise ValueError(f"{objective.value} counts days or degrees: {why}")


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
