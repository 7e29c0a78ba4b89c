"""Map by latitude: days with a flight or a design, and the range of their numbers."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from missions.dates import date_label
from missions.mission.scenarios import latitude_label
from missions.weather.record import runs_of
from sizing.day.metrics import Status
from sizing.program.objectives import Objective, SizingStatus
from sizing.results.result import Result
from solar.types import BoolArray, IntArray
from studies import quantities as q
from studies.output import gridded
from studies.render.tables import Column, Line
from studies.render.words import extrapolation_blocks
from studies.serialise import serialise

_ROWS = {1: 15, 2: 1000}  # latitudes of the table, by level
_DAYS = 365
_RUNS = 2  # seasons of a latitude


@dataclass(frozen=True, repr=False)
class MapResult(Result):
    """Map of a fixed aircraft or of sized designs, with a row for each latitude."""

    data: gridded.OnGrid

    @property
    def objective(self) -> str:
        """Objective of each cell's sizing; empty for a fixed aircraft."""
        return str(self.data.attrs.get("objective", ""))

    def to_dict(self) -> dict[str, Any]:
        """Return the days by outcome and ranges of numbers, lists over the latitudes."""
        ends = SizingStatus if self.objective else (Status.failed,)
        numbers: dict[str, Any] = {f"{end.name}_days": self._days_of(end) for end in ends}
        if self.objective:
            windy = self.data["violated_requirement"].to_numpy() == gridded.TOO_WINDY
            numbers = {"objective": self.objective} | numbers
            numbers |= {"too_windy_days": windy.sum(axis=1)} if windy.any() else {}
        else:
            numbers = {"perpetual_days": gridded.feasible(self.data).sum(axis=1)} | numbers
            # Models that need a path in winds have cells too windy for the path.
            if Status.infeasible in gridded.status_names(self.data):
                numbers["too_windy_days"] = self._days_of(Status.infeasible)
        for quantity in self._ranged:
            least, largest = self._least_and_largest(quantity)
            numbers |= {f"least_{quantity.name}": least, f"largest_{quantity.name}": largest}
        record: dict[str, Any] = serialise(
            {"latitude_deg": self._latitudes, "days": self.data["day"].to_numpy()}
            | numbers
            | {"extrapolations": gridded.extrapolations_of(self.data)}
        )
        return record

    # ---- Fixed aircraft

    @property
    def _goal(self) -> str:
        """Flight that a cell is to have, in words."""
        landed = np.any(self.data["status"].to_numpy() == Status.lands)
        return "flights that land" if landed else "perpetual flight"

    def _seasons(self, record: dict[str, Any]) -> tuple[Sequence[Column], dict[str, list[Any]]]:
        """Return the season of each latitude, and the largest excess time: columns, their cells."""
        days = self.data["day"].to_numpy()
        excess = replace(q.EXCESS_TIME, label="largest excess time")
        # The number of perpetual days means little unless all days are mapped.
        counted = [Column("perpetual_days", "days")] if len(days) == _DAYS else []
        others = (
            replace(quantity, label="endurance on the other days", to_right=True)
            for quantity in self._ranged
        )
        return [Column("season", self._goal), *counted, excess, *others], {
            "season": [season_text(days, perpetual) for perpetual in gridded.feasible(self.data)],
            excess.name: self._least_and_largest(excess)[1].tolist(),
            "perpetual_days": record["perpetual_days"],
            **{quantity.name: self._range_texts(quantity) for quantity in self._ranged},
        }

    # ---- Sized designs

    def _designs(self, record: dict[str, Any]) -> tuple[Sequence[Column], dict[str, list[Any]]]:
        """Return the days with a design, and the range of its size."""
        groups = {
            f"designs on {len(record['days'])} days": gridded.SIZED,
            "none": (SizingStatus.infeasible, SizingStatus.invalid),
            "unknown": (SizingStatus.not_converged,),
        }
        days = {
            head: np.sum([record[f"{kind.name}_days"] for kind in kinds], axis=0).tolist()
            for head, kinds in groups.items()
        }
        shown = list(self._ranged)
        if "excess" not in self.objective:
            shown.remove(q.EXCESS_TIME)
        texts = {quantity.name: self._range_texts(quantity) for quantity in shown}
        short = {q.TOTAL_MASS: "mass"}
        heads = (replace(c, label=short.get(c, c.label), to_right=False) for c in shown)
        return [*map(Column, days), *heads], days | texts

    # ---- Both

    @property
    def _latitudes(self) -> NDArray[Any]:
        return self.data["latitude"].to_numpy()

    @property
    def _ranged(self) -> tuple[q.Quantity, ...]:
        """Quantities reported by their range over the days of a latitude."""
        if not self.objective:
            return (q.ENDURANCE,) if q.ENDURANCE.variable in self.data else ()
        largest = Objective(self.objective).column
        payload = (p for p in (q.PAYLOAD_MASS, q.PAYLOAD_POWER) if p.variable == largest)
        return (q.WINGSPAN, q.TOTAL_MASS, q.EXCESS_TIME, *payload)

    def _least_and_largest(self, quantity: q.Quantity) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return least and largest value of each latitude; NaN without any."""
        values = self.data[quantity.variable].to_numpy()
        if quantity is q.ENDURANCE:  # on days with limited flight
            values = np.where(np.isposinf(values), np.nan, values)
        # No warning for a latitude without a value, as nanmin has one.
        return np.fmin.reduce(values, axis=1), np.fmax.reduce(values, axis=1)

    def _range_texts(self, quantity: q.Quantity) -> list[str]:
        """Return the range of each latitude in words."""
        form, ends = replace(quantity, form=".2f"), self._least_and_largest(quantity)
        return [
            " to ".join(dict.fromkeys(map(form.text, (low, high))))
            if np.isfinite(low)
            else form.text(low)
            for low, high in zip(*map(np.ndarray.tolist, ends), strict=True)
        ]

    def _days_of(self, status: int) -> IntArray:
        """Count the days of each latitude with a status."""
        return np.asarray(np.sum(self.data["status"].to_numpy() == status, axis=1))


def headline(result: MapResult) -> str:
    """Return aircraft, mission and the mapped quantity."""
    names = (json.loads(result.data.attrs[key])["name"] for key in ("aircraft", "mission"))
    what = (
        f"best designs for {result.objective}" if result.objective else f"seasons of {result._goal}"
    )
    return f"{' on '.join(names)}: {what}"


def blocks(result: MapResult, level: int) -> list[Any]:
    """Return headline, table (round latitudes in a summary), and conditions."""
    data, days = result.data, result.data["day"].to_numpy()
    record, latitudes = result.to_dict(), result._latitudes
    columns, cells = (result._designs if result.objective else result._seasons)(record)
    without = {"failed_days": "failed", "too_windy_days": "too windy for the path"}
    lacking = {key: head for key, head in without.items() if any(record.get(key, ()))}
    places = gridded.shown_places(latitudes.tolist(), _ROWS[level])
    table = q.table_of(
        "",
        (q.TABLE["latitude"], *columns, *(Column(*item) for item in lacking.items())),
        (
            {"latitude": latitude_label(latitudes[i])}
            | {key: column[i] for key, column in cells.items()}
            | {key: record[key][i] for key in lacking}
            for i in places
        ),
    )
    notes = [
        f"{gridded.flown_caption(data)}; {len(days)} days of the year, {days[0]} to {days[-1]}"
    ]
    if len(places) < len(latitudes):
        shown = f"{len(places)} of {len(latitudes)} latitudes shown"
        notes.insert(0, f"{shown}; all with -v and in --out FILE")
    outside = extrapolation_blocks(gridded.extrapolations_of(data), level)
    if not result.objective and any(hours < 0.0 for hours in cells[q.EXCESS_TIME.name]):
        outside.append(q.BELOW_ZERO)
    return [Line(headline(result), "strong"), table, *notes, *outside]


def season_text(days: IntArray, perpetual: BoolArray) -> str:
    """Return first and last mapped day with perpetual flight; a full year is a circle."""
    if perpetual.all() or not perpetual.any():
        return "on all mapped days" if perpetual.all() else "none"
    starts, stops = runs_of(perpetual).T
    ends = [[int(days[a]), int(days[b - 1])] for a, b in zip(starts, stops, strict=True)]
    gaps = np.diff(days, append=days[0] + 365)
    if len(ends) > 1 and perpetual[0] and perpetual[-1] and gaps[-1] <= gaps[:-1].max():
        ends[0][0] = ends.pop()[0]
    spans = [
        date_label(first) if first == last else f"{date_label(first)} to {date_label(last)}"
        for first, last in ends
    ]
    return ", ".join(spans[:_RUNS]) + (", ..." if len(spans) > _RUNS else "")
