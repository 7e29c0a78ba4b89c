"""Design space: ranges of the design variables, and limits of a design."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

from pydantic import Field, Strict, model_validator

from solar.schema import PositiveReal, Record, spell, wrong_value


class Limit(Record):
    """Least and largest value of a quantity of the design; either is optional."""

    _not_below: ClassVar[Mapping[str, str]] = {"maximum": "minimum"}

    minimum: PositiveReal | None = None
    maximum: PositiveReal | None = None

    @model_validator(mode="after")
    def _check_ends(self) -> Self:
        if self.minimum is None and self.maximum is None:
            raise ValueError("give a minimum, a maximum or both")
        return self


class Range(Limit):
    """Bounds of a design variable; equal bounds fix it."""

    minimum: PositiveReal
    maximum: PositiveReal


# Quantities of a design that a file may bound; their formulas are in sizing.limits.
LimitedQuantity = Literal[
    "total_mass_kg",
    "structure_mass_kg",
    "battery_energy_wh",
    "battery_fraction",
    "payload_fraction",
    "wing_area_m2",
    "chord_m",
    "module_coverage",
    "wing_loading_kg_per_m2",
    "airspeed_m_per_s",
    "stall_speed_m_per_s",
    "stall_margin",
    "lift_coefficient",
    "reynolds_number",
    "propulsion_power_w",
    "rated_power_w",
    "load_w",
    "climb_rate_m_per_s",
    "cruise_discharge_rate_per_h",
    "climb_discharge_rate_per_h",
]
LimitEnd = Literal["minimum", "maximum"]
ENDS: tuple[LimitEnd, LimitEnd] = ("minimum", "maximum")
# Limits with their own keys.
_NAMED_LIMITS: dict[str, tuple[LimitedQuantity, LimitEnd]] = {
    "maximum_wing_loading_kg_per_m2": ("wing_loading_kg_per_m2", "maximum"),
    "minimum_stall_margin": ("stall_margin", "minimum"),
    "minimum_climb_rate_m_per_s": ("climb_rate_m_per_s", "minimum"),
    "maximum_climb_discharge_rate_per_h": ("climb_discharge_rate_per_h", "maximum"),
}


class LimitRow(NamedTuple):
    """Lower or upper limit of a quantity of the design, and its key."""

    quantity: LimitedQuantity
    end: LimitEnd
    value: float
    key: str


PROPULSION_VARIABLES = (
    "propeller_diameter_m",
    "propeller_pitch_m",
    "gear_ratio",
    "motor_speed_constant_rpm_per_v",
)


class DesignSpace(Record):
    """Bounds of the optimiser's variables and of other quantities.

    Aspect ratio, lift coefficient, propeller, gear and winding of the motor are those of the
    airframe unless they have a range here. ``limits`` bounds any other quantity of the design.
    """

    wingspan_m: Range = Range(minimum=1.0, maximum=15.0)
    battery_mass_kg: Range = Range(minimum=0.1, maximum=50.0)
    module_area_m2: Range = Range(minimum=0.05, maximum=25.0)
    aspect_ratio: Range | None = None
    lift_coefficient: Range | None = None
    propeller_diameter_m: Range | None = None
    propeller_pitch_m: Range | None = None
    gear_ratio: Range | None = None
    motor_speed_constant_rpm_per_v: Range | None = None
    maximum_total_mass_kg: PositiveReal | None = None
    maximum_wing_loading_kg_per_m2: PositiveReal | None = None
    minimum_stall_margin: Annotated[float, Strict(), Field(ge=1.0, le=5.0)] | None = None
    minimum_climb_rate_m_per_s: PositiveReal | None = None
    maximum_climb_discharge_rate_per_h: PositiveReal | None = None
    limits: dict[LimitedQuantity, Limit] = Field(default_factory=dict)

    def requested_ranges(self) -> dict[str, Range]:
        """Return the bounds of the optional variables that have a range, by name."""
        names = ("aspect_ratio", "lift_coefficient", *PROPULSION_VARIABLES)
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}

    def __hash__(self) -> int:
        # Mappings have no hash; aircraft are keys of caches.
        others = (getattr(self, name) for name in type(self).model_fields if name != "limits")
        return hash((*others, frozenset(self.limits.items())))

    def limit_rows(self) -> dict[str, LimitRow]:
        """Return the limits on quantities of the design, by the names of their rows."""
        ends = [(*place, getattr(self, key), key) for key, place in _NAMED_LIMITS.items()]
        ends += [
            (quantity, end, getattr(limit, end), f"limits.{quantity}.{end}")
            for quantity, limit in self.limits.items()
            for end in ENDS
        ]
        rows = (LimitRow(*end) for end in ends if end[2] is not None)
        return {f"{row.quantity}_{row.end}": row for row in rows}

    def user_requirements(self, design: Any) -> list[Any]:
        """Return user-defined requirements on a design; none in files."""
        return []

    @model_validator(mode="after")
    def _check_mass(self) -> DesignSpace:
        heaviest, battery = self.maximum_total_mass_kg, self.battery_mass_kg.minimum
        twice = [
            key
            for key, (quantity, _) in _NAMED_LIMITS.items()
            if getattr(self, key) is not None and quantity in self.limits
        ]
        if twice:
            raise ValueError(f"{twice[0]} and the same quantity in limits: give one of them")
        if heaviest is not None and heaviest <= battery:
            text = f"must be above the least battery mass of {spell(battery)} kg"
            raise wrong_value("maximum_total_mass_kg", text, got=heaviest)
        return self
