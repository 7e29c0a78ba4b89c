"""What results of an analysis and of a sizing have in common: a design, part by part."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from operator import attrgetter
from typing import Any

from missions.files.overrides import with_values
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.catalogues.choice import CatalogueValue
from sizing.design import Design
from sizing.results.conditions import BatteryCondition, Wind, battery_condition, wind_of
from sizing.results.numbers import finite
from sizing.results.parts import cells_record
from sizing.results.result import Result
from sizing.validity.checks import check_user_models
from solar.schema import Record


def _of_design(key: str, text: str) -> property:
    """Return an attribute: a number of the design, NaN without one."""

    def value(result: DesignResult) -> float | None:
        design = result.design
        return math.nan if design is None else finite(attrgetter(key)(design))

    return property(value, doc=f"{text}; NaN without a design.")


class DesignResult(Result, ABC):
    """Result on a mission with a design, of which nothing is known where there is none."""

    aircraft: Aircraft
    mission: Mission

    wingspan_m = _of_design("variables.wingspan_m", "Wingspan [m]")
    battery_mass_kg = _of_design("variables.battery_mass_kg", "Battery mass [kg]")
    module_area_m2 = _of_design("variables.module_area_m2", "Area of the solar modules [m²]")
    total_mass_kg = _of_design("total_mass_kg", "Total mass [kg]")
    battery_energy_wh = _of_design("battery_energy_wh", "Energy of the full battery [Wh]")
    propulsion_power_w = _of_design("propulsion_power_w", "Power of level flight [W]")
    airspeed_m_per_s = _of_design("airspeed_m_per_s", "Airspeed [m/s]")

    @property
    @abstractmethod
    def design(self) -> Design | None:
        """Masses and power; None without a design."""

    @property
    def battery_condition(self) -> BatteryCondition | None:
        """Battery in the mission's air; None where nothing there changes it."""
        design = self.design
        mass_kg = None if design is None else float(design.variables.battery_mass_kg)
        air_c, height_m = self.mission.air_state().temperature_c, self.mission.altitude_m
        return battery_condition(self.aircraft, air_c, height_m, mass_kg)

    @property
    def cells(self) -> dict[str, Any] | None:
        """Solar and battery cells; None without whole cells."""
        return cells_record(self.aircraft) or None

    @property
    def wind(self) -> Wind | None:
        """Wind of every scenario; None for one that the mission gives."""
        return wind_of(self.mission)

    @property
    def from_catalogues(self) -> tuple[CatalogueValue, ...]:
        """Values of the aircraft that catalogues gave."""
        return tuple(self.aircraft.from_catalogues())

    @property
    def reading_notes(self) -> tuple[str, ...]:
        """What was left out of the files."""
        return (*self.aircraft.reading_notes(), *self.mission.reading_notes())


def check_subjects(aircraft: object, mission: object) -> None:
    """Refuse what is no aircraft and no mission, such as the names of some."""
    for thing, kind, load in (
        (aircraft, Aircraft, "sizing.load_aircraft"),
        (mission, Mission, "missions.load_mission"),
    ):
        if not isinstance(thing, kind):
            raise TypeError(
                f"expected {kind.__name__} (got {type(thing).__name__}); {load}(name or path) "
                "reads one"
            )
        _check_copies(thing)
    if isinstance(aircraft, Aircraft) and isinstance(mission, Mission):
        check_user_models(aircraft, mission)


def _check_copies(record: Record) -> None:
    """Validate what ``model_copy`` has changed, in a record and those inside it."""
    for name in type(record).model_fields:
        inner = getattr(record, name)
        if isinstance(inner, Record):
            _check_copies(inner)
    if record.is_unchecked():
        unknown = record.model_fields_set - type(record).model_fields.keys()
        with_values(record, {name: getattr(record, name) for name in unknown})
