"""Tables of a comparison of models, for the terminal and for the documentation."""

from __future__ import annotations

from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from studies.models.summary import two_digits

_DESIGN_COLUMNS = {
    "max_excess_time": ("built: promised [h]", "promised_excess_time_h"),
    "min_wingspan": ("built: span [m]", "wingspan_m"),
    "min_mass": ("built: mass [kg]", "total_mass_kg"),
    "max_payload_mass": ("built: payload [kg]", "payload_mass_kg"),
    "max_payload_power": ("built: payload [W]", "payload_power_w"),
}
_PREDICTED = (
    "model",
    "corr.",
    "income [Wh]",
    "vs ref. [%]",
    "excess time [h]",
    "least SoC [%]",
    "charge margin [h]",
    "endur. [h]",
    "season [d]",
)
_JUDGED = ("then: excess [h]", "then: endur. [h]")


def print_comparison(console: Console, record: dict[str, Any]) -> None:
    """One row for each case, the sentence, and what the reader should know."""
    reference = record["reference"]
    console.print(f"{record['aircraft']} on {record['mission']}", style="bold")
    # 80 columns must show every number whole.
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=0)
    for number, name in enumerate(_header(record)):
        justify: Any = "left" if number < 2 else "right"
        table.add_column(name.replace(" ", "\n"), justify=justify, no_wrap=True)
    previous = None
    for case in record["cases"]:
        if previous not in (None, case["model"]):
            table.add_section()
        previous = case["model"]
        is_reference = {k: case[k] for k in reference} == reference
        table.add_row(*_cells(case, record), style="bold" if is_reference else None)
    console.print(table)
    console.print(record["sentence"])
    worst = dict.fromkeys(case["worst_scenario"]["label"] for case in record["cases"])
    lines = [
        f"reference: {reference['model']}, correction {reference['correction']}; income: mean of "
        "all scenarios",
        f"worst scenario: {' or '.join(worst)}; season: days of perpetual flight in the year",
    ]
    if _has_designs(record):
        required = record["objective"]["required_excess_time_h"]
        lines.append(
            f"built: {record['objective']['name']} with {required:g} h of excess time; "
            "then: judged by the reference, in its worst scenario"
        )
    for line in (*lines, *record["notes"]):
        console.print(f"- {line}", style="dim")


def markdown(record: dict[str, Any]) -> str:
    """Table with one row for each case, and the sentence."""
    header = _header(record)
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(_cells(case, record)) + " |" for case in record["cases"]]
    return "\n".join(lines) + f"\n\n{record['sentence']}\n"


def _has_designs(record: dict[str, Any]) -> bool:
    return any(case["design"] is not None for case in record["cases"])


def _header(record: dict[str, Any]) -> list[str]:
    if not _has_designs(record):
        return list(_PREDICTED)
    name, _ = _DESIGN_COLUMNS[record["objective"]["name"]]
    return [*_PREDICTED, name, *_JUDGED]


def _cells(case: dict[str, Any], record: dict[str, Any]) -> list[str]:
    above = case["income_above_reference"]
    cells = [
        case["model"],
        case["correction"],
        f"{case['mean_solar_energy_wh']:.0f}",
        "-" if above is None else f"{_rounded(100 * above):+.1f}",
        _excess(case),
        f"{100 * case['minimum_state_of_charge']:.1f}",
        f"{case['charge_margin_h']:.2f}",
        _endurance(case),
        _season(case["season"]),
    ]
    if case["design"] is None:
        return cells
    return [*cells, *_design_cells(case["design"], record["objective"]["name"])]


def _rounded(percent: float) -> float:
    """Percentage to one decimal, without a negative zero."""
    return round(percent, 1) + 0.0


def _design_cells(design: dict[str, Any], objective: str) -> list[str]:
    judged = design["judged"]
    if judged is None:
        return [design["status"].replace("_", " "), "-", "-"]
    value = design[_DESIGN_COLUMNS[objective][1]]
    return ["no end" if value is None else f"{value:.2f}", _excess(judged), _endurance(judged)]


def _excess(of: dict[str, Any]) -> str:
    return "no end" if of["excess_time_h"] is None else f"{of['excess_time_h']:.2f}"


def _endurance(of: dict[str, Any]) -> str:
    if of["status"] in ("perpetual", "always_lit"):
        return "no end"
    hours = of["endurance_h"]
    if hours is None:
        return "> 1 year"
    # A flight that is almost perpetual ends after a number of days that is known less well.
    return f"{hours:.1f}" if hours < 72.0 else f"{two_digits(hours / 24.0)} d"


def _season(season: dict[str, Any]) -> str:
    """Days in the year; where they are not one window around the solstice, that window's too."""
    days, window = season["days"], season["window_days"]
    return f"{days}" if days == window else f"{window} of {days}"
