"""The command ``solar-uav verify``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from studies.cli.options import Parsed, json_option, mission_option, out_option, set_option

if TYPE_CHECKING:
    from studies.flight_logs.errors import Window

_LONGEST_FILTER = 1_000_000


@click.command()
@click.argument("aircraft")
@click.argument("log_file", metavar="LOG")
@mission_option("rafz-28h")
@click.option(
    "--window",
    "windows",
    type=Parsed("a:b", "studies.flight_logs.errors:parse_window"),
    multiple=True,
    help="Period in solar hours, e.g. 5.71:5.79, on every day, or 2015-07-01@5.71:5.79 on one. "
    "May be repeated.",
)
@click.option(
    "--filter",
    "semi_window",
    type=click.IntRange(0, _LONGEST_FILTER),
    metavar="N",
    help="Samples on either side in the moving average.  [default: 2 in windows, 800 over days]",
)
@set_option
@json_option
@out_option("samples and figures")
def verify(
    aircraft: str,
    log_file: str,
    mission: str,
    windows: tuple[Window, ...],
    semi_window: int | None,
    overrides: tuple[str, ...],
    as_json: bool,
    out_dir: str | None,
) -> None:
    """Compare the solar power models with the flight LOG (CSV or ULog) of AIRCRAFT."""
    from missions.files.writing import check_writable_folder
    from missions.logs.csv import read_flight_log
    from studies.cli.files import load, refuse_swapped_log
    from studies.cli.outputs import tell
    from studies.flight_logs import verification as study
    from studies.flight_logs.output import print_verification, verification_files
    from studies.flight_logs.records import to_json
    from studies.output.run_folder import write_run_folder

    if out_dir is not None:
        check_writable_folder(Path(out_dir))
    refuse_swapped_log(aircraft, log_file)
    case = load(aircraft, mission, overrides)
    log = read_flight_log(log_file)
    result = study.verify(
        log, case.aircraft, case.mission, windows=windows, semi_window=semi_window
    )
    record = case.named(to_json(result))
    if out_dir is not None:
        inputs = case.inputs(log=Path(log_file))
        write_run_folder(Path(out_dir), inputs, record, verification_files(result))
    tell(
        *(case, record),
        lambda console: print_verification(console, record),
        as_json=as_json,
        out_dir=out_dir,
    )
