"""Structural models beside built aircraft: cases, figure, tables, and the script that draws."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.validation.built_aircraft import ATLANTIKSOLAR, SKY_SAILOR, calibrated_rib_wing
from benchmarks.validation.structure_comparison import (
    BUILT,
    family,
    in_words,
    main,
    models,
    structure_figure,
)
from missions.library import load_mission
from sizing.aircraft import ParametricAirframe
from sizing.design import variables_of
from sizing.library import load_aircraft
from sizing.mass_budget import closed_design, design_of
from sizing.sized_structure import structure_parts
from sizing.structures.models import AllPowerLawStructure
from sizing.structures.torsion import WingTorsion

DESIGN = "atlantiksolar-design"


def test_one_factor_fits_atlantiksolar_and_sky_sailor_is_told_honestly() -> None:
    model = calibrated_rib_wing()
    # Published range of AtlantikSolar's structure; the factor is fitted to its middle.
    assert ATLANTIKSOLAR.mass_kg(model) == pytest.approx(1.35, abs=0.005)
    # Nothing fitted: one fifth is what the documentation admits to, and it is on the light side.
    assert 0.80 * 0.725 < SKY_SAILOR.mass_kg(model) < 0.725


def test_calibration_and_stiffness_are_all_that_the_file_says() -> None:
    # All other inputs are the model's own constants, the same for every aircraft.
    model = calibrated_rib_wing()
    stiffness = {"gusts_fall_with_altitude", "torsion"}
    battery = {"spar_battery_density_kg_per_m3", "pod_battery_mount_fraction"}
    assert model.model_fields_set == {"model", "build", "calibration"} | stiffness | battery
    assert model.torsion == WingTorsion()


def test_calibration_is_near_that_of_the_published_tool() -> None:
    # 1.21 with other assumptions on film, ribs and joints: a fifth either way is not another model.
    assert calibrated_rib_wing().calibration == pytest.approx(1.21, rel=0.2)


def test_case_agrees_with_the_shipped_design() -> None:
    aircraft, mission = load_aircraft(DESIGN), load_mission("rafz-july")
    design = design_of(aircraft, mission)
    # Air of 1.09 instead of 1.10 kg/m3, and 6.922 instead of 6.92 kg.
    assert ATLANTIKSOLAR.mass_kg(calibrated_rib_wing()) == pytest.approx(
        design.masses.structure, rel=2e-3
    )


def test_parts_of_a_design_add_up_to_its_structure() -> None:
    aircraft, mission = load_aircraft(DESIGN), load_mission("rafz-july")
    design = closed_design(aircraft, mission, variables_of(aircraft))
    parts = structure_parts(aircraft, mission, design)
    assert float(parts.total_kg) == pytest.approx(float(design.masses.structure), rel=1e-12)


@pytest.mark.parametrize("name", ["sky-sailor", "atlantiksolar-as2"])
def test_other_models_know_no_parts(name: str) -> None:
    aircraft, mission = load_aircraft(name), load_mission("rafz-july")
    assert structure_parts(aircraft, mission, design_of(aircraft, mission)) is None


def test_family_keeps_proportions() -> None:
    wide = family(11.3)
    # Twice the span: four times the mass at the same wing loading.
    assert wide.total_mass_kg == pytest.approx(4.0 * 6.92)
    assert wide.span_load_kg / wide.total_mass_kg == pytest.approx(
        ATLANTIKSOLAR.span_load_kg / 6.92
    )
    with pytest.raises(ValueError, match="no built aircraft"):
        _ = wide.built_kg


def test_every_model_is_chosen_by_a_file() -> None:
    for choice in ("rib_wing", "spar", "power_law", "power_law_all"):
        aircraft = load_aircraft(DESIGN, [f"airframe.structure={{model: {choice}}}"])
        assert isinstance(aircraft.airframe, ParametricAirframe)
        assert aircraft.airframe.structure.model == choice
    assert isinstance(aircraft.airframe.structure, AllPowerLawStructure)


def test_figure_shows_every_model_and_both_aircraft() -> None:
    (axes,) = structure_figure().axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]  # type: ignore[union-attr]
    assert {in_words(name) for name in models()} <= set(labels)
    for case in BUILT:
        (point,) = [
            line for line in axes.lines if str(line.get_label()).startswith(f"{case.name},")
        ]
        assert list(point.get_xdata()) == [case.wingspan_m]  # type: ignore[arg-type]
        assert list(point.get_ydata()) == [case.built_kg]  # type: ignore[arg-type]
    assert "[m]" in axes.get_xlabel()
    assert "[kg]" in axes.get_ylabel()
    for name, model in models().items():
        (line,) = [each for each in axes.lines if each.get_label() == in_words(name)]
        span_m, mass_kg = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        assert span_m[0] == pytest.approx(2.0)
        assert span_m[-1] == pytest.approx(30.0)
        assert np.all(np.diff(mass_kg) > 0.0)
        assert mass_kg[7] == pytest.approx(float(family(float(span_m[7])).mass_kg(model)))


def test_script_writes_the_figure(tmp_path: Path) -> None:
    target = tmp_path / "masses.png"
    assert main(["--out", str(target)]) == 0
    assert target.read_bytes().startswith(b"\x89PNG")


def test_script_says_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--out", str(tmp_path / "missing" / "masses.png")]) == 1
    assert "its folder does not exist" in capsys.readouterr().err
    with pytest.raises(SystemExit) as stopped:
        main(["--out", str(tmp_path / "masses.gif")])
    assert stopped.value.code == 2
    assert ".png, .svg, .pdf" in capsys.readouterr().err
