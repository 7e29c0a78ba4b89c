"""
Resized map
===========

The smallest aircraft that flies perpetually at each latitude and in each season.

Run with: ``python examples/resized_map.py [figure.png]``
"""

import sys

import numpy as np

import missions
import sizing
import studies
from studies.output.gridded import SIZED, SizingStatus

LATITUDES_DEG, DAYS = np.arange(-70.0, 71.0, 10.0), np.arange(1, 366, 14)


def main() -> None:
    """Print the range of wingspans at each latitude, and what the cells without one lack."""
    data = studies.resized_map(
        sizing.load_aircraft("atlantiksolar-design"),
        # The place and the date are those of the cell.
        missions.load_mission("rafz-july"),
        "min_wingspan",
        latitudes=LATITUDES_DEG,
        days=DAYS,
        required_excess_time_h=2.0,
        correction="report",
        # As many processes as there are cores, where the work is worth their start.
        workers=None,
    )
    for latitude in LATITUDES_DEG:
        row = data.sel(latitude=latitude)
        sized = row["status"].isin(SIZED)
        spans_m = row["wingspan"].where(sized)
        text = f"{latitude:4.0f} N: {int(sized.sum()):2} of {len(DAYS)} days have a design"
        if sized.any():
            text += f", {float(spans_m.min()):.2f} to {float(spans_m.max()):.2f} m"
        lacking = row["violated_requirement"].where(row["status"] == SizingStatus.infeasible, "")
        names = sorted(set(lacking.to_numpy().tolist()) - {""})
        print(f"{text}; else missed: {', '.join(names)}" if names else text)
    if len(sys.argv) > 1:
        studies.plot_resized_map(data).savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
