"""Reports: one page about an aircraft on its mission, to be read in a browser or printed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from missions.files.writing import to_json
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.results.design_result import check_subjects
from sizing.results.sizing_study import SizingStudy
from sizing.validity.ranges import model_error_note
from solar.names import CorrectionName, ModelName
from studies import quantities as q
from studies.output.run_folder import InputFile, RunInputs
from studies.render.analysis import landing
from studies.render.words import amount, given, hours, percent
from studies.report.blocks import Fact, Section
from studies.report.sections import AT_THE_END, OF_A_DESIGN, OF_A_LOG, Make
from studies.report.subject import Subject

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
    solar, here = SolarModel(model, correction), InputFile("given in Python", None)
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


def makers(subject: Subject) -> tuple[tuple[str, str, Make], ...]:
    """Return key, heading and maker of the sections of a report; some have nothing to show."""
    of_subject = OF_A_DESIGN if subject.verification is None else OF_A_LOG
    return (*of_subject, *AT_THE_END)


def render(subject: Subject, progress: Callable[[int, int], None] | None = None) -> str:
    """Return the page; ``progress`` takes the numbers of finished and of all sections."""
    sections = []
    for number, (key, title, make) in enumerate(every := makers(subject), 1):
        sections.append(Section(key, title, [*make(subject)]))
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
        sections=[section for section in sections if section.blocks],
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


# ---- The verdict in one sentence, and the numbers that it rests on

_WORDS = {"good": "Requirement met", "edge": "On the edge", "bad": "Requirement not met"}


class Verdict(NamedTuple):
    """A sentence, and whether what it says is ``good``, on the ``edge`` or ``bad``.

    ``word`` says the latter to those who see no colour.
    """

    state: str
    sentence: str
    word: str


def verdict(subject: Subject) -> Verdict:
    """Return whether and by how much the flight is perpetual, and how sure that is."""
    verification = subject.verification
    if verification is None:
        state, sentence = _judged(subject)
        return Verdict(state, sentence, _WORDS[state])
    errors = _errors(verification)
    if not errors:
        text = f"{verification.log.source} has no sample to compare with."
        return Verdict("edge", text, "No comparison")
    model, (average, rms) = min(errors.items(), key=lambda of_model: of_model[1][1])
    text = (
        f"{model} comes closest to the flight of {verification.aircraft}: it errs by "
        f"{percent(average, '+.1f')} on average, RMS {percent(rms)}."
    )
    return Verdict("good", text, "Compared")


def _judged(subject: Subject) -> tuple[str, str]:
    """Return the state and the sentence of a flight."""
    analysis, mission = subject.analysis, subject.mission
    low_h, high_h = (end.least_excess_time_h for end in (analysis.low, analysis.high))
    required, excess = mission.required_excess_time_h, analysis.excess_time_h
    where = analysis.worst_scenario.label
    at = f"in its weakest scenario, {where}," if len(analysis.scenarios) > 1 else f"at {where},"
    who, what = f"{subject.aircraft.name} on {mission.name}", "ends perpetual flight"
    relative, measured = percent(subject.solar.rms_relative, ".0f"), model_error_note
    error = f"one RMS error of the solar model ({relative}{measured(mission.altitude_m)})"
    if mission.flight is not None:
        text, what = landing(analysis).rstrip(".").replace("It flies", "it flies"), "ends it early"
        text = f"{who}, {at} {text}"
        if excess <= 0.0:
            return "bad", f"{text}."
    elif not analysis.is_perpetual:
        hold_h = float(analysis.endurance_h)
        longest = "more than a year" if np.isinf(hold_h) else f"{hours(hold_h)} at most"
        text = (
            f"{who} does not fly perpetually: {at} it flies for {longest}, "
            f"{hours(max(-float(excess), 0.0))} of every day are without power"
        )
        if high_h > 0.0:
            return "edge", f"{text}; with {error} more sun it would fly perpetually."
        return "bad", f"{text}; {error} more sun would not change that."
    elif np.isinf(excess):
        text = f"{who} flies perpetually: {at} the sun always carries it"
    else:
        text = f"{who} flies perpetually: {at} {hours(excess)} of excess time remain"
    if excess < required:
        return "bad", f"{text}, less than the required {given(required, 'h')}."
    if required > 0.0 and np.isfinite(excess):
        text += f", {hours(excess - required)} more than required"
    if low_h <= 0.0:
        return "edge", f"{text}, but {error} less sun {what}."
    if low_h < required:
        return "edge", f"{text}, but {error} less sun leaves {hours(low_h)}, too little."
    if np.isinf(low_h):
        return "good", f"{text}, also with {error} less sun."
    return "good", f"{text}, and {hours(low_h)} with {error} less sun."


def _errors(verification: Verification) -> dict[str, tuple[float, float]]:
    """Return average and RMS error of every model over the whole log [-]."""
    from studies.flight_logs.errors import sections  # with pandas

    if not verification.days:
        return {}
    excluded, filter_s = verification.excluded, verification.days[0].filter_s
    whole = [("log", np.ones(len(excluded), bool))]
    (log,) = sections(verification.samples, excluded, filter_s, "UTC", whole)
    return {
        model: (errors["average_error_relative"], errors["rms_error_relative"])
        for model, errors in log.models.items()
        if errors["rms_error_relative"] is not None
    }


def key_facts(subject: Subject) -> Iterator[Fact]:
    """Yield the key numbers, the most important first."""
    if (compared := subject.verification) is not None:
        log, count = compared.log, len(compared.samples.time_s)
        yield Fact("samples", str(count), f"with the sun up, of {len(log)}")
        long_h = (log.time_s[-1] - log.time_s[0]) / 3600.0
        yield Fact("flight", amount(long_h, "h", ".1f"), f"every {given(log.step_s, 's')}")
        for model, (average, rms) in _errors(compared).items():
            yield Fact(f"error of {model}", percent(average, "+.1f"), f"RMS {percent(rms)}")
        yield Fact("samples left out", str(int(compared.excluded.sum())))
        return
    analysis, required = subject.analysis, subject.mission.required_excess_time_h
    battery, values, design = subject.aircraft.battery, analysis.scenario(), analysis.design
    share = float(design.variables.module_area_m2) / float(design.wing_area_m2)
    least = f"required: {given(required, 'h')}" if required else ""
    yield Fact(*q.EXCESS_TIME.fact(values["excess_time_h"]), least)
    if (scattered := subject.uncertainty) is not None:
        of = f"of {scattered.samples} draws of the uncertain inputs"
        yield Fact("probability", percent(scattered.probability_required.value), of)
    for quantity, label, note in (
        (q.CHARGE_MARGIN, "", "how long the battery stays full"),
        (q.MINIMUM_CHARGE, "", "in the morning"),
        (q.WINGSPAN, "", " ".join(q.ASPECT_RATIO.fact(q.ASPECT_RATIO.of(design)))),
        (q.TOTAL_MASS, "", f"battery {amount(battery.mass_kg, 'kg')}"),
        (q.BATTERY_ENERGY, "battery", given(battery.specific_energy_wh_per_kg, "Wh/kg")),
        (q.MODULE_AREA, "modules", f"{percent(share, '.0f')} of the wing"),
        (q.LOAD, "", f"sun: {q.SOLAR_ENERGY.fact(analysis.solar_energy_wh)[1]} a day"),
    ):
        value = values[quantity.name] if quantity.name in values else quantity.of(design)
        words, text = quantity.fact(value)
        yield Fact(label or words, text, note)
