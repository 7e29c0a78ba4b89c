"""Quality of building: its factors, what it multiplies, and how it goes with the calibration."""

import csv
from importlib import resources

import numpy as np
import pytest
from pydantic import TypeAdapter

from missions.library import load_mission
from missions.uncertainty import LogNormal
from sizing.day.light import UNCORRECTED_CAM
from sizing.library import load_aircraft
from sizing.structures.build import build_qualities
from sizing.structures.loads import StructureInputs
from sizing.structures.models import Structure
from sizing.uncertainty.inputs import uncertain_inputs
from sizing.user_models import register_structure

INPUTS = StructureInputs(5.65, 18.5, 6.92, 3.7, 8.5, 1.1)
BUILD = "airframe.structure.build"
JULY = load_mission("rafz-july")

register_structure("of a test of build", lambda of: 0.2 * of.wingspan_m)


def structure(**keys):
    return TypeAdapter(Structure).validate_python(keys)


def test_factor_is_the_mean_of_a_class_and_scatter_that_of_its_next_aircraft():
    text = (resources.files("sizing") / "data" / "built-structures.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    qualities = build_qualities()
    logs = {
        name: np.log([float(row["ratio"]) for row in rows if row["quality"] == name])
        for name in qualities
    }
    squares = sum(len(values) * np.var(values) for values in logs.values())
    for name, quality in qualities.items():
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
def test_build_multiplies_every_model_and_has_the_calibration_of_atlantiksolar(keys):
    plain = structure(**keys).mass_kg(INPUTS)
    without = {key: value for key, value in keys.items() if key != "calibration"}
    for build, factor in (("record", 1.0), (2.5, 2.5), ("careful", 1.85), (None, None)):
        if factor is not None:
            assert structure(**without, build=build).mass_kg(INPUTS) == pytest.approx(
                factor * plain
            )
        expected = plain if factor is None else factor * plain
        assert structure(**keys, build=build).mass_kg(INPUTS) == pytest.approx(expected)


def test_scatter_of_a_class_is_an_input_where_the_file_has_no_other():
    def keys(name, changes):
        inputs = uncertain_inputs(load_aircraft(name, changes), JULY, UNCORRECTED_CAM)
        return {scattering.key: scattering for scattering in inputs.inputs}

    of_class = keys("stratosphere-design", {BUILD: "careful"})[BUILD]
    assert of_class.nominal == 1.85
    assert isinstance(of_class.distribution, LogNormal)
    sigma = build_qualities()["careful"].log_sigma
    # The value that is above 84.13 % of all draws lies one sigma above the median.
    assert float(of_class.values(np.array(0.841345))) == pytest.approx(1.85 * np.exp(sigma))
    assert BUILD not in keys("stratosphere-design", {BUILD: 1.85})
    # This file says how its calibration scatters.
    assert BUILD not in keys("atlantiksolar-design", {})
