"""Names that users choose from, kept apart from the code behind them.

A command line that lists the choices does not have to import the models.
"""

from __future__ import annotations

from typing import Literal, get_args

ModelName = Literal["CDM", "CAM"]
CorrectionName = Literal["none", "report"]

MODEL_NAMES: tuple[ModelName, ...] = get_args(ModelName)
CORRECTION_NAMES: tuple[CorrectionName, ...] = get_args(CorrectionName)

# The objectives of sizing; their formulation is in sizing.sizing_problem.
OBJECTIVE_NAMES = ("max_excess_time", "min_wingspan", "min_mass")
