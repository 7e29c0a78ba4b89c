"""The checker of wild problems can fail: wrong answers that are planted must be seen."""

from dataclasses import replace

import numpy as np
import pytest
from builders import DESIGN, mission

from benchmarks import wild_missions
from benchmarks.simulated_search import Effort
from benchmarks.wild_problems import WildProblem, wild_problem
from benchmarks.wild_verdicts import PASSED, claim_of, judged
from missions.files.validation import validate
from missions.files.yaml import read_yaml
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective

pytestmark = pytest.mark.slow

PROBLEM = WildProblem(
    seed=0,
    aircraft=DESIGN,
    mission=mission(),
    objective=Objective.min_mass,
    required_h=4.0,
    solar=UNCORRECTED_CAM,
    tags=("test",),
)
SHORT = Effort(drawn=60, population=16, generations=20, polishing=20)
# Enough where the search begins at a design that is known.
SHORTEST = Effort(drawn=16, population=12, generations=2, polishing=12)


@pytest.fixture(scope="module")
def truth():
    """Return what the product says of the problem."""
    return claim_of(PROBLEM)


def test_the_optimum_agrees_and_the_search_finds_it_alone(truth):
    row = judged(PROBLEM, truth, effort=SHORTEST)
    assert row["verdict"] == "agree"
    # Without the optimum's neighbourhood, from random designs alone.
    alone = judged(PROBLEM, replace(truth, design=None, value=None), effort=SHORT)
    # So short a search comes within a few per cent.
    assert alone["found"] == pytest.approx(truth.value, rel=0.05)


def test_a_heavier_design_is_a_false_optimum(truth):
    heavier = truth.design._replace(
        wingspan_m=1.02 * truth.design.wingspan_m,
        battery_mass_kg=1.1 * truth.design.battery_mass_kg,
        module_area_m2=1.1 * truth.design.module_area_m2,
    )
    perf = performance_of_designs(DESIGN, PROBLEM.mission, heavier.mapped(np.atleast_1d))
    wrong = replace(truth, value=float(perf.design.total_mass_kg[0]), design=heavier)
    row = judged(PROBLEM, wrong, effort=SHORTEST)
    assert row["verdict"] == "false optimum"
    assert row["gain_percent"] > 1.0
    # The design that was found is kept, and stands for a search.
    again = judged(PROBLEM, wrong, earlier=row)
    assert (again["verdict"], again["found"]) == (row["verdict"], row["found"])
    assert judged(PROBLEM, truth, earlier=row)["verdict"] in PASSED


def test_a_claim_of_infeasibility_is_refuted(truth):
    wrong = replace(truth, status="infeasible", value=None, design=None)
    assert judged(PROBLEM, wrong, effort=SHORTEST)["verdict"] == "false infeasible"


def test_a_value_that_its_design_does_not_have_is_unsound(truth):
    lighter = replace(truth, value=0.99 * truth.value)
    assert judged(PROBLEM, lighter, effort=SHORTEST)["verdict"] == "unsound"
    empty = truth.design._replace(battery_mass_kg=0.8 * truth.design.battery_mass_kg)
    assert judged(PROBLEM, replace(truth, design=empty), effort=SHORTEST)["verdict"] == "unsound"


def test_problems_are_the_same_every_time_and_can_be_written(tmp_path):
    for number in range(8):
        problem = wild_problem(3, number)
        assert problem == wild_problem(3, number)
        row = {"objective": problem.objective.value, "required_h": problem.required_h}
        row |= {"number": number, "verdict": "unsound", "status": "optimal", "value": 1.0}
        row |= {"says": "", "found": None, "gain_percent": None, "found_design": {}, "tags": []}
        row |= {"model": problem.solar.model, "correction": problem.solar.correction}
        wild_missions.write_case(tmp_path, row, problem)
        read = [
            validate(read_yaml(tmp_path / f"{number}-{kind}.yaml"), record)
            for kind, record in (("aircraft", Aircraft), ("mission", Mission))
        ]
        assert read == [problem.aircraft, problem.mission]


@pytest.mark.parametrize(
    ("number", "required_h", "searched"),
    [(101, 0.0, 201.86), (106, 6.54, 4.1105), (108, 32.1, 12.15)],
    ids=["payload far above the first design's", "next to no battery", "thermals at midnight sun"],
)
def test_problems_that_programs_failed_in_have_their_optimum(number, required_h, searched):
    """Each ended as infeasible once: a program that failed, or a battery that thermals emptied.

    The first two have the optimum of another optimiser; of the third no other found any, and what
    is asked for is less than a design that the simulator accepts has.
    """
    problem = wild_problem(3, number).requiring(required_h)
    value = claim_of(problem).value
    sign = 1.0 if problem.objective.maximised else -1.0
    assert sign * value >= sign * searched * (1.0 - sign * 2e-3)
