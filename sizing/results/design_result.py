"""What results of an analysis and of a sizing have in common: a design, part by part."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.air import GRAVITY_M_PER_S2
from missions.files.overrides import with_values
from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.day.load import flight_of, load_shape
from sizing.design import Design
from sizing.limits import QUANTITIES
from sizing.mass_budget import level_point, parametric_design
from sizing.parameters import label, unit, unit_text
from sizing.performance import Performance
from sizing.propulsion.chain import LINKS
from sizing.propulsion.part_masses import motor_mass_fit, propeller_mass_fit
from sizing.results.result import Result, finite
from sizing.validity.checks import check_user_models
from solar.schema import Record

if TYPE_CHECKING:
    from sizing.propulsion.operating_point import OperatingPoint


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


# ---- Battery in its air, wind, whole cells


class Spread(NamedTuple):
    """What changes with the days of a weather record."""

    lowest: float
    mean: float
    highest: float

    @classmethod
    def of(cls, values: Any) -> Spread:
        """Return the ends and the mean of values; nothing times what is below zero is plain 0."""
        return cls(*(float(end(values)) + 0.0 for end in (np.min, np.mean, np.max)))


class BatteryCondition(NamedTuple):
    """Battery in the air of a mission, or of the days of a weather record; aged as its file says.

    ``pack_temperature_c``: None where no temperature is held.
    """

    pack_temperature_c: float | Spread | None
    heater_power_w: float | Spread
    cycles: float | None
    months: float | None
    capacity_fraction: float | Spread
    charge_efficiency: float
    discharge_efficiency: float


def battery_condition(
    aircraft: Aircraft, air_c: ArrayLike, altitude_m: float, mass_kg: float | None = None
) -> BatteryCondition | None:
    """Return the battery in air, or in the mean air of each day, at an altitude [C, m].

    The margin of its capacity is not counted. ``mass_kg``: that of a sized design. None for a
    battery without temperature, resistance and ageing.
    """
    reported: Callable[[Any], Any] = Spread.of if np.ndim(air_c) else float
    battery, aged = aircraft.battery, aircraft.battery.ageing
    held, _ = battery.temperature_at(altitude_m)
    if not any((held, battery.resistance, aged)):
        return None
    return BatteryCondition(
        pack_temperature_c=None if held is None else reported(held.pack_c(air_c)),
        heater_power_w=reported(battery.heater_w(air_c, altitude_m, mass_kg)),
        cycles=None if aged is None else float(aged.total_cycles),
        months=None if aged is None else float(aged.total_months),
        capacity_fraction=reported(battery.capacity_fraction(air_c, altitude_m)),
        charge_efficiency=float(battery.mean_charge_efficiency),
        discharge_efficiency=float(battery.mean_discharge_efficiency),
    )


class Wind(NamedTuple):
    """Percentile of a table of winds, and its wind in every scenario [m/s].

    ``ends_m_per_s``: weakest and strongest at the altitudes of the flight, ``heights`` of which are
    known.
    """

    percentile: float
    hold_station: bool
    source: str
    scenarios_m_per_s: tuple[float, ...]
    ends_m_per_s: tuple[float, float]
    heights: int


def wind_of(mission: Mission) -> Wind | None:
    """Return the wind of every scenario; None for one that the mission gives."""
    statistics = mission.wind_statistics
    if statistics is None:
        return None
    heights_m = mission.climb_levels_m if statistics.hold_station else [mission.altitude_m]
    speeds = [mission.at_altitude(height_m).scenario_winds_m_per_s() for height_m in heights_m]
    return Wind(
        statistics.percentile,
        statistics.hold_station,
        statistics.table(mission.longitude_deg).source,
        tuple(mission.scenario_winds_m_per_s().tolist()),
        (float(np.min(speeds)), float(np.max(speeds))),
        len(heights_m),
    )


def cells_record(aircraft: Aircraft) -> dict[str, Any]:
    """Return solar cells, strings and pack of an aircraft; empty without whole cells."""
    layout, pack, battery = aircraft.modules.layout, aircraft.battery.pack, aircraft.battery
    record: dict[str, Any] = {}
    if layout is not None:
        record["solar_cells"] = {
            "count": layout.count,
            "area_m2": layout.area_m2,
            "mass_kg": layout.area_m2 * aircraft.modules.mass_kg_per_m2,
            "rows_of_each_half": [list(bay.cells) for bay in layout.bays],
            "tail_rows": list(layout.tail_cells),
        }
        if layout.strings is not None:
            record["strings"] = _strings_record(aircraft)
    if pack is not None:
        low_v, high_v = battery.ends_v or (None, None)
        record["battery_pack"] = {
            "cells_in_series": pack.cells_in_series,
            "cells_in_parallel": pack.cells_in_parallel,
            "mass_kg": battery.mass_kg,
            "battery_energy_wh": battery.battery_energy_wh,
            "empty_voltage_v": low_v,
            "full_voltage_v": high_v,
            "charge_current_a": pack.charge_current_a,
        }
    return record


def _strings_record(aircraft: Aircraft) -> dict[str, Any]:
    """Return strings, their voltages at the coldest and hottest modules, and their MPPTs."""
    layout = aircraft.modules.layout
    strings = None if layout is None else layout.strings
    assert layout is not None
    assert strings is not None
    assert strings.mpp_voltage_v is not None
    assert strings.open_circuit_voltage_v is not None
    loss, lengths = aircraft.modules.temperature_coefficient_per_k, strings.lengths(layout.count)
    mpp, unloaded = strings.mpp_voltage_v, strings.open_circuit_voltage_v
    shortest, longest = min(lengths), max(lengths)
    return {
        "count": len(lengths),
        "cells_in_series": longest if shortest == longest else list(lengths),
        "mppts": strings.mppts(layout.count),
        "hottest_mpp_voltage_v": shortest * strings.voltage_v(mpp, strings.hottest_c, loss),
        "coldest_mpp_voltage_v": longest * strings.voltage_v(mpp, strings.coldest_c, loss),
        "coldest_open_voltage_v": longest * strings.voltage_v(unloaded, strings.coldest_c, loss),
    }


# ---- Power of level flight, parts of the propulsion


@dataclass(frozen=True)
class PowerBudget:
    """Power of level flight, with the turbulence of all hours.

    ``watts``: by the keys of its rows [W], which add up to ``bus_w``; a measured aircraft has
    ``propulsion_w`` instead of drag and losses. ``efficiencies``: of the links and of the chain
    [-], empty for a measured aircraft. ``point``: of one propulsor, where the aircraft's file says
    what it is made of. ``assumed``: efficiency of the chain that the design was found with [-].
    """

    watts: dict[str, float]
    efficiencies: dict[str, float]
    point: OperatingPoint | None
    assumed: float | None

    @property
    def bus_w(self) -> float:
        """Sum of the rows [W]."""
        return sum(self.watts.values())


def power_budget(aircraft: Aircraft, mission: Mission, design: Design) -> PowerBudget:
    """Return the power budget of a design in level flight on a mission.

    The design may be an optimum with the aircraft's technology. An operating point is computed
    anew, at the design's mass.
    """
    level_w, chain = float(design.propulsion_power_w), design.chain
    point = assumed = None
    watts, efficiencies = {"propulsion_w": level_w}, {}
    if chain is not None:
        assumed = float(chain.efficiency)
        thrust_w, efficiencies = level_w * assumed, chain.links
        if aircraft.propulsion_by_parts is not None:
            point = level_point(aircraft, mission, design)
            efficiencies = {k: float(getattr(point, f"{v}_efficiency")) for k, v in LINKS.items()}
        efficiencies = {k: float(v) for k, v in efficiencies.items()}
        watts, after = {"aerodynamic_w": thrust_w}, thrust_w
        for link in reversed(LINKS):
            before = after / efficiencies[link]
            watts[f"{link}_loss_w"], after = before - after, before
        efficiencies["chain"], level_w = thrust_w / after, after
    power, chosen = aircraft.power, design.variables.payload_power_w
    payload_w = mission.payload.power_w if chosen is None else float(chosen)
    consumers_w = power.avionics_w + payload_w
    supplied_w = consumers_w / power.supply_efficiency
    watts |= {
        "turbulence_w": level_w * mission.turbulence.all_day,
        "avionics_w": power.avionics_w,
        "payload_w": payload_w,
        "supply_loss_w": supplied_w - consumers_w,
        "heater_w": float(design.constant_power_w) - supplied_w,
    }
    return PowerBudget(watts, efficiencies, point, assumed)


class PartMasses(NamedTuple):
    """Estimated masses of one propulsor [kg]; None for a part whose mass is known.

    ``motor_scatter``, ``propeller_scatter``: one standard deviation of those of the catalogue, as a
    factor.
    """

    motor_kg: float | None
    motor_scatter: float | None
    gearbox_kg: float | None
    propeller_kg: float | None
    propeller_scatter: float | None


def part_masses(aircraft: Aircraft, design: Design) -> PartMasses | None:
    """Return the estimated masses of a design's propulsion; None where nothing is estimated."""
    propulsion, chain = aircraft.propulsion_by_parts, design.chain
    if propulsion is None or not propulsion.estimates_masses:
        return None
    assert chain is not None
    chosen = propulsion.sized(*design.variables.mapped(float).of_propulsion)
    # Wound anew it has the mass that it had.
    motor = None if propulsion.motor_constants.mass_kg is not None else propulsion.motor_mass_kg
    gears_kg = float(design.masses.propulsion) - float(chain.fixed_mass_kg or 0.0)
    has_gear = chosen.gear.mass_kg is None and chosen.gear.ratio != 1.0
    propeller = None if chosen.propeller.mass_kg is not None else float(chosen.propeller_kg)
    if motor is None and propeller is None and not has_gear:
        return None
    return PartMasses(
        propeller_kg=propeller,
        propeller_scatter=None if propeller is None else propeller_mass_fit().scatter,
        motor_kg=motor,
        motor_scatter=None if motor is None else motor_mass_fit().scatter,
        gearbox_kg=gears_kg / chosen.propulsors if has_gear else None,
    )


