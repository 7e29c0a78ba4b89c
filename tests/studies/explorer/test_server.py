"""The explorer's server: who is let in, what is refused in words, and what comes back."""

import asyncio
import contextlib
import http.client
import json
import re
import socket
import subprocess
import sys
import threading
import time
from typing import NamedTuple

import pytest

pytest.importorskip("uvicorn")

from studies.case import Case
from studies.cli.files import opened
from studies.explorer.app import Explorer
from studies.explorer.security import MAXIMUM_BODY_BYTES, new_token
from studies.explorer.serve import ADDRESS, MOST_CONNECTIONS, bound_socket, configured
from studies.explorer.session import Session
from studies.explorer.settings import AnsweredError
from studies.explorer.worker import Worker, sizing_record


class Answer(NamedTuple):
    status: int
    headers: dict[str, str]
    body: bytes

    def json(self):
        def refuse(constant):
            raise AssertionError(f"{constant} is not JSON")

        return json.loads(self.body, parse_constant=refuse)

    def error(self):
        assert 400 <= self.status < 500, self.status
        found = self.json()["error"]
        assert found["message"]
        assert "Traceback" not in self.body.decode()
        return dict(found)


class Server(NamedTuple):
    port: int
    token: str
    explorer: Explorer

    @property
    def host(self):
        return f"{ADDRESS}:{self.port}"

    def ask(self, method, path, body=None, *, token="", host=None, **headers):
        connection = http.client.HTTPConnection(ADDRESS, self.port, timeout=300)
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        given = {"Host": self.host if host is None else host}
        if token is not None:
            given["Authorization"] = f"Bearer {token or self.token}"
        if body is not None:
            given |= {"Content-Type": "application/json", "Content-Length": str(len(body))}
        if method not in ("GET", "HEAD"):
            given["Origin"] = f"http://{self.host}"
        given |= {name.replace("_", "-").title(): value for name, value in headers.items()}
        for name, value in given.items():
            if value:
                connection.putheader(name, value)
        # A server that refuses what is too long need not read it to its end.
        with contextlib.suppress(ConnectionResetError, BrokenPipeError):
            connection.endheaders(body)
        with contextlib.closing(connection), connection.getresponse() as response:
            told = {name.lower(): value for name, value in response.getheaders()}
            return Answer(response.status, told, response.read())

    def head(self, path, length):
        """Head of a POST, for a body that is sent by hand."""
        return (
            f"POST {path} HTTP/1.1\r\nHost: {self.host}\r\nOrigin: http://{self.host}\r\n"
            f"Authorization: Bearer {self.token}\r\nContent-Type: application/json\r\n"
            f"{length}\r\n\r\n"
        ).encode()

    def get(self, path, **more):
        return self.ask("GET", path, **more)

    def post(self, path, data, **more):
        body = data if isinstance(data, bytes) else json.dumps(data).encode()
        return self.ask("POST", path, body, **more)


@pytest.fixture(scope="module")
def server():
    case = Case(opened("aircraft", "atlantiksolar-design"), opened("mission", "rafz-july"))
    session = Session(case)
    listening, token, explorer = bound_socket(0), new_token(), Explorer(session)
    port = listening.getsockname()[1]
    running = configured(explorer, port=port, token=token)
    thread = threading.Thread(target=running.run, args=([listening],))
    thread.start()
    yield Server(port, token, explorer)
    running.should_exit = True
    thread.join()
    explorer.close()


POSTS = ("/api/view", "/api/size", "/api/files", "/api/report")
GETS = ("/", "/main.js", "/api/session", "/api/alive", "/vendor/uPlot.LICENSE", "/nothing")


def test_page_and_everything_that_it_loads_is_there(server):
    page = server.get("/")
    assert page.status == 200
    assert page.headers["content-type"] == "text/html; charset=utf-8"
    text = page.body.decode()
    for name, kind in (
        ("main.js", "text/javascript"),
        ("explorer.css", "text/css"),
        ("icon.svg", "image/svg+xml"),
        ("vendor/uPlot.iife.min.js", "text/javascript"),
        ("vendor/uPlot.min.css", "text/css"),
    ):
        assert f'"{name}"' in text
        file = server.get(f"/{name}")
        assert file.status == 200
        assert file.headers["content-type"].startswith(kind)
    assert "MIT" in server.get("/vendor/uPlot.LICENSE").body.decode()


