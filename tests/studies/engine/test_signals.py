"""Signals become an exception that comes again where it was swallowed, and only there."""

import contextlib
import os
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

from studies.engine import run as engine
from studies.engine.run import Job
from studies.engine.workers import Pool
from studies.signals import Stopped, interruptible

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")

WAIT_S = 30.0  # never reached where all is well


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Signals are repeated soon; afterwards all handlers are those of before."""
    monkeypatch.setattr("studies.signals._REPEAT_S", 0.01)
    # Python leaves an interrupt ignored that a background job of a shell was started with.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    signal.signal(signal.SIGINT, before)


def send(number=signal.SIGINT):
    os.kill(os.getpid(), number)


def swallowed():
    with contextlib.suppress(KeyboardInterrupt):
        send()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_is_raised_with_its_number(number):
    with pytest.raises(Stopped) as stopped, interruptible():
        send(number)
    assert stopped.value.signum == number
    assert not isinstance(stopped.value, Exception)  # which handlers of errors would swallow


class Finalised:
    def __del__(self):
        send()


@pytest.mark.parametrize("swallow", [swallowed, Finalised])
def test_a_swallowed_signal_comes_again(swallow, capsys):
    def before_a_wait():
        swallow()
        threading.Event().wait(WAIT_S)

    with pytest.raises(Stopped), interruptible():
        before_a_wait()
    assert capsys.readouterr().err == ""


@pytest.mark.long
def test_a_signal_amid_the_start_of_a_native_module_waits_for_its_end():
    """Half of the classes of ft2font, left to the end of the process, abort it."""
    pytest.importorskip("matplotlib")
    code = (
        "import os, signal, sys, threading\n"
        "from importlib.machinery import ExtensionFileLoader\n"
        "from studies.signals import Stopped, interruptible\n"
        "count = 0\n"
        "def starts(frame):\n"
        "    while frame is not None:\n"
        "        loader = frame.f_locals.get('self')\n"
        "        if isinstance(loader, ExtensionFileLoader) and 'ft2font' in loader.name:\n"
        "            return True\n"
        "        frame = frame.f_back\n"
        "    return False\n"
        "def hook(frame, event, arg):\n"
        "    global count\n"
        "    if event == 'call' and starts(frame.f_back):\n"
        "        count += 1\n"
        "        if count == 300:\n"
        "            sys.setprofile(None)\n"
        "            os.kill(os.getpid(), signal.SIGTERM)\n"
        "sys.setprofile(hook)\n"
        "try:\n"
        "    with interruptible():\n"
        "        import matplotlib.ft2font\n"
        f"        threading.Event().wait({WAIT_S} if count >= 300 else 0)\n"
        "        print(count)\n"
        "except Stopped:\n"
        "    print(count, 'matplotlib.ft2font' in sys.modules)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, timeout=2 * WAIT_S, check=False
    )
    if done.stdout.strip().isdigit():
        pytest.skip("before 3.10 Matplotlib makes them by few calls: no signal came")
    assert (done.returncode, done.stdout, done.stderr) == (0, b"300 True\n", b"")


def test_other_errors_of_finalisers_are_reported(monkeypatch):
    errors = []
    monkeypatch.setattr(sys, "unraisablehook", lambda error: errors.append(str(error.exc_value)))

    class Broken:
        def __del__(self):
            raise ValueError("broken")

    before = sys.unraisablehook
    with interruptible():
        Broken()
    assert errors == ["broken"]
    assert sys.unraisablehook is before


def test_what_tidies_up_is_not_interrupted():
    done = []

    @contextlib.contextmanager
    def tidy():
        try:
            yield
        finally:
            threading.Event().wait(0.05)  # five repetitions
            with contextlib.suppress(ValueError):
                raise ValueError
            done.append(True)

    with pytest.raises(Stopped), interruptible(), tidy():
        send()
    assert done == [True]


def test_a_signal_that_is_held_is_raised_at_a_check():
    with interruptible(held=True) as signals:
        send()
        threading.Event().wait(0.03)
        with pytest.raises(Stopped):
            signals.check()


def test_a_signal_that_is_ignored_stays_ignored():
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interruptible() as signals:
            send()
        assert signals.signum is None
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def test_other_threads_catch_nothing():
    caught = []

    def enter():
        with interruptible() as signals:
            caught.append(signals.caught)

    thread = threading.Thread(target=enter)
    thread.start()
    thread.join()
    assert caught == [[]]


def stubborn(settings, cells):
    """Do as CasADi may: swallow the interrupt, and go on for long."""
    swallowed()
    threading.Event().wait(WAIT_S)


def test_a_chunk_that_swallows_the_signal_is_interrupted_all_the_same():
    job = Job(stubborn, None, np.ones((1, 1)), [np.arange(1)], {"a": np.float64(0)})
    with pytest.raises(Stopped):
        engine.run(job, Pool(1))
