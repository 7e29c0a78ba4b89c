"""Commands for other tools: ``solar-uav export``, ``diff`` and ``schema``."""

from __future__ import annotations

from dataclasses import replace

import click

from studies.cli.help_texts import command
from studies.cli.options import (
    Asked,
    aircraft_argument,
    check_table,
    completes,
    mission_option,
    model_options,
    print_json,
    solar_options,
    table_option,
)
from studies.output.formats import table_bytes


@command(
    "solar-uav export atlantiksolar-design --out wing.avl",
    "solar-uav export sized -m rafz-july --out design.tex --out design.xlsx",
)
@aircraft_argument()
@mission_option()
@click.option(
    "--out",
    "out_files",
    type=click.Path(),
    multiple=True,
    required=True,
    metavar="FILE",
    help="Write geometry: .avl (AVL), .vspscript (OpenVSP), .py (AeroSandbox); or a table of the "
    "design on its mission: .tex, .xlsx, .csv, .parquet. May be given several times.",
)
@model_options
def export(
    asked: Asked,
    out_files: tuple[str, ...],
) -> None:
    """Write AIRCRAFT (name, file or folder) for other tools: its geometry, or its numbers."""
    from missions.files.writing import write_files_atomically
    from sizing.results.analysis import analyse
    from studies.cli.checks import check_outputs, require_climber, require_path
    from studies.exchange import files
    from studies.output.terminal import tell_line

    for path in out_files:
        check_outputs(out=path)
        found = files.design_format(path)
        check_table(path, found, files.DESIGN_FORMATS, "--out")
        missing = files.missing_for(path)
        if missing is not None:
            raise click.BadParameter(missing, param_hint="--out")
    case = asked.case()
    require_path(case)
    require_climber(case)
    solar = case.solar
    analysis = analyse(
        case.aircraft, case.mission, model=solar.model, correction=solar.correction, replay=False
    )
    write_files_atomically({path: files.design_bytes(analysis, path) for path in out_files})
    for path in out_files:
        tell_line(f"written to {path}")


@command(
    "solar-uav diff atlantiksolar-design sized",
    "solar-uav diff atlantiksolar-design atlantiksolar-as2 -m rafz-july --table diff.xlsx",
)
@aircraft_argument()
@click.argument("other", metavar="OTHER", shell_complete=completes("aircraft"))
@mission_option()
@table_option("the quantities of both")
@solar_options
def diff(
    asked: Asked,
    other: str,
    table_file: str | None,
) -> None:
    """Put AIRCRAFT and OTHER (names, files or folders) side by side: results, and keys that differ.

    Folders of --out bring their own missions; --set applies to both.
    """
    from sizing.results.analysis import analyse
    from studies.cli.checks import check_outputs, require_climber, require_path
    from studies.cli.outputs import write_results
    from studies.exchange.difference import compare_designs
    from studies.output.terminal import show, tell_line

    check_outputs(table=table_file)
    analyses = []
    for one in (asked, replace(asked, aircraft=other)):
        case = one.case()
        require_path(case)
        require_climber(case)
        solar = case.solar
        analyses.append(
            analyse(
                *(case.aircraft, case.mission),
                model=solar.model,
                correction=solar.correction,
                replay=False,
            )
        )
    found = compare_designs(*analyses)
    write_results(table_file, lambda: table_bytes(found.to_frame(), table_file, title="designs"))
    if asked.as_json:
        print_json(found.to_dict())
        return
    show(found)
    if table_file is not None:
        tell_line(f"written to {table_file}")


@command("solar-uav schema aircraft --out aircraft.schema.json")
@click.argument("kind", type=click.Choice(("aircraft", "mission")))
@click.option(
    "--out", "out_file", type=click.Path(), metavar="FILE", help="Write it instead of printing it."
)
def schema(kind: str, out_file: str | None) -> None:
    """Print the JSON Schema of aircraft or mission files, for completion in an editor."""
    from missions.files.writing import to_json, write_text_atomically
    from studies.cli.checks import check_outputs
    from studies.exchange.schema import file_schema

    check_outputs(out=out_file)
    record = file_schema(kind)  # type: ignore[arg-type]  # click checked it
    if out_file is None:
        print_json(record)
        return
    write_text_atomically(out_file, to_json(record, indent=2) + "\n")
    click.echo(f"written to {out_file}")
