"""Layout of whole solar cells on a wing: number and place of the cells, values of modules.

Places along the span are fractions of the half-span, places along the chord fractions of the local
chord, so that a layout fits wings of any size. Both halves of the wing are equal.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice, pairwise
from typing import Annotated, Any, ClassVar, NamedTuple, TypeAlias

import numpy as np
from pydantic import Field, ValidationError, model_validator

from sizing.catalogues.choice import known_entry
from sizing.catalogues.entries import CellEntry, MpptEntry
from sizing.layout.strings import Strings
from solar.schema import (
    MOST_CELLS,
    NonNegativeInteger,
    NonNegativeReal,
    PositiveReal,
    Record,
    Text,
    UnitInterval,
    is_positive,
    refusal,
    significant,
    spell,
    wrong_value,
)
from solar.shading import TailGeometry

_KEY = "modules.layout"  # of the layout in the aircraft's file
# Tolerance of rounding, far below any gap: relative to a cell, or in metres.
_ROUNDING = 1e-9
# Tolerance of the mean of relative chords, which files round.
_MEAN_TOLERANCE = 0.01
# Starts [m] and numbers of the cells of a row between keep-outs.
_Stretches: TypeAlias = list[tuple[float, int]]
_Row = Annotated[NonNegativeInteger, Field(le=MOST_CELLS)]


class Wing(NamedTuple):
    """Wingspan and mean chord [m]."""

    wingspan_m: float
    chord_m: float


class PlacedCell(NamedTuple):
    """Cell in the plan view: right of the symmetry plane, behind the root's leading edge [m]."""

    left_m: float
    right_m: float
    front_m: float
    rear_m: float


class KeepOut(Record):
    """Part of each half of the wing without cells: a control surface, a joint."""

    _above: ClassVar[Mapping[str, str]] = {"rear": "front"}
    _not_below: ClassVar[Mapping[str, str]] = {"outboard": "inboard"}

    name: Text
    inboard: UnitInterval
    outboard: UnitInterval
    front: UnitInterval = 0.0
    rear: UnitInterval = 1.0
    margin_m: NonNegativeReal = 0.0

    @model_validator(mode="after")
    def _check_span(self) -> KeepOut:
        if self.inboard == self.outboard and not self.margin_m:
            text = f"must be above inboard {spell(self.inboard)}, or have a margin_m"
            raise wrong_value("outboard", text, got=self.outboard)
        return self


class Bay(Record):
    """Part of each half of the wing with straight rows of cells.

    ``cells`` has the number of cells of every row, from front to rear; ``front`` and ``rear`` are
    the usable part of the chord.
    """

    _above: ClassVar[Mapping[str, str]] = {"outboard": "inboard", "rear": "front"}

    inboard: UnitInterval = 0.0
    outboard: UnitInterval = 1.0
    front: UnitInterval = 0.0
    rear: UnitInterval = 1.0
    cells: tuple[_Row, ...]


class Planform(Record):
    """Chord over the mean chord along the half-span, linear in between."""

    _column_over: ClassVar[Mapping[str, str]] = {"relative_chord": "half_span"}

    half_span: tuple[UnitInterval, ...] = Field(min_length=2)
    relative_chord: tuple[PositiveReal, ...] = Field(min_length=2)

    @model_validator(mode="after")
    def _check_table(self) -> Planform:
        if self.half_span[0] != 0.0 or self.half_span[-1] != 1.0:
            raise ValueError("half_span must increase strictly from 0 to 1")
        mean = float(np.trapezoid(self.relative_chord, self.half_span))
        if abs(mean - 1.0) > _MEAN_TOLERANCE:
            text = "the mean of relative_chord along the span must be 1"
            raise ValueError(refusal(text, significant(mean, 3)))
        return self


