"""Commands about the solar power models and published numbers.

``solar-uav published``, ``loiter-correction``, ``efficiencies`` and ``reproduce-report``.
"""

from __future__ import annotations

import os
import sys
from dataclasses import asdict
from pathlib import Path

import click

from studies.cli.help_texts import command
from studies.cli.options import (
    EXIT_FAILED,
    Asked,
    aircraft_argument,
    case_options,
    check_image,
    figure_options,
    mission_option,
    out_option,
    print_json,
    set_options,
    table_option,
)
from studies.output.figures.options import FigureOptions
from studies.output.formats import table_bytes


@command("solar-uav published --explain")
@click.option(
    "--explain",
    is_flag=True,
    help="Show which single input would explain each difference from a flight, and how likely.",
)
@click.option("--season", is_flag=True, help="Show what changes the season of perpetual flight.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@table_option("the table")
@click.option("--markdown", "markdown_file", type=click.Path(), help="Write the table to a file.")
def published(
    explain: bool,
    season: bool,
    as_json: bool,
    table_file: str | None,
    markdown_file: str | None,
) -> None:
    """Compare published numbers with computed ones; exit code 1 if one is missed."""
    from missions.files.writing import write_files_atomically
    from studies.cli.checks import check_outputs
    from studies.cli.progress import progress_of
    from studies.output.terminal import show
    from studies.validation import published as numbers
    from studies.validation.flights import season as of_season
    from studies.validation.flights import single_inputs

    if explain and season:
        raise click.UsageError("give --explain or --season, not both")
    check_outputs(table=table_file, markdown=markdown_file)
    result: numbers.Published | single_inputs.Explanations | of_season.Seasons
    if explain:
        with progress_of("differences", lines=False) as progress:
            result = single_inputs.explain(progress=progress)
    elif season:
        result = of_season.seasons()
    else:
        result = numbers.published()
    page = result.page() if isinstance(result, single_inputs.Explanations) else result.table()
    contents: dict[str | os.PathLike[str], bytes] = {}
    if table_file is not None:
        table = result.table().to_frame()
        contents[table_file] = table_bytes(table, table_file, title="published")
    if markdown_file is not None:
        contents[markdown_file] = page.to_markdown().encode()
    write_files_atomically(contents)
    if as_json:
        print_json(result.to_dict())
    else:
        show(result)
    if isinstance(result, numbers.Published) and not result.met:
        sys.exit(EXIT_FAILED)


@command("solar-uav loiter-correction --markdown errors.md", name="loiter-correction")
@aircraft_argument("atlantiksolar-as2")
@mission_option("rafz-loiter")
@case_options
@click.option("--markdown", "markdown_file", type=click.Path(), help="Write the table to a file.")
def loiter_correction(
    asked: Asked,
    markdown_file: str | None,
) -> None:
    """Tabulate how the errors of CDM and CAM change with latitude, season and wind."""
    from missions.files.writing import write_text_atomically
    from missions.flight_path import largest_wind_m_per_s
    from studies.cli.checks import require_path
    from studies.cli.outputs import tell
    from studies.models import transfer as study

    case = asked.case()
    require_path(case, "--model FM")
    assert case.mission.flight_path is not None
    limit = largest_wind_m_per_s(case.mission.flight_path)
    winds = [w for w in study.WINDS_M_PER_S if w < limit]
    errors = study.transferred_errors(case.aircraft, case.mission, winds_m_per_s=winds)
    if markdown_file is not None:
        write_text_atomically(markdown_file, study.transfer_table(errors).to_markdown())
    record = case.named({"errors": [asdict(error) for error in errors]})
    tell(case, record, study.transfer_table(errors))


@command("solar-uav efficiencies atlantiksolar-as2 --plot efficiencies.png")
@aircraft_argument()
@mission_option("rafz-loiter")
@set_options
@table_option("the table over time")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw it (png, svg, pdf).")
@figure_options
def efficiencies(
    asked: Asked,
    table_file: str | None,
    plot_file: str | None,
    figure: FigureOptions,
) -> None:
    """Show what drives the Full Model's power of AIRCRAFT: every component efficiency."""
    from studies.cli.checks import check_outputs, refuse_polar_night, require_path
    from studies.cli.outputs import told, write_results
    from studies.models import component_efficiencies as study

    check_image(plot_file)
    check_outputs(table=table_file, plot=plot_file)
    case = asked.case()
    require_path(case, "--model FM")
    refuse_polar_night(case)
    data = study.component_efficiencies(case.aircraft, case.mission)
    with told(case, {}, study.efficiency_table(data), files=(table_file, plot_file)):
        write_results(
            table_file,
            lambda: table_bytes(
                data.to_dataframe().reset_index(), table_file, title="efficiencies"
            ),
            plot_file,
            lambda: study.plot_efficiencies(data, figure=figure),
        )


@command("solar-uav reproduce-report --out reproduced", name="reproduce-report")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@out_option("figure and table")
@figure_options
def reproduce_report(as_json: bool, out_dir: str | None, figure: FigureOptions) -> None:
    """Fly the verification morning of Oettershagen's report on solar power models.

    All four models, beside the report's own numbers and the power measured in flight.
    """
    from missions.files.writing import check_writable_folder
    from studies.cli.files import Case, open_aircraft, open_mission
    from studies.cli.outputs import told
    from studies.output.figures.drawing import to_bytes
    from studies.output.run_folder import write_run_folder
    from studies.validation import report_reproduction as study

    if out_dir is not None:
        check_writable_folder(Path(out_dir))
    case = Case(open_aircraft(study.AIRCRAFT), open_mission(study.MISSION), as_json=as_json)
    result = study.reproduce(case.aircraft, case.mission, vary=True)
    record = case.named(result.to_dict())
    with told(case, record, result, out_dir=out_dir):
        if out_dir is not None:
            tables = "\n".join(table.to_markdown() for table in result.tables())
            contents = {"report.md": tables.encode()}
            drawn = {
                "report.png": lambda: to_bytes(
                    study.reproduction_figure(result, figure=figure), "png"
                )
            }
            write_run_folder(Path(out_dir), case.inputs(), record, contents, drawn)
