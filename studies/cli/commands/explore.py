"""The command ``solar-uav explore``."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec

import click

from studies.cli.command import Command, option
from studies.cli.options import CaseOptions, case_options

_SERVER = ("starlette", "uvicorn")  # of the extra ``explore``


@dataclass(frozen=True)
class Explore:
    """Explore AIRCRAFT (name, file or folder) with sliders, on a page of this machine."""

    case: CaseOptions = case_options(with_json=False)
    port: int = option(
        "--port",
        type=click.IntRange(0, 65535),
        default=0,
        show_default=True,
        help="Port on this machine; 0 for any that is free.",
    )
    no_browser: bool = option("--no-browser", is_flag=True, help="Only print the address.")

    def __post_init__(self) -> None:
        """Refuse to start without what the page is served by."""
        missing = next((name for name in _SERVER if find_spec(name) is None), None)
        if missing is not None:
            raise click.UsageError(
                f"explore needs {missing}: pip install 'solar-uav-sizing[explore]'"
            )


explore = Command(
    "explore",
    Explore,
    "explore:explore",
    "solar-uav explore atlantiksolar-design -m central-europe-summer",
)
