"""Comparison of solar power models: predictions for an aircraft, and designs sized with each.

Every model with every correction predicts the same aircraft on the same mission. A parametric
aircraft is also sized with each, and each design evaluated by the reference: the corrected Full
Model on the mission's flight path.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, ParametricAirframe
from sizing.day.light import SolarModel, Sunlight
from sizing.mass_budget import design_of
from sizing.performance import performance, performance_of_designs
from sizing.program.objectives import Objective
from sizing.program.result import SizingStatus
from sizing.program.size import size_aircraft
from sizing.results.result import Result
from sizing.validity.checks import day_checks
from sizing.validity.extrapolations import (
    collect_extrapolations,
    extrapolations,
    keep_worst,
    merge_extrapolations,
)
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
from solar.schema import spell
from studies.maps.season import perpetual_flags, season_of
from studies.models.prediction import Built, Case, predict
from studies.models.solar_models import (
    attitude_is_known,
    combinations,
    model_label,
    perpetual_line,
    reference_model,
)
from studies.output.gridded import resize_objective
from studies.quantities import group, table_of
from studies.render.tables import ALL, Column, Line, Table
from studies.render.words import extrapolation_blocks

if TYPE_CHECKING:
    import pandas as pd

Progress = Callable[[int, int], None]


@dataclass(frozen=True, repr=False)
class Comparison(Result):
    """Comparison of solar power models.

    Attributes
    ----------
    aircraft, mission
        Aircraft and mission of the comparison.
    objective, required_excess_time_h
        Objective of a parametric aircraft's sizings; excess time in every scenario [h].
    reference : Case
        Case that evaluates all designs.
    cases : tuple of Case
        In the order of the models and corrections.
    notes : tuple of str
        Conditions of the comparison.
    extrapolations : tuple of Extrapolation
        Where aircraft and designs leave the range of a model.
    """

    aircraft: Aircraft
    mission: Mission
    objective: Objective
    required_excess_time_h: float
    reference: Case
    cases: tuple[Case, ...]
    notes: tuple[str, ...] = ()
    extrapolations: tuple[Extrapolation, ...] = ()

    @property
    def has_designs(self) -> bool:
        """True if an aircraft was sized with the models."""
        return any(case.built is not None for case in self.cases)

    def perpetual_line(self) -> str:
        """Say how many models and corrections predict perpetual flight."""
        return perpetual_line([case.prediction.perpetual for case in self.cases], self.mission)

    def scenario_tables(self) -> tuple[Table, ...]:
        """Return tables of each case's worst scenario and of all scenarios; one if there is one."""
        table = self.tables()[0]
        if not any(case.prediction.several_scenarios for case in self.cases):
            return (table,)
        rows, lines = list(map(self._prediction_row, self.cases)), table.sections
        worst = f"model correction scenario solar_energy_wh {_REACHED}"
        title = "all scenarios: mean solar energy of a day, and season of perpetual flight"
        return (
            table_of("worst scenario of each model", worst, rows, sections=lines),
            table_of(title, f"{_OF_ALL} season", rows, sections=lines),
        )

    def tables(self) -> tuple[Table, ...]:
        """Return tables of predictions and, if sized, of designs."""
        models = [case.solar.model for case in self.cases]
        lines = [i + 1 for i, (a, b) in enumerate(itertools.pairwise(models)) if a != b]
        rows = map(self._prediction_row, self.cases)
        predicted = table_of("predictions", f"{_OF_ALL} {_REACHED} season", rows, sections=lines)
        if not self.has_designs:
            return (predicted,)
        objective = self.objective
        promised = "promised " if objective is Objective.max_excess_time else ""
        goal = Column("goal", f"{promised}{objective.label}", objective.unit, ".2f")
        judged = group("model correction judged_excess_time_h judged_endurance")
        required = f"{spell(self.required_excess_time_h)} h of excess time"
        title = f"designs by {objective.value} with {required}, then evaluated by the reference"
        columns = (*judged[:2], goal, *judged[2:])
        built = table_of(title, columns, map(self._design_row, self.cases), sections=lines)
        return predicted, built

    def _prediction_row(self, case: Case) -> dict[str, Any]:
        prediction, season = case.prediction, case.season
        whole = season.days == season.window_days
        return {
            **vars(case.solar),
            **vars(prediction),
            "solar_energy_above_reference": case.solar_energy_above_reference,
            "endurance": prediction.endurance_cell,
            "season": season.days if whole else f"{season.window_days} of {season.days}",
        }

    def _design_row(self, case: Case) -> dict[str, Any]:
        assert case.built is not None
        judged, value = case.built.judged, case.built.sizing.status.label
        return {
            **vars(case.solar),
            "goal": value if judged is None else case.built.value(self.objective),
            "judged_excess_time_h": judged and judged.excess_time_h,
            "judged_endurance": judged and judged.endurance_cell,
        }

    def to_frame(self) -> pd.DataFrame:
        """Return a row per case: keys of the record, nested keys joined by underscores."""
        import pandas as pd

        frame = pd.json_normalize(self.to_dict()["cases"], sep="_")
        left_out = ["season_latitudes", "design", "design_violated_requirements", "design_judged"]
        frame = frame.drop(columns=left_out, errors="ignore")
        return frame.rename(columns=lambda name: name.removesuffix("_label"))


