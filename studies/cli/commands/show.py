"""The command ``solar-uav show``."""

from __future__ import annotations

import click


@click.command(short_help="The file of a shipped aircraft or mission.")
@click.argument("name")
def show(name: str) -> None:
    """Print the file of the shipped aircraft or mission NAME, comments included.

    To start your own from it: solar-uav show atlantiksolar-as2 > mine.yaml
    """
    from missions.files.shipped import shipped_text

    click.echo(shipped_text(name), nl=False)
