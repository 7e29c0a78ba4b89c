"""The sizing program: a design and the charge of its battery along the day of a few scenarios.

Direct transcription (Betts, J. T. 2010, Practical Methods for Optimal Control, ch. 4): the day of
every scenario is cut into intervals, and the state of charge at their ends is unknown. What is a
kink in a simulation is an inequality here, of which the lesser side holds by itself:

* balance: ``dE <= eta_c (A p - P) dt / E_full`` and ``dE <= (A p - P) dt / (eta_d E_full)``: what
  charges loses, what discharges loses; light that is not stored is thrown away;
* charger: ``dE <= rate(E) dt``;
* reserve: ``E eta_d E_full / P >= T`` up to the morning's equal power, or at a landing: the excess
  time; elsewhere no more than that the battery is not empty;
* return: the last charge of a repeated day is at least the first.

Light ``p`` and load ``P`` come from the simulated flight of a design as data: means over the
intervals, with the first derivative by the design (:mod:`sizing.program.corrections`). Every
requirement may be missed at a price, so that one solution is the optimum or says what is missing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import pairwise
from threading import RLock
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from missions.air import GRAVITY_M_PER_S2
from sizing.aircraft import Aircraft
from sizing.battery.battery import (
    ChargeLimit,
    NoChargeLimit,
    RuleChargeLimit,
    TableChargeLimit,
    charge_rate_per_h,
)
from sizing.design import Design, DesignVariables, FlightConditions
from sizing.held_station import POWER_AGAINST_WIND
from sizing.limits import MASS_BUDGET, design_requirements
from sizing.mass_budget import level_flight, parametric_design
from sizing.parameters import all_replaced, catalogue, parameter_value
from sizing.program.variables import (
    TOTAL_MASS,
    USER_OBJECTIVE,
    Constraint,
    chosen_variables,
)
from sizing.propulsion.chain import Propulsion, chain_of_numbers
from solar.types import FloatArray

INTERVALS = 22  # of a day at one height: the charge bends at few places, where nodes lie
CLIMBING_INTERVALS = 40  # of heights, which change all day
INSIDE = (0.01, 0.99)  # where heights and charges start: interior points start inside bounds
# By how much more charge a day must return than its night takes, relative, to begin with: a day
# that returns any less lets the battery run empty over many days. In 98 of 100 days steps of five
# minutes err by less than this in it.
FIRST_MARGIN = 1e-4
LONGEST_H = 1e4  # of an excess time that is as long as possible
RESERVE_SCALE_H = 10.0  # excess time that counts as one in a row
CONTINUOUS_MARGIN = 1e-5  # of the load: at equality rounding decides whether the battery is needed
_PROGRAMS_KEPT = 32
LEVELS = 5  # heights, from the floor to the ceiling, through which light and power are polynomials
RATIOS = 4  # airspeeds likewise, from the design's own to the fastest
FASTEST = math.log(3.0)  # airspeed over the design's own: rated powers end long before
_OFF = 1e3  # beyond any row of order one: a row that is not required
# Cost of missing a requirement by all of it, or of lacking the whole load all day: far above any
# multiplier of a cost of order one, so that none is missed for a gain.
PRICE = 1000.0
_BUDGET = 10.0  # of the price, for requirements on the design: next to none can be missed
FULLER = 1e-6  # of the cost: charges that nothing holds are as high as they can be
# Cost of other heights than the flight's, as a mean square over the way to the ceiling: of heights
# that are as good those nearest to it are proposed, and none where they agree (a proximal point:
# Rockafellar, R. T. 1976, SIAM J. Control Optim. 14:877).
NEAR_FLIGHT = 0.4

_NUMBERS_OF_A_KIND = (
    "airframe.structure.cruise_gust_m_per_s",
    "airframe.propulsion.motor.speed_constant_rpm_per_v",
)
_POLAR = "airframe.aerodynamics."


class BlockData(NamedTuple):
    """Data of one scenario; arrays of the intervals, or numbers.

    ``hours``: length of the intervals. ``limit_h``: for how much of it the charge limit charges.
    ``most``: highest state of charge at the nodes. ``light_w_per_m2``: mean specific power, by
    heights as well, fastest. ``load``: mean load over that of the design in level flight.
    ``nominal``: nominal load, likewise. ``light_slope``, ``load_slope``: derivative of the
    logarithm of light and load by the design variables. ``shift_h``: excess time of the program
    beyond that of the simulator, with its derivative ``shift_slope_h`` by the design variables.
    ``reserve``: 1 at the nodes where it must be left. ``margin``: by how much more a night takes,
    relative. ``continuous``: 1 where the sun must carry the nominal load at all times, with
    ``lowest_w_per_m2``. ``repeated``: 1 where the day repeats itself; else it begins with a full
    battery. ``wind_m_per_s``: by heights, that the airspeed must reach where the place is held.
    ``share``: heights of the flight at the nodes, over the way to the ceiling.
    """

    hours: Any
    limit_h: Any
    most: Any
    light_w_per_m2: Any
    load: Any
    nominal: Any
    light_slope: Any
    load_slope: Any
    shift_h: Any
    shift_slope_h: Any
    reserve: Any
    margin: Any
    continuous: Any
    lowest_w_per_m2: Any
    repeated: Any
    wind_m_per_s: Any
    share: Any


class PartsData(NamedTuple):
    """Data of a propulsion at its operating point, as logarithms.

    ``value``: of efficiency, mass [kg] and what its parts do over each of their limits.
    ``slope``: their derivatives by the design variables. ``bend``: second ones of the efficiency.
    ``surface``: power by heights and airspeeds over that with the efficiency of level flight.
    """

    value: Any
    slope: Any
    bend: Any
    surface: Any


Rows = list[tuple[Constraint, Any]]

# Costs and rows are of order one, and the start is a simulated design: a barrier that begins high
# sends it away and back.
IPOPT: dict[str, Any] = {
    "print_time": False,
    "show_eval_warnings": False,
    "error_on_fail": False,
    "calc_lam_p": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.mu_strategy": "adaptive",
    "ipopt.mu_max": 1e-1,
    "ipopt.tol": 1e-7,
    "ipopt.acceptable_tol": 1e-5,
    "ipopt.max_iter": 300,
}


class Form(NamedTuple):
    """What a program of a kind of aircraft has.

    ``blocks``: scenarios. ``holds``: whether the place is held against the wind. ``climbs``:
    whether the height varies. ``days``: those that a flight begins, of 24 h each.
    """

    blocks: int
    holds: bool = False
    climbs: bool = False
    days: int = 1

    @property
    def intervals(self) -> int:
        """Intervals of all days."""
        return self.days * (CLIMBING_INTERVALS if self.climbs else INTERVALS)

    @property
    def levels(self) -> int:
        """Heights at which light and power are known."""
        return LEVELS if self.climbs else 1

    @property
    def ratios(self) -> int:
        """Airspeeds at which power is known."""
        return RATIOS if self.holds else 1

    @property
    def speeds(self) -> int:
        """Airspeeds of a block that are free: faster flight than that of the design."""
        return (self.intervals if self.climbs else 1) if self.holds else 0

    @property
    def heights(self) -> int:
        """Heights of a block that are free: at the nodes."""
        return self.intervals + 1 if self.climbs else 0


@dataclass(frozen=True)
class Program:
    """Expressions of a program and their solvers, shared by all aircraft of a kind."""

    names: tuple[str, ...]
    technology: tuple[str, ...]
    constraints: tuple[Constraint, ...]
    form: Form
    symbols: dict[str, Any]
    lock: RLock = field(default_factory=RLock)

    @cached_property
    def solver(self) -> ca.Function:
        """IPOPT for the program."""
        return ca.nlpsol("sizing", "ipopt", self.symbols, IPOPT)

    @cached_property
    def _function(self) -> ca.Function:
        return ca.Function(
            "program", [self.symbols[k] for k in "xp"], [self.symbols[k] for k in "fg"]
        )

    @cached_property
    def derivatives(self) -> ca.Function:
        """Rows, gradient of the cost, Jacobian of the rows and Hessian of the Lagrangian."""
        x, p, cost, rows = (self.symbols[k] for k in "xpfg")
        multipliers = ca.SX.sym("multipliers", rows.shape[0])
        bent = ca.hessian(cost + ca.dot(multipliers, rows), x)[0]
        derivatives = rows, ca.gradient(cost, x), ca.jacobian(rows, x), bent
        return ca.Function("derivatives", [x, p, multipliers], derivatives)

    def evaluated(self, x: FloatArray, parameters: FloatArray) -> tuple[float, FloatArray]:
        """Cost and rows."""
        cost, rows = self._function(x, parameters)
        return float(cost), np.asarray(rows).ravel()

    @property
    def blocks(self) -> int:
        """Number of scenarios."""
        return self.form.blocks

    @cached_property
    def requirements(self) -> tuple[str, ...]:
        """Names of the requirements on the design, which have a slack each."""
        return tuple(c.name for c in self.constraints if c.block is None)

    @cached_property
    def parts(self) -> dict[str, slice]:
        """Places of the parts of the decision vector."""
        sizes = {
            "design": len(self.names),
            "excess": 1,
            "missed": len(self.requirements),
            "lack": self.blocks,
            "charge": self.blocks * (self.form.intervals + 1),
            "height": self.blocks * self.form.heights,
            "speed": self.blocks * self.form.speeds,
        }
        ends = np.cumsum([0, *sizes.values()])
        return {n: slice(int(a), int(b)) for n, a, b in zip(sizes, ends, ends[1:], strict=False)}


def numbers_taken_out(aircraft: Aircraft) -> tuple[str, ...]:
    """Return the keys of the numbers that are parameters of the program."""
    from sizing.aerodynamics.parabolic import AtLiftCoefficient

    tabulated = not isinstance(getattr(aircraft.airframe, "aerodynamics", None), AtLiftCoefficient)
    return tuple(
        key
        for key, row in catalogue().items()
        if row.kind in ("design", "technology")
        and key not in _NUMBERS_OF_A_KIND
        and not (tabulated and key.startswith(_POLAR))
        and parameter_value(aircraft, None, key) is not None
    )


@lru_cache(maxsize=_PROGRAMS_KEPT)
def kind_of(aircraft: Aircraft) -> Aircraft:
    """Return the aircraft without its name and the numbers that are parameters."""
    values: dict[str, Any] = {
        key: 1.0 if parameter_value(aircraft, None, key) else 0.0
        for key in numbers_taken_out(aircraft)
    }
    return all_replaced(aircraft, values | {"name": "kind", "description": ""})


def build_program(aircraft: Aircraft, form: Form) -> Program:
    """Return the program of an aircraft in a form, built once for aircraft of its kind."""
    return _program(kind_of(aircraft), tuple(aircraft.design_space.limit_rows()), form)


@lru_cache(maxsize=_PROGRAMS_KEPT)
def _program(kind: Aircraft, limits: tuple[str, ...], form: Form) -> Program:
    """Build the program of a kind of aircraft; ``limits`` is the order of its limits."""
    chosen, technology = chosen_variables(kind), numbers_taken_out(kind)
    sizes = {
        "weights": len(chosen) + 1,
        "conditions": len(FlightConditions._fields) * form.levels,
        "technology": len(technology),
        "efficiencies": 2,
        "scales": len(chosen),
        "centre": len(chosen),
        "reference_w": 1,
        "price": 1,
        "ceiling_m": 1,
    }
    if kind.propulsion_by_parts is not None:
        count = 2 + len(kind.propulsion.limit_names)
        every = count, count * len(chosen), len(chosen) ** 2, form.levels * form.ratios
        sizes |= dict(zip(PartsData._fields, every, strict=True))
    data = {name: ca.SX.sym(name, size) for name, size in sizes.items()}
    blocks = [block_symbols(len(chosen), form) for _ in range(form.blocks)]
    x, worst_h, lack = (
        ca.SX.sym(name, size)
        for name, size in (("design", len(chosen)), ("excess_time", 1), ("lack", form.blocks))
    )
    charge, height, speed = (
        ca.SX.sym(name, size, form.blocks)
        for name, size in (
            ("charge", form.intervals + 1),
            ("height", form.heights),
            ("speed", form.speeds),
        )
    )
    design, requirements = _design_symbols(kind, form, x, data)
    missed = ca.SX.sym("missed", len(requirements))
    rows: Rows = [(Constraint(c.name, equation=c.equation), value) for c, value in requirements]
    rows = [(c, value + missed[i]) for i, (c, value) in enumerate(rows)]
    for i, block in enumerate(blocks):
        unknown = Unknowns(worst_h, lack[i], charge[:, i], height[:, i], speed[:, i])
        day = day_rows(kind.battery.charge_limit, form, design, block, unknown, x, data)
        rows += [(c._replace(block=i), value) for c, value in day]
    cost = ca.dot(data["weights"], ca.vertcat(x, worst_h))
    cost += data["price"] * (ca.sum1(lack) + _BUDGET * ca.sum1(missed))
    for i, block in enumerate(blocks):
        moved = ca.sumsqr(height[:, i] - block.share) / max(form.heights, 1)
        cost += NEAR_FLIGHT * moved / form.blocks
    cost -= FULLER * ca.sum1(ca.vec(charge)) / form.blocks
    symbols = {
        "x": ca.vertcat(x, worst_h, missed, lack, *(ca.vec(v) for v in (charge, height, speed))),
        "p": ca.vertcat(*data.values(), *(ca.vertcat(*block) for block in blocks)),
        "f": cost,
        "g": ca.vertcat(*(value for _, value in rows)),
    }
    constraints = tuple(c for c, value in rows for _ in range(value.shape[0]))
    return Program(tuple(v.name for v in chosen), technology, constraints, form, symbols)


# --- the design -----------------------------------------------------------------------------------


class DesignSymbols(NamedTuple):
    """What a day needs of a design; symbols.

    ``area_m2``: of the modules, in proportion to their efficiency. ``log_power_w``: logarithm of
    the propulsion power of level flight, by heights and airspeeds. ``airspeed_m_per_s``: by
    heights. ``steady``: factor of the turbulence of all hours. ``weight_n``: take-off weight.
    """

    area_m2: Any
    full_wh: Any
    log_power_w: Any
    airspeed_m_per_s: Any
    constant_w: Any
    payload_w: Any
    steady: Any
    rated_w: Any
    efficiency: Any
    weight_n: Any


def _design_symbols(
    kind: Aircraft, form: Form, x: Any, data: dict[str, Any]
) -> tuple[DesignSymbols, Rows]:
    """Return the design as symbols, and the requirements on it."""
    chosen, technology = chosen_variables(kind), numbers_taken_out(kind)
    values = {v.name: v.from_program(x[i], data["scales"][i]) for i, v in enumerate(chosen)}
    aircraft = all_replaced(kind, {key: data["technology"][i] for i, key in enumerate(technology)})
    named = {"aspect_ratio": aircraft.airframe.aspect_ratio} | values
    fields = DesignVariables._fields
    variables = DesignVariables(**{name: v for name, v in named.items() if name in fields})
    levels = ca.horzsplit(ca.reshape(data["conditions"], -1, form.levels))
    airs = [FlightConditions(*ca.vertsplit(air)).with_payload_of(variables) for air in levels]
    chain, surface, rows = _parts_symbols(kind, form, x, data)
    design = parametric_design(aircraft, airs[0], variables, values[TOTAL_MASS], chain)
    rows += [
        (Constraint(row.name, equation=row.name == MASS_BUDGET), row.value)
        for row in design_requirements(aircraft, design)
    ]
    if USER_OBJECTIVE in values:
        space: Any = kind.design_space
        row = space.own_objective.row(design, values[USER_OBJECTIVE])
        rows.append((Constraint(USER_OBJECTIVE, equation=True), row.value))
    powers, speeds = power_surface(aircraft, form, airs, variables, design)
    assert design.chain is not None
    symbols = DesignSymbols(
        area_m2=variables.module_area_m2,
        full_wh=design.battery_energy_wh,
        log_power_w=ca.log(powers) + surface,
        airspeed_m_per_s=speeds,
        constant_w=design.constant_power_w,
        payload_w=airs[0].payload_power_w,
        steady=1.0 + airs[0].turbulence,
        rated_w=design.rated_power_w,
        efficiency=design.chain.efficiency,
        weight_n=design.total_mass_kg * GRAVITY_M_PER_S2,
    )
    return symbols, rows


def _parts_symbols(
    kind: Aircraft, form: Form, x: Any, data: dict[str, Any]
) -> tuple[Propulsion | None, Any, Rows]:
    """Return a propulsion at its operating point, its surface, and rows of its parts' limits."""
    if (parts := kind.propulsion_by_parts) is None:
        return None, 0.0, []
    moved = x - data["centre"]
    parts_now = ca.exp(data["value"] + ca.reshape(data["slope"], -1, x.shape[0]) @ moved)
    bent = ca.bilin(ca.reshape(data["bend"], x.shape[0], -1), moved, moved) / 2.0
    efficiency = parts_now[0] * ca.exp(bent)
    chain = chain_of_numbers(parts, efficiency, parts_now[1])
    used = zip(parts.limit_names, ca.vertsplit(parts_now[2:]), strict=True)
    rows = [(Constraint(name), 1.0 - share) for name, share in used]
    return chain, ca.reshape(data["surface"], form.levels, -1), rows


