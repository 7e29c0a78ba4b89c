"""What a user waits for: start-up and whole commands, each in a fresh process.

Processor time counts the workers that a command starts. Beside it stand its two parts that no
command can do without: the computing alone, in this process and warm, and the imports alone, all
modules that the command had imported at its end, in a process that does nothing else.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.measuring import best_time_s, row
from missions.library import load_mission
from sizing.day.light import SolarModel
from sizing.library import load_aircraft

_AS2, _DESIGN, _MISSION = "atlantiksolar-as2", "atlantiksolar-design", "rafz-july"
_FULL = ("--latitudes", "-90:90:1", "--days", "1:365:1")
_RESIZED = ("--latitudes", "-70:70:10", "--days", "1:365:15")
_VARIED = ("wingspan_m=3:8:0.5", "battery_mass_kg=1:8:0.5")
_SHORT_S = 2.0  # processes below this are started more often


@dataclass(frozen=True)
class Command:
    """A call of ``solar-uav``, and what it computes."""

    arguments: tuple[str, ...]
    computing: Callable[[], Any] | None = None

    @property
    def text(self) -> str:
        """As it is typed."""
        return " ".join(("solar-uav", *self.arguments))


def start_up() -> list[dict[str, Any]]:
    """Short commands, and the import of NumPy as a measure of the machine."""
    numpy = _least([sys.executable, "-c", "import numpy"])
    commands = (
        Command(("--help",)),
        Command(("list",)),
        Command(("analyse", _AS2), _analysis),
        Command(("size", _DESIGN, "-m", _MISSION), _sizing),
    )
    return [
        row("start-up", "python -c 'import numpy'", numpy.processor_s, None, None)
        | {"wall_s": numpy.wall_s},
        *(_command_row("start-up", command) for command in commands),
    ]


def whole_commands() -> list[dict[str, Any]]:
    """Commands that compute for long or draw."""
    design = ("sweep", _DESIGN, "--vary", _VARIED[0], "--vary", _VARIED[1])
    resized = ("map", _DESIGN, "--resize", "min_wingspan", *_RESIZED, "--plot", "resized.png")
    commands = (
        Command(("map", _AS2, "--plot", "season.png"), _map(71, np.arange(1, 366, 4), 70.0)),
        Command(("map", _AS2, *_FULL), _map(181, np.arange(1, 366), 90.0)),
        Command(("map", _AS2, *_FULL, "--out", "map.nc"), _map(181, np.arange(1, 366), 90.0)),
        Command(
            ("map", _AS2, *_FULL, "--out", "map.nc", "--plot", "map.png"),
            _map(181, np.arange(1, 366), 90.0),
        ),
        Command(resized, _resized_map),
        Command((*design, "--plot", "chart.png"), _sweep),
        Command(("report", _AS2, "--out", "report.html")),
    )
    return [_command_row("whole command", command) for command in commands]


# ---- What the commands compute, without anything around it


def _analysis() -> Any:
    from sizing.results.analysis import analyse

    return analyse(load_aircraft(_AS2), load_mission(_MISSION))


def _sizing() -> Any:
    from sizing import size

    return size(load_aircraft(_DESIGN), load_mission(_MISSION))


def _map(count: int, days: Any, most_deg: float) -> Callable[[], Any]:
    def work() -> Any:
        from studies.maps.study import prepare

        aircraft, mission = load_aircraft(_AS2), load_mission(_MISSION)
        latitudes = np.linspace(-most_deg, most_deg, count)
        return _computed(prepare(aircraft, mission, latitudes, days, SolarModel()).job)

    return work


def _resized_map() -> Any:
    from studies.maps.study import prepare

    grid = np.linspace(-70.0, 70.0, 15), np.arange(1, 366, 15)
    aircraft, mission = load_aircraft(_DESIGN), load_mission(_MISSION)
    return _computed(prepare(aircraft, mission, *grid, SolarModel(), objective="min_wingspan").job)


def _sweep() -> Any:
    from studies.sweeps.axes import parse_axis
    from studies.sweeps.study import prepare

    axes = tuple(map(parse_axis, _VARIED))
    aircraft, mission = load_aircraft(_DESIGN), load_mission(_MISSION)
    return _computed(prepare(aircraft, mission, axes, SolarModel()).job)


def _computed(job: Any) -> Any:
    from studies.engine.run import run
    from studies.engine.workers import Pool

    return run(job, Pool(1))


# ---- Measuring processes


class _Spent(NamedTuple):
    processor_s: float
    wall_s: float


def _run(call: Sequence[str], folder: str) -> _Spent:
    """Times of a process and of all that it waited for."""
    before, begun = _children_s(), time.perf_counter()
    subprocess.run(call, cwd=folder, capture_output=True, check=True, env=_environment())
    return _Spent(_children_s() - before, time.perf_counter() - begun)


def _children_s() -> float:
    """Processor time of all processes that this one waited for [s]."""
    import resource  # not on Windows

    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _environment() -> dict[str, str]:
    """Packages from where this process has them; one thread a process."""
    root = str(Path(__file__).parents[1])
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    return {**os.environ, **one, "PYTHONPATH": root, "MPLBACKEND": "agg"}


def _least(call: Sequence[str]) -> _Spent:
    """Least times of several processes, fewer of those that take long."""
    with tempfile.TemporaryDirectory() as folder:
        found = [_run(call, folder)]
        for _ in range(4 if found[0].wall_s < _SHORT_S else 2):
            found.append(_run(call, folder))
    return _Spent(min(s.processor_s for s in found), min(s.wall_s for s in found))


# Runs the command, and writes down which modules it had imported at its end.
_LISTED = """
import atexit, json, sys
def told(modules=sys.modules):
    names = [name for name, module in modules.items() if module is not None]
    with open("modules.json", "w") as file:
        json.dump(names, file)
atexit.register(told)
from studies.cli.start import start
sys.argv = ["solar-uav", *sys.argv[1:]]
start()
"""
_IMPORTED = """
import sys
for name in sys.argv[1:]:
    try:
        __import__(name)
    except ImportError:
        pass
"""


def modules_of(arguments: Sequence[str]) -> list[str]:
    """Modules that a command has imported at its end, in the order in which it asked for them."""
    with tempfile.TemporaryDirectory() as folder:
        _run([sys.executable, "-c", _LISTED, *arguments], folder)
        names = json.loads(Path(folder, "modules.json").read_text())
    return [name for name in names if name not in ("__main__", "__mp_main__")]


def _command_row(name: str, command: Command) -> dict[str, Any]:
    spent = _least([sys.executable, "-m", "studies.cli", *command.arguments])
    modules = modules_of(command.arguments)
    imports = _least([sys.executable, "-c", _IMPORTED, *modules])
    computing_s = None
    if command.computing is not None:
        with contextlib.redirect_stdout(None):
            computing_s = best_time_s(command.computing, 3)
    return row(name, command.text, spent.processor_s, None, None) | {
        "wall_s": spent.wall_s,
        "modules": len(modules),
        "imports_s": imports.processor_s,
        "computing_s": computing_s,
    }