def beyond_parts(aircraft: Aircraft, performance: Performance) -> str | None:
    """Return why the propulsion's parts cannot do the greatest load of the day; None if they can.

    Of a single design, with climbs that of level flight.
    """
    if aircraft.propulsion_by_parts is None:
        return None
    mission, day = performance.mission, performance.day
    shape = load_shape(mission, day.time_h, day.sunrise_h, day.sunset_h)
    propulsion, flight = flight_of(aircraft, mission, performance.design)
    bus_v = aircraft.battery.nominal_voltage_v
    point = propulsion.point(flight.thrust_w * np.max(shape), *flight[1:], (bus_v,))
    return str(point.reason) or None


# ---- How far a design is from every requirement on it
#
# Besides what is demanded, two margins that a design office looks at: airspeed over stall speed,
# and climb at the highest altitude and with an empty battery.

# Take-off safety speed over stall speed, CS-23.51 and 14 CFR 23.51 (amendment 62).
RECOMMENDED_STALL_MARGIN = 1.2
# Thrusts over that of level flight in which the largest is searched for.
_THRUSTS, _COARSE = np.geomspace(1.0, 30.0, 241), 16


class RequirementMargin(NamedTuple):
    """A requirement: value, limit, and by how much it is met.

    ``margin`` is relative to the limit, in the unit where ``relative`` is false; below 0 where the
    requirement is missed. ``recommended``: nobody demands it.
    """

    name: str
    label: str
    value: float
    limit: float
    unit: str
    margin: float
    relative: bool = True
    recommended: bool = False


