"""Station keeping by month, over latitude or altitude, as text, table, record and figure."""

from __future__ import annotations

from collections.abc import Callable
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
from sizing.results.result import Result, data_frame
from sizing.station import FASTEST, required_winds, station_keeping
from sizing.validity.checks import design_checks
from sizing.validity.extrapolations import collect_extrapolations, merge_extrapolations
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
from solar.schema import spell
from solar.types import FloatArray
from studies.engine.run import Progress, Study
from studies.output import gridded
from studies.output.cells import cell_edges, draw_cells, draw_colour_bar
from studies.output.figures.drawing import Canvas, new_figure, styled
from studies.output.figures.options import DEFAULT
from studies.quantities import described, text_of
from studies.render.tables import Column, Line, Table
from studies.render.words import extrapolation_blocks, percent

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

LATITUDES_DEG = np.arange(-70.0, 71.0, 5.0)
_MIDDLE = 15  # day of a month that stands for it
_CELL_S = 1e-2  # roughly
_DESCRIBED = described("share airspeed wind at_end")
_CHOSEN = described("chosen_altitude")
_NAMES = {
    "share": "share_on_station",
    "airspeed": "airspeed_m_per_s",
    "wind": "wind_m_per_s",
    "chosen_altitude": "altitude_m",
}
_ROWS = {1: 14, 2: 1000}  # of the tables, by level


