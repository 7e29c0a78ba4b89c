"""How long the residuals of a fit remember: the integrated autocorrelation time."""

from __future__ import annotations

import numpy as np

from solar.types import FloatArray, IntArray

# Autocorrelation that counts as none: where the window of its sum ends.
_LAST_CORRELATION = 0.05
_LONGEST_MEMORY = 0.97  # of a process, from bin to bin
_MOST_LOST = 0.75  # share of that sum which a fit may have taken away; keeps the correction finite


def correlation_time(residual: FloatArray, run: IntArray, unknown: int) -> float:
    """Integrated autocorrelation time of residuals, in bins, at least 1.

    The fit takes some of the correlation away with what it explains: estimates are too low by about
    the time over the number of residuals for each fitted value (Marriott, F. H. C. & Pope, J. A.
    (1954), Biometrika 41, 390-402). That is added back. The time is at least that of the process of
    first order that the correlations of the next two bins belong to.

    ``run``: pairs across the ends of stretches do not count.
    """
    count = len(residual)
    raw = _autocorrelation(residual, run)
    if len(raw) < 2:
        return 1.0
    least = _mixed_time(raw, 0.0)
    least = _mixed_time(raw, min(least * unknown / count, 1.0))
    small = np.flatnonzero(raw < _LAST_CORRELATION)
    window = int(small[0]) if len(small) else len(raw)
    lags = np.arange(1, window + 1)
    seen = 1.0 + 2.0 * float(np.sum(raw[:window] * (1.0 - lags / count)))
    # Every correlation within the window is too low by time * unknown / count.
    lost = min(2.0 * window * unknown / count, _MOST_LOST)
    time = min(max(seen, 1.0) / (1.0 - lost), count / 2.0)
    return max(time, min(least, count / 2.0))


def _mixed_time(raw: FloatArray, lost: float) -> float:
    """Autocorrelation time of a process of the first order, averaged or with white noise on it.

    Its correlations are ``r_1 rho^(lag - 1)``, their sum ``1 + 2 r_1/(1 - rho)``.

    ``lost``: what the fit has taken away of each, which is added back [-]. Returns in bins, at
    least 1.
    """
    first, second = ((float(value) + lost) / (1.0 + lost) for value in raw[:2])
    if first <= 0.0:
        return 1.0
    rho = min(max(second / first, 0.0), _LONGEST_MEMORY)
    return 1.0 + 2.0 * first / (1.0 - rho)


def _autocorrelation(residual: FloatArray, run: IntArray) -> FloatArray:
    """Autocorrelation at lags of 1, 2, ... bins, up to a third of them."""
    count = len(residual)
    variance = float(np.mean(residual**2))
    if variance == 0.0 or count < 6:
        return np.zeros(0)
    correlations = []
    for lag in range(1, count // 3):
        same = run[lag:] == run[:-lag]
        if np.count_nonzero(same) < 5:
            break
        correlations.append(float(np.mean((residual[lag:] * residual[:-lag])[same])) / variance)
        # Beyond the first that are none, only noise is summed up.
        if len(correlations) > 10 and max(correlations[-5:]) < 0.0:
            break
    return np.array(correlations)
