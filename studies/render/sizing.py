"""A sizing as people read it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_label
from missions.mission.scenarios import latitude_label
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.limits import ROW_TOLERANCE
from sizing.results.design_result import RequirementMargin
from sizing.validity.ranges import model_error_note
from studies import quantities as q
from studies.render.analysis import (
    cells_line,
    climb_facts,
    in_columns,
    part_blocks,
    relaxation_table,
    sources,
    structure_lines,
    uncertainty_line,
    wind_rows,
)
from studies.render.tables import ALL, UNLIMITED, Column, Line, Table
from studies.render.words import (
    amount,
    change_text,
    constraint_words,
    extrapolation_blocks,
    given,
    hours,
    objective_text,
    parameter_words,
    percent,
    required,
    with_unit,
)
from studies.serialise import serialise

if TYPE_CHECKING:
    from sizing.design import Design
    from sizing.program.objectives import Objective
    from sizing.program.ranges import WidestRange
    from sizing.results.analysis import Analysis
    from sizing.results.sizing_study import SizingStudy, Survival


_FEW, _MOST_VIOLATIONS = 5, 3  # of a summary


def headline(study: SizingStudy) -> str:
    """Return aircraft, mission, status and objective in one line."""
    text = f"{study.aircraft.name} sized for {_sized_for(study)}: {study.status.label}"
    if study.feasible:
        text += f", {objective_text(study.objective, study.result.objective_value)}"
    return text


def _sized_for(study: SizingStudy) -> str:
    survival, name = study.survival, study.mission.name
    return name if survival is None else f"{name} in the weather of {survival.weather.site.label}"


def blocks(study: SizingStudy, level: int) -> Iterator[Any]:
    """Yield the design, what limits it, what was requested besides, and how sure it is."""
    title = f"{study.aircraft.name} sized for {_sized_for(study)} ({study.objective.value})"
    yield Line(f"{title}: {study.status.label}", "strong")
    if study.optimum is None:
        yield from _without_design(study, level)
        yield from _builds(study, level)
        return
    if study.coverage is not None and study.coverage.first is not None:
        yield _range_text(study.coverage)
    at_bounds = [name for name in study.result.active_constraints if " at its " in name]
    if at_bounds:
        words = "; ".join(str(constraint_words(name, study.aircraft)) for name in at_bounds)
        yield Line(f"at the end of the design space: {words}", "warning")
    yield from in_columns(_sizing_facts(study, study.optimum, level), study.optimum, level)
    yield from _limits(study, level, at_bounds)
    yield from without_climbs(study)
    yield from _whole_cells(study, level)
    yield from _reliability(study)
    yield from _survival(study, level)
    if study.sensitivities is not None and level < ALL:
        yield sensitivities_line(study)
    if study.cross_check is not None:
        line = cross_check_line(vars(study.cross_check), study.objective)
        passed = study.cross_check.cross_checked and level < ALL
        yield line.partition(",")[0] if passed else line
    if level >= ALL:
        yield from record_blocks(study.to_dict(), study.objective)
        yield from part_blocks(study.optimum, cells=study.whole_cells is not None)
        yield requirement_table(study.margins)
    yield from _builds(study, level)
    yield from _confidence(study, level)


def _sizing_facts(study: SizingStudy, optimum: Analysis, level: int) -> list[tuple[str, str]]:
    flight, objective = study.mission.flight, study.objective
    rows = q.facts_of(q.SIZED, study.values, level)
    if objective.variable not in (*(each.name for each in q.SIZED), "worst_excess_time_h"):
        value = with_unit(study.result.objective_value, objective)
        rows.insert(0, (objective.label, value))
    if flight is not None:
        launched = f"launched {flight.launch}"
        rows.append(("flight", launched if objective.value == "max_endurance" else flight.text))
    clear = "clear-sky " if study.survival is not None else ""
    label, excess = q.EXCESS_TIME.fact(optimum.excess_time_h)
    charge = q.MINIMUM_CHARGE.fact(optimum.minimum_state_of_charge)
    where = f"{clear}{label}, {optimum.worst_scenario.label}"
    return [*rows, *wind_rows(study.wind), (where, excess), charge, *climb_facts(optimum, level)]


def _limits(study: SizingStudy, level: int, others: Sequence[str] = ()) -> Iterator[str]:
    """Yield what limits a design; the excess time is no limit where it is the objective."""
    active = [name for name in study.result.active_constraints if name not in others]
    if study.objective.value == "max_excess_time" or not study.feasible:
        active = [name for name in active if not name.startswith("excess_time")]
    if active:
        yield limits_line(active, study.aircraft, keys=level >= ALL)


def _whole_cells(study: SizingStudy, level: int) -> Iterator[str]:
    """Yield what whole cells cost, and where they lie, which level 2 has with the parts."""
    if study.whole_cells is None:
        return
    yield loss_line(serialise(study.whole_cells), study.objective)
    if level < ALL and (placed := (study.cells or {}).get("solar_cells")) is not None:
        yield cells_line(placed)


def _survival(study: SizingStudy, level: int) -> Iterator[Any]:
    """Yield the season's days that close, year by year, beside the design for a clear sky."""
    if (survival := study.survival) is None:
        return
    yield survival_text(survival, study)
    if level >= ALL:
        if survival.by_year:
            years = (year | {"year": str(year["year"])} for year in survival.by_year)
            yield q.table_of("year by year", "year days days_that_close share", years)
        yield from (Line(f"record: {text}", "faint") for text in survival.weather.repairs)
    yield from (Line(text, "faint") for text in survival.notes)


