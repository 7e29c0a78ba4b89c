"""How high AtlantikSolar AS-2 flies for ever in June, and what climbing with surplus power gains.

Run with: python examples/climb_and_ceiling.py
"""

from missions.library import load_mission
from sizing.altitude.ceiling import highest_perpetual_altitude
from sizing.altitude.climb_cycle import climb_performance
from sizing.library import load_aircraft

# 47.6 N on 21 June in standard air; empty brackets take out what the file says of the air.
JUNE = ["dates={on: 06-21}", "air={}"]


def main() -> None:
    """Print the ceiling of flight at constant altitude, then the gain of climbs by day."""
    aircraft = load_aircraft("atlantiksolar-as2")
    mission = load_mission("rafz-july", JUNE)

    found = highest_perpetual_altitude(aircraft, mission, step_m=1000.0)
    if found.highest is None:
        print("no perpetual flight at any altitude")
        return
    print(
        f"perpetual flight up to {found.highest.altitude_m:.0f} m, where level flight takes "
        f"{found.highest.propulsion_power_w:.1f} W"
    )

    # Potential-energy storage: climb once the battery is full, glide in the evening.
    for ceiling_m in (1536, 3536, 6536):
        climbs = load_mission("rafz-july", [*JUNE, f"climb={{ceiling_m: {ceiling_m}}}"])
        result = climb_performance(aircraft, climbs)
        stored_wh = result.climb.maximum_potential_energy_wh[0]
        print(
            f"climbing to {ceiling_m} m stores {stored_wh:.1f} Wh, "
            f"glides {result.climb.gliding_h[0]:.1f} h and adds {result.gain_h[0]:.2f} h "
            f"to {result.constant.cycle.excess_time_h[0]:.2f} h of excess time"
        )


if __name__ == "__main__":
    main()
