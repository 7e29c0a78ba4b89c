"""What ``solar-uav reproduce-report`` does."""

from __future__ import annotations

from pathlib import Path

from studies.cli.commands.verify import ReproduceReport
from studies.cli.files import Case, open_aircraft, open_mission
from studies.cli.outputs import deliver, figure_of
from studies.models import report_reproduction
from studies.output.run_folder import write_run_folder


def reproduce_report(options: ReproduceReport) -> None:
    """Fly the morning of the report with all four models."""
    study = report_reproduction
    aircraft, mission = open_aircraft(study.AIRCRAFT), open_mission(study.MISSION)
    case = Case(aircraft, mission, as_json=options.as_json)
    result = study.reproduce(case.aircraft, case.mission, vary=True)

    def write(folder: str) -> None:
        tables = "\n".join(table.to_markdown() for table in result.tables())
        drawing = figure_of(lambda: study.reproduction_figure(result, figure=options.figure))
        write_run_folder(
            Path(folder),
            case.inputs(),
            case.named(result.to_dict()),
            {"report.md": tables.encode()},
            {"report.png": drawing},
        )

    deliver(case, result, writers={options.out_dir: write})
