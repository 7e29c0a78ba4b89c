"""Disks that are full or read-only, folders that vanish, small files alone: nothing half-written.

Small disks are mounted, which takes the rights of the administrator; without them these are left
out.
"""

from __future__ import annotations

import contextlib
import functools
import os
import random
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from benchmarks.reliability.faults.kept import MAP, SWEEP, Fault, Work
from benchmarks.reliability.faults.processes import running, trouble
from benchmarks.reliability.faults.stops import arguments, undisturbed

__all__ = ["faults"]

_LIMIT = """\
import resource, signal
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, ({bytes}, {bytes}))
"""
_WRITING = ("size", "uncertainty", "report", "analyse --weather", "ceiling", "published")


def faults() -> Iterator[Fault]:
    """Kinds of places."""
    if _may_mount():
        for work in (MAP, SWEEP):
            yield Fault(work.name, "disk that fills up", 5, functools.partial(_full, work))
            yield Fault(work.name, "read-only disk", 2, functools.partial(_read_only, work))
        for name in _WRITING:
            full = functools.partial(_full_for, name)
            yield Fault(name, "disks full or nearly so", 4, full)
    yield Fault(MAP.name, "files limited to a few kilobytes", 4, _limited)
    yield Fault(MAP.name, "folder of another user", 3, _others)
    for what in ("kept chunks", "everything"):
        gone = functools.partial(_removed, what)
        yield Fault(MAP.name, f"folder of {what} removed while it runs", 5, gone)
    for name in _WRITING[:4]:
        yield Fault(
            name, "folder removed while it runs", 3, functools.partial(_removed_under, name)
        )
    yield Fault("every command", "standard output full or closed", 10, _no_output)


@functools.cache
def _may_mount() -> bool:
    done = subprocess.run(
        ["unshare", "-m", "mount", "-t", "tmpfs", "tmpfs", "/mnt"], capture_output=True, check=False
    )
    return done.returncode == 0