def headline(comparison: Comparison) -> str:
    """Return the first case against the reference, summed up: designs if there are any.

    The first case is the least trustworthy one, where the models are listed from the simplest
    to the fullest and the corrections from none.
    """
    case, reference, name = comparison.cases[0], comparison.reference, comparison.aircraft.name
    by, truth = model_label(case.solar), model_label(reference.solar)
    itself = case.solar == reference.solar
    if case.built is None or reference.built is None:
        text = f"According to {by} {name} {case.prediction.outcome()}"
        other = "" if itself else f"; according to {truth} it {reference.prediction.outcome()}"
        return f"{text}{other}."
    aside = reference.built.result(comparison.objective)
    aside = "" if itself else f" (sized with {truth}: {aside})"
    if case.built.judged is None:
        none = f"no design of {name} meets the requirements"
        if case.built.sizing.status is not SizingStatus.infeasible:
            none = f"{name} comes to no result, as the solver does not converge"
        return f"Sized with {by}, {none}{aside}."
    joined = " and" if itself else f"; evaluated by {truth} it"
    outcome = case.built.judged.outcome(comparison.required_excess_time_h)
    text = f"Sized with {by}, {name} has {case.built.result(comparison.objective)}"
    return f"{text}{joined} {outcome}{aside}."


def blocks(comparison: Comparison, level: int) -> list[Any]:
    """Return predictions, designs, headline, extrapolations and notes."""
    aircraft, mission = comparison.aircraft, comparison.mission
    reference = comparison.reference.solar
    worst = dict.fromkeys(case.prediction.scenario for case in comparison.cases)
    lines = [
        f"reference: {reference.label}; solar energy: of a day, mean of all scenarios",
        f"worst scenario: {' or '.join(worst)}; season: days of perpetual flight in the year",
        *comparison.notes,
        mission.climb_label,
    ]
    subject, models = f"{aircraft.name} on {mission.name}", len(comparison.cases)
    title = f"{subject}: {models} models, reference: {model_label(reference)}"
    notes = [Line(f"- {line}", "faint") for line in lines if line]
    outside = extrapolation_blocks(comparison.extrapolations, level)
    tables: Sequence[Table] = comparison.tables()
    if level < ALL:
        tables = [replace(tables[0], title="", sections=())]
        notes = [Line(text, "faint") for text in comparison.notes]
    return [Line(title, "strong"), *tables, headline(comparison), *outside, *notes]


_OF_ALL = "model correction mean_solar_energy_wh solar_energy_above_reference"
_REACHED = "excess_time_h minimum_state_of_charge charge_margin_h endurance"


