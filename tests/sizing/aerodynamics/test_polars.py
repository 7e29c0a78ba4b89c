"""Airfoil polars: tables, their smooth fit, and the drag of an aircraft that stands on them."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from source_tree import ROOT

from benchmarks.validation.make_polars import default_grid, main
from benchmarks.validation.power_curve import power_tables
from missions.files.errors import InputError
from missions.files.texts import texts_as_read
from sizing.aerodynamics.airfoil_polar import AirfoilPolar
from sizing.aerodynamics.polar_table import (
    COLUMNS,
    parse_polar_table,
    shipped_airfoils,
    shipped_table,
)
from sizing.aerodynamics.wing_polar import WingPolar

SHIPPED = shipped_airfoils()
HEADER = "# airfoil: test\n# source: made up\n" + ",".join(COLUMNS) + "\n"

# Fitted where a test asks for one: collecting the tests need not take a second more.
polars = st.sampled_from(SHIPPED).map(AirfoilPolar.load)
wild_lift = st.floats(-1e6, 1e6)
wild_reynolds = st.floats(0.0, 12.0).map(lambda exponent: 10.0**exponent)


def _wing(airfoil="fx60126", **changes):
    record = {
        "model": "wing_polar",
        "airfoil": airfoil,
        "design_aspect_ratio": 18.5,
        "design_reynolds": 158000.0,
    }
    return WingPolar.model_validate(record | changes)


def _formula_table(reynolds=(60e3, 1e5, 2e5, 4e5, 6e5), step_deg=1.0):
    """Table of a section known in closed form: thin airfoil, parabolic drag, no stall."""
    rows = []
    for re in reynolds:
        for alpha in np.arange(-4.0, 10.01, step_deg):
            cl = 0.4 + 0.1 * alpha
            rows.append(f"{alpha:g},{re:g},{cl:.6f},{_formula_drag(cl, re):.8f},0,1")
    return HEADER + "\n".join(rows) + "\n"


def _formula_drag(cl, reynolds):
    return float((0.008 + 0.004 * (cl - 0.5) ** 2) * (reynolds / 2e5) ** -0.4)


# ---- The shipped tables


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_table_covers_the_range_and_says_where_it_is_from(name):
    table = shipped_table(name)
    assert table.name.startswith(name)
    assert {"airfoil", "source", "coordinates", "ncrit", "mach", "tool"} <= set(table.header)
    reynolds = np.unique(table.columns["reynolds"])
    assert len(reynolds) >= 8
    assert reynolds[[0, -1]] == pytest.approx([60e3, 600e3])
    # Every Reynolds number has every angle.
    assert np.unique(table.columns["alpha_deg"]) == pytest.approx(default_grid().alpha_deg)
    assert len(table.columns["cl"]) == len(reynolds) * len(default_grid().alpha_deg)


@pytest.mark.parametrize("name", SHIPPED)
def test_fit_error_is_that_of_the_table_read_by_other_means(name):
    polar, columns = AirfoilPolar.load(name), shipped_table(name).columns
    # Well below NeuralFoil's own difference from XFOIL: 2.4 % mean error of drag for this network.
    median, most = polar.fit_error
    assert median < 0.01
    assert most < 0.05
    for reynolds in np.unique(columns["reynolds"]):
        if not polar.reynolds_range[0] <= reynolds <= polar.reynolds_range[1]:
            continue
        rows = columns["reynolds"] == reynolds
        alpha, cl, cd = (columns[key][rows] for key in ("alpha_deg", "cl", "cd"))
        # Angles that are surely attached at all Reynolds numbers, below the stall.
        used = (alpha >= 0.0) & (alpha <= 6.0) & (cl > max(0.2, polar.least_lift))
        assert np.any(used)
        assert polar.profile_drag(cl[used], reynolds) == pytest.approx(cd[used], rel=0.05)


@pytest.mark.parametrize("name", SHIPPED)
def test_maximum_lift_is_above_one_and_near_the_tables(name):
    polar, columns = AirfoilPolar.load(name), shipped_table(name).columns
    for reynolds in (90e3, 200e3, 600e3):
        lift = float(polar.maximum_lift(reynolds))
        nearest = columns["reynolds"][np.argmin(np.abs(columns["reynolds"] - reynolds))]
        greatest = float(np.max(columns["cl"][columns["reynolds"] == nearest]))
        assert lift > 1.0
        # Lift that still creeps up at a tenth of the slope, or after a dip, does not count.
        assert greatest - 0.12 < lift < greatest + 0.04


@pytest.mark.parametrize(("name", "best"), [("mh114", 109.0), ("e214", 97.1), ("sd7037", 72.9)])
def test_best_endurance_ratio_agrees_with_xfoil(name, best):
    # Greatest cl^1.5/cd at Re 200 000, Ncrit 9, computed with XFOIL 6.99, which NeuralFoil imitates
    # to some per cent.
    cl = np.linspace(0.5, 1.8, 400)
    ratio = cl**1.5 / AirfoilPolar.load(name).profile_drag(cl, 2e5)
    assert np.max(ratio) == pytest.approx(best, rel=0.03)


# ---- The fit


def test_fit_returns_the_formula_a_table_was_made_from():
    polar = AirfoilPolar.from_table(parse_polar_table(_formula_table(), "test.csv"))
    assert polar.reynolds_range == (60e3, 600e3)
    for reynolds in (80e3, 150e3, 300e3, 500e3):
        for cl in (0.15, 0.5, 0.9, 1.2):
            # Clamps and fit together stay within half a per cent.
            assert float(polar.profile_drag(cl, reynolds)) == pytest.approx(
                _formula_drag(cl, reynolds), rel=5e-3
            )


@given(polars, wild_lift, wild_reynolds)
def test_drag_and_maximum_lift_are_positive_everywhere(polar, cl, reynolds):
    drag = float(polar.profile_drag(cl, reynolds))
    # Laminar flat plate, both sides, at Re 600 000: no section has less.
    assert drag > 2.0 * 1.328 / math.sqrt(600e3)
    assert math.isfinite(drag)
    assert float(polar.maximum_lift(reynolds)) > 0.0


@given(polars, wild_reynolds, st.floats(0.0, 3.0), st.floats(0.01, 3.0))
def test_drag_rises_beyond_the_stall_and_below_the_branch(polar, reynolds, first, more):
    # A tenth outside the branch, beyond the blend.
    inside = float(np.clip(reynolds, *polar.reynolds_range))
    stalled = float(polar.maximum_lift(inside)) + 0.1 + first
    below = polar.least_lift - 0.1 - first
    assert polar.profile_drag(stalled + more, reynolds) > polar.profile_drag(stalled, reynolds)
    assert polar.profile_drag(below - more, reynolds) > polar.profile_drag(below, reynolds)


@pytest.mark.parametrize("name", SHIPPED)
def test_below_the_table_slower_flow_has_more_drag_and_less_lift(name):
    polar = AirfoilPolar.load(name)
    reynolds = polar.reynolds_range[0] * np.array([0.5, 0.25, 0.1])
    drag, lift = polar.profile_drag(0.8, reynolds), polar.maximum_lift(reynolds)
    # More than laminar friction, which rises with the root of the Reynolds number.
    assert np.all(drag[1:] / drag[:-1] > (reynolds[:-1] / reynolds[1:]) ** 0.5)
    assert np.all(np.diff(lift) < 0.0)


@pytest.mark.parametrize("name", SHIPPED)
def test_drag_and_slope_are_continuous_across_the_clamps(name):
    polar = AirfoilPolar.load(name)
    lift = np.linspace(polar.least_lift - 0.3, 2.0, 60001)
    logs = [np.linspace(math.log(edge / 1.5), math.log(edge * 1.5), 60001) for edge in (6e4, 6e5)]
    paths = [(lift, np.log(polar.profile_drag(lift, re))) for re in (30e3, 1.5e5, 9e5)]
    paths += [(path, np.log(polar.profile_drag(0.8, np.exp(path)))) for path in logs]
    paths += [(path, polar.maximum_lift(np.exp(path))) for path in logs]
    for x, y in paths:
        slope = np.gradient(y, x)
        curvature = np.gradient(slope, x)
        # A jump in y or in its slope would appear as a multiple of 1/step, above 20 000.
        assert np.max(np.abs(slope)) < 60.0
        assert np.max(np.abs(curvature[2:-2])) < 6000.0


# ---- Reading tables


def test_reynolds_numbers_at_which_the_rise_breaks_off_are_left_out():
    """Lift of the second Reynolds number falls by 0.35 at 3 degrees, and rises again."""
    rows = _formula_table((60e3, 1e5, 2e5, 3e5, 4e5, 6e5), 0.5).removeprefix(HEADER).split()
    for i, row in enumerate(rows):
        alpha, reynolds, cl, *rest = row.split(",")
        if reynolds == "100000" and float(alpha) > 3.0:
            rows[i] = ",".join([alpha, reynolds, f"{float(cl) - 0.35:.4f}", *rest])
    kept = [row for row in rows if not row.startswith("-")]
    polar = AirfoilPolar.from_table(parse_polar_table(HEADER + "\n".join(kept), "test.csv"))
    assert polar.reynolds_range == (2e5, 6e5)


def test_polar_is_read_from_a_path(tmp_path):
    file = tmp_path / "own.csv"
    for unknown, message in (
        (str(file), "own.csv: no such file"),
        ("mh139", "unknown airfoil 'mh139'.*e214"),
    ):
        with pytest.raises(ValidationError, match=message):
            _wing(unknown)
    file.write_text(_formula_table(), encoding="utf-8")
    assert AirfoilPolar.load(str(file)).name == "test"
    assert _wing(str(file), lift_coefficient=0.8).polar.name == "test"


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("1,2e5,0.5,0.01,0", "test.csv:4: has 5 values, but the table names 6 columns"),
        ("1,2e5,0.5,0.01,0,1,7", "test.csv:4: has 7 values, but the table names 6 columns"),
        ("1,2e5,abc,0.01,0,1", "test.csv:4: cl: must be a number from -12.57 to 12.57 .*abc"),
        ("1,2e5,nan,0.01,0,1", "test.csv:4: cl: must be a number from -12.57 to 12.57 .*nan"),
        ("1,0,0.5,0.01,0,1", "test.csv:4: reynolds: must be a number above 0"),
        ("1,2e5,0.5,0,0,1", "test.csv:4: cd: must be a number above 0"),
        ("1,2e5,1e300,0.01,0,1", "test.csv:4: cl: must be a number from -12.57 to 12.57"),
        ("1,2e5,0.5,1e300,0,1", "test.csv:4: cd: must be a number above 0 and at most 10"),
        ("1,1e300,0.5,0.01,0,1", "test.csv:4: reynolds: must be a number above 0 and at most 1e"),
        ("1e9,2e5,0.5,0.01,0,1", "test.csv:4: alpha_deg: must be a number from -180 to 180"),
        ("1,2e5,0.5,0.01,0,1.5", "test.csv:4: confidence: must be a number from 0 to 1"),
        ("1,2e5,.5,.01,0,1\n1,2e5,.6,.01,0,1", "test.csv:5: same alpha_deg .* as in line 4"),
        ("", "no rows"),
    ],
)
def test_wrong_row_is_reported_with_its_line(row, message):
    with pytest.raises(InputError, match=message):
        parse_polar_table(HEADER + row + "\n", "test.csv")


def _rough_table():
    generator = np.random.default_rng(1)
    lines = [line.split(",") for line in _formula_table(step_deg=0.25).splitlines()]
    for fields in lines[3:]:
        fields[3] = f"{float(fields[3]) * generator.choice([0.5, 2.0]):.6f}"
    return "\n".join(map(",".join, lines))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEADER + "1\n2,2e5,1,0.02,0,1\nx\n", r"csv:4: has 1 values.*\n.*csv:6: has 1 values"),
        (_rough_table(), "too rough for a smooth polar"),
        (HEADER.replace("alpha_deg", "alpha"), "test.csv:3: column names must be alpha_deg,"),
        ("", "column names must be"),
        (_formula_table().replace("# source: made up\n", ""), "no line '# source: ...'"),
        (_formula_table(reynolds=(1e5, 2e5, 3e5)), "attached flow at 3 Reynolds numbers"),
        (_formula_table(step_deg=2.0), "8 angles of attack"),
    ],
)
def test_wrong_header_and_table_too_small_for_a_fit_are_refused(text, message):
    with pytest.raises(InputError, match=message):
        AirfoilPolar.from_table(parse_polar_table(text, "test.csv"))


def test_a_record_keeps_its_table_when_the_file_goes(tmp_path):
    file = tmp_path / "own.csv"
    file.write_text(_formula_table())
    wing = _wing(str(file))
    drag = wing.drag_at(0.8, 18.5, 158e3)
    file.unlink()
    copied = pickle.loads(pickle.dumps(wing)).model_copy()
    assert copied.drag_at(0.8, 18.5, 158e3) == drag
    with texts_as_read({str(file): wing.contents_read() or ""}):
        assert _wing(str(file)) == wing
    # Another table under this path makes another record.
    file.write_text(_formula_table().replace("# source: made up", "# source: other"))
    assert _wing(str(file)) != wing == pickle.loads(pickle.dumps(wing))
    assert wing.model_copy(update={"calibration": 2.0}) != wing


def test_writer_repeats_a_shipped_table(tmp_path):
    pytest.importorskip("neuralfoil")
    file = tmp_path / "out.csv"
    assert main(["--airfoil", "e214", "--out", str(file)]) == 0
    written = parse_polar_table(file.read_text(encoding="utf-8"), str(file)).columns
    for name, values in shipped_table("e214").columns.items():
        # Digits of the file; another version may differ a little more.
        assert written[name] == pytest.approx(values, rel=0.02, abs=2e-3)


# ---- The wing


def test_best_lift_needs_least_power_within_the_stall_margin():
    for name in SHIPPED:
        polar = _wing(name)
        best = polar.flight_lift_coefficient
        assert best <= polar.highest_lift_coefficient
        lift = np.linspace(0.4, polar.highest_lift_coefficient, 500)
        power = polar.drag_at(lift, 18.5, 158000.0 * lift**-0.5) / lift**1.5
        least = float(polar.drag_at(best, 18.5, 158000.0 * best**-0.5)) / best**1.5
        assert least <= np.min(power) * (1.0 + 1e-9)


def test_stall_margin_bounds_the_lift():
    polar = _wing(stall_margin=1.4)
    assert polar.flight_lift_coefficient == pytest.approx(polar.highest_lift_coefficient)
    # V / V_stall.
    ratio = polar.maximum_lift_coefficient / polar.flight_lift_coefficient
    assert ratio**0.5 == pytest.approx(1.4)
    highest = _wing().highest_lift_coefficient
    assert _wing(lift_coefficient=highest - 1e-6).flight_lift_coefficient == highest - 1e-6
    with pytest.raises(ValidationError, match="lift_coefficient must be at most"):
        _wing(lift_coefficient=highest + 0.01)
    # A wing may stall before its section, whose greatest lift hardly changes with speed.
    clean, rough = (_wing(maximum_lift_factor=f).maximum_lift_coefficient for f in (1.0, 0.85))
    assert rough == pytest.approx(0.85 * clean, rel=0.03)


def test_parts_add_up_and_calibration_multiplies_them():
    parts = profile, induced, other = _wing().parts(18.5, 158000.0, 1.0)
    assert _wing(calibration=1.3).drag_at(1.0, 18.5, 158000.0) == pytest.approx(1.3 * sum(parts))
    assert induced == pytest.approx(1.0 / (math.pi * 0.92 * 18.5))
    assert profile > 0.0
    # A tail has the drag of a section of its size: 0.010 to 0.012 on its own area at a Reynolds
    # number near 90 000.
    _, _, without_tail = _wing(tail_area_ratio=0.0).parts(18.5, 158000.0, 1.0)
    assert 0.010 < (other - without_tail) / _wing().tail_area_ratio < 0.012


def test_documentation_holds_the_tables_as_computed():
    page = ROOT / "docs" / "aerodynamics.md"
    documented = page.read_text(encoding="utf-8").splitlines()
    rows = [
        line
        for line in "".join(t.to_markdown() for t in power_tables()).splitlines()
        if line.startswith(tuple(map("| {} ".format, SHIPPED)))
    ]
    assert len(rows) == 2 * len(SHIPPED)
    assert [row for row in rows if row not in documented] == []
