"""Sizing of an aircraft for a mission: records, tables and the sized aircraft's own file."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from missions.dates import date_code
from missions.files.writing import to_yaml
from missions.files.yaml import Document
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.analysis import finite
from sizing.design import Design, DesignVariables, FlightConditions
from sizing.limits import QUANTITIES, DesignInFlight
from sizing.optimisation.coverage import WidestRange, widest_range
from sizing.optimisation.cross_check import CrossCheck, cross_check
from sizing.optimisation.objectives import Objective
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.relaxations import Relaxation, relaxations
from sizing.optimisation.result import SizingResult, SizingStatus
from sizing.optimisation.search import size_aircraft
from sizing.optimisation.sensitivity import (
    ConstraintMultiplier,
    Sensitivity,
    constraint_multipliers,
    sensitivities,
)
from sizing.performance import (
    UNCORRECTED_CAM,
    Performance,
    SolarModel,
    performance_of_designs,
    solar_day,
)
from solar._version import __version__

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class SizingStudy:
    """A sizing and what was asked about it.

    ``band`` is the range of days or latitudes for the objectives that have one;
    ``relaxations`` exist for an infeasible sizing, ``worth`` and ``cross_check`` where they were
    asked for; ``as_assumed`` is the optimum without the mission's bands, where it has any.
    """

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    result: SizingResult
    band: WidestRange | None = None
    relaxations: tuple[Relaxation, ...] = ()
    worth: list[Sensitivity] | None = None
    multipliers: list[ConstraintMultiplier] | None = None
    cross_check: CrossCheck | None = None
    as_assumed: Performance | None = None

    def record(self) -> dict[str, Any]:
        """All of it, JSON-ready."""
        record = to_json(self.result, self.aircraft, self.mission)
        if self.band is not None:
            record["range"] = _range_record(self.band)
        if self.result.status is SizingStatus.infeasible:
            record["relaxations"] = [_relaxation_record(one) for one in self.relaxations]
        if self.worth is not None:
            record["sensitivities"] = sensitivity_records(self.worth)
        if self.multipliers is not None:
            record["constraint_multipliers"] = [dict(one.__dict__) for one in self.multipliers]
        if self.cross_check is not None:
            record["cross_check"] = cross_check_record(self.cross_check)
        if self.as_assumed is not None:
            record["as_assumed"] = _reached(self.as_assumed)
        return record


def size(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
    with_sensitivities: bool = False,
    with_cross_check: bool = False,
) -> SizingStudy:
    """Size an aircraft, and say what would help where that is infeasible."""
    problems = SizingProblems(aircraft)
    band = None
    if objective.of_range:
        band = widest_range(
            aircraft,
            mission,
            objective,
            solar,
            required_excess_time_h=required_excess_time_h,
            problems=problems,
        )
        result = band.sizing
    else:
        result = size_aircraft(
            aircraft,
            mission,
            objective,
            solar,
            required_excess_time_h=required_excess_time_h,
            problems=problems,
        )
    helpful: tuple[Relaxation, ...] = ()
    if result.status is SizingStatus.infeasible and not objective.of_range:
        helpful = tuple(relaxations(aircraft, mission, result, solar, problems=problems))
    asked = (aircraft, mission, result, solar)
    return SizingStudy(
        *(aircraft, mission, solar, result, band, helpful),
        worth=sensitivities(*asked) if with_sensitivities and result.feasible else None,
        multipliers=constraint_multipliers(result)
        if with_sensitivities and result.feasible
        else None,
        cross_check=cross_check(*asked) if with_cross_check and result.feasible else None,
        as_assumed=_as_assumed(aircraft, mission, result, solar),
    )


def _as_assumed(
    aircraft: Aircraft, mission: Mission, result: SizingResult, solar: SolarModel
) -> Performance | None:
    """Optimum without the mission's bands; None where the mission has none."""
    if result.design is None or result.simulated is None or not mission.bands.given:
        return None
    plain = mission.without_bands()
    day = solar_day(aircraft, plain, solar, scenarios=result.simulated.day.scenarios)
    return performance_of_designs(aircraft, plain, result.design.variables, solar, day=day)


