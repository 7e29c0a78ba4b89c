"""Checks of the quantities of a design and its flight against the ranges of models."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from missions.air import standard_air, thin_air_share
from missions.mission import Mission, Scenarios
from sizing.aerodynamics.parabolic import UserDragPolar
from sizing.aerodynamics.wing_polar import WingPolar
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.battery.battery import Battery, RuleChargeLimit, TableChargeLimit
from sizing.day.light import SolarDay, SolarModel
from sizing.design import Design, variables_of
from sizing.limits import QUANTITIES
from sizing.mass_budget import closed_design, parametric_design
from sizing.parameters import catalogue, value_at
from sizing.performance import Performance
from sizing.sized_structure import structure_masses_by_model, structure_parts
from sizing.structures.models import UserStructure
from sizing.structures.rib_wing import RibWingStructure
from sizing.validity.ranges import Check, experience, ranges
from solar.clearsky import THIN_AIR_FROM_M
from solar.schema import Allowed, spell
from solar.sun import declination

# Model name of rib wings with the keys of large wings, in the catalogue.
_LARGE = "rib_wing_large"
# In the flight of the report, 7 % less airspeed changes the solar power of FM by 0.4 %.
_AIRSPEED_TOLERANCE = 0.05


def design_checks(
    aircraft: Aircraft,
    mission: Mission,
    design: Design,
    solar: SolarModel,
    highest_m: ArrayLike | None = None,
) -> Iterator[Check]:
    """Yield the checks of a design in flight that do not depend on the scenario.

    ``highest_m``: highest altitude of a flight with climbs [m], of the shape of scenarios, cells,
    or designs with a last axis of scenarios. Altitude and air of a battery without a temperature in
    the file are checked there, all else at the mission's altitude.
    """
    loading = np.asarray(design.total_mass_kg) / design.wing_area_m2
    yield Check.of("wing_loading_kg_per_m2", "aircraft", loading)
    load_w = design.nominal_load_w(mission)
    yield Check.of("cruise_discharge_rate_per_h", "battery", load_w / design.battery_energy_wh)
    yield from technology_checks(aircraft)
    air = mission.air_state()
    air_c: ArrayLike = air.temperature_c
    altitude_m: ArrayLike = mission.altitude_m if highest_m is None else highest_m
    if highest_m is not None and aircraft.battery.temperature is None:
        offset_k = air.temperature_k - standard_air(mission.altitude_m).temperature_k
        air_c = standard_air(highest_m, offset_k).temperature_c
    yield from battery_checks(aircraft.battery, air_c, altitude_m)
    has_balance = "thermal" in aircraft.modules.model_fields_set
    if mission.air.module_temperature_c is None and not has_balance:
        yield Check.of("altitude_m", "module_temperature", altitude_m)
    yield Check.of("altitude_m", "model_error", altitude_m)
    if _uses_reported_errors(mission, solar):
        yield Check.of("altitude_m", "correction", altitude_m)
    if mission.clear_sky == "ashrae":  # a user-defined sky has no range
        altitude = np.asarray(altitude_m, float)
        thin = altitude >= THIN_AIR_FROM_M
        yield Check.of("altitude_m", "ashrae", np.where(thin, np.nan, altitude))
        yield Check.of("altitude_m", "thin_air", np.where(thin, altitude, np.nan))
    path_speed = getattr(mission.flight_path, "airspeed_m_per_s", None)
    if solar.needs_path and path_speed is not None and design.airspeed_m_per_s is not None:
        ends = (path_speed * (1.0 - _AIRSPEED_TOLERANCE), path_speed * (1.0 + _AIRSPEED_TOLERANCE))
        yield Check.of("airspeed_m_per_s", "flight_path", design.airspeed_m_per_s, ends)
    yield from wind_check(design, design.conditions.wind_m_per_s)
    airframe = aircraft.airframe
    if not isinstance(airframe, MeasuredAirframe):
        yield from _parametric_checks(aircraft, design)
        return
    flight, now = airframe.level_flight, design.conditions
    # At constant lift coefficient Re scales with (m rho)^0.5/mu; files have the density of the
    # measurement, and the viscosity is assumed to be that at standard sea level.
    mass_density = (design.total_mass_kg * now.density_kg_per_m3) / (
        flight.mass_kg * flight.density_kg_per_m3
    )
    viscosity = now.dynamic_viscosity / float(standard_air(0.0).dynamic_viscosity_pa_s)
    yield Check.of("reynolds_ratio", "measured", mass_density**0.5 / viscosity)
    if flight.maximum_electric_power_w is not None:
        climbing_w = flight.maximum_electric_power_w + design.constant_power_w
        rate = climbing_w / design.battery_energy_wh
        yield Check.of("climb_discharge_rate_per_h", "battery", rate)


def wind_check(design: Design, wind_m_per_s: ArrayLike) -> Iterator[Check]:
    """Yield the check of the airspeed against the wind, of all or of every cell [m/s]."""
    if design.airspeed_m_per_s is not None:
        ends = (wind_m_per_s, None)
        yield Check.of("airspeed_m_per_s", "wind", design.airspeed_m_per_s, ends)


def technology_checks(aircraft: Aircraft) -> Iterator[Check]:
    """Yield checks of the aircraft's technology parameters against values built or in sight."""
    for key, parameter in catalogue().items():
        value = value_at(aircraft, key) if parameter.kind == "technology" else None
        # An array holds the values of many draws.
        known = isinstance(value, int | float | np.ndarray)
        # Without a mass per watt the masses of the parts are given.
        if known and (key != "airframe.propulsion.mass_kg_per_w" or np.any(value)):
            ends = np.asarray(parameter.minimum), np.asarray(parameter.maximum)
            yield Check(experience(parameter), np.asarray(value, float), *ends)


