"""Chunk functions for the tests of the engine, importable by worker processes."""

import os
import signal
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.engine.run import Job

BLANKS = {"root": np.float64("nan"), "number": np.int64(-1), "name": np.str_("")}


@dataclass(frozen=True)
class Settings:
    """What goes wrong where: cells are numbers."""

    scale: float = 1.0
    raising: tuple[int, ...] = ()
    deadly: tuple[int, ...] = ()
    once: str = ""  # a file: who finds none leaves it and dies, others live
    pause_s: float = 0.0
    log: str = ""  # a folder that tells which cells were computed


def work(settings, cells):
    numbers = [int(cell[0]) for cell in cells]
    if settings.log:
        name = f"{numbers[0]}-{len(numbers)}-{os.getpid()}-{threading.get_ident()}-{time.time_ns()}"
        (Path(settings.log) / name).touch()
    if settings.once and 3 in numbers and not Path(settings.once).exists():
        Path(settings.once).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    for number in numbers:
        if number in settings.deadly:
            os._exit(7)
        if number in settings.raising:
            raise ArithmeticError(f"cell {number}\nis bad")
    time.sleep(settings.pause_s)
    values = np.asarray(numbers, float)
    return {
        "root": settings.scale * np.sin(np.sqrt(values)),
        "number": np.asarray(numbers),
        "name": [f"cell {n}" for n in numbers],
    }


def threads(settings, cells):
    """Whether the linear algebra was told to use one thread before NumPy was imported."""
    return {"root": [float(os.environ["OPENBLAS_NUM_THREADS"])] * len(cells)}


def interruptible(settings, cells):
    """Whether Ctrl-C could have reached this process since it began."""
    blocked = signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())
    return {"root": [float(not blocked)] * len(cells)}


def numbered_job(cells=20, each=4, **settings):
    """Return the job of so many cells, in chunks of so many each."""
    numbers = np.arange(cells)
    chunks = np.split(numbers, range(each, cells, each))
    return Job(work, Settings(**settings), numbers[:, np.newaxis] + 0.0, chunks, BLANKS)
