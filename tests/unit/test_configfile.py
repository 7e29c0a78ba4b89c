"""Tests of the strict, located reader of aircraft and mission files."""

from __future__ import annotations

import enum
import math
import os
import pickle
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, NewType

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import Discriminator, Field, RootModel, TypeAdapter, ValidationError, model_validator
from pydantic import Tag as UnionTag
from pydantic_core import PydanticCustomError

from missions import configfile
from missions.configfile import (
    Document,
    InputError,
    OutputError,
    Problem,
    load,
    located_error,
    parse_yaml,
    read_yaml,
    to_yaml,
    validate,
    with_overrides,
    write_bytes_atomically,
    write_text_atomically,
)
from solar.schema import (
    Flag,
    Fraction,
    Integer,
    NonNegativeInteger,
    NonNegativeReal,
    PositiveInteger,
    PositiveReal,
    Real,
    Record,
    Text,
    UnitInterval,
)


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
    def _in_order(self) -> Window:
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


def problems_of(text: str, *overrides: str, model: type[Record] = Aircraft) -> list[str]:
    with pytest.raises(InputError) as caught:
        validate(with_overrides(parse_yaml(text, "as2.yaml"), overrides), model)
    return [str(problem) for problem in caught.value.problems]


def problem_of(text: str, *overrides: str) -> str:
    (problem,) = problems_of(text, *overrides)
    return problem


def parse_problem(text: str) -> str:
    with pytest.raises(InputError) as caught:
        parse_yaml(text, "a.yaml")
    return str(caught.value)


@pytest.fixture(params=["libyaml", "python"])
def parser(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    if request.param == "python":
        monkeypatch.setattr(configfile, "_Parser", yaml.SafeLoader)
    elif not hasattr(yaml, "CSafeLoader"):
        pytest.skip("PyYAML without libyaml")
    return str(request.param)


# ---- field types ----


@pytest.mark.parametrize(
    ("kind", "good", "bad"),
    [
        (Real, [-1.5, 0, 3], [True, "1", math.inf, math.nan, None]),
        (PositiveReal, [1, 0.1], [0, -1, True, math.inf]),
        (NonNegativeReal, [0, 1], [-1e-9, "0"]),
        (Fraction, [1, 0.5], [0, 1.01, True]),
        (UnitInterval, [0, 1, 0.5], [-0.01, 1.01, False]),
        (Integer, [0, -3], [1.0, True, "3"]),
        (PositiveInteger, [1], [0, 1.0, True]),
        (NonNegativeInteger, [0, 2], [-1, 1.0, False]),
        (Flag, [True, False], [1, "true"]),
        (Text, ["a"], ["", 1]),
    ],
)
def test_field_types(kind: Any, good: list[object], bad: list[object]) -> None:
    adapter = TypeAdapter(kind)
    for value in good:
        assert adapter.validate_python(value) == value
    for value in bad:
        with pytest.raises(ValidationError):
            adapter.validate_python(value)


def test_records_are_frozen_and_check_their_defaults() -> None:
    class Wrong(Record):
        mass_kg: PositiveReal = -1.0

    with pytest.raises(ValidationError):
        Battery(mass_kg=1.0).mass_kg = 2.0  # type: ignore[misc]
    with pytest.raises(ValidationError):
        Wrong()


# ---- reading ----


def test_good_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "as2.yaml"
    path.write_text(
        GOOD + "legs:\n- {kind: cruise, speed_m_s: 9}\npolar: [1, 2.5, 1e-3]\n", encoding="utf-8"
    )
    aircraft = load(path, Aircraft, ["battery.cells=6"])
    assert aircraft.battery == Battery(mass_kg=2.9, cells=6)
    assert aircraft.legs == (Cruise(kind="cruise", speed_m_s=9.0),)
    assert aircraft.polar == (1.0, 2.5, 0.001)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True),
        ("False", False),
        ("null", None),
        ("~", None),
        ("", None),
        ("7", 7),
        ("+7", 7),
        ("-0", 0),
        ("2.50", 2.5),
        (".5", 0.5),
        ("1.", 1.0),
        ("1e5", 1e5),
        ("1e-3", 1e-3),
        ("1.5E+3", 1.5e3),
        ("1e999", math.inf),
        (".inf", math.inf),
        ("-.INF", -math.inf),
        ("12:30", "12:30"),
        ("12:30:45", "12:30:45"),
        ("2015-06-21", "2015-06-21"),
        ("no", "no"),
        ("on", "on"),
        ("y", "y"),
        ("010", "010"),
        ("0o17", "0o17"),
        ("0x1F", "0x1F"),
        ("1_000", "1_000"),
        ("=", "="),
        ("inf", "inf"),
        ("nan", "nan"),
        ("'2.9'", "2.9"),
        ('"true"', "true"),
        ("''", ""),
        ("|-\n  7", "7"),
    ],
)
def test_scalars(parser: str, text: str, value: object) -> None:
    data = parse_yaml(f"a: {text}\n", "a.yaml").data
    assert data == {"a": value}
    assert type(data["a"]) is type(value)


