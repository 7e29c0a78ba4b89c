"""Solving the program of a task: IPOPT from a simulated design, and what its solution says."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from functools import cached_property, lru_cache
from io import StringIO
from typing import Any

import casadi as ca
import numpy as np

from sizing.aircraft import Aircraft
from sizing.parameters import parameter_value
from sizing.program.climbing import Profile
from sizing.program.corrections import Linearisation
from sizing.program.task import SizingTask
from sizing.program.transcription import (
    FASTEST,
    INSIDE,
    LONGEST_H,
    PRICE,
    RESERVE_SCALE_H,
    Program,
    build_program,
)
from sizing.program.variables import WORST_EXCESS, Role, Variable, scales_of
from solar.types import BoolArray, FloatArray

LACKING = 1e-4  # relative: a smaller violation is what the solver leaves
_PAYLOAD_SHARE = 0.1  # of mass or load: a smaller payload counts as this in the cost
_MOST_STEPS = 12  # of Newton, which doubles its digits each time; more is no neighbour
_LARGEST_STEP = 1.0  # of the logarithm of a size
_SETTLED_STEP = 3e-3  # in variables of order one: about its square is what is left


@dataclass
class ActiveSet:
    """Sequential quadratic programming for a series of similar programs.

    Whole Newton steps from the last solution. The rows that hold in one quadratic program are the
    first guess for the next one (Ferreau, H. J. et al. 2014, qpOASES, Math. Prog. Comp. 6:327).
    """

    _program: Program | None = None
    _quadratic: Any = None

    def solve(
        self, program: Program, ends: dict[str, Any], multipliers: FloatArray
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return answer and statistics as IPOPT's; without success where steps lead nowhere."""
        if self._program is not program or self._quadratic is None:
            self._program, shapes = program, program.derivatives
            sparsity = {"h": shapes.sparsity_out(3), "a": shapes.sparsity_out(2)}
            quiet: dict[str, Any] = {"printLevel": "none", "error_on_fail": False}
            with redirect_stdout(StringIO()):  # it prints its licence
                self._quadratic = ca.conic("similar", "qpoases", sparsity, quiet)
        x, held = ca.DM(ends["x0"]), ca.DM(multipliers)
        p, low, high, most = (ca.DM(ends[name]) for name in ("p", "lbx", "ubx", "ubg"))
        sizes = program.parts["design"]
        for number in range(_MOST_STEPS):
            least, largest = low - x, high - x
            least[sizes] = ca.fmax(least[sizes], -_LARGEST_STEP)
            largest[sizes] = ca.fmin(largest[sizes], _LARGEST_STEP)
            rows, slope, jacobian, bent = program.derivatives(x, p, held)
            step = self._quadratic(
                h=bent, g=slope, a=jacobian, lba=-rows, uba=most - rows, lbx=least, ubx=largest
            )
            far = float(ca.norm_inf(step["x"]))
            if not (self._quadratic.stats()["success"] and math.isfinite(far)):
                break
            x, held = x + step["x"], step["lam_a"]
            if far < _SETTLED_STEP:
                stats = {
                    "success": True,
                    "iter_count": number + 1,
                    "return_status": "Solve_Succeeded",
                }
                return {"x": x, "lam_g": held, "lam_x": step["lam_x"]}, stats
        self._quadratic = None  # its guess leads nowhere
        return {}, {"success": False, "iter_count": number + 1}


