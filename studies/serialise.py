"""Results as plain data for JSON: one function for all of them, and the keys of each.

A class without an entry in :data:`RECORDS` is written with its fields. An entry lists keys and the
paths to their values, ``key=path``, or ``key`` alone where the path is the same:

* a path is of attributes, keys and places; a method on it is called; behind None is None
* a key with dots makes records within the record; ``key?`` leaves out None and an empty tuple
* ``key:Name`` and ``key=path:Name`` write the value by the entry of that name, ``key=path:utc``
  a time by its function
* ``+`` stands for all fields, ``-key`` leaves one out, ``*path`` stands for all keys of a record
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from typing import Any

import numpy as np

from solar.versions import software_record
from studies.quantities import SIZED, reach

RECORDS = {
    # ---- What is analysed
    "Analysis": """
        *worst_scenario
        climb.program_excess_time_h?=climb_check_h.program_excess_time_h
        climb.one_minute_excess_time_h?=climb_check_h.one_minute_excess_time_h
        aircraft=aircraft.name mission=mission.name total_mass_kg=design.total_mass_kg
        masses_kg structure battery_energy_wh=design.battery_energy_wh
        propulsion_power_w=design.propulsion_power_w
        airspeed_m_per_s=design.airspeed_m_per_s power_budget airspeed_above_wind limited_flight
        relaxations extrapolations *software scenarios part_masses? beyond_parts?
        battery_condition? whole_cells?=cells drag_coefficients? balance? wind?
        from_catalogues?=aircraft.from_catalogues reading_notes? flight?
        """,
    "Scenario": """
        *quantities model=solar.model correction=solar.correction latitude_deg day_of_year date
        uncertainty.solar_power_rms_relative=solar.rms_relative
        uncertainty.excess_time_low_h=excess_time_low_h
        uncertainty.excess_time_high_h=excess_time_high_h climb?
        """,
    "WorstScenario": "latitude_deg day_of_year label",
    "CalendarRun": """
        launch=launch.text utc_offset_h=launch.utc_offset_h duration_h full_charge_clock_h
        minimum_state_of_charge final_state_of_charge empty_clock_h
        """,
    # ---- What is sized
    "SizingStudy": """
        status aircraft=aircraft.name mission=mission.name objective.name=objective.value
        objective.value=result.objective_value
        objective.required_excess_time_h=result.required_excess_time_h
        active_constraints=result.active_constraints violated_requirements=result.violations
        solver=result.solver *software battery_condition? nearest=result.nearest:NearestDesign
        quantities margins *result:Optimum power_out_w=optimum.power_out_w
        worst_scenario=optimum.worst_scenario:WorstScenario simulated=optimum:Reached
        power_budget=optimum.power_budget part_masses?=optimum.part_masses structure
        balance?=optimum.balance model=solar.model correction=solar.correction wind?
        uncertainty=optimum:LeastExcessTime extrapolations
        from_catalogues?=aircraft.from_catalogues reading_notes? range? relaxations? sensitivities?
        constraint_multipliers?=multipliers cross_check? with_margin?:Guarded as_assumed?:Reached
        reliability? weather?=survival whole_cells? whole_cells.solar_cells?=cells.solar_cells
        whole_cells.strings?=cells.strings whole_cells.battery_pack?=cells.battery_pack
        climb?=optimum.worst_scenario.climb without_climbs?:LevelFlight builds?
        """,
    "Optimum": """
        *design.variables:DesignVariables total_mass_kg=design.total_mass_kg masses_kg=design.masses
        wing_area_m2=design.wing_area_m2 airspeed_m_per_s=design.airspeed_m_per_s
        propulsion_power_w=design.propulsion_power_w
        """,
    "Guarded": """
        status solar_model_sigmas=mission.uncertainty_margins.solar_model_sigmas
        objective_value=result.objective_value *result:Optimum
        least_excess_time_h=optimum.excess_time_h excess_time_h=as_assumed.excess_time_h
        """,
    "LevelFlight": """
        status objective_value wingspan_m=design.variables.wingspan_m
        aspect_ratio=design.variables.aspect_ratio
        battery_mass_kg=design.variables.battery_mass_kg
        module_area_m2=design.variables.module_area_m2 total_mass_kg=design.total_mass_kg
        """,
    "BuiltDesign": """
        build factor of_file objective_value wingspan_m=design.variables.wingspan_m
        total_mass_kg=design.total_mass_kg battery_mass_kg=design.variables.battery_mass_kg
        module_area_m2=design.variables.module_area_m2
        """,
    "Reached": """
        excess_time_h charge_margin_h minimum_state_of_charge total_mass_kg
        model=performance.solar.model correction=performance.solar.correction
        """,
    "LeastExcessTime": """
        solar_power_rms_relative=performance.solar.rms_relative
        excess_time_low_h=low.least_excess_time_h excess_time_high_h=high.least_excess_time_h
        """,
    "NearestDesign": """
        *design.variables.chosen total_mass_kg=design.total_mass_kg
        excess_time_h=least_excess_time_h worst_scenario=worst_label
        """,
    "WholeCells": "loss relaxed:RelaxedCells chosen tried",
    "RelaxedCells": "value=objective_value *design.variables.chosen",
    "Relaxation": "+ text",
    "Reliability": """
        required achieved=achieved.value low=achieved.low high=achieved.high samples
        nominal=nominal.value nominal_objective
        """,
    "Sensitivity": "+ per_percent",
    "Survival": """
        *weather.origin flight_altitude_m=mission.altitude_m season required achieved
        days=days.closes.size days_that_close=days.that_close longest_gap_days=days.longest_gap_days
        by_year clear_sky.status=clear_sky.status clear_sky.objective=clear_sky.objective_value
        clear_sky.days_that_close=clear_sky_days.that_close clear_sky.share=clear_sky_days.share
        repairs=weather.repairs notes
        """,
    # ---- Draws
    "UncertaintyAnalysis": """
        aircraft=aircraft.name mission=mission.name climb?=mission.climb.record model=solar.model
        correction=solar.correction samples seed probability_perpetual
        required_excess_time_h=required_h probability_required nominal_excess_time_h *percentiles
        extrapolations sobol inputs=spreads
        """,
    # ---- In the weather
    "WeatherAnalysis": """
        *weather.origin flight_altitude_m=mission.altitude_m days days_that_close
        clear_sky_days_that_close=performance.clear.closes.sum
        longest_run_days=performance.recorded.longest_run_days
        clear_sky_longest_run_days=performance.clear.longest_run_days
        share_of_days_that_close=performance.recorded.closes.mean endurance_h flown_to_sunset_share
        launches_that_outlast_the_record=performance.recorded.outlasts.sum windows years
        year_to_year irradiation_kwh_per_m2 share_of_clear_sky_light=share_of_clear_light
        wind_above_airspeed_share battery_condition extrapolations repairs=weather.repairs notes
        model=performance.days.solar.model
        correction=performance.days.solar.correction
        """,
    # ---- Altitudes
    "Ceiling": """
        aircraft=aircraft.name mission=mission.name model=solar.model correction=solar.correction
        climb?=mission.climb.record required_excess_time_h=search.required_excess_time_h
        highest_perpetual_altitude_m=search.highest.altitude_m
        at_search_limit=search.at_search_limit best_altitude_m=search.best.altitude_m
        best_excess_time_h=search.best.excess_time_h
        extrapolations altitudes=search.flights
        """,
    "AltitudeFlight": "+ -extrapolations -maximum_altitude_m maximum_altitude_m?",
    "Station": """
        aircraft=aircraft.name mission=mission.name model=solar.model correction=solar.correction
        winds=source *places *columns at_fastest_airspeed=at_end extrapolations
        """,
    # ---- Models side by side
    "Comparison": """
        aircraft=aircraft.name mission=mission.name climb?=mission.climb.record summary=headline
        reference.model=reference.solar.model reference.correction=reference.solar.correction
        objective.name=objective.value objective.required_excess_time_h=required_excess_time_h
        cases notes extrapolations *software
        """,
    "Case": """
        model=solar.model correction=solar.correction solar_power_rms_relative=solar.rms_relative
        *prediction solar_energy_above_reference season=season_record design=built
        """,
    "Prediction": """
        status worst_scenario.latitude_deg=latitude_deg worst_scenario.day_of_year=day_of_year
        worst_scenario.label=scenario excess_time_h excess_time_low_h excess_time_high_h
        minimum_state_of_charge charge_margin_h endurance_h solar_energy_wh mean_solar_energy_wh
        maximum_altitude_m?
        """,
    "Built": """
        status=sizing.status *sizing.design.variables:DesignVariables
        total_mass_kg=sizing.design.total_mass_kg promised_excess_time_h violated_requirements
        """
    + "judged",
    "DesignVariables": """
        wingspan_m aspect_ratio battery_mass_kg module_area_m2 lift_coefficient payload_mass_kg
        payload_power_w propeller_diameter_m propeller_pitch_m gear_ratio
        motor_speed_constant_rpm_per_v
        """,
    # ---- Models against flights
    "Verification": """
        aircraft mission log.source log.start=log.time_s.0:utc log.end=log.time_s.-1:utc
        log.samples=log.time_s.size log.sunlit_samples=samples.time_s.size log.rows_read
        log.rows_dropped log.step_s log.gaps log.left_out applied models=samples.models
        excluded_samples=excluded.sum windows days estimates=estimates_by_name
        clock_heading_correlation=correlation rms_error_w.as_logged=rms_w.0
        rms_error_w.estimated=rms_w.1 residuals=residual_rows mppts=each_mppt left_out notes
        """,
    "Gap": "start=start_s:utc end=end_s:utc",
    "LeftOut": "column kind values start?=ends.0:utc end?=ends.1:utc",
    "Section": """
        label start=start_s:utc end=end_s:utc samples excluded_samples filter_s measured_mean_w
        models
        """,
    "Estimate": "+ -name",
    "Stretch": "reason count evidence start?=start_s:utc end?=end_s:utc",
    # ---- Parts of both
    "BalanceAssessment": """
        items horizontal_volume_for_static_margin=volume_for_margin mass_kg
        centre_of_gravity_m=gravity_m neutral_point_m=neutral_point.x_m
        aerodynamic_chord_m=wing.aerodynamic_chord_m
        aerodynamic_chord_leading_edge_m=chord_leading_edge_m static_margin
        downwash_slope=neutral_point.downwash lift_slope_per_rad=neutral_point.slope
        tail=planes
        tail_lift_coefficient=level.tail_lift wing_lift_coefficient=level.wing_lift
        trim_drag_coefficient=level.drag elevator_deg elevator_at_stall_deg elevator_limit_deg
        directional_slope_per_rad=directional_slope rudder_sideslip_deg=sideslip_deg
        rudder_crosswind_m_per_s=crosswind_m_per_s motor_out_rudder_share=motor_out
        """,
    "ClimbOfDay": """
        ceiling_m held_up_to_m? maximum_altitude_m gliding_h stored_height_wh climb_energy_wh
        constant_altitude_excess_time_h gain_in_excess_time_h dawn_altitude_m
        """,
    "DragShares": "+ parasitic total",
    "Extrapolation": "quantity label unit value + text",
    "PowerBudget": """
        aerodynamic_w=watts.aerodynamic_w propeller_loss_w=watts.propeller_loss_w
        gearbox_loss_w=watts.gearbox_loss_w motor_loss_w=watts.motor_loss_w
        controller_loss_w=watts.controller_loss_w wiring_loss_w=watts.wiring_loss_w
        propulsion_w=watts.propulsion_w turbulence_w=watts.turbulence_w avionics_w=watts.avionics_w
        payload_w=watts.payload_w supply_loss_w=watts.supply_loss_w heater_w=watts.heater_w
        bus_w efficiencies assumed_efficiency=assumed
        operating_point=point:OperatingPoint
        """,
    "OperatingPoint": "+ -reason",
    "StructureAssessment": "+ text=headline",
    "Wind": "percentile hold_station source scenarios_m_per_s",
}


def utc(time_s: float) -> str | None:
    """Return universal time [s since 1970] as ISO 8601, to the second; None where unknown."""
    if not math.isfinite(time_s):
        return None
    instant = datetime.datetime.fromtimestamp(round(float(time_s)), datetime.UTC)
    return instant.strftime("%Y-%m-%dT%H:%M:%SZ")


def serialise(value: Any, entry: str = "") -> Any:
    """Return a value as JSON has it: null for numbers that are infinite or not defined.

    ``entry``: of :data:`RECORDS`; by default that of the value's class.
    """
    return _finite(plain(value, entry))


def rows_of(values: Mapping[str, Any]) -> list[tuple[str, Any, str]]:
    """Return words, value and unit of a sized design's quantities; NaN where there is none."""
    shown = ((each, values.get(each.name, math.nan)) for each in (SIZED if values else SIZED[:10]))
    return [(each.label, value, each.unit) for each, value in shown if value is not None]


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def plain(value: Any, entry: str = "") -> Any:
    """Return a value as dicts, lists, numbers and texts, for frames: numbers as they are."""
    if isinstance(value, Enum):
        return value.name
    if value is None or isinstance(value, bool | str | int):
        return value
    if isinstance(value, float):
        return float(value)
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {getattr(key, "name", key): plain(item) for key, item in value.items()}
    if (name := entry or type(value).__name__) in RECORDS:
        return _record(value, name)
    if names := _names(value):
        return {name: plain(getattr(value, name)) for name in names}
    return [plain(item) for item in value]


