"""Re-sized map: the smallest aircraft that flies for ever at each latitude and in each season.

Run with: python examples/resized_map.py [figure.png]
"""

import sys

import numpy as np

from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.optimisation.objectives import Objective
from sizing.sunlight import SolarModel
from studies.engine.run import run
from studies.engine.workers import AutomaticCrew
from studies.maps.jobs import (
    SizedMapConfiguration,
    sized_map_dataset,
    sized_map_figure,
    sized_map_job,
)
from studies.output.columns import SIZED, SizingStatus

LATITUDES_DEG, DAYS = np.arange(-70.0, 71.0, 10.0), np.arange(1, 366, 14)


def main() -> None:
    """Print the range of wingspans at each latitude, and what the cells without one lack."""
    asked = SizedMapConfiguration(
        load_aircraft("atlantiksolar-design"),
        # Two hours that remain at dawn; the place and the date are those of the cell.
        load_mission("rafz-july", ["required_excess_time_h=2"]),
        SolarModel("CAM", "report"),
        Objective.min_wingspan,
    )
    job = sized_map_job(asked, LATITUDES_DEG, DAYS)
    # Several processes where the map is large. Cells that are infeasible say why.
    data = sized_map_dataset(job, run(job, AutomaticCrew()), LATITUDES_DEG, DAYS)
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
        sized_map_figure(data).savefig(sys.argv[1], dpi=150)


if __name__ == "__main__":
    main()
