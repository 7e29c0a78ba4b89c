"""Systematic errors of the solar power models against table 3 of Oettershagen's report."""

import pytest

from solar.names import CORRECTION_NAMES, MODELS
from solar.systematic_errors import correction

FLOWN_W = 99.61


@pytest.mark.parametrize(
    ("model", "power_w", "average", "rms_w", "rms"),
    [
        ("CDM", 117.35, 0.1781, 19.95, 0.2003),
        ("CAM", 104.89, 0.0531, 6.99, 0.0702),
        ("VM", 97.65, -0.0196, 3.94, 0.0396),
        ("FM", 97.87, -0.0175, 4.17, 0.0419),
    ],
)
def test_errors_are_those_of_table_3(model, power_w, average, rms_w, rms):
    reported, none = MODELS[model], correction(model, "none")
    assert (reported.average, reported.rms) == (average, rms)
    # Powers are printed to 0.01 W of 100 W, errors to 0.01 %: together 0.02 %.
    assert average == pytest.approx(power_w / FLOWN_W - 1.0, abs=2e-4)
    assert rms == pytest.approx(rms_w / FLOWN_W, abs=2e-4)
    assert power_w * correction(model, "report").factor == pytest.approx(FLOWN_W, rel=2e-4)
    # No correction changes nothing but states the band.
    assert (none.factor, none.rms_relative) == (1.0, rms)
    assert [correction(model, name).name for name in CORRECTION_NAMES] == list(CORRECTION_NAMES)


def test_unknown_names_are_refused():
    for wrong in ("XM", "cam", ""):
        for names, told in (((wrong, "none"), "solar power model"), (("CAM", wrong), "correction")):
            with pytest.raises(ValueError, match=f"unknown {told}"):
                correction(*names)
