"""A sizing and what was asked about it, with its record."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from missions.dates import date_code
from missions.files.texts import texts_as_read
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.balance.assessment import BalanceAssessment, balance_assessment
from sizing.climb import ClimbPerformance, beside_constant
from sizing.day.light import SolarModel
from sizing.design import Design, DesignVariables, Masses
from sizing.limits import QUANTITIES, DesignInFlight
from sizing.mass_budget import parametric_design
from sizing.performance import Performance
from sizing.program.cross_check import CrossCheck
from sizing.program.objectives import Objective
from sizing.program.ranges import WidestRange
from sizing.program.reliability import Reliability
from sizing.program.result import SizingResult, SizingStatus
from sizing.program.sensitivity import ConstraintMultiplier, Sensitivity
from sizing.program.whole_cells import WholeCells
from sizing.relaxed_flight import Relaxation
from sizing.results import quantities as q
from sizing.results.conditions import battery_record, climbs_record, level_record, wind_record
from sizing.results.notes import extrapolation_records, relaxation_records, source_records
from sizing.results.parts import sized_data, sizing_record
from sizing.results.propulsion import PartMasses, PowerBudget, part_masses, power_budget
from sizing.results.qualities import BuiltDesign
from sizing.results.records import NEGLIGIBLE, finite, finite_values, uncertainty_record
from sizing.results.requirements import RequirementMargin, margin_records, requirement_margins
from sizing.results.season import Survival
from sizing.results.tables import Result, data_frame
from sizing.sized_structure import structure_assessment
from sizing.structures.assessment import StructureAssessment
from sizing.validity.checks import record_check, stall_margin_within_polar
from sizing.validity.extrapolations import extrapolations, told, with_worth
from sizing.validity.ranges import Extrapolation
from solar.versions import software_record

if TYPE_CHECKING:
    import pandas as pd


T = TypeVar("T")


@dataclass(frozen=True, repr=False, eq=False)
class SizingStudy(Result):
    """A sizing and what was asked about it.

    Attributes
    ----------
    aircraft, mission, solar
        What was sized, for what, and by which solar power model.
    result : SizingResult
        Optimum, or the requirements that cannot be met.
    low, high : Performance or None
        Optimum with the solar power one RMS error of the model lower and higher.
    coverage : WidestRange or None
        Range of days or latitudes, for the objectives that have one.
    relaxations : tuple
        Single changes that would make an infeasible sizing feasible.
    sensitivities, multipliers : list or None
        What parameters and constraints are worth at the optimum, where asked for.
    cross_check : CrossCheck or None
        Optimality cross-check by simulation, where asked for.
    without_margins : Performance or None
        Optimum without the mission's uncertainty margins, where it has any.
    with_margin : SizingStudy or None
        Sizing that keeps the requirement with one RMS error less solar power, where asked for.
    reliability : Reliability or None
        Probability of the required excess time, where one was asked for.
    survival : Survival or None
        Days of a weather record's season that the design closes, where it was sized for them.
    whole_cells : WholeCells or None
        Designs of whole cells, the relaxed optimum and the loss, where they were asked for; the
        aircraft is then that with the cells of the best design.
    without_climbs : SizingResult or None
        Sizing for level flight at the night's floor, on a mission with climbs.
    builds : tuple of BuiltDesign
        Best design of each class of building, where asked for.
    """

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    result: SizingResult
    low: Performance | None = None
    high: Performance | None = None
    coverage: WidestRange | None = None
    relaxations: tuple[Relaxation, ...] = ()
    sensitivities: list[Sensitivity] | None = field(default=None)
    multipliers: list[ConstraintMultiplier] | None = field(default=None)
    cross_check: CrossCheck | None = None
    without_margins: Performance | None = None
    with_margin: SizingStudy | None = None
    reliability: Reliability | None = None
    survival: Survival | None = None
    whole_cells: WholeCells | None = None
    without_climbs: SizingResult | None = None
    builds: tuple[BuiltDesign, ...] = ()

    renderer = "sizing.results.sizing_summary"

    wingspan_m = q.attribute_of_design(q.WINGSPAN)
    battery_mass_kg = q.attribute_of_design(q.BATTERY_MASS)
    module_area_m2 = q.attribute_of_design(q.MODULE_AREA)
    total_mass_kg = q.attribute_of_design(q.TOTAL_MASS)

    @property
    def excess_time_h(self) -> float:
        """Excess time of the optimum in its worst scenario [h]; NaN without one."""
        flown = self.result.simulated
        return math.nan if flown is None else float(np.min(flown.cycle.excess_time_h))

    @property
    def status(self) -> SizingStatus:
        """How the sizing ended: ``optimal``, ``infeasible`` or ``not_converged``."""
        return self.result.status

    @property
    def feasible(self) -> bool:
        """Whether an optimum was found."""
        return self.result.feasible

    @property
    def objective(self) -> Objective:
        """What was optimised."""
        return self.result.objective

    @property
    def design(self) -> Design | None:
        """Masses and power of the optimum."""
        return self.result.design

    @property
    def variables(self) -> DesignVariables | None:
        """Wingspan, aspect ratio, battery mass, module area ... of the optimum."""
        return None if self.result.design is None else self.result.design.variables

    def sized_aircraft(self) -> Aircraft:
        """Aircraft with the optimum put in, ready to be analysed or written to a file.

        Raises
        ------
        ValueError
            Where no optimum was found.
        """
        with texts_as_read(self.aircraft.texts_read):
            data = sized_data(self.aircraft, self._optimum(), self.whole_cells is not None)
            return Aircraft.model_validate(data)

    def sized_mission(self) -> Mission:
        """Mission with the payload that the optimum carries, at the altitudes chosen for it.

        Raises
        ------
        ValueError
            Where no optimum was found.
        """
        design = self._optimum()
        power_w = design.variables.payload_power_w or self.mission.payload.power_w
        # What a solver leaves of a payload that is none is no payload.
        carried = {
            key: value if value > NEGLIGIBLE else 0.0
            for key, value in (("mass_kg", design.masses.payload), ("power_w", power_w))
        }
        payload = self.mission.payload.model_copy(update=carried)
        return self.mission.model_copy(update={"payload": payload})

    def _optimum(self) -> Design:
        if self.result.design is None:
            raise ValueError(f"the sizing is {self.status.label}: it has no design")
        return self.result.design

    @cached_property
    def structure(self) -> StructureAssessment | None:
        """What sizes the structure of the optimum, or else of the nearest design.

        None where the structure's model does not say, or no design could be simulated. A design
        that no mass closes is taken at twice the mass of all but its structure and propulsion.
        """
        nearest = self.result.nearest
        design = self.result.design or (None if nearest is None else nearest.design)
        if design is None:
            return None
        if not np.isfinite(design.total_mass_kg):
            carried_kg = float(sum(design.masses[2:], 0.0))
            design = parametric_design(
                self.aircraft, self.mission, design.variables.mapped(float), 2.0 * carried_kg
            )
        return structure_assessment(self.aircraft, design)

    @cached_property
    def part_masses(self) -> PartMasses | None:
        """Masses of the optimum's propulsion that are estimated; None where there are none."""
        return None if self.design is None else part_masses(self.aircraft, self.design)

    @cached_property
    def power_budget(self) -> PowerBudget | None:
        """Where the optimum's power of level flight goes; None without one."""
        design = self.result.design
        return None if design is None else power_budget(self.aircraft, self.mission, design)

    @cached_property
    def climbs(self) -> ClimbPerformance | None:
        """Optimum on a mission with climbs; None without one, or them."""
        flown = self.result.simulated
        if flown is None or flown.mission.climb is None:
            return None
        return beside_constant(self.aircraft, flown, flown.design, flown.day)

    @cached_property
    def balance(self) -> BalanceAssessment | None:
        """Balance of the optimum; None without one, or without ``airframe.balance``."""
        design = self.result.design
        return None if design is None else balance_assessment(self.aircraft, design)

    @cached_property
    def extrapolations(self) -> tuple[Extrapolation, ...]:
        """What the optimum takes from outside the range of a model.

        Where excess time alone is missing, what the nearest design takes, which flies all the same.
        """
        result, flight = self.result, self.result.simulated
        if flight is None and all(one.requirement == "excess_time" for one in result.violations):
            flight = result.nearest
        if flight is None:
            return ()
        notes = extrapolations(self.aircraft, flight)
        if self.survival is not None:
            site = self.survival.weather.site
            notes += told([record_check(self.survival.mission, site.altitude_m)])
        return with_worth(notes, self.aircraft, lambda: flight)

    def to_dict(self) -> dict[str, Any]:
        """All of it, JSON-ready; what only an optimum has is null without one."""
        result, infeasible = self.result, self.status is SizingStatus.infeasible
        record = _result_record(result, self.aircraft, self.mission) | {
            "quantities": self.quantities,
            "margins": margin_records(self.margins),
            **_design_record(result.design),
            **_simulated_record(result.simulated),
        }
        low, high = (None, None) if result.simulated is None else (self.low, self.high)
        parts = {
            "power_budget": _of(self.power_budget, PowerBudget.to_dict),
            "part_masses": _of(self.part_masses, PartMasses.to_dict),
            "structure": _of(self.structure, StructureAssessment.to_dict),
            "balance": _of(self.balance, BalanceAssessment.to_dict),
            "model": self.solar.model,
            "correction": self.solar.correction,
            "wind": wind_record(self.mission),
            "uncertainty": None if low is None or high is None else uncertainty_record(low, high),
            "extrapolations": extrapolation_records(self.extrapolations),
            **source_records(self.aircraft, self.mission),
            "range": _of(self.coverage, _range_record),
            "relaxations": _of(self.relaxations if infeasible else None, relaxation_records),
            "sensitivities": _of(self.sensitivities, sensitivity_records),
            "constraint_multipliers": _of(self.multipliers, lambda m: [dict(vars(o)) for o in m]),
            "cross_check": _of(self.cross_check, lambda check: finite_values(vars(check))),
            "with_margin": _of(self.with_margin, _margin_record),
            "as_assumed": _of(self.without_margins, lambda p: q.worst_record(p, q.REACHED)),
            "reliability": _of(self.reliability, lambda one: finite_values(one.to_dict())),
            "weather": _of(self.survival, Survival.to_dict),
            "whole_cells": _of(self.whole_cells, lambda o: sizing_record(o, self.aircraft)),
            "climb": _of(self.climbs, lambda one: climbs_record(one, self.mission)),
            "without_climbs": _of(self.without_climbs, level_record),
            "builds": [one.to_dict() for one in self.builds] or None,
        }
        always = ("power_budget", "structure", "uncertainty")
        return record | {k: one for k, one in parts.items() if one is not None or k in always}

    @cached_property
    def quantities(self) -> dict[str, float] | None:
        """Quantities that may be bounded; outside of the airfoil's polar the stall is the fenced.

        None where no optimum was found.
        """
        design = self.result.design
        if design is None:
            return None
        it = DesignInFlight(self.aircraft, design)
        values: dict[str, float] = {name: float(of(it)) for name, of in QUANTITIES.items()}
        margin = float(stall_margin_within_polar(it))
        if margin != values["stall_margin"]:
            values["stall_margin"] = margin
            values["stall_speed_m_per_s"] = values["airspeed_m_per_s"] / margin
        return values

    def design_values(self) -> list[tuple[q.Quantity, float]]:
        """Quantities of the optimum that tables show."""
        design, perf, quantities = self._optimum(), self.result.simulated, self.quantities
        assert perf is not None
        assert quantities is not None
        known = design.variables._asdict() | quantities | q.worst_record(perf, [q.LOAD])
        chosen = [one for one in q.CHOSEN_PROPULSION if known[one.name] is not None]
        return [(one, float(known[one.name])) for one in (*q.SIZED_TABLE, *chosen)]

    def to_frame(self) -> pd.DataFrame:
        """Design as rows of quantity, value and unit; values are NaN without an optimum."""
        values = self.design_values() if self.feasible else [(o, np.nan) for o in q.SIZED_TABLE]
        rows = [(one.label, value, one.unit) for one, value in values]
        return data_frame(rows, columns=["quantity", "value", "unit"])

    @property
    def margins(self) -> list[RequirementMargin]:
        """Margin of the optimum on every requirement; empty without one."""
        flown = self.result.simulated
        if flown is None or self.design is None:
            return []
        required_h = max(self.result.required_excess_time_h, 0.0)
        return requirement_margins(self.aircraft, flown, required_h)

    @property
    def masses_kg(self) -> dict[str, float] | None:
        """Mass budget of the optimum [kg]; None without one."""
        return None if self.design is None else self.design.masses._asdict()

    def masses(self) -> pd.DataFrame:
        """Mass budget, one row per item; NaN without an optimum."""
        masses = self.masses_kg or dict.fromkeys(Masses._fields, np.nan)
        return data_frame({"item": list(masses), "mass_kg": list(masses.values())})

    def scenarios(self) -> pd.DataFrame:
        """Metrics of the optimum in every scenario, one row each; NaN without an optimum."""
        perf = self.result.simulated
        scenarios = self.mission.scenarios() if perf is None else perf.day.scenarios
        places = {"latitude_deg": scenarios.latitude_deg, "day_of_year": scenarios.day_of_year}
        reached = {o.name: np.nan if perf is None else o.of(perf) for o in q.REACHED_FRAME}
        return data_frame(places | reached)


