"""Sizings with climbs, beside level flight and other simulated designs."""

from functools import cache

import numpy as np
import pytest
from builders import DESIGN, aircraft
from builders import mission as plain_day
from builders import shipped_mission as mission

import sizing
from missions.mission import Scenarios
from sizing.day.light import solar_day
from sizing.limits import meets_requirements
from sizing.parameters import all_replaced
from sizing.performance import performance_of_designs
from sizing.program.cells import size_cells
from sizing.program.objectives import Objective
from sizing.program.result import SizingStatus, merit_of
from sizing.program.size import size_aircraft


def climbing(ceiling_m, **changes):
    return mission(climb={"ceiling_m": ceiling_m}, **changes)


@cache
def sized(objective, ceiling_m, date="07-15"):
    return size_aircraft(DESIGN, climbing(ceiling_m, dates={"on": date}), objective)


@pytest.mark.slow
@pytest.mark.parametrize(
    "objective", [Objective.min_mass, Objective.max_excess_time, Objective.max_payload_mass]
)
def test_no_design_nearby_is_better(objective):
    result, there = sized(objective, 2536.0), climbing(2536.0)
    rng, own = np.random.default_rng(5), result.design.variables
    names = ("wingspan_m", "battery_mass_kg", "module_area_m2")
    near = {n: getattr(own, n) * np.exp(rng.normal(0.0, 0.02, 40)) for n in names}
    flown = performance_of_designs(DESIGN, there, own._replace(**near))
    good = np.min(flown.cycle.excess_time_h, axis=-1) > result.required_excess_time_h
    good &= np.asarray(meets_requirements(DESIGN, flown.design))
    # Each flies the best schedule of its own, which a sizing knows to half a per cent.
    best = float(np.where(good, merit_of(objective, flown), -np.inf).max())
    assert best <= result.merit + 0.01 * abs(result.merit)


def test_turbulence_above_the_rated_power_leaves_level_flight():
    # Level flight is not held to the rated power, which such air exceeds; so a climb has nothing
    # to take from, and the ceiling changes nothing.
    rough = {"turbulence": {"all_day": 0.6}}
    weak = all_replaced(DESIGN, {"airframe.propulsion.climb_power_ratio": 1.3})
    level = size_aircraft(weak, mission(**rough), Objective.min_mass)
    ours = size_aircraft(weak, climbing(2536.0, **rough), Objective.min_mass)
    assert ours.objective_value == pytest.approx(level.objective_value, rel=2e-3)


def test_what_is_sized_flies_as_analysed():
    study = sizing.size(DESIGN, climbing(3536.0), required_excess_time_h=1.0)
    again = sizing.analyse(study.sized_aircraft(), study.sized_mission())
    # The analysis has the best schedule of this design, the sizing one that is enough.
    # Both are known to what a round of program and simulator leaves.
    assert 0.995 <= again.excess_time_h < 1.1
    assert study.optimum.worst_scenario.climb.maximum_altitude_m == pytest.approx(3536.0, abs=5.0)
    level = study.without_climbs
    assert level.objective_value > 1.02 * study.result.objective_value
    assert "highest altitude" in str(study)


@pytest.mark.slow
def test_what_is_asked_of_a_sizing_knows_climbs():
    study = sizing.size(DESIGN, climbing(2536.0), with_sensitivities=True)
    assert study.sensitivities
    failed = sizing.size(DESIGN, climbing(2536.0, dates={"on": "12-21"}))
    assert failed.result.status is SizingStatus.infeasible
    assert failed.relaxations


@pytest.mark.slow
def test_cells_are_the_sizings_of_each():
    days = np.array([166, 196, 226])
    there = climbing(2536.0)
    cells = size_cells(
        DESIGN, there, Scenarios(np.full(3, 47.6), days), Objective.min_mass, scenarios_per_cell=1
    )
    for place, day in enumerate(days.tolist()):
        place_of = Scenarios(np.array([47.6]), np.array([day]))
        light = solar_day(DESIGN, there, scenarios=place_of)
        alone = size_aircraft(DESIGN, there, Objective.min_mass, day=light)
        assert cells.objective_value[place] == pytest.approx(alone.objective_value, rel=5e-3)


def test_an_optimum_is_shown_with_heights_that_suffice_in_every_scenario():
    # In the first scenario heights of the program suffice where those found for the design alone
    # lack 0.004 h; in the others it is the other way round.
    plane = aircraft("atlantiksolar-design", "design_space.maximum_total_mass_kg=9")
    where = plain_day(
        latitude_deg={"from_deg": -17.6456, "to_deg": -14.0, "count": 3},
        dates={"on": "07-01"},
        altitude_m=1904.1964132646328,
        climb={"ceiling_m": 4698.228871023729},
    )
    result = size_aircraft(plane, where, Objective.max_payload_mass, required_excess_time_h=1.0)
    assert result.status is SizingStatus.optimal
    shown = result.simulated
    assert np.min(shown.cycle.excess_time_h) >= 1.0
    assert shown.cycle.energy_wh.shape == shown.altitude_m.shape == shown.load_w.shape
