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
from sizing.parameters import unit_text
from sizing.propulsion.chain import LINKS
from sizing.propulsion.part_masses import motor_mass_fit, propeller_mass_fit
from sizing.relaxed_flight import Relaxation
from sizing.results.conditions import BatteryCondition, Spread, wind_of
from sizing.results.propulsion import Instant, PartMasses, PowerBudget, VaryingEfficiency
from sizing.validity.ranges import model_error_note
from solar.sun import solar_time_h
from studies import quantities as q
from studies.render.numbers import (
    amount,
    change_text,
    clock_of_day,
    counted,
    hours,
    percent,
    with_unit,
)
from studies.render.tables import clock_label
from studies.render.words import constraint_words, parameter_words

if TYPE_CHECKING:
    from sizing.program.cross_check import CrossCheck
    from sizing.program.objectives import Objective
    from sizing.program.ranges import WidestRange
    from sizing.program.result import SizingResult
    from sizing.results.analysis import Analysis
    from sizing.results.season import Survival
    from sizing.results.sizing_study import SizingStudy

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
        f"{parameter_words(row.parameter)} {row.direction} {row.value:g} {unit_text(row.unit)}"
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
    return f"latitudes: {ends}, {extent:g} degrees; the mission's own latitude plays no part"


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
        share = (
            f"{structure_kg:.3g} kg of its {total_kg:.3g} kg are structure "
            f"({percent(structure_kg / total_kg, '.0f')})"
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


def climb_lines(study: SizingStudy) -> list[str]:
    """Return the heights of the optimum's day, and the optimum without climbs."""
    level, mission = study.without_climbs, study.mission
    climb = None if study.optimum is None else study.optimum.worst_scenario.climb
    if climb is None:
        return []
    floor_m, highest_m = mission.altitude_m, climb.maximum_altitude_m
    reached = "its ceiling of " if highest_m > climb.ceiling_m - 1.0 else ""
    floor, highest, dawn = (
        q.text_of("altitude_m", height_m)
        for height_m in (floor_m, highest_m, climb.dawn_altitude_m)
    )
    text = f"stays at {floor}: no surplus, or no power, is left to climb with"
    if highest_m > floor_m + 1.0:
        text = (
            f"climbs by day from {floor} to {reached}{highest}, which stores "
            f"{amount(climb.stored_height_wh, 'Wh')}; glides {hours(climb.gliding_h)} in "
            f"the evening; at dawn at {dawn}"
        )
    return [text] if level is None else [text, _without_climbs(study, level)]


def _without_climbs(study: SizingStudy, level: SizingResult) -> str:
    """Return the optimum of level flight, and how much larger it is."""
    where = f"in level flight at {q.text_of('altitude_m', study.mission.altitude_m)}"
    objective = study.objective
    if level.design is None or study.design is None:
        return f"{where} no design was found ({level.status.label})"
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
    return f"{where}: {', '.join(parts)}"


def reliability_text(study: SizingStudy) -> str:
    """Return how reliable the design is, and what the optimum without uncertainty is."""
    reliability, objective = study.reliability, study.objective
    assert reliability is not None
    hours_h = study.result.required_excess_time_h
    what = f"{hours_h:g} h of excess time" if hours_h > 0.0 else "perpetual flight"
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
    return (
        f"days that close, {ends}: {days.that_close} of {len(days)}, {percent(days.share)} "
        f"(required {percent(survival.required, 'g')}){whose}; longest gap "
        f"{days.longest_gap_days} days. {_clear_sky_text(survival, study)}"
    )


def _clear_sky_text(survival: Survival, study: SizingStudy) -> str:
    """Return the design for a clear sky on the same dates, and its days that close."""
    value, clear = survival.clear_sky.objective_value, survival.clear_sky_days
    if value is None or clear is None:
        return "No design flies perpetually on all of these dates under a clear sky"
    objective, sized = study.objective, study.result.objective_value
    text = (
        f"The design for a clear sky, {objective.label} {with_unit(value, '.4g', objective)}, "
        f"closes {clear.that_close}, {percent(clear.share)}"
    )
    if sized is None or value <= 0.0:
        return text
    more = sized / value - 1.0
    return f"{text}; this one is {percent(abs(more))} {'larger' if more >= 0.0 else 'smaller'}"


def sensitivities_line(study: SizingStudy) -> str:
    """Return what the most important parameters change, and what relaxing a constraint gains."""
    objective, gain = study.objective, q.TABLE["gain"]
    parts = (
        f"{parameter_words(row.parameter)} {row.per_percent:+.4f}"
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
    weakest = low.worst_scenario()
    at = "" if weakest == analysis.worst else f" ({low.day.scenarios.label(weakest)})"
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
            f"{solar.label}; its error at {mission.altitude_m:g} m is not known. One of "
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
    ends = dict.fromkeys(f"{w:.1f}" for w in (np.min(speeds), np.max(speeds)))
    everywhere = ", at all heights" if len(heights_m) > 1 else ""
    words = f"wind, {wind.percentile:g} % of the time at most{everywhere}"
    return [(words, f"{' to '.join(ends)} m/s")]


def battery_line(aircraft: Aircraft, condition: BatteryCondition) -> str:
    """Return the battery's state in a line, such as ``battery at 12 °C: 90 % of its capacity``."""
    words = "battery"
    if condition.pack_temperature_c is not None:
        words += f" at {_spread(condition.pack_temperature_c)} °C"
    if condition.cycles is not None:
        words += f", after {condition.cycles:.0f} cycles and {condition.months:.0f} months"
    words += f": {_spread(condition.capacity_fraction, 100.0)} % of its capacity"
    heater_w = condition.heater_power_w
    if not isinstance(heater_w, Spread):
        words += f", heated with {heater_w:.1f} W" if heater_w > 0.0 else ""
    elif heater_w.highest > 0.0:
        words += (
            f", heated with {heater_w.mean:.1f} W on average and up to {heater_w.highest:.1f} W"
        )
    if aircraft.battery.resistance is not None:
        charge, discharge = condition.charge_efficiency, condition.discharge_efficiency
        words += f", efficiencies {charge:.3f} (charge) and {discharge:.3f} (discharge)"
    return words


def _spread(value: float | Spread, factor: float = 1.0) -> str:
    """Return a number, or the ends of what changes with the days."""
    if not isinstance(value, Spread):
        return f"{factor * value:.0f}"
    low, high = (f"{factor * end:.0f}" for end in (value.lowest, value.highest))
    return low if low == high else f"{low} to {high}"


def catalogue_line(aircraft: Aircraft) -> str | None:
    """Return the values that catalogues gave, by product; None where they gave none."""
    taken = aircraft.from_catalogues()
    parts = []
    for label in dict.fromkeys(row.label for row in taken):
        values = [f"{row.key} {row.text}" for row in taken if row.label == label]
        parts.append(f"{', '.join(values)} of {label}")
    return f"From catalogues: {'; '.join(parts)}." if parts else None


# ---- Parts


_POWER_WORDS = {
    "aerodynamic_w": "drag of level flight",
    **{f"{link}_loss_w": f"lost in the {link}" for link in reversed(LINKS)},
    "propulsion_w": "propulsion in level flight (measured)",
    "turbulence_w": "turbulence",
    "avionics_w": "avionics",
    "payload_w": "payload",
    "supply_loss_w": "lost in the power supply",
    "heater_w": "heater of the battery",
}
_SHOWN = 1e-5  # of the chain: the fourth digit of what is printed


def power_rows(budget: PowerBudget) -> tuple[tuple[str, float], ...]:
    """Return the rows of a power budget in words [W], without those of nothing."""
    return tuple((_POWER_WORDS[key], w) for key, w in budget.watts.items() if w > 1e-9)


def power_note(budget: PowerBudget) -> str:
    """Return what the efficiencies of a power budget are."""
    if not budget.efficiencies:
        return "Only the whole power of a measured aircraft is known, not the share of drag."
    chain = f"From battery to thrust: {percent(budget.efficiencies['chain'])}"
    if budget.point is None:
        return f"{chain} by constants of the file (assumed)."
    point, off = budget.point, (budget.assumed or 0.0) - budget.efficiencies["chain"]
    rest = f"; the optimiser's efficiency is {off:+.1e} off" if abs(off) > _SHOWN else ""
    return (
        f"{chain} at the operating point: propeller {float(point.rotation_rpm):.0f} rpm, "
        f"motor {float(point.motor_current_a):.2f} A, duty {float(point.duty):.2f} of "
        f"{amount(float(point.bus_power_w / point.bus_current_a), 'V')}{rest}."
    )


# Words that are long in a sentence.
_LEFT_OUT = ("lost in the ", " of level flight", " in level flight (measured)")


def power_line(budget: PowerBudget, mission: Mission) -> str:
    """Return the power budget in a sentence; faster flight against the wind is not part of it."""
    parts = []
    for name, watts in power_rows(budget):
        for words in _LEFT_OUT:
            name = name.replace(words, "")
        parts.append(f"{name} {amount(watts, 'W')}")
    slow = " at its own airspeed" if mission.holds_station else ""
    rows = f"{amount(budget.bus_w, 'W')}: {', '.join(parts)}"
    return f"power in level flight{slow}, {rows}. {power_note(budget)}"


def part_masses_line(masses: PartMasses) -> str:
    """Return the estimated masses in a sentence."""
    parts = []
    for name, size, mass_kg, fit in (
        ("motor", "torque", masses.motor_kg, motor_mass_fit()),
        ("propeller", "diameter", masses.propeller_kg, propeller_mass_fit()),
    ):
        if mass_kg is not None:
            low, high = mass_kg / fit.scatter, mass_kg * fit.scatter
            parts.append(
                f"{name} {amount(mass_kg, 'kg')} by the {size} of {fit.number} {name}s of the "
                f"catalogue, which scatter by a factor of {fit.scatter:.2f} "
                f"({low:.3f} to {amount(high, 'kg')})"
            )
    if masses.gearbox_kg is not None:
        gearbox = amount(masses.gearbox_kg, "kg")
        parts.append(f"gearbox {gearbox} by its torque (NASA/TM-2009-215680)")
    return f"estimated masses of a propulsor: {', '.join(parts)}."


# Of the power: an error that would show in the efficiency as it is printed.
_REPORTED_ERROR = 1e-3


def varying_line(varying: VaryingEfficiency) -> str:
    """Return what the varying efficiency changes, in a sentence or two."""
    excess_h, level_h = varying.excess_time_h, varying.level_excess_time_h
    text = f"excess time {hours(excess_h)}" if np.isfinite(excess_h) else "unlimited excess time"
    night, most = varying.night, varying.most
    parts = [
        f"propulsion at the load of the moment: {text}, {hours(level_h)} by level "
        f"flight's efficiency; {_efficiency(night)} at {amount(night.bus_voltage_v, 'V')} at the "
        f"end of the night, {percent(night.state_of_charge, '.0f')} charge"
    ]
    if most is not None:
        parts.append(
            f", {_efficiency(most)} at {amount(most.bus_voltage_v, 'V')} in thermals, "
            f"{most.load:.2f} times the power of level flight"
        )
    if varying.interpolation_error > _REPORTED_ERROR:
        parts.append(f"; the table of the march is {varying.interpolation_error:.1e} off")
    reasons = [
        instant.reason for instant in (night, most) if instant is not None and instant.reason
    ]
    return "".join([*parts, ".", *(f" Beyond the parts: {reason}." for reason in reasons[:1])])


def _efficiency(instant: Instant) -> str:
    known = np.isfinite(instant.efficiency)
    return percent(instant.efficiency) if known else "beyond what the parts can do"


_CLOSE = 0.01  # what a weighed list and the mass budget may differ by without a note


def balance_lines(balance: BalanceAssessment) -> list[str]:
    """Return static margin, tail, trim and controls in sentences."""
    tail, level, out = balance.planes, balance.level, balance.motor_out
    stable = "stable" if balance.static_margin > 0.0 else "unstable"
    lines = [
        f"Static margin {percent(balance.static_margin)} of the mean aerodynamic chord "
        f"({stable}): centre of gravity at {percent(balance.in_chord(balance.gravity_m))}, "
        f"neutral point at {percent(balance.in_chord(balance.neutral_point.x_m))} of "
        f"{amount(balance.wing.aerodynamic_chord_m, 'm')}.",
        f"Tail planes of {tail.horizontal_m2:.3f} and {tail.vertical_m2:.3f} m², "
        f"{tail.arm_m:.2f} m behind the wing; trimmed C_L {level.wing_lift:.3f} of the wing and "
        f"{level.tail_lift:.3f} of the tail, trim drag {level.drag:+.5f} "
        f"({percent(level.drag / balance.drag_coefficient, '+.1f')} of the drag).",
        f"Elevator, trailing edge up positive, of {balance.elevator_limit_deg:g}°: "
        f"{-balance.elevator_deg:+.1f}° trims 1.2 times the stall speed, "
        f"{-balance.elevator_at_stall_deg:+.1f}° the stall. Rudder at 1.2 times the stall speed: "
        f"{balance.sideslip_deg:.0f}° of sideslip, {amount(balance.crosswind_m_per_s, 'm/s')} of "
        "crosswind"
        + ("." if out is None else f"; one motor out needs {percent(out, '.0f')} of it."),
    ]
    if (margin := balance.required_margin) is not None:
        volume = balance.volume_for_margin
        would = "no horizontal tail" if volume is None else f"a horizontal volume of {volume:.3f}"
        lines[0] += f" The {percent(margin, 'g')} asked for would take {would}."
    off = balance.mass_kg / balance.design_mass_kg - 1.0
    if abs(off) > _CLOSE:
        lines.append(
            f"The weighed masses add up to {amount(balance.mass_kg, 'kg')}, "
            f"{percent(off, '+.1f')} off the mass budget of {amount(balance.design_mass_kg, 'kg')}."
        )
    return lines


def cells_lines(record: Mapping[str, Any]) -> list[str]:
    """Return whole cells in words, from their record: a line for modules, one for the battery."""
    lines = []
    solar, strings = record.get("solar_cells"), record.get("strings")
    pack = record.get("battery_pack")
    if solar is not None:
        rows = ", then ".join(rows_text(bay) for bay in solar["rows_of_each_half"])
        text = f"solar cells: {solar['count']}, each half of the wing {rows}"
        if solar["tail_rows"]:
            text += f", the tail {rows_text(solar['tail_rows'])}"
        if strings is not None:
            series = strings["cells_in_series"]
            series = ", ".join(map(str, series)) if isinstance(series, list) else series
            text += (
                f"; {counted(strings['count'], 'string')} of {series} on "
                f"{counted(strings['mppts'], 'MPPT')}, {strings['hottest_mpp_voltage_v']:.1f} to "
                f"{amount(strings['coldest_mpp_voltage_v'], 'V')}, "
                f"{amount(strings['coldest_open_voltage_v'], 'V')} unloaded"
            )
        lines.append(text)
    if pack is not None:
        series, parallel = pack["cells_in_series"], pack["cells_in_parallel"]
        text = f"battery cells: {series * parallel}, {series} in series and {parallel} in parallel"
        if pack["empty_voltage_v"] is not None:
            text += f", {pack['empty_voltage_v']:.1f} to {amount(pack['full_voltage_v'], 'V')}"
        if pack["charge_current_a"] is not None:
            text += f", charged with at most {amount(pack['charge_current_a'], 'A')}"
        lines.append(text)
    return lines


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
