"""What is to be sized: aircraft, mission, objective and light, and what judges its designs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.day.light import SolarDay, SolarModel
from sizing.design import DesignVariables, FlightConditions
from sizing.design_space import PROPULSION_VARIABLES
from sizing.limits import meets_requirements
from sizing.performance import Performance
from sizing.program.objectives import Objective
from sizing.program.result import merit_of
from sizing.program.transcription import Form
from sizing.program.variables import (
    TOTAL_MASS,
    TOTAL_OVER_BATTERY_MASS,
    USER_OBJECTIVE,
    Role,
    Variable,
    chosen_variables,
)
from solar.types import BoolArray, FloatArray

Values = Mapping[str, float]


@dataclass(frozen=True)
class SizingTask:
    """A sizing, before its program.

    ``objective``: or one of the user's own, which answers as an objective does. ``day``: light in
    the scenarios of the mission. ``required_h``: excess time of every scenario. ``continuous``:
    whether the sun must carry the nominal load at all times, instead of the battery. ``bounds``: of
    variables, in their unit, that replace their own. ``beyond_limits``: whether the propulsion's
    parts may do more than their limits.
    """

    aircraft: Aircraft
    mission: Mission
    objective: Objective
    solar: SolarModel
    day: SolarDay
    required_h: float
    continuous: bool = False
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    beyond_limits: bool = False

    @property
    def count(self) -> int:
        """Number of scenarios."""
        return len(self.day.scenarios)

    @cached_property
    def window_h(self) -> FloatArray | None:
        """Launch and landing in every scenario [h]; None where a day is repeated."""
        ends = self.mission.flight_window_h(self.day.scenarios)
        return None if ends is None else np.stack(ends, axis=-1)

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """Variables of the program, with the bounds of this task."""
        ends = {name: (value, value) for name, value in self.held.items()}
        ends |= dict.fromkeys(self.free_names, (0.0, math.inf)) | dict(self.bounds)
        return tuple(
            v._replace(minimum=ends[v.name][0], maximum=ends[v.name][1]) if v.name in ends else v
            for v in chosen_variables(self.aircraft)
        )

    @cached_property
    def free_names(self) -> frozenset[str]:
        """Names of the payload that is free."""
        return frozenset({self.objective.variable} if self.objective.payload_key else ())

    @cached_property
    def held(self) -> dict[str, float]:
        """Payload of the mission, which is held where it is not free."""
        payload = self.mission.payload
        return {"payload_mass_kg": payload.mass_kg, "payload_power_w": payload.power_w}

    @cached_property
    def names(self) -> list[str]:
        """Names of the variables, in the order of the program."""
        return [v.name for v in self.variables]

    @cached_property
    def moved(self) -> list[str]:
        """Names of the design variables that the simulator is asked to move."""
        designs = DesignVariables._fields
        return [v.name for v in self.variables if v.name in designs and v.minimum < v.maximum]

    @cached_property
    def conditions(self) -> FlightConditions:
        """Air, payload and wind of the mission."""
        return FlightConditions.of(self.mission, self.aircraft)

    def form(self, blocks: int) -> Form:
        """Form of the program with some scenarios."""
        mission, ends_h = self.mission, self.window_h
        days = (
            1 if ends_h is None else max(math.ceil(float(np.ptp(ends_h, axis=1).max()) / 24.0), 1)
        )
        climbs = mission.climb is not None
        return Form(blocks, mission.holds_station, climbs, days)

    @cached_property
    def heights(self) -> tuple[Mission, ...]:
        """The mission at the floor, and with climbs at evenly spaced heights up to the ceiling."""
        mission = self.mission
        levels_m = np.linspace(mission.altitude_m, mission.ceiling_m, self.form(1).levels)
        return (mission, *map(mission.at_altitude, levels_m[1:].tolist()))

    @cached_property
    def airs(self) -> tuple[FlightConditions, ...]:
        """Air at these heights."""
        return tuple(FlightConditions.of(there, self.aircraft) for there in self.heights)

    @property
    def climb_height_m(self) -> float:
        """Height of the ceiling above the floor [m]."""
        return self.mission.ceiling_m - self.mission.altitude_m

    @cached_property
    def winds_m_per_s(self) -> FloatArray:
        """Wind to hold the place against, ``(scenario, height)``; zero where none is held."""
        if not self.mission.holds_station:
            return np.zeros((self.count, len(self.heights)))
        winds = [there.scenario_winds_m_per_s(self.day.scenarios) for there in self.heights]
        return np.stack(winds, axis=-1)

    @cached_property
    def simulated_aircraft(self) -> Aircraft:
        """Aircraft that designs are simulated with: limits of propulsion parts are rows."""
        return self.aircraft.with_airframe(propulsion=self.aircraft.propulsion.without_limits())

    @property
    def maximises_excess(self) -> bool:
        """Whether the excess time itself is to be as long as possible."""
        return self.objective is Objective.max_excess_time and not self.continuous

    @property
    def has_continuous_sun(self) -> bool:
        """Whether a required excess time may come from a sun that never sets."""
        never_dark = self.window_h is None and self.day.specific_power_w_per_m2.min() > 0.0
        return bool(never_dark and (self.required_h > 0.0 or self.maximises_excess))

    @cached_property
    def has_polar_night(self) -> bool:
        """Whether a repeated day has no sun at all, or a flight no sunrise to begin with."""
        if self.window_h is not None:
            return bool((np.ptp(self.window_h, axis=1) == 0.0).any())
        return bool(self.day.scenarios.in_polar_night().any())

    @property
    def goal_h(self) -> float:
        """Excess time that the program requires [h]; continuous solar power needs none."""
        return 0.0 if self.continuous else self.required_h

    @cached_property
    def cost(self) -> Mapping[str, float]:
        """Weights of the program's variables in what it minimises.

        Excess time is unlimited with continuous solar power: the lightest design is as good as any.
        """
        longest = self.objective is Objective.max_excess_time
        return (Objective.min_mass if longest and self.continuous else self.objective).cost

    # --- simulator ------------------------------------------------------------------------------

    def design_variables(self, values: Values) -> DesignVariables:
        """Design variables of a design, of which a payload is one only where it is free."""
        chosen = {"aspect_ratio": self.aircraft.airframe.aspect_ratio}
        for v in self.variables:
            if v.name not in DesignVariables._fields:
                continue
            if v.role is not Role.payload or v.name in self.free_names:
                chosen[v.name] = values[v.name]
        return DesignVariables(**chosen)

    def within_bounds(self, values: Values) -> dict[str, float]:
        """Values of a design, each within its bounds: the solver may step slightly over."""
        variables = self.variables
        return {v.name: min(max(float(values[v.name]), v.minimum), v.maximum) for v in variables}

    def stacked(self, designs: list[Values]) -> DesignVariables:
        """Return the variables of a list of designs as arrays."""
        chosen = [self.design_variables(values).chosen() for values in designs]
        return DesignVariables(
            **{name: np.array([float(design[name]) for design in chosen]) for name in chosen[0]}
        )

    def first_values(self, variables: DesignVariables) -> dict[str, float]:
        """Return the values of a design, with a guess of the mass that closes its budget."""
        chosen = {name: float(value) for name, value in variables.chosen().items()}
        values: dict[str, float] = {USER_OBJECTIVE: 0.0} | self.held
        values[TOTAL_MASS] = TOTAL_OVER_BATTERY_MASS * chosen["battery_mass_kg"]
        known = zip(PROPULSION_VARIABLES, self.aircraft.propulsion.sizes, strict=False)
        values |= {name: float(value) for name, value in known if value}
        values |= {v.name: chosen[v.name] for v in self.variables if v.name in chosen}
        values |= {v.name: v.minimum for v in self.variables if v.name not in values}
        return self.within_bounds(values)

    def merit(self, perf: Performance, worst_excess_h: float) -> float:
        """Return the objective of the first of simulated designs, the larger the better."""
        if self.objective is Objective.max_excess_time:
            return worst_excess_h
        return float(merit_of(self.objective, perf)[0])

    def is_enough(self, excess_h: FloatArray) -> BoolArray:
        """Return whether excess times are those required; scenarios are the last axis."""
        worst_h = excess_h.min(axis=-1)
        return np.asarray((worst_h > 0.0) & (worst_h >= self.required_h))

    def meets(self, perf: Performance) -> BoolArray:
        """Return whether each design of a batch keeps every requirement on itself."""
        aircraft = self.aircraft if self.beyond_limits else self.simulated_aircraft
        return np.ravel(meets_requirements(aircraft, perf.design))
