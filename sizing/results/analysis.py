"""Analysis of one aircraft on one mission: every scenario's cycle, and the flight if it has one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from missions.dates import date_code
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.balance.assessment import BalanceAssessment, balance_assessment, drag_shares
from sizing.balance.drag import DragShares
from sizing.climb import (
    ClimbOfDay,
    ClimbPerformance,
    compare_with_constant,
    fine_step_excess_time_h,
)
from sizing.day.heights import check_climb_limits
from sizing.day.light import SolarModel, solar_day
from sizing.day.replay import CalendarRun, calendar_run
from sizing.design import Design
from sizing.mass_budget import design_of
from sizing.performance import MEASURES, OF_SCENARIO, Performance, performance
from sizing.relaxed_flight import Relaxation, relaxed_flight
from sizing.results.design_result import (
    DesignResult,
    PartMasses,
    PowerBudget,
    beyond_parts,
    check_subjects,
    described,
    part_masses,
    power_budget,
)
from sizing.results.result import data_frame
from sizing.sized_structure import structure_assessment
from sizing.structures.assessment import StructureAssessment
from sizing.validity.extrapolations import (
    add_effects,
    extrapolations,
    keep_worst,
    replay_extrapolations,
)
from sizing.validity.ranges import Extrapolation
from solar.names import CorrectionName, ModelName
from solar.types import FloatArray

if TYPE_CHECKING:
    import pandas as pd


_OF_FRAME = (
    "status",
    "excess_time_h",
    "charge_margin_h",
    "endurance_h",
    "minimum_state_of_charge",
    "solar_energy_wh",
    "load_energy_wh",
)


class ClimbCheck(NamedTuple):
    """Excess time of heights by the program that chose them, and in steps of a minute [h]."""

    program_excess_time_h: float
    one_minute_excess_time_h: float


@dataclass(frozen=True)
class LimitedFlight:
    """Flights that start full and end with an empty battery, in solar time [h].

    ``launch_h``, ``endurance_h``: launch and length of the longest. ``before_sun_h``: from its end
    until solar power meets the load again; NaN where it never does. ``from_sunrise_h``,
    ``from_noon_h``: length of those launched at sunrise and at noon; NaN without a sunrise.
    """

    launch_h: float
    endurance_h: float
    before_sun_h: float
    from_sunrise_h: float
    from_noon_h: float

    @property
    def empty_h(self) -> float:
        """Return when the longest flight ends, counted from midnight before its launch [h]."""
        return self.launch_h + self.endurance_h


@dataclass(frozen=True)
class Scenario:
    """A scenario of an analysis: where, when, and what becomes of the flight there.

    ``quantities``: measures, infinite where unlimited, NaN where there is none.
    ``excess_time_low_h``, ``excess_time_high_h``: with one RMS error of the model less and more
    solar power [h]. ``climb``: its climbs; None without them.
    """

    solar: SolarModel
    latitude_deg: float
    day_of_year: int
    date: str
    label: str
    quantities: dict[str, Any]
    excess_time_low_h: float
    excess_time_high_h: float
    climb: ClimbOfDay | None


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Analysis(DesignResult):
    """Performance of an aircraft in the scenarios of a mission.

    The numbers at the top of :meth:`to_dict` are attributes of the same names: those of the worst
    scenario (``excess_time_h``, ``endurance_h``, ``minimum_state_of_charge`` ...) and those of the
    design (``total_mass_kg``, ``masses_kg`` ...). Where a number is unlimited the attribute is
    infinite, as in :meth:`to_frame`, and where there is none NaN; both are null in the record.

    Attributes
    ----------
    aircraft, mission
        What was analysed.
    performance : Performance
        Cycles of all scenarios.
    low, high : Performance
        Flight with the solar power one RMS error of the model lower and higher.
    flight : CalendarRun or None
        Replay of the mission's launch, where it has one.
    worst : int
        Index of the scenario with the least excess time.
    values : dict
        Measures of all scenarios: infinite where unlimited, NaN where there is none.
    scenarios : tuple of Scenario
        Every scenario.
    limited_flight : LimitedFlight or None
        Flights in the worst scenario; None where it is unlimited or outlasts a year.
    relaxations : tuple of Relaxation
        What alone would make it perpetual, smallest relative change first: battery mass, module
        area or load. Empty where it is perpetual, for a mission with climbs, and for one with a
        flight that lands.
    climb : ClimbPerformance or None
        Climbs beside flight at constant altitude; None for a mission without them.
    climb_check_h : ClimbCheck or None
        Both excess times of the worst scenario; None where it does not climb.
    beyond_parts : str or None
        Why the propulsion's parts cannot do the greatest load of the day; None if they can.
    extrapolations : tuple of Extrapolation
        What lies outside the range of a model, each quantity once.
    structure : StructureAssessment or None
        What sizes the structure; None where the aircraft's model of it does not say.
    power_budget : PowerBudget
        Where the power of level flight goes, at the mission's altitude.
    part_masses : PartMasses or None
        Masses of the propulsion's parts that are estimated; None where there are none.
    balance : BalanceAssessment or None
        Centre of gravity, static margin and trim; None without ``airframe.balance``.
    drag_coefficients : DragShares or None
        Drag coefficients of the parts in level flight; None without ``airframe.drag``.
    excess_time_h, charge_margin_h, endurance_h, best_launch_h, minimum_state_of_charge, status
        Of the worst scenario, as those that follow; the launch of the longest flight.
    sunrise_h, sunset_h, equal_power_morning_h, equal_power_evening_h, full_charge_h
        Solar times [h]: solar power equals the load for the first and for the last time; the
        battery is full for the first time.
    power_out_w, solar_energy_wh, load_energy_wh, curtailed_energy_wh
        Nominal load; energy of the modules over the day, drawn, and not collected.
    """

    renderer = "studies.render.analysis"

    design: Design
    performance: Performance
    low: Performance
    high: Performance
    flight: CalendarRun | None
    worst: int
    values: dict[str, Any]
    scenarios: tuple[Scenario, ...]
    limited_flight: LimitedFlight | None
    relaxations: tuple[Relaxation, ...]
    climb: ClimbPerformance | None
    climb_check_h: ClimbCheck | None
    beyond_parts: str | None
    extrapolations: tuple[Extrapolation, ...]
    structure: StructureAssessment | None
    power_budget: PowerBudget
    part_masses: PartMasses | None
    balance: BalanceAssessment | None
    drag_coefficients: DragShares | None
    excess_time_h: float
    charge_margin_h: float
    endurance_h: float
    best_launch_h: float
    minimum_state_of_charge: float
    status: str
    sunrise_h: float
    sunset_h: float
    equal_power_morning_h: float
    equal_power_evening_h: float
    full_charge_h: float
    power_out_w: float
    solar_energy_wh: float
    load_energy_wh: float
    curtailed_energy_wh: float

    @property
    def is_perpetual(self) -> bool:
        """Whether the aircraft flies perpetually, or to its landing, in every scenario."""
        return bool(np.all(self.performance.cycle.sufficient))

    @property
    def masses_kg(self) -> dict[str, float] | None:
        """Mass budget [kg]; None for a measured aircraft, whose parts are not known."""
        if isinstance(self.aircraft.airframe, MeasuredAirframe):
            return None
        return {item: float(mass) for item, mass in self.design.masses._asdict().items()}

    @property
    def worst_scenario(self) -> Scenario:
        """Scenario with the least excess time."""
        return self.scenarios[self.worst]

    def scenario(self, index: int | None = None) -> dict[str, Any]:
        """Return the measures of a scenario, by default of the worst."""
        return self.scenarios[self.worst if index is None else index].quantities

    @property
    def airspeed_above_wind(self) -> bool | None:
        """Whether the airspeed is above the mission's wind; None where it is not known."""
        airspeed, wind = self.design.airspeed_m_per_s, self.mission.strongest_wind_m_per_s
        return None if airspeed is None else bool(airspeed > wind)

    def to_frame(self) -> pd.DataFrame:
        """Return the metrics of every scenario, one row each; infinite where unlimited."""
        scenarios = self.performance.day.scenarios
        place = {"latitude_deg": scenarios.latitude_deg, "day_of_year": scenarios.day_of_year}
        return data_frame(place | {key: self.values[key] for key in _OF_FRAME})

    @property
    def curves(self) -> dict[str, FloatArray]:
        """Power, charge and, with climbs, altitude along the cycles, ``(scenario, time)``."""
        perf, energy_wh = self.performance, self.performance.cycle.energy_wh
        charge = energy_wh / float(perf.design.battery_energy_wh)
        curves: dict[str, Any] = {"solar_power_w": perf.solar_power_w, "load_w": perf.load_w}
        curves |= {"energy_wh": energy_wh, "state_of_charge": charge, "altitude_m": perf.altitude_m}
        return {name: curve for name, curve in curves.items() if curve is not None}

    def trajectory(self) -> pd.DataFrame:
        """Return power and state of charge of every scenario's cycle, one row per node of time."""
        time_h, scenarios = self.performance.day.time_h, self.performance.day.scenarios
        places = {
            "latitude_deg": np.repeat(scenarios.latitude_deg, len(time_h)),
            "day_of_year": np.repeat(scenarios.day_of_year, len(time_h)),
            "time_solar_h": np.tile(time_h, len(scenarios)),
        }
        return data_frame(places | {name: each.ravel() for name, each in self.curves.items()})


