"""Specific power of an aircraft's modules over scenarios and time, and the flow that cools them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.air import Air, plate_convection_w_per_m2k
from missions.flight_path import at_airspeed, path_trouble
from missions.loiter_power import Daylight, PathModules, mean_power_on_path
from missions.mission import Mission, Scenarios
from sizing.aircraft import Aircraft
from sizing.design import Design
from sizing.mass_budget import airspeed_in_flight
from solar.clearsky import pressure_ratio
from solar.heat_balance import (
    EARTH_ALBEDO,
    Surroundings,
)
from solar.horizontal_models import HORIZONTAL_MODELS, horizontal_specific_power, in_surroundings
from solar.names import ATTITUDE_MODELS, ModelName
from solar.types import FloatArray

# Flow over that of the known power, and its inverse, at which power is computed as well.
FASTER = math.sqrt(2.0)
SLOWER = 1.0 / FASTER
_LEAST_GAIN = 1e-6  # of the power, by a faster flow; less is rounding


class Cooling(NamedTuple):
    """Change of the power of modules with the flow that cools them.

    In a convection ``h`` the power is ``a - b / (h + g)`` of the known one: as much heat as modules
    are warmer than the air is carried away by it, and by radiation.

    ``convection``: that of the known power, of every level [W/(m2 K)]. ``terms``: ``a``, ``b`` and
    ``g``, each of the shape of the power. ``transition_reynolds``: of the modules' flow.
    """

    convection: FloatArray
    terms: tuple[FloatArray, ...]
    transition_reynolds: float

    @classmethod
    def of(
        cls,
        power: FloatArray,
        slower: FloatArray,
        faster: FloatArray,
        convection: FloatArray,
        transition_reynolds: float,
    ) -> Cooling:
        """Return the cooling from the power in a flow, ``SLOWER`` and ``FASTER``, exact in these.

        Powers are of shape ``(level, scenario, time)``, ``convection`` of every level.
        """
        flow, known = convection.reshape(-1, 1, 1), np.where(power > 0.0, power, np.inf)
        gain, loss = (faster - power) / known, (power - slower) / known
        changes = np.abs(gain) > _LEAST_GAIN
        # Of (h - h0) / (h + g), which tells g: from 1 over FASTER, all by radiation, to FASTER.
        ratio = np.clip(loss / np.where(changes, gain, np.inf), 1.01 * SLOWER, FASTER)
        radiation = flow * (1.0 - SLOWER * ratio) / (ratio - SLOWER)
        most = gain * (FASTER * flow + radiation) / ((FASTER - 1.0) * flow)
        most = np.where(changes, most, 0.0)
        terms = (1.0 + most, most * (flow + radiation), radiation)
        return cls(convection, terms, transition_reynolds)

    @classmethod
    def joined(cls, days: Sequence[Cooling]) -> Cooling:
        """Return the cooling of the scenarios of several days, one day after the other."""
        terms = zip(*(day.terms for day in days), strict=True)
        return days[0]._replace(terms=tuple(np.concatenate(each, axis=1) for each in terms))

    def mapped(self, function: Callable[[FloatArray], FloatArray]) -> Cooling:
        """Return the same flow with a function of all arrays of the shape of the power."""
        return self._replace(terms=tuple(map(function, self.terms)))

    def factor(self, convection: ArrayLike) -> FloatArray:
        """Return the factor on the known power in another flow [W/(m2 K)]."""
        most, lost, radiation = self.terms
        return np.asarray(most - lost / (np.asarray(convection, float) + radiation))


def balances_heat(mission: Mission) -> bool:
    """Return whether the modules balance their heat: no temperature of theirs is set."""
    return mission.air.module_temperature_c is None


def convection_of(
    design: Design, air: Air, transition_reynolds: float, unknown: ArrayLike
) -> FloatArray:
    """Return the convection of designs in level flight, ``unknown`` where none is known."""
    speed = design.airspeed_m_per_s
    if speed is None:
        return np.asarray(unknown)
    chord = np.asarray(design.variables.wingspan_m, float) / design.variables.aspect_ratio
    with np.errstate(invalid="ignore"):
        flow = plate_convection_w_per_m2k(air, speed, chord, transition_reynolds)
    return np.where(np.isfinite(flow), flow, unknown)


def convection_in_flight(
    aircraft: Aircraft, mission: Mission, airspeed_m_per_s: float | None = None
) -> float:
    """Return the convection of an aircraft's file in level flight [W/(m2 K)]."""
    speed = airspeed_m_per_s or airspeed_in_flight(aircraft, mission)
    chord = aircraft.airframe.wingspan_m / aircraft.airframe.aspect_ratio
    transition = aircraft.modules.thermal.transition_reynolds
    return float(plate_convection_w_per_m2k(mission.air_state(), speed, chord, transition))


# Airspeed over wind of a design that is slower than the wind, on a path: no path can be held at
# less, and 5 % are what power along a path tolerates.
_ABOVE_WIND = 1.05


def on_path(aircraft: Aircraft, mission: Mission) -> Mission:
    """Return the mission with its flight path at the design's airspeed where its file has none.

    :mod:`sizing.validity` tells of a design that is slower than the wind; the airspeed of its path
    is a little above the wind.
    """
    return _on_paths(aircraft, mission, [mission])[0]