def battery_checks(battery: Battery, air_c: ArrayLike, altitude_m: ArrayLike) -> Iterator[Check]:
    """Yield checks of the battery's temperature and age.

    Without a temperature in the file, the altitude from which a heater is assumed is checked, and
    below that altitude the air temperature.
    """
    if battery.temperature is None:
        assumed = thin_air_share(altitude_m) > 0.0
        yield Check.of("air_temperature_c", "battery", np.where(assumed, np.nan, air_c))
        yield Check.of("altitude_m", "battery", altitude_m)
    else:
        pack_c = battery.temperature.pack_c(air_c)
        yield Check.of("pack_temperature_c", "battery", pack_c)
    if battery.ageing is not None:
        left = battery.ageing.capacity_fraction()
        yield Check.of("aged_capacity_fraction", "battery", left)


def record_check(mission: Mission, site_altitude_m: float) -> Check:
    """Return the check of the largest height above the site of a weather record.

    ``site_altitude_m`` is the ground's altitude above mean sea level [m].
    """
    above_m = np.asarray(mission.climb_levels_m[-1]) - site_altitude_m
    return Check.of("height_above_record_m", "weather_record", above_m)


def _parametric_checks(aircraft: Aircraft, design: Design) -> Iterator[Check]:
    structure = aircraft.parametric.structure
    large = isinstance(structure, RibWingStructure) and structure.is_for_large_wings
    for quantity, value in (design.variables._asdict() | design._asdict()).items():
        default = (quantity, structure.model)
        row = (quantity, _LARGE) if large and (quantity, _LARGE) in ranges() else default
        if row in ranges():
            yield Check.of(*row, value)
    if isinstance(structure, RibWingStructure):
        # Thickness of both caps over the depth of the spar, mean over the span.
        with np.errstate(invalid="ignore", over="ignore"):  # of a design that cannot carry itself
            parts = structure_parts(aircraft, design)
        assert parts is not None
        span_m: Any = design.variables.wingspan_m
        chord_m = span_m / design.variables.aspect_ratio
        volume_m3 = parts.spar_caps / (structure.mass_factor * structure.cap_density_kg_per_m3)
        section_m2, width_m = volume_m3 / span_m, structure.cap_width_fraction * chord_m
        if structure.narrow_caps:
            width_m = np.minimum(width_m, structure.narrow_cap_width_m(section_m2 / 2.0))
        depth_m = structure.spar_depth_fraction * structure.thickness_ratio * chord_m
        share = section_m2 / (width_m * depth_m)
        yield Check.of("spar_cap_depth_ratio", structure.model, share)
    with np.errstate(invalid="ignore", over="ignore"):  # of a design that cannot carry itself
        by_model = structure_masses_by_model(aircraft, design)
        if by_model is not None:
            model, other = by_model
            masses = {name: np.asarray(mass, float) for name, mass in by_model.items()}
            ratio = masses[model] / masses[other]
            yield Check.of("structure_mass_ratio", model, ratio, masses_kg=masses)
    polar = aircraft.parametric.aerodynamics
    reynolds, speed = design.reynolds_number, design.airspeed_m_per_s
    if isinstance(polar, WingPolar):
        ends = polar.polar.reynolds_range
        yield Check.of("reynolds_number", "wing_polar", reynolds, ends, airspeed_m_per_s=speed)
        section = (polar.polar.least_lift, polar.polar.maximum_lift(np.asarray(reynolds, float)))
        low, high = (np.asarray(lift) / polar.section_lift_ratio for lift in section)
        yield Check.of("lift_coefficient", "wing_polar", design.lift_coefficient, (low, high))
        margin = stall_margin_within_polar(aircraft, design)
        yield Check.of("stall_margin", "wing_polar", margin, (polar.stall_margin, None))
    else:
        yield Check.of("reynolds_number", "parabolic", reynolds, airspeed_m_per_s=speed)
        yield Check.of("stall_margin", "parabolic", design.stall_margin)
    with np.errstate(invalid="ignore"):
        mach = design.airspeed_m_per_s / design.conditions.air.speed_of_sound_m_per_s
        yield Check.of("mach_number", "aerodynamics", mach)
        yield Check.of("propulsion_power_w", "propulsion", design.propulsion_power_w)
        rate = QUANTITIES["climb_discharge_rate_per_h"](design)
        yield Check.of("climb_discharge_rate_per_h", "battery", rate)


