"""The command ``solar-uav fit``, and the file that it writes."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from builders import AS2
from click.testing import CliRunner, Result

from missions.files.yaml import read_yaml
from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.sunlight import SolarModel
from sizing.uncertainty.inputs import uncertain_inputs
from studies.cli.__main__ import cli
from studies.fitting.estimation import Fitted
from studies.fitting.files import scatter_of
from studies.fitting.parameters import PARAMETERS
from studies.fitting.synthetic import Errors, Flight, fly

DOCS = Path(__file__).resolve().parents[3] / "docs"


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("flight") / "flight.csv"
    flight = Flight(seed=5, duration_h=30.0, step_s=60.0, errors=Errors(haze=0.01))
    fly(AS2, load_mission("rafz-28h"), flight).table.to_csv(path, index=False)
    return path


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["fit", *map(str, arguments)])


def keys(record: Any) -> Iterator[str]:
    if isinstance(record, list):
        for entry in record:
            yield from keys(entry)
    elif isinstance(record, dict):
        for key, value in record.items():
            yield key
            yield from keys(value)


@pytest.mark.slow
def test_the_file_that_is_written_says_where_its_numbers_come_from(
    log: Path, tmp_path: Path
) -> None:
    made, folder = tmp_path / "mine.yaml", tmp_path / "out"
    done = run(
        "atlantiksolar-as2", log, "--predict", log, "--write", made, "--out", folder, "--json"
    )
    assert done.exit_code == 0, done.output
    record = json.loads(done.output)
    # A full battery is no reason to check nothing.
    assert any("charging that may be limited" in note for note in record["notes"])
    assert not any("not checked" in note for note in record["notes"])
    craft = load_aircraft(made)
    assert craft.name == "atlantiksolar-as2-fitted"
    assert craft.provenance is not None
    assert craft.provenance.log == str(log)
    assert craft.provenance.log_sha256 == hashlib.sha256(log.read_bytes()).hexdigest()
    assert [one.key for one in craft.provenance.fitted] == [one["key"] for one in record["fitted"]]
    for one, told in zip(craft.provenance.fitted, record["fitted"], strict=True):
        assert one.value == PARAMETERS[told["name"]].value(craft)
        assert one.value == pytest.approx(told["value"], abs=0.01 * told["standard_error"])
        assert (one.low, one.high) == pytest.approx((told["low"], told["high"]), rel=1e-2)
    comments = made.read_text().partition("name:")[0]
    assert all(f"#   {one.key}: " in comments for one in craft.provenance.fitted)
    # What was fitted scatters by its standard errors.
    scattering = uncertain_inputs(craft, load_mission("rafz-july"), SolarModel())
    assert {one.key for one in scattering.inputs} > {o.key for o in craft.provenance.fitted}
    assert read_yaml(folder / "aircraft.yaml").data == read_yaml(made).data
    assert (folder / "fit.png").read_bytes().startswith(b"\x89PNG")
    text = (DOCS / "fit.md").read_text(encoding="utf-8")
    documented = {name.rstrip("[]") for name in re.findall(r"`(\w+(?:\[\])?)`", text)}
    assert set(keys(record)) - {"mission_is_default"} <= documented


@pytest.mark.long
def test_where_nothing_can_be_fitted_no_residual_is_independent_and_nothing_is_written(
    log: Path, tmp_path: Path
) -> None:
    by_day, made = tmp_path / "day.csv", tmp_path / "mine.yaml"
    by_day.write_text("\n".join(log.read_text().splitlines()[:400]))
    fit = ("atlantiksolar-as2", by_day, "--fit", "discharge_efficiency")
    done = run(*fit, "--json", "--write", made)
    assert done.exit_code == 1, done.output
    assert "nothing is written" in done.stderr
    assert not made.exists()
    record = json.loads(done.stdout)
    assert [one["name"] for one in record["held"]] == ["discharge_efficiency"]
    assert [one["independent"] for one in record["channels"]] == [None]
    assert not any("clear sky" in note for note in record["notes"])  # of modules alone


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("flight.csv", "atlantiksolar-as2"), "the aircraft comes first: fit"),
        (("atlantiksolar-as2", "LOG", "--fit", "span"), "'span' cannot be fitted (allowed: "),
        (("atlantiksolar-design", "LOG", "--fit", "level_power"), "fit profile_drag"),
        (("atlantiksolar-as2", "LOG", "--light-sigma", "0.9"), "--light-sigma"),
        (("atlantiksolar-as2", "LOG", "--exclude", "11:20"), "must be times like 11:20-11:45"),
        (("atlantiksolar-as2", "LOG", "--start", "11:20"), "must be a time with its zone like"),
        (("atlantiksolar-as2", "LOG", "--dpi", "90"), "--dpi is of the figure"),
    ],
)
def test_mistakes_are_told(log: Path, arguments: tuple[str, ...], message: str) -> None:
    done = run(*(str(log) if word == "LOG" else word for word in arguments))
    assert done.exit_code == 2
    assert message in " ".join(done.output.split())


def test_a_log_is_not_overwritten(tmp_path: Path) -> None:
    log = tmp_path / "flight.csv"
    log.write_text("a flight that is not flown again")
    done = run("atlantiksolar-as2", log, "--write", log)
    assert done.exit_code == 2
    assert "is read by this command; name another file" in " ".join(done.output.split())
    assert log.read_text() == "a flight that is not flown again"


def test_scatter_stays_within_what_is_possible() -> None:
    rise, mppt = PARAMETERS["temperature_rise"], PARAMETERS["mppt_efficiency"]
    assert scatter_of(Fitted(rise, 12.0, 12.0, 1.0, 10.0, 14.0)) == {"sigma": 1.0}
    assert scatter_of(Fitted(rise, 12.0, 6.0, 3.0, 0.0, 12.0))["distribution"] == "lognormal"
    ends = scatter_of(Fitted(mppt, 0.95, 0.97, 0.02, 0.93, 1.01))
    assert ends == {"distribution": "uniform", "low": 0.93, "high": 1.0}
