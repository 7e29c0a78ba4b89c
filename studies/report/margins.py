"""How much worse each assumption may become before perpetual flight ends, or how much better.

One quantity at a time is moved until the weakest scenario just has the required excess time; all
else stays as it is. The sun is not computed anew: none of the quantities changes it but by a
factor.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import ImpossibleDesignError, design_of
from sizing.energy.cycle import Cycle
from sizing.parameters import with_parameter
from sizing.performance import cycle_of_variants
from sizing.results.records import relative_change
from sizing.results.tables import Column, Table
from sizing.sunlight import SolarDay
from sizing.varying_load import DesignLoads
from solar.types import BoolArray
from studies.report.subject import Subject

# The weakest scenarios, of which one remains the weakest.
_SCENARIOS = 6
_NO_MARGIN = 1e-3  # of a value, or in its unit: what a design on the edge has
_STEPS = 16  # of a bisection: a hundred-thousandth of its range


class _Quantity(NamedTuple):
    """A quantity that is moved: words, its unit, value of the files, and ends of its range.

    ``worse`` is the end at which nothing flies, ``better`` the other one; ``changed`` gives
    aircraft, mission and the factor on the sun at a value.
    """

    label: str
    unit: str
    value: float
    worse: float
    better: float
    changed: Callable[[float], tuple[Aircraft, Mission, float]]


def margin_table(subject: Subject) -> Table | None:
    """Margin of every quantity to the end of perpetual flight, or what it lacks.

    Without those that have next to none; None where that is true of all.
    """
    nominal = subject.analysis.performance
    weakest = np.argsort(nominal.cycle.excess_time_h, kind="stable")[:_SCENARIOS]
    day = nominal.day.at(weakest)
    required = max(subject.mission.required_excess_time_h, 0.0)
    holds = bool(np.all(_hold(nominal.cycle, required)))
    quantities = _quantities(subject.aircraft, subject.mission)
    rows = []
    for one, limit in zip(quantities, _limits(quantities, day, required, holds=holds), strict=True):
        change = None if limit is None else limit - one.value
        scale = max(abs(one.value), 100.0 if one.unit == "%" else 1.0)
        if change is not None and abs(change) <= _NO_MARGIN * scale:
            continue
        relative = None if limit is None else relative_change(one.value, limit)
        percent = None if relative is None else 100.0 * relative
        rows.append((one.label, one.unit, one.value, limit, change, percent))
    if not rows:
        return None
    what = "may become" if holds else "would have to become"
    than = f"{required:g} h of excess time" if required > 0.0 else "perpetual flight"
    columns = (
        Column("quantity"),
        Column("unit"),
        Column("value", "now", form=".4g"),
        Column("limit", what, form=".4g", missing="no limit" if holds else "not enough alone"),
        Column("change", form="+.3g"),
        Column("relative", "change", "%", "+z.0f"),
    )
    title = f"{'margins to the end of' if holds else 'what is missing for'} {than}, one at a time"
    return Table(title, columns, tuple(rows))


def _quantities(aircraft: Aircraft, mission: Mission) -> list[_Quantity]:
    """What is moved: sun, battery, propulsion, consumers, payload."""

    def of(key: str) -> Callable[[float], tuple[Aircraft, Mission, float]]:
        return lambda value: (*with_parameter(aircraft, mission, key, value), 1.0)

    battery = aircraft.battery.specific_energy_wh_per_kg
    extra, avionics = mission.turbulence.all_day, aircraft.power.avionics_w
    return [
        _Quantity("solar power, of the modelled", "%", 100.0, 0.0, 400.0,
                  lambda value: (aircraft, mission, value / 100.0)),
        _Quantity("specific energy of the battery", "Wh/kg", battery, 0.01 * battery,
                  4.0 * battery, of("battery.specific_energy_wh_per_kg")),
        _Quantity("propulsion power, beyond level flight", "%", 100.0 * extra, 400.0,
                  -90.0, lambda value: of("mission.turbulence.all_day")(value / 100.0)),
        _Quantity("avionics power", "W", avionics, 1e3 + 10.0 * avionics, 0.0,
                  of("power.avionics_w")),
        _Quantity("payload mass", "kg", mission.payload.mass_kg,
                  mission.payload.mass_kg + 50.0, 0.0, of("mission.payload.mass_kg")),
    ]  # fmt: skip


def _limits(
    quantities: Sequence[_Quantity], day: SolarDay, required: float, *, holds: bool
) -> list[float | None]:
    """Values at which the weakest scenario just has what is required; None where there is none.

    All quantities are halved together: a march of several flights takes no longer than one.
    """

    def enough(values: Sequence[float]) -> list[bool]:
        return _suffice(quantities, values, day, required)

    good = [one.value if holds else one.better for one in quantities]
    bad = [one.worse if holds else one.value for one in quantities]
    # What becomes of the values themselves is known: ``holds``.
    known = [not flies for flies in enough(bad)] if holds else enough(good)
    for _ in range(_STEPS):
        middle = [0.5 * (g + b) for g, b in zip(good, bad, strict=True)]
        fly = enough(middle)
        good = [m if flies else g for m, g, flies in zip(middle, good, fly, strict=True)]
        bad = [b if flies else m for m, b, flies in zip(middle, bad, fly, strict=True)]
    return [limit if has_one else None for limit, has_one in zip(good, known, strict=True)]


def _suffice(
    quantities: Sequence[_Quantity], values: Sequence[float], day: SolarDay, required: float
) -> list[bool]:
    """Whether each quantity at its value leaves every scenario what is required."""
    found = [False] * len(quantities)
    flown = []
    for number, (one, value) in enumerate(zip(quantities, values, strict=True)):
        aircraft, mission, factor = one.changed(value)
        try:
            design = design_of(aircraft, mission)
            if mission.climb is not None:
                design_of(aircraft, mission.at_altitude(mission.climb.ceiling_m))
            loads = DesignLoads.of(aircraft, mission, design, day.scaled(factor))
        except ImpossibleDesignError:
            continue
        flown.append((number, (aircraft, loads)))
    if flown:
        cycle = cycle_of_variants([variant for _, variant in flown])
        every = np.all(_hold(cycle, required), axis=-1).tolist()
        for (number, _), holds in zip(flown, every, strict=True):
            found[number] = holds
    return found


def _hold(cycle: Cycle, required: float) -> BoolArray:
    """Whether each flight is perpetual, with the required excess time."""
    return np.asarray(cycle.perpetual & (cycle.excess_time_h >= required))
