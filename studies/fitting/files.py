"""Aircraft files that a fit or a calibration writes, with where each number comes from."""

from __future__ import annotations

import copy
import datetime
import math
from collections.abc import Mapping, Sequence
from typing import Any

from missions.files.errors import printable
from missions.files.overrides import with_overrides
from missions.files.validation import validate
from missions.files.writing import to_yaml
from missions.files.yaml import Document
from sizing.aircraft import Aircraft
from solar._version import __version__
from studies.fitting.estimation import Fitted
from studies.fitting.flight import FlightFit
from studies.fitting.least_squares import CONFIDENCE
from studies.fitting.parameters import MPPT, scaled_mppt

_MOST_OF_A_NAME = 110
_TAILS = 3.8  # standard deviations: beyond what draws of uncertain inputs are cut off at


def fitted_document(
    document: Document, fit: FlightFit, sources: Mapping[str, str | None]
) -> Document:
    """Document with the fitted values; their standard errors are in its ``uncertainty``."""
    more: dict[str, Any] = {}
    if any(one.parameter.name == MPPT for one in fit.fitted):
        aircraft = fit.fitted_aircraft()
        more["modules.mppt"] = scaled_mppt(aircraft, 1.0).model_dump(mode="json")
    held = [one.to_dict() for one in fit.held]
    block = {**provenance(document, "fit", sources), "light_sigma": fit.light_sigma}
    return changed_document(document, fit.fitted, {**block, "held": held}, "fitted", more)


def changed_document(
    document: Document,
    fitted: Sequence[Fitted],
    block: Mapping[str, Any],
    what: str,
    more: Mapping[str, Any] | None = None,
) -> Document:
    """Document with other values, their scatter and provenance; its name ends with ``what``."""
    values = {one.parameter.key: _digits(one.value, one.standard_error) for one in fitted}
    records = [
        {
            "key": one.parameter.key,
            "value": values[one.parameter.key],
            "before": one.before,
            "standard_error": _digits(one.standard_error, one.standard_error),
            "low": _digits(one.low, one.standard_error),
            "high": _digits(one.high, one.standard_error),
        }
        for one in fitted
    ]
    scatter = copy.deepcopy(document.data.get("uncertainty") or {})
    inputs = scatter.setdefault("inputs", {})
    inputs.update({one.parameter.key: scatter_of(one) for one in fitted})
    changed = with_overrides(
        document,
        {
            **values,
            **(more or {}),
            "provenance": {**block, "confidence": CONFIDENCE, "fitted": records},
            "uncertainty": scatter,
            "name": renamed(document.data["name"], what),
        },
    )
    validate(changed, Aircraft)
    return changed


def scatter_of(one: Fitted) -> dict[str, Any]:
    """Block of ``uncertainty``: normal; lognormal or uniform where its tails are impossible."""
    sigma = one.standard_error
    low, high = one.parameter.lowest, one.parameter.highest
    if low < one.value - _TAILS * sigma and one.value + _TAILS * sigma < high:
        return {"sigma": _digits(sigma, sigma)}
    relative = sigma / one.value
    if one.value * math.exp(_TAILS * math.log1p(relative)) < high:
        return {"distribution": "lognormal", "relative_sigma": _digits(relative, relative)}
    ends = {"low": max(one.low, low + 1e-3 * sigma), "high": min(one.high, high)}
    return {"distribution": "uniform", **{end: _digits(v, sigma) for end, v in ends.items()}}


def renamed(name: str, what: str) -> str:
    """Name of an aircraft that was made of another one."""
    return name if name.endswith(f"-{what}") else f"{name[:_MOST_OF_A_NAME]}-{what}"


def provenance(
    document: Document, command: str, sources: Mapping[str, str | None]
) -> dict[str, Any]:
    """Where a file comes from, as its block says it."""
    known = {key: printable(value) for key, value in sources.items() if value is not None}
    return {
        "tool": f"solar-uav {__version__} {command}",
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "aircraft": printable(document.source),
        **known,
    }


def _digits(value: float, standard_error: float) -> float:
    """Value with three digits of its standard error: rounding must not widen the interval."""
    if not 0.0 < standard_error < math.inf:
        return value
    return round(value, 1 - math.floor(math.log10(standard_error / 10.0)))


def file_text(document: Document, notes: Sequence[str]) -> str:
    """Text of a file, with comments above that say where its numbers come from."""
    block = document.data["provenance"]
    origin = f"# Written by {block['tool']} on {block['date']} from {block['aircraft']}"
    comments = [origin, *(f"# {printable(line)}" for line in notes)]
    return "\n".join([*comments, to_yaml(document.data, compact=True)])


def fitted_lines(fit: FlightFit) -> list[str]:
    """What was fitted, a line each, for the comments above a file."""
    logs = ", ".join(one.source for one in fit.logs)
    start = f"fitted to {logs}: intervals of {CONFIDENCE:.0%}, see provenance below"
    lines = [start, *value_lines(fit.fitted)]
    lines += [f"  {one.parameter.key}: held at {one.value:g}; {one.reason}" for one in fit.held]
    return lines


def value_lines(fitted: Sequence[Fitted]) -> list[str]:
    """Values with their intervals, a line each."""
    lines = []
    for one in fitted:
        unit = f" {one.parameter.unit}" if one.parameter.unit else ""
        interval = f"{one.low:.5g} to {one.high:.5g}{unit}"
        lines.append(f"  {one.parameter.key}: {one.value:.5g} ({interval}; before {one.before:g})")
    return lines