def test_not_a_number_is_a_float() -> None:
    assert math.isnan(parse_yaml("a: .nan", "a.yaml").data["a"])


def test_integers_of_thousands_of_digits_are_not_finite() -> None:
    text = "name: x\nbattery:\n  mass_kg: " + "9" * 5000
    assert problem_of(text).endswith("battery.mass_kg: must be a finite number (got .inf)")


def test_integers_too_large_for_a_float_are_not_finite() -> None:
    text = "name: x\nbattery:\n  mass_kg: " + "9" * 400
    message = problem_of(text)
    assert "battery.mass_kg: must be a finite number (got 999" in message
    assert len(message) < 150


def test_marks_tell_keys_from_values(parser: str) -> None:
    document = parse_yaml("a: 1\nb:\n  c: [5, 6]\n  d:\n", "a.yaml")
    assert document.marks.keys == {
        ("a",): (1, 1),
        ("b",): (2, 1),
        ("b", "c"): (3, 3),
        ("b", "d"): (4, 3),
    }
    assert document.marks.values == {
        (): (1, 1),
        ("a",): (1, 4),
        ("b",): (3, 3),
        ("b", "c"): (3, 6),
        ("b", "c", 0): (3, 7),
        ("b", "c", 1): (3, 10),
        ("b", "d"): (4, 5),
    }


def test_byte_order_mark_is_no_part_of_the_text(parser: str, tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\n")
    document = read_yaml(path)
    assert document.data == {"a": 1}
    assert document.marks.keys["a",] == (1, 1)


# ---- text that is refused ----


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: !!float 1", "a.yaml:1:4: a: explicit tags (!!float) are not allowed"),
        ("a: !x {b: 1}", "a.yaml:1:4: a: explicit tags (!x) are not allowed"),
        ("a: !!set [b]", "a.yaml:1:4: a: explicit tags (!!set) are not allowed"),
        ("a: ! 1", "a.yaml:1:4: a: explicit tags (!) are not allowed"),
        (
            "a:\n  <<: {b: 1}",
            "a.yaml:2:3: a: merge keys (<<) are not allowed; write the keys out",
        ),
        ("1: a", "a.yaml:1:1: a key must be text (got 1); put it in quotes"),
        ("true: a", "a.yaml:1:1: a key must be text (got true); put it in quotes"),
        ("? [a]\n: b", "a.yaml:1:3: a key must be text (got a list)"),
        ("? {a: 1}\n: b", "a.yaml:1:3: a key must be text (got a mapping)"),
        ("a: &x b\n*x : c", "a.yaml:2:1: a key must be text (got an alias)"),
        ("a: 1\nb: 2\na: 3", "a.yaml:3:1: a: duplicate key (first at line 1)"),
        ("a: {b: 1, b: 2}", "a.yaml:1:11: a.b: duplicate key (first at line 1)"),
        ("a: 1\n---\nb: 2", "a.yaml:2:1: only one document (---) is allowed per file"),
        ("", "a.yaml: the file is empty; it must hold a mapping (key: value)"),
        ("# only words\n", "a.yaml: the file is empty; it must hold a mapping (key: value)"),
        ("---\n", "a.yaml: the file is empty; it must hold a mapping (key: value)"),
        ("- 1\n", "a.yaml:1:1: the top level must be a mapping (key: value), not a list"),
        (
            "\nwords\n",
            "a.yaml:2:1: the top level must be a mapping (key: value), "
            "not the single value 'words'",
        ),
        (
            "~",
            "a.yaml:1:1: the top level must be a mapping (key: value), not the single value null",
        ),
        ("a: *x", "a.yaml:1:4: a: alias *x has no anchor before it"),
        ("a: &x [1, *x]", "a.yaml:1:11: a.1: alias *x refers to a value that contains it"),
        ("a: &x\n  b: *x", "a.yaml:2:6: a.b: alias *x refers to a value that contains it"),
        ("a: &x 1\nb: &x 2", "a.yaml:2:4: b: anchor &x is defined twice"),
        ("a: 1\nb: x\x07y", "a.yaml:2:5: character U+0007 is not allowed"),
        ("a: \ud800", "a.yaml:1:4: character U+D800 is not allowed"),
    ],
)
def test_refused_text(parser: str, text: str, message: str) -> None:
    assert parse_problem(text) == message


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("a: [1, 2", "a.yaml:"),
        ("a: 'open", "a.yaml:1:"),
        ("a: 1\n b: 2", "a.yaml:2:"),
        ("a: @b", "a.yaml:1:4: "),
        ("a: b: c", "a.yaml:1:5: "),
        ("%YAML 3.0\n---\na: 1", "a.yaml:1:1: "),
    ],
)
def test_syntax_errors_have_a_place(parser: str, text: str, place: str) -> None:
    message = parse_problem(text)
    assert message.startswith(place)
    assert "is not valid YAML: " in message
    assert "\n" not in message


def test_open_brackets_tell_where_they_start(parser: str) -> None:
    assert parse_problem("b: 1\na: [1,\n2\n\n").endswith(" (it starts at line 2)")


