"""Where the sun never sets: designs that live on it at all times, and those that need a battery."""

from dataclasses import replace
from typing import NamedTuple

import builders
import numpy as np
import pytest
from builders import mission as july_day

from missions.air import standard_air
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel, solar_day
from sizing.day.metrics import Status
from sizing.design import variables_of
from sizing.performance import performance_of_designs
from sizing.program.cells import _Cells, size_cells
from sizing.program.corrections import CUSHION_H
from sizing.program.cross_check import cross_check
from sizing.program.objectives import Objective
from sizing.program.result import SizingStatus, objective_value
from sizing.program.search import Search
from sizing.program.size import size_aircraft
from sizing.program.task import SizingTask

# A structure as heavy as AtlantikSolar's at its size, by a formula that known designs can rely on.
STRUCTURE = "airframe.structure={model: power_law, coefficient_kg: 0.0131, span_exponent: 3.1, "
STRUCTURE += "aspect_ratio_exponent: -0.25}"
LIGHT_BATTERY = "design_space.battery_mass_kg={minimum: 0.1, maximum: 150}"


def aircraft(*overrides):
    return builders.aircraft("atlantiksolar-design", STRUCTURE, *overrides)


MIN_MASS = Objective.min_mass


def as_cold(altitude_m):
    """Air whose modules are as cold: the known designs are of such modules."""
    return {"module_temperature_c": float(standard_air(altitude_m).temperature_c)}


def mission(**changes):
    plain = {"latitude_deg": 80.0, "altitude_m": 0.0, "turbulence": {"thermal": 1.0}}
    return july_day(**plain | {"air": as_cold(0.0)} | changes)


class Known(NamedTuple):
    """A sizing, and a good design for it that a search by simulation alone has found."""

    plane: Aircraft
    mission: Mission
    objective: Objective
    required_h: float
    solar: SolarModel
    design: dict[str, float]

    @classmethod
    def of(cls, name):
        plane, where, row = builders.hard_case(name)
        objective, required_h, *solar = row["sized_for"]
        given = Objective(objective), required_h, SolarModel(*solar)
        return cls(plane, where, *given, row["known"])

    def sized(self):
        given = self.plane, self.mission, self.objective, self.solar
        return size_aircraft(*given, required_excess_time_h=self.required_h)

    def value(self):
        """Objective of the known design, which the simulator must accept."""
        variables = variables_of(self.plane)._replace(**self.design)
        perf = performance_of_designs(self.plane, self.mission, variables, self.solar)
        worst_h = float(np.min(perf.cycle.excess_time_h))
        assert worst_h > 0.0
        assert worst_h >= self.required_h
        return float(objective_value(self.objective, perf))


@pytest.mark.parametrize(
    "name",
    [
        "thermals at noon, one day",
        "more required than any battery has",
        "battery for the thermals alone",
        "a range of latitudes",
    ],
)
def test_thermals_under_a_midnight_sun_cost_no_more_than_they_must(name):
    known = Known.of(name)
    result = known.sized()
    assert result.status is SizingStatus.optimal
    assert result.objective_value <= known.value() * 1.001
    assert (result.simulated.cycle.status == Status.always_lit).all()
    assert any(name.startswith("always_lit") for name in result.active_constraints) or any(
        name.startswith("battery_capacity") for name in result.active_constraints
    )


