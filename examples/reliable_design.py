"""
Reliable design
===============

The span that a probability of 3 h of excess time takes.

Run with: ``python examples/reliable_design.py [figure.png]``
"""

import sys

import numpy as np
from matplotlib.figure import Figure

import missions
import sizing

RELIABILITIES = (0.5, 0.7, 0.8, 0.9, 0.95, 0.99)


def main() -> None:
    """Print and draw the least wingspan over the reliability."""
    # The file says how battery, cells, drag, propeller and structure may turn out otherwise.
    aircraft = sizing.load_aircraft("atlantiksolar-design")
    mission = missions.load_mission("rafz-july", {"required_excess_time_h": 3.0})
    sizings = [
        sizing.size(aircraft, mission, "min_wingspan", reliability=reliability)
        for reliability in RELIABILITIES
    ]
    nominal = sizings[0].reliability
    print(f"no margin: {nominal.nominal_objective:.2f} m, {100 * nominal.nominal.value:.1f} %")
    for reliability, sized in zip(RELIABILITIES, sizings, strict=True):
        span_m, mass_kg = sized.variables.wingspan_m, sized.design.total_mass_kg
        reached = sized.reliability.achieved.text()
        print(f"{100 * reliability:.0f} %: {span_m:.2f} m, {mass_kg:.2f} kg, {reached}")
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    spans_m = np.array([sized.variables.wingspan_m for sized in sizings])
    reached = [sized.reliability.achieved for sized in sizings]
    share = np.array([estimate.value for estimate in reached])
    low = np.array([estimate.low for estimate in reached])
    high = np.array([estimate.high for estimate in reached])
    axes.errorbar(
        spans_m, 100 * share, 100 * np.array([share - low, high - share]), marker="o", capsize=3
    )
    axes.plot(nominal.nominal_objective, 100 * nominal.nominal.value, "s", color="tab:red")
    axes.annotate(
        "optimum without uncertainty",
        (nominal.nominal_objective, 100 * nominal.nominal.value),
        textcoords="offset points",
        xytext=(8, -4),
    )
    axes.set(
        xlabel="smallest wingspan, 47.6° N on 15 July [m]",
        ylabel="probability of 3 h of excess time [%]",
        ylim=(20, 102),
    )
    axes.grid(alpha=0.3)
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
