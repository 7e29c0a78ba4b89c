"""Simulation of many draws of uncertain inputs at once.

Formulas of the sizing take arrays, so that draws are elements of a batch of designs. Solar power of
CDM, CAM and VM is linear in the uncertain factors, so that the sky is computed once.

With climbs the height profile is not optimised for every draw. Each draw flies the optimal profiles
of the nominal aircraft for the next lower and higher ratio of light to load; where neither closes
the day, the profiles at the least light that does, and level flight. The best of these flights is
a lower bound of the draw's own optimum.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.balance import blocks
from sizing.day.light import SolarModel, solar_day
from sizing.day.module_power import balances_heat
from sizing.design import NO_FLIGHT_W, Design, FlightConditions, variables_of
from sizing.mass_budget import design_of, measured_design, parametric_design
from sizing.parameters import with_parameter
from sizing.performance import Performance, fly
from sizing.program.schedule import flown_along
from sizing.propulsion.chain import PARTS, Propulsion
from sizing.propulsion.nearby import NearbyPropulsion
from sizing.roots import lightest_mass
from sizing.uncertainty.inputs import SOLAR_MODEL, UncertainInputs
from sizing.validity.checks import charge_rate_check, correction_check, design_checks
from sizing.validity.extrapolations import collect_extrapolations, keep_worst
from sizing.validity.ranges import Extrapolation
from solar.types import FloatArray, IntArray

# Logarithmic step of light over load, and steps between profiles: within 5 % the optimal profile
# changes little, except where days begin to close.
_LIGHT_STEP, _STRIDE = 0.05 / 8, 8
_TOLERANCE = 1e-10  # relative, of the total mass
# Keys whose effect on VM and FM is not linear in the light.
_OF_HORIZONTAL_MODELS = (
    "modules.camber_efficiency",
    "modules.diffuse_efficiency",
    "modules.temperature_coefficient_per_k",
)
# Keys that change the path of the sun, or cannot differ within a batch.
_FIXED = (
    "mission.latitude_deg",
    "mission.altitude_m",
    "mission.longitude_deg",
    "mission.dates",
    "mission.climb",
)


class Flights(NamedTuple):
    """Results of the draws in their critical scenario; arrays of shape ``(sample,)``.

    ``excess_time_h`` is infinite where it is unlimited; ``minimum_state_of_charge`` is that of the
    converged cycle [-]; ``worst`` is the index of the critical scenario; ``peak_solar_w`` the
    largest solar power and ``maximum_altitude_m`` the highest altitude of all scenarios, NaN
    without climbs.
    """

    excess_time_h: FloatArray
    minimum_state_of_charge: FloatArray
    total_mass_kg: FloatArray
    propulsion_power_w: FloatArray
    worst: FloatArray
    peak_solar_w: FloatArray
    maximum_altitude_m: FloatArray

    def first(self, count: int) -> Flights:
        """Return the results of the first draws."""
        return Flights(*(column[:count] for column in self))


class Profiles(NamedTuple):
    """Optimal height profiles of the nominal aircraft in more and less light.

    ``light``: nominal mean light over load by scenario [-]; ``known``: heights [m] and excess time
    [h] by scenario and steps of light from the nominal.
    """

    light: dict[int, float]
    known: dict[tuple[int, int], tuple[FloatArray, float]]


_PROPULSION, _FACTOR = "airframe.propulsion.", "efficiency_factor"
# Keys of the propulsion that may differ between draws.
_DRAWN = {_FACTOR, "motor_mass_factor", "propeller_mass_factor"}
_PARTS = tuple(f"{_PROPULSION}{part}." for part in ("propeller", "gear", "motor", "controller"))


def check_inputs(inputs: UncertainInputs, mission: Mission, solar: SolarModel) -> None:
    """Refuse inputs that a propagation cannot vary."""
    for key in (scattering.key for scattering in inputs.inputs):
        if key.startswith(_FIXED) or key.startswith("modules.geometry"):
            raise ValueError(f"{key} moves the sun on the modules: vary it with `sweep`")
        if key.startswith(_PARTS) or key.removeprefix(_PROPULSION) in PARTS - _DRAWN:
            raise ValueError(
                f"{key} has one value for all draws: vary it with `sweep`, or let "
                f"{_PROPULSION}{_FACTOR} scatter"
            )
        if key.startswith("battery.charge_limit"):
            # All batteries of a batch share the charger's table of times.
            raise ValueError(f"{key} is the same for all draws: vary it with `sweep`")
        if key in _OF_HORIZONTAL_MODELS and solar.model in ("VM", "FM"):
            raise ValueError(f"{key} varies with CDM and CAM alone (got {solar.model})")


def _with_nearby_parts(aircraft: Aircraft, mission: Mission) -> Aircraft:
    """Return the aircraft with its propulsion approximated near nominal level flight.

    A propeller by tables, which are not smooth, gives the constant efficiencies of that flight.
    """
    if (parts := aircraft.propulsion_by_parts) is None or not parts.is_exact:
        return aircraft
    design = design_of(aircraft, mission)
    assert design.chain is not None
    if parts.propeller.table is not None:
        return aircraft.with_airframe(propulsion=design.chain)
    thrust_w, speed_m_per_s = float(design.thrust_power_w), float(design.airspeed_m_per_s)
    nearby = NearbyPropulsion.of(parts, thrust_w, speed_m_per_s, design.conditions.air)
    return aircraft.with_airframe(propulsion=nearby)


class Propagation:
    """Simulation of an aircraft in level flight on a mission under draws of its inputs.

    ``profiles`` of climbs are those of a similar aircraft; missing ones are added.
    """

    draws_at_once = 2048  # limited by memory
    draws_of_endurance = 1024  # whose longest flights are looked for: a launch of each is refined

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        solar: SolarModel,
        profiles: Profiles | None = None,
    ) -> None:
        self.aircraft = _with_nearby_parts(aircraft, mission)
        self.mission, self.solar = mission, solar
        self.day = solar_day(aircraft, mission, solar)
        self._best = Profiles({}, {}) if profiles is None else profiles
        # A propeller by tables has constant efficiencies here.
        by_table = isinstance(self.aircraft.propulsion, Propulsion)
        self._parts = aircraft.propulsion_by_parts if by_table else None

    def flights(
        self, values: dict[str, FloatArray], *, stop_at_excess_time_h: float = np.inf
    ) -> Flights:
        """Simulate all draws, given as values of every input by its key, shape ``(sample,)``.

        Draws with the excess time ``stop_at_excess_time_h`` try no further height profile.
        """
        count = len(next(iter(values.values()))) if values else 1
        parts = [
            self._block({key: value[draws] for key, value in values.items()}, stop_at_excess_time_h)
            for draws in blocks(count, self.draws_at_once)
        ]
        return Flights(*map(np.concatenate, zip(*parts, strict=True)))

    def extrapolations(
        self, values: dict[str, FloatArray], flights: Flights
    ) -> tuple[Extrapolation, ...]:
        """Return the quantities outside the range of a model, with worst value and count of draws.

        ``values`` holds values of every input by its key, shape ``(sample,)``.
        """
        case = self._case(values)
        aircraft, mission, design = case.aircraft, case.mission, case.design
        highest_m = None if mission.climb is None else flights.maximum_altitude_m
        checks = [
            *design_checks(aircraft, mission, design, self.solar, highest_m),
            *charge_rate_check(aircraft, mission, design, flights.peak_solar_w),
        ]
        sun_checks = correction_check(self.day.scenarios, self.solar, mission)
        return keep_worst(
            [
                *collect_extrapolations(checks, of=case.count, what="draws"),
                *collect_extrapolations(sun_checks, self.day.scenarios),
            ]
        )

    def endurance_h(
        self, values: dict[str, FloatArray], flights: Flights | None = None
    ) -> FloatArray:
        """Return every draw's longest flight in its critical scenario [h], infinite if perpetual.

        ``flights`` are the results of the same draws, if known.
        """
        results = self.flights(values) if flights is None else flights
        hours = np.full(len(results.excess_time_h), np.inf)
        short = results.excess_time_h <= 0.0
        for scenario in range(len(self.day.scenarios)):
            at = np.flatnonzero(short & (results.worst == scenario))
            if len(at):
                case = self._case({key: value[at] for key, value in values.items()})
                hours[at] = self._level_flight(case, scenario).endurance_h
        return hours

    def income_and_storage(
        self, values: dict[str, FloatArray], scenario: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return daily solar energy and battery energy of every draw over the day's load [-].

        ``values`` holds values of every input by its key, shape ``(sample,)``.
        """
        case = self._case(values)
        perf, battery = self._level_flight(case, scenario), case.aircraft.battery
        load = np.mean(perf.load_w, axis=-1) / np.asarray(battery.mean_discharge_efficiency, float)
        income = np.mean(perf.solar_power_w, axis=-1) * battery.mean_charge_efficiency / load
        return np.asarray(income), np.asarray(case.design.battery_energy_wh / (24.0 * load))

    def _block(self, values: dict[str, FloatArray], stop_at_excess_time_h: float) -> Flights:
        case = self._case(values)
        excess, charge, peak_w = [], [], np.zeros(case.count)
        highest_m = np.full(case.count, np.nan)
        flies = np.isfinite(case.mass_kg)
        for scenario in range(len(self.day.scenarios)):
            level = self._level_flight(case, scenario)
            excess_h, least, altitude_m = self._best_flights(
                case, scenario, level, stop_at_excess_time_h
            )
            highest_m = np.fmax(highest_m, altitude_m)
            peak_w = np.maximum(peak_w, np.max(level.solar_power_w, axis=-1))
            excess.append(np.where(flies, excess_h, -24.0))
            charge.append(np.where(flies, least, 0.0))
        worst = np.argmin(excess, axis=0)
        rows = np.arange(case.count)
        return Flights(
            excess_time_h=np.asarray(excess)[worst, rows],
            minimum_state_of_charge=np.asarray(charge)[worst, rows],
            total_mass_kg=case.mass_kg,
            propulsion_power_w=case.propulsion_w,
            worst=worst.astype(float),
            peak_solar_w=peak_w,
            maximum_altitude_m=highest_m,
        )

    def _case(self, values: dict[str, FloatArray]) -> _Case:
        aircraft, mission = self.aircraft, self.mission
        for key, value in values.items():
            if key.removeprefix(_PROPULSION) in _DRAWN and self._parts is not None:
                key, value = self._scaled_constant(aircraft, key.removeprefix(_PROPULSION), value)
            if key != SOLAR_MODEL:
                aircraft, mission = with_parameter(aircraft, mission, key, value)
        count = len(next(iter(values.values()))) if values else 1
        design = _drawn_design(aircraft, mission, count)

        def each(value: object) -> FloatArray:
            return np.array(np.broadcast_to(np.asarray(value, float), (count,)))

        power_w, mass_kg = each(design.propulsion_power_w), each(design.total_mass_kg)
        design = design._replace(
            total_mass_kg=mass_kg,
            battery_energy_wh=each(design.battery_energy_wh),
            propulsion_power_w=np.where(np.isfinite(power_w), power_w, NO_FLIGHT_W),
            constant_power_w=each(design.constant_power_w),
        )
        factor = each(values.get(SOLAR_MODEL, 1.0))
        return _Case(aircraft, mission, design, mass_kg, power_w, factor, count)

    def _scaled_constant(
        self, aircraft: Aircraft, name: str, factor: FloatArray
    ) -> tuple[str, FloatArray]:
        """Return key and values that apply a factor to a constant efficiency or mass."""
        parts, chain = self._parts, aircraft.propulsion
        assert parts is not None
        assert isinstance(chain, Propulsion)
        if name == _FACTOR:
            key = f"{_PROPULSION}propeller_efficiency"
            return key, chain.propeller_efficiency * factor / parts.efficiency_factor
        is_motor = name.startswith("motor")
        part_kg = parts.motor_kg if is_motor else parts.propeller_kg
        more_kg = parts.propulsors * part_kg * (factor - getattr(parts, name))
        return f"{_PROPULSION}fixed_mass_kg", chain.fixed_mass_kg + more_kg

    def _level_flight(self, case: _Case, scenario: int) -> Performance:
        """Return the flights of all draws in a scenario at the lowest altitude."""
        return self._flown(case, scenario)

    def _flown(
        self, case: _Case, scenario: int, heights_m: FloatArray | None = None
    ) -> Performance:
        """Return the flights of all draws in a scenario, each in its own light.

        ``heights_m``: of climbs, instead of the best.
        """
        levels_m = enumerate(case.mission.climb_levels_m)
        powers = [self._specific_power(case, scenario, *level) for level in levels_m]
        day = self.day.at(np.full(case.count, scenario))
        return fly(
            case.aircraft,
            case.mission,
            self.solar,
            case.design,
            replace(day, power_w_per_m2=np.stack(powers), cooling=None),
            keep_trajectory=False,
            paired=True,
            heights_m=heights_m,
        )

    def _best_flights(
        self, case: _Case, scenario: int, level: Performance, stop_at_excess_time_h: float
    ) -> tuple[FloatArray, FloatArray, ArrayLike]:
        """Return excess time [h], least state of charge [-] and highest altitude [m] of draws."""
        return level.cycle.excess_time_h, level.cycle.minimum_state_of_charge, np.nan

    def _specific_power(
        self, case: _Case, scenario: int, level: int, altitude_m: float
    ) -> FloatArray:
        """Return the power of every draw at a flight level [W/m2], shape ``(sample, time)``.

        With direct part ``D`` and diffuse part ``F`` of the nominal power, the power of a draw is
        ``k (c D + f F) = k f (D + F) + k (c - f) D``: ``k`` from efficiencies, temperature and
        clearness, ``c`` from the camber, ``f`` from the efficiency for diffuse light.
        """
        nominal, drawn = (m.at_altitude(altitude_m) for m in (self.mission, case.mission))
        was, now = self.aircraft.modules, case.aircraft.modules
        warmer_k = self._warmer_k
        warm_was = was.temperature_efficiency(nominal.module_temperature_c() + warmer_k)
        warm = now.temperature_efficiency(drawn.module_temperature_c() + warmer_k)
        k = (
            case.solar_factor
            * (now.efficiency_stc / was.efficiency_stc)
            * (now.mppt_efficiency / was.mppt_efficiency)
            * (warm / warm_was)
            * (drawn.pessimistic_clearness / nominal.pessimistic_clearness)
        )
        camber = np.asarray(now.camber_efficiency / was.camber_efficiency, float)
        # Of CDM camber acts on all light, and diffuse light has no efficiency of its own.
        is_cdm = self.solar.model == "CDM"
        diffuse = np.asarray(now.diffuse_efficiency / was.diffuse_efficiency, float)
        whole = np.asarray(k * (camber if is_cdm else diffuse))
        power = whole[..., np.newaxis] * self.day.power_w_per_m2[level, scenario]
        if not is_cdm and (camber.ndim or diffuse.ndim):
            more = np.asarray(k * (camber - diffuse))
            power = power + more[..., np.newaxis] * self._direct_w_per_m2[level, scenario]
        return np.broadcast_to(np.maximum(power, 0.0), (case.count, len(self.day.time_h)))

    @cached_property
    def _warmer_k(self) -> float:
        """Power-weighted mean of module above air temperature by the heat balance [K]."""
        modules, mission = self.aircraft.modules, self.mission
        if not balances_heat(mission) or not modules.temperature_coefficient_per_k:
            return 0.0
        air_c = mission.module_temperature_c()
        air = mission.air.model_copy(update={"module_temperature_c": air_c})
        as_cold = mission.model_copy(update={"air": air, "climb": None})
        scenarios, step_h = self.day.scenarios, float(self.day.time_h[1])
        cold = solar_day(self.aircraft, as_cold, self.solar, scenarios=scenarios, step_h=step_h)
        warm_w, cold_w = (float(d.specific_power_w_per_m2.sum()) for d in (self.day, cold))
        lost = 1.0 - warm_w / cold_w if cold_w > 0.0 else 0.0
        at_air = float(modules.temperature_efficiency(air_c))
        return lost * at_air / modules.temperature_coefficient_per_k

    @cached_property
    def _direct_w_per_m2(self) -> FloatArray:
        """Direct part of the nominal specific power [W/m2], ``(level, scenario, time)``."""
        # Halving the diffuse efficiency isolates the diffuse part.
        half = 0.5 * self.aircraft.modules.diffuse_efficiency
        key, scenarios = "modules.diffuse_efficiency", self.day.scenarios
        aircraft, _ = with_parameter(self.aircraft, self.mission, key, half)
        halved = solar_day(aircraft, self.mission, self.solar, scenarios=scenarios)
        return 2.0 * halved.power_w_per_m2 - self.day.power_w_per_m2