def _without_design(study: SizingStudy, level: int) -> Iterator[Any]:
    """Yield the violated requirements, what limits the nearest design, and what would help."""
    violations, cells, everything = study.result.violations, study.whole_cells, level >= ALL
    most = len(violations) if everything else _MOST_VIOLATIONS
    yield from (f"  {violation.text}" for violation in violations[:most])
    if len(violations) > most:
        yield f"  and {len(violations) - most} more"
    yield from _limits(study, level)
    yield from nearest_lines(study)
    yield from (f"{label}: {wind}" for label, wind in wind_rows(study.wind))
    if everything:
        yield from structure_lines(study)
    yield from extrapolation_blocks(study.extrapolations, level)
    yield from _reliability(study)
    if study.reliability is not None:
        return
    yield from _survival(study, level)
    yield from _whole_cells(study, level)
    if cells is not None and everything:
        yield neighbour_table(serialise(cells), study.objective)
    if cells is None and study.status.name == "infeasible" and study.coverage is None:
        few = study.relaxations if everything else study.relaxations[:_FEW]
        yield relaxation_table(few) if few else NONE_ALONE.format(study.objective.value)


def record_blocks(sizing: Mapping[str, Any], objective: Objective) -> Iterator[Table]:
    """Yield the tables of what was requested of an optimum besides, from a sizing's record."""
    if (cells := sizing.get("whole_cells")) is not None:
        yield neighbour_table(cells, objective)
    if (sensitivities := sizing.get("sensitivities")) is not None:
        yield sensitivity_table(sensitivities, objective)
    if multipliers := sizing.get("constraint_multipliers"):
        yield multiplier_table(multipliers, objective)
    if (guarded := sizing.get("with_margin")) is not None and guarded["status"] == "optimal":
        yield margin_table(objective, sizing, guarded)
    if builds := sizing.get("builds"):
        yield build_table(builds, objective)


def _builds(study: SizingStudy, level: int) -> Iterator[Table]:
    """Yield the designs of each build quality, where no record has shown them."""
    if study.builds and (level < ALL or study.design is None):
        table = build_table(serialise(study.builds), study.objective)
        yield table if level >= ALL else replace(table, title="")


