"""Commands for other tools: ``solar-uav export`` and ``schema``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import click

from studies.cli.command import Command, OutputFile, argument, option
from studies.cli.options import CaseOptions, case_options


@dataclass(frozen=True)
class Export:
    """Write AIRCRAFT (name, file or folder) for other tools: its geometry, or its numbers."""

    case: CaseOptions = case_options(with_json=False)
    out_files: tuple[str, ...] = option(
        "--out",
        type=click.Path(),
        multiple=True,
        required=True,
        metavar="FILE",
        help="Write geometry: .avl (AVL), .vspscript (OpenVSP), .py (AeroSandbox); or a table of "
        "the design on its mission: .tex, .xlsx, .csv, .parquet. May be given several times.",
    )


@dataclass(frozen=True)
class Schema:
    """Print the JSON Schema of aircraft or mission files, for completion in an editor."""

    kind: Literal["aircraft", "mission"] = argument(type=click.Choice(("aircraft", "mission")))
    out_file: str | None = option(
        "--out", type=OutputFile(), metavar="FILE", help="Write it instead of printing it."
    )


export = Command(
    "export",
    Export,
    "exchange:export",
    "solar-uav export atlantiksolar-design --out wing.avl",
    "solar-uav export sized -m rafz-july --out design.tex --out design.xlsx",
)
schema = Command(
    "schema", Schema, "exchange:schema", "solar-uav schema aircraft --out aircraft.schema.json"
)
