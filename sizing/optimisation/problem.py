"""The sizing problem: variables, objective and constraints of a small nonlinear program.

Variables and rows are those of :mod:`sizing.optimisation.variables`: the mass budget, the energy
over a day, and the limits of :mod:`sizing.limits`. The sun enters as specific
power per module area, which no design variable changes, so that a whole day of a scenario is a
parameter vector, and so do air, wind, payload and technology: a program is built once for a kind of
aircraft, and serves any mission and objective.

Energy over the day is integrated exactly as the simulator does it;
:mod:`sizing.optimisation.energy_constraints`:

* the night's deficit must fit into the battery, ``soc_dawn + deficit <= 1``;
* the day's surplus must bring it back, ``soc_dawn + deficit <= soc after charging from soc_dawn``,
  with the charge limit followed step by step.

Both together say that the cycle repeats itself with at least ``soc_dawn``, and the excess time is
the energy at dawn over the load. Every cost is a weighted sum of variables. Slack variables, held
at zero in the sizing itself, let the same program tell by how much the requirements are missed. An
*eased* program has technology, limits and wind among its variables as well, and tells which value
would meet them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from threading import RLock
from typing import Any

import casadi as ca
import numpy as np

from sizing.aerodynamics.parabolic import AtLiftCoefficient
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.design import DesignVariables, FlightConditions, parametric_design
from sizing.held_station import POWER_AGAINST_WIND
from sizing.limits import MASS_BUDGET, DesignInFlight, Requirement, design_requirements
from sizing.optimisation.climb_constraints import (
    ALOFT_PARAMETERS,
    CLIMB_SUN_PARAMETERS,
    Strategy,
    climb_values,
    climbing_cycle_function,
)
from sizing.optimisation.energy_constraints import (
    LEVELS_ALOFT,
    SUN_PARAMETERS,
    cycle_function,
    flown_as_fast,
    smooth_loads_w,
)
from sizing.optimisation.solver_options import OPTIONS, TOLERANCE, Effort
from sizing.optimisation.variables import (
    EXCESS_SCALE_H,
    HEIGHT,
    OWN,
    SOLAR_TECHNOLOGY,
    TOTAL_MASS,
    WIND,
    WORST_EXCESS,
    Constraint,
    Role,
    Variable,
    all_variables,
    chosen_variables,
    eased_row,
    limit_rows,
)
from sizing.parameters import all_replaced, catalogue, parameter_value
from sizing.propulsion.smooth_chain import SmoothPropulsion
from solar.types import FloatArray

# By how much the lowest sun must exceed the load where it carries it at all times, relative: at
# equality rounding decides whether the battery is needed for an instant.
ALWAYS_LIT_MARGIN = 1e-5

# Technology that stays a number of the formulas: what compares it or looks it up takes no symbol.
_NUMBERS_OF_A_KIND = (
    "airframe.structure.cruise_gust_m_per_s",
    "airframe.propulsion.motor.speed_constant_rpm_per_v",
)
_POLAR = "airframe.aerodynamics."

# Solutions with climbs take up to 60 steps in the wild problems that were looked at.
_STEPS_WITH_CLIMBS = 80

# Programs that are kept, each with its solvers: some megabytes.
_PROGRAMS_KEPT = 32


@dataclass(frozen=True)
class Program:
    """Expressions of a program and their solvers, shared by all aircraft of a kind.

    A program has a number of *scenario blocks*, each filled with one scenario by its parameters, so
    that the scenarios in it can be exchanged without building it anew.

    ``names``: of the variables, in the order of the decision vector ``x``. ``constraints``: in the
    order of the constraint vector ``g``. ``technology``: keys of the parameters ``p``. ``symbols``:
    of these and of the cost ``f``. ``holds``: whether every scenario is flown at its own airspeed,
    to hold the place; ``climbs``: whether missions have climbs. ``lock``: held from a solver's call
    until its statistics are read: threads
    share a program.
    """

    names: tuple[str, ...]
    constraints: tuple[Constraint, ...]
    technology: tuple[str, ...]
    symbols: dict[str, Any]
    holds: bool = False
    climbs: bool = False
    lock: RLock = field(default_factory=RLock)
    _solvers: dict[Effort, ca.Function] = field(default_factory=dict)

    def solver(self, effort: Effort = "quick") -> ca.Function:
        """Solver of the program, silent; built at the first call.

        The sizing itself makes do with a ``quick`` quasi-Newton Hessian: for a handful of variables
        it needs few more iterations than exact second derivatives of the charge recursion, and each
        costs a third. ``still`` is the same, ending where the cost stands still. With slacks, which
        reach far, exact ones are now and then better: ``steady``. ``next`` is sequential quadratic
        programming, which starts well from the solution of a similar problem, as interior points do
        not; ``direct`` is the same for a start that is no solution, and gives up early.
        """
        if effort not in self._solvers:
            kind = "sqpmethod" if effort in ("next", "direct") else "ipopt"
            options = OPTIONS[effort]
            if self.climbs and kind == "ipopt":
                # Second derivatives of two stores over a day take seconds to build.
                options = options | {"ipopt.hessian_approximation": "limited-memory"}
                if effort != "steady":  # a height that no design reaches would take all steps
                    options = options | {"ipopt.max_iter": _STEPS_WITH_CLIMBS}
            self._solvers[effort] = ca.nlpsol("sizing", kind, self.symbols, options)
        return self._solvers[effort]

    @cached_property
    def rows(self) -> ca.Function:
        """Cost and constraints as a function of decision vector and parameters."""
        return ca.Function(
            "program", [self.symbols[k] for k in "xp"], [self.symbols[k] for k in "fg"]
        )


@dataclass(frozen=True)
class SizingProblem:
    """The program of an aircraft: expressions of its kind, its own bounds and technology."""

    aircraft: Aircraft
    variables: tuple[Variable, ...]
    program: Program

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """Rows in the order of the constraint vector."""
        return self.program.constraints

    @cached_property
    def _technology(self) -> list[float]:
        """Technology, correction of a propulsion by formulas, the battery's efficiencies."""
        values = [parameter_value(self.aircraft, None, key) for key in self.program.technology]
        values += _correction_of(self.aircraft)
        battery = self.aircraft.battery
        efficiencies = (battery.mean_charge_efficiency, battery.mean_discharge_efficiency)
        return [float(value) for value in (*values, *efficiencies) if value is not None]

    @cached_property
    def index(self) -> dict[str, int]:
        """Place of every variable in the decision vector."""
        return {v.name: i for i, v in enumerate(self.variables)}

    def of_role(self, *roles: Role) -> tuple[Variable, ...]:
        """Variables of some roles."""
        return tuple(v for v in self.variables if v.role in roles)

    def weights(self, of: Mapping[str, float]) -> FloatArray:
        """Cost per unit of the decision vector, from names of variables."""
        weights = np.zeros(len(self.variables))
        for name, weight in of.items():
            weights[self.index[name]] = weight
        return weights

    def parameters(
        self,
        weights: FloatArray,
        conditions: FlightConditions,
        suns: FloatArray,
        *,
        margin: float,
        aloft: FloatArray | None = None,
        winds: FloatArray | None = None,
    ) -> FloatArray:
        """Parameter vector of the program.

        ``margin``: by how much more charge the day must return than the night takes, relative.
        ``aloft``: conditions above the floor, on missions with climbs. ``winds``: of every block
        [m/s], where the place is held, at the floor and with climbs at the levels aloft.
        """
        parts = {
            "weights": weights,
            "margin": [margin],
            "conditions": conditions,
            "aloft": () if aloft is None else aloft,
            "technology": self._technology,
            "suns": suns.ravel(),
            "winds": () if winds is None or not self.program.holds else winds.ravel(),
        }
        return np.concatenate([parts[name] for name in _PARAMETERS])

    def design_variables(
        self, x: FloatArray, ends: Mapping[str, tuple[float, float]]
    ) -> DesignVariables:
        """Design in a decision vector, within its bounds: the solver may step slightly over.

        What the solver leaves of a value at zero, below its tolerance, is zero.

        ``ends``: bounds by name of a variable, in its unit; the same where it is held.
        """
        values = {"aspect_ratio": self.aircraft.airframe.aspect_ratio}
        for v, own in zip(self.variables, x, strict=True):
            if v.name in DesignVariables._fields:
                value = float(np.clip(float(v.from_program(own)), *ends[v.name]))
                noise = TOLERANCE * (v.scale or 0.0) >= abs(value) and ends[v.name][0] == 0.0
                values[v.name] = 0.0 if noise else value
        return DesignVariables(**values)