def _confidence(study: SizingStudy, level: int) -> Iterator[Any]:
    """Yield how sure the answer is: ranges of the models, their error, margins."""
    yield from extrapolation_blocks(study.extrapolations, level)
    yield from sources(study, level)
    if (optimum := study.optimum) is not None:
        yield Line(uncertainty_line(optimum), "faint")
        required_h, low_h = study.result.required_excess_time_h, optimum.low.least_excess_time_h
        guarded = study.mission.uncertainty_margins.is_set or study.reliability is not None
        guarded = guarded or study.survival is not None
        if study.with_margin is not None:
            yield _margin_line(optimum, study.with_margin, level)
        elif low_h < max(required_h, 0.0) and not guarded:
            missed = f"misses the required {given(required_h, 'h')}"
            what = "ends perpetual flight" if low_h <= 0.0 else missed
            measured = model_error_note(study.mission.altitude_m)
            text = f"on the edge: one RMS error{measured} less solar power {what}; {_TO_GUARD}"
            yield Line(text, "warning")
    if study.as_assumed is not None:
        reached = hours(study.as_assumed.excess_time_h)
        yield f"without the mission's uncertainty margins the excess time is {reached}"


_TO_GUARD = "to size with that margin: --set mission.uncertainty_margins.solar_model_sigmas=1"


def _margin_line(optimum: Analysis, guarded: SizingStudy, level: int) -> Line:
    """Return what a margin costs, which level 2 has as a table."""
    with_error = _with_error(optimum.performance.solar)
    if guarded.design is None:
        return Line(f"{with_error} no design was found", "warning")
    if level >= ALL:
        return Line(_TO_GUARD, "faint")
    changes = ", ".join(_changes(optimum.design, guarded.design))
    return Line(f"{with_error}: {changes}; {_TO_GUARD.split(': ')[1]}", "faint")


def _with_error(solar: SolarModel) -> str:
    return f"with one RMS error ({percent(solar.rms_relative, '.0f')}) less solar power as margin"


def margin_table(
    objective: Objective, sizing: Mapping[str, Any], guarded: Mapping[str, Any]
) -> Table:
    """Return an optimum beside the one with a margin of one RMS error, by their records."""
    name, excess = objective.variable, q.EXCESS_TIME
    was = dict(sizing) | {
        name: sizing["objective"]["value"],
        excess.name: sizing["simulated"][excess.name],
        "least_excess_time_h": sizing["uncertainty"]["excess_time_low_h"],
    }
    now = dict(guarded) | {name: guarded["objective_value"]}
    shown = (*q.CHOSEN, q.TOTAL_MASS)
    rows = [
        (each.label, *(each.fact(record[each.name])[1] for record in (was, now)),
         change_text(was[each.name], now[each.name]))
        for each in shown
    ]  # fmt: skip
    if objective.label not in (excess.label, *(each.label for each in shown)):
        texts = (with_unit(record[name], objective) for record in (was, now))
        rows.insert(0, (objective.label, *texts, change_text(was[name], now[name])))
    for key, what in ((excess.name, ""), ("least_excess_time_h", ", that error less")):
        ends = (np.inf if record[key] is None else record[key] for record in (was, now))
        rows.append((f"{excess.label}{what}", *map(hours, ends), ""))
    columns = (
        Column("quantity", ""),
        Column("optimum", "as requested", to_right=True),
        Column("guarded", "with margin", to_right=True),
        Column("change", to_right=True),
    )
    solar = SolarModel(sizing["model"], sizing["correction"])
    return Table(_with_error(solar), columns, tuple(rows))


# ---- Sentences

_FEW_SENSITIVITIES = 3  # of a line; a table has more
NONE_ALONE = (
    "no single one makes it feasible of: technology parameters to the ends of their ranges, less "
    "payload, bounds and limits in the way, wind, latitude, required excess time. Where and when "
    "there is a design: solar-uav map --resize {0}; with two changes at once: solar-uav sweep "
    "--resize {0}"
)