def power_surface(
    aircraft: Aircraft,
    form: Form,
    airs: Sequence[FlightConditions],
    variables: DesignVariables,
    design: Design,
) -> tuple[Any, Any]:
    """Return power of level flight by heights (rows) and airspeeds, and airspeed by heights.

    Faster flight has a lower lift coefficient, ``C_L / ratio**2``.
    """
    ratios = [math.exp(place * FASTEST) for place in _places(form.ratios)]
    powers, speeds = [], []
    for air in airs:
        row = []
        for ratio in ratios:
            faster = variables
            if ratio != 1.0:
                faster = variables._replace(lift_coefficient=design.lift_coefficient / ratio**2)
            _, power_w, speed = level_flight(
                aircraft, air, faster, design.total_mass_kg, design.chain
            )
            row.append(power_w)
            if ratio == 1.0:
                speeds.append(speed)
        powers.append(ca.horzcat(*row))
    return ca.vertcat(*powers), ca.vertcat(*speeds)


# --- the day --------------------------------------------------------------------------------------


class Unknowns(NamedTuple):
    """What is unknown of a day besides the design; symbols.

    ``lack``: missing power over the nominal load without payload, of all intervals or of each.
    ``charge``: energy at the nodes over that load for ``RESERVE_SCALE_H``. ``height``: at the
    nodes, over the way to the ceiling. ``speed``: logarithm of the airspeed over the design's.
    """

    excess_h: Any
    lack: Any
    charge: Any
    height: Any
    speed: Any


