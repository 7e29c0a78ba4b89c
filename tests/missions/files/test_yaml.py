"""Tests of the parser of YAML text: its subset, its places and its limits."""

import math
import os
from pathlib import Path

import pytest
import yaml

from missions.files import yaml as reading
from missions.files.errors import InputError
from missions.files.yaml import parse_yaml, read_yaml, set_absolute_paths


def parse_problem(text):
    with pytest.raises(InputError) as caught:
        parse_yaml(text, "a.yaml")
    return str(caught.value)


@pytest.fixture(params=["libyaml", "python"])
def parser(request, monkeypatch):
    if request.param == "python":
        monkeypatch.setattr(reading, "_Loader", reading._loader(yaml.SafeLoader))
    elif not hasattr(yaml, "CSafeLoader"):
        pytest.skip("PyYAML without libyaml")
    return str(request.param)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True),
        ("False", False),
        *[(text, None) for text in ("null", "~", "")],
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
        (".nan", math.nan),
        *[(text, text) for text in ("12:30", "12:30:45", "2015-06-21", "no", "on", "y", "=")],
        *[(text, text) for text in ("010", "0o17", "0x1F", "1_000", "inf", "nan")],
        ("'2.9'", "2.9"),
        ('"true"', "true"),
        ("''", ""),
        ("|-\n  7", "7"),
    ],
)
def test_scalars(parser, text, value):
    data = parse_yaml(f"a: {text}\n", "a.yaml").data
    # By their text, as a number that is none does not equal itself.
    assert repr(data) == repr({"a": value})


def test_marks_tell_keys_from_values(parser):
    document = parse_yaml("a: 1\nb:\n  c: [5, 6]\n  d:\n", "a.yaml")
    assert document.places == {
        (): (None, (1, 1), ""),
        ("a",): ((1, 1), (1, 4), ""),
        ("b",): ((2, 1), (3, 3), ""),
        ("b", "c"): ((3, 3), (3, 6), ""),
        ("b", "c", 0): (None, (3, 7), ""),
        ("b", "c", 1): (None, (3, 10), ""),
        ("b", "d"): ((4, 3), (4, 5), ""),
    }


def test_byte_order_mark_is_no_part_of_the_text(parser, tmp_path):
    path = tmp_path / "a.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\n")
    document = read_yaml(path)
    assert document.data == {"a": 1}
    assert document.places["a",].key == (1, 1)


TOP = "the top level must be a mapping (key: value)"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: !!float 1", "1:4: explicit tags (!!float) are not allowed"),
        ("a: !x {b: 1}", "1:4: explicit tags (!x) are not allowed"),
        ("a: !!set [b]", "1:4: explicit tags (!!set) are not allowed"),
        ("a: ! 1", "1:4: explicit tags (!) are not allowed"),
        ("a:\n  <<: {b: 1}", "2:3: a: merge keys (<<) are not allowed; write the keys out"),
        ("1: a", "1:1: a key must be text (got 1); put it in quotes"),
        ("true: a", "1:1: a key must be text (got true); put it in quotes"),
        ("? [a]\n: b", "1:3: a key must be text (got a list)"),
        ("? {a: 1}\n: b", "1:3: a key must be text (got a mapping)"),
        ("a: 1\nb: 2\na: 3", "3:1: a: duplicate key (first at line 1)"),
        ("a: {b: 1, b: 2}", "1:11: a.b: duplicate key (first at line 1)"),
        ("a: 1\n---\nb: 2", "2:1: only one document (---) is allowed per file"),
        *[
            (text, " the file is empty; it must hold a mapping (key: value)")
            for text in ("", "# only words\n", "---\n")
        ],
        ("- 1\n", f"1:1: {TOP}, not a list"),
        ("\nwords\n", f"2:1: {TOP}, not the single value 'words'"),
        ("~", f"1:1: {TOP}, not the single value null"),
        ("a: &x [1, *x]", "1:4: a.1: an alias refers to a value that contains it"),
        ("a: 1\nb: x\x07y", "2:5: character U+0007 is not allowed"),
        ("a: \ud800", "1:4: character U+D800 is not allowed"),
    ],
)
def test_refused_text(parser, text, message):
    assert parse_problem(text) == f"a.yaml:{message}"


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("a: [1, 2", "a.yaml:"),
        ("a: 'open", "a.yaml:1:"),
        ("a: 1\n b: 2", "a.yaml:2:"),
        ("a: '" + "[" * 50 + "'\nb: ]", "a.yaml:2:4: "),
        ("a: @b", "a.yaml:1:4: "),
        ("a: b: c", "a.yaml:1:5: "),
        ("a: *x", "a.yaml:1:4: "),
        ("a: &x 1\nb: &x 2", "a.yaml:2:4: "),
        ("%YAML 3.0\n---\na: 1", "a.yaml:1:1: "),
    ],
)
def test_syntax_errors_have_a_place(parser, text, place):
    message = parse_problem(text)
    assert message.startswith(place)
    assert "is not valid YAML: " in message
    assert "\n" not in message


