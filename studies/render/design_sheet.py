"""Quantities of a design as one table, for a paper, a workbook, or a comparison of designs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sizing.aircraft import ParametricAirframe
from sizing.limits import QUANTITIES
from sizing.parameters import parameter, parameter_value
from sizing.results.analysis import Analysis
from sizing.results.result import data_frame
from studies import quantities as q

if TYPE_CHECKING:
    import pandas as pd

_MASSES = "masses"
# Keys of each group, in the order of the sheet; the parts of the mass come first in theirs.
_GROUPS = {
    "geometry": "wingspan_m aspect_ratio wing_area_m2 chord_m module_area_m2 module_coverage",
    _MASSES: "total_mass_kg wing_loading_kg_per_m2",
    "balance": "centre_of_gravity_m neutral_point_m static_margin",
    "flight": """
        airspeed_m_per_s lift_coefficient reynolds_number stall_speed_m_per_s climb_rate_m_per_s
        """,
    "power": "propulsion_power_w rated_power_w load_w",
    "energy": """
        battery_energy_wh cruise_discharge_rate_per_h solar_energy_wh excess_time_h charge_margin_h
        minimum_state_of_charge endurance_h
        """,
    "technology": """
        modules.efficiency_stc modules.mppt_efficiency modules.mass_kg_per_m2
        battery.specific_energy_wh_per_kg battery.charge_efficiency battery.discharge_efficiency
        """,
}
# What is known without a structure and a polar.
_OF_MEASURED = """
    total_mass_kg battery_energy_wh wing_area_m2 chord_m module_coverage wing_loading_kg_per_m2
    airspeed_m_per_s propulsion_power_w load_w cruise_discharge_rate_per_h
    """


@dataclass(frozen=True)
class Entry:
    """Quantity of a design with its value, infinite if unlimited; ``group``: its table."""

    group: str
    quantity: q.Quantity
    value: float

    def shown(self) -> tuple[str, str]:
        """Return value and unit as people read them."""
        text, _, unit = self.quantity.fact(self.value)[1].replace(",", "").partition(" ")
        return text, unit


@dataclass(frozen=True)
class DesignSheet:
    """Quantities of a design on a mission.

    ``title``: aircraft and mission. ``notes``: model, correction and scenario of the energy.
    """

    title: str
    quantities: tuple[Entry, ...]
    notes: tuple[str, ...]

    def to_frame(self) -> pd.DataFrame:
        """Return the quantities as a pandas frame, all digits; the unit is ``1`` where none is."""
        rows = (
            (e.group, of.name, of.label, of.symbol, of.unit or "1", e.value)
            for e in self.quantities
            for of in [e.quantity]
        )
        return data_frame(list(rows), ["group", "key", "label", "symbol", "unit", "value"])


def design_sheet(analysis: Analysis) -> DesignSheet:
    """Return the quantities of an aircraft on a mission, more of a parametric one."""
    aircraft, design = analysis.aircraft, analysis.design
    measured = not isinstance(aircraft.airframe, ParametricAirframe)  # in one part
    words = {"other": "airframe, propulsion, avionics"} if measured else {}
    masses = {
        q.Quantity(
            f"{name}_mass_kg",
            f"mass: {words.get(name, q.words(name))}",
            "kg",
            ".3f",
            symbol=rf"m_\mathrm{{{name}}}",
        ): float(mass)
        for name, mass in design.masses._asdict().items()
        if float(mass) > 0.0
    }
    values = analysis.scenario() | {part.name: mass_kg for part, mass_kg in masses.items()}
    values |= {each.name: each.of(design) for each in q.CHOSEN}
    values |= {each.name: each.of(analysis) for each in q.of_part("balance")}
    known = _OF_MEASURED.split() if measured else list(QUANTITIES)
    values |= {key: of(design) for key, of in QUANTITIES.items() if key in known}
    technology = _GROUPS["technology"].split()
    values |= {key: parameter_value(aircraft, None, key) for key in technology}
    keys = {group: list(map(_quantity, keys.split())) for group, keys in _GROUPS.items()}
    keys[_MASSES] = [*masses, *keys[_MASSES]]
    entries = (
        Entry(group, quantity, float(value))
        for group, quantities in keys.items()
        for quantity in quantities
        if (value := values.get(quantity.name)) is not None and not np.isnan(value)
    )
    return DesignSheet(
        f"{aircraft.name} on {analysis.mission.name}",
        tuple(entries),
        (f"Energy: {analysis.worst_scenario.label}; {analysis.performance.solar.label}.",),
    )


def _quantity(key: str) -> q.Quantity:
    """Return the quantity of a key; a parameter of the files with the digits that they give."""
    if key in q.TABLE:
        return q.TABLE[key]
    known = parameter(key)
    return q.Quantity(key, known.label, known.unit, "g", symbol=known.symbol)
