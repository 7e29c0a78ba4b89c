"""What a flight's sky, attitude, clock and model may be off by, and what that does to the power.

The errors are those of :mod:`studies.flight_logs.causes.fit`. There they are wide, so that nothing
is blamed wrongly; here they are what is published, with the sources in ``docs/fit.md``. Power is
multiplied by the exponential of their sum, so that light never becomes negative.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from sizing.sunlight import UNCORRECTED_CAM
from solar.types import FloatArray
from studies.flight_logs.causes.data import LOG_SIGMAS
from studies.flight_logs.causes.fit import MODEL_SIGMAS, modelled
from studies.flight_logs.causes.forward import Forward, LogError

WARMTH = "warmth"  # of the modules: no error where their temperature is fitted
# Haze: 0.08 per unit of Linke's turbidity (Kasten, F. (1996), Solar Energy 56, 239-244), which is 2
# to 5 on clear days; uniform, that scatters by 0.87. Diffuse light: McClear at eight stations, 7 to
# 37 % RMS, 20 % in the mean (preprints.org 202603.0405, section 3.2). Warmth: the 10 K at 95 % that
# are the prior knowledge of `temperature_rise`, at 0.3 %/K. Diffuse light has an
# error of its own here, whatever the haze, and all light from around the sun is one.
SIGMAS = {**MODEL_SIGMAS, "haze": 0.07, "diffuse": 0.2, "warmth": 0.015, "circumsolar": 0.7}
OF_THE_AIRCRAFT = ("incidence", "oblique", "grazing", WARMTH, "low_light")
CAM_SIGMA = UNCORRECTED_CAM.rms_relative
_STEP = 0.5  # standard deviations of an error by which its effect is found
_LEAST_W = 1e-3  # of a relative change


@dataclass(frozen=True)
class FlightError:
    """An error of a flight, known within ``sigma``.

    ``slope``: relative change of the power of each sample or bin per unit of the error. ``flight``:
    its number; None for what is wrong with the model of the aircraft on all flights.
    """

    name: str
    sigma: float
    slope: FloatArray
    flight: int | None = 0


def flight_errors(
    forward: Forward, light_sigma: float, mean: Callable[[FloatArray], FloatArray] = np.asarray
) -> tuple[FlightError, ...]:
    """Errors of light, attitude, clock and model, ``mean`` in bins; none known exactly."""
    level = light_sigma if forward.knows_angles else float(np.hypot(light_sigma, CAM_SIGMA))
    found = (
        FlightError(
            *(name, sigma, (np.log(above) - np.log(below)) / (2.0 * _STEP * sigma)),
            flight=None if name in OF_THE_AIRCRAFT else 0,
        )
        for name, sigma, above, below in _moved(forward, {**SIGMAS, "level": level}, mean)
    )
    return tuple(one for one in found if np.any(one.slope))


def _moved(
    forward: Forward, sigmas: dict[str, float], mean: Callable[[FloatArray], FloatArray]
) -> Iterator[tuple[str, float, FloatArray, FloatArray]]:
    """Errors by name with their standard deviations, and the power above and below [W]."""
    none, nothing = dict.fromkeys(sigmas, 0.0), np.zeros(1)

    def power(error: LogError, values: dict[str, float]) -> FloatArray:
        found = [
            modelled(part.parts(error)._replace(beam_over_diffuse=nothing, passed=nothing), values)
            for part in forward.chunks()
        ]
        return np.maximum(mean(np.concatenate(found)), _LEAST_W)

    for name, sigma in sigmas.items():
        if sigma > 0.0:
            ends = ({**none, name: sign * _STEP * sigma} for sign in (1.0, -1.0))
            above, below = (power(LogError(), values) for values in ends)
            yield name, sigma, above, below
    for name, sigma in LOG_SIGMAS.items() if forward.knows_angles else ():
        wrong = (LogError().plus({name: sign * _STEP * sigma}) for sign in (1.0, -1.0))
        above, below = (power(error, none) for error in wrong)
        yield name, sigma, above, below
