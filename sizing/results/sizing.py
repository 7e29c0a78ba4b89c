"""Sizing of an aircraft for a mission, with all that is asked about it: ``size``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, cast

from missions.files.overrides import with_values
from missions.mission import Mission
from missions.weather.files import mission_at_site
from missions.weather.record import Weather
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.light import SolarModel
from sizing.mass_budget import ImpossibleDesignError
from sizing.parameters import all_replaced
from sizing.program.cross_check import cross_check
from sizing.program.endurance import longest_flight_of_all
from sizing.program.margin import MarginCase
from sizing.program.objectives import Objective
from sizing.program.own_terms import with_own_terms
from sizing.program.ranges import widest_range
from sizing.program.relaxations import relaxations
from sizing.program.reliability import check_reliability, size_reliably
from sizing.program.result import SizingResult, SizingStatus
from sizing.program.sensitivity import constraint_multipliers, sensitivities
from sizing.program.size import size_aircraft, sized_in_own_flow
from sizing.program.survival import SurvivalSizing, check_survival, in_the_record
from sizing.program.whole_cells import size_whole_cells
from sizing.results.design_result import check_subjects
from sizing.results.sizing_study import BuiltDesign, SeasonDays, SizingStudy, Survival, study_of
from sizing.structures.build import build_qualities
from sizing.structures.models import UserStructure
from solar.names import CorrectionName, ModelName


def size(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective | str | Callable[[Any], Any] = Objective.min_mass,
    *,
    required_excess_time_h: float | None = None,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    with_sensitivities: bool = False,
    with_cross_check: bool = False,
    with_margin: bool = False,
    with_builds: bool = False,
    reliability: float | None = None,
    constraints: Sequence[Callable[[Any], Any]] = (),
    whole_cells: bool = False,
) -> SizingStudy:
    """Find the best design of a parametric aircraft for a mission, or say why there is none.

    Parameters
    ----------
    aircraft : Aircraft
        A parametric one; its ``design_space`` bounds what is chosen.
    mission : Mission
        All of its latitudes and dates must be flown.
    objective : Objective, str or callable
        ``min_mass``, ``min_wingspan``, ``max_excess_time``, ``max_payload_mass``,
        ``max_payload_power``, ``max_endurance``, ``longest_season`` or ``widest_latitude_band``; or
        a function of the design that is to be as small as possible, such as
        ``lambda design: design.total_mass_kg + 0.5 * design.wingspan_m``. It is called once, with
        symbols: arithmetic, NumPy's and CasADi's functions take them, ``if`` and ``max`` do not. A
        wrong name is answered with all that there are.
    required_excess_time_h : float, optional
        Excess time that every scenario must have [h], instead of the mission's.
    model : {"CAM", "CDM", "VM", "FM"}
        Solar power model.
    correction : {"none", "report", "loiter"}
        Correction of the model's systematic error.
    with_sensitivities : bool
        Also what each technology parameter and constraint is worth.
    with_cross_check : bool
        Also try to beat the optimum with thousands of other designs in the simulator.
    with_margin : bool
        Also the design that keeps the requirement with one RMS error of the model less solar power;
        not of a range, with a reliability, or where the mission has uncertainty margins itself.
    with_builds : bool
        Also the best design of each class of ``airframe.structure.build``; not of a range, with a
        reliability, or for whole cells.
    reliability : float, optional
        Least probability that every scenario has the required excess time when the inputs scatter
        as the ``uncertainty`` of aircraft and mission says; above 0 and below 1.
    constraints : sequence of callable
        Further requirements on the design, functions that return one comparison by ``<=`` or
        ``>=``: ``lambda design: design.wing_loading_kg_per_m2 <= 3``. Answers name a function by
        its name, a lambda by what it compares.
    whole_cells : bool
        The best design of whole solar and battery cells instead of the relaxed optimum, for an
        aircraft with ``modules.layout`` and ``battery.pack``.

    Returns
    -------
    SizingStudy

    Raises
    ------
    TypeError
        For a measured aircraft, or what is no aircraft or mission.
    InputError
        With a reliability, for uncertain inputs that contradict the files' rules.
    ValueError
        For an unknown objective, model or correction, an impossible required excess time, or a
        reliability without uncertain inputs, of a range, or with sensitivities or a cross-check;
        for whole cells of an aircraft without a layout or a pack, of a range, or with any of these.
    """
    check_subjects(aircraft, mission)
    solar, required_h = SolarModel(model, correction), required_excess_time_h
    subject, goal = _with_user_terms(aircraft, mission, objective, constraints)
    if goal is Objective.max_endurance:
        longest = longest_flight_of_all(subject, mission, solar, required_excess_time_h=required_h)
        launched = mission if longest.simulated is None else longest.simulated.mission
        return study_of(subject, launched, longest, solar)
    demanding = mission
    if required_h is not None:
        # The mission's rules for its own requirement hold for another one, too.
        demanding = with_values(mission, {"required_excess_time_h": required_h})
        required_h = demanding.required_excess_time_h
    of_optimum = with_sensitivities or with_cross_check
    if whole_cells:
        if of_optimum or reliability is not None:
            raise ValueError(
                "whole cells have no sensitivities, cross-check or reliability: leave them out"
            )
        result, cells = size_whole_cells(
            subject, mission, goal, solar, required_excess_time_h=required_h
        )
        if cells.relaxed.feasible:
            laid = subject if cells.aircraft is None else cells.aircraft
            return study_of(laid, mission, result, solar, whole_cells=cells)
    if reliability is not None:
        if of_optimum:
            raise ValueError("sensitivities and cross-check know of no reliability: leave one out")
        case = (subject, demanding, goal, solar)
        check_reliability(*case, reliability)
        result, reached = size_reliably(MarginCase(*case), reliability)
        # What would help is known of a sizing that fails without uncertainty as well.
        failed = result.status is SizingStatus.infeasible and reached is None
        relaxed = tuple(relaxations(subject, demanding, result, solar)) if failed else ()
        return study_of(subject, demanding, result, solar, relaxations=relaxed, reliability=reached)
    cooled, result, aspects = _without_uncertainty(subject, mission, goal, solar, required_h)
    optimum = (cooled, mission, result, solar)
    if result.feasible and with_sensitivities:
        multipliers = sorted(constraint_multipliers(result), key=lambda row: -row.gain)
        aspects |= {"sensitivities": sensitivities(*optimum[:3]), "multipliers": multipliers}
    if result.feasible and with_cross_check:
        aspects["cross_check"] = cross_check(*optimum)
    if result.feasible and with_margin and not goal.of_range:
        aspects["with_margin"] = _with_margin(*optimum)
    if with_builds and not goal.of_range:
        aspects["builds"] = designs_by_build(
            subject, mission, goal, solar, result, required_excess_time_h=required_h
        )
    return study_of(aircraft, mission, result, solar, cooled=cooled, **aspects)


def _without_uncertainty(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    required_h: float | None,
) -> tuple[Aircraft, SizingResult, dict[str, Any]]:
    """Return the sizing for certain inputs, with what would help an infeasible one.

    A mission with climbs is sized for level flight as well. The aircraft has the cooling of the
    optimum's airflow.
    """
    if objective.of_range:
        coverage = widest_range(
            aircraft, mission, objective, solar, required_excess_time_h=required_h
        )
        return aircraft, coverage.sizing, {"coverage": coverage}
    cooled, result = sized_in_own_flow(
        aircraft, mission, objective, solar, required_excess_time_h=required_h
    )
    others: dict[str, Any] = {}
    if mission.climb is not None:
        others["without_climbs"] = size_aircraft(
            cooled,
            mission.at_altitude(mission.altitude_m),
            objective,
            solar,
            explain=False,
            required_excess_time_h=required_h,
        )
    if result.status is SizingStatus.infeasible:
        others["relaxations"] = tuple(relaxations(cooled, mission, result, solar))
    return cooled, result, others


def _with_margin(
    aircraft: Aircraft, mission: Mission, optimum: SizingResult, solar: SolarModel
) -> SizingStudy | None:
    """Return the sizing with one RMS error less solar power; None with margins of the mission."""
    if mission.uncertainty_margins.is_set or optimum.design is None:
        return None
    guarded = with_values(mission, {"uncertainty_margins.solar_model_sigmas": 1.0})
    result = size_aircraft(
        aircraft,
        guarded,
        optimum.objective,
        solar,
        required_excess_time_h=optimum.required_excess_time_h,
        start=optimum.design.variables,
    )
    return study_of(aircraft, guarded, result, solar)


def _with_user_terms(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective | str | Callable[[Any], Any],
    constraints: Sequence[Callable[[Any], Any]],
) -> tuple[Aircraft, Objective]:
    """Return the aircraft with user-defined terms in its design space, and the objective."""
    user_defined: Callable[[Any], Any] | None = None
    if callable(objective):
        user_defined, named = objective, Objective.min_mass
    else:
        named = checked_objective(objective)
    if (user_defined is None and not constraints) or isinstance(
        aircraft.airframe, MeasuredAirframe
    ):
        return aircraft, named
    aircraft, minimised = with_own_terms(aircraft, mission, user_defined, constraints)
    # It answers as an objective does.
    return aircraft, named if minimised is None else cast(Objective, minimised)


def checked_objective(objective: Objective | str) -> Objective:
    """Return the objective of a name; refuse an unknown one."""
    try:
        return Objective(objective)
    except ValueError:
        allowed = ", ".join(Objective)
        raise ValueError(f"objective must be one of {allowed} (got {objective!r})") from None


def designs_by_build(
    aircraft: Aircraft,
    mission: Mission,
    objective: Objective,
    solar: SolarModel,
    result: SizingResult,
    *,
    required_excess_time_h: float | None,
) -> tuple[BuiltDesign, ...]:
    """Return the best design of every build quality; ``result``: that of the aircraft's file.

    A calibration without ``build`` may be that of one's own aircraft: the classes have that of
    AtlantikSolar. A structure of the user's own has no classes.
    """
    structure = aircraft.parametric.structure
    if isinstance(structure, UserStructure):
        return ()
    fitted: dict[str, Any] = {}
    if structure.build is None and structure.atlantiksolar_calibration is not None:
        fitted["calibration"] = structure.atlantiksolar_calibration
    designs = []
    for name, quality in build_qualities().items():
        changed = all_replaced(structure, fitted | {"build": name})
        of_file = bool(changed.mass_factor == structure.mass_factor)
        sizing: SizingResult | None = result
        if not of_file:
            start = None if result.design is None else result.design.variables
            built = aircraft.with_airframe(structure=changed)
            try:
                _, sizing = sized_in_own_flow(
                    built,
                    mission,
                    objective,
                    solar,
                    start=start,
                    required_excess_time_h=required_excess_time_h,
                )
            except ImpossibleDesignError:  # its propulsion flies no design
                sizing = None
        design, value = (None, None) if sizing is None else (sizing.design, sizing.objective_value)
        designs.append(BuiltDesign(name, quality.factor, of_file, design, value))
    return tuple(designs)


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
