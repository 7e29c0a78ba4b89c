"""What results tell of the ranges of their models, and of where values of the file come from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.parameters import unit_text
from sizing.performance import Performance
from sizing.relaxed_flight import Relaxation
from sizing.results import quantities as q
from sizing.results.records import finite_values, hours
from sizing.results.requirements import parameter_words
from sizing.results.tables import MISSING, Column, Line, Table, facts
from sizing.structures.assessment import StructureAssessment
from sizing.validity.ranges import Extrapolation, where_error_is_known

HEADING = "outside the range of a model:"
# Of what is assumed instead of a model, by the model: whose excess time a note has.
_OTHERWISE = {"module_temperature": "modules as cold as the air", "battery": "unheated battery"}


def extrapolation_blocks(extrapolations: Sequence[Extrapolation]) -> list[Any]:
    """Blocks of a summary, a line for each quantity; none where nothing is outside."""
    if not extrapolations:
        return []
    head, *lines = extrapolation_lines(extrapolations)
    return [Line(head, "warning"), *lines]


def extrapolation_lines(extrapolations: Sequence[Extrapolation]) -> list[str]:
    """Lines below a table; none where nothing is outside."""
    return [HEADING, *(f"  {one.text}" for one in extrapolations)] if extrapolations else []


def extrapolation_records(extrapolations: Sequence[Extrapolation]) -> list[dict[str, Any]]:
    """List of the key ``extrapolations``, JSON-ready."""
    return [one.to_dict() for one in extrapolations]


def extrapolation_caption(extrapolations: Sequence[Extrapolation]) -> str:
    """Line of a figure's caption; empty where nothing is outside."""
    if not extrapolations:
        return ""
    names = dict.fromkeys(
        one.label
        if one.excess_time_h is None
        else f"{one.holder} ({_OTHERWISE[one.model]}: excess time {hours(one.excess_time_h)})"
        for one in extrapolations
    )
    return f"extrapolated: {', '.join(names)}"


def structure_blocks(structure: StructureAssessment | None) -> list[Any]:
    """What sizes the structure, and what its criteria do not cover; none where no model says."""
    if structure is None:
        return []
    return [structure.headline(), *(Line(text, "faint") for text in structure.remarks)]


def mass_table(masses_kg: Mapping[str, float]) -> Table:
    """Mass budget as a list of facts."""
    words = {"mppt": "MPPT"}
    masses = [(words.get(item, item), f"{mass:.3f} kg") for item, mass in masses_kg.items()]
    return facts("", [("mass budget", ""), *masses])


def source_blocks(aircraft: Aircraft, mission: Mission) -> list[Any]:
    """Lines on what was left out of the files, and on the values that catalogues gave."""
    notes = [*aircraft.reading_notes(), *mission.reading_notes()]
    lines = [Line(text, "faint") for text in notes]
    taken = aircraft.from_catalogues()
    if not taken:
        return lines
    labels = dict.fromkeys(one.label for one in taken)
    parts = []
    for label in labels:
        values = [f"{one.key} {one.text}" for one in taken if one.label == label]
        parts.append(f"{', '.join(values)} of {label}")
    return [*lines, Line(f"From catalogues: {'; '.join(parts)}.", "faint")]


def source_records(aircraft: Aircraft, mission: Mission) -> dict[str, Any]:
    """Keys ``from_catalogues`` and ``reading_notes`` of a record, where there is something."""
    records = {
        "from_catalogues": [one.to_dict() for one in aircraft.from_catalogues()],
        "reading_notes": [*aircraft.reading_notes(), *mission.reading_notes()],
    }
    return {key: value for key, value in records.items() if value}


def relaxation_table(relaxations: Sequence[Relaxation], title: str = "feasible") -> Table:
    """Values of single parameters that suffice each for itself, smallest change first."""
    columns = (
        Column("parameter"),
        Column("now", form=".4g"),
        Column("needed", to_right=True),
        Column("key", "key in the file"),
    )
    rows = [
        (
            parameter_words(one.parameter),
            one.present,
            f"{one.direction} {one.value:g} {unit_text(one.unit)}".rstrip(),
            one.parameter if "." in one.parameter else MISSING,
        )
        for one in relaxations
    ]
    return Table(f"{title} with one of these, all else unchanged", columns, tuple(rows))


def relaxation_records(relaxations: Sequence[Relaxation]) -> list[dict[str, Any]]:
    """Relaxations, JSON-ready, with their texts."""
    return [{**finite_values(one.__dict__), "text": one.text} for one in relaxations]


def uncertainty_line(low: Performance, high: Performance, index: int, mission: Mission) -> str:
    """What the RMS error of the solar power model means for the least excess time.

    ``low``, ``high``: with the solar power one RMS error lower and higher. ``index``: the worst
    scenario without the error; where it is another one with less sun, that one is named.
    ``mission``: with its uncertainty margins, which are taken off before that error.
    """
    ends_h = [float(np.min(q.EXCESS_TIME.of(one))) for one in (low, high)]
    # Less sun may turn a scenario with a short day into the worst one.
    weakest = low.worst_scenario()
    at = "" if weakest == index else f" ({low.day.scenarios.label(weakest)})"
    means = (
        f"leaves the excess time {'unlimited' if np.isinf(ends_h[0]) else f'at {hours(ends_h[0])}'}"
        if hours(ends_h[0]) == hours(ends_h[1])
        else f"puts the excess time between {hours(ends_h[0])}{at} and {hours(ends_h[1])}"
    )
    solar, given = low.solar, mission.uncertainty_margins.given
    beyond = ", on top of the mission's uncertainty margins," if given else ""
    plain = solar.correction == "none"
    error = "the model's RMS error" if plain else "the RMS error left after it"
    if where := where_error_is_known(mission.altitude_m):
        return (
            f"{solar.label}; its error at {mission.altitude_m:g} m is not known. One of "
            f"{100 * solar.rms_relative:.0f} % of the mean power,{where},{beyond[1:]} "
            f"would {means.replace('leaves', 'leave', 1).replace('puts', 'put', 1)}."
        )
    return (
        f"{solar.label}; {error} of "
        f"{100 * solar.rms_relative:.0f} % of the mean power{beyond} {means}."
    )