class CellLayout(Record):
    """Whole cells on wing and tail.

    ``cell_span_m`` and ``cell_chord_m`` are the outline of a cell along span and chord, ``gap_m``
    lies between neighbours both ways. ``cell_area_m2`` is less than the outline if corners are cut;
    by default it is that of the catalogue's entry, or of the outline. ``tail_cells`` are the
    numbers in centred rows on the horizontal tail.
    """

    cell_span_m: PositiveReal
    cell_chord_m: PositiveReal
    gap_m: NonNegativeReal = 0.002
    cell_area_m2: PositiveReal | None = None
    planform: Planform | None = None
    bays: tuple[Bay, ...]
    keep_outs: tuple[KeepOut, ...] = ()
    tail_cells: tuple[_Row, ...] = ()
    strings: Strings | None = None

    @model_validator(mode="after")
    def _check_places(self) -> CellLayout:
        outline = self.cell_span_m * self.cell_chord_m
        if self.area_of_a_cell_m2 > outline * (1.0 + _ROUNDING):
            text = f"must not exceed the outline of a cell, {spell(outline, 4)} m²"
            raise wrong_value("cell_area_m2", text, got=self.area_of_a_cell_m2)
        for i, (bay, following) in enumerate(pairwise(self.bays), 1):
            if following.inboard < bay.outboard:
                text = f"must be at least outboard of the bay before, {spell(bay.outboard)}"
                raise wrong_value(f"bays.{i}.inboard", text, got=following.inboard)
        if not 0 < self.count <= MOST_CELLS:
            text = f"must have from 1 to {MOST_CELLS} cells, both halves and the tail"
            raise wrong_value("bays", text, got=self.count)
        return self

    # ---- Numbers

    @property
    def tail_count(self) -> int:
        """Number of cells on the tail."""
        return sum(self.tail_cells)

    @property
    def count(self) -> int:
        """Number of cells on wing and tail."""
        return 2 * sum(sum(bay.cells) for bay in self.bays) + self.tail_count

    @property
    def area_of_a_cell_m2(self) -> float:
        """Area of a cell [m2]."""
        known = self.cell_area_m2
        return self.cell_span_m * self.cell_chord_m if known is None else known

    @property
    def area_m2(self) -> float:
        """Area of all cells, without gaps [m2]."""
        return self.count * self.area_of_a_cell_m2

    # ---- Places

    def chord_m(self, wing: Wing, place: float) -> float:
        """Return the chord at a fraction of the half-span [m]."""
        if self.planform is None:
            return wing.chord_m
        form = self.planform
        return wing.chord_m * float(np.interp(place, form.half_span, form.relative_chord))

    def leading_edge_m(self, wing: Wing, place: float) -> float:
        """Return the leading edge behind the root's, for a straight quarter-chord line [m]."""
        return (self.chord_m(wing, 0.0) - self.chord_m(wing, place)) / 4.0

    def outline(self, wing: Wing) -> list[tuple[float, float, float]]:
        """Return the wing from left to right: place, leading and trailing edge [m]."""
        ends = (1.0,) if self.planform is None else self.planform.half_span
        half = wing.wingspan_m / 2.0
        edges = [(at, self.leading_edge_m(wing, at), self.chord_m(wing, at)) for at in ends]
        right = [(at * half, front, front + chord) for at, front, chord in edges]
        return [*((-y, front, rear) for y, front, rear in reversed(right) if y > 0.0), *right]

    def placed(self, wing: Wing, tail: TailGeometry | None) -> list[PlacedCell]:
        """Return all cells; refuse those that do not fit on wing or tail."""
        right = [cell for number in range(len(self.bays)) for cell in self._bay(number, wing)]
        left = [cell._replace(left_m=-cell.right_m, right_m=-cell.left_m) for cell in right]
        return [*left, *right, *self._on_tail(tail)]

    def _bay(self, number: int, wing: Wing) -> Iterator[PlacedCell]:
        bay, key = self.bays[number], f"{_KEY}.bays.{number}.cells"
        if not bay.cells:
            return
        room_m, _ = self._band(bay, wing)
        deep_m = self._length(len(bay.cells), self.cell_chord_m)
        if deep_m > room_m + _ROUNDING:
            rows = "a row" if len(bay.cells) == 1 else f"{len(bay.cells)} rows"
            cells_m, needed, has = (
                spell(size_m, 4) for size_m in (self.cell_chord_m, deep_m, max(room_m, 0.0))
            )
            text = f"{rows} of cells of {cells_m} m need {needed} m of chord, the bay has {has} m"
            raise wrong_value(key, f"{text}: at most {self.rows_that_fit(bay, wing)}")
        places = zip(bay.cells, self._rows(bay, wing, len(bay.cells)), strict=True)
        for row, (cells, (front_m, stretches)) in enumerate(places):
            if cells > (most := sum(count for _, count in stretches)):
                size_m, gap_m = spell(self.cell_span_m), spell(self.gap_m)
                text = f"the cells of {size_m} m with gaps of {gap_m} m that the row holds"
                raise wrong_value(f"{key}.{row}", f"must be at most {most}, {text}", got=cells)
            yield from islice(self._laid(stretches, front_m), cells)

    def rows_that_fit(self, bay: Bay, wing: Wing) -> int:
        """Return the number of rows that fit in the chord of a bay."""
        return _pieces(self._band(bay, wing)[0], self.cell_chord_m, self.gap_m)

    def _rows(self, bay: Bay, wing: Wing, count: int) -> Iterator[tuple[float, _Stretches]]:
        """Yield front edge [m] and stretches of rows centred in a bay's part of the chord."""
        room_m, front_m = self._band(bay, wing)
        first_m = front_m + (room_m - self._length(count, self.cell_chord_m)) / 2.0
        for row in range(count):
            at_m = first_m + row * (self.cell_chord_m + self.gap_m)
            yield at_m, self._stretches(bay, wing, at_m)

    def _band(self, bay: Bay, wing: Wing) -> tuple[float, float]:
        """Return depth and front of a bay's part of the chord for straight rows [m]."""
        breaks = () if self.planform is None else self.planform.half_span
        places = [bay.inboard, *(at for at in breaks if bay.inboard < at < bay.outboard)]
        every = (*places, bay.outboard)
        ends = [(self.leading_edge_m(wing, at), self.chord_m(wing, at)) for at in every]
        front_m = max(edge + bay.front * chord for edge, chord in ends)
        return min(edge + bay.rear * chord for edge, chord in ends) - front_m, front_m

    def _stretches(self, bay: Bay, wing: Wing, front_m: float) -> _Stretches:
        """Return the stretches of a row between keep-outs: start [m] and number of cells."""
        rear_m, half_m = front_m + self.cell_chord_m, wing.wingspan_m / 2.0
        # Half a gap to the other half of the wing.
        start_m = max(bay.inboard * half_m, self.gap_m / 2.0)
        end_m, stretches = bay.outboard * half_m, []
        taken = []
        for corners in self.kept_out_corners(wing):
            along, aft = zip(*corners, strict=True)
            if min(aft) < rear_m - _ROUNDING and max(aft) > front_m + _ROUNDING:
                taken.append((min(along), max(along)))
        for low_m, high_m in [*sorted(taken), (end_m, math.inf)]:
            length_m = min(low_m, end_m) - start_m
            stretches.append((start_m, _pieces(length_m, self.cell_span_m, self.gap_m)))
            start_m = max(start_m, high_m)
        return stretches

    def _laid(self, stretches: Iterable[tuple[float, int]], front_m: float) -> Iterator[PlacedCell]:
        for start_m, count in stretches:
            for number in range(count):
                left_m = start_m + number * (self.cell_span_m + self.gap_m)
                yield PlacedCell(
                    left_m, left_m + self.cell_span_m, front_m, front_m + self.cell_chord_m
                )

    def kept_out_corners(self, wing: Wing) -> list[list[tuple[float, float]]]:
        """Return the corners of the keep-outs: right of the middle, and aft [m]."""
        half_m = wing.wingspan_m / 2.0
        return [
            [
                (at * half_m + beyond * part.margin_m, edge_m + place * chord_m)
                for at, beyond, places in (
                    (part.inboard, -1.0, (part.rear, part.front)),
                    (part.outboard, 1.0, (part.front, part.rear)),
                )
                for edge_m, chord_m in [(self.leading_edge_m(wing, at), self.chord_m(wing, at))]
                for place in places
            ]
            for part in self.keep_outs
        ]

    def _on_tail(self, tail: TailGeometry | None) -> Iterator[PlacedCell]:
        if not self.tail_cells:
            return
        if tail is None:
            raise wrong_value(
                f"{_KEY}.tail_cells", "needs modules.tail, the size of the horizontal tail"
            )
        deep_m = self._length(len(self.tail_cells), self.cell_chord_m)
        wide_m = self._length(max(self.tail_cells), self.cell_span_m)
        for needed_m, has_m, what in (
            (deep_m, tail.horizontal_chord_m, "chord"),
            (wide_m, tail.horizontal_span_m, "span"),
        ):
            if needed_m > has_m + _ROUNDING:
                text = f"the cells need {spell(needed_m, 4)} m of the tail's {what}, it has "
                raise wrong_value(f"{_KEY}.tail_cells", f"{text}{spell(has_m, 4)} m")
        first_m = tail.horizontal_aft_m + (tail.horizontal_chord_m - deep_m) / 2.0
        for row, count in enumerate(self.tail_cells):
            front_m = first_m + row * (self.cell_chord_m + self.gap_m)
            yield from self._laid([(-self._length(count, self.cell_span_m) / 2.0, count)], front_m)

    def _length(self, count: int, size_m: float) -> float:
        """Return the length of cells in line, with the gaps between them [m]."""
        return count * size_m + max(count - 1, 0) * self.gap_m

    # ---- As many as fit

    def _as_many_rows(self, wing: Wing) -> Iterator[tuple[int, int, float, _Stretches]]:
        """Yield bay, row, front edge [m] and stretches of all rows that fit on half of a wing."""
        for number, bay in enumerate(self.bays):
            rows = self._rows(bay, wing, self.rows_that_fit(bay, wing))
            yield from ((number, row, *place) for row, place in enumerate(rows))

    def capacity(self, wing: Wing) -> int:
        """Return the number of cells that fit on half of a wing."""
        return sum(count for *_, parts in self._as_many_rows(wing) for _, count in parts)

    def with_cells(self, per_half: int, wing: Wing, strings: Strings | None) -> CellLayout:
        """Return the layout with a number of cells on each half, from the middle outwards."""
        most = self.capacity(wing)
        if per_half > most:
            text = f"half of the wing holds {most} cells, not {per_half}"
            raise wrong_value(f"{_KEY}.bays", text)
        counts = [[0] * self.rows_that_fit(bay, wing) for bay in self.bays]
        places = [
            (cell.right_m, row, number)
            for number, row, front_m, stretches in self._as_many_rows(wing)
            for cell in islice(self._laid(stretches, front_m), per_half)
        ]
        for _, row, number in sorted(places)[:per_half]:
            counts[number][row] += 1
        bays = [
            bay.model_copy(update={"cells": tuple(cells) if any(cells) else ()})
            for bay, cells in zip(self.bays, counts, strict=True)
        ]
        return self.model_copy(update={"bays": tuple(bays), "strings": strings})


