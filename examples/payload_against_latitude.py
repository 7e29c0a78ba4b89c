"""
Payload against latitude
========================

The smallest wingspan that carries a payload through the summer, by latitude.

Run with: ``python examples/payload_against_latitude.py [figure.png]``
"""

import sys

import numpy as np
from matplotlib.figure import Figure

import missions
import sizing

LATITUDES_DEG = np.arange(-30.0, 61.0, 10.0)
PAYLOADS_KG = np.array([0.0, 1.0, 2.0])
# The summer is its two ends and the solstice. They make one cell: the worst of them counts.
DAYS = np.array([missions.day_of_year(date) for date in ("05-01", "06-21", "08-15")])


def main() -> None:
    """Size every case at once, print a table and draw a curve for each payload."""
    payload, latitude = (v.ravel() for v in np.meshgrid(PAYLOADS_KG, LATITUDES_DEG, indexing="ij"))
    sizings = sizing.size_cells(
        sizing.load_aircraft("atlantiksolar-design"),
        missions.load_mission("central-europe-summer"),
        missions.Scenarios(np.repeat(latitude, len(DAYS)), np.tile(DAYS, len(latitude))),
        solar=sizing.SolarModel("CAM", "report"),
        scenarios_per_cell=len(DAYS),
        required_excess_time_h=2.0,
        payload_mass_kg=payload,
    )
    spans_m = sizings.objective_value.reshape(len(PAYLOADS_KG), len(LATITUDES_DEG))

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    print("payload  " + "".join(f"{latitude:6.0f} N" for latitude in LATITUDES_DEG))
    for payload_kg, row_m, marker in zip(PAYLOADS_KG, spans_m, "os^", strict=True):
        cells = "".join("       -" if np.isnan(s) else f"{s:6.2f} m" for s in row_m)
        print(f"{payload_kg:4.1f} kg  {cells}")
        axes.plot(LATITUDES_DEG, row_m, marker=marker, label=f"{payload_kg:g} kg")
    axes.set(xlabel="latitude [deg N]", ylabel="smallest wingspan, 1 May to 15 August [m]")
    axes.legend(title="payload; 2 h of excess time\n(CAM, correction: report)")
    axes.grid(alpha=0.3)
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
