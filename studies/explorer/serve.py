"""The explorer's server: on this machine alone, until Ctrl-C."""

from __future__ import annotations

import asyncio
import logging
import os
import socket
import threading
import webbrowser
from collections.abc import Callable
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from studies.explorer.app import Explorer
from studies.explorer.security import new_token
from studies.explorer.session import Session

ADDRESS = "127.0.0.1"
REQUEST_S = 10.0  # for the head of a request, and for its body
MOST_CONNECTIONS = 64
_MOST_WAITING = 40  # connections that wait for a request; then the oldest of them goes


def bound_socket(port: int) -> socket.socket:
    """Return a socket that listens on this machine."""
    # Named as TCP, or asyncio leaves Nagle's algorithm on: every other answer came 40 ms late.
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        if os.name == "posix":
            # A port that a server left a moment ago may be taken again at once. Elsewhere this
            # option would let another program take the port of a server that runs.
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((ADDRESS, port))
        listening.listen(64)
    except OSError:
        listening.close()
        raise
    return listening


class Connection(H11Protocol):
    """Connection that is closed when its request does not come.

    A client may open connections and send nothing, or half a request. The server answers so many at
    once and no more: without a limit of time, such a client alone would hold it.
    """

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
            min(waiting, key=lambda connection: connection._since_s).leave()
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


class _Server(uvicorn.Server):
    """Server that ends what a page still waits for before it waits for its pages."""

    def __init__(self, configuration: uvicorn.Config, explorer: Explorer) -> None:
        super().__init__(configuration)
        self._explorer = explorer

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop listening, and answer what is under way."""
        self._explorer.worker.end()
        await super().shutdown(sockets)


def configured(explorer: Explorer, *, port: int, token: str) -> uvicorn.Server:
    """Return the server of an explorer, not yet running."""
    server = _Server(
        uvicorn.Config(
            explorer.application(port=port, token=token),
            http=Connection,  # the same limits whatever else is installed
            log_level="error",
            access_log=False,
            lifespan="off",
            ws="none",
            server_header=False,
            date_header=False,
            proxy_headers=False,
            timeout_graceful_shutdown=1,
            limit_concurrency=MOST_CONNECTIONS,
            h11_max_incomplete_event_size=16_384,
        ),
        explorer,
    )
    logging.getLogger("uvicorn.error").addFilter(_is_a_mistake)
    return server


def _is_a_mistake(record: logging.LogRecord) -> bool:
    """Return whether a message is more than that the server's end broke a request off."""
    error = record.exc_info[1] if record.exc_info else None
    broken_off = isinstance(error, asyncio.CancelledError)
    return not broken_off and not str(record.msg).startswith("Cancel ")


def serve(
    session: Session, listening: socket.socket, *, tell: Callable[[str], None], browser: bool
) -> None:
    """Serve the page until a signal ends it."""
    port, token = listening.getsockname()[1], new_token()
    explorer = Explorer(session)
    server = configured(explorer, port=port, token=token)
    address = f"http://{ADDRESS}:{port}/?token={token}"
    tell(address)
    if browser:
        # Finding a browser may take a while, and the page has to be answered meanwhile.
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    try:
        server.run(sockets=[listening])
    finally:
        explorer.close()
