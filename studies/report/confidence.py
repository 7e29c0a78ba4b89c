"""Sections on how far the results may be trusted, and on what went into them."""

from __future__ import annotations

from typing import Any

from missions.files.writing import to_yaml
from sizing.results.analysis_summary import settling_line, uncertainty_line
from sizing.results.conditions import battery_line
from sizing.results.tables import Column, Table, facts
from solar.systematic_errors import REPORTED_ERRORS
from studies.report.blocks import Block, Items, Listing, Section, Tables, Text
from studies.report.margins import margin_table
from studies.report.subject import Subject


def margins_section(subject: Subject) -> Section:
    """How much worse each assumption may become."""
    text = (
        "Each quantity is moved alone until the weakest scenario just has what is required; all "
        "else stays as it is, the mass with the battery's specific energy as well."
    )
    table = margin_table(subject)
    if table is None:
        text = (
            "None: the weakest scenario has just what is required. A little less of any quantity, "
            "of the sun or the battery, ends it."
        )
        return Section("margins", "Margins", [Text(text, "warning")])
    return Section("margins", "Margins", [Tables((table,)), Text(text, "faint")])


def belief_section(subject: Subject) -> Section:
    """Ranges of the models that were left, errors of the solar models, and what is left out."""
    blocks: list[Block] = []
    if subject.verification is None:
        analysis = subject.analysis
        outside = analysis.extrapolations
        if outside:
            blocks.append(Text("Outside the range of a model:", "warning"))
            blocks.append(Items(tuple(one.text for one in outside)))
        else:
            blocks.append(Text("Nothing lies outside the range of a model.", "good"))
        blocks.append(
            Text(uncertainty_line(analysis.low, analysis.high, analysis.worst, subject.mission))
        )
        slow = settling_line(analysis)
        if slow is not None:
            blocks.append(Text(slow, "warning"))
        condition = battery_line(subject.aircraft, subject.mission)
        if condition is not None:
            blocks.append(Text(f"{condition[:1].upper()}{condition[1:]}."))
    blocks.append(Tables((_published_errors(),)))
    blocks.append(Items(_left_out(subject)))
    return Section("belief", "Confidence", blocks)


def _published_errors() -> Table:
    columns = (
        Column("model"),
        Column("average", "mean error", "%", "+.2f"),
        Column("rms", "RMS error", "%", ".2f"),
        Column("scatter", "RMS without the mean", "%", ".2f"),
    )
    rows = [
        (model, 100.0 * error.average, 100.0 * error.rms, 100.0 * error.scatter)
        for model, error in REPORTED_ERRORS.items()
    ]
    note = (
        "of the mean measured power; one flight of AtlantikSolar AS-2, 47.6° N, 1 July 2015, "
        "sunrise to 9.72 h (Oettershagen, High-Fidelity Solar Power Income Modeling, table 3)"
    )
    return Table("published errors of the solar power models", columns, tuple(rows), (note,))


def _left_out(subject: Subject) -> tuple[str, ...]:
    mission = subject.mission
    sky = (
        "The sky is clear"
        if mission.pessimistic_clearness == 1.0
        else f"The light is {100.0 * mission.pessimistic_clearness:.0f} % of a clear sky's"
    )
    sentences = [f"{sky} all day; clouds come in with a weather record (--weather)."]
    if subject.verification is None and subject.analysis.days is None:
        sentences.append(
            "The day repeats itself: the date does not advance, and the battery's state at dawn is "
            "that of the settled cycle."
        )
    if subject.verification is None and subject.aircraft.battery.ageing is None:
        sentences.append("The battery is new: the aircraft file has no ageing.")
    still = mission.turbulence.all_day == 0.0 and mission.turbulence.thermal == 0.0
    if subject.verification is None and mission.holds_station:
        sentences.append("The wind is steady: faster flight against it takes as much all day.")
    elif subject.verification is None and still:
        sentences.append("The air is calm: level flight takes no more power than in still air.")
    left_out = subject.with_uncertainty is None and subject.has_uncertain_inputs
    if subject.verification is None and left_out and not subject.uncertainty_is_quick:
        sentences.append(
            f"Uncertain inputs: left out, {len(mission.scenarios())} scenarios take long "
            "(--uncertainty)."
        )
    if mission.uncertainty_margins.given:
        sentences.append("The mission's uncertainty margins are taken off every number here.")
    return tuple(sentences)


def inputs_section(subject: Subject) -> Section:
    """Aircraft and mission as they were used."""
    blocks: list[Block] = []
    if subject.overrides:
        blocks.append(Text("Values given in place of the files' own:"))
        blocks.append(Items(subject.overrides))
    if subject.mission_is_default:
        blocks.append(Text("The mission is the default: nobody chose one.", "warning"))
    taken = subject.aircraft.from_catalogues()
    if taken:
        columns = (Column("key"), Column("value"), Column("label", "product"), Column("source"))
        rows = [(one.key, one.text, one.label, one.source) for one in taken]
        blocks.append(Tables((Table("values from catalogues", columns, tuple(rows)),)))
    for title, data in (
        (f"aircraft {subject.aircraft.name}", subject.inputs.aircraft),
        (f"mission {subject.mission.name}", subject.inputs.mission),
    ):
        blocks.append(Listing(title, to_yaml(data, compact=True)))
    return Section("inputs", "Inputs", blocks)


def provenance_section(subject: Subject, run: dict[str, Any]) -> Section:
    """Command line, software and files that the report was made from."""
    solar = subject.solar
    made = [
        ("date (UTC)", run["date_utc"].replace("T", " ").removesuffix("+00:00")),
        ("solar-uav", run["version"]),
        ("Python", run["python"]),
    ]
    if subject.verification is None:
        made.insert(0, ("solar power model", solar.label))
    columns = (Column("what"), Column("source", "file"), Column("sha256", "SHA-256"))
    files = [
        (kind, file["source"], file["sha256"] or "not read again (a pipe)")
        for kind, file in run["inputs"].items()
    ]
    return Section(
        "provenance",
        "How this report was made",
        [
            Listing("command line", run["command"]),
            Tables((facts("software", made), facts("libraries", list(run["libraries"].items())))),
            Tables((Table("files", columns, tuple(files)),)),
        ],
    )