def _range_text(widest: WidestRange) -> str:
    """Return the range of days or latitudes that one design covers."""
    first, last, extent = widest.first, widest.last, widest.extent
    assert first is not None
    assert last is not None
    if widest.sizing.objective.value == "longest_season":
        ends = " to ".join(date_label(int(day)) for day in (first, last))
        return f"season: {ends}, {int(extent)} days; the mission's own dates play no part"
    ends = f"{latitude_label(first)} to {latitude_label(last)}"
    return f"latitudes: {ends}, {given(extent)} degrees; the mission's own latitude plays no part"


def limits_line(active: Iterable[str], aircraft: Aircraft, *, keys: bool) -> str:
    """Return what limits a design, most important first.

    Without ``keys`` each limit once, and a scenario that they share once.
    """
    words = [constraint_words(name, aircraft) for name in active]
    if keys:
        order = " (most important first)" if len(words) > 1 else ""
        return f"limited by{order}: {'; '.join(map(str, words))}"
    first = list({limit.label: limit for limit in reversed(words)}.values())[::-1]
    places = {limit.where for limit in words if limit.where}
    if len(places) == 1:
        return f"limited at {places.pop()} by {'; '.join(limit.label for limit in first)}"
    return f"limited by {'; '.join(limit.without_key for limit in first)}"


def nearest_lines(study: SizingStudy) -> list[str]:
    """Return what the nearest design is, and how much of it is structure."""
    if (nearest := study.result.nearest) is None:
        return []
    design = nearest.design
    known = q.facts_of((*q.CHOSEN, q.AIRSPEED), design)
    lines = [f"nearest design, not a solution: {', '.join(map(' '.join, known))}"]
    if study.structure is not None:
        structure_kg, total_kg = float(design.masses.structure), float(design.total_mass_kg)
        of_mass, whole = (amount(mass_kg, "kg", ".3g") for mass_kg in (structure_kg, total_kg))
        share = "its structure outgrows every mass that it could have"
        if math.isfinite(total_kg):
            relative = percent(structure_kg / total_kg, ".0f")
            share = f"{of_mass} of its {whole} are structure ({relative})"
        lines.append(f"nearest design: {share}")
    return lines


def without_climbs(study: SizingStudy) -> list[str]:
    """Return the optimum of level flight, and how much larger it is; nothing without climbs."""
    level, objective, value = study.without_climbs, study.objective, study.result.objective_value
    if level is None or study.design is None:
        return []
    where = f"in level flight at {q.text_of('altitude_m', study.mission.altitude_m)}"
    if level.design is None:
        return [f"{where} no design was found ({level.status.label})"]
    parts = _changes(study.design, level.design)
    if objective.variable not in (q.WINGSPAN.name, q.TOTAL_MASS.name):
        assert level.objective_value is not None
        assert value is not None
        change = change_text(value, level.objective_value)
        parts.insert(0, f"{objective_text(objective, level.objective_value)} ({change})")
    return [f"{where}: {', '.join(parts)}"]


def _changes(before: Design, after: Design) -> list[str]:
    """Return span and mass of a design, each with its change."""
    return [
        f"{' '.join(each.fact(each.of(after)))} "
        f"({change_text(float(each.of(before)), float(each.of(after)))})"
        for each in (q.WINGSPAN, q.TOTAL_MASS)
    ]


def _reliability(study: SizingStudy) -> list[str]:
    """Return how reliable the design is, and what the optimum without uncertainty is."""
    if (reliability := study.reliability) is None:
        return []
    what = required(study.result.required_excess_time_h, study.mission)
    reached = reliability.achieved.text()
    of_nearest = "" if study.feasible else "of the nearest design "
    nominal = objective_text(study.objective, reliability.nominal_objective)
    return [
        f"reliability ({what} in every scenario): {of_nearest}{reached} of {reliability.samples} "
        f"draws; required {percent(reliability.required, 'g')}. The optimum without uncertainty, "
        f"{nominal}, has {percent(reliability.nominal.value)}"
    ]


