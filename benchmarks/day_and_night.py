"""A converged day and night: many scenarios at once against one after the other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.measuring import best_time_s, row
from missions.library import load_mission
from missions.mission import Scenarios
from sizing.battery.battery import Battery, NoChargeLimit
from sizing.day.battery import Store
from sizing.day.cycle import simulate_cycle
from sizing.day.light import solar_day
from sizing.library import load_aircraft
from solar.types import FloatArray

_COUNT = 500
_LOAD_W = 42.0
_BATTERY = Battery(mass_kg=2.918, specific_energy_wh_per_kg=251.0, charge_limit=NoChargeLimit())
# A plain loop with steps of 5 min errs by about this much of the battery.
_AGREEMENT = 0.005


def one_day() -> list[dict[str, Any]]:
    """A day: ours in a batch and alone, against scipy's integrator and a plain Python loop."""
    aircraft = load_aircraft("atlantiksolar-as2")
    mission = load_mission("rafz-july")
    scenarios = Scenarios(np.linspace(20.0, 50.0, _COUNT), np.full(_COUNT, 172))
    day = solar_day(aircraft, mission, scenarios=scenarios)
    solar_w = aircraft.modules.area_m2 * day.specific_power_w_per_m2
    load_w, store = np.full(solar_w.shape, _LOAD_W), Store.of(_BATTERY)

    def ours(count: int) -> Any:
        return simulate_cycle(day.time_h, solar_w[:count], load_w[:count], store)

    batch_s = best_time_s(lambda: ours(_COUNT)) / _COUNT
    alone_s = best_time_s(lambda: ours(1))
    _check(float(ours(1).minimum_state_of_charge[0]), looped_day(day.time_h, solar_w[0]))

    integrated_s = best_time_s(_integrator(day.time_h, solar_w[0]), 3)
    hours, power = day.time_h.tolist(), solar_w[0].tolist()
    looped_s = best_time_s(lambda: looped_day(hours, power), 20)
    batch = f"a scenario's converged cycle and metrics, one of {_COUNT} at once"
    alone = "a scenario's converged cycle and metrics, simulated alone"
    one, two = "; the peer marches one day", "; the peer marches two days, energy alone"
    scipy_name, loop = "scipy.integrate.solve_ivp", "plain Python loop"
    return [
        row("day and night, in a batch", batch + one, batch_s, scipy_name, integrated_s),
        row("day and night, in a batch", batch + two, batch_s, loop, looped_s),
        row("day and night, alone", alone + one, alone_s, scipy_name, integrated_s),
        row("day and night, alone", alone + two, alone_s, loop, looped_s),
    ]


def _check(ours: float, looped: float) -> None:
    if abs(ours - looped) > _AGREEMENT:
        raise AssertionError(f"least state of charge: ours {ours:.4f}, loop {looped:.4f}")


def _integrator(time_h: FloatArray, solar_w: FloatArray) -> Callable[[], Any]:
    from scipy.integrate import solve_ivp

    def rate(t: float, energy: Any) -> Any:
        net = np.interp(t, time_h, solar_w) - _LOAD_W
        if net > 0.0:
            return (
                0.0 if energy[0] >= _BATTERY.battery_energy_wh else _BATTERY.charge_efficiency * net
            )
        return net / _BATTERY.discharge_efficiency

    return lambda: solve_ivp(rate, (0.0, 24.0), [400.0], max_step=1.0 / 12.0, rtol=1e-6)


def looped_day(hours: Any, solar_w: Any) -> float:
    """Least state of charge on the second of two days from a full battery, by a plain loop."""
    full = energy = _BATTERY.battery_energy_wh
    charging, discharging = _BATTERY.charge_efficiency, _BATTERY.discharge_efficiency
    least = full
    for _ in range(2):
        least = full
        for i in range(len(hours) - 1):
            net = (solar_w[i] + solar_w[i + 1]) / 2.0 - _LOAD_W
            step = hours[i + 1] - hours[i]
            energy += step * (charging * net if net > 0.0 else net / discharging)
            energy = min(max(energy, 0.0), full)
            least = min(least, energy)
    return float(least / full)
