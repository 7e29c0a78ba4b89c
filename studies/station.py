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
from sizing.results.result import Result, data_frame
from sizing.station import FASTEST, required_winds, station_keeping
from sizing.validity.checks import design_checks
from sizing.validity.extrapolations import collect_extrapolations, merge_extrapolations
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
from solar.schema import spell
from solar.types import BoolArray, FloatArray
from studies.engine.run import Progress
from studies.output import gridded
from studies.output.cells import cell_edges, draw_cells, draw_colour_bar
from studies.output.figures.drawing import Canvas, new_figure, styled
from studies.output.figures.options import DEFAULT
from studies.quantities import described, text_of
from studies.render.notes import extrapolation_blocks
from studies.render.numbers import percent
from studies.render.tables import Column, Line, Table
from studies.study import Study

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
    study = prepare(aircraft, mission, latitudes, altitudes_m, SolarModel(model, correction))
    return station_of(study, study.computed(workers, scheduler, progress))


@dataclass(frozen=True)
class _Configuration:
    """Inputs common to all cells; ``altitudes_m``: to choose from, for rows of latitude.

    ``chooses``: the altitudes are the user's, not the mission's.
    """

    aircraft: Aircraft
    mission: Mission
    solar: SolarModel
    altitudes_m: tuple[float, ...] | None
    chooses: bool


def prepare(
    aircraft: Aircraft,
    mission: Mission,
    latitudes: ArrayLike | None,
    altitudes_m: ArrayLike | None,
    solar: SolarModel,
) -> Study:
    """Check a study over latitude or altitude and month, and return it."""
    months = np.array(required_winds(aircraft, mission).table(mission.longitude_deg).months)
    heights = np.asarray([mission.altitude_m] if altitudes_m is None else altitudes_m, float)
    over, rows = "latitude", np.asarray(LATITUDES_DEG if latitudes is None else latitudes, float)
    choice: tuple[float, ...] | None = tuple(heights.tolist())
    chooses = altitudes_m is not None
    if altitudes_m is not None and latitudes is None:
        over, rows, choice, chooses = "altitude", heights, None, False
    cells = np.stack(np.meshgrid(rows, months, indexing="ij"), -1).reshape(-1, 2)
    configuration = _Configuration(aircraft, mission, solar, choice, chooses)
    for altitude_m, where in _by_altitude(configuration, cells).items():
        # Refuses cells outside the table of winds.
        there = mission.at_altitude(altitude_m)
        there.scenario_winds_m_per_s(_scenarios(configuration, cells[where]))
    extrapolated = _extrapolations(
        [mission.at_altitude(h) for h in heights.tolist()], configuration
    )
    units = "degrees_north" if over == "latitude" else "m"
    month = {"units": "1", "long_name": "month"}
    return Study(
        _station_cells,
        configuration,
        cells,
        cell_s=_CELL_S * (1 if choice is None else len(choice)),
        described=_DESCRIBED | (_CHOSEN if chooses else {}),
        statuses=(),
        coordinates={
            over: gridded.Labelled((over,), rows, {"units": units, "standard_name": over}),
            "month": gridded.Labelled(("month",), months, month),
        },
        attributes=gridded.attributes(
            f"Station keeping of {aircraft.name}", aircraft, mission, solar
        ),
        extrapolated=lambda columns: extrapolated,
    )


def _by_altitude(configuration: _Configuration, cells: FloatArray) -> dict[float, BoolArray]:
    """Return flags of the cells to simulate at each altitude [m]."""
    if configuration.altitudes_m is None:
        return {height: cells[:, 0] == height for height in np.unique(cells[:, 0]).tolist()}
    return {height: np.ones(len(cells), bool) for height in configuration.altitudes_m}


def _scenarios(configuration: _Configuration, cells: FloatArray) -> Scenarios:
    """Return the middle of each cell's month, at its latitude or the mission's first."""
    days = [day_of_year(f"{int(month):02d}-{_MIDDLE}") for month in cells[:, 1]]
    first = configuration.mission.latitudes()[0]
    north = np.full(len(cells), first) if configuration.altitudes_m is None else cells[:, 0]
    return Scenarios(north, np.array(days))


def _station_cells(configuration: _Configuration, cells: FloatArray) -> dict[str, FloatArray]:
    """Compute columns of cells, each at the altitude of the largest share."""
    groups = _by_altitude(configuration, cells)
    results = {name: np.full((len(groups), len(cells)), -1.0) for name in _DESCRIBED}
    for row, (height, where) in enumerate(groups.items()):
        mission = configuration.mission.at_altitude(height)
        flights = station_keeping(
            configuration.aircraft,
            mission,
            configuration.solar,
            scenarios=_scenarios(configuration, cells[where]),
        )
        results["share"][row, where], results["at_end"][row, where] = flights.share, flights.at_end
        results["airspeed"][row, where] = flights.airspeed_m_per_s
        results["wind"][row, where] = flights.wind_m_per_s
    best = results["share"].argmax(axis=0)
    columns = {name: values[best, np.arange(len(cells))] for name, values in results.items()}
    chosen_m = np.array(list(groups))[best]
    return columns | (dict.fromkeys(_CHOSEN, chosen_m) if configuration.chooses else {})


def station_of(study: Study, data: gridded.Gridded) -> Station:
    """Make the result of a study."""
    configuration: _Configuration = study.configuration
    winds = required_winds(configuration.aircraft, configuration.mission).table(
        configuration.mission.longitude_deg
    )
    variables = dict(data.variables)
    return Station(
        configuration.aircraft,
        configuration.mission,
        configuration.solar,
        over="altitude" if configuration.altitudes_m is None else "latitude",
        source=winds.source,
        at_end=bool(np.any(variables.pop("at_end").values == 1.0)),
        cells=gridded.Gridded(variables, data.coordinates, data.attrs),
    )


def _extrapolations(
    places: Sequence[Mission], configuration: _Configuration
) -> tuple[Extrapolation, ...]:
    """Return where the design leaves the range of a model, at all altitudes."""
    aircraft, solar = configuration.aircraft, configuration.solar
    calm = [place.in_wind(0.0) for place in places]  # the share says what the wind does
    each = [
        collect_extrapolations(design_checks(aircraft, place, design_of(aircraft, place), solar))
        for place in calm
    ]
    return each[0] if len(each) == 1 else merge_extrapolations(each, "altitudes")


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
