"""The same requirement by every class of building."""

import pytest

from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.results.sizing import size
from sizing.user_models import register_structure

BUILD = "airframe.structure.build"
JULY = load_mission("rafz-july")
register_structure("of a test of rows", lambda of: 0.2 * of.wingspan_m)


def study(changes=None, **options):
    aircraft = load_aircraft("atlantiksolar-design", changes or {})
    return size(aircraft, JULY, with_builds=True, **options)


@pytest.mark.parametrize("objective", ["min_mass", "max_excess_time"])
def test_rows_are_the_sizings_of_each_class(objective):
    found = study(objective=objective)
    assert [(one.build, one.of_file) for one in found.builds] == [
        ("record", True),
        ("careful", False),
        ("ordinary", False),
    ]
    for one in found.builds:
        alone = size(load_aircraft("atlantiksolar-design", {BUILD: one.build}), JULY, objective)
        # Both within the tolerance of an optimum.
        assert one.objective_value == pytest.approx(alone.result.objective_value, rel=0.005)


@pytest.mark.long
def test_rows_say_where_there_is_no_design_and_stand_below_a_failure_too():
    found = study({BUILD: "ordinary"}, required_excess_time_h=8.0)
    assert not found.feasible
    assert [one.design is not None for one in found.builds] == [True, True, False]
    text = str(found)
    assert text.splitlines()[-1].split() == ["ordinary", "(this", "file)", "3.61", "no", "design"]
    assert text.index("feasible with one of these") < text.index("build quality")


def test_a_calibration_without_build_may_hold_its_own_aircraft():
    own = study({BUILD: None, "airframe.structure.calibration": 2.0})
    shipped = study()
    for one, other in zip(own.builds, shipped.builds, strict=True):
        assert not one.of_file
        assert one.objective_value == pytest.approx(other.objective_value, rel=0.005)
