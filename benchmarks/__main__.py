"""``python -m benchmarks [--json]``: speed as ratios against peers, measured in one process.

Absolute times depend on the machine and on what else it does; the ratios hold up better. A ratio
above one says how many times faster this project does the same work. Peers that are not installed
are left out.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.map_scaling import map_scaling
from missions.mission import Scenarios
from sizing.battery import Battery, NoChargeLimit
from sizing.cycle import simulate_cycle
from sizing.energy_balance import Store
from sizing.objectives import Objective
from sizing.optimiser import size_aircraft
from sizing.performance import performance, solar_day
from solar.modules import SolarCell
from solar.power import horizontal_specific_power
from studies.library import load_aircraft, load_mission

_REPEATS = 5
_LATITUDES = np.linspace(-70.0, 70.0, 60)
_DAYS = np.linspace(1.5, 365.5, 37)
_HOURS = np.linspace(0.0, 24.0, 241)


def best_time_s(work: Callable[[], Any], repeats: int = _REPEATS) -> float:
    """Least wall time of several runs after one that warms up [s]."""
    work()
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return min(times)


def row(
    name: str, work: str, ours_s: float, peer: str | None, peer_s: float | None
) -> dict[str, Any]:
    """One line of the result."""
    ratio = None if peer_s is None else peer_s / ours_s
    return {
        "name": name,
        "work": work,
        "ours_s": ours_s,
        "peer": peer,
        "peer_s": peer_s,
        "ratio": ratio,
    }


def module_power() -> list[dict[str, Any]]:
    """Module power over latitude x day x time: ours with incidence losses, peers without."""
    latitude, day = _LATITUDES[:, None, None], _DAYS[:, None]
    points = len(_LATITUDES) * len(_DAYS) * len(_HOURS)
    cell = SolarCell()
    ours = best_time_s(
        lambda: horizontal_specific_power(
            latitude, day, _HOURS, cell=cell, module_temperature_c=25.0, altitude_m=500.0
        )
    )
    work = f"{points} points of electric power (CAM)"
    rows = []
    pvlib = _optional("pvlib")
    if pvlib is not None:
        rows.append(
            row(
                "module power",
                work,
                ours,
                "pvlib, analytic sun and Ineichen, irradiance only",
                best_time_s(lambda: _pvlib_ghi(pvlib, latitude, day)),
            )
        )
    power_solar = _optional("aerosandbox.library.power_solar")
    if power_solar is not None:
        rows.append(
            row(
                "module power",
                work,
                ours,
                "AeroSandbox solar_flux, irradiance only",
                best_time_s(
                    lambda: power_solar.solar_flux(
                        latitude=latitude, day_of_year=day, time=(_HOURS - 12.0) * 3600.0
                    )
                ),
            )
        )
    return rows or [row("module power", work, ours, None, None)]


def _pvlib_ghi(pvlib: Any, latitude: Any, day: Any) -> Any:
    position = pvlib.solarposition
    zenith = position.solar_zenith_analytical(
        np.radians(latitude),
        np.radians((_HOURS - 12.0) * 15.0),
        position.declination_spencer71(day),
    )
    zenith_deg = np.degrees(zenith)
    with np.errstate(all="ignore"):
        mass = pvlib.atmosphere.get_relative_airmass(zenith_deg)
        return pvlib.clearsky.ineichen(zenith_deg, mass, 3.0, 500.0, 1366.0)["ghi"]


def one_day() -> list[dict[str, Any]]:
    """A converged day and night: a batch of scenarios against scipy's integrator, one by one."""
    from scipy.integrate import solve_ivp

    count = 500
    aircraft = load_aircraft("atlantiksolar-as2").aircraft
    mission = load_mission("rafz-july").mission
    scenarios = Scenarios(np.linspace(20.0, 50.0, count), np.full(count, 172))
    day = solar_day(aircraft, mission, scenarios=scenarios)
    solar_w = aircraft.modules.area_m2 * day.specific_power_w_per_m2
    battery = Battery(mass_kg=2.918, specific_energy_wh_per_kg=251.0, charge_limit=NoChargeLimit())
    load_w, store = np.full(solar_w.shape, 42.0), Store.of(battery)
    batch_s = best_time_s(lambda: simulate_cycle(day.time_h, solar_w, load_w, store)) / count

    def rate(t: float, energy: Any) -> Any:
        net = np.interp(t, day.time_h, solar_w[0]) - 42.0
        charge = battery.charge_efficiency * net if net > 0.0 else net / 0.97
        return 0.0 if (energy[0] >= battery.energy_wh and net > 0.0) else charge

    peer_s = best_time_s(
        lambda: solve_ivp(rate, (0.0, 24.0), [400.0], max_step=1.0 / 12.0, rtol=1e-6), 3
    )
    work = f"a scenario's day, one of {count}; ours converges the cycle, the peer marches one day"
    return [row("day and night", work, batch_s, "scipy.integrate.solve_ivp", peer_s)]


def sizing() -> list[dict[str, Any]]:
    """Sizing for nine scenarios: whole call, and time in the solver."""
    aircraft = load_aircraft("atlantiksolar-design").aircraft
    mission = load_mission("central-europe-summer").mission
    solves: list[float] = []

    def work() -> None:
        result = size_aircraft(
            aircraft, mission, Objective.min_wingspan, required_excess_time_h=5.0
        )
        solves.append(result.solver.time_s)

    whole = best_time_s(work)
    text = "9 scenarios, least wingspan with 5 h of excess time"
    return [
        row("sizing, with simulation", text, whole, None, None),
        row("sizing, solver alone", text, min(solves), None, None),
    ]


def map_cells() -> list[dict[str, Any]]:
    """Cost of a map against its size: time for each cell."""
    aircraft = load_aircraft("atlantiksolar-as2").aircraft
    mission = load_mission("rafz-july").mission
    rows = []
    for count in (128, 512, 2048):
        scenarios = Scenarios(
            np.linspace(-70.0, 70.0, count), np.arange(count, dtype=int) * 7 % 365 + 1
        )

        def work(scenarios: Scenarios = scenarios) -> None:
            lit = solar_day(aircraft, mission, scenarios=scenarios)
            performance(aircraft, mission, day=lit)

        rows.append(row("map, one cell", f"of {count}", best_time_s(work, 3) / count, None, None))
    return rows


def _optional(name: str) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def main(arguments: list[str]) -> None:
    """Run all benchmarks and print a table, or JSON."""
    parts = (module_power, one_day, sizing, map_cells, map_scaling)
    rows = [r for part in parts for r in part()]
    if "--json" in arguments:
        print(json.dumps(rows, indent=2))
        return
    for r in rows:
        peer = "" if r["ratio"] is None else f"  {r['ratio']:6.1f} x {r['peer']}"
        print(f"{r['name']:26} {1e3 * r['ours_s']:10.3f} ms  {r['work']}{peer}")


if __name__ == "__main__":
    main(sys.argv[1:])
