"""Polars of XFOIL and XFLR5: formats, units, and the line of every mistake."""

import math
import re
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from missions.files.errors import InputError
from missions.files.texts import read_text, texts_as_read
from sizing.aerodynamics.airfoil_polar import AirfoilPolar
from sizing.aerodynamics.polar_files import FilePolar, PolarRow, read_polars, reading_notes
from sizing.aerodynamics.polar_table import (
    POLAR_SUFFIXES,
    PolarTable,
    WingReference,
    _is_fixed,
    parse_polar,
)
from sizing.aerodynamics.wing_polar import WingPolar
from sizing.library import load_aircraft

ANGLES = tuple(float(alpha) for alpha in np.arange(-4.0, 12.01, 1.0))
REYNOLDS = (60e3, 100e3, 200e3, 400e3, 800e3)
# The wing: XFLR5's standard viscosity, and a span efficiency.
CHORD_M, ASPECT_RATIO, VISCOSITY, SPAN_EFFICIENCY = 0.3, 18.0, 1.5e-5, 0.95


def lift(alpha_deg):
    """Lift coefficient, 0.1 per degree with a soft stall that does not depend on Re."""
    return 0.4 + 0.1 * alpha_deg - 2e-5 * max(alpha_deg, 0.0) ** 4


def drag(cl, reynolds):
    """Parabolic drag with a power of the Reynolds number."""
    return (0.008 + 0.004 * (cl - 0.5) ** 2) * (reynolds / 2e5) ** -0.4


def induced(cl):
    """Induced drag of the wing."""
    return cl**2 / (math.pi * ASPECT_RATIO * SPAN_EFFICIENCY)


def section(
    reynolds,
    *,
    program="       XFOIL         Version 6.99",
    name="FORMULA 12",
    kind=1,
    commas=False,
    mach=0.0,
    ncrit=9.0,
    angles=ANGLES,
):
    """Polar of the section; ``reynolds`` is that at C_L = 1 for kind 2."""
    types = {1: "1 1 Reynolds number fixed          Mach number fixed         "}
    types[2] = "2 1 Reynolds number ~ 1/sqrt(CL)   Mach number fixed         "
    lines = [
        "  ",
        program,
        "  ",
        f" Calculated polar for: {name:<40}",
        "  ",
        f" {types[kind]}",
        "  ",
        " xtrf =   1.000 (top)        1.000 (bottom)  ",
        f" Mach = {mach:7.3f}     Re = {reynolds / 1e6:9.3f} e 6     Ncrit = {ncrit:7.3f}",
        "  ",
    ]
    if commas:
        lines.append("alpha,CL,CD,CDp,Cm,Top Xtr,Bot Xtr,Cpmin,Chinge,XCp")
    else:
        lines.append("   alpha    CL        CD       CDp       CM     Top_Xtr  Bot_Xtr")
        lines.append("  ------ -------- --------- --------- -------- -------- --------")
    for alpha in angles:
        cl = lift(alpha)
        if kind == 2 and cl <= 0.0:
            continue
        re = reynolds if kind == 1 else reynolds / math.sqrt(cl)
        cd = drag(cl, re)
        if commas:
            first = f"{alpha:8.3f},{cl:8.4f},{cd:9.6f},{cd / 3:9.6f},{-0.05:8.4f}"
            lines.append(f"{first},  0.6000,  0.9000, -1.5000,  0.0000,  0.2500")
        else:
            first = f"{alpha:8.3f}{cl:9.4f}{cd:10.6f}{cd / 3:10.6f}{-0.05:9.4f}"
            lines.append(f"{first}{0.6:9.4f}{0.9:9.4f}")
    return "\n".join([*lines, "", ""])


