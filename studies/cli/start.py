"""Where ``solar-uav`` begins, before it imports anything that takes time."""

from __future__ import annotations

import gc
import os
import signal
import sys
from importlib import import_module

_ALLOCATIONS = 50_000  # between two looks for garbage; Python's own 700 suit long-lived servers


def start() -> None:
    """Run the command; until it is there, and once it is done, Ctrl-C ends the process silently."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    # Matrices of a command are small: threads for them take a tenth of a short one, and on a busy
    # machine most of a long one.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # xarray imports dask where it is installed, to know its arrays: a second for nothing, as no
    # command holds any.
    sys.modules.setdefault("dask", None)  # type: ignore[arg-type]  # Python refuses to import it
    # What is imported lives as long as the process: to look through it for garbage takes a tenth of
    # a short command, which begins to look once it has imported everything.
    gc.disable()
    gc.set_threshold(_ALLOCATIONS)
    from studies.output.figures.options import ignore_settings_of_folder

    ignore_settings_of_folder()
    import_module("studies.cli.__main__").main()


def let_dask_in() -> None:
    """Let dask be imported after all, for workers of a cluster."""
    if sys.modules.get("dask", sys) is None:
        del sys.modules["dask"]
