"""Which solar power models a study compares, and which of them comes closest to the truth."""

from __future__ import annotations

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.sunlight import SolarModel
from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName

# The best knowledge of the solar power there is: the Full Model on the flight path without the
# systematic error that it showed in flight; without a path, CAM without its own.
BEST = SolarModel("FM", "report")
BEST_WITHOUT_PATH = SolarModel("CAM", "report")


def attitude_is_known(aircraft: Aircraft, mission: Mission) -> bool:
    """Whether VM, FM and the loiter correction have the surfaces and the path that they need."""
    return aircraft.modules.geometry is not None and mission.flight_path is not None


def reference_model(aircraft: Aircraft, mission: Mission) -> SolarModel:
    """Model that comes closest to the truth for an aircraft and a mission."""
    return BEST if attitude_is_known(aircraft, mission) else BEST_WITHOUT_PATH


def combinations(
    models: tuple[ModelName, ...] = MODEL_NAMES,
    corrections: tuple[CorrectionName, ...] = CORRECTION_NAMES,
    *,
    attitude: bool = True,
) -> list[SolarModel]:
    """Every model with every correction, without repetition.

    FM corrected by the loiter is FM corrected by its measured error, and counts as that. Without
    knowledge of the ``attitude``, what needs it is left out.
    """
    found = []
    for model in models:
        for name in corrections:
            if not attitude and (model in ATTITUDE_MODELS or name == "loiter"):
                continue
            found.append(SolarModel(model, "report" if (model, name) == ("FM", "loiter") else name))
    return list(dict.fromkeys(found))


def model_label(solar: SolarModel) -> str:
    """Model and correction in words, for instance ``uncorrected CDM``."""
    return {
        "none": f"uncorrected {solar.model}",
        "report": f"corrected {solar.model}",
        "loiter": f"loiter-corrected {solar.model}",
    }[solar.correction]