def test_tabs_get_a_hint(parser: str) -> None:
    message = parse_problem("a:\n\tb: 1")
    assert message.startswith("a.yaml:2:1: is not valid YAML: ")
    assert message.endswith("; indent with spaces, not tabs")
    assert parse_problem("\ufeffa:\n\tb: 1") == message


def test_all_structural_problems_come_together() -> None:
    lines = parse_problem("a: 1\na: 2\n3: x\nb: !!str x").splitlines()
    assert [line.split(":")[1] for line in lines] == ["2", "3", "4"]


# ---- guards against hostile files ----


@pytest.mark.parametrize(
    "text",
    ["a: " + "[" * 50_000, "a: " + "{" * 50_000, "- " * 50_000, "? " * 50_000, "[a, " * 50_000],
)
def test_deep_nesting_is_refused(parser: str, text: str) -> None:
    assert "nested too deeply (at most 40 levels)" in parse_problem(text)


def test_forty_levels_are_allowed() -> None:
    assert parse_yaml("a: " + "[" * 39 + "]" * 39, "a.yaml").data
    assert "nested too deeply" in parse_problem("a: " + "[" * 40 + "]" * 40)


def test_nesting_through_aliases_is_refused() -> None:
    lines = ["k0: &k0 " + "[" * 38 + "]" * 38]
    lines += [f"k{n}: &k{n} " + "[" * 30 + f"*k{n - 1}" + "]" * 30 for n in range(1, 40)]
    message = parse_problem("\n".join(lines))
    assert message.startswith("a.yaml:2:")
    assert "nested too deeply" in message


def test_alias_bomb_is_refused_at_once() -> None:
    lines = ["k0: &k0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"k{n}: &k{n} [" + ", ".join([f"*k{n - 1}"] * 5) + "]" for n in range(1, 10)]
    start = time.perf_counter()
    message = parse_problem("\n".join(lines))
    assert time.perf_counter() - start < 0.5
    assert "too many values after the expansion of aliases" in message


def test_too_many_aliases_are_refused() -> None:
    assert parse_yaml("a: &x 1\nb: [" + "*x, " * 50 + "]", "a.yaml").data["b"] == [1] * 50
    message = parse_problem("a: &x 1\nb: [" + "*x, " * 51 + "]")
    assert "too many aliases (at most 50)" in message


def test_too_many_values_are_refused() -> None:
    assert "too many values in one file" in parse_problem("a: [" + "1," * 50_001 + "]")


def test_large_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "large.yaml"
    # Cut at the limit, this text ends in half a character.
    path.write_text("a: 1\n#" + "é" * 600_000, encoding="utf-8")
    with pytest.raises(InputError, match=r"large\.yaml: is too large \(at most 1 MB\)"):
        read_yaml(path)
    assert parse_problem("a: " + "é" * 600_000) == "a.yaml: is too large (at most 1 MB)"


def test_aliases_give_independent_copies() -> None:
    document = parse_yaml("a: &x {b: [1]}\nc: *x", "a.yaml")
    assert document.data == {"a": {"b": [1]}, "c": {"b": [1]}}
    changed = with_overrides(document, ["c.b.0=2"])
    assert changed.data == {"a": {"b": [1]}, "c": {"b": [2]}}
    assert document.marks.values["c",] == (2, 4)
    assert document.marks.values["c", "b"] == (1, 11)


# ---- files ----


def read_problem(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_yaml(path)
    return str(caught.value)


def test_missing_file(tmp_path: Path) -> None:
    path = tmp_path / "none.yaml"
    assert read_problem(path) == f"{path}: no such file"


def test_folder(tmp_path: Path) -> None:
    assert read_problem(tmp_path) == f"{tmp_path}: is a folder, not a file"


def test_unreadable_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    path = tmp_path / "a.yaml"
    assert read_problem(path) == f"{path}: cannot be read: permission denied"


def test_path_through_a_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert "cannot be read: not a directory" in read_problem(tmp_path / "file" / "a.yaml")


def test_file_name_that_cannot_be() -> None:
    assert read_problem(Path("a\0b")) == r"a\x00b: is not a valid file name"


def test_file_name_outside_unicode() -> None:
    message = read_problem(Path("a\udcff.yaml"))
    assert message.encode("utf-8") == rb"a\udcff.yaml: no such file"


@pytest.mark.parametrize(
    ("raw", "place"),
    [(b"a: 1\nb: \xe9t\xe9\n", "2:4: is not UTF-8 text (byte 0xe9)"), (b"\xff\xfea\0", "1:1: ")],
)
def test_other_encodings_are_refused(tmp_path: Path, raw: bytes, place: str) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(raw)
    assert read_problem(path).startswith(f"{path}:{place}")


# ---- validation ----


def test_limit_is_named_with_the_value_and_its_place() -> None:
    text = "name: x\nbattery:\n  mass_kg: -2.9\n"
    message = "as2.yaml:3:12: battery.mass_kg: must be greater than 0 (got -2.9)"
    assert problem_of(text) == message


def test_plain_pydantic_error_is_not_shown_as_the_cause() -> None:
    with pytest.raises(InputError) as caught:
        validate(parse_yaml("{}", "a.yaml"), Aircraft)
    assert caught.value.__context__ is None


def test_all_problems_come_together_sorted_by_line() -> None:
    text = "tail_m2: -1\nzzz: 3\nbattery:\n  usable_fraction: 1.5\n  mass_kg: 0\nname: 5\n"
    assert problems_of(text) == [
        "as2.yaml:1:10: tail_m2: must be at least 0 (got -1)",
        "as2.yaml:2:1: zzz: unknown key; allowed keys: name, battery, spare, legs, window, "
        "polar, table, size, curve, airfoil, tested, tail_m2",
        "as2.yaml:4:20: battery.usable_fraction: must be at most 1 (got 1.5)",
        "as2.yaml:5:12: battery.mass_kg: must be greater than 0 (got 0)",
        "as2.yaml:6:7: name: must be text (got 5); put it in quotes",
    ]


def test_missing_key_points_at_the_mapping_around_it() -> None:
    text = "name: x\nbattery:\n  cells: 2\n"
    assert problem_of(text) == "as2.yaml:2:1: battery.mass_kg: required key is missing"
    assert problem_of("\nname: x\n") == "as2.yaml:2:1: battery: required key is missing"
    assert problems_of("{}")[0] == "as2.yaml:1:1: name: required key is missing"


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("cell", "cells"),
        ("Mass_kg", "mass_kg"),
        ("CELL", "cells"),
        ("mass_g", "mass_kg"),
        ("mass", "mass_kg"),
        ("mass_lbs", "mass_kg"),
        ("useable_fraction", "usable_fraction"),
        ("usable_percent", "usable_fraction"),
    ],
)
def test_unknown_key_gets_a_suggestion(key: str, meant: str) -> None:
    text = f"{GOOD}  {key}: 1\n"
    message = f"as2.yaml:4:3: battery.{key}: unknown key; did you mean '{meant}'?"
    assert problem_of(text) == message