def wing(
    speed_m_per_s,
    *,
    word="Wing",
    unit="m/s",
    per_unit=1.0,
    commas=False,
    fixed_lift=False,
    early=False,
    sideslip=False,
    angles=ANGLES,
):
    """Polar of the wing; ``speed_m_per_s`` is that at C_L = 1 for fixed lift."""
    comma = "," if commas else ""
    named = "Wing polar" if word == "Wing" else "Polar"
    speed = speed_m_per_s / per_unit
    lines = [
        "xflr5 v5.02" if early else "xflr5 v6.47",
        "",
        f"{word} name :{comma}        Formula wing",
        f"{named} name :{comma}  {'T2' if fixed_lift else 'T1'}-{speed:.1f} {unit}-LLT",
        "" if fixed_lift else f"Freestream speed :{comma} {speed:7.3f} {unit}",
        "",
    ]
    columns = ["alpha", "CL", "ICd", "PCd", "TCd", "CY", "GCm", "GRm", "GYm", "IYm", "QInf", "XCP"]
    if not early:
        columns = ["alpha", "CL", "CDi", "CDv", "CD", "CY", "Cl", "Cm", "Cn", "Cni", "QInf", "XCP"]
    if sideslip:
        columns.insert(1, "Beta")
    lines.append((", " if commas else "       ").join(columns))
    if early:
        lines.append((",  " if commas else "  ").join(["_________"] * len(columns)))
    for alpha in angles:
        cl = lift(alpha)
        if fixed_lift and cl <= 0.0:
            continue
        at = speed_m_per_s / math.sqrt(cl) if fixed_lift else speed_m_per_s
        viscous = drag(cl, at * CHORD_M / VISCOSITY)
        values = [alpha, cl, induced(cl), viscous, induced(cl) + viscous]
        values += [0.0, 0.0, -0.05, 0.0, 0.0]
        values += [at / per_unit, 0.08]
        if sideslip:
            values.insert(1, 0.0)
        lines.append((",  " if commas else "  ").join(f"{value:9.6f}" for value in values))
    return "\n".join([*lines, "", ""])


REFERENCE = WingReference(CHORD_M, ASPECT_RATIO, VISCOSITY)
SPEEDS = tuple(re * VISCOSITY / CHORD_M for re in REYNOLDS)
XFLR5 = "xflr5 v6.47"


def sections(**changes):
    return "".join(section(re, **changes) for re in REYNOLDS)


def wings(**changes):
    return "".join(wing(speed, **changes) for speed in SPEEDS)


def deviation(table):
    """Largest relative difference of the drag to the formula that the polars are made from."""
    columns = table.columns
    expected = [drag(cl, re) for cl, re in zip(columns["cl"], columns["reynolds"], strict=True)]
    return float(np.max(np.abs(columns["cd"] / expected - 1.0)))


def too_wide(program):
    """XFLR5 6.61 names Cpmin, Chinge and XCp over five columns."""
    text = sections(program=program).replace("Bot_Xtr\n", "Bot_Xtr   Cpmin  Chinge   XCp\n")
    return text.replace("   0.9000\n", "   0.9000  -1.5   0.0   0.0   0.0   0.25\n")


def of_a_site(reynolds, head="Mach,0"):
    """Polar as airfoiltools.com returns CSV."""
    rows = "".join(
        f"{alpha:.3f},{lift(alpha):.4f},{drag(lift(alpha), reynolds):.6f},0.01,-0.05,0.6,0.9\n"
        for alpha in ANGLES
    )
    return (
        "Xfoil polar. Reynolds number fixed. Mach  number fixed\nPolar key,xf-formula-il\n"
        f"Airfoil,formula-il\nReynolds number,{reynolds:.0f}\nNcrit,9\n{head}\nMax Cl/Cd,57.1\n"
        "Max Cl/Cd alpha,5.5\nUrl,http://airfoiltools.com/polar/csv?polar=xf-formula-il\n\n"
        f"Alpha,Cl,Cd,Cdp,Cm,Top_Xtr,Bot_Xtr\n{rows}"
    )


# ---- Sections


@pytest.mark.parametrize("commas", [False, True])
@pytest.mark.parametrize("program", ["       XFOIL         Version 6.99", XFLR5])
def test_polars_of_a_section_make_a_table(program, commas):
    table = parse_polar(sections(program=program, commas=commas), "e.txt")
    assert table.name == "FORMULA 12"
    assert table.header["source"] == " ".join(program.split())
    assert len(table.columns["cl"]) == len(REYNOLDS) * len(ANGLES)
    assert np.unique(table.columns["reynolds"]) == pytest.approx(REYNOLDS)
    # Six decimals of drag.
    assert deviation(table) < 1e-3
    polar = AirfoilPolar.from_table(table)
    assert polar.profile_drag(0.7, 150e3) == pytest.approx(drag(0.7, 150e3), rel=5e-3)


