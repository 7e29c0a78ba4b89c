"""What results of an analysis and of a sizing have in common: a design, part by part."""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from missions.files.overrides import with_values
from missions.mission import Mission
from sizing.aircraft import Aircraft
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


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class DesignResult(Result):
    """Result on a mission with a design, of which nothing is known where there is none.

    ``design``: masses and power; None without a design. ``battery_condition``: battery in the
    mission's air; None where nothing there changes it. ``cells``: solar and battery cells; None
    without whole cells. ``wind``: wind of every scenario; None for one that the mission gives.
    ``reading_notes``: what was left out of the files.
    """

    aircraft: Aircraft
    mission: Mission
    design: Design | None
    battery_condition: BatteryCondition | None
    cells: dict[str, Any] | None
    wind: Wind | None
    reading_notes: tuple[str, ...]

    wingspan_m = _of_design("variables.wingspan_m", "Wingspan [m]")
    battery_mass_kg = _of_design("variables.battery_mass_kg", "Battery mass [kg]")
    module_area_m2 = _of_design("variables.module_area_m2", "Area of the solar modules [m²]")
    total_mass_kg = _of_design("total_mass_kg", "Total mass [kg]")
    battery_energy_wh = _of_design("battery_energy_wh", "Energy of the full battery [Wh]")
    propulsion_power_w = _of_design("propulsion_power_w", "Power of level flight [W]")
    airspeed_m_per_s = _of_design("airspeed_m_per_s", "Airspeed [m/s]")


def described(aircraft: Aircraft, mission: Mission, design: Design | None) -> dict[str, Any]:
    """Return what all results of a design have; of none the battery is that of the file."""
    mass_kg = None if design is None else float(design.variables.battery_mass_kg)
    air_c, height_m = mission.air_state().temperature_c, mission.altitude_m
    return {
        "aircraft": aircraft,
        "mission": mission,
        "battery_condition": battery_condition(aircraft, air_c, height_m, mass_kg),
        "cells": cells_record(aircraft) or None,
        "wind": wind_of(mission),
        "reading_notes": (*aircraft.reading_notes(), *mission.reading_notes()),
    }


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
