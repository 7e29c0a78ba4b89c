"""Text of an analysis: the worst scenario in full, the others as rows, the flight, if any."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from missions.dates import date_label, day_of_year
from missions.mission.scenarios import latitude_label
from sizing.aircraft import MeasuredAirframe
from sizing.day.replay import CalendarRun
from sizing.limits import ROW_TOLERANCE
from sizing.results import quantities as q
from sizing.results.analysis import Analysis
from sizing.results.conditions import battery_line, battery_record, wind_rows
from sizing.results.notes import (
    extrapolation_blocks,
    mass_table,
    relaxation_table,
    source_blocks,
    structure_blocks,
    uncertainty_line,
)
from sizing.results.parts import balance_blocks, cells_lines, cells_record
from sizing.results.propulsion import part_masses_line, power_line, varying_line
from sizing.results.records import clock_label, hours
from sizing.results.tables import MISSING, Column, Line, Summary, Table, facts
from solar.sun import solar_time_h


def headline(analysis: Analysis) -> str:
    """Aircraft, mission, place and excess time in one line."""
    values = analysis.scenario()
    return (
        f"{analysis.aircraft.name} on {analysis.mission.name} at {_where(analysis)}: "
        f"{' '.join(q.EXCESS_TIME.fact(values[q.EXCESS_TIME]))}, {_status(values)}"
    )


def summary(analysis: Analysis) -> Summary:
    """What is shown of an analysis, in the order in which it is read."""
    several = len(analysis.performance.cycle.status) > 1
    worst = ", worst scenario" if several else ""
    title = (
        f"{analysis.aircraft.name} on {analysis.mission.name}, {_where(analysis)}{worst}: "
        f"{_status(analysis.scenario())}"
    )
    blocks: list[Any] = [Line(title, "strong"), Line(answer(analysis))]
    table, masses = facts("", _scenario_rows(analysis)), analysis.masses_kg
    blocks.append(table if masses is None else (table, mass_table(masses)))
    blocks.append(power_line(analysis.power_budget, analysis.mission))
    if analysis.part_masses is not None:
        blocks.append(part_masses_line(analysis.part_masses))
    if analysis.varying_efficiency is not None:
        blocks.append(varying_line(analysis.varying_efficiency))
    blocks += structure_blocks(analysis.structure)
    blocks += balance_blocks(analysis.drag_coefficients, analysis.balance)
    if several:
        blocks.append(scenario_table(analysis))
    if analysis.relaxations:
        blocks.append(relaxation_table(analysis.relaxations[:_CHEAPEST], "perpetual"))
    if analysis.flight is not None:
        blocks.append(flight_table(analysis.flight))
    condition = battery_line(analysis.aircraft, battery_record(analysis.aircraft, analysis.mission))
    if condition is not None:
        blocks.append(condition)
    blocks += cells_lines(cells_record(analysis.aircraft))
    beyond = coverage_line(analysis)
    if beyond is not None:
        blocks.append(Line(beyond, "warning"))
    blocks += extrapolation_blocks(analysis.extrapolations)
    blocks += source_blocks(analysis.aircraft, analysis.mission)
    if analysis.excess_time_h < 0.0:
        blocks.append(Line(q.BELOW_ZERO, "faint"))
    error = uncertainty_line(analysis.low, analysis.high, analysis.worst, analysis.mission)
    blocks.append(Line(error, "faint"))
    return Summary(tuple(blocks))


_CHEAPEST = 2  # relaxations that are shown


def answer(analysis: Analysis) -> str:
    """How long the aircraft flies, in a sentence or two; times are solar, and UTC if known."""
    values, flight = analysis.scenario(), analysis.limited_flight
    if analysis.mission.flight is not None:
        return landing(analysis)
    if flight is None:
        if values[q.STATUS] == "always_lit":
            return "It flies perpetually: the sun carries the load at all times."
        if analysis.is_perpetual:
            return f"It flies perpetually, with {hours(analysis.excess_time_h)} to spare."
        return "It flies for over a year, but its days do not repeat themselves."
    first_day = int(analysis.performance.day.scenarios.day_of_year[analysis.worst])
    launched, empty = flight.launch_h, flight.empty_h
    days = int(empty // 24.0)
    later = {0: "", 1: " on the next day"}.get(days, f" {days} days later")
    clock = f"{clock_label(empty % 24.0)}{later} (solar time{_utc(analysis, first_day, empty)})"
    text = (
        f"It flies {hours(flight.endurance_h)} at best: launched with a full battery at "
        f"{clock_label(launched)} it flies until {clock}"
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
    """From when to when the flight of the worst scenario goes, and what is left at its end."""
    at, perf = analysis.worst, analysis.performance
    window_h = analysis.mission.flight_window_h(perf.day.scenarios)
    assert window_h is not None
    launch_h, land_h = (float(one[at]) for one in window_h)
    later = {0: "", 1: " on the next day"}.get(
        int(land_h // 24.0), f" {land_h // 24.0:.0f} days later"
    )
    when = f"from {clock_label(launch_h)} to {clock_label(land_h % 24.0)}{later} (solar time)"
    excess_h = analysis.excess_time_h
    if excess_h > 0.0:
        return f"It flies {when} and lands with {hours(excess_h)} to spare."
    return f"Of a flight {when} it lacks power for {hours(-excess_h)}."


def _utc(analysis: Analysis, day: int, solar_h: float) -> str:
    """The same instant in UTC, where the mission has a longitude."""
    longitude = analysis.mission.longitude_deg
    if longitude is None:
        return ""
    ahead_h = float(solar_time_h(0.0, day, longitude))
    return f"; {clock_label((solar_h - ahead_h) % 24.0)} UTC"


def coverage_line(analysis: Analysis) -> str | None:
    """Note on modules that leave less of the wing free than the file asks; None where they fit."""
    airframe, design = analysis.aircraft.airframe, analysis.performance.design
    if isinstance(airframe, MeasuredAirframe):
        return None
    covered = float(design.variables.module_area_m2 / design.wing_area_m2)
    most = airframe.maximum_module_coverage
    if covered <= most * (1.0 + ROW_TOLERANCE):
        return None
    return (
        f"The modules cover {100.0 * covered:.0f} % of the wing, more than the "
        f"{100.0 * most:g} % of airframe.maximum_module_coverage."
    )


def _where(analysis: Analysis) -> str:
    return analysis.performance.day.scenarios.label(analysis.worst)


def _status(values: dict[q.Quantity, Any]) -> str:
    return str(values[q.STATUS]).replace("_", " ")


def _endurance(values: dict[q.Quantity, Any]) -> str:
    endurance_h, unlimited = values[q.ENDURANCE], values[q.STATUS] in ("perpetual", "always_lit")
    return "over a year" if np.isinf(endurance_h) and not unlimited else hours(endurance_h)


def _scenario_rows(analysis: Analysis) -> list[tuple[str, str]]:
    values, design = analysis.scenario(), analysis.performance.design
    endurance = _endurance(values)
    if not np.isnan(values[q.BEST_LAUNCH]) and not np.isnan(values[q.SUNRISE]):
        # Without sun every launch is as good.
        endurance += f", launched {clock_label(values[q.BEST_LAUNCH])}"
    morning, evening = q.EQUAL_POWER_MORNING, q.EQUAL_POWER_EVENING
    return [
        *(one.fact(values[one]) for one in (q.EXCESS_TIME, q.CHARGE_MARGIN)),
        (q.ENDURANCE.label, endurance),
        q.MINIMUM_CHARGE.fact(values[q.MINIMUM_CHARGE]),
        q.TOTAL_MASS.fact(design.total_mass_kg, ".2f"),
        ("battery", q.BATTERY_ENERGY.fact(design.battery_energy_wh, ".0f")[1]),
        q.AIRSPEED.fact(design.airspeed_m_per_s, ".1f"),
        *wind_rows(analysis.mission),
        *(one.fact(values[one]) for one in (q.LOAD, q.SOLAR_ENERGY)),
        ("sunrise, sunset (solar time)", _clocks(values[q.SUNRISE], values[q.SUNSET])),
        ("equal power, morning and evening", _clocks(values[morning], values[evening])),
        (q.FULL_CHARGE.label, clock_label(values[q.FULL_CHARGE])),
        *_climb_rows(analysis),
    ]


def _clocks(*hours_h: float) -> str:
    return ", ".join(map(clock_label, hours_h))


def _height(altitude_m: float) -> str:
    return f"{altitude_m:.0f} m" if math.isfinite(altitude_m) else "nowhere"


def _climb_rows(analysis: Analysis) -> list[tuple[str, str]]:
    """What climbing does in the worst scenario; nothing where the mission does not climb."""
    if analysis.climb is None:
        return []
    climb, worst, held_m = analysis.climb, analysis.worst, analysis.climb.held_up_to_m
    # Zero added: what rounds to -0 is no loss.
    gain_h = round(float(climb.gain_h[worst]), 2) + 0.0
    # A limited flight is flown from a full battery, and may climb where the repeated day does not.
    day = "" if analysis.performance.cycle.perpetual[worst] else ", repeated day"
    return [
        *([] if held_m is None else [("wind held up to", _height(float(held_m[worst])))]),
        (f"highest altitude{day}", f"{climb.altitude_m[worst].max():.0f} m"),
        (f"gliding in the evening{day}", hours(float(climb.gliding_h[worst]))),
        (f"stored potential energy{day}", f"{climb.stored_height_wh[worst]:.1f} Wh"),
        (
            "excess time at constant altitude",
            q.EXCESS_TIME.fact(q.EXCESS_TIME.of(climb.constant)[worst])[1],
        ),
        ("gained by climbing", f"{gain_h:+.2f} h" if np.isfinite(gain_h) else MISSING),
        *_check_rows(analysis),
    ]


def _check_rows(analysis: Analysis) -> list[tuple[str, str]]:
    """Excess time of the heights by the program that chose them, and in steps of a minute."""
    if (checked := analysis.climb_check_h) is None:
        return []
    more_h = (round(one_h - analysis.excess_time_h, 2) + 0.0 for one_h in checked)
    texts = (f"{h:.2f} h ({more:+.2f})" for h, more in zip(checked, more_h, strict=True))
    return [("by the program, by the minute", ", ".join(texts))]


def scenario_table(analysis: Analysis, shown: Iterable[int] | None = None) -> Table:
    """Metrics of scenarios, a row each: of all, or of some of them."""
    scenarios = analysis.performance.day.scenarios
    columns = (
        Column("latitude"),
        Column("date"),
        Column("excess_time", q.EXCESS_TIME.label),
        Column("charge_margin", q.CHARGE_MARGIN.label),
        Column("minimum_state_of_charge", "min. SoC"),
        Column("endurance"),
    )
    rows = []
    for index in range(len(scenarios)) if shown is None else shown:
        values = analysis.scenario(index)
        rows.append(
            (
                latitude_label(float(scenarios.latitude_deg[index])),
                date_label(int(scenarios.day_of_year[index])),
                *(one.fact(values[one])[1] for one in q.REACHED),
                _endurance(values),
            )
        )
    return Table("all scenarios", columns, tuple(rows))


def flight_table(flight: CalendarRun) -> Table:
    """Replayed flight as a list of facts."""
    first_day = day_of_year(flight.launch.date)
    rows = [("launch (local time)", f"{date_label(first_day)} {flight.launch.time_local}")]
    for clock in flight.full_charge_clock_h:
        rows.append((q.FULL_CHARGE.label, clock_label(clock, first_day=first_day)))
    rows += [
        q.MINIMUM_CHARGE.fact(flight.minimum_state_of_charge),
        ("flown", hours(float(flight.clock_h[-1] - flight.clock_h[0]))),
        ("state of charge at the end", f"{100 * flight.state_of_charge[-1]:.1f} %"),
    ]
    if flight.empty_clock_h is not None:
        rows.append(("battery empty", clock_label(flight.empty_clock_h, first_day=first_day)))
    return facts("flight on the calendar", rows)
