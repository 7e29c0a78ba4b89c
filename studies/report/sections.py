"""Sections of a report: the aircraft, its flight, how far to trust the results, and the inputs.

Margins: how much worse each assumption may become before perpetual flight ends, or how much better.
One quantity at a time is moved until the weakest scenario just has the required excess time; all
else stays as it is. The sun is not computed anew: none of the quantities changes it but by a
factor.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from matplotlib.contour import ContourSet

from missions.dates import DAYS_PER_YEAR, MONTH_NAMES, MONTH_STARTS, date_label
from missions.files.writing import to_yaml
from missions.mission import Mission, Scenarios
from missions.mission.scenarios import latitude_label
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.day.light import SolarModel, solar_day
from sizing.day.metrics import Cycle
from sizing.mass_budget import ImpossibleDesignError, design_of
from sizing.parameters import with_parameter
from sizing.performance import performance
from sizing.program.objectives import Objective
from sizing.results.analysis import Analysis
from sizing.results.design_result import requirement_margins
from sizing.results.result import Result, relative_change
from sizing.roots import bracketed_root
from solar.names import MODELS
from solar.types import FloatArray
from studies.maps.plots import plot_map
from studies.maps.study import prepare
from studies.models.plots import plot_comparison
from studies.output.cycle_plots import panel_count, plot_cycle, plot_flight
from studies.output.figures.drawing import objective_caption
from studies.quantities import BELOW_ZERO, EXCESS_TIME, MINIMUM_CHARGE, TABLE, group, words
from studies.render.analysis import power_rows, scenario_table, wind_rows
from studies.render.design_sheet import design_sheet
from studies.render.sizing import (
    cross_check_line,
    limits_line,
    loss_line,
    record_blocks,
    requirement_table,
)
from studies.render.tables import ALL, Column, Line, Table, facts
from studies.render.words import percent, required, with_unit
from studies.report.blocks import Bars, Block, Listing, page_figure, page_options
from studies.report.geometry import Drawing
from studies.report.subject import Subject
from studies.report.three_view import description, plot_three_view
from studies.uncertainty import plot_uncertainty
from studies.weather import plot_weather

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Plot

_WIDTH_IN, _WIDE_IN = 7.4, 7.8
# Steps that say where the chain has arrived.
LIGHT, LOAD = "light on a horizontal area as large as the modules", "load"
ELECTRIC = "electric energy of the modules"
SUMS = frozenset((LIGHT, ELECTRIC, LOAD))
_SHOWN_WH = 0.5  # smaller losses are left out


def aircraft_blocks(subject: Subject) -> Iterator[Block]:
    """Yield three views to scale, and the quantities of the design."""
    aircraft, balance = subject.aircraft, subject.analysis.balance
    drawing, points = Drawing(aircraft), {}
    if balance is not None:
        points = {"gravity_m": balance.gravity_m, "neutral_m": float(balance.neutral_point.x_m)}
    if aircraft.description:
        yield Line(aircraft.description, "strong")
    yield page_figure(
        plot_three_view(drawing, **points, figure=page_options(_WIDTH_IN)),
        f"Three views to scale. {' '.join(drawing.notes)}",
        title=f"Three views of {aircraft.name}",
        words=description(drawing),
        key="views",
    )
    if subject.verification is not None:
        return
    rows = [
        (entry.group, entry.quantity.label, " ".join(entry.shown()).strip())
        for entry in design_sheet(subject.analysis).quantities
        if entry.group not in ("masses", "balance")
    ]
    rows += [("flight", *row) for row in wind_rows(subject.analysis.wind)]
    if subject.mission.holds_station:
        rows.append(("flight", "flown, to hold its place", "as fast as the wind at least"))
    groups = dict.fromkeys(group for group, *_ in rows)
    yield tuple(facts(name, [(a, b) for of, a, b in rows if of == name]) for name in groups)
    required_h = max(subject.mission.required_excess_time_h, 0.0)
    yield requirement_table(requirement_margins(aircraft, subject.analysis.performance, required_h))


# ---- Masses and power


def budget_blocks(subject: Subject) -> Iterator[Block]:
    """Yield where mass, power and the energy of the day go."""
    analysis = subject.analysis
    where = analysis.worst_scenario.label
    measured = not isinstance(subject.aircraft.airframe, ParametricAirframe)  # in a single part
    names = {"other": "airframe, propulsion and avionics (measured)"} if measured else {}
    each = analysis.performance.design.masses._asdict().items()
    masses = tuple((names.get(name, words(name)), float(kg)) for name, kg in each if kg > 0.0)
    yield Bars("mass budget", "kg", ".3f", masses, "total mass")
    yield Bars("load in level flight", "W", ".2f", power_rows(analysis.power_budget), "load")
    title = f"from the sun to the load: energy of the day, {where}"
    yield Bars(title, "Wh", ".0f", loss_chain(analysis), sums=SUMS)
    yield from subject.sections["parts"]


def loss_chain(analysis: Analysis) -> tuple[tuple[str, float], ...]:
    """Return the steps from the light on the modules to the load, in the worst scenario [Wh].

    A step is a loss, negative, or one of :data:`SUMS`. The losses of the modules are found by the
    solar power model itself, with one loss after the other taken away. Of a flight that draws from
    a full battery, what it draws is a step as well.
    """
    cycle, worst = analysis.performance.cycle, analysis.worst
    budget = {
        key: float(np.broadcast_to(values, cycle.status.shape)[worst])
        for key, values in vars(cycle.energy_budget).items()
    }
    solar_wh, stored_wh = budget["solar_wh"], budget["stored_wh"]
    steps = [
        *(_of_modules(analysis, solar_wh) if solar_wh > 0.0 else ()),
        (ELECTRIC, solar_wh),
        ("not collected, the battery being full", -budget["curtailed_wh"]),
        ("lost in charging", -budget["charge_loss_wh"]),
        ("lost in discharging", -budget["discharge_loss_wh"]),
        ("left in the battery" if stored_wh > 0.0 else "drawn from the battery", -stored_wh),
        (LOAD, budget["load_wh"]),
        ("of which not met: the battery is empty", -budget["unserved_wh"]),
    ]
    return tuple((label, wh) for label, wh in steps if label in SUMS or abs(wh) >= _SHOWN_WH)


# Modules without losses; one constant after the other becomes that of the file.
_LOSSLESS = {
    "efficiency_stc": 1.0,
    "camber_efficiency": 1.0,
    "temperature_coefficient_per_k": 0.0,
    "mppt_efficiency": 1.0,
}


def _of_modules(analysis: Analysis, solar_wh: float) -> list[tuple[str, float]]:
    """Return the steps from the light to the electric energy of the modules."""
    perf, modules = analysis.performance, analysis.aircraft.modules
    solar, of, worst = perf.solar, perf.day.scenarios, [analysis.worst]
    scenarios = Scenarios(of.latitude_deg[worst], of.day_of_year[worst])
    models = [SolarModel("CDM"), *4 * [replace(solar, correction="none")], solar]
    energies = []  # of a day, in proportion to each other
    for number, model in enumerate(models):
        update = {"modules": modules.model_copy(update=dict([*_LOSSLESS.items()][number:]))}
        aircraft = analysis.aircraft.model_copy(update=update)
        day = solar_day(aircraft, analysis.mission, model, scenarios=scenarios, design=perf.design)
        energies.append(np.trapezoid(day.specific_power_w_per_m2[0], day.time_h))
    light, *by_model = solar_wh / energies[-1] * np.array(energies)
    labels = (
        f"not converted: module efficiency {percent(modules.efficiency_stc)}",
        f"angle of incidence, diffuse light, attitude{', MPPT' if solar.model == 'FM' else ''}",
        "camber of the wing",
        "temperature of the modules",
        "MPPT",
        "correction of the model's systematic error",
    )
    losses = np.diff([light, light * modules.efficiency_stc, *by_model]).tolist()
    return [(LIGHT, float(light)), *zip(labels, losses, strict=True)]


# ---- Sizing


def sizing_blocks(subject: Subject) -> Iterator[Block]:
    """Yield what was optimised, what limits it, how sensitive it is, and its cross-check."""
    if (sizing := subject.sizing) is None:
        return
    objective = Objective(sizing["objective"]["name"])
    value, required_h = (sizing["objective"][key] for key in ("value", "required_excess_time_h"))
    text = f"Sized for the {objective_caption(objective)}: {with_unit(value, objective)}"
    if required_h:
        text += f", with {required(required_h, subject.mission)} required in every scenario"
    yield f"{text} ({sizing['status'].replace('_', ' ')})."
    if (reliability := sizing.get("reliability")) is not None:
        achieved, least = percent(reliability["achieved"]), percent(reliability["required"], "g")
        yield f"Reliability: {achieved} of {reliability['samples']} draws; required {least}."
    if active := sizing["active_constraints"]:
        yield limits_line(active, subject.aircraft, keys=True)
    if (cells := sizing.get("whole_cells")) is not None:
        yield loss_line(cells, objective)
    if sizing.get("sensitivities") is None and not objective.of_range:
        yield Line("The sensitivities were not computed.", "faint")
    if (record := sizing.get("cross_check")) is not None:
        text = cross_check_line(record, objective)
        yield Line(text, "good" if record["cross_checked"] else "warning")
    elif not objective.of_range:
        yield Line("The optimum was not cross-checked.", "faint")
    yield from record_blocks(sizing, objective)


# ---- The day

_MOST_SCENARIOS = 20  # rows of the table
# Cells of the season map: latitudes and days; fewer of the models that take 10 ms each.
CELLS, CLIMBING_CELLS, SLOW_CELLS = (57, 74), (29, 37), (15, 14)
_MIDDLE_OF_MONTH = 14  # days after its first
_POLEWARD_DEG = 70.0  # or the poles, for a mission beyond
_MOST_RINGS = 30
# Lines on the cells of a map: black on a dark page as well, unlike the axes.
_ON_CELLS = "#111111"


def day_blocks(subject: Subject) -> Iterator[Block]:
    """Yield the weakest scenario's day, all scenarios, and the flight on the calendar."""
    analysis = subject.analysis
    where, several = analysis.worst_scenario.label, len(analysis.scenarios) > 1
    caption = (
        f"Solar power, load and state of charge over solar time at {where}"
        f"{', the weakest scenario' if several else ''}; bands: the solar model's RMS error. Grey: "
        "night."
    )
    options = page_options(_WIDTH_IN, 1.2 + 2.0 * panel_count(analysis))
    _, least = MINIMUM_CHARGE.fact(analysis.minimum_state_of_charge)
    charge, title = f"The charge is least, {least}, in the morning.", f"Day cycle at {where}"
    plot = plot_cycle(analysis, figure=options)
    yield page_figure(plot, caption, title=title, words=charge, key="cycle")
    if several:
        excess_h = analysis.performance.cycle.excess_time_h
        weakest = np.argsort(excess_h, kind="stable")[:_MOST_SCENARIOS]
        if len(weakest) == len(excess_h):
            yield scenario_table(analysis)
        else:
            note = f"the {_MOST_SCENARIOS} weakest of {len(excess_h)} scenarios"
            yield replace(scenario_table(analysis, weakest), notes=(note,))
    if analysis.flight is not None:
        plot = plot_flight(analysis, analysis.flight, figure=page_options(_WIDTH_IN, 4.8))
        caption = "Solar power, load and state of charge from the mission's launch. Grey: night."
        yield page_figure(plot, caption, title="Flight on the calendar", key="calendar")
        yield from subject.sections["flight"]


