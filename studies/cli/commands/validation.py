"""Commands about the solar power models and published numbers.

``solar-uav published``, ``loiter-correction``, ``efficiencies`` and ``reproduce-report``.
"""

from __future__ import annotations

from dataclasses import dataclass

import click

from studies.cli.command import Command, option
from studies.cli.options import (
    CaseOptions,
    case_options,
    figure_options,
    json_option,
    markdown_option,
    out_option,
    plot_option,
    table_option,
)
from studies.output.figures.options import FigureOptions


@dataclass(frozen=True)
class Published:
    """Compare published numbers with computed ones; exit code 1 if one is missed."""

    explain: bool = option(
        "--explain",
        is_flag=True,
        help="Show which single input would explain each difference from a flight, and how likely.",
    )
    season: bool = option(
        "--season", is_flag=True, help="Show what changes the season of perpetual flight."
    )
    as_json: bool = json_option("Print JSON.")
    table_file: str | None = table_option("the table")
    markdown_file: str | None = markdown_option()

    def __post_init__(self) -> None:
        """Refuse what does not go together."""
        if self.explain and self.season:
            raise click.UsageError("give --explain or --season, not both")


@dataclass(frozen=True)
class LoiterCorrection:
    """Tabulate how the errors of CDM and CAM change with latitude, season and wind."""

    case: CaseOptions = case_options("atlantiksolar-as2", "rafz-loiter", with_models=False)
    markdown_file: str | None = markdown_option()


@dataclass(frozen=True)
class Efficiencies:
    """Show what drives the Full Model's power of AIRCRAFT: every component efficiency."""

    case: CaseOptions = case_options(mission="rafz-loiter", with_models=False, with_json=False)
    table_file: str | None = table_option("the table over time")
    plot_file: str | None = plot_option("Draw it")
    figure: FigureOptions = figure_options()


@dataclass(frozen=True)
class ReproduceReport:
    """Fly the verification morning of Oettershagen's report on solar power models.

    All four models, beside the report's own numbers and the power measured in flight.
    """

    as_json: bool = json_option("Print JSON.")
    out_dir: str | None = out_option("figure and table")
    figure: FigureOptions = figure_options()


published = Command("published", Published, "validation:published", "solar-uav published --explain")
loiter_correction = Command(
    "loiter-correction",
    LoiterCorrection,
    "validation:loiter_correction",
    "solar-uav loiter-correction --markdown errors.md",
)
efficiencies = Command(
    "efficiencies",
    Efficiencies,
    "validation:efficiencies",
    "solar-uav efficiencies atlantiksolar-as2 --plot efficiencies.png",
)
reproduce_report = Command(
    "reproduce-report",
    ReproduceReport,
    "validation:reproduce_report",
    "solar-uav reproduce-report --out reproduced",
)
