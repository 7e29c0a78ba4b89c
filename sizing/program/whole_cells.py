"""Designs of whole solar and battery cells next to a sizing's optimum.

The optimum of the program, whose module area and battery mass are continuous, is rounded to whole
cells both ways, and from the best of these designs the search goes on to its neighbours until none
is better. Each one is sized with its cells held: the program chooses what is left, wingspan above
all, which must hold the cells, and the simulator decides.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import product

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.design import DesignVariables
from sizing.design_space import DesignSpace
from sizing.layout.cells import Wing
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult, SizingStatus, Violation
from sizing.program.whole_cell_designs import ROW_ROOM, CellDesigns, Found, Neighbour, Numbers
from sizing.sunlight import UNCORRECTED_CAM, SolarModel
from solar.schema import MOST_CELLS

# Rings around the rounded optimum that are tried before the search gives up.
_RINGS = 4
# Numbers of cells on half of the wing that are looked at, below and above the rounded optimum.
_AROUND = 200
# Of many cells the search begins with longer steps, this part of them, and halves the steps.
_STRIDES = 20


@dataclass(frozen=True)
class WholeCells:
    """Best design of whole cells, its neighbours and what whole cells cost.

    ``aircraft`` is the aircraft with that design put in, None without one; ``relaxed`` the sizing
    with a continuous module area and battery mass.
    """

    aircraft: Aircraft | None
    relaxed: SizingResult
    chosen: Neighbour | None
    tried: tuple[Neighbour, ...]

    @property
    def loss(self) -> float | None:
        """By how much the objective is worse than the relaxed one, relative to it [-]."""
        best = self.relaxed.objective_value
        if self.chosen is None or self.chosen.value is None or best is None:
            return None
        if best == 0.0 or not math.isfinite(self.chosen.value - best):
            return None
        worse = self.chosen.value - best
        return (-worse if self.relaxed.objective.maximised else worse) / abs(best)


def size_whole_cells(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    required_excess_time_h: float | None = None,
) -> tuple[SizingResult, WholeCells]:
    """Find the best design of whole solar and battery cells.

    ``aircraft``: with ``modules.layout`` and ``battery.pack``; where its layout has strings, only
    numbers of cells count that divide into strings within the window of their MPPT. Raises
    :class:`ValueError` without a layout or a pack, and for an objective that is a range.
    """
    for key, given in (
        ("modules.layout", aircraft.modules.layout),
        ("battery.pack", aircraft.battery.pack),
    ):
        if given is None:
            raise ValueError(f"whole cells need {key} of the aircraft")
    if objective.of_range:
        raise ValueError(f"{objective.value} is a range of days or latitudes: no whole cells")
    designs = CellDesigns(aircraft, mission, objective, solar, required_excess_time_h)
    relaxed = designs.relaxed()
    if relaxed.design is None:
        return relaxed, WholeCells(None, relaxed, None, ())
    return _WholeCellSearch(designs, relaxed, relaxed.design.variables).run()


class _WholeCellSearch:
    """One search: what it starts from, and all that it has tried."""

    def __init__(self, designs: CellDesigns, relaxed: SizingResult, start: DesignVariables) -> None:
        self.designs, self.relaxed, self.start = designs, relaxed, start
        self.known: dict[Numbers, Found] = {}
        layout = designs.layout
        half = (start.module_area_m2 / layout.area_of_a_cell_m2 - layout.tail_count) / 2.0
        parallel = start.battery_mass_kg / designs.battery_kg(1)
        self.wished = half, parallel
        self.middle = Numbers(max(round(half), 1), max(round(parallel), 1))
        self.halves = self._halves()

    def run(self) -> tuple[SizingResult, WholeCells]:
        """Best of the designs around the relaxed optimum."""
        best = self._of_rounded()
        stride = max(self.middle.per_half // _STRIDES, 1)
        while best is not None and stride:
            better = self._best_of(self._ring(best.numbers, 1, stride))
            if better is not None and better.beats(best):
                best = better
            else:
                stride //= 2
        # Numbers between those that can be laid and strung have none but a reason.
        middle = self.middle if best is None else best.numbers
        for more in (-1, 0, 1):
            self._best_of([Numbers(max(middle.per_half + more, 1), middle.parallel)])
        # The best first, then in the order in which they were tried.
        ranked = sorted(self.known.values(), key=lambda one: one.rank)
        tried = tuple(one.neighbour for one in ranked)
        if best is None or best.result is None:
            near = self.known[middle].neighbour
            text = (
                f"no design of whole cells among {len(tried)} next to the relaxed optimum; with "
                f"{near.cells} solar cells and {near.battery_cells} battery cells: {near.reason}"
            )
            missed = Violation("whole_cells", 1.0, text)
            nearest = self.relaxed.simulated
            failed = self.relaxed.without_design(SizingStatus.infeasible, nearest, missed)
            return failed, WholeCells(None, self.relaxed, None, tried)
        limiting = _limiting(best.result, self.designs.aircraft.design_space)
        result = replace(best.result, active_constraints=limiting)
        return result, WholeCells(best.aircraft, self.relaxed, best.neighbour, tried)

    def _of_rounded(self) -> Found | None:
        """Best of the rounded optimum both ways, else of the rings around it."""
        half, parallel = self.wished
        counts = [max(math.floor(parallel), 1), max(math.ceil(parallel), 1)]
        at = bisect_left(self.halves, half)
        around = self.halves[max(at - 1, 0) : at + 1]
        best = self._best_of(Numbers(*one) for one in product(around, counts))
        for radius in range(1, _RINGS + 1):
            if best is not None:
                return best
            best = self._best_of(self._ring(self.middle, radius))
        return best

    def _ring(self, middle: Numbers, radius: int, stride: int = 1) -> Iterator[Numbers]:
        """Numbers at a distance of some steps; of the solar cells those that can be laid."""
        steps = range(-radius, radius + 1)
        at = bisect_left(self.halves, middle.per_half)
        for a, b in product(steps, steps):
            place, parallel = at + a * stride, middle.parallel + b
            if max(abs(a), abs(b)) == radius and 0 <= place < len(self.halves) and parallel > 0:
                yield Numbers(self.halves[place], parallel)

    def _best_of(self, numbers: Iterable[Numbers]) -> Found | None:
        """Best of some designs, each of which is sized once."""
        best: Found | None = None
        for one in dict.fromkeys(numbers):
            if one not in self.known:
                self.known[one] = self.designs.sized(one, self.start)
            found = self.known[one]
            if found.result is not None and (best is None or found.beats(best)):
                best = found
        return best

    def _halves(self) -> list[int]:
        """Numbers of cells on half of the wing around the wish, that wing and strings allow."""
        aircraft, layout = self.designs.aircraft, self.designs.layout
        space, ratio = aircraft.design_space, aircraft.airframe.aspect_ratio
        span_m = space.wingspan_m.maximum
        ratio = ratio if space.aspect_ratio is None else space.aspect_ratio.minimum
        most = min(layout.capacity(Wing(span_m, span_m / ratio)), MOST_CELLS // 2)
        middle, tail = min(self.middle.per_half, most), layout.tail_count
        around = range(max(middle - _AROUND, 1), min(middle + _AROUND, most) + 1)
        return [half for half in around if not self.designs.strings(2 * half + tail)[1]]


def _limiting(result: SizingResult, space: DesignSpace) -> tuple[str, ...]:
    """What limits a design, without the bounds that hold its cells; their wing by its own name."""
    assert result.design is not None
    held = ("module_area_m2 at its", "battery_mass_kg at its")
    by_cells = []
    if result.design.variables.wingspan_m > space.wingspan_m.minimum * (1.0 + ROW_ROOM):
        by_cells.append("wingspan_m at its minimum")
    if space.aspect_ratio is not None:
        by_cells.append("chord_m_minimum")
    names = (name for name in result.active_constraints if not name.startswith(held))
    return tuple(dict.fromkeys("whole_cells" if one in by_cells else one for one in names))
