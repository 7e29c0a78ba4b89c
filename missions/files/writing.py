"""Writing result files: completely or not at all, and data as YAML that reads back equal."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from missions.files.errors import printable, shortened, shown

__all__ = [
    "OutputError",
    "check_writable_folder",
    "to_yaml",
    "write_bytes_atomically",
    "write_files_atomically",
    "write_folder",
    "write_text_atomically",
]

_BARE_TEXT = re.compile(r"[A-Za-z_](?:[A-Za-z0-9_./+ -]*[A-Za-z0-9_./+-])?")
# Readers of YAML 1.1 take these for booleans.
_AMBIGUOUS = re.compile(r"y|n|yes|no|on|off|true|false|null", re.IGNORECASE)
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}
_ESCAPED = re.compile('[\\\\"\x00-\x1f\x7f-\xa0\u2028\u2029\ufeff\ufffe\uffff]')


class OutputError(OSError):
    """A file could not be written; the text says which one and why."""


def to_yaml(data: Mapping[str, Any]) -> str:
    """Write plain data as block style YAML that `parse_yaml` reads back equal.

    Parameters
    ----------
    data : mapping
        Nested mappings with text keys, lists, tuples, text, numbers, booleans and None;
        the order of keys is kept.

    Raises
    ------
    TypeError
        If a key is not text or a value is of another type.
    ValueError
        If a text holds a lone surrogate or a key is too long for YAML.
    """
    return "\n".join(_lines(data)) + "\n"


def _lines(value: Mapping[str, Any] | Sequence[Any]) -> list[str]:
    """Return the lines of a collection, without indentation."""
    if not value:
        return ["{}" if isinstance(value, Mapping) else "[]"]
    if isinstance(value, Mapping):
        return [line for key, item in value.items() for line in _entry(_key_text(key), item)]
    return [line for item in value for line in _item(item)]


def _is_collection(value: object) -> bool:
    return isinstance(value, Mapping | list | tuple)


def _entry(key: str, value: Any) -> list[str]:
    if _is_collection(value) and value:
        return [f"{key}:", *(f"  {line}" for line in _lines(value))]
    return [f"{key}: {_inline(value)}"]


def _item(value: Any) -> list[str]:
    if _is_collection(value) and value:
        first, *rest = _lines(value)
        return [f"- {first}", *(f"  {line}" for line in rest)]
    return [f"- {_inline(value)}"]


def _inline(value: Any) -> str:
    """Return a scalar or an empty collection."""
    if _is_collection(value):
        return _lines(value)[0]
    if value is None or isinstance(value, bool | float):
        return shown(value)
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, str):
        return _text(str.__str__(value))
    raise TypeError(f"cannot write a value of type {type(value).__name__} as YAML")


def _key_text(key: object) -> str:
    if not isinstance(key, str):
        raise TypeError(f"a key must be text, not {type(key).__name__}")
    text = _text(str.__str__(key))
    if len(text) > 1000:
        raise ValueError(f"the key {shortened(key)} is too long for YAML")
    return text


def _text(text: str) -> str:
    if _BARE_TEXT.fullmatch(text) and not _AMBIGUOUS.fullmatch(text):
        return text
    text.encode("utf-8")  # a lone surrogate has no spelling in YAML
    return '"' + _ESCAPED.sub(_escape, text) + '"'


def _escape(match: re.Match[str]) -> str:
    return _ESCAPES.get(match.group()) or f"\\u{ord(match.group()):04x}"


def write_text_atomically(path: str | os.PathLike[str], text: str) -> None:
    """Write a UTF-8 text file completely or not at all; line breaks are written as they are.

    Raises
    ------
    OutputError
        If the file cannot be written; an existing file is then unchanged.
    """
    write_bytes_atomically(path, text.encode("utf-8"))


def write_bytes_atomically(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file completely or not at all.

    Raises
    ------
    OutputError
        If the file cannot be written; an existing file is then unchanged.
    """
    write_files_atomically({path: data})


