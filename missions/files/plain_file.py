"""Reading files of unknown origin: plain files of a bounded size, nothing else."""

from __future__ import annotations

import os
from pathlib import Path

from missions.files.errors import file_error, printable


def read_plain_file(path: str | os.PathLike[str], *, most_bytes: int) -> bytes:
    """Read a file whole, if it is one.

    A pipe would keep its reader waiting, and a device may never end.
    """
    source = printable(os.fspath(path))
    if "\0" in os.fspath(path):
        raise file_error(source, "cannot be read: is no name of a file")
    try:
        place = Path(path)
        if place.is_dir():
            raise file_error(source, "cannot be read: is a folder")
        if place.exists() and not place.is_file():
            raise file_error(source, "cannot be read: is not a plain file")
        with place.open("rb") as file:
            content = file.read(most_bytes + 1)
    except OSError as error:
        reason = "no such file" if isinstance(error, FileNotFoundError) else error.strerror
        raise file_error(source, f"cannot be read: {str(reason).lower()}") from error
    if len(content) > most_bytes:
        raise file_error(source, f"is larger than {most_bytes / 1e6:g} MB")
    return content