# Parts of the parameter vector, in their order.
_PARAMETERS = ("weights", "margin", "conditions", "aloft", "technology", "suns", "winds")


def build_problem(
    aircraft: Aircraft,
    blocks: int,
    *,
    eased: bool = False,
    holds: bool = False,
    climb: Strategy | None = None,
) -> SizingProblem:
    """Build the program of an aircraft, unless one of its kind has been built before.

    ``eased``: whether technology, limits and wind are variables, which may be freed. ``holds``:
    whether every scenario is flown as fast as its wind. ``climb``: when the aircraft climbs, on
    missions on which it does.
    """
    if not isinstance(aircraft.airframe, ParametricAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    if (propulsion := aircraft.propulsion_by_parts) is not None and propulsion.is_exact:
        raise TypeError(
            f"the propulsion of {aircraft.name} is at its operating point: with_smooth_chain first"
        )
    chosen = chosen_variables(aircraft, eased=eased)
    # A mapping's order plays no part in the equality of aircraft, but in that of the rows.
    program = _program(kind_of(aircraft), tuple(limit_rows(aircraft)), blocks, eased, holds, climb)
    variables = all_variables(chosen, blocks, program.constraints, climbs=climb is not None)
    return SizingProblem(aircraft, variables, program)


def kind_of(aircraft: Aircraft) -> Aircraft:
    """Aircraft without the numbers that are parameters of its program, and without its name.

    A program is built from this alone: two aircraft share one exactly if they are of one kind, and
    a number that is not a parameter makes another kind. Those that are not zero are 1, unchecked.
    """
    values: dict[str, Any] = {
        key: 1.0 if parameter_value(aircraft, None, key) else 0.0
        for key in numbers_taken_out(aircraft)
    }
    kind = all_replaced(aircraft, values | {"name": "kind", "description": ""})
    return _corrected_by(kind, (1.0, 1.0))


def _correction_of(aircraft: Aircraft) -> tuple[float, ...]:
    """Correction of a propulsion by formulas, another one in each round of a sizing."""
    propulsion = getattr(aircraft.airframe, "propulsion", None)
    return propulsion.correction if isinstance(propulsion, SmoothPropulsion) else ()


def _corrected_by(aircraft: Aircraft, correction: tuple[Any, ...]) -> Aircraft:
    """Aircraft whose propulsion by formulas has another correction; else itself."""
    propulsion = getattr(aircraft.airframe, "propulsion", None)
    if not isinstance(propulsion, SmoothPropulsion):
        return aircraft
    changed = propulsion.model_copy(update={"correction": correction})
    return aircraft.with_airframe(propulsion=changed)


def numbers_taken_out(aircraft: Aircraft) -> tuple[str, ...]:
    """Keys of the numbers that are parameters, or play no part in any formula of the program."""
    tabulated = not isinstance(getattr(aircraft.airframe, "aerodynamics", None), AtLiftCoefficient)
    return tuple(
        key
        for key, one in catalogue().items()
        if one.kind in ("design", "technology")
        and key not in _NUMBERS_OF_A_KIND
        # The best lift coefficient of an airfoil is looked up.
        and not (tabulated and key.startswith(_POLAR))
        and parameter_value(aircraft, None, key) is not None
    )


@lru_cache(maxsize=_PROGRAMS_KEPT)
def _program(
    kind: Aircraft,
    limits: tuple[str, ...],
    blocks: int,
    eased: bool,
    holds: bool,
    climb: Strategy | None,
) -> Program:
    """Program of a kind of aircraft; ``limits`` is the order of its limits."""
    chosen = chosen_variables(kind, eased=eased)
    technology = numbers_taken_out(kind)
    levels = 1 if climb is None else LEVELS_ALOFT + 1
    design, against_wind, requirements = _design_functions(
        kind, chosen, technology, levels=levels, holds=holds
    )
    free = ca.MX.sym("design", len(chosen))
    dawn_soc = ca.MX.sym("dawn_state_of_charge", blocks)
    worst_h = ca.MX.sym(WORST_EXCESS)
    margin = ca.MX.sym("recharge_margin")
    conditions = ca.MX.sym("conditions", len(FlightConditions._fields))
    numbers = ca.MX.sym("technology", len(technology) + len(_correction_of(kind)))
    efficiencies = ca.MX.sym("battery_efficiencies", 2)
    sun = ca.MX.sym("sun", SUN_PARAMETERS if climb is None else CLIMB_SUN_PARAMETERS, blocks)
    aloft = ca.MX.sym("aloft", 0 if climb is None else ALOFT_PARAMETERS)
    heights = ca.MX.sym("heights", 0 if climb is None else blocks)
    winds = ca.MX.sym("winds", levels, blocks if holds else 0)

    lit_area, capacity_wh, nominal_w, propulsion_w, values, store = design(
        free, conditions, numbers, aloft
    )
    rows = [
        (
            Constraint(one.name, equation=one.name in (MASS_BUDGET, OWN)),
            values[k],
        )
        for k, one in enumerate(requirements)
    ]
    for i in range(blocks):
        if holds:
            nominal_w, propulsion_w, spare, store = against_wind(
                free, conditions, numbers, aloft, winds[:, i]
            )
            rows.append((Constraint(POWER_AGAINST_WIND, i), spare))
        usable_h = capacity_wh * efficiencies[1] / nominal_w
        if climb is None:
            deficit, charged = cycle_function(kind.battery.charge_limit)(
                *(lit_area, capacity_wh, nominal_w, propulsion_w),
                *(dawn_soc[i], efficiencies, sun[:, i]),
            )
            reserve_h = dawn_soc[i] * usable_h
        else:
            parts = kind.propulsion_by_parts is not None
            climbing = climbing_cycle_function(kind.battery.charge_limit, climb, by_parts=parts)
            deficit, charged, reached, beyond_h = climbing(
                *(lit_area, capacity_wh, dawn_soc[i], heights[i], store),
                *(efficiencies, margin, sun[:, i]),
            )
            charged = charged + margin * deficit  # the day began with so much less
            rows.append((Constraint(HEIGHT, i, firm=True), reached - heights[i]))
            reserve_h = dawn_soc[i] * usable_h + beyond_h
        # The margin is slightly more charge than the night takes. At equality the cycle
        # stands on an edge: a day that returns any less lets the battery run empty over many days.
        recharged = charged - dawn_soc[i] - (1.0 + margin) * deficit
        excess = Constraint("excess_time", i, "h", EXCESS_SCALE_H)
        # Where the sun carries the load at all times the excess time is unlimited, whatever the
        # battery holds at dawn.
        lowest = sun[-1, i]
        sunlit = lowest > 0.0
        reserve = (reserve_h - worst_h) / excess.scale
        spare_sun = lit_area * lowest / nominal_w - (1.0 + ALWAYS_LIT_MARGIN)
        rows += [
            (Constraint("battery_capacity", i), 1.0 - dawn_soc[i] - deficit),
            (Constraint("energy_balance", i), recharged),
            (excess, (1.0 - sunlit) * reserve + sunlit * spare_sun),
        ]
    constraints = tuple(c for c, _ in rows)
    slacks = list(dict.fromkeys(name for c in constraints for name in c.slacks))
    slack = ca.MX.sym("slack", len(slacks))
    missed = [
        sum((sign * slack[slacks.index(name)] for name, sign in c.slacks.items()), 0.0)
        for c in constraints
    ]
    x = ca.vertcat(free, dawn_soc, heights, worst_h, slack)
    every = all_variables(chosen, blocks, constraints, climbs=climb is not None)
    names = tuple(v.name for v in every)
    weights = ca.MX.sym("weights", len(names))
    parameters = {
        "weights": weights,
        "margin": margin,
        "conditions": conditions,
        "aloft": aloft,
        "technology": ca.vertcat(numbers, efficiencies),
        "suns": ca.vec(sun),
        "winds": ca.vec(winds),
    }
    # The dawn states of scenarios that do not bind are otherwise undetermined.
    tie_break = -1e-7 * (ca.sum1(dawn_soc) + ca.sum1(heights))
    symbols = {
        "x": x,
        "p": ca.vertcat(*(parameters[name] for name in _PARAMETERS)),
        "f": ca.dot(weights, x) + tie_break,
        "g": ca.vertcat(*(value + by for (_, value), by in zip(rows, missed, strict=True))),
    }
    return Program(names, constraints, technology, symbols, holds, climb is not None)


def forget_programs() -> None:
    """Forget all programs that have been built: the next sizing is the first of its kind again."""
    _program.cache_clear()
    cycle_function.cache_clear()


def programs_built() -> int:
    """How many programs have been built since the last time that all were forgotten."""
    return _program.cache_info().misses


def _design_functions(
    kind: Aircraft,
    variables: Sequence[Variable],
    technology: Sequence[str],
    *,
    levels: int,
    holds: bool,
) -> tuple[ca.Function, ca.Function, list[Requirement]]:
    """Functions of the variables: a design's properties, and its loads as fast as winds.

    The first has lit area, capacity, loads and requirements, and what its potential store is where
    it climbs, between several ``levels``; the second loads, what the rated power has to spare, and
    that store where the place is held. Conditions and technology are data. The lit area is the
    module area times the relative efficiency of the cells: power per area is a parameter, and
    proportional to it.
    """
    x = ca.SX.sym("x", len(variables))
    symbols = ca.SX.sym("conditions", len(FlightConditions._fields))
    numbers = ca.SX.sym("technology", len(technology) + len(_correction_of(kind)))
    climbs = levels > 1
    aloft = ca.SX.sym("aloft", ALOFT_PARAMETERS if climbs else 0)
    values = {v.name: v.from_program(x[i]) for i, v in enumerate(variables)}
    relative = {v.name: values[v.name] for v in variables if v.role is Role.technology}
    flown = all_replaced(
        kind, {key: numbers[i] * relative.get(key, 1.0) for i, key in enumerate(technology)}
    )
    flown = _corrected_by(flown, tuple(ca.vertsplit(numbers[len(technology) :])))
    own = {"aspect_ratio": flown.airframe.aspect_ratio}
    named = {name: v for name, v in (own | values).items() if name in DesignVariables._fields}
    chosen = DesignVariables(**named)
    conditions = FlightConditions(*(symbols[i] for i in range(symbols.shape[0])))
    conditions = conditions.with_payload_of(chosen)
    if WIND in values:
        conditions = conditions._replace(wind_m_per_s=values[WIND])
    design = parametric_design(flown, conditions, chosen, values[TOTAL_MASS])
    limits = limit_rows(kind)
    requirements = [
        row._replace(value=eased_row(row.value, limits[row.name][1], values[row.name]))
        if row.name in limits and row.name in values
        else row
        for row in design_requirements(flown, design, conditions)
    ]
    if OWN in values:
        it = DesignInFlight(flown, design, conditions)
        space: Any = kind.design_space
        requirements.append(space.own_objective.row(it, values[OWN]))
    store = climb_values(flown, design, conditions, aloft) if climbs and not holds else ()
    function = ca.Function(
        "design",
        [x, symbols, numbers, aloft],
        [
            design.variables.module_area_m2 * relative.get(SOLAR_TECHNOLOGY, 1.0),
            design.battery_energy_wh,
            *smooth_loads_w(flown, design, conditions),
            ca.vertcat(*(one.value for one in requirements)),
            ca.vertcat(*store),
        ],
        {"is_diff_in": [True, False, False, False], "jac_penalty": 0},
    )
    winds = ca.SX.sym("winds", levels)
    faster = flown_as_fast(flown, conditions, design, winds[0])
    faster_w = faster.propulsion_power_w
    held = climb_values(flown, design, conditions, aloft, winds) if climbs and holds else ()
    against_wind = ca.Function(
        "against_wind",
        [x, symbols, numbers, aloft, winds],
        [
            faster.load_in_turbulence_w(conditions.turbulence),
            *(faster_w, design.rated_power_w / faster_w - 1.0),
            ca.vertcat(*held),
        ],
        {"is_diff_in": [True] + [False] * 4, "jac_penalty": 0},
    )
    return function, against_wind, requirements


class SizingProblems:
    """Programs of one aircraft by their number of scenario blocks, built when first needed.

    ``eased``: see :func:`build_problem`.
    """

    def __init__(self, aircraft: Aircraft) -> None:
        self.aircraft = aircraft
        self._known: dict[tuple[int, bool, bool, Strategy | None], SizingProblem] = {}

    def of(
        self,
        blocks: int,
        *,
        eased: bool = False,
        holds: bool = False,
        climb: Strategy | None = None,
    ) -> SizingProblem:
        """Program with this number of blocks; the rest as for :func:`build_problem`."""
        key = (blocks, eased, holds, climb)
        if key not in self._known:
            self._known[key] = build_problem(
                self.aircraft, blocks, eased=eased, holds=holds, climb=climb
            )
        return self._known[key]
