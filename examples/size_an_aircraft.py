"""
Size an aircraft
================

The smallest wing that carries a camera through the European summer.

Run with: ``python examples/size_an_aircraft.py [figure.png]``
"""

import sys

import missions
import sizing
import studies


def main() -> None:
    """Print the sized aircraft for two margins, or what stands in the way."""
    # AtlantikSolar's technology; span, battery and module area are free within its design space.
    aircraft = sizing.load_aircraft("atlantiksolar-design")
    # 45° to 50° N, 1 May to 15 August, with a payload.
    camera = {"payload.mass_kg": 0.25, "payload.power_w": 3}
    mission = missions.load_mission("central-europe-summer", camera)

    # Hours without sun that remain possible at every dawn. Try 30.
    for required_h in (2.0, 4.0):
        sized = sizing.size(
            aircraft,
            mission,
            "min_wingspan",
            required_excess_time_h=required_h,
            correction="report",
        )
        # An optimum, or the requirement that cannot be met and what would help.
        print(f"required excess time of {required_h:g} h")
        print(sized)

    # A sized aircraft is an aircraft again: what would the Full Model say of the last one?
    analysis = sizing.analyse(sized.sized_aircraft(), sized.sized_mission(), model="FM")
    print(f"on a circle, by FM: excess time {analysis.excess_time_h:.2f} h")
    if len(sys.argv) > 1:
        masses_kg = sized.design.masses._asdict()
        studies.plot_masses(masses_kg, "for 4 h of excess time").savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
