"""The best heights of a day for a known design: the sizing program with its design held.

Light and power of the design at all heights are known; what is unknown is charge and height along
the day. The excess time is as long as any schedule makes it, and where none closes the day the
hours that lack power are as few as can be.
"""

from __future__ import annotations

from functools import lru_cache
from threading import RLock
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from sizing.battery.battery import ChargeLimit
from sizing.day.battery import Store
from sizing.day.cycle import simulate_cycle
from sizing.day.heights import FlightLevels
from sizing.day.metrics import Cycle
from sizing.program.intervals import (
    CutDay,
    Day,
    Held,
    efficiencies,
    light_at_heights,
)
from sizing.program.transcription import (
    FIRST_MARGIN,
    FULLER,
    INSIDE,
    IPOPT,
    LEVELS,
    LONGEST_H,
    PRICE,
    RESERVE_SCALE_H,
    BlockData,
    DesignSymbols,
    Form,
    Unknowns,
    block_symbols,
    day_rows,
    lagrange,
)
from solar.types import FloatArray

FORM = Form(1, climbs=True)
_HEIGHTS = slice(-FORM.heights, None)
_FIRST_CHARGE = 1 + FORM.intervals
_CHARGES = slice(_FIRST_CHARGE, -FORM.heights)
_ROUNDS = 6  # of program and simulator, at most
_AGREED_H = 0.02  # excess time within which they agree
_WIDER = 3.0  # factor on the margin of a day's return where that is too little
LOWEST_M = 1.0  # a shorter way to climb is none


class Climbs(NamedTuple):
    """Cycles of elements along heights of their own; arrays ``(element, time)``.

    ``program_h``: excess time that the program has of the heights, NaN in level flight; None of
    heights that are not its own.
    """

    cycle: Cycle
    height_m: FloatArray
    solar_w: FloatArray
    load_w: FloatArray
    program_h: FloatArray | None = None


class Window(NamedTuple):
    """Part of a flight, of a day at most, from one solar time to another [h] with some charge."""

    begin_h: float
    end_h: float
    begin_wh: float

    def day(self, time_h: FloatArray, solar_w: FloatArray, load_w: FloatArray) -> Day:
        """Powers of a repeated day in it."""
        axis = np.concatenate([time_h, time_h[1:] + 24.0])
        twice = (np.concatenate([power_w, power_w[:, 1:]], axis=1) for power_w in (solar_w, load_w))
        return Day.between(np.array([self.begin_h, self.end_h]), axis, *twice)


def best_climbs(time_h: FloatArray, levels: FlightLevels, store: Store) -> Climbs:
    """Simulate every element along the heights with which its excess time is longest."""
    best_m = np.zeros((len(levels.scenario), len(time_h)))
    level = climbs = flown_along(time_h, levels, store, best_m)
    best_h = level.cycle.excess_time_h
    able = levels.flies & (levels.reach_m > LOWEST_M) & np.isfinite(best_h)
    able &= level.solar_w.max(axis=-1) > 0.0
    goal_h, margin = best_h.copy(), np.full(len(best_h), FIRST_MARGIN)
    program_h = np.full(len(best_h), np.nan)
    for _ in range(_ROUNDS):
        if not able.any():
            break
        height_m = best_m.copy()
        for i in np.flatnonzero(able).tolist():
            height_m[i], goal_h[i] = best_heights(
                time_h, levels, store, climbs, i, margin=float(margin[i])
            )
        climbs = flown_along(time_h, levels, store, height_m)
        excess_h = climbs.cycle.excess_time_h
        better = excess_h > best_h
        best_m = np.where(better[:, np.newaxis], height_m, best_m)
        program_h = np.where(better, goal_h, program_h)
        best_h = np.maximum(excess_h, best_h)
        # A day that should close, and does not quite.
        margin = np.where(climbs.cycle.missing_h > 0.0, _WIDER * margin, margin)
        able &= ~np.isclose(goal_h, excess_h, rtol=0.0, atol=_AGREED_H)
        able &= goal_h > _AGREED_H
    if not best_m.any():
        return level
    if not np.array_equal(climbs.height_m, best_m):
        climbs = flown_along(time_h, levels, store, best_m)
    return climbs._replace(program_h=program_h)


