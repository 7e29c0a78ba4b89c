"""Air around the solar modules of a design: what cools them on a mission."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from missions.air import GRAVITY_M_PER_S2, plate_convection_w_per_m2k, thin_air_share
from missions.mission import Mission
from sizing.aircraft import Aircraft, MeasuredAirframe
from sizing.design import Design, closed_design, first_chain, measured_design, variables_of
from sizing.propulsion.chain import OperatingPointPropulsion
from solar.clearsky import pressure_ratio
from solar.heat_balance import EARTH_ALBEDO, Surroundings
from solar.types import FloatArray

# Of flights whose airspeed nobody measured, and of first guesses that cannot fly: lift coefficient
# of level flight (Noth 2008, Design of solar powered airplanes for continuous flight) and wing
# loading [kg/m2], in the middle of what has been built.
_LIFT_COEFFICIENT, _WING_LOADING = 0.8, 4.0


class Cooling(NamedTuple):
    """How the power of modules changes with the flow that cools them.

    ``convection``: that of the known power [W/(m2 K)]. ``gain``: power of modules as cold as the
    air over that power, less 1 [-]. ``radiation``: what radiation adds to the convection
    [W/(m2 K)]. Arrays of the shape of the power. ``transition_reynolds``: of the modules' flow.
    """

    convection: float
    gain: FloatArray
    radiation: FloatArray
    transition_reynolds: float

    @classmethod
    def between(
        cls,
        cold: FloatArray,
        known: FloatArray,
        cooled: FloatArray,
        *,
        convection: tuple[float, float],
        transition_reynolds: float,
    ) -> Cooling:
        """Cooling from the power of cold modules and that in two flows.

        The rise of the temperature goes with ``1 / (h + g)``, where ``g`` hardly changes; two flows
        give it.
        """
        first, second = convection
        left, less = cold - known, cold - cooled
        warm = (left > 0.0) & (less > 0.0) & (left > less)
        ratio = np.where(warm, less, 1.0) / np.where(warm, left, 2.0)
        radiation = np.where(warm, (second * ratio - first) / (1.0 - ratio), 0.0)
        gain = np.where(warm, left / np.where(warm, known, 1.0), 0.0)
        return cls(first, gain, np.maximum(radiation, 0.0), transition_reynolds)

    def mapped(self, gain: FloatArray, radiation: FloatArray) -> Cooling:
        """Same flow with other arrays."""
        return self._replace(gain=gain, radiation=radiation)

    def factor(self, convection: ArrayLike) -> FloatArray:
        """Factor on the known power in another flow [W/(m2 K)]."""
        flow = np.asarray(convection, float)
        warm = (self.convection + self.radiation) / (flow + self.radiation)
        return np.asarray(1.0 + self.gain * (1.0 - warm))


def balances_heat(mission: Mission) -> bool:
    """Whether the modules find their own temperature on a mission."""
    return mission.air.module_temperature_c is None and bool(
        np.any(thin_air_share(mission.altitude_m) > 0.0)
    )


def convection_of(
    design: Design, mission: Mission, transition_reynolds: float, unknown: float
) -> FloatArray:
    """Convection of designs in level flight on a mission, ``unknown`` where none is known."""
    speed = design.airspeed_m_per_s
    if speed is None:
        return np.asarray(unknown)
    chord = np.asarray(design.variables.wingspan_m, float) / design.variables.aspect_ratio
    with np.errstate(invalid="ignore"):
        found = plate_convection_w_per_m2k(mission.air_state(), speed, chord, transition_reynolds)
    return np.where(np.isfinite(found), found, unknown)


def convection_in_flight(aircraft: Aircraft, mission: Mission) -> float:
    """Convection of an aircraft as its file describes it, in level flight [W/(m2 K)]."""
    airframe, air = aircraft.airframe, mission.air_state()
    chord = airframe.wingspan_m / airframe.aspect_ratio
    transition = aircraft.modules.thermal.transition_reynolds
    loading = _WING_LOADING
    if isinstance(airframe, MeasuredAirframe):
        design = measured_design(aircraft, mission)
        loading = float(design.total_mass_kg) / (airframe.wingspan_m * chord)
    else:
        if isinstance(airframe.propulsion, OperatingPointPropulsion):
            usual = airframe.model_copy(update={"propulsion": first_chain(airframe.propulsion)})
            aircraft = aircraft.model_copy(update={"airframe": usual})
        design = closed_design(aircraft, mission, variables_of(aircraft))
    weight = 2.0 * loading * GRAVITY_M_PER_S2
    speed = np.sqrt(weight / (air.density_kg_per_m3 * _LIFT_COEFFICIENT))
    unknown = float(plate_convection_w_per_m2k(air, speed, chord, transition))
    return float(convection_of(design, mission, transition, unknown))


def surroundings(mission: Mission, convection: float) -> Surroundings:
    """What heats and cools modules on a mission in a flow."""
    albedo = mission.air.albedo
    return Surroundings(
        float(mission.air_state().temperature_c),
        convection,
        float(pressure_ratio(mission.altitude_m)),
        EARTH_ALBEDO if albedo is None else albedo,
        float(thin_air_share(mission.altitude_m)),
    )
