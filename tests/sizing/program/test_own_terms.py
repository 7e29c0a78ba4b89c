"""Objectives and constraints of the user's own, against shipped ones."""

import re
from pathlib import Path

import numpy as np
import pytest

import missions
import sizing
from sizing.design import variables_of
from sizing.mass_budget import closed_design
from sizing.program.own_terms import NAMES, with_own_terms

REQUIRED_H = 3.0
MISSION = missions.load_mission("central-europe-summer", {"required_excess_time_h": REQUIRED_H})
DESIGN = sizing.load_aircraft("atlantiksolar-design")
JULY = missions.load_mission("rafz-july", {"required_excess_time_h": REQUIRED_H})


@pytest.fixture(scope="module")
def free():
    return sizing.size(DESIGN, MISSION)


@pytest.mark.parametrize(
    ("shipped", "own"),
    [
        ("min_mass", lambda design: design.total_mass_kg),
        ("min_wingspan", lambda design: design.wingspan_m),
        ("min_wingspan", lambda design: design.wingspan_m**2 - 30.0),  # negative at the optimum
        ("min_wingspan", lambda design: design.wingspan_m - 5.65),  # nothing at first
    ],
)
def test_a_shipped_objective_written_as_a_function(shipped, own):
    expected, found = (sizing.size(DESIGN, MISSION, one) for one in (shipped, own))
    assert found.feasible
    # Each search ends where excess time above the required one is worth 0.03 % of the objective.
    chosen = found.variables.chosen()
    for name, value in expected.variables.chosen().items():
        assert chosen[name] == pytest.approx(value, rel=2e-3, abs=1e-9)
    assert found.design.total_mass_kg == pytest.approx(expected.design.total_mass_kg, rel=2e-3)
    if shipped == "min_mass":
        assert found.result.objective_value == pytest.approx(
            expected.result.objective_value,
            rel=1e-4,  # of searches by two programs
        )


@pytest.mark.parametrize(
    ("key", "limit", "constraint"),
    [
        ("wingspan_m.maximum", 4.5, lambda design: design.wingspan_m <= 4.5),
        ("maximum_wing_loading_kg_per_m2", 3.3, lambda d: d.wing_loading_kg_per_m2 <= 3.3),
        ("limits.airspeed_m_per_s.maximum", 7.5, lambda d: d.airspeed_m_per_s <= 7.5),
        # Quantities on both sides.
        (
            "limits.battery_fraction.maximum",
            0.35,
            lambda d: d.battery_mass_kg <= 0.35 * d.total_mass_kg,
        ),
    ],
)
def test_a_constraint_is_a_bound_of_the_design_space(free, key, limit, constraint):
    bounded = sizing.load_aircraft("atlantiksolar-design", {f"design_space.{key}": limit})
    expected = sizing.size(bounded, MISSION)
    found = sizing.size(DESIGN, MISSION, constraints=[constraint])
    # What two searches leave of the objective where it is an excess time.
    assert found.result.objective_value == pytest.approx(expected.result.objective_value, rel=5e-5)
    assert found.result.objective_value > 1.0005 * free.result.objective_value
    assert any("<=" in one for one in found.result.active_constraints)
    assert found.aircraft == DESIGN


@pytest.mark.long
def test_an_infeasible_answer_names_the_constraint():
    def fits_the_van(it):
        return it.wingspan_m <= 3.0

    for constraint, name in (
        (fits_the_van, "fits_the_van"),
        (lambda d: d.chord_m >= 2, "2<=chord_m"),
    ):
        found = sizing.size(DESIGN, MISSION, constraints=[constraint])
        assert found.status is sizing.SizingStatus.infeasible
        assert name in " ".join(str(found).split())
        assert found.to_dict()["violated_requirements"]


@pytest.mark.parametrize("count", [0, 1, 3])
def test_a_constraint_of_a_batch_has_an_answer_for_each_design(count):
    held, _ = with_own_terms(DESIGN, JULY, None, [lambda it: it.wingspan_m <= 4.5])
    spans = np.linspace(4.0, 5.0, count)
    batch = closed_design(held, JULY, variables_of(DESIGN)._replace(wingspan_m=spans))
    (row,) = held.design_space.user_requirements(batch)
    assert row.value == pytest.approx((4.5 - spans) / 4.5)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda d: d.mass, "a design has no mass; it has wingspan_m, aspect_ratio"),
        (lambda d: max(d.wingspan_m, 3.0), "is called with symbols"),
        (lambda d: 3.0, r"must return one number that depends on the design \(got 3.0\)"),
        (lambda d: None, r"must return one number .* \(got None\)"),
    ],
)
def test_wrong_functions(wrong, said):
    with pytest.raises(ValueError, match=f"the objective:? {said}"):
        sizing.size(DESIGN, MISSION, wrong)
    with pytest.raises(ValueError, match=f"a constraint:? {said}"):
        sizing.size(DESIGN, MISSION, constraints=[wrong])


def excess_time(it):
    return it.wingspan_m <= 5.0


@pytest.mark.parametrize(
    ("terms", "said"),
    [
        ({"objective": lambda d: d.wingspan_m <= 3.0}, "the objective is a comparison"),
        ({"constraints": [lambda d: d.wingspan_m]}, "must be one comparison by <= or >="),
        ({"constraints": [lambda d: d.wingspan_m == 4.0]}, "must be one comparison by <= or >="),
        ({"constraints": [excess_time]}, "there is a excess_time already"),
    ],
)
def test_wrong_comparisons(terms, said):
    with pytest.raises(ValueError, match=said):
        sizing.size(DESIGN, MISSION, **terms)


def test_the_documented_names_are_those_that_there_are():
    page = (Path(__file__).parents[3] / "docs" / "python-api.md").read_text(encoding="utf-8")
    table = page.split("| quantity of a design | names |")[1].split("\n\n")[0]
    assert set(re.findall(r"`(\w+)`", table)) == set(NAMES)
