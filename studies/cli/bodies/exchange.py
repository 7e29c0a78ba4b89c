"""What ``solar-uav export`` and ``schema`` do."""

from __future__ import annotations

import sys

import click

from missions.files.writing import to_json, write_bytes_atomically, write_text_atomically
from sizing.results.analysis import Analysis, analyse
from studies.cli.command import check_outputs
from studies.cli.commands.exchange import Export, Schema
from studies.cli.files import load, require_climber, require_path
from studies.cli.options import EXIT_FAILED, CaseOptions, check_format
from studies.cli.outputs import print_json
from studies.cli.telling import tell_error
from studies.exchange import files
from studies.exchange.schema import file_schema
from studies.output.terminal import tell_line


def export(options: Export) -> None:
    """Write a design for other tools: of several files those that can be written."""
    several, troubles = len(options.out_files) > 1, dict[str, Exception]()
    for path in options.out_files:
        try:
            check_outputs({"--out": path})
        except OSError as error:
            troubles[path] = error
        known = files.design_format(path)
        try:
            check_format(path, known, files.DESIGN_FORMATS, "--out")
        except click.BadParameter as error:
            if known is None:
                raise
            troubles[path] = error
        missing = files.missing_for(path)
        if missing is not None:
            troubles[path] = click.BadParameter(missing, param_hint="--out")
    if len(troubles) == len(set(options.out_files)):
        raise next(iter(troubles.values()))
    analysis = _analysed(options.case)
    for path in options.out_files:
        if path not in troubles:
            try:
                write_bytes_atomically(path, files.design_bytes(analysis, path))
                tell_line(f"written to {path}")
            except OSError as error:
                if not several:
                    raise
                troubles[path] = error
    for path, trouble in troubles.items():
        reason = trouble.message if isinstance(trouble, click.BadParameter) else str(trouble)
        tell_error(f"solar-uav: {path} is not written: {reason}")
    if troubles:
        sys.exit(EXIT_FAILED)


def _analysed(options: CaseOptions) -> Analysis:
    """Aircraft on its mission, without the replay."""
    case = load(options)
    require_path(case)
    require_climber(case)
    return analyse(**case.arguments, replay=False)


def schema(options: Schema) -> None:
    """Print or write the schema of a kind of file."""
    record = file_schema(options.kind)
    if options.out_file is None:
        print_json(record)
        return
    write_text_atomically(options.out_file, to_json(record, indent=2) + "\n")
    click.echo(f"written to {options.out_file}")