def compare(
    aircraft: Aircraft,
    mission: Mission,
    *,
    models: Sequence[ModelName | SolarModel] | None = None,
    corrections: Sequence[CorrectionName] | None = None,
    objective: Objective | str = Objective.min_wingspan,
    required_excess_time_h: float | None = None,
    design: bool = True,
    progress: Progress | None = None,
) -> Comparison:
    """Compare solar power models on an aircraft and a mission.

    Parameters
    ----------
    aircraft, mission
        Aircraft and mission; VM, FM and the loiter correction need module surfaces and a flight
        path.
    models : sequence of str or SolarModel, optional
        Names, combined with every one of the corrections, or models with their own correction; by
        default all that can be computed.
    corrections : sequence of str, optional
        Names; by default all that can be computed.
    objective : Objective or str
        Objective of a parametric aircraft's sizings.
    required_excess_time_h : float, optional
        Excess time that every scenario must have, instead of the mission's [h].
    design : bool
        Size a parametric aircraft with every model.
    progress : callable, optional
        Called with the steps done and the steps in all.

    Returns
    -------
    Comparison

    Raises
    ------
    ValueError
        If a name does not exist, or a model lacks the surfaces or the path.
    ImpossibleDesignError
        If a parametric aircraft cannot carry its own mass.
    """
    goal = resize_objective(objective)
    requested = combinations(models, corrections, attitude=attitude_is_known(aircraft, mission))
    if not requested:
        raise ValueError("there is no model to compare")
    reference = reference_model(aircraft, mission)
    every = list(dict.fromkeys([*requested, reference]))
    sized = design and isinstance(aircraft.airframe, ParametricAirframe)
    required = mission.required_excess_time_h
    required = required if required_excess_time_h is None else required_excess_time_h
    latitudes = mission.latitudes()
    total, steps = len(latitudes) + len(every) * (2 if sized else 1), itertools.count(1)

    def advance() -> None:
        if progress is not None:
            progress(next(steps), total)

    sun = Sunlight(aircraft, mission)
    flags = {}
    for latitude in latitudes:
        flags[latitude] = perpetual_flags(aircraft, mission, latitude, every)
        advance()
    simulate = partial(performance, aircraft, mission, keep_trajectory=False)
    predictions = {solar: predict(simulate, solar, sun.day(solar)) for solar in every}
    truth_wh = predictions[reference].mean_solar_energy_wh
    cases, outside = {}, {}
    for solar, prediction in predictions.items():
        advance()
        day, highest_m = sun.day(solar), prediction.maximum_altitude_m
        checks = day_checks(aircraft, mission, design_of(aircraft, mission), solar, day, highest_m)
        outside[solar] = list(collect_extrapolations(checks, day.scenarios))
        built = None
        if sized:
            result = size_aircraft(
                aircraft, mission, goal, solar, required_excess_time_h=required, day=day
            )
            judged = None
            if result.design is not None:
                best = result.design.variables
                fly = partial(performance_of_designs, aircraft, mission, best, reference)
                judged = predict(fly, reference, sun.day(reference))
            if result.simulated is not None:
                outside[solar] += extrapolations(aircraft, result.simulated)
            built = Built(result, judged)
            advance()
        above = prediction.mean_solar_energy_wh / truth_wh - 1.0 if truth_wh > 0.0 else None
        seasons = {latitude: season_of(days[solar], latitude) for latitude, days in flags.items()}
        all_year = np.logical_and.reduce([days[solar] for days in flags.values()])
        season = season_of(all_year, float(np.mean(latitudes)))
        cases[solar] = Case(solar, prediction, above, season, seasons, built)
    lacking = [f"modules.geometry of {aircraft.name}"] * (aircraft.modules.geometry is None)
    lacking += [f"flight_path of {mission.name}"] * (mission.flight_path is None)
    notes: tuple[str, ...] = ()
    if lacking:
        needed = f"VM, FM and the loiter correction need {' and '.join(lacking)}"
        notes = (f"{needed}; without, corrected {reference.model} is the reference",)
    elif sized:
        path = "the reference flies the path of the mission at its airspeed"
        notes = (f"{path}, whatever the design's own",)
    return Comparison(
        aircraft=aircraft,
        mission=mission,
        objective=goal,
        required_excess_time_h=required,
        reference=cases[reference],
        cases=tuple(cases[solar] for solar in requested),
        notes=notes,
        extrapolations=merge_extrapolations(
            [keep_worst(outside[solar]) for solar in requested], "cases"
        ),
    )
