"""One design of whole cells: whether it can be laid and strung, and how it is sized.

Its solar and battery cells are held; the program chooses what is left, wingspan above all, which
must hold the cells, and the simulator decides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

from missions.files.texts import texts_as_read
from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.chosen_parts import put_parts_in
from sizing.design import DesignVariables
from sizing.design_space import Limit, Range
from sizing.energy.battery_pack import BatteryPack
from sizing.layout.cells import CellLayout, Wing
from sizing.layout.strings import Strings
from sizing.program.objectives import Objective
from sizing.program.result import SizingResult
from sizing.program.size import size_aircraft
from sizing.sunlight import SolarModel
from solar.modules import STC_IRRADIANCE_W_PER_M2

# Objectives that differ by less are equal: the lighter design is then the better one.
_SAME = 1e-6
# The solver meets its rows to about 1e-8.
ROW_ROOM = 1e-6
_PER_M = 10_000  # lengths that are tried
_LONGEST_M = 10_000.0


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
class Found:
    """A neighbour with its sizing."""

    numbers: Numbers
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

    def beats(self, other: Found) -> bool:
        """Whether it is better, or as good and lighter."""
        (own, own_kg), (its, its_kg) = self.rank, other.rank
        if math.isclose(own, its, rel_tol=_SAME):
            return own_kg < its_kg * (1.0 - _SAME)
        return own < its


def without_whole_cells(aircraft: Aircraft) -> Aircraft:
    """Aircraft with the technology that its whole cells give it, and none of them; unchecked."""
    modules, battery = aircraft.modules, aircraft.battery
    if modules.layout is not None:
        given = {key: getattr(modules, key) for key in ("area_m2", "mppt_mass_kg_per_w")}
        modules = modules.model_copy(update={"layout": None, **given})
    if battery.pack is not None:
        keys = ("mass_kg", "specific_energy_wh_per_kg", "charge_limit")
        given = {key: getattr(battery, key) for key in keys}
        battery = battery.model_copy(update={"pack": None, **given})
    return aircraft.model_copy(update={"modules": modules, "battery": battery})


class CellDesigns:
    """Designs of whole cells of an aircraft for a mission and an objective."""

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
        # Loss of voltage per kelvin where strings have none of their own, and the battery's ends.
        self.electric = aircraft.modules.temperature_coefficient_per_k, aircraft.battery.ends_v

    def relaxed(self) -> SizingResult:
        """Sizing with continuous area, battery and MPPTs, each of these with all that it takes."""
        strings, plain = self.layout.strings, self.plain
        if strings is not None:
            most = max(strings.window(*self.electric).most, 1)
            plain = self._with_mppts(1.0, strings.strings_per_mppt * most)
        return self._sizing(plain)

    def battery_kg(self, parallel: int) -> float:
        """Mass of a battery with so many cells in parallel [kg]."""
        pack = self.pack.model_copy(update={"cells_in_parallel": parallel})
        return pack.mass_kg(self.aircraft.battery.cell_mass_fraction)

    def sized(self, numbers: Numbers, start: DesignVariables) -> Found:
        """Design of some numbers of cells, with all else free, from the relaxed optimum on."""
        cells = 2 * numbers.per_half + self.layout.tail_count
        strings, reason = self.strings(cells)
        results: list[tuple[SizingResult, Aircraft]] = []
        if not reason:
            for wing in self._wings(numbers.per_half, start):
                held = self._held(numbers, cells, wing)
                if isinstance(held, str):
                    reason = held
                    continue
                result = self._sizing(held, start)
                if result.design is None:
                    reason = _why(result)
                    continue
                results.append((result, self._put_in(result, numbers, strings)))
        best = max(results, key=lambda one: one[0].merit, default=None)
        design = None if best is None else best[0].design
        neighbour = Neighbour(
            cells=cells,
            strings=None if strings is None else len(strings.lengths(cells)),
            mppts=None if strings is None else strings.mppts(cells),
            cells_in_parallel=numbers.parallel,
            battery_cells=numbers.parallel * self.pack.cells_in_series,
            value=None if best is None else best[0].objective_value,
            wingspan_m=None if design is None else float(design.variables.wingspan_m),
            total_mass_kg=None if design is None else float(design.total_mass_kg),
            reason="" if best is not None else reason,
        )
        return Found(numbers, neighbour, *(best or (None, None)))

    def strings(self, cells: int) -> tuple[Strings | None, str]:
        """Strings of so many cells; why there are none."""
        strings = self.layout.strings
        if strings is None:
            return None, ""
        found = strings.for_cells(cells, *self.electric)
        if found is not None:
            return found, ""
        window = strings.window(*self.electric)
        return None, (
            f"{cells} cells do not divide into strings of {window.least} to {window.most}"
        )

    def _wings(self, per_half: int, start: DesignVariables) -> Iterator[Wing]:
        """Smallest wings that hold so many cells: one, or with a free aspect ratio one per row."""
        airframe, space = self.aircraft.airframe, self.aircraft.design_space
        if space.aspect_ratio is None:
            ratio = airframe.aspect_ratio
            span_m = self._least(lambda b: Wing(b, b / ratio), per_half)
            yield Wing(span_m, span_m / ratio)
            return
        wing = Wing(float(start.wingspan_m), float(start.wingspan_m / start.aspect_ratio))
        rows = max(self.layout.rows_that_fit(self.layout.bays[0], wing), 1)
        for count in (rows, rows + 1):
            deep_m = _least_chord_m(self.layout, count, wing.wingspan_m)
            if math.isinf(deep_m):
                continue
            span_m = self._least(partial(Wing, chord_m=deep_m), per_half)
            yield Wing(span_m, deep_m * (1.0 + ROW_ROOM))

    def _least(self, wing_of: Callable[[float], Wing], per_half: int) -> float:
        """Least wingspan whose wing holds so many cells on each half [m]."""
        return _bisected(lambda b: self.layout.capacity(wing_of(b)) >= per_half)

    def _held(self, numbers: Numbers, cells: int, wing: Wing) -> Aircraft | str:
        """Aircraft whose design space holds these cells and no others; why there is none."""
        space, airframe = self.aircraft.design_space, self.plain.airframe
        assert isinstance(airframe, ParametricAirframe)
        held: dict[str, Any] = {}
        for name, value, text in (
            ("module_area_m2", cells * self.layout.area_of_a_cell_m2, "module area {:.4g} m²"),
            ("battery_mass_kg", self.battery_kg(numbers.parallel), "battery of {:.4g} kg"),
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
        strings = self.strings(cells)[0]
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

    def _sizing(self, aircraft: Aircraft, start: DesignVariables | None = None) -> SizingResult:
        """Sizing of a design space."""
        required_h = self.required_h
        return size_aircraft(aircraft, *self.given, required_excess_time_h=required_h, start=start)

    def _put_in(self, result: SizingResult, numbers: Numbers, strings: Strings | None) -> Aircraft:
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
        data["battery"]["mass_kg"] = self.battery_kg(numbers.parallel)
        put_parts_in(data, self.aircraft, result.design)
        if variables.lift_coefficient is not None:
            data["airframe"]["aerodynamics"]["lift_coefficient"] = float(variables.lift_coefficient)
        with texts_as_read(self.aircraft.texts_read):
            return Aircraft.model_validate(data)


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
