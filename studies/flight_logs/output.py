"""Tables on the terminal, and files, of a verification."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table

from studies.flight_logs.errors import day_masks
from studies.flight_logs.plots import day_figure, window_figure
from studies.flight_logs.records import samples_csv
from studies.flight_logs.verification import Verification
from studies.output.plots import to_bytes


def verification_files(result: Verification) -> dict[str, bytes]:
    """Samples and figures of a verification, by the names of their files."""
    contents = {"samples.csv": samples_csv(result).encode()}
    for number in range(len(result.windows)):
        figure = window_figure(result, number)
        contents[f"window-{number + 1}.png"] = to_bytes(figure, "png")
    for section, (date, mask) in zip(result.days, day_masks(result.samples), strict=True):
        contents[f"day-{date}.png"] = to_bytes(day_figure(result, section, mask), "png")
    return contents


def print_verification(console: Console, record: dict[str, Any]) -> None:
    """Print errors of every window and day, anomalies, and what the reader should know.

    Parameters
    ----------
    console : Console
    record : dict
        Verification as :func:`studies.flight_logs.records.to_json` gives it.
    """
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
