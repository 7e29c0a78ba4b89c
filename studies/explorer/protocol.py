"""Connections of the explorer that let nobody keep the others out.

A client may open connections and send nothing, or half a request. The server answers so many at
once and no more: without a limit of time, such a client alone would hold it.
"""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

__all__ = ["MOST_CONNECTIONS", "REQUEST_S", "Connection"]

REQUEST_S = 10.0  # for the head of a request, and for its body
MOST_CONNECTIONS = 64
_MOST_WAITING = 40  # connections that wait for a request; then the oldest of them goes


class Connection(H11Protocol):
    """Connection that is closed when its request does not come."""

    _since_s = 0.0

    @property
    def waits(self) -> bool:
        """Whether no request is under way."""
        cycle: Any = self.cycle  # none before the first one
        return cycle is None or bool(cycle.response_complete)

    # uvicorn narrows the type of asyncio's own argument as well.
    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a connection, and close the one that waits longest where there are too many."""
        self._since_s = self.loop.time()
        waiting = [c for c in self.connections if isinstance(c, Connection) and c.waits]
        if len(waiting) >= _MOST_WAITING:
            min(waiting, key=lambda one: one._since_s).leave()
        super().connection_made(transport)
        self.loop.call_later(REQUEST_S, self._look, None)

    def leave(self) -> None:
        """Close this connection at once, and forget it."""
        self.connections.discard(self)
        self.transport.close()

    def _look(self, before: object) -> None:
        """Close the connection if it has waited for the same request since the last look."""
        if self.transport.is_closing():
            return
        if self.waits and self.cycle is before:
            self.leave()
            return
        self.loop.call_later(REQUEST_S, self._look, self.cycle)
