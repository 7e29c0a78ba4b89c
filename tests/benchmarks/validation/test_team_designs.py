"""Aircraft that flew, from what ``init`` writes, beside the aim of the page."""

import pytest

from benchmarks.validation.team_designs import computed, factor_without, team_designs
from sizing.structures.build import build_qualities

GIVEN = [key for key, one in team_designs().items() if "geometry" in one]


@pytest.mark.parametrize("key", GIVEN)
def test_masses_at_a_given_size_are_within_the_aim_without_their_own_structure(key):
    one = team_designs()[key]
    for build in (one["build"], factor_without(one)):
        design = computed(one, build)
        # The aim of docs/validation.md.
        known_kg = one["published"]["total_mass_kg"]
        assert float(design.total_mass_kg) == pytest.approx(known_kg, rel=0.25)


def test_atlantiksolar_is_found_with_its_own_parts():
    one = team_designs()["atlantiksolar"]
    design = computed(one, one["build"], one["own_parts"])
    assert design.total_mass_kg == pytest.approx(one["published"]["total_mass_kg"], rel=0.25)
    assert design.variables.wingspan_m == pytest.approx(one["published"]["wingspan_m"], rel=0.15)


def test_a_class_of_two_without_one_is_the_other():
    apart = [factor_without(team_designs()[key]) for key in ("solong", "seaway-mini")]
    # Two digits, as the classes have.
    mean = (apart[0] * apart[1]) ** 0.5
    assert build_qualities()["ordinary"].factor == pytest.approx(mean, abs=0.005)
