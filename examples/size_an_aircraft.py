"""Size an aircraft: the smallest wing that carries a camera through the European summer.

Run with: python examples/size_an_aircraft.py
"""

from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.optimisation.objectives import Objective
from sizing.optimisation.search import size_aircraft
from sizing.sunlight import SolarModel


def main() -> None:
    """Print the sized aircraft for two margins, or what stands in the way."""
    # AtlantikSolar's technology; span, battery and module area are free within its design space.
    aircraft = load_aircraft("atlantiksolar-design")
    # 45 to 50 N, 1 May to 15 August, with a payload.
    mission = load_mission("central-europe-summer", ["payload.mass_kg=0.25", "payload.power_w=3"])

    # Hours without sun that remain possible at every dawn. Try 30.
    for margin_h in (2.0, 4.0):
        result = size_aircraft(
            aircraft,
            mission,
            Objective.min_wingspan,
            SolarModel("CAM", "report"),
            required_excess_time_h=margin_h,
        )
        print(f"margin of {margin_h:g} h: {result.status.label}")
        if result.design is None or result.simulated is None:
            for violation in result.violations:
                print(f"  {violation.text}")
            continue
        chosen = result.design.variables
        print(
            f"  wingspan {chosen.wingspan_m:.2f} m, battery {chosen.battery_mass_kg:.2f} kg, "
            f"modules {chosen.module_area_m2:.2f} m2, mass {result.design.total_mass_kg:.2f} kg"
        )
        # The simulator repeats what the optimiser promised.
        worst = result.simulated.worst_scenario()
        where = result.simulated.day.scenarios.label(worst)
        print(f"  simulated: {result.simulated.cycle.excess_time_h[worst]:.2f} h at {where}")
        print(f"  limited by: {', '.join(result.active_constraints)}")


if __name__ == "__main__":
    main()
