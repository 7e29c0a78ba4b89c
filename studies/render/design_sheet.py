"""Quantities of a design as one table, for a paper, a workbook, or a comparison of designs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import isnan
from typing import TYPE_CHECKING, Any

from sizing.aircraft import ParametricAirframe
from sizing.limits import QUANTITIES, DesignInFlight
from sizing.parameters import catalogue, parameter, parameter_value, unit_text
from sizing.results.analysis import Analysis
from sizing.results.result import data_frame
from studies import quantities as q
from studies.render.tables import MISSING, Column, Table
from studies.serialise import serialise

if TYPE_CHECKING:
    import pandas as pd

_GEOMETRY = (q.WINGSPAN.name, "aspect_ratio", "wing_area_m2", "chord_m", "module_area_m2",
             "module_coverage")  # fmt: skip
_FLIGHT = ("airspeed_m_per_s", "lift_coefficient", "reynolds_number", "stall_speed_m_per_s",
           "climb_rate_m_per_s")  # fmt: skip
_POWER = ("propulsion_power_w", "rated_power_w", "load_w")
_STORAGE = ("battery_energy_wh", "cruise_discharge_rate_per_h")
_MASS_LABELS = {"mppt": ("MPPT", r"m_\mathrm{mppt}"), "other": ("other", r"m_\mathrm{other}")}
_TECHNOLOGY = (
    "modules.efficiency_stc",
    "modules.mppt_efficiency",
    "modules.mass_kg_per_m2",
    "battery.specific_energy_wh_per_kg",
    "battery.charge_efficiency",
    "battery.discharge_efficiency",
)


@dataclass(frozen=True)
class Entry:
    """Quantity of a design with its value.

    ``group``: ``geometry``, ``masses``, ``balance``, ``flight``, ``power``, ``energy`` or
    ``technology``. ``key``: name in files and JSON, with its unit. ``label``: words. ``symbol``:
    LaTeX, empty without. ``unit``: ``1`` without. ``value``: None if the aircraft has none,
    infinite if unlimited.
    """

    group: str
    key: str
    label: str
    symbol: str
    unit: str
    value: float | str | None

    def shown(self) -> tuple[str, str]:
        """Return value and unit as people read them: in the form of the table of quantities.

        Other results have four digits, inputs as many as they were given.
        """
        known = q.TABLE.get(self.key)
        if known is not None:
            text, _, unit = known.fact(self.value)[1].replace(",", "").partition(" ")
            return text, unit
        if self.group == "technology" and isinstance(self.value, float):
            return f"{self.value:g}", unit_text(self.unit)
        return number_text(self.value), unit_text(self.unit)


@dataclass(frozen=True)
class DesignSheet:
    """Quantities of a design on a mission.

    ``title``: aircraft and mission. ``notes``: model, correction and scenario of the energy.
    """

    title: str
    quantities: tuple[Entry, ...]
    notes: tuple[str, ...]

    def table(self) -> Table:
        """Return a table for people, with a line between the groups."""
        columns = (Column("quantity"), Column("value", to_right=True), Column("unit"))
        rows = tuple((entry.label, *entry.shown()) for entry in self.quantities)
        sections = group_starts(self.quantities)
        return Table(self.title, columns, rows, self.notes, sections=sections)

    def to_frame(self) -> pd.DataFrame:
        """Return the quantities as a pandas frame, all digits."""
        return data_frame([vars(quantity) for quantity in self.quantities])

    def to_dict(self) -> dict[str, Any]:
        """Return values by key, JSON-ready."""
        record: dict[str, Any] = serialise({entry.key: entry.value for entry in self.quantities})
        return record


def group_starts(entries: Sequence[Entry]) -> tuple[int, ...]:
    """Return the indices at which a new group begins, except the first."""
    pairs = enumerate(pairwise(entries), start=1)
    return tuple(place for place, (entry, following) in pairs if entry.group != following.group)


def design_sheet(analysis: Analysis) -> DesignSheet:
    """Return the quantities of an aircraft on a mission."""
    worst = analysis.performance.day.scenarios.label(analysis.worst)
    solar, aircraft = analysis.performance.solar, analysis.aircraft
    values = analysis.scenario()
    energy = ((quantity, float(values[quantity.name])) for quantity in q.SHEET_ENERGY)
    technology = ((catalogue()[k], parameter_value(aircraft, None, k)) for k in _TECHNOLOGY)
    quantities = (
        *_of_catalogue("geometry", _GEOMETRY, analysis),
        *_masses(analysis),
        *_balance(analysis),
        *_of_catalogue("flight", _FLIGHT, analysis),
        *_of_catalogue("power", _POWER, analysis),
        *_of_catalogue("energy", _STORAGE, analysis),
        *(
            _entry("energy", quantity, None if isnan(value) else value)
            for quantity, value in energy
        ),
        *(Entry("technology", p.key, p.label, p.symbol, p.unit, value) for p, value in technology),
    )
    notes = (f"Energy: {worst}; {solar.label}.",)
    return DesignSheet(
        f"{analysis.aircraft.name} on {analysis.mission.name}",
        tuple(entry for entry in quantities if entry.value is not None),
        notes,
    )


def number_text(value: float | str | None) -> str:
    """Return a value with four significant digits, if possible without an exponent."""
    if value is None:
        return MISSING
    if isinstance(value, str):
        return value
    if not abs(value) < float("inf"):
        return "unlimited"
    if abs(value) >= 1e4:
        return f"{value:.0f}" if abs(value) < 1e7 else f"{value:.4g}"
    return f"{value:#.4g}".rstrip(".") if abs(value) >= 1e-3 or value == 0.0 else f"{value:.4g}"


def _of_catalogue(group: str, names: tuple[str, ...], analysis: Analysis) -> list[Entry]:
    """Return quantities that the catalogue of parameters describes."""
    values = _values(analysis)
    known = [(parameter(name), values.get(name)) for name in names]
    return [Entry(group, p.name, p.label, p.symbol, p.unit, value) for p, value in known]


def _values(analysis: Analysis) -> dict[str, float | None]:
    """Return quantities of the design by name, more for a parametric aircraft."""
    aircraft, design = analysis.aircraft, analysis.performance.design
    known = (*q.CHOSEN, q.WING_AREA, q.AIRSPEED, q.PROPULSION_POWER, q.BATTERY_ENERGY)
    values = {quantity.name: _as_float(quantity.of(design)) for quantity in known}
    load_w, area_m2 = float(design.nominal_load_w(analysis.mission)), float(design.wing_area_m2)
    values |= {
        "chord_m": area_m2 / float(design.variables.wingspan_m),
        "module_coverage": float(design.variables.module_area_m2) / area_m2,
        "load_w": load_w,
        "cruise_discharge_rate_per_h": load_w / float(design.battery_energy_wh),
    }
    if isinstance(aircraft.airframe, ParametricAirframe):
        flight = DesignInFlight(aircraft, design)
        names = (*_FLIGHT, *_POWER)
        values |= {name: _as_float(QUANTITIES[name](flight)) for name in names}  # type: ignore[index]  # all are quantities
    return values


def _as_float(value: Any) -> float | None:
    return None if value is None else float(value)


def _masses(analysis: Analysis) -> list[Entry]:
    """Return the parts of the mass above zero, and the total mass."""
    design = analysis.performance.design
    measured = not isinstance(analysis.aircraft.airframe, ParametricAirframe)
    masses = []
    for name, mass in design.masses._asdict().items():
        text, symbol = _MASS_LABELS.get(name, (name, rf"m_\mathrm{{{name}}}"))
        if measured and name == "other":
            text = "airframe, propulsion, avionics"
        if float(mass) > 0.0:
            masses.append(
                Entry("masses", f"{name}_mass_kg", f"mass: {text}", symbol, "kg", float(mass))
            )
    mass_kg = float(design.total_mass_kg)
    values = ((q.TOTAL_MASS, mass_kg), (q.WING_LOADING, mass_kg / float(design.wing_area_m2)))
    return [*masses, *(_entry("masses", quantity, value) for quantity, value in values)]


def _balance(analysis: Analysis) -> list[Entry]:
    """Return centre of gravity, neutral point and static margin, empty without a balance."""
    balance = analysis.balance
    if balance is None:
        return []
    place = "behind the leading edge of the wing root"
    values = (
        ("centre_of_gravity_m", f"centre of gravity {place}", "x_g", "m", balance.gravity_m),
        ("neutral_point_m", f"neutral point {place}", "x_n", "m", float(balance.neutral_point.x_m)),
        ("static_margin", "static margin", r"\sigma_s", "1", balance.static_margin),
    )
    return [Entry("balance", *row) for row in values]


def _entry(group: str, quantity: q.Quantity, value: float | None) -> Entry:
    return Entry(group, quantity.name, quantity.label, quantity.symbol, quantity.unit or "1", value)
