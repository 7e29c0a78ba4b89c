"""Blocks that results of an analysis and of a sizing have in common."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from missions.mission import Mission
from sizing.parameters import unit_text
from sizing.relaxed_flight import Relaxation
from sizing.results.conditions import wind_of
from studies import quantities as q
from studies.render import sentences as say
from studies.render.numbers import amount
from studies.render.tables import ALL, MISSING, Line, Table, facts
from studies.render.words import parameter_words

if TYPE_CHECKING:
    from sizing.results.analysis import Analysis
    from sizing.results.sizing_study import SizingStudy


_SCREEN, _GAPS = 80, 2 + 5 + 2  # characters of a line, and those between two columns of facts


def in_columns(
    rows: list[tuple[str, str]], masses_kg: Mapping[str, float] | None, level: int
) -> list[Any]:
    """Return facts in two columns, long ones below; at level 2 with the mass budget beside."""
    if level >= ALL:
        return [facts("", rows) if masses_kg is None else (facts("", rows), mass_table(masses_kg))]
    lines: list[Any] = []
    while True:
        half = (len(rows) + 1) // 2
        halves = rows[:half], rows[half:]
        widths = (max(map(len, cells)) for column in halves for cells in zip(*column, strict=True))
        if sum(widths) + _GAPS <= _SCREEN:
            return [tuple(facts("", column) for column in halves), *lines]
        longest = max(rows, key=lambda row: len("".join(row)))
        rows = [row for row in rows if row is not longest]
        lines.append(": ".join(longest))


def facts_of(values: Mapping[q.Quantity, Any], level: int) -> list[tuple[str, str]]:
    """Return the quantities of a level that have a value."""
    shown = (
        (quantity, value) for quantity, value in values.items() if quantity.importance <= level
    )
    return [quantity.fact(value) for quantity, value in shown if value is not None]


def wind_source(mission: Mission) -> Iterable[str]:
    """Return where the winds are from, and whether the flight is as fast."""
    wind = wind_of(mission)
    if wind is None:
        return ()
    held = "; airspeed at least that of the wind, to hold its place" if wind.hold_station else ""
    return (f"winds from {wind.source}{held}",)


def sources(result: Analysis | SizingStudy, level: int) -> list[Any]:
    """Return what was left out of the files, and which values catalogues gave."""
    lines = [*result.reading_notes]
    if level >= ALL and (text := say.catalogue_line(result.aircraft)) is not None:
        lines.append(text)
    return [Line(text, "faint") for text in lines]


def battery_lines(result: Analysis | SizingStudy) -> list[Any]:
    """Return the battery in the mission's air in a line; none where nothing changes it."""
    condition = result.battery_condition
    return [] if condition is None else [say.battery_line(result.aircraft, condition)]


def structure_lines(result: Analysis | SizingStudy) -> list[Any]:
    """Return what sizes the structure, and what its criteria do not cover."""
    structure = result.structure
    if structure is None:
        return []
    return [structure.headline(), *(Line(text, "faint") for text in structure.remarks)]


def mass_table(masses_kg: Mapping[str, float]) -> Table:
    """Return the mass budget as a list of facts."""
    words = {"mppt": "MPPT"}
    masses = [(words.get(item, item), amount(mass, "kg")) for item, mass in masses_kg.items()]
    return facts("", [("mass budget", ""), *masses])


def relaxation_table(relaxations: Sequence[Relaxation], title: str = "feasible") -> Table:
    """Return values of single parameters that each suffice alone, smallest change first."""
    parameter, now, needed, key = q.group("parameter now needed key")
    columns = (parameter, now, replace(needed, to_right=True), key)
    rows = [
        (
            parameter_words(row.parameter),
            row.present,
            f"{row.direction} {row.value:g} {unit_text(row.unit)}".rstrip(),
            row.parameter if "." in row.parameter else MISSING,
        )
        for row in relaxations
    ]
    return Table(f"{title} with one of these, all else unchanged", columns, tuple(rows))
