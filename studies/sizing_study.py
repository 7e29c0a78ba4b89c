"""Sizing of an aircraft for a mission: records, tables and the sized aircraft's own file."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any

from missions.mission import Mission
from missions.output_files import to_yaml
from missions.yaml_document import Document
from sizing.aircraft import Aircraft
from sizing.certificate import Certificate
from sizing.design import Design, DesignVariables
from sizing.optimiser import SizingResult
from sizing.performance import Performance
from sizing.sensitivity import Sensitivity
from solar._version import __version__
from studies.analysis import finite

if TYPE_CHECKING:
    import pandas as pd


def to_json(result: SizingResult, aircraft: Aircraft, mission: Mission) -> dict[str, Any]:
    """Result of a sizing, JSON-ready; what only an optimum has is null without one."""
    record: dict[str, Any] = {
        "status": result.status,
        "aircraft": aircraft.name,
        "mission": mission.name,
        "objective": {
            "name": result.objective.value,
            "value": result.objective_value,
            "required_excess_time_h": result.required_excess_time_h,
        },
        "active_constraints": list(result.active_constraints),
        "violated_requirements": [
            {"requirement": v.requirement, "shortfall": v.shortfall, "text": v.text}
            for v in result.violations
        ],
        "solver": {
            "iterations": result.solver.iterations,
            "time_s": result.solver.time_s,
            "build_time_s": result.solver.build_time_s,
            "solves": result.solver.solves,
            "message": result.solver.message,
        },
        "version": __version__,
    }
    record["nearest"] = None if result.nearest is None else _nearest_record(result.nearest)
    return record | _design_record(result.design) | _simulated_record(result.simulated)


def _nearest_record(perf: Performance) -> dict[str, Any]:
    """Design that comes closest to an infeasible requirement, and what it reaches."""
    worst = perf.worst_scenario()
    return {
        **{name: float(value) for name, value in perf.design.variables.chosen().items()},
        "total_mass_kg": finite(perf.design.total_mass_kg),
        "excess_time_h": finite(perf.cycle.excess_time_h[worst]),
        "worst_scenario": perf.day.scenarios.label(worst),
    }


def _design_record(design: Design | None) -> dict[str, Any]:
    if design is None:
        keys = (*DesignVariables._fields, "total_mass_kg", "masses_kg", "wing_area_m2")
        return dict.fromkeys((*keys, "airspeed_m_per_s", "propulsion_power_w"))
    return {
        **design.variables.chosen(),
        "total_mass_kg": design.total_mass_kg,
        "masses_kg": design.masses._asdict(),
        "wing_area_m2": design.wing_area_m2,
        "airspeed_m_per_s": design.airspeed_m_per_s,
        "propulsion_power_w": design.propulsion_power_w,
    }


def _simulated_record(perf: Performance | None) -> dict[str, Any]:
    if perf is None:
        return {"power_out_w": None, "worst_scenario": None, "simulated": None}
    worst = perf.worst_scenario()
    scenarios = perf.day.scenarios
    return {
        "power_out_w": float(perf.nominal_load_w.ravel()[0]),
        "worst_scenario": {
            "latitude_deg": float(scenarios.latitude_deg[worst]),
            "day_of_year": int(scenarios.day_of_year[worst]),
            "label": scenarios.label(worst),
        },
        "simulated": {
            "excess_time_h": finite(perf.cycle.excess_time_h[worst]),
            "charge_margin_h": finite(perf.cycle.charge_margin_h[worst]),
            "minimum_state_of_charge": finite(perf.cycle.minimum_state_of_charge[worst]),
            "total_mass_kg": float(perf.design.total_mass_kg),
            "model": perf.solar.model,
            "correction": perf.solar.correction,
        },
    }


def sensitivity_records(worth: list[Sensitivity]) -> list[dict[str, Any]]:
    """Sensitivities, JSON-ready, most important first."""
    return [
        {
            "parameter": s.parameter,
            "unit": s.unit,
            "value": s.value,
            "derivative": s.derivative,
            "elasticity": s.elasticity,
            "per_percent": s.per_percent,
        }
        for s in worth
    ]


def certificate_record(certificate: Certificate) -> dict[str, Any]:
    """Certificate, JSON-ready; a value that does not exist is null."""
    return {
        name: finite(value) if isinstance(value, float) else value
        for name, value in certificate.__dict__.items()
    }


def sensitivity_table(worth: list[Sensitivity]) -> pd.DataFrame:
    """Sensitivities, one row each, most important first."""
    import pandas as pd

    return pd.DataFrame(sensitivity_records(worth))


def scenario_table(perf: Performance) -> pd.DataFrame:
    """Metrics of a design in every scenario, one row each."""
    import pandas as pd

    scenarios, cycle = perf.day.scenarios, perf.cycle
    return pd.DataFrame(
        {
            "latitude_deg": scenarios.latitude_deg,
            "day_of_year": scenarios.day_of_year,
            "excess_time_h": cycle.excess_time_h,
            "charge_margin_h": cycle.charge_margin_h,
            "minimum_state_of_charge": cycle.minimum_state_of_charge,
            "solar_energy_wh": cycle.account.solar_wh,
            "load_energy_wh": cycle.account.load_wh,
        }
    )


def mass_table(design: Design) -> pd.DataFrame:
    """Mass budget, one row per item."""
    import pandas as pd

    masses = design.masses._asdict()
    return pd.DataFrame({"item": list(masses), "mass_kg": list(masses.values())})


def sized_document(document: Document, design: Design) -> dict[str, Any]:
    """Aircraft file's data with the sized design put in."""
    data: dict[str, Any] = copy.deepcopy(dict(document.data))
    data["name"] = f"{data['name']}-sized"
    data["airframe"]["wingspan_m"] = design.variables.wingspan_m
    data["airframe"]["aspect_ratio"] = design.variables.aspect_ratio
    data["battery"]["mass_kg"] = design.variables.battery_mass_kg
    data["modules"]["area_m2"] = design.variables.module_area_m2
    return data


def sized_yaml(document: Document, design: Design, result: SizingResult, mission: Mission) -> str:
    """Sized aircraft as a file that the other commands accept."""
    header = (
        f"# Sized by solar-uav {__version__} from {document.source} for the mission "
        f"{mission.name}.\n"
        f"# Objective: {result.objective.value}, required excess time "
        f"{result.required_excess_time_h:g} h.\n"
    )
    return header + to_yaml(sized_document(document, design))
