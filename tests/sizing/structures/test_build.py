"""Quality of building: its factors, what it multiplies, and how it goes with the calibration."""

from __future__ import annotations

import csv
from importlib import resources
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from missions.files.errors import InputError
from missions.files.shipped import shipped_names
from missions.library import load_mission
from missions.uncertainty import LogNormal
from sizing.day.light import UNCORRECTED_CAM
from sizing.library import load_aircraft
from sizing.own_models import register_structure
from sizing.results.sizing import size
from sizing.structures.build import build_qualities
from sizing.structures.loads import StructureInputs
from sizing.structures.models import Structure
from sizing.uncertainty.inputs import uncertain_inputs

INPUTS = StructureInputs(5.65, 18.5, 6.92, 3.7, 8.5, 1.1)
BUILD = "airframe.structure.build"
JULY = load_mission("rafz-july")

register_structure("of a test of build", lambda of: 0.2 * of.wingspan_m)


def structure(**keys: Any) -> Any:
    return TypeAdapter(Structure).validate_python(keys)


def test_factor_is_the_mean_of_a_class_and_scatter_that_of_its_next_aircraft() -> None:
    text = (resources.files("sizing") / "data" / "built-structures.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    found = build_qualities()
    logs = {
        name: np.log([float(row["ratio"]) for row in rows if row["quality"] == name])
        for name in found
    }
    squares = sum(len(some) * np.var(some) for some in logs.values())
    for name, quality in found.items():
        # Two digits, as the ratios have.
        assert quality.factor == pytest.approx(np.exp(np.mean(logs[name])), abs=0.005)
        n = len(logs[name])
        assert quality.log_sigma**2 == pytest.approx(squares / (len(rows) - 3) * (1 + 1 / n))
        assert len(quality.aircraft) == n


@pytest.mark.parametrize(
    "keys",
    [
        {"model": "rib_wing", "calibration": 1.188},
        {"model": "spar", "calibration": 1.109},
        {"model": "power_law"},
        {"model": "power_law_all"},
        {"model": "own", "name": "of a test of build"},
    ],
    ids=lambda keys: keys["model"],
)
def test_build_multiplies_every_model_and_has_the_calibration_of_atlantiksolar(
    keys: dict[str, Any],
) -> None:
    plain = structure(**keys).mass_kg(INPUTS)
    without = {key: value for key, value in keys.items() if key != "calibration"}
    for build, factor in (("record", 1.0), (2.5, 2.5), ("careful", 1.85), (None, None)):
        if factor is not None:
            assert structure(**without, build=build).mass_kg(INPUTS) == pytest.approx(
                factor * plain
            )
        expected = plain if factor is None else factor * plain
        assert structure(**keys, build=build).mass_kg(INPUTS) == pytest.approx(expected)


@pytest.mark.parametrize("build", ["carefull", 0, -1.0, True, [1]])
def test_another_build_is_refused(build: Any) -> None:
    with pytest.raises(InputError, match="record, careful, ordinary or a number greater than 0"):
        load_aircraft("atlantiksolar-design", {BUILD: build})


def test_class_number_and_calibration_are_one_formula_in_every_study() -> None:
    """Optimiser, simulator and sensitivities take 1.85 in each of the three ways."""
    studies = [
        size(load_aircraft("atlantiksolar-design", changes), JULY, with_sensitivities=True)
        for changes in (
            {BUILD: "careful"},
            {BUILD: 1.85},
            {BUILD: None, "airframe.structure.calibration": 1.85 * 1.188},
        )
    ]
    masses = [float(one.design.total_mass_kg) for one in studies if one.design]
    assert masses == pytest.approx([masses[0]] * 3, rel=1e-6)  # tolerance of the solver
    rows = [{s.parameter: s.per_percent for s in one.sensitivities or []} for one in studies]
    worth = [rows[0][BUILD], rows[1][BUILD], rows[2]["airframe.structure.calibration"]]
    assert worth == pytest.approx([worth[0]] * 3, rel=1e-3)
    assert "airframe.structure.calibration" not in rows[0]


def test_scatter_of_a_class_is_an_input_where_the_file_has_no_other() -> None:
    def keys(name: str, changes: dict[str, Any]) -> dict[str, Any]:
        found = uncertain_inputs(load_aircraft(name, changes), JULY, UNCORRECTED_CAM)
        return {one.key: one for one in found.inputs}

    of_class = keys("stratosphere-design", {BUILD: "careful"})[BUILD]
    assert of_class.nominal == 1.85
    assert isinstance(of_class.distribution, LogNormal)
    sigma = build_qualities()["careful"].log_sigma
    # The value that is above 84.13 % of all draws lies one sigma above the median.
    assert float(of_class.values(np.array(0.841345))) == pytest.approx(1.85 * np.exp(sigma))
    assert BUILD not in keys("stratosphere-design", {BUILD: 1.85})
    # This file says how its calibration scatters.
    assert BUILD not in keys("atlantiksolar-design", {})


def test_shipped_designs_say_how_they_are_built() -> None:
    for name in shipped_names("aircraft"):
        airframe = load_aircraft(name).airframe
        if airframe.kind == "parametric":
            assert airframe.structure.build == "record", name


def test_init_asks_for_it_first_and_writes_careful() -> None:
    text = (resources.files("studies") / "templates" / "aircraft.yaml").read_text(encoding="utf-8")
    lines = text.splitlines()
    assert "airframe.structure.build" in lines[0]
    told = dict(line.split()[1:3] for line in lines[1:4])
    assert told == {name: f"{one.factor:.2f}" for name, one in build_qualities().items()}
    assert "    build: careful " in text
