"""Load of a flight in level flight, and the charge that measured power and load lead to."""

from __future__ import annotations

import numpy as np

from missions.air import (
    MAXIMUM_ALTITUDE_M,
    MINIMUM_ALTITUDE_M,
    ZERO_CELSIUS_K,
    air_at,
    standard_air,
)
from missions.logs.table import FlightLog
from sizing.aircraft import Aircraft
from sizing.mass_budget import design_of
from solar.types import BoolArray, FloatArray
from studies.fitting.channels.bins import Bins, long_stretches
from studies.fitting.channels.channel import Channel, Flown, ambient_c
from studies.fitting.channels.solar import NEARLY_FULL

NEARLY_EMPTY = 0.02  # charge at which a gauge is held and no longer counts; assumption
# Faster climbs need power of their own; 0.1 m/s of an aircraft of 7 kg takes 11 W; assumption.
_FASTEST_CLIMB_M_PER_S = 0.05
_SHORTEST_NIGHT_S = 3600.0
# Shorter stretches of charge are not worth a level of their own; assumption.
_SHORTEST_STRETCH_S = 7200.0


def load_channel(flown: Flown) -> Channel | str:
    """Load in level flight, by night if there is one: thermals and work are of the day."""
    log = flown.log
    if log.load_w is None:
        return "the log has no load_w"
    known = ~np.isnan(log.load_w)
    dark = np.ones(len(log), bool)
    dark[flown.found.samples.index] = False
    note = "by night alone"
    if np.count_nonzero(known & dark) * log.step_s < _SHORTEST_NIGHT_S:
        dark, note = np.ones(len(log), bool), "by day and night, since the night is too short"
    use = known & dark & ~_climbing(log)
    bins = Bins.of(log.time_s, log.segment(), use)
    height_m = np.clip(log.altitude_m[use], MINIMUM_ALTITUDE_M, MAXIMUM_ALTITUDE_M)
    kelvin = ambient_c(flown, np.flatnonzero(use)) + ZERO_CELSIUS_K
    density = air_at(kelvin, standard_air(height_m).pressure_pa).density_kg_per_m3
    mission = flown.mission
    mean_density = float(mission.air_state().density_kg_per_m3)
    thinner = bins.mean(np.sqrt(mean_density / density))

    def predict(aircraft: Aircraft) -> FloatArray:
        design = design_of(aircraft, mission)
        level_w = float(design.propulsion_power_w) * (1.0 + mission.turbulence.all_day)
        return np.asarray(level_w * thinner + float(design.constant_power_w))

    return Channel(
        *("load", "load", "W", bins.mean(log.time_s[use]), bins.mean(log.load_w[use]), bins.run),
        predict,
        notes=(f"load {note}, without climbs",),
    )


def _climbing(log: FlightLog) -> BoolArray:
    """Samples in bins over which the altitude rises or falls faster than level flight does."""
    bins = Bins.of(log.time_s, log.segment(), np.ones(len(log), bool))
    mean_m, mean_s = bins.mean(log.altitude_m), bins.mean(log.time_s)
    if len(mean_m) < 2:
        return np.zeros(len(log), bool)
    rate = np.gradient(mean_m, mean_s)
    return np.asarray(np.abs(rate[bins.number]) > _FASTEST_CLIMB_M_PER_S)


def charge_channel(flown: Flown) -> Channel | str:
    """State of charge, from the measured power and load.

    ``dE/dt = eta_charge (P_solar - P_load)`` by surplus, over ``eta_discharge`` by deficit: the
    balance of :mod:`sizing.energy.march`, integrated from sample to sample by the trapezoidal rule.
    """
    log = flown.log
    if log.state_of_charge is None or log.load_w is None:
        lacking = "state_of_charge" if log.state_of_charge is None else "load_w"
        return f"the log has no {lacking}"
    charge, load = log.state_of_charge, log.load_w
    known = ~np.isnan(charge) & ~np.isnan(load)
    inside = known & (charge < NEARLY_FULL) & (charge > NEARLY_EMPTY)
    net_w = np.where(known, log.solar_power_w - np.nan_to_num(load), 0.0)
    # A gap, and a stretch at either end of the gauge, end a stretch: energy goes uncounted there.
    run = np.cumsum(np.diff(inside.astype(int), prepend=0) != 0) + 2 * len(log) * log.segment()
    inside &= long_stretches(log.time_s, run, _SHORTEST_STRETCH_S)
    bins = Bins.of(log.time_s, run, inside)
    hours = np.diff(log.time_s, prepend=log.time_s[0]) / 3600.0
    hours[1:][np.diff(run) != 0] = 0.0

    def trapezoid(power_w: FloatArray) -> FloatArray:
        """Integral from the start of the log, nothing across the ends of stretches [Wh]."""
        mean_w = 0.5 * (power_w + np.concatenate((power_w[:1], power_w[:-1])))
        return np.cumsum(mean_w * hours)

    surplus = bins.mean(trapezoid(np.maximum(net_w, 0.0))[inside])
    deficit = bins.mean(trapezoid(np.maximum(-net_w, 0.0))[inside])
    air_c = float(flown.mission.air_state().temperature_c)

    def predict(aircraft: Aircraft) -> FloatArray:
        battery = aircraft.battery
        stored = surplus * battery.mean_charge_efficiency
        drawn = deficit / battery.mean_discharge_efficiency
        energy_wh = battery.battery_energy_wh * battery.capacity_fraction(air_c)
        return np.asarray((stored - drawn) / energy_wh, float)

    return Channel(
        *("charge", "state of charge", "", bins.mean(log.time_s[inside])),
        *(bins.mean(charge[inside]), bins.run, predict),
        floating=True,
        notes=(f"charge between {NEARLY_EMPTY:.0%} and {NEARLY_FULL:.0%}",),
    )
