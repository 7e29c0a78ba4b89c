"""Measured aircraft made parametric."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

import sizing
from missions.files.errors import InputError
from missions.files.shipped import find_document
from missions.library import load_mission
from sizing.performance import performance
from studies.cli.__main__ import cli
from studies.fitting.calibration import calibrate


def test_the_parametric_aircraft_flies_like_the_measured_one_and_can_be_sized(
    tmp_path: Path,
) -> None:
    made = tmp_path / "made.yaml"
    words = ["calibrate", "atlantiksolar-as2", "atlantiksolar-design", "--write", str(made)]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0, done.output
    craft, mission = sizing.load_aircraft(made), load_mission("rafz-july")
    built = sizing.load_aircraft("atlantiksolar-as2")
    hours = [float(performance(one, mission).cycle.excess_time_h[0]) for one in (built, craft)]
    # The charge is the same; drag scales with the Reynolds number as well: a per cent or two.
    assert hours[1] == pytest.approx(hours[0], abs=0.2)
    assert sizing.size(craft, mission, "min_mass", required_excess_time_h=4.0).result.design


def test_a_factor_out_of_range_is_named() -> None:
    measured, technology = (
        find_document("aircraft", name) for name in ("sky-sailor-2008", "atlantiksolar-design")
    )
    with pytest.raises(InputError, match=r"structure\.calibration: would have to be -1\.0"):
        calibrate(measured, technology)
