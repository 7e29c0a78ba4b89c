"""
Compare the solar power models
==============================

What each model predicts and would have built, and how that really flies.

Run with: ``python examples/compare_models.py [figure.png]``
"""

import sys

import missions
import sizing
import studies
from studies.models.solar_models import model_label


def main() -> None:
    """Print the outcome of every model's design, and the summary."""
    # A parametric aircraft: every model sizes an aircraft. The reference is corrected FM.
    aircraft = sizing.load_aircraft("atlantiksolar-design")
    mission = missions.load_mission("rafz-july")
    comparison = studies.compare(aircraft, mission, required_excess_time_h=3.0)

    for case in comparison.cases:
        # Every model sees the same aircraft ...
        seen = case.prediction
        print(
            f"{model_label(case.solar):21}: {seen.solar_energy_wh:.0f} Wh a day, "
            f"excess time {seen.excess_time_h:.2f} h, {case.season.days} days a year"
        )
        # ... and would have built another aircraft.
        if case.built is None or case.built.sizing.design is None or case.built.judged is None:
            continue
        span_m = case.built.sizing.design.variables.wingspan_m
        print(f"  would build {span_m:.2f} m, which {case.built.judged.outcome(3.0)}")
    print(comparison.headline())

    if len(sys.argv) > 1:
        studies.plot_comparison(comparison).savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