@dataclass(frozen=True, repr=False)
class Station(Result):
    """Share of the time in which an aircraft holds its place, by row and month.

    ``over``: quantity of the rows, ``latitude`` [deg] or ``altitude`` [m]. ``cells``: arrays of
    shape ``(row, month)``; airspeed NaN where no day is perpetual; ``chosen_altitude``: altitude
    of the largest share, if chosen by latitude and month.
    """

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    over: Literal["latitude", "altitude"]
    source: str
    at_end: bool
    cells: gridded.Gridded

    @property
    def rows(self) -> FloatArray:
        """Latitudes [deg] or altitudes [m]."""
        return self.cells[self.over].values

    @property
    def months(self) -> list[int]:
        """Months of the columns."""
        return list(map(int, self.cells["month"].values))

    @property
    def share(self) -> FloatArray:
        """Share of the time on station."""
        return self.cells["share"].values

    @property
    def airspeed_m_per_s(self) -> FloatArray:
        """Fastest airspeed of perpetual flight [m/s], NaN where no day is perpetual."""
        return self.cells["airspeed"].values

    def table(self, level: int = 2) -> Table:
        """Return the share of the time [%] by row and month; empty where no day is perpetual."""
        title = "share of the time on station [%]"
        return self._by_month(title, 100.0 * self.share, ".0f", level)

    def _by_month(self, title: str, values: FloatArray, form: str, level: int) -> Table:
        """Return a table of values by row and month; empty where no day is perpetual."""
        first = Column(self.over, to_right=True)
        months = tuple(Column(MONTH_NAMES[m - 1], form=form) for m in self.months)
        shown = np.where(np.isfinite(self.airspeed_m_per_s), values, np.nan)
        most = _ROWS[level] // (2 if "chosen_altitude" in self.cells and level == 1 else 1)
        places = gridded.shown_places(self.rows.tolist(), most)
        rows = [(self._label(i), *shown[i].tolist()) for i in places][::-1]
        part = f"{len(rows)} of {len(self.rows)} rows; -v has the rest"
        notes = (part,) if len(rows) < len(self.rows) else ()
        return Table(title, (first, *months), tuple(rows), notes)

    def _label(self, row: int) -> str:
        value = float(self.rows[row])
        return latitude_label(value) if self.over == "latitude" else text_of("altitude_m", value)

    @property
    def places(self) -> dict[str, Any]:
        """Latitudes [deg] or altitudes [m], and months."""
        name = "latitudes_deg" if self.over == "latitude" else "altitudes_m"
        return {name: self.rows, "months": self.months}

    @property
    def columns(self) -> dict[str, FloatArray]:
        """Values of all cells by their names in records and tables."""
        return {name: self.cells[key].values for key, name in _NAMES.items() if key in self.cells}

    @property
    def extrapolations(self) -> tuple[Extrapolation, ...]:
        """Extrapolated quantities of the design."""
        return gridded.extrapolations_of(self.cells)

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each latitude or altitude and month."""
        rows, months = np.meshgrid(self.rows, self.months, indexing="ij")
        unit = "deg" if self.over == "latitude" else "m"
        columns = {f"{self.over}_{unit}": rows, "month": months, **self.columns}
        return data_frame({name: values.ravel() for name, values in columns.items()})


def headline(station: Station) -> str:
    """Return the best month and place in one line."""
    best = np.unravel_index(int(np.argmax(station.share)), station.share.shape)
    name = f"{station.aircraft.name} on {station.mission.name}"
    if not station.share.any():
        return f"{name}: no perpetual flight, so that it holds no place"
    return (
        f"{name}: holds its place for up to {percent(station.share[best], '.0f')} of the time "
        f"({station._label(int(best[0]))}, {MONTH_NAMES[station.months[best[1]] - 1]})"
    )


def blocks(station: Station, level: int) -> list[Any]:
    """Return headline, tables (of round latitudes in a summary), and notes."""
    notes = [Line(f"{station.solar.label}; winds from {station.source}", "faint")]
    if not np.all(np.isfinite(station.airspeed_m_per_s)):
        notes.insert(0, Line("-: no perpetual flight", "faint"))
    if station.at_end:
        text = f"airspeeds end at {spell(FASTEST)} times that of the design: it may stay longer"
        notes.insert(0, Line(text, "faint"))
    outside = extrapolation_blocks(station.extrapolations, level)
    tables = [station.table(level)]
    if "chosen_altitude" in station.cells:
        altitude_km = station.cells["chosen_altitude"].values / 1000.0
        tables.append(station._by_month("altitude of that share [km]", altitude_km, ".1f", level))
    return [Line(headline(station), "strong"), *tables, *outside, *notes]


def station(
    aircraft: Aircraft,
    mission: Mission,
    *,
    latitudes: ArrayLike | None = None,
    altitudes_m: ArrayLike | None = None,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    workers: int | None = 1,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> Station:
    """Compute the share of the time on station by latitude or altitude and month.

    With both, each latitude and month gets the altitude with the largest share.
    """
    solar = SolarModel(model, correction)
    study, result = prepare(aircraft, mission, latitudes, altitudes_m, solar)
    return result(study.computed(workers, scheduler, progress))


def prepare(
    aircraft: Aircraft,
    mission: Mission,
    latitudes: ArrayLike | None,
    altitudes_m: ArrayLike | None,
    solar: SolarModel,
) -> tuple[Study, Callable[[gridded.Gridded], Station]]:
    """Check a study over altitude, latitude and month; return it, and what makes its result."""
    winds = required_winds(aircraft, mission).table(mission.longitude_deg)
    by_altitude = altitudes_m is not None
    by_latitude = latitudes is not None or not by_altitude
    if latitudes is None:
        latitudes = LATITUDES_DEG if by_latitude else mission.latitudes()[:1]
    heights = np.atleast_1d(np.asarray(altitudes_m if by_altitude else mission.altitude_m, float))
    axes = {"altitude": heights, "latitude": np.asarray(latitudes, float)}
    axes["month"] = np.array(winds.months)
    cells = np.stack(np.meshgrid(*axes.values(), indexing="ij"), -1).reshape(-1, 3)
    outside = []
    for height in heights.tolist():
        there = mission.at_altitude(height)
        # Refuses cells outside the table of winds.
        there.scenario_winds_m_per_s(_scenarios(cells[cells[:, 0] == height]))
        calm = there.in_wind(0.0)  # the share says what the wind does
        checks = design_checks(aircraft, calm, design_of(aircraft, calm), solar)
        outside.append(collect_extrapolations(checks))
    extrapolated = outside[0] if len(outside) == 1 else merge_extrapolations(outside, "altitudes")
    about = {
        "altitude": {"units": "m", "standard_name": "altitude"},
        "latitude": {"units": "degrees_north", "standard_name": "latitude"},
        "month": {"units": "1", "long_name": "month"},
    }
    kept = {"altitude": by_altitude, "latitude": by_latitude, "month": True}
    study = Study(
        _station_cells,
        (aircraft, mission, solar),
        cells,
        cell_s=_CELL_S,
        described=_DESCRIBED,
        statuses=(),
        coordinates={
            name: gridded.Labelled((name,), axes[name], about[name])
            for name, is_kept in kept.items()
            if is_kept
        },
        attributes=gridded.attributes(
            f"Station keeping of {aircraft.name}", aircraft, mission, solar
        ),
        extrapolated=lambda columns: extrapolated,
    )

    def result(data: gridded.Gridded) -> Station:
        """Return the shares; over altitudes and latitudes the largest of all altitudes."""
        variables, coordinates = dict(data.variables), dict(data.coordinates)
        if by_altitude and by_latitude:
            dims = ("latitude", "month")
            best = np.nan_to_num(variables["share"].values, nan=-1.0).argmax(axis=0)
            for name, (_, values, attrs) in variables.items():
                flown = np.take_along_axis(values, best[None], axis=0)[0]
                variables[name] = gridded.Labelled(dims, flown, attrs)
            chosen = dict.fromkeys(_CHOSEN, coordinates.pop("altitude").values[best])
            variables |= gridded.variables(dims, chosen, _CHOSEN, ())
        return Station(
            aircraft,
            mission,
            solar,
            over="latitude" if by_latitude else "altitude",
            source=winds.source,
            at_end=bool(np.any(variables.pop("at_end").values == 1.0)),
            cells=gridded.Gridded(variables, coordinates, data.attrs),
        )

    return study, result


def _scenarios(cells: FloatArray) -> Scenarios:
    """Return the middle of each cell's month, at its latitude."""
    days = [day_of_year(f"{int(month):02d}-{_MIDDLE}") for month in cells[:, 2]]
    return Scenarios(cells[:, 1], np.array(days))


