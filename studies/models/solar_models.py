"""All solar power models over the same scenarios, each evaluated once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.energy.march import FloatArray
from sizing.performance import SolarDay, SolarModel, day_axis_h, modelled_power
from solar.correction import correction
from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName
from solar.sun import declination, sun_times

# The best knowledge of the solar power there is: the Full Model on the flight path without the
# systematic error that it showed in flight; without a path, CAM without its own.
BEST = SolarModel("FM", "report")
BEST_WITHOUT_PATH = SolarModel("CAM", "report")


def attitude_is_known(aircraft: Aircraft, mission: Mission) -> bool:
    """Whether VM, FM and the loiter correction have what they need.

    Parameters
    ----------
    aircraft : Aircraft
        Needs surfaces in ``modules.geometry``.
    mission : Mission
        Needs a ``flight_path``.
    """
    return aircraft.modules.geometry is not None and mission.flight_path is not None


def reference_model(aircraft: Aircraft, mission: Mission) -> SolarModel:
    """Model that comes closest to the truth.

    Parameters
    ----------
    aircraft, mission
        Decide whether the Full Model can be computed.
    """
    return BEST if attitude_is_known(aircraft, mission) else BEST_WITHOUT_PATH


def combinations(
    models: Iterable[ModelName | SolarModel] | None = None,
    corrections: Iterable[CorrectionName] | None = None,
    *,
    attitude: bool = True,
) -> list[SolarModel]:
    """Every model with every correction, without repetition.

    FM corrected by the loiter is FM corrected by its measured error, and counts as that.

    Parameters
    ----------
    models : iterable of str or SolarModel, optional
        Names of models, all by default; a :class:`SolarModel` stands for itself, with its own
        correction.
    corrections : iterable of str, optional
        Names of corrections, all by default.
    attitude : bool
        Whether the attitude is known. Without, what needs it is left out where nothing is named,
        and refused where it is.

    Returns
    -------
    list of SolarModel

    Raises
    ------
    ValueError
        If a name does not exist, or needs an attitude that is not known.
    """
    models = None if models is None else list(models)
    corrections = None if corrections is None else list(corrections)
    found = []
    for model in MODEL_NAMES if models is None else models:
        if isinstance(model, SolarModel):
            found.append(model)
            continue
        _check_name("model", model, MODEL_NAMES)
        for name in CORRECTION_NAMES if corrections is None else corrections:
            _check_name("correction", name, CORRECTION_NAMES)
            by_report = (model, name) == ("FM", "loiter")
            found.append(SolarModel(model, "report" if by_report else name))
    if attitude:
        return list(dict.fromkeys(found))
    named = [m.model if isinstance(m, SolarModel) else m for m in models or ()]
    named_corrections = [m.correction for m in models or () if isinstance(m, SolarModel)]
    for given in (*named, *named_corrections, *(corrections or ())):
        if given in (*ATTITUDE_MODELS, "loiter"):
            raise ValueError(
                f"{given} needs modules.geometry of the aircraft and flight_path of the mission"
            )
    horizontal = (s for s in found if s.model not in ATTITUDE_MODELS and s.correction != "loiter")
    return list(dict.fromkeys(horizontal))


def _check_name(what: str, name: str, allowed: Sequence[str]) -> None:
    if name not in allowed:
        raise ValueError(f"{what} {name!r} is not one of {', '.join(allowed)}")


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

    Parameters
    ----------
    aircraft, mission
        What flies, and where.
    scenarios : Scenarios
        Latitudes and days, instead of the mission's own.
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
