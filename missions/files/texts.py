"""Reading files of unknown origin: plain files of a bounded size, nothing else.

Files that a record names, such as tables, keep the text of the first reading.
"""

from __future__ import annotations

import codecs
import io
import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from missions.files.errors import InputError, file_error, in_file, printable, refused

# Begins a line that names the file of the lines below it, in the text of a whole folder.
FILE_MARK = "#file "

_MAX_BYTES = 5_000_000
_MAX_FILES = 200
# Texts of files by the path under which they were read, for records made anew from data.
_READ: ContextVar[Mapping[str, str] | None] = ContextVar("texts that were read", default=None)


@contextmanager
def reading(path: str | os.PathLike[str]) -> Iterator[None]:
    """Refuse a file that cannot be read, by its name and the reason."""
    name = os.fspath(path)
    if "\0" in name:
        raise file_error(printable(name), "is not a valid file name")
    try:
        yield
    except OSError as error:
        words = {FileNotFoundError: "no such file", IsADirectoryError: "is a folder, not a file"}
        reason = f"cannot be read: {str(error.strerror or error).lower()}"
        raise file_error(printable(name), words.get(type(error), reason)) from error


def open_plain(path: str | os.PathLike[str]) -> io.BufferedReader:
    """Open a plain file for reading, else raise InputError.

    Checked before reading: a pipe would keep its reader waiting, and a device may never end.
    """
    waiting = getattr(os, "O_NONBLOCK", 0)
    with reading(path):
        file = open(path, "rb", opener=lambda p, flags: os.open(p, flags | waiting))  # noqa: SIM115
    if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        return file
    file.close()
    raise file_error(printable(os.fspath(path)), "cannot be read: is not a plain file")


def read_plain_file(path: str | os.PathLike[str], *, most_bytes: int) -> bytes:
    """Read the bytes of a plain file of at most ``most_bytes``."""
    with reading(path), open_plain(path) as file:
        content = file.read(most_bytes + 1)
    if len(content) > most_bytes:
        raise _too_large(path, most_bytes)
    return content


def _too_large(path: str | os.PathLike[str], most_bytes: int) -> InputError:
    size = f"is larger than {most_bytes // 1_000_000} MB"
    return file_error(printable(os.fspath(path)), size)


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


def read_text(path: str, suffixes: tuple[str, ...] = ()) -> str:
    """Return the text of a file, as first read within :func:`texts_as_read`.

    A path that ends in a slash is that of a folder: the texts of its files with given suffixes
    (lower case), in order of names, each after a line with :data:`FILE_MARK` and its name.
    """
    known = (_READ.get() or {}).get(path)
    if known is not None:
        return known
    if not path.endswith("/"):
        with in_file(printable(path)):
            return decoded(read_plain_file(path, most_bytes=_MAX_BYTES))[0]
    with reading(path):
        every = sorted(Path(path).iterdir())
    files = [file for file in every if file.name.lower().endswith(suffixes)]
    if not files:
        allowed = ", ".join(suffixes)
        raise file_error(printable(path), f"has no files of that kind ({allowed})")
    if len(files) > _MAX_FILES:
        message = f"has {len(files)} files, at most {_MAX_FILES} are read"
        raise file_error(printable(path), message)
    parts, size = [], 0
    for file in files:
        raw = read_plain_file(file, most_bytes=_MAX_BYTES)
        size += len(raw)
        if size > _MAX_BYTES:
            raise _too_large(path, _MAX_BYTES)
        with in_file(printable(str(file))):
            parts.append(f"{FILE_MARK}{printable(file.name)}\n{decoded(raw)[0]}\n")
    return "".join(parts)


def decoded(content: bytes) -> tuple[str, str]:
    """Return a text with line feeds, and its encoding.

    UTF-8, UTF-16 with the mark of spreadsheets, else Windows' code page 1252.
    """
    wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    encoding, content = "utf-16" if wide else "utf-8", content.removeprefix(codecs.BOM_UTF8)
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        if wide:
            raise refused(f"is not UTF-16 text (byte {error.start})") from None
        encoding = "cp1252"
        text = content.decode(encoding, errors="replace")
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text, encoding
