"""The command ``solar-uav report``."""

from __future__ import annotations

from dataclasses import dataclass

import click

from studies.cli.command import Command, option
from studies.cli.options import CaseOptions, case_options, mass_option, weather_option


@dataclass(frozen=True)
class Report:
    """Write a report on AIRCRAFT (name, file or folder): one page, to be read or printed."""

    case: CaseOptions = case_options()
    mass_kg: float | None = mass_option()
    out_file: str = option(
        "--out",
        type=click.Path(),
        required=True,
        metavar="FILE",
        help="Write the page: .html, or .pdf for the printed one alone.",
    )
    with_pdf: bool = option("--pdf", is_flag=True, help="Also print it, beside the page, as PDF.")
    weather_file: str | None = weather_option("Also fly through a weather record, as analyse does.")
    uncertainty: bool | None = option(
        "--uncertainty/--no-uncertainty",
        default=None,
        help="Whether inputs scatter.  [default: if aircraft or mission has uncertain inputs]",
    )


report = Command(
    "report",
    Report,
    "report:report",
    "solar-uav report atlantiksolar-as2 -m rafz-july --out report.html",
)
