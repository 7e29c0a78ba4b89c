"""Extrapolated quantities of a design, of many results, and of cells of maps and trade studies.

The effect of an assumption at altitude comes from another simulation without the assumption.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from missions.dates import DAYS_PER_YEAR
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.battery.condition import BatteryTemperature
from sizing.day.light import SolarModel, solar_day
from sizing.day.replay import CalendarRun
from sizing.mass_budget import ImpossibleDesignError, closed_design, design_of
from sizing.parameters import parameter
from sizing.performance import Performance, performance
from sizing.validity.checks import charge_rate_check, correction_check, design_checks, flight_checks
from sizing.validity.ranges import (
    EXPERIENCE,
    Check,
    Extrapolation,
    experience,
    extrapolation,
    ranges,
)
from solar.modules import STC_TEMPERATURE_C
from solar.schema import spell


def extrapolations(aircraft: Aircraft, perf: Performance) -> tuple[Extrapolation, ...]:
    """Return the extrapolated quantities of a single design, in the order of the catalogue."""
    return collect_extrapolations(flight_checks(aircraft, perf), perf.day.scenarios)


def replay_extrapolations(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, run: CalendarRun
) -> tuple[Extrapolation, ...]:
    """Return the extrapolated quantities of a flight by the clock."""
    days = (np.unique(np.floor(run.day_of_year).astype(int)) - 1) % DAYS_PER_YEAR + 1
    scenarios = Scenarios(np.full(len(days), mission.latitudes()[0]), days)
    checks = [
        *design_checks(aircraft, mission, run.design, solar),
        *correction_check(scenarios, solar, mission),
        *charge_rate_check(aircraft, mission, run.design, np.max(run.solar_power_w)),
    ]
    return collect_extrapolations(checks, scenarios)


def collect_extrapolations(
    checks: Iterable[Check], scenarios: Scenarios | None = None, *, of: int = 0, what: str = ""
) -> tuple[Extrapolation, ...]:
    """Return the extrapolations among checks with their worst value, in the catalogue's order.

    ``checks`` are scalars or have the shape of scenarios or cells. ``scenarios`` name those
    concerned, unless all are; ``of`` and ``what`` are number and name of the cells.
    """
    collected = []
    for check in checks:
        outside, distance = check.outside, check.distance
        if not np.any(outside):
            continue
        place = np.unravel_index(np.argmax(distance), distance.shape)
        worst = check.extrapolation_at(tuple(map(int, place)))
        if of:
            count = int(np.sum(outside)) if outside.shape else of
            worst = replace(worst, count=count, of=of, what=what)
        elif scenarios is not None and outside.shape and not np.all(outside):
            names = tuple(scenarios.label(int(place)) for place in np.flatnonzero(outside))
            worst = replace(worst, scenarios=names)
        collected.append(worst)
    return _in_order(collected)


def keep_worst(
    outside: Iterable[Extrapolation], *, of: int = 0, what: str = ""
) -> tuple[Extrapolation, ...]:
    """Return each quantity of a model once, with its worst value.

    ``of`` and ``what`` are number and name of the results, unless they belong to one design.
    """
    groups: dict[tuple[str, str], list[Extrapolation]] = {}
    for item in outside:
        groups.setdefault((item.quantity, item.model), []).append(item)
    worst = {key: max(group, key=lambda item: item.distance) for key, group in groups.items()}
    return _in_order(
        replace(item, count=len(groups[key]), of=of, what=what) if of else item
        for key, item in worst.items()
    )


def _in_order(outside: Iterable[Extrapolation]) -> tuple[Extrapolation, ...]:
    order = {place: number for number, place in enumerate(ranges())}
    last = len(order)  # parameters outside of experience keep the order of their checks
    return tuple(sorted(outside, key=lambda item: order.get((item.quantity, item.model), last)))


def merge_extrapolations(
    several: Sequence[Sequence[Extrapolation]], what: str
) -> tuple[Extrapolation, ...]:
    """Return the worst value of each quantity of many results, and how many have it."""
    return keep_worst((item for result in several for item in result), of=len(several), what=what)


# ---- Cells, as a column of text


def cell_texts(checks: Iterable[Check], count: int) -> list[str]:
    """Return the extrapolations of each design of a batch as text, which :func:`from_text` reads.

    ``checks`` are scalars or of shape ``(design,)`` or ``(design, scenario)``. The texts ``model:
    quantity value not low to high`` have the worst scenario's value and are joined by semicolons.
    """
    lines: list[list[str]] = [[] for _ in range(count)]
    for check in checks:
        if not np.any(check.outside):
            continue
        every = check if check.outside.shape else check.over((count,))
        distance = every.distance.reshape(count, -1)
        shape = every.outside.shape[1:]
        for number in np.flatnonzero(np.any(distance > 0.0, axis=1)):
            scenario = np.unravel_index(np.argmax(distance[number]), shape)
            lines[number].append(_line(every.extrapolation_at((int(number), *map(int, scenario)))))
    return ["; ".join(line) for line in lines]


def as_text(outside: Iterable[Extrapolation]) -> str:
    """Return the extrapolations of a single design as text, see :func:`cell_texts`."""
    return "; ".join(map(_line, outside))


def _line(item: Extrapolation) -> str:
    low = -math.inf if item.minimum is None else item.minimum
    high = math.inf if item.maximum is None else item.maximum
    return f"{item.model}: {item.quantity} {spell(item.value)} not {spell(low)} to {spell(high)}"


_LINE = re.compile(r"(\w+): ([\w.]+) (\S+) not (\S+) to (\S+)")


def from_text(text: str) -> tuple[Extrapolation, ...]:
    """Return the extrapolations of a text of :func:`cell_texts`."""
    outside = []
    for part in text.split("; ") if text else ():
        match = _LINE.fullmatch(part)
        if match is None:
            raise ValueError(f"names no model: {part[:80]!r}")
        model, quantity, *numbers = match.groups()
        value, low, high = map(float, numbers)
        # Technology parameters have a range of experience.
        row = experience(parameter(quantity)) if model == EXPERIENCE else ranges()[quantity, model]
        outside.append(extrapolation(row, value, low, high))
    return tuple(outside)


def add_effects(
    extrapolations: Iterable[Extrapolation],
    aircraft: Aircraft,
    simulate: Callable[[], Performance | None],
) -> tuple[Extrapolation, ...]:
    """Add the effect of the assumption to extrapolations of modules and battery in cold air.

    ``simulate`` returns a single design's repeated day, None if infeasible. It is called only for
    such extrapolations; the critical scenario is simulated again, climbs in level flight at their
    highest altitude.
    """
    notes = tuple(extrapolations)
    perf, flight_note = None, ""
    if any((note.quantity, note.model) in _WITHOUT for note in notes):
        perf = simulate()
    if perf is not None and perf.maximum_altitude_m is not None:
        highest_m = float(np.max(perf.maximum_altitude_m))
        flight_note = f"in level flight at {round(highest_m)} m"
        perf = level_flight_at(aircraft, perf, highest_m)
    if perf is None:
        return notes
    critical = perf.day.at([perf.worst_scenario()])
    once = performance(aircraft, perf.mission, perf.solar, day=critical, design=perf.design)
    what, place = f"the excess time {flight_note}".rstrip(), once.day.scenarios.label(0)
    effects = []
    for note in notes:
        if (without := _WITHOUT.get((note.quantity, note.model))) is not None:
            other, words = without(aircraft, once)
            hours = [float(flight.cycle.excess_time_h[0]) for flight in (once, other)]
            before, after = ("unlimited" if math.isinf(h) else f"{h:.2f} h" for h in hours)
            change = f"stays {before}" if before == after else f"is {after} instead of {before}"
            note = replace(
                note,
                worth=f"{words} {what} {change} at {place}",
                excess_time_h=hours[1] if np.isfinite(hours[1]) else None,
            )
        effects.append(note)
    return tuple(effects)


def level_flight_at(aircraft: Aircraft, perf: Performance, altitude_m: float) -> Performance | None:
    """Return the repeated day of a design at an altitude; None where it cannot fly there."""
    mission = perf.mission.at_altitude(altitude_m)
    try:
        if isinstance(aircraft.airframe, ParametricAirframe):
            design = closed_design(aircraft, mission, perf.design.variables)
        else:
            design = design_of(aircraft, mission)
        if not np.all(np.isfinite(design.propulsion_power_w)):
            return None
        day = solar_day(aircraft, mission, perf.solar, scenarios=perf.day.scenarios)
        return performance(aircraft, mission, perf.solar, day=day, design=design)
    except ImpossibleDesignError:
        return None


def _with_cold_modules(aircraft: Aircraft, perf: Performance) -> tuple[Performance, str]:
    """Return the flight with modules at air temperature, and the change in words."""
    air_c = float(perf.mission.air_state().temperature_c)
    air = perf.mission.air.model_copy(update={"module_temperature_c": air_c})
    mission = perf.mission.model_copy(update={"air": air})
    step_h = float(perf.day.time_h[1] - perf.day.time_h[0])
    day = solar_day(aircraft, mission, perf.solar, scenarios=perf.day.scenarios, step_h=step_h)
    cold = performance(aircraft, mission, perf.solar, day=day, design=perf.design)
    warm_wh, cold_wh = (float(flight.cycle.energy_budget.solar_wh[0]) for flight in (perf, cold))
    at = f"as cold as the air, {spell(air_c, 3)} °C,"
    if warm_wh <= 0.0:
        return cold, at
    percent = round(100.0 * (cold_wh / warm_wh - 1.0))
    loss_per_k, balanced = aircraft.modules.temperature_coefficient_per_k, ""
    if loss_per_k != 0.0 and perf.solar.model != "FM" and perf.solar.correction != "loiter":
        # The highest temperature of the modules, from their power when cold.
        place = int(np.argmax(cold.solar_power_w[0]))
        ratio = float(perf.solar_power_w[0, place] / cold.solar_power_w[0, place])
        at_air = float(aircraft.modules.temperature_efficiency(air_c))
        warmest_c = STC_TEMPERATURE_C + (1.0 - ratio * at_air) / loss_per_k
        balanced = f"by a balance of heat at most {round(warmest_c)} °C; "
    return cold, f"{balanced}{at} they would give {percent} % more solar energy, and"


def _with_an_unheated_battery(aircraft: Aircraft, perf: Performance) -> tuple[Performance, str]:
    """Return the flight with a battery at air temperature, and the change in words."""
    mission, design, battery = perf.mission, perf.design, aircraft.battery
    air_c = float(mission.air_state().temperature_c)
    left = float(BatteryTemperature().capacity_fraction(air_c))
    unheated = battery.model_copy(update={"temperature": BatteryTemperature()})
    share = unheated.capacity_fraction(air_c) / battery.capacity_fraction(air_c, mission.altitude_m)
    mass_kg = design.variables.battery_mass_kg
    heater_w = float(battery.heater_w(air_c, mission.altitude_m, mass_kg))
    other = design._replace(
        battery_energy_wh=design.battery_energy_wh * share,
        constant_power_w=design.constant_power_w - heater_w,
    )
    cold = performance(aircraft, mission, perf.solar, day=perf.day, design=other)
    held, _ = battery.temperature_at(mission.altitude_m)
    kept = ""
    if held is not None and heater_w > 0.0:
        pack_c = round(float(held.pack_c(air_c)))
        kept = f"assumed heated to {pack_c} °C with {spell(heater_w, 3)} W; "
    words = f"unheated at {spell(air_c, 3)} °C, with {round(100.0 * left)} % of its capacity,"
    return cold, f"{kept}{words}"


_WITHOUT = {
    ("altitude_m", "module_temperature"): _with_cold_modules,
    ("altitude_m", "battery"): _with_an_unheated_battery,
    ("air_temperature_c", "battery"): _with_an_unheated_battery,
}