def write_files_atomically(contents: Mapping[str | os.PathLike[str], bytes]) -> None:
    """Write several files, each completely, and none of them where one cannot be written.

    Everything is written beside its target first; only then are the targets replaced.

    Raises
    ------
    OutputError
        If one of the files cannot be written; existing files are then unchanged.
    """
    staged: list[_Staged] = []
    path: str | os.PathLike[str] = ""
    try:
        for path, data in contents.items():
            staged.append(_stage(Path(path), data))
        for file in staged:
            path = file.target
            file.commit()
    except (OSError, ValueError) as error:
        name = printable(os.fspath(path))
        raise OutputError(f"cannot write {name}: {_writing_trouble(error)}") from error
    finally:
        for file in staged:
            file.discard()


def write_folder(folder: Path, contents: Mapping[str, bytes]) -> None:
    """Write files into a folder, made if need be: all of them, or none.

    Raises
    ------
    OutputError
        If the folder or one of the files cannot be written.
    """
    made = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        name = printable(os.fspath(folder))
        raise OutputError(f"cannot write to {name}: {_writing_trouble(error)}") from error
    try:
        write_files_atomically({folder / file: data for file, data in contents.items()})
    except OutputError:
        for path in made:
            with suppress(OSError):  # not empty: somebody else's by now
                path.rmdir()
        raise


def check_writable_folder(folder: Path) -> None:
    """Refuse a folder that files cannot be put into, before any work is done for them.

    A folder that does not exist is made later; then the one above it must take it.

    Raises
    ------
    OutputError
        If the path is no folder or may not be written to.
    """
    name = printable(os.fspath(folder))
    existing = next((p for p in (folder, *folder.parents) if p.exists()), None)
    if existing is None or not existing.is_dir():
        raise OutputError(f"cannot write to {name}: {existing or name} is not a folder")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise OutputError(f"cannot write to {name}: permission denied")


@dataclass(frozen=True)
class _Staged:
    """A file's content beside its target; devices and pipes have no such place (no scratch)."""

    target: Path
    data: bytes
    scratch: Path | None

    def commit(self) -> None:
        if self.scratch is None:
            self.target.write_bytes(self.data)
        else:
            self.scratch.replace(self.target)

    def discard(self) -> None:
        if self.scratch is not None:
            self.scratch.unlink(missing_ok=True)


def _stage(path: Path, data: bytes) -> _Staged:
    if not os.fspath(path) or os.fspath(path) == ".":
        raise IsADirectoryError
    mode = path.stat().st_mode if path.exists() else None
    if mode is not None and stat.S_ISDIR(mode):
        raise IsADirectoryError
    if mode is not None and not stat.S_ISREG(mode):
        # A device or a pipe must be written to, never replaced by a file.
        return _Staged(path, data, None)
    # Through a symbolic link the file it names is replaced, not the link.
    target = Path(os.path.realpath(path))
    scratch = target.parent / f".{os.urandom(8).hex()}.tmp"
    # Created by hand, for the permissions of an ordinary new file rather than a private one.
    descriptor = os.open(scratch, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    staged = _Staged(target, data, scratch)
    try:
        with open(descriptor, "wb") as file:  # noqa: PTH123 - a descriptor has no path
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if mode is not None:
            scratch.chmod(stat.S_IMODE(mode))
    except BaseException:
        staged.discard()
        raise
    return staged


def _writing_trouble(error: OSError | ValueError) -> str:
    if isinstance(error, FileNotFoundError):
        return "its folder does not exist"
    if isinstance(error, NotADirectoryError):
        return "a part of the path is a file, not a folder"
    if isinstance(error, IsADirectoryError):
        return "it is a folder"
    if isinstance(error, OSError):
        return (error.strerror or str(error)).lower()
    return "not a valid file name"