def _on_paths(aircraft: Aircraft, mission: Mission, winds: Sequence[Mission]) -> list[Mission]:
    """Return the mission in several winds, each on its path."""
    path = mission.flight_path
    if path is None or getattr(path, "airspeed_m_per_s", 0.0) is not None:
        return list(winds)
    airspeed = airspeed_in_flight(aircraft, mission)
    paths = (
        at_airspeed(path, max(airspeed, _ABOVE_WIND * there.wind.speed_m_per_s)) for there in winds
    )
    return [
        there.model_copy(update={"flight_path": new_path})
        for there, new_path in zip(winds, paths, strict=True)
    ]


def path_troubles(
    aircraft: Aircraft, mission: Mission, scenarios: Scenarios | None = None
) -> list[str | None]:
    """Return why a path cannot be held in the wind of each scenario; None where it can.

    ``scenarios``: of which each has its own wind; left out, the strongest wind alone.
    """
    winds, each = [mission], np.zeros(1, int)
    if scenarios is not None:
        speeds, each = np.unique(mission.winds_on_path_m_per_s(scenarios), return_inverse=True)
        winds = [mission.in_wind(speed) for speed in speeds.tolist()]
    troubles = [
        None if there.flight_path is None else path_trouble(there.flight_path, there.wind)
        for there in _on_paths(aircraft, mission, winds)
    ]
    return [troubles[place] for place in each]


def surroundings(mission: Mission, convection: float) -> Surroundings:
    """Return the air and radiation around modules on a mission in a flow."""
    albedo = mission.air.albedo
    return Surroundings(
        float(mission.air_state().temperature_c),
        convection,
        float(pressure_ratio(mission.altitude_m)),
        EARTH_ALBEDO if albedo is None else albedo,
    )


def surroundings_in_flight(aircraft: Aircraft, mission: Mission) -> Surroundings | None:
    """Return the surroundings of modules in level flight; None where they balance no heat."""
    if not balances_heat(mission):
        return None
    return surroundings(mission, convection_in_flight(aircraft, mission))


def modelled_power(
    aircraft: Aircraft,
    mission: Mission,
    model: ModelName,
    scenarios: Scenarios,
    time_h: FloatArray,
    around: Surroundings | None,
) -> FloatArray:
    """Return the uncorrected specific power of a model over scenarios and time [W/m2].

    CDM and CAM see one horizontal surface, VM and FM are averaged over the mission's flight path.
    ``around``: surroundings of the modules; without them they have the mission's temperature.
    """
    latitude_deg, day = scenarios.latitude_deg, scenarios.noon_day
    if model not in ATTITUDE_MODELS:
        places = (latitude_deg[:, np.newaxis], day[:, np.newaxis])
        light = clear_daylight(mission, *places, time_h)
        return specific_power(aircraft, mission, model, light, around)
    winds = mission.scenario_winds_m_per_s(scenarios).tolist()
    windy = _on_paths(aircraft, mission, [mission.in_wind(wind) for wind in winds])
    return np.stack(
        [
            specific_power(
                aircraft, there, model, clear_daylight(there, float(latitude), noon, time_h), around
            )
            for there, latitude, noon in zip(windy, latitude_deg, day, strict=True)
        ]
    )


def clear_daylight(
    mission: Mission,
    latitude_deg: float | FloatArray,
    day_of_year: ArrayLike,
    time_solar_h: FloatArray,
) -> Daylight:
    """Return the light of a mission's clear sky."""
    return Daylight(
        latitude_deg,
        day_of_year,
        time_solar_h,
        mission.altitude_m,
        mission.pessimistic_clearness,
        mission.sky,
        albedo=mission.air.albedo or 0.0,
    )


def specific_power(
    aircraft: Aircraft,
    mission: Mission,
    model: ModelName,
    light: Daylight,
    around: Surroundings | None,
    air_c: ArrayLike | None = None,
    module_c: ArrayLike | None = None,
) -> FloatArray:
    """Return the uncorrected power by any model [W/m2]; VM and FM take a single latitude.

    ``air_c``, ``module_c``: temperature of the air and, without surroundings, of the modules; those
    of the mission by default, one at each time of a light that is no clear sky's.
    """
    modules = aircraft.modules
    air_c = float(mission.air_state().temperature_c) if air_c is None else np.asarray(air_c)
    module_c = mission.module_temperature_c() if module_c is None else np.asarray(module_c)
    if model in ATTITUDE_MODELS:
        if modules.geometry is None:
            text = f"model {model} needs modules.geometry on the aircraft {aircraft.name}"
            raise ValueError(text)
        path = on_path(aircraft, mission).flight_path
        if path is None:
            raise ValueError(f"model {model} needs a flight_path on the mission {mission.name}")
        return mean_power_on_path(
            model,
            PathModules(modules.geometry, modules, path, mission.wind, modules.shading),
            light,
            ambient_temperature_c=air_c,
            module_temperature_c=module_c,
            surroundings=around,
        )
    convert, seen = HORIZONTAL_MODELS[model], light.irradiance
    if around is not None:
        convert = in_surroundings(convert, around._replace(ambient_c=air_c))
    return horizontal_specific_power(
        *light[:3],
        cell=modules,
        module_temperature_c=module_c,
        altitude_m=light.altitude_m,
        clearness=light.clearness,
        sky=light.sky if seen is None else lambda *_: seen,
        model=convert,
    )
