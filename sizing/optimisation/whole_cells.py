"""Designs of whole solar and battery cells next to a sizing's optimum.

The optimum of the program, whose module area and battery mass are continuous, is rounded to whole
cells both ways, and from the best of these designs the search goes on to its neighbours until none
is better. Each one is sized with its cells held: the program chooses what is left, wingspan above
all, which must hold the cells, and the simulator decides.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any, NamedTuple

from missions.files.texts import texts_as_read
from missions.mission import Mission
from sizing.aircraft import Aircraft, DesignSpace, Limit, ParametricAirframe, Range
from sizing.design import DesignVariables
from sizing.energy.battery_pack import BatteryPack
from sizing.layout.cells import MOST_CELLS, CellLayout, Wing
from sizing.layout.strings import Strings
from sizing.optimisation.objectives import Objective
from sizing.optimisation.propulsion import with_fixed_chain
from sizing.optimisation.result import SizingResult, SizingStatus, Violation
from sizing.optimisation.search import size_aircraft
from sizing.sunlight import UNCORRECTED_CAM, SolarModel
from solar.modules import STC_IRRADIANCE_W_PER_M2

__all__ = ["Neighbour", "WholeCells", "size_whole_cells", "without_whole_cells"]

# Rings around the rounded optimum that are tried before the search gives up.
_RINGS = 4
# Numbers of cells on half of the wing that are looked at, below and above the rounded optimum.
_AROUND = 200
# Objectives that differ by less are equal: the lighter design is then the better one.
_SAME = 1e-6
# The solver meets its rows to about 1e-8.
_ROW_ROOM = 1e-6
_PER_M = 10_000  # lengths that are tried
_LONGEST_M = 10_000.0


class _Numbers(NamedTuple):
    """Cells on half of the wing, and battery cells in parallel."""

    per_half: int
    parallel: int


@dataclass(frozen=True)
class Neighbour:
    """A design of whole cells, and what became of it.

    ``cells``, ``strings``, ``mppts``: solar cells on wing and tail, strings of them and MPPTs; the
    latter are None where the file has no strings. ``battery_cells``: in series times parallel.
    ``value``: objective, None where there is no design; ``reason`` then says why.
    """

    cells: int
    strings: int | None
    mppts: int | None
    cells_in_parallel: int
    battery_cells: int
    value: float | None
    wingspan_m: float | None
    total_mass_kg: float | None
    reason: str = ""


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
        if not math.isfinite(best) or best == 0.0:
            return None
        worse = self.chosen.value - best
        return (-worse if self.relaxed.objective.maximised else worse) / abs(best)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        design = self.relaxed.design
        variables = {} if design is None else design.variables.chosen()
        return {
            "loss": self.loss,
            "relaxed": {
                "value": self.relaxed.objective_value,
                **{name: float(value) for name, value in variables.items()},
            },
            "chosen": None if self.chosen is None else dict(self.chosen.__dict__),
            "tried": [dict(one.__dict__) for one in self.tried],
        }


def without_whole_cells(aircraft: Aircraft) -> Aircraft:
    """Aircraft with the same technology and no whole cells; not validated."""
    return aircraft.model_copy(
        update={
            "modules": aircraft.modules.model_copy(update={"layout": None}),
            "battery": aircraft.battery.model_copy(update={"pack": None}),
        }
    )


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
    search = _WholeCellSearch(aircraft, mission, objective, solar, required_excess_time_h)
    return search.run()


@dataclass(frozen=True)
class _Found:
    """A neighbour with its sizing."""

    neighbour: Neighbour
    result: SizingResult | None
    aircraft: Aircraft | None

    @property
    def rank(self) -> tuple[float, float]:
        """Objective and mass, the smaller the better."""
        result = self.result
        if result is None or result.design is None:
            return math.inf, math.inf
        return -result.merit, result.design.total_mass_kg

    def beats(self, other: _Found) -> bool:
        """Whether it is better, or as good and lighter."""
        (own, own_kg), (its, its_kg) = self.rank, other.rank
        if math.isclose(own, its, rel_tol=_SAME):
            return own_kg < its_kg * (1.0 - _SAME)
        return own < its


class _WholeCellSearch:
    """One search: what it starts from, and all that it has tried."""

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        objective: Objective,
        solar: SolarModel,
        required_h: float | None,
    ) -> None:
        self.aircraft, self.plain = aircraft, without_whole_cells(aircraft)
        self.given = mission, objective, solar
        self.required_h = required_h
        layout, pack = aircraft.modules.layout, aircraft.battery.pack
        assert layout is not None
        assert pack is not None
        self.layout: CellLayout = layout
        self.pack: BatteryPack = pack
        self.share = aircraft.battery.cell_mass_fraction
        # Loss of voltage per kelvin where strings have none of their own, and the battery's ends.
        self.electric = aircraft.modules.temperature_coefficient_per_k, aircraft.battery.ends_v
        self.known: dict[_Numbers, _Found] = {}

    def run(self) -> tuple[SizingResult, WholeCells]:
        """Relaxed optimum, the designs around it, and the best of them."""
        relaxed = self.relaxed = self._sized(self._relaxed_aircraft())
        if relaxed.design is None:
            return relaxed, WholeCells(None, relaxed, None, ())
        best = self._first(relaxed.design.variables)
        while best is not None:
            better = self._best(self._ring(best[0], 1))
            if better is None or not better[1].beats(best[1]):
                break
            best = better
        # Numbers between those that can be laid and strung have none but a reason.
        middle = self.middle if best is None else best[0]
        for more in (-1, 0, 1):
            self._best([_Numbers(max(middle.per_half + more, 1), middle.parallel)])
        tried = tuple(one.neighbour for one in self._ranked())
        if best is None or best[1].result is None:
            near = self.known[middle].neighbour
            text = (
                f"no design of whole cells among {len(tried)} next to the relaxed optimum; with "
                f"{near.cells} solar cells and {near.battery_cells} battery cells: {near.reason}"
            )
            failed = relaxed.without_design(
                SizingStatus.infeasible, relaxed.simulated, Violation("whole_cells", 1.0, text)
            )
            return failed, WholeCells(None, relaxed, None, tried)
        found = best[1]
        limiting = _limiting(best[1].result, self.aircraft.design_space)
        result = replace(best[1].result, active_constraints=limiting)
        return result, WholeCells(found.aircraft, relaxed, found.neighbour, tried)

    def _first(self, relaxed: DesignVariables) -> tuple[_Numbers, _Found] | None:
        """Best of the rounded optimum both ways, else of the rings around it."""
        cell_m2 = self.layout.area_of_a_cell_m2
        half = (relaxed.module_area_m2 / cell_m2 - self.layout.tail_count) / 2.0
        parallel = relaxed.battery_mass_kg / self._battery_kg(1)
        counts = [max(math.floor(parallel), 1), max(math.ceil(parallel), 1)]
        self.middle = _Numbers(max(round(half), 1), max(round(parallel), 1))
        self.halves = self._halves(half)
        at = bisect_left(self.halves, half)
        around = self.halves[max(at - 1, 0) : at + 1]
        best = self._best(_Numbers(*one) for one in product(around, counts))
        for radius in range(1, _RINGS + 1):
            if best is not None:
                return best
            best = self._best(self._ring(self.middle, radius))
        return best

    def _ring(self, middle: _Numbers, radius: int) -> Iterator[_Numbers]:
        """Numbers at a distance of some steps; of the solar cells those that can be laid."""
        steps = range(-radius, radius + 1)
        at = bisect_left(self.halves, middle.per_half)
        for a, b in product(steps, steps):
            place, parallel = at + a, middle.parallel + b
            if max(abs(a), abs(b)) == radius and 0 <= place < len(self.halves) and parallel > 0:
                yield _Numbers(self.halves[place], parallel)

    def _best(self, numbers: Iterable[_Numbers]) -> tuple[_Numbers, _Found] | None:
        """Best of some designs, each of which is sized once."""
        best: tuple[_Numbers, _Found] | None = None
        for one in dict.fromkeys(numbers):
            if one not in self.known:
                self.known[one] = self._tried(one)
            found = self.known[one]
            if found.result is not None and (best is None or found.beats(best[1])):
                best = one, found
        return best

    def _halves(self, wished: float) -> list[int]:
        """Numbers of cells on half of the wing around one that strings and largest wing allow."""
        space, ratio = self.aircraft.design_space, self.aircraft.airframe.aspect_ratio
        span_m = space.wingspan_m.maximum
        ratio = ratio if space.aspect_ratio is None else space.aspect_ratio.minimum
        most = min(self.layout.capacity(Wing(span_m, span_m / ratio)), MOST_CELLS // 2)
        middle, tail = min(round(wished), most), self.layout.tail_count
        around = range(max(middle - _AROUND, 1), min(middle + _AROUND, most) + 1)
        return [half for half in around if not self._strings(2 * half + tail)[1]]

    def _ranked(self) -> list[_Found]:
        """All that was tried, the best first; then in the order in which it was."""
        return sorted(self.known.values(), key=lambda one: one.rank)

    # ---- One design

    def _battery_kg(self, parallel: int) -> float:
        pack = self.pack.model_copy(update={"cells_in_parallel": parallel})
        return pack.mass_kg(self.share)

    def _tried(self, numbers: _Numbers) -> _Found:
        """Design of some numbers of cells, sized with all else free."""
        assert self.relaxed.design is not None
        start = self.relaxed.design.variables
        cells = 2 * numbers.per_half + self.layout.tail_count
        strings, reason = self._strings(cells)
        results: list[tuple[SizingResult, Aircraft]] = []
        if not reason:
            for wing in self._wings(numbers.per_half):
                held = self._held(numbers, cells, wing)
                if isinstance(held, str):
                    reason = held
                    continue
                result = self._sized(held, start)
                if result.design is None:
                    reason = _why(result)
                    continue
                results.append((result, self._put_in(result, numbers, strings)))
        best = max(results, key=lambda one: one[0].merit, default=None)
        design = None if best is None else best[0].design
        neighbour = Neighbour(
            cells=cells,
            strings=None if strings is None else cells // strings.cells_in_series,
            mppts=None if strings is None else strings.mppts(cells),
            cells_in_parallel=numbers.parallel,
            battery_cells=numbers.parallel * self.pack.cells_in_series,
            value=None if best is None else best[0].objective_value,
            wingspan_m=None if design is None else float(design.variables.wingspan_m),
            total_mass_kg=None if design is None else float(design.total_mass_kg),
            reason="" if best is not None else reason,
        )
        return _Found(neighbour, *(best or (None, None)))

    def _strings(self, cells: int) -> tuple[Strings | None, str]:
        """Strings of so many cells; why there are none."""
        strings = self.layout.strings
        if strings is None:
            return None, ""
        loss, ends_v = self.electric
        found = strings.for_cells(cells, loss, ends_v)
        if found is not None:
            return found, ""
        window = strings.window(loss, ends_v)
        return None, (
            f"{cells} cells do not divide into strings of {window.least} to {window.most}"
        )

    def _wings(self, per_half: int) -> Iterator[Wing]:
        """Smallest wings that hold so many cells: one, or with a free aspect ratio one per row."""
        airframe, space = self.aircraft.airframe, self.aircraft.design_space
        if space.aspect_ratio is None:
            ratio = airframe.aspect_ratio
            span_m = self._least(lambda b: Wing(b, b / ratio), per_half)
            yield Wing(span_m, span_m / ratio)
            return
        assert self.relaxed.design is not None
        variables = self.relaxed.design.variables
        chord_m = float(variables.wingspan_m / variables.aspect_ratio)
        bay = self.layout.bays[0]
        rows = max(self.layout.rows_that_fit(bay, Wing(variables.wingspan_m, chord_m)), 1)
        for count in (rows, rows + 1):
            deep_m = _least_chord_m(self.layout, count, float(variables.wingspan_m))
            if math.isinf(deep_m):
                continue
            span_m = self._least(partial(Wing, chord_m=deep_m), per_half)
            yield Wing(span_m, deep_m * (1.0 + _ROW_ROOM))

    def _least(self, wing_of: Callable[[float], Wing], per_half: int) -> float:
        """Least wingspan whose wing holds so many cells on each half [m]."""
        return _bisected(lambda b: self.layout.capacity(wing_of(b)) >= per_half)

    def _held(self, numbers: _Numbers, cells: int, wing: Wing) -> Aircraft | str:
        """Aircraft whose design space holds these cells and no others; why there is none."""
        space, airframe = self.aircraft.design_space, self.plain.airframe
        assert isinstance(airframe, ParametricAirframe)
        held: dict[str, Any] = {}
        for name, value, text in (
            ("module_area_m2", cells * self.layout.area_of_a_cell_m2, "module area {:.4g} m²"),
            ("battery_mass_kg", self._battery_kg(numbers.parallel), "battery of {:.4g} kg"),
        ):
            ends = getattr(space, name)
            if not ends.minimum <= value <= ends.maximum:
                return f"{text.format(value)} is outside design_space.{name}"
            held[name] = Range.model_construct(minimum=value, maximum=value)
        span = space.wingspan_m
        if wing.wingspan_m > span.maximum:
            return (
                f"the cells need a wingspan of {wing.wingspan_m:.4g} m, "
                f"design_space.wingspan_m ends at {span.maximum:g} m"
            )
        least_m = max(span.minimum, wing.wingspan_m)
        held["wingspan_m"] = Range.model_construct(minimum=least_m, maximum=span.maximum)
        if space.aspect_ratio is not None:
            known = space.limits.get("chord_m", Limit.model_construct(minimum=None, maximum=None))
            chord = known.model_copy(update={"minimum": max(known.minimum or 0.0, wing.chord_m)})
            held["limits"] = space.limits | {"chord_m": chord}
        strings = self._strings(cells)[0]
        mppts = 0 if strings is None else strings.mppts(cells)
        plain = self._with_mppts(mppts, cells)
        return plain.model_copy(update={"design_space": space.model_copy(update=held)})

    def _with_mppts(self, mppts: float, cells: float) -> Aircraft:
        """Aircraft without cells whose MPPTs weigh what so many weigh, where the layout says it."""
        strings, modules = self.layout.strings, self.plain.modules
        if strings is None or strings.mppt.mass_kg is None:
            return self.plain
        rated_w = STC_IRRADIANCE_W_PER_M2 * modules.efficiency_stc * self.layout.area_of_a_cell_m2
        per_w = mppts * strings.mppt.mass_kg / (cells * rated_w)
        modules = modules.model_copy(update={"mppt_mass_kg_per_w": per_w})
        return self.plain.model_copy(update={"modules": modules})

    def _relaxed_aircraft(self) -> Aircraft:
        """Aircraft of the relaxed optimum: its MPPTs come by the gram, each with all it takes."""
        strings = self.layout.strings
        if strings is None:
            return self.plain
        loss, ends_v = self.electric
        most = max(strings.window(loss, ends_v).most, 1)
        return self._with_mppts(1.0, strings.strings_per_mppt * most)

    def _sized(self, aircraft: Aircraft, start: DesignVariables | None = None) -> SizingResult:
        """Sizing of a design space."""
        mission, objective, solar = self.given
        options: dict[str, Any] = {"required_excess_time_h": self.required_h}
        aircraft, settled = with_fixed_chain(aircraft, mission, objective, solar, **options)
        return size_aircraft(aircraft, mission, objective, solar, start=settled or start, **options)

    def _put_in(self, result: SizingResult, numbers: _Numbers, strings: Strings | None) -> Aircraft:
        """Aircraft of a design, its cells laid on its wing and checked as a file is."""
        assert result.design is not None
        variables = result.design.variables
        wing = Wing(variables.wingspan_m, variables.wingspan_m / variables.aspect_ratio)
        layout = self.layout.with_cells(numbers.per_half, wing, strings)
        data = self.aircraft.model_dump(mode="json", exclude_unset=True)
        data["airframe"] |= {
            key: float(getattr(variables, key)) for key in ("wingspan_m", "aspect_ratio")
        }
        data["modules"] |= {
            "layout": layout.model_dump(mode="json", exclude_unset=True),
            "area_m2": layout.area_m2,
        }
        data["battery"]["pack"] |= {"cells_in_parallel": numbers.parallel}
        data["battery"]["mass_kg"] = self._battery_kg(numbers.parallel)
        if variables.lift_coefficient is not None:
            data["airframe"]["aerodynamics"]["lift_coefficient"] = float(variables.lift_coefficient)
        with texts_as_read(self.aircraft.texts_read):
            return Aircraft.model_validate(data)


def _limiting(result: SizingResult, space: DesignSpace) -> tuple[str, ...]:
    """What limits a design, without the bounds that hold its cells; their wing by its own name."""
    assert result.design is not None
    held = ("module_area_m2 at its", "battery_mass_kg at its")
    by_cells = []
    if result.design.variables.wingspan_m > space.wingspan_m.minimum * (1.0 + _ROW_ROOM):
        by_cells.append("wingspan_m at its minimum")
    if space.aspect_ratio is not None:
        by_cells.append("chord_m_minimum")
    names = (name for name in result.active_constraints if not name.startswith(held))
    return tuple(dict.fromkeys("whole_cells" if one in by_cells else one for one in names))


def _why(result: SizingResult) -> str:
    """Why a sizing has no design, in words."""
    if result.violations:
        return "; ".join(one.text for one in result.violations)
    nearest = result.nearest
    if nearest is None:
        return "no design found"
    least_h = float(nearest.cycle.excess_time_h.min())
    return f"the required excess time is out of reach (nearest design {least_h:.2f} h)"


def _least_chord_m(layout: CellLayout, rows: int, wingspan_m: float) -> float:
    """Least mean chord on which the innermost bay has so many rows [m]."""
    bay = layout.bays[0]
    return _bisected(lambda chord: layout.rows_that_fit(bay, Wing(wingspan_m, chord)) >= rows)


def _bisected(holds: Callable[[float], bool]) -> float:
    """Least length at which something holds, to a tenth of a millimetre; infinite if none [m]."""
    low, high = 0, _PER_M
    while not holds(high / _PER_M):
        high *= 2
        if high > _LONGEST_M * _PER_M:
            return math.inf
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle / _PER_M) else (middle, high)
    return high / _PER_M
