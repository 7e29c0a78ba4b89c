"""Files of a design for other tools, by the ending of their name."""

from __future__ import annotations

import os
import re
from itertools import groupby

from missions.files.writing import write_bytes_atomically
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.results.analysis import Analysis, analyse
from solar.names import CorrectionName, ModelName
from studies.exchange.airplane import airplane_text, missing_library
from studies.output import formats
from studies.render.design_sheet import DesignSheet, design_sheet
from studies.render.tables import UNLIMITED

# Geometry needs no mission; tables hold results on one.
GEOMETRY_FORMATS = ("avl", "vspscript", "py")
_TABLE_FORMATS = ("tex", "xlsx", "csv", "parquet")
DESIGN_FORMATS = (*GEOMETRY_FORMATS, *_TABLE_FORMATS)


def design_format(path: str) -> str | None:
    """Return the format of a file name, None if it cannot be written."""
    return formats.format_of(path, DESIGN_FORMATS)


def missing_for(path: str) -> str | None:
    """Return the missing library of a file's format and how to install it, else None."""
    if design_format(path) in ("avl", "vspscript"):
        missing = missing_library()
        return None if missing is None else f".{design_format(path)} {missing}"
    return formats.missing_writer(design_format(path))


def export_design(
    aircraft: Aircraft,
    mission: Mission,
    path: str | os.PathLike[str],
    *,
    model: ModelName = "CAM",
    correction: CorrectionName = "none",
) -> None:
    """Write a design for another tool, whole or not at all.

    Parameters
    ----------
    aircraft : Aircraft
    mission : Mission
        Mission of its flight and energy; of the geometry, only the centre of gravity depends on it.
    path : str or path-like
        Ends in ``.avl`` (AVL), ``.vspscript`` (OpenVSP), ``.py`` (a
        script for AeroSandbox), ``.tex`` (a table of LaTeX), ``.xlsx`` (a workbook of the design,
        its scenarios and their cycles), ``.csv`` or ``.parquet`` (the table of the design).
    model : {"CAM", "CDM", "VM", "FM"}
    correction : {"none", "report", "loiter"}

    Raises
    ------
    ValueError
        For another ending.
    ImportError
        If the library that writes the format is not installed.
    OutputError
        If a file cannot be written.
    """
    name = os.fspath(path)
    if design_format(name) is None:
        raise ValueError(formats.wrong_ending(name, DESIGN_FORMATS))
    missing = missing_for(name)
    if missing is not None:
        raise ImportError(missing)
    analysis = analyse(aircraft, mission, model=model, correction=correction, replay=False)
    write_bytes_atomically(name, design_bytes(analysis, name))


def design_bytes(analysis: Analysis, path: str) -> bytes:
    """Return the content of a design's file."""
    ending = design_format(path)
    if ending is not None and ending in GEOMETRY_FORMATS:
        gravity_m = None if analysis.balance is None else analysis.balance.gravity_m
        return airplane_text(analysis.aircraft, ending, gravity_m).encode()

    sheet = design_sheet(analysis)
    if ending == "tex":
        return latex_table(sheet).encode()
    if ending == "xlsx":
        tables = {
            "design": sheet.to_frame(),
            "scenarios": analysis.to_frame(),
            "cycle": analysis.trajectory(),
        }
        return formats.workbook_bytes(tables)
    return formats.table_bytes(sheet.to_frame(), path)


# ---- LaTeX, with the package booktabs

_ESCAPES = {
    "\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "$": r"\$", "&": r"\&", "#": r"\#",
    "%": r"\%", "_": r"\_", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "°": r"$^\circ$", "²": r"$^2$", "³": r"$^3$", "−": r"$-$", "·": r"$\cdot$", "×": r"$\times$",
}  # fmt: skip


def latex_table(sheet: DesignSheet) -> str:
    """Return a design as a LaTeX ``table`` with caption and label, which needs ``booktabs``."""
    label = re.sub(r"[^a-z0-9]+", "-", sheet.title.lower()).strip("-") or "design"
    lines = [
        r"% \usepackage{booktabs}",
        r"\begin{table}",
        r"  \centering",
        rf"  \caption{{{escaped(sheet.title)}. {escaped(' '.join(sheet.notes))}}}",
        rf"  \label{{tab:{label}}}",
        r"  \begin{tabular}{llrl}",
        r"    \toprule",
        r"    Quantity & Symbol & Value & Unit \\",
    ]
    for _, entries in groupby(sheet.quantities, key=lambda entry: entry.group):
        lines.append(r"    \midrule")
        for entry in entries:
            of, (value, unit) = entry.quantity, entry.shown()
            symbol = f"${of.symbol}$" if of.symbol else ""
            if value != UNLIMITED:  # a number, with its exponent
                ten = re.sub(
                    r"e([+-])0*(\d+)", lambda m: rf"\times 10^{{{m[1].strip('+')}{m[2]}}}", value
                )
                value = f"${ten}$"
            raised = unit.replace("²", "^2").replace("³", "^3").replace("%", r"\%")
            upright = rf"$\mathrm{{{raised}}}$" if unit else ""
            lines.append(f"    {escaped(of.label)} & {symbol} & {value} & {upright} \\\\")
    lines += [r"    \bottomrule", r"  \end{tabular}", r"\end{table}"]
    return "\n".join(lines) + "\n"


def escaped(text: str) -> str:
    """Escape characters that mean something to LaTeX."""
    return "".join(_ESCAPES.get(character, character) for character in text)
