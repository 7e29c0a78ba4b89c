"""Sizing of an aircraft for a mission, with all that is asked about it: ``size``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from missions.dates import date_code
from missions.files.overrides import with_values
from missions.files.texts import texts_as_read
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.altitude.climb_cycle import ClimbPerformance, climb_performance
from sizing.balance.assessment import BalanceAssessment, balance_assessment
from sizing.design import (
    Design,
    DesignVariables,
    FlightConditions,
    Masses,
    parametric_design,
    structure_assessment,
)
from sizing.limits import QUANTITIES, DesignInFlight
from sizing.margins.probability import Reliability, check_reliability, size_reliably
from sizing.margins.season_flights import Survival
from sizing.optimisation.altitudes import with_best_altitudes
from sizing.optimisation.coverage import WidestRange, widest_range
from sizing.optimisation.cross_check import CrossCheck, cross_check
from sizing.optimisation.module_flow import with_flow_of_optimum
from sizing.optimisation.objectives import Objective
from sizing.optimisation.own_terms import with_own_terms
from sizing.optimisation.problem import SizingProblems
from sizing.optimisation.propulsion import sized_smoothly
from sizing.optimisation.relaxations import relaxations
from sizing.optimisation.result import SizingResult, SizingStatus
from sizing.optimisation.search import size_aircraft
from sizing.optimisation.sensitivity import (
    ConstraintMultiplier,
    Sensitivity,
    altitude_multipliers,
    constraint_multipliers,
    sensitivities,
)
from sizing.optimisation.whole_cells import WholeCells, size_whole_cells
from sizing.parameters import parameter
from sizing.performance import Performance, performance_of_designs
from sizing.relaxed_flight import Relaxation
from sizing.results import quantities as q
from sizing.results.conditions import battery_record, climbs_record, level_record, wind_record
from sizing.results.notes import catalogue_records, extrapolation_records, relaxation_records
from sizing.results.parts import sizing_record
from sizing.results.propulsion import PartMasses, PowerBudget, part_masses, power_budget
from sizing.results.records import (
    NEGLIGIBLE,
    check_subjects,
    finite,
    finite_values,
    uncertainty_record,
)
from sizing.results.requirements import RequirementMargin, margin_records, requirement_margins
from sizing.results.tables import Result, data_frame
from sizing.smooth_propulsion import put_parts_in
from sizing.structures.assessment import StructureAssessment
from sizing.sunlight import SolarModel, solar_day
from sizing.validity.checks import record_check, stall_margin_within_polar
from sizing.validity.extrapolations import extrapolations, told, with_worth
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
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

    renderer = "sizing.results.sizing_summary"

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
            return Aircraft.model_validate(self._sized_data())

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
        return self.mission.with_fixed_altitudes().model_copy(update={"payload": payload})

    def _optimum(self) -> Design:
        if self.result.design is None:
            raise ValueError(f"the sizing is {self.status.label}: it has no design")
        return self.result.design

    def _sized_data(self) -> dict[str, Any]:
        """Aircraft's file as data, the optimum put in."""
        variables = self._optimum().variables
        data = self.aircraft.model_dump(mode="json", exclude_unset=True)
        data["name"] = f"{data['name']}-sized"
        for one in q.CHOSEN:
            section, key = parameter(one.name).key.split(".")
            data[section][key] = one.of(self.result.design)
        if variables.lift_coefficient is not None:
            data["airframe"]["aerodynamics"]["lift_coefficient"] = variables.lift_coefficient
        put_parts_in(data, self.aircraft, self._optimum())
        return data if self.whole_cells is not None else self._without_cells(data)

    def _without_cells(self, data: dict[str, Any]) -> dict[str, Any]:
        """Data without the whole cells of another design, with the technology they had given."""
        modules, battery = self.aircraft.modules, self.aircraft.battery
        if data["modules"].pop("layout", None) is not None:
            data["modules"]["mppt_mass_kg_per_w"] = modules.mppt_mass_kg_per_w
        if data["battery"].pop("pack", None) is not None:
            technology = battery.model_dump(mode="json")
            for key in ("specific_energy_wh_per_kg", "charge_limit"):
                data["battery"][key] = technology[key]
        return data

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
        return structure_assessment(self.aircraft, self.mission, design)

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
        """Optimum on a mission with climbs, in steps of 1 min; None without one, or them."""
        flown = self.result.simulated
        if flown is None or flown.mission.climb is None:
            return None
        # A range has other scenarios than the mission: that of the least excess time stands for it.
        worst = flown.day.at([flown.worst_scenario()]).scenarios
        sized = self.sized_aircraft(), self.sized_mission(), self.solar
        return climb_performance(*sized, scenarios=worst)

    @cached_property
    def balance(self) -> BalanceAssessment | None:
        """Balance of the optimum; None without one, or without ``airframe.balance``."""
        design = self.result.design
        return None if design is None else balance_assessment(self.aircraft, self.mission, design)

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
            "wind": wind_record(self.mission) if self.mission.holds_station else None,
            "uncertainty": None if low is None or high is None else uncertainty_record(low, high),
            "extrapolations": extrapolation_records(self.extrapolations),
            **catalogue_records(self.aircraft),
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
        conditions = FlightConditions.of(self.mission, self.aircraft)
        it = DesignInFlight(self.aircraft, design, conditions.with_payload_of(design.variables))
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


