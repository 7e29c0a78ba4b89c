"""Tests of a horizontal tail whose size holds the static margin that is asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from builders import shipped_mission

import sizing
from missions.files.errors import InputError
from sizing.balance.assessment import BalanceAssessment, balance_assessment
from sizing.design import Design, variables_of
from sizing.mass_budget import ImpossibleDesignError, closed_design, design_of
from sizing.program.cross_check import cross_check
from sizing.sized_structure import structure_parts
from sizing.sunlight import UNCORRECTED_CAM

MISSION = shipped_mission()
# Its battery lies still, where that of the shipped file does; the chain is one of constants.
HELD = {
    "airframe.balance.held_by": "horizontal_tail",
    "airframe.balance.positions_chords.battery": 0.45,
    "airframe.propulsion": {"kind": "constant", "mass_kg_per_w": 0.0011},
}
# The same aircraft without anything that follows from a static margin.
FREE: dict[str, Any] = HELD | {
    "airframe.balance.held_by": "moved_mass",
    "airframe.balance.static_margin": None,
}


def craft(*changes: dict[str, Any]) -> sizing.Aircraft:
    values: dict[str, Any] = {}
    for one in changes:
        values |= one
    return sizing.load_aircraft("twin-boom-design", values)


def flown(aircraft: sizing.Aircraft) -> tuple[Design, BalanceAssessment]:
    design = design_of(aircraft, MISSION)
    found = balance_assessment(aircraft, MISSION, design)
    assert found is not None
    return design, found


@pytest.mark.parametrize("margin", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("exact", [False, True])
def test_the_tail_has_the_size_that_holds_the_margin(margin: float, exact: bool) -> None:
    changes = {k: v for k, v in HELD.items() if not (exact and "propulsion" in k)}
    design, found = flown(craft(changes, {"airframe.balance.static_margin": margin}))
    assert found.static_margin == pytest.approx(margin, abs=1e-9)
    assert found.sized_volume == design.horizontal_volume
    assert found.moved is None
    # Masses of the budget, the tail's own among them, give the centre of gravity.
    assert found.mass_kg == pytest.approx(float(design.total_mass_kg), rel=1e-9)
    assert design.masses.total_kg == pytest.approx(design.total_mass_kg, rel=1e-9)


def test_a_larger_tail_moves_the_neutral_point_aft_and_has_its_mass_and_drag() -> None:
    designs, found = zip(
        *(flown(craft(HELD, {"airframe.balance.static_margin": one})) for one in (0.05, 0.15)),
        strict=True,
    )
    small, large = found
    assert large.planes.horizontal_m2 > small.planes.horizontal_m2
    assert large.found.x_m > small.found.x_m
    assert large.gravity_m > small.gravity_m  # by its own mass
    parts = [structure_parts(craft(HELD), MISSION, one) for one in designs]
    assert all(part is not None for part in parts)
    ratio = parts[1].tails / parts[0].tails  # type: ignore[union-attr]  # not None
    areas = [one.planes.horizontal_m2 + one.planes.vertical_m2 for one in found]
    assert ratio == pytest.approx(areas[1] / areas[0], rel=1e-9)
    shares = [
        sizing.analyse(craft(HELD, {"airframe.balance.static_margin": one}), MISSION).to_dict()
        for one in (0.05, 0.15)
    ]
    drags = [one["drag_coefficients"] for one in shares]
    assert drags[1]["horizontal_tail"] > drags[0]["horizontal_tail"]
    # Of both the thrust power is that of the drag that is told.
    for design, drag in zip(designs, drags, strict=True):
        assert design.chain is not None
        power_w = float(design.propulsion_power_w * design.chain.efficiency)
        air_kg_per_m3 = float(MISSION.air_state().density_kg_per_m3)
        dynamic = 0.5 * air_kg_per_m3 * float(design.airspeed_m_per_s) ** 3
        assert power_w == pytest.approx(
            dynamic * float(design.wing_area_m2) * drag["total"], rel=1e-9
        )


def test_a_scan_of_tails_finds_the_same_one() -> None:
    """Without the search: the size whose static margin is that one, of tails that a file gives."""
    sizes = np.linspace(0.3, 0.6, 7)
    margins = [
        flown(craft(FREE, {"airframe.tail.horizontal_volume": float(one)}))[1].static_margin
        for one in sizes
    ]
    assert np.all(np.diff(margins) > 0.0)
    design, _ = flown(craft(HELD))
    # What the scan leaves out is the trim drag, and with it a few grams of propulsion.
    scanned = np.polyval(np.polyfit(margins, sizes, 3), 0.1)
    assert design.horizontal_volume == pytest.approx(scanned, rel=1e-3)


def test_with_the_mass_where_it_would_be_moved_the_tail_is_that_of_the_file() -> None:
    """Both ways to hold a margin are one equation: each finds what the other was given."""
    moving = craft({k: v for k, v in HELD.items() if "balance" not in k})
    design, found = flown(moving)
    assert found.moved is not None
    place = found.moved.x_m / float(found.wing.mean_chord_m)
    design, _ = flown(craft(HELD, {"airframe.balance.positions_chords.battery": place}))
    assert design.horizontal_volume == pytest.approx(0.45, rel=1e-8)


def test_arrays_of_designs_are_the_same_as_single_ones() -> None:
    aircraft = craft(HELD)
    some = variables_of(aircraft)._replace(wingspan_m=np.array([4.5, 5.0, 30.0]))
    many, one = closed_design(aircraft, MISSION, some), design_of(aircraft, MISSION)
    assert many.total_mass_kg[1] == pytest.approx(one.total_mass_kg, rel=1e-12)
    assert many.horizontal_volume is not None
    assert many.horizontal_volume[1] == pytest.approx(one.horizontal_volume, rel=1e-9)
    assert many.horizontal_volume[0] != pytest.approx(one.horizontal_volume, rel=1e-3)


def test_an_area_in_the_file_is_replaced() -> None:
    area = {"airframe.tail.horizontal_volume": None, "airframe.tail.horizontal_area_m2": 0.3}
    by_volume, by_area = (flown(craft(HELD, one))[0] for one in ({}, area))
    assert by_area.horizontal_volume == pytest.approx(by_volume.horizontal_volume, rel=1e-9)


@pytest.fixture(scope="module")
def sized() -> sizing.SizingStudy:
    return sizing.size(craft(HELD), MISSION)


def test_a_sizing_holds_the_margin(sized: sizing.SizingStudy) -> None:
    assert sized.status.name == "optimal"
    assert sized.balance is not None
    assert sized.balance.static_margin == pytest.approx(0.1, abs=1e-6)
    # The file that it writes is an aircraft of the same mass, whose tail the file has.
    again = design_of(sized.sized_aircraft(), MISSION)
    assert sized.design is not None
    assert again.total_mass_kg == pytest.approx(float(sized.design.total_mass_kg), rel=1e-6)
    tail = sized.sized_aircraft().airframe.tail  # type: ignore[union-attr]  # parametric
    assert tail is not None
    assert tail.horizontal_volume == pytest.approx(again.horizontal_volume, rel=1e-6)


def test_a_sizing_lies_between_those_of_given_tails(sized: sizing.SizingStudy) -> None:
    """Sizings with a tail of the file, the mass moved instead: it crosses the place it had."""
    assert sized.design is not None
    volume = float(sized.design.horizontal_volume or 0.0)
    masses, places = [], []
    for factor in (0.9, 1.0, 1.1):
        size = {"airframe.tail.horizontal_volume": factor * volume}
        study = sizing.size(craft(HELD, size, {"airframe.balance.held_by": "moved_mass"}), MISSION)
        assert study.balance is not None
        assert study.balance.moved is not None
        assert study.design is not None
        masses.append(float(study.design.total_mass_kg))
        places.append(study.balance.moved.x_m / float(study.balance.wing.mean_chord_m))
    assert masses[0] < masses[1] < masses[2]
    assert places[0] < 0.43 < places[1] < 0.47 < places[2]
    assert masses[1] == pytest.approx(float(sized.design.total_mass_kg), rel=1e-4)


def test_a_grid_of_designs_with_tails_of_their_own_finds_none_better(
    sized: sizing.SizingStudy,
) -> None:
    checked = cross_check(craft(HELD), MISSION, sized.result)
    assert checked.cross_checked
    assert checked.designs_tried > 100


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"airframe.balance.positions_chords.battery": 8.0}, r"it is -\d"),
        ({"airframe.balance.positions_chords.battery": -3.0}, "smallest volume coefficient, 0.05"),
        ({"airframe.balance.maximum_horizontal_volume": 0.3}, r"0\.0\d+ with the largest, 0\.3"),
    ],
)
def test_no_tail_holds_the_margin(changes: dict[str, Any], text: str) -> None:
    aircraft = craft(HELD, changes)
    with pytest.raises(ImpossibleDesignError, match=text):
        design_of(aircraft, MISSION)


@pytest.mark.parametrize("place", [-3.0, 8.0])
def test_a_sizing_without_a_tail_that_would_do_says_so(place: float) -> None:
    """To either side: stable without a tail, and unstable with the largest."""
    changes = {
        "airframe.balance.positions_chords.battery": place,
        "airframe.distributed_battery_fraction": 0.0,
    }
    study = sizing.size(craft(HELD, changes), MISSION)
    assert study.status.name == "infeasible"
    texts = [one.text for one in study.result.violations]
    assert any("static margin is off by" in text for text in texts), texts


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"airframe.balance.static_margin": None}, "static_margin: required key is missing: held_"),
        ({"airframe.balance.maximum_horizontal_volume": 0.04}, "above minimum_horizontal_volume"),
        ({"airframe.balance.held_by": "fin"}, "held_by"),
    ],
)
def test_bad_input(changes: dict[str, Any], text: str) -> None:
    with pytest.raises(InputError, match=text):
        craft(HELD, changes)


def test_draws_have_the_tail_that_is_built() -> None:
    from sizing.uncertainty.propagation import Propagation

    aircraft = craft(HELD)
    flights = Propagation(aircraft, MISSION, UNCORRECTED_CAM)
    avionics = np.array([1.0, 1.2])
    drawn = flights.flights({"airframe.avionics_mass_kg": avionics})
    built = design_of(aircraft, MISSION)
    assert drawn.total_mass_kg[0] == pytest.approx(float(built.total_mass_kg), rel=1e-9)
    tail = {"airframe.tail.horizontal_volume": built.horizontal_volume}
    # That of the file with this tail and no search for it, but the mass that is moved.
    fixed = craft(HELD, tail, {"airframe.balance.held_by": "moved_mass"})
    heavier = design_of(
        fixed.model_copy(
            update={"airframe": fixed.airframe.model_copy(update={"avionics_mass_kg": 1.2})}
        ),
        MISSION,
    )
    assert drawn.total_mass_kg[1] == pytest.approx(float(heavier.total_mass_kg), rel=1e-9)
