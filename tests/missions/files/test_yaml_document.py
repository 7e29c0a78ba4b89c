"""Tests of reading YAML files."""

from __future__ import annotations

from pathlib import Path

import pytest

from missions.files.errors import InputError
from missions.files.yaml import read_yaml


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
