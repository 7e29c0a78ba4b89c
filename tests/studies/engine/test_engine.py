"""Tests of the engine: the same result whoever computes it, however often it was stopped."""

import contextlib
import io
import json
import os
import signal
import subprocess
import sys
import threading
import time
import zipfile
from pathlib import Path

import chunk_functions
import numpy as np
import pytest
from chunk_functions import numbered_job

from missions.files.writing import OutputError, check_writable_file
from studies.cli.options import parts_folder
from studies.engine import chunk_store, workers
from studies.engine import run as engine
from studies.engine.chunk_store import FAILURE, ChunkStore
from studies.engine.run import Job
from studies.engine.workers import DaskPool, Pool, WorkersUnavailableError

KEY = "0123456789abcdef" * 2 + "01234567"


def run(job, pool=None, folder=None):
    pool = pool or Pool(1)
    if folder is None:
        return engine.run(job, pool)
    with ChunkStore(folder).opened(job.size_bytes, len(job.chunks)) as store:
        return engine.run(job, pool, store)


def one_cell(function, **blanks):
    return Job(function, chunk_functions.Settings(), np.ones((1, 1)), [np.arange(1)], blanks)


def assert_identical(outcome, expected):
    assert outcome.columns.keys() == expected.columns.keys()
    for name, values in outcome.columns.items():
        assert values.tobytes() == expected.columns[name].tobytes(), name
    assert outcome.failures == expected.failures


# ---- the same result whoever computes it


@pytest.mark.parametrize("method", sorted({workers._METHOD, "spawn"}))
def test_processes_agree_with_this_process_to_the_last_bit(monkeypatch, method):
    monkeypatch.setattr(workers, "_METHOD", method)  # that of macOS and Windows, too
    job = numbered_job()
    alone = run(job)
    assert alone.columns["number"].tolist() == list(range(20))
    assert alone.columns["name"][10] == "cell 10"
    assert_identical(alone, run(job, Pool(2)))


def test_small_work_starts_no_process(tmp_path):
    run(numbered_job(log=str(tmp_path)), Pool())
    assert {path.name.split("-")[2] for path in tmp_path.iterdir()} == {str(os.getpid())}


def test_long_work_starts_processes_and_agrees(tmp_path, monkeypatch):
    monkeypatch.setattr("studies.engine.workers.available_cores", lambda: 2)
    job = numbered_job(log=str(tmp_path))
    assert_identical(run(job, Pool(None, work_s=1000.0)), run(numbered_job()))
    assert str(os.getpid()) not in {path.name.split("-")[2] for path in tmp_path.iterdir()}


def test_workers_use_one_thread_and_the_environment_is_restored():
    before = dict(os.environ)
    job = one_cell(chunk_functions.threads, root=np.float64(0))
    assert run(job, Pool(2)).columns["root"] == [1.0]
    assert dict(os.environ) == before


# ---- cells that go wrong


@pytest.fixture
def pool(request):
    """Processes of this machine, or two of dask."""
    if request.param != "dask":
        yield Pool(request.param)
        return
    pytest.importorskip("distributed")
    import dask

    # A task is given up after two workers, not four: each takes a second to start again, which is
    # no reason to take it for lost.
    settings = {"scheduler.allowed-failures": 1, "deploy.lost-worker-timeout": "0 s"}
    with dask.config.set({f"distributed.{key}": value for key, value in settings.items()}):
        yield DaskPool("local-cluster", 2)


DASK = pytest.param("dask", marks=[pytest.mark.slow, pytest.mark.extra])


@pytest.mark.parametrize("pool", [1, 2, DASK], indirect=True)
def test_a_raising_cell_fails_alone(pool):
    outcome = run(numbered_job(raising=(5, 19)), pool)
    assert outcome.failures == {
        5: "ArithmeticError: cell 5 is bad",
        19: "ArithmeticError: cell 19 is bad",
    }
    good = np.delete(np.arange(20), [5, 19])
    whole = run(numbered_job())
    np.testing.assert_array_equal(outcome.columns["root"][good], whole.columns["root"][good])
    assert np.isnan(outcome.columns["root"][[5, 19]]).all()
    assert outcome.columns["number"][5] == -1


