"""Files and folders that a command writes, checked before any work is done for them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePath

import click

from missions.files.errors import printable
from missions.files.writing import check_writable_folder
from studies.engine.chunk_store import check_target
from studies.report import pdf

PAGE, PRINTED = ".html", ".pdf"


def check_files(options: Mapping[str, str | None]) -> None:
    """Refuse files that cannot be written, or all be written, before any work is done for them.

    ``options``: path given with each option.
    """
    taken: dict[str, str] = {}
    for option, path in options.items():
        if path is None:
            continue
        if not path:
            raise click.BadParameter("needs the name of a file", param_hint=option)
        check_target(path)
        if os.path.exists(path) and not os.path.isfile(path):  # noqa: PTH110, PTH113
            continue  # a device or a pipe takes one after the other
        folder, file = os.path.split(os.path.abspath(path))  # noqa: PTH100
        place = os.path.join(os.path.realpath(folder), file)  # noqa: PTH118
        if place in taken:
            raise click.UsageError(f"{taken[place]} and {option} name the same file {path!r}")
        taken[place] = option


def check_folder(option: str, path: str | None) -> None:
    """Refuse a folder that cannot be written, before any work is done for it."""
    if path is not None:
        if not path:
            raise click.BadParameter("needs the name of a folder", param_hint=option)
        check_writable_folder(Path(path))


def refuse_to_overwrite(option: str, path: str | None, read: Iterable[str | None]) -> None:
    """Refuse an output in place of what the command reads: a flight is not flown again."""
    if path is None or not os.path.isfile(path):  # noqa: PTH113
        return
    for one in read:
        if one is not None and os.path.isfile(one) and os.path.samefile(one, path):  # noqa: PTH113, PTH121
            message = f"{printable(path)!r} is read by this command; name another file"
            raise click.BadParameter(message, param_hint=option)


def check_report(path: str | None, *, with_pdf: bool = False, option: str = "--out") -> None:
    """Refuse before any work a report that could not be written.

    ``path``: file that the option names; None where it is not given.
    """
    if path is None:
        return
    suffix = PurePath(path).suffix.lower()
    if suffix not in (PAGE, PRINTED):
        raise click.BadParameter(f"{path!r} must end in .html or .pdf", param_hint=option)
    if (with_pdf or suffix == PRINTED) and not pdf.has_weasyprint():
        raise click.UsageError(pdf.MISSING)
    places = {option: path}
    if with_pdf and suffix == PAGE:
        places["--pdf"] = str(PurePath(path).with_suffix(PRINTED))
    check_files(places)
