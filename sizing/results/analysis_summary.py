"""Text of an analysis: the worst scenario in full, the others as rows, the flight, if any."""

from __future__ import annotations

from typing import Any

import numpy as np

from missions.dates import date_label, day_of_year
from missions.mission import Mission, latitude_label
from sizing.energy.settling import MAXIMUM_DAYS, SETTLED
from sizing.results.analysis import Analysis, flight_record, scenario_record
from sizing.results.battery import battery_line
from sizing.results.notes import (
    catalogue_blocks,
    extrapolation_blocks,
    mass_table,
    structure_blocks,
)
from sizing.results.records import clock_label, hours
from sizing.results.tables import MISSING, UNLIMITED, Column, Line, Summary, Table, facts


def headline(analysis: Analysis) -> str:
    """Aircraft, mission, place and excess time in one line."""
    record = scenario_record(analysis, analysis.worst)
    excess = hours(record["excess_time_h"], UNLIMITED if _always_lit(record) else MISSING)
    flown = "" if analysis.days is None else f" after {_days(analysis.days)}"
    return (
        f"{analysis.aircraft.name} on {analysis.mission.name} at {_where(analysis)}{flown}: "
        f"excess time {excess}, {record['status'].replace('_', ' ')}"
    )


def summary(analysis: Analysis) -> Summary:
    """What is shown of an analysis, in the order in which it is read."""
    record = analysis.to_dict()
    several = len(record["scenarios"]) > 1
    worst = ", worst scenario" if several else ""
    flown = "" if analysis.days is None else f", after {_days(analysis.days)} from an empty battery"
    title = (
        f"{record['aircraft']} on {record['mission']}, {_where(analysis)}{worst}{flown}: "
        f"{record['status'].replace('_', ' ')}"
    )
    rows = _rows(record) + (_climb_rows(record["climb"]) if "climb" in record else [])
    blocks: list[Any] = [Line(title, "strong")]
    table, masses = facts("", rows), record["masses_kg"]
    blocks.append(table if masses is None else (table, mass_table(masses)))
    blocks += structure_blocks(analysis.structure)
    if several:
        blocks.append(scenario_table(record["scenarios"]))
    if analysis.flight is not None:
        blocks.append(flight_table(flight_record(analysis.flight)))
    condition = battery_line(analysis.aircraft, analysis.mission)
    if condition is not None:
        blocks.append(condition)
    slow = settling_line(analysis)
    if slow is not None:
        blocks.append(Line(slow, "warning"))
    blocks += extrapolation_blocks(analysis.extrapolations)
    blocks += catalogue_blocks(analysis.aircraft)
    blocks.append(Line(uncertainty_line(record, analysis.mission), "faint"))
    return Summary(tuple(blocks))


# More days than these are told: at an equinox at 47.6 N the energy of a day has changed by 5 % by
# then, about as much as the solar power model errs.
_A_FEW_DAYS = 5


def settling_line(analysis: Analysis) -> str | None:
    """Warning that the season does not wait for the repeated day to settle; None if it need not."""
    days = analysis.days_to_settle
    slow = days > _A_FEW_DAYS
    if not slow.any():
        return None
    which = analysis.worst if slow[analysis.worst] else int(np.argmax(np.where(slow, days, 0.0)))
    number = f"{days[which]:.0f}" if np.isfinite(days[which]) else f"more than {MAXIMUM_DAYS}"
    where = "" if len(days) == 1 else f" at {analysis.performance.day.scenarios.label(which)}"
    return (
        f"From an empty battery the day{where} must repeat itself {number} times until the charge "
        f"in the morning is within {100 * SETTLED:.0f} % of the battery's energy of the one shown. "
        "The season does not wait: --days 2 flies from an empty battery while the date advances."
    )


def _days(count: int) -> str:
    return "1 day" if count == 1 else f"{count} days"


def uncertainty_line(record: dict[str, Any], mission: Mission) -> str:
    """What the RMS error of the solar power model means for the excess time.

    ``mission``: with its uncertainty margins, which are taken off before that error.
    """
    spread = record["uncertainty"]
    low, high = spread["excess_time_low_h"], spread["excess_time_high_h"]
    means = (
        "leaves the excess time unlimited"
        if low is None and high is None
        else f"puts the excess time between {hours(low, UNLIMITED)} and {hours(high, UNLIMITED)}"
    )
    plain = record["correction"] == "none"
    given = mission.uncertainty_margins.given
    beyond = ", on top of the mission's uncertainty margins," if given else ""
    error = "the model's RMS error" if plain else "the RMS error left after it"
    return (
        f"{record['model']}, correction: {record['correction']}; {error} of "
        f"{100 * spread['solar_power_rms_relative']:.0f} % of the mean power{beyond} {means}."
    )