def day_rows(
    limit: ChargeLimit,
    form: Form,
    design: DesignSymbols,
    block: BlockData,
    unknown: Unknowns,
    x: Any,
    data: dict[str, Any],
) -> Rows:
    """Return the rows of a scenario."""
    moved, reference_w = x - data["centre"], data["reference_w"]
    unit_wh = RESERVE_SCALE_H * reference_w
    light_slope = ca.reshape(block.light_slope, form.intervals + 1, x.shape[0])
    load_slope = ca.reshape(block.load_slope, form.intervals + 1, x.shape[0])
    brighter, heavier = ca.exp(light_slope @ moved), ca.exp(load_slope @ moved)
    weights, floor_w, beyond_w, rows = _motion(form, design, block, unknown, data["ceiling_m"])
    level_w = floor_w * design.steady + design.constant_w
    light = ca.reshape(block.light_w_per_m2, form.levels, form.intervals)
    light = ca.sum1(light * weights).T * brighter[:-1]
    load_w = level_w * block.load * heavier[:-1] + beyond_w
    nominal_w = block.nominal * level_w * heavier[-1]
    # A payload counts for nothing in what may be missing: it would grow without end.
    lack_w = unknown.lack * (nominal_w - design.payload_w)
    net_w = design.area_m2 * light - load_w + lack_w
    net, charge, full = net_w * block.hours / unit_wh, unknown.charge, design.full_wh / unit_wh
    into, out_of = data["efficiencies"][0], data["efficiencies"][1]
    gain = charge[1:] - charge[:-1]
    rows.append((Constraint("charge"), into * net - gain))
    rows.append((Constraint("discharge"), (1.0 + block.margin) * net / out_of - gain))
    if not isinstance(limit, NoChargeLimit):
        clock = charge_clock(limit, charge / full)
        rows.append((Constraint("charge_limit"), block.limit_h - (clock[1:] - clock[:-1])))
    rows.append((Constraint("battery_capacity"), full * block.most - charge))
    shift_h = block.shift_h + ca.dot(block.shift_slope_h, moved)
    required = block.reserve * (unknown.excess_h + shift_h) * nominal_w / unit_wh
    sun_w = design.area_m2 * brighter[-1] * block.lowest_w_per_m2
    sun = (sun_w + lack_w) / nominal_w - 1.0 - CONTINUOUS_MARGIN
    rows.append((Constraint("excess_time"), charge * out_of - required + _OFF * block.continuous))
    rows.append((Constraint("continuous"), sun + _OFF * (1.0 - block.continuous)))
    once = _OFF * (1.0 - block.repeated)
    rows.append((Constraint("energy_balance"), charge[-1] - charge[0] + once))
    rows.append((Constraint("launch"), charge[0] - full + _OFF * block.repeated))
    return rows


