"""Kinds of inputs, and how many cases of each a campaign has."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

from benchmarks.reliability.inputs import commands, explorer, files, tables
from benchmarks.reliability.inputs.cases import Case, Maker, rng_of
from benchmarks.reliability.inputs.process import Told, in_processes, run_case

__all__ = ["KINDS", "Kind", "Result", "campaign", "work_of"]


class Kind(NamedTuple):
    """A kind of input: what reads it, what is done to it, and its cases in a campaign."""

    reader: str
    attack: str
    cases: int
    maker: Maker | None  # None: requests of the explorer


def _kinds() -> dict[str, Kind]:
    found = {
        "aircraft": Kind(
            "aircraft files",
            "keys, values, lines, characters and bytes changed; validate, analyse, map, size ...",
            22_000,
            files.aircraft_file,
        ),
        "missions": Kind("mission files", "the same", 16_000, files.mission_file),
        "set": Kind("`--set`", "keys and values, also such as no file has", 14_000, files.override),
        "polars": Kind("polar tables", "lines, fields and bytes changed", 6_000, files.polar_table),
        "folders": Kind("folders of results", "files damaged, gone, or links", 2_000, files.folder),
        "logs": Kind("flight logs, CSV", "lines, columns and bytes changed", 7_000, tables.log_csv),
        "ulog": Kind("flight logs, ULog", "topics and bytes changed", 5_000, tables.log_ulog),
        "options": Kind("options of all commands", "drawn values", 6_000, commands.options),
        "completion": Kind("shell completion", "words, places", 2_000, commands.completion),
        "explorer": Kind("explorer", "paths, headers and bodies changed", 9_000, None),
    }
    for layout, name in zip(tables.weather_layouts(), _WEATHER, strict=True):
        attack = "lines, columns and bytes changed"
        found[f"weather-{name}"] = Kind(f"weather, {layout}", attack, 1_100, tables.weather(layout))
    return found


_WEATHER = ("csv", "epw", "pvgis-epw", "tmy", "json", "hourly", "psm", "bsrn", "tmy2", "tmy3")
KINDS: dict[str, Kind] = _kinds()


class Result(NamedTuple):
    """What a kind's cases came to."""

    name: str
    kind: Kind
    cases: int
    accepted: int
    refused: int  # exit code 2
    failed: int  # exit code 1
    broken: tuple[str, ...]
    peak_mb: int
    longest_s: float
    seconds: float


def work_of(name: str, seed: int) -> Callable[[int], Told]:
    """What does a case of a kind by its number.

    Parameters
    ----------
    name : str
        Of the kind.
    seed : int
        Of the campaign.

    Returns
    -------
    callable
    """
    maker = KINDS[name].maker

    def work(number: int) -> Told:
        rng = rng_of(seed, name, number)
        return _asked(number, rng) if maker is None else run_case(number, maker(rng))

    return work


def _asked(number: int, rng: random.Random) -> Told:
    """Ask the explorer; the code is 0 for an answer, 2 for a refusal."""
    scope, body = explorer.request(rng)
    begun = time.process_time()
    try:
        status, wrong = explorer.answer(scope, body)
    except Exception as error:  # the server would answer 500
        status, wrong = 500, f"traceback: {type(error).__name__}: {str(error)[:160]}"
    code = 0 if status < 400 else 2
    return Told(number, code, wrong, 0, time.process_time() - begun)


def campaign(names: list[str], count: int | None, seed: int, *, first: int = 0) -> Iterator[Result]:
    """Run cases kind by kind.

    Parameters
    ----------
    names : list of str
        Kinds.
    count : int or None
        Cases of each kind; None for those of a whole campaign.
    seed : int
        Of the cases that are drawn.
    first : int
        Number of the first case.

    Yields
    ------
    Result
    """
    _warm()
    for name in names:
        kind = KINDS[name]
        begun = time.monotonic()
        told = list(in_processes(range(first, first + (count or kind.cases)), work_of(name, seed)))
        yield Result(
            name,
            kind,
            len(told),
            sum(one.code == 0 for one in told),
            sum(one.code == 2 for one in told),
            sum(one.code == 1 for one in told),
            tuple(f"{name} {one.number}: {one.wrong}" for one in told if one.wrong is not None),
            max(one.peak_mb for one in told),
            max(one.seconds for one in told),
            time.monotonic() - begun,
        )


def _warm() -> None:
    """Import what cases need before processes are forked, and switch off what leaves them."""
    import webbrowser

    import uvicorn

    def no_browser(*args: object, **options: object) -> bool:
        return True

    def no_server(self: uvicorn.Server, sockets: object = None) -> None:
        return None

    webbrowser.open = no_browser
    uvicorn.Server.run = no_server  # type: ignore[method-assign]  # nothing is served
    for arguments in _EVERY_IMPORT:
        run_case(-1, Case(arguments, {"log.csv": tables.example_log()}))


_EVERY_IMPORT: tuple[tuple[str, ...], ...] = (
    ("analyse", "atlantiksolar-as2", "--plot", "out.svg", "--csv", "out.csv"),
    ("analyse", "atlantiksolar-as2", "--weather", "colorado-2023", "--json"),
    ("size", "atlantiksolar-design", "-m", "rafz-july"),
    ("map", "atlantiksolar-as2", *("--latitudes", "0:60:60", "--days", "1:100:99"), "--json"),
    ("sweep", "atlantiksolar-design", "--vary", "battery_mass_kg=1:3:1", "--out", "out.nc"),
    ("uncertainty", "atlantiksolar-design", "--samples", "64", "--json"),
    ("ceiling", "atlantiksolar-as2", "--step", "5000"),
    ("verify", "atlantiksolar-as2", "log.csv"),
    ("list",),
)
