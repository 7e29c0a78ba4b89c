"""Command line of the modules that draw one figure of the documentation."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from missions.files.writing import OutputError, write_bytes_atomically
from studies.output.formats import IMAGE_FORMATS, image_format


def write_figure(
    draw: Callable[[str], bytes],
    arguments: list[str] | None = None,
    *,
    prog: str,
    description: str | None,
) -> int:
    """Write the figure to the file that ``--out`` names; the exit code is 1 where it cannot.

    Parameters
    ----------
    draw : callable
        Makes the image in a format: ``png``, ``svg`` or ``pdf``.
    arguments : list of str, optional
        Arguments of the command line, by default those of the process.
    prog, description : str
        Name and purpose of the command, for its help.

    Returns
    -------
    int
        Exit code.
    """
    parser = argparse.ArgumentParser(prog=prog, description=description)
    parser.add_argument("--out", required=True, type=Path, help="PNG, SVG or PDF file to write")
    given = parser.parse_args(arguments)
    drawn_as = image_format(str(given.out))
    if drawn_as is None:
        allowed = ", ".join(f".{name}" for name in IMAGE_FORMATS)
        parser.error(f"--out must end in one of {allowed} (got {given.out})")
    try:
        write_bytes_atomically(given.out, draw(drawn_as))
    except OutputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0
