"""Records of a comparison: JSON, and a table with a row for each case."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from missions.dates import date_code
from sizing.analysis import finite
from sizing.design import DesignVariables
from solar._version import __version__
from studies.maps.season import Season
from studies.models.comparison import Built, Case, Comparison, Prediction

if TYPE_CHECKING:
    import pandas as pd


def to_json(comparison: Comparison, sentence: str) -> dict[str, Any]:
    """Whole comparison, JSON-ready; infinite numbers are null, and the status says why."""
    reference = comparison.reference
    return {
        "aircraft": comparison.aircraft.name,
        "mission": comparison.mission.name,
        "sentence": sentence,
        "reference": {"model": reference.solar.model, "correction": reference.solar.correction},
        "objective": {
            "name": comparison.objective.value,
            "required_excess_time_h": comparison.required_excess_time_h,
        },
        "cases": [case_record(case, comparison) for case in comparison.cases],
        "notes": list(comparison.notes),
        "version": __version__,
    }


def case_record(case: Case, comparison: Comparison) -> dict[str, Any]:
    """One case, JSON-ready."""
    truth_wh = comparison.reference.prediction.mean_solar_energy_wh
    seasons = zip(comparison.mission.latitudes(), case.seasons, strict=True)
    return {
        "model": case.solar.model,
        "correction": case.solar.correction,
        "solar_power_rms_relative": case.solar.rms_relative,
        **prediction_record(case.prediction),
        "income_above_reference": (
            case.prediction.mean_solar_energy_wh / truth_wh - 1.0 if truth_wh > 0.0 else None
        ),
        "season": season_record(case.season)
        | {"latitudes": [{"latitude_deg": lat} | season_record(s) for lat, s in seasons]},
        "design": None if case.built is None else design_record(case.built),
    }


def prediction_record(p: Prediction) -> dict[str, Any]:
    """What a model says of an aircraft, JSON-ready."""
    return {
        "status": p.status.name,
        "worst_scenario": {
            "latitude_deg": p.latitude_deg,
            "day_of_year": p.day_of_year,
            "label": p.scenario,
        },
        "excess_time_h": finite(p.excess_time_h),
        "excess_time_low_h": finite(p.excess_time_low_h),
        "excess_time_high_h": finite(p.excess_time_high_h),
        "minimum_state_of_charge": p.minimum_state_of_charge,
        "charge_margin_h": p.charge_margin_h,
        "endurance_h": finite(p.endurance_h),
        "solar_energy_wh": p.solar_energy_wh,
        "mean_solar_energy_wh": p.mean_solar_energy_wh,
    }


def season_record(season: Season) -> dict[str, Any]:
    """Season, JSON-ready."""
    return {
        "days": season.days,
        "window_days": season.window_days,
        "first": None if season.first is None else date_code(season.first),
        "last": None if season.last is None else date_code(season.last),
    }


def design_record(built: Built) -> dict[str, Any]:
    """Design that a model led to and its fate, JSON-ready; null where there is none."""
    sizing, design = built.sizing, built.sizing.design
    names = DesignVariables._fields
    variables = dict.fromkeys(names) if design is None else design.variables._asdict()
    return {
        "status": sizing.status.name,
        **variables,
        "total_mass_kg": None if design is None else design.total_mass_kg,
        "promised_excess_time_h": (
            None
            if sizing.simulated is None
            else finite(np.min(sizing.simulated.cycle.excess_time_h))
        ),
        "violated_requirements": [v.text for v in sizing.violations],
        "judged": None if built.judged is None else prediction_record(built.judged),
    }


def case_table(record: dict[str, Any]) -> pd.DataFrame:
    """One row for each case of a comparison's record."""
    import pandas as pd

    return pd.DataFrame([_row(case) for case in record["cases"]])


def _row(case: dict[str, Any]) -> dict[str, Any]:
    flat = {k: v for k, v in case.items() if k not in ("worst_scenario", "season", "design")}
    season = case["season"]
    flat |= {
        "worst_scenario": case["worst_scenario"]["label"],
        "season_days": season["days"],
        "season_window_days": season["window_days"],
        "season_first": season["first"],
        "season_last": season["last"],
    }
    design = case["design"]
    if design is None:
        return flat
    kept = {k: v for k, v in design.items() if k not in ("judged", "violated_requirements")}
    judged = design["judged"] or {}
    kept |= {f"judged_{key}": judged.get(key) for key in ("status", "excess_time_h", "endurance_h")}
    kept["judged_worst_scenario"] = judged["worst_scenario"]["label"] if judged else None
    return flat | {f"design_{key}": value for key, value in kept.items()}
