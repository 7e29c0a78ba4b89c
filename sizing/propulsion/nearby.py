"""Parts with a propeller approximated near one flight, for many similar flights.

Speed of rotation and power of a blade-element propeller are functions of two numbers: loading
``T / (rho V^2 D^2)`` and Reynolds number ``rho V D / mu``. Chebyshev polynomials of the logarithms
are fitted to exact values.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from pydantic import Field

from missions.air import Air
from sizing.propulsion.chain import OperatingPointPropulsion, UnlimitedPropulsion
from sizing.propulsion.operating_point import Shaft
from sizing.smooth import Value
from solar.types import FloatArray

# Half widths of the logarithms (factors of 2.7 in loading, 1.4 in Reynolds number); the degrees
# leave an error of 1e-5 of the power of blade elements.
_HALF_WIDTHS, _DEGREES = (1.0, 0.35), (9, 4)


class NearbyPropulsion(UnlimitedPropulsion):
    """Parts with polynomials for their propeller, and without limits. Not in files.

    ``polynomials``: their centre, and those of the logarithms of ``n D / V`` and of shaft power
    over thrust power.
    """

    is_exact = False

    polynomials: tuple[FloatArray, ...] = Field(exclude=True, repr=False)

    @classmethod
    def of(
        cls, parts: OperatingPointPropulsion, thrust_w: float, speed_m_per_s: float, air: Air
    ) -> NearbyPropulsion:
        """Return these parts near a flight with a thrust power of the whole aircraft [W]."""
        diameter_m = parts.propeller.propeller.diameter_m
        thrust_w = thrust_w / parts.propulsors
        centre = np.log(_numbers(thrust_w, speed_m_per_s, air, diameter_m))
        nodes = [np.cos(np.pi * (np.arange(n + 3) + 0.5) / (n + 3)) for n in _DEGREES]
        x, y = (grid.ravel() for grid in np.meshgrid(*nodes, indexing="ij"))
        loading, reynolds = np.exp(
            centre[:, np.newaxis] + np.stack([x, y]) * np.reshape(_HALF_WIDTHS, (2, 1))
        )
        # Air and size act on the propeller through the two numbers alone.
        density = air.density_kg_per_m3
        node_air = air._replace(
            dynamic_viscosity_pa_s=density * speed_m_per_s * diameter_m / reynolds
        )
        thrust_w = loading * density * speed_m_per_s**3 * diameter_m**2
        shaft = parts.shaft(thrust_w * parts.propulsors, speed_m_per_s, node_air)
        turns, cost = shaft.rotation_per_s * diameter_m / speed_m_per_s, shaft.power_w / thrust_w
        known = np.isfinite(cost)
        basis = chebyshev.chebvander2d(x[known], y[known], _DEGREES)
        rows = np.log(np.stack([turns, cost], axis=1)[known])
        coefficients = np.linalg.lstsq(basis, rows, rcond=1e-10)[0]
        shape = tuple(n + 1 for n in _DEGREES)
        polynomials = (centre, *(column.reshape(shape) for column in coefficients.T))
        return cls.model_construct(**dict(parts), polynomials=polynomials)

    def shaft(self, thrust_power_w: Value, airspeed_m_per_s: Value, air: Air) -> Shaft:
        """Return the shaft of one propulsor at a thrust power of the whole aircraft [W]."""
        thrust_w = thrust_power_w / self.propulsors
        diameter_m = self.propeller.propeller.diameter_m
        centre, *polynomials = self.polynomials
        numbers = _numbers(thrust_w, airspeed_m_per_s, air, diameter_m)
        place: list[Any] = [
            np.clip((np.log(number) - middle) / half, -1.0, 1.0)
            for number, middle, half in zip(numbers, centre, _HALF_WIDTHS, strict=True)
        ]
        turns, cost = (
            np.exp(chebyshev.chebval2d(place[0], place[1], coefficients))
            for coefficients in polynomials
        )
        reason = np.full(np.shape(cost), "", dtype=object)
        return Shaft(turns * airspeed_m_per_s / diameter_m, thrust_w * cost, reason)


def _numbers(thrust_w: Value, speed_m_per_s: Value, air: Air, diameter_m: float) -> Any:
    """Return loading and Reynolds number [-], broadcast to one shape."""
    density = air.density_kg_per_m3
    loading = thrust_w / (density * speed_m_per_s**3 * diameter_m**2)
    reynolds = density * speed_m_per_s * diameter_m / air.dynamic_viscosity_pa_s
    return np.broadcast_arrays(loading, reynolds)
