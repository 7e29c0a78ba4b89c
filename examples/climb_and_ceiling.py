"""
Climb and ceiling
=================

Ceiling of perpetual flight of AtlantikSolar AS-2 in June, and what climbing by day gains.

Run with: ``python examples/climb_and_ceiling.py [figure.png]``
"""

import sys

import missions
import sizing
import studies

# 47.6° N on 21 June in standard air; empty brackets take out what the file says of the air.
JUNE = {"dates": {"on": "06-21"}, "air": {}}


def main() -> None:
    """Print the ceiling of flight at constant altitude, then the gain of climbs by day."""
    aircraft = sizing.load_aircraft("atlantiksolar-as2")
    mission = missions.load_mission("rafz-july", JUNE)

    found = sizing.highest_perpetual_altitude(aircraft, mission, step_m=1000.0)
    if found.highest is None:
        print("no perpetual flight at any altitude")
        return
    print(
        f"perpetual flight up to {found.highest.altitude_m:.0f} m, where level flight takes "
        f"{found.highest.propulsion_power_w:.1f} W"
    )

    # Potential-energy storage: climb once the battery is full, glide in the evening.
    for ceiling_m in (1536, 3536, 6536):
        climbs = missions.load_mission("rafz-july", JUNE | {"climb": {"ceiling_m": ceiling_m}})
        flown = sizing.analyse(aircraft, climbs)
        climb = flown.to_dict()["climb"]
        print(
            f"climbing to {ceiling_m} m stores {climb['stored_height_wh']:.1f} Wh, "
            f"glides {climb['gliding_h']:.1f} h and adds {climb['gain_in_excess_time_h']:.2f} h "
            f"to {climb['constant_altitude_excess_time_h']:.2f} h of excess time"
        )
    if len(sys.argv) > 1:
        studies.plot_cycle(flown).savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