@pytest.mark.long
@pytest.mark.parametrize("pool", [2, DASK], indirect=True)
def test_a_deadly_cell_fails_alone(pool):
    outcome = run(numbered_job(deadly=(6,), cells=12), pool)
    assert outcome.failures == {6: "the worker process died"}
    good = np.delete(np.arange(12), 6)
    np.testing.assert_array_equal(outcome.columns["number"][good], good)


@pytest.mark.parametrize("pool", [2, DASK], indirect=True)
def test_a_worker_killed_once_changes_nothing(tmp_path, pool):
    killed = numbered_job(once=str(tmp_path / "died"))
    outcome = run(killed, pool)
    assert (tmp_path / "died").exists()
    assert_identical(outcome, run(numbered_job()))


def test_a_wrong_column_is_a_failure_with_its_name():
    job = one_cell(chunk_functions.threads, other=np.float64(0))
    assert "columns ['root'] are not ['other']" in run(job, Pool(2)).failures[0]


# ---- kept chunks


def computed(log):
    """First cells of the chunks that were computed."""
    return {path.name.split("-")[0] for path in log.iterdir()}


def test_finished_chunks_are_not_computed_again(tmp_path):
    log, folder = tmp_path / "log", tmp_path / "parts"
    log.mkdir()
    job = numbered_job(log=str(log))
    first = run(job, folder=folder)
    assert computed(log) == {"0", "4", "8", "12", "16"}
    for path in log.iterdir():
        path.unlink()
    ChunkStore(folder).path(job.keys()[2]).unlink()
    again = run(job, Pool(2), folder)
    assert computed(log) == {"8"}
    assert (again.computed_chunks, again.kept_chunks) == (1, 4)
    assert_identical(first, again)


def archive(**columns):
    """Archive of a part of the cells 4 to 7, with some columns changed; None leaves one out."""
    good = {"root": np.zeros(4), "number": np.arange(4), "name": np.array(list("abcd"))}
    held = good | {FAILURE: np.array([""] * 4)} | columns
    file = io.BytesIO()
    np.savez(file, **{name: column for name, column in held.items() if column is not None})
    return file.getvalue()


def huge(shape, kind="<f8"):
    """Archive whose column says that it is larger than the memory."""
    file = io.BytesIO(archive(root=None))
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    with zipfile.ZipFile(file, "a") as added:
        added.writestr("root.npy", b"\x93NUMPY\x01\x00v\x00" + head.encode() + bytes(8))
    return file.getvalue()


def bomb():
    """Archive with a packed column."""
    file = io.BytesIO()
    np.savez_compressed(file, root=np.zeros(10_000_000))
    return file.getvalue()


MADE_UP = [
    b"",
    b"no archive",
    archive()[:-30],
    archive(root=None),
    archive(other=np.zeros(4)),
    archive(root=np.zeros(3)),
    archive(root=np.zeros((4, 1))),
    archive(root=np.float64(0.0)),
    archive(root=np.zeros(4, "f4")),
    archive(root=np.zeros(4, complex)),
    archive(root=np.zeros(4, "M8[s]")),
    archive(root=np.array([1, "a", None, {}], object)),
    archive(root=np.array(list("abcd"))),
    archive(number=np.zeros(4)),
    archive(name=np.zeros(4)),
    archive(**{FAILURE: None}),
    archive(**{FAILURE: np.array("why")}),
    archive(**{FAILURE: np.zeros(4)}),
    archive(**{FAILURE: np.array(["", "", "", "[" * 100_000])}),
    huge("(1000000000000,)"),
    huge("(-1,)"),
    huge("(4,)", "<U1000000000"),
    huge("'four'"),
    huge("(4,)", "O"),
    huge("__import__('os')"),
    bomb(),
]


