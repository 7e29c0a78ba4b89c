"""Zephyr S with its published technology: which span and mass the sizing gives, input by input.

What is not published is an interval; each input is put to both ends of its interval alone, and
changed until the sizing gives the published mass. Nothing is fitted.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, partial

from benchmarks.validation.single_inputs import nearest_root
from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.program.objectives import Objective
from sizing.program.size import size_aircraft
from studies.render.tables import Column, Table

PUBLISHED_SPAN_M, PUBLISHED_MASS_KG, PUBLISHED_BATTERY_KG = 25.0, 75.0, 24.0

# The flight from 15 June 2022, 64 days, from Yuma (32.7 N): aiimpacts.org wiki, flightglobal.com.
_MISSION = {
    "mission.latitude_deg": 32.7,
    "mission.dates": {"from": "06-15", "to": "08-18"},
    "mission.required_excess_time_h": 0.0,
}
_ASSUMED = "assumption"


@dataclass(frozen=True)
class Unknown:
    """An input and the interval in which it is known to lie; ``search``: ends of a value sought."""

    key: str
    label: str
    used: float
    low: float
    high: float
    search: tuple[float, float]
    source: str


_UNKNOWN = (
    Unknown(
        "mission.altitude_m",
        "altitude [m]",
        20000.0,
        16800.0,
        22600.0,
        (15000.0, 23000.0),
        "55,000 to 74,000 ft: flightglobal.com",
    ),
    Unknown(
        "mission.required_excess_time_h", "excess time [h]", 0.0, 0.0, 3.0, (0.0, 4.0), _ASSUMED
    ),
    Unknown(
        "mission.payload.power_w", "payload power [W]", 50.0, 20.0, 250.0, (0.0, 400.0), _ASSUMED
    ),
    Unknown("power.avionics_w", "avionics power [W]", 50.0, 20.0, 150.0, (0.0, 300.0), _ASSUMED),
    Unknown(
        "airframe.avionics_mass_kg",
        "avionics [kg]",
        4.0,
        2.0,
        6.0,
        (0.5, 12.0),
        "7 to 11 kg with 5 kg of payload: docs/structure.md",
    ),
    Unknown(
        "airframe.aspect_ratio",
        "aspect ratio [-]",
        24.0,
        20.0,
        25.0,
        (14.0, 34.0),
        "not published; docs/structure.md",
    ),
    Unknown(
        "airframe.aerodynamics.lift_coefficient",
        "lift coefficient [-]",
        1.0,
        0.8,
        1.1,
        (0.6, 1.3),
        "typical of such wings: docs/structure.md",
    ),
    Unknown(
        "airframe.aerodynamics.profile_drag_coefficient",
        "profile drag [-]",
        0.01236,
        0.01,
        0.0145,
        (0.006, 0.03),
        "spread of airfoils at that Re; assumption",
    ),
    Unknown(
        "airframe.aerodynamics.parasitic_drag_coefficient",
        "parasitic drag [-]",
        0.005,
        0.003,
        0.008,
        (0.0, 0.02),
        _ASSUMED,
    ),
    Unknown(
        "airframe.propulsion.propeller_efficiency",
        "propeller [-]",
        0.83,
        0.75,
        0.87,
        (0.6, 0.95),
        _ASSUMED,
    ),
    Unknown(
        "airframe.propulsion.motor_efficiency", "motor [-]", 0.92, 0.85, 0.95, (0.7, 0.99), _ASSUMED
    ),
    Unknown(
        "airframe.structure.calibration",
        "structure [-]",
        1.188,
        1.0,
        1.4,
        (0.5, 2.5),
        "15 % to either side: docs/structure.md",
    ),
    Unknown(
        "modules.efficiency_stc",
        "modules [-]",
        0.257,
        0.235,
        0.323,
        (0.12, 0.4),
        "350 W/m2 less 8 % of mounting, to the record cell at AM0",
    ),
    Unknown(
        "modules.mass_kg_per_m2",
        "modules [kg/m2]",
        0.3,
        0.2,
        0.45,
        (0.1, 1.5),
        "a few hundred grams: MicroLink (2009)",
    ),
    Unknown(
        "modules.mppt_mass_kg_per_w",
        "MPPT [kg/W]",
        0.000915,
        0.00042,
        0.0015,
        (0.0002, 0.006),
        "small aircraft to MPPTs in housings: the aircraft's file",
    ),
    Unknown(
        "battery.specific_energy_wh_per_kg",
        "battery [Wh/kg]",
        435.0,
        348.0,
        435.0,
        (250.0, 600.0),
        "cells of 435, of 80 to 100 % of the pack: assumption",
    ),
)


@cache
def sized(key: str = "", value: float = 0.0) -> tuple[float, float, float]:
    """Wingspan [m], total mass and battery [kg] of least mass; infinite where nothing flies."""
    changed = {key: value} if key else {}
    flown = {
        name.removeprefix("mission."): one
        for name, one in (_MISSION | changed).items()
        if name.startswith("mission.")
    }
    craft = {name: one for name, one in changed.items() if not name.startswith("mission.")}
    aircraft = load_aircraft("stratosphere-design", craft)
    result = size_aircraft(
        aircraft, load_mission("stratosphere-mission", flown), Objective.min_mass, explain=False
    )
    if result.simulated is None:
        return (float("inf"),) * 3
    design = result.simulated.design
    variables = design.variables
    return (
        float(variables.wingspan_m),
        float(design.total_mass_kg),
        float(variables.battery_mass_kg),
    )


def zephyr_table() -> Table:
    """What each input makes of the span and the mass, and what it would have to be."""
    columns = (
        Column("input"),
        Column("used", to_right=True),
        Column("known", "known range"),
        Column("at_low", "wingspan and mass at its lower end"),
        Column("at_high", "at its upper end"),
        Column("needed", "for 75 kg", to_right=True),
        Column("within"),
        Column("source"),
    )
    rows = []
    for one in _UNKNOWN:
        needed = nearest_root(partial(_beyond, one.key), one.used, one.search)
        within = needed is not None and one.low <= needed <= one.high
        rows.append(
            (
                *(one.label, _digits(one.used), f"{one.low:g} to {one.high:g}"),
                *(_words(*sized(one.key, end)) for end in (one.low, one.high)),
                *(
                    "none" if needed is None else _digits(needed),
                    "yes" if within else "no",
                    one.source,
                ),
            )
        )
    return Table("", columns, tuple(rows), (f"as it is: {_words(*sized())}",))


def _digits(value: float) -> str:
    """Number of four digits, without powers of ten."""
    return f"{float(f'{value:.4g}'):g}"


def _beyond(key: str, value: float) -> float:
    """Mass beyond the published one [kg]; much where nothing flies."""
    return min(sized(key, value)[1], 1e4) - PUBLISHED_MASS_KG


def _words(span_m: float, mass_kg: float, battery_kg: float) -> str:
    if mass_kg == float("inf"):
        return "does not fly"
    return f"{span_m:.1f} m, {mass_kg:.0f} kg, battery {battery_kg:.0f} kg"