def _station_cells(
    flown: tuple[Aircraft, Mission, SolarModel], cells: FloatArray
) -> dict[str, FloatArray]:
    """Compute columns of cells of altitude [m], latitude [deg] and month."""
    aircraft, mission, solar = flown
    columns = {name: np.empty(len(cells)) for name in _DESCRIBED}
    for height in np.unique(cells[:, 0]).tolist():
        where, there = cells[:, 0] == height, mission.at_altitude(height)
        flights = station_keeping(aircraft, there, solar, scenarios=_scenarios(cells[where]))
        columns["share"][where], columns["at_end"][where] = flights.share, flights.at_end
        columns["airspeed"][where] = flights.airspeed_m_per_s
        columns["wind"][where] = flights.wind_m_per_s
    return columns


@styled
def plot_station(result: Station, *, figure: Canvas = DEFAULT) -> Figure:
    """Draw the share of the time on station over the months, blank where no day is perpetual."""
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
    draw_colour_bar(mesh, axes, "share of the time on station [%]", percent)
    axes.set_xticks(months, [MONTH_NAMES[month - 1] for month in result.months])
    edges = cell_edges(rows)
    axes.set_ylim(float(edges[0]), float(edges[-1]))
    if result.over == "latitude":
        axes.set(ylabel="latitude")
        axes.yaxis.set_major_formatter(lambda value, _: latitude_label(value))
    else:
        axes.set(ylabel="altitude [km]")
    return drawn
