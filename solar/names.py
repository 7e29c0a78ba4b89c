"""Names that users choose from, kept apart from the code behind them.

A command line that lists the choices does not have to import the models.
"""

from __future__ import annotations

from typing import Literal, get_args

ModelName = Literal["CDM", "CAM", "VM", "FM"]
CorrectionName = Literal["none", "report", "loiter"]

MODEL_NAMES: tuple[ModelName, ...] = get_args(ModelName)
CORRECTION_NAMES: tuple[CorrectionName, ...] = get_args(CorrectionName)

# Models that know the attitude: they need module surfaces on the aircraft and a flight path.
ATTITUDE_MODELS: tuple[ModelName, ...] = ("VM", "FM")