def flown_along(
    time_h: FloatArray,
    levels: FlightLevels,
    store: Store,
    height_m: FloatArray,
    *,
    of_others: bool = False,
) -> Climbs:
    """Simulate elements along heights above the lowest altitude [m], ``(element, time)``.

    ``of_others``: heights that were chosen for other elements, of which each flies the share that
    its reach and its largest power allow; without a trajectory.
    """
    if of_others:
        height_m = np.minimum(height_m, levels.reach_m[:, np.newaxis])
    solar_w, load_w = levels.powers_along(time_h, height_m)
    if of_others:
        most_w = levels.most_power_w + levels.constant_power_w
        short = np.flatnonzero((load_w > most_w[:, np.newaxis]).any(axis=-1) & levels.flies)
        if len(short):
            few, high = levels.select(short), height_m[short]
            _, level_w = few.powers_along(time_h, np.zeros_like(high))
            rise_w = load_w[short] - level_w
            share = (most_w[short, np.newaxis] - level_w) / np.where(rise_w > 0.0, rise_w, 1.0)
            share = np.clip(np.where(rise_w > 0.0, share, 1.0).min(axis=-1, keepdims=True), 0, 1)
            height_m[short] = share * high
            solar_w[short], load_w[short] = few.powers_along(time_h, height_m[short])
    cycle = simulate_cycle(
        time_h,
        solar_w,
        load_w,
        store,
        nominal_load_w=levels.nominal_load_w,
        keep_trajectory=not of_others,
        climbs=True,
    )
    return Climbs(cycle, height_m, solar_w, load_w)


def best_heights(
    time_h: FloatArray,
    levels: FlightLevels,
    store: Store,
    climbs: Climbs,
    i: int,
    window: Window | None = None,
    margin: float = 0.0,
) -> tuple[FloatArray, float]:
    """Return the best heights of an element around a flight of it [m], and its excess time.

    The excess time is below zero by the hours that lack power.

    Of the day that repeats itself, or of a window, which begins and ends at the lowest altitude.
    ``margin``: by how much more a night takes, relative.
    """
    around = _Around.of(time_h, levels, store.select(slice(i, i + 1)), climbs, i, window)
    day, nominal_w = around.day, float(levels.nominal_load_w[i])
    design, unit_wh = _design(levels, i, around), RESERVE_SCALE_H * nominal_w
    block = _block(design, around, nominal_w, margin)
    data = (*efficiencies(around.store), nominal_w, around.climb_m)
    start = (
        [max(float(climbs.cycle.excess_time_h[i]), 0.0)],
        np.full(FORM.intervals, INSIDE[0]),
        np.clip(day.soc, *INSIDE) * around.full_wh / unit_wh,
        np.clip(day.share, *INSIDE),
    )
    x0 = np.concatenate(start)
    low, most = np.zeros(len(x0)), np.full(len(x0), np.inf)
    most[0], most[_HEIGHTS] = LONGEST_H, 1.0
    low[_CHARGES] = day.least_wh / unit_wh
    if window is not None:  # which begins and ends without height
        low[_FIRST_CHARGE] = most[_FIRST_CHARGE] = window.begin_wh / unit_wh
        most[_HEIGHTS.start] = 0.0
    solver, upper, lock = _program(store.clock.limit, window is None)
    parameters = np.concatenate([np.ravel(value) for value in (*data, *design, *block)])
    bounds: dict[str, Any] = {"lbx": low, "ubx": most, "lbg": 0.0, "ubg": upper}
    with lock:
        answer = solver(x0=np.clip(x0, low, most), p=parameters, **bounds)
    x = np.asarray(answer["x"]).ravel()
    excess_h = float(x[0] - x[1:_FIRST_CHARGE] @ day.means.hours)
    heights = np.interp(time_h, day.clock_h % 24.0, np.clip(x[_HEIGHTS], 0.0, 1.0), period=24.0)
    return np.asarray(around.climb_m * heights), excess_h


class _Around(NamedTuple):
    """Flight of an element, around which its program is made.

    ``climb_m``: way to its ceiling. ``light_w``: mean power of the modules by heights and
    intervals. ``power_w``: of level flight, by heights.
    """

    store: Store
    climb_m: float
    day: CutDay
    light_w: FloatArray
    power_w: FloatArray

    @property
    def full_wh(self) -> float:
        """Energy of its battery at full charge."""
        return float(self.store.battery_energy_wh[0])

    @classmethod
    def of(
        cls,
        time_h: FloatArray,
        levels: FlightLevels,
        store: Store,
        climbs: Climbs,
        i: int,
        window: Window | None,
    ) -> _Around:
        """Flight of an element ``i``, whose battery ``store`` is."""
        full_wh, climb_m = float(store.battery_energy_wh[0]), float(levels.reach_m[i])
        light, power_w = levels.at_heights(i, np.linspace(0.0, climb_m, LEVELS))
        dark, powers = np.zeros_like(light), (climbs.solar_w[i : i + 1], climbs.load_w[i : i + 1])
        if window is None:
            whole = Day.of(time_h, *powers)
            at_heights = Day.of(time_h, light, dark, whole.first)
            at = (whole.first + np.arange(len(time_h))) % (len(time_h) - 1)
            path = climbs.cycle.energy_wh[i][at] / full_wh
        else:
            whole = window.day(time_h, *powers)
            at_heights = window.day(time_h, light, dark)
            path = whole.path(store, window.begin_wh / full_wh)
        share = np.interp(whole.time_h % 24.0, time_h, climbs.height_m[i]) / climb_m
        day = CutDay.of(whole, path, store, float(levels.nominal_load_w[i]), FORM, share)
        light_w = light_at_heights(at_heights, day.nodes, day.share, day.means.light_w[0])
        return cls(store, climb_m, day, light_w, power_w)


