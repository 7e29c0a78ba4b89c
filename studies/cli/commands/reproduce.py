"""The command ``solar-uav reproduce-report``."""

from __future__ import annotations

from dataclasses import dataclass

from studies.cli.command import Command
from studies.cli.options import figure_options, json_option, out_option
from studies.output.figures.options import FigureOptions


@dataclass(frozen=True)
class ReproduceReport:
    """Fly the verification morning of Oettershagen's report on solar power models.

    All four models, beside the report's own numbers and the power measured in flight.
    """

    as_json: bool = json_option("Print JSON.")
    out_dir: str | None = out_option("figure and table")
    figure: FigureOptions = figure_options()


reproduce_report = Command(
    "reproduce-report",
    ReproduceReport,
    "reproduce:reproduce_report",
    "solar-uav reproduce-report --out reproduced",
)
