"""Current-voltage curves of modules: efficiency at standard test conditions and its temperature.

The maximum power of a curve is that of a polynomial in the voltage through the points above 85 % of
the largest: of the fifth degree where there are ten (Emery, K. (2011), Measurement and
Characterization of Solar Cells and Modules, in Handbook of Photovoltaic Science and Engineering,
chapter 18), less below. Power is ``eta A G f(G) (1 - beta (T - 25 C))`` with the file's low-light
curve ``f``; curves over 15 K or more determine ``beta`` as well (IEC 60891).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sizing.aircraft import Aircraft
from solar.modules import STC_IRRADIANCE_W_PER_M2, STC_TEMPERATURE_C
from studies.bench.tables import BenchTable, Layout, Quantity
from studies.bench.values import Measured, linear_fit, parameter

LAYOUT = Layout(
    "iv-curve",
    "Current-voltage curves of a module, one below the other; rows of a curve have one number.",
    (
        Quantity("curve", "number of the curve", 1, 1e4),
        Quantity("irradiance_w_per_m2", "by a reference cell in the module's plane", 200, 1500),
        Quantity("module_temperature_c", "of the cells", -40, 120),
        Quantity("area_m2", "of the cells that are measured", 1e-5, 1e3),
        Quantity("voltage_v", "of the module", 0, 1e4),
        Quantity("current_a", "of the module", -1e3, 1e3),
    ),
    tuple((1.0, 950.0, 31.0, 0.0153, v, i) for v, i in (
        (0.0, 5.86), (0.40, 5.82), (0.50, 5.70), (0.54, 5.54), (0.56, 5.39), (0.58, 5.16),
        (0.60, 4.80), (0.62, 4.25), (0.68, 0.0),
    )),
)  # fmt: skip
# Standard uncertainties of a calibrated reference cell with its mismatch, and of the cells'
# temperature by a sensor at the back: assumptions.
IRRADIANCE_SIGMA, TEMPERATURE_SIGMA_K = 0.02, 2.0
_NEAR, _LEAST_SPAN_K, _FEWEST = 0.85, 15.0, 4


def evaluate(table: BenchTable, aircraft: Aircraft) -> Sequence[Measured]:
    """Efficiency of the modules, and temperature coefficient from curves that differ enough."""
    cells, numbers = aircraft.modules, np.unique(table["curve"])
    rows = [table["curve"] == number for number in numbers]
    light, warm, area = (
        np.array([float(table[name][own].mean()) for own in rows])
        for name in ("irradiance_w_per_m2", "module_temperature_c", "area_m2")
    )
    power = np.array([_maximum(table, number) for number in numbers.tolist()])
    low = cells.low_light_efficiency(light)
    low = low / cells.low_light_efficiency(np.array(STC_IRRADIANCE_W_PER_M2))
    efficiency, excess = power / (area * light * low), warm - STC_TEMPERATURE_C
    coefficient = cells.temperature_coefficient_per_k
    both = float(np.ptp(warm)) >= _LEAST_SPAN_K
    if both:
        found, covariance, free = linear_fit(
            np.stack([np.ones(len(warm)), -excess], axis=1), efficiency
        )
        value, slope = found.tolist()
        spread = np.sqrt(np.diag(covariance))
    else:
        found, covariance, free = linear_fit(1.0 - coefficient * excess[:, np.newaxis], efficiency)
        value, slope, spread = (
            float(found[0]),
            coefficient * float(found[0]),
            np.sqrt(covariance[0]),
        )
    # Where the temperature is fitted its error moves both values along the line.
    warmth = abs(slope) * TEMPERATURE_SIGMA_K
    instruments = float(np.hypot(IRRADIANCE_SIGMA * value, warmth))
    notes = (
        f"{table.source}: {len(numbers)} curve{'' if len(numbers) == 1 else 's'}; reference cell "
        f"right to {IRRADIANCE_SIGMA:.0%}, temperature to {TEMPERATURE_SIGMA_K:g} K (assumptions)",
    )
    measured = [
        Measured(parameter("module_efficiency"), value, float(spread[0]), free, instruments, notes)
    ]
    if both:
        relative = float(np.hypot(spread[1] / slope, spread[0] / value)) if slope else np.inf
        per_k = slope / value
        name = parameter("temperature_coefficient")
        measured.append(Measured(name, per_k, abs(per_k) * relative, free, 0.05 * abs(per_k)))
    return measured


def _maximum(table: BenchTable, number: float) -> float:
    """Maximum power of a curve [W]."""
    own = table["curve"] == number
    for name in ("irradiance_w_per_m2", "module_temperature_c", "area_m2"):
        if np.ptp(table[name][own]) > 0.02 * abs(float(table[name][own].mean())) + 1.0:
            raise table.refused(f"curve {number:g}: {name} changes within the curve")
    volts, watts = table["voltage_v"][own], table["voltage_v"][own] * table["current_a"][own]
    near = watts > _NEAR * watts.max()
    if watts.max() <= 0.0 or np.count_nonzero(near) < _FEWEST:
        raise table.refused(
            f"curve {number:g}: {np.count_nonzero(near)} points have {_NEAR:.0%} of its largest "
            f"power (allowed: {_FEWEST} or more)"
        )
    degree = min(5, int(np.count_nonzero(near)) // 2)
    shape = np.polynomial.Polynomial.fit(volts[near], watts[near], degree)
    tops = shape.deriv().roots()
    tops = np.real(tops[np.abs(np.imag(tops)) < 1e-9])
    inside = tops[(tops > volts[near].min()) & (tops < volts[near].max())]
    if not len(inside):
        raise table.refused(f"curve {number:g}: its points do not enclose a maximum of the power")
    return float(shape(inside).max())