def size(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective | str | Callable[[Any], Any] = Objective.min_mass,
    *,
    required_excess_time_h: float | None = None,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    with_sensitivities: bool = False,
    with_cross_check: bool = False,
    with_margin: bool = False,
    reliability: float | None = None,
    constraints: Sequence[Callable[[Any], Any]] = (),
    whole_cells: bool = False,
) -> SizingStudy:
    """Find the best design of a parametric aircraft for a mission, or say why there is none.

    Parameters
    ----------
    aircraft : Aircraft
        A parametric one; its ``design_space`` bounds what is chosen.
    mission : Mission
        All of its latitudes and dates must be flown. Altitudes of climbs with a range in
        ``climb.design_space`` are chosen as well, with a reliability as without it.
    objective : Objective, str or callable
        ``min_mass``, ``min_wingspan``, ``max_excess_time``, ``max_payload_mass``,
        ``max_payload_power``, ``longest_season`` or ``widest_latitude_band``; or a function of the
        design that is to be as small as possible, such as
        ``lambda design: design.total_mass_kg + 0.5 * design.wingspan_m``. It is called once, with
        symbols: arithmetic, NumPy's and CasADi's functions take them, ``if`` and ``max`` do not. A
        wrong name is answered with all that there are.
    required_excess_time_h : float, optional
        Excess time that every scenario must have [h], instead of the mission's.
    model : {"CAM", "CDM", "VM", "FM"}
        Solar power model.
    correction : {"none", "report", "loiter"}
        Correction of the model's systematic error.
    with_sensitivities : bool
        Also what each technology parameter and constraint is worth.
    with_cross_check : bool
        Also try to beat the optimum with thousands of other designs in the simulator.
    with_margin : bool
        Also the design that keeps the requirement with one RMS error of the model less solar power;
        not of a range, with a reliability, or where the mission has uncertainty margins itself.
    reliability : float, optional
        Least probability that every scenario has the required excess time when the inputs scatter
        as the ``uncertainty`` of aircraft and mission says; above 0 and below 1.
    constraints : sequence of callable
        Further requirements on the design, functions that return one comparison by ``<=`` or
        ``>=``: ``lambda design: design.wing_loading_kg_per_m2 <= 3``. Answers name a function by
        its name, a lambda by what it compares.
    whole_cells : bool
        The best design of whole solar and battery cells instead of the relaxed optimum, for an
        aircraft with ``modules.layout`` and ``battery.pack``.

    Returns
    -------
    SizingStudy

    Raises
    ------
    TypeError
        For a measured aircraft, or what is no aircraft or mission.
    InputError
        With a reliability, for uncertain inputs that contradict the files' rules.
    ValueError
        For an unknown objective, model or correction, an impossible required excess time, or a
        reliability without uncertain inputs, of a range, or with sensitivities or a cross-check;
        for whole cells of an aircraft without a layout or a pack, of a range, or with any of these.
    """
    check_subjects(aircraft, mission)
    solar, original = SolarModel(model, correction), aircraft
    aircraft, wanted = _with_own(aircraft, mission, objective, constraints)
    other = mission
    if required_excess_time_h is not None:
        # The mission's rules for its own requirement hold for another one, too.
        other = with_values(mission, {"required_excess_time_h": required_excess_time_h})
        required_excess_time_h = other.required_excess_time_h
    options: dict[str, Any] = {"required_excess_time_h": required_excess_time_h}
    mission = with_best_altitudes(aircraft, mission, wanted, solar, **options)
    if whole_cells:
        if with_sensitivities or with_cross_check or reliability is not None:
            raise ValueError(
                "whole cells have no sensitivities, cross-check or reliability: leave them out"
            )
        laid = _of_whole_cells(aircraft, mission, wanted, solar, required_excess_time_h)
        if laid is not None:
            return laid
    smooth, start, settled = sized_smoothly(aircraft, mission, wanted, solar, **options)
    aircraft, start = with_flow_of_optimum(
        *(smooth, mission, wanted, solar), start=start, **options
    )
    problems = options["problems"] = SizingProblems(aircraft)
    if reliability is not None:
        if with_sensitivities or with_cross_check:
            raise ValueError("sensitivities and cross-check know of no reliability: leave one out")
        case = (aircraft, other, wanted, solar)
        return replace(_reliable(*case, least=reliability, problems=problems), aircraft=original)
    coverage = None
    if wanted.of_range:
        coverage = widest_range(aircraft, mission, wanted, solar, **options)
        result = coverage.sizing
    elif settled is not None and aircraft is smooth:
        result = settled  # the last round was this very sizing
    else:
        result = size_aircraft(aircraft, mission, wanted, solar, start=start, **options)
    asked = (aircraft, mission, result, solar)
    relaxed: tuple[Relaxation, ...] = ()
    if result.status is SizingStatus.infeasible and not wanted.of_range:
        relaxed = tuple(relaxations(*asked, problems=problems))
    worth = with_sensitivities and result.feasible
    guarded = None
    if with_margin and result.feasible and coverage is None:
        guarded = _with_margin(aircraft, mission, result, solar, problems)
    level = None
    if mission.climb is not None and coverage is None:
        low_flight = (aircraft, mission.at_altitude(mission.altitude_m), wanted, solar)
        level = size_aircraft(*low_flight, start=start, explain=False, **options)
    study = study_of(
        *asked,
        coverage=coverage,
        relaxations=relaxed,
        without_climbs=level,
        sensitivities=sensitivities(*asked) if worth else None,
        multipliers=_multipliers(*asked) if worth else None,
        cross_check=cross_check(*asked) if with_cross_check and result.feasible else None,
        with_margin=guarded,
    )
    return replace(study, aircraft=original)


