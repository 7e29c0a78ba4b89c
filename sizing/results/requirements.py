"""How far a design is from every requirement on it, in one table, and requirements in words.

Results name requirements, bounds and parameters in JSON by what the program calls them; people read
them here, with the key of the file that changes them. Besides what is demanded, two margins that a
design office looks at: airspeed over stall speed, and climb at the highest altitude and with an
empty battery.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.data_rows import data_rows
from sizing.design import Design, bus_voltage_v
from sizing.design_space import DesignSpace
from sizing.limits import QUANTITIES, DesignInFlight
from sizing.mass_budget import parametric_design
from sizing.parameters import catalogue, label, unit, unit_text
from sizing.performance import Performance
from sizing.results.quantities import EXCESS_TIME, MINIMUM_CHARGE


@cache
def requirements() -> Mapping[str, Mapping[str, str]]:
    """Words, key and reason of every requirement with a name of its own."""
    rows = data_rows("requirements")
    return MappingProxyType({row["name"]: MappingProxyType(row) for row in rows})


_ENDS = ("maximum", "minimum")


class Words(NamedTuple):
    """A constraint for people: what, in which scenario, and the key that changes it."""

    label: str
    where: str = ""
    key: str = ""

    @property
    def without_key(self) -> str:
        """What limits, and where."""
        return f"{self.label} at {self.where}" if self.where else self.label

    def __str__(self) -> str:
        return f"{self.without_key} ({self.key})" if self.key else self.without_key


def constraint_words(name: str, aircraft: Aircraft | None = None) -> Words:
    """Words for a requirement or bound as results name it.

    ``name``: such as ``excess_time (45° N, 15 Aug)``, ``stall_margin_minimum``, ``wingspan_m at its
    maximum`` or ``wingspan_m at its bound``. ``aircraft``: whose design space has the keys of
    limits; without it they are those under ``limits``. Returns the name itself where nothing is
    known of it.
    """
    bounded, at_its, end = name.partition(" at its ")
    if at_its:
        largest, fields = f"maximum_{bounded}", DesignSpace.model_fields
        key = f"{bounded}.{end}" if end in _ENDS else bounded
        key = largest if largest in fields else key
        known = bounded in fields or largest in fields
        return Words(f"{label(bounded)} at its {end}", "", f"design_space.{key}" if known else "")
    plain, _, rest = name.partition(" (")
    where = rest.removesuffix(")")
    named = requirements().get(plain)
    if named is not None and named["words"]:
        return Words(named["words"], where, named["key"])
    quantity, _, end = plain.rpartition("_")
    if end in _ENDS and quantity in catalogue():
        key = f"limits.{quantity}.{end}"
        if aircraft is not None and (row := aircraft.design_space.limit_rows().get(plain)):
            key = row.key
        return Words(f"{label(quantity)} at its {end}", where, f"design_space.{key}")
    return Words(plain, where)


def parameter_words(key: str) -> str:
    """Label of a parameter by its key, limits of the design space included.

    ``key``: of the aircraft's or, behind ``mission.``, of the mission's file. Returns the key
    itself where the catalogue has no label.
    """
    if key in catalogue():
        return label(key)
    last = key.removeprefix("design_space.").removeprefix("limits.")
    for end, word in zip(_ENDS, ("largest", "least"), strict=True):
        quantity = last.removesuffix(f".{end}").removeprefix(f"{end}_")
        if quantity != last and quantity in catalogue():
            return f"{word} {label(quantity)}"
    return key


# Take-off safety speed over stall speed, CS-23.51 and 14 CFR 23.51 (amendment 62).
RECOMMENDED_STALL_MARGIN = 1.2
# Thrusts over that of level flight in which the largest is searched for.
_THRUSTS, _COARSE = np.geomspace(1.0, 30.0, 241), 16


class RequirementMargin(NamedTuple):
    """A requirement: value, limit, and by how much it is met.

    ``margin`` is relative to the limit, in the unit where ``relative`` is false; below 0 where the
    requirement is missed. ``recommended``: nobody demands it.
    """

    name: str
    label: str
    value: float
    limit: float
    unit: str
    margin: float
    relative: bool = True
    recommended: bool = False

    @property
    def value_text(self) -> str:
        """Value with its unit."""
        if not np.isfinite(self.value):
            return _unlimited_or_none(self.value)
        return f"{round(self.value, 3):.4g} {self.unit}".strip()

    @property
    def text(self) -> str:
        """Margin in words."""
        if not np.isfinite(self.margin):
            return _unlimited_or_none(self.margin)
        if self.relative:
            return f"{100.0 * self.margin:+.1f} %"
        return f"{self.margin:+.2f} {self.unit}".strip()


def requirement_margins(
    aircraft: Aircraft, flown: Performance, required_h: float
) -> list[RequirementMargin]:
    """Margins of a single design that has been flown.

    ``aircraft``: with the technology of the design. ``required_h``: excess time that is required of
    every scenario [h].
    """
    mission, design, worst = flown.mission, flown.design, flown.worst_scenario()
    excess_h, charge = (
        float(np.asarray(one.of(flown))[worst]) for one in (EXCESS_TIME, MINIMUM_CHARGE)
    )
    where = f", {flown.day.scenarios.label(worst)}"
    found = [
        _absolute(EXCESS_TIME.name, f"{EXCESS_TIME.label}{where}", excess_h, required_h, "h"),
        _absolute(
            *(MINIMUM_CHARGE.name, f"{MINIMUM_CHARGE.label}{where}"), 100.0 * charge, 0.0, "%"
        ),
    ]
    winds = mission.wind_to_beat_m_per_s(mission.scenario_winds_m_per_s(flown.day.scenarios))
    wind = float(np.max(winds))
    if wind > 0.0 and design.airspeed_m_per_s is not None:
        speed = float(design.airspeed_m_per_s)
        name, text = "airspeed_above_wind", "airspeed above the wind"
        found.append(_at_least(name, text, speed, wind, "m/s"))
    if isinstance(aircraft.airframe, ParametricAirframe):
        found += _of_parametric(aircraft, mission, design)
    return found


def _of_parametric(
    aircraft: Aircraft, mission: Mission, design: Design
) -> Iterator[RequirementMargin]:
    it = DesignInFlight(aircraft, design)
    covered = float(design.variables.module_area_m2 / design.wing_area_m2)
    most = aircraft.parametric.maximum_module_coverage
    yield _at_most("module_coverage", "modules over wing area", covered, most, "")
    limits = aircraft.design_space.limit_rows()
    for name, limit in limits.items():
        value, of = float(QUANTITIES[limit.quantity](it)), unit_text(unit(limit.quantity))
        margin = _at_least if limit.end == "minimum" else _at_most
        yield margin(name, label(limit.quantity), value, limit.value, of)
    if not any(limit.quantity == "stall_margin" for limit in limits.values()):
        least = RECOMMENDED_STALL_MARGIN
        one = _at_least("stall_margin", label("stall_margin"), float(it.stall_margin), least, "")
        yield one._replace(recommended=True)
    yield from _of_climb(aircraft, mission, design, float(design.rated_power_w))
    yield from _of_parts(aircraft, design)


def _of_climb(
    aircraft: Aircraft, mission: Mission, design: Design, rated_w: float
) -> Iterator[RequirementMargin]:
    """Climb at the highest altitude with the rated power, and with the empty battery's voltage."""
    highest_m = mission.ceiling_m
    there = mission.at_altitude(highest_m) if highest_m > mission.altitude_m else mission
    mass_kg = float(design.total_mass_kg)
    aloft = parametric_design(aircraft, there, design.variables, mass_kg)
    assert aloft.chain is not None
    weight_n = mass_kg * GRAVITY_M_PER_S2
    spare_w = (rated_w - float(aloft.propulsion_power_w)) * float(aloft.chain.efficiency)
    at = f"at {highest_m:g} m"
    name, text = "climb_rate_at_highest_altitude_m_per_s", f"climb rate at rated power {at}"
    yield _absolute(name, text, spare_w / weight_n, 0.0, "m/s")._replace(recommended=True)
    if (propulsion := aircraft.propulsion_by_parts) is None:
        return
    thrust_w = float(aloft.thrust_power_w)
    speed, air = float(aloft.airspeed_m_per_s), aloft.conditions.air
    own = propulsion.sized(*design.variables.mapped(float).of_propulsion)
    empty_v, _ = bus_voltage_v(aircraft)
    most, some = np.nan, _THRUSTS[::_COARSE]
    for _ in range(2):
        points = own.point(thrust_w * some, speed, air, (empty_v, empty_v))
        able = np.flatnonzero(np.asarray(points.reason) == "")
        if not able.size:
            break
        most = float(some[able[-1]])
        # The thrusts up to the next of the coarse ones.
        some = _THRUSTS[(most <= _THRUSTS)][:_COARSE]
    name, text = "climb_rate_with_empty_battery_m_per_s", f"climb rate, empty battery, {at}"
    climb = (most - 1.0) * thrust_w / weight_n
    yield _absolute(name, text, climb, 0.0, "m/s")._replace(recommended=True)


