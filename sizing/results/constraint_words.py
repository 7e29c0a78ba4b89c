"""Requirements, bounds and parameters in words, with the key of the file that changes them.

Results name them in JSON by what the program calls them; people read them here.
"""

from __future__ import annotations

from typing import NamedTuple, cast

from sizing.aircraft import Aircraft, DesignSpace, LimitedQuantity, LimitEnd
from sizing.parameters import catalogue, label

# Of the program: what it is, and the key that eases it, if one does so directly.
_REQUIREMENTS = {
    "mass_budget": ("mass budget", ""),
    "module_coverage": ("modules over wing area", "airframe.maximum_module_coverage"),
    "airspeed_above_wind": ("airspeed above the wind", "mission.wind_m_per_s or mission.wind"),
    "power_against_wind": (
        "rated power for flight as fast as the wind",
        "airframe.propulsion.climb_power_ratio",
    ),
    "bus_voltage": ("bus voltage of the empty battery", "battery.voltage"),
    "tip_mach": ("Mach number of the tips", "airframe.propulsion.maximum_tip_mach"),
    "motor_current": ("current of the motor", "airframe.propulsion.motor"),
    "motor_power": ("power of the motor", "airframe.propulsion.motor"),
    "battery_capacity": ("battery capacity for the night", ""),
    "energy_balance": ("solar energy of the day", ""),
    "excess_time": ("required excess time", "mission.required_excess_time_h"),
    "days_that_close": ("days of the record that close", ""),
    "whole_cells": ("wing that holds the cells", "modules.layout"),
    "static_margin": ("static margin", "airframe.balance.static_margin"),
    "moved_mass_foremost": ("moved mass at its foremost", "airframe.balance.foremost_chords"),
    "moved_mass_rearmost": ("moved mass at its rearmost", "airframe.balance.rearmost_chords"),
    "height": ("surplus that the climbs need", ""),
    "climb_ceiling": ("ceiling of the climbs", "mission.climb.ceiling_m"),
    "always_lit": ("solar power above the load at all times", ""),
}
_ENDS = ("maximum", "minimum")


class Words(NamedTuple):
    """A constraint for people: what, in which scenario, and the key that changes it."""

    label: str
    where: str = ""
    key: str = ""

    @property
    def without_key(self) -> str:
        """What limits, and where."""
        return f"{self.label} at {self.where}" if self.where else self.label

    def __str__(self) -> str:
        return f"{self.without_key} ({self.key})" if self.key else self.without_key


def constraint_words(name: str, aircraft: Aircraft | None = None) -> Words:
    """Words for a requirement or bound as results name it.

    ``name``: such as ``excess_time (45° N, 15 Aug)``, ``stall_margin_minimum``, ``wingspan_m at its
    maximum`` or ``wingspan_m at its bound``. ``aircraft``: whose design space has the keys of
    limits; without it they are those under ``limits``. Returns the name itself where nothing is
    known of it.
    """
    bounded, at_its, end = name.partition(" at its ")
    if at_its:
        largest, fields = f"maximum_{bounded}", DesignSpace.model_fields
        key = f"{bounded}.{end}" if end in _ENDS else bounded
        key = largest if largest in fields else key
        known = bounded in fields or largest in fields
        return Words(f"{label(bounded)} at its {end}", "", f"design_space.{key}" if known else "")
    plain, _, rest = name.partition(" (")
    where = rest.removesuffix(")")
    if plain in _REQUIREMENTS:
        text, key = _REQUIREMENTS[plain]
        return Words(text, where, key)
    quantity, _, end = plain.rpartition("_")
    if end in _ENDS and quantity in catalogue():
        key = f"limits.{quantity}.{end}"
        if aircraft is not None:
            limited, side = cast(LimitedQuantity, quantity), cast(LimitEnd, end)
            key = aircraft.design_space.key_of_limit(limited, side)
        return Words(f"{label(quantity)} at its {end}", where, f"design_space.{key}")
    return Words(plain, where)


def parameter_words(key: str) -> str:
    """Label of a parameter by its key, limits of the design space included.

    ``key``: of the aircraft's or, behind ``mission.``, of the mission's file. Returns the key
    itself where the catalogue has no label.
    """
    if key in catalogue():
        return label(key)
    last = key.removeprefix("design_space.").removeprefix("limits.")
    for end, word in zip(_ENDS, ("largest", "least"), strict=True):
        quantity = last.removesuffix(f".{end}").removeprefix(f"{end}_")
        if quantity != last and quantity in catalogue():
            return f"{word} {label(quantity)}"
    return key
