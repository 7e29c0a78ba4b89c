"""What the commands about solar power models and published numbers do."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path

from missions.flight_path import largest_wind_m_per_s
from studies.cli.commands.validation import (
    Efficiencies,
    LoiterCorrection,
    Published,
    ReproduceReport,
)
from studies.cli.files import (
    Case,
    load,
    open_aircraft,
    open_mission,
    refuse_polar_night,
    require_path,
)
from studies.cli.options import EXIT_FAILED
from studies.cli.outputs import deliver, figure_of, print_json, table_of, told, write_results
from studies.cli.telling import progress_of
from studies.models import component_efficiencies, transfer
from studies.output.run_folder import write_run_folder
from studies.output.terminal import show
from studies.validation import published as numbers
from studies.validation import report_reproduction
from studies.validation.flights import season, single_inputs


def published(options: Published) -> None:
    """Put published numbers beside computed ones."""
    result: numbers.Published | single_inputs.Explanations | season.Seasons
    if options.explain:
        with progress_of("differences", lines=False) as progress:
            result = single_inputs.explain(progress=progress)
    elif options.season:
        result = season.seasons()
    else:
        with progress_of("sources", lines=False) as progress:
            result = numbers.published(progress)
    page = result.page() if isinstance(result, single_inputs.Explanations) else result.table()
    write_results(
        {
            options.table_file: table_of(lambda: result.table().to_frame(), "published"),
            options.markdown_file: lambda _: page.to_markdown().encode(),
        }
    )
    if options.as_json:
        print_json(result.to_dict())
    else:
        show(result)
    if isinstance(result, numbers.Published) and not result.met:
        sys.exit(EXIT_FAILED)


def loiter_correction(options: LoiterCorrection) -> None:
    """Tabulate the errors of the models without surfaces."""
    case = load(options.case)
    require_path(case, "--model FM")
    assert case.mission.flight_path is not None
    limit = largest_wind_m_per_s(case.mission.flight_path)
    winds = [w for w in transfer.WINDS_M_PER_S if w < limit]
    errors = transfer.transferred_errors(case.aircraft, case.mission, winds_m_per_s=winds)
    table = transfer.transfer_table(errors)
    with told(case, case.named({"errors": [asdict(error) for error in errors]}), table):
        write_results({options.markdown_file: lambda _: table.to_markdown().encode()})


def efficiencies(options: Efficiencies) -> None:
    """Show the component efficiencies of the Full Model."""
    case = load(options.case)
    require_path(case, "--model FM")
    refuse_polar_night(case)
    data = component_efficiencies.component_efficiencies(case.aircraft, case.mission)
    files = {
        options.table_file: table_of(lambda: data.to_dataframe().reset_index(), "efficiencies"),
        options.plot_file: figure_of(
            lambda: component_efficiencies.plot_efficiencies(data, figure=options.figure)
        ),
    }
    deliver(case, {}, component_efficiencies.efficiency_table(data), files)


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
