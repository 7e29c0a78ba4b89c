"""Three views: to scale, by the numbers of the models, dashed where they have none."""

import re
from xml.etree import ElementTree

import pytest
from builders import AS2, DESIGN, SKY_SAILOR, aircraft

from sizing.library import load_aircraft
from sizing.structures.rib_wing import RibWingStructure
from studies.report.geometry import aircraft_drawing
from studies.report.three_view import three_view


def shapes(svg: str, kind: str) -> list[list[tuple[float, float]]]:
    """Corners of the shapes of a class."""
    found = []
    for node in ElementTree.fromstring(svg):
        if kind in node.attrib.get("class", "").split() and "points" in node.attrib:
            pairs = (pair.split(",") for pair in node.attrib["points"].split())
            found.append([(float(x), float(y)) for x, y in pairs])
    return found


@pytest.mark.parametrize("width", [940.0, 350.0])
def test_wing_modules_and_tail_have_one_scale(width: float) -> None:
    drawing = aircraft_drawing(AS2)
    svg = three_view(drawing, name="a", key="a", width=width, kind="wide")
    wing = shapes(svg, "wing")[0]
    scale = (wing[1][0] - wing[0][0]) / drawing.wingspan_m
    assert wing[2][1] - wing[1][1] == pytest.approx(scale * drawing.chord_m, abs=0.02)
    modules = shapes(svg, "module")[: len(drawing.modules)]
    assert len(modules) == 6
    area_m2 = sum((m[1][0] - m[0][0]) * (m[2][1] - m[1][1]) for m in modules) / scale**2
    assert area_m2 == pytest.approx(AS2.modules.area_m2, rel=0.03)  # outlines are to 2 %
    tail = shapes(svg, "tail")[0]
    span_m = AS2.modules.tail.horizontal_span_m
    assert tail[1][0] - tail[0][0] == pytest.approx(scale * span_m, abs=0.02)
    bar = shapes(svg, "scale")
    metres = float(re.findall(r">([\d.]+) m</text>", svg)[-1])
    assert bar[1][1][0] - bar[0][0][0] == pytest.approx(scale * metres, abs=0.02)


def test_the_note_on_propellers_has_their_diameter_where_the_file_has_it() -> None:
    parts = {
        "kind": "operating_point",
        "propulsors": 2,
        "propeller": {"diameter_m": 0.66, "pitch_m": 0.60},
        "motor": "maxon-re40-148867",
        "controller": {"resistance_ohm": 0.02},
    }
    voltage = {
        "cells_in_series": 6,
        "state_of_charge": [0.0, 1.0],
        "cell_voltage_v": [3.0, 4.2],
    }
    changes = {"airframe.propulsion": parts, "battery.voltage": voltage}
    craft = load_aircraft("atlantiksolar-design", changes)
    assert "2 propellers of 0.66 m diameter" in aircraft_drawing(craft).notes[-1]
    assert "No propeller" in aircraft_drawing(DESIGN).notes[-1]
    assert "No propeller" in aircraft_drawing(AS2).notes[-1]


def test_everything_lies_within_the_drawing() -> None:
    slender, stout, tiny = (
        aircraft("sky-sailor", f"airframe.wingspan_m={span}", f"airframe.aspect_ratio={ratio}",
                 f"modules.area_m2={0.5 * span**2 / ratio}")
        for span, ratio in ((70.0, 35.0), (3.0, 5.0), (0.7, 8.0))
    )  # fmt: skip
    hanging = aircraft("atlantiksolar-as2", "modules.tail.vertical_height_m=-0.4")
    for craft in (AS2, SKY_SAILOR, DESIGN, slender, stout, tiny, hanging):
        svg = three_view(aircraft_drawing(craft), name="a", key="a", width=940.0, kind="wide")
        height = float(ElementTree.fromstring(svg).attrib["height"])
        for kind in ("wing", "tail", "body", "module", "dimension", "scale"):
            for x, y in (place for shape in shapes(svg, kind) for place in shape):
                assert 0.0 <= x <= 940.0
                assert 0.0 <= y <= height


def test_what_no_model_has_a_number_for_is_schematic() -> None:
    assert aircraft_drawing(AS2).schematic == {"pod", "section", "spar"}
    assert aircraft_drawing(SKY_SAILOR).schematic >= {"pod", "tail", "modules"}
    assert aircraft_drawing(DESIGN).schematic == {"pod"}


def test_tail_of_another_wing_follows_the_rule_of_the_structure_model() -> None:
    # 4 m instead of 5.65 m: areas fall with the square of the span, the arm with the chord.
    craft = aircraft("atlantiksolar-design", "airframe.wingspan_m=4.0", "modules.area_m2=0.6")
    drawing, rule = aircraft_drawing(craft), RibWingStructure(model="rib_wing")
    tail, chord_m = drawing.tail, 4.0 / 18.5
    area_m2 = tail.horizontal_span_m * tail.horizontal_chord_m
    share = rule.horizontal_tail_ratio / rule.fuselage_chords
    assert area_m2 == pytest.approx(share * 4.0 * chord_m)
    assert area_m2 < craft.modules.tail.horizontal_span_m * craft.modules.tail.horizontal_chord_m
    assert "modules" in drawing.schematic
    band_m2 = sum((m.right_m - m.left_m) * (m.rear_m - m.front_m) for m in drawing.modules)
    assert band_m2 == pytest.approx(0.6)


def test_dihedral_raises_the_tips() -> None:
    drawing = aircraft_drawing(AS2)
    assert drawing.height_m(0.0) == 0.0
    # 6 degrees from 1.27 m to 2.825 m.
    assert drawing.height_m(2.825) == pytest.approx(0.1634, abs=2e-4)


def test_whole_cells_are_drawn_on_wing_and_tail() -> None:
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
    drawing = aircraft_drawing(plane)
    assert len(drawing.modules) == 54
    assert "modules" not in drawing.schematic
    tail = drawing.tail
    on_tail = [one for one in drawing.modules if one.front_m > drawing.chord_m]
    assert len(on_tail) == 6
    for one in on_tail:
        assert one.front_m >= tail.horizontal_aft_m
        assert one.rear_m <= tail.horizontal_aft_m + tail.horizontal_chord_m
        assert max(-one.left_m, one.right_m) <= tail.horizontal_span_m / 2.0
    svg = three_view(drawing, name="a", key="a", width=940.0, kind="wide")
    assert "54 solar cells" in svg
    assert len(shapes(svg, "module")) >= 54
    # Root, break and tip of both halves, along both edges; the root is one place.
    assert len(shapes(svg, "wing")[0]) == 10
