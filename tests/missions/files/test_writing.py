import enum
import json
import math
import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from missions.files.writing import (
    OutputError,
    check_writable_file,
    check_writable_folder,
    to_json,
    to_yaml,
    write_bytes_atomically,
    write_folder,
)
from missions.files.yaml import parse_yaml

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
def test_written_data_reads_back_equal(data):
    compact = parse_yaml(to_yaml(data, compact=True), "a.yaml").data
    assert compact == parse_yaml(to_yaml(data), "a.yaml").data
    read = parse_yaml(to_yaml(data), "a.yaml").data
    assert read == data
    # Equality alone takes 1, 1.0 and true for the same, and does not see the order.
    assert repr(read) == repr(data)


def test_short_mappings_and_lists_stand_on_a_line():
    data = {"a": {"b": 1, "c": [1.5, 2.0]}, "d": list(range(40)), "e": {}}
    lines = to_yaml(data, compact=True).splitlines()
    assert lines[:3] == ["a:", "  b: 1", "  c: [1.5, 2.0]"]
    assert lines[3:5] == ["d:", "- 0"]
    assert lines[-1] == "e: {}"


def test_written_data_is_readable_block_style():
    data = {
        "name": "AS-2",
        "note": "no",
        "battery": {"mass_kg": 2.9, "cells": 6, "tiny": 1e-05},
        "legs": [{"kind": "cruise", "at": (1, 2)}, [[1.5], []], {}],
        "none": None,
        "on_top": float("inf"),
    }
    assert to_yaml(data) == (
        "name: AS-2\nnote: 'no'\nbattery:\n  mass_kg: 2.9\n  cells: 6\n  tiny: 1.0e-05\n"
        "legs:\n- kind: cruise\n  at:\n  - 1\n  - 2\n- - - 1.5\n  - []\n- {}\n"
        "none: null\non_top: .inf\n"
    )
    assert math.isnan(parse_yaml(to_yaml({"a": math.nan}), "a.yaml").data["a"])
    for other in ({3}, b"x", Path()):
        with pytest.raises(yaml.YAMLError):
            to_yaml({"a": other})


def test_subclasses_are_written_as_plain_values():
    class Odd(float):
        def __repr__(self):
            return "Odd()"

    class Level(enum.IntEnum):
        HIGH = 3

    class Name(enum.StrEnum):
        LOW = "low"

    assert to_yaml({"a": Odd(1.5), "b": Level.HIGH, "c": Name.LOW}) == "a: 1.5\nb: 3\nc: low\n"


@pytest.fixture
def umask():
    before = os.umask(0o027)
    yield
    os.umask(before)


def test_text_is_written_as_it_is(tmp_path, umask):
    path = tmp_path / "a.csv"
    write_bytes_atomically(path, "é\r\nb\n".encode())
    assert path.read_bytes() == b"\xc3\xa9\r\nb\n"
    assert path.stat().st_mode & 0o777 == 0o640
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.csv"]


def test_existing_file_is_replaced_and_keeps_its_permissions(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(b"old")
    path.chmod(0o604)
    write_bytes_atomically(path, b"new")
    assert path.read_bytes() == b"new"
    assert path.stat().st_mode & 0o777 == 0o604


def test_json_is_strict_and_has_no_negative_zero():
    record = {"a": -0.0, "b": [(-0.0, 1.5), {"c": np.float64(-0.0)}], "d": [-0, None, True, "-0.0"]}
    expected = {"a": 0.0, "b": [[0.0, 1.5], {"c": 0.0}], "d": [0, None, True, "-0.0"]}
    assert to_json(record) == json.dumps(expected)
    assert to_json(-1e-300) == "-1e-300"  # what is not zero keeps its sign
    with pytest.raises(ValueError, match="not JSON compliant"):
        to_json({"a": math.nan})


def test_link_is_replaced_and_not_followed(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / "mine.txt").chmod(0o700)
    for number, target in enumerate(("mine.txt", "nowhere")):
        link = tmp_path / f"link{number}"
        link.symlink_to(tmp_path / target)
        write_bytes_atomically(link, b"x")
        assert not link.is_symlink()
        assert link.read_bytes() == b"x"
        assert not link.stat().st_mode & 0o100
    assert (tmp_path / "mine.txt").read_text() == "mine"
    assert not (tmp_path / "nowhere").exists()


def test_link_to_a_device_or_a_pipe_is_written_to(tmp_path):
    link = tmp_path / "link"  # as /dev/stdout is one
    link.symlink_to(os.devnull)
    write_bytes_atomically(link, b"x")
    assert link.is_symlink()
    (tmp_path / "folder").mkdir()
    link.unlink()
    link.symlink_to(tmp_path / "folder")
    with pytest.raises(OutputError, match="it is a folder"):
        write_bytes_atomically(link, b"x")


@pytest.mark.parametrize(("owner", "step"), [(os, "fsync"), (Path, "replace")])
def test_failure_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, owner, step):
    def fail(*_):
        raise OSError(28, "No space left on device")

    path = tmp_path / "a.txt"
    path.write_text("old", encoding="utf-8")
    monkeypatch.setattr(owner, step, fail)
    with pytest.raises(OutputError) as caught:
        write_bytes_atomically(path, b"new")
    assert str(caught.value) == f"cannot write {path}: no space left on device"
    assert path.read_text(encoding="utf-8") == "old"
    assert list(tmp_path.iterdir()) == [path]


