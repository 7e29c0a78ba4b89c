"""Synthetic flights of known truth: sun, load and battery flown together, with errors that last.

Attitude and light are those of :mod:`studies.flight_logs.synthetic`. The sky of a day is off by one
factor, haze and gusts wander, the battery charges as far as its limit allows and what it does not
take is not generated, the gauge drifts. The numbers of the errors are assumptions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.energy.battery import Store
from sizing.mass_budget import design_of
from solar.types import FloatArray
from studies.flight_logs.synthetic import (
    START_UTC_S,
    Settings,
    SyntheticLog,
    lasting,
    synthetic_log,
)


@dataclass(frozen=True)
class Errors:
    """Errors of a flight: standard deviations, and times over which they last.

    ``light``: of the sky of the whole flight, relative [-]. ``haze``, ``haze_h``: of passing haze,
    relative [-], and how long it lasts [h]. ``gust_w``, ``gust_h``: of the load [W, h].
    ``sensor_w``: of the power and load sensors, from sample to sample [W]. ``gauge``, ``gauge_h``:
    of the state of charge [-, h].
    """

    light: float = 0.03
    haze: float = 0.02
    haze_h: float = 0.33
    gust_w: float = 3.0
    gust_h: float = 0.1
    sensor_w: float = 1.0
    gauge: float = 0.004
    gauge_h: float = 0.5


@dataclass(frozen=True)
class Flight:
    """Length and start of a flight, and the seed of its errors."""

    start_utc_s: float = START_UTC_S
    duration_h: float = 28.35
    state_of_charge: float = 0.577
    step_s: float = 30.0
    seed: int = 0
    errors: Errors = Errors()


@dataclass(frozen=True)
class Flown(SyntheticLog):
    """A flight's log, and what became of it.

    ``empty_h`` is when the battery was empty, in hours after the start; the log ends there. None
    where it lasted. ``minimum_charge`` is the least charge of the night, without the gauge's error.
    """

    minimum_charge: float
    empty_h: float | None


def fly(aircraft: Aircraft, mission: Mission, flight: Flight) -> Flown:
    """Fly an aircraft that is as its file says, and write down what the instruments would."""
    rng, errors = np.random.default_rng(flight.seed), flight.errors
    settings = Settings(
        start_utc_s=flight.start_utc_s,
        duration_h=flight.duration_h,
        rate_hz=1.0 / flight.step_s,
        seed=flight.seed,
        power_noise_w=0.0,
    )
    table = synthetic_log(aircraft, mission, settings).table
    count, step_h = len(table), flight.step_s / 3600.0
    sky = 1.0 + errors.light * rng.standard_normal()
    haze = 1.0 + errors.haze * _wandering(count, step_h / errors.haze_h, rng)
    offered = np.maximum(table["solar_power_w"].to_numpy(), 0.0) * sky * haze
    design = design_of(aircraft, mission)
    load = float(design.nominal_load_w(mission)) + errors.gust_w * _wandering(
        count, step_h / errors.gust_h, rng
    )
    solar, stored = _charged(aircraft, offered, load, flight.state_of_charge, step_h)
    full = Store.of(aircraft.battery, design.battery_energy_wh).battery_energy_wh
    empty = np.flatnonzero(stored <= 0.0)
    last = int(empty[0]) if len(empty) else count
    charge = stored / float(full)
    # Where it first falls for good, of a flight that starts by day.
    evening = int(np.argmax(charge[: max(last // 2, 1)]))
    gauge = charge + errors.gauge * _wandering(count, step_h / errors.gauge_h, rng)
    table = table.assign(
        solar_power_w=np.round(solar + errors.sensor_w * rng.standard_normal(count), 2),
        load_w=np.round(load + errors.sensor_w * rng.standard_normal(count), 2),
        state_of_charge=np.round(np.clip(gauge, 0.0, 1.0), 4),
    )
    return Flown(
        table=table.iloc[: max(last, 2)].reset_index(drop=True),
        minimum_charge=float(charge[evening:last].min()),
        empty_h=last * step_h if len(empty) else None,
    )


def _wandering(count: int, step: float, rng: np.random.Generator) -> FloatArray:
    """Noise of unit variance that keeps ``exp(-step)`` of itself from sample to sample."""
    white = rng.standard_normal(count)
    white[0] /= np.sqrt(1.0 - float(np.exp(-step)) ** 2)  # it has always wandered
    return lasting(white, step)


def _charged(
    aircraft: Aircraft, offered: FloatArray, load: FloatArray, start: float, step_h: float
) -> tuple[FloatArray, FloatArray]:
    """Power that is generated [W], and energy in the battery at each sample [Wh]."""
    store = Store.of(aircraft.battery)
    gain, drain = float(store.charge_efficiency), float(store.discharge_efficiency)
    solar, stored = offered.copy(), np.empty(len(offered))
    energy = np.asarray(start * float(store.battery_energy_wh))
    for i in range(len(offered)):
        stored[i] = energy
        surplus_wh = (offered[i] - load[i]) * step_h
        if surplus_wh <= 0.0:
            energy = np.maximum(energy + surplus_wh / drain, 0.0)
            continue
        charged = store.charged(energy, np.asarray(surplus_wh), step_h)
        taken_wh = float(charged - energy) / gain
        if taken_wh < surplus_wh - 1e-12:
            solar[i] = load[i] + taken_wh / step_h
        energy = charged
    return solar, stored
