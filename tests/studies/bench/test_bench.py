"""Bench tests whose truth is known: pvlib's single diode, and formulas integrated by hand."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pvlib
import pytest
from builders import AS2, DESIGN
from click.testing import CliRunner, Result

from missions.files.errors import InputError
from sizing.library import load_aircraft
from studies.bench.result import _EVALUATE, LAYOUTS, evaluate_bench
from studies.cli.__main__ import cli
from studies.cli.commands.bench import KINDS


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["bench", *map(str, arguments)])


def written(folder: Path, kind: str, rows: list[tuple[float, ...]], columns: int = 99) -> Path:
    names = [one.name for one in LAYOUTS[kind].columns][:columns]
    lines = [",".join(names), *(",".join(f"{value:.8g}" for value in row) for row in rows)]
    path = folder / f"{kind}.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def curves(conditions: list[tuple[float, float]], area_m2: float) -> list[tuple[float, ...]]:
    """Curves of a cell by the single diode of De Soto et al. (2006), without low-light losses."""
    rows: list[tuple[float, ...]] = []
    for number, (light, warm) in enumerate(conditions, 1):
        diode = pvlib.pvsystem.calcparams_desoto(
            light, warm, alpha_sc=0.003, a_ref=0.0257, I_L_ref=6.0, I_o_ref=1.3e-11,
            R_sh_ref=80.0, R_s=0.005,
        )  # fmt: skip
        volts = np.linspace(0.0, 0.7, 60)
        amps = pvlib.pvsystem.i_from_v(volts, *diode)
        rows += [(number, light, warm, area_m2, v, a) for v, a in zip(volts, amps, strict=True)]
    return rows


def largest_w(light: float, warm: float) -> float:
    diode = pvlib.pvsystem.calcparams_desoto(
        light, warm, alpha_sc=0.003, a_ref=0.0257, I_L_ref=6.0, I_o_ref=1.3e-11,
        R_sh_ref=80.0, R_s=0.005,
    )  # fmt: skip
    return float(pvlib.pvsystem.max_power_point(*diode, method="brentq")["p_mp"])


def test_curves_of_a_single_diode_give_its_efficiency_and_its_temperature(tmp_path: Path) -> None:
    conditions = [(1000.0, 25.0), (1000.0, 40.0), (1000.0, 55.0)]
    path = written(tmp_path, "iv-curve", curves(conditions, 0.0153))
    found = evaluate_bench(AS2, path)
    efficiency, coefficient = found.fitted
    # The parabola through the top of a curve misses a hundredth of a per cent to a few tenths.
    assert efficiency.value == pytest.approx(largest_w(1000.0, 25.0) / 15.3, rel=4e-3)
    per_k = (1.0 - largest_w(1000.0, 55.0) / largest_w(1000.0, 25.0)) / 30.0
    assert coefficient.value == pytest.approx(per_k, rel=0.02)
    assert coefficient.parameter.key == "modules.temperature_coefficient_per_k"
    # One curve: the reference cell alone decides, 2 % and 2 K of 0.3 %/K.
    one = evaluate_bench(AS2, written(tmp_path, "iv-curve", curves(conditions[:1], 0.0153)))
    (alone,) = one.fitted
    assert alone.standard_error / alone.value == pytest.approx(math.hypot(0.02, 0.006), rel=1e-3)


def test_shaft_and_thrust_give_motor_and_propeller(tmp_path: Path) -> None:
    others = 0.97 * 0.96  # controller and gearbox of the file
    rows: list[tuple[float, ...]] = []
    for speed, electric in ((0.0, 30.0), (8.0, 35.0), (9.0, 40.0)):
        shaft = electric * others * 0.80
        thrust = 2.0 if speed == 0.0 else shaft * 0.75 / speed
        rows.append((speed, thrust, electric, 1000.0, shaft / (2.0 * math.pi * 1000.0 / 60.0)))
    motor, propeller = evaluate_bench(DESIGN, written(tmp_path, "thrust-stand", rows)).fitted
    assert (motor.parameter.key, propeller.parameter.key) == (
        "airframe.propulsion.motor_efficiency",
        "airframe.propulsion.propeller_efficiency",
    )
    assert motor.value == pytest.approx(0.80, rel=1e-6)
    assert propeller.value == pytest.approx(0.75, rel=1e-6)
    whole = evaluate_bench(AS2, written(tmp_path, "thrust-stand", [r[:3] for r in rows[1:]], 3))
    assert whole.fitted[0].value == pytest.approx(0.80 * 0.75 * others, rel=1e-6)


@pytest.mark.parametrize("aircraft", [AS2, DESIGN])
def test_a_glide_polar_gives_the_drag_it_was_made_of(aircraft: object, tmp_path: Path) -> None:
    span, ratio, mass, density = 5.65, 18.5, 6.92, 1.1
    area, weight, viscosity = span**2 / ratio, mass * 9.80665, 1.789e-5  # standard, 15 C
    rows: list[tuple[float, ...]] = []
    for speed in (7.5, 8.0, 8.5, 9.5, 11.0, 13.0):
        reynolds = density * speed * (span / ratio) / viscosity
        angle = 0.03
        for _ in range(20):
            lift = weight * math.cos(angle) / (0.5 * density * speed**2 * area)
            drag = 0.014 * (reynolds / 158000.0) ** -0.35 + 0.008
            drag += lift**2 / (math.pi * 0.85 * ratio)
            angle = math.atan(drag / lift)
        rows.append((speed, speed * math.sin(angle), mass, density, 15.0))
    found = evaluate_bench(aircraft, written(tmp_path, "glide-polar", rows))  # type: ignore[arg-type]
    values = {one.parameter.name: one.value for one in found.fitted}
    if aircraft is DESIGN:
        assert values["profile_drag"] == pytest.approx(0.014, rel=5e-3)
        assert values["span_efficiency"] == pytest.approx(0.85, rel=5e-3)
    else:
        lift = weight / (0.5 * 1.1 * 8.4**2 * area)
        drag = 0.014 * (1.1 * 8.4 * (span / ratio) / viscosity / 158000.0) ** -0.35 + 0.008
        drag += lift**2 / (math.pi * 0.85 * ratio)
        # A straight line in the square of the lift, without the Reynolds number.
        power = drag * 0.5 * 1.1 * 8.4**3 * area / 0.626
        assert values["level_power"] == pytest.approx(power, rel=0.01)


def test_capacity_is_the_integral_of_the_power(tmp_path: Path) -> None:
    times = np.linspace(0.0, 18000.0, 41)
    rows: list[tuple[float, ...]] = []
    for run_number, amps in ((1, 0.7), (2, 0.71)):
        rows += [(run_number, t, amps, 4.2 - t / 18000.0, 0.05) for t in times]
    (found,) = evaluate_bench(AS2, written(tmp_path, "capacity", rows)).fitted
    # 3.7 V in the mean over five hours at 0.705 A, from 50 g at 97 %.
    assert found.value == pytest.approx(3.7 * 5.0 * 0.705 / 0.05 / 0.97, rel=1e-6)
    # Two runs that differ by 1.4 %: Student's quantile of one degree of freedom, 12.7.
    assert found.half_width > 12.0 * 0.005 * found.value


def test_templates_are_tests_that_aircraft_take(tmp_path: Path) -> None:
    assert tuple(LAYOUTS) == tuple(_EVALUATE) == KINDS
    files = []
    for kind in KINDS:
        done = run("--template", kind)
        assert done.exit_code == 0, done.output
        files.append(tmp_path / f"{kind}.csv")
        files[-1].write_text(done.output)
    for name in ("atlantiksolar-as2", "atlantiksolar-design"):
        made = tmp_path / f"{name}.yaml"
        done = run(name, *files, "--write", made, "--json")
        assert done.exit_code == 0, done.output
        record = json.loads(done.output)
        craft = load_aircraft(made)
        assert craft.provenance is not None
        assert [one.key for one in craft.provenance.fitted] == [o["key"] for o in record["fitted"]]
        assert len(craft.provenance.bench_tests) == 4
        for one in record["fitted"]:
            assert one["low"] < one["value"] < one["high"]


@pytest.mark.parametrize(
    ("kind", "text", "message"),
    [
        ("capacity", "", "is empty; allowed: a header"),
        ("capacity", "run,time_s,current_a,voltage_v,mass_kg\n", "has no rows below its header"),
        ("capacity", "run;time_s;current_a;voltage_v;mass_kg\n1;0;1;4;1\n",
         ":1: 'run;time_s;current_a;voltage_v;mass_kg': are the columns of no test; allowed"),
        ("capacity", "run,time_s,curent_a,voltage_v,mass_kg\n1,0,1,4,1\n",
         ":1: curent_a: is no column of capacity; did you mean 'current_a'"),
        ("capacity", "run,time_s,current_a,voltage_v\n1,0,1,4\n", ":1: mass_kg: capacity needs"),
        ("capacity", "run,time_s,current_a,voltage_v,mass_kg\n1,0,1,4\n", ":2: has 4 values"),
        ("capacity", "run,time_s,current_a,voltage_v,mass_kg\n1,0,x,4,1\n",
         ":2: current_a: must be a number from 0 to 10000 (got 'x')"),
        ("capacity", "run,time_s,current_a,voltage_v,mass_kg\n1,0,1,nan,1\n",
         ":2: voltage_v: must be a number from 0 to 10000 (got nan)"),
        ("capacity", "run,time_s,current_a,voltage_v,mass_kg\n1,0,1,4,1\n1,0,1,4,1\n1,9,1,3,1\n",
         "run 1: time_s must rise"),
        ("capacity", "run,time_s,current_a,voltage_v,mass_kg\n1,0,1,4,1\n1,9,1,4,1\n1,900,1,3,1\n",
         "run 1: 891 s lie between two rows"),
        ("iv", "curve,irradiance_w_per_m2,module_temperature_c,area_m2,voltage_v,current_a\n"
         "1,900,25,1,0,5\n1,900,25,1,1,4\n", "points have 85% of its largest power"),
        ("thrust", "airspeed_m_per_s,thrust_n,electric_power_w\n0,2,30\n",
         "airspeed_m_per_s is 0 in all rows"),
        ("thrust", "airspeed_m_per_s,thrust_n,electric_power_w\n9,20,30\n",
         "propulsion_efficiency: the test gives 6 (allowed: 0.05 to 1)"),
        ("glide", "airspeed_m_per_s,sink_rate_m_per_s,mass_kg,density_kg_per_m3,temperature_c\n"
         "8,9,7,1.1,15\n", "line 2: sink_rate_m_per_s must be less than airspeed_m_per_s"),
    ],
)  # fmt: skip
def test_mistakes_are_one_line_each(kind: str, text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / f"{kind}.csv"
    path.write_text(text)
    done = run("atlantiksolar-as2", path, "--write", tmp_path / "out.yaml")
    assert isinstance(done.exception, InputError)
    assert len(done.exception.problems) == 1
    assert message in str(done.exception)
    assert str(path) in str(done.exception)
    assert not (tmp_path / "out.yaml").exists()


def test_columns_are_read_in_any_case_and_a_row_is_counted_as_one(tmp_path: Path) -> None:
    path = tmp_path / "stand.csv"
    names = [one.name for one in LAYOUTS["thrust-stand"].columns]
    path.write_text(f"{','.join(names).upper()}\n8,2,30,6000,0.03\n")
    found = evaluate_bench(DESIGN, path)
    assert any("stand.csv: 1 row; force" in note for note in found.notes)


def test_a_file_that_is_missing_and_two_tests_of_one_key_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        evaluate_bench(AS2, tmp_path / "missing.csv")
    one, two = tmp_path / "a.csv", tmp_path / "b.csv"
    for path in (one, two):
        path.write_text(LAYOUTS["capacity"].template())
    with pytest.raises(InputError, match=r"is also determined by .*a\.csv: give one of the two"):
        evaluate_bench(AS2, one, two)
    done = run("atlantiksolar-as2", one, "--write", one)
    assert done.exit_code == 2
    assert "is read by this command" in " ".join(done.output.split())
