"""
Battery outlook
===============

The smallest aircraft that better cells allow, in summer and towards autumn.

Run with: ``python examples/battery_outlook.py [figure.png]``
"""

import sys

import numpy as np
from matplotlib.figure import Figure

import missions
import sizing

SPECIFIC_ENERGIES_WH_PER_KG = np.arange(200.0, 501.0, 25.0)
DATES = {"21 June": "06-21", "15 August": "08-15", "23 September": "09-23"}
LATITUDE_DEG = 47.6


def smallest_wingspans_m(specific_energy_wh_per_kg: float) -> np.ndarray:
    """Least wingspan on each date with 3 h of excess time; NaN where no design is feasible."""
    days = np.array([missions.day_of_year(date) for date in DATES.values()])
    better = {"battery.specific_energy_wh_per_kg": specific_energy_wh_per_kg}
    # Every date is a cell of its own; cells are sized for the least wingspan by default.
    sizings = sizing.size_cells(
        sizing.load_aircraft("atlantiksolar-design", better),
        missions.load_mission("rafz-july"),
        missions.Scenarios(np.full(len(days), LATITUDE_DEG), days),
        solar=sizing.SolarModel("CAM", "report"),
        required_excess_time_h=3.0,
    )
    return sizings.objective_value


def main() -> None:
    """Print and draw the least wingspan over the cells' specific energy."""
    spans_m = np.array([smallest_wingspans_m(e) for e in SPECIFIC_ENERGIES_WH_PER_KG])
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for date, column, marker in zip(DATES, spans_m.T, "os^", strict=True):
        for energy, span_m in zip(SPECIFIC_ENERGIES_WH_PER_KG, column, strict=True):
            reached = "no design" if np.isnan(span_m) else f"{span_m:.2f} m"
            print(f"{date}, {energy:.0f} Wh/kg: {reached}")
        axes.plot(SPECIFIC_ENERGIES_WH_PER_KG, column, marker=marker, label=date)
    axes.set(
        xlabel="specific energy of the battery [Wh/kg]", ylabel="smallest wingspan, 47.6° N [m]"
    )
    axes.legend(title="3 h of excess time\n(CAM, correction: report)")
    axes.grid(alpha=0.3)
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