def test_unit_suffix_beats_a_similar_spelling() -> None:
    class Model(Record):
        energy_kwh_max: Real = 1.0
        energy_j: Real = 1.0

    (problem,) = problems_of("energy_kwh: 1", model=Model)
    assert problem.endswith("did you mean 'energy_j'?")


@pytest.mark.parametrize("value", ['"2.9 kg"', "2.9 kg", '"2.9"', "2.9kg", "010", "1_000"])
def test_quoted_numbers_and_units_get_a_hint(value: str) -> None:
    message = problem_of(f"name: x\nbattery:\n  mass_kg: {value}\n")
    shown = value.strip('"')
    assert message == (
        f"as2.yaml:3:12: battery.mass_kg: must be a number (got '{shown}'); "
        "write the plain number; the unit is in the key"
    )


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("tail_m2: heavy", "10: tail_m2: must be a number (got 'heavy')"),
        ("tail_m2: true", "10: tail_m2: must be a number (got true)"),
        ("tail_m2:", "9: tail_m2: must be a number (got null)"),
        ("tail_m2: .nan", "10: tail_m2: must be a finite number (got .nan)"),
        ("tail_m2: -.inf", "10: tail_m2: must be a finite number (got -.inf)"),
        ("tail_m2: [1]", "1: tail_m2: must be a number (got a list of 1)"),
        ("tail_m2: " + "x" * 500, "10: tail_m2: must be a number (got '" + "x" * 36 + "...)"),
        ("tested: 1", "9: tested: must be true or false (got 1)"),
        ("tested: yes", "9: tested: must be true or false (got 'yes')"),
        ("airfoil: naca", "10: airfoil: must be 'sd7037' or 'e387' (got 'naca')"),
        ("spare: 3", "8: spare: must be a mapping of keys and values (got 3)"),
        ("legs: 3", "7: legs: must be a list (got 3)"),
        ("polar: [1, 2]", "1: polar: the list is too short: item 3 is missing"),
        ("polar: [1, 2, 3, 4]", "1: polar: must have at most 3 items (got a list of 4)"),
        ("polar: [1, a, 3]", "12: polar.1: must be a number (got 'a')"),
        ("table: {a: -1}", "12: table.a: must be greater than 0 (got -1)"),
        ("size: -1", "7: size: must be greater than 0, or must be 'auto' (got -1)"),
        ("size: big", "7: size: must be a number, or must be 'auto' (got 'big')"),
        (
            "size: '2'",
            "7: size: must be a number, or must be 'auto' (got '2'); "
            "write the plain number; the unit is in the key",
        ),
        ("curve: {mass_kg: -1}", "18: curve.mass_kg: must be greater than 0 (got -1)"),
        ("curve: {mass_g: 1, mass_kg: 1}", "9: curve.mass_g: unknown key; did you mean 'mass_kg'?"),
    ],
)
def test_plain_words(line: str, message: str) -> None:
    assert problem_of(GOOD + line + "\n") == f"as2.yaml:4:{message}"


def test_null_for_a_required_mapping() -> None:
    message = "as2.yaml:2:9: battery: must be a mapping of keys and values (got null)"
    assert problem_of("name: x\nbattery:\n") == message


