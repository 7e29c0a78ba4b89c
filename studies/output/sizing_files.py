"""Files of a sizing: the sized aircraft, tables and figures, written whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd

from missions.files.writing import write_folder
from sizing.results.analysis import analyse
from sizing.results.sizing import SizingStudy, sensitivity_records, sized_yaml
from studies.cli.library import LoadedAircraft
from studies.cli.options import csv_bytes
from studies.output import plots


def write_sizing(
    folder: Path, study: SizingStudy, record: dict[str, Any], craft: LoadedAircraft
) -> None:
    """Write the files of an optimum into a folder; existing files of these names are replaced.

    Sensitivities, where there are any, come as a table and as a tornado plot.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    result, worth = study.result, study.sensitivities
    assert result.design is not None
    assert result.simulated is not None
    text = sized_yaml(study, craft.document.source)
    sized, solar = study.sized_aircraft(), study.solar
    analysis = analyse(
        sized, study.sized_mission(), model=solar.model, correction=solar.correction, replay=False
    )
    masses = plots.mass_figure(result.design.masses._asdict(), f"{sized.name}: mass budget")
    contents: dict[str, bytes] = {
        "aircraft.yaml": text.encode(),
        "result.json": json.dumps(record, indent=2, allow_nan=False).encode(),
        "scenarios.csv": csv_bytes(study.scenarios()),
        "masses.csv": csv_bytes(study.masses()),
        "cycle.png": plots.to_bytes(plots.cycle_figure(analysis), "png"),
        "masses.png": plots.to_bytes(masses, "png"),
    }
    if worth:
        contents["sensitivities.csv"] = csv_bytes(pd.DataFrame(sensitivity_records(worth)))
        tornado = plots.tornado_figure(worth, result.objective, sized.name, result.simulated.solar)
        contents["sensitivities.png"] = plots.to_bytes(tornado, "png")
    write_folder(folder, contents)