def test_nothing_of_the_page_is_inline_or_from_elsewhere(server):
    text = server.get("/").body.decode()
    assert "style=" not in text
    assert "<style" not in text
    assert not re.search(r"\son\w+=", text)
    assert "://" not in text
    scripts = text.split("<script")[1:]
    assert all('src="' in script.split(">")[0] for script in scripts)


@pytest.mark.parametrize("path", [*GETS, *POSTS])
def test_every_answer_has_the_strict_headers(server, path):
    for answer in (server.get(path), server.get(path, token=None)):
        policy = answer.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'none'" in policy
        assert "unsafe" not in policy
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert answer.headers["cache-control"] == "no-store"
        assert "server" not in answer.headers


@pytest.mark.parametrize("path", GETS)
@pytest.mark.parametrize("token", [None, "x", "é"])
def test_without_the_token_there_is_nothing(server, path, token):
    answer = server.get(path, token=token)
    assert answer.status == 403
    assert "token" in answer.error()["message"]
    assert "set-cookie" not in answer.headers
    # Somebody who opens the address alone reads why.
    page = server.get("/", token=None, accept="text/html,*/*")
    assert page.headers["content-type"] == "text/html; charset=utf-8"
    assert "open the address that solar-uav explore printed" in page.body.decode()
    assert server.get("/?" + "a=1&" * 20).status == 200


def test_first_page_turns_the_token_into_a_cookie(server):
    first = server.get(f"/?token={server.token}", token=None)
    assert first.status == 200
    cookie = first.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    pair = cookie.partition(";")[0]
    assert server.get("/api/session", token=None, cookie=pair).status == 200
    # What other programs of this machine set is sent along, whatever it looks like.
    odd = ("other=1", 'x={"a":1}', "a[b]=1", "bare", '"', "=", "", "a=\xe4", "a=b=c", "a,b=1")
    for other in odd:
        for cookies in (f"{other}; {pair}", f"{pair}; {other}", f"{other};{pair} ;{other}"):
            answer = server.get("/api/session", token=None, cookie=cookies)
            assert answer.status == 200, cookies
    name, _, token = pair.partition("=")
    assert server.get("/api/session", token=None, cookie=f"{name}=old; {pair}").status == 200
    for wrong in (name, f"{name}=", f"{name}={token}x", f"a={name}={token}", f"{name} {token}"):
        assert server.get("/api/session", token=None, cookie=wrong).status == 403, wrong
    assert server.get("/api/session", token=None, cookie=f"x{pair}").status == 403
    assert server.get(f"/api/session?token={server.token}", token=None).status == 403


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "[::1]:{port}"]
)
def test_other_hosts_are_refused(server, host):
    answer = server.get("/", host=host.format(port=server.port))
    assert answer.status == 403
    assert "127.0.0.1" in answer.error()["message"]


def test_localhost_is_the_same_machine(server):
    host = f"localhost:{server.port}"
    assert server.get("/api/alive", host=host).json() == {"alive": True}
    assert server.post("/api/view", {}, host=host, origin=f"http://{host}").status == 200


OUT = {"token": None}