def test_counts_are_whole_numbers() -> None:
    assert problem_of(GOOD + "  cells: 2.5\n").endswith("must be a whole number (got 2.5)")
    assert problem_of(GOOD + "  cells: '2'\n").endswith("the unit is in the key")


def test_empty_text() -> None:
    assert problem_of(GOOD.replace("AS-2", "''")).endswith("name: must not be empty (got '')")


@pytest.mark.parametrize(
    ("leg", "message"),
    [
        ("{kind: cruise, speed_m_s: 0}", "legs.0.speed_m_s: must be greater than 0 (got 0)"),
        ("{kind: cruise}", "legs.0.speed_m_s: required key is missing"),
        (
            "{kind: cruise, speed_m_s: 1, speed_kmh: 1}",
            "legs.0.speed_kmh: unknown key; did you mean 'speed_m_s'?",
        ),
        (
            "{kind: cruise, speed_m_s: 1, zzz: 1}",
            "legs.0.zzz: unknown key; allowed keys: kind, speed_m_s",
        ),
        ("{kind: dive}", "legs.0.kind: must be one of 'cruise', 'loiter' (got 'dive')"),
        (
            "{speed_m_s: 1}",
            "legs.0.kind: required key is missing; it must be one of 'cruise', 'loiter'",
        ),
        ("7", "legs.0: must be a mapping of keys and values (got 7)"),
        (
            "{kind: loiter, duration_h: -1, loiter: {mass_kg: 1, cells: 0}}",
            "legs.0.duration_h: must be greater than 0 (got -1)",
        ),
    ],
)
def test_discriminated_unions_give_clean_keys(leg: str, message: str) -> None:
    first, *_ = problems_of(f"{GOOD}legs:\n  - {leg}\n")
    assert first.startswith("as2.yaml:5:")
    assert first.split(": ", 1)[1] == message


def test_name_of_a_choice_is_told_from_a_key_of_the_same_name() -> None:
    text = GOOD + "legs:\n- kind: loiter\n  duration_h: 0\n  loiter:\n    mass_kg: 0\n"
    assert problems_of(text) == [
        "as2.yaml:6:15: legs.0.duration_h: must be greater than 0 (got 0)",
        "as2.yaml:8:14: legs.0.loiter.mass_kg: must be greater than 0 (got 0)",
    ]


def test_unions_by_callable_and_by_optional_field() -> None:
    def shape(value: Any) -> str:
        return "pack" if "mass_kg" in value else "night"

    class Model(Record):
        one: Annotated[
            Annotated[Battery, UnionTag("pack")] | Annotated[Window, UnionTag("night")],
            Discriminator(shape),
        ]
        two: Cruise | Loiter | None = Field(default=None, discriminator="kind")

    text = "one: {mass_kg: 0, zzz: 1}\ntwo: {kind: cruise, speed_m_s: 0}\n"
    assert problems_of(text, model=Model) == [
        "as2.yaml:1:16: one.mass_kg: must be greater than 0 (got 0)",
        "as2.yaml:1:19: one.zzz: unknown key; allowed keys: mass_kg, usable_fraction, cells",
        "as2.yaml:2:32: two.speed_m_s: must be greater than 0 (got 0)",
    ]


def test_optional_mapping_gives_clean_keys() -> None:
    text = GOOD + "spare:\n  mass_kg: 0\n"
    message = "as2.yaml:5:12: spare.mass_kg: must be greater than 0 (got 0)"
    assert problem_of(text) == message


def test_validator_of_one_choice_silences_the_types_of_the_others() -> None:
    class Model(Record):
        window: Real | Window

    text = "window: {start_h: 5, end_h: 4}"
    assert problems_of(text, model=Model) == [
        "as2.yaml:1:1: window: the window ends before it starts"
    ]


def test_unknown_key_of_one_choice_among_models() -> None:
    class Model(Record):
        source: Window | Real | None = None
        pair: tuple[Battery, Cruise] | None = None

    text = "source: {start_h: 1, end_h: 2, zzz: 3}"
    assert problems_of(text, model=Model) == [
        "as2.yaml:1:32: source.zzz: unknown key; allowed keys: start_h, end_h"
    ]
    text = "pair:\n- mass_kg: 1\n- {kind: cruise, speed_m_s: 1, zzz: 1}"
    assert problems_of(text, model=Model) == [
        "as2.yaml:3:32: pair.1.zzz: unknown key; allowed keys: kind, speed_m_s"
    ]


def test_validators_do_not_hide_the_name_of_a_choice() -> None:
    class Model(Record):
        source: Window | Battery

    text = "source: {start_h: 1, end_h: 2, zzz: 3}"
    first, *_ = [line for line in problems_of(text, model=Model) if "zzz" in line]
    assert first.endswith("allowed keys: start_h, end_h")


