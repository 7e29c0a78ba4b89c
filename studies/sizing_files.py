"""Files of a sizing: the sized aircraft, tables and figures, written whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from missions.configfile import validate
from missions.output_files import write_folder
from missions.yaml_document import parse_yaml
from sizing.aircraft import Aircraft
from studies import plots, sizing_study
from studies.analysis import analyse
from studies.command_options import csv_bytes
from studies.library import LoadedAircraft
from studies.sizing_study import SizingStudy


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