def _design(levels: FlightLevels, i: int, around: _Around) -> DesignSymbols:
    """Return the numbers of an element's design."""
    return DesignSymbols(
        area_m2=1.0,
        full_wh=around.full_wh,
        log_power_w=np.log(around.power_w),
        airspeed_m_per_s=np.ones(LEVELS),
        constant_w=levels.constant_power_w[i],
        payload_w=0.0,
        steady=float(levels.nominal_ratio[i]),
        rated_w=levels.most_power_w[i],
        efficiency=levels.efficiency[i],
        weight_n=levels.weight_n[i],
    )


def _block(design: DesignSymbols, around: _Around, nominal_w: float, margin: float) -> BlockData:
    """Return the data of the day of a design that is held, without slopes."""
    day, share, hours = around.day, around.day.share, around.day.means.hours
    middle = np.stack(lagrange((share[1:] + share[:-1]) / 2.0, LEVELS))
    climb_w = design.weight_n / design.efficiency * np.diff(share) * around.climb_m
    floor_w = around.power_w[0]
    beyond_w = (np.exp(design.log_power_w @ middle) - floor_w) * design.steady
    beyond_w = beyond_w + climb_w / (3600.0 * hours)
    level_w = floor_w * design.steady + design.constant_w
    held = Held.nowhere(hours)
    return BlockData(
        hours=hours,
        limit_h=held.limit_h,
        most=held.most,
        light_w_per_m2=around.light_w.ravel(order="F"),
        load=(day.means.load_w[0] - beyond_w) / level_w,
        nominal=nominal_w / level_w,
        light_slope=np.zeros(0),
        load_slope=np.zeros(0),
        shift_h=0.0,
        shift_slope_h=np.zeros(0),
        reserve=day.reserve.astype(float),
        margin=margin,
        continuous=0.0,
        lowest_w_per_m2=0.0,
        repeated=1.0,
        wind_m_per_s=np.zeros(LEVELS),
        share=share,
    )


@lru_cache(maxsize=8)
def _program(limit: ChargeLimit, repeated: bool) -> tuple[ca.Function, FloatArray, RLock]:
    """Return the solver of a charge limit for known designs, upper ends of rows, and its lock.

    For a day that repeats itself or a window; built once.
    """
    sizes = {"efficiencies": 2, "reference_w": 1, "ceiling_m": 1}
    data = {name: ca.SX.sym(name, size) for name, size in sizes.items()}
    sizes = dict.fromkeys(DesignSymbols._fields, 1)
    sizes |= {"log_power_w": LEVELS, "airspeed_m_per_s": LEVELS}
    design = DesignSymbols(*(ca.SX.sym(name, size) for name, size in sizes.items()))
    block, none = block_symbols(0, FORM), ca.SX(0, 1)
    excess_h, lack = ca.SX.sym("excess"), ca.SX.sym("lack", FORM.intervals)
    charge, height = (ca.SX.sym(name, FORM.heights) for name in ("charge", "height"))
    unknown = Unknowns(excess_h, lack, charge, height, none)
    rows = day_rows(limit, FORM, design, block, unknown, none, {**data, "centre": none})
    ends = {"launch", "continuous"} | (set() if repeated else {"energy_balance"})
    rows = [(c, value) for c, value in rows if c.name not in ends]
    # What ends a flight is to come late.
    dear = np.ones(FORM.intervals) if repeated else np.linspace(2.0, 1.0, FORM.intervals)
    lacking_h = ca.dot(lack * dear, block.hours)
    symbols = {
        "x": ca.vertcat(excess_h, lack, charge, height),
        "p": ca.vertcat(*data.values(), *design, *block),
        "f": (PRICE * lacking_h - excess_h) / RESERVE_SCALE_H - FULLER * ca.sum1(charge),
        "g": ca.vertcat(*(value for _, value in rows)),
    }
    equation = [c.equation for c, value in rows for _ in range(value.shape[0])]
    solver = ca.nlpsol("schedule", "ipopt", symbols, IPOPT)
    return solver, np.where(equation, 0.0, np.inf), RLock()
