"""Sentences of results, where numbers need judgement: verdicts, what limits, how sure it is."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_label
from missions.mission import Mission
from missions.mission.scenarios import latitude_label
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.balance.assessment import BalanceAssessment
from sizing.layout.cells import rows_text
from sizing.limits import ROW_TOLERANCE
from sizing.relaxed_flight import Relaxation
from sizing.results.design_result import wind_of
from sizing.validity.ranges import model_error_note
from solar.sun import solar_time_h
from studies import quantities as q
from studies.render.tables import clock_label
from studies.render.words import (
    amount,
    change_text,
    clock_of_day,
    constraint_words,
    given,
    hours,
    parameter_words,
    percent,
    required,
    with_unit,
)

if TYPE_CHECKING:
    from sizing.program.cross_check import CrossCheck
    from sizing.program.objectives import Objective
    from sizing.program.ranges import WidestRange
    from sizing.results.analysis import Analysis
    from sizing.results.sizing_study import SizingStudy, Survival

# ---- How long it flies


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
    longitude = analysis.mission.longitude_deg
    if longitude is None:
        return ""
    ahead_h = float(solar_time_h(0.0, day, longitude))
    return f"; {clock_label((solar_h - ahead_h) % 24.0)} UTC"


def relaxations_line(relaxations: Sequence[Relaxation], end: str) -> str:
    """Return the single changes that suffice, in a line."""
    changes = (
        f"{parameter_words(row.parameter)} {row.direction} {given(row.value, row.unit)}"
        for row in relaxations
    )
    return f"{end} with one change: {', or '.join(changes)}"


def coverage_line(analysis: Analysis) -> str | None:
    """Return a note on modules that cover more of the wing than the file allows; else None."""
    airframe, design = analysis.aircraft.airframe, analysis.design
    if isinstance(airframe, MeasuredAirframe):
        return None
    covered = float(design.variables.module_area_m2 / design.wing_area_m2)
    most = airframe.maximum_module_coverage
    if covered <= most * (1.0 + ROW_TOLERANCE):
        return None
    return (
        f"The modules cover {percent(covered, '.0f')} of the wing, more than the "
        f"{percent(most, 'g')} of airframe.maximum_module_coverage."
    )


# ---- What a sizing ends at


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


def range_text(widest: WidestRange) -> str:
    """Return the range of days or latitudes that one design covers."""
    first, last, extent = widest.first, widest.last, widest.extent
    assert first is not None
    assert last is not None
    if widest.sizing.objective.value == "longest_season":
        ends = " to ".join(date_label(int(day)) for day in (first, last))
        return f"season: {ends}, {int(extent)} days; the mission's own dates play no part"
    ends = f"{latitude_label(first)} to {latitude_label(last)}"
    return f"latitudes: {ends}, {given(extent)} degrees; the mission's own latitude plays no part"


def nearest_lines(study: SizingStudy) -> list[str]:
    """Return what the nearest design is, and how much of it is structure."""
    nearest = study.result.nearest
    if nearest is None:
        return []
    design = nearest.design
    known = design.variables.chosen() | {q.AIRSPEED.name: design.airspeed_m_per_s}
    facts_of = (quantity.fact(known[quantity.name]) for quantity in (*q.CHOSEN, q.AIRSPEED))
    lines = [f"nearest design, not a solution: {', '.join(map(' '.join, facts_of))}"]
    if study.structure is not None:
        structure_kg, total_kg = float(design.masses.structure), float(design.total_mass_kg)
        of_mass, whole = (amount(mass_kg, "kg", ".3g") for mass_kg in (structure_kg, total_kg))
        share = (
            f"{of_mass} of its {whole} are structure ({percent(structure_kg / total_kg, '.0f')})"
            if math.isfinite(total_kg)
            else "its structure outgrows every mass that it could have"
        )
        lines.append(f"nearest design: {share}")
    return lines


NONE_ALONE = (
    "no single one makes it feasible of: technology parameters to the ends of their ranges, less "
    "payload, bounds and limits in the way, wind, latitude, required excess time. Where and when "
    "there is a design: solar-uav map --resize {0}; with two changes at once: solar-uav sweep "
    "--resize {0}"
)


def without_climbs(study: SizingStudy) -> list[str]:
    """Return the optimum of level flight, and how much larger it is; nothing without climbs."""
    level, objective = study.without_climbs, study.objective
    if level is None or study.design is None:
        return []
    where = f"in level flight at {q.text_of('altitude_m', study.mission.altitude_m)}"
    if level.design is None:
        return [f"{where} no design was found ({level.status.label})"]
    parts = [
        f"{quantity.label} {quantity.fact(quantity.of(level.design))[1]} "
        f"({change_text(float(quantity.of(study.design)), float(quantity.of(level.design)))})"
        for quantity in (q.WINGSPAN, q.TOTAL_MASS)
    ]
    if objective.variable not in (q.WINGSPAN.name, q.TOTAL_MASS.name):
        value = with_unit(level.objective_value, ".4g", objective)
        assert level.objective_value is not None
        assert study.result.objective_value is not None
        change = change_text(study.result.objective_value, level.objective_value)
        parts.insert(0, f"{objective.label} {value} ({change})")
    return [f"{where}: {', '.join(parts)}"]


def reliability_text(study: SizingStudy) -> str:
    """Return how reliable the design is, and what the optimum without uncertainty is."""
    reliability, objective = study.reliability, study.objective
    assert reliability is not None
    what = required(study.result.required_excess_time_h)
    reached = reliability.achieved.text()
    if not study.feasible:
        reached = f"of the nearest design {reached}"
    return (
        f"reliability ({what} in every scenario): {reached} of {reliability.samples} draws; "
        f"required {percent(reliability.required, 'g')}. The optimum without uncertainty, "
        f"{objective.label} {with_unit(reliability.nominal_objective, '.4g', objective)}, has "
        f"{percent(reliability.nominal.value)}"
    )


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
    objective, sized = study.objective, study.result.objective_value
    text = (
        f"{close} The design for a clear sky, {objective.label} "
        f"{with_unit(value, '.4g', objective)}, closes {clear.that_close}, {percent(clear.share)}"
    )
    if sized is None or value <= 0.0:
        return text
    more = sized / value - 1.0
    return f"{text}; this one is {percent(abs(more))} {'larger' if more >= 0.0 else 'smaller'}"


def sensitivities_line(study: SizingStudy) -> str:
    """Return what the most important parameters change, and what relaxing a constraint gains."""
    objective, gain = study.objective, q.TABLE["gain"]
    parts = (
        f"{parameter_words(row.parameter)} {amount(row.per_percent, form='+.4f')}"
        for row in (study.sensitivities or [])[:_SENSITIVITIES]
    )
    changes = ", ".join(parts) or f"none: {objective.label} is unlimited"
    text = f"sensitivities, {objective.unit} per +1 %: {changes}"
    for row in (study.multipliers or [])[:1]:
        name = constraint_words(row.constraint).label
        text += f"; {name} relaxed by {row.step}: {gain.text(row.gain)} {objective.unit}"
    return text


_SENSITIVITIES = 3  # of a line; a table has more


def cross_check_line(check: CrossCheck, objective: Objective) -> str:
    """Return whether a search by simulation found a better design; a search is no proof."""
    from sizing.program.result import RELATIVE_TOLERANCE  # with CasADi, which analyses do without

    better = check.advantage > RELATIVE_TOLERANCE * abs(check.objective_value)
    text = (
        f"the best of them has {with_unit(check.best_found, '.5g', objective)}, better by "
        f"{with_unit(check.advantage, '.2g', objective)}"
        if better
        else "none is better by more than the tolerance"
    )
    fine = f"has {with_unit(check.fine_step_value, '.5g', objective)}"
    if math.isnan(check.fine_step_value):
        fine = "misses its requirement"
    elif math.isinf(check.fine_step_value):
        fine = f"has unlimited {objective.label}"
    verdict = "passed" if check.cross_checked else "NOT passed"
    return (
        f"optimality cross-check {verdict}: {check.designs_tried} designs tried, {text}; with a "
        f"time step of one minute the optimum {fine}"
    )


# ---- How sure it is


def uncertainty_line(analysis: Analysis) -> str:
    """Return what the RMS error of the solar power model means for the least excess time.

    Where the worst scenario is another one with less sun, that one is named. The mission's
    uncertainty margins are taken off before that error.
    """
    low, high, mission = analysis.low, analysis.high, analysis.mission
    ends_h = [low.least_excess_time_h, high.least_excess_time_h]
    # Less sun may turn a scenario with a short day into the worst one.
    at = "" if low.worst_scenario() == analysis.worst else f" ({low.worst_label})"
    means = (
        f"leaves the excess time {'unlimited' if np.isinf(ends_h[0]) else f'at {hours(ends_h[0])}'}"
        if hours(ends_h[0]) == hours(ends_h[1])
        else f"puts the excess time between {hours(ends_h[0])}{at} and {hours(ends_h[1])}"
    )
    solar, with_margins = low.solar, mission.uncertainty_margins.is_set
    beyond = ", on top of the mission's uncertainty margins," if with_margins else ""
    plain = solar.correction == "none"
    error = "the model's RMS error" if plain else "the RMS error left after it"
    if where := model_error_note(mission.altitude_m):
        return (
            f"{solar.label}; its error at {given(mission.altitude_m, 'm')} is not known. One of "
            f"{percent(solar.rms_relative, '.0f')} of the mean power,{where},{beyond[1:]} "
            f"would {means.replace('leaves', 'leave', 1).replace('puts', 'put', 1)}."
        )
    return (
        f"{solar.label}; {error} of "
        f"{percent(solar.rms_relative, '.0f')} of the mean power{beyond} {means}."
    )


def wind_rows(mission: Mission) -> list[tuple[str, str]]:
    """Return the wind as facts, from the weakest to the strongest scenario."""
    wind = wind_of(mission)
    if wind is None:
        return []
    heights_m = mission.climb_levels_m if wind.hold_station else [mission.altitude_m]
    speeds = [mission.at_altitude(height_m).scenario_winds_m_per_s() for height_m in heights_m]
    ends = dict.fromkeys(amount(w, form=".1f") for w in (np.min(speeds), np.max(speeds)))
    everywhere = ", at all heights" if len(heights_m) > 1 else ""
    words = f"wind, {given(wind.percentile)} % of the time at most{everywhere}"
    return [(words, f"{' to '.join(ends)} m/s")]


# ---- Parts


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


def loss_line(record: Mapping[str, Any], objective: Objective) -> str:
    """Return what whole cells cost, from the record of a sizing."""
    chosen, loss = record["chosen"], record["loss"]
    relaxed = f"the relaxed optimum's {_value(record['relaxed'], objective)}"
    if chosen is None:
        return f"no whole cells beside {relaxed}"
    text = f"{objective.label} {_value(chosen, objective)}"
    if loss is None:
        return f"whole cells: {text}, beside {relaxed}"
    return f"loss by whole cells: {text}, {percent(loss)} worse than {relaxed}"


def _value(design: Mapping[str, Any], objective: Objective) -> str:
    """Return the objective of a design with its unit; JSON has null for an unlimited one."""
    value = design["value"]
    return with_unit(math.inf if value is None else value, ".4g", objective)