def analyse(
    aircraft: Aircraft,
    mission: Mission,
    *,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
    replay: bool = True,
    known_mass_kg: float | None = None,
) -> Analysis:
    """Analyse how long an aircraft flies on a mission.

    Parameters
    ----------
    aircraft : Aircraft
    mission : Mission
        Its latitudes and dates are the scenarios.
    model : {"CAM", "CDM", "VM", "FM"}
        Solar power model; VM and FM need module surfaces and a flight path.
    correction : {"none", "report", "loiter"}
        Correction of the model's systematic error.
    replay : bool
        Fly the mission's launch on the calendar, if it has one.
    known_mass_kg : float, optional
        Total mass of the aircraft, as :func:`with_total_mass` made it [kg]: what would make it fly
        perpetually is then told at this mass. By default the mass grows with what is added.

    Returns
    -------
    Analysis

    Raises
    ------
    TypeError
        For what is no aircraft or mission, such as their names.
    ValueError
        For an unknown model or correction, and a model that lacks surfaces or path.
    ImpossibleDesignError
        If a parametric aircraft cannot carry its own mass.
    """
    check_subjects(aircraft, mission)
    solar = SolarModel(model, correction)
    day, design = solar_day(aircraft, mission, solar), design_of(aircraft, mission)
    check_climb_limits(aircraft, mission, design)
    simulated = performance(aircraft, mission, solar, day=day, design=design)
    flight = None
    if replay and mission.launch is not None:
        flight = calendar_run(aircraft, mission, solar)
    return analysis_of(aircraft, mission, simulated, flight, known_mass_kg)


