"""Mass and repeated day of a design as functions with exact derivatives.

The formulas are those of the sizing program: masses, powers and limits of a design, and the day of
:mod:`sizing.optimisation.energy_constraints`. Where the program has the total mass and the charge
at dawn among its variables, they are solved for here, so that a design alone is the argument, and
the implicit function theorem gives the derivatives of what depends on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from functools import lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from scipy.optimize import brentq

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.design import DesignVariables, FlightConditions, parametric_design, variables_of
from sizing.energy.battery import ChargeLimit
from sizing.held_station import refuse_held_station
from sizing.limits import design_requirements
from sizing.mass_budget import ImpossibleDesignError, design_of, lightest_mass_kg
from sizing.optimisation.energy_constraints import (
    NODES,
    SUN_PARAMETERS,
    charge_path,
    cycle_function,
    node_balance,
    smooth_loads_w,
    sun_parameters,
)
from sizing.optimisation.problem import numbers_taken_out
from sizing.optimisation.variables import HORIZONTAL_VOLUME, SOLAR_TECHNOLOGY
from sizing.parameters import all_replaced, catalogue, parameter_value
from sizing.sunlight import SolarDay
from solar.types import FloatArray

# Of each scenario, in the order of the function's results. The last two are rows of the sizing
# program, at the charge at dawn that the required excess time asks for.
DAY_OUTPUTS = (
    "excess_time_h",
    "charge_margin_h",
    "minimum_state_of_charge",
    "battery_capacity",
    "energy_balance",
)
# Technology that acts on the power of the modules or on the battery's condition: neither is a
# function of the design here.
_ELSEWHERE = (
    "modules.mppt_efficiency",
    "modules.camber_efficiency",
    "modules.temperature_coefficient_per_k",
    "battery.temperature.",
    "battery.resistance.",
    "battery.ageing.",
)
# Keep a division by nothing finite.
_NOTHING = 1e-12


class Regime(IntEnum):
    """What decides the charge at dawn."""

    filled = 0  # the day fills the battery, the night empties it
    partly_filled = 1  # the day returns what the night takes, below full charge
    limited = 2  # the battery runs empty


class State(NamedTuple):
    """What a design solves for: total mass [kg], and of each scenario charge at dawn and regime."""

    total_mass_kg: float
    dawn_soc: FloatArray
    regimes: tuple[Regime, ...]

    def vector(self) -> FloatArray:
        """Mass and charges."""
        return np.concatenate(([self.total_mass_kg], self.dawn_soc))

    def weights(self) -> FloatArray:
        """1 for the regime of each scenario and 0 for the others, shape ``(3, scenario)``."""
        return np.eye(len(Regime))[:, list(self.regimes)]


class DesignInDays:
    """Mass and repeated days of one kind of aircraft, with derivatives to its design.

    ``inputs``: names and own values of the arguments: design variables, payload and the technology
    of ``keys``. ``scalars``, ``DAY_OUTPUTS``: names of the results, first those of the design, then
    those of the days, each for all scenarios.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        day: SolarDay,
        keys: Sequence[str] = (),
        *,
        required_h: float = 0.0,
    ) -> None:
        if not isinstance(aircraft.airframe, ParametricAirframe):
            raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget")
        refuse_held_station(mission, "a design with derivatives")
        if mission.climb is not None:
            raise ValueError(f"a day of level flight: remove climb from the mission {mission.name}")
        allowed = [
            key
            for key in numbers_taken_out(aircraft)
            if catalogue()[key].kind == "technology" and not key.startswith(_ELSEWHERE)
        ]
        for key in keys:
            if key not in allowed:
                raise ValueError(f"{key} cannot be an input; these can: {', '.join(allowed)}")
        payload = {
            "payload_mass_kg": mission.payload.mass_kg,
            "payload_power_w": mission.payload.power_w,
        }
        values = variables_of(aircraft).chosen() | payload
        if aircraft.sizes_tail:  # its user keeps the static margin by the row of that name
            values[HORIZONTAL_VOLUME] = design_of(aircraft, mission).horizontal_volume
        values |= {key: parameter_value(aircraft, None, key) for key in keys}
        self.inputs = {name: float(value) for name, value in values.items()}
        self._limit, self._required_h = aircraft.battery.charge_limit, required_h
        self._suns = sun_parameters(day, mission)
        self._express(aircraft, mission, keys)

    def _express(self, aircraft: Aircraft, mission: Mission, keys: Sequence[str]) -> None:
        """Build the functions: budget and powers, results and residuals, and their Jacobians."""
        given, mass = ca.SX.sym("inputs", len(self.inputs)), ca.SX.sym("total_mass")
        symbols = dict(zip(self.inputs, ca.vertsplit(given), strict=True))
        flown = all_replaced(aircraft, {key: symbols[key] for key in keys})
        tail = symbols.get(HORIZONTAL_VOLUME)
        chosen = DesignVariables(
            **{n: v for n, v in symbols.items() if n not in (*keys, HORIZONTAL_VOLUME)}
        )
        conditions = FlightConditions.of(mission, aircraft).with_payload_of(chosen)
        design = parametric_design(flown, conditions, chosen, mass, horizontal_volume=tail)
        brighter = flown.modules.efficiency_stc / aircraft.modules.efficiency_stc
        powers = ca.vertcat(
            chosen.module_area_m2 * (brighter if SOLAR_TECHNOLOGY in keys else 1.0),
            design.battery_energy_wh,
            *smooth_loads_w(flown, design, conditions),
            flown.battery.mean_charge_efficiency,
            flown.battery.mean_discharge_efficiency,
        )
        rows = [
            row
            for row in design_requirements(flown, design, conditions)
            if row.name != "mass_budget"
        ]
        single = {"total_mass_kg": mass, "airspeed_m_per_s": design.airspeed_m_per_s}
        single |= {row.name: row.value for row in rows}
        self.scalars = tuple(single)
        budget = ca.vertcat(design.masses.total_kg)
        self._of_design = ca.Function(
            "design", [given, mass], [budget, powers, ca.vertcat(*single.values())]
        )
        self._results, self._jacobians = self._with_days()

    def _with_days(self) -> tuple[ca.Function, ca.Function]:
        """Results of inputs, state and regimes; the Jacobians of results and residuals to both."""
        count = len(self._suns)
        given, state = ca.MX.sym("inputs", len(self.inputs)), ca.MX.sym("state", 1 + count)
        regimes = ca.MX.sym("regimes", len(Regime), count)
        budget, powers, single = self._of_design(given, state[0])
        day = day_function(self._limit)
        days = [
            day(powers, state[1 + i], self._required_h, regimes[:, i], sun)
            for i, sun in enumerate(self._suns)
        ]
        of_days = ca.vertcat(*(ca.vertcat(*of) for of in list(zip(*days, strict=True))[:-1]))
        results = ca.vertcat(single, of_days)
        residuals = ca.vertcat(budget - state[0], *(of[-1] for of in days))
        arguments = [given, state, regimes]
        jacobians = [ca.jacobian(y, x) for y in (results, residuals) for x in (given, state)]
        return (
            ca.Function("results", arguments, [results]),
            ca.Function("jacobians", arguments, jacobians),
        )

    def solved(self, values: FloatArray) -> State:
        """Total mass, and charge at dawn of the repeated day, of a design.

        ``values``: in the order of ``inputs``. Raises :class:`ImpossibleDesignError` for a design
        that cannot carry its own mass.
        """

        def budget_kg(mass_kg: FloatArray, _: Any) -> FloatArray:
            return np.array([float(self._of_design(values, m)[0]) for m in mass_kg])

        given = dict(zip(self.inputs, values, strict=True))
        start_kg = np.array([given["battery_mass_kg"] + given["payload_mass_kg"]])
        (mass_kg,) = lightest_mass_kg(budget_kg, start_kg)
        if not np.isfinite(mass_kg):
            raise ImpossibleDesignError("the design cannot carry its own mass")
        powers = np.asarray(self._of_design(values, mass_kg)[1]).ravel()
        dawns = [self._dawn(powers, sun) for sun in self._suns]
        return State(
            float(mass_kg), np.array([dawn for dawn, _ in dawns]), tuple(r for _, r in dawns)
        )

    def _dawn(self, powers: FloatArray, sun: FloatArray) -> tuple[float, Regime]:
        """Charge at dawn of the repeated day, 0 where the battery runs empty, and what decides."""
        cycle = cycle_function(self._limit)

        def day(dawn: float) -> tuple[float, float]:
            deficit, charged = cycle(*powers[:4], dawn, powers[4:], sun)
            return float(deficit), float(charged)

        deficit, from_empty = day(0.0)
        best = 1.0 - deficit
        if best < 0.0 or from_empty < deficit:
            return 0.0, Regime.limited
        if day(best)[1] >= 1.0:
            return best, Regime.filled
        dawn = brentq(lambda soc: day(soc)[1] - soc - deficit, 0.0, best, xtol=1e-14)
        return float(dawn), Regime.partly_filled

    def results(self, values: FloatArray, state: State) -> FloatArray:
        """Scalars and results of the days at a design and its :meth:`solved` state."""
        return np.asarray(self._results(values, state.vector(), state.weights())).ravel()

    def jacobian(self, values: FloatArray, state: State) -> FloatArray:
        """Derivatives of the results to the inputs, within the regimes of the state."""
        by_input, by_state, moved, held = (
            np.asarray(j) for j in self._jacobians(values, state.vector(), state.weights())
        )
        return np.asarray(by_input - by_state @ np.linalg.solve(held, moved))