# What becomes of a part's bytes, and of the part's key before it.
DAMAGES = [
    lambda whole, other: whole[:-40],
    lambda whole, other: b"",
    lambda whole, other: whole[:200] + bytes([whole[200] ^ 1]) + whole[201:],
    lambda whole, other: whole + b"more",
    lambda whole, other: other,
]


# By number: the bytes themselves are no names, and not the same in every process.
@pytest.mark.parametrize("damage", [*DAMAGES, *MADE_UP], ids=range(len(DAMAGES) + len(MADE_UP)))
def test_a_part_that_is_damaged_or_made_up_is_computed_again(tmp_path, damage):
    job = numbered_job()
    first = run(job, folder=tmp_path)
    other, key = job.keys()[:2]
    path = ChunkStore(tmp_path).path(key)
    if isinstance(damage, bytes):
        path.write_bytes(chunk_store._head(key, damage) + b"\n" + damage)
    else:
        path.write_bytes(damage(path.read_bytes(), ChunkStore(tmp_path).path(other).read_bytes()))
    again = run(job, folder=tmp_path)
    assert again.computed_chunks == 1
    assert_identical(first, again)


def test_a_part_that_is_whole_is_believed(tmp_path):
    key = numbered_job().keys()[1]
    body = archive()
    ChunkStore(tmp_path).path(key).write_bytes(chunk_store._head(key, body) + b"\n" + body)
    again = run(numbered_job(), folder=tmp_path)
    assert again.kept_chunks == 1


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a pipe")
def test_a_pipe_in_place_of_a_part_is_not_waited_for(tmp_path):
    job = numbered_job()
    os.mkfifo(ChunkStore(tmp_path).path(job.keys()[1]))
    assert run(job, folder=tmp_path).computed_chunks == 5


def test_another_configuration_or_version_is_another_chunk(monkeypatch):
    keys = set(numbered_job().keys())
    assert not keys & set(numbered_job(scale=1.0 + 1e-15).keys())
    assert len(keys & set(numbered_job(cells=18).keys())) == 4
    monkeypatch.setattr(engine, "__version__", "another")
    assert not keys & set(numbered_job().keys())


def test_failed_cells_are_tried_again_by_the_next_run(tmp_path):
    job = numbered_job(raising=(5,))
    assert run(job, folder=tmp_path).failures
    again = run(job, folder=tmp_path)
    assert (again.computed_chunks, again.kept_chunks) == (1, 4)
    assert again.failures == {5: "ArithmeticError: cell 5 is bad"}


def test_no_other_files_than_its_parts_are_deleted(tmp_path):
    other = KEY[::-1]
    part = {"a": np.zeros(1), FAILURE: np.array([""])}
    others = {"lock", "notes.txt", "film.part", "film.scratch"}
    for name in others:
        (tmp_path / name).write_text("the owner's own")
    with ChunkStore(tmp_path).opened() as store:
        store.write(other, part)
    with ChunkStore(tmp_path).opened() as store:
        store.write(KEY, part)
        store.remove_parts([KEY])
        assert store.read(other, {"a": np.float64(0)}, 1) is not None
        store.remove_parts([other])
    assert {path.name for path in tmp_path.iterdir()} == others
    assert (tmp_path / "lock").read_text() == "the owner's own"


def test_a_link_in_place_of_the_lock_is_not_followed(tmp_path):
    target = tmp_path / "thesis.tex"
    target.write_text("years of work")
    folder = tmp_path / "parts"
    folder.mkdir()
    (folder / chunk_store._LOCK).symlink_to(target)
    with pytest.raises(OutputError, match="is not a plain file"), ChunkStore(folder).opened():
        pass
    assert target.read_text() == "years of work"


def test_workers_import_nothing_from_the_current_folder(tmp_path):
    for module in ("socket", "pickle", "random"):
        (tmp_path / f"{module}.py").write_text("raise SystemExit('taken from the folder')\n")
    with contextlib.chdir(tmp_path):
        outcome = run(numbered_job(), Pool(2))
    assert not outcome.failures


