"""Files of a design for other tools, by the ending of their name."""

from __future__ import annotations

import os
from pathlib import Path

from missions.files.writing import write_bytes_atomically
from missions.mission import Mission
from sizing.aircraft import Aircraft
from sizing.balance.in_design import with_horizontal_tail
from sizing.results.analysis import Analysis, analyse
from solar.names import CorrectionName, ModelName
from studies.exchange.airplane import airplane_text, missing_library
from studies.exchange.design_sheet import design_sheet
from studies.exchange.latex import latex_table
from studies.output.formats import missing_writer, table_bytes, workbook_bytes

__all__ = ["DESIGN_FORMATS", "GEOMETRY_FORMATS", "design_bytes", "export_design", "missing_for"]

# Geometry alone needs no mission; tables hold what the aircraft does on one.
GEOMETRY_FORMATS = ("avl", "vspscript", "py")
_TABLE_FORMATS = ("tex", "xlsx", "csv", "parquet")
DESIGN_FORMATS = (*GEOMETRY_FORMATS, *_TABLE_FORMATS)


def design_format(path: str) -> str | None:
    """Format of a file name, none if it is not one that can be written."""
    suffix = Path(path).suffix.lstrip(".").lower()
    return suffix if suffix in DESIGN_FORMATS else None


def missing_for(path: str) -> str | None:
    """What to install before a file can be written; None where nothing is missing."""
    if design_format(path) in ("avl", "vspscript"):
        missing = missing_library()
        return None if missing is None else f".{design_format(path)} {missing}"
    return missing_writer(design_format(path))


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
        Where its flight and energy are those of; geometry alone does not depend on it but for the
        centre of gravity.
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
        allowed = ", ".join(f".{ending}" for ending in DESIGN_FORMATS)
        raise ValueError(f"{name!r} must end in {allowed}")
    missing = missing_for(name)
    if missing is not None:
        raise ImportError(missing)
    analysis = analyse(aircraft, mission, model=model, correction=correction, replay=False)
    write_bytes_atomically(name, design_bytes(analysis, name))


def design_bytes(analysis: Analysis, path: str) -> bytes:
    """Content of a file of a design."""
    ending = design_format(path)
    if ending is not None and ending in GEOMETRY_FORMATS:
        volume = analysis.performance.design.horizontal_volume
        gravity_m = None if analysis.balance is None else analysis.balance.gravity_m
        flown = with_horizontal_tail(analysis.aircraft, volume)
        return airplane_text(flown, ending, gravity_m).encode()

    sheet = design_sheet(analysis)
    if ending == "tex":
        return latex_table(sheet).encode()
    if ending == "xlsx":
        tables = {
            "design": sheet.to_frame(),
            "scenarios": analysis.to_frame(),
            "cycle": analysis.trajectory(),
        }
        return workbook_bytes(tables)
    return table_bytes(sheet.to_frame(), path)
