"""The command ``solar-uav report``."""

from __future__ import annotations

from typing import Any

import click

from studies.cli.help_texts import command
from studies.cli.options import (
    Asked,
    aircraft_argument,
    completes,
    mission_option,
    print_json,
    solar_options,
)


@command("solar-uav report atlantiksolar-as2 -m rafz-july --out report.html")
@aircraft_argument()
@mission_option()
@click.option(
    "--out",
    "out_file",
    type=click.Path(),
    required=True,
    metavar="FILE",
    help="Write the page: .html, or .pdf for the printed one alone.",
)
@click.option("--pdf", "with_pdf", is_flag=True, help="Also print it, beside the page, as PDF.")
@click.option(
    "--weather",
    "weather_file",
    shell_complete=completes("weather_file"),
    type=click.Path(),
    metavar="FILE",
    help="Also fly through a weather record, as analyse does.",
)
@click.option(
    "--uncertainty/--no-uncertainty",
    default=None,
    help="Whether inputs scatter.  [default: if aircraft or mission has uncertain inputs]",
)
@solar_options
def report(
    asked: Asked,
    out_file: str,
    with_pdf: bool,
    weather_file: str | None,
    uncertainty: bool | None,
) -> None:
    """Write a report on AIRCRAFT (name, file or folder): one page, to be read or printed."""
    from studies.cli.checks import require_climber, require_path
    from studies.cli.reports import (
        check_report,
        check_uncertainty,
        sizing_of_folder,
        subject_of,
        write_report,
    )
    from studies.output.terminal import tell_line

    check_report(out_file, with_pdf=with_pdf)
    case = asked.case()
    require_path(case)
    require_climber(case)
    options: dict[str, Any] = {"overrides": asked.overrides, "with_uncertainty": uncertainty}
    if weather_file is not None:
        from missions.weather.files import load_weather

        options["weather_record"] = load_weather(weather_file)
    subject = subject_of(case, sizing=sizing_of_folder(asked.aircraft, case), **options)
    check_uncertainty(case, subject)
    written = write_report(subject, out_file, with_pdf=with_pdf)
    if asked.as_json:
        print_json(subject.results())
        return
    for path in written:
        tell_line(f"written to {path}")
