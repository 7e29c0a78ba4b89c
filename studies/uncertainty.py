"""Flights under uncertain inputs as people read them, and their figure: spread and causes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from sizing.results.result import percentiles
from sizing.results.uncertainty import UncertaintyAnalysis
from studies import quantities as q
from studies.output.figures import drawing
from studies.output.figures.options import DEFAULT
from studies.render.tables import ALL, Line, Table, facts
from studies.render.words import amount, extrapolation_blocks, percent, required

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_INPUTS = 8  # of the table of a summary
_MOST_BARS = 12
_LINES = {"p90": ":", "p50": "-", "p10": "--"}


def headline(analysis: UncertaintyAnalysis) -> str:
    """Return aircraft, mission and probability in one line."""
    return (
        f"{analysis.aircraft.name} on {analysis.mission.name}: perpetual flight in "
        f"{percent(analysis.probability_perpetual.value)} of {analysis.samples} draws"
    )


def blocks(analysis: UncertaintyAnalysis, level: int) -> list[Any]:
    """Return probabilities, spread, and what the excess time depends on."""
    mission, inputs = analysis.mission, analysis.inputs
    perpetual, sufficient, nominal = q.of_part("uncertainty")
    sufficient = replace(
        sufficient, label=f"probability of {required(analysis.required_h, analysis.mission)}"
    )
    probabilities = (perpetual, sufficient) if analysis.required_h > 0.0 else (perpetual,)
    rows = q.facts_of((*probabilities, nominal), analysis)
    if not analysis.lobes:
        rows += q.facts_of(q.of_part("scatter"), analysis)
    for name, chosen in analysis.lobes.items():  # perpetual and limited draws by themselves
        share = f"{name}, {percent(float(np.mean(chosen)))} of draws"
        varied = q.MINIMUM_CHARGE if name == "perpetual" else q.ENDURANCE
        for quantity, words in (
            (q.EXCESS_TIME, "excess time, P90, P50, P10"),
            (varied, varied.label),
        ):
            values = analysis.scattered()[quantity.name]
            within = percentiles(values[chosen[: len(values)]])
            rows.append((f"{share}: {words}", quantity.fact(within)[1]))
    climbs = f"; {mission.climb_label}" if mission.climb else ""
    text = (
        f"{analysis.solar.label}{climbs}; seed {analysis.seed}. P90 is exceeded in 90 % of draws."
    )
    if not inputs.independent:
        text += " Inputs are correlated: shares of the variance are not defined."
    return [
        Line(headline(analysis), "strong"),
        facts("", rows),
        input_table(analysis, _INPUTS if level < ALL else len(inputs)),
        *extrapolation_blocks(analysis.extrapolations, level),
        Line(text, "faint"),
    ]


def input_table(analysis: UncertaintyAnalysis, most: int) -> Table:
    """Return the inputs with their spread and their shares of the excess time's variance."""
    shares = {key: (index.first, index.total) for key, index in analysis.sobol.items()}
    nothing, spread = (math.nan, math.nan), q.TABLE["nominal"].text
    order = sorted(analysis.inputs.inputs, key=lambda row: -shares.get(row.key, (0.0, 0.0))[1])
    rows = []
    for row in order[:most]:
        low, high = map(spread, np.percentile(analysis.values[row.key], [10.0, 90.0]))
        alone, with_others = shares.get(row.key, nothing)
        rows.append((row.label, row.nominal, f"{low} to {high}", alone, with_others))
    left = len(order) - len(rows)
    return Table(
        "what the excess time depends on",
        q.group("input nominal spread share_alone share_with_others"),
        tuple(rows),
        (f"{left} more matter less; -v has all",) if left else (),
    )


# ---- Figure