def test_what_stands_in_the_header_is_read():
    (polar,) = read_polars(section(123e3, mach=0.05, ncrit=7.0, kind=2), "polar.txt")
    assert polar.reynolds == pytest.approx(123e3)
    assert (polar.mach, polar.ncrit, polar.trip) == (0.05, 7.0, (1.0, 1.0))
    assert (polar.kind, polar.reynolds_type, polar.line) == ("section", 2, 4)
    first = polar.rows[0]
    assert (first.line, first.alpha_deg) == (13, -3.0)
    assert first.lift == pytest.approx(lift(-3.0), abs=1e-4)


def test_other_ways_to_write_a_header_and_a_row():
    text = section(200e3)
    for old, new in (
        ("Re =     0.200 e 6", "Re =   200000"),
        ("Ncrit =   9.000", "Ncrit =   9.000  9.000"),
        ("\n", "\r\n"),
    ):
        (polar,) = read_polars(text.replace(old, new), "polar.txt")
        assert polar.reynolds == pytest.approx(200e3)
        assert len(polar.rows) == len(ANGLES)
    # A sign follows digits at once where a Fortran field is full; further columns are passed over.
    row = "   5.000   0.8875  0.010602 0.003534-10.0500   0.6000   0.9000"
    assert row.replace("-10.0500", "  -0.0500") != row
    (polar,) = read_polars(re.sub(r"\n {3}5\.000.*", f"\n{row}", text), "polar.txt")
    assert [r.moment for r in polar.rows if r.alpha_deg == 5.0] == [-10.05]
    wide = text.replace("Bot_Xtr\n", "Bot_Xtr  Top_Itr  Bot_Itr\n").replace(
        "   0.9000\n", "   0.9000  20.0000  90.0000\n"
    )
    assert len(read_polars(wide, "polar.txt")[0].rows) == len(ANGLES)


def test_points_that_did_not_converge_are_passed_over():
    text = section(200e3)
    for wrong in ("NaN", "*********", "inf"):
        (polar,) = read_polars(re.sub(r"(\n {3}3\.000 +)\S+", rf"\g<1>{wrong}", text), "p.txt")
        assert len(polar.rows) == len(ANGLES) - 1
        assert 3.0 not in [row.alpha_deg for row in polar.rows]


def test_the_same_point_twice_counts_once():
    text = section(200e3).rstrip("\n")
    (polar,) = read_polars(f"{text}\n{text.splitlines()[-1]}\n", "p.txt")
    assert len(polar.rows) == len(ANGLES)


def test_polars_at_fixed_lift_are_resampled():
    text = "".join(section(re, kind=2) for re in np.geomspace(40e3, 1e6, 9))
    table = parse_polar(text, "t2.txt")
    reynolds = np.unique(table.columns["reynolds"])
    assert len(reynolds) >= 4
    # Drag follows a power of Re and lift none of it, so that the interpolation adds nothing: what
    # remains is the rounding of six decimals.
    assert deviation(table) < 2e-3
    polar = AirfoilPolar.from_table(table)
    middle = float(np.sqrt(reynolds[0] * reynolds[-1]))
    assert polar.profile_drag(0.7, middle) == pytest.approx(drag(0.7, middle), rel=1e-2)
    assert polar.maximum_lift(middle) == pytest.approx(max(map(lift, ANGLES)), rel=1e-2)
    wing_polars = "".join(wing(v, fixed_lift=True) for v in np.geomspace(2.0, 50.0, 9))
    wing_table = parse_polar(wing_polars, "wing.txt", REFERENCE)
    assert deviation(wing_table) < 2e-3
    assert len(np.unique(wing_table.columns["reynolds"])) >= 4


# ---- Wings


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"commas": True},
        {"word": "Plane", "sideslip": True},
        {"word": "Plane", "sideslip": True, "commas": True},
        {"early": True},
        {"early": True, "commas": True},
        {"unit": "km/h", "per_unit": 1.0 / 3.6},
        {"unit": "kts", "per_unit": 0.514444},
        {"unit": "ft/s", "per_unit": 0.3048, "commas": True},
        {"unit": "mph", "per_unit": 0.44704},
    ],
    ids=str,
)
def test_polars_of_a_wing_give_viscous_drag_and_span_efficiency(changes):
    table = parse_polar(wings(**changes), "wing.txt", REFERENCE)
    # Speeds have three decimals.
    assert np.unique(table.columns["reynolds"]) == pytest.approx(REYNOLDS, rel=1e-3)
    assert deviation(table) < 2e-3
    assert table.span_efficiency == pytest.approx(SPAN_EFFICIENCY, rel=2e-3)


