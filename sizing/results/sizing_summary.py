"""Text of a sizing: design and masses, limits, how sure it is; or why there is none."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from missions.dates import date_label
from missions.mission.scenarios import latitude_label
from sizing.day.light import SolarModel
from sizing.parameters import unit_text
from sizing.performance import Performance
from sizing.program.cross_check import CrossCheck
from sizing.program.objectives import Objective
from sizing.program.ranges import WidestRange
from sizing.program.reasons import LIMITING_FRACTION
from sizing.program.reliability import Reliability
from sizing.program.result import RELATIVE_TOLERANCE, SizingStatus
from sizing.program.sensitivity import ConstraintMultiplier, Sensitivity
from sizing.results.conditions import battery_line, battery_record, climb_lines, wind_rows
from sizing.results.notes import (
    extrapolation_blocks,
    mass_table,
    relaxation_table,
    source_blocks,
    structure_blocks,
    uncertainty_line,
)
from sizing.results.parts import (
    balance_lines,
    cells_lines,
    loss_line,
    neighbour_table,
    sizing_record,
)
from sizing.results.propulsion import part_masses_line, power_line
from sizing.results.qualities import build_table
from sizing.results.quantities import (
    AIRSPEED,
    CHOSEN,
    ENDURANCE,
    EXCESS_TIME,
    MINIMUM_CHARGE,
    TOTAL_MASS,
)
from sizing.results.records import change_text, hours, with_unit
from sizing.results.requirements import constraint_words, parameter_words, requirement_table
from sizing.results.season import Survival
from sizing.results.sizing_study import SizingStudy
from sizing.results.tables import Column, Line, Summary, Table, facts
from sizing.validity.ranges import where_error_is_known

_SENSITIVITIES = 15  # rows that are shown; JSON and CSV have them all


def headline(study: SizingStudy) -> str:
    """Aircraft, mission, verdict and objective in one line."""
    objective, value = study.objective, study.result.objective_value
    text = f"{study.aircraft.name} sized for {_where(study)}: {study.status.label}"
    if study.feasible:
        text += f", {objective.label} {with_unit(value, '.4g', objective)}"
    return text


def summary(study: SizingStudy) -> Summary:
    """What is shown of a sizing, in the order in which it is read."""
    title = f"{study.aircraft.name} sized for {_where(study)} ({study.objective.value})"
    blocks: list[Any] = [Line(f"{title}: {study.status.label}", "strong")]
    if study.design is None:
        return Summary((*blocks, *_without_design(study), *_builds(study)))
    if study.coverage is not None and study.coverage.first is not None:
        blocks.append(_range_text(study.coverage))
    at_bounds = [name for name in study.result.active_constraints if " at its " in name]
    if at_bounds:
        words = "; ".join(str(constraint_words(name, study.aircraft)) for name in at_bounds)
        blocks.append(Line(f"at the end of the design space: {words}", "warning"))
    blocks.append((_design_table(study), mass_table(study.design.masses._asdict())))
    if study.power_budget is not None:
        blocks.append(power_line(study.power_budget, study.mission))
    blocks += climb_lines(study.mission, study.result, study.climbs, study.without_climbs)
    if study.part_masses is not None:
        blocks.append(part_masses_line(study.part_masses))
    blocks += _whole_cells(study)
    blocks += _limits("limited by", study, at_bounds)
    blocks += structure_blocks(study.structure)
    if study.balance is not None:
        blocks += [Line(text) for text in balance_lines(study.balance)]
    blocks.append(requirement_table(study.margins))
    blocks += _confidence(study)
    if study.reliability is not None:
        blocks.append(reliability_text(study.reliability, study))
    if study.survival is not None:
        blocks += survival_blocks(study.survival, study)
    if study.sensitivities is not None:
        blocks.append(sensitivity_table(study.sensitivities, study.objective))
    if study.multipliers:
        blocks.append(multiplier_table(study.multipliers, study.objective))
    if study.cross_check is not None:
        blocks.append(cross_check_line(study.cross_check, study.objective))
    return Summary((*blocks, *_builds(study)))


def _builds(study: SizingStudy) -> list[Any]:
    """The same requirement by each class of building; nothing where it was not asked for."""
    records = [one.to_dict() for one in study.builds]
    return [build_table(records, study.objective)] if records else []


def _whole_cells(study: SizingStudy) -> list[Any]:
    """Whole cells, what they cost, and the designs that were tried."""
    if study.whole_cells is None:
        return []
    record = sizing_record(study.whole_cells, study.aircraft)
    lines = [loss_line(record, study.objective), *cells_lines(record)]
    return [*lines, neighbour_table(record, study.objective)]


def _where(study: SizingStudy) -> str:
    survival = study.survival
    name = study.mission.name
    return name if survival is None else f"{name} in the weather of {survival.weather.site.label}"


def _without_design(study: SizingStudy) -> list[Any]:
    """Requirements that are missed, what holds the design back, and what would help."""
    blocks: list[Any] = [f"  {one.text}" for one in study.result.violations]
    blocks += _limits("limited by", study)
    blocks += _nearest_design(study)
    blocks += extrapolation_blocks(study.extrapolations)
    if study.reliability is not None:
        return [*blocks, reliability_text(study.reliability, study)]
    if study.survival is not None:
        blocks += survival_blocks(study.survival, study)
    if study.whole_cells is not None:
        return [*blocks, *_whole_cells(study)]
    if study.status is not SizingStatus.infeasible or study.coverage is not None:
        return blocks
    if not study.relaxations:
        return [*blocks, _NONE_ALONE.format(study.objective.value)]
    return [*blocks, relaxation_table(study.relaxations)]


_NONE_ALONE = (
    "no single one makes it feasible of: technology parameters to the ends of their ranges, less "
    "payload, bounds and limits in the way, wind, latitude, required excess time. Where and when "
    "there is a design: solar-uav map --resize {0}; with two changes at once: solar-uav sweep "
    "--resize {0}"
)


def _nearest_design(study: SizingStudy) -> list[Any]:
    """What the nearest design is, how much of it is structure, and what sizes that."""
    nearest = study.result.nearest
    if nearest is None:
        return []
    design = nearest.design
    known = design.variables.chosen() | {AIRSPEED.name: design.airspeed_m_per_s}
    facts_of = (one.fact(known[one.name]) for one in (*CHOSEN, AIRSPEED))
    values = ", ".join(f"{name} {value}" for name, value in facts_of)
    winds = [f"{name}: {value}" for name, value in wind_rows(study.mission)[:1]]
    head = [f"nearest design, not a solution: {values}", *winds]
    if study.structure is None:
        return head
    structure_kg, total_kg = float(design.masses.structure), float(design.total_mass_kg)
    share = (
        f"nearest design: {structure_kg:.3g} kg of its {total_kg:.3g} kg are structure "
        f"({100.0 * structure_kg / total_kg:.0f} %)"
        if math.isfinite(total_kg)
        else "nearest design: its structure outgrows every mass that it could have"
    )
    return [*head, share, *structure_blocks(study.structure)]


def _limits(head: str, study: SizingStudy, notes: Sequence[str] = ()) -> list[Any]:
    """What limits a design, most important first, as a paragraph.

    Where the excess time is to be as large as possible it is no limit.
    """
    active = study.result.active_constraints
    if study.objective is Objective.max_excess_time or not study.feasible:
        active = tuple(name for name in active if not name.startswith("excess_time"))
    words = [str(constraint_words(name, study.aircraft)) for name in active if name not in notes]
    order = " (most important first)" if len(words) > 1 else ""
    return [f"{head}{order}: {'; '.join(words)}"] if words else []


def _design_table(study: SizingStudy) -> Table:
    flown = study.result.simulated
    assert flown is not None
    worst = flown.worst_scenario()
    clear = " under a clear sky" if study.survival is not None else ""
    excess, charge = (one.fact(one.of(flown)[worst]) for one in (EXCESS_TIME, MINIMUM_CHARGE))
    where = f"{EXCESS_TIME.label}{clear}, {flown.day.scenarios.label(worst)}"
    rows = [one.fact(value) for one, value in study.design_values()]
    flight = study.mission.flight
    if study.objective is Objective.max_endurance:
        launch = "" if flight is None else f", launched {flight.launch}"
        rows.append((ENDURANCE.label, ENDURANCE.fact(study.result.objective_value)[1] + launch))
    elif flight is not None:
        rows.append(("flight", flight.text))
    return facts("", [*rows, *wind_rows(study.mission), (where, excess[1]), charge])


def _confidence(study: SizingStudy) -> list[Any]:
    """How far the answer may be trusted: ranges of the models, their error, margins."""
    flown, low, high = study.result.simulated, study.low, study.high
    some = flown or study.result.nearest
    mass_kg = None if some is None else float(some.design.variables.battery_mass_kg)
    condition = battery_line(study.aircraft, battery_record(study.aircraft, study.mission, mass_kg))
    blocks: list[Any] = [] if condition is None else [condition]
    blocks += extrapolation_blocks(study.extrapolations)
    blocks += source_blocks(study.aircraft, study.mission)
    if flown is not None and low is not None and high is not None:
        worst = flown.worst_scenario()
        blocks.append(Line(uncertainty_line(low, high, worst, study.mission), "faint"))
        low_h = _least_h(low)
        required = max(study.result.required_excess_time_h, 0.0)
        guarded = study.mission.uncertainty_margins.given or study.reliability is not None
        guarded = guarded or study.survival is not None
        if study.with_margin is not None:
            blocks += _margin_blocks(study, study.with_margin)
        elif low_h < required and not guarded:
            what = (
                "ends perpetual flight" if low_h <= 0.0 else f"misses the required {required:g} h"
            )
            measured = where_error_is_known(study.mission.altitude_m)
            text = (
                f"on the edge: one RMS error{measured} less solar power {what}; to size with "
                f"that margin: "
                f"--set {_MARGIN_KEY}"
            )
            blocks.append(Line(text, "warning"))
    if study.without_margins is not None:
        reached = hours(float(np.min(study.without_margins.cycle.excess_time_h)))
        blocks.append(f"without the mission's uncertainty margins the excess time is {reached}")
    return blocks


_MARGIN_KEY = "mission.uncertainty_margins.solar_model_sigmas=1"


def _margin_blocks(study: SizingStudy, guarded: SizingStudy) -> list[Any]:
    """The optimum beside the one with a margin, and what the margin costs."""
    safe, plain = guarded.result.simulated, guarded.without_margins
    flown, low = study.result.simulated, study.low
    if flown is None or low is None or safe is None or plain is None:
        return [Line(f"{_with_error(study.solar)} no design was found", "warning")]
    was, now = (
        {one.name: value for one, value in each.design_values()}
        | {study.objective.variable: each.result.objective_value}
        | {EXCESS_TIME.name: _least_h(modelled), "least_excess_time_h": _least_h(less)}
        for each, modelled, less in ((study, flown, low), (guarded, plain, safe))
    )
    return [
        margin_table(study.objective, study.solar, was, now),
        Line(f"to size with that margin: --set {_MARGIN_KEY}", "faint"),
    ]


def _with_error(solar: SolarModel) -> str:
    return f"with one RMS error ({100 * solar.rms_relative:.0f} %) less solar power as margin"


def _least_h(perf: Performance) -> float:
    return float(np.min(perf.cycle.excess_time_h))


def margin_table(
    objective: Objective, solar: SolarModel, was: Mapping[str, Any], now: Mapping[str, Any]
) -> Table:
    """An optimum beside the one with a margin of one RMS error.

    ``was``, ``now``: quantities of both, ``excess_time_h`` as modelled, ``least_excess_time_h``
    with that error less, and the value of the objective under the name of its variable.
    """
    shown = (*CHOSEN, TOTAL_MASS)
    rows: list[tuple[str, ...]] = [
        (
            one.label,
            *(one.fact(e[one.name])[1] for e in (was, now)),
            change_text(was[one.name], now[one.name]),
        )
        for one in shown
    ]
    name = objective.variable
    if objective.label not in (EXCESS_TIME.label, *(one.label for one in shown)):
        texts = (with_unit(one[name], ".4g", objective) for one in (was, now))
        rows.insert(0, (objective.label, *texts, change_text(was[name], now[name])))
    for key, what in ((EXCESS_TIME.name, ""), ("least_excess_time_h", ", that error less")):
        ends = (np.inf if one[key] is None else one[key] for one in (was, now))
        rows.append((f"{EXCESS_TIME.label}{what}", *map(hours, ends), ""))
    columns = (
        Column("quantity", ""),
        Column("optimum", "as requested", to_right=True),
        Column("guarded", "with margin", to_right=True),
        Column("change", to_right=True),
    )
    return Table(_with_error(solar), columns, tuple(rows))


def reliability_text(reliability: Reliability, study: SizingStudy) -> str:
    """How reliable the design is, and what the optimum without uncertainty is."""
    hours_h = study.result.required_excess_time_h
    what = f"{hours_h:g} h of excess time" if hours_h > 0.0 else "perpetual flight"
    objective = study.objective
    reached = reliability.achieved.text()
    if not study.feasible:
        reached = f"of the nearest design {reached}"
    return (
        f"reliability ({what} in every scenario): {reached} of {reliability.samples} draws; "
        f"required {100 * reliability.required:g} %. The optimum without uncertainty, "
        f"{objective.label} "
        f"{with_unit(reliability.nominal_objective, '.4g', objective)}, has "
        f"{100 * reliability.nominal.value:.1f} %"
    )


def survival_blocks(survival: Survival, study: SizingStudy) -> list[Any]:
    """Days of the season that close, year by year, beside the design for a clear sky.

    Returns blocks of a summary.
    """
    days, season = survival.days, survival.mission.dates.range()
    ends = " to ".join(date_label(day) for day in dict.fromkeys((season[0], season[-1])))
    whose = "" if study.feasible else " with the design that closes most of those found"
    text = (
        f"days that close, {ends}: {days.that_close} of {len(days)}, {100 * days.share:.1f} % "
        f"(required {100 * survival.required:g} %){whose}; longest gap "
        f"{days.longest_gap_days} days"
    )
    blocks: list[Any] = [f"{text}. {_clear_sky_text(survival, study)}"]
    if survival.several_years:
        columns = (
            Column("year"),
            Column("days"),
            Column("days_that_close", "close"),
            Column("share", "share", "%", ".1f"),
        )
        rows = tuple(
            (one["year"], one["days"], one["days_that_close"], 100.0 * one["share"])
            for one in days.by_year()
        )
        blocks.append(Table("year by year", columns, rows))
    blocks += [Line(f"record: {text}", "faint") for text in survival.weather.repairs]
    return blocks + [Line(text, "faint") for text in survival.notes]


def _clear_sky_text(survival: Survival, study: SizingStudy) -> str:
    """Design for a clear sky on the same dates, and what it makes of the record."""
    value, clear = survival.clear_sky_objective, survival.clear_sky_days
    if value is None or clear is None:
        return "No design flies perpetually on all of these dates under a clear sky"
    objective, own = study.objective, study.result.objective_value
    text = (
        f"The design for a clear sky, {objective.label} {with_unit(value, '.4g', objective)}, "
        f"closes {clear.that_close}, {100 * clear.share:.1f} %"
    )
    if own is None or value <= 0.0:
        return text
    more = 100.0 * (own / value - 1.0)
    return f"{text}; this one is {abs(more):.1f} % {'larger' if more >= 0.0 else 'smaller'}"


def _range_text(widest: WidestRange) -> str:
    first, last, extent = widest.first, widest.last, widest.extent
    assert first is not None
    assert last is not None
    if widest.sizing.objective is Objective.longest_season:
        ends = " to ".join(date_label(int(day)) for day in (first, last))
        return f"season: {ends}, {int(extent)} days; the mission's own dates play no part"
    ends = f"{latitude_label(first)} to {latitude_label(last)}"
    return f"latitudes: {ends}, {extent:g} degrees; the mission's own latitude plays no part"


def sensitivity_table(sensitivities: list[Sensitivity], objective: Objective) -> Table:
    """What each technology parameter is worth, most important first."""
    unit = objective.unit
    columns = (
        Column("parameter"),
        Column("value", to_right=True),
        Column("per_percent", f"{unit} per +1 %", form="+.4f"),
        Column("elasticity", form="+.3f"),
    )
    rows = [
        (
            parameter_words(one.parameter),
            f"{one.value:.4g} {unit_text(one.unit)}".rstrip(),
            one.per_percent,
            one.elasticity,
        )
        for one in sensitivities[:_SENSITIVITIES]
    ]
    if rows:
        left = len(sensitivities) - len(rows)
        more = f"{left} more parameters matter less; the record of the sizing has all"
        notes = (more,) if left > 0 else ()
    else:
        notes = (f"none: {objective.label} is unlimited",)
    return Table(
        f"sensitivities of the {objective.label} ({objective.value})", columns, tuple(rows), notes
    )


def multiplier_table(multipliers: list[ConstraintMultiplier], objective: Objective) -> Table:
    """What relaxing each constraint gains, by its multiplier, next to nothing left out."""
    columns = (
        Column("constraint"),
        Column("gain", f"gain in {objective.unit}", form=".3g"),
        Column("step", "per relaxation by"),
    )
    least = LIMITING_FRACTION * max((abs(one.gain) for one in multipliers), default=0.0)
    rows = [
        (constraint_words(one.constraint).without_key, one.gain, one.step)
        for one in multipliers
        if abs(one.gain) >= least
    ]
    return Table("what relaxing a constraint gains", columns, tuple(rows))


def cross_check_line(check: CrossCheck, objective: Objective) -> str:
    """Whether a search by simulation found a better design; a search is no proof."""
    better = check.advantage > RELATIVE_TOLERANCE * abs(check.objective_value)
    text = (
        f"the best of them has {with_unit(check.best_found, '.5g', objective)} "
        f"({check.found_by}), better by {with_unit(check.advantage, '.2g', objective)}"
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
