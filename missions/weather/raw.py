"""Raw contents of a weather file: its text, and the table that a reader makes of it."""

from __future__ import annotations

import gzip
import io
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, NamedTuple

from missions.files.errors import refused
from missions.files.texts import decoded, open_plain, read_plain_file
from missions.weather.record import Site

if TYPE_CHECKING:
    import pandas as pd

MAXIMUM_BYTES = 80_000_000  # unpacked as well; a table of it takes some 900 MB to read
_LONGEST_LINE = 20_000
HEAD_LENGTH = 16_384  # of a text, by which its layout is known
# Share of the interval that has passed at a row's time.
START, MIDDLE, END = 0.0, 0.5, 1.0

_NETCDF = (b"CDF", b"\x89HDF")
_GZIP = b"\x1f\x8b"
_PACKED = {b"PK\x03\x04": "zip", b"BZh": "bzip2", b"\xfd7zXZ": "xz", b"7z\xbc\xaf": "7z"}


class RawTable(NamedTuple):
    """Table of a file, as pvlib returns it.

    ``site``: place of measurement. ``table``: columns ``ghi``, ``dni``, ``dhi`` [W/m2],
    ``temp_air`` [C], ``wind_speed`` [m/s], as far as the file has them; its index is the time, with
    its zone. ``passed``: share of the interval before a row's time: 0 start, 0.5 middle, 1 end.
    ``layout``: name of the file's layout, which ``read_layout`` sets. ``offset_s``: seconds to add
    to every row's time. ``interval_s``: length of a row's interval if shorter than the
    spacing of rows. ``first_line``: line of the first row in the file, counted from 1; 0 if rows
    are not lines. ``air_altitude_m``: altitude of temperature and wind, if not near the ground.
    ``notes``: assumptions.
    """

    site: Site
    table: pd.DataFrame
    passed: float
    layout: str = ""
    offset_s: float = 0.0
    interval_s: float | None = None
    first_line: int = 0
    air_altitude_m: float | None = None
    notes: tuple[str, ...] = ()


def text_of(path: Path) -> str | None:
    """Return a file's text, packed with gzip or not, with line feeds; None for NetCDF."""
    with open_plain(path) as file:
        if file.peek(4).startswith(_NETCDF):
            return None
    content = read_plain_file(path, most_bytes=MAXIMUM_BYTES)
    if content.startswith(_GZIP):
        try:
            with gzip.open(io.BytesIO(content)) as packed:
                content = packed.read(MAXIMUM_BYTES + 1)
        except (OSError, EOFError, zlib.error) as error:
            raise refused(f"cannot be read: {error}") from error
    if len(content) > MAXIMUM_BYTES:
        size = f"is larger than {MAXIMUM_BYTES // 1_000_000} MB"
        raise refused(f"{size} when it is unpacked")
    start = content[:HEAD_LENGTH]
    if not start.strip():
        raise refused("is empty")
    for begin, kind in _PACKED.items():
        if start.startswith(begin):
            raise refused(f"is packed with {kind}: unpack it; allowed: gzip, or none")
    if b"\0" in start:
        raise refused("is no text file")
    if b"\r" in content:  # not in a text, which may be larger
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if not content.lstrip().startswith(b"{"):  # JSON may be a single line
        for number, line in enumerate(io.BytesIO(content), 1):
            if len(line) > _LONGEST_LINE:
                place = f"line {number} has more than {_LONGEST_LINE} characters"
                raise refused(f"{place}: no row of a weather file")
    return decoded(content)[0]


@contextmanager
def as_file(text: str) -> Iterator[str]:
    """Yield a plain file of a text, for readers that take neither gzip nor byte order marks."""
    with TemporaryDirectory() as folder:
        plain = Path(folder) / "plain.txt"
        plain.write_text(text, encoding="utf-8")
        yield str(plain)