# ---- Season


def season_blocks(subject: Subject) -> Iterator[Block]:
    """Yield where and when the flight is perpetual, and the months."""
    analysis, mission, solar = subject.analysis, subject.mission, subject.solar
    scenarios = analysis.performance.day.scenarios
    climbing = CLIMBING_CELLS if mission.climb is not None else CELLS
    rows, columns = SLOW_CELLS if solar.needs_path else climbing
    farthest = 90.0 if np.max(np.abs(scenarios.latitude_deg)) > _POLEWARD_DEG else _POLEWARD_DEG
    south, north = solar.latitudes_with_wind_deg(mission)
    latitudes = np.unique(np.linspace(max(-farthest, south), min(farthest, north), rows))
    days = np.linspace(1, DAYS_PER_YEAR, columns).round().astype(int)
    data = prepare(subject.aircraft, mission, latitudes, days, solar).computed()
    plot = plot_map(data, figure=page_options(_WIDTH_IN, 4.6))
    _ring_places(plot, scenarios.latitude_deg, scenarios.day_of_year)
    if season := _season_text(subject):
        yield season
    conditions = [
        "Excess time of this aircraft on every day at every latitude, in the mission's air",
        "black line: edge of perpetual flight",
        "ring: the mission's scenarios",
        "flown as fast as the wind, at the latitudes where it is known" * mission.holds_station,
        f"with {mission.climb_label}" if mission.climb is not None else "",
    ]
    caption = f"{'; '.join(filter(None, conditions))}."
    yield page_figure(plot, caption, title="Season map", words=season, key="season")
    yield _months(subject)