@contextmanager
def _disk(folder: Path, kilobytes: int) -> Iterator[None]:
    """Mount an empty disk of some size at a folder."""
    size = f"size={kilobytes}k"
    subprocess.run(["mount", "-t", "tmpfs", "-o", size, "tmpfs", str(folder)], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def _full(work: Work, rng: random.Random, folder: Path) -> str | None:
    """Fill the disk after some chunks; with room again the work goes on."""
    whole, chunks, _ = work.whole
    with _disk(folder, 8192):
        process = work.start(folder, "--workers", rng.choice("12"))
        wanted = rng.randrange(0, chunks)
        process.until(lambda: len(work.parts(folder)) >= wanted)
        ballast = folder / "ballast"
        with contextlib.suppress(OSError), ballast.open("wb", buffering=0) as file:
            while True:
                file.write(bytes(512))
        end = process.end()
        if (wrong := trouble(end, {0, 1}, folder)) is not None:
            return wrong
        if end.code and not any(word in end.err for word in ("no space left", "not enough room")):
            return f"no word of the disk: {end.last!r}"
        target = folder / work.target
        if target.exists() and target.read_bytes() != whole:
            return "half a result"
        ballast.unlink()
        return work.finished(folder, "--workers", "1")


def _read_only(work: Work, rng: random.Random, folder: Path) -> str | None:
    """Make the disk read-only before or after some chunks."""
    with _disk(folder, 8192):
        process = None
        if rng.random() < 0.5:
            process = work.start(folder, "--workers", "1")
            process.until(lambda: bool(work.parts(folder)))
        subprocess.run(["mount", "-o", "remount,ro", str(folder)], check=False, capture_output=True)
        end = (process or work.start(folder, "--workers", "1")).end()
        subprocess.run(["mount", "-o", "remount,rw", str(folder)], check=True)
        if (wrong := trouble(end, {0, 1}, folder)) is not None:
            return wrong
        return work.finished(folder, "--workers", "1")


def _full_for(name: str, rng: random.Random, folder: Path) -> str | None:
    """Let a command write to a small disk: its files as a whole, or none and a word on the disk."""
    whole, _ = undisturbed(name)
    total = max(sum(whole.values()) // 1024, 8)
    temporary = folder.parent / "tmp"
    temporary.mkdir()
    with _disk(folder, rng.randint(4, max(2 * total, 8))), _disk(temporary, rng.choice((4, 64))):
        end = running(folder, *arguments(name), environment={"TMPDIR": str(temporary)}).end()
        if (wrong := trouble(end, {0, 1}, folder)) is not None:
            return wrong
        found = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
        if found not in (set(), set(whole)):
            return f"files {sorted(found)} of {sorted(whole)}"
        if not found and "no space left" not in end.err:
            return f"no word of the disk: {end.last!r}"
        return None if found or end.code == 1 else "nothing written, exit code 0"


def _limited(rng: random.Random, folder: Path) -> str | None:
    """Limit the size of files, as a quota does."""
    before = _LIMIT.format(bytes=rng.choice((100, 1000, 3000, 8000)))
    end = MAP.start(folder, "--workers", "1", before=before).end()
    if (wrong := trouble(end, {0, 1}, folder)) is not None:
        return wrong
    return MAP.finished(folder, "--workers", "1")


def _others(rng: random.Random, folder: Path) -> str | None:
    """Run as a user who may not write to the folder."""
    if os.geteuid() != 0:
        folder.chmod(0o555)
        by: tuple[str, ...] = ()
    else:
        folder.parent.chmod(0o755)
        by = ("setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups")
    end = running(folder, *MAP.command("--workers", rng.choice("12")), by=by).end()
    if (wrong := trouble(end, {1}, folder)) is not None:
        return wrong
    if "permission denied" not in end.err:
        return f"no word of the permission: {end.last!r}"
    return f"files {[path.name for path in folder.iterdir()]}" if any(folder.iterdir()) else None


def _removed(what: str, rng: random.Random, folder: Path) -> str | None:
    """Remove the folder of the chunks, or that in which the command runs."""
    _, chunks, took_s = MAP.whole
    process = MAP.start(folder, "--workers", rng.choice("12"))
    wanted = rng.randrange(0, chunks + 1)
    process.until(lambda: len(MAP.parts(folder)) >= wanted, 2.0 * took_s)
    shutil.rmtree(folder / "w" if what == "kept chunks" else folder, ignore_errors=True)
    end = process.end()
    folder.mkdir(exist_ok=True)
    if (wrong := trouble(end, {0, 1}, folder)) is not None:
        return wrong
    target = folder / MAP.target
    if target.exists() and target.read_bytes() != MAP.whole[0]:
        return "half a result"
    return MAP.finished(folder, "--workers", "1")


def _removed_under(name: str, rng: random.Random, folder: Path) -> str | None:
    """Remove the folder in which a command runs."""
    _, took_s = undisturbed(name)
    process = running(folder, *arguments(name))
    process.until(lambda: False, rng.uniform(0.0, took_s))
    shutil.rmtree(folder, ignore_errors=True)
    return trouble(process.end(), {0, 1, 2})


def _no_output(rng: random.Random, folder: Path) -> str | None:
    """Give a command nowhere to print to: it fails in words, or has nothing to say."""
    words = rng.choice(
        (
            ("list",),
            ("analyse", "atlantiksolar-as2"),
            ("analyse", "atlantiksolar-as2", "--json"),
            ("show", "atlantiksolar-as2"),
            ("size", "--help"),
        )
    )
    place = rng.choice(("/dev/full", "&-"))
    redirected = f'exec "$@" > {place}'.replace("> &", ">&")
    # Without a width the output is asked whether it is a terminal.
    process = running(folder, *words, by=("sh", "-c", redirected, "-"), environment={"COLUMNS": ""})
    return trouble(process.end(), {0, 1} if place == "&-" else {1}, folder)
