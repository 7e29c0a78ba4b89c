"""Results of a command: to the terminal, as JSON, and into files."""

from __future__ import annotations

import json
import os
import shlex
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePath
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, TypeAlias

import click
from click.core import ParameterSource

from missions.files.errors import printable
from missions.files.texts import read_plain_file
from missions.files.writing import write_files_atomically
from sizing.results.result import Result
from studies.case import DEFAULT_MISSION, Case
from studies.cli.command import check_outputs
from studies.cli.files import mission_beside, uncertain_inputs
from studies.cli.telling import progress_of, tell_error
from studies.cli.values import PAGE, PRINTED
from studies.output import gridded
from studies.output.figures.drawing import to_bytes
from studies.output.formats import GRID_FORMATS, IMAGE_FORMATS, format_of, table_bytes
from studies.output.run_folder import RESULTS, RunFolder, RunInputs, write_run_folder
from studies.output.terminal import print_json, show, tell_line
from studies.quantities import EXCESS_TIME, TOTAL_MASS
from studies.render.tables import SUMMARY, Line, Summary, Table
from studies.report import pdf

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from studies.cli.options import Drawn
    from studies.output.gridded import OnGrid
    from studies.report.subject import Subject

_COLLAPSED = "constrained_layout not applied because axes sizes collapsed"  # as matplotlib says

# Makes what a file holds, by its name.
Content: TypeAlias = Callable[[str], bytes]
# Inputs, tables and figures of a folder of results.
Folder: TypeAlias = "tuple[RunInputs, dict[str, bytes], dict[str, Content]]"


def deliver(
    case: Case,
    options: Drawn,
    result: Result,
    *,
    table: tuple[str, Callable[[], pd.DataFrame]] | None = None,
    files: Mapping[str | None, Content] | None = None,
    plot: tuple[Any, ...] = (),
    folder: Callable[[], Folder] | None = None,
    report: Callable[[], dict[str, Any]] | None = None,
    record: Callable[[], Any] | None = None,
    remarks: Callable[[], Sequence[str]] = tuple,
    next_step: str | None = None,
) -> None:
    """Write what the options name of a result, and print it, also where one cannot be written.

    Aircraft and mission come first, which JSON has among its keys.

    ``table``: title and what makes it. ``files``: what others hold by their names, None where one
    was not asked for. ``plot``: what draws, and of what. ``folder``: makes what a folder of results
    holds. ``report``: makes arguments of :func:`write_report`. ``record``: what JSON has, by
    default that of the result. ``remarks``: makes lines below the summary. ``next_step``: what to
    do next, for those at a terminal.
    """
    places = vars(options)
    record = record or result.to_dict
    contents = {path: made for path, made in (files or {}).items() if path is not None}
    if table is not None and places["table_file"] is not None:
        contents = {places["table_file"]: table_of(*table), **contents}
    if plot and places["plot_file"] is not None:
        contents[places["plot_file"]] = figure_of(*plot, figure=options.figure)
    written, made = [*contents], dict[str | os.PathLike[str], bytes]()
    try:
        try:
            for path, content in contents.items():
                made[path] = content(path)
        except Exception:
            write_files_atomically(made)  # data, where they cannot be drawn
            raise
        write_files_atomically(made)
        if folder is not None and places["out_dir"] is not None:
            written.append(places["out_dir"])
            inputs, tables, figures = folder()
            whole = case.named(record())
            write_run_folder(Path(places["out_dir"]), inputs, whole, tables, figures)
        if report is not None and places["report_file"] is not None:
            written.append(places["report_file"])
            write_report(case, places["report_file"], **report())
    finally:  # after a signal, too: a report takes seconds
        if places["as_json"]:
            print_json(case.named(record()))
        else:
            level = SUMMARY + places.get("verbose", False)
            show(_headed(result.at_level(level), case) + Summary(tuple(remarks())))
    if not places["as_json"]:
        name_written(written)
        suggest(next_step)


def name_written(places: Iterable[str]) -> None:
    """Name files and folders that were written."""
    for place in places:
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


def _headed(summary: Summary, case: Case) -> Summary:
    """Return a summary whose first line names aircraft and mission, a default one as such."""
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


def table_of(title: str, frame: Callable[[], pd.DataFrame]) -> Content:
    """Return what makes a table in the format of its file's name."""
    return lambda path: table_bytes(frame(), path, title=title)


