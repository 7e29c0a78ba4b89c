"""Files of a sizing: the sized aircraft, the mission that it flies, tables and figures."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_code
from missions.mission.mission import MAXIMUM_SCENARIOS
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel
from sizing.parameters import label, unit_text
from sizing.program.objectives import Objective
from sizing.results.analysis import Analysis, analyse
from sizing.results.design_result import cells_record
from sizing.results.result import data_frame
from sizing.results.sizing_study import SizingStudy
from sizing.structures.rib_wing import RibWingStructure
from sizing.validity.ranges import Extrapolation
from solar.schema import spell
from studies.output.cycle_plots import plot_cycle
from studies.output.figures import drawing
from studies.output.figures.options import DEFAULT, FigureOptions
from studies.output.formats import csv_bytes
from studies.output.run_folder import RunInputs
from studies.quantities import words
from studies.render.analysis import cells_line
from studies.render.words import extrapolation_caption
from studies.serialise import serialise

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sizing.program.sensitivity import Sensitivity

# Keys of a mission that play no part in a weather record.
_NOT_OF_A_RECORD = ("launch", "clearness", "required_excess_time_h")
_MOST_BARS = 15
_WIDTH_IN, _AROUND_IN = 9.0, 1.3  # of the figure, and what title and axis take of its height


def sized_inputs(study: SizingStudy, inputs: RunInputs) -> RunInputs:
    """Return the sized aircraft, and the mission that it was sized for, as files.

    Analysed, they give the excess time of the sizing: the mission has the payload that the optimum
    carries, the range of days or latitudes that it covers, and the site of a weather record.
    """
    mission: dict[str, Any] = copy.deepcopy(dict(inputs.mission))
    coverage = study.coverage
    if coverage is not None and coverage.first is not None and coverage.last is not None:
        first, last, count = coverage.first, coverage.last, len(coverage.members)
        if coverage.sizing.objective is Objective.longest_season:
            assert coverage.sizing.simulated is not None
            latitudes = len(coverage.sizing.simulated.day.scenarios) // count
            ends = {"from": date_code(int(first)), "to": date_code(int(last))}
            most = min(count, MAXIMUM_SCENARIOS // latitudes)
            mission["dates"] = {"on": ends["from"]} if count == 1 else {**ends, "count": most}
        else:
            mission.pop("launch", None)  # a flight has a single latitude
            across = {"from_deg": first, "to_deg": last, "count": min(count, 181)}
            mission["latitude_deg"] = first if count == 1 else across
    if study.survival is not None:
        site = study.survival.weather.site
        mission = {key: mission[key] for key in mission if key not in _NOT_OF_A_RECORD}
        mission |= {"latitude_deg": site.latitude_deg, "longitude_deg": site.longitude_deg}
    carried = study.sized_mission().payload
    if carried != study.mission.payload:
        mission["payload"] = carried.model_dump()
    aircraft = study.sized_aircraft().model_dump(mode="json", exclude_unset=True)
    return dataclasses.replace(inputs, aircraft=aircraft, mission=mission)


def sizing_tables(study: SizingStudy) -> dict[str, bytes]:
    """Return the tables of an optimum by the names of their files."""
    tables = {"scenarios": study.scenarios(), "masses": study.masses()}
    if study.sensitivities:
        tables["sensitivities"] = data_frame(serialise(study.sensitivities))
    return {f"{name}.csv": csv_bytes(table) for name, table in tables.items()}


def sizing_figures(
    study: SizingStudy, figure: FigureOptions = DEFAULT
) -> dict[str, Callable[[], Figure]]:
    """Return functions that draw an optimum, by the names of their files.

    Sensitivities, where there are any, come as a tornado plot, whole cells on their wing.
    """
    result, sensitivities, solar = study.result, study.sensitivities, study.solar
    assert result.design is not None
    masses, sized = result.design.masses._asdict(), study.sized_aircraft()
    mission, outside = study.sized_mission(), study.extrapolations

    @cache
    def analysis() -> Analysis:
        return analyse(sized, mission, **vars(solar), replay=False)

    title, notes = f"{sized.name}: mass budget", (extrapolation_caption(outside),)
    drawings: dict[str, Callable[[], Figure]] = {
        "cycle.png": lambda: plot_cycle(analysis(), figure=figure),
        "masses.png": lambda: plot_masses(masses, title, notes=notes, figure=figure),
    }
    if isinstance(getattr(sized.airframe, "structure", None), RibWingStructure):
        drawings["flight-envelope.png"] = lambda: plot_flight_envelope(analysis(), figure=figure)
    if sized.modules.layout is not None:
        drawings["cells.png"] = lambda: plot_cells(sized, figure=figure)
    if sensitivities:
        drawings["sensitivities.png"] = lambda: plot_sensitivities(
            sensitivities, result.objective, sized.name, solar, extrapolations=outside,
            figure=figure,
        )  # fmt: skip
    return drawings


# ---- Figures of a design


@drawing.styled
def plot_sensitivities(
    sensitivities: list[Sensitivity],
    objective: Objective,
    name: str,
    solar: SolarModel,
    *,
    extrapolations: Sequence[Extrapolation] = (),
    figure: drawing.Canvas = DEFAULT,
) -> Figure:
    """Draw the change of the objective by one per cent more of each parameter.

    Parameters
    ----------
    sensitivities : list of Sensitivity
        Most important first, as they are drawn from the top; at most 15.
    objective : Objective
        Quantity that changes, and its unit.
    name : str
        Aircraft, for the title.
    solar : SolarModel
        Model and correction, for the title.
    extrapolations : sequence of Extrapolation
        What lies outside the range of a model.
    """
    shown = [s for s in sensitivities if s.value != 0.0][:_MOST_BARS][::-1]
    drawn, (axes,) = drawing.new_figure(
        canvas=figure,
        title=f"{name}: what one per cent more changes",
        notes=(solar.label, extrapolation_caption(extrapolations)),
        size_in=(9.0, 1.2 + 0.32 * len(shown)),
        lines=True,
        grid="x",
    )
    numbers = [f"{spell(s.value, 4)} {unit_text(s.unit)}".rstrip() for s in shown]
    labels = [f"{label(s.parameter)} = {n}" for s, n in zip(shown, numbers, strict=True)]
    changes = np.array([s.per_percent for s in shown])
    better = changes > 0.0 if objective.maximised else changes < 0.0
    looks: dict[str, Any] = {"edgecolor": "white", "linewidth": 0.0}
    axes.barh(labels, np.where(better, changes, 0.0), color=drawing.CHARGE, label="better", **looks)
    worse = np.where(better, 0.0, changes)
    axes.barh(labels, worse, color=drawing.SUN, label="worse", hatch="//", **looks)
    axes.axvline(0.0, color=drawing.ink(), linewidth=0.8)
    axes.set(xlabel=f"change of the {objective.label} for +1 % [{unit_text(objective.unit)}]")
    drawing.add_legend(drawn, axes.get_legend_handles_labels()[0], 2, side="right")
    return drawn


@drawing.styled
def plot_masses(
    masses_kg: dict[str, float],
    title: str,
    *,
    notes: Sequence[str] = (),
    figure: drawing.Canvas = DEFAULT,
) -> Figure:
    """Draw the mass budget as horizontal bars, heaviest on top.

    Parameters
    ----------
    masses_kg : dict
        Mass of each part [kg]; parts without mass are left out.
    title : str
        Name of the aircraft.
    notes : sequence of str
        Line below the title.
    """
    kg = sorted(((mass, words(name)) for name, mass in masses_kg.items() if mass > 0.0))
    drawn, (axes,) = drawing.new_figure(
        canvas=figure, title=title, notes=notes, size_in=(7.0, 3.6), lines=True, grid=""
    )
    bars = axes.barh([name for _, name in kg], [mass for mass, _ in kg], color=drawing.LOAD)
    axes.bar_label(bars, fmt="%.2f kg", padding=3)
    axes.set(xlabel="mass [kg]")
    axes.margins(x=0.2)
    return drawn


@drawing.styled
def plot_flight_envelope(analysis: Analysis, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw the V-n diagram: manoeuvres, gusts and limit loads of the structure.

    Parameters
    ----------
    analysis : Analysis
        Of an aircraft with a ``rib_wing``.

    Raises
    ------
    ValueError
        For another structure: its loads are not known.
    """
    structure = analysis.structure
    if structure is None or structure.flight_envelope is None:
        raise ValueError(f"{analysis.aircraft.name} has no rib_wing: its loads are not known")
    envelope = structure.flight_envelope
    drawn, (axes,) = drawing.new_figure(
        canvas=figure,
        title=f"{analysis.aircraft.name}: flight envelope",
        notes=(f"{float(analysis.performance.design.total_mass_kg):.2f} kg", "CS 23.333"),
        size_in=(7.0, 4.6),
    )
    airspeed = np.linspace(0.0, envelope.dive_speed_m_per_s, 400)
    up, down = envelope.manoeuvre(airspeed)
    axes.fill_between(airspeed, down, up, color=drawing.CHARGE, alpha=0.15, linewidth=0)
    around = np.stack([np.append(airspeed, airspeed[::-1]), np.append(up, down[::-1])])
    axes.plot(*around, color=drawing.CHARGE, label="manoeuvres")
    speeds, gusts = np.transpose(envelope.gusts)
    for sign, name in ((1.0, "gusts at cruise and dive speed"), (-1.0, "")):
        factors = 1.0 + sign * gusts
        level = [0.0 * speeds + 1.0, factors]
        axes.plot([0.0 * speeds, speeds], level, ":", color=drawing.SUN, linewidth=1.0)
        axes.plot(speeds, factors, "o--", color=drawing.SUN, markersize=4, label=name)
    limits = (envelope.limit_load_factor, -envelope.negative_limit_load_factor)
    for limit, name in zip(limits, ("limit loads of the structure", ""), strict=True):
        axes.axhline(limit, color=drawing.LOAD, linestyle="-.", linewidth=1.2, label=name)
    axes.axhline(0.0, color=drawing.ink(), linewidth=0.8)
    axes.axhline(1.0, color=drawing.ink(), linewidth=0.5, linestyle=":")
    for name, speed in (
        ("$V_S$", envelope.stall_speed_m_per_s),
        ("$V_C$", envelope.cruise_speed_m_per_s),
        ("$V_D$", envelope.dive_speed_m_per_s),
    ):
        axes.axvline(speed, color=drawing.ink(), linewidth=0.5, linestyle=":")
        drawing.note(axes, f"{name} {speed:.1f}", (speed, 0.0), (0, 3), ha="center")
    axes.set(
        xlim=(0.0, 1.1 * envelope.dive_speed_m_per_s),
        xlabel="equivalent airspeed [m/s]",
        ylabel="load factor [-]",
    )
    drawing.add_legend(drawn, axes.get_legend_handles_labels()[0], 3)
    return drawn


