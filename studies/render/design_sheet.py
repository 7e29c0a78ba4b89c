"""Quantities of a design as one table, for a paper, a workbook, or a comparison of designs."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from missions.files.data_rows import data_rows
from sizing.aircraft import ParametricAirframe
from sizing.limits import QUANTITIES
from sizing.parameters import parameter, parameter_value
from sizing.results.analysis import Analysis
from sizing.results.result import data_frame
from studies import quantities as q

if TYPE_CHECKING:
    import pandas as pd


class Entry(NamedTuple):
    """Quantity of a design with its value, infinite if unlimited; ``group``: its table."""

    group: str
    quantity: q.Quantity
    value: float

    def shown(self) -> tuple[str, str]:
        """Return value and unit as people read them."""
        text, _, unit = self.quantity.fact(self.value)[1].replace(",", "").partition(" ")
        return text, unit


class DesignSheet(NamedTuple):
    """Quantities of a design on a mission.

    ``title``: aircraft and mission. ``notes``: model, correction and scenario of the energy.
    """

    title: str
    quantities: tuple[Entry, ...]
    notes: tuple[str, ...]

    def to_frame(self) -> pd.DataFrame:
        """Return the quantities as a pandas frame, all digits; the unit is ``1`` where none is."""
        rows = [
            (group, of.name, of.label, of.symbol, of.unit or "1", value)
            for group, of, value in self.quantities
        ]
        return data_frame(rows, ["group", "key", "label", "symbol", "unit", "value"])


def design_sheet(analysis: Analysis) -> DesignSheet:
    """Return the quantities of an aircraft on a mission, more of a parametric one."""
    aircraft, design = analysis.aircraft, analysis.design
    measured = not isinstance(aircraft.airframe, ParametricAirframe)  # in one part
    words = {"other": "airframe, propulsion, avionics"} if measured else {}
    values = analysis.scenario() | {each.name: each.of(design) for each in q.CHOSEN}
    values |= {each.name: each.of(analysis) for each in q.of_part("balance")}
    entries = []
    for row in data_rows("design_sheet", "studies"):
        group, key = row["group"], row["key"]
        if key == "parts":
            for name, mass in design.masses._asdict().items():
                label, symbol = f"mass: {words.get(name, q.words(name))}", rf"m_\mathrm{{{name}}}"
                part = q.Quantity(f"{name}_mass_kg", label, "kg", ".3f", symbol=symbol)
                entries += [Entry(group, part, float(mass))] if float(mass) > 0.0 else []
            continue
        value = values.get(key)
        if key in QUANTITIES and not (measured and row["parametric"]):
            value = QUANTITIES[key](design)
        elif "." in key:
            value = parameter_value(aircraft, None, key)
        if value is not None and not np.isnan(value):
            entries.append(Entry(group, _quantity(key), float(value)))
    title = f"{aircraft.name} on {analysis.mission.name}"
    note = f"Energy: {analysis.worst_scenario.label}; {analysis.performance.solar.label}."
    return DesignSheet(title, tuple(entries), (note,))


def _quantity(key: str) -> q.Quantity:
    """Return the quantity of a key; a parameter of the files with the digits that they give."""
    if key in q.TABLE:
        return q.TABLE[key]
    known = parameter(key)
    return q.Quantity(key, known.label, known.unit, "g", symbol=known.symbol)
