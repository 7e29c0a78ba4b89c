"""Who may talk to the explorer: pages of its own address that know the token, and nobody else.

A server on this machine can be reached by every page that a browser has open, and by every user of
the machine. Therefore each request names this server in ``Host`` (a foreign name that resolves to
127.0.0.1 is refused), comes from its own pages (``Origin``), and carries the token that was printed
when it started: in the cookie that the first page sets, or as ``Authorization: Bearer``.
Starlette's ``TrustedHostMiddleware`` looks at no port, and takes the first of two ``Host`` headers.
"""

from __future__ import annotations

import asyncio
import html
import secrets
from typing import Any

from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from missions.files.writing import to_json
from studies.explorer.settings import AnsweredError

MAXIMUM_BODY_BYTES = 16_384
BODY_S = 10.0  # within which a body must come
_MAXIMUM_QUERY_BYTES, _MOST_FIELDS = 512, 10
_HEADERS = {
    # Scripts, styles and data from here alone; nothing may frame the page or send it elsewhere.
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), microphone=(), geolocation=()",
    "cache-control": "no-store",
}


def new_token() -> str:
    """Return a random token of 256 bits."""
    return secrets.token_urlsafe(32)


def error_body(kind: str, message: str, problems: list[dict[str, Any]] | None = None) -> bytes:
    """Return an error as the page and scripts read it.

    ``problems``: field, value, message and what is allowed, of each field that is wrong.
    """
    record = {"kind": kind, "message": message, "problems": problems or []}
    return to_json({"error": record}).encode()


class Guard:
    """ASGI application that lets only the page's own requests through to another one."""

    def __init__(self, app: ASGIApp, *, port: int, token: str) -> None:
        self._app, self._token = app, token.encode()
        self._hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
        self._origins = {f"http://{host}" for host in self._hosts}
        # Cookies do not know of ports: two explorers must not take each other's.
        self.cookie = f"solar-uav-{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check a request, and answer it."""
        if scope["type"] != "http":
            return  # neither web sockets nor a lifespan
        request = Request(scope)
        refused = self._refused(request)
        first_page = scope["path"] == "/" and self._is_ours(_query_tokens(request))

        async def guarded_send(message: Message) -> None:
            if message["type"] == "http.response.start":
                kept = [(k, v) for k, v in message.get("headers", []) if k not in _OURS]
                kept += [(k.encode(), v.encode()) for k, v in _HEADERS.items()]
                if first_page and refused is None:
                    value = f"{self.cookie}={self._token.decode()}; Path=/; HttpOnly; "
                    kept.append((b"set-cookie", f"{value}SameSite=Strict".encode()))
                message = {**message, "headers": kept}
            await send(message)

        if refused is not None:
            status, kind, words = refused
            body, media = error_body(kind, words), "application/json"
            if "text/html" in ",".join(request.headers.getlist("accept")):
                body, media = _PAGE.format(words=html.escape(words)).encode(), "text/html"
            await Response(body, status, media_type=media)(scope, receive, guarded_send)
            return
        await self._app(scope, _limited(receive), guarded_send)

    def _refused(self, request: Request) -> tuple[int, str, str] | None:
        """Return status, kind and words of a refusal; None for a request that may pass."""
        hosts, origins = (request.headers.getlist(name) for name in ("host", "origin"))
        if len(hosts) != 1 or hosts[0].lower() not in self._hosts:
            allowed = ", ".join(sorted(self._hosts))
            instead = "solar-uav report --out FILE writes a page for other computers"
            return 403, "host", f"this server answers to {allowed} alone; {instead}"
        if len(origins) > 1 or any(o.lower() not in self._origins for o in origins):
            return 403, "origin", "requests of other pages are refused"
        if request.method not in ("GET", "HEAD") and not origins:
            return 403, "origin", "a request that is not GET needs the header Origin of this server"
        if len(request.scope["query_string"]) > _MAXIMUM_QUERY_BYTES:
            return 414, "size", f"a query has at most {_MAXIMUM_QUERY_BYTES} bytes"
        tokens = _query_tokens(request) if request.scope["path"] == "/" else []
        for value in request.headers.getlist("authorization"):
            scheme, _, token = value.partition(" ")
            tokens += [token.strip()] if scheme.lower() == "bearer" else []
        if not self._is_ours([*tokens, request.cookies.get(self.cookie, "")]):
            words = "the token is missing or wrong: open the address that solar-uav explore printed"
            return 403, "token", words
        for value in request.headers.getlist("content-length"):
            # Python refuses to read numbers of thousands of digits.
            known = value.isdecimal() and len(value) <= 20
            if known and int(value) <= MAXIMUM_BODY_BYTES:
                continue
            return 413, "size", f"a request has at most {MAXIMUM_BODY_BYTES} bytes"
        return None

    def _is_ours(self, tokens: list[str]) -> bool:
        return any(secrets.compare_digest(token.encode(), self._token) for token in tokens)


_OURS = {name.encode() for name in _HEADERS}


def _query_tokens(request: Request) -> list[str]:
    few = request.scope["query_string"].count(b"&") < _MOST_FIELDS
    return request.query_params.getlist("token") if few else []


def _limited(receive: Receive) -> Receive:
    """Return the stream of a body, which ends where it grows too long.

    The body must come within a time; what is received behind it, such as the end of the
    connection, may take as long as it likes.
    """
    taken, whole = 0, False
    end_s = asyncio.get_running_loop().time() + BODY_S

    async def limited() -> Message:
        nonlocal taken, whole
        if whole:
            return await receive()
        try:
            async with asyncio.timeout_at(end_s):
                message = await receive()
        except TimeoutError:
            raise AnsweredError("the rest of the request did not come", 408, "slow") from None
        taken += len(message.get("body", b""))
        whole = not message.get("more_body", False)
        if taken > MAXIMUM_BODY_BYTES:
            raise AnsweredError("the request is too long", 413, "size")
        return message

    return limited


_PAGE = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>solar-uav explore: refused</title>
</head>
<body><h1>Refused</h1><p>{words}</p></body>
</html>
"""
