"""Light of a sun below the horizontal plane, beside published numbers and what the page says."""

import numpy as np
import pytest

from benchmarks.validation.horizon_dip import (
    beam_below,
    dip_rad,
    left_out,
    rayleigh_depth,
    spectrum,
    transmitted,
)


def test_dip_and_path_are_those_of_the_almanac_and_of_the_slant_column() -> None:
    # Geometric dip of the nautical almanac: 1.93 minutes of arc times the root of the height in m.
    assert np.degrees(dip_rad(20e3)) * 60.0 == pytest.approx(1.93 * np.sqrt(20e3), rel=5e-3)
    # Bodhaine et al. (1999), J. Atmos. Oceanic Technol. 16, table 3: 0.0973 at 0.55 um.
    assert rayleigh_depth()[25] == pytest.approx(0.0973, rel=5e-3)
    # A level ray from 20 km: Chapman's (pi R / 2 H)^0.5 times the pressure there; no ozone in it.
    air = (np.pi * 6391e3 / 2.0 / 6341.6) ** 0.5 * 0.0546
    red = transmitted(20e3, 0.0)[[0, -1]]  # where ozone's band is not
    assert np.log(red) == pytest.approx(-air * rayleigh_depth()[[0, -1]], rel=0.03)


def test_the_beam_sinks_with_the_sun_and_ends_with_the_earth() -> None:
    elevation = np.radians([-5.0, -4.0, -2.0, -0.1, 0.1])
    beam = beam_below(20e3, elevation)
    assert beam[0] == 0.0
    assert beam[-1] == 0.0
    assert np.all(np.diff(beam[:4]) > 0.0)
    assert beam[3] < np.trapezoid(spectrum(), np.linspace(0.3, 1.1, 81))


def test_what_is_left_out_is_less_than_the_page_says() -> None:
    for latitude_deg, declination_deg in ((0.0, 0.0), (47.0, 23.44), (47.0, 0.0)):
        minutes, share = left_out(20e3, latitude_deg, declination_deg)
        assert 15.0 < minutes < 40.0
        assert share["horizontal"] < 0.05
        assert share["banked 5 deg"] < 0.15
        assert 2.0 < share["vertical"] < 4.0
