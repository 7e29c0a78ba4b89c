"""Errors of the models without surfaces over latitudes and seasons."""

from benchmarks.validation.loiter_correction import transferred_errors
from solar.systematic_errors import REPORTED_ERRORS
from studies.models import report_reproduction as study


def test_simple_models_err_less_over_a_tropical_day_than_over_the_reports_morning():
    errors = transferred_errors(
        *study.reference(), latitudes_deg=(0.0,), days=(80,), winds_m_per_s=(2.0,)
    )
    by_model = {e.model: e.error for e in errors}
    assert by_model["CDM"] < 0.5 * REPORTED_ERRORS["CDM"].average
    assert 0.0 < by_model["CAM"] < REPORTED_ERRORS["CAM"].average


def test_errors_leave_polar_night_out():
    errors = transferred_errors(
        *study.reference(), latitudes_deg=(80.0,), days=(355,), winds_m_per_s=(0.0,)
    )
    assert errors == []
