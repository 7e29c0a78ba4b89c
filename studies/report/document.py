"""Reports: one page about an aircraft on its mission, to be read in a browser or printed."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
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
from studies.output.run_folder import InputFile, RunInputs
from studies.report.sections import AT_THE_END, OF_A_DESIGN, OF_A_LOG, Make
from studies.report.subject import Subject
from studies.report.verdict import key_facts, verdict

if TYPE_CHECKING:
    from missions.weather.record import Weather
    from studies.flight_logs.verification import Verification


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
    here = InputFile("given in Python", None)
    as_files = [
        described.model_dump(mode="json", by_alias=True, exclude_unset=True)
        for described in (aircraft, mission)
    ]
    return render(
        Subject(
            aircraft,
            mission,
            solar,
            RunInputs(as_files[0], as_files[1], solar, {"aircraft": here, "mission": here}),
            sizing=sizing.to_dict() if isinstance(sizing, SizingStudy) else sizing,
            verification=verification,
            weather_record=weather,
            with_uncertainty=uncertainty,
            project=project,
            author=author,
        )
    )


def makers(subject: Subject) -> tuple[Make, ...]:
    """Return what makes the sections of a report; some make none of this subject."""
    of_subject = OF_A_DESIGN if subject.verification is None else OF_A_LOG
    return (*of_subject, *AT_THE_END)


def render(subject: Subject, progress: Callable[[int, int], None] | None = None) -> str:
    """Return the page; ``progress`` takes the numbers of finished and of all sections."""
    sections = []
    for number, make in enumerate(every := makers(subject), 1):
        sections.append(make(subject))
        if progress is not None:
            progress(number, len(every))
    environment = Environment(
        loader=PackageLoader("studies.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"drawn": Markup, "minus": _with_minus, "titled": _titled}
    page: str = environment.get_template("report.html").render(
        subject=subject,
        verdict=verdict(subject),
        facts=tuple(key_facts(subject)),
        sections=[section for section in sections if section is not None],
        run=subject.run,
        # No text within may end the element that holds it.
        results=to_json(subject.results(), sort_keys=True).replace("<", "\\u003c"),
    )
    return page


def _titled(title: str) -> str:
    """Return the title of a table as a sentence."""
    return f"{title[:1].upper()}{title[1:]}".rstrip(". ") + "."


def _with_minus(text: str) -> str:
    """Return a text whose negative numbers have a minus sign, not a hyphen."""
    return re.sub(r"(?<![\w.\u2212-])-(?=\d)", "\u2212", text)
