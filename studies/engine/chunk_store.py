"""Finished chunks of a long computation, kept in a folder so that a later run goes on from them.

A part is one file, named by the key of its chunk and written beside its place before it takes it.
Its first line holds the key and a checksum of the rest, a NumPy archive. A part that was cut short,
changed or renamed is not believed and computed anew; therefore parts need no flush to the disk.

One run at a time uses a folder: the lock is one of the operating system and ends with its process,
however that ends.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import shutil
import socket
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from missions.files.errors import printable
from missions.files.writing import OutputError, make_folder, probe, writing_trouble

_KEY = "[0-9a-f]" * 40
_LOCK = ".solar-uav.lock"
_FAILURES = "failures as JSON"  # no column has a name with spaces
# Parts and the file made of them stand side by side for a moment, and the file twice.
_COPIES = 3
_PART_BYTES = 4096
# What a part may have at most: messages of failed cells are the longest that it holds.
_MOST_BYTES, _MOST_BYTES_A_VALUE = 1 << 20, 1 << 12


@dataclass(frozen=True)
class Part:
    """Result of one chunk: columns of one value per cell, and messages of the cells that failed."""

    columns: Mapping[str, Any]
    failures: Mapping[int, str] = field(default_factory=dict)


def parts_folder(target: str | os.PathLike[str]) -> Path | None:
    """Folder for the parts of a result file; none for a device or a pipe, which none stands by."""
    path = Path(target)
    if path.exists() and not path.is_file():
        return None
    return path.with_name(path.name + ".parts")


@dataclass(frozen=True)
class ChunkStore:
    """Folder of parts; use it inside :meth:`opened`."""

    folder: Path

    @contextmanager
    def opened(self, needed_bytes: int = 0, parts: int = 0) -> Iterator[ChunkStore]:
        """Make and lock the folder, and refuse a disk without room for the result.

        Returns this store, locked until the context ends.
        """
        made = make_folder(self.folder)
        with _locked(self.folder / _LOCK):
            try:
                probe(self.folder, f"to {printable(os.fspath(self.folder))}")
                needed = _COPIES * needed_bytes + _PART_BYTES * parts
                free = shutil.disk_usage(self.folder).free
                if free < needed:
                    raise OutputError(
                        f"not enough room in {self.folder}: about {needed / 1e6:.3g} MB are "
                        f"needed, {free / 1e6:.3g} MB are free"
                    )
                yield self
            finally:
                if made and not any(self.folder.glob(f"{_KEY}.part")):
                    self._remove_folder()

    def path(self, key: str) -> Path:
        """File of a chunk."""
        return self.folder / f"{key}.part"

    def read(self, key: str, blanks: Mapping[str, Any], cells: int) -> Part | None:
        """Part of a chunk; none if there is no whole and unchanged one that can be its result.

        A checksum tells accidents, not malice: what the file holds is looked at as well.

        ``blanks``: name of every column that it must have, and a NumPy scalar of its kind.
        """
        path = self.path(key)
        try:
            # A pipe would never end, and a file of another's may fill the memory.
            most = _MOST_BYTES + _MOST_BYTES_A_VALUE * cells * (len(blanks) + 1)
            if not path.is_file() or path.stat().st_size > most:
                return None
            head, _, body = path.read_bytes().partition(b"\n")
            return _part_in(body, blanks, cells) if head == _head(key, body) else None
        except Exception:
            return None  # whatever breaks a file that cannot be read, or was made up

    def write(self, key: str, part: Part) -> None:
        """Keep a part."""
        buffer = io.BytesIO()
        failures = np.array(json.dumps({str(k): v for k, v in part.failures.items()}))
        # The stub takes every keyword for the flag that may stand among them.
        np.savez(buffer, **part.columns, **{_FAILURES: failures})  # type: ignore[arg-type]
        body = buffer.getvalue()
        scratch = self._scratch(key)
        try:
            scratch.write_bytes(_head(key, body) + b"\n" + body)
            scratch.replace(self.path(key))
        except OSError as error:
            with suppress(OSError):
                scratch.unlink(missing_ok=True)
            raise OutputError(f"cannot write to {self.folder}: {writing_trouble(error)}") from error

    def remove_parts(self, keys: Iterable[str]) -> None:
        """Delete the parts of some chunks, and the folder if nothing else is in it.

        Other computations may keep theirs in the same folder, and so may its owner other files.
        """
        for key in keys:
            self.path(key).unlink(missing_ok=True)
            self._scratch(key).unlink(missing_ok=True)
        self._remove_folder()

    def _scratch(self, key: str) -> Path:
        return self.folder / f"{key}.scratch"

    def _remove_folder(self) -> None:
        with suppress(OSError):  # an open file cannot be deleted everywhere, nor a full folder
            (self.folder / _LOCK).unlink(missing_ok=True)
            self.folder.rmdir()


def _part_in(body: bytes, blanks: Mapping[str, Any], cells: int) -> Part | None:
    """Part that an archive holds; none if it has other columns, kinds or lengths."""
    with np.load(io.BytesIO(body), allow_pickle=False) as archive:
        if sorted(archive.files) != sorted([*blanks, _FAILURES]):
            return None
        columns = {name: archive[name] for name in blanks}
        texts = json.loads(str(archive[_FAILURES]))
    for name, column in columns.items():
        kind = np.asarray(blanks[name]).dtype
        alike = column.dtype.kind == "U" if kind.kind == "U" else column.dtype == kind
        if not alike or column.shape != (cells,):
            return None
    failures = {int(cell): text for cell, text in texts.items()}
    if not all(0 <= cell < cells and isinstance(text, str) for cell, text in failures.items()):
        return None
    return Part(columns, failures)


def _head(key: str, body: bytes) -> bytes:
    return f"solar-uav part 1 {key} {hashlib.sha256(body).hexdigest()}".encode()


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock file."""
    from filelock import lock_descriptor  # for those who keep parts

    # A link in its place could lead to any file of the user's, which would be emptied.
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise OutputError(f"cannot write to {path.parent}: {path.name} in it is not a plain file")
    try:
        file = os.fdopen(os.open(path, flags, 0o666), "r+b", buffering=0)
    except OSError as error:
        raise OutputError(f"cannot write to {path.parent}: {writing_trouble(error)}") from error
    with file:
        if not lock_descriptor(file.fileno(), blocking=False):
            holder = ""
            with suppress(OSError):  # Windows lets nobody else read what is locked
                holder = file.read(200).decode(errors="replace").strip()
            who = f" ({holder})" if holder else ""
            raise OutputError(
                f"another run{who} works in {path.parent}: wait for it, or choose another place"
            )
        file.truncate(0)
        file.write(f"process {os.getpid()} on {socket.gethostname()}".encode())
        yield
