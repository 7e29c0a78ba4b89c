"""The command ``solar-uav verify``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from studies.cli.command import Command, Parsed, RealRange, option
from studies.cli.options import (
    CaseOptions,
    LogOptions,
    case_options,
    figure_options,
    log_options,
    out_option,
    report_option,
)
from studies.output.figures.options import FigureOptions

if TYPE_CHECKING:
    from studies.flight_logs.errors import Window

_LONGEST_FILTER_S = 86_400.0


@dataclass(frozen=True)
class Verify:
    """Compare the solar power models with the flight LOG (table, ULog, DataFlash) of AIRCRAFT."""

    case: CaseOptions = case_options(mission="rafz-28h", with_models=False, with_levels=True)
    log: LogOptions = log_options()
    windows: tuple[Window, ...] = option(
        "--window",
        type=Parsed("a:b", "studies.flight_logs.errors:parse_window"),
        multiple=True,
        help="Period in solar hours, e.g. 5.71:5.79, on every day, or 2015-07-01@5.71:5.79 on one. "
        "May be repeated.",
    )
    filter_s: float | None = option(
        "--filter",
        type=RealRange(0.0, _LONGEST_FILTER_S, unit="seconds"),
        metavar="SECONDS",
        help="Time to either side in the moving average.  [default: 1 s in windows, 400 s over "
        "days]",
    )
    clock_offset_min: float = option(
        "--clock-offset",
        type=RealRange(-1440.0, 1440.0, unit="minutes"),
        metavar="MINUTES",
        default=0.0,
        help="Time that the log's clock is ahead of universal time, which is taken off.",
    )
    heading_offset_deg: float = option(
        "--heading-offset",
        type=RealRange(-360.0, 360.0, unit="degrees"),
        metavar="DEGREES",
        default=0.0,
        help="Angle that the log's yaw is too large, which is taken off.",
    )
    out_dir: str | None = out_option("samples and figures")
    figure: FigureOptions = figure_options()
    report_file: str | None = report_option()


verify = Command(
    "verify",
    Verify,
    "verify:verify",
    "solar-uav verify atlantiksolar-as2 flight.csv --window 5.71:5.79 --out verified",
)
