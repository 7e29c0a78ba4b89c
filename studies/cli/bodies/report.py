"""What ``solar-uav report`` does."""

from __future__ import annotations

from missions.weather.files import load_weather
from studies.cli.commands.analyse import Report
from studies.cli.files import load_flyable
from studies.cli.outputs import check_report, name_written, print_json


def report(options: Report) -> None:
    """Write a report on an aircraft and a mission."""
    check_report(options.out_file, with_pdf=options.with_pdf)
    case = load_flyable(options)
    from studies.cli.reports import sizing_of_folder, subject_of, write_report  # takes a second

    record = (
        None if options.weather_file is None else load_weather(options.weather_file, case.mission)
    )
    subject = subject_of(
        case,
        sizing=sizing_of_folder(options.aircraft, case),
        overrides=options.overrides,
        with_uncertainty=options.uncertainty,
        weather_record=record,
        project=options.project,
        author=options.author,
    )
    written = write_report(case, subject, options.out_file, with_pdf=options.with_pdf)
    if case.as_json:
        print_json(subject.results())
    else:
        name_written(written)
