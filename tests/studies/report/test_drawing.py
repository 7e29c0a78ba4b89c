"""Three views: to scale, by the numbers of the models, dashed where they have none."""

import numpy as np
import pytest
from builders import AS2, DESIGN, SKY_SAILOR, aircraft
from matplotlib.backends.backend_agg import FigureCanvasAgg

from sizing.library import load_aircraft
from sizing.structures.rib_wing import RibWingStructure
from studies.report.geometry import Drawing
from studies.report.three_view import description, plot_three_view


def shapes(figure, part, view=0):
    """Corners [m] of the shapes of a part in one view: from above, from ahead, from the left."""
    return [one.get_xy() for one in figure.axes[view].patches if one.get_gid() == part]


def test_wing_modules_and_tail_have_one_scale():
    drawing = Drawing(AS2)
    figure = plot_three_view(drawing)
    FigureCanvasAgg(figure).draw()
    assert len({round(axes.bbox.width / np.ptp(axes.get_xlim()), 3) for axes in figure.axes}) == 1
    for axes in figure.axes:
        scales = (
            axes.bbox.width / np.ptp(axes.get_xlim()),
            axes.bbox.height / np.ptp(axes.get_ylim()),
        )
        assert scales[0] == pytest.approx(scales[1], rel=1e-3)
    (wing,) = shapes(figure, "wing")
    assert np.ptp(wing, axis=0) == pytest.approx((drawing.wingspan_m, drawing.chord_m))
    modules = [np.ptp(one, axis=0) for one in shapes(figure, "modules")]
    assert len(modules) == 6
    assert sum(map(np.prod, modules)) == pytest.approx(AS2.modules.area_m2, rel=0.03)  # to 2 %
    tail = shapes(figure, "tail")[-1]
    assert np.ptp(tail[:, 0]) == pytest.approx(AS2.modules.tail.horizontal_span_m)


def test_the_note_on_propellers_has_their_diameter_where_the_file_has_it():
    parts = {
        "kind": "operating_point",
        "propulsors": 2,
        "propeller": {"diameter_m": 0.66, "pitch_m": 0.60},
        "motor": "maxon-re40-148867",
        "controller": {"resistance_ohm": 0.02},
    }
    voltage = {"cells_in_series": 6, "state_of_charge": [0.0, 1.0], "cell_voltage_v": [3.0, 4.2]}
    changes = {"airframe.propulsion": parts, "battery.voltage": voltage}
    craft = load_aircraft("atlantiksolar-design", changes)
    assert "2 propellers of 0.66 m diameter" in Drawing(craft).notes[-1]
    assert "Propeller: not drawn" in Drawing(DESIGN).notes[-1]
    assert "Propeller: not drawn" in Drawing(AS2).notes[-1]


def test_everything_lies_within_the_drawing():
    slender, stout, tiny = (
        aircraft("sky-sailor", f"airframe.wingspan_m={span}", f"airframe.aspect_ratio={ratio}",
                 f"modules.area_m2={0.5 * span**2 / ratio}")
        for span, ratio in ((70.0, 35.0), (3.0, 5.0), (0.7, 8.0))
    )  # fmt: skip
    hanging = aircraft("atlantiksolar-as2", "modules.tail.vertical_height_m=-0.4")
    for craft in (AS2, SKY_SAILOR, DESIGN, slender, stout, tiny, hanging):
        figure = plot_three_view(Drawing(craft))
        FigureCanvasAgg(figure).draw()
        for axes in figure.axes:
            low, high = np.transpose((axes.get_xlim(), axes.get_ylim()))
            for shape in axes.patches:
                assert np.all((low <= shape.get_xy()) & (shape.get_xy() <= high))
            for text in axes.texts:
                box = text.get_window_extent()
                assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
                assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1


def test_what_no_model_has_a_number_for_is_schematic():
    assert Drawing(AS2).schematic == {"pod", "section", "spar"}
    assert Drawing(SKY_SAILOR).schematic >= {"pod", "tail", "modules"}
    assert Drawing(DESIGN).schematic == {"pod"}


def test_tail_of_another_wing_follows_the_rule_of_the_structure_model():
    # 4 m instead of 5.65 m: areas fall with the square of the span, the arm with the chord.
    craft = aircraft("atlantiksolar-design", "airframe.wingspan_m=4.0", "modules.area_m2=0.6")
    drawing, rule = Drawing(craft), RibWingStructure(model="rib_wing")
    tail, chord_m = drawing.tail, 4.0 / 18.5
    area_m2 = tail.horizontal_span_m * tail.horizontal_chord_m
    share = rule.horizontal_tail_ratio / rule.fuselage_chords
    assert area_m2 == pytest.approx(share * 4.0 * chord_m)
    assert area_m2 < craft.modules.tail.horizontal_span_m * craft.modules.tail.horizontal_chord_m
    assert "modules" in drawing.schematic
    band_m2 = sum((m.right_m - m.left_m) * (m.rear_m - m.front_m) for m in drawing.modules)
    assert band_m2 == pytest.approx(0.6)


def test_dihedral_raises_the_tips():
    drawing = Drawing(AS2)
    assert drawing.height_m(0.0) == 0.0
    # 6 degrees from 1.27 m to 2.825 m.
    assert drawing.height_m(2.825) == pytest.approx(0.1634, abs=2e-4)


def test_whole_cells_are_drawn_on_wing_and_tail():
    layout = {
        "cell_span_m": 0.125,
        "cell_chord_m": 0.125,
        "planform": {"half_span": [0.0, 0.6, 1.0], "relative_chord": [1.1, 1.1, 0.6]},
        "bays": [{"outboard": 0.6, "cells": [12, 12]}],
        "tail_cells": [6],
    }
    plane = load_aircraft(
        "atlantiksolar-design", {"modules.layout": layout, "modules.area_m2": 54 * 0.125**2}
    )
    drawing = Drawing(plane)
    assert len(drawing.modules) == 54
    assert "modules" not in drawing.schematic
    tail = drawing.tail
    on_tail = [one for one in drawing.modules if one.front_m > drawing.chord_m]
    assert len(on_tail) == 6
    for one in on_tail:
        assert one.front_m >= tail.horizontal_aft_m
        assert one.rear_m <= tail.horizontal_aft_m + tail.horizontal_chord_m
        assert max(-one.left_m, one.right_m) <= tail.horizontal_span_m / 2.0
    assert "54 solar cells" in description(drawing)
    figure = plot_three_view(drawing)
    assert len(shapes(figure, "modules")) == 54
    # Root, break and tip of both halves, along both edges; the root is one place.
    assert len(shapes(figure, "wing")[0]) == 10 + 1  # closed