def _months(subject: Subject) -> Table:
    """Return the repeated day in the middle of every month, at the latitude of the worst one."""
    latitude = float(subject.analysis.worst_scenario.latitude_deg)
    days = np.array(MONTH_STARTS) + _MIDDLE_OF_MONTH
    data = prepare(subject.aircraft, subject.mission, [latitude], days, subject.solar).computed()
    columns = group("month day_length_h solar_energy_wh load_energy_wh excess_time_h "
                    "charge_margin_h minimum_state_of_charge")  # fmt: skip
    values = [data[column.variable].to_numpy()[0] for column in columns[1:]]
    rows = tuple(zip(MONTH_NAMES, *values, strict=True))
    title = f"the months at {latitude_label(latitude)}, each on its {_MIDDLE_OF_MONTH + 1}th"
    short = bool(np.any(data[EXCESS_TIME.variable].to_numpy() < 0.0))
    return Table(title, columns, rows, (BELOW_ZERO,) if short else ())


def _ring_places(plot: Plot, latitude_deg: Any, day: Any) -> None:
    """Ring the places of a mission: of many, the corners of what they cover."""
    if len(day) > _MOST_RINGS:
        days, latitudes = ((min(v), max(v)) for v in (day, latitude_deg))
        day, latitude_deg = (*days, *days), (latitudes[0], *latitudes, latitudes[1])
    axes = plot.axes[0]
    for contour in axes.collections:
        if isinstance(contour, ContourSet) and not contour.filled:
            contour.set_edgecolor(_ON_CELLS)
    for colour, width in (("white", 3.2), (_ON_CELLS, 1.4)):
        looks: dict[str, Any] = {"color": colour, "markeredgewidth": width, "fillstyle": "none"}
        axes.plot(day, latitude_deg, "o", markersize=9.0, clip_on=False, zorder=5, **looks)


