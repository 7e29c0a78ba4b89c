import json
from types import SimpleNamespace

import numpy as np
import pytest

import sizing
from missions.files.errors import InputError
from missions.files.overrides import with_values
from missions.library import load_mission
from missions.uncertainty import Uniform
from sizing.library import load_aircraft
from sizing.results.uncertainty import _sobol_indices
from sizing.uncertainty.inputs import UncertainInput, UncertainInputs

DESIGN = load_aircraft("atlantiksolar-design")
MISSION = load_mission("rafz-july")


def with_inputs(inputs, correlations=(), name="atlantiksolar-as2"):
    section = {"inputs": inputs, "correlations": list(correlations)}
    return load_aircraft(name, {"uncertainty": section})


@pytest.fixture(scope="module")
def analysis():
    return sizing.analyse_uncertainty(DESIGN, MISSION, samples=1024)


def test_the_record_agrees_with_the_draws(analysis):
    record = json.loads(json.dumps(analysis.to_dict(), allow_nan=False))
    frame = analysis.to_frame()
    assert record["samples"] == len(frame) == 1024
    assert record["seed"] == 0  # of a call without one, as on the command line and in the docs
    share = float((frame["excess_time_h"] > 0.0).mean())
    found = record["probability_perpetual"]
    assert found["low"] <= share == found["value"] <= found["high"]
    median = record["excess_time_h"]["p50"]
    assert (frame["excess_time_h"] <= median).mean() == pytest.approx(0.5, abs=1e-3)
    # P90 is the value exceeded in 90 % of draws, as in reports on solar power.
    exceeded = (frame["excess_time_h"] >= record["excess_time_h"]["p90"]).mean()
    assert exceeded == pytest.approx(0.9, abs=2e-3)
    assert "P90 is exceeded in 90 % of draws" in " ".join(str(analysis).split())
    assert record["inputs"][0]["key"] == "battery.specific_energy_wh_per_kg"
    # The files' values stand in the middle of all inputs but for curvature.
    assert record["nominal_excess_time_h"] == pytest.approx(median, abs=0.1)
    first = sum(index["first"] for index in record["sobol"].values())
    # Nearly additive; the estimate of 128 points an input scatters by some per cent.
    assert first == pytest.approx(1.0, abs=0.1)


def test_the_same_seed_gives_the_same_numbers_and_another_one_others():
    runs = [sizing.analyse_uncertainty(DESIGN, MISSION, samples=128, seed=s) for s in (3, 3, 4)]
    same, again, other = (run.flights.excess_time_h for run in runs)
    assert np.array_equal(same, again)
    assert not np.array_equal(same, other)


def test_draws_have_the_spread_that_was_asked_for():
    aircraft = with_inputs({"battery.specific_energy_wh_per_kg": {"relative_sigma": 0.04}})
    found = sizing.analyse_uncertainty(aircraft, MISSION, samples=4096, model_error=False)
    values = found.values["battery.specific_energy_wh_per_kg"]
    nominal = aircraft.battery.specific_energy_wh_per_kg
    assert values.mean() == pytest.approx(nominal, rel=1e-4)
    # Cut off at a ten-thousandth on either side.
    assert values.std() == pytest.approx(0.04 * nominal, rel=5e-3)
    assert found.sobol["battery.specific_energy_wh_per_kg"].total == 1.0


def test_correlated_inputs_go_together_and_have_no_indices():
    keys = ["battery.specific_energy_wh_per_kg", "modules.efficiency_stc"]
    inputs = {key: {"relative_sigma": 0.03} for key in keys}
    pair = {"between": keys, "coefficient": 0.7}
    found = sizing.analyse_uncertainty(with_inputs(inputs, [pair]), MISSION, samples=2048)
    scatter = np.corrcoef(*(found.values[key] for key in keys))[0, 1]
    assert scatter == pytest.approx(0.7, abs=0.02)  # of normal scores it is that of the values
    assert found.sobol == {}
    assert "Inputs are correlated" in " ".join(str(found).split())


def pairs(keys, coefficients):
    """Correlations of the first with the second, the second with the third and so on around."""
    around = zip(keys, [*keys[1:], keys[0]], coefficients, strict=False)
    return [{"between": [one, other], "coefficient": value} for one, other, value in around]


EFFICIENCY = "modules.efficiency_stc"
THREE = (EFFICIENCY, "battery.mass_kg", "power.avionics_w")
NARROW = {"relative_sigma": 0.01}