def test_open_brackets_tell_where_they_start(parser):
    assert parse_problem("b: 1\na: [1,\n2\n\n").endswith(" (it starts at line 2)")


def test_tabs_get_a_hint(parser):
    message = parse_problem("a:\n\tb: 1")
    assert message.startswith("a.yaml:2:1: is not valid YAML: ")
    assert message.endswith("; indent with spaces, not tabs")
    assert parse_problem("\ufeffa:\n\tb: 1") == message


@pytest.mark.parametrize(
    ("text", "column"),
    [
        # The mapping is the first level.
        ("a: " + "[" * 50_000, 43),
        ("a: " + "{" * 50_000, 43),
        ("- " * 50_000, 81),
        ("? " * 50_000, 81),
        ("[a, " * 50_000, 161),
    ],
)
def test_deep_nesting_is_refused_at_its_place(parser, text, column):
    assert parse_problem(text) == f"a.yaml:1:{column}: nested too deeply (at most 40 levels)"


def chain(count, first, link):
    """Values that each refer to the one before."""
    return "\n".join([f"k0: &k0 {first}", *(f"k{n}: &k{n} {link(n - 1)}" for n in range(1, count))])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (chain(40, "[" * 38 + "]" * 38, lambda n: f"{'[' * 30}*k{n}{']' * 30}"), " k1.0.0.0."),
        # Expanded whole, these are twenty million values: minutes, and gigabytes.
        (chain(10, f"[{'x, ' * 10}]", lambda n: f"[{f'*k{n}, ' * 5}]"), "too many values after"),
        ("a: &x 1\nb: [" + "*x, " * 51 + "]", "too many aliases (at most 50)"),
        ("a: [" + "1," * 50_001 + "]", "too many values in one file"),
        ("a: " + "é" * 600_000, "a.yaml: is larger than 1 MB"),
    ],
    ids=["nested", "bomb", "aliases", "values", "large"],
)
def test_too_much_is_refused_at_once(text, message):
    assert message in parse_problem(text)
    assert parse_yaml("a: &x 1\nb: [" + "*x, " * 50 + "]", "a.yaml").data["b"] == [1] * 50


def read_problem(path):
    with pytest.raises(InputError) as caught:
        read_yaml(path)
    return str(caught.value)


def test_large_file_is_refused(tmp_path):
    path = tmp_path / "large.yaml"
    # Cut at the limit, this text ends in half a character.
    path.write_text("a: 1\n#" + "é" * 600_000, encoding="utf-8")
    assert read_problem(path) == f"{path}: is larger than 1 MB"


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("none.yaml", "no such file"),
        ("", "is a folder, not a file"),
        ("file/a.yaml", "cannot be read: not a directory"),
    ],
)
def test_files_that_cannot_be_read(tmp_path, name, reason):
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert read_problem(tmp_path / name) == f"{tmp_path / name}: {reason}"


def test_unreadable_file(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    path = tmp_path / "a.yaml"
    assert read_problem(path) == f"{path}: cannot be read: permission denied"


def test_file_name_that_cannot_be():
    assert read_problem(Path("a\0b")) == r"a\x00b: is not a valid file name"
    message = read_problem(Path("a\udcff.yaml"))
    assert message.encode("utf-8") == rb"a\udcff.yaml: no such file"


@pytest.mark.parametrize(
    ("raw", "place"),
    [(b"a: 1\nb: \xe9t\xe9\n", "2:4: is not UTF-8 text (byte 0xe9)"), (b"\xff\xfea\0", "1:1: ")],
)
def test_other_encodings_are_refused(tmp_path, raw, place):
    path = tmp_path / "a.yaml"
    path.write_bytes(raw)
    assert read_problem(path).startswith(f"{path}:{place}")


def test_relative_paths_are_those_beside_the_file(tmp_path):
    data = {"modules": {"cell": "mine.yaml", "name": "mine.yaml"}, "others": [{"airfoil": "a.dat"}]}
    set_absolute_paths(data, tmp_path)
    assert data == {
        "modules": {"cell": str(tmp_path / "mine.yaml"), "name": "mine.yaml"},
        "others": [{"airfoil": str(tmp_path / "a.dat")}],
    }
