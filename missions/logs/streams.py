"""Logs of autopilots: streams of messages, each with its own times, put together into one log."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missions.files.errors import InputError, Problem, file_error, printable
from missions.logs.columns import ColumnMap, Recipe, Source, recipes_for
from missions.logs.quantities import EPOCH
from missions.logs.table import REQUIRED, FlightLog, Series, log_from_table, sampled
from solar.types import BoolArray, FloatArray

_FIX_3D = 3
_STREAM = re.compile(r"([A-Za-z0-9_]+)(?:\[\d+\])?\.")


class Stream(NamedTuple):
    """Messages over time since boot [s]; ``kind``: what their format calls them."""

    name: str
    time_s: FloatArray
    fields: Mapping[str, NDArray[Any]]
    kind: str = "message"

    def field(self, source: str, *names: str) -> FloatArray:
        """First of some fields that there is."""
        for name in names:
            if name in self.fields:
                return np.asarray(self.fields[name], float)
        message = f"{printable(self.name)} has no field {' or '.join(names)}"
        raise file_error(source, f"{self.kind} {message}")

    def has_fix(self, status: str) -> BoolArray:
        """Whether the satellites gave a position, by a field that says so; always without it."""
        if status not in self.fields:
            return np.ones(len(self.time_s), bool)
        return np.asarray(self.fields[status] >= _FIX_3D)

    def series(self, values: Mapping[str, NDArray[Any]]) -> dict[str, Series]:
        """Quantities at the times of the messages."""
        return {name: Series(self.time_s, np.asarray(v, float)) for name, v in values.items()}

    def rising(self) -> Stream:
        """Stream without the messages whose times do not rise, as in damaged logs."""
        keep = np.isfinite(self.time_s)
        highest = np.maximum.accumulate(np.where(keep, self.time_s, -np.inf))
        keep &= np.concatenate(([True], self.time_s[1:] > highest[:-1]))
        fields = {name: values[keep] for name, values in self.fields.items()}
        return self._replace(time_s=self.time_s[keep], fields=fields)


def kinds_named(layout: ColumnMap) -> set[str]:
    """Kinds of messages that a map of columns names."""
    texts = [s.name or "" if isinstance(s, Source) else s for s in layout.columns.values()]
    return {match[1] for text in texts for match in _STREAM.finditer(text)}


def given_series(
    streams: Mapping[str, Stream], layout: ColumnMap, source: str
) -> dict[str, Series]:
    """Quantities that a map of columns makes of ``STREAM.FIELD``."""
    header = [f"{name}.{field}" for name, stream in streams.items() for field in stream.fields]
    recipes = recipes_for(header, layout, guess=False)
    if recipes.problems:
        raise InputError(Problem(source, None, None, "", text) for text in recipes.problems)
    made = (_made(recipe, streams) for name, recipe in recipes.found.items() if name != "time")
    return {name: series for every in made for name, series in every.items()}


def _made(recipe: Recipe, streams: Mapping[str, Stream]) -> dict[str, Series]:
    """Series at the times of its first stream, and of several MPPTs the power of each."""
    if recipe.value is not None:
        return {recipe.quantity: Series(np.full(1, np.nan), np.full(1, recipe.value))}
    first = streams[recipe.columns[0].rpartition(".")[0]].time_s

    def column(name: str) -> FloatArray:
        stream, _, field = name.rpartition(".")
        values = np.asarray(streams[stream].fields[field], float)
        return sampled(Series(streams[stream].time_s, values), first)

    return {name: Series(first, values) for name, values in recipe.values(column).items()}


def log_from_series(
    series: Mapping[str, Series],
    boot_s: float,
    source: str,
    notes: Sequence[str],
    layout: ColumnMap,
) -> FlightLog:
    """Put quantities together at the times of the solar power, those of one value at all."""
    if needed := set(REQUIRED) & set(layout.ignore):
        raise file_error(source, f"{min(needed)} cannot be ignored: it is needed")
    time_s = series["solar_power_w"].time_s
    columns: dict[str, Any] = {EPOCH: time_s + boot_s}
    for quantity, one in series.items():
        if quantity not in layout.ignore:
            columns[quantity] = sampled(one, time_s, quantity)
    return log_from_table(pd.DataFrame(columns), source, notes, layout.exclude)


def no_power(streams: Mapping[str, Stream], source: str, example: str) -> InputError:
    """Error of a log that does not say which message holds the solar power."""
    names = ", ".join(printable(name) for name in list(streams)[:12]) or "nothing"
    return file_error(
        source,
        f"does not say where the solar power is; give it, for instance --column "
        f"'solar_power_w={example}'; read: {names}",
    )
