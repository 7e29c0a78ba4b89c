"""Measured aircraft made parametric."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import sizing
import studies
from missions.files.errors import InputError
from missions.files.shipped import find_document, shipped_text
from missions.library import load_mission
from sizing.performance import performance
from studies.cli.__main__ import cli
from studies.fitting.calibration import calibrate


def run(*words: str) -> Result:
    return CliRunner().invoke(cli, ["calibrate", *words])


def test_the_parametric_aircraft_flies_like_the_measured_one_and_can_be_sized(
    tmp_path: Path,
) -> None:
    made = tmp_path / "made.yaml"
    done = run("atlantiksolar-as2", "atlantiksolar-design", "--write", str(made))
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


def test_python_and_json_tell_the_same() -> None:
    words = ("sky-sailor-2008", "sky-sailor")
    found = studies.calibrate_aircraft(*words)
    record = json.loads(run(*words, "--json").stdout)
    assert record == found.to_dict()
    assert set(record) == {"aircraft", "measured", "technology", "factors", "agreement"}
    keys = {"key", "before", "after", "minimum", "maximum", "source"}
    assert [set(one) for one in record["factors"]] == [keys] * 2
    for one in record["agreement"]:
        assert set(one) == {"quantity", "unit", "measured", "parametric"}
        assert one["parametric"] == pytest.approx(one["measured"], rel=1e-6)
    assert found.aircraft.name == "sky-sailor-2008-parametric"


def test_masses_of_the_technology_can_be_changed() -> None:
    lighter = {"airframe.avionics_mass_kg": 0.2, "airframe.other_mass_kg": 0.1}
    found = studies.calibrate_aircraft("sky-sailor-2008", "atlantiksolar-design", lighter)
    assert found.aircraft.airframe.kind == "parametric"
    assert found.aircraft.airframe.avionics_mass_kg == 0.2
    told = [word for key, value in lighter.items() for word in ("--set", f"{key}={value}")]
    assert run("sky-sailor-2008", "atlantiksolar-design", *told).exit_code == 0


def test_the_measured_aircraft_is_not_overwritten(tmp_path: Path) -> None:
    measured = tmp_path / "measured.yaml"
    text = shipped_text("atlantiksolar-as2")
    measured.write_text(text)
    done = run(str(measured), "atlantiksolar-design", "--write", str(measured))
    assert done.exit_code == 2
    assert measured.read_text() == text


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("atlantiksolar-design", "atlantiksolar-as2"), "airframe.kind: must be measured"),
        (("atlantiksolar-as2", "sky-sailor-2008"), "airframe.kind: must be parametric"),
        (("atlantiksolar-as2", "sky-sailer"), "did you mean"),
        (
            ("atlantiksolar-as2", "sky-sailor", "--set", "airframe.avionics_mas_kg=1"),
            "did you mean 'avionics_mass_kg'",
        ),
    ],
)
def test_wrong_aircraft_are_told(words: tuple[str, ...], message: str, tmp_path: Path) -> None:
    made = tmp_path / "made.yaml"
    done = run(*words, "--write", str(made))
    assert message in str(done.exception or done.output)
    assert done.exit_code != 0
    assert not made.exists()
