"""Quantities of a design as one table: for a paper, a workbook, or beside another design."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sizing.aircraft import ParametricAirframe
from sizing.design import FlightConditions
from sizing.limits import QUANTITIES, DesignInFlight
from sizing.parameters import catalogue, parameter, parameter_value
from sizing.results.analysis import Analysis
from sizing.results.records import finite_values
from sizing.results.tables import MISSING, Column, Table

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["DesignSheet", "Quantity", "design_sheet"]

_GEOMETRY = ("wingspan_m", "aspect_ratio", "wing_area_m2", "chord_m", "module_area_m2",
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
class Quantity:
    """A quantity of a design.

    ``group``: what it is about: ``geometry``, ``masses``, ``flight``, ``power``, ``energy`` or
    ``technology``. ``key``: name in files and JSON, with its unit. ``label``, ``symbol``, ``unit``:
    in words; in LaTeX, empty where there is none; ``1`` for no unit. ``value``: none where the
    aircraft has none; infinite where it is unlimited.
    """

    group: str
    key: str
    label: str
    symbol: str
    unit: str
    value: float | str | None

    def text(self) -> str:
        """Value as people read it: results with four digits, inputs as they were given."""
        if self.group == "technology" and isinstance(self.value, float):
            return f"{self.value:g}"
        return number_text(self.value)


@dataclass(frozen=True)
class DesignSheet:
    """A design on a mission, quantity by quantity.

    ``title``: aircraft and mission. ``notes``: model, correction and scenario that the energy
    belongs to.
    """

    title: str
    quantities: tuple[Quantity, ...]
    notes: tuple[str, ...]

    def table(self) -> Table:
        """Table for people, with a line between the groups."""
        columns = (Column("quantity"), Column("value", to_right=True), Column("unit"))
        rows = tuple((q.label, q.text(), unit_text(q.unit)) for q in self.quantities)
        groups = [q.group for q in self.quantities]
        lines = tuple(i for i in range(1, len(groups)) if groups[i] != groups[i - 1])
        return Table(self.title, columns, rows, self.notes, sections=lines)

    def to_frame(self) -> pd.DataFrame:
        """Quantities as a pandas frame, all digits."""
        import pandas as pd

        return pd.DataFrame([vars(quantity) for quantity in self.quantities])

    def to_dict(self) -> dict[str, Any]:
        """Values by key, JSON-ready."""
        return finite_values({q.key: q.value for q in self.quantities})


def design_sheet(analysis: Analysis) -> DesignSheet:
    """Quantities of an aircraft on a mission."""
    worst = analysis.performance.day.scenarios.label(analysis.worst)
    solar = analysis.performance.solar
    quantities = (
        *_of_catalogue("geometry", _GEOMETRY, analysis),
        *_masses(analysis),
        *_of_catalogue("flight", _FLIGHT, analysis),
        *_of_catalogue("power", _POWER, analysis),
        *_of_catalogue("energy", _STORAGE, analysis),
        *_energy(analysis),
        *_technology_quantities(analysis),
    )
    notes = (f"Energy: {worst}; {solar.model}, correction: {solar.correction}.",)
    return DesignSheet(
        f"{analysis.aircraft.name} on {analysis.mission.name}",
        tuple(q for q in quantities if q.value is not None),
        notes,
    )


def number_text(value: float | str | None) -> str:
    """Value with four significant digits, without an exponent where it can be."""
    if value is None:
        return MISSING
    if isinstance(value, str):
        return value
    if not abs(value) < float("inf"):
        return "unlimited"
    if abs(value) >= 1e4:
        return f"{value:.0f}" if abs(value) < 1e7 else f"{value:.4g}"
    return f"{value:#.4g}".rstrip(".") if abs(value) >= 1e-3 or value == 0.0 else f"{value:.4g}"


def unit_text(unit: str) -> str:
    """Unit as people read it; empty for a number without one."""
    return "" if unit == "1" else unit.replace("m2", "m²").replace("m3", "m³")


def _of_catalogue(group: str, names: tuple[str, ...], analysis: Analysis) -> list[Quantity]:
    """Quantities that the catalogue of parameters knows."""
    values = _values(analysis)
    known = [(parameter(name), values.get(name)) for name in names]
    return [Quantity(group, p.name, p.label, p.symbol, p.unit, value) for p, value in known]


def _values(analysis: Analysis) -> dict[str, float | None]:
    """Quantities of the design by name; those that only a parametric aircraft has are left out."""
    aircraft, design = analysis.aircraft, analysis.performance.design
    load_w = float(design.nominal_load_w(analysis.mission))
    span, area = float(design.variables.wingspan_m), float(design.wing_area_m2)
    values: dict[str, float | None] = {
        "wingspan_m": span,
        "aspect_ratio": float(design.variables.aspect_ratio),
        "wing_area_m2": area,
        "chord_m": area / span,
        "module_area_m2": float(design.variables.module_area_m2),
        "module_coverage": float(design.variables.module_area_m2) / area,
        "airspeed_m_per_s": _number(design.airspeed_m_per_s),
        "propulsion_power_w": float(design.propulsion_power_w),
        "load_w": load_w,
        "battery_energy_wh": float(design.battery_energy_wh),
        "cruise_discharge_rate_per_h": load_w / float(design.battery_energy_wh),
    }
    if isinstance(aircraft.airframe, ParametricAirframe):
        it = DesignInFlight(aircraft, design, FlightConditions.of(analysis.mission, aircraft))
        names = (*_FLIGHT, *_POWER)
        values |= {name: _number(QUANTITIES[name](it)) for name in names}  # type: ignore[index]  # all are quantities
    return values


def _number(value: Any) -> float | None:
    return None if value is None else float(value)


def _masses(analysis: Analysis) -> list[Quantity]:
    """Parts of the mass that there are, and their sum."""
    design = analysis.performance.design
    measured = not isinstance(analysis.aircraft.airframe, ParametricAirframe)
    found = []
    for name, mass in design.masses._asdict().items():
        text, symbol = _MASS_LABELS.get(name, (name, rf"m_\mathrm{{{name}}}"))
        if measured and name == "other":
            text = "airframe, propulsion, avionics"
        if float(mass) > 0.0:
            found.append(
                Quantity("masses", f"{name}_mass_kg", f"mass: {text}", symbol, "kg", float(mass))
            )
    total, loading = parameter("total_mass_kg"), parameter("wing_loading_kg_per_m2")
    mass_kg = float(design.total_mass_kg)
    values = ((total, mass_kg), (loading, mass_kg / float(design.wing_area_m2)))
    return [*found, *(Quantity("masses", p.name, p.label, p.symbol, p.unit, v) for p, v in values)]


def _energy(analysis: Analysis) -> list[Quantity]:
    """Metrics of the worst scenario."""
    cycle, worst = analysis.performance.cycle, analysis.worst
    endurance = analysis.endurances[worst]
    rows: tuple[tuple[str, str, str, str, float | None], ...] = (
        ("solar_energy_wh", "solar energy of the day", r"E_\mathrm{solar}", "Wh",
         float(cycle.energy_budget.solar_wh[worst])),
        ("excess_time_h", "excess time", r"T_\mathrm{exc}", "h",
         _defined(cycle.excess_time_h[worst])),
        ("charge_margin_h", "charge margin", r"T_\mathrm{cm}", "h",
         _defined(cycle.charge_margin_h[worst])),
        ("minimum_state_of_charge", "minimum state of charge", r"\mathit{SoC}_\mathrm{min}", "1",
         float(cycle.minimum_state_of_charge[worst])),
        ("endurance_h", "endurance", r"T_\mathrm{endur}", "h",
         float("inf") if endurance is None else float(endurance.endurance_h)),
    )  # fmt: skip
    return [Quantity("energy", *row) for row in rows]


def _defined(value: Any) -> float | None:
    number = float(value)
    return None if number != number else number


def _technology_quantities(analysis: Analysis) -> list[Quantity]:
    known = [catalogue()[key] for key in _TECHNOLOGY]
    return [
        Quantity("technology", p.key, p.label, p.symbol, p.unit,
                 parameter_value(analysis.aircraft, None, p.key))
        for p in known
    ]  # fmt: skip