def grid_of(data: OnGrid, cells: str) -> Content:
    """Return what makes a file of a result on a grid in the format of its name."""
    return lambda path: gridded.to_bytes(data, format_of(path, GRID_FORMATS), cells)


def figure_of(draw: str | Callable[..., Figure], *arguments: Any, **options: Any) -> Content:
    """Return what makes a figure in the format of its file's name, which was checked before.

    ``draw``: what draws it, or ``module:function``, which is imported for it.
    """

    def content(path: str) -> bytes:
        figure = (resolve_name(draw) if isinstance(draw, str) else draw)(*arguments, **options)
        with warnings.catch_warnings(record=True) as caught:
            warnings.filterwarnings("always", message=_COLLAPSED)
            data = to_bytes(figure, format_of(path, IMAGE_FORMATS) or "png")
        others = [it for it in caught if not str(it.message).startswith(_COLLAPSED)]
        for it in others:
            warnings.warn_explicit(it.message, it.category, it.filename, it.lineno)
        if len(others) < len(caught):
            what = "the figure is too small for its axes and texts"
            tell_error(f"solar-uav: {path}: {what}: give a larger --figure-size, or --no-title")
        return data

    return content


def refuse_to_overwrite(option: str, path: str | None, source: str | None) -> None:
    """Refuse an output in place of what the command reads: a flight is not flown again."""
    if path is None or source is None or not (os.path.isfile(path) and os.path.isfile(source)):  # noqa: PTH113
        return
    if os.path.samefile(source, path):  # noqa: PTH121
        message = f"{printable(path)!r} is read by this command; name another file"
        raise click.BadParameter(message, param_hint=option)


# ---- Reports

_MOST_BYTES = 10_000_000  # of a record of results
# A sizing is that of an aircraft if it has the excess time that was written down, to this [h].
_SAME_H = 1e-6


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


def sizing_of_folder(path: str, case: Case) -> dict[str, Any] | None:
    """Return the record of the sizing in a folder; None where the case is not what was sized.

    ``case``: what it was read as; another mission or other values are not what was sized.
    """
    from sizing.performance import performance

    if RunFolder.at(path) is None:
        return None
    try:
        record = json.loads(read_plain_file(Path(path) / RESULTS, most_bytes=_MOST_BYTES))
        promised = record["simulated"][EXCESS_TIME.name], record[TOTAL_MASS.name]
        known = {"objective", "active_constraints", "masses_kg"} <= record.keys()
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    if not known or promised[0] is None:
        return None
    reached_now = performance(case.aircraft, case.mission, case.solar)
    reached = (
        float(reached_now.cycle.excess_time_h[reached_now.worst_scenario()]),
        float(reached_now.design.total_mass_kg),
    )
    same = all(abs(a - b) <= _SAME_H for a, b in zip(promised, reached, strict=True))
    return dict(record) if same else None


def write_report(
    case: Case, path: str, *, sized: Case | None = None, with_pdf: bool = False, **about: Any
) -> tuple[Subject, list[str]]:
    """Write a report, whole or not at all.

    ``case``: whose files a mistake is placed in. ``path``: file of the page, or of the printed one.
    ``sized``: what the report is on, where that is another case. ``about``: what else
    :class:`Subject` has. Returns what was reported on, and files that were written.
    """
    from studies.report import document  # with all that a page has
    from studies.report.subject import Subject

    shown = sized or case
    subject = Subject(
        shown.aircraft,
        shown.mission,
        shown.solar,
        **{"inputs": shown.inputs()} | about,
        mission_is_default=shown.mission_is_default,
        known_mass_kg=shown.total_mass_kg,
    )
    contents: dict[str | os.PathLike[str], bytes] = {}
    is_page = PurePath(path).suffix.lower() == PAGE
    with progress_of("sections", lines=False) as progress:
        progress(0, len(document.makers(subject)))
        if subject.verification is None:
            with uncertain_inputs(case):
                _ = subject.uncertainty  # a mistake is told before any other work
        page = document.render(subject, progress)
        if is_page:
            contents[path] = page.encode()
        if with_pdf or not is_page:
            printed = str(PurePath(path).with_suffix(PRINTED)) if is_page else path
            contents[printed] = pdf.to_pdf(page)
    write_files_atomically(contents)
    return subject, [os.fspath(name) for name in contents]