@dataclass(frozen=True)
class Solution:
    """Solution of the program of a task.

    ``values``: of its variables, in their units. ``centre``: the design before, in the program's
    variables. ``x``, ``parameters``, ``row_multipliers``,
    ``bound_multipliers``: of the program, with CasADi's signs: the gradient of the cost plus that
    of rows and bounds, each times its multiplier, is zero.
    """

    task: SizingTask
    program: Program
    linearisation: Linearisation
    values: dict[str, float]
    centre: FloatArray
    x: FloatArray
    parameters: FloatArray
    row_multipliers: FloatArray
    bound_multipliers: FloatArray
    converged: bool
    iterations: int
    message: str

    @property
    def excess_time_h(self) -> float:
        """Worst excess time [h]."""
        return float(self.x[self.program.parts["excess"]][0])

    @property
    def lack(self) -> FloatArray:
        """Power that every block lacks, relative to the load of the design before."""
        return self.x[self.program.parts["lack"]]

    @property
    def missed(self) -> dict[str, float]:
        """Requirements on the design that are missed, and by how much, relative."""
        slacks = self.x[self.program.parts["missed"]]
        names = self.program.requirements
        return {n: float(s) for n, s in zip(names, slacks, strict=True) if s > LACKING}

    @property
    def violation(self) -> float:
        """Largest part by which anything is missed."""
        return float(max(self.lack.max(), max(self.missed.values(), default=0.0)))

    @property
    def profiles(self) -> list[Profile | None]:
        """Heights of the blocks; None in level flight."""
        heights = self.x[self.program.parts["height"]].reshape(self.program.blocks, -1)
        rows = zip(self.linearisation.days, np.clip(heights, 0.0, 1.0), strict=True)
        return [Profile(day.clock_h, row) if row.size else None for day, row in rows]

    def _changes(self, names: Iterable[str]) -> list[float]:
        """Return by how much variables change, as logarithms; of those that are not zero."""
        before, after = self.linearisation.values, self.values
        pairs = [(before[name], after[name]) for name in names]
        return [abs(math.log(a / b)) for b, a in pairs if a > 0.0 and b > 0.0]

    @property
    def stride(self) -> float:
        """Largest change of a size that is moved, as a logarithm."""
        sizes = [v.name for v in self.task.variables if may_be_limited(self.task, v)]
        return max(self._changes(sizes), default=0.0)

    @property
    def is_limited(self) -> bool:
        """Whether a size changes by as much as it may."""
        return self.stride > 0.99 * self.linearisation.reach

    @property
    def largest_change(self) -> float:
        """Largest relative change of a size or the mass of the design by this solution.

        A payload is a part of the mass, or of the load.
        """
        sizes = [v.name for v in self.task.variables if v.role is Role.design]
        power_w = self.values["payload_power_w"] - self.linearisation.values["payload_power_w"]
        return max(abs(power_w) / self.linearisation.load_w, *self._changes(sizes))

    def planned_h(self, block: int) -> float:
        """Excess time of a block in the program [h]."""
        kept = self._of("excess_time", block)
        kept[kept] = self.linearisation.blocks[block].reserve > 0.0
        return self.excess_time_h + float((self._rows[kept] / -self._rows_by_hour[kept]).min())

    @property
    def step(self) -> FloatArray:
        """Return the change from the design before, in the program's variables."""
        return np.asarray(self.x[self.program.parts["design"]] - self.centre)

    def multiplier(self, name: str, block: int | None) -> float:
        """Sum of the multipliers of the rows of a name."""
        return float(np.abs(self.row_multipliers[self._of(name, block)]).sum())

    def _of(self, name: str, block: int | None) -> BoolArray:
        """Which rows are those of a name and a block."""
        return np.array([(c.name, c.block) == (name, block) for c in self.program.constraints])

    @cached_property
    def _rows(self) -> FloatArray:
        return self.program.evaluated(self.x, self.parameters)[1]

    @cached_property
    def _rows_by_hour(self) -> FloatArray:
        """Change of the rows with an hour more of excess time."""
        later = self.x.copy()
        later[self.program.parts["excess"]] += 1.0
        return self.program.evaluated(later, self.parameters)[1] - self._rows

    def full(self, block: int) -> float:
        """Energy of the full battery, in the unit of charges."""
        return float(self._rows[self._of("battery_capacity", block)][0] + self._charge(block)[0])

    def _charge(self, block: int) -> FloatArray:
        """Energy at the nodes."""
        charges = self.x[self.program.parts["charge"]].reshape(self.program.blocks, -1)
        return np.asarray(charges[block])

    def first_soc(self, block: int) -> float:
        """State of charge at the first node."""
        return min(float(self._charge(block)[0]) / self.full(block), 1.0)

    def by_hour(self) -> list[float]:
        """What an hour of excess time costs in every block."""
        costs = np.abs(self._rows_by_hour * self.row_multipliers)
        blocks = [c.block for c in self.program.constraints]
        return [float(costs[[b == i for b in blocks]].sum()) for i in range(self.program.blocks)]

    def cost_of_hour(self, *, on_way: bool = False) -> float:
        """What an hour of required excess time costs, relative to the objective.

        ``on_way``: an hour of what must be left before instead.
        """
        if on_way:
            bounds = self.bound_multipliers[self.program.parts["charge"]]
            by_row = float(-np.minimum(bounds, 0.0).sum())
        else:
            by_row = sum(self.multiplier("excess_time", i) for i in range(self.program.blocks))
        if self.task.objective.payload_key is None:
            return by_row / RESERVE_SCALE_H
        unknowns = self.x[: self.program.parts["excess"].stop]
        payload = abs(float(self.parameters[: len(unknowns)] @ unknowns))
        return by_row / RESERVE_SCALE_H / max(payload, 1e-3)


