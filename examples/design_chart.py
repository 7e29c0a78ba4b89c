"""
Design chart
============

Which wingspan and battery fly through a summer, at two aspect ratios.

Run with: ``python examples/design_chart.py [figure.png]``
"""

import sys

import numpy as np

import missions
import sizing
import studies
from studies.output.gridded import feasible


def main() -> None:
    """Print the best battery of each wingspan, and draw excess time and charge margin."""
    # Nothing is sized: each point is a design, flown in all scenarios of the mission. Its modules
    # fill the wing as far as they may. Mass, airspeed and power follow from the geometry.
    data = studies.sweep(
        sizing.load_aircraft("atlantiksolar-design"),
        missions.load_mission("central-europe-summer"),
        {
            "wingspan_m": np.arange(3.0, 7.1, 0.25),
            "battery_mass_kg": np.arange(0.5, 10.1, 0.25),
            "aspect_ratio": [14, 18.5],
        },
        correction="report",
    )
    excess_h = data["excess_time"].where(feasible(data))
    for ratio in data["aspect_ratio"].to_numpy():
        print(f"aspect ratio {ratio:g}")
        for span in (3.0, 4.0, 5.0, 6.0, 7.0):
            row = excess_h.sel(wingspan_m=span, aspect_ratio=ratio).dropna("battery_mass_kg")
            if not row.size:
                print(f"  {span:g} m: no battery makes perpetual flight possible")
                continue
            print(
                f"  {span:g} m: at most {float(row.max()):.2f} h of excess time, "
                f"with {float(row.idxmax()):.2f} kg of battery"
            )
    if len(sys.argv) > 1:
        studies.plot_sweep(data).savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
