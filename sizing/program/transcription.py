"""The sizing program: a design and the charge of its battery along the day of a few scenarios.

Direct transcription (Betts, J. T. 2010, Practical Methods for Optimal Control, ch. 4): the day of
every scenario is cut into intervals, and the state of charge at their ends is unknown. What is a
kink in a simulation is an inequality here, of which the lesser side holds by itself:

* balance: ``dE <= eta_c (A p - P) dt / E_full`` and ``dE <= (A p - P) dt / (eta_d E_full)``: what
  charges loses, what discharges loses; light that is not stored is thrown away;
* charger: ``dE <= rate(E) dt``;
* reserve: ``E eta_d E_full / P >= T`` at all times: the excess time, wherever the charge is least;
* return: the last charge of a repeated day is at least the first.

Light ``p`` and load ``P`` come from the simulated flight of a design as data: means over the
intervals, with the first derivative by the design (:mod:`sizing.program.corrections`). Every
requirement may be missed at a price, so that one solution is the optimum or says what is missing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import pairwise
from threading import RLock
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from sizing.aircraft import Aircraft
from sizing.design import DesignVariables, FlightConditions, parametric_design
from sizing.energy.battery import (
    ChargeLimit,
    NoChargeLimit,
    RuleChargeLimit,
    TableChargeLimit,
    charge_rate_per_h,
)
from sizing.limits import EQUATIONS, DesignInFlight, design_requirements
from sizing.parameters import all_replaced, catalogue, parameter_value
from sizing.program.variables import (
    OWN,
    SOLAR_TECHNOLOGY,
    TOTAL_MASS,
    WIND,
    Constraint,
    Role,
    chosen_variables,
    eased_row,
    limit_rows,
)

INTERVALS = 22
RESERVE_SCALE_H = 10.0  # excess time that counts as one in a row
CONTINUOUS_MARGIN = 1e-5  # of the load: at equality rounding decides whether the battery is needed
_PROGRAMS_KEPT = 32

_NUMBERS_OF_A_KIND = (
    "airframe.structure.cruise_gust_m_per_s",
    "airframe.propulsion.motor.speed_constant_rpm_per_v",
)
_POLAR = "airframe.aerodynamics."


class BlockData(NamedTuple):
    """Data of one scenario; arrays of the intervals, or numbers.

    ``hours``: length of the intervals. ``light_w_per_m2``: mean specific power. ``load``: mean load
    over that of the design in level flight. ``nominal``: nominal load, likewise. ``light_slope``,
    ``load_slope``: derivative of the logarithm of light and load by the design variables.
    ``shift_h``: excess time of the program beyond that of the simulator. ``margin``: by how much
    more a night takes, relative. ``continuous``: 1 where the sun must carry the nominal load at all
    times, with ``lowest_w_per_m2``. ``repeated``: 1 where the day repeats itself.
    """

    hours: Any
    light_w_per_m2: Any
    load: Any
    nominal: Any
    light_slope: Any
    load_slope: Any
    shift_h: Any
    reserve: Any
    margin: Any
    continuous: Any
    lowest_w_per_m2: Any
    repeated: Any


@dataclass(frozen=True)
class Program:
    """Expressions of a program and their solvers, shared by all aircraft of a kind."""

    names: tuple[str, ...]
    technology: tuple[str, ...]
    constraints: tuple[Constraint, ...]
    blocks: int
    symbols: dict[str, Any]
    lock: RLock = field(default_factory=RLock)
    _solvers: dict[str, ca.Function] = field(default_factory=dict)

    def solver(self, name: str, options: dict[str, Any]) -> ca.Function:
        """Solver with some options, built at the first call."""
        if name not in self._solvers:
            self._solvers[name] = ca.nlpsol("sizing", "ipopt", self.symbols, options)
        return self._solvers[name]

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
            "charge": self.blocks * (INTERVALS + 1),
        }
        ends = np.cumsum([0, *sizes.values()])
        return {n: slice(int(a), int(b)) for n, a, b in zip(sizes, ends, ends[1:], strict=False)}


def numbers_taken_out(aircraft: Aircraft) -> tuple[str, ...]:
    """Keys of the numbers that are parameters of the program."""
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


def kind_of(aircraft: Aircraft) -> Aircraft:
    """Aircraft without its name and without the numbers that are parameters of its program."""
    values: dict[str, Any] = {
        key: 1.0 if parameter_value(aircraft, None, key) else 0.0
        for key in numbers_taken_out(aircraft)
    }
    return all_replaced(aircraft, values | {"name": "kind", "description": ""})


def build_program(aircraft: Aircraft, blocks: int, *, eased: bool = False) -> Program:
    """Program of an aircraft with some scenarios, unless one of its kind was built before."""
    return _program(kind_of(aircraft), tuple(limit_rows(aircraft)), blocks, eased)


@lru_cache(maxsize=_PROGRAMS_KEPT)
def _program(kind: Aircraft, limits: tuple[str, ...], blocks: int, eased: bool) -> Program:
    chosen, technology = chosen_variables(kind, eased=eased), numbers_taken_out(kind)
    x = ca.SX.sym("design", len(chosen))
    worst_h = ca.SX.sym("excess_time")
    charge = ca.SX.sym("charge", INTERVALS + 1, blocks)
    lack = ca.SX.sym("lack", blocks)
    weights = ca.SX.sym("weights", len(chosen) + 1)
    conditions = ca.SX.sym("conditions", len(FlightConditions._fields))
    numbers = ca.SX.sym("technology", len(technology))
    efficiencies = ca.SX.sym("efficiencies", 2)
    scales = ca.SX.sym("scales", len(chosen))
    centre = ca.SX.sym("centre", len(chosen))
    reference_w = ca.SX.sym("reference_load")
    price = ca.SX.sym("price")

    # --- design -------------------------------------------------------------------------------
    values = {v.name: v.from_program(x[i], scales[i]) for i, v in enumerate(chosen)}
    relative = {v.name: values[v.name] for v in chosen if v.role is Role.technology}
    flown = all_replaced(
        kind, {key: numbers[i] * relative.get(key, 1.0) for i, key in enumerate(technology)}
    )
    named = {"aspect_ratio": flown.airframe.aspect_ratio} | values
    variables = DesignVariables(
        **{name: v for name, v in named.items() if name in DesignVariables._fields}
    )
    air = FlightConditions(*(conditions[i] for i in range(conditions.shape[0])))
    air = air.with_payload_of(variables)
    if WIND in values:
        air = air._replace(wind_m_per_s=values[WIND])
    design = parametric_design(flown, air, variables, values[TOTAL_MASS])
    bounds = limit_rows(kind)
    requirements = [
        row._replace(value=eased_row(row.value, bounds[row.name][1], values[row.name]))
        if row.name in bounds and row.name in values
        else row
        for row in design_requirements(flown, design, air)
    ]
    if OWN in values:
        space: Any = kind.design_space
        it = DesignInFlight(flown, design, air)
        requirements.append(space.own_objective.row(it, values[OWN]))
    missed = ca.SX.sym("missed", len(requirements))
    rows: list[tuple[Constraint, Any]] = [
        (
            Constraint(one.name, equation=one.name in (*EQUATIONS, OWN)),
            one.value + missed[i],
        )
        for i, one in enumerate(requirements)
    ]

    # --- day ----------------------------------------------------------------------------------
    area = variables.module_area_m2 * relative.get(SOLAR_TECHNOLOGY, 1.0)
    unit_wh = RESERVE_SCALE_H * reference_w
    full_wh, level_w = design.battery_energy_wh, design.load_in_turbulence_w(air.turbulence)
    data = []
    full = full_wh / unit_wh
    for i in range(blocks):
        block = _block_symbols(len(chosen))
        data.append(block)
        moved = x - centre
        light_slope = ca.reshape(block.light_slope, INTERVALS + 1, len(chosen))
        load_slope = ca.reshape(block.load_slope, INTERVALS + 1, len(chosen))
        light = block.light_w_per_m2 * ca.exp(light_slope[:-1, :] @ moved)
        brighter = ca.exp(light_slope[-1, :] @ moved)
        load_w = level_w * block.load * ca.exp(load_slope[:-1, :] @ moved)
        nominal_w = block.nominal * level_w * ca.exp(load_slope[-1, :] @ moved)
        net_w = area * light - load_w + lack[i] * reference_w
        net = net_w * block.hours / unit_wh
        before, after = charge[:-1, i], charge[1:, i]
        gain = after - before
        into, out_of = efficiencies[0], efficiencies[1]
        rows.append((Constraint("charge", i), into * net - gain))
        rows.append((Constraint("discharge", i), (1.0 + block.margin) * net / out_of - gain))
        if not isinstance(kind.battery.charge_limit, NoChargeLimit):
            clock = charge_clock(kind.battery.charge_limit, charge[:, i] / full)
            slower = block.hours - (clock[1:] - clock[:-1])
            rows.append((Constraint("charge_limit", i), slower))
        rows.append((Constraint("battery_capacity", i), full - charge[:, i]))
        reserve = (
            charge[:, i] * out_of - block.reserve * (worst_h + block.shift_h) * nominal_w / unit_wh
        )
        sun = (
            area * brighter * block.lowest_w_per_m2 - (1.0 + CONTINUOUS_MARGIN) * nominal_w
        ) / reference_w
        sun = sun + lack[i]
        rows.append((Constraint("excess_time", i), reserve + block.continuous * 1e3))
        rows.append((Constraint("continuous", i), sun + (1.0 - block.continuous) * 1e3))
        back = charge[-1, i] - charge[0, i] + 20.0 * (1.0 - block.repeated)
        rows.append((Constraint("energy_balance", i), back))
    constraints = tuple(c for c, value in rows for _ in range(value.shape[0]))
    cost = ca.dot(weights, ca.vertcat(x, worst_h))
    cost = cost + price * (ca.sum1(lack) + 10.0 * ca.sum1(missed))
    cost = cost - 1e-6 * ca.sum1(ca.sum2(charge)) / blocks
    symbols = {
        "x": ca.vertcat(x, worst_h, missed, lack, ca.vec(charge)),
        "p": ca.vertcat(
            weights,
            conditions,
            numbers,
            efficiencies,
            scales,
            centre,
            reference_w,
            price,
            *(ca.vertcat(*block) for block in data),
        ),
        "f": cost,
        "g": ca.vertcat(*(value for _, value in rows)),
    }
    return Program(tuple(v.name for v in chosen), technology, constraints, blocks, symbols)


def _block_symbols(count: int) -> BlockData:
    sizes = dict.fromkeys(BlockData._fields, 1)
    sizes |= dict.fromkeys(("hours", "light_w_per_m2", "load"), INTERVALS)
    sizes |= dict.fromkeys(("light_slope", "load_slope"), (INTERVALS + 1) * count)
    sizes |= {"reserve": INTERVALS + 1}
    return BlockData(**{name: ca.SX.sym(name, size) for name, size in sizes.items()})


def charge_clock(limit: ChargeLimit, state_of_charge: Any) -> Any:
    """Hours in which the charge limit alone charges an empty battery, of symbols."""
    soc = state_of_charge
    if isinstance(limit, RuleChargeLimit):
        rate, start = limit.c_rate_per_h, limit.taper_start
        steep = -math.log(limit.relative_rate_at_full) / (1.0 - start)
        beyond = ca.fmax(soc - start, 0.0)
        slower = 0.0 if steep == 0.0 else (ca.exp(steep * beyond) - 1.0) / steep - beyond
        return (soc + slower) / rate
    assert isinstance(limit, TableChargeLimit)
    knots = np.asarray(limit.state_of_charge)
    knots = np.unique(np.concatenate([np.linspace(a, b, 5) for a, b in pairwise(knots)]))
    hours = 1.0 / charge_rate_per_h(limit, knots)
    slopes = np.diff(np.concatenate([[0.0], np.diff(hours) / np.diff(knots), [0.0]]))
    return hours[0] * soc + sum(
        float(slope) * ca.fmax(soc - float(knot), 0.0) ** 2 / 2.0
        for slope, knot in zip(slopes, knots, strict=True)
    )
