"""Tables of a sizing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from sizing.limits import ROW_TOLERANCE
from sizing.results.margins import RequirementMargin
from studies import quantities as q
from studies.render.numbers import amount, percent, with_unit
from studies.render.tables import UNLIMITED, Column, Table
from studies.render.words import constraint_words, parameter_words

if TYPE_CHECKING:
    from sizing.program.objectives import Objective


_SENSITIVITIES = 15  # of the whole; JSON and CSV have them all


def requirement_table(margins: Iterable[RequirementMargin]) -> Table:
    """Return the margins as a table."""
    columns = q.group("requirement value limit margin")
    rows = []
    for row in margins:
        margin = amount(row.margin, row.unit, "+.2f")
        if row.relative and np.isfinite(row.margin):
            margin = percent(row.margin, "+.1f")
        missed = not row.recommended and row.margin < -ROW_TOLERANCE
        rows.append(
            (
                f"{row.label}{' (recommended)' if row.recommended else ''}",
                amount(round(row.value, 3), row.unit, ".4g"),
                amount(row.limit, row.unit, ".5g"),
                f"{margin}, violated" if missed else margin,
            )
        )
    return Table("margins of the requirements", columns, tuple(rows))


def build_table(records: Sequence[Mapping[str, Any]], objective: Objective) -> Table:
    """Return a row for every build quality, of its record."""
    shown = (q.WINGSPAN, q.TOTAL_MASS, q.BATTERY_MASS, q.MODULE_AREA)
    others = objective.variable not in {quantity.name for quantity in shown}
    of_design = (replace(quantity, to_right=True) for quantity in shown)
    columns: list[Column] = [*q.group("build factor"), *of_design]
    if others:
        columns.append(Column("objective", objective.label, to_right=True))
    rows = []
    for record in records:
        name = f"{record['build']} (this file)" if record["of_file"] else record["build"]
        row: list[Any] = [name, record["factor"], *(record[column.name] for column in shown)]
        if others:
            row.append(with_unit(record["objective_value"], ".4g", objective))
        if record[q.WINGSPAN.name] is None:
            row[2:] = ["no design", *("" for _ in row[3:])]
        rows.append(tuple(row))
    title = "the same by how well the structure is built (airframe.structure.build)"
    return Table(title, tuple(columns), tuple(rows))


def sensitivity_table(sensitivities: Sequence[Mapping[str, Any]], objective: Objective) -> Table:
    """Return what each technology parameter changes, most important first, of their records."""
    parameter, value, elasticity = q.group("parameter value elasticity")
    per_percent = Column("per_percent", f"{objective.unit} per +1 %", form="+.4f")
    columns = (parameter, replace(value, to_right=True), per_percent, elasticity)
    rows = [
        (
            parameter_words(row["parameter"]),
            amount(row["value"], row["unit"], ".4g"),
            row["per_percent"],
            row["elasticity"],
        )
        for row in sensitivities[:_SENSITIVITIES]
    ]
    if rows:
        left = len(sensitivities) - len(rows)
        more = f"{left} more parameters matter less; the record of the sizing has all"
        notes = (more,) if left > 0 else ()
    else:
        notes = (f"none: {objective.label} is unlimited",)
    title = f"sensitivities of the {objective.label} ({objective.value})"
    return Table(title, columns, tuple(rows), notes)


# Of the largest gain: a constraint that gains less is left out.
_LEAST_GAIN = 1e-3


def multiplier_table(multipliers: Sequence[Mapping[str, Any]], objective: Objective) -> Table:
    """Return what relaxing each constraint gains, without those that gain next to nothing."""
    constraint, gain, step = q.group("constraint gain step")
    columns = (constraint, replace(gain, label=f"gain in {objective.unit}"), step)
    multipliers = [row for row in multipliers if row["gain"] is not None]
    least = _LEAST_GAIN * max((abs(row["gain"]) for row in multipliers), default=0.0)
    rows = [
        (constraint_words(row["constraint"]).without_key, row["gain"], row["step"])
        for row in multipliers
        if abs(row["gain"]) >= least
    ]
    return Table("what relaxing a constraint gains", columns, tuple(rows))


_DESIGNS = 10  # in the table; JSON has all


def neighbour_table(record: Mapping[str, Any], objective: Objective) -> Table:
    """Return the designs of whole cells that were tried, best first, with why some fail."""
    tried = record["tried"]
    feasible = [design for design in tried if not design["reason"]]
    infeasible = [design for design in tried if design["reason"]]
    room = max(_DESIGNS - len(infeasible), _DESIGNS // 2)
    shown = [*feasible[:room], *infeasible[: _DESIGNS - min(room, len(feasible))]]
    strung = any(design["strings"] is not None for design in tried)
    columns: list[Column] = [
        *q.group(f"cells {'strings' * strung} battery_cells"),
        Column("value", objective.label, objective.unit, ".4g"),
        *([] if objective.value == "min_mass" else [replace(q.TOTAL_MASS, form=".4g")]),
        replace(q.TABLE["reason"], label="why not", missing=""),
    ]
    unlimited = {"value": UNLIMITED}
    rows = (
        design | unlimited if design["value"] is None and not design["reason"] else design
        for design in shown
    )
    left = len(tried) - len(shown)
    notes = (f"{left} more were tried; the record of the sizing has all",) if left else ()
    return q.table_of("designs of whole cells", columns, rows, notes)