def analysis_of(
    aircraft: Aircraft,
    mission: Mission,
    simulated: Performance,
    flight: CalendarRun | None = None,
    known_mass_kg: float | None = None,
) -> Analysis:
    """Return the analysis of an aircraft whose flight was simulated, and perhaps replayed."""
    solar, design, worst = simulated.solar, simulated.design, simulated.worst_scenario()
    low, high = (
        performance(
            aircraft,
            simulated.mission,
            solar,
            day=simulated.day.scaled(1.0 + error * solar.rms_relative),
            design=design,
        )
        for error in (-1.0, 1.0)
    )
    values = {key: MEASURES[key](simulated) for key in OF_SCENARIO}
    in_worst = {key: np.asarray(each)[worst].item() for key, each in values.items()}
    climb = None
    if simulated.mission.climb is not None:
        climb = compare_with_constant(aircraft, simulated)
    relaxed: tuple[Relaxation, ...] = ()
    if mission.climb is None and mission.flight is None:
        relaxed = relaxed_flight(aircraft, simulated, known_mass_kg)
    outside = extrapolations(aircraft, simulated)
    if flight is not None:
        of_replay = replay_extrapolations(aircraft, mission, solar, flight)
        outside = keep_worst([*outside, *of_replay])
    return Analysis(
        **described(aircraft, mission, design),
        design=design,
        performance=simulated,
        low=low,
        high=high,
        flight=flight,
        worst=worst,
        values=values,
        **in_worst,
        scenarios=_scenarios(simulated, low, high, values, climb),
        limited_flight=_limited_flight(simulated, in_worst),
        relaxations=relaxed,
        climb=climb,
        climb_check_h=_climb_check(aircraft, simulated),
        beyond_parts=beyond_parts(aircraft, simulated),
        extrapolations=add_effects(outside, aircraft, lambda: simulated),
        structure=structure_assessment(aircraft, design),
        power_budget=power_budget(aircraft, mission, design),
        part_masses=part_masses(aircraft, design),
        balance=balance_assessment(aircraft, design),
        drag_coefficients=drag_shares(aircraft, design),
    )


def _scenarios(
    simulated: Performance,
    low: Performance,
    high: Performance,
    values: dict[str, Any],
    climb: ClimbPerformance | None,
) -> tuple[Scenario, ...]:
    """Return every scenario, with its measures and what the model's error does there."""
    at = simulated.day.scenarios
    ends_h = zip(low.cycle.excess_time_h.tolist(), high.cycle.excess_time_h.tolist(), strict=True)
    return tuple(
        Scenario(
            simulated.solar,
            float(at.latitude_deg[i]),
            int(at.day_of_year[i]),
            date_code(int(at.day_of_year[i])),
            at.label(i),
            {key: each[i] for key, each in values.items()},
            *low_and_high_h,
            None if climb is None else ClimbOfDay(climb, i),
        )
        for i, low_and_high_h in enumerate(ends_h)
    )


def _limited_flight(simulated: Performance, worst: dict[str, Any]) -> LimitedFlight | None:
    """Return the flights in the worst scenario, of these measures."""
    launch_h, endurance_h = worst["best_launch_h"], worst["endurance_h"]
    if not np.isfinite(endurance_h):
        return None
    from_sunrise_h = from_noon_h = np.nan
    if np.isfinite(worst["sunrise_h"]):
        launches_h = [worst["sunrise_h"], 12.0]
        at = simulated.worst_scenario()
        from_sunrise_h, from_noon_h = simulated.flight_time_h(at, launches_h)
    before_sun_h = (worst["equal_power_morning_h"] - launch_h - endurance_h) % 24.0
    return LimitedFlight(
        launch_h, endurance_h, before_sun_h, float(from_sunrise_h), float(from_noon_h)
    )


def _climb_check(aircraft: Aircraft, simulated: Performance) -> ClimbCheck | None:
    """Return the excess time of the worst scenario by the program and in steps of a minute."""
    program_h, worst = simulated.program_excess_h, simulated.worst_scenario()
    if program_h is None or np.isnan(program_h[worst]):
        return None
    return ClimbCheck(float(program_h[worst]), fine_step_excess_time_h(aircraft, simulated))
