"""What a sizing may be for, and how it may end."""

from __future__ import annotations

from enum import IntEnum, StrEnum
from typing import TYPE_CHECKING, NamedTuple

from sizing import parameters

if TYPE_CHECKING:
    from sizing.design import Design
    from solar.types import FloatArray


class Objective(StrEnum):
    """What the optimiser makes as large or as small as possible.

    The last three are no costs of one program but searches over many: the longest run of days and
    the widest band of latitudes in which one design flies perpetually
    (:mod:`sizing.program.coverage`), and the longest flight (:mod:`sizing.program.endurance`).
    """

    max_excess_time = "max_excess_time"
    min_wingspan = "min_wingspan"
    min_mass = "min_mass"
    max_payload_mass = "max_payload_mass"
    max_payload_power = "max_payload_power"
    longest_season = "longest_season"
    widest_latitude_band = "widest_latitude_band"
    max_endurance = "max_endurance"

    @classmethod
    def _missing_(cls, value: object) -> Objective | None:
        """Short name of the usual payload objective."""
        return cls.max_payload_mass if value == "max_payload" else None

    @property
    def variable(self) -> str:
        """Quantity that the objective is the largest or least of."""
        return _TABLE[self].variable

    @property
    def column(self) -> str:
        """Column of tables and variable of gridded results that the objective is about."""
        return _TABLE[self].column

    @property
    def beside(self) -> str:
        """Another column that is worth a look beside it."""
        return _TABLE[self].beside

    @property
    def cost(self) -> dict[str, float]:
        """Weights of the program's variables in what it minimises; none for a range."""
        return {} if self.of_range else {self.variable: _TABLE[self].weight}

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
        return _TABLE[self].weight <= 0.0

    @property
    def of_range(self) -> bool:
        """Whether the objective is a range of days or latitudes."""
        return _TABLE[self].weight == 0.0

    @property
    def payload_key(self) -> str | None:
        """Key of the mission's payload that is as large as possible; None where none is."""
        kind, _, quantity = self.variable.partition("_")
        return f"{parameters.MISSION_PREFIX}payload.{quantity}" if kind == "payload" else None

    @property
    def of_design(self) -> bool:
        """Whether the design alone tells its value, without a flight."""
        return not (self.of_range or self is Objective.max_excess_time)

    def value_of(self, design: Design) -> FloatArray | float | None:
        """Value of a design, where it tells it; None for a payload that is the mission's."""
        value: FloatArray | float | None
        if self is Objective.min_mass:
            value = design.total_mass_kg
        elif self is Objective.max_payload_mass:
            value = design.masses.payload
        else:
            value = getattr(design.variables, self.variable)
        return value


class _Row(NamedTuple):
    """An objective: its quantity, the weight of that in the program's cost, and its columns."""

    variable: str
    weight: float
    column: str = ""
    beside: str = ""


# The weight is that of the logarithm of a size; an excess time counts in days.
_TABLE = {
    Objective.max_excess_time: _Row(
        "worst_excess_time_h", -1.0 / 24.0, "excess_time", "total_mass"
    ),
    Objective.min_wingspan: _Row("wingspan_m", 1.0, "wingspan", "total_mass"),
    Objective.min_mass: _Row("total_mass_kg", 1.0, "total_mass", "wingspan"),
    Objective.max_payload_mass: _Row("payload_mass_kg", -1.0, "payload_mass", "wingspan"),
    Objective.max_payload_power: _Row("payload_power_w", -1.0, "payload_power", "wingspan"),
    Objective.longest_season: _Row("season_days", 0.0),
    Objective.widest_latitude_band: _Row("latitude_band_deg", 0.0),
    Objective.max_endurance: _Row("endurance_h", 0.0),
}

OBJECTIVE_NAMES = tuple(one.value for one in Objective)
# Those that a map or a trade study can have in every cell, and the short name of one.
RESIZE_NAMES = (*(one.value for one in Objective if not one.of_range), "max_payload")


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
