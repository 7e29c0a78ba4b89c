"""Tests of the geometry for other tools: AeroSandbox, AVL run on the file, OpenVSP."""

import math
import tempfile
from pathlib import Path

import pytest
from builders import AS2, DESIGN, SKY_SAILOR, aircraft

from studies.exchange.airplane import airplane_text, to_aerosandbox

pytestmark = pytest.mark.extra
AVL = pytest.importorskip("aerosandbox").AVL
optvl = pytest.importorskip("optvl")

AIRFOIL = aircraft(
    "atlantiksolar-design",
    "airframe.aerodynamics={model: wing_polar, airfoil: mh114, design_aspect_ratio: 18.5, "
    "design_reynolds: 150000}",
)
CASES = pytest.mark.parametrize("craft", [AS2, DESIGN, SKY_SAILOR, AIRFOIL], ids=lambda a: a.name)


def avl(craft, folder):
    """AVL with the exported file; its paths are short."""
    # A link that optvl left for an environment that is gone by now stands in its way.
    link = Path(tempfile.gettempdir()) / "optvl.libs"
    if link.is_symlink() and not link.exists():
        link.unlink(missing_ok=True)
    path = folder / "w.avl"
    path.write_text(airplane_text(craft, "avl"), encoding="utf-8")
    return optvl.OVLSolver(geo_file=str(path))


def lift_of_wing(solver, alpha_deg):
    """Lift coefficient of both halves of the wing."""
    solver.set_variable("alpha", alpha_deg)
    solver.execute_run()
    parts = solver.get_surface_forces()
    return sum(float(parts[name]["CL"]) for name in parts if "wing" in name)


@CASES
def test_airplane_has_the_dimensions_of_the_aircraft(craft):
    airplane = to_aerosandbox(craft)
    span, ratio = craft.airframe.wingspan_m, craft.airframe.aspect_ratio
    wing = airplane.wings[0]
    assert (airplane.b_ref, airplane.c_ref) == pytest.approx((span, span / ratio))
    assert airplane.s_ref == pytest.approx(span**2 / ratio)
    assert 2.0 * wing.xsecs[-1].xyz_le[1] == pytest.approx(span)
    assert all(section.chord == pytest.approx(span / ratio) for section in wing.xsecs)


@pytest.mark.long
@CASES
def test_avl_lifts_the_exported_wing_as_the_models_do(craft, tmp_path):
    solver = avl(craft, tmp_path)
    reference = solver.get_reference_data()
    span, ratio = craft.airframe.wingspan_m, craft.airframe.aspect_ratio
    assert reference["Bref"] == pytest.approx(span)
    assert reference["Sref"] == pytest.approx(span**2 / ratio)
    slope = (lift_of_wing(solver, 2.0) - lift_of_wing(solver, -2.0)) / math.radians(4.0)
    # The models take the lifting line of an elliptic wing. A rectangle with a real chord lifts
    # less: lifting surfaces of aspect ratio 13 to 19 by 4 to 7 %.
    assert 0.93 <= slope / (2.0 * math.pi * ratio / (ratio + 2.0)) <= 0.97
    # Wings without dihedral lift along a straight line.
    middle = lift_of_wing(solver, 0.0)
    assert middle == pytest.approx(
        0.5 * (lift_of_wing(solver, 2.0) + lift_of_wing(solver, -2.0)), abs=0.005
    )


@pytest.mark.long
def test_avl_sees_camber_incidence_and_drag(tmp_path):
    # 5.7 degrees of incidence carry a symmetric wing at no angle of attack, and camber adds to it:
    # about 7 degrees of zero lift angle for an airfoil with 6.6 % of camber.
    plain, cambered = avl(DESIGN, tmp_path), avl(AIRFOIL, tmp_path)
    slope = math.radians(1.0) * 5.4
    assert lift_of_wing(plain, 0.0) == pytest.approx(5.7 * slope, rel=0.05)
    assert 6.0 * slope < lift_of_wing(cambered, 0.0) - lift_of_wing(plain, 0.0) < 10.0 * slope
    polar = DESIGN.airframe.aerodynamics
    lift_of_wing(plain, 0.0)
    viscous = plain.get_total_forces()["CDv"]
    expected = polar.profile_drag_coefficient + polar.parasitic_drag_coefficient
    # AVL counts the true area of the raised tips: 1/cos(6 deg), 0.6 %, on half of the wing.
    assert expected < viscous < 1.003 * expected


def test_the_script_makes_the_same_airplane():
    for craft in (AIRFOIL, SKY_SAILOR):
        space = {}
        exec(airplane_text(craft, "py"), space)  # a script of our own
        made, direct = space["airplane"], to_aerosandbox(craft)
        assert (made.name, made.s_ref, made.c_ref, made.b_ref) == (
            direct.name,
            pytest.approx(direct.s_ref, rel=1e-5),
            pytest.approx(direct.c_ref, rel=1e-5),
            pytest.approx(direct.b_ref, rel=1e-5),
        )
        for wing, expected in zip(made.wings, direct.wings, strict=True):
            assert (wing.name, wing.symmetric) == (expected.name, expected.symmetric)
            for a, b in zip(wing.xsecs, expected.xsecs, strict=True):
                assert list(a.xyz_le) == pytest.approx(list(b.xyz_le), abs=1e-5)
                assert (a.chord, a.twist) == pytest.approx((b.chord, b.twist), rel=1e-5)
                assert a.airfoil.max_thickness() == pytest.approx(b.airfoil.max_thickness())


def test_names_mean_nothing_in_scripts():
    craft = DESIGN.model_copy(update={"name": '"); import os # \\ \u00e9'})
    for kind in ("avl", "vspscript", "py"):
        text = airplane_text(craft, kind)
        assert text.isascii()
        assert "; import os" not in text


def test_surfaces_say_where_their_numbers_come_from():
    script = airplane_text(AS2, "py")
    assert "no drag polar" in script
    assert "# Section: symmetric" in script
    plain, cambered = (
        to_aerosandbox(craft).wings[0].analysis_specific_options[AVL]["drag_polar"]
        for craft in (AS2, AIRFOIL)
    )
    assert [plain[f"CD{i}"] for i in (1, 2, 3)] == [0.0] * 3
    assert to_aerosandbox(AS2).analysis_specific_options[AVL]["profile_drag_coefficient"] == 0.0
    assert "# Section: mh114" in airplane_text(AIRFOIL, "py")
    lifts, drags = ([cambered[f"{name}{i}"] for i in (1, 2, 3)] for name in ("CL", "CD"))
    assert lifts == sorted(lifts)
    assert drags[1] == min(drags)
