"""Impossible values of a log: left out with a note before anything is computed.

What a quantity can be, and whether it may rest, is declared once in ``units``.
"""

from __future__ import annotations

import datetime
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd

from missions.logs.clock import Span
from missions.logs.units import QUANTITIES, quantity_of
from missions.units import UNITS
from solar.schema import spell
from solar.types import BoolArray, FloatArray

Kind = Literal[
    "no_number", "outside", "code", "spike", "frozen", "saturated", "repeated", "excluded"
]
_WORDS: Mapping[Kind, str] = {
    "no_number": "cannot be read",
    "outside": "cannot be",
    "code": "stands for no value",
    "spike": "single values above three times the highest power",
    "frozen": "frozen at one value",
    "saturated": "held at the highest value",
    "repeated": "copies of earlier rows",
    "excluded": "excluded",
}
# What loggers write for no value: nines, and the ends of integers; MAVLink has -1 % of charge.
_CODES = (999.0, 9999.0, 99999.0, 999999.0, 32767.0, 65535.0, 2147483647.0, 4294967295.0)
_SIGNED_CODES = (*_CODES, *(-c for c in _CODES), -32768.0, -2147483648.0)
# A code is beyond the other values by more than this share of their range.
_APART = 0.5
# Light on modules is never three times a clear sky's: Gueymard (2017), Solar Energy 153, 755-765,
# measured 1.9 kW/m2 below broken clouds. Most of five neighbours are no spikes.
_SPIKE, _NEIGHBOURS = 3.0, 5
# A frozen channel repeats a value for so long [s] and so many samples, but nowhere else for a fifth
# of that; its usual step is at least three of its finest differences, unlike a coarse channel's. A
# value held for more than half of the log is a constant.
_FROZEN_S, _LEAST_FROZEN, _RATIO, _STEPS, _MOST_HELD = 60.0, 10, 5, 3.0, 0.5
_USUAL = 0.2  # quantile of the steps
_DARK = 0.02  # share of the highest power below which there is none to speak of
_GAP_STEPS = 5.0
_LEAST_REPEATED, _LEAST_DISTINCT = 10, 5  # rows, and values of the power in them


class LeftOut(NamedTuple):
    """Values or rows left out of a log, the reason, and the ends of each stretch [s since 1970]."""

    column: str
    kind: Kind
    values: int
    example: str
    periods: tuple[tuple[float, float], ...]

    @property
    def ends(self) -> tuple[float, float]:
        """First and last time [s since 1970], NaN where unknown."""
        return (self.periods[0][0], self.periods[-1][1]) if self.periods else (np.nan, np.nan)

    def sentence(self) -> str:
        """Say how many values or rows are left out, why, and when."""
        kind = "value" if self.column else "row"
        count = f"{self.values} {kind}{'' if self.values == 1 else 's'} left out"
        text = f"{self.column}: {count}, {_WORDS[self.kind]}".removeprefix(": ")
        text += f" ({self.example})" if self.example else ""
        return f"{text}, {span_text(*self.ends)} (UTC)" if self.periods else text


def utc_text(time_s: float) -> str:
    """Return universal time, to the second."""
    instant = datetime.datetime.fromtimestamp(round(float(time_s)), datetime.UTC)
    return instant.strftime("%Y-%m-%d %H:%M:%S")


def span_text(start_s: float, end_s: float) -> str:
    """Return a stretch in universal time, the date once if both ends share it."""
    if not np.isfinite(start_s):
        return ""
    start, end = utc_text(start_s), utc_text(end_s)
    if start == end:
        return start
    return f"{start} to {end[11:] if start[:10] == end[:10] else end}"


def left_out(
    column: str, kind: Kind, mask: BoolArray, time_s: FloatArray, example: str = ""
) -> LeftOut:
    """Record the values that a mask selects."""
    known = np.flatnonzero(mask & np.isfinite(time_s))
    order = known[np.argsort(time_s[known], kind="stable")]
    times = time_s[order]
    cuts = np.flatnonzero(np.diff(order) != 1)
    firsts, lasts = np.append(0, cuts + 1), np.append(cuts, len(order) - 1)
    spans = zip(times[firsts].tolist(), times[lasts].tolist(), strict=True) if len(order) else ()
    return LeftOut(column, kind, int(mask.sum()), example, tuple(spans))


def codes(dimension: str, values: FloatArray) -> BoolArray:
    """Flag values that stand for no value, in any unit of the dimension, far from all others."""
    written = (*_SIGNED_CODES, *((-1.0,) if dimension == "share" else ()))
    every = {u.factor * c + u.offset for u in UNITS[dimension].values() for c in written}
    marked = np.isin(values.round(9), np.round(list(every), 9))
    others = values[~marked & np.isfinite(values)]
    if not marked.any() or not len(others):
        return np.zeros(len(values), bool)
    low, high = np.quantile(others, (0.01, 0.99))
    apart = np.maximum(low - values, values - high)
    return np.asarray(marked & (apart > _APART * (high - low)) & (apart > 0.0))


