"""Technology of the solar modules: efficiencies, tables of the user, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydantic import ValidationError

from solar.modules import IncidenceTable, SolarCell


def test_temperature_efficiency_of_the_verification_flight() -> None:
    # Oettershagen's report, late-morning flight: 96 % at 37 C, rounded to the per cent.
    assert SolarCell().temperature_efficiency(37.0) == pytest.approx(0.96, abs=0.005)


def test_temperature_efficiency_is_one_at_standard_test_conditions() -> None:
    assert SolarCell().temperature_efficiency(25.0) == 1.0


@given(st.floats(0.0, 0.01), st.floats(-100.0, 200.0))
def test_temperature_efficiency_falls_linearly_and_never_below_zero(
    coefficient: float, temperature: float
) -> None:
    cell = SolarCell(temperature_coefficient_per_k=coefficient)
    here = float(cell.temperature_efficiency(temperature))
    hotter = float(cell.temperature_efficiency(temperature + 10.0))
    assert here >= hotter >= 0.0
    assume(hotter > 0.0)
    # Rounding only: values near one, subtracted.
    assert here - hotter == pytest.approx(10.0 * coefficient, abs=1e-12)


def test_temperature_efficiency_ends_at_zero() -> None:
    # 0.3 %/K uses the efficiency up 333 K above 25 C.
    assert SolarCell().temperature_efficiency([358.0, 359.0, 1000.0])[1:] == pytest.approx(0.0)


@given(st.floats(-1.0, 1.0))
def test_incidence_efficiency_is_a_fraction_and_zero_from_behind(cosine: float) -> None:
    value = SolarCell().incidence_efficiency(cosine)
    assert 0.0 <= value <= 1.0
    if cosine <= 0.0:
        assert value == pytest.approx(0.0, abs=1e-12)  # rounding at 90 degrees


def test_incidence_efficiency_takes_the_angle_of_its_cosine() -> None:
    aoi_deg = np.array([0.0, 15.0, 45.0, 70.0, 87.0])
    published = np.array([1.0, 0.997, 0.97, 0.76, 0.34])
    efficiency = SolarCell().incidence_efficiency(np.cos(np.radians(aoi_deg)))
    assert efficiency == pytest.approx(published)


def test_incidence_efficiency_bears_a_cosine_just_above_one() -> None:
    # Products of unit vectors exceed one by rounding.
    assert SolarCell().incidence_efficiency(1.0 + 1e-12) == 1.0


def test_incidence_efficiency_follows_the_table_of_the_user() -> None:
    table = IncidenceTable(aoi_deg=(0.0, 60.0, 90.0), relative_efficiency=(1.0, 0.5, 0.0))
    cell = SolarCell(incidence=table)
    assert cell.incidence_efficiency(0.5) == pytest.approx(0.5)
    assert SolarCell().incidence_efficiency(0.5) == pytest.approx(0.915)


def test_diffuse_efficiency_is_the_mean_incidence_efficiency_of_the_sky() -> None:
    cell = SolarCell()
    aoi = np.linspace(0.0, np.pi / 2.0, 2001)
    # Mean over the area of the sky's half sphere, as Oettershagen's report defines it.
    mean = np.trapezoid(cell.incidence_efficiency(np.cos(aoi)) * np.sin(aoi), aoi)
    # Half of that area is beyond 60 degrees, where the eleven points read off a figure follow the
    # steep end of the curve only to some per cent.
    assert mean == pytest.approx(cell.diffuse_efficiency, abs=0.04)


@pytest.mark.parametrize(
    "table",
    [
        {"aoi_deg": (0.0, 90.0), "relative_efficiency": (1.0,)},
        {"aoi_deg": (0.0, 45.0, 90.0), "relative_efficiency": (1.0, 0.0)},
        {"aoi_deg": (90.0, 0.0), "relative_efficiency": (0.0, 1.0)},
        {"aoi_deg": (0.0, 91.0), "relative_efficiency": (1.0, 0.0)},
        {"aoi_deg": (-1.0, 90.0), "relative_efficiency": (1.0, 0.0)},
        {"aoi_deg": (0.0, 90.0), "relative_efficiency": (100.0, 0.0)},  # per cent
        {"aoi_deg": (0.0, 90.0), "relative_efficiency": (1.0, float("nan"))},
        {"aoi_rad": (0.0, 1.5), "relative_efficiency": (1.0, 0.0)},
    ],
)
def test_bad_incidence_tables_are_refused(table: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        IncidenceTable(**table)


@pytest.mark.parametrize(
    "change",
    [
        {"efficiency_stc": 23.7},  # per cent
        {"efficiency_stc": 0.0},
        {"mppt_efficiency": 1.01},
        {"camber_efficiency": -0.1},
        {"diffuse_efficiency": float("nan")},
        {"temperature_coefficient_per_k": -0.003},
        {"efficiency_stc": "0.2"},
        {"efficiency_stc": True},
        {"efficiency": 0.2},
    ],
)
def test_bad_cells_are_refused(change: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match=next(iter(change))):
        SolarCell(**change)


def test_cells_do_not_change() -> None:
    cell = SolarCell()
    with pytest.raises(ValidationError, match="frozen"):
        cell.efficiency_stc = 0.5  # type: ignore[misc]
