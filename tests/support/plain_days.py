"""Suns and batteries of plain days, and laws of theirs written out for one number."""

from itertools import pairwise
from math import exp, inf, log, pi

from missions.air import GRAVITY_M_PER_S2
from sizing.battery.battery import Battery, NoChargeLimit, RuleChargeLimit, TableChargeLimit
from sizing.day.light import day_axis_h
from solar.horizontal_models import horizontal_specific_power
from solar.modules import SolarCell

TIME = day_axis_h()


def sun(latitude, day, time=TIME):
    """Power of 1.35 m2 of modules [W] on a day at a latitude."""
    return 1.35 * horizontal_specific_power(
        latitude, day + 0.5, time, cell=SolarCell(), module_temperature_c=25.0, altitude_m=500.0
    )


def battery(energy_wh, limit=None):
    return Battery(
        mass_kg=energy_wh / 250.0,
        specific_energy_wh_per_kg=250.0,
        charge_limit=NoChargeLimit() if limit is None else limit,
    )


def rate_per_h(limit, soc):
    """Charge rate [1/h] at a state of charge, independently of the module that has it."""
    if isinstance(limit, RuleChargeLimit):
        way = max(soc - limit.taper_start, 0.0) / (1.0 - limit.taper_start)
        return limit.c_rate_per_h * exp(way * log(limit.relative_rate_at_full))
    if not isinstance(limit, TableChargeLimit):
        return inf
    points = list(zip(limit.state_of_charge, limit.current_a, strict=True))
    soc = min(max(soc, points[0][0]), points[-1][0])
    (x0, y0), (x1, y1) = next(each for each in pairwise(points) if soc <= each[1][0])
    current_a = y0 + (y1 - y0) * (soc - x0) / (x1 - x0)
    return current_a * limit.voltage_v / limit.pack_energy_wh


def parabolic_power_w(plane, design, air, airspeed):
    """Electric power of level flight of an aircraft with a parabolic polar, at an airspeed."""
    frame, area = plane.parametric, float(design.wing_area_m2)
    polar, chord = frame.aerodynamics, frame.wingspan_m / frame.aspect_ratio
    density = float(air.density_kg_per_m3)
    pressure = 0.5 * density * airspeed**2
    lift = float(design.total_mass_kg) * GRAVITY_M_PER_S2 / (pressure * area)
    reynolds = density / float(air.dynamic_viscosity_pa_s) * airspeed * chord
    drag = (
        polar.profile_drag_coefficient
        * (reynolds / polar.reference_reynolds) ** -polar.reynolds_exponent
        + polar.parasitic_drag_coefficient
        + lift**2 / (pi * polar.span_efficiency * frame.aspect_ratio)
    )
    return pressure * airspeed * area * drag / float(design.chain.efficiency)
