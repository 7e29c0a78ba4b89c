"""Names that users choose from, apart from the code behind them.

A command line that lists the choices does not have to import the models.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple, get_args

ModelName = Literal["CDM", "CAM", "VM", "FM"]
CorrectionName = Literal["none", "report", "loiter"]

MODEL_NAMES: tuple[ModelName, ...] = get_args(ModelName)
CORRECTION_NAMES: tuple[CorrectionName, ...] = get_args(CorrectionName)


class ModelEntry(NamedTuple):
    """Facts about a solar power model besides its formula.

    ``needs_path``: True for models of the attitude, which need module surfaces and a flight path.
    ``average`` (positive: overestimated), ``rms``: errors relative to flight, table 3 of the report
    in :mod:`solar.systematic_errors`.
    """

    label: str
    needs_path: bool
    average: float
    rms: float

    @property
    def scatter(self) -> float:
        """RMS error that remains when the average error is taken away."""
        return math.sqrt(self.rms**2 - self.average**2)


MODELS: dict[ModelName, ModelEntry] = {
    "CDM": ModelEntry("constant efficiencies", False, 0.1781, 0.2003),
    "CAM": ModelEntry("light and temperature", False, 0.0531, 0.0702),
    "VM": ModelEntry("attitude on the path", True, -0.0196, 0.0396),
    "FM": ModelEntry("full model", True, -0.0175, 0.0419),
}
ATTITUDE_MODELS: tuple[ModelName, ...] = tuple(m for m in MODEL_NAMES if MODELS[m].needs_path)
