"""Solar power models with their corrections: reference model, and perpetual flight by each."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarModel, Sunlight
from sizing.performance import performance
from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName


def attitude_is_known(aircraft: Aircraft, mission: Mission) -> bool:
    """Return true if aircraft and mission have what VM, FM and the loiter correction need."""
    return aircraft.modules.geometry is not None and mission.flight_path is not None


def reference_model(aircraft: Aircraft, mission: Mission) -> SolarModel:
    """Return the most accurate model: FM on the flight path, else CAM, corrected by its error."""
    return SolarModel("FM" if attitude_is_known(aircraft, mission) else "CAM", "report")


def combinations(
    models: Sequence[ModelName | SolarModel] | None = None,
    corrections: Sequence[CorrectionName] | None = None,
    *,
    attitude: bool = True,
) -> list[SolarModel]:
    """Return the combinations of models and corrections, without repetition.

    FM with the loiter correction equals FM with the report's. ``models``: names, all by default, or
    a :class:`SolarModel` with its correction. ``attitude``: False leaves out models that need it,
    and refuses them if named.
    """
    named = [*(models or ()), *(corrections or ())]
    pairs: list[SolarModel] = []
    for model in MODEL_NAMES if models is None else models:
        if isinstance(model, SolarModel):
            pairs.append(model)
            continue
        for by in CORRECTION_NAMES if corrections is None else corrections:
            pairs.append(SolarModel(model, "report" if (model, by) == ("FM", "loiter") else by))
    if not attitude:
        for pair in pairs:
            word = pair.model if pair.model in ATTITUDE_MODELS else pair.correction
            if pair.needs_path and (word in named or pair in named):
                needed = "modules.geometry of the aircraft and flight_path of the mission"
                raise ValueError(f"{word} needs {needed}")
        pairs = [pair for pair in pairs if not pair.needs_path]
    return list(dict.fromkeys(pairs))


def model_label(solar: SolarModel) -> str:
    """Return model and correction in words, for instance ``uncorrected CDM``."""
    return {
        "none": f"uncorrected {solar.model}",
        "report": f"corrected {solar.model}",
        "loiter": f"loiter-corrected {solar.model}",
    }[solar.correction]


def perpetual_line(perpetual: Sequence[bool], mission: Mission) -> str:
    """Say how many models and corrections predict perpetual flight, or a landing."""
    goal = "perpetual flight" if mission.flight is None else "a landing with power left"
    count, limited = len(perpetual), sum(not is_perpetual for is_perpetual in perpetual)
    pairs = f"{count} pair{'' if count == 1 else 's'} of model and correction"
    if limited == 0:
        return f"All {pairs} predict {goal}." if count > 1 else f"{pairs}: {goal}."
    return f"{limited} of {pairs} {'does' if limited == 1 else 'do'} not predict {goal}."


def perpetual_by_model(aircraft: Aircraft, mission: Mission) -> dict[SolarModel, bool]:
    """Return by model true for perpetual flight in every scenario."""
    sun = Sunlight(aircraft, mission)
    every = combinations(None, None, attitude=attitude_is_known(aircraft, mission))
    simulate = partial(performance, aircraft, mission, keep_trajectory=False)
    return {s: bool(np.all(simulate(day=sun.day(s)).cycle.sufficient)) for s in every}
