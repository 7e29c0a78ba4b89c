"""Wild sizing problems, each drawn from a seed: polar days and nights, huge and tiny design spaces.

Much wilder than :mod:`benchmarks.random_missions`. What is drawn need not be sensible; it must be
what the files allow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from missions.files.overrides import with_values
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.library import load_aircraft
from sizing.program.objectives import SINGLE_OBJECTIVES, Objective

_RANGES = [o for o in Objective if o.of_range]
_RANGE_SHARE, _EDGE_SHARE = 0.06, 0.12
_AIRFOILS = ("sd7037", "mh114", "e214")


@dataclass(frozen=True)
class WildProblem:
    """A sizing problem; ``edge`` problems require what the largest excess time nearly reaches."""

    seed: int
    aircraft: Aircraft
    mission: Mission
    objective: Objective
    required_h: float
    solar: SolarModel
    tags: tuple[str, ...]

    @property
    def edge(self) -> bool:
        """Whether the required excess time is still to be set to the edge of what is possible."""
        return "edge" in self.tags

    def requiring(self, required_h: float) -> WildProblem:
        """Same problem with another required excess time [h]."""
        return replace(self, required_h=required_h)


def wild_problem(seed: int, number: int, *, climb: bool = False) -> WildProblem:
    """Draw one problem.

    Parameters
    ----------
    seed, number : int
        Of the whole series, and of the problem in it.
    climb : bool
        Let the aircraft climb by day; without the objectives that are ranges, whose search by
        simulation takes hours then.

    Returns
    -------
    WildProblem
    """
    rng = np.random.default_rng([seed, number])
    draw = _Draw(rng)
    scale = draw.choice({"as it is": 0.4, "small": 0.1, "large": 0.25, "giant": 0.25})
    name = draw.choice({"atlantiksolar-design": 0.6, "sky-sailor": 0.4})
    tags = [name, f"scale: {scale}"]
    aircraft, own = _aircraft(draw, load_aircraft(name), scale)
    tags += own
    mission, own = _mission(draw, scale)
    tags += own
    objective = draw.one_of(_RANGES if draw.chance(_RANGE_SHARE) else SINGLE_OBJECTIVES)
    edge = not objective.of_range and draw.chance(_EDGE_SHARE)
    if edge:
        objective = draw.one_of([o for o in SINGLE_OBJECTIVES if o.of_design])
        tags.append("edge")
    required_h = draw.choice({0.0: 0.2, 1.0: 0.15, 4.0: 0.15, 8.0: 0.1, -1.0: 0.3, 60.0: 0.1})
    if required_h < 0.0:
        required_h = round(draw.between(0.0, 24.0), 2)
    elif required_h == 60.0:
        required_h = round(draw.between(24.0, 60.0), 1)
    solar = _solar(draw, aircraft, mission)
    tags.append(f"{solar.model} {solar.correction}")
    if climb:
        mission, own = _climbing(draw, mission)
        tags += own
        if objective.of_range:
            objective = draw.one_of(SINGLE_OBJECTIVES)
    return WildProblem(number, aircraft, mission, objective, required_h, solar, tuple(tags))


class _Draw:
    """Random choices of a problem."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def one_of(self, things: Any) -> Any:
        return things[int(self.rng.integers(len(things)))]

    def choice(self, shares: dict[Any, float]) -> Any:
        weights = np.cumsum(list(shares.values()))
        place = int(np.searchsorted(weights / weights[-1], self.rng.random(), side="right"))
        return list(shares)[min(place, len(shares) - 1)]

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def log_between(self, low: float, high: float) -> float:
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def span_of(self, centre: float, factor: float) -> dict[str, float]:
        """Range around a value, from a few per cent to the factor on either side."""
        return {
            "minimum": centre / self.log_between(1.005, factor),
            "maximum": centre * self.log_between(1.005, factor),
        }


# --- aircraft ---------------------------------------------------------------------------------


def _aircraft(draw: _Draw, base: Aircraft, scale: str) -> tuple[Aircraft, list[str]]:
    data = base.model_dump(by_alias=True, exclude_none=True)
    tags = _technology(draw, data, scale)
    space, own = _design_space(draw, data, scale)
    data["design_space"] = space
    return Aircraft.model_validate(data), tags + own


