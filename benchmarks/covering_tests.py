"""Which tests execute which line, and running tests in a copy of the project.

Every test file is run once, in a process of its own, with one context of ``coverage`` per test. A
process is forked from one that has loaded the libraries, which saves seconds each time; this module
therefore imports nothing of the project.
"""

from __future__ import annotations

import compileall
import contextlib
import hashlib
import importlib
import json
import multiprocessing
import os
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from py_compile import PycInvalidationMode

import coverage
import pytest

__all__ = ["PACKAGES", "CoveredTests", "copy_of_project", "run_tests", "sources"]

PACKAGES = ("solar", "missions", "sizing")
_LIBRARIES = (
    "casadi",
    "hypothesis",
    "matplotlib.pyplot",
    "pandas",
    "pvlib",
    "pydantic",
    "scipy.interpolate",
    "scipy.optimize",
    "xarray",
)
_HUNG = "hung"


def sources(folder: Path) -> list[Path]:
    """Modules of the packages below a folder, as paths below it."""
    found = (path for name in PACKAGES for path in (folder / name).rglob("*.py"))
    return sorted(path.relative_to(folder) for path in found)


def copy_of_project(project: Path, work: Path) -> Path:
    """Copy a project into a folder of its own, in place of an earlier copy.

    Parameters
    ----------
    project : Path
        Its root.
    work : Path
        Folder for the copy.

    Returns
    -------
    Path
    """
    tree = work / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    shutil.copytree(project, tree, ignore=shutil.ignore_patterns(".*", "__pycache__", "_build"))
    for name in PACKAGES:
        # Otherwise bytecode goes by a time in seconds, and changes come faster.
        mode = PycInvalidationMode.CHECKED_HASH
        compileall.compile_dir(tree / name, quiet=2, invalidation_mode=mode)
    return tree


def run_tests(tree: Path, tests: Iterable[str], seconds: float) -> str | None:
    """Run tests in their order up to the first that fails.

    Parameters
    ----------
    tree : Path
        Copy of the project.
    tests : iterable of str
        Names as pytest takes them.
    seconds : float
        After which they count as hanging.

    Returns
    -------
    str or None
        The test that fails, ``"hung"``, or how the process ended; None if all pass.
    """
    with tempfile.TemporaryDirectory() as folder:
        listed, told = Path(folder) / "tests", Path(folder) / "failed"
        listed.write_text("".join(f"{test}\n" for test in tests), encoding="utf-8")

        def call() -> int:
            arguments = ["-x", "-q", "-p", "no:cacheprovider", f"@{listed}"]
            return int(pytest.main(arguments, plugins=[_Failures(told)]))

        code = _in_child(tree, call, seconds)
        failed = told.read_text(encoding="utf-8") if told.exists() else ""
    if code == 0:
        return None
    return failed or (_HUNG if code is None else f"exit code {code}")