def of_wing(folder):
    """Keys of an aircraft's drag by a file with polars of its wing."""
    path = folder / "wing.txt"
    path.write_text(wings(), encoding="utf-8")
    size = {"wing_chord_m": CHORD_M, "wing_aspect_ratio": ASPECT_RATIO}
    point = {"design_aspect_ratio": ASPECT_RATIO, "design_reynolds": 150e3}
    return {"model": "wing_polar", "airfoil": str(path)} | size | point


def test_an_aircraft_flies_on_the_polars_of_a_wing(tmp_path):
    data = of_wing(tmp_path) | {"tail_area_ratio": 0.0, "fuselage_wetted_area_ratio": 0.0}
    polar = WingPolar.model_validate(data)
    assert polar.section_lift_ratio == 1.0
    assert polar.span_efficiency == pytest.approx(SPAN_EFFICIENCY, rel=2e-3)
    for cl in (0.4, 0.7, 1.0):
        # Drag of the whole wing as XFLR5 has it, at the aspect ratio that it computed.
        whole = drag(cl, 150e3) + cl**2 / (math.pi * ASPECT_RATIO * SPAN_EFFICIENCY)
        assert polar.drag_at(cl, ASPECT_RATIO, 150e3) == pytest.approx(whole, rel=5e-3)
    # What the polars give does not count as given; a value of the file wins.
    assert "span_efficiency" not in polar.model_fields_set
    assert WingPolar.model_validate(data | {"span_efficiency": 0.9}).span_efficiency == 0.9
    text, path = polar.contents_read(), tmp_path / "wing.txt"
    path.unlink()
    with texts_as_read({str(path): text or ""}):
        assert WingPolar.model_validate(data) == polar


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"wing_chord_m": None}, "goes with wing_chord_m"),
        ({"wing_aspect_ratio": None}, "goes with wing_aspect_ratio"),
        ({"section_lift_ratio": 1.05}, "must be 1 with polars of a wing"),
        ({"airfoil": "sd7037"}, "holds polars of a section"),
        ({"wing_aspect_ratio": 6.0}, "span efficiency of 2.8"),
        ({"wing_chord_m": "0.3"}, "valid number"),
    ],
)
def test_what_does_not_go_with_a_wing_is_refused(tmp_path, changes, words):
    with pytest.raises(ValidationError, match=words):
        WingPolar.model_validate(of_wing(tmp_path) | changes)


# ---- Mistakes


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "   2.000   0.5997",
            "   2.000  59.9700",
            ":19: CL must be from -12.57 to 12.57 (got 59.97)",
        ),
        ("  0.008040", "  0.000000", ":17: CD must be above 0 and below 10 (got 0)"),
    ],
)
def test_a_single_row_that_no_section_has_is_left_out(old, new, words):
    text = section(200e3).replace(old, new, 1)
    (polar,) = read_polars(text, "polar.txt")
    assert len(polar.rows) == len(ANGLES) - 1
    assert reading_notes([polar]) == (f"1 row is left out: polar.txt{words}",)


PLAIN = section(2e5)
LAST_ROW = PLAIN.rstrip("\n").splitlines()[-1]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("Re =     0.200 e 6", "Re =     0.000 e 6", r":9: Re must be .*an inviscid polar"),
        ("Re =     0.200 e 6", "Re =     0.200 e 99", r":9: Re must be from 1000"),
        ("Mach =   0.000", "Mach =   0.600", r":9: Mach must be from 0 to 0\.3 \(got 0\.6\)"),
        (" 1 1 Reynolds number fixed", " 3 1 Reynolds number ~ 1/CL", r":6: .*type 3"),
        (" Mach =", " Nach =", r":4: the header has no line 'Mach"),
        ("   CD    ", "   CX    ", r":11: the columns lack CD"),
        ("   alpha    CL", "   omega    CL", r":4: no line of column names"),
        ("   2.000   0.5997", "   2.000   0.5997 banana", r":19: 7 numbers are needed"),
        ("   2.000   0.5997", "   2.000", r":19: 7 numbers are needed"),
        ("   2.000   0.5997", " 200.000   0.5997", r":19: alpha must be"),
        # Two of seventeen are more than one in twelve.
        ("(  2.000   )0.5997(.*\n .*3.000   )0.6984", r"\g<1>9.9e1\2 69.84", r":20: CL must be"),
        (
            rf"{LAST_ROW}\n",
            f"{LAST_ROW}\n{LAST_ROW.replace(f'{lift(12.0):9.4f}', '   1.0000')}\n",
            r":30: alpha 12 as in line 29, with other values",
        ),
    ],
)
def test_every_mistake_has_its_line(old, new, words):
    text, changes = re.subn(old, new, PLAIN, count=1)
    assert changes
    with pytest.raises(InputError, match=rf"polar\.txt{words}"):
        read_polars(text, "polar.txt")


