import pytest
from builders import DESIGN, aircraft, shipped_mission

import sizing
from missions.files.errors import InputError
from sizing.balance.assessment import balance_assessment, drag_shares
from sizing.mass_budget import design_of
from sizing.structures.rib_wing import RibWingStructure

MISSION = shipped_mission()
TWIN = aircraft("twin-boom-design")
TAIL = "airframe.tail={arm_chords: 4, horizontal_volume: 0.35, vertical_volume: 0.02}"


def balance(*overrides, name="twin-boom-design"):
    loaded = aircraft(name, *overrides)
    return balance_assessment(loaded, design_of(loaded, MISSION))


@pytest.mark.parametrize("growth", [0.0, 0.15])
def test_the_items_are_the_mass_budget(growth):
    assessment = balance(f"airframe.mass_growth={growth}")
    assert assessment.mass_kg == pytest.approx(assessment.design_mass_kg, rel=1e-9)
    moments = sum(item.mass_kg * item.x_m for item in assessment.items)
    assert assessment.gravity_m == pytest.approx(moments / assessment.mass_kg)


def test_the_reported_tail_has_the_margin_that_is_asked_for():
    margin = "airframe.balance.static_margin=0.2"
    volume = balance(margin).volume_for_margin
    held = balance(margin, f"airframe.tail.horizontal_volume={volume}")
    # The mass budget closes anew with the heavier tail: wing and propulsion follow.
    assert held.static_margin == pytest.approx(0.2, abs=0.005)
    assert balance("airframe.balance.static_margin=0.1").volume_for_margin == pytest.approx(
        0.45,
        abs=1e-3,  # that of the file, which has its margin; places of four digits
    )
    assert balance("airframe.balance.static_margin=-0.3").volume_for_margin is None


def test_trim_drag_of_the_margin_is_in_the_power():
    """The power of two margins differs by the trim drag that is reported of both."""
    first, second = (
        aircraft("twin-boom-design", f"airframe.balance.static_margin={margin}",
                 "airframe.propulsion={kind: constant, mass_kg_per_w: 0}")
        for margin in (0.05, 0.6)
    )  # fmt: skip
    designs = [design_of(loaded, MISSION) for loaded in (first, second)]
    drags = [
        shares.trim / shares.total
        for loaded, design in zip((first, second), designs, strict=True)
        if (shares := drag_shares(loaded, design)) is not None
    ]
    powers = [design.propulsion_power_w for design in designs]
    assert powers[1] > powers[0]
    # Without its trim drag either aircraft takes the same power.
    assert powers[0] * (1.0 - drags[0]) == pytest.approx(powers[1] * (1.0 - drags[1]), rel=1e-9)


def test_weighed_masses_replace_the_build_up():
    weighed = "[{name: nose, mass_kg: 2, x_m: -0.2}, {name: rest, mass_kg: 4, x_m: 0.25}]"
    weighed_balance = balance(f"airframe.balance={{weighed: {weighed}}}", TAIL, name=DESIGN.name)
    assert weighed_balance.gravity_m == pytest.approx(0.1)
    assert [item.name for item in weighed_balance.items] == ["nose", "rest"]
    # What the airframe's models need not meet, a line says.
    result = sizing.analyse(
        aircraft("atlantiksolar-design", TAIL, f"airframe.balance={{weighed: {weighed}}}"), MISSION
    )
    assert "off the mass budget of 6.9" in " ".join(str(result.at_level(2)).split())


def test_a_tail_of_the_structures_own_size_weighs_the_same():
    """The volumes of the structure's model, given as those of a tail: 0.045/AR on the span."""
    tail = (
        "airframe.tail={arm_chords: 4, horizontal_volume: 0.35, "
        f"vertical_volume: {0.045 / 18.5!r}}}"
    )
    plain, as_tail = (design_of(a, MISSION) for a in (DESIGN, aircraft(DESIGN.name, tail)))
    assert as_tail.total_mass_kg == pytest.approx(plain.total_mass_kg, rel=1e-12)


def test_two_booms_share_the_load_of_the_tail():
    def boom_kg(number, gauge_m):
        model = RibWingStructure(model="rib_wing", booms=number, minimum_boom_thickness_m=gauge_m)
        return float(model._boom_kg(1.7, 0.3, 30.0))

    # By strength the wall follows the moment, of which each boom has half; by gauge two weigh twice
    # as much. Smooth maxima lie up to 2 % above either.
    assert boom_kg(2, 1e-6) == pytest.approx(boom_kg(1, 1e-6), rel=0.02)
    assert boom_kg(2, 0.01) == pytest.approx(2.0 * boom_kg(1, 0.01), rel=0.02)


def test_results_have_what_the_file_asks_for():
    record = sizing.analyse(TWIN, MISSION).to_dict()
    assert record["balance"]["static_margin"] == pytest.approx(0.1, abs=1e-4)
    parts = record["drag_coefficients"]
    assert parts["total"] == pytest.approx(
        sum(v for k, v in parts.items() if k not in ("total", "parasitic"))
    )
    plain = sizing.analyse(DESIGN, MISSION).to_dict()
    assert not {"balance", "drag_coefficients"} & plain.keys()


LAYOUT = {"cell_span_m": 0.125, "cell_chord_m": 0.125, "bays": [{"cells": [8, 8]}]}


def test_cells_lie_on_the_wing_of_the_airframe():
    cells = {"modules.layout": LAYOUT}
    # Two rows of 0.25 m reach to where the chord is 0.25 m: neither the tip of 0.217 m.
    with pytest.raises(InputError, match=r"2 rows of cells of 0\.125 m need"):
        sizing.load_aircraft("twin-boom-design", cells)
    bays = {"modules.layout": {**LAYOUT, "bays": [{"outboard": 0.6, "cells": [8, 8]}]}}
    loaded = sizing.load_aircraft("twin-boom-design", {**cells, **bays})
    layout, wing = loaded.modules.layout, balance().wing
    assert layout.chord_m(loaded.wing, 0.0) == pytest.approx(wing.root_chord_m)
    assert layout.chord_m(loaded.wing, 1.0) == pytest.approx(0.6 * wing.root_chord_m)
    written = loaded.model_dump(mode="json", exclude_unset=True)
    assert sizing.Aircraft.model_validate(written) == loaded
    other = {"half_span": [0.0, 1.0], "relative_chord": [1.2, 0.8]}
    both = {**cells, "modules.layout": {**LAYOUT, "planform": other}}
    with pytest.raises(InputError, match="is another wing than"):
        sizing.load_aircraft("twin-boom-design", both)
