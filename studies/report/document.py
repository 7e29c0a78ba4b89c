"""Reports: one page about an aircraft on its mission, to be read in a browser or printed."""

from __future__ import annotations

import dataclasses
import re
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from missions.files.writing import to_json
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.results.design_result import check_subjects
from sizing.results.sizing_study import SizingStudy
from solar.names import CorrectionName, ModelName
from studies.output.run_folder import InputFile, RunInputs, run_record
from studies.report.blocks import Bars, Block, Figure, Section, Tables
from studies.report.confidence import (
    belief_section,
    glossary_section,
    inputs_section,
    margins_section,
    provenance_section,
)
from studies.report.design import aircraft_section, budget_section, sizing_section
from studies.report.flight import (
    day_section,
    models_section,
    season_section,
    uncertainty_section,
    verification_section,
    weather_section,
)
from studies.report.subject import Subject
from studies.report.verdict import key_facts, verdict

if TYPE_CHECKING:
    from missions.weather.record import Weather
    from studies.flight_logs.verification import Verification

_OF_A_FLIGHT: tuple[Callable[[Subject], Section | None], ...] = (
    budget_section,
    day_section,
    season_section,
)
_BEYOND: tuple[Callable[[Subject], Section | None], ...] = (
    margins_section,
    uncertainty_section,
    weather_section,
)
SECTIONS = 3 + len(_OF_A_FLIGHT) + len(_BEYOND)  # with aircraft, confidence and models


def make_report(
    aircraft: Aircraft,
    mission: Mission,
    *,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    sizing: SizingStudy | Mapping[str, Any] | None = None,
    verification: Verification | None = None,
    weather: Weather | None = None,
    uncertainty: bool | None = None,
    project: str = "",
    author: str = "",
) -> str:
    """Report on an aircraft and its mission: a page of HTML that needs no other file.

    Parameters
    ----------
    aircraft : Aircraft
    mission : Mission
        Its latitudes and dates are the scenarios.
    model : {"CAM", "CDM", "VM", "FM"}
        Solar power model; VM and FM need module surfaces and a flight path.
    correction : {"none", "report", "loiter"}
        Correction of the model's systematic error.
    sizing : SizingStudy or mapping, optional
        Sizing that the aircraft came from, or its record: with
        ``study.sized_aircraft()`` and ``study.sized_mission()`` as aircraft and mission.
    verification : Verification, optional
        Models against a flight log: the report is then about these.
    weather : Weather, optional
        Record to fly through, see :func:`missions.load_weather`.
    uncertainty : bool, optional
        Whether inputs scatter; by default where aircraft or mission has uncertain inputs.
    project, author : str, optional
        For the head of the page.

    Returns
    -------
    str
        The page; :func:`studies.report.pdf.to_pdf` prints it.

    Raises
    ------
    TypeError
        For what is no aircraft or mission, such as their names.
    ValueError
        For an unknown model or correction, or a model that lacks surfaces or path.
    ImpossibleDesignError
        If a parametric aircraft cannot carry its own mass.
    InputError
        For uncertain inputs that contradict the files' rules.
    """
    check_subjects(aircraft, mission)
    solar = SolarModel(model, correction)
    files = {"aircraft": InputFile("given in Python", None)} | {
        "mission": InputFile("given in Python", None)
    }
    inputs = RunInputs(_as_file(aircraft), _as_file(mission), solar, files)
    record = sizing.to_dict() if isinstance(sizing, SizingStudy) else sizing
    return render(
        Subject(
            aircraft,
            mission,
            solar,
            inputs,
            sizing=record,
            verification=verification,
            weather_record=weather,
            with_uncertainty=uncertainty,
            project=project,
            author=author,
        )
    )


def _as_file(described: Aircraft | Mission) -> dict[str, Any]:
    """Return an aircraft or mission as the content of its file."""
    return described.model_dump(mode="json", by_alias=True, exclude_unset=True)


def render(subject: Subject, progress: Callable[[int, int], None] | None = None) -> str:
    """Return the page; ``progress`` takes the numbers of finished and of all sections."""
    run = run_record(subject.solar, subject.inputs.files)
    if sys.argv[:1] and not sys.argv[0].endswith("solar-uav"):
        run["command"] = shlex.join(["python", *sys.argv]) if sys.argv[0] else "python"
    made: list[Section] = []
    for section in _sections(subject):
        made.append(section)
        if progress is not None:
            progress(len(made), max(SECTIONS, len(made)))
    made += [glossary_section(), provenance_section(subject, run), inputs_section(subject)]
    sections = list(_numbered(made))
    results = to_json(subject.results(), sort_keys=True)
    page: str = _template().render(
        subject=subject,
        verdict=verdict(subject),
        facts=tuple(key_facts(subject)),
        head=[(name, text) for name, text in _head(subject, run) if text],
        sections=sections,
        run=run,
        # No text within may end the element that holds it.
        results=results.replace("<", "\\u003c"),
    )
    return page


def _head(subject: Subject, run: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield what stands on the head of the page: project, author, date."""
    yield "Project", subject.project
    yield "Author", subject.author
    yield "Date", run["date_utc"][:10]


def _sections(subject: Subject) -> Iterator[Section]:
    """Yield the sections in the order in which a design review reads them."""
    yield aircraft_section(subject)
    log = verification_section(subject)
    if log is not None:
        yield log
    else:
        for make in _OF_A_FLIGHT:
            if (section := make(subject)) is not None:
                yield section
        if subject.sizing is not None:
            yield sizing_section(subject.sizing)
        for make in _BEYOND:
            if (section := make(subject)) is not None:
                yield section
    yield belief_section(subject)
    if log is None:
        yield models_section(subject)


def _numbered(sections: Sequence[Section]) -> Iterator[Section]:
    """Yield the sections with figures and tables numbered through."""
    figures = tables = 0
    for section in sections:
        blocks: list[Block] = []
        for block in section.blocks:
            if isinstance(block, Figure):
                figures += 1
                block = dataclasses.replace(block, caption=f"Figure {figures}. {block.caption}")
            elif isinstance(block, Bars):
                tables += 1
                block = dataclasses.replace(block, title=_titled(tables, block.title))
            elif isinstance(block, Tables):
                named = []
                for table in block.tables:
                    tables += 1
                    title = _titled(tables, table.title)
                    named.append(dataclasses.replace(table, title=title))
                block = Tables(tuple(named))
            blocks.append(block)
        yield dataclasses.replace(section, blocks=tuple(blocks))


def _titled(number: int, title: str) -> str:
    """Return the title of a table with its number."""
    return f"Table {number}. {title[:1].upper()}{title[1:]}".rstrip(". ") + "."


def _with_minus(text: str) -> str:
    """Return a text whose negative numbers have a minus sign, not a hyphen."""
    return re.sub(r"(?<![\w.\u2212-])-(?=\d)", "\u2212", text)


def _template() -> Any:
    """Return the template of the page; every text in it is escaped."""
    environment = Environment(
        loader=PackageLoader("studies.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["drawn"] = Markup
    environment.filters["minus"] = _with_minus
    return environment.get_template("report.html")
