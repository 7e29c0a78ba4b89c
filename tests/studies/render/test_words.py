"""Requirements and bounds in words, each with the key that changes it."""

import pytest

import sizing
from sizing.parameters import catalogue
from sizing.program.transcription import Form, build_program
from studies.render.words import constraint_words, parameter_words


@pytest.fixture(scope="module")
def aircraft():
    plane = sizing.load_aircraft("atlantiksolar-design")
    space = plane.design_space.model_copy(update={"minimum_stall_margin": 1.2})
    return plane.model_copy(update={"design_space": space})


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (
            "excess_time (45° N, 15 Aug)",
            "required excess time at 45° N, 15 Aug (mission.required_excess_time_h)",
        ),
        ("battery_capacity (45° N, 15 Aug)", "battery capacity for the night at 45° N, 15 Aug"),
        ("module_coverage", "modules over wing area (airframe.maximum_module_coverage)"),
        ("wingspan_m at its maximum", "wingspan at its maximum (design_space.wingspan_m.maximum)"),
        ("wingspan_m at its bound", "wingspan at its bound (design_space.wingspan_m)"),
        (
            "total_mass_kg at its maximum",
            "total mass at its maximum (design_space.maximum_total_mass_kg)",
        ),
        (
            "stall_speed_m_per_s_maximum",
            "stall speed at its maximum (design_space.limits.stall_speed_m_per_s.maximum)",
        ),
    ],
)
def test_names_of_the_program_in_words(name, words, aircraft):
    assert str(constraint_words(name, aircraft)) == words


def test_every_requirement_of_the_program_has_words(aircraft):
    for row in build_program(aircraft, Form(1)).constraints:
        words = constraint_words(row.name, aircraft)
        assert "_" not in words.label


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("design_space.limits.stall_speed_m_per_s.maximum", "largest stall speed"),
        ("design_space.minimum_stall_margin", "least airspeed over stall speed"),
        ("design_space.maximum_wing_loading_kg_per_m2", "largest wing loading"),
        ("design_space.wingspan_m.maximum", "largest wingspan"),
        ("nobody.knows_it", "nobody.knows_it"),
    ],
)
def test_parameters_in_words(key, words):
    assert parameter_words(key) == words


def test_parameters_of_the_catalogue_have_labels_of_their_own():
    assert all(parameter_words(key) == one.label for key, one in catalogue().items())
