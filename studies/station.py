"""Station keeping by month, over latitude or altitude, as text, table, record and figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from matplotlib.colors import Normalize
from numpy.typing import ArrayLike

from missions.dates import MONTH_NAMES, day_of_year
from missions.mission import Mission, Scenarios
from missions.mission.scenarios import latitude_label
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.mass_budget import design_of
from sizing.results.notes import extrapolation_blocks, extrapolation_records
from sizing.results.records import finite
from sizing.results.tables import Column, Line, Result, Summary, Table, data_frame
from sizing.station import FASTEST, station_keeping
from sizing.validity.checks import design_checks
from sizing.validity.extrapolations import together, told
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
from solar.types import FloatArray
from studies.output.cells import cell_edges, draw_cells, draw_colour_bar
from studies.output.figures.drawing import Canvas, new_figure, styled
from studies.output.figures.options import DEFAULT
from studies.output.gridded import Gridded, Labelled, attributes, extrapolation_attribute

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

LATITUDES_DEG = np.arange(-70.0, 71.0, 5.0)
_MIDDLE = 15  # day of a month that stands for it
_DESCRIBED = {
    "share": ("1", "share of the time in which it holds its place"),
    "airspeed": ("m s-1", "fastest airspeed of perpetual flight"),
    "wind": ("m s-1", "wind speed, at the mission's percentile"),
}


@dataclass(frozen=True, repr=False)
class Station(Result):
    """Share of the time in which an aircraft holds its place, by row and month.

    ``over``: what the rows are, ``latitude`` [deg] or ``altitude`` [m]. Arrays have the shape
    ``(row, month)``; ``airspeed_m_per_s`` is NaN where no day is perpetual. ``altitude_m``: that of
    the largest share, where it is chosen by latitude and month.
    """

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    over: Literal["latitude", "altitude"]
    rows: FloatArray
    months: tuple[int, ...]
    share: FloatArray
    airspeed_m_per_s: FloatArray
    wind_m_per_s: FloatArray
    source: str
    at_end: bool
    altitude_m: FloatArray | None = None
    extrapolations: tuple[Extrapolation, ...] = ()

    def headline(self) -> str:
        """Best month and place in one line."""
        best = np.unravel_index(int(np.argmax(self.share)), self.share.shape)
        name = f"{self.aircraft.name} on {self.mission.name}"
        if not self.share.any():
            return f"{name}: no perpetual flight, so that it holds no place"
        return (
            f"{name}: holds its place for up to {100.0 * self.share[best]:.0f} % of the time "
            f"({self._label(int(best[0]))}, {MONTH_NAMES[self.months[best[1]] - 1]})"
        )

    def summary(self) -> Summary:
        """Headline and table."""
        notes = [Line(f"{self.solar.label}; winds from {self.source}", "faint")]
        if not np.all(np.isfinite(self.airspeed_m_per_s)):
            notes.insert(0, Line("-: no perpetual flight", "faint"))
        if self.at_end:
            text = f"airspeeds end at {FASTEST:g} times that of the design: it may stay longer"
            notes.insert(0, Line(text, "faint"))
        outside = extrapolation_blocks(self.extrapolations)
        tables = [self.table()]
        if self.altitude_m is not None:
            title, altitude_km = "altitude of that share [km]", self.altitude_m / 1000.0
            tables.append(self._by_month(title, altitude_km, ".1f"))
        return Summary((Line(self.headline(), "strong"), *tables, *outside, *notes))

    def table(self) -> Table:
        """Share of the time [%] by row and month; empty where no day is perpetual."""
        return self._by_month("share of the time on station [%]", 100.0 * self.share, ".0f")

    def _by_month(self, title: str, values: FloatArray, form: str) -> Table:
        """Values by row and month; empty where no day is perpetual."""
        first = Column(self.over, to_right=True)
        months = tuple(Column(MONTH_NAMES[m - 1], form=form) for m in self.months)
        shown = np.where(np.isfinite(self.airspeed_m_per_s), values, np.nan)
        rows = [(self._label(i), *shown[i].tolist()) for i in range(len(self.rows))][::-1]
        return Table(title, (first, *months), tuple(rows))

    def _label(self, row: int) -> str:
        value = float(self.rows[row])
        return latitude_label(value) if self.over == "latitude" else f"{value:.0f} m"

    def to_dict(self) -> dict[str, Any]:
        """Everything, JSON-ready; null for no airspeed."""
        name = "latitudes_deg" if self.over == "latitude" else "altitudes_m"
        speeds = [[finite(one) for one in row] for row in self.airspeed_m_per_s.tolist()]
        return {
            "aircraft": self.aircraft.name,
            "mission": self.mission.name,
            "model": self.solar.model,
            "correction": self.solar.correction,
            "winds": self.source,
            name: self.rows.tolist(),
            "months": list(self.months),
            "share_on_station": self.share.tolist(),
            "airspeed_m_per_s": speeds,
            "wind_m_per_s": self.wind_m_per_s.tolist(),
            **({} if self.altitude_m is None else {"altitude_m": self.altitude_m.tolist()}),
            "at_fastest_airspeed": self.at_end,
            "extrapolations": extrapolation_records(self.extrapolations),
        }

    def to_frame(self) -> pd.DataFrame:
        """One row for each latitude or altitude and month."""
        rows, months = np.meshgrid(self.rows, self.months, indexing="ij")
        unit = "deg" if self.over == "latitude" else "m"
        return data_frame(
            {
                f"{self.over}_{unit}": rows.ravel(),
                "month": months.ravel(),
                "share_on_station": self.share.ravel(),
                "airspeed_m_per_s": self.airspeed_m_per_s.ravel(),
                "wind_m_per_s": self.wind_m_per_s.ravel(),
            }
            | ({} if self.altitude_m is None else {"altitude_m": self.altitude_m.ravel()})
        )

    def gridded(self) -> Gridded:
        """The same on a grid, for NetCDF files."""
        dims = (self.over, "month")
        values = [self.share, self.airspeed_m_per_s, self.wind_m_per_s]
        described = dict(_DESCRIBED)
        if self.altitude_m is not None:
            values.append(self.altitude_m)
            described["chosen_altitude"] = ("m", "altitude of the largest share")
        units = "degrees_north" if self.over == "latitude" else "m"
        about = {"units": units, "standard_name": self.over}
        month = {"units": "1", "long_name": "month"}
        return Gridded(
            {
                name: Labelled(dims, array, {"units": unit, "long_name": text})
                for (name, (unit, text)), array in zip(described.items(), values, strict=True)
            },
            {
                self.over: Labelled((self.over,), self.rows, about),
                "month": Labelled(("month",), np.array(self.months), month),
            },
            attributes(
                f"Station keeping of {self.aircraft.name}", self.aircraft, self.mission, self.solar
            )
            | extrapolation_attribute(self.extrapolations),
        )


def station(
    aircraft: Aircraft,
    mission: Mission,
    *,
    latitudes: ArrayLike | None = None,
    altitudes_m: ArrayLike | None = None,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
) -> Station:
    """Share of the time in which an aircraft holds its place, by latitude or altitude and month.

    With both, each latitude and month is flown at that altitude which has the largest share.
    """
    solar = SolarModel(model, correction)
    given = mission.wind_statistics
    table = None if given is None else given.table(mission.longitude_deg)
    months = tuple(range(1, 13)) if table is None else table.months
    days = np.array([day_of_year(f"{month:02d}-{_MIDDLE}") for month in months])

    by_altitude = altitudes_m is not None and latitudes is None
    if by_altitude:
        north = np.array(mission.latitudes()[:1])
    else:
        north = np.asarray(LATITUDES_DEG if latitudes is None else latitudes, float)
    heights = np.asarray([mission.altitude_m] if altitudes_m is None else altitudes_m, float)
    places = [mission if altitudes_m is None else mission.at_altitude(h) for h in heights.tolist()]
    cells = Scenarios(np.repeat(north, len(days)), np.tile(days, len(north)))
    found = [station_keeping(aircraft, there, solar, scenarios=cells) for there in places]

    def stacked(name: str) -> FloatArray:
        """Values of shape ``(altitude, latitude, month)``."""
        return np.stack([getattr(one, name) for one in found]).reshape(-1, len(north), len(days))

    share = stacked("share")
    best = share.argmax(axis=0)[np.newaxis]

    def shown(values: FloatArray) -> FloatArray:
        """Values by row and month: every altitude's, or those of the largest share."""
        return values[:, 0] if by_altitude else np.take_along_axis(values, best, axis=0)[0]

    return Station(
        *(aircraft, mission, solar),
        over="altitude" if by_altitude else "latitude",
        rows=heights if by_altitude else north,
        months=months,
        share=shown(share),
        airspeed_m_per_s=shown(stacked("airspeed_m_per_s")),
        wind_m_per_s=shown(stacked("wind_m_per_s")),
        source="" if table is None else table.source,
        at_end=bool(np.any(shown(stacked("at_end")))),
        altitude_m=heights[best[0]] if altitudes_m is not None and not by_altitude else None,
        extrapolations=_extrapolations(aircraft, places, solar),
    )


