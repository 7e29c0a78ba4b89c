"""Whole solar cells on wings: published counts, places, and what is refused."""

from itertools import combinations

import pytest
from builders import DESIGN, shipped_mission

import sizing
from missions.files.errors import InputError
from sizing.aircraft import Aircraft
from sizing.layout.cells import CellLayout, Wing

SUNPOWER = {"cell_span_m": 0.125, "cell_chord_m": 0.125}
# Modules of AS-2: 20 cells in each central row and 12 in each outer one (docs/shading.md).
AS2_BAYS = [{"outboard": 0.4528, "cells": [10, 10]}, {"inboard": 0.4528, "cells": [12, 12]}]


def laid(base="atlantiksolar-design", area_m2=1.35, **layout):
    modules = {"cell": "sunpower-e60", "layout": layout, "area_m2": area_m2}
    return sizing.load_aircraft(base, {f"modules.{key}": value for key, value in modules.items()})


def bay(cells, **more):
    return {"bays": [{"cells": cells} | more]}


def overlaps(cell, other):
    along = min(cell.right_m, other.right_m) - max(cell.left_m, other.left_m)
    across = min(cell.rear_m, other.rear_m) - max(cell.front_m, other.front_m)
    return min(along, across) > 1e-9


def test_atlantiksolar_holds_its_88_cells_around_the_joints():
    joint = {"name": "joint", "inboard": 0.4528, "outboard": 0.4528, "margin_m": 0.01}
    plane = laid("atlantiksolar-as2", **SUNPOWER, bays=AS2_BAYS, keep_outs=[joint])
    assert len(plane.placed_cells()) == 88
    # 1.35 m2 are published for the 88 cells, rounded to three digits.
    assert plane.modules.area_m2 == pytest.approx(1.35, abs=0.005)
    layout = plane.modules.layout
    # No cell more would fit: the published count is that of full rows.
    assert layout.capacity(plane.wing) == 44


@pytest.mark.parametrize(("gap_m", "count"), [(0.0, 76), (0.002, 72)])
def test_solong_holds_its_76_cells_without_gaps(gap_m, count):
    # Of its chord only the aspect ratio is known, an assumption; two rows fit, three do not.
    layout = CellLayout.model_validate(SUNPOWER | {"gap_m": gap_m} | bay([1]))
    wing = sizing.load_aircraft("solong").wing
    assert 2 * layout.capacity(wing) == count


def test_sky_sailor_holds_its_216_cells():
    # Published: 216 cells, 0.51 m2, hence 23.6 cm2 each; the outline is assumed, 32 mm by 74 mm.
    outline = {"cell_span_m": 0.074, "cell_chord_m": 0.032, "cell_area_m2": 0.51 / 216}
    layout = {"modules.layout": outline | bay([18] * 6)}
    plane = sizing.load_aircraft("sky-sailor", layout)
    assert len(plane.placed_cells()) == 216
    assert plane.modules.area_m2 == pytest.approx(0.51, abs=0.005)
    # A rectangle of the wing's area would hold more.
    assert 2 * plane.modules.layout.capacity(plane.wing) == 294


def test_cells_lie_on_the_wing_apart_from_each_other_and_from_keep_outs():
    planform = {"half_span": [0.0, 0.5, 1.0], "relative_chord": [1.2, 1.1, 0.6]}
    aileron = {"name": "aileron", "inboard": 0.6, "outboard": 0.9, "front": 0.7}
    plane = laid(
        area_m2=46 * 0.0153436,
        **SUNPOWER,
        gap_m=0.004,
        planform=planform,
        keep_outs=[aileron],
        bays=[
            {"outboard": 0.5, "front": 0.05, "cells": [10, 9]},
            {"inboard": 0.5, "front": 0.05, "rear": 0.95, "cells": [4]},
        ],
    )
    cells, wing, layout = plane.placed_cells(), plane.wing, plane.modules.layout
    assert len(cells) == layout.count == 46
    assert not any(overlaps(*pair) for pair in combinations(cells, 2))
    chord_m = wing.chord_m
    for cell in cells:
        for y_m in (abs(cell.left_m), abs(cell.right_m)):
            at = 2.0 * y_m / wing.wingspan_m
            # The chord by hand, and leading edges along a straight line of the quarter chords.
            own_m = chord_m * (1.2 - 0.2 * at if at <= 0.5 else 1.1 - (at - 0.5))
            edge_m = (1.2 * chord_m - own_m) / 4.0
            assert cell.front_m >= edge_m + 0.05 * own_m - 1e-9
            assert cell.rear_m <= edge_m + own_m + 1e-9
            if 0.6 <= at <= 0.9:
                assert cell.rear_m <= edge_m + 0.7 * own_m + 0.03  # the fronts differ by the taper


