from itertools import pairwise

import pytest
from builders import DESIGN, aircraft

import missions
import sizing
from studies.exchange.airplane import to_aerosandbox
from studies.exchange.files import design_bytes
from studies.render.design_sheet import design_sheet
from studies.report.geometry import Drawing
from studies.report.three_view import plot_three_view

TWIN = aircraft("twin-boom-design")
ANALYSIS = sizing.analyse(TWIN, missions.load_mission("rafz-july"), replay=False)


@pytest.mark.extra
def test_surfaces_have_the_areas_and_places_of_the_file():
    asb = pytest.importorskip("aerosandbox")
    airplane, planes = to_aerosandbox(TWIN, 0.13), ANALYSIS.balance.planes
    wing, horizontal, vertical = airplane.wings
    halves = (
        (out.xyz_le[1] - into.xyz_le[1]) * (into.chord + out.chord) / 2.0
        for into, out in pairwise(wing.xsecs)
    )
    assert 2.0 * sum(halves) == pytest.approx(25.0 / 15.0)
    quarters = [section.xyz_le[0] + 0.25 * section.chord for section in wing.xsecs]
    assert quarters == pytest.approx([quarters[0]] * len(quarters))
    tip = horizontal.xsecs[-1]
    assert 2.0 * tip.xyz_le[1] * tip.chord == pytest.approx(planes.horizontal_m2)
    assert tip.xyz_le[0] + 0.25 * tip.chord - quarters[0] == pytest.approx(planes.arm_m)
    root, end = vertical.xsecs
    # Two fins at the ends of the horizontal tail.
    assert vertical.symmetric
    assert root.xyz_le[1] == end.xyz_le[1] == pytest.approx(tip.xyz_le[1])
    height_m = end.xyz_le[2] - root.xyz_le[2]
    assert 2.0 * height_m * root.chord == pytest.approx(planes.vertical_m2)
    assert airplane.xyz_ref[0] == 0.13
    # At the polar's Reynolds number, not far from that of the flight.
    parasitic = ANALYSIS.drag_coefficients.parasitic
    told = airplane.analysis_specific_options[asb.AVL]["profile_drag_coefficient"]
    assert told == pytest.approx(parasitic, rel=0.02)


def test_files_carry_the_centre_of_gravity():
    gravity_m = ANALYSIS.balance.gravity_m
    script = design_bytes(ANALYSIS, "a.py").decode()
    assert f"xyz_ref=[{gravity_m:.6g}, 0, 0]" in script
    sheet = {entry.quantity.name: entry.value for entry in design_sheet(ANALYSIS).quantities}
    assert sheet["centre_of_gravity_m"] == pytest.approx(gravity_m)
    # The place of the battery in the file is to the millimetre, a 1/300 of the chord.
    assert sheet["static_margin"] == pytest.approx(0.1, abs=1e-3 / 0.3)
    plain = design_sheet(sizing.analyse(DESIGN, missions.load_mission("rafz-july"), replay=False))
    assert "static_margin" not in [entry.quantity.name for entry in plain.quantities]


def test_views_show_both_booms_and_the_taper():
    drawing = Drawing(TWIN)
    assert len(drawing.booms_m) == 2
    assert drawing.chord_at(2.5) == pytest.approx(0.6 * drawing.chord_at(0.0))
    assert drawing.front_at(0.0) == 0.0 < drawing.front_at(2.5)
    areas = [(m.right_m - m.left_m) * (m.rear_m - m.front_m) for m in drawing.modules]
    assert sum(areas) == pytest.approx(TWIN.modules.area_m2)
    for shown, fins in ((drawing, 2), (Drawing(DESIGN), 1)):
        above = plot_three_view(shown).axes[0]
        assert sum(line.get_gid() == "fin" for line in above.lines) == fins


@pytest.mark.slow
def test_a_report_has_drag_and_balance(run, tmp_path):
    target = tmp_path / "twin.html"
    assert run("report", "twin-boom-design", "--out", str(target)).code == 0
    text = target.read_text(encoding="utf-8")
    for words in ("Drag budget of level flight", "Balance, from the leading edge", "static margin"):
        assert words in text


@pytest.mark.slow
def test_a_sized_aircraft_tells_its_margin(run, tmp_path):
    """The sizing moves no mass: the analysis says what is left of the margin."""
    folder = str(tmp_path / "sized")
    arguments = ("twin-boom-design", "-m", "rafz-july", "--required-excess-time", "2")
    assert run("size", *arguments, "--out", folder).code == 0
    record = run("analyse", folder, "--json").json()
    sized = sizing.load_aircraft(f"{folder}/aircraft.yaml")
    known = sizing.analyse(sized, missions.load_mission("rafz-july"), replay=False).balance
    assert record["balance"]["static_margin"] == pytest.approx(known.static_margin, abs=1e-3)
