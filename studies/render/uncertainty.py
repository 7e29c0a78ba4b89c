"""Flights under uncertain inputs as people read them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from sizing.results.numbers import percentiles
from studies import quantities as q
from studies.render.tables import ALL, Line, Table, facts
from studies.render.words import extrapolation_blocks, percent, required

if TYPE_CHECKING:
    from sizing.results.uncertainty import UncertaintyAnalysis

_INPUTS = 8  # of the table of a summary


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
    sufficient = replace(sufficient, label=f"probability of {required(analysis.required_h)}")
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
