"""Whole solar cells laid on a wing: how many fit, and where each lies.

Places along the span are fractions of the half-span, places along the chord fractions of the local
chord, so that a layout goes with a wing of any size. Both halves of the wing are alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice, pairwise
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from sizing.layout.strings import Strings
from solar.schema import (
    MOST_CELLS,
    NonNegativeInteger,
    NonNegativeReal,
    PositiveReal,
    Record,
    Text,
    UnitInterval,
    check_order,
    wrong_value,
)
from solar.shading import TailGeometry

# A cell that lacks less than this of its own size fits: rounding, far below any gap.
_ROUNDING = 1e-9
# The mean of the chords may be off by what a file rounds.
_MEAN_TOLERANCE = 0.01
_Row = Annotated[NonNegativeInteger, Field(le=MOST_CELLS)]


class LayoutError(ValueError):
    """A layout that a wing does not hold; ``key`` is below ``modules.layout``."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


class Wing(NamedTuple):
    """Wingspan and mean chord [m]."""

    wingspan_m: float
    chord_m: float


class PlacedCell(NamedTuple):
    """A cell in the plan view: right of the symmetry plane, behind the root's leading edge [m]."""

    left_m: float
    right_m: float
    front_m: float
    rear_m: float

    def mirrored(self) -> PlacedCell:
        """Cell of the other half."""
        return self._replace(left_m=-self.right_m, right_m=-self.left_m)


class KeepOut(Record):
    """Part of each half of the wing that bears no cells: a control surface, a joint."""

    name: Text
    inboard: UnitInterval
    outboard: UnitInterval
    front: UnitInterval = 0.0
    rear: UnitInterval = 1.0
    margin_m: NonNegativeReal = 0.0

    @model_validator(mode="after")
    def _check_order(self) -> KeepOut:
        check_order(self, "inboard", "outboard", equal=self.margin_m > 0.0)
        check_order(self, "front", "rear")
        return self


class Bay(Record):
    """Part of each half of the wing with straight rows of cells.

    ``cells`` has the number along the span of every row, the front one first; ``front`` and
    ``rear`` are the part of the chord that may bear cells.
    """

    inboard: UnitInterval = 0.0
    outboard: UnitInterval = 1.0
    front: UnitInterval = 0.0
    rear: UnitInterval = 1.0
    cells: tuple[_Row, ...]

    @model_validator(mode="after")
    def _check_order(self) -> Bay:
        check_order(self, "inboard", "outboard")
        check_order(self, "front", "rear")
        return self


class Planform(Record):
    """Chord over the mean chord along the half-span, linear in between."""

    half_span: tuple[UnitInterval, ...] = Field(min_length=2)
    relative_chord: tuple[PositiveReal, ...] = Field(min_length=2)

    @model_validator(mode="after")
    def _check_table(self) -> Planform:
        at, wrong = self.half_span, ""
        if len(at) != len(self.relative_chord):
            wrong = "relative_chord must have a value for each of half_span"
        elif at[0] != 0.0 or at[-1] != 1.0 or np.any(np.diff(at) <= 0.0):
            wrong = "half_span must increase strictly from 0 to 1"
        elif abs((mean := float(np.trapezoid(self.relative_chord, at))) - 1.0) > _MEAN_TOLERANCE:
            wrong = f"the mean of relative_chord along the span must be 1 (got {mean:.3g})"
        if wrong:
            raise ValueError(wrong)
        return self