def _pieces(length_m: float, size_m: float, gap_m: float) -> int:
    """Return the number of pieces of a size that fit into a length, with gaps between them."""
    return max(math.floor((length_m + gap_m) / (size_m + gap_m) + _ROUNDING), 0)


def rows_text(cells: Sequence[int]) -> str:
    """Return the rows of a bay in words: ``2 rows of 22``, ``rows of 13 and 12``."""
    if not cells:
        return "none"
    if len(set(cells)) > 1:
        return f"rows of {', '.join(map(str, cells[:-1]))} and {cells[-1]}"
    return f"{len(cells)} row{'s' if len(cells) > 1 else ''} of {cells[0]}"


# ---- Layout of an aircraft's file

_OF_A_CELL = ("mpp_voltage_v", "open_circuit_voltage_v", "mpp_current_a")
_HALF_A_CELL = 0.5  # tolerance of a given area, in cells


def with_layout_values(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the modules' data with the area of the layout's cells.

    Wrong data are left to the validation of the records.
    """
    raw = data["layout"]
    raw = raw.model_dump(exclude_unset=True) if isinstance(raw, Record) else raw
    if not isinstance(raw, Mapping):
        return data
    board = known_entry("mppts", data, "mppt_board")
    layout = _with_entry(raw, known_entry("cells", data, "cell"), board)
    try:
        cells = CellLayout.model_validate(layout)
    except ValidationError:
        return {"area_m2": 0.0, **data, "layout": layout}
    area = data.get("area_m2")
    if "area_m2" in data and not (area == 0.0 or is_positive(area)):
        return {**data, "layout": layout}
    if area is not None and abs(area / cells.area_of_a_cell_m2 - cells.count) >= _HALF_A_CELL:
        text = f"must be that of the {cells.count} cells of modules.layout, "
        text += f"{spell(cells.area_m2, 4)} m², or left out"
        raise wrong_value("area_m2", text, got=area)
    return {**data, "layout": layout, "area_m2": cells.area_m2}


def _with_entry(
    raw: Mapping[str, Any], entry: CellEntry | None, board: MpptEntry | None
) -> dict[str, Any]:
    """Return the layout with missing area and voltages from the catalogue's cell and MPPT."""
    layout, strings = dict(raw), raw.get("strings")
    if board is not None and isinstance(strings, Mapping):
        mppt = strings.get("mppt", {})
        mppt = board.window() | dict(mppt) if isinstance(mppt, Mapping) else mppt
        layout["strings"] = strings = {**strings, "mppt": mppt}
    if entry is None:
        return layout
    part = _part_of(raw, entry.area_m2)
    if part == 1.0:
        layout.setdefault("cell_area_m2", entry.area_m2)
    if isinstance(strings, Mapping):
        known = {key: getattr(entry, key) for key in _OF_A_CELL}
        if known["mpp_current_a"] is not None:
            known["mpp_current_a"] *= part
        layout["strings"] = {k: v for k, v in known.items() if v is not None} | dict(strings)
    return layout


def _part_of(raw: Mapping[str, Any], area_m2: float | None) -> float:
    """Return the area of the layout's cell over the catalogue's: 1 for a whole cell [-].

    Current scales with the area, voltage does not. A whole cell has at least the area of the round
    wafer in its outline.
    """
    span_m, chord_m = raw.get("cell_span_m"), raw.get("cell_chord_m")
    if area_m2 is None or not is_positive(span_m) or not is_positive(chord_m):
        return 1.0
    outline, cell_area_m2 = span_m * chord_m, raw.get("cell_area_m2")
    if math.pi / 4.0 * outline <= area_m2 <= outline:
        return 1.0
    return (cell_area_m2 if is_positive(cell_area_m2) else outline) / area_m2


def check_layout(
    layout: CellLayout,
    wing: Wing,
    tail: TailGeometry | None,
    loss_per_k: float,
    battery_v: tuple[float, float] | None,
) -> None:
    """Refuse cells that do not fit on wing and tail, and strings that do not fit the MPPT."""
    layout.placed(wing, tail)
    strings = layout.strings
    if strings is None:
        return
    if battery_v is None and strings.mppt.conversion != "any":
        text = f"required key is missing: modules.layout.strings.mppt has {strings.mppt.conversion}"
        raise wrong_value("battery.voltage", text)
    problem = strings.problem(layout.count, loss_per_k, battery_v)
    if problem is not None:
        raise wrong_value(f"modules.layout.strings.{problem[0]}", problem[1])
