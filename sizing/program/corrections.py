"""What the simulator finds for a design and its neighbours, as data of the program.

A model of low fidelity is corrected by one of high fidelity until both agree (Alexandrov, Lewis,
Gumbert, Green and Newman 2001, J. Aircraft 38:1093): the program has the light and the load along
the day as the simulated flight of its last design has them, with their first derivatives by the
design from a batch of neighbours. Whatever the simulator knows of a design is in them: thermals,
the flow that cools the modules, the operating point of the propulsion.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from sizing.day.battery import Store
from sizing.design import Design
from sizing.limits import design_requirements
from sizing.mass_budget import closed_design
from sizing.performance import Performance
from sizing.program.climbing import Profile, power_beyond_floor
from sizing.program.intervals import (
    CutDay,
    Day,
    Held,
    deficit_wh,
    equal_power_step,
    held_back,
    light_at_heights,
)
from sizing.program.task import SizingTask, Values
from sizing.program.transcription import (
    FIRST_MARGIN,
    INSIDE,
    LEVELS,
    RESERVE_SCALE_H,
    BlockData,
    PartsData,
    power_surface,
)
from sizing.program.variables import scales_of
from solar.types import FloatArray, IntArray

STEP = 1e-3  # of a neighbour, in the program's variable
# Excess time above the required one that is aimed at: steps leave so much between simulator and
# program.
CUSHION_H = 5e-4
_NEVER = -10.0  # logarithm of what is far from its limit
# For second derivatives: its square is far above what root finders leave.
_WIDE_STEP = 0.02
_STEEPEST = 3.0  # slope of a logarithm; more is one of a neighbour that hardly flies


@dataclass(frozen=True)
class Linearisation:
    """Light and load of a simulated design in the blocks of a program, with their derivatives.

    ``values``: of the design. ``days``, ``held``: of every block, its intervals and how the battery
    holds back in them. ``speed``: of every block, to start from. ``load_w``: nominal load that
    charges count in. ``full_wh``, ``mass_kg``: of the design. ``parts``: of a propulsion at its
    operating point. ``known``: of the scenarios.
    """

    values: dict[str, float]
    blocks: tuple[BlockData, ...]
    days: tuple[CutDay, ...]
    held: tuple[Held, ...]
    speed: tuple[FloatArray, ...]
    load_w: float
    full_wh: float
    mass_kg: float
    parts: PartsData | None
    known: dict[int, Scenario]
    reach: float = math.inf

    @property
    def charge(self) -> FloatArray:
        """State of charge at the nodes of all blocks, to start from, in the program's unit."""
        soc = np.clip(np.concatenate([day.soc for day in self.days]), *INSIDE)
        return np.asarray(soc * self.full_wh / self._unit_wh)

    @property
    def least(self) -> FloatArray:
        """Charge that must be left there, in the program's unit."""
        least_wh = np.concatenate([day.least_wh for day in self.days])
        return np.asarray(least_wh / self._unit_wh)

    @property
    def height(self) -> FloatArray:
        """Heights at the nodes, to start from, over the way to the ceiling."""
        share = np.concatenate([block.share for block in self.blocks])
        return np.asarray(np.clip(share, *INSIDE))

    @property
    def _unit_wh(self) -> float:
        return RESERVE_SCALE_H * self.load_w


@dataclass
class Scenario:
    """What a search knows of a scenario.

    ``bias_h``: excess time that programs have beyond their flights. ``margin``: by how much more a
    night takes, relative. ``begin``: state of charge that the last program begins its day with.
    ``profile``: heights that are flown.
    """

    bias_h: float = CUSHION_H
    margin: float = FIRST_MARGIN
    begin: float | None = None
    profile: Profile | None = None


def neighbours(task: SizingTask, values: Values) -> list[Values]:
    """Return a design, and one more for each variable that is moved by a step."""
    return [values, *(_moved(task, values, {name: STEP}) for name in task.moved)]


def _moved(task: SizingTask, values: Values, steps: Mapping[str, float]) -> Values:
    """Return a design with variables moved by steps of the program's variable."""
    moved = dict(values)
    for v, scale in zip(task.variables, scales_of(task.variables, values), strict=True):
        if v.name in steps:
            x = v.to_program(values[v.name], scale) + steps[v.name]
            moved[v.name] = float(v.from_program(x, scale))
    return moved


