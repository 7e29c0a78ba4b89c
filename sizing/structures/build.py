"""Quality of building: how much heavier a team's structure is than that of AtlantikSolar.

Factors and their scatter come from built aircraft, ``data/built-structures.csv``; see "Quality of
building" in docs/structure.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, get_args

from pydantic import BeforeValidator, model_validator

from missions.files.errors import shown
from sizing.data_rows import data_rows
from sizing.smooth import Value
from solar.schema import PositiveReal, Record, is_positive

Quality = Literal["record", "careful", "ordinary"]
QUALITIES: tuple[Quality, ...] = get_args(Quality)


class BuildQuality(NamedTuple):
    """A class of aircraft as teams build them.

    ``factor``: structure over that of AtlantikSolar [-]. ``log_sigma``: scatter of the next
    aircraft's logarithm [-]. ``aircraft``: names of those that both rest on.
    """

    factor: float
    log_sigma: float
    aircraft: tuple[str, ...]


@cache
def build_qualities() -> Mapping[str, BuildQuality]:
    """Classes by their names.

    The factor is the geometric mean of a class of n aircraft, to the two digits that its data
    have. The scatter of the next aircraft is ``s sqrt(1 + 1/n)`` with s of all classes together, as
    two aircraft alone tell none: ``s^2 = sum (ln r - mean)^2/(N - classes)`` (Montgomery, Design
    and Analysis of Experiments, section 3.3: pooled variance of an analysis of variance).
    """
    rows = data_rows("built-structures")
    logs = {
        quality: {
            one["aircraft"]: math.log(float(one["ratio"]))
            for one in rows
            if one["quality"] == quality
        }
        for quality in QUALITIES
    }
    means = {quality: sum(some.values()) / len(some) for quality, some in logs.items()}
    squares = sum((r - means[quality]) ** 2 for quality in logs for r in logs[quality].values())
    sigma = math.sqrt(squares / (len(rows) - len(logs)))
    return MappingProxyType(
        {
            quality: BuildQuality(
                round(math.exp(means[quality]), 2),
                sigma * math.sqrt(1.0 + 1.0 / len(some)),
                tuple(some),
            )
            for quality, some in logs.items()
        }
    )


def _checked_build(value: Any) -> Any:
    if value is None or value in QUALITIES or is_positive(value):
        return value
    allowed = ", ".join(QUALITIES)
    raise ValueError(f"must be one of {allowed} or a number greater than 0 (got {shown(value)})")


Build = Annotated[Quality | PositiveReal, BeforeValidator(_checked_build)]


class BuiltStructure(Record):
    """What every model of the structure has: how well the team builds.

    ``build`` counts from AtlantikSolar. So a model that has a ``calibration`` takes that of
    AtlantikSolar where a file with ``build`` gives none.
    """

    atlantiksolar_calibration: ClassVar[float | None] = None

    build: Build | None = None

    @model_validator(mode="before")
    @classmethod
    def _calibrated(cls, data: Any) -> Any:
        own = cls.atlantiksolar_calibration
        if own is None or not isinstance(data, Mapping) or data.get("build") is None:
            return data
        return {"calibration": own, **data}

    @property
    def build_factor(self) -> Value:
        """Structure over that of AtlantikSolar [-]; a number or symbol is one itself, none is 1."""
        if self.build is None:
            return 1.0
        return build_qualities()[self.build].factor if isinstance(self.build, str) else self.build

    @property
    def mass_factor(self) -> Value:
        """Factor on the mass that the formulas give [-]: calibration and build together."""
        return getattr(self, "calibration", 1.0) * self.build_factor
