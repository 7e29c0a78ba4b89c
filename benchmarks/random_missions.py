"""Random missions and technology sets, sized, cross-checked and held against a simulated grid.

``python -m benchmarks.random_missions --count 300``. Each case is drawn from its own seed:
aircraft, latitudes, dates, altitude, clearness, turbulence, payload, wind, uncertainty margins,
battery, cells, avionics, free variables, objective and required excess time. The optimum is
cross-checked; the verdict, feasible or not, is compared with a grid over the whole design space
that only the simulator judges.
"""

from __future__ import annotations

import time
from collections import Counter
from typing import Any

import click
import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.day.light import solar_day
from sizing.design_space import Range
from sizing.library import load_aircraft
from sizing.limits import meets_requirements
from sizing.parameters import with_parameter
from sizing.performance import performance_of_designs
from sizing.program.cross_check import cross_check
from sizing.program.objectives import SINGLE_OBJECTIVES, Objective
from sizing.program.size import size_aircraft
from sizing.program.start import grid_of

_GRID_STEP_H = 0.25


def random_case(seed: int) -> tuple[Aircraft, Mission, Objective, float]:
    """Aircraft, mission, objective and required excess time [h] of a seed."""
    rng = np.random.default_rng(seed)
    aircraft = load_aircraft(str(rng.choice(["atlantiksolar-design", "sky-sailor"])))
    mission = _random_mission(rng)
    for key, low, high in (
        ("battery.specific_energy_wh_per_kg", 180.0, 450.0),
        ("modules.efficiency_stc", 0.17, 0.3),
        ("power.avionics_w", 1.0, 12.0),
    ):
        aircraft, _ = with_parameter(aircraft, mission, key, float(rng.uniform(low, high)))
    space = aircraft.design_space
    if rng.random() < 0.25:
        space = space.model_copy(update={"aspect_ratio": Range(minimum=8.0, maximum=24.0)})
    if rng.random() < 0.25:
        airframe = aircraft.airframe
        assert isinstance(airframe, ParametricAirframe)
        highest = float(airframe.aerodynamics.maximum_lift_coefficient) / 1.2
        lift = Range(minimum=0.35, maximum=highest)
        space = space.model_copy(update={"lift_coefficient": lift})
    aircraft = aircraft.model_copy(update={"design_space": space})
    objective = SINGLE_OBJECTIVES[int(rng.integers(len(SINGLE_OBJECTIVES)))]
    return aircraft, mission, objective, float(rng.choice([0.0, 1.0, 3.0, 6.0, 10.0]))


def _random_mission(rng: np.random.Generator) -> Mission:
    south = float(rng.uniform(-60.0, 55.0))
    band = {"from_deg": south, "to_deg": south + float(rng.uniform(1.0, 10.0)), "count": 3}
    first = int(rng.integers(1, 13))
    last = (first + int(rng.integers(0, 5)) - 1) % 12 + 1
    day = int(rng.integers(1, 28))
    ranged = {"from": f"{first:02d}-{day:02d}", "to": f"{last:02d}-28"}
    return Mission.model_validate(
        {
            "name": "random",
            "latitude_deg": band if rng.random() < 0.5 else south,
            "dates": ranged if rng.random() < 0.6 else {"on": f"{first:02d}-{day:02d}"},
            "altitude_m": float(rng.uniform(0.0, 4000.0)),
            "clearness": float(rng.uniform(0.7, 1.0)),
            "turbulence": {
                "all_day": float(rng.choice([0.0, 0.1, 0.3])),
                "thermal": float(rng.choice([0.0, 0.2])),
            },
            "payload": {
                "mass_kg": float(rng.choice([0.0, 0.2, 0.6, 1.5])),
                "power_w": float(rng.choice([0.0, 3.0, 10.0])),
            },
            "wind_m_per_s": float(rng.choice([0.0, 0.0, 5.0, 9.0])),
            "uncertainty_margins": {
                "solar_model_sigmas": float(rng.choice([0.0, 1.0])),
                "battery_capacity": float(rng.choice([1.0, 0.85])),
            },
        }
    )


def feasible_on_grid(
    aircraft: Aircraft, mission: Mission, objective: Objective, required_h: float
) -> bool:
    """Whether the simulator finds any feasible design on a grid over the design space.

    Parameters
    ----------
    aircraft, mission, objective
        As for :func:`sizing.program.size.size_aircraft`.
    required_h : float
        Required excess time [h].
    """
    carried = mission.payload
    payload = {"payload_mass_kg": carried.mass_kg, "payload_power_w": carried.power_w}
    payload |= {name: 0.0 for name in payload if name == objective.variable}
    grid = grid_of(aircraft)
    grid = grid._replace(**{k: np.full(grid.wingspan_m.shape, v) for k, v in payload.items()})
    day = solar_day(aircraft, mission, step_h=_GRID_STEP_H)
    perf = performance_of_designs(aircraft, mission, grid, day=day)
    worst = perf.cycle.excess_time_h.min(axis=-1)
    met = meets_requirements(aircraft, perf.design)
    return bool(np.any(met & (worst > 0.0) & (worst >= required_h)))


def judged(seed: int) -> dict[str, Any]:
    """Verdict, cross-check and time of a seed."""
    aircraft, mission, objective, required_h = random_case(seed)
    begun = time.process_time()
    result = size_aircraft(aircraft, mission, objective, required_excess_time_h=required_h)
    row: dict[str, Any] = {
        "seed": seed,
        "objective": objective.value,
        "required_h": required_h,
        "status": result.status.name,
        "value": result.objective_value,
        "cpu_s": time.process_time() - begun,
    }
    if result.feasible:
        found = cross_check(aircraft, mission, result)
        row |= {"cross_checked": found.cross_checked, "best_found": found.best_found}
    else:
        row["on_grid"] = feasible_on_grid(aircraft, mission, objective, required_h)
    return row


@click.command()
@click.option("--count", default=300, show_default=True, help="Number of cases.")
@click.option("--first", default=0, show_default=True, help="First seed.")
def main(count: int, first: int) -> None:
    """Size random missions, cross-check the optima and check the verdicts; print the exceptions."""
    rows = []
    for seed in range(first, first + count):
        rows.append(judged(seed))
        row = rows[-1]
        if (
            row["status"] == "not_converged"
            or row.get("on_grid")
            or row.get("cross_checked") is False
        ):
            click.echo(row)
    statuses = Counter(row["status"] for row in rows)
    checked = sum(bool(row.get("cross_checked")) for row in rows)
    contradicted = sum(bool(row.get("on_grid")) for row in rows)
    click.echo(f"{count} cases: {dict(statuses)}")
    click.echo(f"{checked} of {statuses['optimal']} optima pass the cross-check")
    click.echo(f"{contradicted} infeasible verdicts contradicted by the grid")
    for status in statuses:
        times = [row["cpu_s"] for row in rows if row["status"] == status]
        click.echo(f"{status}: {np.mean(times):.3f} s of processor time on average")


if __name__ == "__main__":
    main()
