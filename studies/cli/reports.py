"""Reports of the command line: what they are about, and their files."""

from __future__ import annotations

import json
import os
from pathlib import Path, PurePath
from typing import Any

from missions.files.texts import read_plain_file
from missions.files.writing import write_files_atomically
from sizing.performance import performance
from studies.case import Case
from studies.cli.files import uncertain_inputs
from studies.cli.telling import progress_of
from studies.cli.values import PAGE, PRINTED
from studies.output.run_folder import RESULTS, RunFolder
from studies.quantities import EXCESS_TIME, TOTAL_MASS
from studies.report import document
from studies.report.pdf import to_pdf
from studies.report.subject import Subject

_MOST_BYTES = 10_000_000  # of a record of results
# A sizing is that of an aircraft if it has the excess time that was written down, to this [h].
_SAME_H = 1e-6


def sizing_of_folder(path: str, case: Case) -> dict[str, Any] | None:
    """Return the record of the sizing in a folder; None where the case is not what was sized.

    ``case``: what it was read as; another mission or other values are not what was sized.
    """
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
            contents[printed] = to_pdf(page)
    write_files_atomically(contents)
    return subject, [os.fspath(name) for name in contents]
