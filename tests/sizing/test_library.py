from importlib import resources
from pathlib import Path

import pytest

from missions.files.errors import InputError
from missions.files.shipped import find_document
from missions.files.validation import validate
from missions.files.writing import to_yaml
from missions.files.yaml import parse_yaml
from missions.library import load_mission
from sizing.aircraft import Aircraft
from sizing.library import load_aircraft
from sizing.performance import performance
from sizing.program.size import size_aircraft

WING = {"model": "wing_polar", "design_aspect_ratio": 18.5, "design_reynolds": 158_000.0}
SHIPPED = resources.files("sizing").joinpath("data", "polars", "e214.csv").read_text("utf-8")


def airfoil_of(aircraft):
    return aircraft.airframe.aerodynamics.airfoil


def write_bird(file, airfoil):
    """Write an aircraft whose wing has an airfoil."""
    data = find_document("aircraft", "atlantiksolar-design").data
    data["airframe"]["aerodynamics"] = {**WING, "airfoil": airfoil}
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(to_yaml(data), encoding="utf-8")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Folder with an aircraft and its polar beside it; the working folder is another one."""
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    write_bird(tmp_path / "hangar" / "bird.yaml", "polars/own.csv")
    (tmp_path / "hangar" / "polars").mkdir()
    polar = tmp_path / "hangar" / "polars" / "own.csv"
    polar.write_text(SHIPPED, encoding="utf-8")
    return tmp_path / "hangar"


def test_polar_is_looked_for_beside_the_file_that_names_it(folder):
    found = str(folder / "polars" / "own.csv")
    for name in ("../hangar/bird.yaml", f"{folder}/bird.yaml"):
        assert airfoil_of(load_aircraft(name)) == found
    # What a command writes from the data of a file, as a sized aircraft, goes to other folders.
    document = find_document("aircraft", str(folder / "bird.yaml"))
    copied = validate(parse_yaml(to_yaml(document.data), "copy"), Aircraft)
    assert airfoil_of(copied) == found
    (folder / "e214").write_text("no polar", encoding="utf-8")
    for airfoil in ("e214", "none.csv"):
        write_bird(folder / f"{airfoil}.yaml", airfoil)
    assert airfoil_of(load_aircraft(folder / "e214.yaml")) == "e214"  # of the shipped ones
    with pytest.raises(InputError, match=rf"{folder}/none\.csv: no such file"):
        load_aircraft(folder / "none.csv.yaml")


def test_polar_of_an_override_is_looked_for_in_the_working_folder(folder):
    Path("mine.csv").write_text(SHIPPED, encoding="utf-8")
    override = "airframe.aerodynamics.airfoil=mine.csv"
    assert airfoil_of(load_aircraft(folder / "bird.yaml", [override])) == str(
        Path.cwd() / "mine.csv"
    )
    with pytest.raises(InputError, match=r"hangar.none\.csv"):
        load_aircraft(folder / "bird.yaml", ["airframe.aerodynamics.airfoil=../hangar/none.csv"])


def test_text_that_only_looks_like_a_file_stays(folder):
    text = (folder / "bird.yaml").read_text("utf-8")
    (folder / "bird.yaml").write_text(
        f"description: own.csv\n{text}".replace("\ndescription", "\n# ")
    )
    assert load_aircraft(folder / "bird.yaml").description == "own.csv"


def test_files_show_themselves_in_one_line():
    aircraft, mission = load_aircraft("sky-sailor"), load_mission("central-europe-summer")
    assert repr(aircraft) == str(aircraft)
    for record, words in (
        (aircraft, ("Aircraft name sky-sailor", "wingspan [m] 3.2", "battery [kg] 1.06")),
        (mission, ("Mission name central-europe-summer", "45° N to 50° N", "1 May to 15 Aug")),
        (performance(aircraft, mission), ("Performance of 1 design", "9 scenario(s)")),
    ):
        assert len(repr(record).splitlines()) == 1
        assert len(repr(record)) < 160
        assert all(word in repr(record) for word in words), repr(record)
    odd = aircraft.model_copy(update={"name": "<b>"})
    assert "<td>&lt;b&gt;</td>" in odd._repr_html_()
    assert repr(load_mission("rafz-july")).count("15 Jul") == 1


@pytest.mark.parametrize(
    ("name", "value"), [("wingspan_m", 4.0), ("battery_mass_kg", 2.5), ("module_area_m2", 1.3)]
)
def test_equal_bounds_hold_a_variable(name, value):
    held = {f"design_space.{name}": {"minimum": value, "maximum": value}}
    result = size_aircraft(load_aircraft("atlantiksolar-design", held), load_mission("rafz-july"))
    assert getattr(result.design.variables, name) == pytest.approx(value, rel=1e-9)
    assert not [text for text in result.active_constraints if text.startswith(name)]