def _season_text(subject: Subject) -> str:
    """Return the days of the year with perpetual flight at all latitudes, in words."""
    if (comparison := subject.comparison) is None:
        return ""
    cases = (case.season for case in comparison.cases if case.solar == subject.solar)
    if (season := next(cases, None)) is None:
        return ""
    text = f"At {_places(comparison.mission.latitudes())}, flight is perpetual on"
    if season.days in (0, DAYS_PER_YEAR):
        return f"{text} {'every' if season.days else 'no'} day of the year."
    if season.first is None or season.last is None:
        return f"{text} {season.days} days of the year, none of them at midsummer."
    window = f"{date_label(season.first)} to {date_label(season.last)}"
    return f"{text} {season.days} days of the year, {window} without a break."


def _places(latitudes: Sequence[float]) -> str:
    """Return one latitude, or the ends of several, in words."""
    ends = [latitude_label(latitude) for latitude in latitudes]
    return ends[0] if len(ends) == 1 else f"all latitudes from {ends[0]} to {ends[-1]}"


# ---- Models


def models_blocks(subject: Subject) -> Iterator[Block]:
    """Yield all solar power models side by side."""
    if (comparison := subject.comparison) is None:
        yield f"The solar power models are not compared: {subject.path_trouble}."
        return
    options = page_options(_WIDE_IN, 1.9 + 0.26 * len(comparison.cases))
    at = comparison.mission.latitudes()
    where = "" if len(at) == len(subject.mission.latitudes()) else f" at {_places(at)}"
    caption = (
        f"What each model predicts{where}: solar energy and excess time with bars of the model's "
        "RMS error, and the perpetual season."
    )
    yield f"{comparison.headline()} {comparison.perpetual_line()}"
    yield page_figure(
        plot_comparison(comparison, figure=options),
        caption,
        title="Solar power models",
        words="The same numbers are in the table below.",
        key="models",
    )
    yield from comparison.scenario_tables()
    yield from (f"- {note}" for note in comparison.notes)