@lru_cache(maxsize=32)
def day_function(charge_limit: ChargeLimit) -> ca.Function:
    """Metrics of one scenario and the residual of its charge at dawn.

    Arguments: module area [m2], capacity [Wh], nominal load and propulsion power [W] and
    efficiencies of charge and discharge; state of charge at dawn; required excess time [h]; 1 for
    its :class:`Regime`, else 0; the sun as :func:`sun_parameters` gives it.
    """
    powers, dawn, required_h = ca.SX.sym("powers", 6), ca.SX.sym("dawn"), ca.SX.sym("required")
    regime, sun = ca.SX.sym("regime", len(Regime)), ca.SX.sym("sun", SUN_PARAMETERS)
    area, capacity_wh, nominal_w, propulsion_w, charging, discharging = ca.vertsplit(powers)
    net, deficit_wh, step_h, dark_h = node_balance(area, nominal_w, propulsion_w, sun)
    usable_wh = capacity_wh * discharging
    deficit = deficit_wh / usable_wh
    rate = charging * net / capacity_wh
    path = charge_path(charge_limit, dawn, rate, step_h)
    required = required_h * nominal_w / usable_wh
    returned = charge_path(charge_limit, required, rate, step_h)[-1]
    unserved_wh = deficit_wh - ca.fmin(path[-1], 1.0) * usable_wh
    missing_h = _missing_h(net, nominal_w, step_h, dark_h, unserved_wh)
    perpetual = 1.0 - regime[Regime.limited]
    excess_h = perpetual * dawn * usable_wh / nominal_w - regime[Regime.limited] * missing_h
    residual = (
        regime[Regime.filled] * (dawn + deficit - 1.0)
        + regime[Regime.partly_filled] * (dawn + deficit - path[-1])
        + regime[Regime.limited] * dawn
    )
    rows = [1.0 - required - deficit, returned - required - deficit]
    return ca.Function(
        "day",
        [powers, dawn, required_h, regime, sun],
        [excess_h, _full_h(net, path, step_h), perpetual * dawn, *rows, residual],
        {"is_diff_in": [True, True, False, False, False], "never_inline": True, "jac_penalty": 0},
    )


