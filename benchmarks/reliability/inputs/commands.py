"""Cases of the command line itself: options of every command, and what shells ask to complete."""

from __future__ import annotations

import random
from functools import cache
from typing import Any, NamedTuple

import click

from benchmarks.reliability.inputs.cases import Case
from benchmarks.reliability.inputs.mutations import HOSTILE, NUMBERS, number_text
from missions.files.shipped import shipped_names

__all__ = ["completion", "options"]

_OUTPUTS = {
    "csv_file": ("out.csv",),
    "csv_years": ("years.csv",),
    "plot_file": ("out.svg", "out.png", "out.pdf"),
    "markdown_file": ("out.md",),
    "report_file": ("out.html",),
    "static_file": ("page.html",),
}
# Of commands that take long: one of so many of their cases.
_RARE = {"report": 25, "published": 40, "loiter-correction": 25, "reproduce-report": 25}
_RARE |= {"compare": 8, "explore": 10, "ceiling": 2, "size": 2}
_COARSE = {
    "map": ("--latitudes", "0:60:30", "--days", "100:200:50", "--workers", "1"),
    "sweep": ("--vary", "battery_mass_kg=1:3:1", "--workers", "1"),
    "ceiling": ("--step", "5000"),
    "uncertainty": ("--samples", "64"),
    "compare": ("--models", "CDM,CAM", "--no-design"),
}
_TEXTS = {
    "vary": ("wingspan_m=3:5:1", "battery_mass_kg=1,2", "modules.efficiency_stc=0.2,0.3", "a=1"),
    "latitudes": ("0:60:30", "-90:90:90", "10:0:1", "0:1:0.0001"),
    "days": ("1:365:182", "100:200:50", "0:400:1", "1.5:3:1"),
    "batteries": ("1:2:1", "0:1:1"),
    "models": ("CDM", "CAM,CDM", "CDM,,CAM", "all"),
    "corrections": ("none", "report", "loiter,none"),
    "figure-size": ("80x60mm", "4in", "0x0mm", "1e9x1e9in", "-1in", "80x60"),
    "dpi": ("50", "72.5", "0", "-1", "1e9"),
    "style": ("paper", "dark", "default", "style.mplstyle", "ggplot", "/dev/zero"),
    "date": ("06-21", "02-29", "13-01", "2015-06-21"),
    "latitude": ("47", "-90", "90.0001", "47N"),
    "sort": ("wingspan", "-excess_time", "nothing"),
    "window": ("5:6", "2015-07-01@5:6", "6:5", "a:b"),
    "weather": ("w.csv", "nowhere.epw", "colorado-2023"),
    "scheduler": ("nowhere", "tcp://", ""),
    "out": ("out.nc", "out.csv", "folder", "folder/deep/out.csv", ".", "taken", "out.html"),
    "work": ("folder", "taken", "."),
}


class _Option(NamedTuple):
    """An option: its longest name, how many values it takes, and what may stand there."""

    name: str
    values: int
    choices: tuple[str, ...]
    destination: str


def options(rng: random.Random) -> Case:
    """Command of any name with options of its own, some of their values strange."""
    names = sorted(_commands())
    name = rng.choice(names)
    if rng.randrange(_RARE.get(name, 1)):
        name = rng.choice(("analyse", "map", "sweep", "uncertainty", "list", "show", "validate"))
    known = _commands()[name]
    arguments: list[str] = [name, *_positional(name, rng)]
    arguments += _COARSE.get(name, ()) if rng.random() < 0.9 else ()
    outputs: list[str] = []
    for option in rng.sample(known, min(len(known), rng.choice((0, 1, 1, 2, 3)))):
        if option.name in ("--workers", "--samples", "--explain", "--help"):  # or slow by intent
            continue
        arguments += _given(option, rng, outputs)
    if name == "report":
        arguments += ["--out", "out.html"]
    if rng.random() < 0.05:
        arguments.insert(rng.randrange(len(arguments)), rng.choice(HOSTILE).replace("\0", ""))
    as_json = "--json" in arguments
    files = {
        "taken": b"a file\n",
        "w.csv": b"# latitude_deg: 47\n",
        "style.mplstyle": rng.choice(_STYLES),
    }
    return Case(tuple(arguments), files, json=as_json, outputs=tuple(outputs))