def test_types_behind_other_names() -> None:
    class Legs(RootModel[tuple[Cruise, ...]]):
        pass

    pack = NewType("pack", Battery)

    class Model(Record):
        legs: Legs
        pack: pack

    text = "legs: [{kind: cruise, speed_m_s: 1, zzz: 1}]\npack: {mass_kg: 1, mass_g: 1}"
    assert problems_of(text, model=Model) == [
        "as2.yaml:1:37: legs.0.zzz: unknown key; allowed keys: kind, speed_m_s",
        "as2.yaml:2:20: pack.mass_g: unknown key; did you mean 'mass_kg'?",
    ]


def test_key_that_is_refused_is_located_itself() -> None:
    class Model(Record):
        table: dict[Annotated[str, Field(max_length=1)], Real]
        items: Annotated[tuple[Real, ...], Field(max_length=1)]

    text = "table: {long: 1}\nitems: [1, 2]"
    assert problems_of(text, model=Model) == [
        "as2.yaml:1:9: table.long: must have at most 1 character (got 'long')",
        "as2.yaml:2:1: items: must have at most 1 item (got a list of 2)",
    ]


def test_aliased_field_goes_by_the_key_of_the_file() -> None:
    class Model(Record):
        lift: PositiveReal = Field(alias="C_L")

    (problem,) = problems_of("C_L: 0", model=Model)
    assert problem == "as2.yaml:1:6: C_L: must be greater than 0 (got 0)"
    assert problems_of("C_D: 1\nC_L: 1", model=Model) == [
        "as2.yaml:1:1: C_D: unknown key; did you mean 'C_L'?"
    ]


def test_own_message_of_a_validator_stands_alone_at_the_mapping() -> None:
    text = GOOD + "window:\n  start_h: 5\n  end_h: 4\n"
    assert problem_of(text) == "as2.yaml:4:1: window: the window ends before it starts"


def test_validator_may_point_at_a_key() -> None:
    text = GOOD + "window:\n  start_h: 5\n  end_h: 25\n"
    assert problem_of(text) == "as2.yaml:6:10: window.end_h: ends after midnight"


def test_validator_may_point_into_a_list() -> None:
    class Model(Record):
        legs: tuple[Real, ...]

        @model_validator(mode="after")
        def _refuse(self) -> Model:
            raise PydanticCustomError("x", "too\nlong", {"key": "legs.1"})

    assert problems_of("legs:\n- 1\n- 2", model=Model) == ["as2.yaml:3:3: legs.1: too long"]


def test_value_through_an_alias_is_located_where_it_stands() -> None:
    text = "name: x\nbattery: &b\n  mass_kg: 0\nspare: *b\n"
    assert problems_of(text) == [
        "as2.yaml:3:12: battery.mass_kg: must be greater than 0 (got 0)",
        "as2.yaml:3:12: spare.mass_kg: must be greater than 0 (got 0)",
    ]


def test_located_error() -> None:
    document = with_overrides(parse_yaml(GOOD, "as2.yaml"), ["tail_m2=1"])
    (problem,) = located_error(document, ("battery", "mass_kg"), "too heavy").problems
    assert problem == Problem("as2.yaml", 3, 12, "battery.mass_kg", "too heavy")
    assert str(located_error(document, ["battery"], "m")) == "as2.yaml:2:1: battery: m"
    assert str(located_error(document, ["battery", "x"], "m")) == "as2.yaml:2:1: battery.x: m"
    assert str(located_error(document, ["tail_m2"], "m")) == "--set tail_m2: m"
    assert str(located_error(document, [], "m")) == "as2.yaml:1:1: m"
    assert str(located_error(Document("b.yaml", {}), ["a"], "m")) == "b.yaml: a: m"


def test_strange_keys_stay_on_one_line() -> None:
    message = problem_of(GOOD + '"a\\nb": 1\n')
    assert message.startswith("as2.yaml:4:1: a\\nb: unknown key")
    assert "\n" not in message


def test_input_error_keeps_its_problems_through_pickling() -> None:
    error = InputError([Problem("b", 2, 1, "k", "m"), Problem("b", 1, None, "", "n")])
    assert str(error) == "b:1: n\nb:2:1: k: m"
    copied = pickle.loads(pickle.dumps(error))
    assert copied.problems == error.problems
    assert isinstance(error, ValueError)


pieces = st.sampled_from(
    [*"ab:-[]{},&*!?|>'\"#%@` \n\t~<=.", "\n  ", ": ", "- ", "&a", "*a", "<<: ", "---\n", "1e5"]
)


@given(st.lists(pieces | st.characters(), max_size=40).map("".join))
def test_any_text_is_read_or_refused_with_a_place(text: str) -> None:
    problems: tuple[Problem, ...] = ()
    try:
        document = with_overrides(parse_yaml(GOOD + text, "a.yaml"), [f"battery.{text}"])
        validate(document, Aircraft)
    except InputError as error:
        problems = error.problems
    for problem in map(str, problems):
        assert problem.startswith(("a.yaml", "--set "))
        assert len(problem.encode("utf-8").decode("utf-8").splitlines()) == 1


# ---- overrides ----


def overridden(text: str, *overrides: str) -> dict[str, Any]:
    return with_overrides(parse_yaml(text, "a.yaml"), overrides).data


