"""Sections on the aircraft: its drawing, masses, power, and how it was sized."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.day.light import SolarModel
from sizing.design import Design
from sizing.limits import DesignInFlight
from sizing.program.cross_check import CrossCheck
from sizing.program.objectives import Objective
from sizing.program.sensitivity import ConstraintMultiplier, Sensitivity
from sizing.results.margins import requirement_margins
from studies import quantities as q
from studies.render.analysis import balance_table, drag_table
from studies.render.numbers import with_unit
from studies.render.sentences import (
    balance_lines,
    cells_lines,
    cross_check_line,
    loss_line,
    power_note,
    power_rows,
    wind_rows,
)
from studies.render.sizing import margin_table
from studies.render.sizing_tables import (
    build_table,
    multiplier_table,
    neighbour_table,
    requirement_table,
    sensitivity_table,
)
from studies.render.tables import facts
from studies.render.words import constraint_words
from studies.report.blocks import Bars, Block, Section, Tables, Text, sentence
from studies.report.figures import page_figure, page_options
from studies.report.geometry import aircraft_drawing
from studies.report.losses import loss_chain
from studies.report.subject import Subject
from studies.report.three_view import description, plot_three_view

_WIDTH_IN = 7.4
_HELD = ("flown, to hold its place", "as fast as the wind at least")


def aircraft_section(subject: Subject) -> Section:
    """Three views to scale, and the quantities of the design."""
    aircraft = subject.aircraft
    balance = subject.analysis.balance
    drawing = aircraft_drawing(aircraft)
    points = {}
    if balance is not None:
        points = {"gravity_m": balance.gravity_m, "neutral_m": float(balance.neutral_point.x_m)}
    views = page_figure(
        plot_three_view(drawing, **points, figure=page_options(_WIDTH_IN)),
        f"Three views to scale. {' '.join(drawing.notes)}",
        title=f"Three views of {aircraft.name}",
        description=description(drawing, **points),
        key="views",
    )
    blocks: list[Block] = []
    if aircraft.description:
        blocks.append(Text(aircraft.description))
    blocks.append(views)
    if subject.verification is None:
        required_h = max(subject.mission.required_excess_time_h, 0.0)
        margins = requirement_margins(aircraft, subject.analysis.performance, required_h)
        blocks.append(Tables(tuple(_design_tables(subject))))
        blocks.append(Tables((requirement_table(margins),)))
    return Section("aircraft", "The aircraft", blocks)


def _design_tables(subject: Subject) -> Iterator[Any]:
    aircraft, analysis = subject.aircraft, subject.analysis
    design = analysis.performance.design
    modules, mission = aircraft.modules, subject.mission
    flown = DesignInFlight(aircraft, design)
    yield facts(
        "geometry and mass",
        [
            *(_fact(one, design) for one in (q.WINGSPAN, q.ASPECT_RATIO, q.WING_AREA)),
            _fact(q.CHORD, flown),
            _fact(q.MODULE_AREA, design),
            ("modules over wing area", f"{100.0 * modules.area_m2 / design.wing_area_m2:.0f} %"),
            _fact(q.TOTAL_MASS, design),
            _fact(q.WING_LOADING, flown),
        ],
    )
    modelled = isinstance(aircraft.airframe, ParametricAirframe)
    speed_known = design.airspeed_m_per_s is not None  # a measured power may be all there is
    yield facts(
        "level flight",
        [
            ("altitude", f"{mission.altitude_m:g} m"),
            *([_fact(q.AIRSPEED, design)] if speed_known else []),
            _fact(q.AIR_DENSITY, flown),
            *([_fact(q.REYNOLDS_NUMBER, flown)] if speed_known else []),
            *(_fact(one, flown) for one in q.MODELLED_FLIGHT if modelled),
            *([*wind_rows(mission), _HELD] if mission.holds_station else []),
        ],
    )
    share = 100.0 * aircraft.battery.mass_kg / design.total_mass_kg
    yield facts(
        "power and energy",
        [
            ("propulsion power", _fact(q.PROPULSION_POWER, design)[1]),
            q.LOAD.fact(analysis.power_out_w),
            _fact(q.BATTERY_ENERGY, design),
            ("specific energy", f"{aircraft.battery.specific_energy_wh_per_kg:g} Wh/kg"),
            ("battery over total mass", f"{share:.0f} %"),
            ("module efficiency", f"{100.0 * modules.efficiency_stc:.1f} %"),
            q.SOLAR_ENERGY.fact(analysis.solar_energy_wh),
        ],
    )


def _fact(quantity: q.Quantity, of: Design | DesignInFlight) -> tuple[str, str]:
    return quantity.fact(quantity.of(of))


# ---- Masses and power


def budget_section(subject: Subject) -> Section:
    """Where mass and power go."""
    design, used = subject.analysis.performance.design, subject.analysis.power_budget
    assert used is not None  # an analysis has a design
    masses = Bars("mass budget", "kg", ".3f", _mass_rows(subject.aircraft, design), "total mass")
    power = Bars(
        "load in level flight", "W", ".2f", power_rows(used), "load", note=power_note(used),
    )  # fmt: skip
    shares, balance = subject.analysis.drag_coefficients, subject.analysis.balance
    parts = [] if shares is None else [drag_table(shares)]
    parts += [] if balance is None else [balance_table(balance)]
    told = [] if balance is None else [Text(text) for text in balance_lines(balance)]
    analysis = subject.analysis
    steps = loss_chain(analysis)
    energy = Bars(
        f"from the sun to the load: energy of the day, "
        f"{analysis.performance.day.scenarios.label(analysis.worst)}",
        "Wh",
        ".0f",
        tuple((step.label, step.energy_wh) for step in steps),
        sums=frozenset(step.label for step in steps if step.is_sum),
    )
    blocks: list[Block] = [masses, power, energy]
    if parts:
        blocks.append(Tables(tuple(parts)))
    return Section("budgets", "Mass, power and energy", [*blocks, *told])


def _mass_rows(aircraft: Aircraft, design: Design) -> tuple[tuple[str, float], ...]:
    measured = not isinstance(aircraft.airframe, ParametricAirframe)
    names = {"mppt": "MPPT"}
    if measured:
        names["other"] = "airframe, propulsion and avionics (measured)"
    return tuple(
        (names.get(name, name), float(mass))
        for name, mass in design.masses._asdict().items()
        if float(mass) > 0.0
    )


# ---- Sizing


def sizing_section(sizing: Mapping[str, Any]) -> Section:
    """What was optimised, what limits it, how sensitive it is, and whether it was cross-checked."""
    objective = Objective(sizing["objective"]["name"])
    value, required = sizing["objective"]["value"], sizing["objective"]["required_excess_time_h"]
    sought = "largest" if objective.maximised else "smallest"
    told = f"Sized for the {sought} {objective.label}: {with_unit(value, '.4g', objective)}"
    if required:
        told += f", with {required:g} h of excess time required in every scenario"
    blocks: list[Block] = [Text(f"{told} ({sizing['status'].replace('_', ' ')}).")]
    active = sizing["active_constraints"]
    if active:
        words = "; ".join(str(constraint_words(name)) for name in active)
        blocks.append(Text(f"Limited by (most important first): {words}."))
    cells = sizing.get("whole_cells")
    if cells is not None:
        for line in (loss_line(cells, objective), *cells_lines(cells)):
            blocks.append(sentence(line))
    if sizing.get("structure") is not None:
        structure = sizing["structure"]
        for text in (structure["text"], *structure["remarks"]):
            blocks.append(sentence(text))
    if sizing.get("reliability") is not None:
        found = sizing["reliability"]
        achieved = f"{100.0 * found['achieved']:.1f} % of {found['samples']} draws"
        text = f"Reliability: {achieved}; required {100.0 * found['required']:g} %."
        blocks.append(Text(text))
    tables = []
    if cells is not None:
        tables.append(neighbour_table(cells, objective))
    guarded = sizing.get("with_margin")
    if guarded is not None and guarded["status"] == "optimal":
        solar = SolarModel(sizing["model"], sizing["correction"])
        tables.append(margin_table(objective, solar, sizing, guarded))
    if sizing.get("constraint_multipliers"):
        multipliers = [ConstraintMultiplier(**one) for one in sizing["constraint_multipliers"]]
        tables.append(multiplier_table(multipliers, objective))
    if sizing.get("sensitivities"):
        fields = Sensitivity.__dataclass_fields__
        known = [Sensitivity(**{f: one[f] for f in fields}) for one in sizing["sensitivities"]]
        tables.append(sensitivity_table(known, objective))
    blocks += [Tables((table,)) for table in tables]
    if sizing.get("sensitivities") is None and not objective.of_range:
        blocks.append(Text("The sensitivities were not computed.", "faint"))
    check = sizing.get("cross_check")
    if check is not None:
        values: dict[str, Any] = {k: float("nan") if v is None else v for k, v in check.items()}
        found = CrossCheck(**values)
        looks = "good" if found.cross_checked else "warning"
        blocks.append(sentence(cross_check_line(found, objective), looks))
    elif not objective.of_range:
        blocks.append(Text("The optimum was not cross-checked.", "faint"))
    if sizing.get("builds"):
        blocks.append(Tables((build_table(sizing["builds"], objective),)))
    return Section("sizing", "Sizing", blocks)