def _record(value: Any, entry: str) -> dict[str, Any]:
    """Return the record of a value by its entry."""
    record: dict[str, Any] = {}
    if value is None:
        return {key: None for key, *_ in _keys(entry)}
    for key, optional, path, of in _keys(entry):
        if key == "+":
            record |= {name: plain(getattr(value, name)) for name in _names(value)}
        elif key.startswith("-"):
            del record[key[1:]]
        elif key == "*":
            joined = software_record() if path == "software" else reach(value, path)
            record |= _record(joined, of) if of else plain(joined)
        else:
            reached = reach(value, path)
            written = utc(reached) if of == "utc" else plain(reached, of)
            if optional and (written is None or (isinstance(reached, tuple) and not reached)):
                continue
            *outer, last = key.split(".")
            inside = record
            for name in outer:
                inside = inside.setdefault(name, {})
            inside[last] = written
    return record


@cache
def _keys(entry: str) -> list[tuple[str, bool, str, str]]:
    """Return the keys of an entry: key, whether it may be left out, path, entry of its value."""
    keys = []
    for word in RECORDS[entry].split():
        word, _, of = word.partition(":")
        key, _, path = word.partition("=")
        if key.startswith("*"):
            key, path = "*", key[1:]
        keys.append((key.rstrip("?"), key.endswith("?"), path or key.rstrip("?"), of))
    return keys


def _names(value: Any) -> tuple[str, ...]:
    """Return the names of the fields of a data class or a named tuple."""
    if is_dataclass(value):
        return tuple(declared.name for declared in fields(value))
    return getattr(value, "_fields", ())