def _technology(draw: _Draw, data: dict[str, Any], scale: str) -> list[str]:
    """Replace technology in place."""
    tags = []
    airframe, battery = data["airframe"], data["battery"]
    battery["specific_energy_wh_per_kg"] = draw.log_between(200.0, 600.0)
    data["modules"]["efficiency_stc"] = draw.between(0.17, 0.34)
    if draw.chance(0.3):
        battery["charge_efficiency"] = draw.between(0.85, 1.0)
        battery["discharge_efficiency"] = draw.between(0.85, 1.0)
    limit = draw.choice({"own": 0.5, "none": 0.2, "slow": 0.15, "fast": 0.15})
    if limit == "none":
        battery["charge_limit"] = {"kind": "none"}
    elif limit != "own":
        rate = draw.between(0.06, 0.3) if limit == "slow" else draw.between(0.5, 2.0)
        taper = draw.between(0.5, 0.97)
        battery["charge_limit"] = {"kind": "rule", "c_rate_per_h": rate, "taper_start": taper}
    if limit == "slow":
        tags.append("slow charger")
    data["power"]["avionics_w"] = draw.choice({0.0: 0.2, draw.between(0.5, 12.0): 0.8})
    if data["power"]["avionics_w"] == 0.0:
        tags.append("no avionics")
    for key in ("avionics_mass_kg", "other_mass_kg"):
        airframe[key] = draw.choice({0.0: 0.15, airframe[key]: 0.6, draw.between(0.0, 3.0): 0.25})
    if draw.chance(0.2):
        airframe["maximum_module_coverage"] = draw.between(0.4, 1.0)
    if draw.chance(0.3):
        airframe["distributed_battery_fraction"] = draw.one_of([0.0, 0.5, 1.0])
    if draw.chance(0.15):
        airframe["propulsion"].pop("climb_power_ratio", None)
        airframe["propulsion"]["climb_rate_m_per_s"] = draw.between(0.2, 3.0)
        tags.append("climb rate")
    if scale in ("large", "giant") or draw.chance(0.2):
        # Sky-Sailor's law of mass is far too heavy beyond a few metres.
        airframe["structure"] = draw.choice({"rib_wing": 0.6, "spar": 0.4})
        tags.append(airframe["structure"])
        airframe["structure"] = {
            "model": airframe["structure"],
            "calibration": draw.between(0.6, 1.2),
        }
    if draw.chance(0.12):
        airframe["aerodynamics"] = {
            "model": "wing_polar",
            "airfoil": draw.one_of(_AIRFOILS),
            "design_aspect_ratio": airframe["aspect_ratio"],
            "design_reynolds": draw.log_between(1.2e5, 4e5),
        }
        tags.append("wing polar")
    return tags


def _design_space(
    draw: _Draw, data: dict[str, Any], scale: str
) -> tuple[dict[str, Any], list[str]]:
    airframe = data["airframe"]
    grown = {
        "as it is": 1.0,
        "small": draw.between(0.4, 0.9),
        "large": draw.log_between(1.2, 3.0),
        "giant": draw.log_between(3.0, 10.0),
    }[scale]
    centre = {
        "wingspan_m": airframe["wingspan_m"] * grown,
        "battery_mass_kg": data["battery"]["mass_kg"] * grown**2.2,
        "module_area_m2": data["modules"]["area_m2"] * grown**2,
    }
    airframe["wingspan_m"] = centre["wingspan_m"]
    data["battery"]["mass_kg"] = centre["battery_mass_kg"]
    data["modules"]["area_m2"] = centre["module_area_m2"]
    data["modules"].pop("tail", None)
    width = draw.choice({"wide": 0.35, "usual": 0.35, "narrow": 0.2, "as the file": 0.1})
    tags = [f"{width} space"]
    space: dict[str, Any]
    if width == "wide":
        space = {
            "wingspan_m": {"minimum": draw.log_between(0.3, 3.0), "maximum": 80.0},
            "battery_mass_kg": {"minimum": draw.log_between(0.001, 0.3), "maximum": 500.0},
            "module_area_m2": {"minimum": draw.log_between(0.001, 0.1), "maximum": 300.0},
        }
    elif width == "as the file" and scale == "as it is":
        own = data["design_space"]
        space = {key: own[key] for key in centre}
    else:
        factor = 1.06 if width == "narrow" else 6.0
        space = {key: draw.span_of(value, factor) for key, value in centre.items()}
    factor = 1.06 if width == "narrow" else 2.2
    if draw.chance(0.4):
        space["aspect_ratio"] = draw.span_of(airframe["aspect_ratio"], factor)
        tags.append("free aspect ratio")
    polar = airframe["aerodynamics"]
    if draw.chance(0.4):
        highest = 1.0 if polar["model"] == "wing_polar" else polar["maximum_lift_coefficient"]
        lift = draw.between(0.4, 0.9) * highest
        ends = draw.span_of(lift, min(factor, 1.8))
        ends["maximum"] = min(ends["maximum"], 0.99 * highest)
        space["lift_coefficient"] = ends
        tags.append("free lift coefficient")
    tags += _limits(draw, space, centre)
    return space, tags