def _full_h(net: Any, path: Sequence[Any], step_h: Any) -> Any:
    """Hours of surplus after the first full charge: the path of the charge passes 1."""
    total = 0.0
    for k in range(NODES - 1):
        left, right = net[k], net[k + 1]
        sunlit = (ca.fmax(left, 0.0) + ca.fmax(right, 0.0)) / (
            ca.fabs(left) + ca.fabs(right) + 1e-9
        )
        after = (path[k + 1] - 1.0) / (path[k + 1] - path[k] + _NOTHING)
        total += sunlit * ca.fmax(ca.fmin(after, 1.0), 0.0)
    return total * step_h


def _missing_h(net: Any, nominal_w: Any, step_h: Any, dark_h: Any, unserved_wh: Any) -> Any:
    """Hours before the morning's surplus whose deficits add up to what cannot be served."""
    short = [ca.fmax(-net[k], 0.0) for k in range(NODES)]
    noon = NODES // 2
    spans = []
    for k in [*range(noon - 1, -1, -1), None, *range(NODES - 2, noon - 1, -1)]:
        if k is None:
            spans.append((nominal_w, nominal_w, dark_h))
        else:
            share = (short[k] + short[k + 1]) / (ca.fabs(net[k]) + ca.fabs(net[k + 1]) + 1e-9)
            spans.append((short[k], short[k + 1], share * step_h))
    hours, later_wh = 0.0, 0.0
    for before, after, length in spans:
        energy = (before + after) / 2.0 * length
        goal = ca.fmax(ca.fmin(unserved_wh - later_wh, energy), 0.0) / (length + _NOTHING)
        # As sizing.energy.power_balance.ramp_fraction, from the end of the interval.
        root = ca.sqrt(ca.fmax(after**2 + 2.0 * (before - after) * goal, 0.0) + _NOTHING)
        hours += length * 2.0 * goal / (after + root + _NOTHING)
        later_wh += energy
    return hours
