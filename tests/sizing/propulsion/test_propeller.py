"""Tests of the blade-element model: wind tunnel, momentum theory, limits."""

import re
from pathlib import Path

import numpy as np
import pytest
from documented import DOCS

from missions.air import standard_air
from sizing.propulsion.propeller import BladeElementPropeller, section_coefficients

UIUC = Path(__file__).parent / "uiuc"
RUNS = sorted(path for path in UIUC.glob("*.txt") if "static" not in path.name)
PAGE = (DOCS / "propulsion.md").read_text(encoding="utf-8")
AIR = standard_air(200.0)  # Urbana, Illinois


def of_run(path):
    """Propeller, speed of rotation [1/s] and rows of a run in the wind tunnel."""
    match = re.match(r"apc(\w+)_([\d.]+)x([\d.]+)_.*_(\d+)\.txt", path.name)
    assert match
    diameter, pitch = float(match[2]) * 0.0254, float(match[3]) * 0.0254
    family = "slow_flyer" if match[1] == "sf" else "thin_electric"
    propeller = BladeElementPropeller(diameter, pitch, 2, family)
    return propeller, float(match[4]) / 60.0, np.loadtxt(path, skiprows=1)


def errors_at_equal_thrust(path):
    """Efficiency of the model less that of the tunnel, at one airspeed and thrust [-].

    The loading ``C_T / J^2`` is thrust over dynamic pressure and diameter squared: what drag and
    airspeed of an aircraft prescribe, whatever the speed of rotation comes out as.
    """
    propeller, n, rows = of_run(path)
    advance = np.linspace(0.08, 1.0, 80)
    model = propeller.coefficients(advance * n * propeller.diameter_m, n, AIR)
    pulls = model.thrust > 0.002
    loading = (model.thrust / advance**2)[pulls][::-1]
    efficiency = (advance * model.thrust / model.power)[pulls][::-1]
    measured = rows[:, 1] / rows[:, 0] ** 2
    used = (measured > 0.05) & (measured < 1.5)
    return np.asarray((np.interp(measured, loading, efficiency) - rows[:, 3])[used])


def test_efficiency_over_all_runs_in_the_wind_tunnel():
    errors = np.concatenate([errors_at_equal_thrust(path) for path in RUNS])
    assert len(errors) == 122
    assert np.mean(errors) == pytest.approx(-0.007, abs=6e-4)
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(0.027, abs=6e-4)
    assert np.abs(errors).max() == pytest.approx(0.047, abs=6e-4)


@pytest.mark.parametrize("path", RUNS, ids=lambda path: path.stem)
def test_row_of_the_page(path):
    propeller, n, rows = of_run(path)
    errors = errors_at_equal_thrust(path)
    model = propeller.coefficients(rows[:, 0] * n * propeller.diameter_m, n, AIR)
    numbers = [np.mean(errors), np.sqrt(np.mean(errors**2)), np.mean(model.thrust - rows[:, 1])]
    family, size = path.stem.split("_")[:2]
    name = f"{'Slow Flyer' if 'sf' in family else 'Thin Electric'} {size} | {60 * n:.0f} |"
    (row,) = [line for line in PAGE.splitlines() if line.startswith(f"| {name}")]
    printed = [float(cell) for cell in row.split("|")[-4:-1]]
    assert printed == pytest.approx(numbers, abs=6e-4)


def test_static_thrust_of_a_9x6():
    rows = np.loadtxt(UIUC / "apce_9x6_static_rd0987.txt", skiprows=1)
    propeller = BladeElementPropeller(9 * 0.0254, 6 * 0.0254)
    model = propeller.coefficients(0.0, rows[:, 0] / 60.0, AIR)
    assert model.thrust == pytest.approx(rows[:, 1], rel=0.10)
    assert model.power == pytest.approx(rows[:, 2], rel=0.20)
    # More Reynolds number, less drag: power falls with speed as in the tunnel.
    assert np.all(np.diff(model.power) < 0.0)


