"""A value that a bench test determines, with its interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm, t

from sizing.aircraft import Aircraft
from solar.types import FloatArray
from studies.fitting.estimation import Fitted
from studies.fitting.least_squares import CONFIDENCE
from studies.fitting.parameters import PARAMETERS, FitParameter

_TAIL = 0.5 + 0.5 * CONFIDENCE


def parameter(name: str) -> FitParameter:
    """Parameter of a flight's fit, or one of the bench alone."""
    return PARAMETERS[name] if name in PARAMETERS else _OF_THE_BENCH[name]


def _efficiency(name: str, key: str) -> FitParameter:
    return FitParameter(name, key, name.replace("_", " "), "", "load", 0.05, 1.0, 0.2)


_CHAIN = "airframe.propulsion"
_OF_THE_BENCH = {
    one.name: one
    for one in (
        _efficiency("propeller_efficiency", f"{_CHAIN}.propeller_efficiency"),
        _efficiency("motor_efficiency", f"{_CHAIN}.motor_efficiency"),
        _efficiency("propulsion_efficiency", "airframe.level_flight.propulsion_efficiency"),
        _efficiency("span_efficiency", "airframe.aerodynamics.span_efficiency"),
    )
}


@dataclass(frozen=True)
class Measured:
    """A value with the standard error of its scatter, and that of the instruments.

    ``freedom``: degrees of freedom of the scatter; 0 where there is none to see.
    """

    parameter: FitParameter
    value: float
    scatter: float
    freedom: int
    instruments: float
    notes: tuple[str, ...] = ()

    @property
    def standard_error(self) -> float:
        """Of scatter and instruments together."""
        return float(np.hypot(self.scatter, self.instruments))

    def fitted(self, aircraft: Aircraft) -> Fitted:
        """Value with its interval, beside that of the aircraft's file."""
        seen = float(t.ppf(_TAIL, self.freedom)) * self.scatter if self.freedom else 0.0
        half = float(np.hypot(seen, norm.ppf(_TAIL) * self.instruments))
        before = self.parameter.value(aircraft)
        ends = (self.value - half, self.value + half)
        return Fitted(self.parameter, before, self.value, self.standard_error, *ends)


def linear_fit(design: FloatArray, measured: FloatArray) -> tuple[FloatArray, FloatArray, int]:
    """Linear least squares.

    Returns coefficients, their covariance by the scatter of the residuals, and the degrees of
    freedom; without any the covariance is zero.
    """
    found, *_ = np.linalg.lstsq(design, measured, rcond=None)
    free = len(measured) - design.shape[1]
    residual = measured - design @ found
    variance = float(residual @ residual) / free if free > 0 else 0.0
    covariance = np.asarray(variance * np.linalg.pinv(design.T @ design), float)
    return np.asarray(found, float), covariance, max(int(free), 0)
