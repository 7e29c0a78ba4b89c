"""Quantities that are logged at times of their own: the nearest sample, if it is near enough."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from missions.logs.quantities import ATTITUDE
from solar.types import FloatArray

# A sample of a stream stands for a time no further from it than this [s].
_PLACE = ("latitude_deg", "longitude_deg", "altitude_m")
_AGES = {**dict.fromkeys(ATTITUDE, 0.5), **dict.fromkeys(_PLACE, 2.0)}
OTHER_AGE_S = 5.0


class Series(NamedTuple):
    """A quantity in the unit of the log format, over time since boot [s]."""

    time_s: FloatArray
    values: FloatArray


def age_s_of(quantity: str) -> float:
    """How far from a time a sample of a quantity may be to stand for it [s]."""
    return _AGES.get(quantity, OTHER_AGE_S)


def sampled(series: Series, time_s: FloatArray, age_s: float) -> FloatArray:
    """Nearest sample at other times, NaN if it is older or younger than allowed."""
    own = series.time_s
    if not len(own):
        return np.full(len(time_s), np.nan)
    after = np.minimum(np.searchsorted(own, time_s), len(own) - 1)
    before = np.maximum(after - 1, 0)
    earlier = np.abs(time_s - own[before]) <= np.abs(own[after] - time_s)
    nearest = np.where(earlier, before, after)
    fresh = np.abs(own[nearest] - time_s) <= age_s
    return np.where(fresh, series.values[nearest], np.nan)