@pytest.mark.parametrize(
    "climb",
    [
        pytest.param(None, id="level"),
        pytest.param({"ceiling_m": 12300.0}, id="climbs", marks=pytest.mark.long),
    ],
)
def test_modules_cooled_otherwise_than_the_first_guess_s_still_carry_the_load(climb):
    # The first guess has 5.6 m of span, the optimum 12 m: its modules are warmer by a degree or so.
    plane = aircraft("design_space.wingspan_m.maximum=40", LIGHT_BATTERY)
    high = mission(climb=climb).model_copy(update={"altitude_m": 12000.0})
    given = (plane, high, Objective.max_payload_power)
    result = size_aircraft(*given, required_excess_time_h=26.0)
    assert np.isinf(result.simulated.cycle.excess_time_h).all()
    lowest_w = result.simulated.solar_power_w.min(axis=-1)
    assert lowest_w == pytest.approx(result.simulated.nominal_load_w, rel=1e-3)
    where = Scenarios(np.array([80.0]), np.array([196]))
    cells = size_cells(plane, high, where, given[2], required_excess_time_h=26.0)
    assert cells.objective_value == pytest.approx([result.objective_value], rel=1e-3)


def test_dates_with_and_without_a_night_are_sized_together():
    # The sun sets at 76° N from the middle of August on; until then it may do without a battery.
    ranged = mission(dates={"from": "06-21", "to": "08-18", "count": 3})
    ranged = ranged.model_copy(update={"latitude_deg": 76.0})
    plane = aircraft("design_space.wingspan_m.maximum=12")
    result = size_aircraft(plane, ranged, MIN_MASS, required_excess_time_h=3.0)
    assert result.feasible
    assert cross_check(plane, ranged, result).cross_checked


def test_only_requirements_that_limit_are_named():
    result = Known.of("a range of latitudes").sized()
    assert result.active_constraints == (
        "always_lit (76.8° N, 15 Jul)",
        "module_coverage",
        "battery_mass_kg at its minimum",
    )


def test_later_cell_of_two_midnight_suns_has_the_design_of_a_single_sizing():
    known = Known.of("thermals at noon, one day")
    days = mission(dates={"from": "07-05", "to": "07-15", "count": 2})
    polar = days.scenarios()
    ordinary = np.full(len(polar), 45.0)
    cells = size_cells(
        known.plane,
        days,
        Scenarios(
            np.concatenate([ordinary, polar.latitude_deg]),
            np.concatenate([polar.day_of_year, polar.day_of_year]),
        ),
        MIN_MASS,
        required_excess_time_h=12.0,
        scenarios_per_cell=len(polar),
    )
    alone = size_aircraft(known.plane, days, MIN_MASS, required_excess_time_h=12.0)
    assert (alone.simulated.cycle.status == Status.always_lit).all()
    assert np.isinf(cells.excess_time_h[1])
    # Both stop within 0.012 h of the requirement.
    assert cells.objective_value[1] == pytest.approx(alone.objective_value, rel=1e-3)


def test_climbs_under_a_sun_that_never_sets_have_no_excess_time_to_correct():
    plane, climb = builders.DESIGN, {"ceiling_m": 2536.0}
    there = july_day(latitude_deg=80.0, dates={"on": "06-21"}, climb=climb)
    goal = Objective.min_wingspan, SolarModel(), solar_day(plane, there), 1.0
    task = SizingTask(plane, there, *goal, continuous=True)
    # The first optimum of the program has a battery's excess time left: 2.4 h, which is none of
    # the row that is switched off.
    large = {"wingspan_m": 5.5, "battery_mass_kg": 4.0, "module_area_m2": 1.2}
    search = Search(task, task.first_values(variables_of(plane)._replace(**large))).run()
    assert search.status is SizingStatus.optimal
    assert search.scenarios[0].bias_h == CUSHION_H
    assert search.report.solves == 2


def test_a_second_search_of_a_cell_has_its_verdict_where_the_first_had_none():
    plane, dark = builders.DESIGN, july_day(latitude_deg=80.0, dates={"on": "12-21"})
    day = solar_day(plane, dark)
    task = SizingTask(plane, dark, MIN_MASS, SolarModel(), day, 0.0)
    cells = _Cells([task], day, searches={0: Search(task)})  # which ended open
    cells._run({0: Search(replace(task, continuous=True))})
    assert cells.searches[0].status is SizingStatus.not_converged
    cells._run({0: Search(task)})
    assert cells.searches[0].status is SizingStatus.infeasible
