"""One aircraft between its lowest altitude and its ceiling: power, sunlight, potential energy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from missions.air import GRAVITY_M_PER_S2
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import (
    Design,
    ImpossibleDesignError,
    measured_design,
    operating_trouble,
    parametric_design,
)
from sizing.performance import Performance
from sizing.sunlight import SolarDay, SolarModel, solar_day
from solar.types import FloatArray

# Between levels everything is linear: the pressure's curvature over 500 m is 0.05 %.
_LEVEL_SPACING_M = 500.0
_MAXIMUM_LEVELS = 21
_GLIDE_POINTS = 2001


class ClimbLimitError(ValueError):
    """An aircraft that cannot climb; ``key`` is what its file lacks or has too small."""

    def __init__(self, key: tuple[str, ...], message: str) -> None:
        super().__init__(f"{'.'.join(key)}: {message}")
        self.key, self.message = key, message


class ClimbLimits(NamedTuple):
    """What the propulsion can do: efficiency [-] and largest electric power [W]."""

    efficiency: float
    maximum_power_w: float


@dataclass(frozen=True)
class FlightLevels:
    """One aircraft, of one mass, between the lowest altitude and the ceiling.

    ``altitude_m``, ``potential_energy_wh``, ``propulsion_power_w``: altitude [m], energy of
    altitude and speed above that of the lowest level [Wh], and electric propulsion power of level
    flight in calm air [W]. ``solar_power_w``: power of the solar modules [W].
    ``turbulence_factor``: factor on the propulsion power [-]; ``nominal_factor`` is that without
    thermals. ``constant_power_w``: power of avionics and payload [W]. ``limits``: what the
    propulsion can do.
    """

    altitude_m: FloatArray
    potential_energy_wh: FloatArray
    propulsion_power_w: FloatArray
    solar_power_w: FloatArray
    turbulence_factor: FloatArray
    nominal_factor: float
    constant_power_w: float
    limits: ClimbLimits

    def altitude_at(self, potential_energy_wh: FloatArray) -> FloatArray:
        """Altitude [m] of a potential energy [Wh]."""
        return np.asarray(np.interp(potential_energy_wh, self.potential_energy_wh, self.altitude_m))

    @property
    def nominal_load_w(self) -> float:
        """Load at the lowest altitude without thermals [W]."""
        return float(self.propulsion_power_w[0]) * self.nominal_factor + self.constant_power_w

    def glide_h(self, potential_energy_wh: FloatArray) -> FloatArray:
        """Hours of gliding from a potential energy [Wh] with the motor off [h]."""
        energies = np.linspace(0.0, self.potential_energy_wh[-1], _GLIDE_POINTS)
        level_w = np.interp(energies, self.potential_energy_wh, self.propulsion_power_w)
        slowness = 1.0 / (self.limits.efficiency * (level_w * self.nominal_factor))
        hours = np.concatenate(
            ([0.0], np.cumsum(np.diff(energies) * (slowness[1:] + slowness[:-1]) / 2.0))
        )
        return np.asarray(np.interp(potential_energy_wh, energies, hours))


def climb_limits(aircraft: Aircraft, design: Design) -> ClimbLimits:
    """Efficiency and largest power of the propulsion.

    Parametric: the rated power of the propulsion, sized at the mission's altitude. Measured: as
    the file says.

    ``design``: its mass and the power of its level flight at the mission's altitude. Returns
    efficiency [-] and largest electric power [W], which is above that of level flight.
    """
    airframe = aircraft.airframe
    if isinstance(airframe, MeasuredAirframe):
        flight = airframe.level_flight
        place = ("airframe", "level_flight")
        for name in ("maximum_electric_power_w", "propulsion_efficiency"):
            if getattr(flight, name) is None:
                message = "required key is missing: the mission has climb"
                raise ClimbLimitError((*place, name), message)
        assert flight.propulsion_efficiency is not None
        assert flight.maximum_electric_power_w is not None
        limits = ClimbLimits(flight.propulsion_efficiency, flight.maximum_electric_power_w)
        key = (*place, "maximum_electric_power_w")
    else:
        weight_n = float(design.total_mass_kg) * GRAVITY_M_PER_S2
        level_w = float(design.propulsion_power_w)
        assert design.chain is not None
        rated = float(design.chain.rated_power_w(level_w, weight_n=weight_n))
        limits = ClimbLimits(float(design.chain.efficiency), rated)
        key = ("airframe", "propulsion", "climb_power_ratio")
    if limits.maximum_power_w <= float(design.propulsion_power_w):
        raise ClimbLimitError(
            key,
            f"{limits.maximum_power_w:.3g} W in all leaves nothing to climb with: level flight "
            f"takes {float(design.propulsion_power_w):.3g} W; it must be more",
        )
    return limits


def flight_levels(
    aircraft: Aircraft,
    mission: Mission,
    solar: SolarModel,
    constant: Performance,
    solar_factor: float = 1.0,
) -> FlightLevels:
    """Power and sunlight between a mission's altitude and its ceiling, for the mass built.

    Returns at least two, evenly spaced from the mission's altitude to the ceiling.
    """
    assert mission.climb is not None
    design, day = constant.design, constant.day
    floor_m, ceiling_m = mission.altitude_m, mission.climb.ceiling_m
    count = int(np.ceil((ceiling_m - floor_m) / _LEVEL_SPACING_M - 1e-9)) + 1
    altitudes = np.linspace(floor_m, ceiling_m, min(max(count, 2), _MAXIMUM_LEVELS))
    flown = [_same_aircraft_at(aircraft, mission, design, float(h)) for h in altitudes]
    speed = np.array([0.0 if d.airspeed_m_per_s is None else d.airspeed_m_per_s for d in flown])
    energy_height_m = altitudes + speed**2 / (2.0 * GRAVITY_M_PER_S2)
    weight_n = float(design.total_mass_kg) * GRAVITY_M_PER_S2
    area_m2 = float(design.variables.module_area_m2)
    return FlightLevels(
        altitude_m=altitudes,
        potential_energy_wh=weight_n * (energy_height_m - energy_height_m[0]) / 3600.0,
        propulsion_power_w=np.array([float(d.propulsion_power_w) for d in flown]),
        solar_power_w=area_m2
        * np.stack(
            [
                _specific_power(aircraft, mission.at_altitude(float(h)), solar, day, solar_factor)
                for h in altitudes
            ]
        ),
        turbulence_factor=(constant.load_w - float(design.constant_power_w))
        / float(design.propulsion_power_w),
        nominal_factor=1.0 + mission.turbulence.all_day,
        constant_power_w=float(design.constant_power_w),
        limits=climb_limits(aircraft, design),
    )


def _same_aircraft_at(
    aircraft: Aircraft, mission: Mission, design: Design, altitude_m: float
) -> Design:
    """Level flight of an aircraft of given mass at another altitude."""
    there = mission.at_altitude(altitude_m)
    if isinstance(aircraft.airframe, MeasuredAirframe):
        return measured_design(aircraft, there)
    flown = parametric_design(aircraft, there, design.variables, design.total_mass_kg)
    if not np.isfinite(flown.propulsion_power_w):
        raise ImpossibleDesignError(operating_trouble(aircraft, there))
    return flown


def _specific_power(
    aircraft: Aircraft, there: Mission, solar: SolarModel, day: SolarDay, factor: float
) -> FloatArray:
    found = solar_day(aircraft, there, solar, scenarios=day.scenarios)
    return found.scaled(factor).specific_power_w_per_m2
