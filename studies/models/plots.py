"""Figure of a comparison of models: what each predicts, and what each would have built."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from missions.dates import MONTH_NAMES
from sizing.optimisation.objectives import Objective
from studies.maps.season import Season
from studies.models.comparison import Case, Comparison
from studies.models.solar_models import model_label

# Okabe & Ito's palette, and a marker for each so that print in grey is read as well.
_LOOKS = {
    "none": ("#D55E00", "o", "uncorrected"),
    "report": ("#0072B2", "s", "corrected by its error in flight"),
    "loiter": ("#009E73", "D", "corrected for the loiter"),
}
_MONTH_STARTS = np.cumsum([0, 31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30]) + 1


def comparison_figure(comparison: Comparison) -> Figure:
    """Income, excess time and season by every case, and the designs where there are any."""
    with_designs = any(case.built is not None for case in comparison.cases)
    panels = 4 if with_designs else 3
    rows = len(comparison.cases)
    height = 1.9 + 0.27 * rows
    figure = Figure(figsize=(2.9 * panels, height), layout="constrained")
    all_axes = figure.subplots(1, panels, sharey=True)
    position = _positions(comparison.cases)
    _draw_income(all_axes[0], comparison, position)
    _draw_excess(all_axes[1], comparison, position)
    _draw_season(all_axes[2], comparison, position)
    if with_designs:
        _draw_designs(all_axes[3], comparison, position)
    for axes in all_axes:
        axes.grid(alpha=0.3, axis="x")
        axes.set_axisbelow(True)
        axes.tick_params(axis="y", length=0)
        axes.spines[["top", "right", "left"]].set_visible(False)
    all_axes[0].set_ylim(position.max() + 0.7, -0.7)
    all_axes[0].set_yticks(position, [c.solar.model for c in comparison.cases])
    figure.legend(
        handles=_legend(comparison, with_designs),
        loc="outside lower center",
        ncols=5,
        fontsize="small",
        frameon=False,
    )
    title = f"{comparison.aircraft.name} on {comparison.mission.name}"
    figure.suptitle(title, parse_math=False)
    return figure


def _positions(cases: tuple[Case, ...]) -> Any:
    """Heights of the rows, with a gap between models."""
    models = [case.solar.model for case in cases]
    changes = np.cumsum([0, *(a != b for a, b in itertools.pairwise(models))])
    return np.arange(len(cases)) + 0.5 * changes


def _legend(comparison: Comparison, with_designs: bool) -> list[Line2D]:
    shown = dict.fromkeys(case.solar.correction for case in comparison.cases)
    handles = [
        Line2D([], [], color=_LOOKS[c][0], marker=_LOOKS[c][1], linestyle="", label=_LOOKS[c][2])
        for c in shown
    ]
    truth = model_label(comparison.reference.solar)
    handles.append(Line2D([], [], color="black", linestyle=":", label=f"{truth} (reference)"))
    if with_designs:
        handles.append(
            Line2D(
                [],
                [],
                color="black",
                marker="x",
                linestyle="",
                label=f"comes down, judged by {truth}",
            )
        )
    return handles


def _draw_income(axes: Axes, comparison: Comparison, position: Any) -> None:
    truth = comparison.reference.prediction.mean_solar_energy_wh
    for y, case in zip(position, comparison.cases, strict=True):
        income = case.prediction.mean_solar_energy_wh
        colour, marker, _ = _LOOKS[case.solar.correction]
        band = income * case.solar.rms_relative
        axes.errorbar(income, y, xerr=band, color=colour, marker=marker, capsize=2, linewidth=1)
    axes.axvline(truth, color="black", linestyle=":", linewidth=1)
    axes.set_xlabel("solar energy of a day [Wh]\n(bars: RMS error of the model)")


def _note(axes: Axes, y: float, text: str, colour: str) -> None:
    """Words in place of a number that a case does not have."""
    axes.annotate(
        text,
        (0.02, y),
        xycoords=("axes fraction", "data"),
        va="center",
        fontsize="small",
        color=colour,
    )


def _draw_excess(axes: Axes, comparison: Comparison, position: Any) -> None:
    for y, case in zip(position, comparison.cases, strict=True):
        p = case.prediction
        colour, marker, _ = _LOOKS[case.solar.correction]
        if not np.isfinite(p.excess_time_h):
            _note(axes, y, "no night", colour)
            continue
        # The band may reach over the cliff at zero, or to where there is no end.
        ends = [
            v if np.isfinite(v) else p.excess_time_h
            for v in (p.excess_time_low_h, p.excess_time_high_h)
        ]
        axes.plot(ends, [y, y], color=colour, linewidth=1)
        axes.plot([p.excess_time_h], [y], color=colour, marker=marker)
    truth = comparison.reference.prediction.excess_time_h
    if np.isfinite(truth):
        axes.axvline(truth, color="black", linestyle=":", linewidth=1)
    low, high = axes.get_xlim()
    if low < 0.0 < high:
        axes.axvline(0.0, color="black", linewidth=0.8)
    axes.set_xlabel("excess time, worst scenario [h]\n(lines: RMS error of the model)")


def _draw_season(axes: Axes, comparison: Comparison, position: Any) -> None:
    for y, case in zip(position, comparison.cases, strict=True):
        colour = _LOOKS[case.solar.correction][0]
        season = case.season
        for first, last in spans(season):
            axes.barh(y, last - first + 1, left=first, height=0.6, color=colour, linewidth=0)
        days = "none" if season.days == 0 else f"{season.days} d"
        middle = 183
        shown = any(first <= middle <= last for first, last in spans(season))
        axes.annotate(
            days,
            (middle, y),
            ha="center",
            va="center",
            fontsize="small",
            color="white" if shown else "black",
        )
    axes.set_xticks(_MONTH_STARTS[::2], MONTH_NAMES[::2], ha="left")
    axes.set_xlim(1, 366)
    axes.set_xlabel("perpetual season around the\nsummer solstice (days in the year)")


def spans(season: Season) -> list[tuple[int, int]]:
    """Window of a season as spans of days that do not cross the year's end."""
    if season.first is None or season.last is None:
        return []
    if season.first <= season.last:
        return [(season.first, season.last)]
    return [(1, season.last), (season.first, 365)]


def _draw_designs(axes: Axes, comparison: Comparison, position: Any) -> None:
    for y, case in zip(position, comparison.cases, strict=True):
        if case.built is None:
            continue
        colour, marker, _ = _LOOKS[case.solar.correction]
        value = _objective_value(case, comparison)
        if value is None or case.built.judged is None:
            _note(axes, y, "no design", colour)
            continue
        axes.plot([value], [y], color=colour, marker=marker)
        judged = case.built.judged
        if not judged.perpetual:
            axes.plot([value], [y], color="black", marker="x", markersize=9)
    truth = _objective_value(comparison.reference, comparison)
    if truth is not None:
        axes.axvline(truth, color="black", linestyle=":", linewidth=1)
    axes.margins(x=0.15)
    required = comparison.required_excess_time_h
    objective = comparison.objective
    promised = "promised " if objective is Objective.max_excess_time else ""
    label = f"{promised}{objective.label} [{objective.unit}]"
    axes.set_xlabel(f"design: {label},\n{required:g} h of excess time required")


def _objective_value(case: Case, comparison: Comparison) -> float | None:
    """What the sizing arrived at, none without a design or where it has no end."""
    if case.built is None or case.built.sizing.objective_value is None:
        return None
    value = float(case.built.sizing.objective_value)
    return value if np.isfinite(value) else None
