"""How much residuals scatter, and how many of them are independent."""

from __future__ import annotations

import numpy as np

from solar.types import FloatArray
from studies.flight_logs.autocorrelation import correlation_time
from studies.flight_logs.causes.data import Data
from studies.flight_logs.causes.fit import LEAST_SIGMA, UNKNOWN_NOISE, Fit, Noise

_SECTORS, _CLUSTER_S = 12, 3600.0


def noise_of(data: Data, fit: Fit) -> Noise:
    """Scatter of the residuals, and how many of them are independent; outliers count less.

    Errors of a model last, and return on every circle: the design effect of clusters (Kish, L.
    (1965), Survey Sampling, section 5.4) of one hour and one sector of the sun's bearing.
    """
    sigma = max(fit.scale, LEAST_SIGMA * data.peak)
    residual = np.clip(fit.residual, -3.0 * sigma, 3.0 * sigma)
    sector = np.floor(data.parts(fit.error).bearing * _SECTORS / (2.0 * np.pi)) % _SECTORS
    hour = np.floor((data.time_s - data.time_s[0]) / _CLUSTER_S)
    tracker = np.tile(np.arange(data.trackers), len(data.run))
    effects = []
    for own in {0, data.trackers}:  # of all MPPTs together, and of each
        group = _SECTORS * hour + sector + 1e6 * np.minimum(tracker, own)
        effects.append(design_effect(residual, group, fit, sigma, LEAST_SIGMA * data.peak))
    by_tracker = residual.reshape(-1, data.trackers).T.ravel()
    runs = np.concatenate([data.run + (data.run.max() + 1) * i for i in range(data.trackers)])
    time = correlation_time(by_tracker, runs, fit.jacobian.shape[1])
    return Noise(sigma, 1.0 / max(*effects, time, 1.0))


def design_effect(
    residual: FloatArray, group: FloatArray, fit: Fit, sigma: float, least: float
) -> float:
    """Design effect of clusters; what the fit took of the errors that they share comes back.

    The variances of samples and of clusters are those whose expected sums of squares, of residuals
    and of their sums over clusters, are the ones of the residuals (Henderson, C. R. (1953),
    Biometrics 9(2), 226-252). ``least``: deviation that clusters have at least [W], for a fit may
    take all that is seen of them.
    """
    weight = UNKNOWN_NOISE.worth / sigma**2
    cluster = np.unique(group, return_inverse=True)[1]
    sizes = np.bincount(cluster)
    of_clusters = np.zeros((len(sizes), fit.jacobian.shape[1]))
    np.add.at(of_clusters, cluster, fit.jacobian)
    square = fit.jacobian.T @ fit.jacobian
    inverse = weight * np.linalg.inv(weight * square + np.diag(1.0 / fit.prior**2))
    taken = of_clusters @ inverse @ of_clusters.T
    both = inverse @ square @ inverse
    count, left = len(residual), np.diag(sizes) - taken
    shared = count - 2.0 * np.trace(taken) + np.sum((of_clusters @ both) * of_clusters)
    expected = np.array(
        [[count - np.sum(inverse * square), shared], [np.trace(left), np.sum(left**2)]]
    )
    seen = [np.sum(residual**2), np.sum(np.bincount(cluster, residual) ** 2)]
    own, common = np.maximum(np.linalg.solve(expected, seen), [0.0, least**2])
    within = common / max(own + common, 1e-300)
    return float(1.0 + (np.sum(sizes**2) / count - 1.0) * within)
