"""The checker of wild problems can fail: wrong answers that are planted must be seen."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from builders import DESIGN, mission
from click.testing import CliRunner

from benchmarks import wild_missions, wild_verdicts
from benchmarks.simulated_search import Effort, RangeJudge
from benchmarks.wild_problems import WildProblem, wild_problem
from benchmarks.wild_verdicts import Claim, claim_of, judged
from missions.files.validation import validate
from missions.files.yaml import read_yaml
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import UNCORRECTED_CAM
from sizing.performance import performance_of_designs
from sizing.program.objectives import Objective
from sizing.relaxed_flight import Relaxation

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
def truth() -> Claim:
    """Return what the product says of the problem."""
    return claim_of(PROBLEM)


def test_the_optimum_agrees_and_the_search_finds_it_alone(truth: Claim) -> None:
    row = judged(PROBLEM, truth, effort=SHORTEST)
    assert row["verdict"] == "agree"
    # Without the optimum's neighbourhood, from random designs alone.
    alone = judged(PROBLEM, replace(truth, design=None, value=None), effort=SHORT)
    # So short a search comes within a few per cent.
    assert alone["found"] == pytest.approx(truth.value, rel=0.05)


def test_a_heavier_design_is_a_false_optimum(truth: Claim) -> None:
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
    assert judged(PROBLEM, truth, earlier=row)["verdict"] == "agree"


def test_a_claim_of_infeasibility_is_refuted(truth: Claim) -> None:
    wrong = replace(truth, status="infeasible", value=None, design=None)
    assert judged(PROBLEM, wrong, effort=SHORTEST)["verdict"] == "false infeasible"


def test_a_value_that_its_design_does_not_have_is_unsound(truth: Claim) -> None:
    lighter = replace(truth, value=0.99 * truth.value)
    assert judged(PROBLEM, lighter, effort=SHORTEST)["verdict"] == "unsound"
    empty = truth.design._replace(battery_mass_kg=0.8 * truth.design.battery_mass_kg)
    assert judged(PROBLEM, replace(truth, design=empty), effort=SHORTEST)["verdict"] == "unsound"


def test_a_relaxation_that_does_not_suffice_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    span = DESIGN.design_space.wingspan_m.model_copy(update={"maximum": 4.0})
    space = DESIGN.design_space.model_copy(update={"wingspan_m": span})
    narrow = replace(PROBLEM, aircraft=DESIGN.model_copy(update={"design_space": space}))
    problem = narrow.requiring(12.0)
    claim = claim_of(problem)
    assert claim.status == "infeasible"
    assert judged(problem, claim, effort=SHORTEST)["verdict"] == "agree"
    key = "design_space.wingspan_m.maximum"
    planted = [Relaxation(key, "m", 4.0, "at least", value, 12.0) for value in (4.01, 12.0)]
    monkeypatch.setattr(wild_verdicts, "relaxations", lambda *_: planted)
    found = wild_verdicts.checked_relaxations(problem, claim)
    assert [one["status"] for one in found] == ["infeasible", "optimal"]
    # 1 % less than 4.01 is less than now
    assert [one["with_less"] for one in found] == [None, "optimal"]


def test_problems_are_the_same_every_time_and_can_be_written(tmp_path: Path) -> None:
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
    ("objective", "held", "longest"),
    [
        # Across the year's end, and not across a pole; n latitudes span n - 1 degrees.
        (Objective.longest_season, [*range(10), *range(350, 365)], 25),
        (Objective.widest_latitude_band, [*range(10), *range(160, 181)], 20),
        (Objective.longest_season, list(range(365)), 365),
        (Objective.longest_season, [], 0),
    ],
)
def test_longest_run(objective: Objective, held: list[int], longest: int) -> None:
    judge = RangeJudge(replace(PROBLEM, objective=objective))
    excess_h = np.full(365 if judge.season else 181, -1.0)
    excess_h[held] = 5.0
    assert int(judge._longest_run(excess_h)) == longest


def test_rows_are_kept_and_not_computed_again(tmp_path: Path) -> None:
    rows = tmp_path / "rows.jsonl"
    row = {"number": 0, "verdict": "agree", "status": "optimal", "product_cpu_s": 0.1}
    row |= {"search_cpu_s": 1.0, "gain_percent": 0.0, "value": 7.0, "found_by_chance": 7.1}
    rows.write_text(json.dumps(row) + "\n", encoding="utf-8")
    done = CliRunner().invoke(wild_missions.main, ["--count", "1", "--rows", str(rows)])
    assert done.exit_code == 0, done.output
    assert "1 problems: 1 optimal" in done.output
    assert "by chance alone: 1 of 1" in done.output
