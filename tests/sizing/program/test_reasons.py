"""What the nearest design misses: of energy, to the battery's capacity."""

from dataclasses import replace

import numpy as np
import pytest
from builders import DESIGN, mission

from sizing.day.light import UNCORRECTED_CAM, solar_day
from sizing.design import variables_of
from sizing.limits import MASS_BUDGET
from sizing.performance import performance_of_designs
from sizing.program.climbing import simulate
from sizing.program.corrections import Scenario, linearised, neighbours
from sizing.program.objectives import Objective
from sizing.program.reasons import limits_of, missed_by
from sizing.program.size import size_aircraft
from sizing.program.solve import LACKING, solve
from sizing.program.task import SizingTask

DAY = solar_day(DESIGN, mission())
TASK = SizingTask(DESIGN, mission(), Objective.min_mass, UNCORRECTED_CAM, DAY, 0.0)


def simulated(**changes):
    design = variables_of(DESIGN)._replace(**changes)
    return performance_of_designs(DESIGN, mission(), design, day=DAY)


def test_a_battery_too_small_for_the_night_lacks_what_the_night_takes_beyond_it():
    perf = simulated(battery_mass_kg=0.5)
    net_w = np.ravel(perf.load_w) - np.ravel(perf.solar_power_w)
    fine_h = np.linspace(0.0, 24.0, 200_001)
    lacking_w = np.maximum(np.interp(fine_h, DAY.time_h, net_w), 0.0)
    night_wh = 24.0 * float(lacking_w[:-1].mean()) / DESIGN.battery.mean_discharge_efficiency
    full_wh = float(np.ravel(perf.design.battery_energy_wh)[0])
    assert missed_by(TASK, None, perf) == {
        "battery_capacity": pytest.approx(night_wh / full_wh - 1.0, rel=1e-4)
    }


def test_a_day_that_returns_next_to_enough_lacks_the_least_share_of_its_load():
    less_m2, more_m2 = 0.1, 1.35
    for _ in range(20):
        area_m2 = (less_m2 + more_m2) / 2.0
        closes = bool(np.all(simulated(module_area_m2=area_m2).cycle.perpetual))
        less_m2, more_m2 = (less_m2, area_m2) if closes else (area_m2, more_m2)
    perf = simulated(module_area_m2=less_m2)
    load_wh = 24.0 * float(np.ravel(perf.nominal_load_w)[0])
    full_wh = float(np.ravel(perf.design.battery_energy_wh)[0])
    assert missed_by(TASK, None, perf) == {
        "energy_balance": pytest.approx(LACKING * load_wh / full_wh, rel=1e-6)
    }


def test_what_nobody_can_lift_is_missed_by_more_with_more_payload():
    missed = []
    for mass_kg in (1e5, 2e5, 4e5):
        there = mission(payload={"mass_kg": mass_kg})
        perf = performance_of_designs(DESIGN, there, variables_of(DESIGN), day=DAY)
        task = SizingTask(DESIGN, there, Objective.min_mass, UNCORRECTED_CAM, DAY, 0.0)
        missed.append(missed_by(task, None, perf)[MASS_BUDGET])
    assert 0.0 < missed[0] < missed[1] < missed[2] < np.inf


def test_a_variable_that_is_held_is_no_bound_that_limits():
    held = size_aircraft(
        DESIGN, mission(), Objective.min_mass, day=DAY, bounds={"battery_mass_kg": (3.3, 3.3)}
    )
    assert float(held.design.variables.battery_mass_kg) == 3.3
    assert not any("battery_mass_kg" in name for name in held.active_constraints)


def test_how_far_a_step_may_go_is_no_bound_that_limits():
    first = TASK.first_values(variables_of(DESIGN))
    perf = simulate(TASK, neighbours(TASK, first), {})
    point = linearised(TASK, first, perf, {0: Scenario()})
    solution = solve(TASK, replace(point, reach=0.01), excess_h=0.0)
    assert solution.is_limited
    assert np.abs(solution.bound_multipliers[solution.program.parts["design"]]).max() > 0.01
    assert not any(" at its " in limit.name for limit in limits_of(solution))
