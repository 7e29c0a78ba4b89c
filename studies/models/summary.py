"""The one sentence that a designer needs from a comparison of models."""

from __future__ import annotations

import numpy as np

from sizing.energy.cycle import Status
from sizing.optimisation.objectives import Objective
from sizing.optimisation.result import SizingStatus
from studies.models.comparison import Built, Case, Comparison, Prediction
from studies.models.solar_models import model_label

# Excess time that is missing by less than is printed is not missing [h].
_MET_H = 0.005
# Nights from which on a flight ends by what is lost from day to day.
_MANY_NIGHTS = 10


def sentence(comparison: Comparison) -> str:
    """Compare the first case with the reference: the designs if there are any, else the aircraft.

    The first case is the least trustworthy one, where the models are listed from the simplest to
    the fullest and the corrections from none.
    """
    case, reference = comparison.cases[0], comparison.reference
    if case.built is not None:
        return _of_designs(comparison, case, case.built)
    name, by = comparison.aircraft.name, model_label(case.solar)
    told = f"By {by} {name} {fate(case.prediction)}"
    if case.solar == reference.solar:
        return f"{told}."
    return f"{told}; judged by {model_label(reference.solar)} it {fate(reference.prediction)}."


def _of_designs(comparison: Comparison, case: Case, built: Built) -> str:
    name, by = comparison.aircraft.name, model_label(case.solar)
    truth = model_label(comparison.reference.solar)
    own = comparison.reference.built
    assert own is not None
    itself = case.solar == comparison.reference.solar
    required_h = comparison.required_excess_time_h
    aside = "" if itself else f" (sized with {truth}: {_in_short(own, comparison.objective)})"
    if built.judged is None:
        return f"Sized with {by}, {_no_design(built, name)}{aside}."
    told = f"Sized with {by} {name} gets {outcome(built, comparison.objective)}"
    joined = " and" if itself else f"; judged by {truth} it"
    return f"{told}{joined} {fate(built.judged, required_h)}{aside}."


def _no_design(built: Built, name: str) -> str:
    if built.sizing.status is SizingStatus.infeasible:
        return f"no design of {name} meets the requirements"
    return f"{name} comes to no result, as the solver does not converge"


def _in_short(built: Built, objective: Objective) -> str:
    if built.judged is not None:
        return outcome(built, objective)
    return "no design" if built.sizing.status is SizingStatus.infeasible else "no result"


def outcome(built: Built, objective: Objective) -> str:
    """What a sizing arrived at, in the quantity that it was asked for."""
    design, simulated = built.sizing.design, built.sizing.simulated
    assert design is not None
    assert simulated is not None
    if objective is Objective.min_wingspan:
        return f"a span of {design.variables.wingspan_m:.2f} m"
    if objective is Objective.min_mass:
        return f"a mass of {design.total_mass_kg:.2f} kg"
    if objective is Objective.max_payload_mass:
        return f"a payload of {design.variables.payload_mass_kg:.2f} kg"
    if objective is Objective.max_payload_power:
        return f"a payload of {design.variables.payload_power_w:.1f} W"
    promised_h = float(np.min(simulated.cycle.excess_time_h))
    if not np.isfinite(promised_h):
        return "an excess time without end"
    return f"an excess time of {promised_h:.1f} h"


def fate(prediction: Prediction, required_h: float = 0.0) -> str:
    """What becomes of an aircraft in its worst scenario: ``stays up 21.3 h at ...``."""
    at = prediction.scenario
    if prediction.status is Status.always_lit:
        return "flies for ever, as solar power always exceeds the load"
    if prediction.status is Status.perpetual:
        shown = f"h of excess time at {at}"
        if prediction.excess_time_h < required_h - _MET_H:
            return (
                f"flies for ever, but with {prediction.excess_time_h:.2f} {shown} instead of the "
                f"required {required_h:g} h"
            )
        where = " in every scenario" if prediction.several_scenarios else ""
        return f"flies for ever{where}, with {prediction.excess_time_h:.1f} {shown}"
    return f"stays up {duration(prediction.endurance_h)} at {at}: {_why_it_ends(prediction)}"


def duration(hours: float) -> str:
    """Length of a flight: hours up to three days, then days with two digits."""
    if not np.isfinite(hours):
        return "more than a year"
    return f"{hours:.1f} h" if hours < 72.0 else f"{two_digits(hours / 24.0)} days"


def two_digits(number: float) -> str:
    """Number with two significant digits, without an exponent."""
    return f"{float(f'{number:.1e}'):g}"


def _why_it_ends(prediction: Prediction) -> str:
    if prediction.status is Status.never_lit:
        return "there is no solar power"
    if not prediction.enough_sun:
        return "solar power never reaches the load"
    if prediction.polar_day:
        return "the sun does not set, but the battery does not last through its low hours"
    if prediction.nights >= _MANY_NIGHTS or not np.isfinite(prediction.endurance_h):
        return "the days return a trifle less than the nights take"
    if prediction.nights == 0:
        return "it does not survive the night"
    nights = "1 night" if prediction.nights == 1 else f"{prediction.nights} nights"
    return f"it survives {nights} and not the next"