@pytest.mark.parametrize(
    ("call", "more", "status"),
    [
        *[(f"POST {path}", OUT, 403) for path in POSTS],
        *[(f"POST {path}?token={{token}}", OUT, 403) for path in POSTS],
        # A page that knows no token must not make the server fail either.
        (f"GET /?{'a=1&' * 20}token={{token}}", OUT, 403),
        *[
            (f"{call}", {"origin": origin}, 403)
            for call in ("GET /api/session", "POST /api/view")
            for origin in ("http://evil.example", "null", "https://{host}", f"http://{ADDRESS}:1")
        ],
        ("POST /api/view", {"origin": ""}, 403),
        ("POST /api/view", {"content_type": "text/plain"}, 415),
        *[("POST /api/view", {"data": {"season": season}}, 422) for season in ("fine", 3)],
        *[("POST /api/view", {"data": {"client": client}}, 422) for client in (4, "x" * 65)],
        ("POST /api/size", {"data": {"objective": "cheapest"}}, 422),
        ("POST /api/size", {"data": {"objective": "longest_season"}}, 422),
        ("POST /api/size", {"data": {"scenarios": "all"}}, 422),
        ("PUT /api/view", {}, 405),
        ("POST /api/session", {}, 405),
        *[(f"GET /{path}", {}, 404) for path in ("api/view", "vendor", "api/other", "etc/passwd")],
        *[(f"GET /{up}/session.py", {}, 404) for up in ("..", "static/../..", "%2e%2e")],
    ],
)
def test_other_requests_are_refused(server, call, more, status):
    method, path = call.format(token=server.token).split(" ")
    more = {k: v.format(host=server.host) if k == "origin" else v for k, v in more.items()}
    if method == "POST":
        answer = server.post(path, more.pop("data", {}), **more)
    else:
        answer = server.ask(method, path, **more)
    assert answer.status == status
    assert "origin" not in more or answer.error()["kind"] == "origin"


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"", 400),
        (b"{", 400),
        (b"[]", 400),
        (b"3", 400),
        (b'{"settings": {"battery.mass_kg": NaN}}', 400),
        (b'{"settings": {"battery.mass_kg": Infinity}}', 400),
        (b'{"settings": {"battery.mass_kg": 1e999}}', 422),
        (b'{"settings": {"battery.mass_kg": ' + b"9" * 5000 + b"}}", 400),
        (b'{"settings": {"battery.mass_kg": ' + b"9" * 400 + b"}}", 422),
        (b"[" * 8000, 400),
        (b"\xff\xfe\x00", 400),
        (b'{"settings": {"battery.mass_kg": "3"}}', 422),
        (b'{"settings": {"battery.mass_kg": true}}', 422),
        (b'{"settings": {"nothing": 1}}', 422),
        (b'{"settings": [1]}', 422),
        (b'{"settings": {"modules.area_m2": 20}}', 422),
        (b'{"other": 1}', 422),
    ],
)
@pytest.mark.parametrize("path", POSTS)
def test_bad_body_is_refused_in_words(server, path, body, status):
    answer = server.post(path, body)
    assert answer.status == status
    problems = answer.error()["problems"]
    assert status == 400 or all(
        {"field", "value", "message", "allowed"} == set(p) for p in problems
    )


def test_bad_field_names_value_and_range(server):
    answer = server.post("/api/view", {"settings": {"mission.latitude_deg": 91}})
    (problem,) = answer.error()["problems"]
    assert problem == {
        "field": "mission.latitude_deg",
        "value": 91,
        "message": "is out of range",
        "allowed": "a number from -90 to 90 °",
    }


def test_too_much_is_refused(server):
    # Lengths are told and nothing is sent: a server that closes with bytes unread resets the
    # connection, and then it is chance whether its answer is read before that.
    told = str(MAXIMUM_BODY_BYTES + 1)
    assert server.post("/api/view", b"", content_length=told).status == 413
    assert server.get("/?token=" + "x" * 600).status == 414
    assert server.post("/api/view", b"", content_length="-1").status in (400, 413)


def test_a_length_of_thousands_of_digits_is_refused(server):
    # Of a server that passes it on; ours refuses the header itself.
    host = server.host.encode()
    headers = [(b"host", host), (b"authorization", b"Bearer " + server.token.encode())]
    scope = {"type": "http", "method": "GET", "path": "/", "query_string": b""}
    scope["headers"] = [*headers, (b"content-length", b"9" * 5000)]
    sent = []

    async def send(message):
        sent.append(message)

    guarded = server.explorer.application(port=server.port, token=server.token)
    asyncio.run(guarded(scope, None, send))
    assert sent[0]["status"] == 413


