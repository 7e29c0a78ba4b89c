"""The command ``solar-uav verify``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from studies.cli.options import (
    console,
    json_option,
    load,
    mission_option,
    print_json,
    set_option,
)

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from studies.flight_logs.errors import Window
    from studies.flight_logs.verification import Verification

_LONGEST_FILTER = 1_000_000


class SolarWindow(click.ParamType["Window"]):
    """A period of solar time, on every day or on one."""

    name = "a:b"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> Window:
        """Read the window."""
        from studies.flight_logs.errors import parse_window

        try:
            return parse_window(str(value))
        except ValueError as error:
            self.fail(str(error), param, ctx)


@click.command(short_help="The solar power models against a flight log.")
@click.argument("aircraft")
@click.argument("log_file", metavar="LOG")
@mission_option("rafz-28h")
@click.option(
    "--window",
    "windows",
    type=SolarWindow(),
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
@click.option("--out", "out_dir", type=click.Path(), help="Folder for samples, JSON and figures.")
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
    from studies.flight_logs import verification as study
    from studies.flight_logs.records import to_json

    if out_dir is not None:
        check_writable_folder(Path(out_dir))
    craft, where = load(aircraft, mission, overrides)
    log = read_flight_log(log_file)
    result = study.verify(
        log, craft.aircraft, where.mission, windows=windows, semi_window=semi_window
    )
    record = to_json(result)
    if out_dir is not None:
        write_verification(Path(out_dir), result, record)
    if as_json:
        print_json(record)
        return
    print_verification(console(), record)
    if out_dir is not None:
        click.echo(f"written to {out_dir}")


# ---- Files


def write_verification(folder: Path, result: Verification, record: dict[str, Any]) -> None:
    """Write samples, JSON and figures into a folder; existing files of these names are replaced.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    from missions.files.writing import write_folder
    from studies.flight_logs import plots as figures
    from studies.flight_logs.errors import day_masks
    from studies.flight_logs.records import samples_csv
    from studies.output.plots import to_bytes

    contents: dict[str, bytes] = {
        "samples.csv": samples_csv(result).encode(),
        "verification.json": json.dumps(record, indent=2, allow_nan=False).encode(),
    }
    for number in range(len(result.windows)):
        figure = figures.window_figure(result, number)
        contents[f"window-{number + 1}.png"] = to_bytes(figure, "png")
    for section, (date, mask) in zip(result.days, day_masks(result.samples), strict=True):
        contents[f"day-{date}.png"] = to_bytes(figures.day_figure(result, section, mask), "png")
    write_folder(folder, contents)


def print_verification(console: Console, record: dict[str, Any]) -> None:
    """Errors of every window and day, anomalies, and what the reader should know."""
    log = record["log"]
    console.print(
        f"{record['aircraft']} against {log['source']}: {log['start']} to {log['end']}, "
        f"{log['sunlit_samples']} of {log['samples']} samples with the sun up",
        style="bold",
    )
    for kind, key in (("solar time", "windows"), ("UTC", "days")):
        for section in record[key]:
            console.print(_error_table(section, kind))
    if record["anomalies"]:
        console.print(_anomaly_table(record["anomalies"]))
    else:
        console.print("no anomaly found")
    if record["excluded_samples"]:
        console.print(
            f"{record['excluded_samples']} samples with limited charging are not in the errors"
        )
    for note in record["notes"]:
        console.print(f"- {note}")
    console.print(
        "errors are modelled minus measured, % of the mean measured power; RMS and maximum after a "
        "moving average over so many samples on either side as filter says",
        style="dim",
    )


def _error_table(section: dict[str, Any], kind: str) -> Table:
    from rich.table import Table

    if not section["models"]:
        return Table(title=f"{section['label']} ({kind}): all samples are excluded")
    title = (
        f"{section['label']} ({kind}): {section['measured_mean_w']:.2f} W measured, "
        f"{section['samples']} samples, filter {section['filter_semi_window']}"
    )
    table = Table(title=title, title_justify="left")
    table.add_column("model")
    for name in ("mean W", "average W", "%", "RMS W", "%", "maximum W", "%"):
        table.add_column(name, justify="right", no_wrap=True)
    for model, errors in section["models"].items():
        table.add_row(
            model,
            f"{errors['modelled_mean_w']:.2f}",
            *_error_cells(errors, "average", "+"),
            *_error_cells(errors, "rms", ""),
            *_error_cells(errors, "maximum", ""),
        )
    return table


def _error_cells(errors: dict[str, Any], name: str, sign: str) -> tuple[str, str]:
    relative = errors[f"{name}_error_relative"]
    share = "-" if relative is None else f"{100 * relative:{sign}.2f}"
    return f"{errors[f'{name}_error_w']:{sign}.2f}", share


def _anomaly_table(anomalies: list[dict[str, Any]]) -> Table:
    from rich.table import Table

    table = Table(title="anomalies", title_justify="left", show_lines=True)
    for name in ("what", "from, to (UTC)", "evidence"):
        table.add_column(name)
    for a in anomalies:
        lost = f"\n{a['lost_wh']:.1f} Wh lost" if a["lost_wh"] else ""
        table.add_row(
            f"{a['kind'].replace('_', ' ')}\n{a['severity']}{lost}",
            "\n".join(a[end].replace("T", " ").rstrip("Z") for end in ("start", "end")),
            a["evidence"],
        )
    return table
