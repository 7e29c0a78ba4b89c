from pathlib import Path

import numpy as np
import pytest

from missions.files.errors import InputError
from sizing import load_aircraft
from sizing.propulsion.propeller_files import read_propeller

UIUC = Path(__file__).parent / "uiuc"
# Rows and spaces as in APC's file of the 11x5.5E of 2014.
APC = (UIUC.parent / "apc_11x5.5E.dat").read_text("utf-8")


def written(folder, text, name="table.csv"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def problem(folder, text, name="table.csv", **options):
    with pytest.raises(InputError) as caught:
        read_propeller(written(folder, text, name), **options)
    return str(caught.value).replace(str(folder) + "/", "")


def at(table, advance, rpm):
    n = rpm / 60.0
    both = table.coefficients(advance * n * table.diameter_m, n)
    return float(both.thrust), float(both.power)


def test_uiuc_runs_of_two_speeds_and_the_static_one():
    table = read_propeller(sorted(UIUC.glob("apce_9x6_*.txt")))
    assert table.diameter_m == pytest.approx(0.2286)
    assert [curve.speed_rpm for curve in table.curves] == [4003, 6701]
    assert at(table, 0.360, 4003) == pytest.approx((0.0797, 0.0510))
    # Between the speeds: the mean, at an advance ratio that both have.
    slow, fast, between = at(table, 0.405, 4003), at(table, 0.405, 6701), at(table, 0.405, 5352)
    assert between == pytest.approx((np.array(slow) + fast) / 2)
    # At rest: the static run at 4003 rpm, between 0.1137 at 3779 and 0.1139 at 4079 rpm.
    assert at(table, 0.0, 4003)[0] == pytest.approx(0.1137 + 0.0002 * (4003 - 3779) / 300)


@pytest.mark.parametrize(("advance", "rpm"), [(0.81, 4003), (0.6, 6701), (0.3, 3900), (0.3, 6800)])
def test_outside_the_table_nothing_is_told(advance, rpm):
    table = read_propeller(sorted(UIUC.glob("apce_9x6_*.txt")))
    assert np.isnan(at(table, advance, rpm)).all()


def test_any_speed_holds_the_outer_curves_and_no_advance_ratio():
    table = read_propeller(sorted(UIUC.glob("apce_9x6_*.txt")), any_speed=True)
    assert at(table, 0.3, 9000) == pytest.approx(at(table, 0.3, 6701))
    assert at(table, 0.7, 2000) == pytest.approx(at(table, 0.7, 4003))
    assert np.isnan(at(table, 0.9, 2000)).all()


def test_apc_file_by_its_own_units(tmp_path):
    table = read_propeller(written(tmp_path, APC, "PER3_11x55E.dat"))
    assert table.diameter_m == pytest.approx(11 * 0.0254)
    # 13.1 mph at 4000 rpm: J of the file is rounded to 0.31.
    advance = 13.1 * 0.44704 / (4000 / 60 * 11 * 0.0254)
    assert table.curves[1].advance_ratio[1] == pytest.approx(advance)
    # Torque and thrust of the file, in pounds and inches, by the definitions of C_T and C_P.
    thrust, power = at(table, advance, 4000)
    n, d = 4000 / 60, 11 * 0.0254
    assert thrust * 1.225 * n**2 * d**4 == pytest.approx(0.530 * 4.448222, rel=3e-3)
    assert power * 1.225 * n**2 * d**5 / (2 * np.pi) == pytest.approx(0.503 * 0.1129848, rel=3e-3)


def test_own_csv_in_any_order(tmp_path):
    text = "# diameter_m: 0.66\nrpm,CP,J,CT\n900,.05,.5,.08\n900,.03,.9,.02\n"
    text += "1200,.05,.5,.09\n1200,.03,.9,.03\n"
    table = read_propeller(written(tmp_path, text))
    assert table.diameter_m == 0.66
    assert at(table, 0.7, 1050) == pytest.approx((0.055, 0.04))
    assert read_propeller(written(tmp_path, text), diameter_m=0.5).diameter_m == 0.5


ROWS = "# diameter_m: 0.66\nJ,CT,CP,rpm\n.5,.08,.05,900\n.9,.02,.03,900\n"


BARE = ROWS.removeprefix("# diameter_m: 0.66\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ROWS, ": has 900 rpm alone: two speeds or more are needed"),
        (ROWS + ".5,x,.05,1200\n", ":5: ct: must be a number from -2 to 2 (got 'x')"),
        (ROWS + ".5,nan,.05,1200\n", ":5: ct: must be a number from -2 to 2 (got 'nan')"),
        (ROWS + "-.5,.1,.05,1200\n", ":5: j: must be a number from 0 to 5 (got '-.5')"),
        (ROWS + ".5,.1,.05,-3\n", ":5: rpm: must be a number above 0"),
        (ROWS + ".9,.1,.05,1200\n", ":5: CT 0.1 and CP 0.05 at J 0.9 are an efficiency"),
        (ROWS + ".9,.1,.1,1200\n", ":5: the only advance ratio at this speed"),
        (f"# diameter_m: -1\n{BARE}", "diameter_m: must be above 0 and at most 100 (got -1)"),
        (BARE, ": does not tell the diameter: give diameter_m"),
        ("J,CT,CP,torque\n", ":1: columns must be J, CT, CP and rpm"),
        ("J,CT,CP,rpm\n", ": holds no row of J, CT and CP"),
        ("", ": is no table of a propeller"),
        ("alpha cl cd\n1 2 3\n", ": is no table of a propeller"),
        (APC.replace("11x5.5E ", "9x5.5E "), ":14: J 0.29 is not V/(nD) of 3.0 mph"),
        (APC.replace("0.0742", "O.0742"), ":14: CT must be a number (got 'O.0742')"),
        (APC.replace("0.0742", "      "), ":14: 8 numbers are needed (got 7)"),
        (APC.replace("RPM =       1000", "RPM = fast"), ":9: PROP RPM must be above 0"),
    ],
)
def test_bad_file_is_told_by_file_line_and_value(tmp_path, text, message):
    name = "P.dat" if text.startswith("\n") else "t.csv"
    place = name if message.startswith(":") else ""
    assert f"{place}{message}" in problem(tmp_path, text, name)
    unnamed = problem(tmp_path, "J CT CP eta\n.1 .1 .05 .2\n.2 .1 .05 .4\n", "x_9x6.txt")
    assert "names no speed of rotation" in unnamed