def survival_text(survival: Survival, study: SizingStudy) -> str:
    """Return the days of the season that close, beside those of the design for a clear sky."""
    days, season = survival.days, survival.mission.dates.range()
    ends = " to ".join(date_label(day) for day in dict.fromkeys((season[0], season[-1])))
    whose = "" if study.feasible else " with the design that closes most of those found"
    close = (
        f"days that close, {ends}: {days.that_close} of {len(days)}, {percent(days.share)} "
        f"(required {percent(survival.required, 'g')}){whose}; longest gap "
        f"{days.longest_gap_days} days."
    )
    value, clear = survival.clear_sky.objective_value, survival.clear_sky_days
    if value is None or clear is None:
        return f"{close} No design flies perpetually on all of these dates under a clear sky"
    text = (
        f"{close} The design for a clear sky, {objective_text(study.objective, value)}, closes "
        f"{clear.that_close}, {percent(clear.share)}"
    )
    sized = study.result.objective_value
    if sized is None or value <= 0.0:
        return text
    more = sized / value - 1.0
    return f"{text}; this one is {percent(abs(more))} {'larger' if more >= 0.0 else 'smaller'}"


def sensitivities_line(study: SizingStudy) -> str:
    """Return what the most important parameters change, and what relaxing a constraint gains."""
    objective, gain = study.objective, q.TABLE["gain"]
    parts = (
        f"{parameter_words(row.parameter)} {amount(row.per_percent, form='+.4f')}"
        for row in (study.sensitivities or [])[:_FEW_SENSITIVITIES]
    )
    changes = ", ".join(parts) or f"none: {objective.label} is unlimited"
    text = f"sensitivities, {objective.unit} per +1 %: {changes}"
    for row in (study.multipliers or [])[:1]:
        name = constraint_words(row.constraint).label
        text += f"; {name} relaxed by {row.step}: {gain.text(row.gain)} {objective.unit}"
    return text


def cross_check_line(record: Mapping[str, Any], objective: Objective) -> str:
    """Return whether a search by simulation found a better design; a search is no proof."""
    from sizing.program.result import RELATIVE_TOLERANCE  # with CasADi, which analyses do without

    best, fine, ours, gained = (
        math.nan if record[key] is None else record[key]
        for key in ("best_found", "fine_step_value", "objective_value", "advantage")
    )
    text = "none is better by more than the tolerance"
    if gained > RELATIVE_TOLERANCE * abs(ours):
        better = with_unit(gained, objective, ".2g")
        text = f"the best of them has {with_unit(best, objective, '.5g')}, better by {better}"
    reached = f"has {with_unit(fine, objective, '.5g')}"
    if math.isnan(fine):
        reached = "misses its requirement"
    elif math.isinf(fine):
        reached = f"has unlimited {objective.label}"
    passed, tried = "" if record["cross_checked"] else "NOT ", record["designs_tried"]
    return (
        f"optimality cross-check {passed}passed: {tried} designs tried, {text}; with a time step "
        f"of one minute the optimum {reached}"
    )


def loss_line(record: Mapping[str, Any], objective: Objective) -> str:
    """Return what whole cells cost, from the record of a sizing; null is unlimited."""
    chosen, loss = record["chosen"], record["loss"]
    values = (each and each["value"] for each in (record["relaxed"], chosen))
    best, value = (with_unit(math.inf if each is None else each, objective) for each in values)
    relaxed, text = f"the relaxed optimum's {best}", f"{objective.label} {value}"
    if chosen is None:
        return f"no whole cells beside {relaxed}"
    if loss is None:
        return f"whole cells: {text}, beside {relaxed}"
    return f"loss by whole cells: {text}, {percent(loss)} worse than {relaxed}"