def study_of(
    aircraft: Aircraft, mission: Mission, result: SizingResult, solar: SolarModel, **asked: Any
) -> SizingStudy:
    """Sizing with its optimum under the model's error, and without the mission's margins."""
    given = (aircraft, mission, result, solar)
    low, high = _under_model_error(*given)
    plain = _without_margins_of(*given)
    return SizingStudy(
        *(aircraft, mission, solar, result, low, high), without_margins=plain, **asked
    )


def _multipliers(
    aircraft: Aircraft, mission: Mission, result: SizingResult, solar: SolarModel
) -> list[ConstraintMultiplier]:
    """What holds the optimum back, largest first: of the program, and of chosen altitudes."""
    altitudes = altitude_multipliers(aircraft, mission, result, solar)
    return sorted(constraint_multipliers(result) + altitudes, key=lambda one: -one.gain)


def _of_whole_cells(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    required_excess_time_h: float | None,
) -> SizingStudy | None:
    """Best design of whole cells; None where there is not even a relaxed one."""
    result, cells = size_whole_cells(
        *(aircraft, mission, objective, solar), required_excess_time_h=required_excess_time_h
    )
    if not cells.relaxed.feasible:
        return None
    laid = aircraft if cells.aircraft is None else cells.aircraft
    return study_of(laid, mission, result, solar, whole_cells=cells)