class ClimbingPropagation(Propagation):
    """Simulation of an aircraft with climbs under draws of its inputs."""

    draws_at_once = 1024  # with the light at all levels
    draws_of_endurance = 256

    def _level_flight(self, case: _Case, scenario: int) -> Performance:
        return self._flown(case, scenario, np.zeros((case.count, len(self.day.time_h))))

    def _best_flights(
        self, case: _Case, scenario: int, level: Performance, stop_at_excess_time_h: float
    ) -> tuple[FloatArray, FloatArray, ArrayLike]:
        """Return these of the best flight of every draw along its height profiles, or level."""
        levels = level.levels
        assert levels is not None
        light_over_load = self._light_of(level)
        below, known = np.zeros(case.count, int), light_over_load > 0.0
        nominal = self._nominal_light(scenario)
        below[known] = _STRIDE * np.floor(
            np.log(light_over_load[known] / nominal) / (_STRIDE * _LIGHT_STEP)
        )
        steps, places = np.unique([below, below + _STRIDE], return_inverse=True)
        heights_m = np.stack([height_m for height_m, _ in self._profiles(scenario, steps.tolist())])
        cycle, floor_m = level.cycle, np.full(case.count, levels.altitude_m[0])
        best = np.stack([cycle.excess_time_h, cycle.minimum_state_of_charge, floor_m])

        def simulate(draws: IntArray, height_m: FloatArray) -> None:
            if not len(draws):
                return
            flights = flown_along(
                self.day.time_h,
                levels.select(draws),
                level.store.select(draws),
                height_m,
                of_others=True,
            )
            highest_m = levels.altitude_m[0] + flights.height_m.max(axis=-1)
            cycle = flights.cycle
            new = np.stack([cycle.excess_time_h, cycle.minimum_state_of_charge, highest_m])
            best[:, draws] = np.where(new[0] > best[0, draws], new, best[:, draws])

        for at in places.reshape(2, -1):
            unfinished = np.flatnonzero(best[0] < stop_at_excess_time_h)
            simulate(unfinished, heights_m[at[unfinished]])
        edge, closing_m = self._closing(scenario, steps)
        for height_m in closing_m:
            unfinished = np.flatnonzero((best[0] <= 0.0) & (np.abs(below - edge) <= _STRIDE))
            simulate(unfinished, np.tile(height_m, (len(unfinished), 1)))
        return best[0], best[1], best[2]

    def _light_of(self, level: Performance) -> FloatArray:
        """Return mean light over load of draws [-]; 0 where one does not fly."""
        assert level.levels is not None
        light = np.mean(level.solar_power_w, axis=-1) / level.nominal_load_w
        return np.where(level.levels.flies, light, 0.0)

    def _nominal_light(self, scenario: int) -> float:
        """Return mean light over load of the aircraft whose profiles the draws fly [-]."""
        light = self._best.light
        if scenario not in light:
            light[scenario] = self._own_light(scenario)
        return light[scenario]

    def _own_light(self, scenario: int) -> float:
        """Return nominal mean light over load of this aircraft [-]; 1 where there is neither."""
        return float(self._light_of(self._level_flight(self._case({}), scenario))[0]) or 1.0

    def _profiles(self, scenario: int, steps: list[int]) -> list[tuple[FloatArray, float]]:
        """Return nominal optimal heights [m] and excess times [h] at steps of light."""
        centre, known = self._nominal_light(scenario), self._best.known
        if new := [step for step in steps if (scenario, step) not in known]:
            factors = np.exp(_LIGHT_STEP * np.array(new)) * centre / self._own_light(scenario)
            best = self._flown(self._case({SOLAR_MODEL: factors}), scenario)
            assert best.altitude_m is not None
            heights_m = best.altitude_m - self.mission.altitude_m
            flights = zip(heights_m, best.cycle.excess_time_h.tolist(), strict=True)
            known.update({(scenario, n): flight for n, flight in zip(new, flights, strict=True)})
        return [known[scenario, step] for step in steps]

    def _closing(self, scenario: int, steps: IntArray) -> tuple[int, list[FloatArray]]:
        """Return the step of light at which days begin to close, and optimal heights above it [m].

        Two strides are covered: with another battery, days begin to close in other light.
        """
        closes = [excess_h > 0.0 for _, excess_h in self._profiles(scenario, steps.tolist())]
        edges = np.flatnonzero(np.diff(closes) & (np.diff(steps) == _STRIDE))
        if not len(edges):
            return 0, []
        edge = int(steps[edges[0]])
        between = self._profiles(scenario, list(range(edge + 1, edge + 2 * _STRIDE)))
        return edge, [height_m for height_m, excess_h in between if excess_h > 0.0]