# ---- Scatter, weather, logs


def _with_figure(result: Result, figure: Block) -> Iterator[Block]:
    """Yield all blocks of a result, a figure behind the first one."""
    first, *others = result.at_level(ALL).blocks
    yield from (first, figure, *others)


def uncertainty_blocks(subject: Subject) -> Iterator[Block]:
    """Yield how likely the flight is perpetual when inputs scatter, if any do."""
    if (uncertainty := subject.uncertainty) is None:
        return
    figure = page_figure(
        plot_uncertainty(uncertainty, figure=page_options(9.6)),
        f"Excess time of the weakest scenario in {uncertainty.samples} draws of the uncertain "
        "inputs, and what it depends on.",
        title="Excess time under uncertain inputs",
        words=f"{uncertainty.headline()}. The shares are in the table below.",
        key="scatter",
    )
    yield from _with_figure(uncertainty, figure)


def weather_blocks(subject: Subject) -> Iterator[Block]:
    """Yield the flight through a weather record, if there is one."""
    if (weather := subject.weather) is None:
        return
    figure = page_figure(
        plot_weather(weather, figure=page_options(_WIDE_IN, 6.4)),
        "State of charge at every dawn, survival of launches, and the season in this weather.",
        title="Flight through the weather record",
        words=f"{weather.headline()}.",
        key="weather",
    )
    yield from _with_figure(weather, figure)


def verification_blocks(subject: Subject) -> Iterator[Block]:
    """Yield the models against a flight log, if there is one."""
    if (verification := subject.verification) is None:
        return
    from studies.flight_logs.plots import figures  # a fifth of a second, with pandas

    yield from verification.at_level(ALL).blocks
    for name, draw in figures(verification, figure=page_options(_WIDE_IN)):
        title, caption = f"Log and models, {name}", f"Measured and modelled power: {name}."
        yield page_figure(draw(), caption, title=title, key=f"log-{name}")


# ---- Margins, confidence, inputs


def margins_blocks(subject: Subject) -> Iterator[Block]:
    """Yield how much worse each assumption may become."""
    if (table := margin_table(subject)) is None:
        text = (
            "None: the weakest scenario has just what is required. A little less of any quantity, "
            "of the sun or the battery, ends it."
        )
        yield Line(text, "warning")
        return
    yield table
    text = (
        "Each quantity changes alone until the weakest scenario just meets the requirement; all "
        "else stays as it is, the mass with the battery's specific energy as well."
    )
    yield Line(text, "faint")


def belief_blocks(subject: Subject) -> Iterator[Block]:
    """Yield what is extrapolated, the solar models' errors, and what is left out."""
    if subject.verification is None:
        within = Line("Nothing lies outside the range of a model.", "good")
        yield from subject.sections["warnings"]
        yield from subject.sections["extrapolations"] or [within]
        yield from subject.sections["error"]
    columns = group("model average_error rms_error scatter_of_error")
    rows = tuple((model, of.average, of.rms, of.scatter) for model, of in MODELS.items())
    note = (
        "of the mean measured power; one flight of AtlantikSolar AS-2, 47.6° N, 1 July 2015, "
        "sunrise to 9.72 h (Oettershagen, High-Fidelity Solar Power Income Modeling, table 3)"
    )
    yield Table("published errors of the solar power models", columns, rows, (note,))
    yield from (f"- {text}" for text in _left_out(subject))


