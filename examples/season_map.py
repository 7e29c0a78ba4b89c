"""
Season map
==========

Where and when AtlantikSolar AS-2 flies perpetually, with the battery as built and half of it.

Run with: ``python examples/season_map.py [figure.png]``
"""

import sys

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

import missions
import sizing
import studies

AIRCRAFT = {"as built": [], "half the battery": ["battery.mass_kg=1.46"]}
LATITUDES_DEG, DAYS = np.arange(-70.0, 71.0), np.arange(1, 366, 2)
# Published of AS-2: perpetual flight "in a 6-month window around June 21st at mid-European
# latitudes". Which latitudes these are is our reading.
SOLSTICE, HALF_WINDOW_D, MID_EUROPE_DEG = 172, 91, (45.0, 50.0)


def main() -> None:
    """Print the days of perpetual flight by latitude, and draw the map."""
    # The mission gives the air and the load; latitudes and days are those of the map.
    mission = missions.load_mission("rafz-july")
    maps = {}
    for name, overrides in AIRCRAFT.items():
        aircraft = sizing.load_aircraft("atlantiksolar-as2", overrides)
        maps[name] = studies.feasibility_map(
            aircraft, mission, latitudes=LATITUDES_DEG, days=DAYS, correction="report"
        )
        share = studies.season_length(maps[name]) / len(DAYS)
        print(f"{name}: share of the year flown perpetually")
        for latitude in (0.0, 30.0, 45.0, 60.0):
            print(f"  {latitude:2.0f} N: {100 * float(share.sel(latitude=latitude)):3.0f} %")
    if len(sys.argv) > 1:
        draw(maps["as built"], maps["half the battery"]).savefig(sys.argv[1], dpi=150)


def draw(built: xr.Dataset, half: xr.Dataset) -> Figure:
    """Map as built; dashed the edge with half the battery; what was published, and the tropics."""
    figure = studies.plot_map(built)
    axes = figure.axes[0]
    flies = (half["excess_time"] > 0.0).astype(float)
    axes.contour(DAYS, LATITUDES_DEG, flies, [0.5], colors="black", linestyles="dashed")
    axes.plot([], [], "k-", label="edge of perpetual flight, as built")
    axes.plot([], [], "k--", label="with half the battery")
    low, high = MID_EUROPE_DEG
    window = (SOLSTICE - HALF_WINDOW_D, low), 2 * HALF_WINDOW_D, high - low
    published = "published: 6 months around 21 June, mid-European latitudes (here 45° to 50° N)"
    axes.add_patch(Rectangle(*window, fill=False, color="#D55E00", linewidth=2, label=published))
    all_year = LATITUDES_DEG[studies.season_length(built) == len(DAYS)]
    label = f"all year, as built: {-all_year.min():g}° S to {all_year.max():g}° N"
    axes.axhspan(all_year.min(), all_year.max(), fill=False, hatch="..", alpha=0.3, label=label)
    # A single legend with what the map's own has: the reasons of hatched cells.
    handles, _ = axes.get_legend_handles_labels()
    for legend in list(figure.legends):
        handles += [handle for handle in legend.legend_handles if handle is not None]
        legend.remove()
    figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize="small")
    return figure


if __name__ == "__main__":
    main()
