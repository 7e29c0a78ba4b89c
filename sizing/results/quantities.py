"""The table of quantities of results: key, path, words, unit, form, importance, each once.

Records, frames, tables, the design sheet, and the variables of maps and trade studies are made of
the groups at the end. A new quantity is an entry here and in the groups that are to have it; what
a design may also be bounded by is in :data:`sizing.limits.QUANTITIES` as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import Any

import numpy as np

from sizing.day.metrics import Status
from sizing.design_space import LimitedQuantity
from sizing.limits import QUANTITIES
from sizing.parameters import parameter, unit_text
from sizing.performance import Performance
from sizing.results.records import finite
from sizing.results.tables import CLOCK, UNLIMITED, Column

Getter = Callable[[Any], Any]


@dataclass(frozen=True)
class Quantity(Column):
    """A column that knows where its values come from; its name is the key of records and frames.

    ``of``: its value of a design, or of one in flight; or in every design and scenario of a
    performance. ``importance``: level from which on it is shown; 0 in headlines, 1 in summaries, 2
    with all, 3 in data alone. ``symbol``: in LaTeX. ``meaning``: long name in files on a grid,
    where it is not the label; ``short``: its name there, where it is not the key without its unit.
    """

    of: Getter = field(kw_only=True)
    importance: int = field(default=1, kw_only=True)
    symbol: str = field(default="", kw_only=True)
    meaning: str = field(default="", kw_only=True)
    short: str = field(default="", kw_only=True)

    @property
    def variable(self) -> str:
        """Name in files on a grid."""
        ending = f"_{self.unit.lower().replace('/', '_per_')}"
        return self.short or self.name.removesuffix(ending)

    @property
    def described(self) -> tuple[str, str]:
        """Unit and long name in files on a grid."""
        return self.unit or "1", self.meaning or self.label

    def fact(self, value: Any, form: str = "") -> tuple[str, str]:
        """Label, and the value with its unit; ``form``: where it is not the quantity's own."""
        form = form or self.form
        text = replace(self, form=form).text(value)
        bare = (
            isinstance(value, str)
            or not self.unit
            or form == CLOCK
            or text in (self.missing, UNLIMITED)
        )
        return self.label, text if bare else f"{text} {unit_text(self.unit)}"


def attribute_in_worst(one: Quantity) -> property:
    """Attribute of an analysis: the quantity in its worst scenario."""
    unit = f" [{one.unit}]" if one.unit else ""
    return property(
        lambda analysis: analysis.value_in_worst(one),
        doc=f"{one.meaning or one.label or one.name}{unit}, in the worst scenario.",
    )


def attribute_of_design(one: Quantity) -> property:
    """Attribute of an analysis or a sizing: the quantity of its design, NaN without one."""

    def value(result: Any) -> float | None:
        design = result.design
        return math.nan if design is None else finite(one.of(design))

    return property(value, doc=f"{one.meaning or one.label} [{one.unit}].")


def _quantity(
    key: str, of: str | Getter = "", words: str = "", *, unit: str = "", **others: Any
) -> Quantity:
    """Row of the table: what the catalogue of parameters knows of a key needs no words here.

    ``of``: path from a design or a performance, or a function; the key itself by default.
    """
    if not words:
        known = parameter(key)
        words, unit = known.label, "" if known.unit == "1" else known.unit
        others.setdefault("symbol", known.symbol)
    getter = of if callable(of) else attrgetter(of or key)
    return Quantity(key, words, unit, of=getter, **others)


def _in_flight(key: LimitedQuantity, form: str = ".2f", **others: Any) -> Quantity:
    """Quantity of a design in flight, which a design may be bounded by."""
    return _quantity(key, QUANTITIES[key], form=form, **others)


def _daylight(name: str) -> Getter:
    """Instant of the sun; NaN where it does not rise or does not set."""

    def instant(flight: Performance) -> Any:
        day = flight.day
        return np.where(day.sunset_h > day.sunrise_h, getattr(day, name), np.nan)

    return instant


def _status_names(flight: Performance) -> list[str]:
    """Status for users; a cycle without any solar power is one of the limited ones."""
    every = (Status(int(one)) for one in flight.cycle.status)
    return [(Status.limited if one is Status.never_lit else one).name for one in every]


def _best_launches(flight: Performance) -> Any:
    return [np.nan if one is None else one.launch_h for one in flight.endurances()]


# ---- Of a design

