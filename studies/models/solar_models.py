"""Solar power models with their corrections: the closest to the truth, and what each says."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarDay, SolarModel, Sunlight
from sizing.performance import performance
from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName

# The best knowledge of the solar power there is: the Full Model on the flight path without the
# systematic error that it showed in flight; without a path, CAM without its own.
BEST = SolarModel("FM", "report")
BEST_WITHOUT_PATH = SolarModel("CAM", "report")


def attitude_is_known(aircraft: Aircraft, mission: Mission) -> bool:
    """Whether VM, FM and the loiter correction have what they need."""
    return aircraft.modules.geometry is not None and mission.flight_path is not None


def reference_model(aircraft: Aircraft, mission: Mission) -> SolarModel:
    """Model that comes closest to the truth."""
    return BEST if attitude_is_known(aircraft, mission) else BEST_WITHOUT_PATH


def combinations(
    models: Iterable[ModelName | SolarModel] | None = None,
    corrections: Iterable[CorrectionName] | None = None,
    *,
    attitude: bool = True,
) -> list[SolarModel]:
    """Every model with every correction, without repetition.

    FM corrected by the loiter is FM corrected by its measured error, and counts as that.

    ``models``: names of models, all by default; a :class:`SolarModel` stands for itself, with its
    own correction. ``attitude``: whether the attitude is known. Without, what needs it is left out
    where nothing is named, and refused where it is.
    """
    models = None if models is None else list(models)
    corrections = None if corrections is None else list(corrections)
    pairs = []
    for model in MODEL_NAMES if models is None else models:
        if isinstance(model, SolarModel):
            pairs.append(model)
            continue
        _check_name("model", model, MODEL_NAMES)
        for name in CORRECTION_NAMES if corrections is None else corrections:
            _check_name("correction", name, CORRECTION_NAMES)
            by_report = (model, name) == ("FM", "loiter")
            pairs.append(SolarModel(model, "report" if by_report else name))
    if attitude:
        return list(dict.fromkeys(pairs))
    named = [m.model if isinstance(m, SolarModel) else m for m in models or ()]
    named_corrections = [m.correction for m in models or () if isinstance(m, SolarModel)]
    for given in (*named, *named_corrections, *(corrections or ())):
        if given in (*ATTITUDE_MODELS, "loiter"):
            raise ValueError(
                f"{given} needs modules.geometry of the aircraft and flight_path of the mission"
            )
    horizontal = (s for s in pairs if not s.needs_path)
    return list(dict.fromkeys(horizontal))


def _check_name(what: str, name: str, allowed: Sequence[str]) -> None:
    if name not in allowed:
        raise ValueError(f"{what} must be one of {', '.join(allowed)} (got {name!r})")


def model_label(solar: SolarModel) -> str:
    """Model and correction in words, for instance ``uncorrected CDM``."""
    return {
        "none": f"uncorrected {solar.model}",
        "report": f"corrected {solar.model}",
        "loiter": f"loiter-corrected {solar.model}",
    }[solar.correction]


def perpetual_line(perpetual: Sequence[bool], mission: Mission) -> str:
    """How many of the models and corrections say that the flight is not perpetual, or lands not."""
    wanted = "perpetual flight" if mission.flight is None else "a landing with power left"
    count, limited = len(perpetual), sum(not one for one in perpetual)
    pairs = f"{count} pair{'' if count == 1 else 's'} of model and correction"
    if limited == 0:
        return f"All {pairs} predict {wanted}." if count > 1 else f"{pairs}: {wanted}."
    return f"{limited} of {pairs} {'does' if limited == 1 else 'do'} not predict {wanted}."


def perpetual_by_model(aircraft: Aircraft, mission: Mission) -> dict[SolarModel, bool]:
    """Whether each model with each correction predicts perpetual flight in every scenario."""
    sun = Sunlight(aircraft, mission)
    every = combinations(None, None, attitude=attitude_is_known(aircraft, mission))
    together = SolarDay.joined([sun.day(solar) for solar in every])
    found = performance(aircraft, mission, every[0], day=together, keep_trajectory=False)
    by_model = np.reshape(found.cycle.flown, (len(every), -1))
    return {solar: bool(np.all(one)) for solar, one in zip(every, by_model, strict=True)}
