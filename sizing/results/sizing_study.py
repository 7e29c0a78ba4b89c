"""A sizing and what was asked about it, with its record."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_code
from missions.files.texts import texts_as_read
from missions.mission import Mission
from missions.weather.light import DayAxis
from missions.weather.record import Weather, longest_run
from sizing.aircraft import Aircraft
from sizing.chosen_parts import sized_data
from sizing.day.light import SolarModel, solar_day
from sizing.design import Design, DesignVariables, Masses
from sizing.limits import QUANTITIES
from sizing.mass_budget import parametric_design
from sizing.performance import performance_of_designs
from sizing.program.cross_check import CrossCheck
from sizing.program.objectives import Objective
from sizing.program.ranges import WidestRange
from sizing.program.reliability import Reliability
from sizing.program.result import SizingResult, SizingStatus
from sizing.program.sensitivity import ConstraintMultiplier, Sensitivity
from sizing.program.whole_cells import WholeCells
from sizing.relaxed_flight import Relaxation
from sizing.results.analysis import Analysis, analysis_of
from sizing.results.design_result import (
    DesignResult,
    RequirementMargin,
    described,
    requirement_margins,
)
from sizing.results.result import NEGLIGIBLE, SERIALISER, data_frame
from sizing.sized_structure import structure_assessment
from sizing.structures.assessment import StructureAssessment
from sizing.validity.checks import check_user_models, record_check, stall_margin_within_polar
from sizing.validity.extrapolations import add_effects, collect_extrapolations, extrapolations
from sizing.validity.ranges import Extrapolation
from solar.types import BoolArray, IntArray

if TYPE_CHECKING:
    import pandas as pd


_OF_SCENARIO = (
    "excess_time_h",
    "charge_margin_h",
    "minimum_state_of_charge",
    "solar_energy_wh",
    "load_energy_wh",
)


@dataclass(frozen=True)
class SeasonDays:
    """Days of a record's season, and which of them close.

    ``year``: of each day of the season, by local date. ``closes``: whether it closes.
    ``longest_gap_days``: most consecutive days of the season that do not close.
    """

    year: IntArray
    closes: BoolArray
    longest_gap_days: int

    @classmethod
    def of(cls, axis: DayAxis, season: BoolArray, closes: BoolArray) -> SeasonDays:
        """Return the season's days, of all days of a record and which of them close."""
        return cls(
            year=axis.year[season],
            closes=closes[season],
            longest_gap_days=longest_run(season & ~closes),
        )

    def __len__(self) -> int:
        return len(self.closes)

    @property
    def that_close(self) -> int:
        """Days that close."""
        return int(np.count_nonzero(self.closes))

    @property
    def share(self) -> float:
        """Share of the days that close [-]."""
        return self.that_close / len(self)

    def by_year(self) -> list[dict[str, Any]]:
        """Return the days, and the days that close, of each year."""
        return [
            {
                "year": int(year),
                "days": int(np.count_nonzero(at)),
                "days_that_close": int(np.count_nonzero(self.closes[at])),
                "share": float(np.mean(self.closes[at])),
            }
            for year in np.unique(self.year)
            for at in [self.year == year]
        ]


@dataclass(frozen=True)
class Survival:
    """How a sized design flies through the season of a weather record.

    ``mission``: at the record's site; its dates are the season. ``required``: share of the days
    that was asked for [-]. ``days``: of the design; of the one with the most days that close that
    was found, where no design has enough. ``clear_sky``: sizing for perpetual flight under a clear
    sky on the same dates. ``clear_sky_days``: what its design makes of the record. ``notes``: what
    was changed to fly the mission at the record's site.
    """

    weather: Weather
    mission: Mission
    required: float
    days: SeasonDays
    clear_sky: SizingResult
    clear_sky_days: SeasonDays | None
    notes: tuple[str, ...] = ()

    @property
    def season(self) -> dict[str, str]:
        """First and last date."""
        days = self.mission.dates.range()
        return {"from": date_code(days[0]), "to": date_code(days[-1])}

    @property
    def achieved(self) -> float:
        """Share of the season's days that close [-]."""
        return self.days.share

    @property
    def by_year(self) -> list[dict[str, Any]]:
        """Days of each year that close; empty where the record does not tell years apart."""
        several = not self.weather.typical and len(np.unique(self.days.year)) > 1
        return self.days.by_year() if several else []


