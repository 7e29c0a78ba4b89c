"""Build quality: mass of a team's structures relative to AtlantikSolar.

Factors and scatter come from built aircraft, ``data/built-structures.csv``; see "Quality of
building" in docs/structure.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, get_args

from pydantic import BeforeValidator, model_validator

from missions.files.data_rows import data_rows
from missions.files.errors import shown
from sizing.smooth import Value
from solar.schema import PositiveReal, Record, is_positive, refusal

Quality = Literal["record", "careful", "ordinary"]
QUALITIES: tuple[Quality, ...] = get_args(Quality)


class BuildQuality(NamedTuple):
    """Build quality of a class of aircraft.

    ``factor``: structural mass relative to AtlantikSolar [-]. ``log_sigma``: standard deviation of
    its logarithm for the next aircraft [-]. ``aircraft``: names of the aircraft in the data.
    """

    factor: float
    log_sigma: float
    aircraft: tuple[str, ...]


@cache
def build_qualities() -> Mapping[str, BuildQuality]:
    """Return the build qualities by their names.

    The factor is the geometric mean of the class's n aircraft, to the data's two digits. The
    scatter of the next aircraft is ``s sqrt(1 + 1/n)`` with the pooled variance of all classes,
    ``s^2 = sum (ln r - mean)^2/(N - classes)`` (Montgomery, Design and Analysis of Experiments,
    section 3.3), as a class of two aircraft is too small for its own.
    """
    rows = data_rows("built-structures", "sizing")
    logs: dict[str, dict[str, float]] = {quality: {} for quality in QUALITIES}
    for row in rows:
        logs[row["quality"]][row["aircraft"]] = math.log(float(row["ratio"]))
    means = {quality: sum(known.values()) / len(known) for quality, known in logs.items()}
    squares = sum((r - means[quality]) ** 2 for quality in logs for r in logs[quality].values())
    sigma = math.sqrt(squares / (len(rows) - len(logs)))
    qualities = {}
    for quality, known in logs.items():
        scatter = sigma * math.sqrt(1.0 + 1.0 / len(known))
        factor = round(math.exp(means[quality]), 2)
        qualities[quality] = BuildQuality(factor, scatter, tuple(known))
    return MappingProxyType(qualities)


def _checked_build(value: Any) -> Any:
    if value is None or value in QUALITIES or is_positive(value):
        return value
    allowed = f"must be one of {', '.join(QUALITIES)} or a number greater than 0"
    raise ValueError(refusal(allowed, shown(value)))


Build = Annotated[Quality | PositiveReal, BeforeValidator(_checked_build)]


class BuiltStructure(Record):
    """Base of all structural models, with the build quality.

    ``build`` is relative to AtlantikSolar: with it, ``calibration`` is AtlantikSolar's by default.
    """

    atlantiksolar_calibration: ClassVar[float | None] = None

    build: Build | None = None

    @model_validator(mode="before")
    @classmethod
    def _calibrated(cls, data: Any) -> Any:
        calibration = cls.atlantiksolar_calibration
        if calibration is None or not isinstance(data, Mapping) or data.get("build") is None:
            return data
        return {"calibration": calibration, **data}

    @property
    def build_factor(self) -> Value:  # the number of a word, see `parameter_value`
        """Structural mass relative to AtlantikSolar [-]; 1 by default."""
        if self.build is None:
            return 1.0
        return build_qualities()[self.build].factor if isinstance(self.build, str) else self.build

    @property
    def mass_factor(self) -> Value:
        """Factor on the mass by the formulas: calibration times build factor [-]."""
        return getattr(self, "calibration", 1.0) * self.build_factor
