"""What ``solar-uav export`` does."""

from __future__ import annotations

import sys

import click

from missions.files.writing import write_bytes_atomically
from sizing.results.analysis import analyse
from studies.cli.command import check_outputs
from studies.cli.commands.design import Export
from studies.cli.files import load_flyable
from studies.cli.options import EXIT_FAILED, check_format
from studies.cli.telling import tell_error
from studies.exchange import files
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
    analysis = analyse(**load_flyable(options).arguments, replay=False)
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
