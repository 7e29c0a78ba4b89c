"""The command ``solar-uav explore``."""

from __future__ import annotations

import click

from studies.cli.help_texts import command
from studies.cli.options import (
    EXIT_FAILED,
    Asked,
    aircraft_argument,
    mission_option,
    model_options,
)
from studies.cli.telling import tell_error

_NEEDS = "explore needs {missing}: pip install 'solar-uav-sizing[explore]'"


@command("solar-uav explore atlantiksolar-design -m central-europe-summer")
@aircraft_argument()
@mission_option()
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    show_default=True,
    help="Port on this machine; 0 for any that is free.",
)
@click.option("--no-browser", is_flag=True, help="Only print the address.")
@click.option(
    "--static",
    "static_file",
    type=click.Path(),
    metavar="FILE",
    help="Write an HTML page that needs no server and no network, instead of serving one.",
)
@model_options
def explore(
    asked: Asked,
    port: int,
    no_browser: bool,
    static_file: str | None,
) -> None:
    """Explore AIRCRAFT (name, file or folder) with sliders, on a page of this machine."""
    from studies.cli.checks import check_outputs, refuse_climb, require_path
    from studies.explorer.session import Session

    if static_file is None:
        _require_server()
    elif port or no_browser:
        raise click.UsageError("--static serves nothing: give it without --port and --no-browser")
    check_outputs(static=static_file)
    case = asked.case()
    refuse_climb(case, "explore")
    require_path(case)
    where = case.where.document.source.removesuffix(" (shipped)")
    words = [asked.aircraft, "-m", where, *(w for one in asked.overrides for w in ("--set", one))]
    session = Session(case.craft.document, case.where.document, case.solar, command=words)
    if static_file is not None:
        from missions.files.writing import write_text_atomically
        from studies.explorer.offline.page import offline_page
        from studies.output.terminal import tell_line

        write_text_atomically(static_file, offline_page(session))
        tell_line(f"written to {static_file}")
        return
    from studies.explorer.serve import ADDRESS, bound_socket, serve

    try:
        listening = bound_socket(port)
    except OSError as error:
        reason = f"cannot listen on {ADDRESS}:{port}: {error.strerror}; try --port 0"
        tell_error(f"solar-uav: {reason}")
        raise SystemExit(EXIT_FAILED) from None

    def tell(address: str) -> None:
        click.echo(address)  # which flushes, so that a program that started us can read it
        tell_error(f"{case.title}; Ctrl-C ends it")

    serve(session, listening, tell=tell, browser=not no_browser)


def _require_server() -> None:
    """Name what is missing of the extra ``explore``."""
    try:
        import starlette  # noqa: F401
        import uvicorn  # noqa: F401
    except ImportError as error:
        raise click.UsageError(_NEEDS.format(missing=error.name)) from None
