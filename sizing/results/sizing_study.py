"""A sizing and what was asked about it, with its record."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_code
from missions.files.texts import texts_as_read
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.chosen_parts import sized_data
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
from sizing.results.analysis import Analysis
from sizing.results.conditions import BatteryCondition
from sizing.results.design_result import DesignResult
from sizing.results.margins import RequirementMargin, requirement_margins
from sizing.results.measures import MEASURES
from sizing.results.numbers import NEGLIGIBLE
from sizing.results.parts import cells_record
from sizing.results.qualities import BuiltDesign
from sizing.results.result import SERIALISER, data_frame
from sizing.results.season import Survival
from sizing.sized_structure import structure_assessment
from sizing.structures.assessment import StructureAssessment
from sizing.validity.checks import record_check, stall_margin_within_polar
from sizing.validity.extrapolations import add_effects, collect_extrapolations, extrapolations
from sizing.validity.ranges import Extrapolation

if TYPE_CHECKING:
    import pandas as pd


_OF_DESIGN = (
    "wingspan_m",
    "aspect_ratio",
    "battery_mass_kg",
    "module_area_m2",
    "total_mass_kg",
    "airspeed_m_per_s",
    "stall_speed_m_per_s",
    "wing_loading_kg_per_m2",
    "climb_rate_m_per_s",
    "power_out_w",
)
_OF_PROPULSION = (
    "propeller_diameter_m",
    "propeller_pitch_m",
    "gear_ratio",
    "motor_speed_constant_rpm_per_v",
)
_OF_SCENARIO = (
    "excess_time_h",
    "charge_margin_h",
    "minimum_state_of_charge",
    "solar_energy_wh",
    "load_energy_wh",
)


@dataclass(frozen=True, repr=False, eq=False)
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

    renderer = "studies.render.sizing"

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    result: SizingResult
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

    @property
    def excess_time_h(self) -> float:
        """Excess time of the optimum in its worst scenario [h]; NaN without one."""
        return math.nan if self.optimum is None else self.optimum.excess_time_h

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
        if self.result.design is None:
            raise ValueError(f"the sizing is {self.status.label}: it has no design")
        return self.result.design

    @cached_property
    def optimum(self) -> Analysis | None:
        """The optimum as it was simulated; None without one."""
        return self._analysis_of(self.result.simulated)

    @cached_property
    def as_assumed(self) -> Analysis | None:
        """The optimum without the mission's uncertainty margins; None where it has none."""
        return self._analysis_of(self.without_margins)

    @cached_property
    def nearest(self) -> Analysis | None:
        """Design that comes closest, of an infeasible sizing."""
        return self._analysis_of(self.result.nearest)

    def _analysis_of(self, flight: Performance | None) -> Analysis | None:
        return None if flight is None else Analysis(self.aircraft, self.mission, flight)

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

    @property
    def battery_condition(self) -> BatteryCondition | None:
        """Battery of the optimum, or else of the nearest design, in the mission's air."""
        shown = self.optimum or self.nearest
        return super().battery_condition if shown is None else shown.battery_condition

    @property
    def cells(self) -> dict[str, Any] | None:
        """Designs of whole cells, the relaxed optimum and the loss; None where not asked for."""
        if (whole := self.whole_cells) is None:
            return None
        record: dict[str, Any] = import_module(SERIALISER).serialise(whole)
        return record | (cells_record(self.aircraft) if whole.aircraft is not None else {})

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

    @cached_property
    def extrapolations(self) -> tuple[Extrapolation, ...]:
        """What the optimum takes from outside the range of a model.

        Where excess time alone is missing, what the nearest design takes, which flies all the same.
        """
        result, flight = self.result, self.result.simulated
        if flight is None and all(
            violation.requirement == "excess_time" for violation in result.violations
        ):
            flight = result.nearest
        if flight is None:
            return ()
        notes = extrapolations(self.aircraft, flight)
        if self.survival is not None:
            site = self.survival.weather.site
            notes += collect_extrapolations([record_check(self.survival.mission, site.altitude_m)])
        return add_effects(notes, self.aircraft, lambda: flight)

    @cached_property
    def quantities(self) -> dict[str, float] | None:
        """Quantities that may be bounded; outside of the airfoil's polar the stall is the fenced.

        None where no optimum was found.
        """
        design = self.result.design
        if design is None:
            return None
        flight = DesignInFlight(self.aircraft, design)
        values: dict[str, float] = {name: float(of(flight)) for name, of in QUANTITIES.items()}
        margin = float(stall_margin_within_polar(flight))
        if margin != values["stall_margin"]:
            values["stall_margin"] = margin
            values["stall_speed_m_per_s"] = values["airspeed_m_per_s"] / margin
        return values

    def design_values(self) -> dict[str, float]:
        """Return the numbers of the optimum that tables show."""
        design, quantities = self._optimum(), self.quantities
        assert quantities is not None
        assert self.optimum is not None
        known = design.variables._asdict() | quantities | {"power_out_w": self.optimum.power_out_w}
        chosen = [key for key in _OF_PROPULSION if known[key] is not None]
        return {key: float(known[key]) for key in (*_OF_DESIGN, *chosen)}

    def to_frame(self) -> pd.DataFrame:
        """Return the design, a row each number with its unit; NaN without an optimum."""
        values = self.design_values() if self.feasible else dict.fromkeys(_OF_DESIGN, np.nan)
        rows = import_module(SERIALISER).rows_of(values)
        return data_frame(rows, columns=["quantity", "value", "unit"])

    @property
    def margins(self) -> list[RequirementMargin]:
        """Margin of the optimum on every requirement; empty without one."""
        simulated = self.result.simulated
        if simulated is None or self.design is None:
            return []
        required_h = max(self.result.required_excess_time_h, 0.0)
        return requirement_margins(self.aircraft, simulated, required_h)

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
        perf = self.result.simulated
        scenarios = self.mission.scenarios() if perf is None else perf.day.scenarios
        places = {"latitude_deg": scenarios.latitude_deg, "day_of_year": scenarios.day_of_year}
        reached = {key: np.nan if perf is None else MEASURES[key](perf) for key in _OF_SCENARIO}
        return data_frame(places | reached)
