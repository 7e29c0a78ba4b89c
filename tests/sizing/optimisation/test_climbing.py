"""Sizings with climbs: the program beside the march, and optima beside other simulated designs."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np
import pytest
from builders import DESIGN
from builders import shipped_mission as mission
from scipy.interpolate import CubicSpline

from benchmarks.wild_problems import wild_problem
from missions.mission import Mission, Scenarios
from sizing.altitude.climb_levels import flight_levels
from sizing.altitude.climb_march import March
from sizing.altitude.climb_run import Stored
from sizing.design import FlightConditions, variables_of
from sizing.energy.battery import Store
from sizing.library import load_aircraft
from sizing.limits import meets_requirements
from sizing.mass_budget import closed_design
from sizing.optimisation.cells import size_cells
from sizing.optimisation.climb_constraints import (
    aloft_parameters,
    climb_values,
    climbing_cycle_function,
)
from sizing.optimisation.energy_constraints import (
    LEVELS_ALOFT,
    NODES,
    spline_basis,
    spline_coefficients,
    sun_parameters,
)
from sizing.optimisation.propulsion import sized_in_own_flow
from sizing.optimisation.search import size_aircraft, unjudged_optimum
from sizing.optimisation.variables import WORST_EXCESS
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, merit_of
from sizing.smooth_propulsion import smooth_at
from sizing.sunlight import solar_day

pytestmark = pytest.mark.slow

STRATEGIES = ("battery_full", "surplus")


def climbing(ceiling_m: float, strategy: str = "battery_full", **changes: object) -> Mission:
    return mission(climb={"ceiling_m": ceiling_m, "strategy": strategy}, **changes)


@cache
def sized(objective: Objective, ceiling_m: float, strategy: str, date: str) -> SizingResult:
    there = climbing(ceiling_m, strategy, dates={"on": date})
    return size_aircraft(DESIGN, there, objective)


# ---- The program and the march


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("ceiling_m", [1536.0, 4536.0])
@pytest.mark.parametrize("name", ["atlantiksolar-design", "twin-boom-design"])
def test_the_program_has_the_day_of_the_march(strategy: str, ceiling_m: float, name: str) -> None:
    there = climbing(ceiling_m, strategy)
    own = smooth_at(load_aircraft(name), there)
    day, battery = solar_day(own, there), own.battery
    design = closed_design(own, there, variables_of(own))
    capacity_wh = float(design.battery_energy_wh)
    levels = flight_levels(own, there, design, day)
    store = Store.of(battery, np.array([capacity_wh]))
    march = March(day.time_h, levels, store, strategy, 5)  # type: ignore[arg-type]
    run = march.empty_run()
    march.end_of_day(march.end_of_day(Stored(np.array([capacity_wh]), np.zeros(1))), run)
    dawn = run.energy_wh[:, 0].min() / capacity_wh
    highest = run.potential_wh[:, 0].max() / levels.potential_energy_wh[-1, 0]
    drawn = run.drawn.sum() / capacity_wh

    values = climb_values(
        *(own, design, FlightConditions.of(there, own)),
        list(aloft_parameters(there, own)),
    )
    deficit, charged, reached, beyond_h = (
        float(one)
        for one in climbing_cycle_function(
            battery.charge_limit,
            there.climb.strategy,  # type: ignore[union-attr]
            by_parts=levels.chain is not None,
        )(
            *(float(variables_of(own).module_area_m2), capacity_wh, dawn, highest),
            ca.vertcat(*values),
            ca.DM([battery.mean_charge_efficiency, battery.mean_discharge_efficiency]),
            *(0.0, sun_parameters(day, there)[0]),
        )
    )
    # A spline through five levels and steps of 10 min, against levels 500 m apart and 1 min; of
    # parts also three straight lines against the chain.
    assert deficit == pytest.approx(drawn, rel=1e-3)
    assert charged > 1.0
    assert reached > highest == pytest.approx(1.0)
    # Of the interval in which the sun takes over, a part of the deficit counts as after that.
    assert 0.0 <= beyond_h < 2e-3


@pytest.mark.parametrize("number", [1, 14])
def test_the_program_has_the_excess_time_of_the_simulator(number: int) -> None:
    # A climb through the tropopause, where light and power bend; and thermals of 2.6 times the
    # power of level flight, in which the battery gives long after the morning's equal power.
    problem = wild_problem(5521, number, climb=True)
    given = (problem.aircraft, problem.mission, problem.objective, problem.solar)
    hours = {"required_excess_time_h": problem.required_h}
    aircraft, _ = sized_in_own_flow(*given, **hours)
    optimum = unjudged_optimum(aircraft, *given[1:], **hours)
    assert optimum is not None
    flown = performance_of_designs(aircraft, problem.mission, optimum.design, problem.solar)
    # Steps of 10 min in the program: 0.02 h. With parabolas through three levels, and with the
    # battery's least charge for that at equal power, it was off by 0.5 and 0.7 h.
    expected = optimum.value(WORST_EXCESS)
    assert float(np.min(flown.cycle.excess_time_h)) == pytest.approx(expected, abs=0.03)


def test_climbs_that_end_short_of_the_ceiling_cost_what_they_must() -> None:
    # Best payload of a search over simulated designs [kg], of an aircraft of 45 kg. The program's
    # climbs end 0.6 % too high there; with another tenth of an hour as goal instead 7 % were lost.
    problem = wild_problem(8300, 8, climb=True)
    given = (problem.aircraft, problem.mission, problem.objective, problem.solar)
    result = size_aircraft(*given, required_excess_time_h=problem.required_h)
    assert result.objective_value is not None
    assert result.objective_value > 1.2786 * (1.0 - 3e-3)  # what a sizing is held to


def test_spline_of_the_levels_aloft() -> None:
    places = np.linspace(0.0, 1.0, LEVELS_ALOFT + 1)
    values = np.exp(places) + np.array([0.0, 0.3, 0.0, -0.2, 0.1])
    share = np.linspace(0.0, 1.0, 21)
    found = [float(ca.dot(spline_coefficients() @ values, spline_basis(one))) for one in share]
    expected = CubicSpline(places, values, bc_type="natural")(share)
    assert found == pytest.approx(expected.tolist(), rel=1e-12)


def test_a_day_without_a_night_begins_where_the_sun_carries_least() -> None:
    pole = {"latitude_deg": 90.0, "dates": {"on": "06-21"}}
    calm, rough = (mission(**pole, turbulence={"thermal": one}) for one in (0.0, 0.5))
    thermal = [sun_parameters(solar_day(DESIGN, one), one)[0, NODES:-3] for one in (calm, rough)]
    assert np.all(thermal[0] == 0.0)
    assert np.argmax(thermal[1]) in (0, NODES - 1)  # noon
    assert np.argmin(thermal[1]) == NODES // 2


# ---- Optima


@pytest.mark.parametrize("objective", [Objective.min_wingspan, Objective.max_excess_time])
def test_a_ceiling_at_the_floor_is_level_flight(objective: Objective) -> None:
    level = size_aircraft(DESIGN, mission(), objective)
    found = sized(objective, mission().altitude_m, "battery_full", "07-15")
    # Within the cushion of the goal, and the two marches' difference.
    assert found.objective_value == pytest.approx(level.objective_value, rel=1e-3)


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("objective", [Objective.min_wingspan, Objective.min_mass])
def test_no_design_nearby_is_better(objective: Objective, strategy: str) -> None:
    result = sized(objective, 3536.0, strategy, "07-15")
    assert result.design is not None
    assert result.simulated is not None
    centre, there = result.design.variables, result.simulated.mission
    rng = np.random.default_rng(0)
    spread = np.repeat([0.05, 0.01, 0.002], 150)
    names = ("wingspan_m", "battery_mass_kg", "module_area_m2")
    moved = {n: getattr(centre, n) * np.exp(spread * rng.standard_normal(450)) for n in names}
    around = centre.mapped(lambda v: np.full(450, v))._replace(**moved)
    flown = performance_of_designs(DESIGN, there, around)
    kept = (flown.cycle.excess_time_h[:, 0] > 0.0) & meets_requirements(DESIGN, there, flown.design)
    assert kept.any()
    best = np.max(np.where(kept, merit_of(objective, flown), -np.inf))
    assert best <= result.merit + 3e-3 * abs(result.merit)  # what a sizing is held to


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize(
    ("latitude_deg", "date"), [(40.0, "12-21"), (30.0, "12-21"), (47.6, "07-15")]
)
def test_climbing_is_never_worse_than_level_flight(
    latitude_deg: float, date: str, strategy: str
) -> None:
    # Without a surplus beyond the full battery the optimum of level flight is one with climbs too;
    # on the shortest days optima without height, with some and with all of it are far apart.
    where = {"latitude_deg": latitude_deg, "dates": {"on": date}}
    level = size_aircraft(DESIGN, mission(**where), Objective.min_mass)
    climbs = size_aircraft(DESIGN, climbing(3536.0, strategy, **where), Objective.min_mass)
    assert climbs.objective_value is not None
    assert level.objective_value is not None
    assert climbs.objective_value <= level.objective_value * (1.0 + 1e-3)


@pytest.mark.parametrize(("number", "best"), [(76, 10.4597), (105, 18.806), (112, 7.2067)])
def test_a_day_that_must_return_more_than_the_program_thinks_costs_little(
    number: int, best: float
) -> None:
    # Best designs of searches over simulated ones. With the program's first margin on the recharge
    # they run empty; the goal of another hour instead cost up to a third, or all designs.
    problem = wild_problem(0, number, climb=True)
    given = (problem.aircraft, problem.mission, problem.objective, problem.solar)
    result = size_aircraft(*given, required_excess_time_h=problem.required_h)
    assert result.objective_value is not None
    worse = (
        best - result.objective_value
        if problem.objective.maximised
        else (result.objective_value - best)
    )
    assert worse < 3e-3 * best  # what a sizing is held to


def test_a_higher_ceiling_takes_less_span() -> None:
    spans = [
        sized(Objective.min_wingspan, ceiling_m, "battery_full", "07-15").objective_value
        for ceiling_m in (536.0, 1536.0, 3536.0)
    ]
    assert spans == sorted(spans, reverse=True)
    assert spans[0] > 1.02 * spans[-1]


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_ceiling_far_above_what_is_reached_takes_nothing(strategy: str) -> None:
    lower = sized(Objective.min_mass, 14000.0, strategy, "07-15").objective_value
    assert lower is not None
    for ceiling_m in (16000.0, 20000.0, 25000.0, 32000.0):
        higher = sized(Objective.min_mass, ceiling_m, strategy, "07-15").objective_value
        assert higher is not None
        # Searches over simulated designs find the least at 20 and 32 km, 1.3 and 2 % below 14 km's.
        assert higher < 1.002 * lower


def test_a_day_between_two_others_takes_a_mass_between_theirs() -> None:
    # On 15 January the solver finds no solution at the ceiling, nor with a free height.
    masses_kg = [
        size_aircraft(
            DESIGN,
            climbing(3536.0, "surplus", latitude_deg=37.5, dates={"on": f"01-{day}"}, air={}),
            Objective.min_mass,
        ).objective_value
        for day in (13, 15, 17)
    ]
    assert masses_kg == sorted(masses_kg, reverse=True)


def test_what_limits_names_the_ceiling() -> None:
    active = sized(Objective.min_wingspan, 3536.0, "battery_full", "07-15").active_constraints
    assert any(name.startswith("climb_ceiling (") for name in active)


def test_cells_are_the_sizings_of_each() -> None:
    latitudes, days = np.array([10.0, 40.0, 47.6]), np.array([172, 355, 196])
    there = climbing(3536.0)
    cells = size_cells(DESIGN, there, Scenarios(latitudes, days), Objective.min_wingspan)
    alone = [
        size_aircraft(
            *(DESIGN, there, Objective.min_wingspan),
            day=solar_day(
                DESIGN, there, scenarios=Scenarios(latitudes[i : i + 1], days[i : i + 1])
            ),
        ).objective_value
        for i in range(3)
    ]
    assert cells.objective_value == pytest.approx(alone, rel=3e-3)


# ---- The light aloft


def test_a_day_carries_its_light_aloft() -> None:
    there = climbing(1536.0, dates={"from": "06-21", "to": "08-21", "count": 3})
    day = solar_day(DESIGN, there)
    assert day.aloft_w_per_m2 is not None
    assert day.aloft_w_per_m2.shape == (3, *day.specific_power_w_per_m2.shape)
    np.testing.assert_array_equal(day.aloft_w_per_m2[0], day.specific_power_w_per_m2)
    top = solar_day(DESIGN, there.at_altitude(1536.0)).specific_power_w_per_m2
    np.testing.assert_array_equal(day.aloft_w_per_m2[-1], top)
    changed = day.at([2, 0]).scaled(0.5).coarsened(4)
    np.testing.assert_array_equal(changed.aloft_w_per_m2[-1], 0.5 * top[[2, 0], ::4])  # type: ignore[index]
    joined = type(day).joined([day.at([0]), day.at([1, 2])])
    np.testing.assert_array_equal(joined.aloft_w_per_m2, day.aloft_w_per_m2)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_first_guess_of_a_tenth_of_the_optimum_does_not_stand_in_the_way() -> None:
    # The file has a wing of 3 m. As it cools its modules a wing of 34 m has 9 % too much light:
    # the days of the optima that the program found did not return what the night took.
    problem = wild_problem(6607, 42, climb=True)
    given = (problem.aircraft, problem.mission, problem.objective, problem.solar)
    result = size_aircraft(*given, required_excess_time_h=9.9)
    assert result.status is SizingStatus.infeasible
    assert result.nearest is not None
    # 6.98 h of the best of a search by simulation.
    assert float(np.min(result.nearest.cycle.excess_time_h)) == pytest.approx(6.98, abs=0.02)
