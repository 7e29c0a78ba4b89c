"""Systematic errors of the solar power models against table 3 of Oettershagen's report."""

from __future__ import annotations

import pytest

from solar.systematic_errors import CORRECTION_NAMES, MODEL_NAMES, REPORTED_ERRORS, correction

FLOWN_W = 99.61

TABLE_3 = pytest.mark.parametrize(
    ("model", "power_w", "average", "rms_w", "rms"),
    [
        ("CDM", 117.35, 0.1781, 19.95, 0.2003),
        ("CAM", 104.89, 0.0531, 6.99, 0.0702),
        ("VM", 97.65, -0.0196, 3.94, 0.0396),
        ("FM", 97.87, -0.0175, 4.17, 0.0419),
    ],
)


@TABLE_3
def test_errors_are_those_of_table_3(
    model: str, power_w: float, average: float, rms_w: float, rms: float
) -> None:
    assert REPORTED_ERRORS[model].average == average
    assert REPORTED_ERRORS[model].rms == rms


@TABLE_3
def test_relative_errors_follow_from_the_powers_of_the_table(
    model: str, power_w: float, average: float, rms_w: float, rms: float
) -> None:
    # Powers are printed to 0.01 W of 100 W, errors to 0.01 %: together 0.02 %.
    assert REPORTED_ERRORS[model].average == pytest.approx(power_w / FLOWN_W - 1.0, abs=2e-4)
    assert REPORTED_ERRORS[model].rms == pytest.approx(rms_w / FLOWN_W, abs=2e-4)


@pytest.mark.parametrize(("model", "power_w"), [("CDM", 117.35), ("CAM", 104.89)])
def test_corrected_power_is_the_flown_one(model: str, power_w: float) -> None:
    # The printed digits of error and power, 0.02 %.
    assert power_w * correction(model, "report").factor == pytest.approx(FLOWN_W, rel=2e-4)


@pytest.mark.parametrize("model", MODEL_NAMES)
def test_no_correction_changes_nothing_but_states_the_band(model: str) -> None:
    none = correction(model, "none")
    assert none.factor == 1.0
    assert none.rms_relative == REPORTED_ERRORS[model].rms > 0.0


@pytest.mark.parametrize("model", MODEL_NAMES)
@pytest.mark.parametrize("name", CORRECTION_NAMES)
def test_correction_carries_its_name(model: str, name: str) -> None:
    assert correction(model, name).name == name


def test_analysis_model_is_better_than_the_design_model() -> None:
    assert correction("CDM", "report").factor < correction("CAM", "report").factor < 1.0
    assert correction("CAM", "report").rms_relative < correction("CDM", "report").rms_relative


@pytest.mark.parametrize("model", ["XM", "cam", ""])
def test_unknown_model_is_refused(model: str) -> None:
    with pytest.raises(ValueError, match="unknown solar power model"):
        correction(model, "none")


@pytest.mark.parametrize("name", ["Report", "flight", ""])
def test_unknown_correction_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="unknown correction"):
        correction("CAM", name)