class CoveredTests:
    """Tests of a copy of the project, how long each takes and which lines it executes.

    Parameters
    ----------
    tree : Path
        Copy of the project.
    store : Path
        Folder of what was recorded: of unchanged files it is not recorded again.
    told : callable
        Called with what is recorded.
    """

    def __init__(self, tree: Path, store: Path, told: Callable[[str], None]) -> None:
        self._tree, self._store, self._told = tree, store, told
        store.mkdir(parents=True, exist_ok=True)
        shared = [*(tree / path for path in sources(tree)), *_shared_by_tests(tree)]
        self._shared_key = _digest(shared)
        self._seconds: dict[str, dict[str, float]] = {}
        self._data: dict[str, coverage.CoverageData] = {}

    def record(self, files: Iterable[str]) -> None:
        """Record test files that have not been."""
        for name in files:
            if name not in self._seconds:
                self._record(name, self._tree / name)

    def _record(self, name: str, path: Path) -> None:
        key = hashlib.sha256(f"{name} {self._shared_key} {_digest([path])}".encode()).hexdigest()
        told, data_file = self._store / f"{key}.json", self._store / f"{key}.coverage"
        if not told.exists():
            data_file.unlink(missing_ok=True)
            begun = time.monotonic()
            code = _in_child(self._tree, lambda: _record_here(name, data_file, told), 3600.0)
            if code != 0:
                told.unlink(missing_ok=True)
                raise RuntimeError(f"{name} fails as it is (exit code {code})")
            self._told(f"recorded {name} in {time.monotonic() - begun:.0f} s")
        self._seconds[name] = json.loads(told.read_text(encoding="utf-8"))
        self._data[name] = coverage.CoverageData(str(data_file))
        self._data[name].read()

    def seconds_of(self, tests: Iterable[str]) -> float:
        """How long tests took together, under coverage [s]."""
        return sum(self._seconds[test.partition("::")[0]][test] for test in tests)

    def of_files(self, files: Iterable[str]) -> list[str]:
        """All tests of files, shortest file first."""
        ordered = sorted(files, key=lambda name: sum(self._seconds[name].values()))
        return [test for name in ordered for test in self._seconds[name]]

    def executing(
        self, module: Path, lines: Iterable[int] | None, files: Iterable[str]
    ) -> list[str]:
        """Tests that execute one of the lines, shortest first.

        Parameters
        ----------
        module : Path
            Below the root of the project.
        lines : iterable of int, optional
            Lines of the module; all if not given.
        files : iterable of str
            Test files that count.

        Returns
        -------
        list of str
        """
        found: dict[str, float] = {}
        for name in files:
            contexts = self._data[name].contexts_by_lineno(str(self._tree / module))
            for line in contexts if lines is None else lines:
                for test in contexts.get(line, ()):
                    if test in self._seconds[name]:
                        found[test] = self._seconds[name][test]
        return sorted(found, key=found.__getitem__)


def _shared_by_tests(tree: Path) -> list[Path]:
    """Files that many test files use."""
    tests = tree / "tests"
    return [*sorted(tests.rglob("conftest.py")), *sorted((tests / "support").glob("*.py"))]


def _digest(paths: Iterable[Path]) -> str:
    """Of the contents of files."""
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.read_bytes())
        digest.update(b"\0")
    return digest.hexdigest()


def _record_here(name: str, data_file: Path, told: Path) -> int:
    """Run a test file under coverage and keep what its tests execute; in a child."""
    cover = coverage.Coverage(
        data_file=str(data_file), source=list(PACKAGES), config_file=False, messages=False
    )
    recorder = _Contexts(cover)
    cover.start()
    code = int(pytest.main(["-q", "-p", "no:cacheprovider", name], plugins=[recorder]))
    cover.stop()
    cover.save()
    told.write_text(json.dumps(recorder.seconds), encoding="utf-8")
    return code


@dataclass
class _Failures:
    """Plugin of pytest that writes the name of the test that fails."""

    path: Path

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Called with the outcome of a test."""
        if report.failed:
            self.path.write_text(report.nodeid, encoding="utf-8")


class _Contexts:
    """Plugin of pytest that makes every test a context, and measures it."""

    def __init__(self, cover: coverage.Coverage) -> None:
        self._cover = cover
        self.seconds: dict[str, float] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Around set-up, call and teardown of a test."""
        self._cover.switch_context(item.nodeid)
        begun = time.monotonic()
        yield
        self.seconds[item.nodeid] = round(time.monotonic() - begun, 4)
        self._cover.switch_context("")


def _in_child(tree: Path, call: Callable[[], int], seconds: float) -> int | None:
    """Exit code of a call in a child that imports the project from ``tree``; None if it hangs."""
    for name in _LIBRARIES:
        importlib.import_module(name)

    def start() -> None:
        os.setsid()
        quiet = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(quiet, stream)
        os.chdir(tree)
        os.environ["PYTHONPATH"] = str(tree)
        sys.path.insert(0, str(tree))
        os._exit(call())

    child = multiprocessing.get_context("fork").Process(target=start)
    child.start()
    child.join(seconds)
    hung = child.is_alive()
    # Also what tests have started and not ended.
    _kill_group(child.pid)
    child.join()
    return None if hung else child.exitcode


def _kill_group(group: int | None) -> None:
    """Kill a process group, if there is one left."""
    if group is not None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(group, signal.SIGKILL)
