"""Figure of a flight envelope: the V-n diagram."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sizing.results.analysis import Analysis
from studies.output.figures.drawing import CHARGE, LOAD, SUN, Canvas, ink, new_figure, styled
from studies.output.figures.options import DEFAULT

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@styled
def plot_flight_envelope(analysis: Analysis, *, figure: Canvas = DEFAULT) -> Figure:
    """V-n diagram: manoeuvres, gusts, and the limit loads that the structure is sized for.

    Parameters
    ----------
    analysis : Analysis
        Of an aircraft with a ``rib_wing``.
    figure : FigureOptions or Figure
        How the figure looks, or one that is drawn on.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        For another structure: its loads are not known.
    """
    structure = analysis.structure
    if structure is None or structure.envelope is None:
        raise ValueError(f"{analysis.aircraft.name} has no rib_wing: its loads are not known")
    one = structure.envelope
    drawn, (axes,) = new_figure(
        canvas=figure,
        title=f"{analysis.aircraft.name}: flight envelope",
        notes=(f"{float(analysis.performance.design.total_mass_kg):.2f} kg", "CS 23.333"),
        size_in=(7.0, 4.6),
    )
    airspeed = np.linspace(0.0, one.dive_speed_m_per_s, 400)
    up, down = one.manoeuvre(airspeed)
    axes.fill_between(airspeed, down, up, color=CHARGE, alpha=0.15, linewidth=0)
    outline = np.concatenate([up, down[::-1]])
    axes.plot(np.concatenate([airspeed, airspeed[::-1]]), outline, color=CHARGE, label="manoeuvres")
    for number, sign in enumerate((1.0, -1.0)):
        ends = [(0.0, 1.0), *((v, 1.0 + sign * dn) for v, dn in one.gusts)]
        for speed, factor in ends[1:]:
            axes.plot((0.0, speed), (1.0, factor), ":", color=SUN, linewidth=1.0)
        label = "gusts at cruise and dive speed" if not number else ""
        axes.plot(*np.transpose(ends[1:]), "o--", color=SUN, markersize=4, label=label)
    for number, limit in enumerate((one.limit_load_factor, -one.negative_limit_load_factor)):
        label = "limit loads of the structure" if not number else ""
        axes.axhline(limit, color=LOAD, linestyle="-.", linewidth=1.2, label=label)
    axes.axhline(0.0, color=ink(), linewidth=0.8)
    axes.axhline(1.0, color=ink(), linewidth=0.5, linestyle=":")
    for name, speed in (
        ("$V_S$", one.stall_speed_m_per_s),
        ("$V_C$", one.cruise_speed_m_per_s),
        ("$V_D$", one.dive_speed_m_per_s),
    ):
        axes.axvline(speed, color=ink(), linewidth=0.5, linestyle=":")
        axes.annotate(
            f"{name} {speed:.1f}",
            (speed, 0.0),
            (0, 3),
            textcoords="offset points",
            ha="center",
            fontsize="small",
        )
    axes.set(
        xlim=(0.0, 1.1 * one.dive_speed_m_per_s),
        xlabel="equivalent airspeed [m/s]",
        ylabel="load factor [-]",
    )
    axes.legend(loc="upper left")
    return drawn
