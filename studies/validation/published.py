"""Published numbers beside computed ones: what the software must meet, and does or does not."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.performance import performance, perpetual_days
from sizing.replay import calendar_run
from sizing.sunlight import SolarModel
from solar.modules import SolarCell
from solar.names import CORRECTION_NAMES, ModelName
from solar.power import horizontal_specific_power
from studies.validation.known_structures import SKY_SAILOR as SKY_SAILOR_CASE
from studies.validation.known_structures import calibrated_rib_wing

REPORT = "Oettershagen, solar power models, table 3"
FLIGHT_81H = "AtlantikSolar AS-2, 81 h flight, July 2015"
FLIGHT_28H = "AtlantikSolar AS-2, 28 h flight, 30 June 2015"
AIRFRAME = "AtlantikSolar AS-2, as built"
SKY_SAILOR = "Sky-Sailor, Noth 2008"

# Conditions of the report's comparison: 1 July, solar time 4.17 to 9.72 h, 47.6 N.
_WINDOW_H = (4.17, 9.72)
_WINDOW_NOON_DAY = 182.5
_WINDOW_TEMPERATURE_C = 22.7


@dataclass(frozen=True)
class Comparison:
    """A published and a computed number; ``allowed`` is the largest accepted difference."""

    quantity: str
    source: str
    unit: str
    published: float
    computed: float
    allowed: float

    @property
    def difference(self) -> float:
        """Computed minus published."""
        return self.computed - self.published

    @property
    def met(self) -> bool:
        """Whether the difference is within what is allowed."""
        return abs(self.difference) <= self.allowed

    def record(self) -> dict[str, Any]:
        """All of it, JSON-ready."""
        return asdict(self) | {"difference": self.difference, "met": self.met}


def comparisons() -> list[Comparison]:
    """Every published number that the software is held against."""
    return [
        *_window_means(),
        *_flight_81h(),
        *_season(),
        *_flight_28h(),
        *_parametric_atlantiksolar(),
        *_sky_sailor(),
        *_rib_wing_of_sky_sailor(),
    ]


def window_mean_w(model: ModelName, *, corrected: bool) -> float:
    """Mean power of AS-2's modules over the report's window, horizontal models [W]."""
    time_h = np.linspace(*_WINDOW_H, 2001)
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
    return float(1.35 * np.trapezoid(power, time_h) / (time_h[-1] - time_h[0]))


def _window_means() -> list[Comparison]:
    published = {"CDM": 117.35, "CAM": 104.89}
    models: tuple[ModelName, ...] = ("CDM", "CAM")
    rows = [
        Comparison(
            f"mean power of {m}, solar time 4.17 to 9.72 h",
            REPORT,
            "W",
            published[m],
            window_mean_w(m, corrected=False),
            0.015 * published[m],
        )
        for m in models
    ]
    rows += [
        Comparison(
            f"mean power of {m}, corrected, against the flight",
            REPORT,
            "W",
            99.61,
            window_mean_w(m, corrected=True),
            0.02 * 99.61,
        )
        for m in models
    ]
    return rows


def _flight_81h() -> list[Comparison]:
    aircraft = load_aircraft("atlantiksolar-as2")
    cycle = performance(aircraft, load_mission("rafz-july")).cycle
    return [
        Comparison(
            "minimum state of charge",
            FLIGHT_81H,
            "%",
            39.0,
            100.0 * float(cycle.minimum_state_of_charge[0]),
            3.0,
        ),
        Comparison("excess time", FLIGHT_81H, "h", 6.8, float(cycle.excess_time_h[0]), 0.6),
        Comparison("charge margin", FLIGHT_81H, "h", 6.2, float(cycle.charge_margin_h[0]), 0.5),
    ]


def _season() -> list[Comparison]:
    aircraft = load_aircraft("atlantiksolar-as2")
    mission = load_mission("rafz-july")
    rows = []
    for correction in CORRECTION_NAMES:
        days = perpetual_days(aircraft, mission, 47.6, SolarModel("CAM", correction))
        rows.append(
            Comparison(
                f"perpetual season at 47.6 N, CAM, correction {correction}",
                "AtlantikSolar: a 6-month window around 21 June",
                "months",
                6.0,
                len(days) / (365.0 / 12.0),
                1.25,
            )
        )
    return rows


def _flight_28h() -> list[Comparison]:
    aircraft = load_aircraft("atlantiksolar-as2")
    flight = calendar_run(aircraft, load_mission("rafz-28h"))
    return [
        Comparison(
            "full charge on the first day (CEST)",
            FLIGHT_28H,
            "h",
            14.0 + 8.0 / 60.0,
            flight.full_charge_clock_h[0],
            40.0 / 60.0,
        ),
        Comparison(
            "minimum state of charge",
            FLIGHT_28H,
            "%",
            35.0,
            100.0 * flight.minimum_state_of_charge,
            6.0,
        ),
    ]


def _parametric_atlantiksolar() -> list[Comparison]:
    aircraft = load_aircraft("atlantiksolar-design")
    design = performance(aircraft, load_mission("rafz-july")).design
    return [
        Comparison("total mass, parametric", AIRFRAME, "kg", 6.92, design.total_mass_kg, 0.02),
        Comparison("structure, parametric", AIRFRAME, "kg", 1.35, design.masses.structure, 0.05),
        Comparison(
            "electric power of level flight, parametric, 1.09 kg/m3",
            AIRFRAME,
            "W",
            35.8 * (1.10 / 1.0877) ** 0.5,
            design.propulsion_power_w,
            0.36,
        ),
    ]


def _sky_sailor() -> list[Comparison]:
    aircraft = load_aircraft("sky-sailor")
    mission = load_mission("rafz-july")
    design = performance(aircraft, mission).design
    return [
        Comparison("total mass, parametric", SKY_SAILOR, "kg", 2.44, design.total_mass_kg, 0.2),
        Comparison(
            "electric power of level flight, all consumers",
            SKY_SAILOR,
            "W",
            16.0,
            design.nominal_load_w(mission),
            2.0,
        ),
    ]


def _rib_wing_of_sky_sailor() -> list[Comparison]:
    computed_kg = float(SKY_SAILOR_CASE.mass_kg(calibrated_rib_wing()))
    return [
        Comparison(
            "structure, rib wing calibrated on AtlantikSolar",
            SKY_SAILOR,
            "kg",
            SKY_SAILOR_CASE.built_kg,
            computed_kg,
            0.15,
        )
    ]


def markdown(rows: list[Comparison]) -> str:
    """Table of the comparisons in Markdown."""
    lines = [
        "| quantity | source | unit | published | computed | difference | allowed | met |",
        "|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {r.quantity} | {r.source} | {r.unit} | {r.published:.4g} | {r.computed:.4g} "
        f"| {r.difference:+.2g} | {r.allowed:.2g} | {'yes' if r.met else 'no'} |"
        for r in rows
    ]
    return "\n".join(lines) + "\n"
