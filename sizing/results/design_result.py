"""What the result of an analysis and of a sizing have in common: a design, part by part."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.balance.assessment import BalanceAssessment, balance_assessment
from sizing.catalogues.choice import Taken
from sizing.design import Design
from sizing.results import quantities as q
from sizing.results.conditions import BatteryCondition, Wind, battery_condition, wind_of
from sizing.results.parts import cells_record
from sizing.results.propulsion import PartMasses, PowerBudget, part_masses, power_budget
from sizing.results.tables import Result


class DesignResult(Result):
    """Result on a mission with a design, of which nothing is known where there is none."""

    aircraft: Aircraft
    mission: Mission

    wingspan_m = q.attribute_of_design(q.WINGSPAN)
    battery_mass_kg = q.attribute_of_design(q.BATTERY_MASS)
    module_area_m2 = q.attribute_of_design(q.MODULE_AREA)
    total_mass_kg = q.attribute_of_design(q.TOTAL_MASS)
    battery_energy_wh = q.attribute_of_design(q.BATTERY_ENERGY)
    propulsion_power_w = q.attribute_of_design(q.PROPULSION_POWER)
    airspeed_m_per_s = q.attribute_of_design(q.AIRSPEED)

    @property
    def design(self) -> Design | None:
        """Masses and power; None without a design."""
        raise NotImplementedError

    @cached_property
    def power_budget(self) -> PowerBudget | None:
        """Where the power of level flight goes, at the mission's altitude."""
        design = self.design
        return None if design is None else power_budget(self.aircraft, self.mission, design)

    @cached_property
    def part_masses(self) -> PartMasses | None:
        """Masses of the propulsion's parts that are estimated; None where there are none."""
        return None if self.design is None else part_masses(self.aircraft, self.design)

    @cached_property
    def balance(self) -> BalanceAssessment | None:
        """Centre of gravity, static margin and trim; None without ``airframe.balance``."""
        design = self.design
        return None if design is None else balance_assessment(self.aircraft, design)

    @property
    def battery_condition(self) -> BatteryCondition | None:
        """Battery in the mission's air; None where nothing there changes it."""
        design = self.design
        mass_kg = None if design is None else float(design.variables.battery_mass_kg)
        return battery_condition(self.aircraft, self.mission, mass_kg)

    @property
    def cells(self) -> dict[str, Any] | None:
        """Solar and battery cells; None without whole cells."""
        return cells_record(self.aircraft) or None

    @property
    def wind(self) -> Wind | None:
        """Wind of every scenario; None for one that the mission gives."""
        return wind_of(self.mission)

    @property
    def from_catalogues(self) -> tuple[Taken, ...]:
        """Values of the aircraft that catalogues gave."""
        return tuple(self.aircraft.from_catalogues())

    @property
    def reading_notes(self) -> tuple[str, ...]:
        """What was left out of the files."""
        return (*self.aircraft.reading_notes(), *self.mission.reading_notes())
