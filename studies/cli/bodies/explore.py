"""What ``solar-uav explore`` does."""

from __future__ import annotations

import sys

import click

from missions.files.writing import write_text_atomically
from studies.cli.commands.explore import Explore
from studies.cli.files import (
    OFFLINE,
    load,
    refuse_climb,
    refuse_held_station,
    require_climber,
    require_path,
)
from studies.cli.options import EXIT_FAILED
from studies.cli.telling import tell_error
from studies.explorer.offline.page import offline_page
from studies.explorer.session import Session
from studies.output.terminal import tell_line


def explore(options: Explore) -> None:
    """Serve the page of a design, or write it."""
    case = load(options.case)
    require_path(case)
    require_climber(case)
    if options.static_file is not None:
        refuse_climb(case, "explore --static", OFFLINE)
        refuse_held_station(case, "explore --static")
    aircraft, mission = case.aircraft_file.document, case.mission_file.document
    words = [options.case.aircraft, "-m", mission.source.removesuffix(" (shipped)")]
    words += [word for one in options.case.overrides for word in ("--set", one)]
    session = Session(aircraft, mission, case.solar, command=words)
    if options.static_file is not None:
        write_text_atomically(options.static_file, offline_page(session))
        tell_line(f"written to {options.static_file}")
        return
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