def solve(
    task: SizingTask,
    point: Linearisation,
    *,
    excess_h: float,
    before: Solution | None = None,
    active_set: ActiveSet | None = None,
) -> Solution:
    """Solve the program of a task around a simulated design.

    ``point``: light and load of the design, and where the search starts. ``excess_h``: worst excess
    time to start from [h]. ``active_set``: solver of many similar programs, that is tried first,
    from the solution ``before``: of the last round, or of a similar task.
    """
    program = build_program(task.aircraft, task.form(len(point.blocks)))
    scales = scales_of(task.variables, point.values)
    centre = np.array(
        [v.to_program(point.values[v.name], s) for v, s in zip(task.variables, scales, strict=True)]
    )
    parameters = parameters_of(task, program, point, scales, centre)
    low, high = _bounds(task, program, point, scales)
    parts = program.parts
    low[parts["charge"]] = point.least
    start = np.zeros(parts["speed"].stop)
    start[parts["design"]], start[parts["excess"]] = centre, excess_h
    start[parts["missed"]] = start[parts["lack"]] = INSIDE[0]
    start[parts["charge"]], start[parts["height"]] = point.charge, point.height
    start[parts["speed"]] = np.concatenate(point.speed)
    equation = np.array([c.equation for c in program.constraints])
    ends: dict[str, Any] = {
        "lbx": low,
        "ubx": high,
        "ubg": np.where(equation, 0.0, np.inf),
        "p": parameters,
    }
    iterations, stats = 0, {"success": False}
    with program.lock:
        if active_set is not None and before is not None and before.program is program:
            answer, stats = active_set.solve(
                program, {**ends, "x0": np.clip(start, low, high)}, before.row_multipliers
            )
            iterations += stats["iter_count"]
        if not stats["success"]:
            answer = program.solver(lbg=0.0, **ends, x0=np.clip(start, low, high))
            stats = program.solver.stats()
            iterations += stats["iter_count"]
    x = np.asarray(answer["x"]).ravel()
    values = {
        v.name: float(v.from_program(value, scale))
        for v, value, scale in zip(task.variables, x[parts["design"]], scales, strict=True)
    }
    return Solution(
        task=task,
        program=program,
        linearisation=point,
        values=task.within_bounds(values),
        centre=centre,
        x=x,
        parameters=parameters,
        row_multipliers=np.asarray(answer["lam_g"]).ravel(),
        bound_multipliers=np.asarray(answer["lam_x"]).ravel(),
        converged=bool(stats["success"]),
        iterations=int(iterations),
        message=str(stats["return_status"]),
    )


def parameters_of(
    task: SizingTask,
    program: Program,
    point: Linearisation,
    scales: FloatArray,
    centre: FloatArray,
) -> FloatArray:
    """Return the parameter vector of the program, in the order of its symbols."""
    technology = _technology(task.aircraft, program.technology)
    battery = task.aircraft.battery
    efficiencies = [battery.mean_charge_efficiency, battery.mean_discharge_efficiency]
    vectors: Sequence[Any] = (
        _weights(task, point, scales),
        np.ravel([np.array(air, float) for air in task.airs]),
        technology,
        np.array(efficiencies, float),
        scales,
        centre,
        [point.load_w, PRICE, task.climb_height_m],
        *(point.parts or ()),
        *(np.ravel(value) for block in point.blocks for value in block),
    )
    return np.concatenate(vectors)


@lru_cache(maxsize=64)
def _technology(aircraft: Aircraft, keys: tuple[str, ...]) -> FloatArray:
    """Return the numbers of an aircraft that are parameters of its program."""
    return np.array([parameter_value(aircraft, None, key) for key in keys], float)


def _weights(task: SizingTask, point: Linearisation, scales: FloatArray) -> FloatArray:
    """Return the cost per unit of the design's variables and of the excess time.

    A payload counts in parts of itself, or where it is small of the mass or the load it is in.
    """
    weights = np.zeros(len(task.variables) + 1)
    wholes = {"payload_mass_kg": point.mass_kg, "payload_power_w": point.load_w}
    for name, weight in task.cost.items():
        if name == WORST_EXCESS:
            weights[-1] = weight
            continue
        place = task.names.index(name)
        least = _PAYLOAD_SHARE * wholes.get(name, 0.0)
        weights[place] = weight * scales[place] / max(scales[place], least)
    return weights


def _bounds(
    task: SizingTask, program: Program, point: Linearisation, scales: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the bounds of the decision vector."""
    parts = program.parts
    low, high = np.zeros(parts["speed"].stop), np.full(parts["speed"].stop, np.inf)
    for i, (v, scale) in enumerate(zip(task.variables, scales, strict=True)):
        low[i], high[i] = (v.to_program(end, scale) for end in within_reach(task, point, v))
    high[parts["height"]], high[parts["speed"]] = 1.0, FASTEST
    low[parts["excess"]] = task.goal_h
    high[parts["excess"]] = LONGEST_H if task.maximises_excess else task.goal_h
    return low, high


def may_be_limited(task: SizingTask, v: Variable) -> bool:
    """Return whether a step of a variable may be limited: of a size that is moved, no payload."""
    return v.name in task.moved and v.role is Role.design


def within_reach(task: SizingTask, point: Linearisation, v: Variable) -> tuple[float, float]:
    """Return the ends of a variable in a program: its bounds, or how far one step may go."""
    if not may_be_limited(task, v) or math.isinf(point.reach):
        return v.minimum, v.maximum
    value, factor = point.values[v.name], math.exp(point.reach)
    return max(v.minimum, value / factor), min(v.maximum, value * factor)