@dataclass(frozen=True)
class BuiltDesign:
    """Best design of a class of building; ``of_file``: whether the file has that class."""

    build: str
    factor: float
    of_file: bool
    design: Design | None
    objective_value: float | None


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class SizingStudy(DesignResult):
    """A sizing and what was asked about it.

    Attributes
    ----------
    aircraft, mission, solar
        What was sized, for what, and by which solar power model.
    result : SizingResult
        Optimum, or the requirements that cannot be met.
    coverage : WidestRange or None
        Range of days or latitudes, for the objectives that have one.
    relaxations : tuple
        Single changes that would make an infeasible sizing feasible.
    sensitivities, multipliers : list or None
        What parameters and constraints are worth at the optimum, where asked for.
    cross_check : CrossCheck or None
        Optimality cross-check by simulation, where asked for.
    optimum : Analysis or None
        Optimum as it was simulated.
    as_assumed : Analysis or None
        Optimum without the mission's uncertainty margins, where it has any.
    quantities : dict or None
        Quantities of the optimum that may be bounded; outside of the airfoil's polar the stall is
        the fenced.
    margins : list of RequirementMargin
        Margin of the optimum on every requirement; empty without one.
    structure : StructureAssessment or None
        What sizes the structure of the optimum, or else of the nearest design. None where the
        structure's model does not say, or no design could be simulated.
    extrapolations : tuple of Extrapolation
        What the optimum takes from outside the range of a model. Where excess time alone is
        missing, what the nearest design takes, which flies all the same.
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

    renderer = "studies.render.sizing"

    solar: SolarModel
    result: SizingResult
    optimum: Analysis | None
    as_assumed: Analysis | None
    quantities: dict[str, float] | None
    margins: list[RequirementMargin]
    structure: StructureAssessment | None
    extrapolations: tuple[Extrapolation, ...]
    coverage: WidestRange | None = None
    relaxations: tuple[Relaxation, ...] = ()
    sensitivities: list[Sensitivity] | None = None
    multipliers: list[ConstraintMultiplier] | None = None
    cross_check: CrossCheck | None = None
    with_margin: SizingStudy | None = None
    reliability: Reliability | None = None
    survival: Survival | None = None
    whole_cells: WholeCells | None = None
    without_climbs: SizingResult | None = None
    builds: tuple[BuiltDesign, ...] = ()

    @property
    def excess_time_h(self) -> float:
        """Excess time of the optimum in its worst scenario [h]; NaN without one."""
        return math.nan if self.optimum is None else self.optimum.excess_time_h

    @cached_property
    def nearest(self) -> Analysis | None:
        """Design that comes closest, of an infeasible sizing."""
        flight = self.result.nearest
        return None if flight is None else analysis_of(self.aircraft, self.mission, flight)

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
    def variables(self) -> DesignVariables | None:
        """Wingspan, aspect ratio, battery mass, module area ... of the optimum."""
        return None if self.design is None else self.design.variables

    def sized_aircraft(self) -> Aircraft:
        """Return the aircraft with the optimum put in, ready to be analysed or written to a file.

        Raises
        ------
        ValueError
            Where no optimum was found.
        """
        with texts_as_read(self.aircraft.texts_read):
            data = sized_data(self.aircraft, self._optimum(), self.whole_cells is not None)
            return Aircraft.model_validate(data)

    def sized_mission(self) -> Mission:
        """Return the mission with the payload that the optimum carries.

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
        if self.design is None:
            raise ValueError(f"the sizing is {self.status.label}: it has no design")
        return self.design

    @property
    def range(self) -> dict[str, Any] | None:
        """Days or latitudes that the optimum covers, for the objectives that have a range."""
        if (coverage := self.coverage) is None:
            return None
        first, last = coverage.first, coverage.last
        if self.objective is Objective.longest_season and first is not None and last is not None:
            ends = {"from": date_code(int(first)), "to": date_code(int(last))}
            return {**ends, "days": int(coverage.extent)}
        return {"from_deg": first, "to_deg": last, "width_deg": coverage.extent}

    @property
    def values(self) -> dict[str, Any]:
        """Numbers of the optimum by the keys of quantities; empty without one."""
        if self.design is None or self.quantities is None or self.optimum is None:
            return {}
        load = {"power_out_w": self.optimum.power_out_w}
        return self.design.variables._asdict() | self.quantities | load

    def to_frame(self) -> pd.DataFrame:
        """Return the design, a row each number with its unit; NaN without an optimum."""
        rows = import_module(SERIALISER).rows_of(self.values)
        return data_frame(rows, columns=["quantity", "value", "unit"])

    @property
    def masses_kg(self) -> dict[str, float] | None:
        """Mass budget of the optimum [kg]; None without one."""
        return None if self.design is None else self.design.masses._asdict()

    def masses(self) -> pd.DataFrame:
        """Return the mass budget, one row per item; NaN without an optimum."""
        masses = self.masses_kg or dict.fromkeys(Masses._fields, np.nan)
        return data_frame({"item": list(masses), "mass_kg": list(masses.values())})

    def scenarios(self) -> pd.DataFrame:
        """Return the metrics of the optimum in every scenario, one row each; NaN without one."""
        scenarios, values = self.mission.scenarios(), dict.fromkeys(_OF_SCENARIO, np.nan)
        if self.optimum is not None:
            scenarios = self.optimum.performance.day.scenarios
            values = {key: self.optimum.values[key] for key in _OF_SCENARIO}
        places = {"latitude_deg": scenarios.latitude_deg, "day_of_year": scenarios.day_of_year}
        return data_frame(places | values)