def _limits(draw: _Draw, space: dict[str, Any], centre: dict[str, float]) -> list[str]:
    """Add a few limits to the design space; their names."""
    limits: dict[str, dict[str, float]] = {}
    chord_m = centre["wingspan_m"] / 16.0
    candidates = {
        "total_mass_kg": {"maximum": centre["battery_mass_kg"] * draw.between(2.0, 6.0)},
        "wing_loading_kg_per_m2": {"maximum": draw.between(2.5, 12.0)},
        "airspeed_m_per_s": {"minimum": draw.between(6.0, 11.0)},
        "chord_m": {"minimum": 0.7 * chord_m, "maximum": 2.0 * chord_m},
        "module_coverage": {"minimum": draw.between(0.05, 0.4)},
        "battery_fraction": {"maximum": draw.between(0.35, 0.6)},
        "stall_margin": {"minimum": draw.between(1.05, 1.3)},
        "climb_rate_m_per_s": {"minimum": draw.between(0.1, 1.5)},
        "cruise_discharge_rate_per_h": {"maximum": draw.between(0.04, 0.2)},
        "wing_area_m2": {"maximum": (centre["wingspan_m"] * chord_m) * draw.between(0.8, 2.5)},
    }
    for name, limit in candidates.items():
        if draw.chance(0.05):
            limits[name] = limit
    if limits:
        space["limits"] = limits
    return [f"limit: {name}" for name in limits]


# --- missions ---------------------------------------------------------------------------------


def _mission(draw: _Draw, scale: str) -> tuple[Mission, list[str]]:
    where = draw.choice({"polar": 0.3, "band": 0.15, "single": 0.45, "far apart": 0.1})
    latitude, dates, tags = _place_and_season(draw, where)
    heavy = {"small": 0.1, "as it is": 0.5, "large": 2.0, "giant": 15.0}[scale]
    data: dict[str, Any] = {
        "name": "wild",
        "latitude_deg": latitude,
        "dates": dates,
        "altitude_m": draw.choice(
            {0.0: 0.2, draw.between(0.0, 4000.0): 0.4, draw.between(4000.0, 18000.0): 0.4}
        ),
        "clearness": draw.choice({1.0: 0.4, draw.between(0.5, 1.0): 0.6}),
        "turbulence": {
            "all_day": draw.choice({0.0: 0.5, draw.between(0.0, 0.8): 0.5}),
            "thermal": draw.choice(
                {0.0: 0.5, draw.between(0.0, 0.5): 0.3, draw.between(0, 3): 0.2}
            ),
        },
        "payload": {
            "mass_kg": draw.choice({0.0: 0.4, draw.between(0.0, heavy): 0.6}),
            "power_w": draw.choice({0.0: 0.4, 10.0 * draw.between(0.0, heavy): 0.6}),
        },
        "wind_m_per_s": draw.choice(
            {0.0: 0.5, draw.between(0.0, 9.0): 0.35, draw.between(5, 25): 0.15}
        ),
        "uncertainty_margins": {
            "solar_model_sigmas": draw.choice({0.0: 0.6, draw.between(0.0, 2.0): 0.4}),
            "battery_capacity": draw.choice({1.0: 0.6, draw.between(0.5, 1.0): 0.4}),
        },
    }
    if draw.chance(0.4):
        data["air"] = {"temperature_offset_k": draw.between(-40.0, 40.0)}
    if draw.chance(0.4):
        # Attitude models and the loiter correction; slower wind than the path's airspeed.
        data["wind_m_per_s"] = min(data["wind_m_per_s"], 7.0)
        data["flight_path"] = {
            "kind": "circle",
            "radius_m": draw.between(50.0, 400.0),
            "airspeed_m_per_s": draw.between(8.0, 16.0),
        }
    for name in ("altitude_m", "wind_m_per_s"):
        data[name] = float(data[name])
    if data["altitude_m"] > 10000.0:
        tags.append("high")
    if data["turbulence"]["thermal"] > 0.0:
        tags.append("strong thermals" if data["turbulence"]["thermal"] > 0.5 else "thermals")
    if data["wind_m_per_s"] > 0.0:
        tags.append("wind")
    return Mission.model_validate(data), tags


