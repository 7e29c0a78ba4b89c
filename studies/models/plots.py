"""Figure of a comparison of models: what each predicts, and what each would have built."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from missions.dates import MONTH_NAMES, MONTH_STARTS
from sizing.program.objectives import Objective
from solar.schema import spell
from studies.maps.season import Season
from studies.models.comparison import Comparison
from studies.models.prediction import Case
from studies.models.solar_models import model_label
from studies.output.figures import drawing
from studies.output.figures.options import DEFAULT, library
from studies.render.words import extrapolation_caption

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

# A marker for each colour, so that print in grey is read as well.
_LOOKS = {
    "none": (drawing.VERMILLION, "o", "uncorrected"),
    "report": (drawing.BLUE, "s", "corrected by its error in flight"),
    "loiter": (drawing.GREEN, "D", "corrected for the loiter"),
}

_ROOM_DAYS = 110  # length of a season's bar that holds its text


@drawing.styled
def plot_comparison(comparison: Comparison, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw solar energy, excess time and season of every case, and designs if any.

    Parameters
    ----------
    comparison : Comparison
    """
    columns = 4 if comparison.has_designs else 3
    size_in = (2.9 * columns, 1.9 + 0.27 * len(comparison.cases))
    across = 2 if drawing.is_narrow(figure, size_in) and columns > 1 else columns
    rows = -(-columns // across)
    drawn, panels = drawing.new_figure(
        rows,
        across,
        canvas=figure,
        title=f"{comparison.aircraft.name} on {comparison.mission.name}",
        notes=(
            "solar power models compared",
            comparison.mission.climb_label,
            extrapolation_caption(comparison.extrapolations),
        ),
        size_in=(2.9 * across, size_in[1] * rows),
        lines=True,
        grid="x",
        sharey=True,
    )
    for spare in panels[columns:]:
        spare.remove()
    panels = panels[:columns]
    models = [case.solar.model for case in comparison.cases]
    gaps = np.cumsum([0, *(a != b for a, b in itertools.pairwise(models))])
    heights = np.arange(len(models)) + 0.5 * gaps
    for case, y in zip(comparison.cases, heights, strict=True):
        for axes, draw in zip(panels, _PANELS, strict=False):
            draw(axes, comparison, case, y)
    reference = comparison.reference
    truths = (
        reference.prediction.mean_solar_energy_wh,
        reference.prediction.excess_time_h,
        None,
        _objective_value(reference, comparison),
    )
    required, objective = comparison.required_excess_time_h, comparison.objective
    promised = "promised " if objective is Objective.max_excess_time else ""
    labels = (
        "solar energy\nof a day [Wh]\n(bars: RMS error)",
        "excess time [h],\nworst scenario\n(lines: RMS error)",
        "perpetual season\naround the summer\nsolstice [d]",
        f"design: {promised}{objective.label} [{objective.unit}],\n"
        f"{spell(required)} h of excess time required",
    )
    for axes, label, truth in zip(panels, labels, truths, strict=False):
        if truth is not None and np.isfinite(truth):
            axes.axvline(truth, color=drawing.ink(), linestyle=":", linewidth=1)
        axes.set_xlabel(label)
        axes.tick_params(axis="y", length=0)
        axes.spines[["top", "right", "left"]].set_visible(False)
    low, high = panels[1].get_xlim()
    if low < 0.0 < high:
        panels[1].axvline(0.0, color=drawing.ink(), linewidth=0.8)
    panels[2].set_xticks(MONTH_STARTS[::3], MONTH_NAMES[::3], ha="left")
    panels[2].set_xlim(1, 366)
    if comparison.has_designs:
        panels[-1].margins(x=0.15)
    panels[0].set_ylim(heights.max() + 0.7, -0.7)
    panels[0].set_yticks(heights, [c.solar.label for c in comparison.cases])
    drawing.add_legend(drawn, _legend(comparison), 5, frameon=False)
    return drawn


def _legend(comparison: Comparison) -> list[Line2D]:
    truth = model_label(comparison.reference.solar)
    shown = dict.fromkeys(case.solar.correction for case in comparison.cases)
    entries: list[tuple[str, str, str, str]] = [
        (words, colour, marker, "") for colour, marker, words in (_LOOKS[c] for c in shown)
    ]
    entries.append((f"{truth} (reference)", drawing.ink(), "", ":"))
    if comparison.has_designs:
        entries.append((f"limited, evaluated by {truth}", drawing.ink(), "x", ""))
    line = library().lines.Line2D
    return [line([], [], label=n, color=c, marker=m, linestyle=ls) for n, c, m, ls in entries]


def _draw_solar_energy(axes: Axes, _: Comparison, case: Case, y: float) -> None:
    energy = case.prediction.mean_solar_energy_wh
    colour, marker, _name = _LOOKS[case.solar.correction]
    error = energy * case.solar.rms_relative
    axes.errorbar(energy, y, xerr=error, color=colour, marker=marker, capsize=2, linewidth=1)


def _draw_excess(axes: Axes, _: Comparison, case: Case, y: float) -> None:
    p, (colour, marker, _name) = case.prediction, _LOOKS[case.solar.correction]
    if not np.isfinite(p.excess_time_h):
        drawing.note(axes, "no night", (0.02, y), across=True, va="center", color=colour)
        return
    # One end may lie beyond the discontinuity at zero, or where excess time is unlimited.
    ends = (p.excess_time_low_h, p.excess_time_high_h)
    shown = [end if np.isfinite(end) else p.excess_time_h for end in ends]
    axes.plot(shown, [y, y], color=colour, linewidth=1)
    axes.plot([p.excess_time_h], [y], color=colour, marker=marker)


def _draw_season(axes: Axes, _: Comparison, case: Case, y: float) -> None:
    colour, parts = _LOOKS[case.solar.correction][0], spans(case.season)
    for first, last in parts:
        axes.barh(y, last - first + 1, left=first, height=0.6, color=colour, linewidth=0)
    longest = max(parts, key=lambda part: part[1] - part[0], default=(183, 183))
    within = longest[1] - longest[0] >= _ROOM_DAYS
    drawing.note(
        axes,
        "none" if case.season.days == 0 else f"{case.season.days} d",
        (sum(longest) / 2.0 if within else longest[1], y),
        (0, 0) if within else (4, 0),
        ha="center" if within else "left",
        va="center",
        color="white" if within else drawing.ink(),
    )


def spans(season: Season) -> list[tuple[int, int]]:
    """Return a season's window as spans of days that do not cross the year's end."""
    if season.first is None or season.last is None:
        return []
    if season.first <= season.last:
        return [(season.first, season.last)]
    return [(1, season.last), (season.first, 365)]


def _draw_design(axes: Axes, comparison: Comparison, case: Case, y: float) -> None:
    if case.built is None:
        return
    colour, marker, _name = _LOOKS[case.solar.correction]
    value = _objective_value(case, comparison)
    if value is None or case.built.judged is None:
        drawing.note(axes, "no design", (0.02, y), across=True, va="center", color=colour)
        return
    axes.plot([value], [y], color=colour, marker=marker)
    if not case.built.judged.perpetual:
        axes.plot([value], [y], color=drawing.ink(), marker="x", markersize=9)


_PANELS = (_draw_solar_energy, _draw_excess, _draw_season, _draw_design)


def _objective_value(case: Case, comparison: Comparison) -> float | None:
    """Return the objective's value, None without a design or if unlimited."""
    value = None if case.built is None else case.built.value(comparison.objective)
    return value if value is not None and np.isfinite(value) else None
