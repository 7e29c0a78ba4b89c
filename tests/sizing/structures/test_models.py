"""Structural masses: published numbers, sums by hand and directions."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sizing.structures.loads import StructureInputs, root_bending_moment_nm
from sizing.structures.models import AllPowerLawStructure, PowerLawStructure, SparStructure

SPAR = SparStructure()

spans = st.floats(1.0, 30.0)
aspects = st.floats(6.0, 35.0)


def wing(b, ar, m=1.0, load=0.0):
    """Wing in a flight that the simpler models of the structure ignore."""
    return StructureInputs(b, ar, m, load, airspeed_m_per_s=9.0, density_kg_per_m3=1.1)


def spar_mass(b, ar, m, load=0.0):
    return SPAR.mass_kg(wing(b, ar, m, load))


@pytest.mark.parametrize(
    ("law", "newton"),
    # As published, in wing area and aspect ratio.
    [
        (PowerLawStructure(), lambda s, ar: 0.44 * s**1.55 * ar**1.30),
        (AllPowerLawStructure(model="power_law_all"), lambda s, ar: 5.58 * s**1.59 * ar**0.71),
    ],
    ids=["best 5 %", "all 415"],
)
@given(span=spans, aspect=aspects)
def test_power_laws_are_those_published(law, newton, span, aspect):
    # The same law in other variables: rounding.
    assert law.mass_kg(wing(span, aspect)) * 9.81 == pytest.approx(
        newton(span**2 / aspect, aspect), rel=1e-9
    )


def test_spar_structure_adds_up_by_hand():
    b, ar, m = 5.65, 18.5, 6.92
    chord = b / ar
    moment = root_bending_moment_nm(b, m, 3.7, 0.25)
    shell = 0.45 * b * chord + 0.35 * (0.35 + 0.045) / 4.0 * b * chord
    boom, web = 0.12 * 4.0 * chord, 0.03 * b
    cap_area = 1.5 * moment / (0.9 * 0.125 * chord) / 368e6
    caps = 2.0 * 0.45 * cap_area * b * 1600.0
    # The same sum: rounding.
    assert spar_mass(b, ar, m, 3.7) == pytest.approx(shell + boom + web + caps, rel=1e-12)
    doubled = SparStructure(calibration=2.0).mass_kg(wing(b, ar, m, 3.7))
    assert doubled == pytest.approx(2.0 * spar_mass(b, ar, m, 3.7), rel=1e-12)
