"""Ctrl-C and SIGTERM as an exception that comes soon, and comes again where it was swallowed.

The first signal is noted and raised as :class:`Stopped`; the second ends the process at once, even
amid a call into a library, because it finds the system's own handler.

An exception that a signal handler raises may be lost: CasADi swallows about half of those that come
amid its solvers, and Python drops those of finalisers. It is therefore raised again every second
until somebody is seen to handle it. It is not raised while a native module is initialised: some
call Python meanwhile and, left half-made, abort the process at its end (matplotlib's ft2font:
``Fatal Python error: PyThreadState_Get``).
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
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
    """A signal asked to stop; what was finished is kept in the store, if there is one."""

    def __init__(self, signum: int) -> None:
        super().__init__(signum)
        self.signum = signum


class Signals:
    """What came while :func:`interruptible` was entered.

    ``signum``: the first signal that came. ``held``: whether signals are noted alone, for
    :meth:`check` to raise.
    """

    def __init__(self) -> None:
        self.signum: int | None = None
        self.held = False
        self.caught: list[int] = []

    def check(self) -> None:
        """Raise for a signal that came while it was held, or was swallowed."""
        if self.signum is not None:
            raise Stopped(self.signum)

    def handle(self, signum: int, frame: FrameType | None) -> None:
        """Note the signal, and raise it unless it is held."""
        if self.signum is None:
            self.signum = signum
            for number in self.caught:
                signal.signal(number, signal.SIG_DFL)
            if _CAN_REPEAT:
                signal.signal(signal.SIGALRM, self._repeat)
                signal.setitimer(signal.ITIMER_REAL, _FIRST_REPEAT_S, _REPEAT_S)
            # A second one might leave the terminal as a progress bar has it.
            if sys.stderr is not None and sys.stderr.isatty():
                os.write(sys.stderr.fileno(), _SHOW_CURSOR)
        if not self.held and not (_CAN_REPEAT and _starts_native_module(frame)):
            raise Stopped(self.signum)

    def _repeat(self, signum: int, frame: FrameType | None) -> None:
        if self.signum is None or self.held or _being_handled():
            return
        if not _starts_native_module(frame):
            raise Stopped(self.signum)


def _being_handled() -> bool:
    """Whether an ``except``, ``finally`` or ``with`` tidies up after a signal just now."""
    error = sys.exc_info()[1]
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    return error is not None


def _starts_native_module(frame: FrameType | None) -> bool:
    """Whether a native module is being initialised where a signal came."""
    while frame is not None:
        if frame.f_code in _STARTS:
            return True
        frame = frame.f_back
    return False


@contextmanager
def interruptible(*, held: bool = False) -> Iterator[Signals]:
    """Catch Ctrl-C and SIGTERM, in the main thread; elsewhere nothing is caught.

    A signal that is ignored, as Ctrl-C is by jobs in the background, remains so.
    """
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
    try:
        for number in signals.caught:
            before[number] = signal.signal(number, signals.handle)
        sys.unraisablehook = _without_signals(hook)
        yield signals
    finally:
        if signals.signum is not None and _CAN_REPEAT:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
        for number, handler in before.items():
            signal.signal(number, handler)
        sys.unraisablehook = hook


def _without_signals(
    hook: Callable[[sys.UnraisableHookArgs], object],
) -> Callable[[sys.UnraisableHookArgs], object]:
    """Hook for errors that cannot be raised: those of signals are raised again by themselves."""

    def told(unraisable: sys.UnraisableHookArgs) -> object:
        if isinstance(unraisable.exc_value, KeyboardInterrupt):
            return None
        return hook(unraisable)

    return told