@pytest.mark.parametrize("blades", [2, 3, 6])
@pytest.mark.parametrize("ratio", [0.4, 0.8, 1.4])
def test_no_propeller_beats_momentum_theory(blades, ratio):
    propeller = BladeElementPropeller(0.6, 0.6 * ratio, blades)
    advance = np.linspace(0.02, ratio + 0.3, 60)
    n = 25.0
    v = advance * n * 0.6
    model = propeller.coefficients(v, n, AIR)
    pulls = model.thrust > 0.0
    loading = 8.0 / np.pi * (model.thrust / advance**2)[pulls]
    ideal = 2.0 / (1.0 + np.sqrt(1.0 + loading))
    assert np.all((advance * model.thrust / model.power)[pulls] < ideal)


@pytest.mark.parametrize("advance", [0.0, 0.3, 0.6])
def test_each_further_blade_pulls_but_less_than_those_before(advance):
    # The blades pull in the wake of each other.
    propellers = [BladeElementPropeller(0.6, 0.5, blades) for blades in (2, 3, 4)]
    thrust = [float(one.coefficients(15.0 * advance, 25.0, AIR).thrust) for one in propellers]
    each = [pull / blades for pull, blades in zip(thrust, (2, 3, 4), strict=True)]
    assert thrust == sorted(thrust)
    assert each == sorted(each, reverse=True)


def test_fast_flight_brakes_and_turns_the_propeller():
    propeller = BladeElementPropeller(0.25, 0.15)
    n = 50.0
    v = np.linspace(0.2, 2.0, 200) * n * 0.25
    model = propeller.coefficients(v, n, AIR)
    # Thrust ends first, where the motor still turns it; then the air does.
    brakes, driven = (int(np.argmax(c < 0.0)) for c in (model.thrust, model.power))
    assert 0 < brakes < driven
    assert np.all(model.thrust[brakes:] < 0.0)
    assert np.all(model.power[driven:] < 0.0)
    # Drag of a disc is at most about that of a plate of its size.
    force = model.thrust[-1] * n**2 * 0.25**4 / (0.5 * v[-1] ** 2 * np.pi * 0.125**2)
    assert -1.2 < force < 0.0


def test_coefficients_depend_on_air_by_the_reynolds_number_alone():
    propeller = BladeElementPropeller(0.66, 0.60)
    low, high = standard_air(500.0), standard_air(15_000.0)
    kinematic = [air.dynamic_viscosity_pa_s / air.density_kg_per_m3 for air in (low, high)]
    n = np.array([10.0, 10.0 * kinematic[1] / kinematic[0]])
    at_low = propeller.coefficients(0.7 * n[0] * 0.66, n[0], low)
    other = propeller.coefficients(0.7 * n[1] * 0.66, n[1], high)
    assert float(other.thrust) == pytest.approx(float(at_low.thrust), rel=1e-9)
    assert float(other.power) == pytest.approx(float(at_low.power), rel=1e-9)
    # The same speeds high up: thinner air, more drag.
    thin = propeller.coefficients(0.7 * n[0] * 0.66, n[0], high)
    assert thin.thrust / thin.power < at_low.thrust / at_low.power


def test_section_is_continuous_and_stalls():
    angle = np.radians(np.linspace(-90, 90, 20_001))
    lift, drag = section_coefficients(angle, 70_000.0)
    assert np.abs(np.diff(lift)).max() < 2e-3
    assert np.abs(np.diff(drag)).max() < 1e-3
    assert lift.max() == pytest.approx(1.2)
    assert drag.min() == pytest.approx(0.028, rel=1e-3)
    assert section_coefficients(0.0, 140_000.0)[1] == pytest.approx(0.028 * 2**-0.7)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0.0, 0.1), r"diameter_m must be above 0 and at most 100 \(got 0\)"),
        ((0.5, -0.1), r"pitch_m must be above 0 and at most 100 \(got -0.1\)"),
        ((0.5, float("nan")), "pitch_m must be above 0"),
        ((101.0, 0.3), r"diameter_m must be above 0 and at most 100 \(got 101\)"),
        ((0.5, 0.3, 1), r"blades must be a whole number from 2 to 12 \(got 1\)"),
        ((0.5, 0.3, 2, "wide"), "chords must be one of thin_electric, slow_flyer"),
    ],
)
def test_what_is_no_propeller_is_refused(values, message):
    with pytest.raises(ValueError, match=message):
        BladeElementPropeller(*values)