@pytest.mark.parametrize(
    ("override", "value"),
    [
        ("a=2.5", 2.5),
        ("a=-3", -3),
        ("a = 1e-3", 1e-3),
        ("a=true", True),
        ("a=null", None),
        ("a=12:30", "12:30"),
        ("a=no", "no"),
        ("a='2'", "2"),
        ("a=''", ""),
        ("a=x=y", "x=y"),
        ("a=[1, 2.5, [x]]", [1, 2.5, ["x"]]),
        ("a={b: 1}", {"b": 1}),
    ],
)
def test_override_values_follow_the_rules_of_files(override: str, value: object) -> None:
    assert overridden("a: 1", override) == {"a": value}


def test_overrides_reach_into_lists_and_new_mappings() -> None:
    data = overridden("a: [{b: 1}, 2]\nn:\n", "a.0.b=5", "a.1=6", "c.d.e=7", "c.f=8", "n.x=9")
    assert data == {"a": [{"b": 5}, 6], "c": {"d": {"e": 7}, "f": 8}, "n": {"x": 9}}


def test_later_override_wins_and_the_document_is_not_changed() -> None:
    document = parse_yaml("a: {b: 1}", "a.yaml")
    assert with_overrides(document, ["a.b=2", "a.b=3"]).data == {"a": {"b": 3}}
    assert document.data == {"a": {"b": 1}}
    assert document.overridden == {}


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("a", "--set a: write an override as KEY=VALUE, for example a.b=2.5"),
        ("=1", "--set =1: write an override as KEY=VALUE, for example a.b=2.5"),
        ("a..b=1", "--set a..b=1: write an override as KEY=VALUE, for example a.b=2.5"),
        ("a=", "--set a: no value after the = sign (write null for no value)"),
        ("a=#x", "--set a: no value after the = sign (write null for no value)"),
        ("s.b.c=1", "--set s.b.c: s is the single value 3 and has no keys"),
        ("l.x=1", "--set l.x: l is a list and takes an index from 0 to 1 (got 'x')"),
        ("l.2=1", "--set l.2: l is a list and takes an index from 0 to 1 (got '2')"),
        ("l.-1=1", "--set l.-1: l is a list and takes an index from 0 to 1 (got '-1')"),
        ("e.0=1", "--set e.0: e is a list and takes no index: it is empty (got '0')"),
        ("a=!!int 3", "--set a: the value explicit tags (!!int) are not allowed"),
    ],
)
def test_bad_overrides(override: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        overridden("s: 3\nl: [1, 2]\ne: []\n", override)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    "override", ["a=[1", "a=@x", "a=- 1", "a=b: 1", "a=--- 1\n--- 2", "a=\udcff", "a=" + "[" * 999]
)
def test_unreadable_override_values(override: str) -> None:
    with pytest.raises(InputError) as caught:
        overridden("a: 1", override)
    assert str(caught.value).startswith("--set a: ")
    str(caught.value).encode("utf-8")


def test_override_key_outside_unicode_is_printable() -> None:
    message = problem_of(GOOD, "\udcff=1")
    assert message == r"--set \udcff: the key holds a character that is not allowed"


def test_bad_overrides_come_together() -> None:
    with pytest.raises(InputError) as caught:
        overridden("s: 3", "x", "s.b=1", "t=1")
    assert [problem.key for problem in caught.value.problems] == ["x", "s.b"]


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
def test_problems_of_overrides_are_located_at_the_option(override: str, message: str) -> None:
    assert problem_of(GOOD, override) == f"--set {message}"


def test_override_mends_a_value_of_the_file() -> None:
    text = "name: x\nbattery: 3\n"
    document = with_overrides(parse_yaml(text, "a.yaml"), ["battery={mass_kg: 2}"])
    assert validate(document, Aircraft).battery.mass_kg == 2
    assert ("battery",) not in document.marks.keys


def test_override_below_an_override_leaves_the_first_in_its_place() -> None:
    overrides = ["window={start_h: 3, end_h: x}", "window.start_h=y"]
    assert problems_of(GOOD, *overrides) == [
        "--set window.start_h: must be a number (got 'y')",
        "--set window: window.end_h: must be a number (got 'x')",
    ]


def test_problems_of_the_file_come_before_those_of_overrides() -> None:
    problems = problems_of("battery:\n  mass_kg: 0\n", "tail_m2=-1", "name=x")
    assert [problem.split(":")[0] for problem in problems] == ["as2.yaml", "--set tail_m2"]


# ---- writing YAML ----

texts = st.text(max_size=20) | st.sampled_from(
    ["1e5", "010", "12:30", "no", "null", "~", "", " a ", "a: b", "a #b", "- a", "<<", "\x85", "é"]
)
scalars = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | texts
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(texts, inner, max_size=4),
    max_leaves=20,
)


@given(st.dictionaries(texts, values, max_size=5))
def test_written_data_reads_back_equal(data: dict[str, Any]) -> None:
    read = parse_yaml(to_yaml(data), "a.yaml").data
    assert read == data
    # Equality alone takes 1, 1.0 and true for the same, and does not see the order.
    assert repr(read) == repr(data)


