"""Reading files of unknown origin: plain files of a bounded size, nothing else.

Files that a record names, such as tables, keep the text of the first reading.
"""

from __future__ import annotations

import io
import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from missions.files.errors import InputError, Problem, file_error, printable

# Begins a line that names the file of the lines below it, in the text of a whole folder.
FILE_MARK = "#file "

_MAX_BYTES = 5_000_000
_MAX_FILES = 200
# Texts of files by the path under which they were read, for records made anew from data.
_READ: ContextVar[Mapping[str, str] | None] = ContextVar("texts that were read", default=None)


def open_plain(path: str | os.PathLike[str]) -> io.BufferedReader:
    """Open a plain file for reading, else raise InputError.

    Checked before reading: a pipe would keep its reader waiting, and a device may never end.
    """
    waiting = getattr(os, "O_NONBLOCK", 0)
    file = open(path, "rb", opener=lambda p, flags: os.open(p, flags | waiting))  # noqa: SIM115
    if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        return file
    file.close()
    raise file_error(printable(os.fspath(path)), "cannot be read: is not a plain file")


@contextmanager
def texts_as_read(texts: Mapping[str, str]) -> Iterator[None]:
    """Give files the text of their first reading within this context.

    A record made anew from data, perhaps on another machine, then describes the same aircraft even
    where the file has changed or is missing.
    """
    token = _READ.set({**(_READ.get() or {}), **texts})
    try:
        yield
    finally:
        _READ.reset(token)


def read_text(path: str) -> str:
    """Return the text of a file, as first read within :func:`texts_as_read`."""
    known = (_READ.get() or {}).get(path)
    return _decoded(_bytes(Path(path)), path) if known is None else known


def read_folder(path: str, suffixes: tuple[str, ...]) -> str:
    """Return the text of a folder's files with given suffixes (lower case), in order of names.

    Each begins with a line :data:`FILE_MARK` and its name. As :func:`texts_as_read` for files that
    were read before.
    """
    known = (_READ.get() or {}).get(path)
    if known is not None:
        return known
    files = sorted(file for file in Path(path).iterdir() if file.name.lower().endswith(suffixes))
    if not files:
        allowed = ", ".join(suffixes)
        raise file_error(printable(path), f"has no files of that kind ({allowed})")
    if len(files) > _MAX_FILES:
        message = f"has {len(files)} files, at most {_MAX_FILES} are read"
        raise file_error(printable(path), message)
    parts, size = [], 0
    for file in files:
        raw = _bytes(file)
        size += len(raw)
        if size > _MAX_BYTES:
            raise _too_large(path)
        parts.append(f"{FILE_MARK}{printable(file.name)}\n{_decoded(raw, str(file))}\n")
    return "".join(parts)


def _bytes(file: Path) -> bytes:
    with open_plain(file) as opened:
        raw = opened.read(_MAX_BYTES + 1)
    if len(raw) > _MAX_BYTES:
        raise _too_large(str(file))
    return raw


def _too_large(path: str) -> InputError:
    return file_error(printable(path), f"is too large (at most {_MAX_BYTES // 1_000_000} MB)")


def _decoded(raw: bytes, path: str) -> str:
    """Decode UTF-8, with the degree sign of Windows' code page allowed."""
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if raw[error.start : error.start + 1] == b"\xb0":
            return _decoded(raw.replace(b"\xb0", "°".encode()), path)
        line = raw.count(b"\n", 0, error.start) + 1
        message = f"is not UTF-8 text (byte 0x{raw[error.start]:02x})"
        raise InputError([Problem(printable(path), line, None, "", message)]) from error


def read_plain_file(path: str | os.PathLike[str], *, most_bytes: int) -> bytes:
    """Read the bytes of a plain file of at most ``most_bytes``."""
    source = printable(os.fspath(path))
    if "\0" in os.fspath(path):
        raise file_error(source, "cannot be read: is no name of a file")
    try:
        with open_plain(path) as file:
            content = file.read(most_bytes + 1)
    except OSError as error:
        words = {FileNotFoundError: "no such file", IsADirectoryError: "is a folder"}
        reason = words.get(type(error), error.strerror)
        raise file_error(source, f"cannot be read: {str(reason).lower()}") from error
    if len(content) > most_bytes:
        raise file_error(source, f"is larger than {most_bytes // 1_000_000} MB")
    return content
