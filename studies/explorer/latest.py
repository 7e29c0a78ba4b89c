"""Of many requests of a page only the latest matters: it is computed, those before it are dropped.

Computing happens in one thread; a request that waits for it is dropped as soon as the same page
sends another one.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Executor
from typing import TypeVar

T = TypeVar("T")


class SupersededError(RuntimeError):
    """A later request took the place of this one."""


class Latest:
    """Turns of an executor, at most one waiting for each client."""

    def __init__(self, executor: Executor) -> None:
        self._executor = executor
        self._turn = asyncio.Lock()
        self._newest: dict[str, object] = {}

    @property
    def waiting(self) -> int:
        """Number of clients whose request waits or is computed."""
        return len(self._newest)

    async def run(self, client: str, work: Callable[[], T]) -> T:
        """Compute when it is this request's turn."""
        mine = self._newest[client] = object()
        try:
            async with self._turn:
                if self._newest.get(client) is not mine:
                    raise SupersededError
                return await asyncio.get_running_loop().run_in_executor(self._executor, work)
        finally:
            if self._newest.get(client) is mine:
                del self._newest[client]