def test_written_data_is_readable_block_style() -> None:
    data = {
        "name": "AS-2",
        "note": "no",
        "battery": {"mass_kg": 2.9, "cells": 6, "tiny": 1e-05},
        "legs": [{"kind": "cruise", "at": (1, 2)}, [[1.5], []], {}],
        "none": None,
        "on_top": float("inf"),
    }
    assert to_yaml(data) == (
        'name: AS-2\nnote: "no"\nbattery:\n  mass_kg: 2.9\n  cells: 6\n  tiny: 1e-05\n'
        "legs:\n  - kind: cruise\n    at:\n      - 1\n      - 2\n  - - - 1.5\n    - []\n  - {}\n"
        "none: null\non_top: .inf\n"
    )
    assert math.isnan(parse_yaml(to_yaml({"a": math.nan}), "a.yaml").data["a"])


def test_subclasses_are_written_as_plain_values() -> None:
    class Odd(float):
        def __repr__(self) -> str:
            return "Odd()"

    class Level(enum.IntEnum):
        HIGH = 3

    class Name(enum.StrEnum):
        LOW = "low"

    assert to_yaml({"a": Odd(1.5), "b": Level.HIGH, "c": Name.LOW}) == "a: 1.5\nb: 3\nc: low\n"


@pytest.mark.parametrize("data", [{1: 2}, {"a": {1: 2}}, {"a": {3}}, {"a": b"x"}])
def test_other_types_are_not_written(data: dict[Any, Any]) -> None:
    with pytest.raises(TypeError):
        to_yaml(data)


@pytest.mark.parametrize("data", [{"a": "\ud800"}, {"k" * 1001: 1}])
def test_text_without_a_spelling_is_not_written(data: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"surrogate|too long"):
        to_yaml(data)


# ---- writing files ----


@pytest.fixture
def umask() -> Iterator[None]:
    before = os.umask(0o027)
    yield
    os.umask(before)


def test_text_is_written_as_it_is(tmp_path: Path, umask: None) -> None:
    path = tmp_path / "a.csv"
    write_text_atomically(path, "é\r\nb\n")
    assert path.read_bytes() == b"\xc3\xa9\r\nb\n"
    assert path.stat().st_mode & 0o777 == 0o640
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.csv"]


def test_existing_file_is_replaced_and_keeps_its_permissions(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")
    path.chmod(0o604)
    write_bytes_atomically(path, b"new")
    assert path.read_bytes() == b"new"
    assert path.stat().st_mode & 0o777 == 0o604


def test_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_bytes_atomically(tmp_path / "link", b"x")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_bytes() == b"x"


@pytest.mark.parametrize(("owner", "step"), [(os, "fsync"), (Path, "replace")])
def test_failure_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, owner: object, step: str
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    path = tmp_path / "a.txt"
    path.write_text("old", encoding="utf-8")
    monkeypatch.setattr(owner, step, fail)
    with pytest.raises(OutputError) as caught:
        write_text_atomically(path, "new")
    assert str(caught.value) == f"cannot write {path}: no space left on device"
    assert path.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_file_is_synced_before_it_is_put_in_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps: list[str] = []
    replace = Path.replace

    def noted(scratch: Path, target: Path) -> Path:
        steps.append(f"replace {scratch.read_text(encoding='utf-8')}")
        return replace(scratch, target)

    monkeypatch.setattr(os, "fsync", lambda _: steps.append("fsync"))
    monkeypatch.setattr(Path, "replace", noted)
    write_text_atomically(tmp_path / "a", "x")
    assert steps == ["fsync", "replace x"]


def write_problem(path: Path) -> str:
    with pytest.raises(OSError, match="cannot write") as caught:
        write_text_atomically(path, "x")
    assert isinstance(caught.value, OutputError)
    return str(caught.value)


def test_missing_folder(tmp_path: Path) -> None:
    path = tmp_path / "none" / "a.txt"
    assert write_problem(path) == f"cannot write {path}: its folder does not exist"


def test_folder_as_a_target(tmp_path: Path) -> None:
    assert write_problem(tmp_path) == f"cannot write {tmp_path}: it is a folder"


def test_file_as_a_folder(tmp_path: Path) -> None:
    (tmp_path / "f").write_text("", encoding="utf-8")
    path = tmp_path / "f" / "a.txt"
    assert write_problem(path).endswith("a part of the path is a file, not a folder")


def test_folder_without_permission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> int:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    assert write_problem(tmp_path / "a").endswith("a: permission denied")


def test_name_that_cannot_be() -> None:
    assert write_problem(Path("a\0b")) == r"cannot write a\x00b: not a valid file name"


def test_pipe_is_written_to_and_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    try:
        write_text_atomically(path, "x")
        assert os.read(reader, 9) == b"x"
    finally:
        os.close(reader)
    assert path.is_fifo()


# ---- imports ----


def test_import_is_light() -> None:
    code = (
        "import sys, missions.configfile\n"
        "print([m for m in ('numpy', 'pandas', 'casadi', 'scipy') if m in sys.modules])"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert run.stdout.strip() == "[]"
