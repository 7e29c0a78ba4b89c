"""Commands about the solar power models and published numbers.

``solar-uav published``, ``loiter-correction``, ``efficiencies`` and ``reproduce-report``.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from studies.cli.options import (
    EXIT_FAILED,
    check_image,
    check_outputs,
    console,
    load,
    mission_option,
    print_json,
    refuse_polar_night,
    require_path,
    set_option,
    write_results,
)

if TYPE_CHECKING:
    from missions.mission import Mission


@click.command(short_help="Published beside computed numbers.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--markdown", "markdown_file", type=click.Path(), help="Write the table to a file.")
def published(as_json: bool, markdown_file: str | None) -> None:
    """Compare published numbers with computed ones; exit code 1 if one is missed."""
    from studies.validation import published as study

    rows = study.comparisons()
    if markdown_file is not None:
        from missions.files.writing import write_text_atomically

        write_text_atomically(markdown_file, study.markdown(rows))
    if as_json:
        print_json([row.record() for row in rows])
    else:
        from studies.output.tables import print_published

        print_published(console(), rows)
    if not all(row.met for row in rows):
        sys.exit(EXIT_FAILED)


@click.command(
    name="loiter-correction", short_help="Errors of CDM and CAM by latitude, season and wind."
)
@click.argument("aircraft", default="atlantiksolar-as2")
@mission_option("rafz-loiter")
@set_option
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--markdown", "markdown_file", type=click.Path(), help="Write the table to a file.")
def loiter_correction(
    aircraft: str,
    mission: str,
    overrides: tuple[str, ...],
    as_json: bool,
    markdown_file: str | None,
) -> None:
    """Tabulate how the errors of CDM and CAM change with latitude, season and wind."""
    craft, where = load(aircraft, mission, overrides)
    require_path("FM", "none", craft, where)
    from studies.models import transfer as study

    winds = _flyable_winds(where.mission, study.WINDS_M_PER_S)
    errors = study.transferred_errors(craft.aircraft, where.mission, winds_m_per_s=winds)
    if markdown_file is not None:
        from missions.files.writing import write_text_atomically

        write_text_atomically(markdown_file, study.transfer_table(errors).to_markdown())
    if as_json:
        print_json([asdict(error) for error in errors])
    else:
        from studies.output.terminal import show

        show(study.transfer_table(errors))


def _flyable_winds(mission: Mission, winds_m_per_s: tuple[float, ...]) -> list[float]:
    """Those of the winds that the mission's flight path can be held in."""
    from missions.flight_path import largest_wind_m_per_s

    assert mission.flight_path is not None
    limit = largest_wind_m_per_s(mission.flight_path)
    return [w for w in winds_m_per_s if w < limit]


@click.command(short_help="What drives the power of the Full Model.")
@click.argument("aircraft")
@mission_option("rafz-loiter")
@set_option
@click.option("--csv", "csv_file", type=click.Path(), help="Write the table over time as CSV.")
@click.option("--plot", "plot_file", type=click.Path(), help="Draw it (png, svg, pdf).")
def efficiencies(
    aircraft: str,
    mission: str,
    overrides: tuple[str, ...],
    csv_file: str | None,
    plot_file: str | None,
) -> None:
    """Show what drives the Full Model's power of AIRCRAFT: every component efficiency."""
    check_image(plot_file)
    check_outputs(csv=csv_file, plot=plot_file)
    craft, where = load(aircraft, mission, overrides)
    require_path("FM", "none", craft, where)
    refuse_polar_night(where.mission, where, options=False)
    from studies.models import component_efficiencies as study

    data = study.component_efficiencies(craft.aircraft, where.mission)
    write_results(
        csv_file,
        lambda: data.to_dataframe().to_csv().encode(),
        plot_file,
        lambda: study.efficiency_figure(data),
    )
    from studies.output.terminal import show

    show(study.efficiency_table(data))


@click.command(
    name="reproduce-report", short_help="The four models on the morning they were published with."
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--out", "out_dir", type=click.Path(), help="Folder for figure, table and JSON.")
def reproduce_report(as_json: bool, out_dir: str | None) -> None:
    """Fly the verification morning of Oettershagen's report on solar power models.

    All four models, beside the report's own numbers and the power measured in flight.
    """
    from studies.validation import report_reproduction as study

    if out_dir is not None:
        from missions.files.writing import check_writable_folder

        check_writable_folder(Path(out_dir))
    aircraft, mission = study.reference()
    result = study.reproduce(aircraft, mission)
    varied = study.sensitivities(aircraft, mission)
    record = study.to_json(result, mission, varied)
    if out_dir is not None:
        from missions.files.writing import write_folder
        from studies.output.plots import to_bytes

        contents = {
            "report.json": json.dumps(record, indent=2).encode(),
            "report.md": study.markdown(result, varied).encode(),
            "report.png": to_bytes(study.figure(aircraft, mission), "png"),
        }
        write_folder(Path(out_dir), contents)
    if as_json:
        print_json(record)
        return
    from studies.output.tables import print_reproduction

    print_reproduction(console(), record)
