from operator import attrgetter

import pytest

from missions.files.errors import InputError
from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.parameters import catalogue
from sizing.results.analysis import analyse

JULY = load_mission("rafz-july")


@pytest.mark.parametrize(
    ("key", "value", "noted"),
    [
        ("battery.specific_energy_wh_per_kg", 2500, True),
        ("battery.specific_energy_wh_per_kg", 1000, False),
        ("modules.efficiency_stc", 0.6, True),
        ("airframe.structure.calibration", 1e-9, True),
        ("modules.mass_kg_per_m2", 1e3, True),
        ("modules.temperature_coefficient_per_k", 1000, True),
    ],
)
def test_technology_beyond_experience_is_noted(key, value, noted):
    aircraft = load_aircraft("atlantiksolar-design", [f"{key}={value}"])
    notes = [note for note in analyse(aircraft, JULY).extrapolations if note.model == "experience"]
    assert [note.quantity for note in notes] == ([key] if noted else [])
    if noted:
        row = catalogue()[key]
        assert (notes[0].minimum, notes[0].maximum) == (row.minimum, row.maximum)
        assert "outside the range of experience" in notes[0].text


@pytest.mark.parametrize(
    ("key", "highest"),
    [
        # Lithium and fluorine, 587.7 kJ/mol and 25.94 g/mol, are below the limit of all elements.
        ("battery.specific_energy_wh_per_kg", 6443.0),
        ("modules.efficiency_stc", 0.868),
        ("airframe.aerodynamics.maximum_lift_coefficient", 12.57),
        ("airframe.propulsion.motor_efficiency", 1.0),
        ("battery.charge_efficiency", 1.0),
    ],
)
def test_what_nature_does_not_allow_is_refused(key, highest):
    assert 587.7e3 / 0.02594 / 3600.0 < 6443.0
    allowed = load_aircraft("atlantiksolar-design", [f"{key}={highest}"])
    section, name = key.rsplit(".", 1)
    assert getattr(attrgetter(section)(allowed), name) == highest
    with pytest.raises(InputError, match=rf"{key}: must be at most {highest:g} \(got"):
        load_aircraft("atlantiksolar-design", [f"{key}={1.01 * highest}"])