@drawing.styled
def plot_uncertainty(analysis: UncertaintyAnalysis, *, figure: drawing.Canvas = DEFAULT) -> Figure:
    """Draw the distribution of the excess time, and the inputs that cause it.

    On the left a histogram of the draws with P90, P50 and P10; P90 is exceeded in 90 % of them. On
    the right a tornado: mean excess time from the lowest to the highest fifth of an input's draws,
    and the share of the variance that the input explains together with all others. The histogram
    alone for a single input.

    Parameters
    ----------
    analysis : UncertaintyAnalysis
    """
    count = min(len(analysis.inputs), _MOST_BARS)
    size_in = (10.0, max(3.6, 1.8 + 0.42 * count))
    narrow = drawing.is_narrow(figure, size_in)
    notes: tuple[str, ...] = (analysis.solar.label, analysis.mission.climb_label)
    single = count == 1
    if single:
        notes = (*notes, f"one input scatters: {analysis.inputs.inputs[0].label}")
        size_in = (7.0, 4.2)
    elif narrow:
        size_in = (size_in[0], 1.9 * size_in[1])
    beside = not (single or narrow)
    drawn, panels = drawing.new_figure(
        1 if beside or single else 2,
        2 if beside else 1,
        canvas=figure,
        title=analysis.headline(),
        notes=notes,
        size_in=size_in,
        lines=True,
        grid="both" if single else "x",
        width_ratios=(1.0, 1.15) if beside else (1.0,),
    )
    _draw_spread(panels[0], analysis)
    if not single:
        _draw_causes(panels[1], analysis)
    handles = [h for axes in panels for h in axes.get_legend_handles_labels()[0]]
    drawing.add_legend(drawn, handles, 4 if single else 6)
    return drawn


def _draw_spread(axes: Axes, analysis: UncertaintyAnalysis) -> None:
    excess = analysis.flights.excess_time_h
    finite = excess[np.isfinite(excess)]
    axes.set(xlabel=q.EXCESS_TIME.heading, ylabel="draws [%]")
    if not len(finite):
        axes.text(0.5, 0.5, "unlimited in all draws", transform=axes.transAxes, ha="center")
        return
    weights = np.full(len(finite), 100.0 / len(excess))
    axes.hist(finite, bins=60, weights=weights, color=drawing.BLUE, alpha=0.8)
    for style, label, value in _marked(analysis):
        if np.isfinite(value):
            words = f"{label} {amount(value, 'h', '.1f')}".replace("-", "−")
            axes.axvline(value, color=drawing.ink(), linestyle=style, linewidth=1.2, label=words)
    low, high = axes.get_xlim()
    if low < 0.0 < high:
        axes.axvspan(low, 0.0, color=drawing.VERMILLION, alpha=0.12, linewidth=0, label="limited")
    axes.set_xlim(low, high)


def _marked(analysis: UncertaintyAnalysis) -> Iterator[tuple[Any, str, float]]:
    """Yield style, name and value of marks: percentiles, or the medians of two lobes."""
    excess = analysis.flights.excess_time_h
    styles = tuple(_LINES.values())
    for style, (name, chosen) in zip(styles, analysis.lobes.items(), strict=False):
        share = f"{percent(float(np.mean(chosen)), '.0f')} {name}, median"
        yield style, share, percentiles(excess[chosen])["p50"]
    if not analysis.lobes:
        for name, value in percentiles(excess).items():
            yield _LINES[name], f"{name.upper()} (exceeded in {name[1:]} %)", value


def _draw_causes(axes: Axes, analysis: UncertaintyAnalysis) -> None:
    """Draw bars between mean excess times of each input's lowest and highest draws."""
    excess, names, means = analysis.flights.excess_time_h, [], []
    finite = np.isfinite(excess)
    for source in analysis.inputs.inputs:
        value, index = analysis.values[source.key], analysis.sobol.get(source.key)
        fifths = value <= np.percentile(value, 20.0), value >= np.percentile(value, 80.0)
        known = [excess[finite & fifth] for fifth in fifths]
        means.append([float(np.mean(each)) if len(each) else np.nan for each in known])
        share = "" if index is None else f", {100 * index.total:.0f}\u00a0%\u00a0of\u00a0variance"
        names.append(f"{source.label}{share}")
    ends = np.array(means)
    shown = np.argsort(np.nan_to_num(np.abs(ends[:, 1] - ends[:, 0])), kind="stable")[-_MOST_BARS:]
    centre = float(np.mean(excess[finite])) if np.any(finite) else 0.0
    for end, name, colour, hatch in (
        (ends[shown, 0], "lowest fifth of the input", drawing.ORANGE, ""),
        (ends[shown, 1], "highest fifth", drawing.BLUE, "//"),
    ):
        looks: dict[str, Any] = {"facecolor": colour, "edgecolor": drawing.paper(), "hatch": hatch}
        axes.barh(range(len(shown)), end - centre, 0.6, centre, linewidth=0.0, label=name, **looks)
    axes.axvline(centre, color=drawing.DARK_GREY)
    axes.set_yticks(range(len(shown)), [names[index] for index in shown])
    axes.set_xlabel("mean excess time [h]")
