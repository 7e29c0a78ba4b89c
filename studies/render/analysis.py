"""An analysis as people read it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_label, day_of_year
from missions.mission.scenarios import latitude_label
from sizing.aircraft import MeasuredAirframe
from sizing.balance.assessment import BalanceAssessment
from sizing.balance.drag import DragShares
from sizing.day.replay import CalendarRun
from sizing.layout.cells import rows_text
from sizing.limits import ROW_TOLERANCE
from sizing.relaxed_flight import Relaxation
from sizing.validity.ranges import model_error_note
from solar.sun import solar_time_h
from studies import quantities as q
from studies.render.tables import ALL, UNLIMITED, Line, Table, clock_label, facts
from studies.render.words import (
    amount,
    clock_of_day,
    date_and_clock,
    extrapolation_blocks,
    given,
    hours,
    parameter_words,
    percent,
)

if TYPE_CHECKING:
    from sizing.results.analysis import Analysis
    from sizing.results.design_result import PowerBudget, Wind
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
    everything, scenarios = level >= ALL, len(analysis.scenarios)
    title = (
        f"{analysis.aircraft.name} on {analysis.mission.name}, {analysis.worst_scenario.label}"
        f"{f', worst of {scenarios} scenarios' if scenarios > 1 else ''}: {_status(analysis)}"
    )
    facts = in_columns(_analysis_facts(analysis, level), analysis, level)
    alone, flight = analysis.relaxations, []
    if analysis.flight is not None:
        table = flight_table(analysis.flight)
        text = ", ".join(" ".join(row) for row in table.rows if row[0] != q.FULL_CHARGE.label)
        flight = [table if everything else f"{table.title}: {text}"]
    changes = (f"{parameter_words(row.parameter)} {_needed(row)}" for row in alone[:2])
    relaxations: Any = f"perpetual with one change: {', or '.join(changes)}"
    if everything:
        relaxations = relaxation_table(alone, "perpetual")
    return {
        "answer": [Line(title, "strong"), answer(analysis), *facts],
        "parts": [*part_blocks(analysis)] if everything else [],
        "scenarios": [scenario_table(analysis)] if everything and scenarios > 1 else [],
        "relaxations": [relaxations] if alone else [],
        "flight": flight,
        "warnings": coverage_lines(analysis),
        "extrapolations": extrapolation_blocks(analysis.extrapolations, level),
        "sources": sources(analysis, level),
        "error": [
            *([Line(q.BELOW_ZERO, "faint")] if analysis.excess_time_h < 0.0 else []),
            Line(uncertainty_line(analysis), "faint"),
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
        *wind_rows(analysis.wind),
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


def answer(analysis: Analysis) -> str:
    """Return how long the aircraft flies, in a sentence or two; solar time, and UTC if known."""
    if analysis.mission.flight is not None:
        return landing(analysis)
    flight, status = analysis.limited_flight, analysis.status
    if flight is None:
        if status == "always_lit":
            return "It flies perpetually: solar power exceeds the load at all times."
        if analysis.is_perpetual:
            return f"It flies perpetually, with an excess time of {hours(analysis.excess_time_h)}."
        return "It flies for over a year, but its days do not repeat themselves."
    first_day = int(analysis.performance.day.scenarios.day_of_year[analysis.worst])
    empty = flight.empty_h
    clock = f"{clock_of_day(empty)} (solar time{_utc(analysis, first_day, empty)})"
    text = (
        f"It flies {hours(flight.endurance_h)} at best: launched with a full battery at "
        f"{clock_label(flight.launch_h)} it flies until {clock}"
    )
    if np.isfinite(flight.before_sun_h):
        text += f", {hours(flight.before_sun_h)} before the sun carries the load"
    if not np.isfinite(flight.from_sunrise_h):
        return f"{text}."
    return (
        f"{text}. Launched at sunrise it flies {hours(flight.from_sunrise_h)}, at noon "
        f"{hours(flight.from_noon_h)}."
    )


def landing(analysis: Analysis) -> str:
    """Return when the flight of the worst scenario begins and ends, and what is left then."""
    window_h = analysis.mission.flight_window_h(analysis.performance.day.scenarios)
    assert window_h is not None
    launch_h, land_h = (float(ends[analysis.worst]) for ends in window_h)
    when = f"from {clock_label(launch_h)} to {clock_of_day(land_h)} (solar time)"
    excess_h = analysis.excess_time_h
    if excess_h > 0.0:
        return f"It flies {when} and lands with an excess time of {hours(excess_h)}."
    return f"Of a flight {when} it lacks power for {hours(-excess_h)}."


def _utc(analysis: Analysis, day: int, solar_h: float) -> str:
    """Return the same instant in UTC, where the mission has a longitude."""
    if (longitude := analysis.mission.longitude_deg) is None:
        return ""
    ahead_h = float(solar_time_h(0.0, day, longitude))
    return f"; {clock_label((solar_h - ahead_h) % 24.0)} UTC"


def coverage_lines(analysis: Analysis) -> list[Line]:
    """Return a note on modules that cover more of the wing than the file allows, if they do."""
    airframe, design = analysis.aircraft.airframe, analysis.design
    if isinstance(airframe, MeasuredAirframe):
        return []
    covered = float(design.variables.module_area_m2 / design.wing_area_m2)
    most, cover = airframe.maximum_module_coverage, percent(covered, ".0f")
    if covered <= most * (1.0 + ROW_TOLERANCE):
        return []
    text = f"The modules cover {cover} of the wing, more than the {percent(most, 'g')} of"
    return [Line(f"{text} airframe.maximum_module_coverage.", "warning")]


# ---- Blocks that other results have as well


_SCREEN, _GAPS = 80, 2 + 5 + 2  # characters of a line, and those between two columns of facts
_NOTHING_W = 1e-9


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


def part_blocks(analysis: Analysis, *, cells: bool = True) -> Iterator[Any]:
    """Yield wind, structure, drag and balance, the facts of all parts, and what is wrong.

    ``cells``: whether those of the file are the design's.
    """
    wind, shares, balance = analysis.wind, analysis.drag_coefficients, analysis.balance
    if wind is not None:
        held = "; airspeed at least that of the wind, to hold its place" * wind.hold_station
        yield f"winds from {wind.source}{held}"
    yield from structure_lines(analysis)
    if shares is not None:
        yield drag_table(shares)
    if balance is not None:
        yield balance_table(balance)
    for parts in (("propulsion", "cells"), ("balance", "battery")):  # beside each other
        known = (part for part in parts if cells or part != "cells")
        yield from filter(None, [part_tables(analysis, *known)])
    if cells and (placed := (analysis.cells or {}).get("solar_cells")) is not None:
        yield cells_line(placed)
    yield from [] if balance is None else balance_notes(balance)
    if analysis.beyond_parts is not None:
        yield f"beyond the parts: {analysis.beyond_parts}"


def sources(result: Analysis | SizingStudy, level: int) -> list[Any]:
    """Return what was left out of the files, and which values catalogues gave."""
    lines, by_product = [*result.reading_notes], defaultdict(list)
    for row in result.aircraft.from_catalogues() if level >= ALL else ():
        by_product[row.label].append(f"{row.key} {row.text}")
    if by_product:
        parts = (f"{', '.join(values)} of {label}" for label, values in by_product.items())
        lines.append(f"From catalogues: {'; '.join(parts)}.")
    return [Line(text, "faint") for text in lines]


def structure_lines(result: Analysis | SizingStudy) -> list[Any]:
    """Return what sizes the structure, and what its criteria do not cover."""
    if (structure := result.structure) is None:
        return []
    return [structure.headline(), *(Line(text, "faint") for text in structure.remarks)]


def drag_table(shares: DragShares) -> Table:
    """Return the drag of the parts in level flight, with their shares."""
    parts = {q.words(name): coefficient for name, coefficient in shares._asdict().items()}
    parts |= {"sum": shares.total, "all but wing and trim": shares.parasitic}
    rows = tuple(
        (name, float(coefficient), float(coefficient / shares.total))
        for name, coefficient in parts.items()
        if coefficient != 0.0
    )
    columns = q.group("part drag_coefficient share_of_drag")
    return Table("drag budget of level flight", columns, rows)


def balance_table(balance: BalanceAssessment) -> Table:
    """Return the masses with their places."""
    rows = [(q.words(item.name), item.mass_kg, item.x_m) for item in balance.items]
    rows.append(("centre of gravity", balance.mass_kg, balance.gravity_m))
    title, columns = "balance, from the leading edge of the wing root", "item mass_kg place_m"
    return Table(title, q.group(columns), tuple(rows))


def relaxation_table(relaxations: Sequence[Relaxation], title: str = "feasible") -> Table:
    """Return values of single parameters that each suffice alone, smallest change first."""
    parameter, now, needed, key = q.group("parameter now needed key")
    columns = (parameter, now, replace(needed, to_right=True), key)
    rows = tuple(
        (parameter_words(row.parameter), row.present, _needed(row),
         row.parameter if "." in row.parameter else None)
        for row in relaxations
    )  # fmt: skip
    return Table(f"{title} with one of these, all else unchanged", columns, rows)


def _needed(row: Relaxation) -> str:
    """Return the value of a parameter that suffices."""
    return f"{row.direction} {given(row.value, row.unit)}"


def uncertainty_line(analysis: Analysis) -> str:
    """Return what the RMS error of the solar power model means for the least excess time.

    Where the worst scenario is another one with less sun, that one is named. The mission's
    uncertainty margins are taken off before that error.
    """
    low, mission = analysis.low, analysis.mission
    solar, where = low.solar, model_error_note(mission.altitude_m)
    least, most = (hours(end.least_excess_time_h) for end in (low, analysis.high))
    # Less sun may turn a scenario with a short day into the worst one.
    at = "" if low.worst_scenario() == analysis.worst else f" ({low.worst_label})"
    leaves, puts = ("would leave", "would put") if where else ("leaves", "puts")
    means = f"{puts} the excess time between {least}{at} and {most}"
    if least == most:
        means = f"{leaves} the excess time {least if least == UNLIMITED else f'at {least}'}"
    with_margins = mission.uncertainty_margins.is_set
    beyond = ", on top of the mission's uncertainty margins," if with_margins else ""
    error = "the model's RMS error" if solar.correction == "none" else "the RMS error left after it"
    relative = f"{percent(solar.rms_relative, '.0f')} of the mean power"
    if where:
        unknown = f"its error at {given(mission.altitude_m, 'm')} is not known"
        return f"{solar.label}; {unknown}. One of {relative},{where},{beyond[1:]} {means}."
    return f"{solar.label}; {error} of {relative}{beyond} {means}."


def wind_rows(wind: Wind | None) -> list[tuple[str, str]]:
    """Return the wind as facts, from the weakest to the strongest scenario."""
    if wind is None:
        return []
    ends = dict.fromkeys(amount(speed, form=".1f") for speed in wind.ends_m_per_s)
    everywhere = ", at all heights" if wind.heights > 1 else ""
    words = f"wind, {given(wind.percentile)} % of the time at most{everywhere}"
    return [(words, f"{' to '.join(ends)} m/s")]


_CLOSE = 0.01  # what a weighed list and the mass budget may differ by without a note


def balance_notes(balance: BalanceAssessment) -> list[str]:
    """Return that a balance is unstable, and how far weighed masses are off the mass budget."""
    notes = [] if balance.static_margin > 0.0 else ["unstable: the static margin is negative"]
    if balance.required_margin is not None and balance.volume_for_margin is None:
        notes.append("no horizontal tail has the required static margin")
    off = balance.mass_kg / balance.design_mass_kg - 1.0
    if abs(off) > _CLOSE:
        notes.append(
            f"The weighed masses add up to {amount(balance.mass_kg, 'kg')}, "
            f"{percent(off, '+.1f')} off the mass budget of {amount(balance.design_mass_kg, 'kg')}."
        )
    return notes


def cells_line(solar_cells: Mapping[str, Any]) -> str:
    """Return where whole solar cells lie, from their record."""
    rows = ", then ".join(rows_text(bay) for bay in solar_cells["rows_of_each_half"])
    tail = solar_cells["tail_rows"]
    on_tail = f", the tail {rows_text(tail)}" if tail else ""
    return f"solar cells: {solar_cells['count']}, each half of the wing {rows}{on_tail}"