def linearised(
    task: SizingTask,
    values: Values,
    perf: Performance,
    known: Mapping[int, Scenario],
    like: Linearisation | None = None,
) -> Linearisation:
    """Return light and load of a design in scenarios, from its flight and its neighbours'.

    ``perf``: of :func:`neighbours`, in all scenarios of the task. ``known``: what is known of the
    scenarios that make the blocks, in their order. ``like``: one of the same scenarios, whose
    intervals, and how the battery holds back in them, are kept.
    """
    nominal_w = np.asarray(perf.nominal_load_w)
    nominal_w = np.broadcast_to(nominal_w, (nominal_w.shape[0], task.count))
    ordered_w = np.sort(nominal_w[0])  # a median by hand: NumPy's imports masked arrays
    blocks = [
        _block(
            task,
            perf,
            number,
            scenario,
            nominal_w[:, number],
            None if like is None else (like.days[i].nodes, like.held[i]),
        )
        for i, (number, scenario) in enumerate(known.items())
    ]
    data, days, held = zip(*blocks, strict=True)
    speeds = task.form(len(known)).speeds
    return Linearisation(
        dict(values),
        data,
        days,
        held,
        speed=tuple(np.full(speeds, _speed(task, perf, number)) for number in known),
        load_w=float(ordered_w[(task.count - 1) // 2] + ordered_w[task.count // 2]) / 2.0,
        full_wh=float(np.asarray(perf.design.battery_energy_wh)[0]),
        mass_kg=float(np.asarray(perf.design.total_mass_kg)[0]),
        parts=_parts(task, values, perf),
        known={number: replace(scenario) for number, scenario in known.items()},
    )


def day_of(task: SizingTask, perf: Performance, number: int) -> Day:
    """Return the powers of a batch of designs in a scenario, over its day or the flight."""
    time_h = task.day.time_h
    shape = (np.size(perf.design.total_mass_kg), task.count, len(time_h))
    solar_w, load_w = (
        np.broadcast_to(power_w, shape)[:, number] for power_w in (perf.solar_power_w, perf.load_w)
    )
    if task.window_h is None:
        return Day.of(time_h, solar_w, load_w)
    ends_h, steps = task.window_h[number], task.form(1).intervals
    return Day.between(ends_h, time_h, solar_w, load_w, least_steps=steps)


def unserved(task: SizingTask, perf: Performance, number: int) -> float:
    """Energy that the load of a design lacks in a scenario, relative to what its night takes."""
    day = day_of(task, perf, number)
    lacking_wh = np.broadcast_to(perf.cycle.energy_budget.unserved_wh, perf.cycle.status.shape)
    return float(lacking_wh[0, number]) / max(deficit_wh(day), 1e-9)


def _speed(task: SizingTask, perf: Performance, number: int) -> float:
    """Logarithm of the airspeed that holds the place at the floor, over the design's."""
    airspeed_m_per_s = float(np.ravel(perf.design.airspeed_m_per_s)[0])
    return math.log(max(float(task.winds_m_per_s[number, 0]) / airspeed_m_per_s, 1.0))


def _parts(task: SizingTask, values: Values, perf: Performance) -> PartsData | None:
    """What is known of a propulsion at its operating point."""
    names = task.aircraft.propulsion.limit_names
    if not names:
        return None
    design, count = perf.design, len(task.variables)
    if len(np.ravel(design.total_mass_kg)) == 1:  # without its neighbours
        designs = task.stacked(neighbours(task, values))
        design = closed_design(task.simulated_aircraft, task.mission, designs)
    assert design.chain is not None
    limits = {row.name: row.value for row in design_requirements(task.simulated_aircraft, design)}
    every = (design.chain.efficiency, design.masses.propulsion, *(1.0 - limits[n] for n in names))
    count_of = len(design.total_mass_kg)
    logs = np.log(np.stack([np.broadcast_to(row, count_of) for row in every], 1))
    if task.beyond_limits:
        logs[:, 2:] = _NEVER
    places = [task.names.index(name) for name in task.moved]
    bend = np.zeros((count, count))
    bend[np.ix_(places, places)] = _bend(task, values)
    surface = _surface(task, design.mapped(lambda v: float(np.ravel(v)[0])))
    slope = _derivatives(task, logs)
    return PartsData(logs[0], slope.ravel(order="F"), bend.ravel(), surface)


def _bend(task: SizingTask, values: Values) -> FloatArray:
    """Second derivatives of the logarithm of a design's efficiency by what is moved.

    The best of a propulsion lies where nothing changes to the first order. Only what makes designs
    farther away worse counts: the rest has no optimum.
    """
    names, count, h = task.moved, len(task.moved), _WIDE_STEP
    pairs = [(i, j) for i in range(count) for j in range(i)]
    steps: list[dict[str, float]] = [{}, *({n: h} for n in names), *({n: -h} for n in names)]
    steps += [{names[i]: h, names[j]: h} for i, j in pairs]
    designs = task.stacked([_moved(task, values, step) for step in steps])
    chain = closed_design(task.simulated_aircraft, task.mission, designs).chain
    assert chain is not None
    centre, *others = np.log(np.asarray(chain.efficiency))
    ahead, behind, both = np.split(np.array(others), [count, 2 * count])
    bend = np.diag(ahead - 2.0 * centre + behind)
    for (i, j), there in zip(pairs, both, strict=True):
        bend[i, j] = bend[j, i] = there - ahead[i] - ahead[j] + centre
    bend = np.nan_to_num(bend / h**2)
    sizes, axes = np.linalg.eigh(bend)
    return np.asarray(axes @ np.diag(np.minimum(sizes, 0.0)) @ axes.T)


def _surface(task: SizingTask, design: Design) -> FloatArray:
    """Power of a design's parts by heights and airspeeds over that with its chain, logarithm."""
    form, variables = task.form(1), design.variables
    if form.levels * form.ratios == 1:
        return np.zeros(1)
    airs = [air.with_payload_of(variables) for air in task.airs]
    by_parts, by_chain = (
        np.array(power_surface(task.simulated_aircraft, form, airs, variables, it)[0], float)
        for it in (design._replace(chain=None), design)
    )
    return np.asarray(np.nan_to_num(np.log(by_parts / by_chain)).ravel(order="F"))


def _block(
    task: SizingTask,
    perf: Performance,
    number: int,
    scenario: Scenario,
    nominal_w: FloatArray,
    known: tuple[IntArray, Held] | None,
) -> tuple[BlockData, CutDay, Held]:
    """Data of one scenario, its day, and how the battery holds back, where that is not known."""
    whole = day_of(task, perf, number)
    store = perf.store.flat((len(nominal_w), task.count)).select(np.array([0]))
    path = _path(task, perf, whole, number, store, scenario.begin)
    form, share = task.form(1), np.zeros(len(whole.time_h))
    if scenario.profile is not None:
        share = scenario.profile.at(whole.time_h)
    nodes, held = known or (None, None)
    day = CutDay.of(whole, path, store, float(nominal_w[0]), form, share, nodes)
    held = held or held_back(store, day.soc, day.means)
    light, load, mean_light = _light_and_load(task, perf, number, whole, day, nominal_w)
    load[:, :-1] += held.turned_away_w
    level_w = np.asarray(perf.design.load_in_turbulence_w(task.mission.turbulence.all_day))
    if task.mission.holds_station or task.mission.climb is not None:
        level_w = nominal_w  # as fast as the wind of the scenario
    load = load / level_w[:, np.newaxis]
    if task.aircraft.propulsion_by_parts is not None:
        # Where a day does not close its voltages leap, and the load has no derivative.
        closes = np.broadcast_to(perf.cycle.perpetual, (len(load), task.count))[:, number]
        load = np.where((closes & closes[0])[:, np.newaxis], load, load[0])
    shift_h = np.zeros(len(nominal_w))
    if task.window_h is None:  # of a landing, which is a node, the program knows all
        shift_h = _beyond_h(perf, whole, number, day.nodes[day.reserve], nominal_w)
    block = BlockData(
        hours=day.means.hours,
        limit_h=held.limit_h,
        most=held.most,
        light_w_per_m2=mean_light,
        load=load[0, :-1],
        nominal=load[0, -1],
        light_slope=_slopes(task, light),
        load_slope=_slopes(task, load),
        shift_h=shift_h[0] + scenario.bias_h,
        shift_slope_h=_derivatives(task, shift_h[:, np.newaxis]).ravel(),
        reserve=day.reserve.astype(float),
        margin=scenario.margin,
        continuous=float(task.continuous),
        lowest_w_per_m2=task.continuous * light[0, -1],
        repeated=float(task.window_h is None),
        wind_m_per_s=task.winds_m_per_s[number],
        share=day.share if form.climbs else np.zeros(0),
    )
    least_wh = day.least_wh + CUSHION_H * nominal_w[0]
    return block, day._replace(least_wh=least_wh), held


def _light_and_load(
    task: SizingTask,
    perf: Performance,
    number: int,
    whole: Day,
    day: CutDay,
    nominal_w: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Specific power and load of a batch over the intervals of a day, and light at all heights.

    After the intervals: the lowest light of the day, and the nominal load.
    """
    area = np.asarray(perf.design.variables.module_area_m2)[:, np.newaxis]
    lowest = whole.solar_w.min(axis=-1, keepdims=True) / area
    light = np.hstack([day.means.light_w / area, lowest])
    load_w, mean_light = day.means.load_w, light[0, :-1]
    if (levels := perf.levels) is not None:
        load_w = load_w - power_beyond_floor(task, perf.design, number, day)
        way_m = np.linspace(0.0, levels.altitude_m[-1] - levels.altitude_m[0], LEVELS)
        rows, _ = levels.at_heights(number, way_m)  # of the first design
        at_heights = Day.of(task.day.time_h, rows, np.zeros_like(rows), whole.first)
        mean_light = light_at_heights(at_heights, day.nodes, day.share, mean_light).ravel(order="F")
    return light, np.hstack([load_w, nominal_w[:, np.newaxis]]), mean_light


def _beyond_h(
    perf: Performance, day: Day, number: int, nodes: IntArray, nominal_w: FloatArray
) -> FloatArray:
    """Excess time of designs at the nodes of a morning beyond that of their flights [h].

    The program knows the charge at nodes alone, of which the least is not that at equal power. Zero
    where the day of the first design does not close, and as for it where that of another does not.
    """
    shape = (len(nominal_w), *perf.cycle.status.shape[1:])
    hours = np.broadcast_to(perf.cycle.excess_time_h, shape)[:, number]
    closes = np.isfinite(hours) & (hours > 0.0)
    if not closes[0]:
        return np.zeros(len(nominal_w))
    steps = perf.cycle.energy_wh.shape[-1] - 1
    energy_wh = np.broadcast_to(perf.cycle.energy_wh, (*shape, steps + 1))[:, number]
    least_wh = energy_wh[:, (day.first + nodes) % steps].min(axis=-1)
    beyond_h = least_wh * perf.store.discharge_efficiency / nominal_w - hours
    return np.asarray(np.where(closes, beyond_h, beyond_h[0]))


def _path(
    task: SizingTask, perf: Performance, day: Day, number: int, store: Store, begin: float | None
) -> FloatArray:
    """State of charge over a day that repeats itself, or over a flight from its launch.

    ``store``: battery of the first design. ``begin``: state of charge that a day begins with which
    does not close; where none is planned, what lasts until equal power, with the required excess
    time left, or as much more as the day is short of a full battery.
    """
    if task.window_h is not None:
        return day.path(store, 1.0)
    full_wh = float(store.battery_energy_wh[0])
    if perf.cycle.sufficient[0, number]:
        charge = perf.cycle.energy_wh[0, number]
        steps = len(charge) - 1
        return np.asarray(charge[(day.first + np.arange(steps + 1)) % steps] / full_wh)
    if begin is not None:
        return day.path(store, begin)
    nominal_w = float(np.broadcast_to(perf.nominal_load_w, perf.cycle.status.shape)[0, number])
    needed_wh = deficit_wh(day, equal_power_step(day, nominal_w)) + task.goal_h * nominal_w
    battery = task.aircraft.battery
    into, out_of = battery.mean_charge_efficiency, battery.mean_discharge_efficiency
    needed = needed_wh / out_of / full_wh
    taken = np.cumsum(day.stored_wh(into, out_of)[0]) / full_wh
    return day.path(store, min(max(needed, 1.0 - float(taken.max())), 1.0))


def _slopes(task: SizingTask, values: FloatArray) -> FloatArray:
    """Derivative of the logarithm of some values by every variable, column by column.

    ``values``: of a design and its neighbours. Zero where there is nothing, or no neighbour flies.
    """
    positive = (values > 0.0).all(axis=0)
    slopes = _derivatives(task, np.log(np.where(positive, values, 1.0)))
    return np.clip(slopes, -_STEEPEST, _STEEPEST).ravel(order="F")


def _derivatives(task: SizingTask, values: FloatArray) -> FloatArray:
    """Derivatives by every variable, ``(value, variable)``, of the values of a design.

    ``values``: ``(design, value)``, of a design and its neighbours; of the design alone there are
    none.
    """
    slopes = np.zeros((values.shape[1], len(task.variables)))
    places = [task.names.index(name) for name in task.moved[: len(values) - 1]]
    slopes[:, places] = np.nan_to_num((values[1:] - values[0]) / STEP).T
    return slopes