# ---- Tables

_SENSITIVITIES = 15  # of the whole; JSON and CSV have them all
_LEAST_GAIN = 1e-3  # of the largest: a constraint that gains less is left out
_DESIGNS = 10  # of whole cells; JSON has all


def requirement_table(margins: Iterable[RequirementMargin]) -> Table:
    """Return the margins as a table."""
    rows = []
    for row in margins:
        relative = row.relative and np.isfinite(row.margin)
        margin = percent(row.margin, "+.1f") if relative else amount(row.margin, row.unit, "+.2f")
        missed = not row.recommended and row.margin < -ROW_TOLERANCE
        rows.append(
            {
                "requirement": f"{row.label}{' (recommended)' if row.recommended else ''}",
                "value": amount(round(row.value, 3), row.unit, ".4g"),
                "limit": amount(row.limit, row.unit, ".5g"),
                "margin": f"{margin}, violated" if missed else margin,
            }
        )
    return q.table_of("margins of the requirements", "requirement value limit margin", rows)


def build_table(records: Sequence[Mapping[str, Any]], objective: Objective) -> Table:
    """Return a row for every build quality, of its record."""
    of_design = (q.WINGSPAN, q.TOTAL_MASS, q.BATTERY_MASS, q.MODULE_AREA)
    shown: list[Column] = [replace(quantity, to_right=True) for quantity in of_design]
    if objective.variable not in {quantity.name for quantity in of_design}:
        shown.append(Column("objective_value", objective.label, to_right=True))
    rows: list[tuple[Any, ...]] = []
    for record in records:
        name = f"{record['build']} (this file)" if record["of_file"] else record["build"]
        written = {**record, "objective_value": with_unit(record["objective_value"], objective)}
        values = [written[column.name] for column in shown]
        if record[q.WINGSPAN.name] is None:
            values = ["no design", *("" for _ in values[1:])]
        rows.append((name, record["factor"], *values))
    title = "the same by how well the structure is built (airframe.structure.build)"
    return Table(title, (*q.group("build factor"), *shown), tuple(rows))


def sensitivity_table(sensitivities: Sequence[Mapping[str, Any]], objective: Objective) -> Table:
    """Return what each technology parameter changes, most important first, of their records."""
    parameter, value, elasticity = q.group("parameter value elasticity")
    per_percent = Column("per_percent", f"{objective.unit} per +1 %", form="+.4f")
    columns = (parameter, replace(value, to_right=True), per_percent, elasticity)
    rows = [
        {**row, "parameter": parameter_words(row["parameter"]),
         "value": amount(row["value"], row["unit"], ".4g")}
        for row in sensitivities[:_SENSITIVITIES]
    ]  # fmt: skip
    left, notes = len(sensitivities) - len(rows), []
    if left > 0:
        notes = [f"{left} more parameters matter less; the record of the sizing has all"]
    if not rows:
        notes = [f"none: {objective.label} is unlimited"]
    title = f"sensitivities of the {objective.label} ({objective.value})"
    return q.table_of(title, columns, rows, notes)


def multiplier_table(multipliers: Sequence[Mapping[str, Any]], objective: Objective) -> Table:
    """Return what relaxing each constraint gains, without those that gain next to nothing."""
    constraint, gain, step = q.group("constraint gain step")
    known = [row for row in multipliers if row["gain"] is not None]
    least = _LEAST_GAIN * max((abs(row["gain"]) for row in known), default=0.0)
    rows = [
        {**row, "constraint": constraint_words(row["constraint"]).without_key}
        for row in known
        if abs(row["gain"]) >= least
    ]
    columns = (constraint, replace(gain, label=f"gain in {objective.unit}"), step)
    return q.table_of("what relaxing a constraint gains", columns, rows)


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
