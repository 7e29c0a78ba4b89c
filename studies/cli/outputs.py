"""Results of a command: to the terminal, as JSON, and into files."""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, TypeAlias

import click
from click.core import ParameterSource

from missions.files.errors import printable
from missions.files.writing import to_json, write_files_atomically
from sizing.results.result import Result
from studies.cli.command import check_outputs
from studies.cli.files import DEFAULT_MISSION, Case, mission_beside
from studies.cli.telling import tell_error
from studies.output.figures.drawing import to_bytes
from studies.output.formats import image_format, table_bytes
from studies.output.terminal import show, tell_line
from studies.render.tables import Line, Summary, Table
from studies.report import pdf

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

PAGE, PRINTED = ".html", ".pdf"

# Makes what a file holds, by its name.
Content: TypeAlias = Callable[[str], bytes]
Shown: TypeAlias = Result | Summary | Table


def deliver(
    case: Case,
    shown: Shown | Callable[[], Shown],
    files: Mapping[str | None, Content] | None = None,
    *,
    record: Callable[[], Any] | None = None,
    writers: Mapping[str | None, Callable[[str], None]] | None = None,
    next_step: str | None = None,
) -> None:
    """Write the files of a result that were asked for, and print it, also where one cannot be.

    Aircraft and mission come first, which JSON has among its keys.

    ``shown``: what is printed, or a function that makes it where it is. ``files``, ``writers``:
    what files hold, and what writes others and folders, by their names; None where one was not
    asked for. ``record``: makes what JSON has, by default that of the result. ``next_step``: what
    to do next, for somebody at a terminal.
    """
    files, writers = files or {}, writers or {}
    record = shown.to_dict if record is None and isinstance(shown, Result) else record
    try:
        write_results(files)
        for path, write in writers.items():
            if path is not None:
                write(path)
    except BaseException:  # a signal, too: a report takes seconds
        _print_result(case, record, shown)
        raise
    _print_result(case, record, shown)
    if not case.as_json:
        name_written([*files, *writers])
        suggest(next_step)


def _print_result(
    case: Case, record: Callable[[], Any] | None, shown: Shown | Callable[[], Shown]
) -> None:
    if case.as_json:
        print_json(case.named({} if record is None else record()))
        return
    result = shown if isinstance(shown, Result | Summary | Table) else shown()
    show(_headed(result.at_level(case.level) if isinstance(result, Result) else result, case))


def name_written(places: Iterable[str | os.PathLike[str] | None]) -> None:
    """Name files and folders that were written; None where one was not asked for."""
    for place in places:
        if place is not None:
            tell_line(f"written to {place}")


def suggest(step: str | None) -> None:
    """Say on standard error what to do next, where somebody reads along: on a terminal alone."""
    if step is not None and sys.stdout.isatty() and sys.stderr.isatty():
        click.secho(printable(f"next: {step}"), err=True, dim="NO_COLOR" not in os.environ)


def call(verb: str, *others: str) -> str:
    """Call of another command on the aircraft and mission of this one, as it is typed."""
    context = click.get_current_context()
    words = ["solar-uav", verb, context.params["aircraft"]]
    mission = chosen_mission = context.params["mission"]
    chosen = context.get_parameter_source("mission") is ParameterSource.COMMANDLINE
    if chosen_mission is None:
        mission, chosen = mission_beside(context.params["aircraft"]), True
    if mission is not None and (chosen or verb == "size"):  # size has no mission by default
        words += ["-m", mission]
    return shlex.join([*words, *others])


def _headed(shown: Summary | Table, case: Case) -> Summary:
    """Return a summary whose first line names aircraft and mission, a default one as such."""
    summary = Summary((shown,)) if isinstance(shown, Table) else shown
    first, *others = summary.blocks
    text = first if isinstance(first, str) else getattr(first, "text", getattr(first, "title", ""))
    before, aircraft, after = text.partition(case.aircraft.name)
    between, mission, rest = after.partition(case.mission.name)
    if not (aircraft and mission):
        return Summary((Line(case.title, "strong"), *summary.blocks))
    if case.mission_is_default:
        mission += DEFAULT_MISSION
    text = f"{before}{aircraft}{between}{mission}{rest}"
    changed = replace(first, title=text) if isinstance(first, Table) else Line(text, "strong")
    return Summary((changed, *others))


def write_results(files: Mapping[str | None, Content]) -> None:
    """Make and write those files that were asked for; if one cannot be written, none is.

    Where one cannot be made, those before it are written: data, where they cannot be drawn.
    """
    contents: dict[str | os.PathLike[str], bytes] = {}
    try:
        for path, made in files.items():
            if path is not None:
                contents[path] = made(path)
    except Exception:
        write_files_atomically(contents)
        raise
    if contents:
        write_files_atomically(contents)


def table_of(frame: Callable[[], pd.DataFrame], title: str) -> Content:
    """Return what makes a table in the format of its file's name."""
    return lambda path: table_bytes(frame(), path, title=title)


def figure_of(draw: Callable[[], Figure]) -> Content:
    """Return what makes a figure in the format of its file's name, which was checked before."""

    def content(path: str) -> bytes:
        figure = draw()
        data = to_bytes(figure, image_format(path) or "png")
        if getattr(figure.get_layout_engine(), "collapsed", False):
            what = "the figure is too small for its axes and texts"
            tell_error(f"solar-uav: {path}: {what}: give a larger --figure-size, or --no-title")
        return data

    return content


def print_json(record: Any) -> None:
    """Print a record as strict JSON."""
    click.echo(to_json(record, indent=2))


def refuse_to_overwrite(option: str, path: str | None, read: Iterable[str | None]) -> None:
    """Refuse an output in place of what the command reads: a flight is not flown again."""
    if path is None or not os.path.isfile(path):  # noqa: PTH113
        return
    for source in read:
        if source is not None and os.path.isfile(source) and os.path.samefile(source, path):  # noqa: PTH113, PTH121
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
    check_outputs(places)
