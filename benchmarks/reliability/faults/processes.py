"""Commands in a session of their own, to be stopped in every way, and what they leave behind."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

__all__ = ["Ended", "Running", "ended", "own_folder", "running", "trouble"]

ROOT = Path(__file__).resolve().parents[3]
# As the installed script begins; chunks of so many seconds, so that a short computation has many.
_START = """\
import os, signal
signal.signal(signal.SIGINT, signal.SIG_DFL)
{before}
from studies.cli.start import start
chunk_s = os.environ.get("CHUNK_S")
if chunk_s:
    import studies.grid as grid, studies.sweeps.study as study
    grid._CHUNK_S = study._CHUNK_S = float(chunk_s)
start()
"""
_LONGEST_S = 300.0
_LATE_S = 20.0  # on a machine that does other things as well
_MOST_LINES = 6


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    code: int
    out: str
    err: str
    after_s: float  # the fault
    left: tuple[str, ...]  # processes

    @property
    def last(self) -> str:
        """Last line of standard error."""
        return (self.err.strip().splitlines() or [""])[-1]


@dataclass
class Running:
    """A command that runs."""

    process: subprocess.Popen[bytes]
    out: Path
    err: Path
    struck_s: float = field(default_factory=time.monotonic)

    def strike(self, signum: int, *, group: bool) -> None:
        """Send a signal to the process, or to all processes as a terminal does.

        Parameters
        ----------
        signum : int
            Which.
        group : bool
            Whether to all of them.
        """
        self.struck_s = time.monotonic()
        with contextlib.suppress(ProcessLookupError):
            if group:
                os.killpg(self.process.pid, signum)
            elif self.process.poll() is None:
                self.process.send_signal(signum)

    def until(self, seen: Callable[[], bool], longest_s: float = 60.0) -> None:
        """Wait until something is seen, the time is up, or the command has ended.

        Parameters
        ----------
        seen : callable
            Tells whether it is.
        longest_s : float
            How long to wait at most [s].
        """
        deadline = time.monotonic() + longest_s
        while not seen() and time.monotonic() < deadline and self.process.poll() is None:
            time.sleep(0.005)

    def children(self) -> list[int]:
        """Processes of the command's session without the command itself."""
        return [pid for pid in _session(self.process.pid) if pid != self.process.pid]

    def end(self, longest_s: float = _LONGEST_S) -> Ended:
        """Wait for the end; what hangs is killed, and said to be left.

        Parameters
        ----------
        longest_s : float
            How long to wait at most [s].

        Returns
        -------
        Ended
        """
        hung = []
        try:
            code = self.process.wait(longest_s)
        except subprocess.TimeoutExpired:
            hung = [f"the command itself after {longest_s:.0f} s"]
            self.process.kill()
            code = self.process.wait()
        after_s = time.monotonic() - self.struck_s
        deadline = time.monotonic() + 10.0
        while (left := _session(self.process.pid)) and time.monotonic() < deadline:
            time.sleep(0.01)
        names = [_name(pid) for pid in left]
        for pid in left:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        out, err = (path.read_text(errors="replace") for path in (self.out, self.err))
        return Ended(code, out, err, after_s, (*hung, *names))


@contextmanager
def own_folder() -> Iterator[Path]:
    """Yield an empty folder, which is deleted afterwards."""
    with tempfile.TemporaryDirectory(prefix="faults-", ignore_cleanup_errors=True) as name:
        (Path(name) / "work").mkdir()
        yield Path(name) / "work"


def running(
    folder: Path,
    *arguments: str,
    chunk_s: float | None = None,
    environment: Mapping[str, str] | None = None,
    before: str = "",
    by: Collection[str] = (),
) -> Running:
    """Start ``solar-uav`` in a folder.

    Parameters
    ----------
    folder : Path
        Where it runs; what it says is kept beside the folder.
    *arguments : str
        What follows ``solar-uav``.
    chunk_s : float, optional
        Time of a chunk [s].
    environment : mapping, optional
        Variables that are set besides.
    before : str, optional
        Python that is run first.
    by : collection of str, optional
        Words before the interpreter, such as ``setpriv``.

    Returns
    -------
    Running
    """
    number = sum(1 for _ in folder.parent.glob("*.out"))
    out, err = (folder.parent / f"{number}.{end}" for end in ("out", "err"))
    variables = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "OMP_NUM_THREADS": "1",
        "COLUMNS": "100",
        **({} if chunk_s is None else {"CHUNK_S": str(chunk_s)}),
        **(environment or {}),
    }
    with out.open("wb") as out_file, err.open("wb") as err_file:
        process = subprocess.Popen(
            [*by, sys.executable, "-c", _START.format(before=before), *arguments],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=out_file,
            stderr=err_file,
            env=variables,
            start_new_session=True,
        )
    return Running(process, out, err)


def ended(folder: Path, *arguments: str, chunk_s: float | None = None) -> Ended:
    """Run a command to its end.

    Parameters
    ----------
    folder, *arguments, chunk_s
        As for :func:`running`.

    Returns
    -------
    Ended
    """
    return running(folder, *arguments, chunk_s=chunk_s).end()


def trouble(end: Ended, codes: Collection[int], folder: Path | None = None) -> str | None:
    """Tell what is wrong with the way in which a command ended; None if nothing is.

    Parameters
    ----------
    end : Ended
        How it ended.
    codes : collection of int
        Exit codes that are right.
    folder : Path, optional
        Where no temporary file may lie.

    Returns
    -------
    str or None
    """
    lines = end.err.strip().splitlines()
    if end.code not in codes:
        return f"exit code {end.code}, not {sorted(codes)}: {end.last!r}"
    for word in ("Traceback", "Exception ignored", "Error in atexit", "core dumped"):
        if word in end.err:
            return f"{word}: {end.last!r}"
    if end.code != 0 and len(lines) > _MOST_LINES:
        return f"{len(lines)} lines: {end.last!r}"
    if end.left:
        return f"left: {', '.join(end.left)}"
    if end.after_s > _LATE_S and end.code != 0:
        return f"ended {end.after_s:.0f} s after the fault"
    if folder is not None and folder.is_dir():
        waste = [p.name for p in folder.rglob("*") if p.suffix in (".tmp", ".scratch")]
        if waste:
            return f"temporary files: {waste}"
    return None


def _session(leader: int) -> list[int]:
    """Processes of a session that are not dead."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == leader and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found


def _name(pid: int) -> str:
    try:
        words = Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return str(pid)
    return b" ".join(words)[:100].decode(errors="replace")
