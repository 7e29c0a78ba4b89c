"""Tests of the check of aircraft and mission files against their models."""

import pickle
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError
from refusals import refusals

from missions.files.errors import InputError, Problem
from missions.files.overrides import with_overrides, with_values
from missions.files.validation import located_error, validate
from missions.files.yaml import Document, parse_yaml, read_yaml
from solar.schema import (
    Flag,
    Fraction,
    NonNegativeReal,
    PositiveInteger,
    PositiveReal,
    Real,
    Record,
    Text,
)
from solar.versions import DeprecatedKeyWarning


class Battery(Record):
    mass_kg: PositiveReal
    usable_fraction: Fraction = 0.9
    cells: PositiveInteger = 1


class Cruise(Record):
    kind: Literal["cruise"]
    speed_m_s: PositiveReal


class Loiter(Record):
    kind: Literal["loiter"]
    duration_h: PositiveReal
    # Named like a choice of the union, to prove that names of choices are told from keys.
    loiter: Battery | None = None


Leg = Annotated[Cruise | Loiter, Field(discriminator="kind")]


class Window(Record):
    start_h: Real
    end_h: Real

    @model_validator(mode="after")
    def _in_order(self):
        if self.end_h < self.start_h:
            raise ValueError("the window ends before it starts")
        if self.end_h > 24:
            raise PydanticCustomError("late", "ends after midnight", {"key": "end_h"})
        return self


class Aircraft(Record):
    name: Text
    battery: Battery
    spare: Battery | None = None
    legs: tuple[Leg, ...] = ()
    window: Window | None = None
    polar: tuple[Real, Real, Real] | None = None
    table: dict[str, PositiveReal] = Field(default={})
    size: PositiveReal | Literal["auto"] = "auto"
    curve: PositiveReal | Battery = 1.0
    airfoil: Literal["sd7037", "e387"] = "e387"
    tested: Flag = False
    tail_m2: NonNegativeReal = 0.0


GOOD = """\
name: AS-2
battery:
  mass_kg: 2.9
"""


def problems_of(text, *overrides, model=Aircraft):
    with pytest.raises(InputError) as caught:
        validate(with_overrides(parse_yaml(text, "as2.yaml"), overrides), model)
    return [str(problem) for problem in caught.value.problems]


def problem_of(text, *overrides):
    (problem,) = problems_of(text, *overrides)
    return problem


def test_good_file_is_read(tmp_path):
    path = tmp_path / "as2.yaml"
    path.write_text(GOOD + "legs:\n- {kind: cruise, speed_m_s: 9}\npolar: [1, 2.5, 1e-3]\n")
    aircraft = validate(with_overrides(read_yaml(path), ["battery.cells=6"]), Aircraft)
    assert aircraft.battery == Battery(mass_kg=2.9, cells=6)
    assert aircraft.legs == (Cruise(kind="cruise", speed_m_s=9.0),)
    assert aircraft.polar == (1.0, 2.5, 0.001)


def test_integers_too_large_for_a_float_are_not_finite():
    text = "name: x\nbattery:\n  mass_kg: "
    assert problem_of(text + "9" * 5000).endswith("mass_kg: must be a finite number (got .inf)")
    message = problem_of(text + "9" * 400)
    assert "battery.mass_kg: must be a finite number (got 999" in message
    assert len(message) < 150


def test_input_error_keeps_its_problems_through_pickling():
    error = InputError([Problem("b", 2, 1, "k", "m"), Problem("b", 1, None, "", "n")])
    assert str(error) == "b:1: n\nb:2:1: k: m"
    assert pickle.loads(pickle.dumps(error)).problems == error.problems
    assert isinstance(error, ValueError)


def test_plain_pydantic_error_is_not_shown_as_the_cause():
    with pytest.raises(InputError) as caught:
        validate(parse_yaml("{}", "a.yaml"), Aircraft)
    assert caught.value.__context__ is None


class Table(Record):
    title: Annotated[Text, Field(max_length=3)]
    values: tuple[PositiveReal, ...] = Field(min_length=2)


class OldPack(Battery):
    explained_keys: ClassVar[dict[str, str]] = {"weight_kg": "mass_kg"}


class Packs(Record):
    packs: tuple[OldPack, ...]


class Units(Record):
    energy_kwh_max: Real = 1.0
    energy_j: Real = 1.0