def _with_margin(
    aircraft: Aircraft,
    mission: Mission,
    optimum: SizingResult,
    solar: SolarModel,
    problems: SizingProblems,
) -> SizingStudy | None:
    """Sizing with one RMS error less solar power; None where the mission has margins itself."""
    if mission.uncertainty_margins.given or optimum.design is None:
        return None
    guarded = with_values(mission, {"uncertainty_margins.solar_model_sigmas": 1.0})
    result = size_aircraft(
        *(aircraft, guarded, optimum.objective, solar),
        required_excess_time_h=optimum.required_excess_time_h,
        problems=problems,
        start=optimum.design.variables,
    )
    plain = _without_margins_of(aircraft, guarded, result, solar)
    return SizingStudy(aircraft, guarded, solar, result, without_margins=plain)


def _with_own(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective | str | Callable[[Any], Any],
    constraints: Sequence[Callable[[Any], Any]],
) -> tuple[Aircraft, Objective]:
    """Aircraft with the user's own terms in its design space, and the objective."""
    own = objective if callable(objective) else None
    # What is no function of the user's is a name.
    named = Objective.min_mass if own is not None else checked_objective(objective)  # type: ignore[arg-type]
    if (own is None and not constraints) or isinstance(aircraft.airframe, MeasuredAirframe):
        return aircraft, named
    aircraft, minimised = with_own_terms(aircraft, mission, own, constraints)
    # It answers as an objective does.
    return aircraft, named if minimised is None else cast(Objective, minimised)


def _reliable(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    *,
    least: float,
    problems: SizingProblems,
) -> SizingStudy:
    """Sizing for a probability of the mission's required excess time."""
    case = (aircraft, mission, objective, solar)
    check_reliability(*case, least)
    result, reliability = size_reliably(*case, reliability=least, problems=problems)
    asked = (aircraft, mission, result, solar)
    # What would help is known of a sizing that fails without uncertainty as well.
    failed = result.status is SizingStatus.infeasible and reliability is None
    relaxed = tuple(relaxations(*asked, problems=problems)) if failed else ()
    return study_of(*asked, relaxations=relaxed, reliability=reliability)


def checked_objective(objective: Objective | str) -> Objective:
    """Objective of a name."""
    try:
        return Objective(objective)
    except ValueError:
        allowed = ", ".join(Objective)
        raise ValueError(f"objective must be one of {allowed} (got {objective!r})") from None


def _under_model_error(
    aircraft: Aircraft, mission: Mission, result: SizingResult, solar: SolarModel
) -> tuple[Performance | None, Performance | None]:
    """Optimum with the solar power one RMS error of the model lower and higher."""
    if result.design is None or result.simulated is None:
        return None, None
    low, high = (
        performance_of_designs(
            aircraft,
            result.simulated.mission,
            result.design.variables,
            solar,
            day=result.simulated.day.scaled(factor),
        )
        for factor in (1.0 - solar.rms_relative, 1.0 + solar.rms_relative)
    )
    return low, high


def _without_margins_of(
    aircraft: Aircraft, mission: Mission, result: SizingResult, solar: SolarModel
) -> Performance | None:
    """Optimum without the mission's uncertainty margins; None where the mission has none."""
    if result.design is None or result.simulated is None or not mission.uncertainty_margins.given:
        return None
    plain = mission.without_margins()
    day = solar_day(aircraft, plain, solar, scenarios=result.simulated.day.scenarios)
    return performance_of_designs(aircraft, plain, result.design.variables, solar, day=day)


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
        "objective_value": None
        if result.objective_value is None
        else finite(result.objective_value),
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
