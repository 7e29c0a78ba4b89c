"""Kept chunks that are cut, changed, swapped or made up; their clock; two runs at once."""

from __future__ import annotations

import functools
import hashlib
import io
import os
import random
import shutil
import signal
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.reliability.faults.kept import MAP, SWEEP, Fault, Work
from benchmarks.reliability.faults.processes import trouble
from missions.library import load_mission
from sizing.library import load_aircraft
from sizing.optimisation.objectives import Objective
from sizing.sunlight import SolarModel
from studies.engine import run as engine
from studies.engine.chunk_store import ChunkStore
from studies.engine.run import Outcome
from studies.engine.workers import Job, LocalPool
from studies.grid import GridStudy
from studies.maps import feasibility, resized

__all__ = ["faults"]

Damage = Callable[[bytes, random.Random], bytes]

_NUMBERS = (np.nan, np.inf, -np.inf, 1e300, -1.0, 0.0)
_TEXTS = ("\x1b[31m", "x" * 1000, "=cmd|'/c calc'!A1", "CAM: nothing 1 not 0 to 0")


def faults() -> Iterator[Fault]:
    """Kinds of damage; the first two compute in this process."""
    kinds: dict[str, Damage] = {
        "cut off": lambda data, rng: data[: rng.randrange(len(data))],
        "bits flipped": _flipped,
        "bytes in the middle lost or repeated": _shifted,
        "another's content": lambda data, rng: rng.randbytes(rng.randrange(2000)),
    }
    for name, damage in kinds.items():
        yield Fault("kept chunks of a map", name, 500, functools.partial(_damaged, damage))
    yield Fault("kept chunks of a map", "other content, right checksum", 500, _made_up)
    for work in (MAP, SWEEP):
        clock = functools.partial(_clock, work)
        yield Fault(work.name, "clock set back or forward while it was stopped", 3, clock)
    yield Fault(MAP.name, "clock that jumps while it runs", 4, _jumps)
    yield Fault(MAP.name, "two runs on one output", 8, _two)


# ---- Damage to chunks, in this process


@functools.cache
def _study(sized: bool) -> GridStudy:
    """Return a map of a few short chunks."""
    from studies import grid

    before, grid._CHUNK_S = grid._CHUNK_S, 1e-4
    try:
        mission = load_mission("rafz-july")
        days = [1, 91, 182]
        if not sized:
            latitudes = [-90.0, 0.0, 47.0, 90.0]
            aircraft = load_aircraft("atlantiksolar-as2")
            return feasibility.prepare(aircraft, mission, latitudes, days, SolarModel())
        aircraft = load_aircraft("atlantiksolar-design")
        some = [0.0, 60.0]
        return resized.prepare(aircraft, mission, Objective.min_mass, some, days, SolarModel())
    finally:
        grid._CHUNK_S = before


def _computed(job: Job, folder: Path) -> Outcome:
    with ChunkStore(folder).opened() as store:
        return engine.run(job, LocalPool(1), store)


@functools.cache
def _whole(sized: bool) -> tuple[Outcome, dict[str, bytes]]:
    """Result undisturbed, and the chunks that were kept of it."""
    with tempfile.TemporaryDirectory() as name:
        outcome = _computed(_study(sized).job, Path(name))
        return outcome, {path.name: path.read_bytes() for path in Path(name).glob("*.part")}


def _flipped(data: bytes, rng: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 10))):
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _shifted(data: bytes, rng: random.Random) -> bytes:
    begin = rng.randrange(len(data))
    end = min(begin + rng.choice((1, 8, 64, 512)), len(data))
    return data[:begin] + data[end:] if rng.random() < 0.5 else data[:end] + data[begin:]


def _damaged(damage: Damage, rng: random.Random, folder: Path) -> str | None:
    """Damage some chunks, and go on: they are computed again, the others not."""
    sized = rng.random() < 0.05
    whole, parts = _whole(sized)
    broken = 0
    hit = rng.sample(sorted(parts), rng.randint(1, 3))
    for name, data in parts.items():
        content = damage(data, rng) if name in hit else data
        broken += content != data
        (folder / name).write_bytes(content)
    again = _computed(_study(sized).job, folder)
    if again.computed_chunks != broken:
        return f"{again.computed_chunks} chunks computed again, {broken} were damaged"
    return _differing(whole, again)


def _differing(one: Outcome, other: Outcome) -> str | None:
    for name, values in one.columns.items():
        if values.tobytes() != other.columns[name].tobytes():
            return f"another {name}"
    return None


