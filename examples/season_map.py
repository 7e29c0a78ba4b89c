"""Season map: where and when AtlantikSolar AS-2 flies for ever, with AS-2's own battery and half.

Run with: python examples/season_map.py [figure.png]
"""

import sys

import numpy as np

from sizing.performance import SolarModel
from studies.feasibility_map import feasibility_map, map_figure, season_length
from studies.library import load_aircraft, load_mission


def main() -> None:
    """Print the days of perpetual flight by latitude, and draw the map."""
    # The mission gives the air and the load; latitudes and days are those of the map.
    mission = load_mission("rafz-july").mission
    latitudes_deg = np.arange(-70.0, 71.0, 5.0)
    days = np.arange(1, 366, 7)
    solar = SolarModel("CAM", "report")

    maps = {
        name: feasibility_map(
            load_aircraft("atlantiksolar-as2", overrides).aircraft,
            mission,
            latitudes_deg,
            days,
            solar,
        )
        for name, overrides in {
            "as built": [],
            "half the battery": ["battery.mass_kg=1.46"],
        }.items()
    }
    for name, data in maps.items():
        share = season_length(data) / len(days)
        print(f"{name}: share of the year flown perpetually")
        for latitude in (0.0, 30.0, 45.0, 60.0):
            print(f"  {latitude:2.0f} N: {100 * float(share.sel(latitude=latitude)):3.0f} %")

    if len(sys.argv) > 1:
        map_figure(maps["as built"]).savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
