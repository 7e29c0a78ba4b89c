"""Battery outlook: the smallest aircraft that better cells allow, in summer and towards autumn.

Run with: python examples/battery_outlook.py [figure.png]
"""

import sys

from matplotlib.figure import Figure

from sizing.objectives import Objective
from sizing.optimiser import size_aircraft
from sizing.performance import SolarModel
from studies.library import load_aircraft, load_mission

SPECIFIC_ENERGIES_WH_PER_KG = [200.0, 250.0, 300.0, 400.0, 500.0]
DATES = {"06-21": "21 June", "08-15": "15 August", "09-23": "23 September"}


def smallest_wingspan_m(specific_energy_wh_per_kg: float, date: str) -> float | None:
    """Least wingspan with 3 h of excess time at 47.6 N, none where no design is feasible."""
    energy = f"battery.specific_energy_wh_per_kg={specific_energy_wh_per_kg}"
    result = size_aircraft(
        load_aircraft("atlantiksolar-design", [energy]).aircraft,
        load_mission("rafz-july", [f"dates.on={date}"]).mission,
        Objective.min_wingspan,
        SolarModel("CAM", "report"),
        required_excess_time_h=3.0,
    )
    return result.objective_value


def main() -> None:
    """Print and draw the least wingspan over the cells' specific energy."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for (date, label), marker in zip(DATES.items(), "os^", strict=True):
        spans_m = [smallest_wingspan_m(e, date) for e in SPECIFIC_ENERGIES_WH_PER_KG]
        for energy, span_m in zip(SPECIFIC_ENERGIES_WH_PER_KG, spans_m, strict=True):
            reached = "no design" if span_m is None else f"{span_m:.2f} m"
            print(f"{label}, {energy:.0f} Wh/kg: {reached}")
        axes.plot(SPECIFIC_ENERGIES_WH_PER_KG, spans_m, marker=marker, label=label)
    axes.set(
        xlabel="specific energy of the battery [Wh/kg]", ylabel="smallest wingspan, 47.6 N [m]"
    )
    axes.legend(title="CAM, correction: report")
    axes.grid(alpha=0.3)
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
