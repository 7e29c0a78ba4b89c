"""Sizing for a share of the days of a season, in a weather record: ``size --weather``."""

from __future__ import annotations

from collections.abc import Callable

from missions.mission import Mission
from missions.weather.record import Weather
from missions.weather.site import mission_at_site
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.light import SolarModel
from sizing.program.margin import MarginCase
from sizing.program.objectives import Objective
from sizing.program.relaxations import relaxations
from sizing.program.result import SizingStatus
from sizing.program.survival import SurvivalSizing, check_survival, in_the_record
from sizing.results.design_result import check_subjects
from sizing.results.season import SeasonDays, Survival
from sizing.results.sizing import checked_objective
from sizing.results.sizing_study import SizingStudy, study_of
from solar.names import CorrectionName, ModelName


def size_in_weather(
    aircraft: Aircraft,
    mission: Mission,
    weather: Weather,
    objective: Objective | str = Objective.min_mass,
    *,
    survive: float,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    progress: Callable[[int, int], None] | None = None,
) -> SizingStudy:
    """Find the best design for which a share of the days of a season closes in a weather record.

    A day closes if, begun at dawn with the charge carried over from the day before, it reaches the
    next dawn without an empty battery. The season is the mission's dates, in all years of the
    record.

    Parameters
    ----------
    aircraft : Aircraft
        A parametric one; its ``design_space`` bounds what is chosen.
    mission : Mission
        Dates, altitude, air, turbulence, payload, flight path and margins; it is flown at the
        record's site. Its clearness and required excess time play no part: the clouds are the
        record's.
    weather : Weather
        Record (:func:`missions.load_weather`).
    objective : Objective or str
        ``min_mass``, ``min_wingspan``, ``max_payload_mass`` or ``max_payload_power``.
    survive : float
        Least share of the season's days that close [-], above 0 and at most 1.
    model : {"CAM", "CDM", "VM", "FM"}
        Solar power model.
    correction : {"none", "report", "loiter"}
        Correction of the model's systematic error.
    progress : callable, optional
        Called with the steps of the search that are done, and those in all, which may become more.

    Returns
    -------
    SizingStudy
        Its ``survival`` tells the days. Everything else is that of the design under a clear sky, on
        the mission's dates at the record's site.

    Raises
    ------
    InputError
        If the mission climbs, is far from the site, flies below its ground, or has no day in the
        record.
    TypeError
        For a measured aircraft, or what is no aircraft or mission.
    ValueError
        For an unknown objective, model or correction, one that no share of days can be asked of, or
        a share that is none.
    """
    check_subjects(aircraft, mission)
    goal, solar = checked_objective(objective), SolarModel(model, correction)
    check_survival(goal, survive)
    if isinstance(aircraft.airframe, MeasuredAirframe):
        raise TypeError(f"{aircraft.name} is a measured aircraft: it has no mass budget to size")
    moved, notes = mission_at_site(mission, weather)
    if mission.required_excess_time_h > 0.0:
        notes += (
            f"the mission's required excess time of {mission.required_excess_time_h:g} h is not "
            "asked for: it is a margin for clouds, and these are the record's",
        )
    if mission.pessimistic_clearness < 1.0:
        notes += (
            f"the mission's clearness of {mission.pessimistic_clearness:g} plays no part: the "
            "clouds are the record's",
        )
    there = in_the_record(moved)
    case = MarginCase(aircraft, there, goal, solar)
    search = SurvivalSizing(case, weather, survive, progress or (lambda done, steps: None))
    result, clear, shown = search.run()
    if shown is None:
        failed = clear.status is SizingStatus.infeasible
        relaxed = tuple(relaxations(aircraft, there, clear, solar)) if failed else ()
        return study_of(aircraft, there, result, solar, relaxations=relaxed)
    days, of_clear = (
        None
        if sizing.design is None
        else SeasonDays.of(search.days.axis, search.season, search.closes(sizing))
        for sizing in (shown, clear)
    )
    assert days is not None
    survival = Survival(
        weather,
        there,
        survive,
        days=days,
        clear_sky=clear,
        clear_sky_days=of_clear,
        notes=notes,
    )
    return study_of(aircraft, there, result, solar, survival=survival)
