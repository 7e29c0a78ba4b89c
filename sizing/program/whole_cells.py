"""Designs of whole solar and battery cells next to a sizing's optimum.

The optimum of the program, whose module area and battery mass are continuous, is rounded to whole
cells both ways, and from the best of these designs the search goes on to its neighbours until none
is better. Each one is sized with its cells held: the program chooses what is left, wingspan above
all, which must hold the cells, and the simulator decides.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import NamedTuple

from missions.files.texts import texts_as_read
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.chosen_parts import put_parts_in
from sizing.day.light import UNCORRECTED_CAM, SolarModel
from sizing.design_space import Limit
from sizing.layout.cells import Wing
from sizing.layout.strings import Strings
from sizing.limits import ROW_TOLERANCE
from sizing.parameters import all_replaced
from sizing.program.objectives import Objective, refuse_range
from sizing.program.result import SizingResult, Violation
from sizing.program.size import size_aircraft
from sizing.roots import bisect
from solar.modules import STC_IRRADIANCE_W_PER_M2
from solar.schema import MOST_CELLS

_RINGS = 4  # around the rounded optimum that are tried before the search gives up
# Numbers of cells on half of the wing that are looked at, below and above the rounded optimum.
_AROUND = 200
# Of many cells the search begins with longer steps, this part of them, and halves the steps.
_STRIDES = 20
# Of an objective, of which the solver knows eight. Of equal designs the lighter one is better.
_DIGITS = 6
_NONE = math.inf, math.inf  # rank where there is no design
_TENTH_OF_A_MM, _LONGEST_M = 1e-4, 1e4  # of lengths that are tried

Bounds = dict[str, tuple[float, float]]


class Numbers(NamedTuple):
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
        if best == 0.0 or not math.isfinite(self.chosen.value - best):
            return None
        worse = self.chosen.value - best
        return (-worse if self.relaxed.objective.maximised else worse) / abs(best)


def without_whole_cells(aircraft: Aircraft) -> Aircraft:
    """Aircraft with the technology that its whole cells give it, and none of them; unchecked."""
    sections = {}
    for section, whole, keys in (
        ("modules", "layout", ("area_m2", "mppt_mass_kg_per_w")),
        ("battery", "pack", ("mass_kg", "specific_energy_wh_per_kg", "charge_limit")),
    ):
        record = getattr(aircraft, section)
        if getattr(record, whole) is not None:
            values = {key: getattr(record, key) for key in keys}
            sections[section] = record.model_copy(update={whole: None, **values})
    return aircraft.model_copy(update=sections)


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
    refuse_range(objective, "no whole cells")
    sizing = partial(size_aircraft, mission=mission, objective=objective, solar=solar)
    return _Search(aircraft, partial(sizing, required_excess_time_h=required_excess_time_h)).run()


class _Search:
    """One search around the relaxed optimum, and all that it has tried."""

    def __init__(self, aircraft: Aircraft, sizing: Callable[..., SizingResult]) -> None:
        layout, pack = aircraft.modules.layout, aircraft.battery.pack
        for key, record in (("modules.layout", layout), ("battery.pack", pack)):
            if record is None:
                raise ValueError(f"whole cells need {key} of the aircraft")
        assert layout is not None
        assert pack is not None
        self.aircraft, self.layout, self.pack, self.sizing = aircraft, layout, pack, sizing
        # Loss of voltage per kelvin where strings have none of their own, and the battery's ends.
        self.electric = aircraft.modules.temperature_coefficient_per_k, aircraft.battery.ends_v
        self.known: dict[Numbers, tuple[Neighbour, SizingResult | None]] = {}

    def run(self) -> tuple[SizingResult, WholeCells]:
        """Return the best of the designs around the relaxed optimum."""
        # With continuous area, battery and MPPTs, each of these with all the cells that it takes.
        strings, mppts_per_cell = self.layout.strings, 0.0
        if strings is not None:
            most = max(strings.window(*self.electric).most, 1)
            mppts_per_cell = 1.0 / (strings.strings_per_mppt * most)
        relaxed = self.sizing(self._without_cells(mppts_per_cell))
        if relaxed.design is None:
            return relaxed, WholeCells(None, relaxed, None, ())
        start = self.start = relaxed.design.variables
        half = (start.module_area_m2 / self.layout.area_of_a_cell_m2 - self.layout.tail_count) / 2.0
        parallel = start.battery_mass_kg / self._battery_kg(1)
        best = self._best(half, parallel)
        # Numbers next to it that cannot be strung have none but a reason.
        for more in (-1, 0, 1):
            self._rank(Numbers(max(best.per_half + more, 1), best.parallel))
        # The best first, then in the order in which they were tried.
        tried = tuple(self.known[numbers][0] for numbers in sorted(self.known, key=self._rank))
        chosen, result = self.known[best]
        if result is None:
            text = (
                f"no design of whole cells among {len(tried)} next to the relaxed optimum; with "
                f"{chosen.cells} solar cells and {chosen.battery_cells} battery cells: "
                f"{chosen.reason}"
            )
            missed = Violation("whole_cells", 1.0, text)
            failed = relaxed.without_design(relaxed.simulated, missed)
            return failed, WholeCells(None, relaxed, None, tried)
        result = replace(result, active_constraints=self._limiting(result))
        return result, WholeCells(self._put_in(result, best), relaxed, chosen, tried)

    def _best(self, half: float, parallel: float) -> Numbers:
        """Return the best numbers around those of the optimum; these where no design is found."""
        middle = Numbers(max(round(half), 1), max(round(parallel), 1))
        halves = self._halves(middle.per_half)

        def around(numbers: Numbers, radius: int, stride: int = 1) -> Iterator[Numbers]:
            """Yield the numbers at a distance of steps; of solar cells those that are strung."""
            steps, at = range(-radius, radius + 1), bisect_left(halves, numbers.per_half)
            for a, b in product(steps, steps):
                place, parallel = at + a * stride, numbers.parallel + b
                if max(abs(a), abs(b)) == radius and 0 <= place < len(halves) and parallel > 0:
                    yield Numbers(halves[place], parallel)

        at, best = bisect_left(halves, half), middle
        counts = {max(math.floor(parallel), 1), max(math.ceil(parallel), 1)}
        rounded = map(Numbers._make, product(halves[max(at - 1, 0) : at + 1], counts))
        for candidates in (rounded, *(around(middle, 1 + ring) for ring in range(_RINGS))):
            best = min(candidates, key=self._rank, default=middle)
            if self._rank(best) < _NONE:
                break
        stride = max(middle.per_half // _STRIDES, 1)
        while stride and self._rank(best) < _NONE:
            better = min((best, *around(best, 1, stride)), key=self._rank)
            stride = stride // 2 if better == best else stride
            best = better
        return best

    def _rank(self, numbers: Numbers) -> tuple[float, float]:
        """Return objective and mass of a design, the smaller the better; each is sized once."""
        if numbers not in self.known:
            self.known[numbers] = self._sized(numbers)
        neighbour, result = self.known[numbers]
        if result is None or neighbour.total_mass_kg is None:
            return _NONE
        return float(f"{-result.merit:.{_DIGITS}g}"), neighbour.total_mass_kg

    def _halves(self, middle: int) -> list[int]:
        """Return the numbers of cells on half of the wing that wing and strings allow."""
        space, ratio = self.aircraft.design_space, self.aircraft.airframe.aspect_ratio
        span_m, tail = space.wingspan_m.maximum, self.layout.tail_count
        ratio = ratio if space.aspect_ratio is None else space.aspect_ratio.minimum
        most = min(self.layout.capacity(Wing(span_m, span_m / ratio)), MOST_CELLS // 2)
        middle = min(middle, most)
        around = range(max(middle - _AROUND, 1), min(middle + _AROUND, most) + 1)
        return [half for half in around if not self._strings(2 * half + tail)[1]]

    # ---- One design

    def _sized(self, numbers: Numbers) -> tuple[Neighbour, SizingResult | None]:
        """Size a design of these numbers of cells, with all else free, from the optimum on."""
        cells = 2 * numbers.per_half + self.layout.tail_count
        strings, reason = self._strings(cells)
        mppts = None if strings is None else strings.mppts(cells)
        best: SizingResult | None = None
        for wing in () if reason else self._wings(numbers.per_half):
            bounds = self._bounds(numbers, cells, wing)
            if isinstance(bounds, str):
                reason = bounds
                continue
            held = self._with_chord(self._without_cells((mppts or 0) / cells), wing)
            result = self.sizing(held, bounds=bounds, start=self.start)
            if result.design is None:
                texts = (violation.text for violation in result.violations)
                reason = "; ".join(texts) or "no design found"
            elif best is None or result.merit > best.merit:
                best = result
        design = None if best is None else best.design
        neighbour = Neighbour(
            cells=cells,
            strings=None if strings is None else len(strings.lengths(cells)),
            mppts=mppts,
            cells_in_parallel=numbers.parallel,
            battery_cells=numbers.parallel * self.pack.cells_in_series,
            value=None if best is None else best.objective_value,
            wingspan_m=None if design is None else float(design.variables.wingspan_m),
            total_mass_kg=None if design is None else float(design.total_mass_kg),
            reason="" if best is not None else reason,
        )
        return neighbour, best

    def _strings(self, cells: int) -> tuple[Strings | None, str]:
        """Return the strings of so many cells, or why there are none."""
        strings = self.layout.strings
        if strings is None:
            return None, ""
        if (divided := strings.for_cells(cells, *self.electric)) is not None:
            return divided, ""
        window = strings.window(*self.electric)
        text = f"{cells} cells do not divide into strings of {window.least} to {window.most}"
        return None, text

    def _wings(self, per_half: int) -> Iterator[Wing]:
        """Yield the smallest wings that hold so many cells: one for each row of a free chord."""

        def span_m(wing_of: Callable[[float], Wing]) -> float:
            return _least_m(lambda b: self.layout.capacity(wing_of(b)) >= per_half)

        if self.aircraft.design_space.aspect_ratio is None:
            ratio = self.aircraft.airframe.aspect_ratio
            least_m = span_m(lambda b: Wing(b, b / ratio))
            yield Wing(least_m, least_m / ratio)
            return
        start, bay = self.start, self.layout.bays[0]
        wing = Wing(float(start.wingspan_m), float(start.wingspan_m / start.aspect_ratio))

        def chord_m(rows: int) -> float:
            fits = self.layout.rows_that_fit
            return _least_m(lambda deep_m: fits(bay, wing._replace(chord_m=deep_m)) >= rows)

        rows = max(self.layout.rows_that_fit(bay, wing), 1)
        for deep_m in (chord_m(rows), chord_m(rows + 1)):
            if math.isfinite(deep_m):
                yield Wing(span_m(partial(Wing, chord_m=deep_m)), deep_m * (1.0 + ROW_TOLERANCE))

    def _bounds(self, numbers: Numbers, cells: int, wing: Wing) -> Bounds | str:
        """Return the bounds that hold these cells and no others, or why there are none."""
        space, held = self.aircraft.design_space, Bounds()
        for name, value, text in (
            ("module_area_m2", cells * self.layout.area_of_a_cell_m2, "module area {:.4g} m²"),
            ("battery_mass_kg", self._battery_kg(numbers.parallel), "battery of {:.4g} kg"),
        ):
            ends, held[name] = getattr(space, name), (value, value)
            if not ends.minimum <= value <= ends.maximum:
                return f"{text.format(value)} is outside design_space.{name}"
        least_m, most_m = max(space.wingspan_m.minimum, wing.wingspan_m), space.wingspan_m.maximum
        if least_m > most_m:
            return (
                f"the cells need a wingspan of {wing.wingspan_m:.4g} m, "
                f"design_space.wingspan_m ends at {most_m:g} m"
            )
        return held | {"wingspan_m": (least_m, most_m)}

    def _with_chord(self, aircraft: Aircraft, wing: Wing) -> Aircraft:
        """Aircraft whose chord is at least that of a wing, where its aspect ratio is free."""
        if (space := aircraft.design_space).aspect_ratio is None:
            return aircraft
        known = space.limits.get("chord_m", Limit.model_construct(minimum=None, maximum=None))
        chord = known.model_copy(update={"minimum": max(known.minimum or 0.0, wing.chord_m)})
        return all_replaced(aircraft, {"design_space.limits.chord_m": chord})

    def _without_cells(self, mppts_per_cell: float) -> Aircraft:
        """Aircraft without cells, whose MPPTs have the mass that the layout gives them."""
        plain, strings = without_whole_cells(self.aircraft), self.layout.strings
        if strings is None or strings.mppt.mass_kg is None:
            return plain
        cell_m2 = self.layout.area_of_a_cell_m2
        cell_w = STC_IRRADIANCE_W_PER_M2 * plain.modules.efficiency_stc * cell_m2
        per_w = mppts_per_cell * strings.mppt.mass_kg / cell_w
        return all_replaced(plain, {"modules.mppt_mass_kg_per_w": per_w})

    def _battery_kg(self, parallel: int) -> float:
        """Return the mass of a battery with so many cells in parallel [kg]."""
        pack = self.pack.model_copy(update={"cells_in_parallel": parallel})
        return pack.mass_kg(self.aircraft.battery.cell_mass_fraction)

    def _limiting(self, result: SizingResult) -> tuple[str, ...]:
        """Return what limits a design; the wing that its cells need as ``whole_cells``."""
        assert result.design is not None
        space, by_cells = self.aircraft.design_space, []
        if result.design.variables.wingspan_m > space.wingspan_m.minimum * (1.0 + ROW_TOLERANCE):
            by_cells.append("wingspan_m at its minimum")
        if space.aspect_ratio is not None:
            by_cells.append("chord_m_minimum")
        names = result.active_constraints
        return tuple(dict.fromkeys("whole_cells" if name in by_cells else name for name in names))

    def _put_in(self, result: SizingResult, numbers: Numbers) -> Aircraft:
        """Return the aircraft of a design, its cells laid on its wing, checked as a file is."""
        assert result.design is not None
        variables = result.design.variables
        strings, _ = self._strings(2 * numbers.per_half + self.layout.tail_count)
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
        put_parts_in(data, self.aircraft, result.design)
        with texts_as_read(self.aircraft.texts_read):
            return Aircraft.model_validate(data)


def _least_m(holds: Callable[[float], bool]) -> float:
    """Least length at which something holds, to a tenth of a millimetre; infinite if none [m]."""
    return bisect(0.0, math.inf, holds, lambda _: _TENTH_OF_A_MM, most=_LONGEST_M)
