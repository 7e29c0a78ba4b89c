"""Performance of an aircraft on a mission: solar power, load and battery put together."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from missions.loiter_power import mean_power_on_path
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import (
    Design,
    DesignVariables,
    closed_design,
    design_of,
    load_profile,
)
from sizing.energy.cycle import Cycle, simulate_cycle
from sizing.energy.endurance import Endurance, longest_flight
from sizing.energy.march import FloatArray, Store
from solar.correction import correction
from solar.names import (
    ATTITUDE_MODELS,
    CORRECTION_NAMES,
    MODEL_NAMES,
    CorrectionName,
    ModelName,
)
from solar.power import horizontal_specific_power
from solar.sun import declination, sun_times

DEFAULT_STEP_H = 1.0 / 12.0
# Scenarios whose best launch is searched for together.
_SCENARIOS_AT_ONCE = 2048


@dataclass(frozen=True)
class SolarModel:
    """Which solar power model is believed, and how its systematic error is treated."""

    model: ModelName = "CAM"
    correction: CorrectionName = "none"

    def __post_init__(self) -> None:
        """Refuse unknown names."""
        for word, name, allowed in (
            ("model", self.model, MODEL_NAMES),
            ("correction", self.correction, CORRECTION_NAMES),
        ):
            if name not in allowed:
                raise ValueError(f"unknown {word} {name!r}; allowed: {', '.join(allowed)}")

    @property
    def rms_relative(self) -> float:
        """RMS error of the model relative to the mean measured power [-]."""
        return correction(self.model, self.correction).rms_relative


UNCORRECTED_CAM = SolarModel()


@dataclass(frozen=True)
class SolarDay:
    """Specific power over the day in each scenario: all that a design needs of the sun.

    ``specific_power_w_per_m2`` has the shape ``(scenario, time)``; ``sunrise_h`` and ``sunset_h``
    are those of the geometric sun [solar h].
    """

    scenarios: Scenarios
    time_h: FloatArray
    specific_power_w_per_m2: FloatArray
    sunrise_h: FloatArray
    sunset_h: FloatArray

    def scaled(self, factor: float) -> SolarDay:
        """Same day with all power multiplied by a factor."""
        return replace(self, specific_power_w_per_m2=self.specific_power_w_per_m2 * factor)

    def at(self, indices: ArrayLike) -> SolarDay:
        """Same day in some of its scenarios."""
        some = np.asarray(indices, int)
        of = self.scenarios
        return SolarDay(
            Scenarios(of.latitude_deg[some], of.day_of_year[some]),
            self.time_h,
            self.specific_power_w_per_m2[some],
            np.asarray(self.sunrise_h)[some],
            np.asarray(self.sunset_h)[some],
        )


def day_axis_h(step_h: float = DEFAULT_STEP_H) -> FloatArray:
    """Nodes from 0 to 24 h, at most ``step_h`` apart.

    Raises
    ------
    ValueError
        If the step is not between 1 s and 1 h.
    """
    if not 1.0 / 3600.0 <= step_h <= 1.0:
        raise ValueError(f"step_h must be from 1/3600 to 1 (got {step_h:g})")
    return np.linspace(0.0, 24.0, int(np.ceil(24.0 / step_h - 1e-9)) + 1)


def solar_day(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    scenarios: Scenarios | None = None,
    step_h: float = DEFAULT_STEP_H,
) -> SolarDay:
    """Specific power of an aircraft's modules in the mission's (or other) scenarios."""
    chosen = mission.scenarios() if scenarios is None else scenarios
    time_h = day_axis_h(step_h)
    times = sun_times(chosen.latitude_deg, declination(chosen.noon_day))
    power = modelled_power(aircraft, mission, solar.model, chosen, time_h)
    if solar.correction == "loiter":
        power = power * loiter_ratio(aircraft, mission, solar.model, chosen, time_h, power)
    factor = judged_factor(mission, solar)
    corrected = power if factor == 1.0 else power * factor
    return SolarDay(chosen, time_h, corrected, times.sunrise_h, times.sunset_h)


def judged_factor(mission: Mission, solar: SolarModel) -> float:
    """Factor on a model's power: its correction, and the low end of the mission's band."""
    factor = correction(solar.model, solar.correction).factor
    return factor * mission.bands.solar_factor(solar.rms_relative)


def modelled_power(
    aircraft: Aircraft, mission: Mission, model: ModelName, scenarios: Scenarios, time_h: FloatArray
) -> FloatArray:
    """Specific power of a model, uncorrected, over scenarios and time [W/m2].

    VM and FM are averaged over the mission's flight path.

    Raises
    ------
    ValueError
        If VM or FM lack the aircraft's module geometry or the mission's flight path.
    """
    if model not in ATTITUDE_MODELS:
        latitude, day = scenarios.latitude_deg, scenarios.noon_day
        # In memory the time comes first: the simulator marches over it, all scenarios at once.
        column = time_h[:, np.newaxis]
        return _horizontal_power(aircraft, mission, model, latitude, day, column).T
    pairs = zip(scenarios.latitude_deg, scenarios.noon_day, strict=True)
    return np.stack(
        [_power_on_path(aircraft, mission, model, float(lat), day, time_h) for lat, day in pairs]
    )


def power_on_calendar(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    day_of_year: FloatArray,
    time_solar_h: FloatArray,
) -> FloatArray:
    """Specific power at a mission's single latitude while the date advances, corrected [W/m2].

    Parameters
    ----------
    day_of_year, time_solar_h : ndarray, shape (time,)
        Fractional day of year and local solar time [h] at each instant.
    """
    latitude = mission.latitudes()[0]
    if solar.model in ATTITUDE_MODELS:
        power = _power_on_path(aircraft, mission, solar.model, latitude, day_of_year, time_solar_h)
    else:
        power = _horizontal_power(
            aircraft, mission, solar.model, latitude, day_of_year, time_solar_h
        )
    if solar.correction == "loiter":
        days, place = np.unique(np.floor(day_of_year).astype(int), return_inverse=True)
        scenarios = Scenarios(np.full(len(days), latitude), (days - 1) % 365 + 1)
        axis = day_axis_h()
        repeated = modelled_power(aircraft, mission, solar.model, scenarios, axis)
        ratio = loiter_ratio(aircraft, mission, solar.model, scenarios, axis, repeated)
        power = power * ratio[place, 0]
    return power * judged_factor(mission, solar)


def _horizontal_power(
    aircraft: Aircraft,
    mission: Mission,
    model: ModelName,
    latitude_deg: ArrayLike,
    day_of_year: ArrayLike,
    time_solar_h: ArrayLike,
) -> FloatArray:
    return horizontal_specific_power(
        latitude_deg,
        day_of_year,
        time_solar_h,
        cell=aircraft.modules,
        module_temperature_c=mission.module_temperature_c(),
        altitude_m=mission.altitude_m,
        clearness=mission.judged_clearness,
        model=model,
    )


def _power_on_path(
    aircraft: Aircraft,
    mission: Mission,
    model: ModelName,
    latitude_deg: float,
    day_of_year: ArrayLike,
    time_solar_h: FloatArray,
) -> FloatArray:
    geometry, path = aircraft.modules.geometry, mission.flight_path
    if geometry is None:
        raise ValueError(f"model {model} needs modules.geometry on the aircraft {aircraft.name}")
    if path is None:
        raise ValueError(f"model {model} needs a flight_path on the mission {mission.name}")
    return mean_power_on_path(
        model,
        latitude_deg,
        day_of_year,
        time_solar_h,
        geometry=geometry,
        cell=aircraft.modules,
        path=path,
        wind=mission.wind,
        ambient_temperature_c=float(mission.air_state().temperature_c),
        module_temperature_c=mission.module_temperature_c(),
        altitude_m=mission.altitude_m,
        clearness=mission.judged_clearness,
        shading=aircraft.modules.shading,
    )


def loiter_ratio(
    aircraft: Aircraft,
    mission: Mission,
    model: ModelName,
    scenarios: Scenarios,
    time_h: FloatArray,
    power: FloatArray,
) -> FloatArray:
    """Daily energy of the Full Model on the flight path over that of a model, per scenario.

    The single numbers of the report hold for one morning; this ratio holds for the latitude, the
    day, the wind and the path at hand. It is 1 where no sun is seen. Shape ``(scenario, 1)``.
    """
    if model == "FM":
        return np.ones((len(scenarios), 1))
    full = modelled_power(aircraft, mission, "FM", scenarios, time_h)
    ours = np.trapezoid(power, time_h, axis=-1)
    theirs = np.trapezoid(full, time_h, axis=-1)
    lit = ours > 0.0
    return np.where(lit, theirs / np.where(lit, ours, 1.0), 1.0)[:, np.newaxis]


@dataclass(frozen=True)
class Performance:
    """Converged cycles of a design in its scenarios, and what went in.

    Arrays have the scenarios on their last batch axis; with a batch of designs those come first.
    """

    design: Design
    mission: Mission
    solar: SolarModel
    day: SolarDay
    solar_power_w: FloatArray
    load_w: FloatArray
    nominal_load_w: FloatArray
    store: Store
    cycle: Cycle

    def worst_scenario(self) -> int:
        """Index of the scenario with the least excess time (of a single design)."""
        return int(np.argmin(self.cycle.excess_time_h))

    def endurances(self) -> list[Endurance | None]:
        """Longest flight in every scenario (of a single design); none where it has no end."""
        ends = np.flatnonzero(~self.cycle.perpetual)
        found: list[Endurance | None] = [None] * len(self.cycle.status)
        flights = self._longest_flights(ends)
        for k, index in enumerate(ends):
            found[index] = Endurance(flights.endurance_h[k], flights.launch_h[k])
        return found

    def endurance_h(self) -> FloatArray:
        """Longest flight in every scenario (of a single design) [h], infinite if perpetual."""
        ends = np.flatnonzero(~self.cycle.perpetual)
        hours = np.full(len(self.cycle.status), np.inf)
        hours[ends] = self._longest_flights(ends).endurance_h
        return hours

    def _longest_flights(self, scenarios: NDArray[np.intp]) -> Endurance:
        energy = np.broadcast_to(self.store.energy_max_wh, self.cycle.status.shape)
        hours, launch = np.empty((2, len(scenarios)))
        for start in range(0, len(scenarios), _SCENARIOS_AT_ONCE):
            part = slice(start, start + _SCENARIOS_AT_ONCE)
            some = scenarios[part]
            store = replace(self.store, energy_max_wh=energy[some])
            flights = longest_flight(
                self.day.time_h, self.solar_power_w[some], self.load_w[some], store
            )
            hours[part], launch[part] = flights.endurance_h, flights.launch_h
        return Endurance(hours, launch)


def performance(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    day: SolarDay | None = None,
    step_h: float = DEFAULT_STEP_H,
    keep_trajectory: bool = True,
) -> Performance:
    """Simulate an aircraft, as its file describes it, in every scenario of a mission.

    Without ``keep_trajectory`` the stored energy over time is not kept.
    """
    lit = solar_day(aircraft, mission, solar, step_h=step_h) if day is None else day
    design = design_of(aircraft, mission)
    return _simulate(aircraft, mission, solar, design, lit, keep_trajectory=keep_trajectory)


def performance_of_designs(
    aircraft: Aircraft,
    mission: Mission,
    variables: DesignVariables,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    day: SolarDay | None = None,
    step_h: float = DEFAULT_STEP_H,
) -> Performance:
    """Simulate a batch of designs of a parametric aircraft in every scenario of a mission.

    ``variables`` are arrays that broadcast to the shape of the batch; results have that shape
    plus an axis of scenarios. A design that cannot carry itself has an excess time of -24 h.
    """
    lit = solar_day(aircraft, mission, solar, step_h=step_h) if day is None else day
    design = closed_design(aircraft, mission, variables)
    return _simulate(aircraft, mission, solar, design, lit, keep_trajectory=True)


def performance_of_pairs(
    aircraft: Aircraft,
    mission: Mission,
    variables: DesignVariables,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    day: SolarDay,
) -> Performance:
    """Simulate one design of a parametric aircraft in every scenario of a day.

    ``variables`` are arrays over the scenarios, and so are the results.
    """
    design = closed_design(aircraft, mission, variables)
    return _simulate(aircraft, mission, solar, design, day, keep_trajectory=False, paired=True)


def _simulate(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    design: Design,
    day: SolarDay,
    *,
    keep_trajectory: bool,
    paired: bool = False,
) -> Performance:
    """Simulate every design in every scenario, or ``paired``: every design in its own."""

    def over_scenarios(value: ArrayLike) -> FloatArray:
        return np.asarray(value) if paired else np.asarray(value)[..., np.newaxis]

    # An impossible design draws infinite power; a finite, hopeless one keeps the arithmetic clean.
    power_w = np.asarray(design.propulsion_power_w)
    sound = design._replace(propulsion_power_w=np.where(np.isfinite(power_w), power_w, 1e12))
    area = over_scenarios(design.variables.module_area_m2)[..., np.newaxis]
    solar_w = area * day.specific_power_w_per_m2
    per_scenario = sound._replace(
        propulsion_power_w=over_scenarios(sound.propulsion_power_w),
        constant_power_w=over_scenarios(sound.constant_power_w),
    )
    load_w = load_profile(day.time_h, per_scenario, mission, day.sunrise_h, day.sunset_h)
    load_w = np.broadcast_to(load_w, np.broadcast_shapes(load_w.shape, solar_w.shape))
    nominal = np.asarray(per_scenario.nominal_load_w(mission))
    store = Store.of(aircraft.battery, over_scenarios(design.battery_energy_wh))
    cycle = simulate_cycle(
        day.time_h,
        solar_w,
        load_w,
        store,
        nominal_load_w=nominal,
        keep_trajectory=keep_trajectory,
    )
    return Performance(design, mission, solar, day, solar_w, load_w, nominal, store, cycle)


def perpetual_days(
    aircraft: Aircraft,
    mission: Mission,
    latitude_deg: float,
    solar: SolarModel = UNCORRECTED_CAM,
    *,
    days: ArrayLike | None = None,
) -> NDArray[np.int_]:
    """Days of the year, ascending, on which the aircraft flies perpetually at a latitude."""
    every = np.arange(1, 366) if days is None else np.asarray(days, int)
    scenarios = Scenarios(np.full(len(every), float(latitude_deg)), every)
    lit = solar_day(aircraft, mission, solar, scenarios=scenarios)
    return every[performance(aircraft, mission, solar, day=lit).cycle.perpetual]
