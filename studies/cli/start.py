"""Where ``solar-uav`` begins, before it imports anything that takes time."""

from __future__ import annotations

import signal

__all__ = ["start"]


def start() -> None:
    """Run the command; until it is there, and once it is done, Ctrl-C ends the process silently."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from studies.cli.__main__ import main

    main()