@drawing.styled
def plot_cells(aircraft: Aircraft, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw the wing, and a tail with cells, from above with all cells and keep-outs."""
    from matplotlib.patches import Polygon
    from matplotlib.ticker import MaxNLocator

    layout, wing, tail = aircraft.modules.layout, aircraft.wing, aircraft.modules.tail
    if layout is None:
        raise ValueError(f"{aircraft.name} has no modules.layout")
    edges, aft_m = layout.outline(wing), wing.chord_m
    shapes = [[(y, front) for y, front, _ in edges] + [(y, rear) for y, _, rear in edges[::-1]]]
    if tail is not None and layout.tail_cells:
        half, aft_m = tail.horizontal_span_m / 2.0, tail.horizontal_aft_m + tail.horizontal_chord_m
        shapes.append(drawing.box(-half, half, tail.horizontal_aft_m, aft_m))
    drawn, (axes,) = drawing.new_figure(
        canvas=figure,
        title=f"{aircraft.name}: solar cells",
        notes=[cells_line(cells_record(aircraft)["solar_cells"])],
        size_in=(_WIDTH_IN, _AROUND_IN + _WIDTH_IN * aft_m / wing.wingspan_m),
        grid="",
    )
    kept_out = [
        [(side * y, x) for y, x in corners]
        for corners in layout.kept_out_corners(wing)
        for side in (-1.0, 1.0)
    ]
    cells = [drawing.box(c.left_m, c.right_m, c.front_m, c.rear_m) for c in aircraft.placed_cells()]
    for outlines, face, edge, style in (
        (shapes, drawing.GREY, drawing.ink(), {"linewidth": 0.8, "alpha": 0.5}),
        (kept_out, "none", drawing.DARK_GREY, {"linewidth": 0.6, "hatch": "////"}),
        (cells, drawing.LOAD, "white", {"linewidth": 0.3}),
    ):
        for corners in outlines:
            axes.add_patch(Polygon(corners, facecolor=face, edgecolor=edge, **style))
    axes.margins(0.01)
    axes.autoscale_view()
    axes.set(aspect="equal", xlabel="right of the middle [m]", ylabel="aft [m]")
    axes.invert_yaxis()
    axes.yaxis.set_major_locator(MaxNLocator(3))
    return drawn
