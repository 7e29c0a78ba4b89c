"""Cases of the explorer: requests of its page, and of programs that mean harm."""

from __future__ import annotations

import asyncio
import json
import random
from functools import cache
from typing import Any

from benchmarks.reliability.inputs.mutations import HOSTILE, bytes_changed, number_text

__all__ = ["answer", "request"]

_PORT, _TOKEN = 8000, "x" * 43
_PATHS = ("/", "/api/alive", "/api/session", "/api/view", "/api/files", "/api/size", "/api/report")
_STATUSES = (200, 307, 400, 403, 404, 405, 409, 413, 414, 415, 422, 503)
_CONTENT = (b"content-type", b"application/json")


def request(rng: random.Random) -> tuple[dict[str, Any], list[bytes]]:
    """Request as a server passes it on: scope, and parts of its body.

    Parameters
    ----------
    rng : random.Random

    Returns
    -------
    scope : dict
    body : list of bytes
    """
    way = rng.random()
    path = rng.choice(_PATHS[3:5]) if way < 0.85 else rng.choice((*_PATHS[:5], *_odd_paths(rng)))
    method = "POST" if path.startswith("/api/") and rng.random() < 0.97 else "GET"
    if rng.random() < 0.02:
        method = rng.choice(("PUT", "DELETE", "HEAD", "OPTIONS", "TRACE", "get", "\u00e9", ""))
    headers = [
        (b"host", f"127.0.0.1:{_PORT}".encode()),
        (b"origin", f"http://127.0.0.1:{_PORT}".encode()),
        (b"authorization", f"Bearer {_TOKEN}".encode()),
        _CONTENT,
    ]
    body = json.dumps(_body(path, rng)).encode()
    if rng.random() < 0.1:
        body = bytes_changed(body, rng)
    if rng.random() < 0.08:
        _spoil(headers, rng)
    query = rng.choice((b"", b"", b"", b"token=x", b"token=%ff&token=" + b"a" * 600, b"&" * 40))
    scope = {
        **{"type": "http", "asgi": {"version": "3.0"}, "http_version": "1.1", "method": method},
        **{"path": path, "raw_path": path.encode("utf-8", "replace"), "query_string": query},
        **{"headers": headers, "scheme": "http", "server": ("127.0.0.1", _PORT), "root_path": ""},
    }
    cut = rng.randrange(len(body) + 1)
    return scope, rng.choice(([body], [body[:cut], body[cut:]], [body]))


def _odd_paths(rng: random.Random) -> tuple[str, ...]:
    hostile = rng.choice(HOSTILE).replace("\0", "")
    return ("/../../etc/passwd", "/vendor/../main.js", "/main.js", "//", "/%2e%2e/", f"/{hostile}")


def _body(path: str, rng: random.Random) -> Any:
    if rng.random() < 0.05:
        return rng.choice((None, [], 1, "text", {}, {"settings": None}, {"a": {}}, [[]] * 50))
    body: dict[str, Any] = {"settings": _settings(rng)}
    if path == "/api/view":
        body["season"] = rng.choices(
            ("none", "coarse", "exact", "odd", None, []), (6, 6, 1, 1, 1, 1)
        )[0]
        body |= {"client": rng.choice(("a", "", "x" * 65, 5)), "sequence": rng.randrange(9)}
    if rng.random() < 0.1:
        body[rng.choice(HOSTILE)] = rng.choice((1, None, rng.choice(HOSTILE), [1]))
    return body


def _settings(rng: random.Random) -> Any:
    if rng.random() < 0.03:
        return rng.choice((None, [], 5, "x", [{}]))
    fields = _fields()
    found: dict[str, Any] = {}
    for key in rng.sample(sorted(fields), rng.choice((0, 1, 2, 4, len(fields)))):
        low, high, names = fields[key]
        if names:
            found[key] = rng.choice((*names, *names, "none", 1, None, rng.choice(HOSTILE)))
            continue
        value: Any = rng.choice((low, high, low + rng.random() * (high - low)))
        if key.endswith("day_of_year") and rng.random() < 0.9:
            value = round(value)
        if rng.random() < 0.06:
            value = rng.choice(
                (None, True, "1", [], {}, 10**400, 1e308, -1e308, 5e-324, float("nan"))
            )
        elif rng.random() < 0.03:
            value = number_text(rng)
        found[key] = value
    if rng.random() < 0.1:
        found[rng.choice(HOSTILE)] = 1
    return found


def _spoil(headers: list[tuple[bytes, bytes]], rng: random.Random) -> None:
    at = rng.randrange(len(headers))
    way = rng.random()
    if way < 0.3:
        del headers[at]
    elif way < 0.6:
        headers[at] = headers[at][0], bytes_changed(headers[at][1], rng)
    elif way < 0.8:
        headers.append(headers[at])
    else:
        length = rng.choice(
            (b"-1", b"99999999999999999999", b"1e3", b"\xb2", b"+5", b"", b"9" * 5000)
        )
        headers.append((b"content-length", length))


@cache
def _served() -> Any:
    from missions.files.shipped import find_document
    from studies.explorer.app import Explorer
    from studies.explorer.session import Session

    documents = (
        find_document("aircraft", "atlantiksolar-design"),
        find_document("mission", "rafz-july"),
    )
    explorer = Explorer(Session(*documents))
    return explorer, explorer.application(port=_PORT, token=_TOKEN)


@cache
def _fields() -> dict[str, tuple[float, float, tuple[str, ...]]]:
    from studies.explorer.fields import Field

    found: dict[str, tuple[float, float, tuple[str, ...]]] = {}
    for key, field in _served()[0].session.fields.items():
        if isinstance(field, Field):
            found[key] = field.minimum, field.maximum, ()
        else:
            found[key] = 0.0, 0.0, tuple(option.name for option in field.options)
    return found


def answer(scope: dict[str, Any], body: list[bytes]) -> tuple[int, str | None]:
    """Status of the answer to a request, and what is wrong with it; None where nothing is.

    Parameters
    ----------
    scope : dict
        As :func:`request` made it.
    body : list of bytes
        Parts of the body.

    Returns
    -------
    status : int
    wrong : str or None
    """
    sent: list[Any] = []
    parts = [
        {"type": "http.request", "body": part, "more_body": i + 1 < len(body)}
        for i, part in enumerate(body)
    ]

    async def receive() -> Any:
        return parts.pop(0) if parts else {"type": "http.disconnect"}

    async def send(message: Any) -> None:
        sent.append(message)

    asyncio.run(_served()[1](scope, receive, send))
    if not sent:
        return 0, "no answer"
    return sent[0]["status"], _wrong(scope, sent)


def _wrong(scope: dict[str, Any], sent: list[Any]) -> str | None:
    status = sent[0]["status"]
    if status not in _STATUSES:
        return f"status {status}"
    content = b"".join(message.get("body", b"") for message in sent[1:])
    kind = dict(sent[0]["headers"]).get(b"content-type", b"")
    if kind == b"application/json" and scope["method"] != "HEAD":
        try:
            json.loads(content, parse_constant=_refused)
        except ValueError as error:
            return f"no strict JSON: {error}"
    return "message of more than 8 kB" if status >= 400 and len(content) > 8000 else None


def _refused(name: str) -> float:
    raise ValueError(f"{name} in it")