def requirement_margins(
    aircraft: Aircraft, performance: Performance, required_h: float
) -> list[RequirementMargin]:
    """Return the margins of a single simulated design.

    ``aircraft``: with the technology of the design. ``required_h``: excess time that is required of
    every scenario [h].
    """
    mission, design, worst = performance.mission, performance.design, performance.worst_scenario()
    excess_h = float(performance.cycle.excess_time_h[worst])
    charge_percent = 100.0 * float(performance.cycle.minimum_state_of_charge[worst])
    at = performance.worst_label
    charge_name, charge_label = "minimum_state_of_charge", f"minimum state of charge, {at}"
    margins = [
        _absolute("excess_time_h", f"excess time, {at}", excess_h, required_h, "h"),
        _absolute(charge_name, charge_label, charge_percent, 0.0, "%"),
    ]
    winds = mission.wind_to_beat_m_per_s(mission.scenario_winds_m_per_s(performance.day.scenarios))
    wind = float(np.max(winds))
    if wind > 0.0 and design.airspeed_m_per_s is not None:
        speed = float(design.airspeed_m_per_s)
        name, text = "airspeed_above_wind", "airspeed above the wind"
        margins.append(_at_least(name, text, speed, wind, "m/s"))
    if isinstance(aircraft.airframe, ParametricAirframe):
        margins += _of_parametric(aircraft, mission, design)
    return margins


