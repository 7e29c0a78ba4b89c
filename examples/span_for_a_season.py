"""
Span for a season
=================

The wingspan that a share of the days of a real season takes. The figure is shown on the page
:doc:`/season`.

Run with: ``python examples/span_for_a_season.py [figure.png]``
"""

import sys

from matplotlib.figure import Figure

import missions
import sizing

SHARES = (0.5, 0.7, 0.8, 0.9, 0.95, 0.99)


def main() -> None:
    """Print and draw the least wingspan over the share of days that close."""
    aircraft = sizing.load_aircraft("atlantiksolar-design")
    # 1 May to 15 August at the site of the record.
    place = {"latitude_deg": 40.5, "altitude_m": 2300.0}
    mission = missions.load_mission("central-europe-summer", place)
    weather = missions.load_weather("colorado-2023")
    sizings = [
        sizing.size_in_weather(aircraft, mission, weather, "min_wingspan", survive=share)
        for share in SHARES
    ]
    spans_m = [sized.variables.wingspan_m for sized in sizings]
    reached = [100.0 * sized.survival.achieved for sized in sizings]
    clear = sizings[0].survival
    clear_m, clear_share = clear.clear_sky.objective_value, 100.0 * clear.clear_sky_days.share
    print(f"for a clear sky: {clear_m:.2f} m, {clear_share:.1f} % of the days")
    for share, sized in zip(SHARES, sizings, strict=True):
        span_m, mass_kg = sized.variables.wingspan_m, sized.design.total_mass_kg
        days = sized.survival.days
        print(
            f"{100 * share:.0f} %: {span_m:.2f} m, {mass_kg:.2f} kg, {days.that_close} of "
            f"{len(days)} days, longest gap {days.longest_gap_days} days"
        )
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.plot(spans_m, reached, marker="o")
    axes.plot(clear_m, clear_share, "s", color="tab:red")
    axes.annotate(
        "design for a clear sky",
        (clear_m, clear_share),
        textcoords="offset points",
        xytext=(8, -4),
    )
    axes.set(
        xlabel="smallest wingspan [m]",
        ylabel="days that close, 1 May to 15 Aug 2023 [%]",
        ylim=(0, 102),
    )
    axes.grid(alpha=0.3)
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
