"""Command line of the modules that draw one figure of the documentation."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from missions.files.writing import OutputError, write_bytes_atomically
from studies.output.figures.drawing import read_style
from studies.output.figures.options import (
    SHIPPED_STYLES,
    FigureOptions,
    read_dots_per_inch,
    read_size,
)
from studies.output.formats import IMAGE_FORMATS, format_of


def add_figure_arguments(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of figures that the commands of ``solar-uav`` have."""
    for name, reader, metavar, help_text in (
        ("--figure-size", read_size, "WIDTHxHEIGHT", "for example 170x100mm, 7x4in or 85mm"),
        ("--dpi", read_dots_per_inch, "DOTS", "dots per inch of PNG"),
        ("--style", read_style, "NAME|FILE", f"{', '.join(SHIPPED_STYLES)}, one of matplotlib's"),
    ):
        parser.add_argument(name, type=_told(reader), metavar=metavar, help=help_text)
    parser.add_argument("--no-title", action="store_true", help="no title over the figure")


def _told(reader: Callable[[str], Any]) -> Callable[[str], Any]:
    """Reader whose message argparse shows."""

    def read(text: str) -> Any:
        try:
            return reader(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return read


def figure_of_arguments(
    parser: argparse.ArgumentParser, given: argparse.Namespace
) -> FigureOptions:
    """What the options of :func:`add_figure_arguments` ask for."""
    try:
        return FigureOptions(
            given.figure_size, given.dpi, given.style or "default", not given.no_title
        )
    except ValueError as error:
        parser.error(f"--dpi: {error}")


def write_figure(
    draw: Callable[[str, FigureOptions], bytes],
    arguments: list[str] | None = None,
    *,
    prog: str,
    description: str | None,
) -> int:
    """Write the figure to the file that ``--out`` names; the exit code is 1 where it cannot.

    ``draw``: makes the image in a format, ``png``, ``svg`` or ``pdf``, as the options ask for.
    ``arguments``: arguments of the command line, by default those of the process. ``prog``,
    ``description``: name and purpose of the command, for its help.
    """
    parser = argparse.ArgumentParser(prog=prog, description=description)
    parser.add_argument("--out", required=True, type=Path, help="PNG, SVG or PDF file to write")
    add_figure_arguments(parser)
    given = parser.parse_args(arguments)
    figure = figure_of_arguments(parser, given)
    drawn_as = format_of(str(given.out), IMAGE_FORMATS)
    if drawn_as is None:
        allowed = ", ".join(f".{name}" for name in IMAGE_FORMATS)
        parser.error(f"--out must end in one of {allowed} (got {given.out})")
    try:
        write_bytes_atomically(given.out, draw(drawn_as, figure))
    except OutputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0
