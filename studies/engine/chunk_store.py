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
import os
import shutil
import socket
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from missions.files.errors import printable
from missions.files.writing import OutputError, make_folder, probe, writing_trouble
from solar.schema import spell

# Result of one chunk: columns of one value per cell, among them why a cell failed, or nothing.
Part: TypeAlias = dict[str, NDArray[Any]]
FAILURE = "why it failed"  # no other column has a name with spaces

_KEY = "[0-9a-f]" * 40
_LOCK = ".solar-uav.lock"
# Parts and the file made of them stand side by side for a moment, and the file twice.
_COPIES = 3
_PART_BYTES = 4096


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
                        f"not enough room in {self.folder}: about {spell(needed / 1e6, 3)} MB are "
                        f"needed, {spell(free / 1e6, 3)} MB are free"
                    )
                yield self
            finally:
                if made and not any(self.folder.glob(f"{_KEY}.part")):
                    self._remove_folder()

    def path(self, key: str) -> Path:
        """Return the file of a chunk."""
        return self.folder / f"{key}.part"

    def read(self, key: str, blanks: Mapping[str, Any], cells: int) -> Part | None:
        """Return the part of a chunk; None unless there is a whole and unchanged one.

        A checksum tells accidents, not malice: what the file holds is looked at as well.

        ``blanks``: name of every column that it must have, and a NumPy scalar of its kind.
        """
        path = self.path(key)
        try:
            if not path.is_file():  # a pipe would never end
                return None
            head, _, body = path.read_bytes().partition(b"\n")
            if head != _head(key, body):
                return None
            with np.load(io.BytesIO(body), allow_pickle=False) as archive:
                part = dict(archive)
        except Exception:
            return None  # whatever breaks a file that cannot be read, or was made up
        kinds = {name: np.asarray(blank).dtype for name, blank in {**blanks, FAILURE: ""}.items()}
        fits = part.keys() == kinds.keys() and all(
            part[name].shape == (cells,)
            and (part[name].dtype == kind or part[name].dtype.kind == kind.kind == "U")
            for name, kind in kinds.items()
        )
        return part if fits else None

    def write(self, key: str, part: Part) -> None:
        """Keep a part."""
        buffer, scratch = io.BytesIO(), self._scratch(key)
        # The stub takes every keyword for the flag that may stand among them.
        np.savez(buffer, **part)  # type: ignore[arg-type]  # the stubs take an array for a flag
        body = buffer.getvalue()
        try:
            scratch.write_bytes(_head(key, body) + b"\n" + body)
            scratch.replace(self.path(key))
        except OSError as error:
            raise OutputError(f"cannot write to {self.folder}: {writing_trouble(error)}") from error
        finally:
            with suppress(OSError):  # there if the writing was broken off
                scratch.unlink(missing_ok=True)

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


def _head(key: str, body: bytes) -> bytes:
    return f"solar-uav part 2 {key} {hashlib.sha256(body).hexdigest()}".encode()


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold a lock file."""
    from filelock import lock_descriptor  # for those who keep parts

    # A link in its place could lead to any file of the user's, which would be emptied.
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    try:
        if path.is_symlink() or (path.exists() and not path.is_file()):
            raise OSError(f"{path.name} in it is not a plain file")
        file = os.fdopen(os.open(path, flags, 0o666), "r+b", buffering=0)
    except OSError as error:
        raise OutputError(f"cannot write to {path.parent}: {writing_trouble(error)}") from error
    with file:
        if not lock_descriptor(file.fileno(), blocking=False):
            holder = ""
            with suppress(OSError):  # Windows lets nobody else read what is locked
                holder = f" ({file.read(200).decode(errors='replace').strip()})"
            raise OutputError(
                f"another run{holder} works in {path.parent}: wait for it, or choose another place"
            )
        file.truncate(0)
        file.write(f"process {os.getpid()} on {socket.gethostname()}".encode())
        yield
