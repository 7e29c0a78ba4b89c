"""What ``solar-uav explore`` does."""

from __future__ import annotations

import sys

import click

from studies.cli.commands.design import Explore
from studies.cli.files import load_flyable
from studies.cli.options import EXIT_FAILED
from studies.cli.telling import tell_error
from studies.explorer.session import Session


def explore(options: Explore) -> None:
    """Serve the page of a design."""
    case = load_flyable(options)
    aircraft, mission = case.aircraft_file.document, case.mission_file.document
    words = [options.aircraft, "-m", mission.source.removesuffix(" (shipped)")]
    words += [word for override in options.overrides for word in ("--set", override)]
    session = Session(aircraft, mission, case.solar, command=words)
    from studies.explorer.serve import ADDRESS, bound_socket, serve  # of the extra

    try:
        listening = bound_socket(options.port)
    except OSError as error:
        reason = f"cannot listen on {ADDRESS}:{options.port}: {error.strerror}; try --port 0"
        tell_error(f"solar-uav: {reason}")
        sys.exit(EXIT_FAILED)

    def tell(address: str) -> None:
        click.echo(address)  # which flushes, so that a program that started us can read it
        tell_error(f"{case.title}; Ctrl-C ends it")

    serve(session, listening, tell=tell, browser=not options.no_browser)
