"""Shadows of the tail: by hand on a level wing, by ray casting on a real one, and their losses."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from solar.geometry import ModuleGeometry, ModuleOutline, ModuleSurface, direction_cosines
from solar.shading import (
    LOSS_MODELS,
    TailGeometry,
    apply_losses,
    elevation_free_of_shading_deg,
    loss_model,
    proportional_losses,
    register_loss_model,
    shaded_area,
    shaded_fraction,
    string_losses,
)
from solar.shadows import module_frame


def outline_corners(surface, geometry):
    return module_frame(surface, geometry).corners()


# Polygons are exact but for rounding, a few units in the last place of a metre.
ROUNDING = 1e-12

# The level wing: one module two metres wide, and a T-tail of which the fin is as good as nothing.
REAR, HEIGHT, AFT, SPAN, CHORD = 0.3, 0.4, 1.5, 0.8, 0.2


def level_wing(**outline):
    sides = {"inboard_m": -1.0, "outboard_m": 1.0, "front_m": 0.0, "rear_m": REAR} | outline
    return ModuleGeometry(
        surfaces=(
            ModuleSurface(
                name="wing", area_m2=2.0 * REAR, side="centre", outline=ModuleOutline(**sides)
            ),
        )
    )


def t_tail(**changes):
    values = {
        "horizontal_span_m": SPAN,
        "horizontal_chord_m": CHORD,
        "horizontal_aft_m": AFT,
        "vertical_height_m": HEIGHT,
        "vertical_chord_m": 1e-6,
        "vertical_aft_m": AFT,
    }
    return TailGeometry(**(values | changes))


def atlantiksolar():
    """Six modules of 20 and 12 cells of 0.125 m; angles and areas from table 1 of the report."""
    outer, centre = (1.27, 2.77, 0.184, 6.0), (-1.25, 1.25, 0.307, 0.0)
    surfaces = [
        {
            **{"name": f"{side} {row}", "area_m2": area, "side": side},
            "outline": {
                **{"inboard_m": inboard, "outboard_m": outboard},
                **{"front_m": front, "rear_m": front + 0.125},
            },
            **{"dihedral_deg": dihedral, "pitch_deg": pitch},
        }
        for side, (inboard, outboard, area, dihedral) in zip(
            ("left", "centre", "right"), (outer, centre, outer), strict=True
        )
        for row, front, pitch in (("front", 0.025, -0.5), ("rear", 0.155, 9.4))
    ]
    return ModuleGeometry.model_validate({"wing_incidence_deg": 5.7, "surfaces": surfaces})


ATLANTIKSOLAR = atlantiksolar()
TAIL = TailGeometry(
    horizontal_span_m=0.87,
    horizontal_chord_m=0.173,
    horizontal_aft_m=1.253,
    vertical_height_m=0.30,
    vertical_chord_m=0.065,
    vertical_aft_m=1.280,
    boom_height_m=0.0,
)
AREAS = np.array([surface.area_m2 for surface in ATLANTIKSOLAR.surfaces])


def sun_from(elevation_deg, azimuth_deg=180.0):
    """Unit vectors to the sun, body axes; azimuth from the nose, clockwise seen from above."""
    e, a = np.broadcast_arrays(np.radians(elevation_deg), np.radians(azimuth_deg))
    return np.stack((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), -np.sin(e)), axis=-1)


def rays_hit(points, sun, rectangle):
    """Whether rays from the points towards the sun meet a rectangle given by its corners."""
    first, second = rectangle[1] - rectangle[0], rectangle[3] - rectangle[0]
    offsets = np.linalg.solve(np.stack((first, second, -sun), axis=1), (points - rectangle[0]).T)
    inside = (offsets[:2] >= 0.0) & (offsets[:2] <= 1.0)
    return np.asarray(inside.all(axis=0) & (offsets[2] > 0.0))


def cast_rays(geometry, tail, sun, rotation, cells=(400, 120)):
    """Shaded fractions by ray casting, everything but the sun turned by ``rotation`` first."""
    u, v = np.meshgrid(*[(np.arange(n) + 0.5) / n for n in cells], indexing="ij")
    fractions = []
    panels = [panel @ rotation.T for panel in tail.panels()]
    for surface, normal in zip(geometry.surfaces, geometry.normals(), strict=True):
        a, b, _, d = outline_corners(surface, geometry) @ rotation.T
        points = a + u.reshape(-1, 1) * (b - a) + v.reshape(-1, 1) * (d - a)
        hits = np.any([rays_hit(points, sun, panel) for panel in panels], axis=0)
        fractions.append(hits.mean() if sun @ (rotation @ normal) > 0.0 else 0.0)
    return np.array(fractions)


# Level wing, by hand.


@pytest.mark.parametrize("elevation_deg", [8.0, 14.5, 16.0, 17.0, 18.4, 18.5, 40.0])
def test_shadow_of_the_horizontal_tail_moves_forward_by_height_over_tangent(elevation_deg):
    front = AFT - HEIGHT / np.tan(np.radians(elevation_deg))
    length = max(0.0, min(front + CHORD, REAR) - max(front, 0.0))
    result = shaded_area(level_wing(), t_tail(), sun_from(elevation_deg))
    assert result == pytest.approx([SPAN * length], abs=ROUNDING)


@pytest.mark.parametrize(("aft_m", "azimuth_deg"), [(0.35, 210.0), (-0.45, 30.0)])
def test_shadow_of_the_vertical_tail_under_a_slanting_sun(aft_m, azimuth_deg):
    # Sun 30 degrees off the tail: at each chordwise position the shadow is chord * tan(30) wide,
    # and it reaches beyond the wing.
    fin = t_tail(
        vertical_height_m=1.0, vertical_chord_m=0.1, vertical_aft_m=aft_m, horizontal_height_m=50.0
    )
    result = shaded_area(level_wing(), fin, sun_from(45.0, azimuth_deg))
    assert result == pytest.approx([REAR * 0.1 * np.tan(np.radians(30.0))], abs=ROUNDING)


def test_module_under_the_tail_is_shaded_by_the_sun_overhead():
    geometry = level_wing(front_m=AFT - 0.1, rear_m=AFT + 0.2)
    expected = SPAN * CHORD / 0.6
    assert shaded_fraction(geometry, t_tail(), [0.0, 0.0, -1.0]) == pytest.approx([expected])
    roof = t_tail(horizontal_span_m=9.0, horizontal_chord_m=9.0, horizontal_aft_m=-4.0)
    areas = shaded_area(ATLANTIKSOLAR, roof, [0.0, 0.0, -1.0])
    assert areas == pytest.approx(AREAS, rel=ROUNDING)
    # Never more than the whole, by which models of losses would be refused.
    sky = t_tail(horizontal_span_m=90.0, horizontal_chord_m=90.0, horizontal_aft_m=-40.0)
    assert shaded_fraction(ATLANTIKSOLAR, sky, sun_from(np.linspace(5, 89, 99), 30.0)).max() == 1.0


def test_sun_or_tail_where_there_is_no_shade():
    # The sun overhead, behind the module or in its plane; a tail below it.
    assert not shaded_area(ATLANTIKSOLAR, TAIL, [0.0, 0.0, -1.0]).any()
    suns = sun_from([-90.0, -16.0, 0.0, 0.05], 180.0)
    assert not shaded_area(level_wing(), t_tail(), suns).any()
    hanging = t_tail(vertical_height_m=-HEIGHT, boom_height_m=-0.01)
    suns = sun_from(np.linspace(-90.0, 90.0, 181), 180.0)
    assert not shaded_area(level_wing(), hanging, suns).any()
    assert elevation_free_of_shading_deg(level_wing(), hanging) == 0.0


# AtlantikSolar, against rays.

REAL_SUNS = [(6.0, 184.0), (10.0, 200.0), (14.0, 178.5), (14.1, 211.0), (9.0, 150.0), (17.0, 165.0)]


@pytest.mark.parametrize(("elevation_deg", "azimuth_deg"), REAL_SUNS)
@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.3, -1.1, 2.0)])
def test_agrees_with_ray_casting_in_any_frame(elevation_deg, azimuth_deg, angles):
    sun = sun_from(elevation_deg, azimuth_deg)
    rotation = Rotation.from_euler("xyz", angles).as_matrix()
    result = shaded_fraction(ATLANTIKSOLAR, TAIL, sun)
    assert result.any()
    expected = cast_rays(ATLANTIKSOLAR, TAIL, rotation @ sun, rotation)
    # The one per cent is asked for; a row of the 400 by 120 points is below it.
    assert result == pytest.approx(expected, abs=0.01)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_agrees_with_ray_casting_for_odd_tails(seed):
    # Tails of any position and size, also across the planes of the modules.
    rng = np.random.default_rng(seed)
    tail = TailGeometry(
        horizontal_span_m=rng.uniform(1.0, 5.0),
        horizontal_chord_m=rng.uniform(0.3, 1.5),
        horizontal_aft_m=rng.uniform(-1.0, 0.5),
        vertical_height_m=rng.uniform(0.5, 2.0),
        vertical_chord_m=rng.uniform(0.1, 1.0),
        vertical_aft_m=rng.uniform(-1.0, 1.0),
        boom_height_m=rng.uniform(-0.4, 0.2),
    )
    suns = sun_from(rng.uniform(5.0, 85.0, 6), rng.uniform(0.0, 360.0, 6))
    result = shaded_fraction(ATLANTIKSOLAR, tail, suns)
    expected = [cast_rays(ATLANTIKSOLAR, tail, sun, np.eye(3)) for sun in suns]
    assert result.any()
    # 400 x 120 rays sample a module: 1 % is a few of the short rows.
    assert result == pytest.approx(np.array(expected), abs=0.01)


def test_no_tail_shades_nothing_and_needs_no_outlines():
    bare = ModuleGeometry(surfaces=(ModuleSurface(name="wing", area_m2=1.0, side="centre"),))
    assert np.array_equal(shaded_area(bare, None, np.ones((7, 3))), np.zeros((7, 1)))
    assert elevation_free_of_shading_deg(bare, None) == 0.0
    with pytest.raises(ValueError, match="wing needs an outline"):
        shaded_area(bare, TAIL, [0.0, 0.0, -1.0])


@pytest.mark.parametrize(
    ("roll_deg", "pitch_deg"), [(0, 0), (0, 5), (0, -5), (15, 0), (-15, 3), (40, 0)]
)
def test_free_elevation_separates_shade_from_light(roll_deg, pitch_deg):
    roll, pitch = np.radians([roll_deg, pitch_deg])
    limit = elevation_free_of_shading_deg(ATLANTIKSOLAR, TAIL, roll, pitch)
    to_ned = direction_cosines(roll, pitch, 0.0)
    azimuths = np.arange(0.0, 360.0, 0.2)
    above = np.linspace(limit + 1e-6, 90.0, 40)[:, np.newaxis]
    assert not shaded_area(ATLANTIKSOLAR, TAIL, sun_from(above, azimuths) @ to_ned).any()
    # The cone is wider than the step of the azimuth a tenth of a degree below its steepest ray.
    assert shaded_area(ATLANTIKSOLAR, TAIL, sun_from(limit - 0.1, azimuths) @ to_ned).any()


def test_free_elevation_by_hand_and_as_reported():
    expected = np.degrees(np.arctan(HEIGHT / (AFT - REAR)))
    result = elevation_free_of_shading_deg(level_wing(), t_tail())
    assert result == pytest.approx(expected, rel=1e-9)  # accuracy of the least squares
    # "Above 19 degrees": two digits. The height of the assumed T-tail was chosen for it.
    result = elevation_free_of_shading_deg(ATLANTIKSOLAR, TAIL)
    assert result == pytest.approx(19.0, abs=0.5)


# Outlines in space.


def test_outlines_lie_in_the_planes_of_the_normals_and_keep_their_size():
    for surface, normal in zip(ATLANTIKSOLAR.surfaces, ATLANTIKSOLAR.normals(), strict=True):
        corners = outline_corners(surface, ATLANTIKSOLAR)
        across, along = corners[1] - corners[0], corners[3] - corners[0]
        assert np.cross(along, across) / (np.linalg.norm(across) * np.linalg.norm(along)) == (
            pytest.approx(normal, abs=ROUNDING)
        )
        assert np.linalg.norm(across) == pytest.approx(2.5 if surface.side == "centre" else 1.5)
        assert np.linalg.norm(along) == pytest.approx(0.125)
        assert corners[0] + corners[2] == pytest.approx(corners[1] + corners[3])


def test_corners_are_clockwise_from_the_front_left():
    (surface,) = level_wing().surfaces
    expected = [(0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (-REAR, 1.0, 0.0), (-REAR, -1.0, 0.0)]
    assert outline_corners(surface, level_wing()) == pytest.approx(np.array(expected))


def test_incidence_lowers_what_is_aft_and_dihedral_raises_the_tips():
    flat = ATLANTIKSOLAR.model_copy(update={"wing_incidence_deg": 0.0})
    middles = [outline_corners(s, ATLANTIKSOLAR).mean(axis=0) for s in ATLANTIKSOLAR.surfaces]
    assert middles[2][2] == pytest.approx(0.0875 * np.sin(np.radians(5.7)))
    tip = outline_corners(flat.surfaces[4], flat).mean(axis=0)
    bent = 2.02 - 1.25  # middle of the outer module from the edge of the central one
    assert tip[2] == pytest.approx(-bent * np.sin(np.radians(6.0)))
    assert tip[1] == pytest.approx(1.25 + bent * np.cos(np.radians(6.0)))


def test_horizontal_tail_sits_on_the_fin_unless_told_otherwise():
    assert t_tail(boom_height_m=0.1).height_m == pytest.approx(HEIGHT + 0.1)
    assert t_tail(horizontal_height_m=0.2).height_m == 0.2
    horizontal, vertical = t_tail(boom_height_m=0.1).panels()
    assert horizontal[:, 2] == pytest.approx(np.full(4, -HEIGHT - 0.1))
    assert vertical[:, 2] == pytest.approx([-0.1, -HEIGHT - 0.1, -HEIGHT - 0.1, -0.1])


# Losses.

FRACTIONS = np.linspace(0.0, 1.0, 101)


@pytest.mark.parametrize("name", sorted(LOSS_MODELS))
def test_losses_rise_from_nothing_and_stay_below_all(name):
    lost = loss_model(name)(FRACTIONS)
    assert lost[0] == 0.0
    assert (np.diff(lost) >= 0.0).all()
    assert lost[-1] == (0.0 if name == "none" else 1.0)


def test_string_loses_whole_substrings_above_the_threshold():
    model = string_losses(substrings=4, threshold=0.01)
    shaded = np.array([0.0, 0.01, 0.011, 0.25, 0.26, 0.5, 0.75, 0.751, 1.0])
    assert model(shaded) == pytest.approx([0.0, 0.0, 0.25, 0.25, 0.5, 0.5, 0.75, 1.0, 1.0])


def test_losses_reduce_the_light_of_each_surface():
    direct = np.array([[100.0, 200.0], [0.0, 50.0]])
    shaded = np.array([0.25, 0.0])
    assert np.array_equal(apply_losses(direct, shaded), direct)
    left = apply_losses(direct, shaded, proportional_losses)
    assert np.array_equal(left, [[75.0, 200.0], [0.0, 50.0]])


def test_own_model_is_found_by_its_name(monkeypatch):
    monkeypatch.setattr("solar.shading.LOSS_MODELS", dict(LOSS_MODELS))
    register_loss_model("square", np.square)
    assert apply_losses(8.0, np.array([0.5]), loss_model("square")) == pytest.approx([6.0])
    with pytest.raises(ValueError, match="already"):
        register_loss_model("square", np.square)


def losing(lost):
    return apply_losses(1.0, np.zeros(2), lambda shaded: np.full_like(shaded, lost))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        *((lambda lost=lost: losing(lost), "between 0 and 1") for lost in (-0.1, 1.1, np.nan)),
        (lambda: apply_losses(1.0, np.zeros(2), lambda shaded: shaded[:1]), "shape"),
        (lambda: loss_model("bypass"), "none, proportional, string"),
        (lambda: string_losses(0, 0.0), "sub-string"),
        (lambda: t_tail(horizontal_span_m=0.0), "horizontal_span_m"),
        (lambda: t_tail(vertical_chord_m=-1.0), "vertical_chord_m"),
        (lambda: t_tail(vertical_height_m=0.0), "vertical_height_m"),
        (lambda: t_tail(boom_height_m=float("nan")), "boom_height_m"),
        (lambda: t_tail(horizontal_aft_m="1.5"), "horizontal_aft_m"),
        (lambda: t_tail(colour="white"), "colour"),
        *((lambda one=one: string_losses(2, one), "threshold") for one in (-0.1, 1.0, np.nan)),
        *(
            (lambda sun=sun: shaded_area(ATLANTIKSOLAR, TAIL, sun), "three components")
            for sun in (0.0, [0.0, 1.0], np.zeros((3, 2)))
        ),
    ],
)
def test_what_cannot_be_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.parametrize(
    ("above_boom_m", "is_one"), [(0.1, False), (0.19, False), (0.21, True), (0.4, True)]
)
def test_a_tail_on_the_upper_half_of_the_fin_makes_a_t(above_boom_m, is_one):
    tail = t_tail(vertical_height_m=0.4, boom_height_m=0.1, horizontal_height_m=0.1 + above_boom_m)
    assert tail.is_t_tail is is_one
    assert not t_tail(vertical_height_m=-0.4, horizontal_height_m=-0.4).is_t_tail