@pytest.mark.parametrize(
    ("text", "reference", "words"),
    [
        (section(1e5) + section(1e5), None, r"p:34: Reynolds number 100000 as in p:4"),
        (section(1e5) + section(2e5, name="B"), None, r"p:34: polar of B, but p:4 is of FORMULA"),
        (section(1e5) + section(2e5, mach=0.1), None, r"p:34: Mach 0\.1, but 0 in p:4"),
        (section(1e5) + section(2e5, ncrit=5.0), None, r"p:34: Ncrit 5, but 9 in p:4"),
        (section(1e5) + section(2e5, kind=2), None, r"p:34: polars of fixed speed and of fixed l"),
        (section(1e5, kind=2) + section(1.6e5, kind=2), None, r"at least 2\.5 times"),
        (wing(8.0, unit="furlongs"), REFERENCE, r"p:5: the unit .* must be one of m/s.*furlongs"),
        (wing(8.0).replace("CDi", "CDx"), REFERENCE, r"p:7: the columns lack CDI"),
        (section(1e5, angles=()), None, r"p:4: no point of this polar converged"),
        ("xflr5 v6.47\n", None, r"p: holds no polar"),
        (wings(), None, r"p:3: is the polar of a whole wing"),
        (sections(), REFERENCE, "holds polars of a section"),
        ("# airfoil: a\n# source: b\n", REFERENCE, "holds polars of a section"),
        (sections() + wings(), REFERENCE, "of an airfoil and of a wing mixed"),
        (too_wide("XFOIL   Version 6.99"), None, "10 numbers are needed"),
        (of_a_site(1e5, "Mach,x"), None, "p:6: mach must be a number"),
        (of_a_site(1e5, "Mach,0.5"), None, "p:6: Mach must be from 0"),
    ],
)
def test_polars_that_do_not_belong_together(text, reference, words):
    with pytest.raises(InputError, match=words):
        parse_polar(text, "p", reference)


def test_columns_of_xflr5_are_taken_from_the_left():
    table = parse_polar(too_wide("xflr5 v6.61"), "p")
    assert deviation(table) < 1e-4
    assert table.notes == (
        "XFLR5 writes 12 numbers under 10 names: columns are taken by their place from the left",
    )


def test_csv_of_an_airfoil_site_is_read(tmp_path):
    for re_ in REYNOLDS:
        (tmp_path / f"{re_:.0f}.csv").write_text(of_a_site(re_), encoding="utf-8")
    table = parse_polar(read_text(f"{tmp_path}/", POLAR_SUFFIXES), f"{tmp_path}/")
    assert sorted(set(table.columns["reynolds"])) == list(REYNOLDS)
    assert table.name == "formula-il"
    # Four digits of the lift coefficient.
    assert deviation(table) < 1e-4


def test_fine_steps_that_scatter_are_the_same_polar():
    """At 0.1 degree lift rises by 0.01 a step, and scatters by 0.01 from row to row."""
    polars = []
    for step, scatter in ((0.1, 0.005), (0.5, 0.0)):
        angles = np.arange(-4.0, 12.01, step)
        rows = [
            (alpha, reynolds, lift(alpha) + scatter * (-1) ** i, drag(lift(alpha), reynolds))
            for reynolds in REYNOLDS
            for i, alpha in enumerate(angles)
        ]
        columns = dict(zip(("alpha_deg", "reynolds", "cl", "cd"), np.array(rows).T, strict=True))
        polars.append(AirfoilPolar.from_table(PolarTable("p", {"airfoil": "p"}, columns)))
    fine, coarse = polars
    for reynolds in (7e4, 2e5, 6e5):
        # The scatter itself, and that of the drag at a lift so much off: 0.1 % here.
        peak = coarse.maximum_lift(reynolds)
        assert fine.maximum_lift(reynolds) == pytest.approx(peak, abs=0.006)
        for cl in (0.3, 0.6, 0.8):
            expected = pytest.approx(coarse.profile_drag(cl, reynolds), rel=2e-3)
            assert fine.profile_drag(cl, reynolds) == expected