def _of_parts(aircraft: Aircraft, design: Design) -> Iterator[RequirementMargin]:
    """Limits of the parts of a propulsion in level flight with an empty battery."""
    if (propulsion := aircraft.propulsion_by_parts) is None:
        return
    own = propulsion.sized(*design.variables.mapped(float).of_propulsion)
    thrust_w = float(design.thrust_power_w)
    speed, air = float(design.airspeed_m_per_s), design.conditions.air
    empty_v, _ = bus_voltage_v(aircraft)
    point = own.point(thrust_w, speed, air, (empty_v, empty_v))
    yield _at_most("duty", "duty of the controller, empty battery", float(point.duty), 1.0, "")
    mach = own.maximum_tip_mach
    yield _at_most("tip_mach", "Mach number of the tips", float(point.tip_mach), mach, "")
    current = own.own_motor.maximum_current_a
    if current is not None:
        used = float(point.motor_current_a)
        yield _at_most("motor_current", "current of the motor", used, current, "A")


def _unlimited_or_none(value: float) -> str:
    return "unlimited" if value > 0.0 else "none"


def _absolute(name: str, text: str, value: float, limit: float, of: str) -> RequirementMargin:
    return RequirementMargin(name, text, value, limit, of, value - limit, relative=False)


def _at_least(name: str, text: str, value: float, limit: float, of: str) -> RequirementMargin:
    return RequirementMargin(name, text, value, limit, of, value / limit - 1.0)


def _at_most(name: str, text: str, value: float, limit: float, of: str) -> RequirementMargin:
    return RequirementMargin(name, text, value, limit, of, 1.0 - value / limit)