WINGSPAN = _quantity("wingspan_m", "variables.wingspan_m", form=".3f", importance=0)
ASPECT_RATIO = _quantity("aspect_ratio", "variables.aspect_ratio", form=".2f")
BATTERY_MASS = _quantity("battery_mass_kg", "variables.battery_mass_kg", form=".3f", importance=0)
MODULE_AREA = _quantity(
    *("module_area_m2", "variables.module_area_m2"),
    form=".3f",
    importance=0,
    meaning="area of the solar modules",
)
PAYLOAD_MASS = _quantity("payload_mass_kg", "masses.payload", form=".3f")
PAYLOAD_POWER = _quantity(
    *("payload_power_w", "variables.payload_power_w"), form=".1f", meaning="power of the payload"
)
PROPELLER_DIAMETER = _quantity("propeller_diameter_m", "variables.propeller_diameter_m", form=".3f")
PROPELLER_PITCH = _quantity("propeller_pitch_m", "variables.propeller_pitch_m", form=".3f")
GEAR_RATIO = _quantity("gear_ratio", "variables.gear_ratio", form=".2f")
SPEED_CONSTANT = _quantity(
    *("motor_speed_constant_rpm_per_v", "variables.motor_speed_constant_rpm_per_v"), form=".0f"
)
TOTAL_MASS = _quantity("total_mass_kg", form=".3f", importance=0)
WING_AREA = _quantity("wing_area_m2", form=".3f")
AIRSPEED = _quantity("airspeed_m_per_s", form=".2f")
BATTERY_ENERGY = _quantity("battery_energy_wh", form=".1f")
PROPULSION_POWER = _quantity("propulsion_power_w", form=".1f")

STALL_SPEED = _in_flight("stall_speed_m_per_s", importance=2)
WING_LOADING = _in_flight("wing_loading_kg_per_m2", importance=2)
CLIMB_RATE = _in_flight("climb_rate_m_per_s", importance=2)
CHORD = _in_flight("chord_m", ".3f", importance=2)
REYNOLDS_NUMBER = _in_flight("reynolds_number", ",.0f", digits=3, importance=2)
LIFT_COEFFICIENT = _in_flight("lift_coefficient", importance=2)
AIR_DENSITY = _quantity(
    *("air_density_kg_per_m3", "conditions.density_kg_per_m3", "air density"),
    unit="kg/m³",
    form=".3f",
    symbol=r"\rho",
    importance=2,
)
DRAG = _quantity("drag_n", "", "drag", unit="N", form=".2f", symbol="D", importance=2)
LIFT_TO_DRAG = _quantity(
    "lift_to_drag", "", "lift over drag", form=".1f", symbol="L/D", importance=2
)

# ---- In a scenario

EXCESS_TIME = _quantity(
    *("excess_time_h", "cycle.excess_time_h", "excess time"),
    unit="h",
    form=".2f",
    importance=0,
    symbol=r"T_\mathrm{exc}",
    meaning="excess time; infinite where solar power always exceeds the load",
)
CHARGE_MARGIN = _quantity(
    *("charge_margin_h", "cycle.charge_margin_h", "charge margin"),
    unit="h",
    form=".2f",
    symbol=r"T_\mathrm{cm}",
    meaning="time from first full charge to last instant of full charge",
)
MINIMUM_CHARGE = _quantity(
    *("minimum_state_of_charge", "cycle.minimum_state_of_charge", "minimum state of charge"),
    form=".1%",
    symbol=r"\mathit{SoC}_\mathrm{min}",
    meaning="minimum state of charge of the repeated day",
)
# Where a negative one is shown.
BELOW_ZERO = "An excess time below 0 is the time of the day without enough power."
ENDURANCE = _quantity(
    *("endurance_h", "endurance_h", "endurance"),
    unit="h",
    form=".2f",
    symbol=r"T_\mathrm{endur}",
    meaning="longest flight over all launch times; infinite where perpetual",
)
BEST_LAUNCH = _quantity(
    "best_launch_h", _best_launches, "best launch", unit="h", form=CLOCK, importance=2
)
STATUS = _quantity("status", _status_names, "status", importance=0)
SUNRISE = _quantity(
    "sunrise_h", _daylight("sunrise_h"), "sunrise", unit="h", form=CLOCK, importance=2
)
SUNSET = _quantity("sunset_h", _daylight("sunset_h"), "sunset", unit="h", form=CLOCK, importance=2)
DAY_LENGTH = _quantity(
    *("day_length_h", lambda flight: flight.day.sunset_h - flight.day.sunrise_h, "day length"),
    unit="h",
    importance=3,
    meaning="time from sunrise to sunset",
)
EQUAL_POWER_MORNING = _quantity(
    *("equal_power_morning_h", "cycle.equal_power_morning_h", "equal power in the morning"),
    unit="h",
    form=CLOCK,
    importance=2,
    meaning="solar time at which solar power first equals the load",
)
EQUAL_POWER_EVENING = _quantity(
    *("equal_power_evening_h", "cycle.equal_power_evening_h", "equal power in the evening"),
    unit="h",
    form=CLOCK,
    importance=2,
    meaning="solar time at which solar power last equals the load",
)
FULL_CHARGE = _quantity(
    *("full_charge_h", "cycle.full_charge_h", "full charge"),
    unit="h",
    form=CLOCK,
    meaning="solar time of the first full charge",
)
LOAD = _quantity(
    *("power_out_w", lambda one: np.broadcast_to(one.nominal_load_w, one.cycle.status.shape)),
    "load",
    unit="W",
    form=".1f",
    meaning="nominal load",
    short="power",
)
SOLAR_ENERGY = _quantity(
    *("solar_energy_wh", "cycle.energy_budget.solar_wh", "solar energy of the day"),
    unit="Wh",
    form=".0f",
    symbol=r"E_\mathrm{solar}",
    meaning="electric energy of the modules over the day",
)
LOAD_ENERGY = _quantity(
    *("load_energy_wh", "cycle.energy_budget.load_wh", "load"),
    unit="Wh",
    form=".0f",
    importance=3,
    meaning="energy drawn over the day",
)
CURTAILED_ENERGY = _quantity(
    *("curtailed_energy_wh", "cycle.energy_budget.curtailed_wh"),
    "not collected, the battery being full",
    unit="Wh",
    form=".0f",
    importance=3,
)