def stall_margin_within_polar(aircraft: Aircraft, design: Design) -> Any:
    """Return airspeed over stall speed, without lift beyond the airfoil's tables [-].

    Within the Reynolds numbers of the polar it is :attr:`sizing.Design.stall_margin`, by the design
    point of the aerodynamics.
    Outside of them the polar's bounded lift gives the stall: at constant weight the Reynolds number
    of the stall is that of the flight over the margin ``m``, so that ``m^2 C_L = C_L,max(Re/m)``.
    """
    polar = aircraft.parametric.aerodynamics
    assumed = np.asarray(design.stall_margin, float)
    if not isinstance(polar, WingPolar):
        return assumed
    reynolds = np.asarray(design.reynolds_number, float)
    low, high = polar.polar.reynolds_range
    known = (reynolds >= low) & (reynolds <= high)
    if np.all(known | ~np.isfinite(reynolds)):
        return assumed
    lift = np.asarray(design.lift_coefficient, float) * polar.section_lift_ratio
    margin = np.broadcast_to(assumed, np.broadcast_shapes(assumed.shape, reynolds.shape))
    for _ in range(60):
        # The geometric mean converges however steeply the bounded lift falls.
        following = (polar.polar.maximum_lift(reynolds / margin) / lift) ** 0.5
        margin = (margin * following) ** 0.5
    return np.where(known, assumed, margin)


def correction_check(scenarios: Scenarios, solar: SolarModel, mission: Mission) -> Iterator[Check]:
    """Yield the check of the noon elevation for corrections and errors from the reported flight.

    Scenarios without sunrise are NaN. Nothing is yielded where the mission's margins and the solar
    model use no constant of that flight.
    """
    if not _uses_reported_errors(mission, solar):
        return
    sun_deg = np.degrees(declination(scenarios.noon_day))
    noon_deg = 90.0 - np.abs(scenarios.latitude_deg - sun_deg)
    yield Check.of("noon_elevation_deg", "correction", np.where(noon_deg > 0.0, noon_deg, np.nan))


def _uses_reported_errors(mission: Mission, solar: SolarModel) -> bool:
    """Return whether a correction or a margin uses a constant of the reported flight."""
    return solar.correction != "none" or mission.uncertainty_margins.solar_model_sigmas != 0.0


def charge_rate_is_open(aircraft: Aircraft) -> bool:
    """Return whether no limit keeps the charge rate within the battery model's range."""
    limit = aircraft.battery.charge_limit
    if isinstance(limit, TableChargeLimit):
        return False  # measured
    highest = ranges()["charge_rate_per_h", "battery"].maximum
    assert highest is not None
    return not isinstance(limit, RuleChargeLimit) or limit.c_rate_per_h > highest


