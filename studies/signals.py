"""Ctrl-C and SIGTERM as an exception, raised again where it is swallowed.

The first signal is raised as :class:`Stopped`; the second ends the process at once, even within a
library, by the system's handler.

Exceptions of signal handlers may be lost: CasADi swallows about half of them within its solvers,
and Python drops them in finalisers. The exception is therefore raised again every second until it
is being handled, but not while a native module is initialised: some call Python meanwhile and, left
half-made, abort the process at its end (matplotlib's ft2font: ``Fatal Python error:
PyThreadState_Get``).
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import ExtensionFileLoader
from types import FrameType
from typing import Any

_REPEAT_S = 1.0
_FIRST_REPEAT_S = 0.1
_CAN_REPEAT = hasattr(signal, "setitimer")  # not on Windows
_STARTS = {ExtensionFileLoader.create_module.__code__, ExtensionFileLoader.exec_module.__code__}
_SHOW_CURSOR = b"\x1b[?25h"


class Stopped(KeyboardInterrupt):
    """Stop by a signal; finished work is kept in the store, if there is one."""

    def __init__(self, signum: int) -> None:
        super().__init__(signum)
        self.signum = signum


class Signals:
    """Signals within :func:`interruptible`.

    ``signum``: first signal. ``held``: signals are recorded alone, for :meth:`check` to raise.
    """

    def __init__(self) -> None:
        self.signum: int | None = None
        self.held = False
        self.caught: list[int] = []

    def check(self) -> None:
        """Raise for a signal that was held or swallowed."""
        if self.signum is not None:
            raise Stopped(self.signum)

    def handle(self, signum: int, frame: FrameType | None) -> None:
        """Record the signal, and raise it unless held."""
        if self.signum is None:
            self.signum = signum
            for number in self.caught:
                signal.signal(number, signal.SIG_DFL)
            if _CAN_REPEAT:
                signal.signal(signal.SIGALRM, self._repeat)
                signal.setitimer(signal.ITIMER_REAL, _FIRST_REPEAT_S, _REPEAT_S)
            # A second signal might leave the cursor hidden by a progress bar.
            if sys.stderr is not None and sys.stderr.isatty():
                os.write(sys.stderr.fileno(), _SHOW_CURSOR)
        if not self.held and not (_CAN_REPEAT and _starts_native_module(frame)):
            raise Stopped(self.signum)

    def _repeat(self, signum: int, frame: FrameType | None) -> None:
        handled = sys.exc_info()[1]  # by an ``except``, ``finally`` or ``with``
        while handled is not None and not isinstance(handled, KeyboardInterrupt):
            handled = handled.__context__
        if self.signum is None or self.held or handled is not None:
            return
        if not _starts_native_module(frame):
            raise Stopped(self.signum)


def _starts_native_module(frame: FrameType | None) -> bool:
    """Return true if a frame is within the initialisation of a native module."""
    while frame is not None:
        if frame.f_code in _STARTS:
            return True
        frame = frame.f_back
    return False


@contextmanager
def interruptible(*, held: bool = False) -> Iterator[Signals]:
    """Catch Ctrl-C and SIGTERM in the main thread, unless ignored as by jobs in the background."""
    signals = Signals()
    signals.held = held
    if threading.current_thread() is not threading.main_thread():
        yield signals
        return
    both = (signal.SIGINT, signal.SIGTERM)
    ignored = (signal.SIG_IGN, None)  # None: a handler that was not set by Python
    signals.caught = [number for number in both if signal.getsignal(number) not in ignored]
    before: dict[int, Any] = {}
    hook = sys.unraisablehook

    def without_signals(unraisable: sys.UnraisableHookArgs) -> object:
        """Skip signals, which are raised again."""
        return None if isinstance(unraisable.exc_value, KeyboardInterrupt) else hook(unraisable)

    try:
        for number in signals.caught:
            before[number] = signal.signal(number, signals.handle)
        sys.unraisablehook = without_signals
        yield signals
    finally:
        if signals.signum is not None and _CAN_REPEAT:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
        for number, handler in before.items():
            signal.signal(number, handler)
        sys.unraisablehook = hook
