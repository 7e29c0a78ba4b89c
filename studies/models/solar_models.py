"""All solar power models over the same scenarios, each evaluated once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.performance import SolarDay, SolarModel, day_axis_h, modelled_power
from solar.correction import correction
from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName
from solar.sun import declination, sun_times
from solar.types import FloatArray

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


def stacked(days: Sequence[SolarDay]) -> SolarDay:
    """Scenarios of several days one after the other, to be simulated in one go."""
    scenarios = Scenarios(
        np.concatenate([d.scenarios.latitude_deg for d in days]),
        np.concatenate([d.scenarios.day_of_year for d in days]),
    )
    return SolarDay(
        scenarios,
        days[0].time_h,
        np.concatenate([d.specific_power_w_per_m2 for d in days]),
        np.concatenate([d.sunrise_h for d in days]),
        np.concatenate([d.sunset_h for d in days]),
    )


class ModelDays:
    """Specific power by every model in the same scenarios; corrections only scale what is known.

    Gives what :func:`sizing.performance.solar_day` gives, without computing a model twice.
    """

    def __init__(self, aircraft: Aircraft, mission: Mission, scenarios: Scenarios) -> None:
        self.aircraft, self.mission, self.scenarios = aircraft, mission, scenarios
        self.time_h = day_axis_h()
        self._times = sun_times(scenarios.latitude_deg, declination(scenarios.noon_day))
        self._power: dict[ModelName, FloatArray] = {}

    def day(self, solar: SolarModel) -> SolarDay:
        """Specific power by a model and its correction."""
        power = self._modelled(solar.model)
        if solar.correction == "loiter":
            power = power * self._full_over(solar.model)[:, np.newaxis]
        factor = correction(solar.model, solar.correction).factor
        rise, set_ = self._times.sunrise_h, self._times.sunset_h
        return SolarDay(self.scenarios, self.time_h, power * factor, rise, set_)

    def _modelled(self, model: ModelName) -> FloatArray:
        if model not in self._power:
            self._power[model] = modelled_power(
                self.aircraft, self.mission, model, self.scenarios, self.time_h
            )
        return self._power[model]

    def _full_over(self, model: ModelName) -> FloatArray:
        """Daily energy of FM over that of a model; see :func:`sizing.performance.loiter_ratio`."""
        ours, theirs = (
            np.asarray(np.trapezoid(self._modelled(m), self.time_h, axis=-1)) for m in (model, "FM")
        )
        lit = ours > 0.0
        return np.where(lit, theirs / np.where(lit, ours, 1.0), 1.0)
