"""What each flight of a fit says: its values alone, and the errors of its sky and attitude."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from scipy.stats import chi2

from sizing.results.tables import Column, Line, Table
from studies.fitting.estimation import Estimate
from studies.fitting.least_squares import widening

# Errors that are printed: words, unit, and the unit in that of the fit.
_SHOWN = {
    "level": ("level of the light", "%", 0.01),
    "haze": ("haze per air mass", "%", 0.01),
    "diffuse": ("diffuse light", "%", 0.01),
    "roll": ("roll", "deg", math.radians(1.0)),
    "pitch": ("pitch", "deg", math.radians(1.0)),
}


def flight_table(estimates: Sequence[Estimate], names: Sequence[str]) -> Table:
    """Values of each of several flights alone, and how much of what is known it adds."""
    columns = (
        Column("parameter"),
        Column("unit"),
        Column("flight"),
        Column("value", "alone", form=".4g"),
        Column("standard_error", "standard error", form=".2g"),
        Column("share", "adds [%]", form=".0f"),
    )
    rows = [
        (
            *(one.parameter.name, one.parameter.unit, names[number], float(alone.values[place])),
            *(float(alone.errors[place]), 100.0 * float(alone.shares[place])),
        )
        for part in estimates
        for place, one in enumerate(part.fitted)
        for number, alone in zip(part.channel.numbers, part.solution.flights, strict=False)
    ]
    return Table("what each flight adds", columns, tuple(rows))


def error_table(estimates: Sequence[Estimate], names: Sequence[str]) -> Table:
    """Errors of sky and attitude of the flights: what is known before, and what is fitted."""
    columns = (
        Column("error"),
        Column("unit"),
        Column("flight"),
        Column("sigma", "known within", form=".2g"),
        Column("value", "fitted", form="+.2f"),
        Column("standard_error", "standard error", form=".2g"),
    )
    rows = []
    for known, value, error in (one for part in estimates if part.fitted for one in part.errors):
        if known.name in _SHOWN and known.flight is not None:
            words, unit, size = _SHOWN[known.name]
            numbers = (known.sigma / size, value / size, error / size)
            rows.append((words, unit, names[known.flight], *numbers))
    return Table("sky and attitude, errors of the model or the log", columns, tuple(rows))


def differences(estimates: Sequence[Estimate]) -> Iterator[Line]:
    """Whether several flights agree, a line for each channel."""
    for part in estimates:
        chi_square, freedom = part.solution.chi_square, part.solution.freedom
        if freedom:
            text = (
                f"{part.channel.label}: differences between the flights have chi-square "
                f"{chi_square:.1f} at {freedom} degrees of freedom, probability "
                f"{float(chi2.sf(chi_square, freedom)):.2g}"
            )
            wider = widening(chi_square, freedom)
            if wider > 1.0:
                text += f": they differ; intervals are {wider:.2f} times as wide for it"
            yield Line(text, "warning" if wider > 1.0 else "plain")


def flight_records(part: Estimate) -> dict[str, Any]:
    """Errors and values of the flights of a channel, JSON-ready."""
    return {
        "errors": [
            {
                **{"name": one.known.name, "flight": one.known.flight, "sigma": one.known.sigma},
                **{"value": one.value, "standard_error": one.standard_error},
            }
            for one in part.errors
        ],
        "flights": [
            {
                "flight": number,
                "values": one.values.tolist(),
                "standard_errors": one.errors.tolist(),
                "shares": one.shares.tolist(),
            }
            for number, one in zip(part.channel.numbers, part.solution.flights, strict=False)
        ],
        "chi_square": part.solution.chi_square,
        "degrees_of_freedom": part.solution.freedom,
    }
