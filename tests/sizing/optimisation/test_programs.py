"""Programs shared by all aircraft of a kind: how many are built, and whose numbers they hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from builders import aircraft, mission
from pydantic import BaseModel

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, FlightConditions, parametric_design, variables_of
from sizing.library import load_aircraft
from sizing.limits import design_requirements
from sizing.optimisation.energy_constraints import cycle_function, sun_parameters
from sizing.optimisation.problem import (
    SizingProblem,
    SizingProblems,
    build_problem,
    forget_programs,
    kind_of,
    programs_built,
)
from sizing.optimisation.result import ProblemInstance
from sizing.optimisation.search import size_aircraft
from sizing.optimisation.solver import ProgramSolver
from sizing.optimisation.variables import SOLAR_TECHNOLOGY, WIND, WORST_EXCESS, Role
from sizing.parameters import all_replaced, parameter_value
from sizing.performance import performance
from sizing.program.objectives import Objective
from sizing.sunlight import UNCORRECTED_CAM, solar_day

STEP_H = 0.5
MARGIN = 1e-3
DAWN, WORST_H, MASS_KG = 0.25, 3.0, 7.0


@pytest.fixture
def empty_cache() -> Iterator[None]:
    """No program has been built; afterwards, too, lest these crowd out others."""
    forget_programs()
    yield
    forget_programs()


def design(*overrides: str) -> Aircraft:
    return load_aircraft("atlantiksolar-design", overrides)


def numbers(node: BaseModel, prefix: str = "") -> Iterator[tuple[str, float]]:
    """Every number of a description that is no count, with its key."""
    for name in type(node).model_fields:
        value = getattr(node, name)
        if isinstance(value, BaseModel):
            yield from numbers(value, f"{prefix}{name}.")
        elif isinstance(value, float):
            yield prefix + name, value


def at_a_point(
    problem: SizingProblem, aircraft: Aircraft, place: Mission, **factors: float
) -> dict[str, float]:
    """Rows of a program with one block, at one decision vector; ``factors`` ease limits."""
    day = solar_day(aircraft, place, step_h=STEP_H)
    values = {
        "wingspan_m": 5.0,
        "battery_mass_kg": 2.5,
        "module_area_m2": 1.2,
        "total_mass_kg": MASS_KG,
        "payload_mass_kg": 0.3,
        "payload_power_w": 2.0,
        "dawn_state_of_charge[0]": DAWN,
        WORST_EXCESS: WORST_H,
        WIND: place.wind_m_per_s,
    }
    values |= {v.name: 1.0 for v in problem.of_role(Role.technology, Role.limit)} | factors
    x = np.array([v.to_program(values.get(v.name, 0.0)) for v in problem.variables])
    given = problem.parameters(
        problem.weights({"wingspan_m": 1.0}),
        FlightConditions.of(place, aircraft),
        sun_parameters(day, place),
        margin=MARGIN,
    )
    _, rows = problem.program.rows(x, given)
    names = [row.name for row in problem.constraints]
    return dict(zip(names, np.asarray(rows).ravel().tolist(), strict=True))


def by_the_formulas(aircraft: Aircraft, place: Mission) -> dict[str, float]:
    """The same rows from the aircraft itself, in numbers."""
    day = solar_day(aircraft, place, step_h=STEP_H)
    chosen = DesignVariables(5.0, aircraft.airframe.aspect_ratio, 2.5, 1.2, None, 0.3, 2.0)
    conditions = FlightConditions.of(place, aircraft).with_payload_of(chosen)
    it = parametric_design(aircraft, conditions, chosen, MASS_KG)
    rows = {r.name: float(r.value) for r in design_requirements(aircraft, it, conditions)}
    battery = aircraft.battery
    efficiencies = [battery.mean_charge_efficiency, battery.mean_discharge_efficiency]
    nominal_w = it.nominal_load_w(place)
    deficit, charged = (
        float(v)
        for v in cycle_function(battery.charge_limit)(
            *(1.2, it.battery_energy_wh, nominal_w, it.propulsion_power_w, DAWN),
            *(efficiencies, sun_parameters(day, place)[0]),
        )
    )
    usable_h = it.battery_energy_wh * efficiencies[1] / nominal_w
    return rows | {
        "battery_capacity": 1.0 - DAWN - deficit,
        "energy_balance": charged - DAWN - (1.0 + MARGIN) * deficit,
        "excess_time": (DAWN * usable_h - WORST_H) / 2.4,
    }


@pytest.mark.slow
@pytest.mark.usefixtures("empty_cache")
def test_one_program_serves_all_sizings_of_a_kind() -> None:
    technology = [
        ("battery.specific_energy_wh_per_kg=300", "name=other"),
        ("modules.efficiency_stc=0.26", "battery.charge_efficiency=0.93"),
        ("airframe.structure.calibration=1.3", "airframe.aspect_ratio=16"),
        ("power.avionics_w=4.0", "airframe.avionics_mass_kg=1.0", "airframe.wingspan_m=6"),
    ]
    places = [mission(latitude_deg=latitude) for latitude in (40.0, 45.0, 50.0, 55.0)]
    objectives = [Objective.min_mass, Objective.min_wingspan, Objective.max_excess_time]
    sized = [
        size_aircraft(
            design(*values), place, objective, day=solar_day(design(*values), place, step_h=STEP_H)
        )
        for values, place in zip(technology, places, strict=True)
        for objective in objectives
    ]
    assert all(one.feasible for one in sized)
    assert programs_built() == 1


@pytest.mark.parametrize("eased", [False, True])
def test_a_shared_program_holds_the_numbers_of_each_aircraft(eased: bool) -> None:
    # Whichever number of an aircraft differs, it is in the parameters or makes another kind, and
    # the rows are those of the formulas with that number.
    aircraft, place = design(), mission(latitude_deg=47.0, wind_m_per_s=3.0)
    shared, own, moved = kind_of(aircraft), by_the_formulas(aircraft, place), set()
    rows = at_a_point(build_problem(aircraft, 1, eased=eased), aircraft, place)
    kinds = 0
    for key, value in numbers(aircraft):
        other = all_replaced(aircraft, {key: 0.99 * value if value else 0.01})
        expected = by_the_formulas(other, place)
        differs = expected != pytest.approx(own, rel=1e-9, abs=1e-12)
        if kind_of(other) != shared:
            kinds += 1
            if eased or kinds % 8:  # each takes a program of its own: some stand for all
                continue
        elif differs:
            moved.add(key)
        found = at_a_point(build_problem(other, 1, eased=eased), other, place)
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-12), key
        assert (found != rows) == differs, key
    assert len(moved) > 15
    assert {"battery.specific_energy_wh_per_kg", "airframe.structure.safety_factor"} <= moved


@pytest.mark.slow
@pytest.mark.usefixtures("empty_cache")
def test_a_kept_program_gives_the_bits_of_a_fresh_one() -> None:
    place = mission(latitude_deg=47.0)
    others = [design(f"battery.specific_energy_wh_per_kg={value}") for value in (220, 260, 300)]

    def span_m(aircraft: Aircraft) -> Any:
        found = size_aircraft(
            *(aircraft, place, Objective.min_wingspan),
            required_excess_time_h=2.0,
            day=solar_day(aircraft, place, step_h=STEP_H),
        )
        return found.objective_value

    together = [span_m(one) for one in others]
    alone = []
    for one in others:
        forget_programs()
        alone.append(span_m(one))
    assert together == alone
    assert len(set(together)) == len(others)


def test_a_number_that_is_no_parameter_makes_another_kind() -> None:
    same = build_problem(design(), 1).program
    for override in (
        "battery.charge_limit={kind: none}",
        "battery.charge_limit.c_rate_per_h=0.4",
        "airframe.structure.cruise_gust_m_per_s=14",
        "airframe.maximum_module_coverage=0.8",
        "design_space.limits={chord_m: {minimum: 0.1}}",
        "design_space.limits={chord_m: {minimum: 0.11}}",
        "design_space.battery_mass_kg={minimum: 0.2, maximum: 60}",
        "airframe.structure.torsion=null",
    ):
        other = design(override)
        assert kind_of(other) != kind_of(design()), override
        assert build_problem(other, 1).program is not same, override
    assert build_problem(design(), 2).program is not same
    assert build_problem(design("power.avionics_w=3"), 1).program is same


def test_limits_in_another_order_keep_their_rows() -> None:
    place = mission(latitude_deg=47.0)
    texts = ("chord_m: {minimum: 0.1}", "wing_area_m2: {maximum: 9}")
    for order in (texts, texts[::-1]):
        aircraft = design(f"design_space.limits={{{', '.join(order)}}}")
        found = at_a_point(build_problem(aircraft, 1), aircraft, place)
        assert found == pytest.approx(by_the_formulas(aircraft, place), rel=1e-9)


def test_problems_of_one_aircraft_keep_its_program() -> None:
    problems = SizingProblems(design())
    assert problems.of(2) is problems.of(2)
    assert problems.of(2, eased=True).program is not problems.of(2).program


@pytest.mark.parametrize("factor", [0.5, 3.0])
def test_an_eased_limit_is_the_limit_times_a_factor(factor: float) -> None:
    place, names = mission(latitude_deg=47.0), ("chord_m_minimum", "wing_area_m2_maximum")

    def limited(times: float) -> Aircraft:
        ends = f"chord_m: {{minimum: {0.2 * times}}}, wing_area_m2: {{maximum: {4.0 * times}}}"
        return design(f"design_space.limits={{{ends}}}")

    aircraft = limited(1.0)
    rows = at_a_point(
        build_problem(aircraft, 1, eased=True), aircraft, place, **dict.fromkeys(names, factor)
    )
    assert rows == pytest.approx(by_the_formulas(limited(factor), place), rel=1e-9, abs=1e-12)
    # By hand: b/AR = 5 m/18.5 over 0.2 m, and b^2/AR over 4 m2.
    aspect = aircraft.airframe.aspect_ratio
    assert rows[names[0]] == pytest.approx(5.0 / aspect / (0.2 * factor) - 1.0, rel=1e-9)
    assert rows[names[1]] == pytest.approx(1.0 - 25.0 / aspect / (4.0 * factor), rel=1e-9)


def test_technology_that_is_eased_is_the_technology_times_a_factor() -> None:
    # Of a given temperature: that of modules in balance follows from the technology.
    place = mission(latitude_deg=47.0, air={"module_temperature_c": 20.0})
    aircraft = design()
    problem = build_problem(aircraft, 1, eased=True)
    own = at_a_point(problem, aircraft, place)
    for one in problem.of_role(Role.technology):
        value = parameter_value(aircraft, None, one.name)
        assert value is not None
        if one.name == SOLAR_TECHNOLOGY:  # the sun's power per area holds it already
            continue
        rows = at_a_point(problem, aircraft, place, **{one.name: 1.1})
        changed = all_replaced(aircraft, {one.name: 1.1 * value})
        assert rows == pytest.approx(by_the_formulas(changed, place), rel=1e-9, abs=1e-12)
        assert rows != own, one.name


@pytest.mark.parametrize(
    "limit",
    [
        "{kind: none}",
        "{kind: rule, c_rate_per_h: 0.5, taper_start: 0.9, relative_rate_at_full: 0.046}",
        "{kind: rule, c_rate_per_h: 0.15, taper_start: 0.5, relative_rate_at_full: 0.1}",
    ],
)
@pytest.mark.parametrize(("latitude", "battery_kg"), [(47.6, 2.918), (20.0, 4.0), (60.0, 3.5)])
def test_day_of_the_program_repeats_itself_where_that_of_the_simulator_does(
    limit: str, latitude: float, battery_kg: float
) -> None:
    # The march on arrays and the rows on symbols say the same physics twice: the state of charge at
    # dawn to which the march settles is the one that the rows' day leads back to.
    plane = aircraft(
        "atlantiksolar-design",
        f"battery.charge_limit={limit}",
        f"battery.mass_kg={battery_kg}",
        "modules.area_m2=1.3",
    )
    place = mission(latitude_deg=latitude, turbulence={"all_day": 0.05, "thermal": 0.2})
    day = solar_day(plane, place)
    flown = performance(plane, place, UNCORRECTED_CAM, day=day)
    dawn = float(flown.cycle.minimum_state_of_charge[0])
    design, battery = flown.design, plane.battery
    deficit, charged = (
        float(value)
        for value in cycle_function(battery.charge_limit)(
            *(1.3, design.battery_energy_wh, design.nominal_load_w(place)),
            *(design.propulsion_power_w, dawn),
            [battery.mean_charge_efficiency, battery.mean_discharge_efficiency],
            sun_parameters(day, place)[0],
        )
    )
    assert dawn > 0.0
    # The program's day has 97 nodes from sunrise to sunset, the simulator's one every few minutes.
    assert min(charged, 1.0) - deficit == pytest.approx(dawn, abs=0.003)


def test_a_warm_start_has_a_multiplier_of_zero() -> None:
    # CasADi's QRQP ended the whole process where all multipliers of an interior point changed
    # their signs at once: its list of changes is one too short for that.
    design, there = aircraft("atlantiksolar-design"), mission()
    given = (SizingProblems(design), there, UNCORRECTED_CAM, solar_day(design, there))
    solver = ProgramSolver(*given)
    instance = ProblemInstance.of(Objective.min_mass, 0.0)
    found = solver.solve(instance, [0], [variables_of(design)])
    assert found is not None
    rows, bounds = np.ones(len(found.constraints)), np.ones(len(found.variables))
    inner = replace(found, constraint_multipliers=rows, bound_multipliers=bounds)
    starts: list[dict[str, Any]] = []
    solved = ProgramSolver._solved

    def watched(self: Any, posed: Any, effort: Any, start: Any) -> Any:
        starts.append(dict(start))
        return solved(self, posed, effort, start)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ProgramSolver, "_solved", watched)
        again = solver.solve(instance, [0], [variables_of(design)], previous=inner)
    assert again is not None
    assert again.design.wingspan_m == pytest.approx(found.design.wingspan_m, rel=1e-6)
    multipliers = np.concatenate([starts[0]["lam_x0"], starts[0]["lam_g0"]])
    assert np.count_nonzero(multipliers) == len(rows) + len(bounds) - 1
