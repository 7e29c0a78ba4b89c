"""Cases in processes of their own, with limits: time, memory, and a watch on what hangs."""

from __future__ import annotations

import contextlib
import io
import json
import os
import resource
import select
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.reliability.inputs.cases import Case
from benchmarks.reliability.inputs.judge import Outcome, mistake

__all__ = ["Told", "in_processes", "run_case"]

_LONGEST_S = 10.0  # processor time of a case
_LONGEST_WAIT_S = 90.0  # without any news of a case, whatever it does
_MOST_BYTES = 1_000_000_000
_CASES_A_PROCESS = 400
_SCRATCH = "/dev/shm" if Path("/dev/shm").is_dir() else None  # memory: most of the time else


class Told(NamedTuple):
    """What is told of a case: its number, exit code, what is wrong, and its peak of memory."""

    number: int
    code: int
    wrong: str | None
    peak_mb: int
    seconds: float


class _HangError(BaseException):
    """A case takes too long."""


def in_processes(numbers: Sequence[int], work: Callable[[int], Told]) -> Iterator[Told]:
    """Do cases in forked processes, a few hundred each; one that dies is told and passed over.

    Parameters
    ----------
    numbers : sequence of int
        Numbers of the cases.
    work : callable
        Does a case.

    Yields
    ------
    Told
        Of every case, in order.
    """
    left = list(numbers)
    while left:
        some = left[:_CASES_A_PROCESS]
        done = 0
        for told in _in_process(some, work):
            done += 1
            yield told
        if done < len(some):
            raise RuntimeError("a process ended without a word")  # _in_process tells of each
        left = left[done:]


def _in_process(numbers: Sequence[int], work: Callable[[int], Told]) -> Iterator[Told]:
    at = 0
    while at < len(numbers):
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(reading)
            code = 1
            try:
                _limited()
                with os.fdopen(writing, "w", buffering=1) as out:
                    for number in numbers[at:]:
                        out.write(json.dumps(work(number)) + "\n")
                code = 0
            except BaseException:
                traceback.print_exc()
            finally:
                os._exit(code)
        os.close(writing)
        with os.fdopen(reading, "rb", buffering=0) as pipe:
            waiting = _read(pipe)
            hangs = False
            while True:
                told = next(waiting, None)
                if told is None:
                    break
                if told.number < 0:
                    hangs = True
                    os.kill(child, signal.SIGKILL)
                    break
                at += 1
                yield told
        _, status = os.waitpid(child, 0)
        if at < len(numbers):
            code = os.waitstatus_to_exitcode(status)
            wrong = "hangs" if hangs else f"process ends with exit code {code}"
            yield Told(numbers[at], -1, wrong, 0, _LONGEST_WAIT_S * hangs)
            at += 1


def _read(pipe: Any) -> Iterator[Told]:
    """Lines of a pipe until it ends; where no news come for too long, one with a number below 0."""
    rest = b""
    while select.select([pipe], [], [], _LONGEST_WAIT_S)[0]:
        data = pipe.read(65536)
        if not data:
            return
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            yield Told(*json.loads(line))
    yield Told(-1, -1, None, 0, _LONGEST_WAIT_S)


def _limited() -> None:
    """Limit this process to what it has and a gigabyte more; let time limits be heard."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * os.sysconf("SC_PAGE_SIZE") + _MOST_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGPROF, _hang)
    null = os.open(os.devnull, os.O_RDWR)
    os.dup2(null, 0)


def _hang(signum: int, frame: Any) -> None:
    raise _HangError


def run_case(number: int, case: Case, *, keep: Path | None = None) -> Told:
    """Run a case in this process and judge it.

    Parameters
    ----------
    number : int
        Of the case.
    case : Case
    keep : Path, optional
        Folder to run it in, which is kept; without, one that is removed.

    Returns
    -------
    Told
    """
    folder = Path(tempfile.mkdtemp(prefix="inputs-", dir=_SCRATCH)) if keep is None else keep
    here = Path.cwd()
    _forget_peak()
    begun, start_mb = time.process_time(), _memory_mb("VmRSS")
    try:
        _written(case, folder)
        os.chdir(folder)
        before = {str(p.relative_to(folder)) for p in folder.rglob("*") if not p.is_dir()}
        wrong: str | None
        try:
            outcome = _called(case)
            code, wrong = outcome.code, mistake(case, outcome, before, folder)
        except _HangError:
            code, wrong = -1, f"takes more than {_LONGEST_S:g} s of processor time"
        except BaseException as error:  # whatever comes out of the command is a defect
            code, wrong = -1, _where(error)
    finally:
        os.chdir(here)
        if keep is None:
            shutil.rmtree(folder, ignore_errors=True)
    peak_mb = max(_memory_mb("VmHWM") - start_mb, 0)
    if wrong is None and peak_mb > _MOST_BYTES / 1e6:
        wrong = f"takes {peak_mb} MB of memory"
    return Told(number, code, wrong, peak_mb, time.process_time() - begun)


def _written(case: Case, folder: Path) -> None:
    for name, content in case.files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    for name, target in case.links.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.symlink_to(target)


def _called(case: Case) -> Outcome:
    from studies.cli.__main__ import main

    printed = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True)
    told = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True)
    arguments, environment = sys.argv, dict(os.environ)
    sys.argv = ["solar-uav", *case.arguments]
    os.environ.update(case.environment)
    code: Any = 0
    signal.setitimer(signal.ITIMER_PROF, _LONGEST_S, 1.0)
    try:
        with (
            contextlib.redirect_stdout(printed),
            contextlib.redirect_stderr(told),
            warnings.catch_warnings(),
        ):
            for kind in (RuntimeWarning, UserWarning, FutureWarning):
                warnings.simplefilter("always", kind)
            try:
                main()
            except SystemExit as end:
                code = end.code
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        sys.argv = arguments
        os.environ.clear()
        os.environ.update(environment)
    text = [stream.buffer.getvalue().decode("utf-8") for stream in (printed, told)]
    return Outcome(code if isinstance(code, int) else 0 if code is None else 1, *text)


def _where(error: BaseException) -> str:
    """Error with the innermost place in our own packages, and the place that raised it."""
    places = traceback.extract_tb(error.__traceback__)
    root = str(Path(__file__).parents[3])
    own = [f for f in places if f.filename.startswith(root) and "reliability" not in f.filename]
    shown = [f"{f.filename.removeprefix(root + '/')}:{f.lineno}" for f in own[-1:]]
    text = " ".join(str(error).split())[:160]
    return f"traceback: {type(error).__name__} at {'; '.join(shown)}: {text}"


def _forget_peak() -> None:
    with contextlib.suppress(OSError):  # only to make the peak that of one case
        Path("/proc/self/clear_refs").write_text("5")


def _memory_mb(name: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(name):
            return int(line.split()[1]) // 1024
    return 0