def _made_up(rng: random.Random, folder: Path) -> str | None:
    """Put other content under a right checksum: refused, or taken without a traceback."""
    sized = rng.random() < 0.3
    _, parts = _whole(sized)
    study = _study(sized)
    for name, data in parts.items():
        head, _, body = data.partition(b"\n")
        made_up = _changed_columns(body, rng)
        words = [*head.split(b" ")[:-1], hashlib.sha256(made_up).hexdigest().encode()]
        (folder / name).write_bytes(b" ".join(words) + b"\n" + made_up)
    try:
        outcome = _computed(study.job, folder)
        from studies.maps import results

        gridded = study.gridded(outcome)
        if sized:
            results.designs_record(gridded)
            str(results.designs_table(gridded))
        else:
            results.seasons_record(gridded)
            str(results.seasons_table(gridded))
    except Exception as error:
        return f"{type(error).__name__}: {error}"[:200]
    return None


def _changed_columns(body: bytes, rng: random.Random) -> bytes:
    """Archive with a column that has other values, another kind or length, or is not there."""
    columns: dict[str, Any] = dict(np.load(io.BytesIO(body)))
    for name in rng.sample(sorted(columns), rng.randint(1, 3)):
        values = columns[name]
        way = rng.randrange(6)
        if way == 0:
            del columns[name]
        elif way == 1:
            columns[name] = np.resize(values, rng.choice(((0,), (1, 1), (7,), ())))
        elif way == 2:
            columns[name] = (
                values.astype(rng.choice(("U5", "S3", "c16", "f2", "?")), copy=False)
                if values.dtype.kind != "U"
                else np.zeros(values.shape)
            )
        elif values.dtype.kind == "f":
            columns[name] = np.array([rng.choice(_NUMBERS) for _ in values])
        elif values.dtype.kind == "U":
            texts = [rng.choice(_TEXTS) for _ in np.atleast_1d(values)]
            columns[name] = np.array(texts if values.shape else texts[0])
        else:
            columns[name] = np.array([rng.randint(-128, 127) for _ in values], values.dtype)
    if rng.random() < 0.1:
        columns["more"] = np.zeros(3)
    file = io.BytesIO()
    (np.savez_compressed if rng.random() < 0.2 else np.savez)(file, **columns)
    return file.getvalue()


# ---- The clock, and two runs


def _stopped_half_way(work: Work, rng: random.Random, folder: Path) -> str | None:
    process = work.start(folder, "--workers", "1")
    wanted = rng.randrange(1, work.whole[1])
    process.until(lambda: len(work.parts(folder)) >= wanted)
    process.strike(signal.SIGINT, group=True)
    return trouble(process.end(), {0, 130}, folder)


def _clock(work: Work, rng: random.Random, folder: Path) -> str | None:
    """Give kept files dates before 1980 and after 2100, as a wrong clock does."""
    if (wrong := _stopped_half_way(work, rng, folder)) is not None:
        return wrong
    for path in folder.rglob("*"):
        date = rng.choice((0.0, 1.0, 3e8, 4.2e9, 7e9))
        os.utime(path, (date, date))
    return work.finished(folder, "--workers", rng.choice("12"))


_JUMPS = """\
import random, time
_real, _jump = time.time, [0.0]
def _jumping():
    if random.random() < 0.2:
        _jump[0] = random.choice((0.0, -1e5, -1e9, 1e5, 1e9))
    return _real() + _jump[0]
time.time = _jumping
"""


def _jumps(rng: random.Random, folder: Path) -> str | None:
    """Let the clock jump back and forth in the command; not in its workers."""
    before = f"import random\nrandom.seed({rng.randrange(1000)})\n{_JUMPS}"
    end = MAP.start(folder, "--workers", rng.choice("12"), before=before).end()
    if (wrong := trouble(end, {0}, folder)) is not None:
        return wrong
    same = (folder / MAP.target).read_bytes() == MAP.whole[0]
    return None if same else "another result"


def _two(rng: random.Random, folder: Path) -> str | None:
    """Start the same twice, a moment apart: one is refused in words, or both end well."""
    keep = rng.random() < 0.5
    first = MAP.start(folder, "--workers", "1", keep=keep)
    first.until(lambda: False, rng.uniform(0.0, 1.2 * MAP.whole[2]))
    second = MAP.start(folder, "--workers", "1", keep=keep)
    ends = [first.end(), second.end()]
    for end in ends:
        if (wrong := trouble(end, {0, 1}, folder)) is not None:
            return wrong
        if end.code == 1 and "another run" not in end.err:
            return f"refused for another reason: {end.last!r}"
    if all(end.code for end in ends):
        return "both refused"
    if (folder / MAP.target).read_bytes() != MAP.whole[0]:
        return "another result"
    shutil.rmtree(folder / "w", ignore_errors=True)
    left = sorted(path.name for path in folder.iterdir())
    return None if left == [MAP.target] else f"files {left}"
