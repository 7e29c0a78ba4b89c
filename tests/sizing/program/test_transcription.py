"""Programs are built once for aircraft of a kind."""

from builders import DESIGN, mission

from sizing.parameters import catalogue, parameter_value, with_parameter
from sizing.program.transcription import Form, build_program, numbers_taken_out


def test_aircraft_that_differ_in_numbers_of_their_technology_share_a_program():
    known = {
        key: parameter_value(DESIGN, None, key)
        for key, row in catalogue().items()
        if row.kind == "technology"
    }
    numbers = {key: value for key, value in known.items() if value is not None}
    # Gust factors depend on it as a table does.
    of_a_kind = numbers.keys() - set(numbers_taken_out(DESIGN))
    assert of_a_kind <= {"airframe.structure.cruise_gust_m_per_s"}
    program = build_program(DESIGN, Form(1))
    for key in numbers.keys() - of_a_kind:
        other, _ = with_parameter(DESIGN, mission(), key, 1.01 * numbers[key])
        assert build_program(other, Form(1)) is program, key
