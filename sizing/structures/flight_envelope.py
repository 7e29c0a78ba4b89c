"""Flight envelope (V-n diagram): load factors over airspeed, and the gusts that size the wing.

Manoeuvre and gust envelopes of CS 23.333, with the gust speeds and speed ratios of the structure's
file. Airspeeds are equivalent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from missions.air import GRAVITY_M_PER_S2
from sizing.structures.loads import (
    SEA_LEVEL_DENSITY_KG_PER_M3,
    StructureInputs,
    gust_load_increment,
)
from sizing.structures.rib_wing import RibWingStructure
from solar.types import FloatArray


@dataclass(frozen=True)
class FlightEnvelope:
    """Airspeeds [m/s, equivalent] and load factors [-] of an aircraft.

    Attributes
    ----------
    stall_speed_m_per_s, cruise_speed_m_per_s, dive_speed_m_per_s : float
        At one g; of level flight, taken as cruise; ``dive_speed_ratio`` times that.
    manoeuvre_load_factor, negative_manoeuvre_load_factor : float
        Limits of manoeuvres, the second counted positive.
    cruise_gust_increment, dive_gust_increment : float
        What the gust of that speed adds and takes away.
    limit_load_factor, negative_limit_load_factor : float
        What the structure is sized for, the second counted positive.
    """

    stall_speed_m_per_s: float
    cruise_speed_m_per_s: float
    dive_speed_m_per_s: float
    manoeuvre_load_factor: float
    negative_manoeuvre_load_factor: float
    cruise_gust_increment: float
    dive_gust_increment: float
    limit_load_factor: float
    negative_limit_load_factor: float

    def highest_lift(self, airspeed_m_per_s: ArrayLike) -> FloatArray:
        """Load factor at the maximum lift coefficient, ``(V/V_s)^2`` [-]."""
        return np.asarray((np.asarray(airspeed_m_per_s, float) / self.stall_speed_m_per_s) ** 2)

    def manoeuvre(self, airspeed_m_per_s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Largest load factors of manoeuvres, upwards and downwards (negative) [-].

        Limited by the lift: downwards by the same coefficient, as no other is known. The downward
        limit falls linearly to none from cruise to dive speed, CS 23.333 (b).
        """
        airspeed, stalled = np.asarray(airspeed_m_per_s, float), self.highest_lift(airspeed_m_per_s)
        fading = np.interp(airspeed, (self.cruise_speed_m_per_s, self.dive_speed_m_per_s), (1, 0))
        up = np.minimum(stalled, self.manoeuvre_load_factor)
        return up, -np.minimum(stalled, fading * self.negative_manoeuvre_load_factor)

    @property
    def gusts(self) -> tuple[tuple[float, float], ...]:
        """Airspeed [m/s] and increment [-] of the gusts at cruise and at dive speed."""
        return (
            (self.cruise_speed_m_per_s, self.cruise_gust_increment),
            (self.dive_speed_m_per_s, self.dive_gust_increment),
        )

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return dict(vars(self))


def flight_envelope(
    model: RibWingStructure, inputs: StructureInputs, maximum_lift_coefficient: float
) -> FlightEnvelope:
    """Flight envelope of a rib wing.

    Parameters
    ----------
    model : RibWingStructure
        With its gusts and its ratio of dive speed.
    inputs : StructureInputs
        As numbers.
    maximum_lift_coefficient : float
        Of the aircraft [-].

    Returns
    -------
    FlightEnvelope
    """
    wing = model.wing(inputs)
    area_m2, density = float(wing.wing_area_m2), float(inputs.density_kg_per_m3)
    mass_kg, cruise = float(inputs.total_mass_kg), float(wing.equivalent_airspeed_m_per_s)
    dynamic = 0.5 * SEA_LEVEL_DENSITY_KG_PER_M3 * area_m2 * maximum_lift_coefficient
    dive, pull_up = model.dive_speed_ratio * cruise, float(model.pull_up(mass_kg))
    fraction = float(inputs.gust_fraction) if model.gusts_fall_with_altitude else 1.0
    increments = [
        float(
            gust_load_increment(
                fraction * gust * airspeed,
                total_mass_kg=mass_kg,
                wing_area_m2=area_m2,
                aspect_ratio=float(inputs.aspect_ratio),
                density_kg_per_m3=density,
            )
        )
        for gust, airspeed in ((model.cruise_gust_m_per_s, cruise), (model.dive_gust_m_per_s, dive))
    ]
    return FlightEnvelope(
        stall_speed_m_per_s=float((mass_kg * GRAVITY_M_PER_S2 / dynamic) ** 0.5),
        cruise_speed_m_per_s=cruise,
        dive_speed_m_per_s=dive,
        manoeuvre_load_factor=pull_up,
        negative_manoeuvre_load_factor=model.negative_load_ratio * pull_up,
        cruise_gust_increment=increments[0],
        dive_gust_increment=increments[1],
        limit_load_factor=float(wing.factors.up),
        negative_limit_load_factor=float(wing.factors.down),
    )
