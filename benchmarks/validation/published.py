"""Published numbers beside computed ones: what the software must meet, and does or does not."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.validation.built_aircraft import ATLANTIKSOLAR, SKY_SAILOR, calibrated_rib_wing
from benchmarks.validation.published_flights import FLIGHTS, Flight
from missions.library import load_mission
from sizing.day.light import SolarModel
from sizing.library import load_aircraft
from sizing.performance import performance, perpetual_days
from solar.horizontal_models import horizontal_specific_power
from solar.modules import SolarCell
from solar.names import CORRECTION_NAMES, ModelName
from studies.models.report_reproduction import MEASURED_W, PERIOD_H, PUBLISHED_W
from studies.render.tables import Column, Table

REPORT = "Oettershagen, solar power models, table 3"
AIRFRAME = "AtlantikSolar AS-2, as built"
NOTH = "Sky-Sailor, Noth 2008"

# Conditions of the report's comparison: 1 July, solar time 4.17 to 9.72 h, 47.6 N.
_WINDOW_NOON_DAY = 182.5
_WINDOW_TEMPERATURE_C = 22.7


@dataclass(frozen=True)
class Number:
    """A published and a computed number; ``allowed`` is the largest accepted difference.

    A ``known_miss`` is farther off, and the documentation discusses it.
    """

    quantity: str
    source: str
    unit: str
    published: float
    computed: float
    allowed: float
    known_miss: bool = False

    @property
    def difference(self) -> float:
        """Computed minus published."""
        return self.computed - self.published

    @property
    def met(self) -> bool:
        """Whether the difference is within what is allowed."""
        return abs(self.difference) <= self.allowed


def published_table() -> Table:
    """All numbers with their sources, as the page on validation shows them."""
    columns = (
        *map(Column, ("quantity", "source", "unit")),
        Column("published", form=".4g"),
        Column("computed", form=".4g"),
        Column("difference", form="+.2g"),
        Column("allowed", form=".2g"),
        Column("met"),
    )
    return Table("published and computed", columns, tuple(map(_row, published())))


def _row(number: Number) -> tuple[float | bool | str, ...]:
    n = number
    met = "no, known" if n.known_miss and not n.met else n.met
    return n.quantity, n.source, n.unit, n.published, n.computed, n.difference, n.allowed, met


def published() -> tuple[Number, ...]:
    """Compute every published number that the software is held against."""
    flights = (flight for key, flight in FLIGHTS.items() if key != "as2-season")
    return (
        *_window_means(),
        *itertools.chain.from_iterable(map(_numbers_of_flight, flights)),
        *_season(),
        *_parametric_atlantiksolar(),
        *_sky_sailor(),
    )


def window_mean_w(model: ModelName, *, corrected: bool) -> float:
    """Mean power of AS-2's modules over the report's window."""
    time_h = np.linspace(*PERIOD_H, 2001)
    power = horizontal_specific_power(
        47.6,
        _WINDOW_NOON_DAY,
        time_h,
        cell=SolarCell(),
        module_temperature_c=_WINDOW_TEMPERATURE_C,
        altitude_m=536.0,
        model=model,
        correct="report" if corrected else "none",
    )
    return float(
        ATLANTIKSOLAR.module_area_m2 * np.trapezoid(power, time_h) / (time_h[-1] - time_h[0])
    )


def _window_means() -> Iterator[Number]:
    models: tuple[ModelName, ...] = ("CDM", "CAM")
    for model in models:
        name, mean_w = f"mean power of {model}, solar time 4.17 to 9.72 h", PUBLISHED_W[model]
        computed_w = window_mean_w(model, corrected=False)
        yield Number(name, REPORT, "W", mean_w, computed_w, 0.015 * mean_w)
    for model in models:
        name = f"mean power of {model}, corrected, against the flight"
        computed_w = window_mean_w(model, corrected=True)
        yield Number(name, REPORT, "W", MEASURED_W, computed_w, 0.02 * MEASURED_W)


def _numbers_of_flight(flight: Flight) -> Iterator[Number]:
    trial = flight.trial()
    for q in flight.quantities:
        computed = q.compute(trial)
        yield Number(
            q.name, flight.name, q.unit, q.published, computed, q.allowed, known_miss=q.known_miss
        )


def _season() -> Iterator[Number]:
    aircraft, mission = load_aircraft("atlantiksolar-as2"), load_mission("rafz-july")
    source = "AtlantikSolar: a 6-month window around 21 June"
    for correction in CORRECTION_NAMES:
        solar = SolarModel("CAM", correction)
        name = f"perpetual season at 47.6° N, {solar.label}"
        days = perpetual_days(aircraft, mission, 47.6, solar)
        yield Number(name, source, "months", 6.0, len(days) / (365.0 / 12.0), 1.25)


def _parametric_atlantiksolar() -> Iterator[Number]:
    built = ATLANTIKSOLAR
    mission = load_mission("rafz-july")
    design = performance(load_aircraft("atlantiksolar-design"), mission).design
    mass, structure = float(design.total_mass_kg), float(design.masses.structure)
    yield Number("total mass, parametric", AIRFRAME, "kg", built.size[-1], mass, 0.02)
    yield Number("structure, parametric", AIRFRAME, "kg", built.built_kg, structure, 0.05)
    name = "electric power of level flight, parametric, 1.09 kg/m3"
    power_w = built.level_flight_w * (built.density_kg_per_m3 / 1.0877) ** 0.5
    yield Number(name, AIRFRAME, "W", power_w, design.propulsion_power_w, 0.36)


def _sky_sailor() -> Iterator[Number]:
    built, mission = SKY_SAILOR, load_mission("rafz-july")
    design = performance(load_aircraft("sky-sailor"), mission).design
    mass, load_w = float(design.total_mass_kg), float(design.nominal_load_w(mission))
    yield Number("total mass, parametric", NOTH, "kg", built.size[-1], mass, 0.2)
    name = "electric power of level flight, all consumers"
    yield Number(name, NOTH, "W", built.level_flight_w, load_w, 2.0)
    name = "structure, rib wing calibrated on AtlantikSolar"
    computed_kg = float(built.mass_kg(calibrated_rib_wing()))
    yield Number(name, NOTH, "kg", built.built_kg, computed_kg, 0.15)
