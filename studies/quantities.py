"""The table of quantities of results: key, path, words, unit, form, importance, each once.

``data/quantities.csv`` declares them; records, frames, tables, the design sheet, and the variables
of maps and trade studies are made of the groups at the end. A new quantity is a row there and in
the groups that are to have it; what a design may also be bounded by is in
:data:`sizing.limits.QUANTITIES` as well.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from missions.files.data_rows import data_rows
from sizing.parameters import parameter, unit_text
from sizing.performance import MEASURES, Performance
from studies.render.tables import ALL, CLOCK, UNLIMITED, Column, Table


@dataclass(frozen=True)
class Quantity(Column):
    """A column that knows where its values come from; its name is the key of records and frames.

    ``path``: to its value, where it is not the key. ``importance``: level from which on it is
    shown; 0 in headlines, 1 in summaries, 2 with all, 3 in data alone. ``symbol``: in LaTeX.
    ``meaning``: long name in files on a grid, where it is not the label; ``short``: its name there,
    where it is not the key without its unit. ``definition``: for glossaries. ``part``: table of
    facts that has it.
    """

    path: str = field(default="", kw_only=True)
    importance: int = field(default=1, kw_only=True)
    symbol: str = field(default="", kw_only=True)
    meaning: str = field(default="", kw_only=True)
    short: str = field(default="", kw_only=True)
    definition: str = field(default="", kw_only=True)
    part: str = field(default="", kw_only=True)

    def of(self, result: Any) -> Any:
        """Return the value of a design, a result, or values by their keys; None where it has none.

        Of a performance that of every scenario.
        """
        if isinstance(result, Performance) and self.name in MEASURES:
            return MEASURES[self.name](result)
        return reach(result, self.name if isinstance(result, Mapping) else self.path or self.name)

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
        """Return label, and value, or several, with the unit; ``form``: in place of its own."""
        if isinstance(value, Mapping):
            return self.label, ", ".join(self.fact(each, form)[1] for each in value.values())
        column = replace(self, form=form or self.form)
        text, unit = column.text(value), unit_text(column.shown_unit)
        bare = isinstance(value, str) or not unit or column.form == CLOCK
        return self.label, text if bare or text in (self.missing, UNLIMITED) else f"{text} {unit}"


# ---- The table


def _from_row(row: dict[str, Any]) -> Quantity:
    """Return the quantity of a row; words may be those of the catalogue of parameters."""
    key, label, digits = row.pop("key"), row.pop("words"), row.pop("digits")
    if not label:
        known = parameter(key)
        unit = "" if known.unit == "1" else known.unit
        label, row = known.label, row | {"unit": unit, "symbol": known.symbol}
    row |= {"definition": row["definition"] or "", "part": row["part"] or ""}
    numbers = {"importance": int(row["importance"]), "digits": int(digits) if digits else None}
    return Quantity(key, label, **row | numbers)


TABLE = {quantity.name: quantity for quantity in map(_from_row, data_rows("quantities", "studies"))}


def reach(value: Any, path: str) -> Any:
    """Return the value at the end of a path of attributes, keys, places and methods.

    None behind None.
    """
    for name in path.split("."):
        if value is None:
            return None
        if name.lstrip("-").isdecimal():
            value = value[int(name)]
        else:
            value = value.get(name) if isinstance(value, Mapping) else getattr(value, name)
        value = value() if callable(value) else value
    return value


def words(key: str) -> str:
    """Return the words of a quantity, or of what the table does not have by its key."""
    return TABLE[key].label if key in TABLE else key.replace("_", " ")


def facts_of(
    quantities: Iterable[Quantity], result: Any, level: int = ALL
) -> list[tuple[str, str]]:
    """Return words and values of the quantities of a level that a result has."""
    shown = ((each, each.of(result)) for each in quantities if each.importance <= level)
    return [each.fact(value) for each, value in shown if value is not None]


def group(keys: str) -> tuple[Quantity, ...]:
    """Return quantities by their keys."""
    return tuple(TABLE[key] for key in keys.split())


def of_part(part: str) -> tuple[Quantity, ...]:
    """Return the quantities of a table of facts."""
    return tuple(quantity for quantity in TABLE.values() if quantity.part == part)


def described(keys: str) -> dict[str, tuple[str, str]]:
    """Return unit and long name of variables in files on a grid, by the quantities' keys."""
    return {quantity.variable: quantity.described for quantity in group(keys)}


def table_of(
    title: str,
    keys: str | Sequence[Column],
    rows: Iterable[Any],
    notes: Sequence[str] = (),
    sections: Sequence[int] = (),
) -> Table:
    """Return a table of records or objects, a row each, with a column for each key."""
    columns = group(keys) if isinstance(keys, str) else tuple(keys)
    cells = tuple(tuple(reach(row, column.name) for column in columns) for row in rows)
    return Table(title, columns, cells, tuple(notes), sections=tuple(sections))


def text_of(key: str, value: Any) -> str:
    """Return the value of a quantity with its unit."""
    return TABLE[key].fact(value)[1]


WINGSPAN, ASPECT_RATIO, BATTERY_MASS, MODULE_AREA = group(
    "wingspan_m aspect_ratio battery_mass_kg module_area_m2"
)
PAYLOAD_MASS, PAYLOAD_POWER, TOTAL_MASS = group("payload_mass_kg payload_power_w total_mass_kg")
AIRSPEED, BATTERY_ENERGY = group("airspeed_m_per_s battery_energy_wh")
EXCESS_TIME, CHARGE_MARGIN, MINIMUM_CHARGE, ENDURANCE = group(
    "excess_time_h charge_margin_h minimum_state_of_charge endurance_h"
)
BEST_LAUNCH, FULL_CHARGE = group("best_launch_h full_charge_h")
LOAD, SOLAR_ENERGY, MAXIMUM_ALTITUDE = group("power_out_w solar_energy_wh maximum_altitude_m")
# Where a negative excess time is shown.
BELOW_ZERO = "An excess time below 0 is the time of the day without enough power."

# ---- Groups: what is made of quantities

# Facts of an analysis: of its flight, and of its aircraft.
IN_FLIGHT = group(
    "excess_time_h charge_margin_h endurance_h best_launch_h minimum_state_of_charge full_charge_h "
    "sunrise_h sunset_h equal_power_morning_h equal_power_evening_h"
)
OF_AIRCRAFT = (TOTAL_MASS, BATTERY_ENERGY, AIRSPEED)
# What a sized design reaches in its worst scenario, and in each.
REACHED = (EXCESS_TIME, CHARGE_MARGIN, MINIMUM_CHARGE)
# Variables of a map, of trade studies and of maps of sized designs.
MAP = group(
    "excess_time_h minimum_state_of_charge charge_margin_h equal_power_morning_h "
    "equal_power_evening_h full_charge_h solar_energy_wh load_energy_wh day_length_h"
)
CHOSEN = (WINGSPAN, ASPECT_RATIO, BATTERY_MASS, MODULE_AREA)
DESIGN_COLUMNS = (*CHOSEN, PAYLOAD_MASS, PAYLOAD_POWER, TOTAL_MASS)
# Of a sized design; the last four where its propulsion is chosen.
SIZED = group(
    "wingspan_m aspect_ratio battery_mass_kg module_area_m2 total_mass_kg airspeed_m_per_s "
    "stall_speed_m_per_s wing_loading_kg_per_m2 climb_rate_m_per_s power_out_w "
    "propeller_diameter_m propeller_pitch_m gear_ratio motor_speed_constant_rpm_per_v"
)