# Since 2022 APC's files leave the coefficients blank.
COEFFICIENTS = "      0.5524      0.0742      0.0389       0.001       0.032       0.035"


@pytest.mark.parametrize("blank", [COEFFICIENTS.replace("0.0742      0.0389", "-NaN   -NaN"), ""])
def test_rows_that_apc_could_not_compute_are_left_out(tmp_path, blank):
    table = read_propeller(written(tmp_path, APC.replace(COEFFICIENTS, blank)))
    assert len(table.curves[0].advance_ratio) == 2
    (note,) = table.notes
    assert note == f"1 row is left out: {tmp_path / 'table.csv'}:14: no CT and CP"


def test_low_and_high_advance_ratios_of_one_nominal_speed_are_one_curve(tmp_path):
    head = "J CT CP eta\n"
    low = written(tmp_path, head + "0.1 .10 .05 .2\n0.5 .06 .04 .75\n", "x_9x6_a_5013.txt")
    high = written(tmp_path, head + "0.5 .05 .04 .63\n0.8 .01 .02 .4\n", "x_9x6_b_5000.txt")
    other = written(tmp_path, head + "0.1 .12 .05 .2\n0.8 .02 .04 .4\n", "x_9x6_c_6000.txt")
    table = read_propeller([low, high, other])
    assert len(table.curves) == 2
    assert list(table.curves[0].advance_ratio) == [0.1, 0.5, 0.8]
    assert table.curves[0].thrust[1] == pytest.approx(0.055)


def test_no_file_is_refused():
    with pytest.raises(InputError, match="files: must name at least one file"):
        read_propeller([])


def test_a_changed_table_makes_another_aircraft_and_another_key_of_kept_results(tmp_path):
    table = ROWS + ".5,.09,.05,1200\n.9,.03,.03,1200\n"
    path = written(tmp_path, table)
    propeller = {"airframe.propulsion.propeller": {"table": str(path)}}
    before, again = (load_aircraft("twin-boom-design", propeller) for _ in range(2))
    written(tmp_path, table.replace(".09", ".1"))
    changed = load_aircraft("twin-boom-design", propeller)
    context = {"contents": True}
    assert before == again
    assert before != changed
    assert before.model_dump_json() == changed.model_dump_json()
    assert before.model_dump_json(context=context) == again.model_dump_json(context=context)
    assert before.model_dump_json(context=context) != changed.model_dump_json(context=context)