@pytest.mark.parametrize(("other", "fixed"), [(5.0, True), (5.01, True), (5.05, False)])
def test_speeds_that_differ_by_their_last_digit_are_one(other, fixed):
    # Two digits behind the point, of a slow wing; a per cent is another speed.
    rows = [
        PolarRow(line, 1.0 * line, 0.1 * line, 0.02, 0.0, speed_m_per_s=speed)
        for line, speed in enumerate((5.0, other, 5.0), start=8)
    ]
    assert _is_fixed(FilePolar("p", 5, "wing", "a wing", XFLR5, rows=rows)) is fixed


def test_all_mistakes_are_listed_in_the_aircrafts_message(tmp_path):
    text = sections().replace("   3.000   0.6984", "   3.000   banana")
    (tmp_path / "polar.txt").write_text(text, encoding="utf-8")
    aerodynamics = {
        "model": "wing_polar",
        "airfoil": str(tmp_path / "polar.txt"),
        "design_aspect_ratio": 18.5,
        "design_reynolds": 158e3,
    }
    with pytest.raises(InputError) as caught:
        load_aircraft("atlantiksolar-design", {"airframe.aerodynamics": aerodynamics})
    lines = [p.line for p in caught.value.problems if p.source.endswith("polar.txt")]
    assert lines == [20, 50, 80, 110, 140]
    (problem,) = (p for p in caught.value.problems if not p.source.endswith("polar.txt"))
    assert "airfoil" in problem.key
    assert "5 mistakes" in problem.message


def test_a_folder_of_polars_is_one_table(tmp_path):
    folder = tmp_path / "polars"
    folder.mkdir()
    for re_ in REYNOLDS:
        name = f"T1_Re{re_ / 1e6:.3f}_M0.00_N9.0.txt"
        (folder / name).write_text(section(re_, program=XFLR5), encoding="utf-8")
    (folder / "notes.md").write_text("not a polar", encoding="utf-8")
    path = f"{folder}/"
    text = read_text(path, POLAR_SUFFIXES)
    table = parse_polar(text, path)
    assert np.unique(table.columns["reynolds"]) == pytest.approx(REYNOLDS)
    # As one file, which a folder of results holds, it is the same.
    assert parse_polar(text, "polar.txt").columns["cd"] == pytest.approx(table.columns["cd"])
    wrong = folder / "T1_Re0.100_M0.00_N9.0.txt"
    wrong.write_text(section(1e5).replace("   3.000   0.6984", "   3.000   0.6984 x"))
    with pytest.raises(InputError, match=r"polars/T1_Re0\.100_M0\.00_N9\.0\.txt:20: 7 numbers"):
        parse_polar(read_text(path, POLAR_SUFFIXES), path)
    wrong.write_text("angle,lift\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"N9\.0\.txt:1: holds no polar"):
        parse_polar(read_text(path, POLAR_SUFFIXES), path)
    for file in folder.iterdir():
        file.unlink()
    with pytest.raises(InputError, match=r"has no files of that kind \(\.csv, \.txt"):
        read_text(path, POLAR_SUFFIXES)


ALL = section(2e5) + wing(8.0, commas=True)


@given(
    st.integers(0, len(ALL) - 1),
    st.integers(0, 60),
    st.text(max_size=12) | st.sampled_from(["e999", "-", "*" * 9, "nan", "\n\n", ",,,", "9" * 400]),
)
def test_damaged_files_are_read_or_refused_with_a_line(at, cut, put):
    text = ALL[:at] + put + ALL[at + cut :]
    for wing_or_not in (None, REFERENCE):
        with suppress(InputError):
            table = parse_polar(text, "p", wing_or_not)
            assert np.isfinite(table.columns["cd"]).all()
            assert (table.columns["reynolds"] > 0.0).all()
