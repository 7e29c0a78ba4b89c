"""Published numbers beside computed ones: what the software must meet, and does or does not."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.performance import performance, perpetual_days
from sizing.results.tables import Column, Line, Result, Summary, Table
from sizing.sunlight import SolarModel
from solar.horizontal_models import horizontal_specific_power
from solar.modules import SolarCell
from solar.names import CORRECTION_NAMES, ModelName
from studies.validation.built_aircraft import ATLANTIKSOLAR, SKY_SAILOR, calibrated_rib_wing
from studies.validation.flights.published_flights import FLIGHTS, Flight
from studies.validation.report_reproduction import MEASURED_W, PERIOD_H, PUBLISHED_W

if TYPE_CHECKING:
    import pandas as pd

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


_NUMBERS = (
    Column("published", form=".4g"),
    Column("computed", form=".4g"),
    Column("difference", form="+.2g"),
    Column("allowed", form=".2g"),
    Column("met"),
)


@dataclass(frozen=True, repr=False)
class Published(Result):
    """Every published number that the software is held against."""

    numbers: tuple[Number, ...]

    @property
    def met(self) -> bool:
        """Whether all differences are within what is allowed, but for the known misses."""
        return all(number.met or number.known_miss for number in self.numbers)

    def headline(self) -> str:
        """How many numbers are met, and how many are known not to be."""
        met = sum(number.met for number in self.numbers)
        known = sum(number.known_miss and not number.met for number in self.numbers)
        missed = f", {known} known misses: published --explain" if known else ""
        return f"{met} of {len(self.numbers)} published numbers are met{missed}"

    def summary(self) -> Summary:
        """Headline, and a table for each source."""
        tables = [
            Table(
                source,
                (Column("quantity"), *_NUMBERS),
                tuple((f"{n.quantity} [{n.unit}]", *_published_values(n)) for n in numbers),
            )
            for source, numbers in itertools.groupby(self.numbers, lambda n: n.source)
        ]
        return Summary((Line(self.headline(), "strong"), *tables))

    def table(self) -> Table:
        """All numbers."""
        columns = (Column("quantity"), Column("source"), Column("unit"), *_NUMBERS)
        rows = tuple((n.quantity, n.source, n.unit, *_published_values(n)) for n in self.numbers)
        return Table("published and computed", columns, rows)

    def to_dict(self) -> list[dict[str, Any]]:
        """All numbers, JSON-ready."""
        return [asdict(n) | {"difference": n.difference, "met": n.met} for n in self.numbers]

    def to_frame(self) -> pd.DataFrame:
        """One row for each number."""
        return self.table().to_frame()


def _published_values(number: Number) -> tuple[float | bool | str, ...]:
    met = "no, known" if number.known_miss and not number.met else number.met
    return number.published, number.computed, number.difference, number.allowed, met


def published(progress: Callable[[int, int], None] | None = None) -> Published:
    """Compute every published number that the software is held against.

    ``progress``: called with the number of sources that are done and the number there are.
    """
    flights = (flight for key, flight in FLIGHTS.items() if key != "as2-season")
    sources: list[Callable[[], Iterable[Number]]] = [
        _window_means,
        *(partial(_numbers_of_flight, flight) for flight in flights),
        _season,
        _parametric_atlantiksolar,
        _sky_sailor,
    ]
    numbers: list[Number] = []
    for done, source in enumerate(sources, start=1):
        numbers += source()
        if progress is not None:
            progress(done, len(sources))
    return Published(tuple(numbers))


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
