"""What ``solar-uav reproduce-report`` does."""

from __future__ import annotations

from pathlib import Path

from studies.cli.commands.reproduce import ReproduceReport
from studies.cli.files import Case, open_aircraft, open_mission
from studies.cli.outputs import figure_of, told
from studies.models import report_reproduction
from studies.output.run_folder import write_run_folder


def reproduce_report(options: ReproduceReport) -> None:
    """Fly the morning of the report with all four models."""
    study, folder = report_reproduction, options.out_dir
    aircraft, mission = open_aircraft(study.AIRCRAFT), open_mission(study.MISSION)
    case = Case(aircraft, mission, as_json=options.as_json)
    result = study.reproduce(case.aircraft, case.mission, vary=True)
    record = case.named(result.to_dict())
    with told(case, record, result, files=(folder,)):
        if folder is not None:
            tables = "\n".join(table.to_markdown() for table in result.tables())
            drawing = figure_of(lambda: study.reproduction_figure(result, figure=options.figure))
            contents = {"report.md": tables.encode()}
            write_run_folder(Path(folder), case.inputs(), record, contents, {"report.png": drawing})
