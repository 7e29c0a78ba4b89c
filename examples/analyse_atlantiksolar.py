"""Analyse a built aircraft: how long AtlantikSolar AS-2 flies in July, and how sure that is.

Run with: python examples/analyse_atlantiksolar.py
"""

from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.performance import performance, perpetual_days
from sizing.sunlight import SolarModel


def main() -> None:
    """Print metrics by solar model, then the effect of heavier avionics and of the season."""
    # Shipped files are found by name; a path to a file of your own works too.
    aircraft = load_aircraft("atlantiksolar-as2")
    mission = load_mission("rafz-july")

    # The optimistic model, the default one, and the default one corrected by flight data.
    for solar in (SolarModel("CDM"), SolarModel("CAM"), SolarModel("CAM", "report")):
        cycle = performance(aircraft, mission, solar).cycle
        # Arrays have one entry per scenario; this mission has one.
        print(
            f"{solar.model}, correction {solar.correction:6}: "
            f"excess time {cycle.excess_time_h[0]:.2f} h, "
            f"charge margin {cycle.charge_margin_h[0]:.2f} h, "
            f"least state of charge {100 * cycle.minimum_state_of_charge[0]:.1f} %"
        )

    # Overrides use the keys of the file, as --set does on the command line.
    hungry = load_aircraft("atlantiksolar-as2", ["power.avionics_w=12"])
    excess_h = performance(hungry, mission).cycle.excess_time_h[0]
    print(f"with 12 W of avionics instead of 6 W: excess time {excess_h:.2f} h")

    # The same aircraft on every day of the year.
    days = perpetual_days(aircraft, mission, 47.6, SolarModel("CAM", "report"))
    print(f"perpetual flight at 47.6 N on {len(days)} days, {days[0]} to {days[-1]} of the year")


if __name__ == "__main__":
    main()
