"""An analysis as people read it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_label, day_of_year
from missions.mission.scenarios import latitude_label
from sizing.day.replay import CalendarRun
from studies import quantities as q
from studies.render import sentences as say
from studies.render.notes import extrapolation_blocks
from studies.render.numbers import date_and_clock, hours, percent
from studies.render.parts import (
    climb_facts,
    in_columns,
    part_blocks,
    relaxation_table,
    sources,
)
from studies.render.tables import ALL, Line, Table, facts

if TYPE_CHECKING:
    from sizing.results.analysis import Analysis


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
    scenarios = analysis.performance.day.scenarios
    rows = []
    for index in range(len(scenarios)) if shown is None else shown:
        values = analysis.scenario(index)
        place = latitude_label(float(scenarios.latitude_deg[index]))
        day = date_label(int(scenarios.day_of_year[index]))
        rows.append(
            (place, day, *(values[quantity.name] for quantity in q.REACHED), _endurance(values))
        )
    columns = (*q.group("latitude date"), *q.REACHED, q.ENDURANCE)
    return Table("all scenarios", columns, tuple(rows))


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
