"""Signals at random moments: to long computations, and to every other command."""

from __future__ import annotations

import atexit
import functools
import random
import signal
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from benchmarks.reliability.faults.kept import MAP, SWEEP, Fault, struck_and_finished
from benchmarks.reliability.faults.processes import Running, own_folder, running, trouble

__all__ = ["arguments", "faults", "undisturbed"]

_EARLY = {-signal.SIGINT, -signal.SIGTERM}  # before the command itself is there, or the second time
_CODES = {
    "SIGKILL": {-signal.SIGKILL},
    "SIGTERM": {143, -signal.SIGTERM},
    "Ctrl-C": {130, -signal.SIGINT},
    "Ctrl-C twice": {130, -signal.SIGINT},
}
_POOLS = {
    "one process": ("--workers", "1"),
    "two worker processes": ("--workers", "2"),
    "a dask cluster of the machine": ("--scheduler", "local-cluster", "--workers", "2"),
}
_LOG = "LOG"  # stands for a flight log, which :func:`arguments` makes
# Commands that are not divided into chunks, and the files that they are asked for.
COMMANDS: dict[str, tuple[str, ...]] = {
    "size": ("size", "atlantiksolar-design", "-m", "rafz-july", "--cross-check", "--out", "d"),
    "fit": ("fit", "atlantiksolar-as2", _LOG, "--out", "d"),
    "sweep without a file": (*SWEEP.arguments, "--workers", "2"),
    "uncertainty": ("uncertainty", "atlantiksolar-as2", "-m", "rafz-july", "--plot", "f.png"),
    "report": ("report", "atlantiksolar-as2", "--out", "r.html"),
    "analyse --weather": (
        *("analyse", "atlantiksolar-as2", "--weather", "colorado-2023", "--csv", "w.csv"),
    ),
    "compare": ("compare", "atlantiksolar-as2", "-m", "rafz-loiter", "--out", "c"),
    "ceiling": ("ceiling", "atlantiksolar-as2", "--csv", "c.csv", "--plot", "c.png"),
    "published": ("published", "--markdown", "p.md"),
    "efficiencies": ("efficiencies", "atlantiksolar-as2", "-m", "rafz-loiter", "--csv", "e.csv"),
    "explore --static": ("explore", "atlantiksolar-as2", "--static", "x.html"),
}


def faults() -> Iterator[Fault]:
    """Kinds of signals."""
    for pool, options in _POOLS.items():
        for name in _CODES:
            work = MAP if name != "SIGTERM" else SWEEP
            if "dask" in pool and name == "Ctrl-C twice":
                continue  # its own processes say goodbye in many lines
            case = struck_and_finished(
                work, functools.partial(_strike, name), _CODES[name], *options
            )
            count = 4 if "dask" in pool else 10
            yield Fault(f"{work.name} by {pool}", f"{name} at a random moment", count, case)
    for name in COMMANDS:
        yield Fault(
            name, "Ctrl-C or SIGTERM at a random moment", 6, functools.partial(_other, name)
        )
    yield Fault("explore", "Ctrl-C or SIGTERM at a random moment", 6, _explore)


def _strike(name: str, process: Running, rng: random.Random) -> None:
    """Send a signal by its name; Ctrl-C reaches all processes, the others mostly the first one."""
    if name == "SIGKILL":
        process.strike(signal.SIGKILL, group=False)
        return
    if name == "SIGTERM":
        process.strike(signal.SIGTERM, group=rng.random() < 0.3)
        return
    process.strike(signal.SIGINT, group=True)
    if name == "Ctrl-C twice":
        process.until(lambda: False, rng.choice((0.0, 0.02, 0.2)))
        process.strike(signal.SIGINT, group=True)


def _other(name: str, rng: random.Random, folder: Path) -> str | None:
    """Strike a command; what it was to write is there as a whole or not at all."""
    whole, took_s = undisturbed(name)
    process = running(folder, *arguments(name))
    process.until(lambda: False, rng.uniform(0.0, took_s))
    attack = rng.choice(("SIGTERM", "Ctrl-C", "Ctrl-C twice"))
    _strike(attack, process, rng)
    end = process.end()
    if (wrong := trouble(end, {0, *_CODES[attack]}, folder)) is not None:
        return f"{attack}: {wrong}"
    if end.code > 0 and len(end.err.strip().splitlines()) != 1:
        return f"{attack}: not one line: {end.err!r}"
    found = _sizes(folder)
    if found and found.keys() != whole.keys():
        return f"{attack}: files {sorted(found)} of {sorted(whole)}"
    # Dates and times of what was computed may differ by a few characters.
    small = [name for name, size in found.items() if size < 0.99 * whole[name] - 8]
    return f"{attack}: cut {small}" if small else None


def arguments(name: str) -> tuple[str, ...]:
    """Arguments of a command."""
    return tuple(_log() if word == _LOG else word for word in COMMANDS[name])


@functools.cache
def _log() -> str:
    """Short synthetic flight log, deleted when the process ends."""
    from missions.library import load_mission
    from sizing.library import load_aircraft
    from studies.fitting.synthetic import Errors, Flight, fly

    place = ExitStack()
    atexit.register(place.close)
    path = place.enter_context(own_folder()) / "flight.csv"
    flight = Flight(seed=5, duration_h=10.0, step_s=300.0, errors=Errors(haze=0.01))
    flown = fly(load_aircraft("atlantiksolar-as2"), load_mission("rafz-28h"), flight)
    flown.table.to_csv(path, index=False)
    return str(path)


@functools.cache
def undisturbed(name: str) -> tuple[dict[str, int], float]:
    """Sizes of the files of a command, and its time [s]."""
    with own_folder() as folder:
        begun = time.monotonic()
        end = running(folder, *arguments(name)).end()
        if end.code not in (0, 1):
            raise RuntimeError(f"{name}: {end.err}")
        return _sizes(folder), time.monotonic() - begun


def _sizes(folder: Path) -> dict[str, int]:
    paths = [path for path in folder.rglob("*") if path.is_file()]
    return {path.relative_to(folder).as_posix(): path.stat().st_size for path in paths}


def _explore(rng: random.Random, folder: Path) -> str | None:
    """Stop the explorer before it serves, while it does, or amid a sizing."""
    process = running(folder, "explore", "atlantiksolar-design", "--no-browser", "--port", "0")
    if rng.random() < 0.5:
        process.until(lambda: b"http" in process.out.read_bytes())
        if rng.random() < 0.7:
            _ask(process.out.read_text().split()[0], rng)
    process.until(lambda: False, rng.uniform(0.0, 1.0))
    attack = rng.choice(("SIGTERM", "Ctrl-C", "Ctrl-C twice"))
    _strike(attack, process, rng)
    wrong = trouble(process.end(30.0), _CODES[attack], folder)
    return None if wrong is None else f"{attack}: {wrong}"


def _ask(address: str, rng: random.Random) -> None:
    """Ask for a sizing, and do not wait for the answer."""
    import socket
    import urllib.parse

    place = urllib.parse.urlsplit(address)
    token = urllib.parse.parse_qs(place.query)["token"][0]
    body = b'{"objective": "min_wingspan"}'
    head = (
        f"POST /api/size HTTP/1.1\r\nHost: {place.netloc}\r\nOrigin: http://{place.netloc}\r\n"
        f"Authorization: Bearer {token}\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(body)}\r\n\r\n"
    )
    with socket.create_connection((str(place.hostname), int(place.port or 0)), 5.0) as connection:
        connection.sendall(head.encode() + body)
        time.sleep(rng.uniform(0.0, 0.5))
