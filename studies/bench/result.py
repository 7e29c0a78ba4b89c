"""Values of an aircraft's file that bench tests determine."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from missions.files.errors import InputError, Problem
from sizing.aircraft import Aircraft
from sizing.results.tables import Column, Line, Result, Summary, Table
from studies.bench import capacity, glide, modules, propulsion
from studies.bench.tables import BenchTable, Layout, read_bench
from studies.bench.values import Measured
from studies.fitting.estimation import Fitted, with_fitted
from studies.fitting.least_squares import CONFIDENCE

Evaluate = Callable[[BenchTable, Aircraft], Sequence[Measured]]
_EVALUATE: Mapping[str, Evaluate] = MappingProxyType(
    {
        "iv-curve": modules.evaluate,
        "thrust-stand": propulsion.evaluate,
        "glide-polar": glide.evaluate,
        "capacity": capacity.evaluate,
    }
)
LAYOUTS: Mapping[str, Layout] = MappingProxyType(
    {one.name: one for one in (modules.LAYOUT, propulsion.LAYOUT, glide.LAYOUT, capacity.LAYOUT)}
)


@dataclass(frozen=True, repr=False)
class BenchTests(Result):
    """Bench tests of an aircraft.

    Attributes
    ----------
    aircraft : Aircraft
        As its file describes it.
    fitted : tuple of Fitted
        Keys that the tests determine, with their values and intervals.
    sources : tuple of str
        File of each.
    notes : tuple of str
        What was left out, and what is taken as known.
    """

    aircraft: Aircraft
    fitted: tuple[Fitted, ...]
    sources: tuple[str, ...]
    notes: tuple[str, ...]

    def tested_aircraft(self) -> Aircraft:
        """Aircraft with the values of the tests."""
        return with_fitted(self.aircraft, self.fitted)

    def headline(self) -> str:
        """How many keys change, by how many tests."""
        keys, files = len(self.fitted), len(dict.fromkeys(self.sources))
        return (
            f"{self.aircraft.name}: {keys} key{'' if keys == 1 else 's'} from {files} bench "
            f"test{'' if files == 1 else 's'}"
        )

    def summary(self) -> Summary:
        """Headline, keys with their values before and by the tests, and notes."""
        columns = (
            Column("key"),
            Column("unit"),
            Column("before", form=".4g"),
            Column("value", "test", form=".4g"),
            Column("low", form=".4g"),
            Column("high", form=".4g"),
            Column("source", "from"),
        )
        rows = tuple(
            (one.parameter.key, one.parameter.unit, one.before, one.value, one.low, one.high, file)
            for one, file in zip(self.fitted, self.sources, strict=True)
        )
        table = Table(f"keys of the aircraft's file, {CONFIDENCE:.0%} intervals", columns, rows)
        blocks: list[Any] = [Line(self.headline(), "strong"), table]
        return Summary((*blocks, *(f"- {note}" for note in self.notes)))

    def to_dict(self) -> dict[str, Any]:
        """Keys with values and intervals, JSON-ready."""
        return {
            "aircraft": self.aircraft.name,
            "confidence": CONFIDENCE,
            "fitted": [
                {**one.to_dict(), "source": file}
                for one, file in zip(self.fitted, self.sources, strict=True)
            ],
            "notes": list(self.notes),
        }


def evaluate_bench(aircraft: Aircraft, *files: str | os.PathLike[str]) -> BenchTests:
    """Evaluate bench tests of an aircraft.

    Parameters
    ----------
    aircraft : Aircraft
        What the tests belong to; what they do not determine is taken from it.
    *files : str or path
        CSV files in the layouts of ``solar-uav bench --template``.

    Returns
    -------
    BenchTests

    Raises
    ------
    InputError
        If a file cannot be read, or a test says nothing about this aircraft.
    """
    found: dict[str, tuple[Fitted, str]] = {}
    notes: list[str] = []
    tables = [read_bench(os.fspath(path), LAYOUTS) for path in files]
    # Efficiencies of the propulsion first: a glide polar takes them as known.
    order, tested = list(LAYOUTS), aircraft
    for table in sorted(tables, key=lambda one: order.index(one.layout.name)):
        for one in _EVALUATE[table.layout.name](table, tested):
            key = one.parameter.key
            _refuse_impossible(table, one)
            if key in found:
                message = f"{key} is also determined by {found[key][1]}: give one of the two"
                raise table.refused(message)
            found[key] = (one.fitted(aircraft), table.source)
            notes += one.notes
        tested = with_fitted(aircraft, [one for one, _ in found.values()])
    sources = tuple(source for _, source in found.values())
    return BenchTests(
        aircraft, tuple(one for one, _ in found.values()), sources, tuple(dict.fromkeys(notes))
    )


def _refuse_impossible(table: BenchTable, one: Measured) -> None:
    """Refuse a value that an aircraft cannot have."""
    low, high = one.parameter.lowest, one.parameter.highest
    if not (low < one.value < high and math.isfinite(one.standard_error)):
        message = f"the test gives {one.value:.4g} (allowed: {low:g} to {high:g})"
        raise InputError([Problem(table.source, None, None, one.parameter.key, message)])