def study_of(
    aircraft: Aircraft,
    mission: Mission,
    result: SizingResult,
    solar: SolarModel,
    *,
    cooled: Aircraft | None = None,
    whole_cells: WholeCells | None = None,
    survival: Survival | None = None,
    **others: Any,
) -> SizingStudy:
    """Return a sizing with all that is known of its optimum, or of the nearest design.

    ``cooled``: the aircraft with the cooling of the optimum's airflow, where it is another.
    ``others``: what else was asked for, by the names of the attributes.
    """
    design, simulated, nearest = result.design, result.simulated, result.nearest
    optimum = as_assumed = quantities = None
    margins: list[RequirementMargin] = []
    if simulated is not None:
        optimum = analysis_of(aircraft, mission, simulated)
    if design is not None and simulated is not None:
        check_user_models(cooled or aircraft, mission, design)
        if mission.uncertainty_margins.is_set:
            plain, scenarios = mission.without_margins(), simulated.day.scenarios
            day = solar_day(cooled or aircraft, plain, solar, scenarios=scenarios)
            flight = performance_of_designs(
                cooled or aircraft, plain, design.variables, solar, day=day
            )
            as_assumed = analysis_of(aircraft, mission, flight)
        required_h = max(result.required_excess_time_h, 0.0)
        margins = requirement_margins(aircraft, simulated, required_h)
    if design is not None:
        quantities = _quantities(aircraft, design)
    shown = design or (None if nearest is None else nearest.design)
    common = described(aircraft, mission, shown)
    laid = whole_cells is not None and whole_cells.aircraft is not None
    return SizingStudy(
        **common | {"cells": common["cells"] if laid else None},
        design=design,
        solar=solar,
        result=result,
        optimum=optimum,
        as_assumed=as_assumed,
        quantities=quantities,
        margins=margins,
        structure=None if shown is None else _structure(aircraft, mission, shown),
        extrapolations=_extrapolations(aircraft, result, survival),
        whole_cells=whole_cells,
        survival=survival,
        **others,
    )


def _structure(aircraft: Aircraft, mission: Mission, design: Design) -> StructureAssessment | None:
    """Return what sizes the structure of a design.

    One that no mass closes is taken at twice the mass of all but its structure and propulsion.
    """
    if not np.isfinite(design.total_mass_kg):
        carried_kg = float(sum(design.masses[2:], 0.0))
        variables = design.variables.mapped(float)
        design = parametric_design(aircraft, mission, variables, 2.0 * carried_kg)
    return structure_assessment(aircraft, design)


def _extrapolations(
    aircraft: Aircraft, result: SizingResult, survival: Survival | None
) -> tuple[Extrapolation, ...]:
    """Return what the optimum, or else the nearest design, takes from outside of a model."""
    flight, missed = result.simulated, {row.requirement for row in result.violations}
    if flight is None and missed <= {"excess_time"}:
        flight = result.nearest
    if flight is None:
        return ()
    outside = extrapolations(aircraft, flight)
    if survival is not None:
        site = survival.weather.site
        outside += collect_extrapolations([record_check(survival.mission, site.altitude_m)])
    return add_effects(outside, aircraft, lambda: flight)


def _quantities(aircraft: Aircraft, design: Design) -> dict[str, float]:
    """Return the quantities that may be bounded, the stall within the airfoil's polar."""
    values: dict[str, float] = {name: float(of(design)) for name, of in QUANTITIES.items()}
    margin = float(stall_margin_within_polar(aircraft, design))
    if margin != values["stall_margin"]:
        values["stall_margin"] = margin
        values["stall_speed_m_per_s"] = values["airspeed_m_per_s"] / margin
    return values