def to_json(result: SizingResult, aircraft: Aircraft, mission: Mission) -> dict[str, Any]:
    """Result of a sizing, JSON-ready; what only an optimum has is null without one."""
    record: dict[str, Any] = {
        "status": result.status.name,
        "aircraft": aircraft.name,
        "mission": mission.name,
        "objective": {
            "name": result.objective.value,
            "value": None if result.objective_value is None else finite(result.objective_value),
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
    record["quantities"] = None
    if result.design is not None:
        conditions = FlightConditions.of(mission).with_payload_of(result.design.variables)
        flown = DesignInFlight(aircraft, result.design, conditions)
        record["quantities"] = {name: float(of(flown)) for name, of in QUANTITIES.items()}
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
        **design.variables._asdict(),
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
            **_reached(perf),
            "total_mass_kg": float(perf.design.total_mass_kg),
            "model": perf.solar.model,
            "correction": perf.solar.correction,
        },
    }


def _reached(perf: Performance) -> dict[str, Any]:
    """What a design reaches in its worst scenario."""
    worst = perf.worst_scenario()
    return {
        "excess_time_h": finite(perf.cycle.excess_time_h[worst]),
        "charge_margin_h": finite(perf.cycle.charge_margin_h[worst]),
        "minimum_state_of_charge": finite(perf.cycle.minimum_state_of_charge[worst]),
    }


def _range_record(band: WidestRange) -> dict[str, Any]:
    season = band.sizing.objective is Objective.longest_season
    first, last = band.first, band.last
    if season and first is not None and last is not None:
        ends = {"from": date_code(int(first)), "to": date_code(int(last))}
        return {**ends, "days": int(band.extent)}
    return {"from_deg": first, "to_deg": last, "width_deg": band.extent}


def _relaxation_record(one: Relaxation) -> dict[str, Any]:
    return {**_strict(one.__dict__), "text": one.text}


def sensitivity_records(worth: list[Sensitivity]) -> list[dict[str, Any]]:
    """Sensitivities, JSON-ready, most important first."""
    return [_strict({**s.__dict__, "per_percent": s.per_percent}) for s in worth]


def cross_check_record(check: CrossCheck) -> dict[str, Any]:
    """Cross-check, JSON-ready; a value that does not exist is null."""
    return _strict(check.__dict__)


def _strict(record: Mapping[str, Any]) -> dict[str, Any]:
    """Record with null for numbers that are infinite or not defined."""
    return {
        name: finite(value) if isinstance(value, float) else value for name, value in record.items()
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
    if design.variables.lift_coefficient is not None:
        data["airframe"]["aerodynamics"]["lift_coefficient"] = design.variables.lift_coefficient
    return data


def sized_mission(mission: Mission, design: Design) -> Mission:
    """Mission with the payload that the design carries."""
    payload = mission.payload.model_copy(
        update={
            "mass_kg": design.masses.payload,
            "power_w": design.variables.payload_power_w or mission.payload.power_w,
        }
    )
    return mission.model_copy(update={"payload": payload})


def sized_yaml(document: Document, design: Design, result: SizingResult, mission: Mission) -> str:
    """Sized aircraft as a file that the other commands accept."""
    carried = sized_mission(mission, design).payload
    header = (
        f"# Sized by solar-uav {__version__} from {document.source} for the mission "
        f"{mission.name}.\n"
        f"# Objective: {result.objective.value}, required excess time "
        f"{result.required_excess_time_h:g} h.\n"
        f"# Payload, to be set on the mission: {carried.mass_kg:.6g} kg, {carried.power_w:.6g} W.\n"
    )
    return header + to_yaml(sized_document(document, design))