class Choices(Record):
    window: Real | Window = 1.0
    source: Window | Real | None = None
    other: Window | Battery | None = None
    pair: tuple[Battery, Cruise] | None = None


class Short(Record):
    table: dict[Annotated[str, Field(max_length=1)], Real]
    items: Annotated[tuple[Real, ...], Field(max_length=1)]


class Aliased(Record):
    lift: PositiveReal = Field(alias="C_L")


class Pointing(Record):
    legs: tuple[Real, ...]

    @model_validator(mode="after")
    def _refuse(self):
        raise PydanticCustomError("x", "too\nlong", {"key": "legs.1"})


NO_KEY = "unknown key; allowed keys"


@pytest.mark.parametrize(
    ("model", "text", "told"), refusals(Path(__file__).with_name("mistakes.txt"))
)
def test_mistakes_are_told_where_they_stand_in_these_words(model, text, told):
    name, _, behind_good = model.partition(" behind ")
    whole = (GOOD if behind_good else "") + text.replace("\\n", "\n")
    problems = problems_of(whole, model=globals()[name])
    assert problems == [f"as2.yaml:{problem}" for problem in told.split(" | ")]


def test_validators_do_not_hide_the_name_of_a_choice():
    problems = problems_of("other: {start_h: 1, end_h: 2, zzz: 3}", model=Choices)
    first = next(problem for problem in problems if "zzz" in problem)
    assert first.endswith("allowed keys: start_h, end_h")


class Rack(Battery):
    deprecated_keys: ClassVar[dict[str, str]] = {"weight_kg": "mass_kg"}


class Racks(Record):
    deprecated_keys: ClassVar[dict[str, str]] = {"racks": "packs"}

    packs: tuple[Rack, ...]


def test_deprecated_keys_are_read_with_a_warning_that_has_line_and_new_name():
    document = parse_yaml("racks:\n- mass_kg: 1\n- weight_kg: 2\n", "as2.yaml")
    with pytest.warns(DeprecatedKeyWarning) as told:
        read = validate(document, Racks)
    assert [pack.mass_kg for pack in read.packs] == [1.0, 2.0]
    new = "is called '{}' now; version 3.0 refuses the old name"
    assert [str(one.message) for one in told] == [
        f"as2.yaml:1:1: racks: {new.format('packs')}",
        f"as2.yaml:3:3: packs.1.weight_kg: {new.format('mass_kg')}",
    ]
    assert document.data == {"racks": [{"mass_kg": 1}, {"weight_kg": 2}]}


def test_mistakes_beside_a_deprecated_key_keep_their_places():
    text = "racks:\n- weight_kg: -1\n- mass_kg: 2\n  cell: 2\n"
    with pytest.warns(DeprecatedKeyWarning):
        assert problems_of(text, model=Racks) == [
            "as2.yaml:2:14: packs.0.mass_kg: must be greater than 0 (got -1)",
            "as2.yaml:4:3: packs.1.cell: unknown key; did you mean 'cells'?",
        ]
    # A deprecated key beside its new name is refused.
    assert problems_of("packs:\n- mass_kg: 1\n  weight_kg: 2\n", model=Racks) == [
        "as2.yaml:3:3: packs.0.weight_kg: this key is called 'mass_kg' now"
    ]


def test_located_error():
    document = with_overrides(parse_yaml(GOOD, "as2.yaml"), ["tail_m2=1"])
    (problem,) = located_error(document, ("battery", "mass_kg"), "too heavy").problems
    assert problem == Problem("as2.yaml", 3, 12, "battery.mass_kg", "too heavy")
    assert str(located_error(document, ["battery"], "m")) == "as2.yaml:2:1: battery: m"
    assert str(located_error(document, ["battery", "x"], "m")) == "as2.yaml:2:1: battery.x: m"
    assert str(located_error(document, ["tail_m2"], "m")) == "--set tail_m2: m"
    assert str(located_error(document, [], "m")) == "as2.yaml:1:1: m"
    assert str(located_error(Document("b.yaml", {}), ["a"], "m")) == "b.yaml: a: m"


pieces = st.sampled_from(
    [*"ab:-[]{},&*!?|>'\"#%@` \n\t~<=.", "\n  ", ": ", "- ", "&a", "*a", "<<: ", "---\n", "1e5"]
)


