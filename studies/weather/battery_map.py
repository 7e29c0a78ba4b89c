"""Season against battery: the share of a record's days that close, in every half of a month.

What a designer asks of a site: in which season can it be flown, and would a larger battery make it
longer? All days of the record are flown with every battery, the charge carried over; the aircraft
carries the battery's mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import MONTH_LENGTHS, MONTH_NAMES, month_and_day
from missions.files.errors import file_error
from missions.mission import Mission
from missions.weather.light import NODE_STEP_S
from missions.weather.record import Weather
from missions.weather.site import mission_at_site
from sizing.aircraft import Aircraft
from sizing.design import Design
from sizing.margins.season_flights import Powers, SeasonFlights
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.parameters import with_parameter
from sizing.results.quantities import BATTERY_MASS, TOTAL_MASS
from sizing.results.records import finite
from sizing.results.tables import Column, Table
from sizing.sunlight import SolarModel
from sizing.validity.checks import record_check
from sizing.validity.extrapolations import told
from solar.types import IntArray
from studies.output.figures.drawing import Canvas, new_figure, styled
from studies.output.figures.options import DEFAULT
from studies.output.gridded import CLIMB, dataset

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

HALF_MONTHS = tuple(
    f"{name} {half}"
    for name, length in zip(MONTH_NAMES, MONTH_LENGTHS, strict=True)
    for half in ("1-15", f"16-{length}")
)
_LAST_NIGHT = "the record's last day, whose night it does not hold, counts in no half of a month"
_SHOWN = 4  # batteries in the table besides the aircraft's own


def battery_map(
    aircraft: Aircraft,
    mission: Mission,
    weather: Weather,
    battery_factors: Sequence[float],
    *,
    solar: SolarModel | None = None,
    mission_chosen: bool = True,
) -> xr.Dataset:
    """Share of the days of a record that close, by half of a month and battery.

    Parameters
    ----------
    aircraft : Aircraft
        Measured or parametric; its mass follows the battery's.
    mission : Mission
        Flown at the record's site, on all of the record's days.
    weather : Weather
        Record.
    battery_factors : sequence of float
        Batteries, as multiples of the aircraft's own.
    solar : SolarModel, optional
        Solar power model and its correction, by default CAM without one.
    mission_chosen : bool
        Whether somebody chose the mission; a default one follows the record anywhere.

    Returns
    -------
    xarray.Dataset
        ``closes`` of every battery and day (-1 where the aircraft cannot carry the battery),
        ``share`` of every battery and half of a month (NaN there, and without days), ``days`` of
        each half of a month, ``battery_mass`` and ``total_mass``.

    Raises
    ------
    InputError
        If a chosen mission is far from the site or below its ground, or the record holds no night.
    ValueError
        If a factor is not positive.
    """
    solar = SolarModel() if solar is None else solar
    factors = np.asarray(battery_factors, float)
    if not np.all(factors > 0.0):
        raise ValueError(f"batteries must be multiples above 0 (got {factors.min():g})")
    moved, notes = mission_at_site(mission, weather, chosen=mission_chosen)
    above = told([record_check(moved, weather.site.altitude_m)])
    all_year = {"dates": type(moved.dates).model_validate({"from": "01-01", "to": "12-31"})}
    moved = moved.model_copy(update=all_year)
    flights = SeasonFlights.of(aircraft, moved, weather, solar, step_s=NODE_STEP_S)
    if len(flights) < 2:
        raise file_error(weather.source, "has one day: a map needs the night after it as well")
    designs = [_with_battery(aircraft, moved, factor) for factor in factors]
    able = [i for i, one in enumerate(designs) if one is not None]
    closes = np.full((len(factors), len(flights)), -1, np.int8)
    powers = [Powers.of(one, flights.days) for one in designs if one is not None]
    if powers:
        closes[able] = flights.closes(Powers.joined(powers))
    axis = flights.days.axis
    dates = [month_and_day(int(day)) for day in axis.day_of_year[:-1]]
    place = np.array([2 * (month - 1) + (day > 15) for month, day in dates])  # 0 to 23
    masses = [np.nan if one is None else float(one.total_mass_kg) for one in designs]
    mass = {"units": "kg"}
    return dataset(
        {
            "closes": (("battery_factor", "time"), closes),
            "share": (("battery_factor", "half_month"), _shares(closes[:, :-1], place)),
            "days": ("half_month", np.bincount(place, minlength=len(HALF_MONTHS))),
            "battery_mass": ("battery_factor", factors * aircraft.battery.mass_kg, mass),
            "total_mass": ("battery_factor", np.array(masses), mass),
        },
        {
            "battery_factor": factors,
            "half_month": list(HALF_MONTHS),
            "time": (axis.time_s + 43200.0).astype("datetime64[s]").astype("datetime64[D]")
            .astype("datetime64[ns]"),
        },
        {
            "aircraft": aircraft.name,
            "mission": mission.name,
            "weather": weather.source,
            "site": weather.site.label,
            "model": solar.model,
            "correction": solar.correction,
            CLIMB: moved.climb_label,
            "notes": "; ".join([*notes, *(one.text for one in above), _LAST_NIGHT]),
        },
    )  # fmt: skip


def _with_battery(aircraft: Aircraft, mission: Mission, factor: float) -> Design | None:
    """Design with a larger or smaller battery; None where it cannot carry itself."""
    mass_kg = factor * aircraft.battery.mass_kg
    other, _ = with_parameter(aircraft, mission, "battery.mass_kg", mass_kg)
    try:
        return design_of(other, mission)
    except ImpossibleDesignError:
        return None


def _shares(closes: np.ndarray, place: IntArray) -> np.ndarray:
    shares = np.full((len(closes), len(HALF_MONTHS)), np.nan)
    for half in np.unique(place):
        shares[:, half] = closes[:, place == half].mean(axis=1)
    return np.where(shares < 0.0, np.nan, shares)


def battery_map_record(data: xr.Dataset) -> dict[str, Any]:
    """Map as a record, JSON-ready."""
    closes = data["closes"].to_numpy()
    return {
        "weather": data.attrs["weather"],
        "site": data.attrs["site"],
        "battery_factor": data["battery_factor"].to_numpy().tolist(),
        BATTERY_MASS.name: data[BATTERY_MASS.variable].to_numpy().tolist(),
        TOTAL_MASS.name: [finite(value) for value in data[TOTAL_MASS.variable].to_numpy()],
        "half_month": list(HALF_MONTHS),
        "days": data["days"].to_numpy().tolist(),
        "days_that_close": [
            None if row.min(initial=0) < 0 else int(row.sum()) for row in closes
        ],
        "share": [[finite(value) for value in row] for row in data["share"].to_numpy()],
        "model": data.attrs["model"],
        "correction": data.attrs["correction"],
        "notes": [text for text in data.attrs["notes"].split("; ") if text],
    }  # fmt: skip


def battery_map_table(data: xr.Dataset) -> Table:
    """Share of the days that close, a row a half of a month, some batteries as columns."""
    factors = data["battery_factor"].to_numpy()
    count = min(len(factors), _SHOWN)
    some = np.round(np.linspace(0, len(factors) - 1, count)).astype(int)
    some = np.unique(np.append(some, np.argmin(np.abs(factors - 1.0))))
    shares = 100.0 * data["share"].to_numpy()[some]
    days = data["days"].to_numpy()
    columns = [Column("half_month", "dates"), Column("days")]
    columns += [
        Column(f"battery_{factors[i]:g}", f"battery x {factors[i]:g}", "%", ".0f") for i in some
    ]
    rows = tuple(
        (name, int(days[i]), *(float(value) for value in shares[:, i]))
        for i, name in enumerate(HALF_MONTHS)
        if days[i]
    )
    title = f"{data.attrs['aircraft']} at {data.attrs['site']}: days that close"
    notes = tuple(text for text in data.attrs["notes"].split("; ") if text)
    return Table(title, tuple(columns), rows, notes)


@styled
def plot_battery_map(data: xr.Dataset, *, figure: Canvas = DEFAULT) -> Figure:
    """Draw the share of days that close over the season and the battery.

    Parameters
    ----------
    data : xarray.Dataset
        Of :func:`battery_map`.
    figure : FigureOptions or Figure
        How the figure looks, or one that is drawn on.

    Returns
    -------
    Figure
    """
    solar = SolarModel(data.attrs["model"], data.attrs["correction"])
    how = "; ".join(filter(None, (solar.label, data.attrs.get(CLIMB))))
    title = f"{data.attrs['aircraft']} at {data.attrs['site']} ({how})"
    drawn, (axes,) = new_figure(1, 1, title=title, size_in=(8.0, 4.2), grid="", canvas=figure)
    mass = data["battery_mass"].to_numpy()
    half = np.diff(mass).mean() / 2.0 if len(mass) > 1 else 0.5 * mass[0]
    edges = np.append(mass - half, mass[-1] + half)
    image = axes.pcolormesh(
        np.arange(25) / 2.0, edges, 100.0 * data["share"].to_numpy(), vmin=0.0, vmax=100.0,
        cmap="viridis", rasterized=True,
    )  # fmt: skip
    axes.set_xticks(np.arange(12) + 0.5, MONTH_NAMES)
    axes.set_ylabel("battery [kg]")
    drawn.colorbar(image, ax=axes, pad=0.01).set_label("days that close [%]")
    return drawn
