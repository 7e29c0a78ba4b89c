"""
Gain by climbs
==============

How much lighter the smallest aircraft is that climbs by day and glides in the evening, by latitude
and month. The figure is shown on the page :doc:`/altitude`.

Run with: ``python examples/climb_gain.py [figure.png]``
"""

import calendar
import sys
from datetime import date

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import missions
import sizing
import studies

# 3000 m of climb, in standard air; empty brackets take out what the file says of the air.
LEVEL: dict[str, object] = {"air": {}}
CLIMBS = LEVEL | {"climb": {"ceiling_m": 3536.0}}
LATITUDES_DEG, DAYS = np.arange(0.0, 51.0, 5.0), np.arange(1, 366, 28)


def main() -> None:
    """Print the least and the largest gain at some latitudes, and draw all of them."""
    aircraft = sizing.load_aircraft("atlantiksolar-design")
    level, climbing = (
        studies.resized_map(
            aircraft,
            missions.load_mission("rafz-july", air),
            "min_mass",
            latitudes=LATITUDES_DEG,
            days=DAYS,
        )["total_mass"]
        for air in (LEVEL, CLIMBS)
    )
    # NaN where either has no design.
    lighter = 100.0 * (1.0 - climbing / level)
    print(f"{int(lighter.isnull().sum())} of {lighter.size} cells have no design in one of both")
    for latitude in (0.0, 25.0, 40.0, 50.0):
        row = lighter.sel(latitude=latitude)
        print(f"{latitude:2.0f} N: {float(row.min()):.1f} to {float(row.max()):.1f} % lighter")
    if len(sys.argv) > 1:
        draw(lighter).savefig(sys.argv[1], dpi=150)


def draw(lighter: xr.DataArray) -> Figure:
    """Contours of the gain; cells without a design are blank."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    filled = axes.contourf(DAYS, LATITUDES_DEG, lighter, levels=12, cmap="viridis")
    figure.colorbar(filled, label="least mass with climbs, lighter by [%]")
    # Any year without a leap day.
    starts = [date(2023, month, 1).timetuple().tm_yday for month in range(1, 13)]
    axes.set_xticks(starts, [calendar.month_abbr[month] for month in range(1, 13)])
    axes.set(ylabel="latitude [° N]", title="atlantiksolar-design, climbs of 3000 m from 536 m")
    return figure


if __name__ == "__main__":
    main()