@given(st.lists(pieces | st.characters(), max_size=40).map("".join))
def test_any_text_is_read_or_refused_with_a_place(text):
    problems = ()
    try:
        document = with_overrides(parse_yaml(GOOD + text, "a.yaml"), [f"battery.{text}"])
        validate(document, Aircraft)
    except InputError as error:
        problems = error.problems
    for problem in map(str, problems):
        assert problem.startswith(("a.yaml", "--set "))
        assert len(problem.encode("utf-8").decode("utf-8").splitlines()) == 1


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("battery.mass_kg=-2.9", "battery.mass_kg: must be greater than 0 (got -2.9)"),
        ("battery.mass_g=1", "battery.mass_g: unknown key; did you mean 'mass_kg'?"),
        ("batery.mass_kg=1", "batery.mass_kg: batery: unknown key; did you mean 'battery'?"),
        ("spare.cells=2", "spare.cells: spare.mass_kg: required key is missing"),
        ("battery={mass_kg: 0}", "battery: battery.mass_kg: must be greater than 0 (got 0)"),
        ("polar=[1, x, 2]", "polar: polar.1: must be a number (got 'x')"),
    ],
)
def test_problems_of_overrides_are_located_at_the_option(override, message):
    assert problem_of(GOOD, override) == f"--set {message}"


def test_override_mends_a_value_of_the_file():
    text = "name: x\nbattery: 3\n"
    document = with_overrides(parse_yaml(text, "a.yaml"), ["battery={mass_kg: 2}"])
    assert validate(document, Aircraft).battery.mass_kg == 2
    assert document.places["battery",].key is None


def test_override_below_an_override_leaves_the_first_in_its_place():
    overrides = ["window={start_h: 3, end_h: x}", "window.start_h=y"]
    assert problems_of(GOOD, *overrides) == [
        "--set window.start_h: must be a number (got 'y')",
        "--set window: window.end_h: must be a number (got 'x')",
    ]


def test_problems_of_the_file_come_before_those_of_overrides():
    problems = problems_of("battery:\n  mass_kg: 0\n", "tail_m2=-1", "name=x")
    assert [problem.split(":")[0] for problem in problems] == ["as2.yaml", "--set tail_m2"]


PLANE = Aircraft(
    name="AS-2",
    battery=Battery(mass_kg=2.9),
    legs=(Cruise(kind="cruise", speed_m_s=9.0), Loiter(kind="loiter", duration_h=1.0)),
    table={"a": 1.0},
)


def test_copy_with_values_of_records_inside_records():
    changed = with_values(
        PLANE,
        {
            "name": "AS-3",
            "battery.mass_kg": 3.5,
            "legs.1.duration_h": 2.0,
            "table.b": 2.0,
            "spare.mass_kg": 1.0,
            "window": Window(start_h=3.0, end_h=4.0),
        },
    )
    assert changed.battery == Battery(mass_kg=3.5)
    assert changed.legs == (PLANE.legs[0], Loiter(kind="loiter", duration_h=2.0))
    assert changed.table == {"a": 1.0, "b": 2.0}
    assert changed.spare == Battery(mass_kg=1.0)
    assert (changed.name, changed.window) == ("AS-3", Window(start_h=3.0, end_h=4.0))
    assert PLANE.battery.mass_kg == 2.9
    assert PLANE.table == {"a": 1.0}
    assert with_values(PLANE, {}) == PLANE


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"battery.mass_kg": -1.0}, "battery.mass_kg: must be greater than 0 (got -1.0)"),
        ({"battery.mass_g": 1.0}, "battery.mass_g: unknown key; did you mean 'mass_kg'?"),
        ({"legs.0.speed_m_s": 0.0}, "legs.0.speed_m_s: must be greater than 0 (got 0.0)"),
        (
            {"legs.7.speed_m_s": 1.0},
            "legs.7.speed_m_s: legs is a list and takes an index from 0 to 1 (got '7')",
        ),
        ({"name.x": 1.0}, "name.x: name is the single value 'AS-2' and has no keys"),
        ({"window": {"start_h": 5.0, "end_h": 4.0}}, "window: the window ends before it starts"),
    ],
)
def test_copy_with_values_is_checked(values, message):
    with pytest.raises(InputError) as caught:
        with_values(PLANE, values)
    assert str(caught.value) == f"Aircraft: {message}"