def test_keep_outs_take_cells_away():
    layout = CellLayout.model_validate(SUNPOWER | {"gap_m": 0.0} | bay([1]))
    wing = Wing(5.0, 0.26)
    assert layout.capacity(wing) == 40
    # 0.05 of 2.5 m are one cell; as a whole chord it takes one of both rows.
    joint = {"name": "joint", "inboard": 0.5, "outboard": 0.55}
    kept = CellLayout.model_validate(layout.model_dump() | {"keep_outs": [joint]})
    assert kept.capacity(wing) == 38
    rear = joint | {"front": 0.6}
    kept = CellLayout.model_validate(layout.model_dump() | {"keep_outs": [rear]})
    assert kept.capacity(wing) == 39


def test_cells_on_the_tail():
    # 0.87 m by 0.173 m: six cells of 0.125 m with gaps of 2 mm.
    plane = laid(area_m2=86 * 0.0153436, **SUNPOWER, bays=[{"cells": [20, 20]}], tail_cells=[6])
    tail_aft_m = plane.modules.tail.horizontal_aft_m
    on_tail = [cell for cell in plane.placed_cells() if cell.front_m > tail_aft_m]
    assert len(on_tail) == 6
    assert sum(cell.left_m + cell.right_m for cell in on_tail) == pytest.approx(0.0, abs=1e-9)


def test_counts_follow_from_the_middle_outwards():
    layout = CellLayout.model_validate(SUNPOWER | bay([1]))
    wing = Wing(5.65, 0.305)
    fewer = layout.with_cells(25, wing, None)
    assert fewer.bays[0].cells == (13, 12)
    assert len(fewer.placed(wing, None)) == 50
    with pytest.raises(ValueError, match="holds 44 cells, not 45"):
        layout.with_cells(45, wing, None)


def strings(in_series, lowest_v, most_a, **mppt):
    window = {"minimum_voltage_v": lowest_v, "maximum_voltage_v": 60.0, "maximum_current_a": most_a}
    cold_and_hot = {"coldest_c": -20.0, "hottest_c": 70.0}
    return {"cells_in_series": in_series, "mppt": window | mppt} | cold_and_hot


WEIGHED = strings(44, 10.0, 7.0, mass_kg=0.08)


def test_area_and_mppt_mass_follow():
    data = DESIGN.model_dump(mode="json", exclude_unset=True)
    data["modules"] |= {
        "cell": "sunpower-c60",
        "layout": SUNPOWER | bay([22, 22]) | {"strings": WEIGHED},
    }
    del data["modules"]["area_m2"], data["modules"]["mppt_mass_kg_per_w"]
    plane = Aircraft.model_validate(data)
    assert plane.modules.area_m2 == pytest.approx(88 * 0.0153436, rel=1e-12)
    design = sizing.design_of(plane, shipped_mission("rafz-july"))
    assert design.masses.mppt == pytest.approx(2 * 0.08, rel=1e-12)
    assert design.masses.modules == pytest.approx(0.59 * 88 * 0.0153436, rel=1e-12)
    with pytest.raises(InputError, match=r"modules\.mppt_mass_kg_per_w: leave it out"):
        sizing.load_aircraft(
            "atlantiksolar-design",
            {f"modules.{key}": data["modules"][key] for key in ("cell", "layout")},
        )
    # Half a cell has half the current.
    half = {"cell_span_m": 0.125, "cell_chord_m": 0.0625, "cell_area_m2": 0.0153436 / 2.0}
    rows = {"bays": [{"cells": [44] * 4}], "strings": strings(22, 5.0, 3.0)}
    changes = {"modules.cell": "sunpower-c60", "modules.layout": half | rows}
    changes |= {"airframe.wingspan_m": 11.3, "modules.area_m2": 352 * 0.0153436 / 2.0}
    layout = sizing.load_aircraft("atlantiksolar-design", changes).modules.layout
    assert layout.strings.mpp_current_a == pytest.approx(5.93 / 2.0)
    # What follows is not written to a file, and follows again when it is read.
    again = plane.model_dump(mode="json", exclude_unset=True)
    assert "area_m2" not in again["modules"]
    assert Aircraft.model_validate(again) == plane