def _left_out(subject: Subject) -> Iterator[str]:
    """Yield what the numbers of the report leave out."""
    mission, clearness = subject.mission, subject.mission.pessimistic_clearness
    clouded = f"The light is {percent(clearness, '.0f')} of a clear sky's"
    sky = "The sky is clear" if clearness == 1.0 else clouded
    yield f"{sky} all day; a weather record (--weather) adds clouds."
    if subject.verification is None:
        yield (
            "The day repeats itself: the date does not advance, and the battery's state at dawn is "
            "that of the settled cycle."
        )
        if subject.aircraft.battery.ageing is None:
            yield "The battery is new: the aircraft file has no ageing."
        if mission.holds_station:
            yield "The wind is steady: faster flight against it takes as much all day."
        elif mission.turbulence.all_day == 0.0 and mission.turbulence.thermal == 0.0:
            yield "The air is calm: level flight takes no more power than in still air."
        asked = subject.with_uncertainty is not None or not subject.has_uncertain_inputs
        if not asked and not subject.uncertainty_is_quick:
            count = len(mission.scenarios())
            yield f"Uncertain inputs: left out, {count} scenarios take long (--uncertainty)."
    if mission.uncertainty_margins.is_set:
        yield "The mission's uncertainty margins are taken off every number here."


def glossary_blocks(_: Subject) -> Iterator[Block]:
    """Yield the words of the report: quantities, and solar power models."""
    models = "; ".join(f"{name}: {model.label}" for name, model in MODELS.items())
    rows = [(each.label, each.definition) for each in TABLE.values() if each.definition]
    rows.append(("solar power models", f"{models}."))
    yield Table("Words", group("word meaning"), tuple(rows))


def inputs_blocks(subject: Subject) -> Iterator[Block]:
    """Yield aircraft and mission as they were used."""
    if subject.overrides:
        yield "Values given in place of the files' own:"
        yield from (f"- {override}" for override in subject.overrides)
    if subject.mission_is_default:
        yield Line("The mission is the default one: --mission names another.", "warning")
    if taken := subject.aircraft.from_catalogues():
        columns = (Column("key"), *group("value product source"))
        rows = [(entry.key, entry.text, entry.label, entry.source) for entry in taken]
        yield Table("values from catalogues", columns, tuple(rows))
    for title, data in (
        (f"aircraft {subject.aircraft.name}", subject.inputs.aircraft),
        (f"mission {subject.mission.name}", subject.inputs.mission),
    ):
        yield Listing(title, to_yaml(data, compact=True))


def provenance_blocks(subject: Subject) -> Iterator[Block]:
    """Yield the command line, software and files of the report."""
    run = subject.run
    made = [
        ("date (UTC)", run["date_utc"].replace("T", " ").removesuffix("+00:00")),
        ("solar-uav", run["version"]),
        ("Python", run["python"]),
    ]
    if subject.verification is None:
        made.insert(0, ("solar power model", subject.solar.label))
    files = tuple(
        (kind, file["source"], file["sha256"] or "not read again (a pipe)")
        for kind, file in run["inputs"].items()
    )
    yield Listing("command line", run["command"])
    yield facts("software", made), facts("libraries", run["libraries"].items())
    yield Table("files", group("what file sha256"), files)


# The weakest scenarios, of which one remains the weakest.
_SCENARIOS = 6
_NO_MARGIN = 1e-3  # of a value, or in its unit: what a design on the edge has
_TOLERANCE = 1e-4  # of a limit
_NOT_FLYING_H = -24.0  # what lacks where no design closes


