"""Of the requests of a page that wait, the latest alone is computed."""

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

pytest.importorskip("starlette")

from studies.explorer.app import Latest
from studies.explorer.settings import AnsweredError


def outcomes(clients):
    """What becomes of requests that come while the first is computed, and what was computed."""
    computed = []

    async def ask():
        begun, go = threading.Event(), threading.Event()

        def work(name, *, wait=False):
            if wait:
                begun.set()
                go.wait(10.0)
            computed.append(name)
            return name

        with ThreadPoolExecutor(1) as executor:
            latest = Latest(executor)
            first = asyncio.create_task(latest.run("a", lambda: work("first", wait=True)))
            await asyncio.to_thread(begun.wait, 10.0)
            later = []
            for number, client in enumerate(clients):
                name = f"{client}{number}"
                later.append(asyncio.create_task(latest.run(client, lambda n=name: work(n))))
                await asyncio.sleep(0)
            go.set()
            done = await asyncio.gather(first, *later, return_exceptions=True)
        assert latest.waiting == 0
        kinds = [one.kind if isinstance(one, AnsweredError) else str(one) for one in done]
        return ["dropped" if kind == "superseded" else kind for kind in kinds]

    found = asyncio.run(ask())
    assert computed == [name for name in found if name != "dropped"]
    return found


@pytest.mark.parametrize(
    ("clients", "done"),
    [("aaa", "first dropped dropped a2"), ("abab", "first dropped dropped a2 b3")],
)
def test_latest_of_each_page_is_computed(clients, done):
    assert outcomes(clients) == done.split()


def test_error_of_one_request_leaves_the_next_alone():
    async def ask():
        with ThreadPoolExecutor(1) as executor:
            latest = Latest(executor)
            try:
                await latest.run("a", lambda: str(1 // 0))
            except ZeroDivisionError:
                return await latest.run("a", lambda: "next")
        return "nothing"

    assert asyncio.run(ask()) == "next"
