"""Flights of many draws of uncertain inputs at once.

The formulas of the sizing take arrays where they take numbers: a draw is an element of a batch, as
a design is. Solar power of CDM, CAM and VM is linear in what scatters, so that the sky is computed
once.

With climbs draws are small changes of one aircraft: none has a program of its own. They fly the
best height profiles of the files' aircraft, in as much light over load as the draw has, a step more
and a step less; where neither closes the day, those in little more light than days begin to close
in, and level flight. Of each draw the best of these flights counts: a lower bound of what its own
best profile gives.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.day.balance import blocks
from sizing.day.battery import Store
from sizing.day.cycle import simulate_cycle
from sizing.day.heights import FlightLevels, flight_levels
from sizing.day.launch import longest_flight
from sizing.day.light import SolarDay, SolarModel, solar_day
from sizing.day.load import Load, part_load_of
from sizing.day.metrics import Cycle
from sizing.day.module_power import balances_heat
from sizing.design import Design, FlightConditions, variables_of
from sizing.mass_budget import design_of, measured_design, parametric_design
from sizing.parameters import with_parameter
from sizing.program.climbing_flights import ClimbFlights
from sizing.program.schedule import best_climbs, flown_along
from sizing.propulsion.chain import PARTS, Propulsion
from sizing.propulsion.nearby import NearbyPropulsion
from sizing.propulsion.part_load import PROPORTIONAL, AnyPartLoad
from sizing.roots import LightestMass
from sizing.uncertainty.inputs import SOLAR_MODEL, UncertainInputs
from sizing.validity.checks import at_highest, charge_rate_check, correction_check, design_checks
from sizing.validity.extrapolations import told, worst_of
from sizing.validity.ranges import Extrapolation
from solar.types import FloatArray, IntArray

# Draws simulated at once: a day of each array stays small.
_DRAWS_AT_ONCE = 2048
_CLIMBING_AT_ONCE = 1024  # with the light at all levels
# Finest step of the profiles' light over load, and steps between two that draws fly: between 5 %
# the best profile changes little but where days begin to close.
_LIGHT, _APART = 0.05 / 8, 8
_TOLERANCE = 1e-10  # relative, of the total mass
# Keys of the modules and the sky that the specific power is rescaled for.
_SUN_KEYS = (
    "modules.efficiency_stc",
    "modules.mppt_efficiency",
    "modules.camber_efficiency",
    "modules.diffuse_efficiency",
    "modules.temperature_coefficient_per_k",
    "mission.clearness",
    "mission.air.module_temperature_c",
    "mission.air.ambient_temperature_c",
    "mission.air.temperature_offset_k",
    SOLAR_MODEL,
)
# Keys that move the sun itself, or what no batch can carry.
_FIXED = (
    *("mission.latitude_deg", "mission.altitude_m", "mission.longitude_deg", "mission.dates"),
    "mission.climb",
)


@dataclass(frozen=True)
class Flights:
    """What becomes of the draws, the worst scenario of each; arrays of shape ``(sample,)``.

    ``excess_time_h``: excess time [h]; infinite where it is unlimited. ``minimum_state_of_charge``:
    of the converged cycle [-]. ``total_mass_kg``, ``propulsion_power_w``: of the design that is
    drawn [kg, W]. ``worst``: scenario with the least excess time. ``peak_solar_w``: largest solar
    power of all scenarios [W]. ``maximum_altitude_m``: highest altitude of all scenarios of a
    mission with climbs [m]; NaN without.
    """

    excess_time_h: FloatArray
    minimum_state_of_charge: FloatArray
    total_mass_kg: FloatArray
    propulsion_power_w: FloatArray
    worst: FloatArray
    peak_solar_w: FloatArray
    maximum_altitude_m: FloatArray

    def first(self, count: int) -> Flights:
        """Flights of the first so many draws."""
        return Flights(*(getattr(self, name)[:count] for name in Flights.__dataclass_fields__))


class Profiles(NamedTuple):
    """Best heights of an aircraft in more and in less light.

    ``light``: mean light over load of its own, by scenario; ``known``: heights [m] and excess time
    [h] by scenario and steps of light from there.
    """

    light: dict[int, float]
    known: dict[tuple[int, int], tuple[FloatArray, float]]


_PROPULSION, _FACTOR = "airframe.propulsion.", "efficiency_factor"
# Of the propulsion's keys those that may differ between draws.
_DRAWN = {_FACTOR, "motor_mass_factor", "propeller_mass_factor"}
_PARTS = tuple(f"{_PROPULSION}{part}." for part in ("propeller", "gear", "motor", "controller"))


def check_inputs(inputs: UncertainInputs, mission: Mission, solar: SolarModel) -> None:
    """Refuse inputs that a propagation cannot vary."""
    for key in (one.key for one in inputs.inputs):
        if key.startswith(_FIXED) or key.startswith("modules.geometry"):
            raise ValueError(f"{key} moves the sun on the modules: vary it with `sweep`")
        if key.startswith(_PARTS) or key.removeprefix(_PROPULSION) in PARTS - _DRAWN:
            raise ValueError(
                f"{key} has one value for all draws: vary it with `sweep`, or let "
                f"{_PROPULSION}{_FACTOR} scatter"
            )
        if key.startswith("battery.charge_limit"):
            # The charger's table of times is one for all batteries of a batch.
            raise ValueError(f"{key} is the same for all draws: vary it with `sweep`")
        if key in _SUN_KEYS[2:5] and solar.model in ("VM", "FM"):
            raise ValueError(f"{key} varies with CDM and CAM alone (got {solar.model})")


def _with_nearby_parts(aircraft: Aircraft, mission: Mission) -> Aircraft:
    """Aircraft with its parts near the level flight of its file.

    With a propeller by tables, which have corners, it has the constant efficiencies of that flight.
    """
    if (parts := aircraft.propulsion_by_parts) is None or not parts.is_exact:
        return aircraft
    design = design_of(aircraft, mission)
    assert design.chain is not None
    if parts.propeller.table is not None:
        return aircraft.with_airframe(propulsion=design.chain)
    flight = float(design.thrust_power_w), float(design.airspeed_m_per_s)
    nearby = NearbyPropulsion.of(parts, *flight, design.conditions.air)
    return aircraft.with_airframe(propulsion=nearby)


class Propagation:
    """Flights of an aircraft on a mission under draws of its inputs.

    ``day``: sun of that aircraft on that mission, where it is known already. ``profiles``: of
    an aircraft much like it; those that are missing join them.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        mission: Mission,
        solar: SolarModel,
        *,
        day: SolarDay | None = None,
        profiles: Profiles | None = None,
    ) -> None:
        self.aircraft = _with_nearby_parts(aircraft, mission)
        self.mission, self.solar = mission, solar
        self.day = solar_day(aircraft, mission, solar) if day is None else day
        self._direct: SolarDay | None = None
        self._best = Profiles({}, {}) if profiles is None else profiles
        # Of a propeller by tables, whose efficiencies are constants here.
        by_table = isinstance(getattr(self.aircraft.airframe, "propulsion", None), Propulsion)
        self._parts = aircraft.propulsion_by_parts if by_table else None

    def flights(self, values: dict[str, FloatArray], *, enough_h: float = np.inf) -> Flights:
        """Fly all draws.

        ``values``: values of every input by its key, shape ``(sample,)``. ``enough_h``: excess time
        from which on no draw need look for a better flight.
        """
        count = len(next(iter(values.values()))) if values else 1
        at_once = _DRAWS_AT_ONCE if self.mission.climb is None else _CLIMBING_AT_ONCE
        parts = [
            self._block({key: value[some] for key, value in values.items()}, enough_h)
            for some in blocks(count, at_once)
        ]
        return Flights(
            *(
                np.concatenate([getattr(part, name) for part in parts])
                for name in Flights.__dataclass_fields__
            )
        )

    def extrapolations(
        self, values: dict[str, FloatArray], flights: Flights
    ) -> tuple[Extrapolation, ...]:
        """What draws take from outside the range of a model, each quantity once.

        ``values``: values of every input by its key, shape ``(sample,)``. Returns with the worst
        value, and how many of the draws it is told of.
        """
        case = self._case(values)
        aircraft, mission, design = case.aircraft, case.mission, case.design
        of_design = list(design_checks(aircraft, mission, design, self.solar))
        if mission.climb is not None:
            highest_m = flights.maximum_altitude_m
            of_design = at_highest(of_design, aircraft, mission, self.solar, highest_m)
        checks = [*of_design, *charge_rate_check(aircraft, mission, design, flights.peak_solar_w)]
        of_sun = correction_check(self.day.scenarios, self.solar, mission)
        return worst_of(
            [*told(checks, of=case.count, what="draws"), *told(of_sun, self.day.scenarios)]
        )

    def endurance_h(
        self, values: dict[str, FloatArray], flights: Flights | None = None
    ) -> FloatArray:
        """Longest flight of every draw in its worst scenario [h], infinite if perpetual.

        ``flights``: those of the same draws, where they are known.
        """
        flown = self.flights(values) if flights is None else flights
        count = len(flown.excess_time_h)
        hours = np.full(count, np.inf)
        short = np.flatnonzero(flown.excess_time_h <= 0.0)
        if not len(short):
            return hours
        some = {key: value[short] for key, value in values.items()}
        case = self._case(some)
        for scenario in range(len(self.day.scenarios)):
            at = np.flatnonzero(flown.worst[short] == scenario)
            if not len(at):
                continue
            store, climb = case.store.select(at), case.mission.climb
            if climb is None:
                _, solar_w, load_w = self._cycle_of(case, scenario)
                longest = longest_flight(self.day.time_h, solar_w[at], load_w[at], store)
            else:
                levels = self._levels(case, scenario).select(at)
                longest = ClimbFlights(self.day.time_h, levels, store).longest()
            hours[short[at]] = longest.endurance_h
        return hours

    def income_and_storage(
        self, values: dict[str, FloatArray], scenario: int
    ) -> tuple[FloatArray, FloatArray]:
        """Solar energy and battery energy of every draw over its load.

        ``values``: values of every input by its key, shape ``(sample,)``. Returns energy that a day
        returns and that the battery delivers, over the day's load [-].
        """
        case = self._case(values)
        _, solar_w, load_w = self._cycle_of(case, scenario)
        battery = case.aircraft.battery
        load = np.mean(load_w, axis=-1) / np.asarray(battery.mean_discharge_efficiency, float)
        energy_wh = np.broadcast_to(case.design.battery_energy_wh, (case.count,))
        income = np.mean(solar_w, axis=-1) * battery.mean_charge_efficiency / load
        return np.asarray(income), np.asarray(energy_wh / (24.0 * load))

    def _block(self, values: dict[str, FloatArray], enough_h: float) -> Flights:
        case = self._case(values)
        excess, charge, peak_w = [], [], np.zeros(case.count)
        highest_m = np.full(case.count, np.nan)
        flies = np.isfinite(case.mass_kg)
        for scenario in range(len(self.day.scenarios)):
            if case.mission.climb is None:
                cycle, solar_w, _ = self._cycle_of(case, scenario)
                excess_h, least = cycle.excess_time_h, cycle.minimum_state_of_charge
            else:
                solar_w = self._solar_of_draws(case, scenario)
                flown = self._with_climbs(case, scenario, solar_w, enough_h)
                excess_h, least, altitude_m = flown
                highest_m = np.fmax(highest_m, altitude_m)
            peak_w = np.maximum(peak_w, np.max(solar_w, axis=-1))
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

    def _with_climbs(
        self, case: _Case, scenario: int, solar_w: FloatArray, enough_h: float
    ) -> FloatArray:
        """Excess time [h], least state of charge and highest altitude [m] of every draw.

        Of the best of level flight and of flights along the profiles of less and of more light.
        """
        levels = self._levels(case, scenario)
        lit = np.mean(solar_w, axis=-1) / levels.nominal_load_w
        below = np.zeros(case.count, int)
        known = (lit > 0.0) & levels.flies
        own = self._own_light(scenario)
        below[known] = _APART * np.floor(np.log(lit[known] / own) / (_APART * _LIGHT))
        steps, places = np.unique([below, below + _APART], return_inverse=True)
        heights_m = np.stack([one for one, _ in self._profiles(scenario, steps.tolist())])
        found = np.full((3, case.count), -np.inf)

        def fly(some: IntArray, height_m: FloatArray) -> None:
            if not len(some):
                return
            given = self.day.time_h, levels.select(some), case.store.select(some)
            flown = flown_along(*given, height_m, of_others=True)
            highest_m = levels.altitude_m[0] + flown.height_m.max(axis=-1)
            cycle = flown.cycle
            new = np.stack([cycle.excess_time_h, cycle.minimum_state_of_charge, highest_m])
            found[:, some] = np.where(new[0] > found[0, some], new, found[:, some])

        for at in places.reshape(2, -1):
            some = np.flatnonzero(found[0] < enough_h)
            fly(some, heights_m[at[some]])
        edge, closing_m = self._closing(scenario, steps)
        for height_m in closing_m:
            some = np.flatnonzero((found[0] <= 0.0) & (np.abs(below - edge) <= _APART))
            fly(some, np.tile(height_m, (len(some), 1)))
        some = np.flatnonzero(found[0] <= 0.0)
        fly(some, np.zeros((len(some), len(self.day.time_h))))
        return found

    def _light(self, scenario: int) -> float:
        """Mean light over load with the files' values; 1 where there is neither."""
        case = self._case({})
        levels, solar_w = self._levels(case, scenario), self._solar_of_draws(case, scenario)
        light = float(np.mean(solar_w) / levels.nominal_load_w[0])
        return light if levels.flies[0] and light > 0.0 else 1.0

    def _own_light(self, scenario: int) -> float:
        """That of the aircraft whose profiles the draws fly."""
        light = self._best.light
        if scenario not in light:
            light[scenario] = self._light(scenario)
        return light[scenario]

    def _profiles(self, scenario: int, steps: list[int]) -> list[tuple[FloatArray, float]]:
        """Best heights of the files' aircraft by light over load [m], and its excess time [h]."""
        centre, known = self._own_light(scenario), self._best.known
        if new := [step for step in steps if (scenario, step) not in known]:
            factors = np.exp(_LIGHT * np.array(new)) * centre / self._light(scenario)
            case = self._case({SOLAR_MODEL: factors})
            found = best_climbs(self.day.time_h, self._levels(case, scenario), case.store)
            flights = zip(found.height_m, found.cycle.excess_time_h.tolist(), strict=True)
            known.update({(scenario, n): one for n, one in zip(new, flights, strict=True)})
        return [known[scenario, step] for step in steps]

    def _closing(self, scenario: int, steps: IntArray) -> tuple[int, list[FloatArray]]:
        """From what step of light days begin to close, and best heights that do from there [m].

        Over two steps of the draws: with another battery their days begin to close in other light.
        """
        closes = [excess_h > 0.0 for _, excess_h in self._profiles(scenario, steps.tolist())]
        edges = np.flatnonzero(np.diff(closes) & (np.diff(steps) == _APART))
        if not len(edges):
            return 0, []
        edge = int(steps[edges[0]])
        between = self._profiles(scenario, list(range(edge + 1, edge + 2 * _APART)))
        return edge, [height_m for height_m, excess_h in between if excess_h > 0.0]

    def _levels(self, case: _Case, scenario: int) -> FlightLevels:
        """Every draw in a scenario, each in its own light at all levels."""
        day, mission = self.day, case.mission
        aloft = [
            self._specific_power(case, scenario, level, altitude_m)
            for level, altitude_m in enumerate(mission.climb_levels_m)
        ]
        own = day.at(np.full(case.count, scenario))
        own = replace(own, power_w_per_m2=np.stack(aloft), cooling=None)
        design = case.design._replace(total_mass_kg=case.mass_kg)
        return flight_levels(case.aircraft, mission, design, own, paired=True)

    def _specific_power(
        self, case: _Case, scenario: int, level: int, altitude_m: float
    ) -> FloatArray:
        """Power of every draw at a level of the climbs [W/m2], shape ``(sample, time)``."""
        missions = (one.at_altitude(altitude_m) for one in (self.mission, case.mission))
        whole, more = self._light_factors(case, *missions)
        power = whole[..., np.newaxis] * self.day.power_w_per_m2[level, scenario]
        if more is not None:
            direct = self._direct_day().power_w_per_m2[level, scenario]
            power = power + more[..., np.newaxis] * direct
        return np.broadcast_to(np.maximum(power, 0.0), (case.count, len(self.day.time_h)))

    def _case(self, values: dict[str, FloatArray]) -> _Case:
        aircraft, mission = self.aircraft, self.mission
        for key, value in values.items():
            if key.removeprefix(_PROPULSION) in _DRAWN and self._parts is not None:
                key, value = self._of_constants(aircraft, key.removeprefix(_PROPULSION), value)
            if key != SOLAR_MODEL:
                aircraft, mission = with_parameter(aircraft, mission, key, value)
        count = len(next(iter(values.values()))) if values else 1
        design = _drawn_design(aircraft, mission, count)

        def each(value: object) -> FloatArray:
            return np.array(np.broadcast_to(np.asarray(value, float), (count,)))

        power_w = each(design.propulsion_power_w)
        flies = np.isfinite(power_w)
        design = design._replace(
            propulsion_power_w=np.where(flies, power_w, 1e12),
            constant_power_w=each(design.constant_power_w),
        )
        energy_wh = each(design.battery_energy_wh)
        store = Store.of(aircraft.battery, energy_wh)
        return _Case(
            aircraft,
            mission,
            design,
            store,
            mass_kg=each(design.total_mass_kg),
            propulsion_w=power_w,
            part_load=PROPORTIONAL
            if mission.holds_station
            else part_load_of(aircraft, mission, design),
            solar_factor=each(values.get(SOLAR_MODEL, 1.0)),
            count=count,
        )

    def _of_constants(
        self, aircraft: Aircraft, name: str, factor: FloatArray
    ) -> tuple[str, FloatArray]:
        """Key and values by which constant efficiencies and masses have a factor."""
        parts, chain = self._parts, getattr(aircraft.airframe, "propulsion", None)
        assert parts is not None
        assert isinstance(chain, Propulsion)
        if name == _FACTOR:
            key = f"{_PROPULSION}propeller_efficiency"
            return key, chain.propeller_efficiency * factor / parts.efficiency_factor
        of_motor = name.startswith("motor")
        part_kg = parts.motor_kg if of_motor else parts.propeller_kg
        more_kg = parts.propulsors * part_kg * (factor - getattr(parts, name))
        return f"{_PROPULSION}fixed_mass_kg", chain.fixed_mass_kg + more_kg

    def _cycle_of(self, case: _Case, scenario: int) -> tuple[Cycle, FloatArray, FloatArray]:
        """Cycle of every draw in a scenario, solar power and load [W], ``(sample, time)``."""
        solar_w, day = self._solar_of_draws(case, scenario), self.day.at([scenario])
        design, mission, part_load = case.design, case.mission, case.part_load
        load = Load.of(case.aircraft, mission, design, day, paired=True, part_load=part_load)
        cycle = simulate_cycle(
            *(day.time_h, solar_w, load.power_w, case.store),
            nominal_load_w=load.nominal_w,
            keep_trajectory=False,
            window_h=mission.flight_window_h(day.scenarios),
        )
        return cycle, solar_w, load.power_w

    def _solar_of_draws(self, case: _Case, scenario: int) -> FloatArray:
        """Solar power of every draw in a scenario [W], shape ``(sample, time)``."""
        day = self.day
        area = np.asarray(case.aircraft.modules.area_m2, float)
        factors = self._light_factors(case, self.mission, case.mission)
        power = factors[0][:, np.newaxis] * day.specific_power_w_per_m2[scenario]
        if factors[1] is not None:
            direct = self._direct_day().specific_power_w_per_m2[scenario]
            power = power + factors[1][:, np.newaxis] * direct
        every = np.broadcast_to(area, (case.count,))[:, np.newaxis]
        return np.asarray(every * np.maximum(power, 0.0))

    def _light_factors(
        self, case: _Case, nominal: Mission, drawn: Mission
    ) -> tuple[FloatArray, FloatArray | None]:
        """Factor on the nominal specific power, and what is added per nominal direct part.

        ``nominal``, ``drawn``: mission as the files give it and as it is drawn, at one altitude.
        With direct part ``D`` and diffuse part ``F`` of the nominal power, that of a draw is
        ``k (c D + f F) = k f (D + F) + k (c - f) D``: ``k`` from efficiencies, temperature and
        clearness, ``c`` from the camber, ``f`` from the efficiency of diffuse light.
        """
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
        if self.solar.model == "CDM":  # camber takes from all light, diffuse light has no own
            return np.asarray(k * camber), None
        diffuse = np.asarray(now.diffuse_efficiency / was.diffuse_efficiency, float)
        if camber.ndim == 0 and diffuse.ndim == 0:
            return np.asarray(k), None
        return np.asarray(k * diffuse), np.asarray(k * (camber - diffuse))

    @cached_property
    def _warmer_k(self) -> float:
        """Modules above the air where they find their own temperature, weighted by power [K]."""
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

    def _direct_day(self) -> SolarDay:
        """Day with the direct part of the nominal specific power."""
        if self._direct is None:
            # A diffuse efficiency that halves its part tells what that part is.
            half = 0.5 * self.aircraft.modules.diffuse_efficiency
            aircraft, _ = with_parameter(
                self.aircraft, self.mission, "modules.diffuse_efficiency", half
            )
            scenarios = self.day.scenarios
            halved = solar_day(aircraft, self.mission, self.solar, scenarios=scenarios)
            self._direct = halved.scaled(2.0).less(self.day)
        return self._direct


@dataclass(frozen=True)
class _Case:
    """Aircraft and mission of a batch of draws, and what follows from them."""

    aircraft: Aircraft
    mission: Mission
    design: Design
    store: Store
    mass_kg: FloatArray
    propulsion_w: FloatArray
    part_load: AnyPartLoad
    solar_factor: FloatArray
    count: int


def _drawn_design(aircraft: Aircraft, mission: Mission, count: int) -> Design:
    """Design of every draw; its mass budget closes again, infinite where it cannot."""
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return measured_design(aircraft, mission)
    variables = variables_of(aircraft)
    conditions = FlightConditions.of(mission, aircraft)

    start_kg = np.broadcast_to(np.asarray(variables.battery_mass_kg, float), (count,))
    search = LightestMass(start_kg, _TOLERANCE)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        while search.open.size:
            # What is drawn is an array of all draws: it cannot be taken apart.
            every = np.ones(count)
            every[search.open] = search.assumed_kg
            closing = parametric_design(aircraft, conditions, variables, every)
            total_kg = np.asarray(closing.masses.total_kg, float)
            search.take(np.broadcast_to(total_kg, (count,))[search.open])
        return parametric_design(aircraft, conditions, variables, search.mass_kg)
