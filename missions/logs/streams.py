"""Logs of autopilots: streams of messages at different times, joined into one table."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missions.files.errors import InputError, Problem, printable, refused
from missions.logs.columns import ColumnMap, Recipe, Source, recipes_for
from missions.logs.table import REQUIRED, FlightLog, log_from_table, sampled
from missions.logs.units import EPOCH
from solar.types import BoolArray, FloatArray

_FIX_3D = 3
_STREAM = re.compile(r"([A-Za-z0-9_]+)(?:\[\d+\])?\.")


class Stream(NamedTuple):
    """Messages over time since boot [s]; ``kind``: their name in the format, topic or message."""

    name: str
    time_s: FloatArray
    fields: Mapping[str, NDArray[Any]]
    kind: str = "message"

    def field(self, *names: str) -> FloatArray:
        """Return the first of the named fields that exists."""
        for name in names:
            if name in self.fields:
                return np.asarray(self.fields[name], float)
        message = f"{printable(self.name)} has no field {' or '.join(names)}"
        raise refused(f"{self.kind} {message}")

    def has_fix(self, status: str) -> BoolArray:
        """Flag messages with a 3D position; all of them where no field says so."""
        if status not in self.fields:
            return np.ones(len(self.time_s), bool)
        return np.asarray(self.fields[status] >= _FIX_3D)

    def boot_s(self, known: BoolArray, universal_s: FloatArray) -> float:
        """Return the universal time of the boot [s since 1970] by the satellites."""
        if not known.any():
            name = printable(self.name)
            raise refused(f"{self.kind} {name} never knows the universal time")
        return float(np.median((universal_s - self.time_s)[known]))

    def series(self, values: Mapping[str, NDArray[Any]]) -> dict[str, pd.Series]:
        """Return quantities at the times of the messages."""
        return {name: pd.Series(np.asarray(v, float), self.time_s) for name, v in values.items()}

    def rising(self) -> Stream:
        """Return the stream without messages whose times do not rise, as in damaged logs."""
        keep = np.isfinite(self.time_s)
        highest = np.maximum.accumulate(np.where(keep, self.time_s, -np.inf))
        keep &= np.concatenate(([True], self.time_s[1:] > highest[:-1]))
        fields = {name: values[keep] for name, values in self.fields.items()}
        return self._replace(time_s=self.time_s[keep], fields=fields)


def kinds_named(layout: ColumnMap) -> set[str]:
    """Return the kinds of messages that a layout names."""
    texts = [s.name or "" if isinstance(s, Source) else s for s in layout.columns.values()]
    return {match[1] for text in texts for match in _STREAM.finditer(text)}


class Streams:
    """Streams of a log by name, and quantities that a layout makes of ``STREAM.FIELD``."""

    def __init__(self, streams: Mapping[str, Stream], layout: ColumnMap, source: str) -> None:
        self.streams, self.layout, self.source = streams, layout, source
        header = [f"{name}.{field}" for name, stream in streams.items() for field in stream.fields]
        recipes = recipes_for(header, layout, guess=False)
        if recipes.problems:
            raise InputError(Problem("", None, None, "", text) for text in recipes.problems)
        self.mapped: dict[str, pd.Series] = {}
        for name, recipe in recipes.by_quantity.items():
            self.mapped |= {} if name == "time" else self._make_series(recipe)

    def _make_series(self, recipe: Recipe) -> dict[str, pd.Series]:
        """Make a quantity at the times of its first stream, with the power of each MPPT."""
        if recipe.value is not None:
            return {recipe.quantity: pd.Series([recipe.value], [np.nan])}
        first = self.streams[recipe.columns[0].rpartition(".")[0]].time_s

        def column(name: str) -> FloatArray:
            stream, _, field = name.rpartition(".")
            values = self.streams[stream].series({name: self.streams[stream].fields[field]})
            return sampled(values[name], first)

        return {name: pd.Series(values, first) for name, values in recipe.values(column).items()}

    def needed(self, names: Sequence[str], lack: str) -> Stream:
        """Return the first of the named streams that exists."""
        for name in names:
            if name in self.streams:
                return self.streams[name]
        raise refused(lack)

    def no_power(self, example: str) -> InputError:
        """Return the error of a log that does not say which message has the solar power."""
        names = ", ".join(printable(name) for name in list(self.streams)[:12]) or "nothing"
        return refused(
            f"does not say where the solar power is; give it, for instance --column "
            f"'solar_power_w={example}'; read: {names}"
        )

    def log(
        self, made: Mapping[str, pd.Series], boot_s: float, notes: list[str], battery: str
    ) -> FlightLog:
        """Join quantities at the times of the solar power; the layout's precede ``made``."""
        ignored = self.layout.ignore
        if needed := set(REQUIRED) & set(ignored):
            raise refused(f"{min(needed)} cannot be ignored: it is needed")
        if "load_w" in made and "load_w" not in self.mapped:
            notes.append(f"load_w is voltage times current of {battery}")
        every = {name: s for name, s in {**made, **self.mapped}.items() if name not in ignored}
        time_s = every["solar_power_w"].index.to_numpy(float)
        columns = {name: sampled(series, time_s, name) for name, series in every.items()}
        table = pd.DataFrame({EPOCH: time_s + boot_s, **columns})
        return log_from_table(table, self.source, notes, self.layout.exclude)