def _of_parametric(
    aircraft: Aircraft, mission: Mission, design: Design
) -> Iterator[RequirementMargin]:
    covered = float(design.variables.module_area_m2 / design.wing_area_m2)
    most = aircraft.parametric.maximum_module_coverage
    yield _at_most("module_coverage", "modules over wing area", covered, most, "")
    limits = aircraft.design_space.limit_rows()
    for name, limit in limits.items():
        value, of = float(QUANTITIES[limit.quantity](design)), unit_text(unit(limit.quantity))
        margin = _at_least if limit.end == "minimum" else _at_most
        yield margin(name, label(limit.quantity), value, limit.value, of)
    if not any(limit.quantity == "stall_margin" for limit in limits.values()):
        least = RECOMMENDED_STALL_MARGIN
        margin_of_stall = _at_least(
            "stall_margin", label("stall_margin"), float(design.stall_margin), least, ""
        )
        yield margin_of_stall._replace(recommended=True)
    yield from _of_propulsion(aircraft, mission, design, float(design.rated_power_w))


def _of_propulsion(
    aircraft: Aircraft, mission: Mission, design: Design, rated_w: float
) -> Iterator[RequirementMargin]:
    """Yield the climb at the highest altitude: at rated power, and with an empty battery.

    Then the limits of parts in level flight with an empty battery.
    """
    highest_m = mission.ceiling_m
    there = mission.at_altitude(highest_m) if highest_m > mission.altitude_m else mission
    mass_kg = float(design.total_mass_kg)
    level = parametric_design(aircraft, there, design.variables, mass_kg)
    assert level.chain is not None
    weight_n = mass_kg * GRAVITY_M_PER_S2
    excess_w = (rated_w - float(level.propulsion_power_w)) * float(level.chain.efficiency)
    at = f"at {highest_m:g} m"
    name, text = "climb_rate_at_highest_altitude_m_per_s", f"climb rate at rated power {at}"
    yield _absolute(name, text, excess_w / weight_n, 0.0, "m/s")._replace(recommended=True)
    if (propulsion := aircraft.propulsion_by_parts) is None:
        return
    thrust_w = float(level.thrust_power_w)
    speed, air = float(level.airspeed_m_per_s), level.conditions.air
    chosen = propulsion.sized(*design.variables.mapped(float).of_propulsion)
    empty_v = float(aircraft.battery.bus_voltage_v(np.zeros(())))
    most, thrusts = np.nan, _THRUSTS[::_COARSE]
    for _ in range(2):
        points = chosen.point(thrust_w * thrusts, speed, air, (empty_v,))
        able = np.flatnonzero(np.asarray(points.reason) == "")
        if not able.size:
            break
        most = float(thrusts[able[-1]])
        # The thrusts up to the next of the coarse ones.
        thrusts = _THRUSTS[(most <= _THRUSTS)][:_COARSE]
    name, text = "climb_rate_with_empty_battery_m_per_s", f"climb rate, empty battery, {at}"
    climb = (most - 1.0) * thrust_w / weight_n
    yield _absolute(name, text, climb, 0.0, "m/s")._replace(recommended=True)
    thrust_w = float(design.thrust_power_w)
    speed, air = float(design.airspeed_m_per_s), design.conditions.air
    point = chosen.point(thrust_w, speed, air, (empty_v,))
    yield _at_most("duty", "duty of the controller, empty battery", float(point.duty), 1.0, "")
    mach = chosen.maximum_tip_mach
    yield _at_most("tip_mach", "Mach number of the tips", float(point.tip_mach), mach, "")
    current = chosen.motor_constants.maximum_current_a
    if current is not None:
        used = float(point.motor_current_a)
        yield _at_most("motor_current", "current of the motor", used, current, "A")


def _absolute(name: str, text: str, value: float, limit: float, of: str) -> RequirementMargin:
    return RequirementMargin(name, text, value, limit, of, value - limit, relative=False)


def _at_least(name: str, text: str, value: float, limit: float, of: str) -> RequirementMargin:
    return RequirementMargin(name, text, value, limit, of, value / limit - 1.0)


def _at_most(name: str, text: str, value: float, limit: float, of: str) -> RequirementMargin:
    return RequirementMargin(name, text, value, limit, of, 1.0 - value / limit)