class CellLayout(Record):
    """Whole cells on wing and tail.

    ``cell_span_m`` and ``cell_chord_m`` are the outline of a cell along span and chord, ``gap_m``
    lies between neighbours both ways. ``cell_area_m2`` is less than the outline where corners are
    cut; without it that of the catalogue's entry, else of the outline. ``tail_cells`` are the
    numbers in the rows on the horizontal tail, which lie in its middle.
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
            raise wrong_value(
                "cell_area_m2",
                f"must not exceed the outline of a cell, {outline:.4g} m² "
                f"(got {self.area_of_a_cell_m2:g})",
            )
        for i, (one, other) in enumerate(pairwise(self.bays), 1):
            if other.inboard < one.outboard:
                raise wrong_value(
                    f"bays.{i}.inboard",
                    f"must be at least outboard of the bay before, {one.outboard:g} "
                    f"(got {other.inboard:g})",
                )
        if not 0 < self.count <= MOST_CELLS:
            raise wrong_value(
                "bays",
                f"must have from 1 to {MOST_CELLS} cells, both halves and the tail "
                f"(got {self.count})",
            )
        return self

    # ---- Numbers

    @property
    def tail_count(self) -> int:
        """Cells on the tail."""
        return sum(self.tail_cells)

    @property
    def count(self) -> int:
        """Cells on wing and tail."""
        return 2 * sum(sum(bay.cells) for bay in self.bays) + self.tail_count

    @property
    def area_of_a_cell_m2(self) -> float:
        """Area of one cell."""
        known = self.cell_area_m2
        return self.cell_span_m * self.cell_chord_m if known is None else known

    @property
    def area_m2(self) -> float:
        """Area of all cells, without gaps."""
        return self.count * self.area_of_a_cell_m2

    # ---- Places

    def chord_m(self, wing: Wing, place: float) -> float:
        """Chord at a fraction of the half-span [m]."""
        if self.planform is None:
            return wing.chord_m
        form = self.planform
        return wing.chord_m * float(np.interp(place, form.half_span, form.relative_chord))

    def leading_edge_m(self, wing: Wing, place: float) -> float:
        """Leading edge behind that of the root [m]; the line of the quarter chords is straight."""
        return (self.chord_m(wing, 0.0) - self.chord_m(wing, place)) / 4.0

    def outline(self, wing: Wing) -> list[tuple[float, float, float]]:
        """Wing from left to right: place from the middle, leading and trailing edge [m]."""
        ends = (1.0,) if self.planform is None else self.planform.half_span
        half = wing.wingspan_m / 2.0
        edges = [(at, self.leading_edge_m(wing, at), self.chord_m(wing, at)) for at in ends]
        right = [(at * half, front, front + chord) for at, front, chord in edges]
        return [*((-y, front, rear) for y, front, rear in reversed(right) if y > 0.0), *right]

    def placed(self, wing: Wing, tail: TailGeometry | None) -> list[PlacedCell]:
        """Every cell; :class:`LayoutError` where wing or tail does not hold them."""
        right = [cell for number in range(len(self.bays)) for cell in self._bay(number, wing)]
        return [*(cell.mirrored() for cell in right), *right, *self._on_tail(tail)]

    def _bay(self, number: int, wing: Wing) -> Iterator[PlacedCell]:
        bay = self.bays[number]
        if not bay.cells:
            return
        room_m, _ = self._band(bay, wing)
        deep_m = self._length(len(bay.cells), self.cell_chord_m)
        if deep_m > room_m + _ROUNDING:
            rows = "a row" if len(bay.cells) == 1 else f"{len(bay.cells)} rows"
            raise LayoutError(
                f"bays.{number}.cells",
                f"{rows} of cells of {self.cell_chord_m:g} m need {deep_m:.4g} m of chord, the bay "
                f"has {max(room_m, 0.0):.4g} m: at most {self.rows_that_fit(bay, wing)}",
            )
        for row, (wanted, front_m) in enumerate(
            zip(bay.cells, self._fronts(bay, wing, len(bay.cells)), strict=True)
        ):
            stretches = self._stretches(bay, wing, front_m)
            if wanted > (most := sum(count for _, count in stretches)):
                raise LayoutError(
                    f"bays.{number}.cells.{row}",
                    f"must be at most {most}, the cells of {self.cell_span_m:g} m with gaps of "
                    f"{self.gap_m:g} m that the row holds (got {wanted})",
                )
            yield from islice(self._laid(stretches, front_m), wanted)

    def rows_that_fit(self, bay: Bay, wing: Wing) -> int:
        """Rows of cells that the chord of a bay holds."""
        return _pieces(self._band(bay, wing)[0], self.cell_chord_m, self.gap_m)

    def _fronts(self, bay: Bay, wing: Wing, count: int) -> list[float]:
        """Front edges of so many rows of a bay, in the middle of its part of the chord [m]."""
        room_m, front_m = self._band(bay, wing)
        first_m = front_m + (room_m - self._length(count, self.cell_chord_m)) / 2.0
        return [first_m + row * (self.cell_chord_m + self.gap_m) for row in range(count)]

    def _band(self, bay: Bay, wing: Wing) -> tuple[float, float]:
        """Depth of the part of the chord that a whole bay has for straight rows, and its front."""
        breaks = () if self.planform is None else self.planform.half_span
        places = [bay.inboard, *(at for at in breaks if bay.inboard < at < bay.outboard)]
        ends = [
            (self.leading_edge_m(wing, at), self.chord_m(wing, at))
            for at in (*places, bay.outboard)
        ]
        front_m = max(edge + bay.front * chord for edge, chord in ends)
        return min(edge + bay.rear * chord for edge, chord in ends) - front_m, front_m

    def _stretches(self, bay: Bay, wing: Wing, front_m: float) -> list[tuple[float, int]]:
        """Stretches of a row between keep-outs: where each begins [m], and the cells it holds."""
        rear_m, half_m = front_m + self.cell_chord_m, wing.wingspan_m / 2.0
        # The halves are neighbours in the middle.
        start_m = max(bay.inboard * half_m, self.gap_m / 2.0)
        end_m, found = bay.outboard * half_m, []
        taken = sorted(
            (low, high)
            for low, high, ahead, behind in self._kept_out(wing)
            if ahead < rear_m - _ROUNDING and behind > front_m + _ROUNDING
        )
        for low_m, high_m in [*taken, (end_m, math.inf)]:
            length_m = min(low_m, end_m) - start_m
            found.append((start_m, _pieces(length_m, self.cell_span_m, self.gap_m)))
            start_m = max(start_m, high_m)
        return found

    def _laid(self, stretches: Iterable[tuple[float, int]], front_m: float) -> Iterator[PlacedCell]:
        for start_m, count in stretches:
            for number in range(count):
                left_m = start_m + number * (self.cell_span_m + self.gap_m)
                yield PlacedCell(
                    left_m, left_m + self.cell_span_m, front_m, front_m + self.cell_chord_m
                )

    def kept_out_corners(self, wing: Wing) -> list[list[tuple[float, float]]]:
        """Corners of the parts without cells: right of the middle, and aft [m]."""
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

    def _kept_out(self, wing: Wing) -> Iterator[tuple[float, float, float, float]]:
        """Rectangles around them: both ends along the span, front and rear [m]."""
        for corners in self.kept_out_corners(wing):
            along, aft = zip(*corners, strict=True)
            yield min(along), max(along), min(aft), max(aft)

    def _on_tail(self, tail: TailGeometry | None) -> Iterator[PlacedCell]:
        if not self.tail_cells:
            return
        if tail is None:
            raise LayoutError("tail_cells", "needs modules.tail, the size of the horizontal tail")
        deep_m = self._length(len(self.tail_cells), self.cell_chord_m)
        wide_m = self._length(max(self.tail_cells), self.cell_span_m)
        for needed_m, has_m, what in (
            (deep_m, tail.horizontal_chord_m, "chord"),
            (wide_m, tail.horizontal_span_m, "span"),
        ):
            if needed_m > has_m + _ROUNDING:
                raise LayoutError(
                    "tail_cells",
                    f"the cells need {needed_m:.4g} m of the tail's {what}, it has {has_m:.4g} m",
                )
        first_m = tail.horizontal_aft_m + (tail.horizontal_chord_m - deep_m) / 2.0
        for row, count in enumerate(self.tail_cells):
            front_m = first_m + row * (self.cell_chord_m + self.gap_m)
            left_m = -self._length(count, self.cell_span_m) / 2.0
            for number in range(count):
                at_m = left_m + number * (self.cell_span_m + self.gap_m)
                yield PlacedCell(
                    at_m, at_m + self.cell_span_m, front_m, front_m + self.cell_chord_m
                )

    def _length(self, count: int, size_m: float) -> float:
        """Length of some cells in line, with the gaps between them [m]."""
        return count * size_m + max(count - 1, 0) * self.gap_m

    # ---- As many as fit

    def capacity(self, wing: Wing) -> int:
        """Cells that half of a wing holds."""
        return sum(
            count
            for bay in self.bays
            for front_m in self._fronts(bay, wing, self.rows_that_fit(bay, wing))
            for _, count in self._stretches(bay, wing, front_m)
        )

    def with_cells(self, per_half: int, wing: Wing, strings: Strings | None) -> CellLayout:
        """Layout with so many cells on each half, from the middle outwards."""
        most = self.capacity(wing)
        if per_half > most:
            raise LayoutError("bays", f"half of the wing holds {most} cells, not {per_half}")
        counts = [[0] * self.rows_that_fit(bay, wing) for bay in self.bays]
        places = [
            (cell.right_m, row, number)
            for number, bay in enumerate(self.bays)
            for row, front_m in enumerate(self._fronts(bay, wing, self.rows_that_fit(bay, wing)))
            for cell in islice(self._laid(self._stretches(bay, wing, front_m), front_m), per_half)
        ]
        for _, row, number in sorted(places)[:per_half]:
            counts[number][row] += 1
        bays = [
            bay.model_copy(update={"cells": tuple(cells) if any(cells) else ()})
            for bay, cells in zip(self.bays, counts, strict=True)
        ]
        return self.model_copy(update={"bays": tuple(bays), "strings": strings})


def _pieces(length_m: float, size_m: float, gap_m: float) -> int:
    """Pieces of a size that a length holds, with gaps between them."""
    return max(math.floor((length_m + gap_m) / (size_m + gap_m) + _ROUNDING), 0)


def rows_text(cells: Sequence[int]) -> str:
    """Rows of a bay in words: ``2 rows of 22``, ``rows of 13 and 12``."""
    if not cells:
        return "none"
    if len(set(cells)) > 1:
        return f"rows of {', '.join(map(str, cells[:-1]))} and {cells[-1]}"
    return f"{len(cells)} row{'s' if len(cells) > 1 else ''} of {cells[0]}"
