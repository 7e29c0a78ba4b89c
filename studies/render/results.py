"""Results as people read them: blocks of a result at a level, for whatever shows them.

Level 1 is the summary that fits a screen, level 2 has the rest (``-v``, the report); a quantity is
shown from its importance on. :mod:`sizing.results.tables` writes blocks as text, Markdown, HTML and
LaTeX.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_label, day_of_year
from missions.mission import Mission
from missions.mission.scenarios import latitude_label
from sizing.balance.assessment import BalanceAssessment
from sizing.balance.drag import DragShares
from sizing.day.replay import CalendarRun
from sizing.limits import ROW_TOLERANCE
from sizing.parameters import unit_text
from sizing.relaxed_flight import Relaxation
from sizing.results.conditions import CalendarFlight, wind_of
from sizing.results.margins import RequirementMargin
from sizing.validity.ranges import where_error_is_known
from studies import quantities as q
from studies.render import sentences as say
from studies.render.chance import (
    uncertainty_blocks,
    uncertainty_headline,
    weather_blocks,
    weather_headline,
)
from studies.render.notes import extrapolation_blocks
from studies.render.numbers import amount, change_text, date_and_clock, hours, percent, with_unit
from studies.render.tables import MISSING, UNLIMITED, Column, Line, Summary, Table, facts
from studies.render.words import constraint_words, parameter_words
from studies.serialise import serialise

if TYPE_CHECKING:
    from sizing.day.light import SolarModel
    from sizing.performance import Performance
    from sizing.program.objectives import Objective
    from sizing.program.sensitivity import ConstraintMultiplier, Sensitivity
    from sizing.results.analysis import Analysis
    from sizing.results.sizing_study import SizingStudy

SUMMARY, ALL = 1, 2

_FEW = 5  # rows of a table in a summary
_SENSITIVITIES = 15  # of the whole; JSON and CSV have them all


def render(result: Any, level: int = SUMMARY) -> Any:
    """Return the blocks of a result in the order in which they are read."""
    blocks = _BLOCKS.get(type(result).__name__)
    return Summary(tuple(result.blocks(level) if blocks is None else blocks(result, level)))


def headline(result: Any) -> str:
    """Return a result in one line."""
    return str(_HEADLINES[type(result).__name__](result))


_SCREEN, _GAPS = 80, 2 + 5 + 2  # characters of a line, and those between two columns of facts


def _in_columns(
    rows: list[tuple[str, str]], masses_kg: Mapping[str, float] | None, level: int
) -> list[Any]:
    """Facts in two columns, what is too long for them below; or with the mass budget beside."""
    if level >= ALL:
        return [facts("", rows) if masses_kg is None else (facts("", rows), mass_table(masses_kg))]
    lines: list[Any] = []
    while True:
        half = (len(rows) + 1) // 2
        halves = rows[:half], rows[half:]
        widths = (max(map(len, cells)) for some in halves for cells in zip(*some, strict=True))
        if sum(widths) + _GAPS <= _SCREEN:
            return [tuple(facts("", some) for some in halves), *lines]
        longest = max(rows, key=lambda row: len("".join(row)))
        rows = [row for row in rows if row is not longest]
        lines.append(": ".join(longest))


def _facts_of(values: Mapping[q.Quantity, Any], level: int) -> list[tuple[str, str]]:
    """Quantities of a level that have a value."""
    shown = ((one, value) for one, value in values.items() if one.importance <= level)
    return [one.fact(value) for one, value in shown if value is not None]


def _wind_source(mission: Mission) -> Iterable[str]:
    """Where the winds are from, and what flies against them."""
    wind = wind_of(mission)
    if wind is None:
        return ()
    held = "; flown as fast as the wind at least, to hold its place" if wind.hold_station else ""
    return (f"winds from {wind.source}{held}",)


def _sources(result: Analysis | SizingStudy, level: int) -> list[Any]:
    """What was left out of the files, and which values catalogues gave."""
    lines = [*result.reading_notes]
    if level >= ALL and (text := say.catalogue_line(result.aircraft)) is not None:
        lines.append(text)
    return [Line(text, "faint") for text in lines]


def _battery(result: Analysis | SizingStudy) -> list[Any]:
    condition = result.battery_condition
    return [] if condition is None else [say.battery_line(result.aircraft, condition)]


def _structure(result: Analysis | SizingStudy) -> list[Any]:
    """What sizes the structure, and what its criteria do not cover; none where no model says."""
    structure = result.structure
    if structure is None:
        return []
    return [structure.headline(), *(Line(text, "faint") for text in structure.remarks)]


# ---- An analysis


def _analysis_headline(analysis: Analysis) -> str:
    excess = " ".join(q.EXCESS_TIME.fact(analysis.excess_time_h))
    return (
        f"{analysis.aircraft.name} on {analysis.mission.name} at {_where(analysis)}: {excess}, "
        f"{_status(analysis)}"
    )


def _where(analysis: Analysis) -> str:
    return analysis.performance.day.scenarios.label(analysis.worst)


def _status(analysis: Analysis) -> str:
    return str(analysis.status).replace("_", " ")


def _analysis(analysis: Analysis, level: int) -> list[Any]:
    scenarios = len(analysis.performance.cycle.status)
    several = scenarios > 1
    title = (
        f"{analysis.aircraft.name} on {analysis.mission.name}, {_where(analysis)}"
        f"{f', worst of {scenarios} scenarios' if several else ''}: {_status(analysis)}"
    )
    blocks: list[Any] = [Line(title, "strong"), say.answer(analysis)]
    blocks += _in_columns(_analysis_facts(analysis, level), analysis.masses_kg, level)
    if level >= ALL:
        blocks += _analysis_parts(analysis)
        if several:
            blocks.append(scenario_table(analysis))
    if analysis.relaxations and level >= ALL:
        blocks.append(relaxation_table(analysis.relaxations, "perpetual"))
    elif analysis.relaxations:
        blocks.append(say.relaxations_line(analysis.relaxations[:2], "perpetual"))
    if analysis.flight is not None:
        table = flight_table(analysis.flight)
        text = ", ".join(" ".join(row) for row in table.rows if row[0] != q.FULL_CHARGE.label)
        blocks.append(table if level >= ALL else f"{table.title}: {text}")
    if level >= ALL:
        blocks += _battery(analysis)
        blocks += say.cells_lines(analysis.cells or {})
    beyond = say.coverage_line(analysis)
    if beyond is not None:
        blocks.append(Line(beyond, "warning"))
    blocks += [*extrapolation_blocks(analysis.extrapolations, level), *_sources(analysis, level)]
    if analysis.excess_time_h < 0.0:
        blocks.append(Line(q.BELOW_ZERO, "faint"))
    error = say.uncertainty_line(analysis.low, analysis.high, analysis.worst, analysis.mission)
    return [*blocks, Line(error, "faint")]


def _analysis_parts(analysis: Analysis) -> list[Any]:
    """Power, propulsion, structure, drag and balance."""
    budget, masses = analysis.power_budget, analysis.part_masses
    assert budget is not None
    blocks: list[Any] = [say.power_line(budget, analysis.mission), *_wind_source(analysis.mission)]
    if masses is not None:
        blocks.append(say.part_masses_line(masses))
    if analysis.varying_efficiency is not None:
        blocks.append(say.varying_line(analysis.varying_efficiency))
    blocks += _structure(analysis)
    shares, balance = analysis.drag_coefficients, analysis.balance
    if shares is not None:
        share = 100.0 * float(shares.parasitic / shares.total)
        text = (
            f"Parasitic drag, all but the wing and the trim: C_D {float(shares.parasitic):.5f}, "
            f"{share:.1f} % of the drag."
        )
        blocks += [drag_table(shares), text]
    if balance is not None:
        blocks += [balance_table(balance), *say.balance_lines(balance)]
    return blocks


def _endurance(values: Mapping[str, Any]) -> float | str:
    endurance_h, unlimited = values["endurance_h"], values["status"] in ("perpetual", "always_lit")
    return "over a year" if np.isinf(endurance_h) and not unlimited else float(endurance_h)


def _analysis_facts(analysis: Analysis, level: int) -> list[tuple[str, str]]:
    values, design = analysis.scenario(), analysis.design
    shown = {one: values[one.name] for one in q.IN_FLIGHT} | {q.ENDURANCE: _endurance(values)}
    if np.isnan(analysis.sunrise_h) or np.isnan(analysis.best_launch_h):
        del shown[q.BEST_LAUNCH]  # without sun every launch is as good
    of_design = {one: one.of(design) for one in q.OF_AIRCRAFT}
    return [
        *_facts_of(shown, level),
        *_climb_facts(analysis, level),
        *_facts_of(of_design, level),
        *_facts_of({one: values[one.name] for one in (q.LOAD, q.SOLAR_ENERGY)}, level),
        *say.wind_rows(analysis.mission),
    ]


def _climb_facts(analysis: Analysis, level: int) -> list[tuple[str, str]]:
    """What climbing does in the worst scenario; nothing where the mission does not climb."""
    climb = analysis.worst_scenario.climb
    if climb is None:
        return []
    held = climb.held_up_to_m
    # A limited flight is flown from a full battery, and may climb where the repeated day does not.
    day = "" if analysis.performance.cycle.perpetual[analysis.worst] else ", repeated day"
    gain_h = round(climb.gain_in_excess_time_h, 2) + 0.0  # zero added: -0 is no loss
    rows = [
        (f"highest altitude{day}", f"{climb.maximum_altitude_m:.0f} m"),
        ("gained by climbing", f"{gain_h:+.2f} h" if np.isfinite(gain_h) else MISSING),
    ]
    if held is not None:
        rows.insert(0, ("wind held up to", "nowhere" if np.isnan(held) else f"{held:.0f} m"))
    if level >= ALL:
        constant = q.EXCESS_TIME.fact(climb.constant_altitude_excess_time_h)[1]
        rows += [
            (f"gliding in the evening{day}", hours(climb.gliding_h)),
            (f"stored potential energy{day}", amount(climb.stored_height_wh, "Wh")),
            ("excess time at constant altitude", constant),
        ]
        if (checked := analysis.climb_check_h) is not None:
            more_h = (round(one_h - analysis.excess_time_h, 2) + 0.0 for one_h in checked)
            texts = (f"{hours(h)} ({more:+.2f})" for h, more in zip(checked, more_h, strict=True))
            rows.append(("by the program, by the minute", ", ".join(texts)))
    return rows


def mass_table(masses_kg: Mapping[str, float]) -> Table:
    """Mass budget as a list of facts."""
    words = {"mppt": "MPPT"}
    masses = [(words.get(item, item), amount(mass, "kg")) for item, mass in masses_kg.items()]
    return facts("", [("mass budget", ""), *masses])


def scenario_table(analysis: Analysis, shown: Iterable[int] | None = None) -> Table:
    """Metrics of scenarios, a row each: of all, or of those of an index."""
    scenarios = analysis.performance.day.scenarios
    rows = []
    for index in range(len(scenarios)) if shown is None else shown:
        values = analysis.scenario(index)
        place = latitude_label(float(scenarios.latitude_deg[index]))
        day = date_label(int(scenarios.day_of_year[index]))
        rows.append((place, day, *(values[one.name] for one in q.REACHED), _endurance(values)))
    columns = (*q.group("latitude date"), *q.REACHED, q.ENDURANCE)
    return Table("all scenarios", columns, tuple(rows))


def flight_table(run: CalendarRun) -> Table:
    """Replayed flight as a list of facts."""
    flight = CalendarFlight.of(run)
    first_day = day_of_year(run.launch.date)
    rows = [("launch (local time)", f"{date_label(first_day)} {run.launch.time_local}")]
    for clock in flight.full_charge_clock_h:
        rows.append((q.FULL_CHARGE.label, date_and_clock(clock, first_day)))
    rows += [
        q.MINIMUM_CHARGE.fact(flight.minimum_state_of_charge),
        ("flown", hours(flight.duration_h)),
        ("state of charge at the end", percent(flight.final_state_of_charge)),
    ]
    if flight.empty_clock_h is not None:
        rows.append(("battery empty", date_and_clock(flight.empty_clock_h, first_day)))
    return facts("flight on the calendar", rows)


def relaxation_table(relaxations: Sequence[Relaxation], title: str = "feasible") -> Table:
    """Values of single parameters that suffice each for itself, smallest change first."""
    parameter, now, needed, key = q.group("parameter now needed key")
    columns = (parameter, now, replace(needed, to_right=True), key)
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


_DRAG_WORDS = {
    "wing_profile": "wing, profile",
    "wing_induced": "wing, induced",
    "horizontal_tail": "horizontal tail",
    "vertical_tail": "vertical tail",
    "gaps": "gaps, leaks, protuberances",
    "other": "constants of the file",
}
_MASS_WORDS = {"mppt": "MPPT", "spar_caps": "spar caps", "spar_web": "spar web"}


def drag_table(shares: DragShares) -> Table:
    """Drag of the parts of level flight, with their shares."""
    columns = q.group("part drag_coefficient share_of_drag")
    rows = [
        (_DRAG_WORDS.get(name, name), float(one), float(one / shares.total))
        for name, one in (*shares._asdict().items(), ("sum", shares.total))
        if one != 0.0
    ]
    return Table("drag budget of level flight", columns, tuple(rows))


def balance_table(balance: BalanceAssessment) -> Table:
    """Masses with their places."""
    columns = q.group("item mass_kg place_m")
    rows = [(_MASS_WORDS.get(one.name, one.name), one.mass_kg, one.x_m) for one in balance.items]
    rows.append(("centre of gravity", balance.mass_kg, balance.gravity_m))
    return Table("balance, from the leading edge of the wing root", columns, tuple(rows))


# ---- A sizing


def _sizing_headline(study: SizingStudy) -> str:
    objective, value = study.objective, study.result.objective_value
    text = f"{study.aircraft.name} sized for {_sized_for(study)}: {study.status.label}"
    if study.feasible:
        text += f", {objective.label} {with_unit(value, '.4g', objective)}"
    return text


def _sized_for(study: SizingStudy) -> str:
    survival, name = study.survival, study.mission.name
    return name if survival is None else f"{name} in the weather of {survival.weather.site.label}"


def _sizing(study: SizingStudy, level: int) -> list[Any]:
    title = f"{study.aircraft.name} sized for {_sized_for(study)} ({study.objective.value})"
    blocks: list[Any] = [Line(f"{title}: {study.status.label}", "strong")]
    if study.design is None:
        return [*blocks, *_without_design(study, level), *_builds(study, level)]
    if study.coverage is not None and study.coverage.first is not None:
        blocks.append(say.range_text(study.coverage))
    at_bounds = [name for name in study.result.active_constraints if " at its " in name]
    if at_bounds:
        words = "; ".join(str(constraint_words(name, study.aircraft)) for name in at_bounds)
        blocks.append(Line(f"at the end of the design space: {words}", "warning"))
    blocks += _in_columns(_sizing_facts(study, level), study.masses_kg, level)
    blocks += _limits(study, level, at_bounds)
    blocks += _requested(study, level)
    if level >= ALL:
        blocks += [*_sizing_parts(study), requirement_table(study.margins)]
    return [*blocks, *_builds(study, level), *_confidence(study, level)]


def _sizing_facts(study: SizingStudy, level: int) -> list[tuple[str, str]]:
    flown = study.result.simulated
    assert flown is not None
    clear = "clear-sky " if study.survival is not None else ""
    excess, charge = (one.fact(one.of(flown)[flown.worst_scenario()]) for one in q.ENOUGH)
    where = f"{clear}{q.EXCESS_TIME.label}, {flown.day.scenarios.label(flown.worst_scenario())}"
    flight, objective = study.mission.flight, study.objective
    values = {q.TABLE[key]: value for key, value in study.design_values().items()}
    rows = _facts_of(values, level)
    if objective.variable not in (*(one.name for one in values), "worst_excess_time_h"):
        value = with_unit(study.result.objective_value, ".4g", objective)
        rows.insert(0, (objective.label, value))
    if flight is not None:
        launched = f"launched {flight.launch}"
        rows.append(("flight", launched if objective.value == "max_endurance" else flight.text))
    return [*rows, *say.wind_rows(study.mission), (where, excess[1]), charge]


def _limits(study: SizingStudy, level: int, others: Sequence[str] = ()) -> list[Any]:
    """What limits a design; where the excess time is to be as large as possible it is no limit."""
    active = study.result.active_constraints
    if study.objective.value == "max_excess_time" or not study.feasible:
        active = tuple(name for name in active if not name.startswith("excess_time"))
    active = tuple(name for name in active if name not in others)
    return [say.limits_line(active, study.aircraft, keys=level >= ALL)] if active else []


def _requested(study: SizingStudy, level: int) -> list[Any]:
    """What was asked about the optimum besides."""
    blocks: list[Any] = [*say.climb_lines(study), *_whole_cells(study, level)]
    if study.reliability is not None:
        blocks.append(say.reliability_text(study))
    blocks += _survival(study, level)
    if study.sensitivities is not None and level < ALL:
        blocks.append(say.sensitivities_line(study))
    elif study.sensitivities is not None:
        blocks.append(sensitivity_table(study.sensitivities, study.objective))
        if study.multipliers:
            blocks.append(multiplier_table(study.multipliers, study.objective))
    if study.cross_check is not None:
        line = say.cross_check_line(study.cross_check, study.objective)
        passed = study.cross_check.cross_checked and level < ALL
        blocks.append(line.partition(",")[0] if passed else line)
    return blocks


def _sizing_parts(study: SizingStudy) -> list[Any]:
    """Power, propulsion, structure and balance."""
    blocks: list[Any] = []
    if study.power_budget is not None:
        blocks.append(say.power_line(study.power_budget, study.mission))
    blocks += _wind_source(study.mission)
    if study.part_masses is not None:
        blocks.append(say.part_masses_line(study.part_masses))
    blocks += _structure(study)
    return blocks if study.balance is None else [*blocks, *say.balance_lines(study.balance)]


def _whole_cells(study: SizingStudy, level: int) -> list[Any]:
    """Whole cells, what they cost, and the designs that were tried."""
    cells = study.cells
    if study.whole_cells is None or cells is None:
        return []
    lines = [say.loss_line(cells, study.objective), *say.cells_lines(cells)]
    return [*lines, neighbour_table(cells, study.objective)] if level >= ALL else lines


def _survival(study: SizingStudy, level: int) -> list[Any]:
    """Days of the season that close, year by year, beside the design for a clear sky."""
    survival = study.survival
    if survival is None:
        return []
    blocks: list[Any] = [say.survival_text(survival, study)]
    if survival.several_years and level >= ALL:
        years = (year | {"year": str(year["year"])} for year in survival.days.by_year())
        blocks.append(q.table_of("year by year", "year days days_that_close share", years))
    if level >= ALL:
        blocks += [Line(f"record: {text}", "faint") for text in survival.weather.repairs]
    return blocks + [Line(text, "faint") for text in survival.notes]


def _without_design(study: SizingStudy, level: int) -> list[Any]:
    """Requirements that are missed, what holds the design back, and what would help."""
    missed = study.result.violations
    shown = missed if level >= ALL else missed[:3]
    blocks: list[Any] = [f"  {one.text}" for one in shown]
    if len(missed) > len(shown):
        blocks.append(f"  and {len(missed) - len(shown)} more")
    blocks += _limits(study, level)
    blocks += [*say.nearest_lines(study), *(f"{a}: {b}" for a, b in say.wind_rows(study.mission))]
    if level >= ALL:
        blocks += _structure(study)
    blocks += extrapolation_blocks(study.extrapolations, level)
    if study.reliability is not None:
        return [*blocks, say.reliability_text(study)]
    blocks += _survival(study, level)
    if study.whole_cells is not None:
        return [*blocks, *_whole_cells(study, level)]
    if study.status.name != "infeasible" or study.coverage is not None:
        return blocks
    if not study.relaxations:
        return [*blocks, say.NONE_ALONE.format(study.objective.value)]
    few = study.relaxations if level >= ALL else study.relaxations[:_FEW]
    return [*blocks, relaxation_table(few)]


def _builds(study: SizingStudy, level: int) -> list[Any]:
    """The same requirement by each quality of building; nothing where it was not asked for."""
    if not study.builds:
        return []
    table = build_table(serialise(study.builds), study.objective)
    return [table if level >= ALL else replace(table, title="")]


def _confidence(study: SizingStudy, level: int) -> list[Any]:
    """How far the answer may be trusted: ranges of the models, their error, margins."""
    flown, low, high = study.result.simulated, study.low, study.high
    blocks: list[Any] = _battery(study) if level >= ALL else []
    blocks += [*extrapolation_blocks(study.extrapolations, level), *_sources(study, level)]
    if flown is not None and low is not None and high is not None:
        error = say.uncertainty_line(low, high, flown.worst_scenario(), study.mission)
        blocks.append(Line(error, "faint"))
        required = max(study.result.required_excess_time_h, 0.0)
        guarded = study.mission.uncertainty_margins.given or study.reliability is not None
        guarded = guarded or study.survival is not None
        if study.with_margin is not None:
            blocks += _margin_blocks(study, study.with_margin, level)
        elif (low_h := _least_h(low)) < required and not guarded:
            what = (
                "ends perpetual flight" if low_h <= 0.0 else f"misses the required {required:g} h"
            )
            measured = where_error_is_known(study.mission.altitude_m)
            text = f"on the edge: one RMS error{measured} less solar power {what}; {_TO_GUARD}"
            blocks.append(Line(text, "warning"))
    if study.without_margins is not None:
        reached = hours(_least_h(study.without_margins))
        blocks.append(f"without the mission's uncertainty margins the excess time is {reached}")
    return blocks


_TO_GUARD = "to size with that margin: --set mission.uncertainty_margins.solar_model_sigmas=1"


def _margin_blocks(study: SizingStudy, guarded: SizingStudy, level: int) -> list[Any]:
    """The optimum beside the one with a margin, and what the margin costs."""
    if study.simulated is None or guarded.as_assumed is None:
        return [Line(f"{_with_error(study.solar)} no design was found", "warning")]
    was, now = study.to_dict(), serialise(guarded, "Guarded")
    table = margin_table(study.objective, study.solar, was, now)
    if level >= ALL:
        return [table, Line(_TO_GUARD, "faint")]
    shown = [row for row in table.rows if row[0] in (q.WINGSPAN.label, q.TOTAL_MASS.label)]
    designs = ", ".join(f"{label} {value} ({change})" for label, _, value, change in shown)
    return [Line(f"{table.title}: {designs}; {_TO_GUARD.split(': ')[1]}", "faint")]


def _with_error(solar: SolarModel) -> str:
    return f"with one RMS error ({percent(solar.rms_relative, '.0f')}) less solar power as margin"


def _least_h(perf: Performance) -> float:
    return float(np.min(perf.cycle.excess_time_h))


def margin_table(
    objective: Objective, solar: SolarModel, sizing: Mapping[str, Any], guarded: Mapping[str, Any]
) -> Table:
    """An optimum beside the one with a margin of one RMS error, by their records."""
    was = dict(sizing) | {
        objective.variable: sizing["objective"]["value"],
        q.EXCESS_TIME.name: sizing["simulated"][q.EXCESS_TIME.name],
        "least_excess_time_h": sizing["uncertainty"]["excess_time_low_h"],
    }
    now = dict(guarded) | {objective.variable: guarded["objective_value"]}
    shown = (*q.CHOSEN, q.TOTAL_MASS)
    rows: list[tuple[str, ...]] = [
        (
            one.label,
            *(one.fact(e[one.name])[1] for e in (was, now)),
            change_text(was[one.name], now[one.name]),
        )
        for one in shown
    ]
    name = objective.variable
    if objective.label not in (q.EXCESS_TIME.label, *(one.label for one in shown)):
        texts = (with_unit(one[name], ".4g", objective) for one in (was, now))
        rows.insert(0, (objective.label, *texts, change_text(was[name], now[name])))
    for key, what in ((q.EXCESS_TIME.name, ""), ("least_excess_time_h", ", that error less")):
        ends = (np.inf if one[key] is None else one[key] for one in (was, now))
        rows.append((f"{q.EXCESS_TIME.label}{what}", *map(hours, ends), ""))
    columns = (
        Column("quantity", ""),
        Column("optimum", "as requested", to_right=True),
        Column("guarded", "with margin", to_right=True),
        Column("change", to_right=True),
    )
    return Table(_with_error(solar), columns, tuple(rows))


def requirement_table(margins: Iterable[RequirementMargin]) -> Table:
    """Margins as a table."""
    columns = q.group("requirement value limit margin")
    rows = tuple(
        (
            f"{one.label}{' (recommended)' if one.recommended else ''}",
            _margin_value_text(one),
            f"{one.limit:.5g} {one.unit}".strip(),
            _margin_text(one)
            if one.recommended or one.margin >= -ROW_TOLERANCE
            else f"{_margin_text(one)}, violated",
        )
        for one in margins
    )
    return Table("margins of the requirements", columns, rows)


def _margin_value_text(row: RequirementMargin) -> str:
    """Return the value of a requirement with its unit."""
    if not np.isfinite(row.value):
        return UNLIMITED if row.value > 0.0 else "none"
    return f"{round(row.value, 3):.4g} {row.unit}".strip()


def _margin_text(row: RequirementMargin) -> str:
    """Return the margin of a requirement, in per cent of its limit or in its unit."""
    if not np.isfinite(row.margin):
        return UNLIMITED if row.margin > 0.0 else "none"
    if row.relative:
        return f"{100.0 * row.margin:+.1f} %"
    return f"{row.margin:+.2f} {row.unit}".strip()


def build_table(records: Sequence[Mapping[str, Any]], objective: Objective) -> Table:
    """A row for every quality of building, of its record."""
    shown = (q.WINGSPAN, q.TOTAL_MASS, q.BATTERY_MASS, q.MODULE_AREA)
    others = objective.variable not in {one.name for one in shown}
    of_design = (replace(one, to_right=True) for one in shown)
    columns: list[Column] = [*q.group("build factor"), *of_design]
    if others:
        columns.append(Column("objective", objective.label, to_right=True))
    rows = []
    for one in records:
        name = f"{one['build']} (this file)" if one["of_file"] else one["build"]
        row: list[Any] = [name, one["factor"], *(one[column.name] for column in shown)]
        if others:
            row.append(with_unit(one["objective_value"], ".4g", objective))
        if one[q.WINGSPAN.name] is None:
            row[2:] = ["no design", *("" for _ in row[3:])]
        rows.append(tuple(row))
    title = "the same by how well the structure is built (airframe.structure.build)"
    return Table(title, tuple(columns), tuple(rows))


def sensitivity_table(
    sensitivities: Sequence[Sensitivity], objective: Objective, most: int = _SENSITIVITIES
) -> Table:
    """What each technology parameter changes, most important first."""
    parameter, value, elasticity = q.group("parameter value elasticity")
    per_percent = Column("per_percent", f"{objective.unit} per +1 %", form="+.4f")
    columns = (parameter, replace(value, to_right=True), per_percent, elasticity)
    rows = [
        (
            parameter_words(one.parameter),
            f"{one.value:.4g} {unit_text(one.unit)}".rstrip(),
            one.per_percent,
            one.elasticity,
        )
        for one in sensitivities[:most]
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


def multiplier_table(multipliers: Sequence[ConstraintMultiplier], objective: Objective) -> Table:
    """What relaxing each constraint gains, by its multiplier, next to nothing left out."""
    constraint, gain, step = q.group("constraint gain step")
    columns = (constraint, replace(gain, label=f"gain in {objective.unit}"), step)
    least = _LEAST_GAIN * max((abs(one.gain) for one in multipliers), default=0.0)
    rows = [
        (constraint_words(one.constraint).without_key, one.gain, one.step)
        for one in multipliers
        if abs(one.gain) >= least
    ]
    return Table("what relaxing a constraint gains", columns, tuple(rows))


_DESIGNS = 10  # in the table; JSON has all


def neighbour_table(record: Mapping[str, Any], objective: Objective) -> Table:
    """Designs of whole cells that were tried, the best first, infeasible ones with the reason."""
    tried = record["tried"]
    feasible = [one for one in tried if not one["reason"]]
    infeasible = [one for one in tried if one["reason"]]
    room = max(_DESIGNS - len(infeasible), _DESIGNS // 2)
    shown = [*feasible[:room], *infeasible[: _DESIGNS - min(room, len(feasible))]]
    strung = any(one["strings"] is not None for one in tried)
    columns: list[Column] = [
        *q.group(f"cells {'strings' * strung} battery_cells"),
        Column("value", objective.label, objective.unit, ".4g"),
        *([] if objective.value == "min_mass" else [replace(q.TOTAL_MASS, form=".4g")]),
        replace(q.TABLE["reason"], label="why not", missing=""),
    ]
    unlimited = {"value": UNLIMITED}
    rows = (one | unlimited if one["value"] is None and not one["reason"] else one for one in shown)
    left = len(tried) - len(shown)
    notes = (f"{left} more were tried; the record of the sizing has all",) if left else ()
    return q.table_of("designs of whole cells", columns, rows, notes)


_BLOCKS: dict[str, Any] = {
    "Analysis": _analysis,
    "SizingStudy": _sizing,
    "UncertaintyAnalysis": uncertainty_blocks,
    "WeatherAnalysis": weather_blocks,
}
_HEADLINES: dict[str, Any] = {
    "Analysis": _analysis_headline,
    "SizingStudy": _sizing_headline,
    "UncertaintyAnalysis": uncertainty_headline,
    "WeatherAnalysis": weather_headline,
}