def _margin_record(study: SizingStudy) -> dict[str, Any]:
    """Design with a margin: what it is, and what it reaches with and without that error."""
    result = study.result
    flown = {"least_excess_time_h": result.simulated, q.EXCESS_TIME.name: study.without_margins}
    reached = {
        key: None if perf is None else finite(np.min(perf.cycle.excess_time_h))
        for key, perf in flown.items()
    }
    return {
        "status": result.status.name,
        "solar_model_sigmas": study.mission.uncertainty_margins.solar_model_sigmas,
        "objective_value": finite(result.objective_value),
        **_design_record(result.design),
        **reached,
    }


def _result_record(result: SizingResult, aircraft: Aircraft, mission: Mission) -> dict[str, Any]:
    record: dict[str, Any] = {
        "status": result.status.name,
        "aircraft": aircraft.name,
        "mission": mission.name,
        "mission_is_default": False,  # a command without --mission says so
        "objective": {
            "name": result.objective.value,
            "value": finite(result.objective_value),
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
        **software_record(),
    }
    flown = result.simulated or result.nearest
    mass_kg = None if flown is None else float(flown.design.variables.battery_mass_kg)
    condition = battery_record(aircraft, mission, mass_kg)
    if condition is not None:
        record["battery_condition"] = condition
    record["nearest"] = None if result.nearest is None else _nearest_record(result.nearest)
    return record


def _nearest_record(perf: Performance) -> dict[str, Any]:
    """Design that comes closest to an infeasible requirement, and what it reaches."""
    return {
        **{name: float(value) for name, value in perf.design.variables.chosen().items()},
        **q.design_record(perf.design, [q.TOTAL_MASS]),
        **q.worst_record(perf, [q.EXCESS_TIME]),
        "worst_scenario": perf.day.scenarios.label(perf.worst_scenario()),
    }


def _design_record(design: Design | None) -> dict[str, Any]:
    if design is None:
        names = (one.name for one in q.SIZED)
        return dict.fromkeys((*DesignVariables._fields, q.TOTAL_MASS.name, "masses_kg", *names))
    return {
        **design.variables._asdict(),
        **q.design_record(design, [q.TOTAL_MASS]),
        "masses_kg": design.masses._asdict(),
        **q.design_record(design, q.SIZED),
    }


def _simulated_record(perf: Performance | None) -> dict[str, Any]:
    if perf is None:
        return {q.LOAD.name: None, "worst_scenario": None, "simulated": None}
    worst, scenarios = perf.worst_scenario(), perf.day.scenarios
    return {
        **q.worst_record(perf, [q.LOAD]),
        "worst_scenario": {
            "latitude_deg": float(scenarios.latitude_deg[worst]),
            "day_of_year": int(scenarios.day_of_year[worst]),
            "label": scenarios.label(worst),
        },
        "simulated": {
            **q.worst_record(perf, q.REACHED),
            **q.design_record(perf.design, [q.TOTAL_MASS]),
            "model": perf.solar.model,
            "correction": perf.solar.correction,
        },
    }


def _range_record(coverage: WidestRange) -> dict[str, Any]:
    season = coverage.sizing.objective is Objective.longest_season
    first, last = coverage.first, coverage.last
    if season and first is not None and last is not None:
        ends = {"from": date_code(int(first)), "to": date_code(int(last))}
        return {**ends, "days": int(coverage.extent)}
    return {"from_deg": first, "to_deg": last, "width_deg": coverage.extent}


def sensitivity_records(rows: list[Sensitivity]) -> list[dict[str, Any]]:
    """Sensitivities, JSON-ready, most important first."""
    return [finite_values({**one.__dict__, "per_percent": one.per_percent}) for one in rows]


def _of(one: T | None, record: Callable[[T], Any]) -> Any:
    """Record of what there is; None of what there is not."""
    return None if one is None else record(one)