def stretches(
    quantity: str, values: FloatArray, time_s: FloatArray
) -> Iterator[tuple[Kind, BoolArray]]:
    """Yield masks of values that their neighbours rule out: spikes, frozen channels."""
    known = np.flatnonzero(np.isfinite(values))
    solar = quantity == "solar_power_w"

    def among_all(places: BoolArray) -> BoolArray:
        mask = np.zeros(len(values), bool)
        mask[known[places]] = True
        return mask

    if solar:
        size = pd.Series(np.abs(values[known]))
        usual = size.rolling(_NEIGHBOURS, center=True, min_periods=3).median().max()
        spikes = np.asarray((size > _SPIKE * usual) & (usual > 0.0), bool)
        if spikes.any():
            yield "spike", among_all(spikes)
            known = known[~spikes]
    if QUANTITIES[quantity].rests or len(known) < _LEAST_FROZEN:
        return
    for kind, mask in _find_held_runs(values[known], time_s[known], dark=_DARK if solar else 0.0):
        if mask.any() and (solar or kind == "frozen"):
            yield kind, among_all(mask)


def _find_held_runs(
    values: FloatArray, time_s: FloatArray, dark: float
) -> Iterator[tuple[Kind, BoolArray]]:
    """Yield masks of runs that are frozen at a value or saturated at the highest."""
    steps, passed = np.abs(np.diff(values)), np.diff(time_s)
    breaks = (steps > 0.0) | (passed > _GAP_STEPS * np.median(passed))
    number = np.concatenate([[0], np.cumsum(breaks)])
    first = np.flatnonzero(np.concatenate([[True], breaks]))
    last = np.concatenate([first[1:] - 1, [len(values) - 1]])
    length, value = last - first + 1, values[first]
    long = (time_s[last] - time_s[first] >= _FROZEN_S) & (length > _LEAST_FROZEN)
    apart = np.diff(np.unique(values))
    finest = apart[apart > 1e-9 * np.abs(values).max()].min(initial=np.inf)  # beyond rounding
    moved = steps[steps > 0.0]
    if not long.any() or not len(moved) or np.quantile(moved, _USUAL) < _STEPS * finest:
        return
    highest = value == values.max()
    inner = (np.abs(value) > dark * np.abs(values).max()) & (value > values.min()) & ~highest
    usual = int(length[inner & ~long].max(initial=1))
    frozen = inner & long
    if frozen.any() and length[frozen].min() < _RATIO * usual:
        return
    kinds: dict[Kind, BoolArray] = {"frozen": frozen, "saturated": highest & long}
    for kind, runs in kinds.items():
        if runs[number].mean() < _MOST_HELD:
            yield kind, runs[number]


def without_spans(
    rows: pd.DataFrame, exclude: Sequence[Span], zone: datetime.tzinfo | None, left: list[LeftOut]
) -> pd.DataFrame:
    """Drop the rows within excluded times of day."""
    time_s, keep = rows.index.to_numpy(float), np.ones(len(rows), bool)
    for span in exclude:
        inside = span.holds(time_s, zone or datetime.UTC)
        keep &= ~inside
        clock = f"{span.text}, {'UTC' if zone is None else zone}"
        left.append(left_out("", "excluded", inside, time_s, clock))
    return rows[keep].copy()


def leave_out_held(rows: pd.DataFrame, labels: Mapping[str, str]) -> list[LeftOut]:
    """Leave out spikes, frozen channels and rows written twice."""
    left, time_s = [], rows.index.to_numpy(float)
    # Rows of stretches that have all been written before, with power that changes in them.
    content = pd.util.hash_pandas_object(rows.reset_index(drop=True), index=False)
    lag = np.arange(len(content)) - content.groupby(content).transform("idxmin").to_numpy(int)
    number = np.concatenate([[0], np.cumsum(np.diff(lag) != 0)])
    power = rows["solar_power_w"].groupby(number)
    distinct, length = (power.transform(how).to_numpy(int) for how in ("nunique", "size"))
    copies = (lag > 0) & (length >= _LEAST_REPEATED) & (distinct >= _LEAST_DISTINCT)
    if copies.any():
        left.append(left_out("", "repeated", copies, time_s))
        rows.loc[copies] = np.nan
    for name in map(str, rows):
        column = rows[name].to_numpy(float, copy=True)
        for kind, mask in stretches(quantity_of(name), column, time_s):
            example = spell(column[np.argmax(mask)])
            left.append(left_out(labels.get(name, name), kind, mask, time_s, example))
            rows.loc[mask, name] = np.nan
    return left
