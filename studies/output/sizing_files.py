"""Files of a sizing: the sized aircraft, tables and figures, written whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from missions.files.validation import validate
from missions.files.writing import write_folder
from missions.files.yaml import parse_yaml
from sizing.aircraft import Aircraft
from sizing.analysis import analyse
from sizing.optimisation import study as sizing_study
from sizing.optimisation.study import SizingStudy
from studies.cli.files import LoadedAircraft
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
    result, worth = study.result, study.worth
    assert result.design is not None
    assert result.simulated is not None
    text = sizing_study.sized_yaml(craft.document, result.design, result, study.mission)
    sized = validate(parse_yaml(text, "sized aircraft"), Aircraft)
    flown = sizing_study.sized_mission(study.mission, result.design)
    analysis = analyse(sized, flown, result.simulated.solar, replay=False)
    masses = plots.mass_figure(result.design.masses._asdict(), f"{sized.name}: mass budget")
    contents: dict[str, bytes] = {
        "aircraft.yaml": text.encode(),
        "result.json": json.dumps(record, indent=2, allow_nan=False).encode(),
        "scenarios.csv": csv_bytes(sizing_study.scenario_table(result.simulated)),
        "masses.csv": csv_bytes(sizing_study.mass_table(result.design)),
        "cycle.png": plots.to_bytes(plots.cycle_figure(analysis), "png"),
        "masses.png": plots.to_bytes(masses, "png"),
    }
    if worth:
        contents["sensitivities.csv"] = csv_bytes(sizing_study.sensitivity_table(worth))
        tornado = plots.tornado_figure(worth, result.objective, sized.name, result.simulated.solar)
        contents["sensitivities.png"] = plots.to_bytes(tornado, "png")
    write_folder(folder, contents)
