"""An analysis as people read it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_label, day_of_year
from missions.mission.scenarios import latitude_label
from sizing.balance.assessment import BalanceAssessment
from sizing.balance.drag import DragShares
from sizing.day.replay import CalendarRun
from sizing.relaxed_flight import Relaxation
from studies import quantities as q
from studies.render import sentences as say
from studies.render.tables import ALL, MISSING, Line, Table, facts
from studies.render.words import (
    amount,
    date_and_clock,
    extrapolation_blocks,
    given,
    hours,
    parameter_words,
    percent,
)

if TYPE_CHECKING:
    from sizing.results.analysis import Analysis
    from sizing.results.design_result import PowerBudget
    from sizing.results.sizing_study import SizingStudy


def headline(analysis: Analysis) -> str:
    """Return aircraft, mission, excess time and status in one line."""
    excess = " ".join(q.EXCESS_TIME.fact(analysis.excess_time_h))
    where = analysis.worst_scenario.label
    return (
        f"{analysis.aircraft.name} on {analysis.mission.name} at {where}: {excess}, "
        f"{_status(analysis)}"
    )


def _status(analysis: Analysis) -> str:
    return str(analysis.status).replace("_", " ")


def blocks(analysis: Analysis, level: int) -> list[Any]:
    """Return the answer, facts, what would make it perpetual, and how sure it is."""
    return [block for section in sections(analysis, level).values() for block in section]


def sections(analysis: Analysis, level: int = ALL) -> dict[str, list[Any]]:
    """Return the blocks of an analysis by what they are about, in the order of reading."""
    everything, scenarios = level >= ALL, len(analysis.performance.cycle.status)
    title = (
        f"{analysis.aircraft.name} on {analysis.mission.name}, {analysis.worst_scenario.label}"
        f"{f', worst of {scenarios} scenarios' if scenarios > 1 else ''}: {_status(analysis)}"
    )
    facts = in_columns(_analysis_facts(analysis, level), analysis, level)
    beyond, alone = say.coverage_line(analysis), analysis.relaxations
    relaxations: list[Any] = []  # what alone would make a flight perpetual
    if alone and everything:
        relaxations.append(relaxation_table(alone, "perpetual"))
    elif alone:
        relaxations.append(say.relaxations_line(alone[:2], "perpetual"))
    flight: list[Any] = []
    if analysis.flight is not None:
        table = flight_table(analysis.flight)
        text = ", ".join(" ".join(row) for row in table.rows if row[0] != q.FULL_CHARGE.label)
        flight.append(table if everything else f"{table.title}: {text}")
    return {
        "answer": [Line(title, "strong"), say.answer(analysis), *facts],
        "parts": part_blocks(analysis) if everything else [],
        "scenarios": [scenario_table(analysis)] if everything and scenarios > 1 else [],
        "relaxations": relaxations,
        "flight": flight,
        "warnings": [] if beyond is None else [Line(beyond, "warning")],
        "extrapolations": extrapolation_blocks(analysis.extrapolations, level),
        "sources": sources(analysis, level),
        "error": [
            *([Line(q.BELOW_ZERO, "faint")] if analysis.excess_time_h < 0.0 else []),
            Line(say.uncertainty_line(analysis), "faint"),
        ],
    }


def _endurance(values: Mapping[str, Any]) -> float | str:
    endurance_h, unlimited = values["endurance_h"], values["status"] in ("perpetual", "always_lit")
    return "over a year" if np.isinf(endurance_h) and not unlimited else float(endurance_h)


def _analysis_facts(analysis: Analysis, level: int) -> list[tuple[str, str]]:
    values, design = analysis.scenario(), analysis.design
    shown = values | {q.ENDURANCE.name: _endurance(values)}
    if np.isnan(analysis.sunrise_h) or np.isnan(analysis.best_launch_h):
        del shown[q.BEST_LAUNCH.name]  # without sun every launch is as good
    return [
        *q.facts_of(q.IN_FLIGHT, shown, level),
        *climb_facts(analysis, level),
        *q.facts_of(q.OF_AIRCRAFT, design, level),
        *q.facts_of((q.LOAD, q.SOLAR_ENERGY), values, level),
        *say.wind_rows(analysis.mission),
    ]


def scenario_table(analysis: Analysis, shown: Iterable[int] | None = None) -> Table:
    """Return the metrics of scenarios, a row each: of all, or of those of some indices."""
    every = analysis.scenarios
    rows = (
        scenario.quantities
        | {
            "latitude": latitude_label(scenario.latitude_deg),
            "date": date_label(scenario.day_of_year),
            "endurance_h": _endurance(scenario.quantities),
        }
        for scenario in (every if shown is None else [every[index] for index in shown])
    )
    keys = "latitude date excess_time_h charge_margin_h minimum_state_of_charge endurance_h"
    return q.table_of("all scenarios", keys, rows)


def flight_table(run: CalendarRun) -> Table:
    """Return the replayed flight as a list of facts."""
    first_day = day_of_year(run.launch.date)
    rows = [("launch (local time)", f"{date_label(first_day)} {run.launch.time_local}")]
    for clock in run.full_charge_clock_h:
        rows.append((q.FULL_CHARGE.label, date_and_clock(clock, first_day)))
    rows += [
        q.MINIMUM_CHARGE.fact(run.minimum_state_of_charge),
        ("flight time", hours(run.duration_h)),
        ("state of charge at the end", percent(run.final_state_of_charge)),
    ]
    if run.empty_clock_h is not None:
        rows.append(("battery empty", date_and_clock(run.empty_clock_h, first_day)))
    return facts("flight on the calendar", rows)


# ---- Blocks that other results have as well


_SCREEN, _GAPS = 80, 2 + 5 + 2  # characters of a line, and those between two columns of facts
_NOTHING_W = 1e-9
_PARTS = (("propulsion", "cells"), ("balance", "battery"))  # beside each other


def in_columns(rows: list[tuple[str, str]], analysis: Analysis, level: int) -> list[Any]:
    """Return facts in two columns, long ones below; at level 2 with the budgets beside."""
    if level >= ALL:
        masses_kg, budget = analysis.masses_kg or {}, analysis.power_budget
        masses = [(q.words(item), amount(mass, "kg")) for item, mass in masses_kg.items()]
        title = "power at its own airspeed" if analysis.mission.holds_station else "power budget"
        powers = [(label, amount(watts, "W")) for label, watts in power_rows(budget)]
        total = (title, amount(budget.bus_w, "W"))
        budgets = [*([("mass budget", "")] if masses else []), *masses, total, *powers]
        return [(facts("", rows), facts("", budgets))]
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


def power_rows(budget: PowerBudget) -> tuple[tuple[str, float], ...]:
    """Return the rows of a power budget in words [W], without those of nothing."""
    return tuple((q.words(key), w) for key, w in budget.watts.items() if w > _NOTHING_W)


def climb_facts(analysis: Analysis, level: int) -> list[tuple[str, str]]:
    """Return what climbing does in the worst scenario; nothing without climbs."""
    if analysis.climb is None:
        return []
    # A limited flight is flown from a full battery, and may climb where the repeated day does not.
    day = "" if analysis.performance.cycle.perpetual[analysis.worst] else ", repeated day"
    held, *rows = q.of_part("climb")
    nowhere = replace(held, missing="nowhere")
    return [
        (f"{label}{day}", text) for label, text in q.facts_of((nowhere, *rows), analysis, level)
    ]


def part_tables(result: Any, *parts: str) -> tuple[Table, ...]:
    """Return what is known of the parts of an analysis, a list of facts for each of them."""
    tables = ((part, q.facts_of(q.of_part(part), result)) for part in parts)
    return tuple(facts(part, rows) for part, rows in tables if rows)


def part_blocks(analysis: Analysis, *, cells: bool = True) -> list[Any]:
    """Return wind, structure, drag and balance, the facts of all parts, and what is wrong.

    ``cells``: whether those of the file are the design's.
    """
    shares, balance = analysis.drag_coefficients, analysis.balance
    beyond, placed = analysis.beyond_parts, (analysis.cells or {}).get("solar_cells")
    placed = placed if cells else None
    wind, held = analysis.wind, ""
    if wind is not None and wind.hold_station:
        held = "; airspeed at least that of the wind, to hold its place"
    every = (
        part_tables(analysis, *(part for part in parts if cells or part != "cells"))
        for parts in _PARTS
    )
    return [
        *([] if wind is None else [f"winds from {wind.source}{held}"]),
        *structure_lines(analysis),
        *([] if shares is None else [drag_table(shares)]),
        *([] if balance is None else [balance_table(balance)]),
        *(tables for tables in every if tables),
        *([] if placed is None else [say.cells_line(placed)]),
        *([] if balance is None else say.balance_notes(balance)),
        *([] if beyond is None else [f"beyond the parts: {beyond}"]),
    ]


def sources(result: Analysis | SizingStudy, level: int) -> list[Any]:
    """Return what was left out of the files, and which values catalogues gave."""
    lines = [*result.reading_notes]
    taken = result.aircraft.from_catalogues() if level >= ALL else ()
    by_product: dict[str, list[str]] = {}
    for row in taken:
        by_product.setdefault(row.label, []).append(f"{row.key} {row.text}")
    if taken:
        parts = (f"{', '.join(values)} of {label}" for label, values in by_product.items())
        lines.append(f"From catalogues: {'; '.join(parts)}.")
    return [Line(text, "faint") for text in lines]


def structure_lines(result: Analysis | SizingStudy) -> list[Any]:
    """Return what sizes the structure, and what its criteria do not cover."""
    structure = result.structure
    if structure is None:
        return []
    return [structure.headline(), *(Line(text, "faint") for text in structure.remarks)]


def drag_table(shares: DragShares) -> Table:
    """Return the drag of the parts in level flight, with their shares."""
    columns = q.group("part drag_coefficient share_of_drag")
    parts = {q.words(name): coefficient for name, coefficient in shares._asdict().items()}
    parts |= {"sum": shares.total, "all but wing and trim": shares.parasitic}
    rows = [
        (name, float(coefficient), float(coefficient / shares.total))
        for name, coefficient in parts.items()
        if coefficient != 0.0
    ]
    return Table("drag budget of level flight", columns, tuple(rows))


def balance_table(balance: BalanceAssessment) -> Table:
    """Return the masses with their places."""
    columns = q.group("item mass_kg place_m")
    rows = [(q.words(item.name), item.mass_kg, item.x_m) for item in balance.items]
    rows.append(("centre of gravity", balance.mass_kg, balance.gravity_m))
    return Table("balance, from the leading edge of the wing root", columns, tuple(rows))


def relaxation_table(relaxations: Sequence[Relaxation], title: str = "feasible") -> Table:
    """Return values of single parameters that each suffice alone, smallest change first."""
    parameter, now, needed, key = q.group("parameter now needed key")
    columns = (parameter, now, replace(needed, to_right=True), key)
    rows = [
        (
            parameter_words(row.parameter),
            row.present,
            f"{row.direction} {given(row.value, row.unit)}",
            row.parameter if "." in row.parameter else MISSING,
        )
        for row in relaxations
    ]
    return Table(f"{title} with one of these, all else unchanged", columns, tuple(rows))