def _climbing(draw: _Draw, mission: Mission) -> tuple[Mission, list[str]]:
    """Mission on which the aircraft climbs, anything from next to nothing to 25 km."""
    draw.one_of(["battery_full", "surplus"])  # what follows stays as it was drawn
    highest = min(mission.altitude_m + draw.log_between(100.0, 25000.0), 30000.0)
    climb = {"ceiling_m": highest}
    return with_values(mission, {"climb": climb}), ["climb"]


def _place_and_season(draw: _Draw, where: str) -> tuple[Any, dict[str, Any], list[str]]:
    """Latitudes and dates that go with them half the time, and what they are called."""
    sign = draw.one_of([1.0, -1.0])
    if where == "polar":
        low = draw.between(58.0, 84.0)
        high = min(low + draw.between(0.5, 15.0), 90.0)
    elif where == "far apart":
        low, high = draw.between(-60.0, 0.0), draw.between(5.0, 80.0)
    else:
        low = draw.between(-10.0, 62.0)
        high = low + draw.between(0.5, 10.0)
    ends = sorted((sign * low, sign * high))
    ranged = {"from_deg": ends[0], "to_deg": ends[1], "count": draw.one_of([2, 3, 4])}
    latitude = ends[0] if where == "single" or draw.chance(0.4) else ranged
    # Day of the year near the summer solstice of the hemisphere, or any.
    summer = 172.0 if sign > 0.0 else 355.0
    season = draw.choice({"summer": 0.6, "any": 0.4})
    middle = (
        summer + 45.0 * float(draw.rng.normal()) if season == "summer" else draw.between(1, 366)
    )
    length = draw.choice({0: 0.45, draw.log_between(2.0, 120.0): 0.45, draw.between(120, 365): 0.1})
    first, last = (_date(middle + sign * length / 2.0) for sign in (-1.0, 1.0))
    dates: dict[str, Any] = {"on": first} if length == 0 else {"from": first, "to": last}
    if length and draw.chance(0.3):
        dates["count"] = draw.one_of([2, 4, 5])
    return latitude, dates, [where, season]


def _date(day: float) -> str:
    from missions.dates import date_code

    return date_code(int(day - 1.0) % 365 + 1)


def _solar(draw: _Draw, aircraft: Aircraft, mission: Mission) -> SolarModel:
    """Model and correction that the aircraft and the mission allow."""
    path = mission.flight_path is not None
    geometry = path and aircraft.modules.geometry is not None
    if geometry and draw.chance(0.5):
        return SolarModel(draw.one_of(["VM", "FM"]), draw.one_of(["none", "report"]))
    corrections = ["none", "none", "report"] + (["loiter"] if geometry else [])
    return SolarModel(draw.one_of(["CAM", "CAM", "CDM"]), draw.one_of(corrections))
