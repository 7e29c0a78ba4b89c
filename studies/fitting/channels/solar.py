"""Solar power of a flight, and which of it is the modules' own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sizing.aircraft import Aircraft
from sizing.energy.battery import NoChargeLimit, charge_rate_per_h
from solar.horizontal_models import conceptual_analysis_model
from solar.types import BoolArray, FloatArray, IntArray
from studies.fitting.channels.bins import Bins
from studies.fitting.channels.channel import Channel, Flown, Predict, ambient_c
from studies.fitting.channels.flight_errors import CAM_SIGMA, flight_errors
from studies.flight_logs.causes.forward import Forward, LogError
from studies.flight_logs.verification import Verification

# Below, no air-mass formula is good, and horizon and haze decide; assumption.
LOWEST_SUN_DEG = 5.0
# Charge at which a battery may be taken for full; assumption.
NEARLY_FULL = 0.98
# Share of what the battery and the load can take from which power may be held back; assumption:
# the errors of the model and of the logged charge.
_MAY_BE_LIMITED = 0.9


def solar_channel(flown: Flown, aircraft: Aircraft, light_sigma: float) -> Channel:
    """Solar power in sunlight without limits: Full Model where it is known enough, else CAM."""
    samples = flown.found.samples
    high = samples.elevation_deg >= LOWEST_SUN_DEG
    faulty = _in_faults(flown.found)
    limited = flown.found.excluded | _may_be_limited(flown, aircraft)
    use = high & ~faulty & ~limited
    bins = Bins.of(samples.time_s, samples.run, use)
    notes = [f"{_hours_of(high & limited, flown)} h with charging that may be limited are left out"]
    notes += [f"{_hours_of(high & faulty, flown)} h with power missing are left out"]
    index = np.asarray(samples.index[use], int)
    model = solar_model(flown, index)
    name = "FM" if samples.detail is not None else "CAM"
    if name == "CAM":
        notes.append(
            "without attitude or module surfaces the modules are fitted to CAM, whose own error "
            f"(RMS {100.0 * CAM_SIGMA:.0f} % of the mean power) the intervals count as one factor"
        )
    return Channel(
        name="solar",
        label=f"solar power ({name})",
        unit="W",
        time_s=bins.mean(samples.time_s[use]),
        measured=bins.mean(samples.measured_w[use]),
        run=bins.run,
        predict=lambda craft: bins.mean(model(craft)),
        notes=tuple(note for note in notes if not note.startswith("0.0 h")),
        errors=flight_errors(forward_model(flown, index), light_sigma, bins.mean),
    )


def _hours_of(mask: BoolArray, flown: Flown) -> str:
    return f"{float(mask.sum()) * flown.log.step_s / 3600.0:.1f}"


def _in_faults(verification: Verification) -> BoolArray:
    """Samples within periods in which modules or MPPT give less than they can."""
    time_s = verification.samples.time_s
    marked = np.zeros(len(time_s), bool)
    for one in verification.anomalies:
        if one.kind in ("mppt_not_tracking", "modules_missing", "power_loss", "cloud"):
            marked |= (time_s >= one.start_s) & (time_s <= one.end_s)
    return marked if not marked.all() else np.zeros(len(time_s), bool)


def _may_be_limited(flown: Flown, aircraft: Aircraft) -> BoolArray:
    """Samples whose power the battery may not take, by model and logged charge.

    Decided without the measured power: leaving out what measures low would make the rest high.
    """
    samples, log = flown.found.samples, flown.log
    if log.state_of_charge is None:
        return np.zeros(len(samples.time_s), bool)
    charge = np.nan_to_num(log.state_of_charge[samples.index], nan=0.0)
    marked, battery = np.asarray(charge >= NEARLY_FULL), aircraft.battery
    if log.load_w is None or isinstance(battery.charge_limit, NoChargeLimit):
        return marked
    load_w = np.nan_to_num(log.load_w[samples.index], nan=np.inf)
    taken_w = charge_rate_per_h(battery.charge_limit, charge) * battery.battery_energy_wh
    taken_w = taken_w / float(battery.mean_charge_efficiency) + load_w
    model_w = samples.modelled_w.get("FM", samples.modelled_w["CAM"])
    return np.asarray(marked | (model_w > _MAY_BE_LIMITED * taken_w))


def forward_model(flown: Flown, index: IntArray) -> Forward:
    """Model of the power at samples of a log: the Full Model if it can be computed, else CAM."""
    craft, known = flown.found.craft, flown.found.samples.detail is not None
    geometry = craft.modules.geometry if known else None
    return Forward(flown.log, craft, flown.mission, geometry, None, index)


def solar_model(flown: Flown, index: IntArray) -> Predict:
    """Power of an aircraft's modules at samples of a log [W]."""
    mission, forward = flown.mission, forward_model(flown, index)
    given, ambient = forward.sunlight(LogError()), ambient_c(flown, index)

    def power_w(aircraft: Aircraft) -> FloatArray:
        modules = aircraft.modules
        if given.to_ned is None or modules.geometry is None:
            module_c = mission.air.module_temperature_c
            constant_c = float(ambient.mean()) if module_c is None else module_c
            specific = conceptual_analysis_model(given.light, given.sine, modules, constant_c)
        else:
            own = replace(forward, aircraft=aircraft, geometry=modules.geometry)
            specific = own.full(given, ambient).specific_power_w_per_m2
        return np.asarray(modules.area_m2 * specific)

    return power_w