def _motion(
    form: Form, design: DesignSymbols, block: BlockData, unknown: Unknowns, ceiling_m: Any
) -> tuple[Any, Any, Any, Rows]:
    """Return the motion along a day, and the rows that hold it.

    Of every interval the weights of the levels; propulsion power at the floor, and of every
    interval the load above that of level flight there.

    The wind's is the airspeed at least; the propulsion gives no less than nothing and no more than
    its rated power; a climb takes ``m g dz/dt`` over the efficiency.
    """
    rows: Rows = []
    height, speed = unknown.height, unknown.speed
    middle = (height[1:] + height[:-1]) / 2.0 if form.climbs else ca.DM.zeros(1)
    weights = _weights(middle, form.levels)
    fast = speed if form.holds else ca.DM.zeros(middle.shape[0])
    faster = _weights(fast / FASTEST, form.ratios)
    # At the floor the airspeed is that of the first interval, which begins there.
    floor = ca.exp((design.log_power_w[0, :] @ faster[:, 0])[0])
    power_w = ca.exp(ca.sum1(weights * (design.log_power_w @ faster)).T)
    if form.holds:
        airspeed = ca.exp(ca.sum1(weights * ca.log(design.airspeed_m_per_s)).T + fast)
        wind = ca.sum1(weights * block.wind_m_per_s).T
        rows.append(
            (Constraint("airspeed_against_wind"), (airspeed - wind) / design.airspeed_m_per_s[0])
        )
    beyond_w: Any = ca.DM.zeros(form.intervals)
    rated_w = design.rated_w
    if form.climbs:
        rate = (height[1:] - height[:-1]) * ceiling_m / (3600.0 * block.hours)
        climb_w = design.weight_n * rate / design.efficiency
        if not form.holds:  # level flight is flown whatever is rated, as without climbs
            rated_w = ca.fmax(rated_w, power_w * design.steady)
        motor_w = power_w * design.steady + climb_w
        rows.append((Constraint("glide"), motor_w / design.rated_w))
        rows.append((Constraint("height", equation=True), height[-1] - height[0]))
        beyond_w = motor_w - floor * design.steady
        power_w = motor_w
    if form.holds or form.climbs:
        spare = 1.0 - power_w / rated_w + unknown.lack
        rows.append((Constraint(POWER_AGAINST_WIND), spare))
    if not form.climbs:
        weights = ca.repmat(weights, 1, form.intervals)
    return weights, floor, beyond_w, rows


