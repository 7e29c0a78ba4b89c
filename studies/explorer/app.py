"""Web application of the explorer: its page, and what the page asks for."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import partial
from typing import Any, TypeVar

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp

from missions.files.writing import to_json
from sizing.program.objectives import SINGLE_OBJECTIVES, Objective
from studies.explorer.security import Guard, error_body
from studies.explorer.session import Session
from studies.explorer.settings import AnsweredError, Refusal, RefusedError, shown
from studies.explorer.worker import Worker, report_page, sizing_record

_SEASONS = ("none", "coarse", "exact")
_LOOK_S = 0.2  # between two looks whether the page still waits for a sizing

T = TypeVar("T")
Answer = Callable[[Request, dict[str, Any]], Awaitable[Any]]


class Explorer:
    """The application, its thread that computes and its process that sizes and reports."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.worker = Worker()
        self._thread = ThreadPoolExecutor(1, "explorer")
        self._waiting = ThreadPoolExecutor(4, "waiting")
        self._latest = Latest(self._thread)

    def application(self, *, port: int, token: str) -> ASGIApp:
        """Return the ASGI application for a port, guarded by a token."""
        routes = [
            Route("/api/alive", self._alive),
            Route("/api/session", self._describe),
            *(
                Route(f"/api/{name}", partial(self._post, answer), methods=["POST"])
                for name, answer in (
                    ("view", self._view),
                    ("size", self._size),
                    ("files", self._files),
                    ("report", self._report_page),
                )
            ),
            Mount("/", StaticFiles(packages=[("studies.explorer", "static")], html=True)),
        ]
        handlers: dict[Any, Any] = {HTTPException: _no_such, Exception: _broken}
        return Guard(Starlette(routes=routes, exception_handlers=handlers), port=port, token=token)

    def close(self) -> None:
        """End the process and the threads."""
        self.worker.end()
        self._thread.shutdown(wait=False, cancel_futures=True)
        self._waiting.shutdown(wait=False, cancel_futures=True)

    async def _alive(self, request: Request) -> Response:
        return _json({"alive": True})

    async def _describe(self, request: Request) -> Response:
        return _json(self.session.describe())

    async def _post(self, answer: Answer, request: Request) -> Response:
        """Answer with JSON; what is wrong with a request is said in a sentence."""
        try:
            return _json(await answer(request, await _body(request)))
        except AnsweredError as error:
            problems = [refusal._asdict() for refusal in error.refusals]
            return _error(error.status, error.kind, str(error), problems)

    async def _view(self, request: Request, body: dict[str, Any]) -> dict[str, Any]:
        """Return day curve, numbers and map of settings."""
        _only(body, "settings", "season", "client", "sequence")
        season = _one_of(body, "season", _SEASONS)
        client = body.get("client", "")
        if not isinstance(client, str) or len(client) > 64:
            raise RefusedError([Refusal("client", shown(client), "must be a short text")])
        settings = self.session.settings(body.get("settings"))

        def work() -> dict[str, Any]:
            view = self.session.day(settings)
            if season != "none":
                view["season"] = self.session.season(settings, coarse=season == "coarse")
            return view

        return await self._latest.run(client, work) | {"sequence": shown(body.get("sequence"))}

    async def _files(self, request: Request, body: dict[str, Any]) -> dict[str, Any]:
        """Return aircraft and mission of settings, and the command that analyses them."""
        _only(body, "settings")
        settings = self.session.settings(body.get("settings"))
        return self.session.saved(settings)

    async def _size(self, request: Request, body: dict[str, Any]) -> dict[str, Any]:
        """Return the best design for the point or the whole mission."""
        _only(body, "settings", "objective", "scenarios")
        names = tuple(objective.value for objective in SINGLE_OBJECTIVES)
        objective = Objective(
            _one_of({"objective": Objective.min_mass.value} | body, "objective", names)
        )
        every = _one_of(body, "scenarios", ("point", "mission")) == "mission"
        settings = self.session.settings(body.get("settings"))
        if self.session.measured:
            message = self.session.describe()["cannot_size"]
            raise RefusedError([Refusal("objective", objective.value, message)])
        made = self.session.inputs(settings, every_scenario=every)
        return await self._worked(request, sizing_record, made, objective)

    async def _report_page(self, request: Request, body: dict[str, Any]) -> dict[str, Any]:
        """Report on the point, as a file to be saved."""
        _only(body, "settings")
        made = self.session.inputs(self.session.settings(body.get("settings")))
        page = await self._worked(request, report_page, made)
        return {"name": self.session.file_names()["report"]} | page

    async def _worked(
        self, request: Request, work: Callable[..., dict[str, Any]], *task: Any
    ) -> dict[str, Any]:
        """Let the process work, as long as the page waits for it."""
        loop = asyncio.get_running_loop()
        running = loop.run_in_executor(self._waiting, self.worker.run, work, *task)
        while not (await asyncio.wait({running}, timeout=_LOOK_S))[0]:
            if await request.is_disconnected() and not running.done():
                await loop.run_in_executor(None, self.worker.end)
        answer = running.result()
        if "error" in answer:
            raise RefusedError([Refusal("mission", None, answer["error"])])
        return answer


async def _body(request: Request) -> dict[str, Any]:
    """Read the body of a request as a JSON object."""
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind != "application/json":
        raise AnsweredError("the body must be application/json", 415)

    def refuse(name: str) -> None:
        raise ValueError(f"{name} is not JSON")

    try:
        data = json.loads(await request.body(), parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        words = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise AnsweredError(f"the body is no JSON: {words}") from None
    if not isinstance(data, dict):
        raise AnsweredError("the body must be a JSON object")
    return data


def _only(body: dict[str, Any], *names: str) -> None:
    """Refuse keys that mean nothing."""
    unknown = [
        Refusal(str(shown(key)), shown(value), "is not a key of this request", ", ".join(names))
        for key, value in body.items()
        if key not in names
    ]
    if unknown:
        raise RefusedError(unknown)


def _one_of(body: dict[str, Any], key: str, names: tuple[str, ...]) -> str:
    """Name among some; the first where none is given."""
    value = body.get(key, names[0])
    if value not in names:
        raise RefusedError([Refusal(key, shown(value), "is not one of them", ", ".join(names))])
    return str(value)


def _json(record: Any) -> Response:
    return Response(to_json(record), media_type="application/json")


def _error(
    status: int, kind: str, message: str, problems: list[dict[str, Any]] | None = None
) -> Response:
    body = error_body(kind, message, problems)
    return Response(body, status_code=status, media_type="application/json")


async def _no_such(request: Request, error: Exception) -> Response:
    status = error.status_code if isinstance(error, HTTPException) else 404
    words = "there is no such page" if status == 404 else "this method is not allowed here"
    return _error(status, "address", words)


async def _broken(request: Request, error: Exception) -> Response:
    return _error(500, "internal", "the explorer made a mistake; its terminal says which")


# ---- Of many requests of a page only the latest matters


class Latest:
    """Turns of an executor, at most one waiting for each client.

    Computing happens in one thread; a request that waits for it is dropped as soon as the same page
    sends another one.
    """

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
                    words = "a later request of this page took its place"
                    raise AnsweredError(words, 409, "superseded")
                return await asyncio.get_running_loop().run_in_executor(self._executor, work)
        finally:
            if self._newest.get(client) is mine:
                del self._newest[client]