@pytest.mark.parametrize(
    ("header", "body", "status"),
    [
        ("Content-Length: 100", b"{", b"408"),  # the rest does not come
        # Longer than allowed, of which the header says nothing.
        ("Transfer-Encoding: chunked", 5 * (b"1000\r\n" + b" " * 4096 + b"\r\n"), b"413"),
    ],
)
def test_bodies_by_hand_are_cut_or_not_waited_for(server, header, body, status, monkeypatch):
    monkeypatch.setattr("studies.explorer.security.BODY_S", 0.02)
    with socket.create_connection((ADDRESS, server.port), timeout=10) as raw:
        raw.sendall(server.head("/api/view", header) + body)
        assert raw.recv(4096).split()[1] == status


def test_half_sent_requests_keep_nobody_out(server):
    with contextlib.ExitStack() as stack:
        for _ in range(3 * MOST_CONNECTIONS):
            raw = stack.enter_context(socket.create_connection((ADDRESS, server.port), timeout=10))
            raw.sendall(b"GET / HTTP/1.1\r\nHost: ")
        assert server.get("/api/alive").status == 200


def test_a_request_that_does_not_come_is_waited_for_no_longer(server, monkeypatch):
    monkeypatch.setattr("studies.explorer.serve.REQUEST_S", 0.02)
    for part in (b"", b"GET / HTTP/1.1\r\nHost: "):
        with socket.create_connection((ADDRESS, server.port), timeout=10) as raw:
            raw.sendall(part)
            assert raw.recv(100) == b""
    with socket.create_connection((ADDRESS, server.port), timeout=10) as raw:
        whole = f"GET /api/alive HTTP/1.1\r\nHost: {server.host}\r\n\r\n".encode()
        raw.sendall(whole)
        assert b" 403 " in raw.recv(100)
        raw.sendall(whole[:20])  # and half a second one
        while raw.recv(4096):
            pass


def test_view_is_the_session_s(server):
    changed = {"battery.mass_kg": 3.2, "model": "CDM"}
    view = server.post("/api/view", {"settings": changed, "season": "coarse", "sequence": 7}).json()
    session = server.explorer.session
    settings = session.settings(changed)
    assert view == {
        **session.day(settings),
        "season": session.season(settings, coarse=True),
        "sequence": 7,
    }
    assert "season" not in server.post("/api/view", {}).json()


@pytest.mark.slow
def test_report_is_one_on_the_settings(server):
    made = server.post("/api/report", {"settings": {"battery.mass_kg": 3.2}}).json()
    assert made["name"] == "atlantiksolar-design-explored.html"
    assert made["text"].lower().startswith("<!doctype html>")
    assert "3.2" in made["text"]


@pytest.mark.long
def test_sizing_gives_values_that_fly(server):
    found = server.post("/api/size", {"objective": "min_mass"}).json()
    assert found["feasible"]
    assert found["limits"][0].startswith("required excess time at ")
    view = server.post("/api/view", {"settings": found["values"]}).json()
    # Values have six digits: 1e-6 of a battery for 24 h is 1e-4 h, of a mass a few times 1e-6.
    simulated = found["record"]["simulated"]
    assert view["numbers"]["excess_time_h"] == pytest.approx(simulated["excess_time_h"], abs=2e-4)
    assert view["numbers"]["excess_time_h"] >= 0.0
    total_kg = found["record"]["total_mass_kg"]
    assert view["numbers"]["total_mass_kg"] == pytest.approx(total_kg, rel=1e-5)
    assert all(len(repr(value)) <= 8 for value in found["values"].values())


@pytest.mark.long
def test_sizing_with_margin_flies_with_an_rms_error_less(server):
    guarded = server.post("/api/size", {"objective": "min_mass"}).json()["with_margin"]
    assert guarded["error"] == "one RMS error of CAM (7 %)"
    view = server.post("/api/view", {"settings": guarded["values"]}).json()
    assert view["numbers"]["uncertainty"]["excess_time_low_h"] >= 0.0