def _places(count: int) -> list[float]:
    return [i / (count - 1) for i in range(count)] if count > 1 else [0.0]


def lagrange(place: Any, count: int) -> list[Any]:
    """Return the weights of evenly spaced nodes from 0 to 1 in the polynomial through them.

    ``place``: number, array or symbol.
    """
    nodes = _places(count)
    return [
        math.prod(((place - other) / (node - other) for other in nodes if other != node), start=1.0)
        for node in nodes
    ]


def _weights(places: Any, count: int) -> Any:
    """Return such weights of a column of places, a column for each."""
    return ca.horzcat(*(ca.vertcat(*lagrange(z, count)) for z in ca.vertsplit(places)))


def block_symbols(count: int, form: Form) -> BlockData:
    """Return the data of a scenario as symbols, for so many design variables."""
    sizes = dict.fromkeys(BlockData._fields, 1)
    sizes |= dict.fromkeys(("hours", "limit_h", "load"), form.intervals)
    sizes |= {"light_w_per_m2": form.intervals * form.levels, "wind_m_per_s": form.levels}
    sizes |= dict.fromkeys(("light_slope", "load_slope"), (form.intervals + 1) * count)
    sizes |= dict.fromkeys(("most", "reserve"), form.intervals + 1) | {"shift_slope_h": count}
    sizes |= {"share": form.heights}
    return BlockData(**{name: ca.SX.sym(name, size) for name, size in sizes.items()})