def test_two_runs_do_not_share_a_folder(tmp_path):
    folder = tmp_path / "parts"
    other = (
        "import sys, pathlib\n"
        "from studies.engine.chunk_store import ChunkStore\n"
        "with ChunkStore(pathlib.Path(sys.argv[1])).opened():\n"
        "    print('locked', flush=True)\n"
        "    sys.stdin.read()\n"
    )
    holder = subprocess.Popen(
        [sys.executable, "-c", other, str(folder)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment(),
    )
    assert holder.stdout.readline() == b"locked\n"
    with (
        pytest.raises(OutputError, match=f"another run .process {holder.pid} on"),
        ChunkStore(folder).opened(),
    ):
        pass
    # A killed holder leaves nothing behind that would have to be cleaned up.
    holder.kill()
    holder.communicate()
    with ChunkStore(folder).opened():
        pass


def test_a_full_disk_is_refused_before_the_work(tmp_path):
    with (
        pytest.raises(OutputError, match="not enough room"),
        ChunkStore(tmp_path / "parts").opened(needed_bytes=10**18),
    ):
        pass
    assert not (tmp_path / "parts").exists()


def test_a_disk_that_fills_up_keeps_what_was_finished(tmp_path, monkeypatch):
    job = numbered_job()
    whole, write = Path.write_bytes, chunk_store.Path.write_bytes
    written = []

    def filling(path, data):
        if path.suffix == ".scratch":
            if len(written) == 2:
                whole(path, data[: len(data) // 2])
                raise OSError(28, "No space left on device")
            written.append(path)
        return write(path, data)

    monkeypatch.setattr(Path, "write_bytes", filling)
    with pytest.raises(OutputError, match="no space left on device"):
        run(job, folder=tmp_path / "parts")
    monkeypatch.undo()
    assert [p.suffix for p in (tmp_path / "parts").iterdir() if p.name != chunk_store._LOCK] == [
        ".part"
    ] * 2
    again = run(job, folder=tmp_path / "parts")
    assert (again.computed_chunks, again.kept_chunks) == (3, 2)
    assert_identical(again, run(job))


@pytest.mark.skipif(not Path("/dev/null").exists(), reason="needs a device")
def test_a_device_has_no_parts():
    check_writable_file("/dev/null")
    if Path("/proc/self").exists():  # a folder that takes no file
        with pytest.raises(OutputError, match=r"cannot write /proc/self/map\.nc"):
            check_writable_file("/proc/self/map.nc")
    assert parts_folder("/dev/null") is None
    assert parts_folder("map.nc") == Path("map.nc.parts")


# ---- stopping and going on


DRIVER = """\
import sys
from pathlib import Path

from chunk_functions import numbered_job
from studies.engine import run as engine
from studies.engine.chunk_store import ChunkStore
from studies.engine.workers import DaskPool, Pool
from studies.signals import Stopped

if __name__ == "__main__":
    folder, log, workers, scheduler = sys.argv[1:]
    job = numbered_job(pause_s=0.05, log=log, cells=60, each=2)
    pool = DaskPool(scheduler, int(workers)) if scheduler else Pool(int(workers))
    with ChunkStore(Path(folder)).opened() as store:
        print("begin", flush=True)
        try:
            outcome = engine.run(job, pool, store)
        except Stopped as stopped:
            sys.exit(128 + stopped.signum)
        print(outcome.columns["root"].tobytes().hex(), outcome.kept_chunks)
"""


def environment():
    folders = Path(engine.__file__).parents[2], Path(chunk_functions.__file__).parent
    return {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, folders))}


class Driver:
    """A computation in a process group of its own, to be stopped in every way."""

    def __init__(self, tmp_path, workers=2, scheduler=""):
        self.script, self.folder, self.log = (tmp_path / n for n in ("drive.py", "parts", "log"))
        self.script.write_text(DRIVER)
        self.log.mkdir(exist_ok=True)
        self.options = [str(workers), scheduler]

    def start(self):
        return subprocess.Popen(
            [sys.executable, str(self.script), str(self.folder), str(self.log), *self.options],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment(),
            start_new_session=True,
        )

    def parts(self):
        return len(list(self.folder.glob("*.part")))

    def started_until(self, parts):
        process = self.start()
        deadline = time.monotonic() + 120.0
        while self.parts() < parts and process.poll() is None:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        return process

    def finish(self):
        out, err = self.start().communicate(timeout=300)
        assert err == ""
        values, kept = out.split()[-2:]
        return bytes.fromhex(values), int(kept)

    def orphans(self, process):
        """Processes of the driver's session that are left."""
        deadline = time.monotonic() + 30.0
        while time.monotonic() < deadline:
            left = _session(process.pid)
            if not left:
                return []
            time.sleep(0.05)
        return left


def _session(leader):
    left = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == leader and fields[0] != "Z":
            left.append(stat.parent.name)
    return left


needs_proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks into /proc")


def expected_values():
    outcome = run(numbered_job(cells=60, each=2))
    return bytes(outcome.columns["root"].tobytes())


@needs_proc
@pytest.mark.slow
# A start takes 0.3 s of processor time, one with a cluster twice that.
@pytest.mark.parametrize(
    ("workers", "scheduler", "kills"),
    [
        (1, "", [3, 11, 20]),
        (2, "", [4, 5, 13, 18, 24, 27]),
        pytest.param(2, "local-cluster", [7, 22], marks=pytest.mark.extra),
    ],
)
def test_killed_runs_go_on_and_end_alike(tmp_path, workers, scheduler, kills):
    if scheduler:
        pytest.importorskip("distributed")
    driver, expected = Driver(tmp_path, workers, scheduler), expected_values()
    for parts in kills:  # killed whenever so many parts are there
        process = driver.started_until(parts)
        process.kill()
        process.communicate()
        assert driver.orphans(process) == []
    before = driver.parts()
    values, kept = driver.finish()
    assert values == expected
    assert kept >= min(before, 30) - 1  # the part under the knife may be half


@needs_proc
@pytest.mark.slow
@pytest.mark.parametrize(
    ("signum", "to_group", "workers"),
    [
        (signal.SIGINT, True, 2),
        (signal.SIGINT, True, 1),
        (signal.SIGTERM, False, 2),
        (signal.SIGTERM, True, 2),
    ],
)
def test_signals_stop_cleanly_and_keep_what_is_finished(tmp_path, signum, to_group, workers):
    driver = Driver(tmp_path, workers)
    process = driver.started_until(4)
    (os.killpg if to_group else os.kill)(process.pid, signum)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 128 + signum
    assert err == ""
    assert driver.orphans(process) == []
    kept = driver.parts()
    assert kept >= 4
    values, reused = driver.finish()
    assert reused == kept
    assert values == expected_values()


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_workers_never_see_an_interrupt(tmp_path):
    script = tmp_path / "drive.py"  # a process that has not started any other yet
    script.write_text(
        "import chunk_functions as f, numpy as np\n"
        "from studies.engine import run as engine, workers\n"
        "cell = np.ones((1, 1)), [np.arange(1)], {'root': np.float64(0)}\n"
        "job = engine.Job(f.interruptible, f.Settings(), *cell)\n"
        "if __name__ == '__main__':\n"
        "    print(engine.run(job, workers.Pool(2)).columns['root'])\n"
    )
    command = [sys.executable, str(script)]
    assert subprocess.check_output(command, env=environment(), timeout=120) == b"[0.]\n"


@pytest.mark.long
def test_a_script_without_main_guard_gets_a_message(tmp_path):
    script = tmp_path / "plain.py"
    script.write_text(
        "from chunk_functions import numbered_job\n"
        "from studies.engine import run as engine, workers\n"
        "engine.run(numbered_job(), workers.Pool(2))\n"
    )
    done = subprocess.run(
        [sys.executable, str(script)],
        capture_output=True,
        text=True,
        timeout=120,
        env=environment(),
        check=False,
    )
    assert done.returncode != 0
    # Python itself may add a warning of its resource tracker behind it.
    lines = [line for line in done.stderr.splitlines() if "WorkersUnavailableError" in line]
    assert "if __name__ == '__main__':" in lines[-1]


# ---- dask


def test_without_dask_the_message_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(WorkersUnavailableError, match="pip install distributed"):
        DaskPool("local-cluster")


@pytest.mark.slow
@pytest.mark.extra
def test_a_scheduler_that_is_not_there(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("studies.engine.workers._CONNECT_S", 1.0)
    with pytest.raises(WorkersUnavailableError, match="no answer of the scheduler tcp"):
        DaskPool("tcp://127.0.0.1:1")


@pytest.fixture
def cluster(tmp_path):
    """Pool on a scheduler with so many workers that nobody starts again; scheduler, workers."""
    pytest.importorskip("distributed")
    started = []

    def start(workers):
        place = tmp_path / "scheduler.json"
        options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
        started.append(dask("scheduler", *options, "--scheduler-file", str(place)))
        deadline = time.monotonic() + 120.0
        # It is there before it is written.
        while not place.exists() or not place.read_text().rstrip().endswith("}"):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        address = json.loads(place.read_text())["address"]
        worker = [address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        started.extend(dask("worker", *worker, "--name", str(n)) for n in range(workers))
        pool = DaskPool(address)
        pool._client.wait_for_workers(workers, timeout=60)
        return pool, started

    yield start
    for process in started:
        process.kill()
        process.wait()


@pytest.mark.slow
@pytest.mark.extra
def test_a_cluster_goes_on_when_one_of_its_two_workers_is_killed(tmp_path, cluster):
    log = tmp_path / "log"
    log.mkdir()
    job = numbered_job(pause_s=0.1, log=str(log), cells=60, each=2)
    pool, (_, *workers) = cluster(2)

    def pids():
        return {path.name.split("-")[2] for path in log.iterdir()}

    def kill_once_it_computes():
        while str(workers[0].pid) not in pids():
            time.sleep(0.02)
        workers[0].kill()

    threading.Thread(target=kill_once_it_computes, daemon=True).start()
    outcome = run(job, pool)
    assert workers[0].wait(timeout=10) == -signal.SIGKILL
    assert pids() == {str(worker.pid) for worker in workers}
    assert_identical(outcome, run(numbered_job(cells=60, each=2)))


@pytest.mark.slow
@pytest.mark.extra
def test_a_cluster_without_workers_ends_the_work_with_a_reason(cluster, monkeypatch):
    monkeypatch.setattr("studies.engine.workers._WITHOUT_WORKERS_S", 2.0)
    monkeypatch.setattr("studies.engine.workers._TOLD_AFTER_S", 1.0)
    monkeypatch.setattr("studies.engine.workers._LOOK_S", 0.5)
    pool, (_, worker) = cluster(1)
    messages = []
    pool._tell = messages.append
    threading.Timer(1.0, worker.kill).start()
    with pytest.raises(WorkersUnavailableError, match="no worker for 2 s; start one with"):
        run(numbered_job(pause_s=0.5, cells=60, each=2), pool)
    (text,) = messages
    assert "has no worker; waiting 1 s; start one with: dask worker tcp://" in text


@pytest.mark.slow
@pytest.mark.extra
def test_a_scheduler_that_is_killed_ends_the_work_in_words(tmp_path, cluster, capfd):
    pool, (scheduler, _) = cluster(1)
    job = numbered_job(pause_s=0.1, cells=60, each=2)
    killed = threading.Event()

    def progress(done, total):
        if done and not killed.is_set():
            scheduler.kill()
            killed.set()

    with (
        ChunkStore(tmp_path / "parts").opened() as store,
        pytest.raises(WorkersUnavailableError, match=r"the scheduler tcp.* is gone"),
    ):
        engine.run(job, pool, store, progress)
    assert capfd.readouterr().err == ""
    assert len(list((tmp_path / "parts").glob("*.part"))) >= 1


def dask(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=environment(),
    )
