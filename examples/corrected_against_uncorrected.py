"""
Corrected against uncorrected
=============================

How much too small an optimistic model builds, by latitude.

Run with: ``python examples/corrected_against_uncorrected.py [figure.png]``
"""

import sys

from matplotlib.figure import Figure

import missions
import sizing
import studies
from studies.models.solar_models import model_label

MODELS = [sizing.SolarModel("CDM"), sizing.SolarModel("CAM"), sizing.SolarModel("FM", "report")]
LATITUDES_DEG = [0.0, 30.0, 55.0]


def main() -> None:
    """Size with three models at every latitude, evaluate by corrected FM, print and draw."""
    aircraft = sizing.load_aircraft("atlantiksolar-design")
    found = []
    for latitude in LATITUDES_DEG:
        mission = missions.load_mission("rafz-july", [f"latitude_deg={latitude}"])
        found.append(studies.compare(aircraft, mission, models=MODELS, required_excess_time_h=3.0))
    for latitude, comparison in zip(LATITUDES_DEG, found, strict=True):
        print(f"{latitude:g} N, 15 Jul")
        for case in comparison.cases:
            assert case.built is not None
            if case.built.judged is None:
                print(f"  {model_label(case.solar)}: no design")
                continue
            ends = "perpetual" if case.built.judged.perpetual else "not perpetual"
            span_m = case.built.sizing.objective_value
            print(f"  {model_label(case.solar):15}: {span_m:.2f} m, {ends}")
    if len(sys.argv) > 1:
        draw(found).savefig(sys.argv[1], dpi=150)


def draw(found: list[studies.Comparison]) -> Figure:
    """Wingspan against latitude; a cross where corrected FM does not fly the design perpetually."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    looks = zip(("#D55E00", "#E69F00", "#0072B2"), "os^", strict=True)
    for number, (colour, marker) in enumerate(looks):
        built = [comparison.cases[number].built for comparison in found]
        spans_m = [b.sizing.objective_value if b else None for b in built]
        label = f"sized with {model_label(MODELS[number])}"
        axes.plot(LATITUDES_DEG, spans_m, ":", color=colour, marker=marker, label=label)
        for latitude, b in zip(LATITUDES_DEG, built, strict=True):
            if b is not None and b.judged is not None and not b.judged.perpetual:
                axes.plot([latitude], [b.sizing.objective_value], "kx", markersize=10)
    axes.plot([], [], "kx", label="not perpetual by corrected FM")
    axes.set(xlabel="latitude [deg N]", ylabel="smallest wingspan, 15 July [m]")
    axes.legend(title="3 h of excess time required")
    axes.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    main()