def charge_clock(limit: ChargeLimit, state_of_charge: Any) -> Any:
    """Return the hours in which the charge limit alone charges an empty battery."""
    soc = state_of_charge
    if isinstance(limit, RuleChargeLimit):
        rate, start = limit.c_rate_per_h, limit.taper_start
        steep = -math.log(limit.relative_rate_at_full) / (1.0 - start)
        beyond = ca.fmax(soc - start, 0.0)
        tapering = ca.fmin(beyond, 1.0 - start)  # as slow as at full charge beyond it
        hours = tapering if steep == 0.0 else (ca.exp(steep * tapering) - 1.0) / steep
        hours += (beyond - tapering) / limit.relative_rate_at_full
        return (soc - beyond + hours) / rate
    assert isinstance(limit, TableChargeLimit)
    knots = np.asarray(limit.state_of_charge)
    knots = np.unique(np.concatenate([np.linspace(a, b, 5) for a, b in pairwise(knots)]))
    hours = 1.0 / charge_rate_per_h(limit, knots)
    slopes = np.diff(np.concatenate([[0.0], np.diff(hours) / np.diff(knots), [0.0]]))
    return hours[0] * soc + sum(
        float(slope) * ca.fmax(soc - float(knot), 0.0) ** 2 / 2.0
        for slope, knot in zip(slopes, knots, strict=True)
    )