def propagation_of(
    aircraft: Aircraft, mission: Mission, solar: SolarModel, profiles: Profiles | None = None
) -> Propagation:
    """Return the simulation of draws of an aircraft as its mission has it fly."""
    kind = Propagation if mission.climb is None else ClimbingPropagation
    return kind(aircraft, mission, solar, profiles)


@dataclass(frozen=True)
class _Case:
    """Aircraft, mission and designs of a batch of draws."""

    aircraft: Aircraft
    mission: Mission
    design: Design
    mass_kg: FloatArray
    propulsion_w: FloatArray
    solar_factor: FloatArray
    count: int


def _drawn_design(aircraft: Aircraft, mission: Mission, count: int) -> Design:
    """Return the designs of the draws, with closed mass budgets; infinite where none closes."""
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return measured_design(aircraft, mission)
    variables = variables_of(aircraft)
    conditions = FlightConditions.of(mission, aircraft)

    def budget_kg(rows: IntArray, assumed_kg: FloatArray) -> FloatArray:
        # Drawn inputs are arrays of all draws and cannot be subset.
        every_kg = np.ones(count)
        every_kg[rows] = assumed_kg
        design = parametric_design(aircraft, conditions, variables, every_kg)
        return np.broadcast_to(np.asarray(design.masses.total_kg, float), (count,))[rows]

    start_kg = np.broadcast_to(np.asarray(variables.battery_mass_kg, float), (count,))
    total_kg = lightest_mass(budget_kg, start_kg, _TOLERANCE)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return parametric_design(aircraft, conditions, variables, total_kg)