_STYLES = (
    *(b"lines.linewidth: 2\n", b"text.usetex: True\n", b"font.size: -5\n", b"axes.grid: maybe\n"),
    *(b"savefig.dpi: 1e9\n", b"figure.figsize: 1e6, 1e6\n", b"\xff\xfe", b"axes.prop_cycle: x\n"),
    *(b"axes.prop_cycle: cycler(color=[__import__('os').getcwd()])\n", b"backend: gtk3agg\n"),
    *(b"font.size: 1e9\n", b"lines.linewidth: nan\n", b"savefig.format: exe\n", b"x" * 100_000),
)


def _positional(name: str, rng: random.Random) -> list[str]:
    if name in ("list", "published", "reproduce-report"):
        return []
    if name == "show":
        return [rng.choice(("atlantiksolar-as2", "rafz-july", *HOSTILE)).replace("\0", "")]
    if name == "init":
        return [rng.choice(("albatross", "taken", *HOSTILE)).replace("\0", "")]
    if name == "validate":
        return [rng.choice(("taken", "nowhere.yaml", *HOSTILE)).replace("\0", "")]
    aircraft = rng.choice(shipped_names("aircraft"))
    if rng.random() < 0.1:
        aircraft = rng.choice(("taken", "nowhere.yaml", *HOSTILE)).replace("\0", "")
    mission = ["-m", rng.choice(shipped_names("mission"))] if rng.random() < 0.7 else []
    return [aircraft, *(["taken"] if name == "verify" else []), *mission]


def _given(option: _Option, rng: random.Random, outputs: list[str]) -> list[str]:
    """Option with values; a file that it should write is noted."""
    if not option.values:
        return [option.name]
    places = _OUTPUTS.get(option.destination)
    if places and rng.random() < 0.8:
        place = rng.choice(places)
        outputs.append(place)
        return [option.name, place]
    given = [_value(option, rng) for _ in range(option.values)]
    if option.values == 1 and rng.random() < 0.5:
        return [f"{option.name}={given[0]}"]
    return [option.name, *given]


def _value(option: _Option, rng: random.Random) -> str:
    ready = (*option.choices, *_TEXTS.get(option.name.lstrip("-"), ()))
    way = rng.random()
    if ready and way < 0.7:
        return rng.choice(ready)
    if way < 0.85:
        return number_text(rng)
    return rng.choice((*HOSTILE, *NUMBERS)).replace("\0", "")


@cache
def _commands() -> dict[str, list[_Option]]:
    from studies.cli.__main__ import cli

    context = click.Context(cli)
    found: dict[str, list[_Option]] = {}
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        if command is not None:
            found[name] = [_option(p) for p in command.params if isinstance(p, click.Option)]
    return found


def _option(parameter: click.Option) -> _Option:
    kind: Any = parameter.type
    choices = tuple(map(str, kind.choices)) if isinstance(kind, click.Choice) else ()
    takes = 0 if parameter.is_flag else parameter.nargs
    return _Option(max(parameter.opts, key=len), takes, choices, str(parameter.name))


def completion(rng: random.Random) -> Case:
    """What a shell asks for when somebody presses the tabulator."""
    words = ["solar-uav"]
    for _ in range(rng.randrange(5)):
        every = (*_commands(), "--set", "--vary", "-m", "power.", "mission.air", "--json", "=", ":")
        words.append(rng.choice((*every, *HOSTILE)).replace("\0", ""))
    place: str = str(rng.randrange(len(words) + 1))
    if rng.random() < 0.3:
        place = rng.choice(("", "-1", "99", "x", "1.5", "9" * 400, " 1", "-9999999999"))
    environment = {
        "_SOLAR_UAV_COMPLETE": rng.choice(
            ("bash_complete", "zsh_complete", "fish_complete", "bash_source", "x", "", "bash_")
        ),
        "COMP_WORDS": rng.choice(("\n", " ")).join(words),
        "COMP_CWORD": place,
        "COMP_WORDBREAKS": rng.choice(("=:", "", " \t\n=")),
    }
    if rng.random() < 0.1:
        del environment[rng.choice(("COMP_WORDS", "COMP_CWORD"))]
    return Case((), {"a.yaml": b""}, environment=environment)