@pytest.mark.long
def test_infeasible_sizing_says_why_and_what_would_help(server):
    asked = {"mission.latitude_deg": 60.0, "mission.day_of_year": 288}
    found = server.post("/api/size", {"settings": asked | {"mission.payload.mass_kg": 2.0}}).json()
    assert not found["feasible"]
    assert found["values"] is None
    assert "short by" in found["missed"][0]
    assert any(one["parameter"] == "mission.payload.mass_kg" for one in found["relaxations"])


def test_sizing_without_sun_is_refused_in_words(server):
    dark = {"mission.latitude_deg": 80.0, "mission.day_of_year": 355}
    assert "polar night" in server.post("/api/size", {"settings": dark}).error()["message"]


def test_one_sizing_at_a_time_and_a_cancelled_one_is_ended(server):
    made = server.explorer.session.inputs(server.explorer.session.settings())
    from sizing.program.objectives import Objective

    worker, outcome = Worker(), []

    def size():
        try:
            outcome.append(worker.run(sizing_record, made, Objective.min_mass))
        except AnsweredError as error:
            outcome.append(error)

    thread = threading.Thread(target=size)
    thread.start()
    time.sleep(0.2)  # its process takes longer to start
    worker.end()
    thread.join(timeout=20)
    assert outcome[0].kind == "ended"
    quick = Worker(longest_s=0.01)
    with pytest.raises(AnsweredError, match="no answer within") as caught:
        quick.run(sizing_record, made, Objective.min_mass)
    assert caught.value.kind == "ended"


@pytest.mark.long
def test_leaving_the_page_ends_what_it_waited_for(server):
    with socket.create_connection((ADDRESS, server.port), timeout=10) as raw:
        raw.sendall(server.head("/api/report", "Content-Length: 2") + b"{}")
        until(lambda: server.post("/api/size", {}).status == 409)
        assert server.get("/api/alive").json() == {"alive": True}
        assert server.post("/api/view", {}).status == 200
    until(lambda: server.post("/api/size", {}).status == 200)


def until(true):
    end = time.monotonic() + 20.0
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.mark.long
@pytest.mark.parametrize("busy", [False, True])
def test_command_prints_its_address_first_and_ends_by_a_signal(busy):
    words = ["explore", "atlantiksolar-as2", "--no-browser", "--port", "0"]
    process = subprocess.Popen(
        [sys.executable, "-m", "studies.cli", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    address = process.stdout.readline().strip()
    assert address.startswith(f"http://{ADDRESS}:")
    port, _, token = address.removeprefix(f"http://{ADDRESS}:").partition("/?token=")
    bearer = {"Authorization": f"Bearer {token}"}
    connection = http.client.HTTPConnection(ADDRESS, int(port), timeout=10)
    connection.request("GET", "/api/session", headers=bearer)
    assert json.load(connection.getresponse())["aircraft"]["measured"]
    if busy:
        more = {"Origin": f"http://{ADDRESS}:{port}", "Content-Type": "application/json"}
        # A request that never comes to its end is of no interest at the server's.
        begun = http.client.HTTPConnection(ADDRESS, int(port), timeout=10)
        begun.request("POST", "/api/view", b"{", bearer | more | {"Content-Length": "100"})
        connection.request("POST", "/api/report", b"{}", bearer | more)
        time.sleep(0.3)  # the report takes seconds
    process.send_signal(2)
    out, errors = process.communicate(timeout=10)
    assert process.returncode == 130
    assert out == ""
    assert errors.split("\n") == [
        "atlantiksolar-as2 on rafz-july (default mission); Ctrl-C ends it",
        "",  # ends the line on which a terminal shows ^C
        "solar-uav: stopped by Ctrl-C",
        "",
    ]
    if busy:
        assert connection.getresponse().status == 503
        begun.close()


def test_answers_are_not_held_back_by_nagle():
    """An event loop sends small packets at once on sockets that are named as TCP alone."""
    with bound_socket(0) as listening, socket.create_connection(listening.getsockname()):
        accepted, _ = listening.accept()
        with accepted:
            assert accepted.proto == socket.IPPROTO_TCP
