"""Quantities of results, each declared once: key, words, unit, form, and where it comes from.

Records, frames, tables, the design sheet, and the variables of maps and trade studies are made of
the groups at the end. A new quantity is an entry here and in the groups that are to have it; what
a design may also be bounded by is in :data:`sizing.limits.QUANTITIES` as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import Any

import numpy as np

from sizing.day.metrics import Status
from sizing.design import Design
from sizing.design_space import LimitedQuantity
from sizing.limits import QUANTITIES
from sizing.parameters import parameter, unit_text
from sizing.performance import Performance
from sizing.results.records import finite
from sizing.results.tables import UNLIMITED, Column

Getter = Callable[[Any], Any]


@dataclass(frozen=True)
class Quantity(Column):
    """A column that knows where its values come from; its name is the key of records and frames.

    ``of``: its value of a design, or of one in flight; or in every design and scenario of a
    performance. ``symbol``: in LaTeX. ``meaning``: long name in files on a grid, where it is not
    the label; ``short``: its name there, where it is not the key without its unit.
    """

    of: Getter = field(kw_only=True)
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
        text = replace(self, form=form or self.form).text(value)
        bare = not self.unit or text in (self.missing, UNLIMITED)
        return self.label, text if bare else f"{text} {unit_text(self.unit)}"


def worst_record(flight: Performance, quantities: Iterable[Quantity]) -> dict[str, float | None]:
    """Values of a single design in its worst scenario, JSON-ready."""
    worst = flight.worst_scenario()
    return {one.name: finite(one.of(flight)[worst]) for one in quantities}


def design_record(design: Design, quantities: Iterable[Quantity]) -> dict[str, float | None]:
    """Values of a design, JSON-ready."""
    return {one.name: finite(one.of(design)) for one in quantities}


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
        return math.nan if design is None else design_record(design, [one])[one.name]

    return property(value, doc=f"{one.meaning or one.label} [{one.unit}].")


def _of_design(key: str, form: str, path: str = "", meaning: str = "") -> Quantity:
    """Quantity of a design, as the catalogue of parameters describes it."""
    known = parameter(key)
    unit, of = "" if known.unit == "1" else known.unit, attrgetter(path or key)
    return Quantity(key, known.label, unit, form, of=of, symbol=known.symbol, meaning=meaning)


def _in_flight(key: LimitedQuantity) -> Quantity:
    """Quantity of a design in flight."""
    return replace(_of_design(key, ".2f"), of=QUANTITIES[key])


def _of_cycle(
    key: str, label: str, symbol: str = "", meaning: str = "", *, unit: str = "h", form: str = ".2f"
) -> Quantity:
    """Quantity of a day that repeats itself."""
    of = attrgetter(f"cycle.{key}")
    return Quantity(key, label, unit, form, of=of, symbol=symbol, meaning=meaning)


def _of_budget(key: str, label: str, symbol: str = "", meaning: str = "") -> Quantity:
    """Energy of a day that repeats itself."""
    of = attrgetter(f"cycle.energy_budget.{key.replace('_energy', '')}")
    return Quantity(key, label, "Wh", ".0f", of=of, symbol=symbol, meaning=meaning)


def _sunlit(name: str) -> Getter:
    """Instant of the sun; NaN where it does not rise or does not set."""

    def instant(flight: Performance) -> Any:
        day = flight.day
        return np.where(day.sunset_h > day.sunrise_h, getattr(day, name), np.nan)

    return instant


def _status_names(flight: Performance) -> list[str]:
    """Status for users; a cycle without any solar power is one of the limited ones."""
    every = (Status(int(one)) for one in flight.cycle.status)
    return [(Status.limited if one is Status.never_lit else one).name for one in every]


# ---- Of a design

WINGSPAN = _of_design("wingspan_m", ".3f", "variables.wingspan_m")
ASPECT_RATIO = _of_design("aspect_ratio", ".2f", "variables.aspect_ratio")
BATTERY_MASS = _of_design("battery_mass_kg", ".3f", "variables.battery_mass_kg")
MODULE_AREA = _of_design(
    "module_area_m2", ".3f", "variables.module_area_m2", "area of the solar modules"
)
PAYLOAD_MASS = _of_design("payload_mass_kg", ".3f", "masses.payload")
PAYLOAD_POWER = _of_design(
    "payload_power_w", ".1f", "variables.payload_power_w", "power of the payload"
)
PROPELLER_DIAMETER = _of_design("propeller_diameter_m", ".3f", "variables.propeller_diameter_m")
PROPELLER_PITCH = _of_design("propeller_pitch_m", ".3f", "variables.propeller_pitch_m")
GEAR_RATIO = _of_design("gear_ratio", ".2f", "variables.gear_ratio")
SPEED_CONSTANT = _of_design(
    "motor_speed_constant_rpm_per_v", ".0f", "variables.motor_speed_constant_rpm_per_v"
)
TOTAL_MASS = _of_design("total_mass_kg", ".3f")
WING_AREA = _of_design("wing_area_m2", ".3f")
AIRSPEED = _of_design("airspeed_m_per_s", ".2f")
BATTERY_ENERGY = _of_design("battery_energy_wh", ".1f")
PROPULSION_POWER = _of_design("propulsion_power_w", ".1f")

STALL_SPEED = _in_flight("stall_speed_m_per_s")
WING_LOADING = _in_flight("wing_loading_kg_per_m2")
CLIMB_RATE = _in_flight("climb_rate_m_per_s")
CHORD = replace(_in_flight("chord_m"), form=".3f")
AIR_DENSITY = Quantity(
    *("air_density_kg_per_m3", "air density", "kg/m³", ".3f"),
    of=attrgetter("conditions.density_kg_per_m3"),
    symbol=r"\rho",
)
REYNOLDS_NUMBER = replace(_in_flight("reynolds_number"), form=",.0f", digits=3)
LIFT_COEFFICIENT = _in_flight("lift_coefficient")
DRAG = Quantity("drag_n", "drag", "N", ".2f", of=attrgetter("drag_n"), symbol="D")
LIFT_TO_DRAG = Quantity(
    *("lift_to_drag", "lift over drag", "", ".1f"), of=attrgetter("lift_to_drag"), symbol="L/D"
)

# ---- In a scenario

EXCESS_TIME = _of_cycle(
    *("excess_time_h", "excess time", r"T_\mathrm{exc}"),
    "excess time; infinite where solar power always exceeds the load",
)
CHARGE_MARGIN = _of_cycle(
    *("charge_margin_h", "charge margin", r"T_\mathrm{cm}"),
    "time from first full charge to last instant of full charge",
)
MINIMUM_CHARGE = _of_cycle(
    *("minimum_state_of_charge", "minimum state of charge", r"\mathit{SoC}_\mathrm{min}"),
    "minimum state of charge of the repeated day",
    unit="",
    form=".1%",
)
# Where a negative one is shown.
BELOW_ZERO = (
    "An excess time below 0 is the time of the day without enough power, one above 0 the time to "
    "spare: it jumps at 0."
)
ENDURANCE = Quantity(
    *("endurance_h", "endurance", "h", ".2f"),
    of=attrgetter("endurance_h"),
    symbol=r"T_\mathrm{endur}",
    meaning="longest flight over all launch times; infinite where perpetual",
)
BEST_LAUNCH = Quantity(
    *("best_launch_h", "best launch", "h"),
    of=lambda found: [np.nan if one is None else one.launch_h for one in found.endurances()],
)
STATUS = Quantity("status", of=_status_names)
SUNRISE = Quantity("sunrise_h", "sunrise", "h", of=_sunlit("sunrise_h"))
SUNSET = Quantity("sunset_h", "sunset", "h", of=_sunlit("sunset_h"))
DAY_LENGTH = Quantity(
    *("day_length_h", "day length", "h"),
    of=lambda found: found.day.sunset_h - found.day.sunrise_h,
    meaning="time from sunrise to sunset",
)
EQUAL_POWER_MORNING = _of_cycle(
    *("equal_power_morning_h", "equal power in the morning", ""),
    "solar time at which solar power first equals the load",
)
EQUAL_POWER_EVENING = _of_cycle(
    *("equal_power_evening_h", "equal power in the evening", ""),
    "solar time at which solar power last equals the load",
)
FULL_CHARGE = _of_cycle("full_charge_h", "full charge", "", "solar time of the first full charge")
LOAD = Quantity(
    *("power_out_w", "load", "W", ".1f"),
    of=lambda found: np.broadcast_to(found.nominal_load_w, found.cycle.status.shape),
    meaning="nominal load",
    short="power",
)
SOLAR_ENERGY = _of_budget(
    *("solar_energy_wh", "solar energy of the day", r"E_\mathrm{solar}"),
    "electric energy of the modules over the day",
)
LOAD_ENERGY = _of_budget("load_energy_wh", "load", "", "energy drawn over the day")
CURTAILED_ENERGY = _of_budget("curtailed_energy_wh", "not collected, the battery being full")

# Of flights with climbs alone.
MAXIMUM_ALTITUDE = Quantity(
    *("maximum_altitude_m", "highest altitude", "m", ".0f"),
    of=attrgetter("maximum_altitude_m"),
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
# Beside the total mass, of what is analysed and of what is sized.
ANALYSED = (BATTERY_ENERGY, PROPULSION_POWER, AIRSPEED)
SIZED = (WING_AREA, AIRSPEED, PROPULSION_POWER)
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