def _where(analysis: Analysis) -> str:
    return analysis.performance.day.scenarios.label(analysis.worst)


def _always_lit(record: dict[str, Any]) -> bool:
    return bool(record["status"] == "always_lit")


def _endurance(record: dict[str, Any]) -> str:
    unlimited = record["status"] in ("perpetual", "always_lit")
    return hours(record["endurance_h"], UNLIMITED if unlimited else "over a year")


def _rows(record: dict[str, Any]) -> list[tuple[str, str]]:
    endurance = _endurance(record)
    if record["best_launch_h"] is not None and record["sunrise_h"] is not None:
        # Without sun every launch is as good.
        endurance += f", launched {clock_label(record['best_launch_h'])}"
    airspeed = record["airspeed_m_per_s"]
    times = {
        key: clock_label(record[f"{key}_h"])
        for key in ("sunrise", "sunset", "equal_power_morning", "equal_power_evening")
    }
    return [
        ("excess time", hours(record["excess_time_h"], UNLIMITED if _always_lit(record) else "-")),
        ("charge margin", hours(record["charge_margin_h"])),
        ("endurance", endurance),
        ("minimum state of charge", f"{100 * record['minimum_state_of_charge']:.1f} %"),
        ("total mass", f"{record['total_mass_kg']:.2f} kg"),
        ("battery", f"{record['battery_energy_wh']:.0f} Wh"),
        ("airspeed", MISSING if airspeed is None else f"{airspeed:.1f} m/s"),
        ("load", f"{record['power_out_w']:.1f} W"),
        ("solar energy of the day", f"{record['solar_energy_wh']:.0f} Wh"),
        ("sunrise, sunset (solar time)", f"{times['sunrise']}, {times['sunset']}"),
        (
            "equal power, morning and evening",
            f"{times['equal_power_morning']}, {times['equal_power_evening']}",
        ),
        ("full charge", clock_label(record["full_charge_h"])),
    ]


def _climb_rows(climb: dict[str, Any]) -> list[tuple[str, str]]:
    gain = climb["gain_in_excess_time_h"]
    constant = hours(climb["constant_altitude_excess_time_h"], UNLIMITED)
    return [
        ("highest altitude", f"{climb['maximum_altitude_m']:.0f} m"),
        ("gliding in the evening", hours(climb["gliding_h"])),
        ("stored potential energy", f"{climb['stored_height_wh']:.1f} Wh"),
        ("excess time at constant altitude", constant),
        ("gained by climbing", MISSING if gain is None else f"{gain:+.2f} h"),
    ]


def scenario_table(records: list[dict[str, Any]]) -> Table:
    """Metrics of all scenarios, a row each."""
    columns = (
        Column("latitude"),
        Column("date"),
        Column("excess_time", "excess time"),
        Column("charge_margin", "charge margin"),
        Column("minimum_state_of_charge", "min. SoC"),
        Column("endurance"),
    )
    rows = [
        (
            latitude_label(r["latitude_deg"]),
            date_label(r["day_of_year"]),
            hours(r["excess_time_h"], UNLIMITED),
            hours(r["charge_margin_h"]),
            f"{100 * r['minimum_state_of_charge']:.1f} %",
            _endurance(r),
        )
        for r in records
    ]
    return Table("all scenarios", columns, tuple(rows))


def flight_table(flight: dict[str, Any]) -> Table:
    """Replayed flight as a list of facts."""
    first_day = day_of_year(flight["launch"].split()[0])
    clock_time = flight["launch"].split()[1]
    rows = [("launch (local time)", f"{date_label(first_day)} {clock_time}")]
    for clock in flight["full_charge_clock_h"]:
        rows.append(("full charge", clock_label(clock, first_day=first_day)))
    rows += [
        ("minimum state of charge", f"{100 * flight['minimum_state_of_charge']:.1f} %"),
        ("flown", hours(flight["duration_h"])),
        ("state of charge at the end", f"{100 * flight['final_state_of_charge']:.1f} %"),
    ]
    if flight["empty_clock_h"] is not None:
        rows.append(("battery empty", clock_label(flight["empty_clock_h"], first_day=first_day)))
    return facts("flight on the calendar", rows)