# Of flights with climbs alone.
MAXIMUM_ALTITUDE = _quantity(
    *("maximum_altitude_m", "maximum_altitude_m", "highest altitude"),
    unit="m",
    form=".0f",
    meaning="highest altitude of the day",
)

# Of tables that have no room for more.
CHARGE_PERCENT = Column("minimum_state_of_charge_percent", "min. SoC", "%", ".1f")

# ---- Groups: what is made of quantities

# Record of a scenario, and the frame of them all.
SCENARIO = (
    *(EXCESS_TIME, CHARGE_MARGIN, ENDURANCE, BEST_LAUNCH, MINIMUM_CHARGE, STATUS, SUNRISE, SUNSET),
    *(EQUAL_POWER_MORNING, EQUAL_POWER_EVENING, FULL_CHARGE, LOAD, SOLAR_ENERGY),
    *(LOAD_ENERGY, CURTAILED_ENERGY),
)
SCENARIO_FRAME = (
    *(STATUS, EXCESS_TIME, CHARGE_MARGIN, ENDURANCE, MINIMUM_CHARGE, SOLAR_ENERGY, LOAD_ENERGY),
)
# Facts of an analysis: of its flight, and of its aircraft.
IN_FLIGHT = (
    *(EXCESS_TIME, CHARGE_MARGIN, ENDURANCE, BEST_LAUNCH, MINIMUM_CHARGE, FULL_CHARGE),
    *(SUNRISE, SUNSET, EQUAL_POWER_MORNING, EQUAL_POWER_EVENING),
)
OF_AIRCRAFT = (TOTAL_MASS, BATTERY_ENERGY, AIRSPEED)
ENOUGH = (EXCESS_TIME, MINIMUM_CHARGE)
# What a sized design reaches in its worst scenario, and in each.
REACHED = (EXCESS_TIME, CHARGE_MARGIN, MINIMUM_CHARGE)
REACHED_FRAME = (*REACHED, SOLAR_ENERGY, LOAD_ENERGY)
# Variables of a map, of trade studies and of maps of sized designs.
MAP = (
    *(EXCESS_TIME, MINIMUM_CHARGE, CHARGE_MARGIN, EQUAL_POWER_MORNING, EQUAL_POWER_EVENING),
    *(FULL_CHARGE, SOLAR_ENERGY, LOAD_ENERGY, DAY_LENGTH),
)
CHOSEN = (WINGSPAN, ASPECT_RATIO, BATTERY_MASS, MODULE_AREA)
# Where they are chosen.
CHOSEN_PROPULSION = (PROPELLER_DIAMETER, PROPELLER_PITCH, GEAR_RATIO, SPEED_CONSTANT)
DESIGN_COLUMNS = (*CHOSEN, PAYLOAD_MASS, PAYLOAD_POWER, TOTAL_MASS)
# Frame of the draws of uncertain inputs.
DRAWN = (EXCESS_TIME, MINIMUM_CHARGE, TOTAL_MASS, PROPULSION_POWER)
# Table of a sized design.
SIZED_TABLE = (*CHOSEN, TOTAL_MASS, AIRSPEED, STALL_SPEED, WING_LOADING, CLIMB_RATE, LOAD)
# Level flight of designs whose drag is modelled, as a report tells it.
MODELLED_FLIGHT = (STALL_SPEED, LIFT_COEFFICIENT, LIFT_TO_DRAG, DRAG)
# Energy of the design sheet.
SHEET_ENERGY = (SOLAR_ENERGY, EXCESS_TIME, CHARGE_MARGIN, MINIMUM_CHARGE, ENDURANCE)