def _extrapolations(
    aircraft: Aircraft, places: Sequence[Mission], solar: SolarModel
) -> tuple[Extrapolation, ...]:
    """What the design takes from outside the range of a model, at all altitudes."""
    calm = [one.in_wind(0.0) for one in places]  # the share says what the wind does
    each = [told(design_checks(aircraft, one, design_of(aircraft, one), solar)) for one in calm]
    return each[0] if len(each) == 1 else together(each, "altitudes")


@styled
def plot_station(result: Station, *, figure: Canvas = DEFAULT) -> Figure:
    """Share of the time on station over the months, blank where no day is perpetual."""
    drawn, (axes,) = new_figure(
        canvas=figure,
        title=f"{result.aircraft.name} on {result.mission.name}: time on station",
        notes=(f"{result.solar.label}; winds from {result.source}; blank: no perpetual flight",),
        size_in=(8.5, 5.2),
        grid="",
    )
    rows = result.rows if result.over == "latitude" else result.rows / 1000.0
    months = np.asarray(result.months, float)
    percent = np.where(np.isfinite(result.airspeed_m_per_s), 100.0 * result.share, np.nan)
    mesh = draw_cells(axes, months, rows, percent, Normalize(0.0, 100.0))
    draw_colour_bar(drawn, mesh, axes, "share of the time on station [%]", unlimited=False)
    axes.set_xticks(months, [MONTH_NAMES[month - 1] for month in result.months])
    edges = cell_edges(rows)
    axes.set_ylim(float(edges[0]), float(edges[-1]))
    if result.over == "latitude":
        axes.set(ylabel="latitude")
        axes.yaxis.set_major_formatter(lambda value, _: latitude_label(value))
    else:
        axes.set(ylabel="altitude [km]")
    return drawn
