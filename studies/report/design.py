"""Sections on the aircraft: its drawing, masses, power, and how it was sized."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from missions.mission import Scenarios
from sizing.aircraft import ParametricAirframe
from sizing.day.light import SolarModel, solar_day
from sizing.program.cross_check import CrossCheck
from sizing.program.objectives import Objective
from sizing.results.analysis import Analysis
from sizing.results.margins import requirement_margins
from studies.quantities import words
from studies.render.analysis import power_rows, wind_rows
from studies.render.design_sheet import design_sheet
from studies.render.sizing import (
    cross_check_line,
    limits_line,
    loss_line,
    record_blocks,
    requirement_table,
)
from studies.render.tables import Line, facts
from studies.render.words import percent, required, with_unit
from studies.report.blocks import Bars, Block, Section, page_figure, page_options
from studies.report.geometry import Drawing
from studies.report.subject import Subject
from studies.report.three_view import description, plot_three_view

_WIDTH_IN = 7.4
LIGHT, ELECTRIC, LOAD = (
    "light on a horizontal area as large as the modules",
    "electric energy of the modules",
    "load",
)
SUMS = frozenset((LIGHT, ELECTRIC, LOAD))  # steps that say where the chain has arrived
_SHOWN_WH = 0.5  # smaller losses are left out


def aircraft_section(subject: Subject) -> Section:
    """Return three views to scale, and the quantities of the design."""
    aircraft, balance = subject.aircraft, subject.analysis.balance
    drawing, points = Drawing(aircraft), {}
    if balance is not None:
        points = {"gravity_m": balance.gravity_m, "neutral_m": float(balance.neutral_point.x_m)}
    views = page_figure(
        plot_three_view(drawing, **points, figure=page_options(_WIDTH_IN)),
        f"Three views to scale. {' '.join(drawing.notes)}",
        title=f"Three views of {aircraft.name}",
        description=description(drawing),
        key="views",
    )
    blocks: list[Block] = [Line(aircraft.description, "strong")] if aircraft.description else []
    blocks.append(views)
    if subject.verification is None:
        required_h = max(subject.mission.required_excess_time_h, 0.0)
        margins = requirement_margins(aircraft, subject.analysis.performance, required_h)
        groups: dict[str, list[tuple[str, str]]] = {}
        for entry in design_sheet(subject.analysis).quantities:
            if entry.group not in ("masses", "balance"):
                row = entry.quantity.label, " ".join(entry.shown()).strip()
                groups.setdefault(entry.group, []).append(row)
        groups.setdefault("flight", []).extend(wind_rows(subject.mission))
        if subject.mission.holds_station:
            groups["flight"].append(("flown, to hold its place", "as fast as the wind at least"))
        tables = tuple(facts(group, rows) for group, rows in groups.items() if rows)
        blocks += [tables, requirement_table(margins)]
    return Section("aircraft", "The aircraft", blocks)


# ---- Masses and power


def budget_section(subject: Subject) -> Section:
    """Return where mass, power and the energy of the day go."""
    analysis = subject.analysis
    where = analysis.performance.worst_label
    measured = not isinstance(subject.aircraft.airframe, ParametricAirframe)  # in a single part
    names = {"other": "airframe, propulsion and avionics (measured)"} if measured else {}
    each = analysis.performance.design.masses._asdict().items()
    masses = tuple((names.get(name, words(name)), float(kg)) for name, kg in each if kg > 0.0)
    blocks: list[Block] = [
        Bars("mass budget", "kg", ".3f", masses, "total mass"),
        Bars("load in level flight", "W", ".2f", power_rows(analysis.power_budget), "load"),
        Bars(f"from the sun to the load: energy of the day, {where}", "Wh", ".0f",
             loss_chain(analysis), sums=SUMS),
    ]  # fmt: skip
    return Section("budgets", "Mass, power and energy", [*blocks, *subject.sections["parts"]])


def loss_chain(analysis: Analysis) -> tuple[tuple[str, float], ...]:
    """Return the steps from the light on the modules to the load, in the worst scenario [Wh].

    A step is a loss, negative, or one of :data:`SUMS`. The losses of the modules are found by the
    solar power model itself, with one loss after the other taken away. Of a flight that draws from
    a full battery, what it draws is a step as well.
    """
    cycle, worst = analysis.performance.cycle, analysis.worst
    budget = {
        key.removesuffix("_wh"): float(np.broadcast_to(values, cycle.status.shape)[worst])
        for key, values in vars(cycle.energy_budget).items()
    }
    solar_wh, stored_wh = budget["solar"], budget["stored"]
    steps = [
        *(_of_modules(analysis, solar_wh) if solar_wh > 0.0 else ()),
        (ELECTRIC, solar_wh),
        ("not collected, the battery being full", -budget["curtailed"]),
        ("lost in charging", -budget["charge_loss"]),
        ("lost in discharging", -budget["discharge_loss"]),
        ("left in the battery" if stored_wh > 0.0 else "drawn from the battery", -stored_wh),
        (LOAD, budget["load"]),
        ("of which not met: the battery is empty", -budget["unserved"]),
    ]
    return tuple((label, wh) for label, wh in steps if label in SUMS or abs(wh) >= _SHOWN_WH)


def _of_modules(analysis: Analysis, solar_wh: float) -> list[tuple[str, float]]:
    """Return the steps from the light to the electric energy of the modules."""
    solar, modules = analysis.performance.solar, analysis.aircraft.modules
    uncorrected = replace(solar, correction="none")
    ideal = {"mppt_efficiency": 1.0}
    cool = ideal | {"temperature_coefficient_per_k": 0.0}
    flat = cool | {"camber_efficiency": 1.0}
    cases: tuple[tuple[SolarModel, dict[str, float]], ...] = (
        (SolarModel("CDM"), flat | {"efficiency_stc": 1.0}),
        (uncorrected, flat),
        (uncorrected, cool),
        (uncorrected, ideal),
        (uncorrected, {}),
        (solar, {}),
    )
    perf, worst, of = analysis.performance, analysis.worst, analysis.performance.day.scenarios
    scenarios = Scenarios(of.latitude_deg[[worst]], of.day_of_year[[worst]])
    each = np.zeros(len(cases))  # energy of a day, in proportion to the others
    for number, (model, changes) in enumerate(cases):
        update = {"modules": modules.model_copy(update=changes)}
        aircraft = analysis.aircraft.model_copy(update=update)
        day = solar_day(aircraft, analysis.mission, model, scenarios=scenarios, design=perf.design)
        each[number] = np.trapezoid(day.specific_power_w_per_m2[0], day.time_h)
    light, *by_model = solar_wh / each[-1] * each
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


def sizing_section(subject: Subject) -> Section | None:
    """Return what was optimised, what limits it, how sensitive it is, and its cross-check."""
    sizing = subject.sizing
    if sizing is None:
        return None
    objective = Objective(sizing["objective"]["name"])
    value, required_h = (sizing["objective"][key] for key in ("value", "required_excess_time_h"))
    extreme = "largest" if objective.maximised else "smallest"
    text = f"Sized for the {extreme} {objective.label}: {with_unit(value, '.4g', objective)}"
    if required_h:
        text += f", with {required(required_h)} required in every scenario"
    blocks: list[Block] = [f"{text} ({sizing['status'].replace('_', ' ')})."]
    if (reliability := sizing.get("reliability")) is not None:
        achieved, least = percent(reliability["achieved"]), percent(reliability["required"], "g")
        draws = f"{reliability['samples']} draws"
        blocks.append(f"Reliability: {achieved} of {draws}; required {least}.")
    if active := sizing["active_constraints"]:
        blocks.append(limits_line(active, subject.aircraft, keys=True))
    cells = sizing.get("whole_cells")
    blocks += [] if cells is None else [loss_line(cells, objective)]
    if sizing.get("sensitivities") is None and not objective.of_range:
        blocks.append(Line("The sensitivities were not computed.", "faint"))
    record = sizing.get("cross_check")
    if record is not None:
        values: dict[str, Any] = {k: math.nan if v is None else v for k, v in record.items()}
        check = CrossCheck(**values)
        line = cross_check_line(check, objective)
        blocks.append(Line(line, "good" if check.cross_checked else "warning"))
    elif not objective.of_range:
        blocks.append(Line("The optimum was not cross-checked.", "faint"))
    return Section("sizing", "Sizing", [*blocks, *record_blocks(sizing, objective)])