def write_problem(path):
    with pytest.raises(OSError, match="cannot write") as caught:
        write_bytes_atomically(path, b"x")
    assert isinstance(caught.value, OutputError)
    return str(caught.value)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("none/a.txt", "its folder does not exist"),
        ("", "it is a folder"),
        ("f/a.txt", "a part of the path is a file, not a folder"),
    ],
)
def test_where_nothing_can_be_written_is_told(tmp_path, name, reason):
    (tmp_path / "f").write_text("", encoding="utf-8")
    path = tmp_path / name
    assert write_problem(path) == f"cannot write {path}: {reason}"
    assert write_problem(Path("a\0b")) == r"cannot write a\x00b: not a valid file name"


def test_folder_without_permission(tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    assert write_problem(tmp_path / "a").endswith("a: permission denied")


def test_pipe_is_written_to_and_not_replaced(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    try:
        write_bytes_atomically(path, b"x")
        assert os.read(reader, 9) == b"x"
    finally:
        os.close(reader)
    assert path.is_fifo()


def test_folder_is_written_whole_or_not_at_all(tmp_path):
    folder = tmp_path / "results"
    (folder / "b.csv").mkdir(parents=True)  # a folder where a file should go
    with pytest.raises(OutputError, match=r"b\.csv: it is a folder"):
        write_folder(folder, {"a.csv": b"1", "b.csv": b"2"})
    assert [p.name for p in folder.iterdir()] == ["b.csv"]
    write_folder(tmp_path / "new" / "results", {"a.csv": b"1"})
    assert (tmp_path / "new" / "results" / "a.csv").read_bytes() == b"1"
    # A link is replaced and not followed.
    (tmp_path / "mine.txt").write_text("mine")
    (folder / "a.csv").symlink_to(tmp_path / "mine.txt")
    (folder / "c.csv").symlink_to("/dev/null")
    write_folder(folder, {"a.csv": b"1", "c.csv": b"2"})
    assert (tmp_path / "mine.txt").read_text() == "mine"
    assert [(folder / f"{n}.csv").read_bytes() for n in "ac"] == [b"1", b"2"]


@pytest.mark.parametrize(
    "name", ["file", "file/deeper", "nowhere", "loop", "n" * 300, "new/" + "n" * 300 + "/newer"]
)
def test_folder_that_cannot_be_made_is_refused_before_any_work(tmp_path, name):
    check_writable_folder(tmp_path / "not" / "there" / "yet")
    assert not list(tmp_path.iterdir())  # what is tried is not left
    (tmp_path / "file").write_text("x")
    (tmp_path / "nowhere").symlink_to(tmp_path / "not" / "there")
    (tmp_path / "loop").symlink_to("loop")
    before = sorted(tmp_path.iterdir())
    with pytest.raises(OutputError, match=f"cannot write to .*{name}: "):
        check_writable_folder(tmp_path / name)
    with pytest.raises(OutputError):
        write_folder(tmp_path / name, {"a": b""})
    assert sorted(tmp_path.iterdir()) == before
    with pytest.raises(OutputError, match=r"cannot write .*n\.png: "):
        check_writable_file(tmp_path / ("n" * 300 + ".png"))


def test_folder_made_in_vain_goes_again(tmp_path):
    folder = tmp_path / "new" / "inner"
    with pytest.raises(OutputError):
        write_folder(folder, {"a.txt": b"a", "missing/b.txt": b"b"})
    assert not list(tmp_path.iterdir())
    (tmp_path / "old").mkdir()
    with pytest.raises(OutputError):
        write_folder(tmp_path / "old", {"missing/b.txt": b"b"})
    assert (tmp_path / "old").is_dir()