@pytest.mark.parametrize(
    ("inputs", "correlations", "message"),
    [
        ({"battery.mass": {"sigma": 1}}, [], "battery.mass: is no key of the file that holds a nu"),
        ({"name": {"sigma": 1}}, [], "name: is no key of the file that holds a number"),
        ({EFFICIENCY: {"relative_sigma": 0.8}}, [], "to impossible values, .* in 10000 draws"),
        ({EFFICIENCY: NARROW}, pairs(THREE, [0.5]), "battery.mass_kg is no uncertain input"),
        (dict.fromkeys(THREE, NARROW), pairs(THREE, [0.9, 0.9, -0.9]), "not positive definite"),
    ],
)
def test_impossible_inputs_are_refused(inputs, correlations, message):
    with pytest.raises(InputError, match=message):
        sizing.analyse_uncertainty(with_inputs(inputs, correlations), MISSION)


def test_calls_are_checked():
    with pytest.raises(ValueError, match="samples must be from 64"):
        sizing.analyse_uncertainty(DESIGN, MISSION, samples=3)
    bare = load_aircraft("atlantiksolar-as2")
    with pytest.raises(ValueError, match="has an uncertain input"):
        sizing.analyse_uncertainty(bare, MISSION, model_error=False)
    with pytest.raises(TypeError, match="expected Aircraft"):
        sizing.analyse_uncertainty("atlantiksolar-as2", MISSION)
    key = "battery.charge_limit.c_rate_per_h"
    limited = with_inputs({key: {"relative_sigma": 0.1}}, name="atlantiksolar-design")
    with pytest.raises(ValueError, match=f"{key} is the same for all draws"):
        sizing.analyse_uncertainty(limited, MISSION)


def test_probabilities_are_those_of_a_loop_over_analyses():
    inputs = {
        "battery.specific_energy_wh_per_kg": {"relative_sigma": 0.08},
        "airframe.level_flight.electric_power_w": {"relative_sigma": 0.12},
        "modules.efficiency_stc": {"distribution": "uniform", "low": 0.2, "high": 0.25},
    }
    aircraft = load_aircraft("atlantiksolar-as2", {"uncertainty": {"inputs": inputs}})
    mission = load_mission("rafz-july", {"clearness": 0.5, "required_excess_time_h": 1.0})
    found = sizing.analyse_uncertainty(aircraft, mission, samples=64, seed=3, model_error=False)
    plain = aircraft.model_copy(update={"uncertainty": None})
    excess_h = []
    for number in range(64):
        draw = {key: float(value[number]) for key, value in found.values.items()}
        excess_h.append(sizing.analyse(with_values(plain, draw), mission).excess_time_h)
    excess_h = np.array(excess_h)
    assert 0 < np.sum(excess_h > 0.0) < 64
    # The same draws, the same verdict on each.
    assert np.array_equal(found.flights.excess_time_h > 0.0, excess_h > 0.0)
    # Two lobes, each told by its own share and spread, and no median of both.
    told = str(found.summary())
    for name, chosen in (("perpetual", excess_h > 0.0), ("limited", excess_h <= 0.0)):
        middle = np.percentile(found.flights.excess_time_h[chosen], 50.0, method="inverted_cdf")
        row = next(
            line for line in told.splitlines() if f"{name}, {100.0 * np.mean(chosen):.1f} %" in line
        )
        assert f" {middle:.2f} h" in row
    assert "excess time: 10, 50, 90 % of draws" not in told
    # All draws have the warmth of the nominal modules, whose airspeed is another.
    assert found.flights.excess_time_h == pytest.approx(excess_h, abs=0.1)
    assert found.probability_perpetual.value == np.mean(excess_h > 0.0)
    assert found.probability_required.value == np.mean(excess_h >= 1.0)


class _Known:
    """Stands for the flights: a function of the inputs whose indices are known."""

    def __init__(self, function):
        self.function = function

    def flights(self, values):
        return SimpleNamespace(excess_time_h=self.function(*values.values()))


def scattered(*distributions):
    named = zip("abc", distributions, strict=False)
    inputs = tuple(UncertainInput(key, 1.0, one) for key, one in named)
    return UncertainInputs(inputs, np.eye(len(inputs)))


def test_indices_of_ishigamis_function():
    # Ishigami and Homma (1990), ISUMA: sin a + 7 sin^2 b + 0.1 c^4 sin a, each from -pi to pi. By
    # integration the parts of its variance are those of a, of b, and of a and c together.
    pi4 = np.pi**4
    of_a, of_b = 0.5 * (1.0 + 0.1 * pi4 / 5.0) ** 2, 7.0**2 / 8.0
    of_ac = 0.1**2 * pi4**2 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = of_a + of_b + of_ac
    inputs = scattered(*[Uniform(distribution="uniform", low=-np.pi, high=np.pi)] * 3)
    study = _Known(lambda a, b, c: np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a))
    found = list(_sobol_indices(study, inputs, 2**16, 1).values())
    assert [i.first for i in found] == pytest.approx([of_a / whole, of_b / whole, 0.0], abs=0.01)
    totals = [of_a + of_ac, of_b, of_ac]
    assert [one.total for one in found] == pytest.approx(np.array(totals) / whole, abs=0.01)
