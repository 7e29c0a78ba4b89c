"""The command ``solar-uav verify``."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from studies.cli.help_texts import command
from studies.cli.log_options import log_options
from studies.cli.options import (
    Asked,
    Parsed,
    RealRange,
    aircraft_argument,
    case_options,
    completes,
    figure_options,
    mission_option,
    out_option,
    report_option,
)
from studies.output.figures.options import FigureOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from missions.logs.columns import ColumnMap
    from studies.flight_logs.errors import Window

_LONGEST_FILTER_S = 86_400.0
# File of a folder of results with the samples.
_SAMPLES = "samples.csv"


@command("solar-uav verify atlantiksolar-as2 flight.csv --window 5.71:5.79 --out verified")
@aircraft_argument()
@click.argument("log_file", metavar="LOG", shell_complete=completes("log_file"))
@mission_option("rafz-28h")
@log_options
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
    "filter_s",
    type=RealRange(0.0, _LONGEST_FILTER_S, unit="seconds"),
    metavar="SECONDS",
    help="Time to either side in the moving average.  [default: 1 s in windows, 400 s over days]",
)
@click.option(
    "--as-logged",
    is_flag=True,
    help="Tell errors of the log's clock, heading and unit of power, but do not correct them.",
)
@case_options
@out_option("samples and figures")
@figure_options
@report_option
def verify(
    asked: Asked,
    log_file: str,
    layout: ColumnMap,
    windows: tuple[Window, ...],
    filter_s: float | None,
    as_logged: bool,
    out_dir: str | None,
    figure: FigureOptions,
    report_file: str | None,
) -> None:
    """Compare the solar power models with the flight LOG (table, ULog, DataFlash) of AIRCRAFT."""
    from missions.files.writing import check_writable_folder
    from missions.logs.csv import read_flight_log
    from studies.cli.checks import refuse_to_overwrite
    from studies.cli.files import refuse_swapped_log
    from studies.cli.outputs import told
    from studies.cli.reports import check_report, report_on_log
    from studies.flight_logs.plots import figures
    from studies.flight_logs.verification import verify as verify_models
    from studies.output.run_folder import write_run_folder

    if out_dir is not None:
        check_writable_folder(Path(out_dir))
        refuse_to_overwrite("--out", str(Path(out_dir) / _SAMPLES), (log_file,))
    check_report(report_file, option="--report")
    refuse_swapped_log(asked.aircraft, log_file)
    case = asked.case()
    result = verify_models(
        case.aircraft,
        read_flight_log(log_file, layout),
        case.mission,
        windows=windows,
        filter_s=filter_s,
        correct=not as_logged,
    )
    record = case.named(result.to_dict())
    with told(case, record, result, out_dir=out_dir, files=(report_file,)):
        if out_dir is not None:
            contents = {_SAMPLES: result.to_csv().encode()}
            drawn = {
                f"{name}.png": partial(_log_figure, draw, f"{name}.png")
                for name, draw in figures(result, figure=figure)
            }
            inputs = case.inputs(log=Path(log_file))
            write_run_folder(Path(out_dir), inputs, record, contents, drawn)
        if report_file is not None:
            report_on_log(case, result, log_file, report_file, overrides=asked.overrides)


def _log_figure(draw: Callable[[], Figure], name: str) -> bytes:
    from studies.cli.outputs import figure_bytes

    return figure_bytes(draw(), name)
