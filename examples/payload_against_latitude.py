"""Payload against latitude: the smallest wingspan that carries it through the summer.

Run with: python examples/payload_against_latitude.py [figure.png]
"""

import sys

import numpy as np
from matplotlib.figure import Figure

from sizing.objectives import Objective
from sizing.optimiser import size_aircraft
from sizing.performance import SolarModel
from studies.library import load_aircraft, load_mission

LATITUDES_DEG = [-30.0, 0.0, 20.0, 40.0, 60.0]
PAYLOADS_KG = [0.0, 1.0, 2.0]


def smallest_wingspan_m(latitude_deg: float, payload_kg: float) -> float:
    """Least wingspan with 2 h of excess time from May to August [m], NaN without a design."""
    result = size_aircraft(
        load_aircraft("atlantiksolar-design").aircraft,
        load_mission(
            "central-europe-summer",
            [f"latitude_deg={latitude_deg}", f"payload.mass_kg={payload_kg}"],
        ).mission,
        Objective.min_wingspan,
        SolarModel("CAM", "report"),
        required_excess_time_h=2.0,
    )
    return np.nan if result.objective_value is None else result.objective_value


def main() -> None:
    """Size every case, print a table and draw a curve for each payload."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    print("payload  " + "".join(f"{latitude:6.0f} N" for latitude in LATITUDES_DEG))
    for payload_kg, marker in zip(PAYLOADS_KG, "os^", strict=True):
        spans_m = [smallest_wingspan_m(latitude, payload_kg) for latitude in LATITUDES_DEG]
        cells = "".join("       -" if np.isnan(s) else f"{s:6.2f} m" for s in spans_m)
        print(f"{payload_kg:4.1f} kg  {cells}")
        axes.plot(LATITUDES_DEG, spans_m, marker=marker, label=f"{payload_kg:g} kg")
    axes.set(xlabel="latitude [deg N]", ylabel="smallest wingspan, May to August [m]")
    axes.legend(title="payload (CAM, correction: report)")
    axes.grid(alpha=0.3)
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
