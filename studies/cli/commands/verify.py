"""Commands to verify with: ``solar-uav compare``, ``verify`` and ``reproduce-report``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from sizing.program.objectives import RESIZE_NAMES
from solar.names import ATTITUDE_MODELS, CORRECTION_NAMES, MODEL_NAMES, CorrectionName, ModelName
from studies.cli.command import command, option
from studies.cli.options import (
    DrawnOptions,
    LevelOptions,
    LogOptions,
    RequirementOptions,
    json_option,
    mission_option,
    out_option,
    plot_option,
    report_option,
    table_option,
)
from studies.cli.values import Names, Parsed, RealRange

if TYPE_CHECKING:
    from studies.flight_logs.errors import Window

DEFAULT_OBJECTIVE = "min_wingspan"
_LONGEST_FILTER_S = 86_400.0


@command(
    "Verify",
    "All solar power models side by side.",
    "compare:compare",
    "solar-uav compare atlantiksolar-design --objective min_mass --table models.csv",
)
class Compare(LevelOptions, RequirementOptions, DrawnOptions):
    """Compare what the solar power models say of AIRCRAFT, and what each would have built."""

    models: tuple[ModelName, ...] | None = option(
        "--models",
        type=Names(MODEL_NAMES),
        metavar="M,M,...",
        help=f"Models to compare.  [default: {','.join(MODEL_NAMES)}]",
    )
    corrections: tuple[CorrectionName, ...] | None = option(
        "--corrections",
        type=Names(CORRECTION_NAMES),
        metavar="C,C,...",
        help=f"Corrections to compare.  [default: {','.join(CORRECTION_NAMES)}]",
    )
    objective: str = option(
        "--objective",
        type=click.Choice(RESIZE_NAMES),
        default=DEFAULT_OBJECTIVE,
        show_default=True,
        help="What a parametric aircraft is sized for with every model.",
    )
    no_design: bool = option(
        "--no-design", is_flag=True, help="Compare predictions only, size nothing."
    )
    out_dir: str | None = out_option("figure")
    table_file: str | None = table_option("the table")
    plot_file: str | None = plot_option("Draw the figure")

    def refuse(self) -> None:
        """Refuse what does not go together."""
        files = (self.table_file, self.plot_file)
        if self.out_dir is not None and files != (None, None):
            raise click.UsageError("give --out, or --table and --plot, not both")

    @property
    def needs_path(self) -> str | None:
        """Option that needs module surfaces and a flight path, None where there is none."""
        for model in self.models or ():
            if model in ATTITUDE_MODELS:
                return f"--models {model}"
        return "--corrections loiter" if "loiter" in (self.corrections or ()) else None


@command(
    "Verify",
    "The solar power models against a flight log.",
    "verify:verify",
    "solar-uav verify atlantiksolar-as2 flight.csv --window 5.71:5.79 --out verified",
)
class Verify(LogOptions, LevelOptions, DrawnOptions):
    """Compare the solar power models with the flight LOG (table, ULog, DataFlash) of AIRCRAFT."""

    mission: str | None = mission_option("rafz-28h")
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
    report_file: str | None = report_option()


@command(
    "Verify",
    "The four models on the morning they were published with.",
    "reproduce:reproduce_report",
    "solar-uav reproduce-report --out reproduced",
)
class ReproduceReport(DrawnOptions):
    """Fly the verification morning of Oettershagen's report on solar power models.

    All four models, beside the report's own numbers and the power measured in flight.
    """

    as_json: bool = json_option("Print JSON.")
    out_dir: str | None = out_option("figure and table")