def margin_table(subject: Subject) -> Table | None:
    """Return the margin of every quantity to the end of perpetual flight, or its gap.

    Without those that have next to none; None where that is true of all.
    """
    nominal = subject.analysis.performance
    day = nominal.day.at(np.argsort(nominal.cycle.excess_time_h, kind="stable")[:_SCENARIOS])
    required_h = max(subject.mission.required_excess_time_h, 0.0)
    holds = _spare_h(nominal.cycle, required_h) >= 0.0

    def spare_h(key: str, scale: float, values: FloatArray) -> FloatArray:
        """Return the excess time beyond what is required with a quantity at a value."""
        aircraft, mission, light = subject.aircraft, subject.mission, day
        if key:
            aircraft, mission = with_parameter(aircraft, mission, key, scale * values.item())
        else:
            light = day.scaled(scale * values.item())
        try:
            if mission.ceiling_m > mission.altitude_m:
                design_of(aircraft, mission.at_altitude(mission.ceiling_m))
            cycle = performance(aircraft, mission, day=light, keep_trajectory=False).cycle
        except ImpossibleDesignError:
            return np.array([_NOT_FLYING_H])
        return np.array([_spare_h(cycle, required_h)])

    rows: list[tuple[Any, ...]] = []
    for label, unit, now, worse, better, key in _quantities(subject.aircraft, subject.mission):
        scale = 0.01 if unit == "%" else 1.0
        ends = np.array([now]), np.array([worse if holds else better])
        found = bracketed_root(partial(spare_h, key, scale), *ends, _TOLERANCE).item()
        if math.isnan(found):
            rows.append((label, unit, now, None, None, None))
        elif abs(found - now) > _NO_MARGIN * max(abs(now), 1.0 / scale):
            relative = relative_change(now, found)
            rows.append((label, unit, now, found, found - now, relative and 100.0 * relative))
    if not rows:
        return None
    columns = group("quantity unit now limit_alone change change_percent")
    looks: dict[str, Any] = {"missing": "no limit"}
    what = "margins to the end of"
    if not holds:
        looks = {"label": "would have to become", "missing": "not enough alone"}
        what = "what is missing for"
    columns = (*columns[:3], replace(columns[3], **looks), *columns[4:])
    return Table(
        f"{what} {required(required_h, subject.mission)}, one at a time", columns, tuple(rows)
    )


def _quantities(
    aircraft: Aircraft, mission: Mission
) -> Iterator[tuple[str, str, float, float, float, str]]:
    """Yield the quantities that are moved: sun, battery, propulsion, loads, payload.

    Words, unit, value of the files, the end at which nothing flies, the other end, and the key of
    the parameter, which the sun has none of.
    """
    battery, avionics = aircraft.battery.specific_energy_wh_per_kg, aircraft.power.avionics_w
    payload, turbulence = mission.payload.mass_kg, mission.turbulence.all_day
    yield "solar power, relative to the model", "%", 100.0, 0.0, 400.0, ""
    label, key = "specific energy of the battery", "battery.specific_energy_wh_per_kg"
    yield label, "Wh/kg", battery, 0.01 * battery, 4.0 * battery, key
    label, key = "propulsion power, beyond level flight", "mission.turbulence.all_day"
    yield label, "%", 100.0 * turbulence, 400.0, -90.0, key
    yield "avionics power", "W", avionics, 1e3 + 10.0 * avionics, 0.0, "power.avionics_w"
    yield "payload mass", "kg", payload, payload + 50.0, 0.0, "mission.payload.mass_kg"


def _spare_h(cycle: Cycle, required: float) -> float:
    """Return the least excess time beyond what is required [h]; negative where one falls short."""
    spare_h = np.clip(cycle.excess_time_h - required, _NOT_FLYING_H, -_NOT_FLYING_H)
    # At the end of perpetual flight it may be just zero.
    return float(np.min(np.where(cycle.sufficient, spare_h, np.minimum(spare_h, -_NO_MARGIN))))


# ---- In the order of reading

Make: TypeAlias = Callable[[Subject], Iterator[Block]]
AIRCRAFT = "aircraft", "The aircraft", aircraft_blocks
BELIEF = "belief", "Confidence", belief_blocks
# Key, heading and what makes the blocks, in the order in which a design review reads them.
OF_A_DESIGN: tuple[tuple[str, str, Make], ...] = (
    AIRCRAFT,
    ("budgets", "Mass, power and energy", budget_blocks),
    ("day", "The day", day_blocks),
    ("season", "The season", season_blocks),
    ("sizing", "Sizing", sizing_blocks),
    ("margins", "Margins", margins_blocks),
    ("uncertainty", "Uncertain inputs", uncertainty_blocks),
    ("weather", "Weather", weather_blocks),
    BELIEF,
    ("models", "Solar power models", models_blocks),
)
OF_A_LOG: tuple[tuple[str, str, Make], ...] = (
    AIRCRAFT,
    ("verification", "Models against the flight log", verification_blocks),
    BELIEF,
)
AT_THE_END: tuple[tuple[str, str, Make], ...] = (
    ("glossary", "Glossary", glossary_blocks),
    ("provenance", "How this report was made", provenance_blocks),
    ("inputs", "Inputs", inputs_blocks),
)