def charge_rate_check(
    aircraft: Aircraft, mission: Mission, design: Design, peak_power_w: ArrayLike
) -> Iterator[Check]:
    """Yield the check of the day's fastest charge, unless the charge limit is measured.

    ``peak_power_w``: largest solar power of the day [W], of the design's shape, or with a last axis
    of scenarios.
    """
    if not charge_rate_is_open(aircraft):
        return
    peak_w = np.asarray(peak_power_w, float)
    of_design = (design.nominal_load_w(mission), design.battery_energy_wh)
    load_w, energy_wh = (
        values.reshape(values.shape + (1,) * max(peak_w.ndim - values.ndim, 0))
        for values in (np.asarray(value, float) for value in of_design)
    )
    with np.errstate(invalid="ignore"):
        rate = (
            aircraft.battery.mean_charge_efficiency * np.maximum(peak_w - load_w, 0.0) / energy_wh
        )
    limit = aircraft.battery.charge_limit
    if isinstance(limit, RuleChargeLimit):
        rate = np.minimum(rate, limit.c_rate_per_h)
    yield Check.of("charge_rate_per_h", "battery", rate)


def flight_checks(aircraft: Aircraft, perf: Performance) -> list[Check]:
    """Return all checks of one or many designs, some with a last axis of scenarios."""
    highest_m = perf.maximum_altitude_m
    return day_checks(aircraft, perf.mission, perf.design, perf.solar, perf.day, highest_m)


def day_checks(
    aircraft: Aircraft,
    mission: Mission,
    design: Design,
    solar: SolarModel,
    day: SolarDay,
    highest_m: ArrayLike | None,
) -> list[Check]:
    """Return all checks of one or many designs on a day; ``highest_m``: of climbs [m]."""
    peak = np.max(day.specific_power_w_per_m2, axis=-1)
    area_m2 = np.asarray(design.variables.module_area_m2, float)[..., np.newaxis]
    elevation = correction_check(day.scenarios, solar, mission)
    return [
        *design_checks(aircraft, mission, design, solar, highest_m),
        *(check.over(area_m2.shape[:-1]) for check in elevation),
        *charge_rate_check(aircraft, mission, design, peak * area_m2),
    ]


# Total mass over battery and payload, for a design to evaluate where no mass budget closes.
_USUAL_MASS = 3.0


def check_user_models(aircraft: Aircraft, mission: Mission, design: Design | None = None) -> None:
    """Refuse user-defined models with an impossible value, by a ValueError that names the model.

    They are evaluated at ``design``, by default that of the aircraft's file.
    """
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return
    structure, polar = aircraft.airframe.structure, aircraft.airframe.aerodynamics
    propulsion = aircraft.airframe.propulsion
    names = (
        structure.name if isinstance(structure, UserStructure) else None,
        polar.name if isinstance(polar, UserDragPolar) else None,
        getattr(propulsion, "mass_model", None),
        getattr(propulsion, "efficiency_model", None),
    )
    if not any(names):
        return
    if design is None:
        variables = variables_of(aircraft)
        mass_kg = float(closed_design(aircraft, mission, variables).total_mass_kg)
        if not np.isfinite(mass_kg):
            mass_kg = _USUAL_MASS * (aircraft.battery.mass_kg + mission.payload.mass_kg)
        design = parametric_design(aircraft, mission, variables, mass_kg)
    assert design.chain is not None
    efficiency = float(design.chain.efficiency)
    drag_w = design.thrust_power_w if efficiency else math.inf
    values = (
        ("register_structure", design.masses.structure, math.inf, "kg"),
        ("register_drag", drag_w, math.inf, "W of drag times airspeed"),
        ("register_propulsion_mass", design.masses.propulsion, math.inf, "kg"),
        ("register_propulsion_efficiency", efficiency, 1.0, "of the whole chain"),
    )
    for name, (register, value, most, unit) in zip(names, values, strict=True):
        allowed = Allowed(0.0, most, above=True)
        if name is not None and not allowed.holds(float(value)):
            numbers = (value, design.variables.wingspan_m, design.total_mass_kg)
            found, span_m, mass = (spell(float(number), 4) for number in numbers)
            raise ValueError(
                f"the function {name!r} of sizing.{register} gives {found} {unit} at {span_m} m of "
                f"span and a total mass of {mass} kg: it must be {allowed}"
            )
