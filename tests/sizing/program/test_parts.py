"""Tests of sizing with a propulsion at its operating point: the exact chain judges every design."""

import numpy as np
import pytest
from builders import shipped_mission
from propulsors import PARTS, aircraft

import sizing
from missions.library import load_mission
from missions.mission import Scenarios
from missions.mission.scenarios import Dates
from sizing.design import DesignVariables
from sizing.mass_budget import ImpossibleDesignError, level_point
from sizing.performance import performance_of_designs
from sizing.program.cells import size_cells
from sizing.program.objectives import Objective
from sizing.program.size import size_aircraft

MISSION = load_mission("rafz-july")
TWIN = sizing.load_aircraft("twin-boom-design")
WEAK = {"speed_constant_rpm_per_v": 317, "resistance_ohm": 0.299, "no_load_current_a": 0.137}
WEAK |= {"maximum_current_a": 1.4, "mass_kg": 0.48}
CHOSEN = {
    "propeller_diameter_m": (0.4, 1.0),
    "propeller_pitch_m": (0.3, 1.0),
    "gear_ratio": (2.0, 12.0),
    "motor_speed_constant_rpm_per_v": (100.0, 800.0),
}


def ranged(*names, motor=PARTS["motor"]):
    ends = {name: dict(zip(("minimum", "maximum"), CHOSEN[name], strict=True)) for name in names}
    space = {f"design_space.{name}": one for name, one in ends.items()}
    return aircraft(space, motor=motor)


def neighbours_excess_h(own, result, relative):
    """Mass [kg] and excess time [h] of designs with one variable moved, by name."""
    variables = result.design.variables
    chosen = {name: float(one) for name, one in variables.chosen().items()}
    names = [name for name in chosen if name != "aspect_ratio" and chosen[name] > 0.0]
    moved = [chosen | {name: chosen[name] * (1.0 + relative)} for name in names]
    stacked = {name: np.array([one[name] for one in moved]) for name in chosen}
    flown = performance_of_designs(own, MISSION, DesignVariables(**stacked))
    pairs = zip(flown.design.total_mass_kg, flown.cycle.excess_time_h.min(axis=-1), strict=True)
    return dict(zip(names, ((float(m), float(h)) for m, h in pairs), strict=True))


@pytest.mark.parametrize(
    ("objective", "required_h", "least"),
    [
        # Of the program with formulas that went before, to what it left of excess time.
        pytest.param("min_mass", 0.5, -5.148, id="lightest", marks=pytest.mark.long),
        # With 3 kg of payload a sizing for the least mass finds a design.
        pytest.param("max_payload_mass", 1.0, 3.0, id="payload", marks=pytest.mark.long),
        pytest.param("max_excess_time", 0.0, 10.5, id="longest", marks=pytest.mark.long),
    ],
)
def test_parts_hold_a_sizing_back_or_not(objective, required_h, least):
    goal = Objective(objective)
    result = size_aircraft(TWIN, MISSION, goal, required_excess_time_h=required_h)
    assert result.design is not None
    assert result.merit > least
    # Without limits of its own the point would be NaN, and the design heavier than anything.
    assert level_point(TWIN, MISSION, result.design).reason == ""
    assert result.simulated.cycle.excess_time_h.min() >= required_h


@pytest.mark.parametrize(
    "names",
    [
        pytest.param((), marks=pytest.mark.long),
        ("propeller_diameter_m", "gear_ratio"),
        pytest.param(tuple(CHOSEN), marks=pytest.mark.long),
    ],
)
def test_no_neighbour_is_lighter(names):
    own = ranged(*names)
    result = size_aircraft(own, MISSION, Objective.min_mass)
    for relative in (-0.03, 0.03):
        for name, (mass_kg, excess_h) in neighbours_excess_h(own, result, relative).items():
            # A sizing may leave this much of its objective.
            better = mass_kg < result.design.total_mass_kg * (1.0 - 5e-4) and excess_h > 0.0
            assert not better, f"{name} {relative:+g}"


@pytest.mark.long
def test_a_limit_of_the_motor_is_kept():
    own = ranged(*list(CHOSEN)[:3], motor=WEAK)
    result = size_aircraft(own, MISSION, Objective.min_mass)
    assert result.design is not None
    point = level_point(own, MISSION, result.design)
    assert point.reason == ""
    assert float(point.motor_current_a) == pytest.approx(1.4, rel=1e-3)
    assert "motor_current" in result.active_constraints


@pytest.mark.long
def test_what_the_parts_cannot_do_has_a_reason():
    fast = aircraft(gear=PARTS["gear"] | {"ratio": 9.0})
    with pytest.raises(ImpossibleDesignError, match=r"level flight .* bus voltage 18 V is below"):
        size_aircraft(fast, MISSION, Objective.min_mass)


def test_cells_with_parts_are_sized_as_one_by_one():
    latitudes_deg = [30.0, 45.0]
    days = np.full(2, 172)
    found = size_cells(TWIN, MISSION, Scenarios(np.array(latitudes_deg), days), Objective.min_mass)
    for latitude_deg, mass_kg in zip(latitudes_deg, found.objective_value, strict=True):
        there = {"latitude_deg": latitude_deg, "dates": Dates(on="06-21")}
        alone = size_aircraft(TWIN, MISSION.model_copy(update=there), Objective.min_mass)
        assert mass_kg == pytest.approx(alone.objective_value, rel=2e-3)


def test_parts_climb_by_day_and_are_lighter_for_it():
    climbing = shipped_mission(climb={"ceiling_m": 2536.0})
    level, result = (
        size_aircraft(TWIN, where, Objective.min_mass) for where in (MISSION, climbing)
    )
    assert np.all(result.simulated.cycle.excess_time_h > 0.0)
    assert result.objective_value < 0.99 * level.objective_value
