"""What every command answers, recorded on one state of the code and compared with another.

``python -m benchmarks.records record FOLDER`` runs the command line of the tree it is started in,
in two processes: two full maps, a re-optimised map, sweeps, three hundred random sizings,
reliability, survival, uncertainty, a year of weather, every command with
``--json`` and as text for all shipped aircraft, the help of every command, and figures.
``python -m benchmarks.records compare OLD NEW`` holds two such folders against each other: maps to
the last bit, optima to a relative difference of 1e-6, verdicts and exit codes exactly, figures by
their pixels; keys and texts that came, went or differ are listed. For changes that may not change
a number.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import click
import numpy as np

_RTOL = 1e-6  # optima are solved to about 1e-8; their ways there may differ in rounding
_MEASURED = ("atlantiksolar-as2", "sky-sailor-2008", "solong")
_DESIGNS = ("atlantiksolar-design", "sky-sailor")
_OBJECTIVES = ("max_excess_time", "min_wingspan", "min_mass", "max_payload_mass")
_RANGES = ("longest_season", "widest_latitude_band")
_RANDOM_SIZINGS = 300
_IGNORED = ("time_s", "iterations", "solves", "version", "message", "created")

Commands = dict[str, list[str]]


def recorded_commands() -> Commands:
    """Arguments of every recorded run by its name; ``{out}`` stands for a file of that name."""
    commands: Commands = {
        "map-as2.nc": ["map", "atlantiksolar-as2", "--latitudes", "-90:90:1", "--days", "1:365:1"],
        "map-design.nc": [
            *("map", "atlantiksolar-design", "--latitudes", "-90:90:1", "--days", "1:365:1"),
            *("--set", "mission.turbulence.thermal=0.1", "--correction", "report"),
        ],
        "map-resized.nc": [
            *("map", "atlantiksolar-design", "--resize", "min_wingspan", "--workers", "1"),
            *("--latitudes", "-70:70:10", "--days", "1:365:15"),
        ],
        "reproduce-report": ["reproduce-report"],
        "sweep": [
            *("sweep", "atlantiksolar-design", "--workers", "1"),
            *("--vary", "wingspan_m=3:8:1", "--vary", "battery_mass_kg=1:8:1"),
        ],
        "sweep-sized": [
            *("sweep", "atlantiksolar-design", "--workers", "1", "--resize", "min_mass"),
            *("--vary", "battery.specific_energy_wh_per_kg=200:350:25"),
        ],
    }
    for aircraft in (*_MEASURED, *_DESIGNS):
        commands |= _of_aircraft(aircraft)
    for aircraft in _DESIGNS:
        commands |= _of_design(aircraft)
    commands |= _with_weather_and_chance()
    commands |= {f"random-{seed:03d}": _random_sizing(seed) for seed in range(_RANDOM_SIZINGS)}
    return commands


def _of_aircraft(aircraft: str) -> Commands:
    """Analyses by all models, ceiling, comparison, season and figures of an aircraft."""
    commands: Commands = {}
    for model in ("CDM", "CAM", "VM", "FM"):
        mission = ["-m", "rafz-loiter"] if model in ("VM", "FM") else []
        for correction in ("none", "report"):
            commands[f"analyse-{aircraft}-{model}-{correction}"] = [
                *("analyse", aircraft, *mission),
                *("--model", model, "--correction", correction),
            ]
    return commands | {
        f"analyse-{aircraft}-81h": ["analyse", aircraft, "-m", "rafz-81h"],
        f"analyse-{aircraft}-place": ["analyse", aircraft, "--latitude", "35", "--date", "10-15"],
        f"analyse-{aircraft}-climb": [
            "analyse",
            aircraft,
            "--set",
            "mission.climb={ceiling_m: 2000}",
        ],
        f"analyse-{aircraft}-figure.png": ["analyse", aircraft],
        f"ceiling-{aircraft}": ["ceiling", aircraft],
        f"compare-{aircraft}": ["compare", aircraft, "--models", "CDM,CAM"],
        f"compare-{aircraft}-figure.png": ["compare", aircraft, "--models", "CDM,CAM"],
        f"map-{aircraft}-figure.png": [
            *("map", aircraft, "--latitudes", "-60:60:20", "--days", "1:365:28"),
        ],
        f"show-{aircraft}": ["show", aircraft],
    }


def _of_design(aircraft: str) -> Commands:
    """Sizings by all objectives, with sensitivities and cross-check."""
    commands: Commands = {}
    for objective in (*_OBJECTIVES, *_RANGES):
        commands[f"size-{aircraft}-{objective}"] = [
            *("size", aircraft, "-m", "central-europe-summer", "--objective", objective),
            *("--required-excess-time", "1"),
            *([] if objective in _RANGES else ["--sensitivities", "--cross-check"]),
        ]
    commands[f"size-{aircraft}-infeasible"] = [
        *("size", aircraft, "-m", "central-europe-summer", "--required-excess-time", "14"),
    ]
    return commands


def _with_weather_and_chance() -> Commands:
    """Weather records, uncertainty, sizings that survive both."""
    design, weather = "atlantiksolar-design", ["--weather", "colorado-2023"]
    return {
        "weather-year": ["analyse", "atlantiksolar-as2", *weather],
        "uncertainty": ["uncertainty", design, "-m", "rafz-july"],
        "uncertainty-figure.png": ["uncertainty", design, "-m", "rafz-july"],
        "reliability": [
            *("size", design, "-m", "rafz-july", "--objective", "min_mass"),
            *("--required-excess-time", "3", "--reliability", "0.9"),
        ],
        "survival": [
            *("size", design, "-m", "central-europe-summer", "--objective", "min_wingspan"),
            *(*weather, "--survive", "0.8"),
        ],
    }


def _random_sizing(seed: int) -> list[str]:
    """A sizing drawn from its seed: place, dates, air, technology, bounds and objective."""
    rng = np.random.default_rng(seed)
    south = round(float(rng.uniform(-55.0, 55.0)), 2)
    month = int(rng.integers(1, 13))
    later = (month + int(rng.integers(0, 4)) - 1) % 12 + 1
    dates = f"{{from: {month:02d}-05, to: {later:02d}-25}}"
    if rng.random() < 0.4:
        dates = f"{{on: {month:02d}-15}}"
    latitudes = f"{{from_deg: {south}, to_deg: {south + 5.0}, count: 3}}"
    values = {
        "mission.latitude_deg": latitudes if rng.random() < 0.5 else south,
        "mission.dates": dates,
        "mission.altitude_m": round(float(rng.uniform(0.0, 4000.0))),
        "mission.clearness": round(float(rng.uniform(0.7, 1.0)), 3),
        "mission.turbulence.thermal": float(rng.choice([0.0, 0.2])),
        "mission.wind_m_per_s": float(rng.choice([0.0, 5.0, 9.0])),
        "battery.specific_energy_wh_per_kg": round(float(rng.uniform(180.0, 450.0)), 1),
        "modules.efficiency_stc": round(float(rng.uniform(0.17, 0.3)), 4),
        "power.avionics_w": round(float(rng.uniform(1.0, 12.0)), 2),
    }
    aircraft = str(rng.choice(_DESIGNS))
    arguments = ["size", aircraft, "-m", "central-europe-summer"]
    arguments += ["--objective", str(rng.choice(_OBJECTIVES))]
    arguments += ["--required-excess-time", str(rng.choice([0.0, 1.0, 3.0, 6.0, 10.0]))]
    for key, value in values.items():
        arguments += ["--set", f"{key}={value}"]
    return arguments


@click.group()
def main() -> None:
    """Record what every command answers, or compare two such records."""


@main.command()
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path))
def record(folder: Path) -> None:
    """Run every command and keep its answer in FOLDER."""
    folder = folder.absolute()
    folder.mkdir(parents=True, exist_ok=True)
    tasks = [(folder, name, arguments) for name, arguments in recorded_commands().items()]
    with ProcessPoolExecutor(2) as pool:
        for name, code in pool.map(_keep_answer, tasks, chunksize=4):
            click.echo(f"{name}: exit code {code}")
    _keep_help(folder)


def _keep_answer(task: tuple[Path, str, list[str]]) -> tuple[str, int]:
    """Run a command as text and with ``--json``, and keep both with its file, if it writes one."""
    folder, name, arguments = task
    option = {".nc": "--out", ".png": "--plot"}.get(Path(name).suffix)
    written = [] if option is None else [option, str(folder / name)]
    code, out, errors = _run([*arguments, *written])
    answer = {"arguments": arguments, "exit_code": code, "text": out, "errors": errors}
    answer["result"] = None
    if arguments[0] != "show" and option != "--plot":
        _, out, _ = _run([*arguments, "--json"])
        answer["result"] = json.loads(out) if out else None
    (folder / f"{name}.json").write_text(json.dumps(answer, indent=1), encoding="utf-8")
    return name, code


def _run(arguments: list[str]) -> tuple[int, str, str]:
    """Exit code and both outputs of the command, run in this process at 80 columns."""
    from studies.cli import __main__ as command

    os.environ["COLUMNS"] = "80"
    out, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        try:
            code = command.cli.main(arguments, prog_name="solar-uav", standalone_mode=False) or 0
        except SystemExit as end:
            code = int(end.code or 0)
        except Exception as error:
            code, _ = 99, errors.write(f"{type(error).__name__}: {error}")
    return code, out.getvalue(), errors.getvalue()


def _keep_help(folder: Path) -> None:
    from studies.cli.__main__ import cli

    names = cli.list_commands(click.Context(cli))
    texts = {name: _run([name, "--help"])[1] for name in names}
    (folder / "help.json").write_text(json.dumps(texts, indent=1), encoding="utf-8")


@main.command()
@click.argument("old", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.argument("new", type=click.Path(exists=True, file_okay=False, path_type=Path))
def compare(old: Path, new: Path) -> None:
    """Print every difference between two records; exit code 1 if a number or a verdict differs."""
    differences = [*_map_differences(old, new), *_figure_differences(old, new)]
    keys: set[str] = set()
    texts: list[str] = []
    for path in sorted(old.glob("*.json")):
        before, after = (json.loads((folder / path.name).read_text()) for folder in (old, new))
        for place, text, is_key in _json_differences(before, after, ""):
            if is_key:
                keys.add(f"{path.stem.split('-')[0]}: {text}")
            elif place.startswith((".text", ".errors")) or path.stem == "help":
                texts.append(f"{path.stem}{place}")
            elif not place.startswith(".arguments"):
                differences.append(f"{path.stem}{place}: {text}")
    for line in sorted(keys):
        click.echo(f"key {line}")
    for line in (*(f"text {name} differs" for name in texts), *differences):
        click.echo(line)
    click.echo(
        f"{len(differences)} differences in values and figures, {len(keys)} in keys, "
        f"{len(texts)} in texts"
    )
    sys.exit(1 if differences else 0)


def _map_differences(old: Path, new: Path) -> Iterator[str]:
    import xarray as xr

    for path in sorted(old.glob("*.nc")):
        with xr.open_dataset(path) as before, xr.open_dataset(new / path.name) as after:
            for name in sorted(map(str, set(before.variables) | set(after.variables))):
                if name not in before.variables or name not in after.variables:
                    yield f"{path.name}: {name} is in one of them only"
                    continue
                one, two = before[name].to_numpy(), after[name].to_numpy()
                numeric = one.dtype.kind == two.dtype.kind == "f"
                if np.array_equal(one, two, equal_nan=numeric):
                    continue
                at_most = np.nanmax(np.abs(one - two)) if numeric else "not numbers"
                yield f"{path.name}: {name} differs in {np.sum(one != two)} cells, by {at_most}"


def _figure_differences(old: Path, new: Path) -> Iterator[str]:
    from matplotlib.image import imread

    for path in sorted(old.glob("*.png")):
        one, two = imread(path), imread(new / path.name)
        if one.shape != two.shape or not np.array_equal(one, two):
            yield f"{path.name}: the figures differ"


def _json_differences(old: Any, new: Any, place: str) -> Iterator[tuple[str, str, bool]]:
    """Places where two records differ: path, what differs, and whether it is a key."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            if key in _IGNORED:
                continue
            if key not in old or key not in new:
                where = "came" if key in new else "went"
                yield f"{place}.{key}", f"{place}.{key} {where}", True
            else:
                yield from _json_differences(old[key], new[key], f"{place}.{key}")
    elif isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            yield place, f"{len(old)} entries before, {len(new)} now", False
        for one, two in zip(old, new, strict=False):
            yield from _json_differences(one, two, f"{place}[]")
    elif isinstance(old, float) and isinstance(new, (int, float)):
        if not math.isclose(old, new, rel_tol=_RTOL, abs_tol=1e-9):
            yield place, f"{old!r} before, {new!r} now", False
    elif old != new:
        yield place, f"{old!r} before, {new!r} now", False


if __name__ == "__main__":
    main()
