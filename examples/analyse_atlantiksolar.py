"""
Analyse a built aircraft
========================

How long AtlantikSolar AS-2 flies in July, and how sure that is.

Run with: ``python examples/analyse_atlantiksolar.py [figure.png]``
"""

import sys

import missions
import sizing
import studies


def main() -> None:
    """Print metrics by solar model, then the effect of heavier avionics and of the season."""
    # Shipped files are found by name; a path to a file of your own works too.
    aircraft = sizing.load_aircraft("atlantiksolar-as2")
    mission = missions.load_mission("rafz-july")

    # The optimistic model, the default one, and the default one corrected by flight data.
    for model, correction in (("CDM", "none"), ("CAM", "none"), ("CAM", "report")):
        analysis = sizing.analyse(aircraft, mission, model=model, correction=correction)
        # One row per scenario; this mission has one.
        row = analysis.to_frame().iloc[0]
        print(
            f"{model}, correction {correction:6}: excess time {row['excess_time_h']:.2f} h, "
            f"charge margin {row['charge_margin_h']:.2f} h, "
            f"least state of charge {100 * row['minimum_state_of_charge']:.1f} %"
        )

    # Overrides use the keys of the file, as --set does on the command line.
    modified = sizing.load_aircraft("atlantiksolar-as2", {"power.avionics_w": 12})
    excess_h = sizing.analyse(modified, mission).excess_time_h
    print(f"with 12 W of avionics instead of 6 W: excess time {excess_h:.2f} h")

    # The same aircraft on every day of the year.
    solar = sizing.SolarModel("CAM", "report")
    days = sizing.perpetual_days(aircraft, mission, 47.6, solar)
    print(f"perpetual flight at 47.6° N on {len(days)} days, {days[0]} to {days[-1]} of the year")
    if len(sys.argv) > 1:
        studies.plot_cycle(sizing.analyse(aircraft, mission)).savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
